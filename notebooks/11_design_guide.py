# %% [markdown]
# # Design study: a guide that stays stiff over its stroke
#
# **Question.** What is the largest support stiffness that a guide can keep at a stroke of ±10 mm, for a given drive
# stiffness, stress and parasitic frequency?
#
# A leaf spring that is bent gives way to loads along its length, since they bend it further (notebook 04). Where its
# middle is reinforced, only the short ends bend, and the loss is smaller. But a reinforced leaf spring is stiffer to
# drive, its ends are stressed more, and its middle is a mass that vibrates between them. So length, thickness, width
# and the share that is reinforced must be chosen together.

# %%
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The model
#
# Two leaf springs 100 mm apart carry a stage of 0.5 kg. Each leaf spring is three elements: a flexible end, the middle
# with plates on it, 3 mm thick in all, and a flexible end. The ends are spectral beams of order 3, the middle is one
# cubic beam. The stroke of S, the middle of the stage, is prescribed. The model is planar: it knows the motions and
# stresses in the plane of the guide.

# %%
steel = fm.Material(E=210e9, G=80e9, rho=7850)
apart, mass, stroke, plates = 0.1, 0.5, 10e-3, 3e-3


def guide(length, thickness, width, reinforced, *, order=3, stroke=stroke):
    leaf = fm.Rectangle(width, thickness, steel)
    middle = fm.Rectangle(width, plates, steel)
    heights = length * jnp.stack([jnp.zeros(()), (1 - reinforced) / 2, (1 + reinforced) / 2, jnp.ones(())])
    b = fm.Builder()
    b.node("S", (apart / 2, length))
    for side, x in (("left", 0.0), ("right", apart)):
        b.node(f"{side} 0", (x, 0.0))
        for part in (1, 2, 3):
            b.node(f"{side} {part}", (x, heights[part]))
            element, section = (planar.beam, middle) if part == 2 else (planar.spectral_beam(order), leaf)
            b.add(element, f"{side} {part - 1}", f"{side} {part}", name=f"{side} part {part}", section=section)
        b.fix(f"{side} 0")
        b.add(planar.beam, "S", f"{side} 3", name=f"stage {side}")  # no section: rigid
    b.mass("S", mass, inertia=mass * apart**2 / 12)
    b.prescribe("S", "x", stroke)
    return b.build()


start = {"length": 0.12, "thickness": 0.4e-3, "width": 0.06, "reinforced": 0.5}
shown = fm.linearize(guide(**start))
ax = fm.plot.stress(fm.stress(shown.model, at=shown), shown)

# %% [markdown]
# ## Answers
#
# All of them at the full stroke. The function that is tuned returns the linearisation there. The drive holds the
# stroke, so that the lowest frequency about this state is that of the first parasitic motion.


# %%
def at_stroke(length, thickness, width, reinforced):
    return fm.linearize(guide(length, thickness, width, reinforced))


def support(lin):
    return fm.stiffness(lin, "S", "y")


def drive(lin):
    return jnp.abs(lin.reactions[lin.labels.known("S")[0]]) / stroke


def stress(lin):
    return fm.stress(lin.model, at=lin).smooth_maximum(200)


def parasitic(lin):
    return fm.frequencies(lin)[0]


answers = {"support": support, "drive": drive, "stress": stress, "parasitic": parasitic}
before = {name: float(f(shown)) for name, f in answers.items()}
print({name: f"{value:.4g}" for name, value in before.items()})

# %% [markdown]
# ## The search
#
# Drive stiffness 1000 N/m, stress at most 300 MPa, first parasitic frequency at full stroke at least 200 Hz. The start
# fills the space that there is and has about the wanted drive stiffness, with half of each leaf spring reinforced. A
# violation of a thousandth is none (`tolerance`), which is closer than such things are made.

# %%
limits = {"stress": (None, 300e6), "parasitic": (200.0, None)}
found = fm.tune(
    at_stroke,
    answers,
    start,
    bounds={
        "length": (0.06, 0.12),
        "thickness": (0.15e-3, 0.8e-3),
        "width": (0.02, 0.06),
        "reinforced": (0.05, 0.85),
    },
    maximize="support",
    equal={"drive": 1000.0},
    limits=limits,
    tolerance=1e-3,
)
print(found)

# %% [markdown]
# Length and width stay at their bounds, the space there is. Thinner leaf springs, reinforced over more of their length,
# carry at their ends the stress they may. What is won over the stroke, and where the stress is:

# %%
figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
strokes = np.linspace(0, stroke, 9)
for label, dimensions in (("start", start), ("found", found.dimensions)):
    values = [float(support(fm.linearize(guide(**dimensions, stroke=s)))) for s in strokes]
    axes[0].plot(1e3 * strokes, 1e-6 * np.array(values), label=label)
axes[0].set_xlabel("stroke [mm]")
axes[0].set_ylabel("support stiffness [N/μm]")
axes[0].set_ylim(bottom=0)
axes[0].grid(visible=True, alpha=0.3)
axes[0].legend()
lin = at_stroke(**found.dimensions)
ax = fm.plot.stress(fm.stress(lin.model, points=9, at=lin), lin, ax=axes[1])

# %% [markdown]
# ## What the numbers are compared with
#
# *A finer model* of the found design: every flexible end a spectral beam of order 5 instead of 3. And for the drive
# stiffness a closed form of small strokes: a leaf spring whose middle is rigid over a share $p$ of its length has
# $12EI/(l^3(1-p^3))$.

# %%
fine = fm.linearize(guide(**found.dimensions, order=5))
checked = {name: float(f(fine)) for name, f in answers.items()}
for name, value in checked.items():
    print(f"{name}: {found.answers[name]:.6g} found, {value:.6g} finer, {before[name]:.6g} at the start")
print(f"the support stiffness at full stroke is {checked['support'] / before['support']:.1f} times that of the start")

length, thickness, width, reinforced = found.dimensions.values()
closed = 2 * steel.E * width * thickness**3 / length**3 / (1 - reinforced**3)
print(f"drive stiffness at small strokes, middle rigid: {closed:.1f} N/m")
for name, value in checked.items():
    assert abs(value / found.answers[name] - 1) < 0.01, name
assert checked["stress"] < 300e6 * 1.01
assert checked["parasitic"] > 200.0
assert abs(checked["drive"] / 1000 - 1) < 2e-3
assert abs(closed / 1000 - 1) < 0.05
assert checked["support"] > 2 * before["support"]
