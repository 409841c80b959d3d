# %% [markdown]
# # First page: a guide and its frequency
#
# **Question.** How fast does a stage on two leaf springs vibrate?
#
# This page takes five minutes. Type the cells in order, in a notebook or a script.

# %%
import numpy as np

import flexmb as fm
from flexmb import planar

# flexmb needs double precision. Compiled code is kept for the next time.
fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# A mechanism is a set of named nodes that elements join. Units are SI. Two leaf springs stand on the ground at A and D.
# A rigid stage joins their tops B and C and has a mass of 0.2 kg.

# %%
steel = fm.Material(E=210e9, G=80e9, rho=7850)  # Pa, Pa, kg/m³
leaf = fm.Rectangle(width=0.018, thickness=0.5e-3, material=steel)  # m

b = fm.Builder()
b.node("A", (0, 0))
b.node("B", (0, 0.1))
b.node("C", (0.1, 0.1))
b.node("D", (0.1, 0))
b.add(planar.leaf_spring, "A", "B", name="left", section=leaf)
b.add(planar.leaf_spring, "D", "C", name="right", section=leaf)
b.add(planar.rigid_body, "B", "C", name="stage")
b.fix("A")
b.fix("D")
b.mass("B", 0.1)
b.mass("C", 0.1)
model = b.build()

# %% [markdown]
# The picture shows the mechanism: squares are clamps, discs are masses, the thick line is rigid.

# %%
ax = fm.plot.mechanism(model, names=True)

# %% [markdown]
# The first frequency belongs to the intended motion of the guide. The next frequencies are far higher.

# %%
frequencies = fm.frequencies(model)
print("frequencies [Hz]:", np.round(frequencies[:3], 2))

# %%
figure = fm.plot.modes(fm.modes(model))

# %% [markdown]
# Beam theory gives the first frequency in closed form. Each leaf spring has the stiffness $12EI/L^3$ and adds 13/35
# of its mass to the stage. The clamps keep a leaf spring flat across its width. Therefore the guide is 3 to 4 %
# stiffer than two beams. Its frequency is 1.5 to 2 % higher.
#
# Next page: [a large stroke and its stress](25_first_stroke.ipynb).

# %%
stiffness = 2 * 12 * 210e9 * (0.018 * 0.5e-3**3 / 12) / 0.1**3
mass = 0.2 + 2 * 13 / 35 * 7850 * 0.018 * 0.5e-3 * 0.1
beam_theory = np.sqrt(stiffness / mass) / (2 * np.pi)
print(f"beam theory: {beam_theory:.2f} Hz")
assert 1.01 < frequencies[0] / beam_theory < 1.025
