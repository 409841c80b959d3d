# %% [markdown]
# # Second page: a large stroke and its stress
#
# **Question.** Which force moves the stage by 10 mm, and how large is the stress there?
#
# This page takes five minutes. It continues [the first page](24_first_guide.ipynb).

# %%
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

steel = fm.Material(E=210e9, G=80e9, rho=7850)
leaf = fm.Rectangle(width=0.018, thickness=0.5e-3, material=steel)

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

# %% [markdown]
# One more line moves the stage. `increment=True` moves it step by step, from rest to 10 mm.

# %%
b.prescribe("B", "x", 10e-3, increment=True)
model = b.build()
path = fm.path(model)

# %% [markdown]
# A path is a sequence of equilibrium states. You ask for a quantity by its name, such as `"force B.x"`. The answer
# has one value for each state.

# %%
ax = fm.plot.path(path, x="displacement B.x", y="force B.x")

# %%
force = path.force_needed("B", "x")
stress = fm.stress(model, at=path).maximum
print(f"at {path.at('B')[-1][0] * 1e3:.0f} mm: {force[-1]:.2f} N, {stress[-1] / 1e6:.0f} MPa")

# %% [markdown]
# The picture shows where the stress is largest: at the clamps.

# %%
end = path.linearization()
ax = fm.plot.stress(fm.stress(model, at=end), end)

# %% [markdown]
# The stage moves sideways by $u$ and does not turn. For small strokes, beam theory then gives the surface stress
# $3Et\,u/L^2$ at a clamp. The clamp keeps the leaf spring flat across its width. There the leaf spring is stiffer by
# the factor $1/(1-\nu^2)$.
#
# Next page: [tune a dimension](26_first_tuning.ipynb).

# %%
nu = 210e9 / (2 * 80e9) - 1
beam_theory = 3 * 210e9 * 0.5e-3 * 10e-3 / 0.1**2
print(f"beam theory: {beam_theory / 1e6:.0f} MPa; plate at the clamp: {beam_theory / (1 - nu**2) / 1e6:.0f} MPa")
assert beam_theory < stress[-1] < 1.1 * beam_theory / (1 - nu**2)
assert np.all(np.diff(force) > 0)
