# %% [markdown]
# # A controller for the elevator
#
# **Question.** Can one controller bring the elevator into place along its whole travel, although its natural
# frequencies change on the way?
#
# The elevator of notebook 06 loses the spring and the damper that represented the controller of its motor. It gets a
# real controller: the height of the left mass, the cabin, is measured, and the motor turns the pulley. A belt lies
# between sensor and motor.

# %%
import warnings
from pathlib import Path

import control
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.mechanisms import mechanism_path

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The machine and its travel
#
# The motor's spring and damper, the start and the signals of the file are left out; an input and an output are added.
# The travel turns the pulley from 0.8 to −0.8 rad in two seconds, which raises the cabin by 160 mm.

# %%
LEFT_OUT = ("ESTIFF 1", "EDAMP 1", "STARTDE", "INPUTS", "OUTE", "TIMESTEP", "ERROR")
lines = Path(mechanism_path("elevator")).read_text(encoding="utf-8").splitlines()
text = "\n".join(line for line in lines if not line.startswith(LEFT_OUT))
radius, free, weight, inertia, EA, EdA = 0.1, 0.2, 10.0, 0.3, 1000.0, 2.5
first, duration = 0.8, 2.0


def elevator(cabin=weight):
    b = fm.read_spacar(text.replace("XM 3 10", f"XM 3 {cabin}")).builder
    b.start("1", 1, first, kind="element")
    b.input("2", "phi", name="motor", kind="node")
    b.output("3", "y", name="cabin", kind="node")
    return b.build(dofs="named")


def height(t):
    """Wanted height of the cabin [m]."""
    s = jnp.clip(t / duration, 0, 1)
    return -radius * first * (1 - 2 * (10 * s**3 - 15 * s**4 + 6 * s**5))


def moment(t):
    """Moment that turns the pulley so while the belts do not stretch [N m]."""
    s = jnp.clip(t / duration, 0, 1)
    turning = -2 * first * (60 * s - 180 * s**2 + 120 * s**3) / duration**2
    return (inertia + 2 * weight * radius**2) * turning


model = elevator()
times = np.linspace(0, 6, 241)
nominal = fm.simulate(model, times, inputs={"motor": moment}, rtol=1e-7)

# %% [markdown]
# ## Frequencies over the travel
#
# `inputs=` drives the motion: functions of time by the names of inputs, here a feedforward alone. Linearised at its
# times, the elevator has a motion without stiffness and two vibrations of the belts.

# %%
along = nominal.linearizations()
places = range(0, 81, 4)
hertz = []
for step in places:
    poles = fm.to_statespace(along.at_time(step)).poles()
    hertz.append(np.sort(np.abs(poles.imag))[[2, 4]] / (2 * np.pi))
hertz = np.array(hertz)
(low, high), (upper_low, upper_high) = np.stack([hertz.min(axis=0), hertz.max(axis=0)], axis=1)
print(f"lower {low:.2f} to {high:.2f} Hz, upper {upper_low:.2f} to {upper_high:.2f} Hz")

# %% [markdown]
# ## A PID controller by pole placement
#
# `fm.control.pid` treats the elevator as one mass without vibrations, and places the four poles of the loop: a pair at
# 0.6 Hz with a damping ratio of 0.7, a slow one by the integrator, a fast one by the filter. The mass is constant along
# the travel, so one gain serves all of it. `fm.control.closed_loop` evaluates the whole mechanism with its vibrations.

# %%
pid = fm.control.pid(model, 0.6, slow=0.3)
print(pid.input_labels, "→", pid.output_labels)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    bare = fm.control.closed_loop(along.at_time(0), pid)
print(said[0].message)

# %% [markdown]
# The loop feeds the lower vibration with the wrong phase, since the sensor is on the other side of the belt. A notch
# filter removes the gain there. A narrow one at the frequency of the start does not suffice, because this frequency
# moves during the travel. A broad one between both vibrations serves everywhere.

# %%
filters = {
    "no notch": control.tf([1], [1]),
    "narrow notch at 3.3 Hz": fm.control.notch(3.3, depth=0.05, width=0.5),
    "broad notch at 4 Hz": fm.control.notch(4.0, depth=0.03, width=1.5),
}
designs = {
    name: control.ss(pid * own, inputs=pid.input_labels, outputs=pid.output_labels) for name, own in filters.items()
}
figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
axes[0].plot(times[places], hertz, label=["lower", "upper"])
axes[0].set_ylabel("frequency [Hz]")
growth, modulus = {}, {}
for name, design in designs.items():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        loops = [fm.control.closed_loop(along.at_time(step), design) for step in places]
    growth[name] = np.array([loop.growth for loop in loops])
    modulus[name] = np.array([loop.margins[0].modulus for loop in loops])
    axes[1].plot(times[places], growth[name], label=name)
axes[1].axhline(0, color="black", linewidth=0.8)
axes[1].set_ylabel("growth of the closed loop [1/s]")
for ax in axes:
    ax.set_xlabel("time of the travel [s]")
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
plt.show()
print(fm.control.closed_loop(along.at_time(40), designs["broad notch at 4 Hz"]))

# %% [markdown]
# ## The travel, and a step
#
# The cabin is 1 kg heavier than the feedforward assumes. At 3.5 s a step asks for 10 mm more. The controller may use
# 2 N m of the motor at most: `fm.control.saturated` limits it, and keeps the integrator from winding up, with a time
# constant of 0.2 s. Feedforward by `inputs=` and feedback by `control=` work together.

# %%
heavy, added, late, limit, tracking = elevator(11.0), 0.01, 3.5, 2.0, 0.2


def wanted(t):
    return height(t) + jnp.where(t < late, 0.0, added)


alone = fm.simulate(heavy, times, inputs={"motor": moment}, rtol=1e-7)
chosen = designs["broad notch at 4 Hz"]
motion = fm.simulate(
    heavy,
    times,
    inputs={"motor": moment},
    control=fm.control.saturated(chosen, limit, tracking=tracking),
    reference=wanted,
    jumps=[late],
    rtol=1e-7,
)
asked = np.array([float(wanted(t)) for t in times])
cabin = np.asarray(motion.at("3"))[:, 1]
open_loop = np.asarray(alone.at("3"))[:, 1]

figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
axes[0].plot(times, 1e3 * asked, "k:", label="wanted")
axes[0].plot(times, 1e3 * open_loop, label="feedforward alone")
axes[0].plot(times, 1e3 * cabin, label="with the controller")
axes[0].set_ylabel("height of the cabin [mm]")
axes[0].legend()
axes[1].plot(times, 1e3 * (asked - cabin))
axes[1].set_ylabel("error with the controller [mm]")
axes[2].plot(times, np.asarray(motion.u)[:, 0], label="controller")
axes[2].plot(times, [float(moment(t)) for t in times], label="feedforward")
axes[2].set_ylabel("moment of the motor [N m]")
axes[2].legend()
for ax in axes:
    ax.set_xlabel("time [s]")
    ax.grid(visible=True, alpha=0.3)
plt.show()

# %% [markdown]
# Feedforward alone misses by some millimetres, since it assumes a wrong mass; the controller corrects this.
#
# ## What the motion is compared with
#
# The equations of notebook 06 with the controller, its limit and its integrator, written by hand and integrated by
# scipy from corner to corner.

# %%
sign = np.array([1.0, -1.0])
depth = np.array([[radius, 1, 0], [-radius, 0, 1]])
masses = depth.T @ np.diag([11.0, weight]) @ depth + np.diag([inertia, 0, 0])
A, B, C, D = (np.asarray(part) for part in (chosen.A, chosen.B, chosen.C, chosen.D))
values, vectors = np.linalg.eig(A)
integrator = np.real(vectors[:, np.argmin(np.abs(values))])
leads = integrator / (C @ integrator).item() / tracking


def rates(t, state):
    phi, e, ed, z = state[0], state[1:3], state[4:6], state[6:]
    error = float(wanted(t)) + (radius * phi + e[0])
    asks = (C @ z + D[:, 0] * error).item()
    gives = np.clip(asks, -limit, limit)
    lengths = free + sign * radius * phi
    tension = (EA * e + EdA * ed) / lengths
    drive = gives + float(moment(t)) + np.sum(sign * radius * EA * e**2 / (2 * lengths**2))
    accelerations = np.linalg.solve(masses, np.concatenate([[drive], -tension]))
    return np.concatenate([state[3:6], accelerations, A @ z + B[:, 0] * error + leads * (gives - asks)])


state, own = np.concatenate([[first], np.zeros(5 + len(A))]), []
for span in (times[times <= late], times[times >= late]):
    # Up to the step its reference is that before it.
    ends = (span[0], span[-1] - (1e-12 if span[-1] == late else 0))
    part = solve_ivp(rates, ends, state, rtol=1e-8, atol=1e-11, t_eval=np.clip(span, *ends), max_step=0.02)
    own.append(-(radius * part.y[0] + part.y[1]))
    state = part.y[:, -1]
own = np.concatenate([own[0], own[1][1:]])
print(f"largest difference {1e6 * np.max(np.abs(cabin - own)):.2f} µm")

w = 2 * np.pi * 0.6
rigid = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0], [-radius / 0.5]], [[1.0, 0.0]], [[0.0]])
found = np.sort_complex(fm.control.closed_loop(rigid, control.ss(pid, inputs=1, outputs=1)).poles)
placed = np.sort_complex(w * np.array([-4.0, -0.7 - 1j * np.sqrt(0.51), -0.7 + 1j * np.sqrt(0.51), -0.3]))
assert np.allclose(found, placed, rtol=1e-6)
assert np.max(np.abs(cabin - own)) < 1e-6
assert not bare.stable
assert np.max(growth["no notch"]) > 0.5
assert np.max(growth["narrow notch at 3.3 Hz"]) > 0
assert np.max(growth["broad notch at 4 Hz"]) < -0.4
assert np.min(modulus["broad notch at 4 Hz"]) > 0.4
assert np.max(np.abs(np.asarray(motion.u))) <= limit
assert abs(open_loop[-1] - height(6.0)) > 2e-3
assert abs(cabin[-1] - asked[-1]) < 0.5e-3
