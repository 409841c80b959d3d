# %% [markdown]
# # Warm mechanism
#
# **Question.** How does a guide of two leaf springs react to heat: where does it move, which stress remains, and when
# does a leaf spring buckle?
#
# A material expands by $\alpha$ per kelvin. In an exactly constrained mechanism this causes motion without stress. An
# over-constrained one gets stress, and a slender part that is held at both ends buckles.

# %%
import warnings

import jax
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar, spatial

fm.enable_x64()
cache = fm.enable_cache(thorough=False)
# The results are compared with beam theory, which neglects shear and restrained warping.
warnings.filterwarnings("ignore", category=fm.BeamTheoryWarning)

# %% [markdown]
# ## One leaf spring is warmer
#
# Two leaf springs of 100 × 18 × 0.5 mm stand 100 mm apart and carry a rigid stage. The material has a coefficient of
# expansion. `b.temperature(element, change)` warms one element; `gradient=` makes one side of it warmer than the other,
# in kelvins per metre of its thickness.

# %%
length, width, thickness, apart, alpha = 0.1, 0.018, 0.5e-3, 0.1, 11.5e-6
steel = fm.Material(E=210e9, G=80e9, rho=7850, alpha=alpha)
leaf = fm.Rectangle(width, thickness, steel)


def guide(right=0.0, stage=0.0):
    b = fm.Builder()
    for side, x in (("left", 0.0), ("right", apart)):
        b.node(f"{side} foot", (x, 0))
        b.node(f"{side} top", (x, length))
        b.add(planar.spectral_beam, f"{side} foot", f"{side} top", name=side, section=leaf)
        b.fix(f"{side} foot")
    b.node("S", (apart / 2, length))
    for side in ("left", "right"):
        b.add(planar.rigid_beam, "S", f"{side} top", name=f"stage {side}", alpha=alpha)
        b.add(planar.hinge, "S.rotation", f"{side} top.rotation", name=f"clamp {side}", released=())
        b.temperature(f"stage {side}", stage)
    b.temperature("right", right)
    b.dof("S", "x")
    return b.build()


def tilt(change):
    return fm.equilibrium(guide(right=change)).at("S.rotation")[0]


per_kelvin = jax.grad(tilt)(0.0)
print(f"tilt of the stage: {1e6 * per_kelvin:.3f} urad for each kelvin, {1e6 * tilt(20.0):.2f} urad at 20 K")
print(f"alpha * length / distance of the feet: {1e6 * alpha * length / apart:.3f} urad")

# %% [markdown]
# Rigid parts expand too. A warm stage spreads the tops of its leaf springs, which bend, and stays in place.

# %%
wide = fm.equilibrium(guide(stage=20.0))
spread = float(wide.at("right top")[0] - wide.at("left top")[0]) - apart
print(
    f"the stage at 20 K: {1e6 * spread:.3f} um wider, its middle at {1e6 * float(wide.at('S')[0] - apart / 2):.3f} um"
)

# %% [markdown]
# ## One side is warmer
#
# A difference of 1 K between the two faces of a leaf spring of half a millimetre is a gradient of 2000 K/m. The leaf
# spring becomes an arc, away from the warmer face, without stress.

# %%
b = fm.Builder()
b.node("foot", (0, 0))
b.node("tip", (length, 0))
b.add(planar.spectral_beam, "foot", "tip", name="leaf", section=leaf)
b.fix("foot")
b.temperature("leaf", 0.0, gradient=1.0 / thickness)
arc = fm.equilibrium(b.build())
print(f"tip {1e6 * float(arc.at('tip')[1]):.1f} um, largest stress resultant {np.max(np.abs(arc.sigma)):.1e}")

# %% [markdown]
# ## Over-constrained
#
# In space a guide of two leaf springs is [over-constrained once](03_find_overconstraints.ipynb): twisting its stage
# bends both leaf springs in their own planes. If one of them is warmer along one edge, it tends to an arc in its plane.
# The other resists, both bend by half of the curvature $\alpha g$, and the moment $EI_z\,\alpha g/2$ twists the stage.
# If the stage is released, so that it may twist freely, only the small effect of torsion of the leaf springs remains.

# %%
gradient = 500.0  # K/m along the width: 9 K from edge to edge


def in_space(released):
    b = fm.Builder()
    for side, y in (("left", 0.0), ("right", apart)):
        b.node(f"{side} foot", (0, y, 0))
        b.node(f"{side} top", (0, y, length))
        b.add(spatial.beam, f"{side} foot", f"{side} top", name=side, section=leaf, y=(1, 0, 0))
        b.fix(f"{side} foot")
    b.add(spatial.beam, "left top", "right top", name="stage", released=released)
    b.temperature("left", 0.0, gradient=(gradient, 0.0))
    return fm.linearize(b.build())


states = {"over-constrained": in_space(()), "released": in_space((2,))}
stresses = {name: fm.stress(lin.model, points=9, at=lin) for name, lin in states.items()}
for name, found in stresses.items():
    moment = float(np.max(np.abs(found.resultants.values[:, :, 5])))
    print(f"{name}: moment {moment:.5f} N m, von Mises stress {float(found.maximum) / 1e6:.4f} MPa")

# %%
ax = fm.plot.stress(stresses["over-constrained"], states["over-constrained"])

# %% [markdown]
# ## Buckling by heat
#
# A leaf spring between two walls cannot get longer. It is compressed, and buckles already at
# $\Delta T = 4\pi^2 (t^2/12)/(\alpha l^2)$. With `increment=True` a path follows the temperature; `switch=1` leaves the
# straight state where it branches.

# %%
critical = 4 * np.pi**2 * thickness**2 / 12 / (alpha * length**2)
most = 2 * critical
b = fm.Builder()
for i, node in enumerate(("wall", "middle", "other wall")):
    b.node(node, (i * length / 2, 0))
for name, ends in {"first half": ("wall", "middle"), "second half": ("middle", "other wall")}.items():
    b.add(planar.spectral_beam, *ends, name=name, section=leaf)
    b.temperature(name, most, increment=True)
b.fix("wall")
b.fix("other wall")
model = b.build()
first = float(fm.buckling(model).multipliers[0]) * most
path = fm.path(model, switch=1)
branch = path.critical_points[0].load_factor * most
print(f"buckles at {first:.4f} K, the path branches at {branch:.4f} K; closed form {critical:.4f} K")
aside = abs(float(path.at("middle")[-1, 1]))
shallow = 2 * length / np.pi * np.sqrt(alpha * (most - critical))
print(f"at {most:.2f} K its middle is {1e3 * aside:.4f} mm aside; a shallow cosine {1e3 * shallow:.4f} mm")

# %%
figure, ax = plt.subplots(figsize=(6, 4), layout="constrained")
ax = fm.plot.path(path, "middle.y", ax=ax)
ax.set_title(f"load factor 1 is {most:.2f} K")
plt.show()

# %% [markdown]
# ## What the numbers are compared with
#
# Closed forms of beam theory. A leaf spring is a plate: near its clamps its cross-section stays flat, and there thermal
# strains are larger by Poisson's ratio, so the tilt is 1.7 % and the arc 4 % larger.

# %%
assert abs(per_kelvin / 11.5e-6 - 1) < 2e-4
assert abs(spread / (alpha * 20 * apart) - 1) < 1e-4
assert abs(float(arc.at("tip")[1]) / -115e-6 - 1) < 1e-4
held, free = (np.max(np.abs(found.resultants.values[:, :, 5])) for found in stresses.values())
assert abs(held / (210e9 * thickness * width**3 / 12 * alpha * gradient / 2) - 1) < 5e-3
assert free < 5e-3 * held
assert abs(first / critical - 1) < 1e-4
assert abs(branch / critical - 1) < 1e-4
assert abs(aside / shallow - 1) < 2e-3
