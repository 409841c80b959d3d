# %% [markdown]
# # Tune a leaf spring
#
# **Question.** How thick must the leaf springs of a guide be for 20 Hz? Which guide with limited frequencies has the
# least mass? How many leaf springs of which material should it have? Which mechanism has a wanted force?
#
# `fm.tune` answers all of them. It takes a function from named dimensions to a model, answers as functions of the
# model, and targets for the answers. The model provides derivatives, so a search takes few evaluations.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## One dimension, one target
#
# The guide of the first notebook, as a function of its thickness.

# %%
steel = fm.Material(E=210e9, G=80e9, rho=7850)
mass = 0.206  # kg


def guide(thickness, length=0.1, width=0.018, released=(2, 3), element=planar.beam, material=steel, stroke=None):
    leaf = fm.Rectangle(width, thickness, material, rotary=False)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (0.1, length), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(element, "A", "B", name="left", section=leaf, released=released)
    b.add(element, "D", "C", name="right", section=leaf, released=released)
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    for end in "BC":  # two masses at the ends have more rotary inertia than the bar that they stand for
        b.mass(end, mass / 2, inertia=-mass * 0.1**2 / 12)
    if stroke is not None:
        b.prescribe("B", "x", stroke)
    return b.build()


found = fm.tune(
    guide,
    {"frequency": lambda model: fm.frequencies(model)[0]},
    {"thickness": 0.5e-3},
    bounds={"thickness": (0.1e-3, 2e-3)},
    targets={"frequency": 20.0},
)
print(found)

# %% [markdown]
# Every evaluation is in `found.history`. The search starts at 10.6 Hz and converges quadratically at the end:

# %%
figure, ax = plt.subplots(layout="constrained")
ax.semilogy(np.abs(found.history["frequency"] / 20 - 1), "o-")
ax.set_xlabel("evaluation")
ax.set_ylabel("relative error of the frequency")
ax.grid(visible=True, alpha=0.3)
plt.show()

# %% [markdown]
# ## Several dimensions, limits
#
# Now the leaf springs may stretch too, so that there are further frequencies. The mass of the guide shall be small. The
# motion shall have 8 Hz, and the next mode, in which the leaf springs stretch, at least 1500 Hz. Thickness, length and
# width are free within bounds.


# %%
def free(thickness, length, width):
    return guide(thickness, length, width, released=(1, 2, 3))


start = {"thickness": 0.5e-3, "length": 0.1, "width": 0.018}
lightest = fm.tune(
    free,
    {
        "frequency": lambda model: fm.frequencies(model)[0],
        "parasitic": lambda model: fm.frequencies(model)[1],
        "mass": fm.mass,
    },
    start,
    bounds={"thickness": (0.1e-3, 1e-3), "length": (0.05, 0.15), "width": (0.005, 0.03)},
    minimize="mass",
    equal={"frequency": 8.0},
    limits={"parasitic": (1500.0, None)},
)
print(lightest)

# %%
ax = fm.plot.mechanism(free(**lightest.dimensions))

# %% [markdown]
# The result states why the search ended and which bounds and limits are active. The two frequencies determine the ratio
# of thickness to length, and the width. Of the remaining guides the shortest is the lightest, so the length reaches its
# bound.
#
# ## Leaf springs as they are, and their strength
#
# So far a leaf spring was a cubic beam, which has a closed form. Near its clamps a leaf spring is a plate, stiffer by
# $1/(1-\nu^2)$, and may be 1 % thinner for the same frequency. `planar.leaf_spring` includes this effect. The material
# here is a spring steel of the catalogue with known strength: `utilisation` is the share of this strength that a stroke
# of 5 mm uses.

# %%
spring_steel = fm.materials.stainless_17_7


def real(thickness, stroke=None):
    return guide(thickness, released=None, element=planar.leaf_spring, material=spring_steel, stroke=stroke)


clamped = fm.tune(
    real,
    {"frequency": lambda model: fm.frequencies(model)[0]},
    {"thickness": 0.5e-3},
    bounds={"thickness": (0.1e-3, 2e-3)},
    targets={"frequency": 20.0},
)
print(clamped)
used = float(fm.stress(real(clamped.dimensions["thickness"], stroke=5e-3)).utilisation.max())
print(f"a stroke of 5 mm uses {used:.1%} of the strength")

# %% [markdown]
# ## How many, and of what
#
# Numbers of leaf springs and materials have no derivative. `choices` searches every combination and returns the best,
# with a table of all. Here a guide shall have 8 Hz, and a stroke of 5 mm may use at most a third of the strength;
# sheets are at least 0.15 mm thick. Which leaf springs are the lightest? The stress of a beam in sway is $3Etd/l^2$.

# %%
reach, share, thinnest_sheet = 5e-3, 1 / 3, 0.15e-3
materials = {"steel": (210e9, 7850.0, 1200e6), "titanium": (114e9, 4430.0, 880e6), "bronze": (120e9, 8800.0, 700e6)}


def several(thickness, length, count, material):
    modulus, density, strength = material
    leaf = fm.Rectangle(0.01, thickness, fm.Material(E=modulus, G=modulus / 2.6, rho=density), rotary=False)
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, length))
    for i in range(count):
        b.add(planar.beam, "A", "B", name=f"leaf {i}", section=leaf, released=(1, 2, 3) if i else (2, 3))
    b.fix("A")
    b.fix("B", "rotation")
    b.mass("B", mass)
    return b.build(), 3 * modulus * thickness * reach / length**2 / strength


chosen = fm.tune(
    several,
    {
        "frequency": lambda made: fm.frequencies(made[0])[0],
        "used": lambda made: made[1],
        "mass": lambda made: fm.mass(made[0]) - mass,
    },
    {"thickness": 0.4e-3, "length": 0.08},
    bounds={"thickness": (thinnest_sheet, 1e-3), "length": (0.02, 0.15)},
    minimize="mass",
    equal={"frequency": 8.0},
    limits={"used": (None, share)},
    choices={"count": [2, 4], "material": materials},
)
print(chosen)

# %% [markdown]
# ## A whole curve as target
#
# Two bars that lean against each other snap through when they are pushed down. The force first rises, then falls, and
# changes sign where the bars lie flat. Which stiffness and which height give a wanted force along the stroke?
#
# The drive is prescribed with `increment=True`, as 1 m per unit of the increment, so that increments are strokes in
# metres. `fm.equilibria` computes the states at all strokes in one compiled program, each from the state before.

# %%
spring = 100.0  # N/m, between the drive and the bars


def flat_truss(stiffness, height):
    b = fm.Builder()
    for name, place in {"left": (-10, 0), "right": (10, 0), "apex": (0, height), "drive": (0, height + 2)}.items():
        b.node(name, place)
    for foot in ("left", "right"):
        b.add(planar.truss, foot, "apex", section=fm.Rigidity(EA=stiffness, mass=1.0))
        b.fix(foot)
    b.add(planar.truss, "drive", "apex", section=fm.Rigidity(EA=2 * spring, mass=1.0))
    b.fix("apex", "x")
    b.fix("drive", "x")
    b.prescribe("drive", "y", -1.0, increment=True)
    return b.build()


def force_at(height):
    """Force down that holds bars of 10 kN and 1 m of height with their apex at a height, in closed form."""
    return 2e4 * (1 / np.hypot(10, height) - 1 / np.hypot(10, 1)) * height


heights = np.linspace(0.9, -1.1, 9)
wanted = fm.design.Curve(1 - heights + force_at(heights) / spring, force_at(heights), "stroke [m]")


def force(model):
    along = fm.equilibria(model, increment=wanted.over)
    return -along.reactions[:, along.labels.known("drive")[1]]


snapping = fm.tune(
    flat_truss,
    force,
    {"stiffness": 7e3, "height": 1.2},
    bounds={"stiffness": (5e3, 2e4), "height": (0.8, 1.3)},
    targets={"force": wanted},
)
print(snapping)

# %%
figure = fm.plot.tuning(snapping)
plt.show()

# %% [markdown]
# ## What the numbers are compared with
#
# *The thickness for 20 Hz* is the root of the closed form $\frac{1}{2\pi}\sqrt{2Ewt^3/(l^3M)} = 20$ Hz with the moving
# mass $M = m + \tfrac{26}{35}\rho wtl$.
#
# *Leaf springs as they are*: the stiffness in sway is larger by $1/(1 - \nu^2(1 - (1 - 0.8\,w/l)^3))$
# (flexmb/THEORY.md, 13.9), and they stretch by the order of $(t/l)^2$.
#
# *The lightest guide.* Along the leaf springs the stage moves on $2EA/l$, with the same moving mass. So $\omega_1^2 =
# 2Ewt^3/(l^3M)$ and $\omega_2^2 = 2Ewt/(lM)$. If both frequencies are reached, at $l = 50$ mm,
#
# $$\frac tl = \frac{\omega_1}{\omega_2}, \qquad
# w = \frac{m\,\omega_2^2}{2E\,t/l - \tfrac{26}{35}\rho\,t\,l\,\omega_2^2} .$$

#
# *How many, and of what.* With $n$ leaf springs $\omega^2 = nEwt^3/(l^3M)$, $M = m + \tfrac{13}{35}\mu$. At the stress
# limit $t = s\,l^2$, $s = \sigma/(3Ed)$, so that $l^3 = \omega^2M/(nEws^3)$. Then $\mu = n\rho wtl =
# \rho\omega^2M/(Es^2)$ for any number of leaf springs, except where sheets would be too thin.
#
# *The force along the stroke* is the force of bars of $EA = 10$ kN that are 1 m high.

# %%
length, width = 0.1, 0.018


def thickness_for(hertz, material, stiffer=1.0):
    def residual(t):
        moving = mass + 26 / 35 * material.rho * width * t * length
        return np.sqrt(stiffer * 2 * material.E * width * t**3 / length**3 / moving) - 2 * np.pi * hertz

    return brentq(residual, 1e-4, 2e-3, xtol=1e-15)


expected = thickness_for(20, steel)
print(f"closed form: {1e3 * expected:.9f} mm, tuned: {1e3 * found.dimensions['thickness']:.9f} mm")

plate = float(spring_steel.poisson()) ** 2 * (1 - (1 - 0.8 * width / length) ** 3)
beams, leaves = thickness_for(20, spring_steel), thickness_for(20, spring_steel, 1 / (1 - plate))
tuned = clamped.dimensions["thickness"]
print(f"spring steel: {1e3 * beams:.4f} mm by beams, {1e3 * leaves:.4f} mm with clamps, tuned {1e3 * tuned:.4f} mm")

ratio, omega, shortest = 8 / 1500, 2 * np.pi * 1500, 0.05
thinnest = ratio * shortest
narrowest = mass * omega**2 / (2 * steel.E * ratio - 26 / 35 * steel.rho * thinnest * shortest * omega**2)
least = mass + 2 * steel.rho * narrowest * thinnest * shortest
dims = lightest.dimensions
print(f"closed form: {1e3 * thinnest:.4f} mm thick, {1e3 * narrowest:.4f} mm wide, {least:.6f} kg")

assert abs(found.dimensions["thickness"] / expected - 1) < 1e-9
assert abs(lightest.answers["frequency"] / 8 - 1) < 1e-5
assert lightest.answers["parasitic"] >= 1500.0
assert abs(dims["length"] / shortest - 1) < 1e-6
assert abs(dims["thickness"] / thinnest - 1) < 1e-3
assert abs(dims["width"] / narrowest - 1) < 1e-3
assert abs(lightest.answers["mass"] / least - 1) < 1e-5
assert abs(tuned / leaves - 1) < 1e-3
assert 0.005 < 1 - tuned / beams < 0.015
# The stress of a beam in sway, 3 E t d/l^2, and up to a sixth more at clamps.
assert 1 < used * spring_steel.strength / (3 * spring_steel.E * tuned * 5e-3 / length**2) < 7 / 6

for one in chosen.combinations:
    count, (modulus, density, strength) = one.choices.values()
    slope, moving = share * strength / (3 * modulus * reach), mass
    for _ in range(20):
        # As thin as stress allows, or as sheets are.
        span = np.cbrt((16 * np.pi) ** 2 * moving / (count * modulus * 0.01 * slope**3))
        thin = max(slope * span**2, thinnest_sheet)
        span = thin * np.cbrt(count * modulus * 0.01 / ((16 * np.pi) ** 2 * moving))
        light = count * density * 0.01 * thin * span
        moving = mass + 13 / 35 * light
    assert abs(one.tuned.answers["mass"] / light - 1) < 1e-4
assert (chosen.choices["count"], chosen.choices["material"]) == (2, materials["titanium"])
assert abs(snapping.dimensions["stiffness"] / 1e4 - 1) < 1e-5
assert abs(snapping.dimensions["height"] - 1) < 1e-6
