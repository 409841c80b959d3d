# %% [markdown]
# # Third page: tune a dimension
#
# **Question.** Which thickness of the leaf springs gives 15 Hz?
#
# This page takes five minutes. It continues [the first page](24_first_guide.ipynb).

# %%
import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# A design is a function of named dimensions that returns a model.

# %%
steel = fm.Material(E=210e9, G=80e9, rho=7850)


def guide(thickness, length=0.1):
    leaf = fm.Rectangle(width=0.018, thickness=thickness, material=steel)
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, length))
    b.node("C", (0.1, length))
    b.node("D", (0.1, 0))
    b.add(planar.leaf_spring, "A", "B", name="left", section=leaf)
    b.add(planar.leaf_spring, "D", "C", name="right", section=leaf)
    b.add(planar.rigid_body, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    return b.build()


# %% [markdown]
# A sensitivity is the change of an answer in percent, if a dimension changes by one percent. Sensitivities show which
# dimension matters.

# %%
answers = {"frequency": lambda model: fm.frequencies(model)[0]}
start = {"thickness": 0.5e-3, "length": 0.1}
print(fm.sensitivities(guide, answers, start))

# %% [markdown]
# `fm.tune` changes the dimensions until the answer has its target. Here only the thickness may change.

# %%
found = fm.tune(
    guide, answers, {"thickness": 0.5e-3}, bounds={"thickness": (0.2e-3, 1e-3)}, targets={"frequency": 15.0}
)
print(found)

# %%
ax = fm.plot.mechanism(guide(**found.dimensions), names=True)

# %% [markdown]
# The stiffness of a leaf spring is proportional to the cube of its thickness. The mass of the leaf springs is small.
# The frequency is therefore proportional to the thickness to the power 1.5. If the frequency is $f$ at 0.5 mm, the
# thickness for 15 Hz is close to $0.5\,\mathrm{mm}\,(15/f)^{2/3}$.
#
# Where to go from here: [the manual and all notebooks](README.md).

# %%
before = float(fm.frequencies(guide(0.5e-3))[0])
expected = 0.5e-3 * (15 / before) ** (2 / 3)
print(f"thickness {found.dimensions['thickness'] * 1e3:.4f} mm, by the power law {expected * 1e3:.4f} mm")
assert abs(fm.frequencies(guide(**found.dimensions))[0] / 15 - 1) < 1e-6
assert abs(found.dimensions["thickness"] / expected - 1) < 0.02
