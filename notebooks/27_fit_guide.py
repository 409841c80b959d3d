# %% [markdown]
# # 27 Fit a guide from its frequency response
#
# **Question.** A guide was built and its frequency response was measured. How thick are its leaf springs, how stiff is
# the clamp, and which numbers does the measurement not determine?

# %%
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# The model has three unknown numbers: the thickness of the leaf springs, the rotational stiffness of one clamp and the
# moving mass. Structural damping, the gain of the sensor and the delay of the measuring chain are unknown too. They
# belong to the measurement, not to the mechanism.

# %%
steel = fm.Material(E=210e9, G=80e9, rho=7850)


def guide(thickness, clamp, mass):
    leaf = fm.Rectangle(width=0.018, thickness=thickness, material=steel)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.leaf_spring(4), "A", "B", name="left", section=leaf)
    b.add(planar.leaf_spring(4), "D", "C", name="right", section=leaf)
    b.add(planar.rigid_body, "B", "C", name="stage")
    b.fix("A", "x", "y")
    b.rotation("wall")
    b.fix("wall")
    b.add(planar.hinge, "wall", "A", name="clamp", released=(1,), stiffness=clamp)
    b.fix("D")
    b.mass("B", mass / 2)
    b.mass("C", mass / 2)
    b.input("B", "x")
    b.output("B", "x")
    return b.build()


# %% [markdown]
# The measurement is simulated here, so that the true numbers are known: 200 frequencies up to 400 Hz, with a scatter of
# 2 % of each value.

# %%
truth = {"thickness": 0.52e-3, "clamp": 60.0, "mass": 0.19, "loss": 0.012, "gain": 1.04, "delay": 20e-6}
hertz = np.linspace(2.0, 400.0, 200)
model = guide(truth["thickness"], truth["clamp"], truth["mass"])
clean = np.asarray(fm.frequency_response(model, hertz, loss_factor=truth["loss"]).of())
clean = truth["gain"] * clean * np.exp(-2j * np.pi * hertz * truth["delay"])
rng = np.random.default_rng(0)
deviation = 0.02 * np.abs(clean)
values = clean + deviation * (rng.standard_normal(200) + 1j * rng.standard_normal(200))

# %% [markdown]
# The fit starts from the drawing, up to 20 % off. Parameters that are no arguments of the model belong to the
# measurement.

# %%
data = fm.measured_response(hertz, values, deviation, loss_factor="loss", gain="gain", delay="delay")
start = {"thickness": 0.5e-3, "clamp": 72.0, "mass": 0.2, "loss": 0.01, "gain": 1.0, "delay": 0.0}
bounds = {
    "thickness": (0.3e-3, 0.8e-3),
    "clamp": (5.0, 5000.0),
    "mass": (0.1, 0.4),
    "loss": (1e-3, 0.1),
    "gain": (0.5, 2.0),
    "delay": (-1e-4, 1e-4),
}
found = fm.fit(guide, data, start, bounds)
print(found)

# %% [markdown]
# Chi-squared is near its degrees of freedom: the model explains the data within their scatter. The correlation shows
# the parameters that the data hardly separate. Here these are the mass, the thickness and the gain: all three change
# the height of the response.

# %%
figure = fm.plot.fit(found)

# %% [markdown]
# Every parameter has a confidence interval. Predictions have standard deviations too, also for answers that were never
# measured.

# %%
for name in found.labels:
    lower, upper = found.interval(name)
    print(f"{name:10} {lower:.6g} to {upper:.6g}, true {truth[name]:.6g}")
for name, prediction in found.predict(["frequency 1", "frequency 3", "stiffness B.x"]).items():
    print(f"{name}: {prediction.value:.5g} ± {prediction.deviation:.2g}")

# %% [markdown]
# Which further measurement would reduce the uncertainty of the mass most? Three are possible, each with its expected
# deviation.

# %%
candidates = [
    fm.measured("mass", 0.2, 0.5e-3, name="weigh the stage"),
    fm.measured("stiffness B.x", 1000.0, 5.0, name="push the stage"),
    fm.measured_modes([700.0], 1.0, numbers_of_modes=[4], name="hear mode 4"),
]
for name, share in found.next_measurement(candidates, narrow="mass"):
    print(f"{name}: {100 * share:.0f} % of the standard deviation remain")

# %% [markdown]
# All intervals of four standard deviations contain the true value. Every start value was outside its interval.

# %%
for name, value in truth.items():
    assert abs(found.parameters[name] - value) < 4 * found.deviation[name]
assert found.probability > 0.01
