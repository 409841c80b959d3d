# %% [markdown]
# # Sweep, sensitivities and tolerances
#
# **Question.** Which dimension of a guide matters most, how precisely must it be made, how do twenty thousand designs
# compare, and which of them are best?

# %%
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## A function of named dimensions, answers as functions of the model
#
# Both serve all questions. A load of 1 N acts on each end of the stage. The buckling load is a multiple of this load.

# %%
E, rho = 210e9, 7850.0


def guide(thickness, length, width, mass, element=planar.beam, released=(2, 3)):
    leaf = fm.Rectangle(width, thickness, fm.Material(E=E, G=80e9, rho=rho), rotary=False)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (0.1, length), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(element, "A", "B", name="left", section=leaf, released=released)
    b.add(element, "D", "C", name="right", section=leaf, released=released)
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", mass / 2)
    b.mass("C", mass / 2)
    b.force("B", (0, -1.0), increment=True)
    b.force("C", (0, -1.0), increment=True)
    return b.build()


design = {"thickness": 0.5e-3, "length": 0.1, "width": 0.018, "mass": 0.206}
answers = {
    "frequency": lambda model: fm.frequencies(model)[0],
    "buckling": lambda model: fm.buckling_loads(model)[0],
}

# %% [markdown]
# `increment=True` makes the forces incremental loads: the frequency belongs to the unloaded guide, and buckling returns
# the factor of these loads.
#
# ## Sensitivities
#
# The table shows the change of an answer in percent per percent of a dimension, $\partial\ln a/\partial\ln p$. These
# are derivatives of the model, not differences.

# %%
sensitivities = fm.sensitivities(guide, answers, design)
print(sensitivities)

# %% [markdown]
# Thickness and length matter most: their power is three in the stiffness and 1.5 in the frequency. The width enters
# both answers at most in the first power.
#
# ## Tolerances
#
# Standard deviations of the dimensions determine standard deviations of the answers, and the share of each dimension.
# `samples` adds a Monte Carlo computation, which shows whether the first order suffices.

# %%
deviations = {"thickness": 5e-6, "length": 20e-6, "width": 50e-6, "mass": 1e-3}
tolerances = fm.tolerances(guide, answers, design, deviations, samples=2000)
print(tolerances)
print("sampled:", np.round(tolerances.sampled_deviations, 4))

# %% [markdown]
# Five micrometres of thickness cause nearly all of it.

# %%
samples = tolerances.samples["frequency"]
figure, ax = plt.subplots(layout="constrained")
ax.hist(samples, bins=40, density=True, label="2000 samples")
hertz = np.linspace(samples.min(), samples.max(), 200)
spread = tolerances.deviations[0]
normal = np.exp(-(((hertz - tolerances.values[0]) / spread) ** 2) / 2) / (spread * np.sqrt(2 * np.pi))
ax.plot(hertz, normal, label="first order")
ax.set_xlabel("frequency [Hz]")
ax.set_ylabel("probability density [1/Hz]")
ax.legend()
plt.show()

# %% [markdown]
# ## A sweep
#
# 40 by 25 designs, compiled once. A design that fails does not stop the others: it gets a code, and its answers are
# NaN. The result of a grid has the axes of the grid.

# %%
axes = fm.design.grid(
    thickness=np.linspace(0.2e-3, 1e-3, 40), length=np.linspace(0.05, 0.15, 25), width=[0.018], mass=[0.206]
)
sweep = fm.sweep(guide, answers, axes)
frequency, buckling = sweep["frequency"][:, :, 0, 0], sweep["buckling"][:, :, 0, 0]
print(frequency.shape, "designs, failures:", sweep.failures())

# %%
figure, ax = plt.subplots(layout="constrained")
horizontal, vertical = 1e3 * sweep.axes["length"], 1e3 * sweep.axes["thickness"]
lines = ax.contour(horizontal, vertical, frequency, levels=[2, 5, 10, 20, 50], colors="C0")
ax.clabel(lines, fmt="%g Hz")
lines = ax.contour(horizontal, vertical, buckling, levels=[20, 60, 200], colors="C3", linestyles="--")
ax.clabel(lines, fmt="%g N")
ax.set_xlabel("length [mm]")
ax.set_ylabel("thickness [mm]")
ax.set_title("frequency (solid), buckling load of either leaf spring (dashed)")
plt.show()

# %% [markdown]
# Where a solid and a dashed line cross there is a guide with that frequency and that buckling load.
#
# ## Twenty thousand designs, and the best of them
#
# A Latin hypercube covers all dimensions at once. A guide should be fast, have light leaf springs, and buckle late. A
# design is on the *Pareto front* if no other design is better in all three. `checkpoint="guides"` would save every
# chunk of designs as it is computed, so that the sweep continues after an interruption.
# `fm.design.Sweep.load("guides")` would read it.

# %%
bounds = {"thickness": (0.2e-3, 1e-3), "length": (0.05, 0.15), "width": (0.005, 0.03)}


def free(thickness, length, width):
    return guide(thickness, length, width, design["mass"])


def leaf_mass(model):
    return fm.mass(model) - design["mass"]


twenty = fm.design.latin_hypercube(20_000, bounds)
many = fm.sweep(
    free,
    {**answers, "leaf_mass": leaf_mass},
    twenty,
    units={"frequency": "Hz", "buckling": "N", "leaf_mass": "kg", "thickness": "m", "length": "m"},
)
front = many.pareto(minimize="leaf_mass", maximize="frequency")
print(front)

# %% [markdown]
# The front among all designs. Many designs are drawn as hexagons, darker for more designs.

# %%
ax = fm.plot.sweep(front)
plt.show()

# %% [markdown]
# All designs of the front are short; light ones are narrow, heavy ones thick. Here they are on a map of the mean
# frequency over two dimensions:

# %%
ax = fm.plot.sweep(front, "frequency", over=["thickness", "length"])
plt.show()

# %% [markdown]
# ## Leaf springs as they are
#
# So far a leaf spring was a cubic beam, which has closed forms. With `planar.leaf_spring`, which agrees with solid
# elements, the guide is 1.9 % faster: clamps keep its leaf springs flat over a distance proportional to their width, so
# the width has more effect on the frequency. The conclusion stays: thickness and length matter most.


# %%
def leaf_guide(thickness, length, width, mass):
    return guide(thickness, length, width, mass, element=planar.leaf_spring, released=None)


real = fm.sensitivities(leaf_guide, {"frequency": answers["frequency"]}, design)
print(real)

# %% [markdown]
# ## What the numbers are compared with
#
# With the moving mass $M = m + \mu$, $\mu = \tfrac{26}{35}\rho wtl$, the frequency is
# $\frac{1}{2\pi}\sqrt{2Ewt^3/(l^3M)}$. Its sensitivities are $\tfrac32 - \tfrac{\mu}{2M}$ for the thickness, $-\tfrac32
# - \tfrac{\mu}{2M}$ for the length, $\tfrac12 - \tfrac{\mu}{2M}$ for the width and $-\tfrac{m}{2M}$ for the mass. One
# cubic beam buckles at $10EI/l^2$ (exactly $\pi^2EI/l^2$), with the power 3 of the thickness, −2 of the length and 1 of
# the width. The stiffness of leaf springs in sway is larger by $1/(1 - \nu^2(1 - (1 - 0.8\,w/l)^3))$ (flexmb/THEORY.md,
# 13.9), which also gives their sensitivities.

# %%
t, length, w, m = design.values()
mu = 26 / 35 * rho * w * t * length
share = mu / (m + mu)
expected = np.array([[1.5 - share / 2, -1.5 - share / 2, 0.5 - share / 2, (share - 1) / 2], [3, -2, 1, 0]])
assert np.allclose(sensitivities.table, expected, rtol=0, atol=1e-7)

relative = np.array([deviations[name] / value for name, value in design.items()])
first_order = sensitivities.values * np.sqrt(expected**2 @ relative**2)
assert np.allclose(tolerances.deviations, first_order, rtol=1e-6)
# 2000 samples know a standard deviation to 1/sqrt(4000), 1.6 %; three times that.
assert np.allclose(tolerances.sampled_deviations, first_order, rtol=0.05)

tt, ll = np.meshgrid(sweep.axes["thickness"], sweep.axes["length"], indexing="ij")
closed = np.sqrt(2 * E * w * tt**3 / ll**3 / (m + 26 / 35 * rho * w * tt * ll)) / (2 * np.pi)
assert not sweep.failures()
assert np.allclose(frequency, closed, rtol=1e-9)
assert np.allclose(buckling, 10 * E * w * tt**3 / 12 / ll**2, rtol=1e-9)

# Leaf springs of a mass mu have a stiffness E mu t^2/(rho l^4): the fastest are short, and as thick as their mass lets
# them be at the least width. No design is faster, and of so many some come near to it.
added, shortest = front["leaf_mass"], bounds["length"][0]
thickest = np.minimum(bounds["thickness"][1], added / (2 * rho * bounds["width"][0] * shortest))
fastest = np.sqrt(E * added * thickest**2 / (rho * shortest**4) / (m + 13 / 35 * added)) / (2 * np.pi)
print(
    f"the front has {front['frequency'].min():.1f} to {front['frequency'].max():.1f} Hz, "
    f"{np.min(front['frequency'] / fastest):.0%} to {np.max(front['frequency'] / fastest):.0%} of what is possible"
)
assert not many.failures()
assert np.all(front["frequency"] < fastest)
assert np.median(front["frequency"] / fastest) > 0.9

# Stretch of the leaf springs is of the order of (t/l)^2; their mass counts a little else than that of cubic beams.
nu, a = 210 / 160 - 1, 0.4 * w / length
lost = nu**2 * (1 - (1 - 2 * a) ** 3)
by_width = 3 * a * nu**2 * (1 - 2 * a) ** 2 / (1 - lost)
assert np.isclose(real.values[0], sensitivities.values[0] / np.sqrt(1 - lost), rtol=3e-4)
assert np.allclose(real.table[0], expected[0] + [0, -by_width, by_width, 0], rtol=0, atol=1e-3)
