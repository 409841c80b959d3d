# %% [markdown]
# # 29 Design for yield
#
# **Question.** A guide needs a first frequency above 10.5 Hz and a low drive stiffness. Its leaf springs are cut from
# sheet metal, and the thickness scatters. Which thickness makes 95 of 100 guides good, and at which drive stiffness?

# %%
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# The guide has two leaf springs. Their nominal thickness is equal, the thicknesses of a made guide differ. The modulus
# scatters too, although it is no dimension of the design.


# %%
def guide(left, right, length, modulus):
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (0.1, length), "D": (0.1, 0)}.items():
        b.node(name, place)
    for foot, end, thickness in (("A", "B", left), ("D", "C", right)):
        leaf = fm.Rectangle(0.018, thickness, fm.Material(E=modulus, G=80e9, rho=7850))
        b.add(planar.beam, foot, end, name=f"leaf {foot}", section=leaf)
        b.fix(foot)
        b.mass(end, 0.1)
    b.add(planar.beam, "B", "C", name="stage")
    b.input("B", "x")
    b.output("B", "x")
    return b.build(release="auto")


def stage(thickness, length, left=0.0, right=0.0, modulus=210e9):
    """Build a guide from its nominal thickness and the deviation of each leaf spring."""
    return guide(thickness + left, thickness + right, length, modulus)


answers = {"frequency": "frequency 1", "drive": lambda model: fm.stiffness(model, "B", "x")}

# %% [markdown]
# The standard deviation of the thickness is 1.5 % of half a millimetre. Both leaf springs come from the same sheet:
# their thicknesses have a correlation of 0.8. The length deviates by up to 0.2 mm. The modulus has a standard deviation
# of 3 %.

# %%
made = fm.scatter(
    {
        "left": 7.5e-6,
        "right": 7.5e-6,
        "length": ("uniform", 0.2e-3),
        "modulus": ("lognormal", 0.03),
    },
    correlation={("left", "right"): 0.8},
    nominal={"left": 0.0, "right": 0.0, "modulus": 210e9},
)
print(made)

# %% [markdown]
# The first search ignores the scatter: it finds the lowest drive stiffness at 10.5 Hz. It ends at the limit.

# %%
start, bounds = {"thickness": 0.55e-3, "length": 0.1}, {"thickness": (0.3e-3, 0.8e-3), "length": (0.08, 0.12)}
nominal = fm.tune(stage, answers, start, bounds, minimize="drive", limits={"frequency": (10.5, None)})
print(nominal)

# %% [markdown]
# Half of the guides made to this design have a frequency below 10.5 Hz. Each estimated share has a confidence interval.

# %%
limits = {"frequency": (10.5, None)}
first = fm.design.robustness(stage, answers, nominal.dimensions, made, limits=limits, samples=4000)
print(first)

# %% [markdown]
# Which dimension causes the scatter? The first order computes the share of each dimension. Shares of correlated
# dimensions include half their covariance. The second order adds mean, deviation, and their error from exact designs.

# %%
tolerance = fm.design.tolerances(stage, answers, nominal.dimensions, made, second_order=True)
print(tolerance)
second_order = tolerance.mean[0], tolerance.second_order_deviations[0], tolerance.error[0]
print("second order: mean {:.4f} Hz, deviation {:.4f} Hz, error {:.1g} Hz".format(*second_order))
print(f"sampled: mean {first.mean('frequency').value:.4f} Hz, deviation {first.deviation('frequency'):.4f} Hz")

# %% [markdown]
# Now the fifth percentile, not the nominal value, must reach 10.5 Hz. The search computes sixty-four made guides of
# each design, always with the same random numbers. The percentile therefore has a derivative. The robust design has
# thicker and longer leaf springs, which are less sensitive to a few micrometres.

# %%
wanted = {"percentile 5 frequency": (10.5, None)}
robust = fm.tune(stage, answers, start, bounds, minimize="drive", limits=wanted, scatter=made, samples=64)
print(robust)
second = fm.design.robustness(stage, answers, robust.dimensions, made, limits=limits, samples=4000, seed=1)
print(second)

# %% [markdown]
# With a second limit of 1000 N/m for the drive stiffness, no thickness makes all guides good. The search finds the
# thickness with the largest yield.

# %%
acceptable = {"frequency": (10.5, None), "drive": (None, 1000.0)}
best = fm.tune(
    stage,
    answers,
    {"thickness": 0.5e-3},
    {"thickness": (0.3e-3, 0.8e-3)},
    maximize="yield",
    acceptable=acceptable,
    scatter=fm.scatter(
        {"left": 7.5e-6, "right": 7.5e-6, "length": ("uniform", 0.2e-3), "modulus": ("lognormal", 0.03)},
        correlation={("left", "right"): 0.8},
        nominal={"left": 0.0, "right": 0.0, "length": 0.1, "modulus": 210e9},
    ),
    samples=128,
)
print(best)

# %% [markdown]
# A Pareto front shows the cost of robustness: the nominal drive stiffness against the frequency that 95 of 100 guides
# exceed.

# %%
front = fm.design.robust_front(
    stage,
    {**answers, "slowness": lambda model: -fm.frequencies(model)[0]},
    start,
    bounds,
    minimize="drive",
    against="percentile 95 slowness",
    limits={"frequency": (8.0, 14.0)},
    points=5,
    scatter=made,
    samples=32,
)
figure, ax = plt.subplots(figsize=(6, 3.5), layout="constrained")
ax.plot(front["drive"], -front["percentile 95 slowness"], "o-", label="95 of 100 guides exceed")
ax.plot(front["drive"], front["frequency"], ".--", label="nominal")
ax.set_xlabel("drive stiffness [N/m]")
ax.set_ylabel("first frequency [Hz]")
ax.legend()
ax.grid(visible=True, alpha=0.3)

# %% [markdown]
# The nominal design has a yield of one half, the robust design has about 95 %. The closed form agrees: the frequency is
# proportional to the square root of E (t1^3 + t2^3)/L^3, with thicknesses t1 and t2, length L and modulus E.

# %%
rng = np.random.default_rng(9)
scores = rng.standard_normal((3, 200_000))
left, right = scores[0], 0.8 * scores[0] + 0.6 * scores[1]
thickness, length = (robust.dimensions[name] for name in ("thickness", "length"))
cubes = ((1 + 7.5e-6 / thickness * left) ** 3 + (1 + 7.5e-6 / thickness * right) ** 3) / 2
lengths = (1 + 0.2e-3 / length * rng.uniform(-1, 1, 200_000)) ** -3
closed = robust.answers["frequency"] * np.sqrt(cubes * lengths * np.exp(0.03 * scores[2]))
print(f"yield {np.mean(closed > 10.5):.4f} by the closed form, {second.fraction.value:.4f} by made guides")
assert abs(first.fraction.value - 0.5) < 0.04
assert abs(second.fraction.value - 0.95) < 0.025
assert abs(second.fraction.value - np.mean(closed > 10.5)) < 0.015
assert tolerance.error[0] < 0.02 * tolerance.deviations[0]
assert robust.answers["drive"] > 1.05 * nominal.answers["drive"]
assert len(front) == 5
