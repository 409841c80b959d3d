# %% [markdown]
# # A guide under load: support stiffness over the stroke, and buckling
#
# **Question.** How stiff does a guide of two leaf springs stay across its motion, and what happens when it is loaded
# beyond its buckling load?
#
# In its straight position a leaf spring carries a load along its length by tension, with the stiffness $EA/l$. Once it
# is bent, such a load changes the bending too, and the guide gives way much more. That loss decides how long a stroke
# can be used.

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
# Two leaf springs of 100 × 18 × 0.5 mm, 100 mm apart, and a rigid stage. S is the middle of the stage. Each leaf spring
# is one **spectral beam**: its elongation and its curvature along the whole length are polynomials, here with five
# coefficients each, which is enough for six digits at a large stroke. `planar.beam`, the cubic beam of SPACAR, is shown
# for comparison.

# %%
length, width, thickness, apart = 0.1, 0.018, 0.5e-3, 0.1
leaf = fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9, rho=7850))
EI, EA = float(leaf.rigidity().EIy), float(leaf.rigidity().EA)


def guide(element, beams=1, stroke=None, load=None):
    b = fm.Builder()
    b.node("S", (apart / 2, length))
    for side, x in (("left", 0.0), ("right", apart)):
        for i in range(beams + 1):
            b.node(f"{side}{i}", (x, length * i / beams))
        for i in range(beams):
            b.add(element, f"{side}{i}", f"{side}{i + 1}", name=f"{side} {i + 1}", section=leaf)
        b.fix(f"{side}0")
        b.add(planar.beam, "S", f"{side}{beams}", name=f"stage {side}")  # no section: rigid
    b.mass("S", 0.2, inertia=2e-4)
    if stroke is not None:
        b.prescribe("S", "x", stroke, increment=True)
    if load is not None:
        b.force("S", load)
        b.fix("S", "phi")
    return b.build()


# %% [markdown]
# ## Support stiffness over the stroke
#
# The stroke is prescribed as an **incremental load**: a factor from 0 to 1 scales it. `fm.linearize(model,
# increment=s)` linearises about the equilibrium at that factor, and `fm.stiffness` reads a stiffness from it: of S
# along y, with x held by the drive and the rotation free.

# %%
stroke = 5e-3
spectral = guide(planar.spectral_beam(5), stroke=stroke)
factors = np.linspace(0, 1, 21)


def support(model, factor):
    return float(fm.stiffness(fm.linearize(model, increment=factor), "S", "y"))


curves = {"one spectral beam of order 5": [support(spectral, s) for s in factors]}
for beams in (1, 2, 4):
    cubic = guide(planar.beam, beams, stroke=stroke)
    curves[f"{beams} cubic beam{'s' if beams > 1 else ''}"] = [support(cubic, s) for s in factors]

figure, ax = plt.subplots(layout="constrained")
for label, values in curves.items():
    ax.plot(1e3 * stroke * factors, 1e-6 * np.array(values), "-" if "spectral" in label else "--", label=label)
ax.set_xlabel("stroke [mm]")
ax.set_ylabel("support stiffness [N/μm]")
ax.set_ylim(bottom=0)
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# At 5 % of the length little more than a third of the stiffness is left. One cubic beam a leaf spring does not see this
# at all, since the load cannot bend its middle. Two beams see half of it, four nearly all. So a support stiffness wants
# four cubic beams a leaf spring, or one spectral beam.
#
# Where the stress is at full stroke:

# %%
lin = fm.linearize(spectral, increment=1.0)
ax = fm.plot.stress(fm.stress(spectral, points=25, at=lin), lin)

# %% [markdown]
# ## Buckling
#
# Now the stage is free to move sideways, a load presses it down, and a second guide behind it keeps it from rotating.
# `fm.buckling` gives the multiple of the load at which the straight state loses its stability. Each leaf spring is then
# a column clamped at its foot and guided at its top, so that it buckles at $\pi^2EI/l^2$, and the guide at twice that.

# %%
critical = 2 * np.pi**2 * EI / length**2
one_newton = guide(planar.spectral_beam(5), load=(0, -1.0))
buckling = fm.buckling(one_newton)
print(f"buckling load {buckling.multipliers[0]:.4f} N, two guided columns {critical:.4f} N")

# %% [markdown]
# ## Past buckling
#
# `fm.path` follows the equilibrium over the load. It names the point where the straight state branches. With `switch=1`
# it goes on along the branch, where the guide sways to one side and can carry more.

# %%
load = 1.2 * critical
buckled = fm.path(guide(planar.spectral_beam(5), load=(0, -load)), switch=1)
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
# *Support stiffness and drive force.* The same guide, as two extensible elasticas between ground and a rigid body, was
# solved by shooting to a tolerance of 10⁻¹², by a program that shares nothing with flexmb. In units of $EI/l^2$ for the
# force and $EI/l^3$ for the stiffness, with $l/t = 200$ and the distance equal to the length:
#
# | stroke/l | drive force | support stiffness |
# |---|---|---|
# | 0.01 | 0.240017862 | 898286.668 |
# | 0.02 | 0.480178956 | 752989.682 |
# | 0.05 | 1.202960515 | 352530.027 |
#
# *Past buckling.* A guided column of length $l$ is two cantilevers of length $l/2$, joined where the curvature changes
# its sign. For a cantilever whose tip has turned by $\alpha$ the elastica gives, with $k = \sin(\alpha/2)$ and the
# complete elliptic integrals $K$ and $E$ of modulus $k$, the load $P/P_{cr} = (2K/\pi)^2$, the deflection $2k/K$ and
# the height $2E/K - 1$ over the length.

# %%
shooting = {0.01: (0.240017862, 898286.668), 0.02: (0.480178956, 752989.682), 0.05: (1.202960515, 352530.027)}
drive = [str(entry) for entry in spectral.labels.x].index("S.x")
for share, (force, stiffness) in shooting.items():
    at = fm.linearize(spectral, increment=share * length / stroke)
    assert abs(float(at.reactions[drive]) * length**2 / EI / force - 1) < 1e-6
    assert abs(float(fm.stiffness(at, "S", "y")) * length**3 / EI / stiffness - 1) < 1e-4

modulus = brentq(lambda k: (2 * ellipk(k**2) / np.pi) ** 2 - load / critical, 1e-6, 0.99)
aside, height = (
    length * 2 * modulus / ellipk(modulus**2),
    length * (2 * ellipe(modulus**2) / ellipk(modulus**2) - 1),
)
print(f"elastica: {1e3 * aside:.3f} mm aside and {1e3 * (length - height):.3f} mm down")
assert abs(float(buckling.multipliers[0]) / critical - 1) < 1e-3
assert abs(abs(x - apart / 2) / aside - 1) < 1e-3
assert abs((length - y) / (length - height) - 1) < 1e-3
