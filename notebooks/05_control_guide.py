# %% [markdown]
# # A state-space model and a controller
#
# **Question.** How does a controller change the guide: where are the poles of the closed loop, and does the linear
# model predict the step response of the mechanism?
#
# flexmb passes the linearised mechanism to python-control, where you design controllers. The nonlinear simulation then
# includes the controller.

# %%
import control
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The plant
#
# The guide of the first notebook. The voice coil pushes on C, a sensor measures B. The builder names inputs and
# outputs. The leaf springs are damped, with a ratio of 0.005 at the 10.6 Hz of the guide and in proportion at other
# frequencies. The simulation needs dampers of elements. For linear answers, `fm.damped` sets a ratio for each mode
# (below).

# %%
length, width, thickness, apart, mass = 0.1, 0.018, 0.5e-3, 0.1, 0.206
leaf = fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9, rho=7850), rotary=False)
damping = fm.sections.damping_from_ratio(leaf, length, 0.005, frequency=10.6448)


def guide(released, *dofs):
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (apart, length), "D": (apart, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf, damping=damping, released=released)
    b.add(planar.beam, "D", "C", name="right", section=leaf, damping=damping, released=released)
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    for end in "BC":
        b.mass(end, mass / 2)
    b.dof("B", *dofs)
    b.input("C", "x", name="force")
    b.output("B", "x", name="position")
    b.output("B", "x", "velocity", name="velocity")
    return b.build()


model = guide((2, 3), "x")
plant = fm.to_statespace(model)
print(plant)

# %%
figure = fm.plot.bode(plant, "position")

# %% [markdown]
# ## The controller
#
# With one degree of freedom the plant is $m\ddot q + d\dot q + kq = u$; `fm.linearize` returns the three numbers. A
# controller with proportional and integrating action on the error and derivative action on the velocity can place the
# three poles of the closed loop anywhere:
#
# $$m s^3 + (d + k_d)s^2 + (k + k_p)s + k_i = m\,(s^2 + 2\zeta\omega s + \omega^2)(s + \omega) .$$

# %%
lin = fm.linearize(model)
m, d, k = (float(matrix[0, 0]) for matrix in (lin.M0, lin.D0, lin.K))
omega, zeta = 2 * np.pi * 30, 0.7
kd = m * omega * (2 * zeta + 1) - d
kp = m * omega**2 * (1 + 2 * zeta) - k
ki = m * omega**3
controller = control.ss([[0.0]], [[1.0, 0.0]], [[ki]], [[kp, kd]])

closed = control.feedback(plant * controller, np.eye(2))[0, 0]
poles = np.sort_complex(closed.poles())
print("poles [rad/s]:", np.round(poles, 4))

# %% [markdown]
# ## The step response of the mechanism
#
# `fm.simulate` integrates the nonlinear equations of motion together with the controller. The input of the controller
# is reference − y: the wanted minus the measured position, and minus the velocity.

# %%
times = np.linspace(0, 0.1, 101)
step = 1e-3  # m
motion = fm.simulate(
    model,
    times,
    control=controller,
    reference=lambda t: jnp.array([step, 0.0]),
    rtol=1e-6,
)
position = np.asarray(motion.at("B")[:, 0])
linear = control.step_response(closed, times).outputs * step

figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
fm.plot.history(motion, "B.x", ax=axes[0])
axes[0].plot(times, linear, "--", label="linear model")
axes[0].legend()
axes[1].plot(times, np.asarray(motion.u[:, 0]))
axes[1].set_xlabel("time [s]")
axes[1].set_ylabel("force of the voice coil [N]")
axes[1].grid(visible=True, alpha=0.3)
plt.show()

# %% [markdown]
# ## Do the neglected motions matter?
#
# The model has one degree of freedom because the leaf springs do not stretch. With released elongations it has three,
# and the controller must not excite the other two. In the straight position it cannot, because the drive does no work
# on them. The poles of the loop stay in place, and only the leaf springs damp the new ones.

# %%
full = fm.to_statespace(guide((1, 2, 3), "x", "y", "phi"))
full_poles = control.feedback(full * controller, np.eye(2)).poles()
slow = full_poles[np.abs(full_poles) < 5 * omega]
print("slow poles [rad/s]:", np.round(np.sort_complex(slow), 4))
print("fast ones [Hz]:", np.round(np.sort(np.abs(full_poles[np.abs(full_poles) >= 5 * omega])) / (2 * np.pi), 1))

# %% [markdown]
# ## Leaf springs as they are, and the few modes that matter
#
# A `leaf_spring` has shear, plate bending at its clamps and vibrations of its own: many modes, most of them far above
# the loop. `fm.damped` sets an assumed or measured damping ratio for all of them. `bandwidth=` keeps the modes up to a
# frequency, with the static response of the others, and reports the error against all modes. python-control's `margin`
# fails for all modes; for the modes of the band it returns the distance of the loop from instability.

# %%
b = fm.Builder()
for name, place in {"A": (0, 0), "B": (0, length), "C": (apart, length), "D": (apart, 0)}.items():
    b.node(name, place)
b.add(planar.leaf_spring, "A", "B", name="left", section=leaf)
b.add(planar.leaf_spring, "D", "C", name="right", section=leaf)
b.add(planar.beam, "B", "C", name="stage")
for foot, end in zip("AD", "BC", strict=True):
    b.fix(foot)
    b.mass(end, mass / 2)
b.input("C", "x", name="force")
b.output("B", "x", name="position")
lin = fm.damped(b.build(), ratio=0.005)
all_modes = fm.to_statespace(lin)
band = fm.to_statespace(lin, bandwidth=300.0)
print(f"{all_modes.nstates} states, {band.nstates} up to 300 Hz: off by {np.max(band.truncation_error):.1e} at most")
figure = fm.plot.bode(band)

# %%
# Position to force, with the velocity as a filtered derivative.
feedback = control.ss(control.tf([kd, kp, ki], [1e-4, 1, 0]))
_, phase_margin, _, crossover = control.margin(band * feedback)
print(f"phase margin {phase_margin:.1f} degrees at {crossover / (2 * np.pi):.1f} Hz")

# %% [markdown]
# ## What the numbers are compared with
#
# The damping ratio of the guide is compared with the requested one, the margin with the response of all modes at the
# crossover, the poles with the poles that the gains were computed for, and the simulated step with python-control's. A
# step of 1 % of the length is so small that the mechanism is linear to about one in 10⁴.

# %%
natural = fm.poles(model)[0]
print(f"damping ratio of the guide: {-natural.real / abs(natural):.6f}")
at_crossover = complex((all_modes * feedback)(1j * crossover))
expected = np.sort_complex(np.roots(np.polymul([1, 2 * zeta * omega, omega**2], [1, omega])))
print("wanted [rad/s]:", np.round(expected, 4))
assert np.allclose(poles, expected, rtol=1e-9)
assert np.allclose(np.sort_complex(slow), expected, rtol=1e-3)
assert np.all(full_poles.real < 0)
assert np.max(np.abs(position - linear)) < 1e-3 * step
assert abs(-natural.real / abs(natural) / 0.005 - 1) < 1e-4
assert abs(abs(at_crossover) - 1) < 1e-3
assert abs(np.degrees(np.angle(at_crossover)) + 180 - phase_margin) < 0.1
assert np.max(band.truncation_error) < 1e-3
