# %% [markdown]
# # Motion: the elevator
#
# **Question.** How does an elevator on belts move when its motor turns it into place, and how do its natural
# frequencies vary on the way?
#
# The appendix of the tutorial (WA 1239, 2012, A.3) shows a planar elevator: a pulley, two masses that hang from it on
# belts, and a motor. A spring and a damper represent the PD controller of the motor. The stiffness of a belt is $EA$
# over its present free length, so the mechanism is nonlinear. The tutorial prints pictures of the answer and no
# parameters; the parameters of the shipped file are flexmb's own.

# %%
import matplotlib.pyplot as plt
import numpy as np
import scipy.linalg
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.mechanisms import mechanism_path

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %%
read = fm.read_spacar(mechanism_path("elevator"))
model = read.builder.build(dofs="named")
ax = fm.plot.mechanism(model, names=True)
print("degrees of freedom:", model.q_labels)
print(read.settings["TIMESTEP"], read.settings["ERROR"])

# %% [markdown]
# The pulley (nodes 1 and 2) carries the masses 3 and 5. Element 1 is the motor, 2 and 3 are the belts. The spoke 4 and
# the line 5 only make the motion visible.
#
# ## The motion
#
# The pulley is released at an angle of 1 rad, as the line `STARTDE 1 1 1` in the file states. `fm.simulate` returns
# coordinates, velocities and deformations at the requested times. `motion.reaction` and similar methods answer by
# name, and `motion.observe()` returns energies.

# %%
times = np.linspace(0, 2.5, 251)
motion = fm.simulate(model, times, rtol=1e-7)
turn, left, right = (np.asarray(motion.deformation(element, 1)) for element in "123")

# %% [markdown]
# ## Natural frequencies along the motion
#
# `fm.motion.linearize_motion` returns the matrices of the linearised equations at every time. The tutorial considers
# the open loop, without the motor's spring of 12.5 N m/rad, so the code subtracts this stiffness. One free motion and
# two vibrations remain, whose frequencies change as belt is rolled on and off.

# %%
lin = fm.motion.linearize_motion(motion)
spring = np.zeros((3, 3))
spring[0, 0] = 12.5
hertz = []
for stiffness, mass in zip(np.asarray(lin.K), np.asarray(lin.M0), strict=True):
    values = scipy.linalg.eigh(stiffness - spring, mass, eigvals_only=True)
    hertz.append(np.sqrt(np.abs(values)) / (2 * np.pi))
hertz = np.array(hertz)

# %% [markdown]
# The three pictures of figure A.2: the rotation comes to rest after one swing, and the frequencies vary until then. The
# belts continue to vibrate, since their own damping is small.

# %%
figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
axes[0].plot(times, turn)
axes[0].set_ylabel("turn of the motor [rad]")
axes[1].plot(times, hertz[:, 1:], label=["lower", "upper"])
axes[1].legend()
axes[1].set_ylabel("frequencies of the open loop [Hz]")
axes[2].plot(times, 1e3 * left, label="left")
axes[2].plot(times, 1e3 * right, label="right")
axes[2].set_ylabel("elongation of the belts [mm]")
axes[2].legend()
for ax in axes:
    ax.set_xlabel("time [s]")
    ax.grid(visible=True, alpha=0.3)
plt.show()

# %%
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
fm.plot.mechanism(motion, time=0.25, ax=axes[0])
axes[0].set_title("after 0.25 s")
ax = fm.plot.history(motion, ["3.y", "5.y"], ax=axes[1])

# %% [markdown]
# ## What the motion is compared with
#
# Three coordinates describe the elevator: the rotation $\varphi$ and the elongations $e_1, e_2$ of the belts. Belt $i$
# has the free length $L_i = L \pm r\varphi$, and its mass hangs at $L_i + e_i$. Here Lagrange's equations are written
# by hand and integrated by scipy.

# %%
radius, free, weight, inertia, EA, EdA, motor, damper = 0.1, 0.2, 10.0, 0.3, 1000.0, 2.5, 12.5, 3.0
sign = np.array([1.0, -1.0])
depth = np.array([[radius, 1, 0], [-radius, 0, 1]])
masses = weight * depth.T @ depth + np.diag([inertia, 0, 0])


def rates(t, state):
    phi, e, phid, ed = state[0], state[1:3], state[3], state[4:]
    lengths = free + sign * radius * phi
    tension = (EA * e + EdA * ed) / lengths
    # The energy EA e²/(2 L) falls as L grows.
    moment = -motor * phi - damper * phid + np.sum(sign * radius * EA * e**2 / (2 * lengths**2))
    return np.concatenate([state[3:], np.linalg.solve(masses, np.concatenate([[moment], -tension]))])


own = solve_ivp(rates, (0, 2.5), [1.0, 0, 0, 0, 0, 0], method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times).y
print(f"largest differences: {np.max(np.abs(turn - own[0])):.1e} rad, {np.max(np.abs(left - own[1])):.1e} m")
assert np.allclose(turn, own[0], rtol=0, atol=1e-5)
assert np.allclose(left, own[1], rtol=0, atol=1e-6)
assert np.allclose(right, own[2], rtol=0, atol=1e-6)
assert -0.2 < turn.min() < 0  # one swing, as figure A.2 shows
