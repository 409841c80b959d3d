# %% [markdown]
# # Tune a leaf spring
#
# **Question.** How thick must the leaf springs of a guide be for 20 Hz, and which guide has the least mass if its
# frequencies are limited?
#
# Both are questions for `fm.tune`: a function from named dimensions to a model, answers as functions of the model, and
# what is wanted of the answers. Derivatives come from the model itself, so that a search takes few evaluations.

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
# Now the leaf springs may stretch too, so that there are frequencies besides that of the motion. The mass of the guide
# is to be small; the motion shall have 8 Hz, and the first other mode, in which the leaf springs stretch, at least 1500
# Hz. Thickness, length and width are free within bounds.


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
# The result says why the search ended and which bounds and limits it ran into. The two frequencies fix the ratio of
# thickness to length, and the width; of the guides that remain the shortest is the lightest, so that the length goes to
# its bound.
#
# ## Leaf springs as they are, and their strength
#
# So far a leaf spring was a cubic beam, which has a closed form. Near its clamps a leaf spring is a plate, stiffer by
# $1/(1-\nu^2)$, and may be 1 % thinner for the same frequency. `planar.leaf_spring` counts that. The material here is a
# spring steel of the catalogue, which states its strength: `utilisation` is the part of it that a stroke of 5 mm uses.

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
# ## What the numbers are compared with
#
# *The thickness for 20 Hz* is the root of the closed form $\frac{1}{2\pi}\sqrt{2Ewt^3/(l^3M)} = 20$ Hz with the moving
# mass $M = m + \tfrac{26}{35}\rho wtl$.
#
# *Leaf springs as they are* have in sway $1/(1 - \nu^2(1 - (1 - 0.8\,w/l)^3))$ times that stiffness
# (flexmb/THEORY.md, 13.9), and stretch by the order of $(t/l)^2$.
#
# *The lightest guide.* Along the leaf springs the stage moves on $2EA/l$, with the same moving mass. So $\omega_1^2 =
# 2Ewt^3/(l^3M)$ and $\omega_2^2 = 2Ewt/(lM)$, and with both frequencies reached, at $l = 50$ mm,
#
# $$\frac tl = \frac{\omega_1}{\omega_2}, \qquad
# w = \frac{m\,\omega_2^2}{2E\,t/l - \tfrac{26}{35}\rho\,t\,l\,\omega_2^2} .$$

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
