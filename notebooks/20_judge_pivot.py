# %% [markdown]
# # Is it good enough?
#
# **Question.** A pivot of two crossed leaf springs shall turn a mirror by 10° to either side. Does it, what limits it,
# and which dimension moves this limit?
#
# This first question of a designer needs many numbers at once: the moment of the drive, stress and fatigue, the
# remaining support stiffness, the shift of the axis, frequencies. `fm.verdict` computes all of them over the stroke and
# shows them on one page.

# %%
import numpy as np

import flexmb as fm
from flexmb import blocks, planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The model
#
# `blocks.cross_pivot` is a building block. The leaf springs are of hard spring steel, with known strength and fatigue
# limit. They cross at a share `ratio` of their length from the base. The model is a function of its dimensions, so that
# the page can state which of them to change.

# %%
stroke, width = np.radians(10), 10e-3


def pivot(thickness, length, ratio, element=None):
    leaf = fm.Rectangle(width, thickness, fm.materials.stainless_301)
    b = fm.Builder()
    b.node("base", (0, 0))
    b.fix("base")
    blocks.cross_pivot(b, "base", "mirror", length=length, ratio=ratio, section=leaf, element=element)
    b.mass("mirror", 0.05, inertia=2e-5)
    return b.build()


dimensions = {"thickness": 0.3e-3, "length": 50e-3, "ratio": 0.3}
ax = fm.plot.mechanism(pivot(**dimensions))

# %% [markdown]
# ## The page
#
# The mirror's angle is driven, to both sides. Stiffness and shift refer to the point of the mirror on the axis.
# Strength and fatigue are always limits. The call adds two more limits: a support stiffness along y of 0.5 N/µm, and a
# shift of the axis along y of 0.1 mm at most.

# %%
wanted = {"stiffness y": 0.5e6, "parasitic y": 0.1e-3}
page = fm.verdict(pivot, {"mirror.phi": stroke}, dimensions=dimensions, limits=wanted, node="pivot axis")
print(page)

# %% [markdown]
# Each row is a subject. The table below has the curves at every stroke; `page.curves["force"]` and so on are arrays.
# Frequencies and buckling belong to the mechanism without the drive, with the drive's moment as a dead load. For the
# support stiffness the drive is fixed. A separate row lists questions without an answer.
#
# The same as a picture:

# %%
figure = fm.plot.verdict(page)

# %% [markdown]
# ## What to change
#
# The page names the limit that is reached first, its stroke, and the effect of a percent of each dimension on the
# limited number there. `page.sensitivities` has all numbers by all dimensions.

# %%
print(page.sensitivities)

# %% [markdown]
# A smaller shift requires a crossing nearer to the base. The page for a smaller ratio:

# %%
better = {**dimensions, "ratio": 0.2}
again = fm.verdict(pivot, {"mirror.phi": stroke}, dimensions=better, limits=wanted, node="pivot axis")
for row in ("stress", "support stiffness", "limits first", "by dimension"):
    print(f"{row}: {again.summary().rows[row]}")
print("good enough" if again.good else "not good enough")

# %% [markdown]
# The shift is small enough now. The stress is a quarter larger, but still far from its limit.
#
# ## What the numbers are compared with
#
# A small rotation $\varphi$ about the axis, at the share $r$ of the length from the base, bends each leaf spring with
# the moments $EI\varphi/L\,(4-6r)$ at its foot and $EI\varphi/L\,(6r-2)$ at its top. So the pivot has the stiffness
# $8EI/L\,(1-3r+3r^2)$ and, for $r < 1/2$, the stress $E t \varphi/2L\,(4-6r)$, by beam theory. The comparison uses
# beams, since clamps make leaf springs a little stiffer. The stress is proportional to the thickness over the length.

# %%
small, r = 1e-3, dimensions["ratio"]


def beams(**given):
    return pivot(**given, element=planar.spectral_beam(4))


found = fm.verdict(beams, {"mirror.phi": small}, dimensions=dimensions, steps=1)
E, t, L = 185e9, dimensions["thickness"], dimensions["length"]
EI = E * width * t**3 / 12
stiffness, stress = 8 * EI / L * (1 - 3 * r + 3 * r**2), E * t * small / (2 * L) * (4 - 6 * r)
print(f"stiffness {found.curves['drive stiffness'][1]:.6f} N m/rad, closed form {stiffness:.6f} N m/rad")
print(f"stress {1e-6 * found.curves['stress'][2]:.5f} MPa, closed form {1e-6 * stress:.5f} MPa")
table = found.sensitivities.table[found.sensitivities.answers.index("stress")]
# Forces along the leaf springs, of the order of t/L, are not in the closed form.
assert abs(found.curves["drive stiffness"][1] / stiffness - 1) < 1e-4
assert abs(found.curves["stress"][2] / stress - 1) < t / L
assert np.allclose(table, [1, -1, -6 * r / (4 - 6 * r)], atol=t / L)
assert page.limits[0].name == "parasitic y"
assert not page.good
assert again.good
