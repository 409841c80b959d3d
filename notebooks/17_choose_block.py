# %% [markdown]
# # Building blocks
#
# **Question.** Which ready-made guides, pivots and hinges exist, and how stiff is each?
#
# Most mechanisms of leaf springs consist of a few known parts. Each function of `fm.blocks` adds one of them to a
# `Builder`, between two bodies, each named by a node: the **base** carries the block, and the block carries the
# **stage**. The base must exist. The stage is made where the block ends, unless it exists; then it may be anywhere. So
# blocks form chains: the stage of one is the base of the next.

# %%
import warnings

import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import blocks

fm.enable_x64()
cache = fm.enable_cache(thorough=False)
# A notch hinge is a plain beam, in the plane without shear, which is warned of; its closed form has none either.
warnings.filterwarnings("ignore", category=fm.BeamTheoryWarning)

steel = fm.Material(E=210e9, G=80e9, rho=7850)
length, width, thickness = 0.1, 18e-3, 0.5e-3
leaf = fm.Rectangle(width, thickness, steel)
wire = fm.Circle(1e-3, steel)
notch = {"width": 10e-3, "height": 6e-3, "neck": 0.5e-3, "radius": 3e-3, "material": steel}


def mechanism(block, dimension=2, **sizes):
    b = fm.Builder()
    b.node("ground", (0,) * dimension)
    block(b, "ground", "stage", **sizes)
    b.fix("ground")
    return b.build()


# %% [markdown]
# ## The blocks
#
# Leaf springs are parallel to y, and the stage of a guide moves along x, unless `along=` states another direction (and,
# in space, `y=`, the direction of the width). All dimensions are differentiable. `at=` puts a block elsewhere than at
# its base. Leaf springs are `planar.leaf_spring` or `spatial.leaf_spring`, which agree with solid elements (notebook
# [18](18_check_beam.ipynb)); `element=` replaces them by another element, such as `planar.spectral_beam`.

# %%
guide = {"length": length, "section": leaf, "spacing": 0.08}
catalogue = {
    "parallel guide": (blocks.parallel_guide, guide),
    "double parallel guide": (blocks.double_parallel_guide, {**guide, "inner": 0.04}),
    "straight-line stage": (blocks.straight_line_stage, {**guide, "inner": 0.04, "height": 0.03}),
    "xy stage": (blocks.xy_stage, {**guide, "inner": 0.04}),
    "cross pivot": (blocks.cross_pivot, {"length": length, "section": leaf}),
    "butterfly pivot": (blocks.butterfly_pivot, {"length": length, "section": leaf, "radius": 0.02}),
    "cartwheel": (blocks.cartwheel, {"length": length, "section": leaf}),
    "folded leaf spring": (blocks.folded_leaf_spring, {"length": length, "section": leaf}),
    "wire flexure": (blocks.wire_flexure, {"length": length, "section": wire}),
    "notch hinge": (blocks.notch_hinge, notch),
    "notch four-bar": (blocks.notch_four_bar, {"length": 0.05, "spacing": 0.04, **notch}),
}

# %% [markdown]
# A square is the base, clamped to the ground. A diamond is the stage, which was pushed or turned in its free direction.
# Thick lines are rigid. The end that stands out of a pivot is its axis, a point of the stage, whose displacement is the
# shift. Every leaf spring is one element.

# %%
turning = ("cross pivot", "butterfly pivot", "cartwheel", "notch hinge")


def pushed(name):
    block, sizes = catalogue[name]
    b = fm.Builder()
    b.node("ground", (0, 0))
    block(b, "ground", "stage", **sizes)
    b.fix("ground")
    if name in turning:
        b.prescribe("stage", "rotation", np.radians(5 if name == "notch hinge" else 10))
    else:
        b.prescribe("stage", "x", 0.004 if name == "notch four-bar" else 0.01)
        if name == "xy stage":
            b.prescribe("stage", "y", 0.01)
    return b.build()


figure, axes = plt.subplots(3, 4, figsize=(12, 9.5), layout="constrained")
for name, ax in zip(catalogue, axes.flat, strict=False):
    there = pushed(name)
    fm.plot.mechanism(there, at=fm.equilibrium(there), ax=ax, dofs=False, loads=False)
    ax.set_title(name)
    ax.set_axis_off()
axes.flat[-1].set_axis_off()
plt.show()

# %% [markdown]
# ## Stiffness compared with closed forms
#
# These are stiffnesses at rest in the free direction of the stage (flexmb/THEORY.md, section 13). First the closed
# forms of beam theory. $EI$ belongs to one leaf spring, $k_h$ is the stiffness of one notch hinge. Both formulas with
# $k_h$ are limits: for a thin neck, and for hinges that are short compared with the bars.
#
# Beams are too soft, since clamps keep a leaf spring flat across its width. Near a clamp, over a share $a = 0.4\,w/L$
# of the length, it bends as a plate with $EI/(1-\nu^2)$. So its compliance is smaller by $\nu^2\,(1 - (1 - 2a)^3)$ in
# sway, by $2a\nu^2$ in bending to an arc, and by $\nu^2\,(1 - (1 - a)^3 + a^3)$ under a force at an end that may turn.
# The rotation of a pivot combines the first two. A leaf spring that meets the axis at $\lambda$ has the stiffness
# $\tfrac{EI}{L}\,(1 + 12\,(\lambda - \tfrac12)^2)$: the first term is the arc, the second one sway.
#
# A neck that is wide compared with $\sqrt{Rt}$ bends as a plate too, except near its edges (THEORY.md, (2.60)).

# %%
nu = float(steel.poisson())


def stiffer(kind, length=length):
    """By which factor clamps make a leaf spring stiffer that bends in a way."""
    a = 0.4 * width / length
    lost = {"sway": 1 - (1 - 2 * a) ** 3, "arc": 2 * a, "force": 1 - (1 - a) ** 3 + a**3}[kind]
    return 1 / (1 - nu**2 * lost)


EI = steel.E * width * thickness**3 / 12
EI_wire = steel.E * np.pi * wire.diameter**4 / 64
near = 0.02 / length
hinge = 2 * steel.E * notch["width"] * notch["neck"] ** 2.5 / (9 * np.pi * notch["radius"] ** 0.5)
plate = 1 / (1 - nu**2 * (1 - 3.1 * (notch["radius"] * notch["neck"]) ** 0.5 / notch["width"]))
sway, arc = stiffer("sway"), stiffer("arc")
spoke = stiffer("arc", length / 2), stiffer("sway", length / 2)
# Formula, its value, and how much stiffer clamps, or the width of a neck, make it.
formulas = {
    "parallel guide": ("24 EI/L³", 24 * EI / length**3, sway),
    "double parallel guide": ("12 EI/L³", 12 * EI / length**3, sway),
    "straight-line stage": ("24 EI/L³", 24 * EI / length**3, sway),
    "xy stage": ("12 EI/L³", 12 * EI / length**3, sway),
    "cross pivot": ("2 EI/L", 2 * EI / length, arc),
    "butterfly pivot": (
        "4 EI/L (1 + 3n + 3n²)",
        4 * EI / length * (1 + 3 * near + 3 * near**2),
        (arc + 12 * (0.5 + near) ** 2 * sway) / (1 + 12 * (0.5 + near) ** 2),
    ),
    "cartwheel": ("8 EI/L", 8 * EI / length, (spoke[0] + 3 * spoke[1]) / 4),
    "folded leaf spring": ("3 EI/L³", 3 * EI / length**3, stiffer("force")),
    "wire flexure": ("3 EI/L³", 3 * EI_wire / length**3, 1.0),
    "notch hinge": ("2 E w t^2.5/(9π√R)", hinge, plate),
    "notch four-bar": ("4 k_h/L²", 4 * hinge / 0.05**2, plate),
}
deviations, table = {}, [f"{'':45} {'beam':>10} {'clamped':>10} {'computed':>10}"]
for name, (text, beam, factor) in formulas.items():
    block, sizes = catalogue[name]
    i, unit = (2, "N m/rad") if name in turning else (0, "N/m")
    found = 1 / float(fm.compliance(mechanism(block, **sizes), "stage")[i, i])
    deviations[name] = found / (beam * factor) - 1
    values = f"{beam:10.5g} {beam * factor:10.5g} {found:10.5g}"
    table.append(f"{name:22} {text:22} {values} {unit:8} beam {beam / found - 1:+.1%}")
print("\n".join(table))

# %% [markdown]
# ## In space
#
# The same functions build in space, where the held directions of a block have stiffness too. A folded leaf spring holds
# one direction, the fold line. Three of them carry a platform that moves in its plane: they hold its height (z) and its
# tilts (about x and y). `at` places their feet on the ground around the platform.

# %%
legs = {"length": 0.05, "section": leaf}
b = fm.Builder()
b.node("ground", (0, 0, -0.04))
b.node("platform", (0, 0, 0))
for i, angle in enumerate(np.radians([0, 120, 240])):
    out, around = np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])
    place = {"at": 0.11 * out - 0.05 * around, "along": around, "fold": -np.pi / 2}
    blocks.folded_leaf_spring(b, "ground", "platform", name=f"leg {i}", **legs, **place)
b.fix("ground")
platform = b.build()
ax = fm.plot.mechanism(platform, dofs=False, ax=plt.figure(figsize=(7, 6)).add_subplot(projection="3d"))
ax.locator_params(nbins=4)
print("N/m, N m/rad:", "  ".join(f"{1 / c:.3g}" for c in np.diag(fm.compliance(platform, "platform"))))

# %% [markdown]
# Along the fold line, with its end free to turn, one leg has the compliance $2(L^3/3EI_z + L/GA\,k) + L^3/GI_t$ of beam
# theory, nearly all of it by twist of the first leg. At its foot this leg cannot warp. At the fold it shares its
# warping with the second leg, which has no torque. So its twist is shorter by $\ell$ and by $\ell/2$, with $\ell^2 = E
# w^3t^3/(144\,(1-\nu^2)\,GI_t)$.

# %%
single = mechanism(blocks.folded_leaf_spring, 3, **legs)
s = fm.Rectangle(width, thickness, steel, shear=True).rigidity()
bent = float(2 * (0.05**3 / (3 * s.EIz) + 0.05 * s.shear_y / s.EIz))
twisted = float(0.05**3 / s.GIt)
layer = np.sqrt(steel.E * (width * thickness) ** 3 / (144 * (1 - nu**2) * float(s.GIt)))
closed = bent + twisted * (1 - 1.5 * layer / 0.05)
found = float(fm.compliance(single, "stage")[2, 2])
deviations["fold line"] = found / closed - 1
print(f"beam theory {1 / (bent + twisted):.5g} N/m, with warping {1 / closed:.5g} N/m, computed {1 / found:.5g} N/m")

# %% [markdown]
# ## Dimensions as input: a sweep, and a search
#
# The place where the leaf springs of a pivot cross determines its stiffness: $8EI/L\,(1 - 3\lambda + 3\lambda^2)$, and
# a little more with clamps.


# %%
def pivot(ratio):
    return mechanism(blocks.cross_pivot, length=length, section=leaf, ratio=ratio)


ratios = np.linspace(0, 1, 11)
swept = fm.sweep(pivot, {"stiffness": lambda m: 1 / fm.compliance(m, "stage")[2, 2]}, fm.design.grid(ratio=ratios))
figure, ax = plt.subplots(layout="constrained")
curve = 2 * EI / length * (arc + 12 * (ratios - 0.5) ** 2 * sway)
ax.plot(ratios, 8 * EI / length * (1 - 3 * ratios + 3 * ratios**2), "--", label="beam theory")
ax.plot(ratios, curve, label="with clamps")
ax.plot(ratios, swept["stiffness"], "o", label="sweep")
ax.set_xlabel("crossing ratio [-]")
ax.set_ylabel("rotational stiffness [N m/rad]")
ax.legend()
plt.show()

# %% [markdown]
# The lightest leaf springs of a guide that carries 0.2 kg at 8 Hz:


# %%
def stage(length, thickness):
    b = fm.Builder()
    b.node("ground", (0, 0))
    blocks.parallel_guide(
        b, "ground", "stage", length=length, spacing=0.08, section=fm.Rectangle(width, thickness, steel)
    )
    b.fix("ground")
    b.mass("stage", 0.2, inertia=2e-4)
    return b.build()


found = fm.tune(
    stage,
    {"frequency": lambda m: fm.frequencies(m)[0], "mass": fm.mass},
    {"length": 0.1, "thickness": 0.5e-3},
    bounds={"length": (0.05, 0.2), "thickness": (0.1e-3, 1e-3)},
    minimize="mass",
    equal={"frequency": 8.0},
)
print(found)

# %% [markdown]
# ## What the numbers are compared with
#
# The closed forms with clamps above, and solid elements in notebook [18](18_check_beam.ipynb). The forms neglect that
# leaf springs stretch, which is of the order of (t/L)² and (t/spacing)². The forms of the notch are limits for a thin
# neck. In the tuned guide, leaf springs of mass $m_l$ in sway count with 13/35, and $(2\pi f)^2 = c\,(24EI/L^3)/(m +
# \tfrac{26}{35} m_l)$, with $c$ by the clamps. By beam theory, $c = 1$, the leaf springs would have to be thicker.

# %%
t, n = (float(found.dimensions[name]) for name in ("thickness", "length"))
moving = 0.2 + 26 / 35 * steel.rho * width * t * n
expected = np.sqrt(stiffer("sway", n) * 2 * steel.E * width * t**3 / n**3 / moving) / (2 * np.pi)
print(
    f"closed form of the tuned guide: {expected:.5f} Hz; by beam theory {stiffer('sway', n) ** (1 / 3) - 1:.1%} thicker"
)

limits = {"notch hinge": 0.03, "notch four-bar": 0.03, "fold line": 1e-3}
assert all(abs(value) < limits.get(name, 5e-4) for name, value in deviations.items())
assert np.allclose(swept["stiffness"], curve, rtol=1e-4)
assert abs(expected / 8.0 - 1) < 1e-3
