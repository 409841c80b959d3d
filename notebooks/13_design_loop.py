# %% [markdown]
# # Design study: a controller and a leaf spring tuned together
#
# **Question.** How much faster does a guide settle if the thickness of its leaf springs is tuned together with the
# gains of the controller?
#
# A voice coil drives the guide of the first notebook. Sensor, computer and amplifier together have a lag of $1/(1+\tau
# s)^2$ with $\tau = 2$ ms. A controller reacts with this lag; a leaf spring reacts at once. So the leaf spring is a
# part of the controller without lag, and a thin one need not be best.
#
# **What is measured.** The spectral abscissa of the closed loop, the real part of its slowest pole, has no derivative
# where poles meet, and the optimum is often there. Instead, the objective is the **mean decay rate over a time T**,
#
# $$\alpha_T = -\frac1T \ln \tfrac12\lVert W e^{A T} W^{-1}\rVert_F ,$$
#
# of the closed-loop matrix A, with a fixed scaling W of the states. It measures how far every initial state has decayed
# after T. It is smooth everywhere, also for an unstable loop, and tends to the spectral abscissa as T grows. Here
# T = 50 ms. Poles and settling times are shown as well.

# %%
import control
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## Mechanism

# %%
length, width, apart, mass = 0.1, 0.018, 0.1, 0.206
steel = fm.Material(E=210e9, G=80e9, rho=7850, strength=900e6)
stroke = 2e-3  # m


def guide(thickness, *, element=planar.beam, released=(2, 3), dofs=("x",), start=0.0, prescribed=None):
    leaf = fm.Rectangle(width, thickness, steel, rotary=False)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (apart, length), "D": (apart, 0)}.items():
        b.node(name, place)
    for name, ends in (("left", "AB"), ("right", "DC")):
        own = {} if released is None else {"released": released}
        b.add(
            element, *ends, name=name, section=leaf, damping=fm.sections.damping_from_ratio(leaf, length, 0.005), **own
        )
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    for end in "BC":
        b.mass(end, mass / 2)
    if dofs:
        b.dof("B", *dofs)
    if prescribed is not None:
        b.prescribe("B", "x", prescribed)
    if start:
        b.start("B", "x", start)
    b.input("C", "x", name="force")
    b.output("B", "x", name="position")
    b.output("B", "x", "velocity", name="velocity")
    return b.build()


# %% [markdown]
# ## Closed loop
#
# The controller has a proportional gain $k_p$, a derivative gain $k_d$ and the lag. The loop shall hold the stage
# against a constant force with 5 N/mm, the sum of the stiffness of the leaf springs and the proportional gain. So $k_p$
# follows from the thickness, and is negative if the leaf springs alone are stiffer.
#
# `fm.control.state_matrices` returns A, B, C, D of the mechanism as JAX arrays, so that the closed loop is a
# differentiable function of thickness and gain. The tuned function may return whatever the answers need.

# %%
tau, horizon, held = 2e-3, 50e-3, 5e3  # s, s, N/m


def controller(kp, kd):
    """A, B, C of the controller from position and velocity to force; its states are the two of the lag."""
    a = jnp.array([[-1 / tau, 0.0], [1 / tau, -1 / tau]])
    b = jnp.stack([-jnp.stack([kp, kd]) / tau, jnp.zeros(2)])
    return a, b, jnp.array([[0.0, 1.0]])


def loop_matrix(plant, kp, kd):
    a, b, c = controller(kp, kd)
    return jnp.concatenate(
        [
            jnp.concatenate([plant.A, plant.B @ c], axis=1),
            jnp.concatenate([b @ plant.C, a], axis=1),
        ]
    )


def loop(thickness, kd):
    model = guide(thickness)
    plant, _ = fm.control.state_matrices(model)
    drive = fm.stiffness(model, "B", "x")
    return {
        "matrix": loop_matrix(plant, held - drive, kd),
        "force": drive * stroke,
        # Stress of a leaf spring clamped at both ends, over the strength that the material states.
        "utilisation": 3 * steel.E * thickness * stroke / length**2 / steel.strength,
    }


# Brings every state to metres: a velocity times τ, a force times τ²/m.
scale = jnp.array([1.0, tau, tau**2 / mass, tau**2 / mass])


def decay(made):
    transition = scale[:, None] * jax.scipy.linalg.expm(made["matrix"] * horizon) / scale
    return -jnp.log(jnp.linalg.norm(transition / 2)) / horizon


answers = {
    "decay": decay,
    "holding force": lambda made: made["force"],
    "utilisation": lambda made: made["utilisation"],
}

# %% [markdown]
# ## The search
#
# The objective is the fastest decay. To hold the full stroke of 2 mm the voice coil may need 30 N, which limits the
# stiffness of the leaf springs, and the stroke may use a third of their strength. First the gain alone is tuned, for
# leaf springs of 0.5 mm; then both.

# %%
start = {"thickness": 0.5e-3, "kd": 60.0}
bounds = {"thickness": (0.2e-3, 2e-3), "kd": (-200.0, 300.0)}


def loop_of_gain(kd):
    return loop(start["thickness"], kd)


alone = fm.tune(loop_of_gain, answers, {"kd": 60.0}, bounds={"kd": bounds["kd"]}, maximize="decay")
print(alone)

# %%
together = fm.tune(
    loop,
    answers,
    {**start, **alone.dimensions},
    bounds=bounds,
    maximize="decay",
    limits={"holding force": (None, 30.0), "utilisation": (None, 1 / 3)},
    tolerance=1e-5,
)
print(together)

# %% [markdown]
# The force limit is reached: the leaf springs provide as much of the stiffness as allowed, and the gains become small.
# The poles of both loops:

# %%
designs = {"gain alone": {**start, **alone.dimensions}, "together": together.dimensions}
figure, ax = plt.subplots(layout="constrained")
abscissa = {}
for (label, dimensions), marker in zip(designs.items(), "ox", strict=True):
    poles = np.linalg.eigvals(np.asarray(loop(**dimensions)["matrix"]))
    abscissa[label] = float(np.max(poles.real))
    ax.plot(poles.real, poles.imag, marker, label=f"{label}: slowest {abscissa[label]:.1f} 1/s")
ax.axvline(-1 / (2 * tau), color="grey", linestyle=":", label="bound −1/(2τ)")
ax.set_xlabel("real part [1/s]")
ax.set_ylabel("imaginary part [rad/s]")
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# No loop of this kind can be faster than the dotted line. The sum of its four poles is $-2/\tau$, except for the small
# damping of the leaf springs, for any gains and stiffness. So the slowest of them cannot lie to the left of
# $-1/(2\tau)$.
#
# ## Settling of the mechanism
#
# Both controllers act on the nonlinear mechanism, released half a millimetre aside. After the settling time it stays
# within 2 % of the release.

# %%
times, release = np.linspace(0, 0.12, 241), 0.5e-3
settling = {}
figure, ax = plt.subplots(layout="constrained")
for label, dimensions in designs.items():
    model = guide(dimensions["thickness"], start=release)
    kp = held - float(fm.stiffness(model, "B", "x"))
    a, b, c = controller(kp, dimensions["kd"])
    motion = fm.simulate(model, times, control=control.ss(a, b, c, np.zeros((1, 2))), sign=1)
    position = np.asarray(motion.at("B")[:, 0])
    settling[label] = float(times[np.flatnonzero(np.abs(position) > 0.02 * release)[-1] + 1])
    ax.plot(1e3 * times, 1e3 * position, label=f"{label}: settled after {1e3 * settling[label]:.1f} ms")
ax.axhspan(-20 * release, 20 * release, alpha=0.2, label="2 % of the release")
ax.set_xlabel("time [ms]")
ax.set_ylabel("position [mm]")
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# It settles sooner, but swings farther to the other side before: the objective contains only decay. To limit the
# overshoot, add a limit.
#
# ## What the numbers are compared with
#
# *Leaf springs as they are.* Each is one `leaf_spring`, which agrees with solid elements. It stretches and vibrates
# too, so that the loop has many more poles, and near its clamps it is stiffer than a beam. So the tuned leaf springs
# need more than 30 N, and thinner ones meet the limit; the stiffness is proportional to the third power of the
# thickness.
#
# With these leaf springs the slow poles must equal those of the simple model, and the fast ones must be stable. The
# fast poles are vibrations of the leaf springs themselves, above 500 Hz, which decay by their own damping of half a
# percent. The controller hardly affects them, and the stage hardly moves in them.


# %%
def real(thickness, prescribed=None):
    return guide(thickness, element=planar.leaf_spring, released=None, dofs=(), prescribed=prescribed)


found = together.dimensions
stiffer = float(fm.stiffness(real(found["thickness"]), "B", "x") / fm.stiffness(guide(found["thickness"]), "B", "x"))
thinner = found["thickness"] / stiffer ** (1 / 3)
fine = fm.linearize(real(thinner))
plant, _ = fm.control.state_matrices(fine)
drive = float(fm.stiffness(fine, "B", "x"))
poles = np.linalg.eigvals(np.asarray(loop_matrix(plant, held - drive, found["kd"])))
fast = np.abs(poles) > 2 * np.pi * 500
fine_abscissa = float(np.max(poles[~fast].real))
used = float(np.max(fm.stress(real(thinner, prescribed=stroke)).utilisation))
print(f"leaf springs of {1e3 * found['thickness']:.4f} mm take {stiffer * together.answers['holding force']:.2f} N")
print(f"those of {1e3 * thinner:.4f} mm {drive * stroke:.2f} N, and {used:.1%} of their strength")
print(f"{len(poles)} poles; of those of the loop {fine_abscissa:.3f} 1/s, simple model {abscissa['together']:.3f} 1/s")
print(f"lowest vibration of the leaf springs: {np.min(np.abs(poles[fast])) / (2 * np.pi):.0f} Hz")
print(f"decay rate {abscissa['together'] / abscissa['gain alone']:.2f} times that with the gain alone")
print(f"settling {1e3 * settling['gain alone']:.1f} ms, then {1e3 * settling['together']:.1f} ms")

# The settling time of the linear loop, for the same release; the motion was looked at every half millisecond.
released = jnp.array([release, 0.0, 0.0, 0.0])
for label, dimensions in designs.items():
    linear = fm.design.settling_time(
        loop(**dimensions)["matrix"], released, jnp.eye(4)[0], 0.02 * release, horizon=times[-1]
    )
    assert abs(float(linear) - settling[label]) < 1e-3, label

assert together.answers["holding force"] <= 30.0
assert together.answers["utilisation"] <= 1 / 3
assert used <= 1 / 3
# Clamps make leaf springs stiffer in sway by 1/(1 - nu^2 (1 - (1 - 0.8 w/L)^3)), flexmb/THEORY.md (13.9); they stretch
# too, by the order of (t/L)^2 = 1.6e-4.
nu = float(steel.poisson())
assert abs(stiffer * (1 - nu**2 * (1 - (1 - 0.8 * width / length) ** 3)) - 1) < 5e-4
assert abscissa["together"] > -1 / (2 * tau) - 1
assert np.sum(~fast) == 4
assert np.all(poles.real < 0)
assert abs(fine_abscissa / abscissa["together"] - 1) < 0.02
assert abscissa["together"] < 1.5 * abscissa["gain alone"]
assert settling["together"] < 0.8 * settling["gain alone"]
