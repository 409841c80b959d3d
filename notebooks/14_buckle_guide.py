# %% [markdown]
# # Buckling of a guide, and what comes after it
#
# **Question.** At which load does a guide of two leaf springs buckle, and where does it move then?
#
# A slender part under pressure along its length stays straight up to a certain load. Beyond it the straight state is
# still an equilibrium, but unstable: the part sways to one side. For a mechanism of leaf springs this is often no
# failure, since it springs back, but its stiffness is lost.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The model
#
# Two leaf springs of 100 × 18 × 0.5 mm, 100 mm apart, and a rigid stage. A second guide behind it keeps the stage from
# rotating. Each leaf spring is one **spectral beam**, whose elongation and curvature are polynomials of five
# coefficients. S is the middle of the stage, where a load presses it down.

# %%
length, width, thickness, apart = 0.1, 0.018, 0.5e-3, 0.1
leaf = fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9, rho=7850))
critical = 2 * np.pi**2 * float(leaf.rigidity().EIy) / length**2


def guide(load):
    b = fm.Builder()
    b.node("S", (apart / 2, length))
    for side, x in (("left", 0.0), ("right", apart)):
        b.node(f"{side} foot", (x, 0))
        b.node(f"{side} top", (x, length))
        b.add(planar.spectral_beam(5), f"{side} foot", f"{side} top", name=side, section=leaf)
        b.fix(f"{side} foot")
        b.add(planar.beam, "S", f"{side} top", name=f"stage {side}")  # no section: rigid
    b.mass("S", 0.2, inertia=2e-4)
    b.force("S", (0, -load))
    b.fix("S", "phi")
    return b.build()


# %% [markdown]
# ## The buckling load
#
# `fm.buckling` returns the multiple of the load at which the straight state loses its stability. Each leaf spring is a
# column clamped at its foot and guided at its top. It buckles at $\pi^2EI/l^2$, and the guide at twice this load.

# %%
buckling = fm.buckling(guide(1.0))
print(f"buckling load {buckling.multipliers[0]:.4f} N, two guided columns {critical:.4f} N")

# %% [markdown]
# ## Past buckling
#
# `fm.path` follows the equilibrium over the load, and names the point where the straight state branches. With
# `switch=1` it continues along the branch, where the guide sways to one side and can carry more.

# %%
load = 1.2 * critical
buckled = fm.path(guide(load), switch=1)
for point in buckled.critical_points:
    print(f"{point.kind} point at {point.load_factor * load:.4f} N")
x, y = np.asarray(buckled.at("S"))[-1]
print(f"at {load:.2f} N: the stage is {1e3 * (x - apart / 2):.3f} mm aside and {1e3 * (length - y):.3f} mm down")

# %%
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
fm.plot.path(buckled, "S.x", ax=axes[0])
ax = fm.plot.mechanism(buckled, ax=axes[1])

# %% [markdown]
# ## What the numbers are compared with
#
# A guided column of length $l$ is two cantilevers of length $l/2$, joined where the curvature changes its sign. For a
# cantilever whose tip has turned by $\alpha$, let $k = \sin(\alpha/2)$, and $K$ and $E$ the complete elliptic integrals
# of modulus $k$. The elastica has the load $P/P_{cr} = (2K/\pi)^2$, the deflection $2k/K$ and the height $2E/K - 1$
# over the length.

# %%
modulus = brentq(lambda k: (2 * ellipk(k**2) / np.pi) ** 2 - load / critical, 1e-6, 0.99)
aside, height = (
    length * 2 * modulus / ellipk(modulus**2),
    length * (2 * ellipe(modulus**2) / ellipk(modulus**2) - 1),
)
print(f"elastica: {1e3 * aside:.3f} mm aside and {1e3 * (length - height):.3f} mm down")
assert abs(float(buckling.multipliers[0]) / critical - 1) < 1e-3
assert abs(abs(x - apart / 2) / aside - 1) < 1e-3
assert abs((length - y) / (length - height) - 1) < 1e-3
