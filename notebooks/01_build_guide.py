# %% [markdown]
# # A first mechanism
#
# **Question.** How fast does a stage on two leaf springs vibrate, and how does that depend on their thickness?
#
# Two leaf springs stand upright, 0.1 m long and 0.1 m apart. A rigid bar joins their tops. The leaf springs bend, so
# the bar moves to the left and to the right. They hardly stretch, so the bar does not move up and down. This mechanism
# is the straight guide of the tutorial *Prototype modelling of mechanical systems* (Aarts, Jonker, van Dijk, University
# of Twente, 2012).

# %%
import jax
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
# Compiled code is kept on disk, so that this notebook starts faster the second time.
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# `enable_x64` is always needed. A leaf spring is about 10⁵ times stiffer in tension than in bending, and single
# precision has too few digits for both. `enable_cache` is optional. `thorough=False` compiles quickly. Omit it if you
# compute a model many thousands of times.
#
# ## Nodes, elements, supports, masses
#
# A `Builder` makes a mechanism. A **node** has a name and a position. An **element** joins nodes; this mechanism has
# three planar beams. Elements that meet at a node share its position and its rotation, so they are clamped together. A
# beam with a section bends and stretches. A beam without a section is rigid.
#
# A planar beam has three **deformations**: 1 is its elongation, 2 and 3 are the bending at its two ends.
# `released=(2, 3)` lets the leaf springs bend and keeps their length.

# %%
length, width, apart = 0.1, 0.018, 0.1  # m
steel = fm.Material(E=210e9, G=80e9, rho=7850)
mass = 0.206  # kg, bar and voice coil


def guide(thickness):
    leaf = fm.Rectangle(width, thickness, steel, rotary=False)
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, length))
    b.node("C", (apart, length))
    b.node("D", (apart, 0))
    b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
    b.add(planar.beam, "D", "C", name="right", section=leaf, released=(2, 3))
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", mass / 2)
    b.mass("C", mass / 2)
    b.dof("B", "x")
    return b.build()


model = guide(0.5e-3)
ax = fm.plot.mechanism(model, names=True)

# %% [markdown]
# Squares are clamped nodes, discs are lumped masses, and the thick line is the rigid stage. The arrow is the
# **degree of freedom** that `b.dof("B", "x")` names. Without this line, flexmb chooses a degree of freedom by itself.
#
# `build()` checks the mechanism. The mechanism has twelve coordinates, and six of them are fixed. It has nine
# deformations. Four of them are released, so five are constraints. One degree of freedom is left, as intended:

# %%
counts = model.counts()
print({name: counts[name] for name in ("nx", "nxo", "neo", "ndof")})
print("degrees of freedom:", model.q_labels)

# %% [markdown]
# ## Natural frequency and mode shape

# %%
frequency = float(fm.frequencies(model)[0])
print(f"{frequency:.7f} Hz")
figure = fm.plot.modes(fm.modes(model))

# %% [markdown]
# ## The derivative by a dimension
#
# `guide` is an ordinary function from a thickness to a model, so `jax.grad` differentiates it. `fm.jit` compiles faster
# than `jax.jit`, and its code runs slower. For a model of this size, this saves time.

# %%
slope = fm.jit(jax.grad(lambda thickness: fm.frequencies(guide(thickness))[0]))(0.5e-3)
print(f"{slope:.4f} Hz/m: one hundredth of a millimetre more gives {slope * 1e-5:.3f} Hz more")

# %% [markdown]
# ## An error names its cause
#
# If the right leaf spring cannot bend, the stage cannot move. The error names the elements that work against each
# other. It also names a deformation whose release removes the conflict. The error cannot know the intention of the
# designer: here the bending of the right leaf spring was forgotten.

# %%
leaf = fm.Rectangle(width, 0.5e-3, steel)
b = fm.Builder()
for name, place in {"A": (0, 0), "B": (0, length), "C": (apart, length), "D": (apart, 0)}.items():
    b.node(name, place)
b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
b.add(planar.beam, "D", "C", name="right", section=leaf, released=())
b.add(planar.beam, "B", "C", name="stage")
b.fix("A")
b.fix("D")
try:
    b.build()
except fm.MechanismError as error:
    print(error)

# %% [markdown]
# ## What the numbers are compared with
#
# When the guide sways, each leaf spring has the stiffness $12EI/l^3$ with $I = wt^3/12$. The leaf spring bends in a
# cubic curve, whose kinetic energy counts 13/35 of its mass. Therefore
#
# $$f = \frac{1}{2\pi}\sqrt{\frac{2Ewt^3/l^3}{m + \tfrac{26}{35}\rho w t l}} .$$
#
# The tutorial prints 10.6448 Hz.

# %%
t = 0.5e-3
stiffness = 2 * steel.E * width * t**3 / length**3
moving = mass + 26 / 35 * steel.rho * width * t * length
expected = np.sqrt(stiffness / moving) / (2 * np.pi)
expected_slope = expected * (3 / (2 * t) - 26 / 35 * steel.rho * width * length / (2 * moving))
print(f"closed form: {expected:.7f} Hz, {expected_slope:.4f} Hz/m")

assert abs(frequency / expected - 1) < 1e-9
assert round(frequency, 4) == 10.6448
assert abs(slope / expected_slope - 1) < 1e-8
