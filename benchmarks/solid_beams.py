"""The cases of ``solid_cases.py`` as mechanisms of flexmb, each leaf spring by one kind of element or chain of them."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
import solid_cases as solid
from solid_cases import ANGLE, AXES, DISTANCE, LENGTH, STROKES, THICKNESS, WIDE, WIDTH

import flexmb as fm
from flexmb import spatial

ACROSS = (0.0, 1.0, 0.0)
# Beams before, in and after the middle, of a chain with breaks.
SHARES = (0.25, 0.5, 0.25)


@dataclass(frozen=True)
class Leaf:
    """A leaf spring.

    Attributes:
        width: [m], or a function of the place from 0 to 1.
        thickness: The same.
        breaks: Where it jumps or has a corner, in order; a chain of beams has nodes at the first and the last.
    """

    width: Any = WIDTH
    thickness: Any = THICKNESS
    breaks: tuple[float, ...] = ()

    def at(self, place, shear: bool = False) -> fm.Rectangle:
        """Section at a place."""
        width: Any = self.width(place) if callable(self.width) else self.width
        thickness: Any = self.thickness(place) if callable(self.thickness) else self.thickness
        return fm.Rectangle(width, thickness, material(), shear=shear)

    def section(self, shear: bool = False):
        """Section of the whole, for an element that takes one that varies."""
        if not callable(self.width) and not callable(self.thickness):
            return self.at(0.0, shear)
        return fm.sections.Profile(lambda place: self.at(place, shear), self.breaks)


def material() -> fm.Material:
    """That of the solid models."""
    m = solid.MATERIAL
    return fm.Material(m["E"], m["E"] / (2 + 2 * m["nu"]), m["rho"], nu=m["nu"], alpha=m["alpha"])


def reinforced(place):
    """Thickness of a leaf spring with a thick middle."""
    first, last = solid.MIDDLE
    return jnp.where((place > first) & (place < last), solid.THICK, THICKNESS)


def tapered(place):
    """Thickness of a tapered leaf spring."""
    return THICKNESS + (solid.THIN - THICKNESS) * place


def notched(place):
    """Thickness of a circular notch hinge."""
    x = (place - 0.5) * solid.NOTCH_LENGTH
    inside = solid.RADIUS**2 - jnp.minimum(x**2, solid.CORNER**2)
    return solid.NECK + 2 * (solid.RADIUS - jnp.sqrt(inside))


CORNERS = tuple(0.5 + side * solid.CORNER / solid.NOTCH_LENGTH for side in (-1, 1))
REINFORCED = Leaf(thickness=reinforced, breaks=solid.MIDDLE)
TAPERED = Leaf(thickness=tapered)
# The neck is a break, since compliance peaks there.
NOTCH = Leaf(solid.NOTCH_WIDTH, notched, (CORNERS[0], 0.5, CORNERS[1]))


def chain(count: int) -> Callable:
    """Builder of a leaf spring of so many cubic beams."""

    def add(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
        start, end = (np.array(b.nodes[node].start) for node in (first, last))
        bounds = [0.0, leaf.breaks[0], leaf.breaks[-1], 1.0] if leaf.breaks and count > 2 else [0.0, 1.0]
        counts = [round(count * share) for share in SHARES] if len(bounds) == 4 else [count]
        places = [bounds[0]]
        for low, high, n in zip(bounds[:-1], bounds[1:], counts, strict=True):
            places += list(np.linspace(low, high, n + 1)[1:])
        nodes = [first, *(f"{first}-{last} {i}" for i in range(1, count)), last]
        for node, place in zip(nodes[1:-1], places[1:-1], strict=True):
            b.node(node, [float(c) for c in start + place * (end - start)])
        return [
            b.add(spatial.beam, p, q, section=leaf.at((places[i] + places[i + 1]) / 2), y=ACROSS)
            for i, (p, q) in enumerate(itertools.pairwise(nodes))
        ]

    return add


def spectral(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
    """One spectral beam with shear."""
    return [b.add(spatial.spectral_beam(6, shear=True), first, last, section=leaf.section(shear=True), y=ACROSS)]


def leaf_spring(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
    """One leaf spring as it is; where its thickness jumps, one a piece."""
    if leaf is not REINFORCED:
        return [b.add(spatial.leaf_spring, first, last, section=leaf.section(), y=ACROSS)]
    start, end = (np.array(b.nodes[node].start) for node in (first, last))
    nodes = [first, *(f"{first}-{last} {i}" for i in range(len(leaf.breaks))), last]
    for node, place in zip(nodes[1:-1], leaf.breaks, strict=True):
        b.node(node, [float(c) for c in start + place * (end - start)])
    middles = [(p + q) / 2 for p, q in itertools.pairwise((0.0, *leaf.breaks, 1.0))]
    return [
        b.add(spatial.leaf_spring, p, q, section=leaf.at(middle), y=ACROSS)
        for (p, q), middle in zip(itertools.pairwise(nodes), middles, strict=True)
    ]


# Builders of one leaf spring between two nodes; each gives the names of its elements.
KINDS: dict[str, Callable] = {
    "one leaf_spring": leaf_spring,
    "one spectral beam with shear": spectral,
    "1 cubic beam": chain(1),
    "4 cubic beams": chain(4),
    "16 cubic beams": chain(16),
}


def rigid(b: fm.Builder, first: str, last: str) -> None:
    """Join two nodes."""
    b.add(spatial.beam, first, last, y=ACROSS)


def cantilever(kind: Callable, leaf: Leaf, free: bool = False, tip: float = LENGTH) -> tuple[fm.Builder, list[str]]:
    """Clamped leaf spring from x = 0 to its tip, the tip held by a rigid part unless free."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (tip, 0, 0))
    names = kind(b, leaf, "foot", "tip")
    b.fix("foot")
    if not free:
        b.node("beyond", (tip + 0.01, 0, 0))
        rigid(b, "tip", "beyond")
    return b, names


def along(compliance, before: str = "", axes=AXES) -> dict[str, float]:
    """Stiffnesses by name, each with everything else free."""
    return {f"{before}stiffness {a}": 1 / float(compliance[AXES.index(a), AXES.index(a)]) for a in axes}


def tip_of(b: fm.Builder, node: str = "tip", guided: bool = True) -> Callable:
    """Question for the stiffnesses of a node."""
    model = b.build()

    def ask():
        compliance = np.asarray(fm.compliance(model, node))
        found = along(compliance)
        if guided:
            stiffness = np.linalg.inv(compliance)
            found |= {f"rotations held, stiffness {a}": stiffness[i, i] for i, a in ((1, "y"), (2, "z"))}
        return found

    return ask


def single_leaf(kind, leaf=None):
    """Clamped leaf spring with a rigid tip."""
    return tip_of(cantilever(kind, leaf or Leaf())[0])


def notch(kind):
    """Notch hinge; what is asked of is a place in its middle that moves with its tip."""
    b = fm.Builder()
    b.node("foot", (-solid.NOTCH_LENGTH / 2, 0, 0))
    b.node("tip", (solid.NOTCH_LENGTH / 2, 0, 0))
    b.node("middle", (0, 0, 0))
    kind(b, NOTCH, "foot", "tip")
    rigid(b, "tip", "middle")
    b.fix("foot")
    return tip_of(b, "middle", guided=False)


def fold(kind, sizes=(LENGTH, WIDTH, THICKNESS), strokes=()):
    """Folded leaf spring at rest, and with its tip moved along x, rotations held, at strokes."""
    leg, width, thickness = sizes

    def at(stroke):
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("corner", (leg, 0, 0))
        b.node("tip", (leg, 0, leg))
        kind(b, Leaf(width, thickness), "foot", "corner")
        kind(b, Leaf(width, thickness), "corner", "tip")
        b.fix("foot")
        if stroke:
            b.prescribe("tip", "x", stroke)
            b.fix("tip", "rotation")
        else:
            b.node("beyond", (leg, 0, leg + 0.01))
            rigid(b, "tip", "beyond")
        return b

    rest, models = tip_of(at(0.0)), {s: at(s).build() for s in strokes}
    if not strokes:
        return rest
    return lambda: {f"0 mm, {k}": v for k, v in rest().items()} | at_strokes(models, "tip", ("y", "z"), 0)


def two(kind, leaf, places) -> tuple[fm.Builder, list[list[str]]]:
    """Two leaf springs, given by their feet and tips, and a stage at the third place."""
    *pairs, centre = places
    b = fm.Builder()
    b.node("stage", centre)
    names = []
    for i, (foot, top) in enumerate(pairs):
        b.node(f"foot{i}", foot)
        b.node(f"tip{i}", top)
        names.append(kind(b, leaf, f"foot{i}", f"tip{i}"))
        b.fix(f"foot{i}")
        rigid(b, f"tip{i}", "stage")
    return b, names


def guide_parts(kind, leaf=None):
    """Parallel guide."""
    pairs = [((0, 0, z), (LENGTH, 0, z)) for z in (0.0, DISTANCE)]
    return two(kind, leaf or Leaf(), [*pairs, (LENGTH, 0, DISTANCE / 2)])


def at_strokes(models, node, axes, component=2) -> dict[str, float]:
    """Force of the drive along z, and stiffnesses with it held."""
    found = {}
    for stroke, model in models.items():
        name, at = solid.millimetres(stroke), fm.linearize(model)
        place = at.labels.known(node)[component]
        found[f"{name}, force of the drive"] = float(at.matrices.reactions[place])
        found |= along(fm.compliance(at, node), f"{name}, ", axes)
    return found


def guide(kind, leaf=None):
    """Parallel guide at rest and at strokes."""

    def at(stroke):
        b, _ = guide_parts(kind, leaf)
        if stroke:
            b.prescribe("stage", "z", stroke)
        return b.build()

    rest, models = at(0.0), {s: at(s) for s in STROKES}
    axes = ("x", "y", "rx", "ry", "rz")
    return lambda: along(fm.compliance(rest, "stage"), "0 mm, ") | at_strokes(models, "stage", axes)


def guided_leaf(kind, strokes=STROKES):
    """Wide leaf spring whose tip moves without turning."""

    def at(stroke):
        b, _ = cantilever(kind, Leaf(WIDE), free=True)
        b.prescribe("tip", "z", stroke)
        b.fix("tip", "rotation")
        return b.build()

    models = {s: at(s) for s in strokes}
    return lambda: at_strokes(models, "tip", ("x", "y"))


def pivot(kind):
    """Cross pivot at rest and at an angle."""
    half = LENGTH / 2 * np.sqrt(0.5)
    pairs = [((-s * half, s * solid.OFFSET, -half), (s * half, s * solid.OFFSET, half)) for s in (1, -1)]

    def at(angle):
        b, _ = two(kind, Leaf(), [*pairs, (0, 0, 0)])
        if angle:
            b.prescribe("stage", "rotation", angle, axis=ACROSS, tilt="free")
        return b.build()

    rest, turned = at(0.0), at(ANGLE)
    name = solid.degrees(ANGLE)

    def ask():
        found = along(fm.compliance(rest, "stage"), "0 degrees, ")
        solved = fm.equilibrium(turned)
        moment = next(i for i, e in enumerate(solved.labels.e) if e.of == "turn of stage")
        found[f"{name}, moment of the drive"] = abs(float(solved.sigma[moment]))
        return found | along(fm.compliance(turned, "stage"), f"{name}, ", ("x", "y", "z", "rx", "rz"))

    return ask


def frequencies(kind):
    """Frequencies by kind of mode."""
    models = {}
    for name, force in ({"free tip": 0.0} | solid.AXIAL).items():
        b, _ = cantilever(kind, Leaf(), free=True)
        if force:
            b.force("tip", (force, 0, 0))
        models[name] = b.build()
    b, _ = cantilever(kind, Leaf(), free=True)
    b.fix("tip", "y", "z")
    b.fix("tip", "rotation")
    b.force("tip", (solid.CLAMPED_TENSION, 0, 0))
    held = b.build()

    def ask():
        found = {}
        for name, model in models.items():
            modes = fm.modes(model)
            shapes = np.asarray(modes.shapes)
            moves, turns = (shapes[list(model.labels.known(n))] for n in ("tip", "tip.rotation"))
            tips = moves[1], moves[2], turns[1] * WIDTH
            by_kind = solid.sorted_modes(np.asarray(modes.frequencies), *tips)
            found |= {f"{name}, {k}": v for k, (v, _) in by_kind.items()}
        for i, f in enumerate(np.asarray(fm.frequencies(held))[:3]):
            found[f"both ends clamped, tension of 100 N, mode {i + 1}"] = float(f)
        return found

    return ask


def buckling(kind):
    """Smallest critical loads."""
    models = {}
    for name in ("column, free tip", "sideways, free tip", "column, tip guided", "sideways, rigid tip"):
        b, _ = cantilever(kind, Leaf(), free="rigid" not in name)
        if "guided" in name:
            b.fix("tip", "y", "z")
            b.fix("tip", "rotation")
        b.force("tip", (-1.0, 0, 0) if name.startswith("column") else (0, 1.0, 0))
        models[name] = b.build()
    return lambda: {n: float(np.min(np.abs(np.asarray(fm.buckling_loads(m))))) for n, m in models.items()}


def heated(kind):
    """Warm leaf springs."""
    b, names = guide_parts(kind)
    for name in names[0]:
        b.temperature(name, 1.0)
    warm, bent = b.build(), {}
    for free in (True, False):
        b, parts = cantilever(kind, Leaf(), free)
        for name in parts:
            b.temperature(name, 0.0, gradient=(0.0, 1.0 / THICKNESS))
        bent["free tip" if free else "rigid tip"] = b.build()
    b, parts = cantilever(kind, Leaf(), free=True)
    for name in parts:
        b.temperature(name, 1.0)
    b.fix("tip")
    held = b.build()

    def ask():
        turned = fm.equilibrium(warm).at("stage.rotation")
        found = {"guide, lower leaf spring 1 K warmer, tilt": 2 * float(turned[2])}
        for name, model in bent.items():
            found[f"1 K across the thickness, {name}, deflection"] = -float(fm.equilibrium(model).at("tip")[2])
        pushed = fm.equilibrium(held)
        found["both ends clamped, 1 K warmer, force"] = -float(pushed.reactions[held.labels.known("tip")[0]])
        return found

    return ask


# By the names of the solid cases: functions of a kind that give a question, which gives numbers.
CASES: dict[str, Callable] = {
    "leaf spring 18 mm wide": single_leaf,
    "leaf spring 50 mm wide": lambda kind: single_leaf(kind, Leaf(WIDE)),
    "tapered leaf spring": lambda kind: single_leaf(kind, TAPERED),
    "reinforced leaf spring": lambda kind: single_leaf(kind, REINFORCED),
    "circular notch hinge": notch,
    "folded leaf spring": fold,
    "guide": guide,
    "guide, reinforced": lambda kind: guide(kind, REINFORCED),
    "guide, 50 mm wide": lambda kind: guide(kind, Leaf(WIDE)),
    "guided leaf spring 50 mm wide": guided_leaf,
    "cross pivot": pivot,
    "frequencies": frequencies,
    "buckling": buckling,
    "heated": heated,
}
