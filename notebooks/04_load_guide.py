# %% [markdown]
# # A guide under load: support stiffness over the stroke
#
# **Question.** How stiff does a guide of two leaf springs stay across its motion?
#
# A straight leaf spring carries a load along its length by tension, with the stiffness $EA/l$. If it is bent, such a
# load also changes the bending, and the guide becomes much softer. This loss limits the usable stroke.

# %%
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The model
#
# Two leaf springs of 100 × 18 × 0.5 mm, 100 mm apart, and a rigid stage. S is the middle of the stage. Each leaf spring
# is one **spectral beam**: its elongation and its curvature along the whole length are polynomials with five
# coefficients each. They give six digits of beam theory at a large stroke. `planar.beam`, the cubic beam of SPACAR, is
# shown for comparison. Notebook [18](18_check_beam.ipynb) compares beams with solid models of leaf springs.

# %%
length, width, thickness, apart, stroke = 0.1, 0.018, 0.5e-3, 0.1, 5e-3
leaf = fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9, rho=7850))
EI, EA = float(leaf.rigidity().EIy), float(leaf.rigidity().EA)


def guide(element, beams=1):
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
    b.prescribe("S", "x", stroke, increment=True)
    return b.build()


# %% [markdown]
# ## Support stiffness over the stroke
#
# The stroke is prescribed as an **incremental load**: a factor from 0 to 1 scales it. `fm.linearize(model,
# increment=s)` linearises about the equilibrium at that factor. `fm.stiffness` reads the stiffness of S along y from
# the result, with x held by the drive and the rotation free.

# %%
spectral = guide(planar.spectral_beam(5))
factors = np.linspace(0, 1, 21)


def support(model, factor):
    return float(fm.stiffness(fm.linearize(model, increment=factor), "S", "y"))


curves = {"one spectral beam of order 5": [support(spectral, s) for s in factors]}
for beams in (1, 2, 4):
    cubic = guide(planar.beam, beams)
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
# At 5 % of the length little more than a third of the stiffness remains. One cubic beam per leaf spring does not show
# this loss, since the load cannot bend its middle. Two beams show half of it, four nearly all. For support stiffness,
# use four cubic beams per leaf spring, or one spectral beam.
#
# The stress at full stroke:

# %%
lin = fm.linearize(spectral, increment=1.0)
ax = fm.plot.stress(fm.stress(spectral, points=25, at=lin), lin)

# %% [markdown]
# ## What the numbers are compared with
#
# *Support stiffness and drive force.* An independent program solved the same guide, as two extensible elasticas between
# ground and a rigid body, by shooting to a tolerance of 10⁻¹². Forces are in units of $EI/l^2$ and stiffnesses in units
# of $EI/l^3$, with $l/t = 200$ and the distance equal to the length:
#
# | stroke/l | drive force | support stiffness |
# |---|---|---|
# | 0.01 | 0.240017862 | 898286.668 |
# | 0.02 | 0.480178956 | 752989.682 |
# | 0.05 | 1.202960515 | 352530.027 |

# %%
shooting = {0.01: (0.240017862, 898286.668), 0.02: (0.480178956, 752989.682), 0.05: (1.202960515, 352530.027)}
drive = [str(entry) for entry in spectral.labels.x].index("S.x")
for share, (force, stiffness) in shooting.items():
    at = fm.linearize(spectral, increment=share * length / stroke)
    assert abs(float(at.reactions[drive]) * length**2 / EI / force - 1) < 1e-6
    assert abs(float(fm.stiffness(at, "S", "y")) * length**3 / EI / stiffness - 1) < 1e-4
