"""The cases of ``solid_shapes.py`` as mechanisms of flexmb, one element for each straight part."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
import solid_shapes as shapes
from solid_beams import ACROSS, Leaf, along, cantilever, fold, guided_leaf, rigid, tip_of
from solid_cases import THICKNESS, millimetres

import flexmb as fm
from flexmb import spatial
from flexmb.linear.linearize import Linearization

# Elements that are compared in these cases.
KINDS = ("one leaf_spring",)


def plain(sizes) -> Callable:
    """Question about one strip of a length, a width and a thickness, which may vary."""
    length, width, thickness = sizes
    return lambda kind: tip_of(cantilever(kind, Leaf(width, thickness), tip=length)[0])


def tapered(sizes) -> Callable:
    """Strip whose width varies linearly."""
    length, foot, tip = sizes
    return plain((length, lambda place: foot + (tip - foot) * place, THICKNESS))


def waist() -> Leaf:
    """Leaf spring whose width narrows to its middle."""
    _, wide, narrow = shapes.WAIST
    return Leaf(lambda place: wide + (narrow - wide) * jnp.sin(jnp.pi * place) ** 2)


def guided(
    leaf: Leaf, length: float, strokes, cut: float | None = None, at_rest: bool = False, build: Any = None
) -> Callable:
    """Strip whose tip is moved along z without turning; its foot is cut at an angle.

    Args:
        leaf: Strip.
        length: [m].
        strokes: Of the tip [m].
        cut: Angle of the cut of the foot [rad].
        at_rest: Whether the stiffnesses at rest are wanted too.
        build: Adds the elements; one leaf spring if None.
    """
    own = {} if cut is None else {"skew": (cut, 0.0)}

    def strip(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
        return [b.add(spatial.leaf_spring, first, last, section=leaf.section(), y=ACROSS, **own)]

    whole = build or strip

    def ask():
        rest = tip_of(cantilever(whole, leaf, tip=length)[0])() if at_rest else {}
        found = {f"0 mm, {k}": v for k, v in rest.items()}
        for stroke in strokes:
            state, about = moved(cantilever(whole, leaf, free=True, tip=length)[0], "z", stroke), millimetres(stroke)
            found[f"{about}, force of the drive"] = force_of(state, 2)
            found |= along(fm.compliance(state, "tip"), f"{about}, ", ("x", "y"))
        return found

    return lambda kind: ask


def curved(chord: float, leaf: Leaf, curvature: tuple[float, float, float]) -> Callable:
    """Strip with a twist and two curvatures before any load, its chord along x."""

    def ask(kind):
        del kind

        def whole(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
            section = leaf.section()
            return [b.add(spatial.leaf_spring, first, last, section=section, y=ACROSS, curvature=lambda _: curvature)]

        return tip_of(cantilever(whole, leaf, tip=chord)[0])

    return ask


def arc() -> Callable:
    """Arc of a circle."""
    radius, angle, width, thickness = shapes.ARC
    return curved(2 * radius * np.sin(angle / 2), Leaf(width, thickness), (0.0, 1 / radius, 0.0))


def moved(b: fm.Builder, component: str, displacement: float) -> Linearization:
    """Mechanism whose tip is moved in a direction without turning."""
    b.prescribe("tip", component, displacement)
    b.fix("tip", "rotation")
    return fm.linearize(b.build())


def force_of(at: Linearization, component: int) -> float:
    """Force of the drive."""
    return float(at.matrices.reactions[at.labels.known("tip")[component]])


def arc_far(kind):
    """Arc whose tip is moved along its chord."""
    del kind
    radius, angle, width, thickness = shapes.ARC
    chord, leaf = 2 * radius * np.sin(angle / 2), Leaf(width, thickness)

    def at(stroke: float):
        def whole(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
            bent = (0.0, 1 / radius, 0.0)
            return [b.add(spatial.leaf_spring, first, last, section=leaf.section(), y=ACROSS, curvature=lambda _: bent)]

        return moved(cantilever(whole, leaf, free=True, tip=chord)[0], "x", stroke)

    def ask():
        found = {}
        for sign, name in ((1, "apart"), (-1, "together")):
            for stroke in shapes.ARC_STROKES[name]:
                about, state = f"{name} {1e3 * stroke:.1f} mm", at(sign * stroke)
                found[f"{about}, force of the drive"] = force_of(state, 0)
                found |= along(fm.compliance(state, "tip"), f"{about}, ", ("y",))
        return found

    return ask


def half_arch(free: bool) -> fm.Builder:
    """Half of a cosine arch, one element through points of its middle line."""
    span, height, width, thickness = shapes.ARCH
    places = np.linspace(0, span / 2, 41)
    line = np.stack([places, 0 * places, height / 2 * (1 - np.cos(2 * np.pi * places / span))], axis=1)
    b = fm.Builder()
    b.node("foot", tuple(line[0]))
    b.node("tip", tuple(line[-1]))
    curvature = fm.sections.curvature_through(line, y=ACROSS)
    section = Leaf(width, thickness).section()
    b.add(spatial.leaf_spring, "foot", "tip", section=section, y=ACROSS, curvature=curvature, clamped=(True, True))
    b.fix("foot")
    if not free:
        b.node("beyond", tuple(line[-1] + (0.01, 0, 0)))
        rigid(b, "tip", "beyond")
    return b


def arch_far(kind):
    """Half of a cosine arch whose middle is moved down without turning; it moves along z alone."""
    del kind

    def ask():
        found = {}
        for stroke in shapes.ARCH_STROKES:
            b = half_arch(free=True)
            b.fix("tip", "x", "y")
            found[f"down {1e3 * stroke:.1f} mm, force of the drive"] = force_of(moved(b, "z", -stroke), 2)
        return found

    return ask


def skew(foot: float, tip: float) -> Callable:
    """Strip whose ends are cut at angles."""
    length, width, thickness = shapes.SKEW

    def ask(kind):
        del kind

        def whole(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
            return [b.add(spatial.leaf_spring, first, last, section=leaf.section(), y=ACROSS, skew=(foot, tip))]

        return tip_of(cantilever(whole, Leaf(width, thickness), tip=length)[0])

    return ask


def in_line(lengths, leaves) -> Callable:
    """Strips one after the other."""

    def ask(kind):
        def whole(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
            del leaf
            inner = [f"step {i}" for i in range(len(lengths) - 1)]
            for name, x in zip(inner, np.cumsum(lengths), strict=False):
                b.node(name, (float(x), 0, 0))
            names = [first, *inner, last]
            return [e for i, part in enumerate(leaves) for e in kind(b, part, names[i], names[i + 1])]

        return tip_of(cantilever(whole, leaves[0], tip=sum(lengths))[0])

    return ask


def with_hole(sizes, rounded: bool) -> Callable:
    """Builder of a strip with a hole in its middle: a leaf spring on both sides, a spectral beam beside the hole."""
    (length, _), (long, wide) = sizes

    def whole(b: fm.Builder, leaf: Leaf, first: str, last: str) -> list[str]:
        nodes = [first, "start", "end", last]
        for node, side in zip(nodes[1:3], (-1, 1), strict=True):
            b.node(node, ((length + side * long) / 2, 0, 0))
        strip, beam = leaf.section(), spatial.spectral_beam(shear=True)
        beside = fm.sections.with_hole(strip, wide, rounded=rounded)
        kinds = [(spatial.leaf_spring, strip), (beam, beside), (spatial.leaf_spring, strip)]
        return [b.add(kind, *nodes[i : i + 2], section=section, y=ACROSS) for i, (kind, section) in enumerate(kinds)]

    return whole


def holed(sizes, rounded: bool) -> Callable:
    """Strip with a hole in its middle."""
    (length, width), _ = sizes
    return lambda _: tip_of(cantilever(with_hole(sizes, rounded), Leaf(width), tip=length)[0])


def stiffened(thick: float) -> Callable:
    """Strip whose middle part is thicker."""
    width, lengths = shapes.STIFFENED
    return in_line(lengths, [Leaf(width), Leaf(width, thick), Leaf(width)])


def widened(middle: float, ends: float) -> Callable:
    """Strip whose middle part is wider, and of another thickness."""
    width, wide, lengths = shapes.WIDENED
    return in_line(lengths, [Leaf(width, ends), Leaf(wide, middle), Leaf(width, ends)])


CASES: dict[str, Callable] = {
    "short leaf spring": plain(shapes.SHORT),
    "broad leaf spring": plain(shapes.BROAD),
    "thick leaf spring": plain(shapes.THICK),
    "trapezoid": tapered(shapes.TRAPEZOID),
    "triangle": tapered(shapes.TRIANGLE),
    "waist": lambda kind: tip_of(cantilever(kind, waist(), tip=shapes.WAIST[0])[0]),
    "steps in width": in_line(
        (shapes.STEPS[0],) * 3, [Leaf(shapes.STEPS[1]), Leaf(shapes.STEPS[2]), Leaf(shapes.STEPS[1])]
    ),
    "slot": holed(shapes.SLOT, False),
    "slot at strokes": guided(
        Leaf(shapes.SLOT[0][1]), shapes.SLOT[0][0], shapes.SLOT_STROKES, build=with_hole(shapes.SLOT, False)
    ),
    "slot with round ends": holed(shapes.OBLONG, True),
    "round hole": holed(shapes.HOLE, True),
    "steps in thickness, 1.75 mm": stiffened(0.00175),
    "steps in thickness, 5 mm": stiffened(0.005),
    "wide thick middle": widened(0.001, shapes.THICKNESS),
    "wide thin middle": widened(shapes.THICKNESS, 0.001),
    "arc": arc(),
    "arc at strokes": arc_far,
    "cosine arch": lambda _: tip_of(half_arch(free=False)),
    "cosine arch at strokes": arch_far,
    "twisted leaf spring": curved(
        shapes.TWISTED[0], Leaf(*shapes.TWISTED[1:]), (shapes.TWIST / shapes.TWISTED[0], 0.0, 0.0)
    ),
    **{
        f"skew {np.degrees(a):.0f} degrees, {'both ends' if tip else 'foot alone'}": skew(a, a if tip else 0.0)
        for tip in (True, False)
        for a in shapes.SKEWNESS
    },
    "wide fold": lambda kind: fold(kind, shapes.FOLDED, shapes.FOLD_STROKES),
    "guided leaf spring 50 mm wide, far": lambda kind: guided_leaf(kind, shapes.GUIDED_STROKES),
    "trapezoid, foot cut at 30 degrees": guided(
        Leaf(lambda place: shapes.TRAPEZOID[1] + (shapes.TRAPEZOID[2] - shapes.TRAPEZOID[1]) * place),
        shapes.TRAPEZOID[0],
        shapes.TENTH,
        shapes.CUT,
        at_rest=True,
    ),
    "waist at a stroke": guided(waist(), shapes.WAIST[0], shapes.TENTH),
    "skew 30 degrees, foot alone, at strokes": guided(
        Leaf(shapes.SKEW[1]), shapes.SKEW[0], shapes.SKEW_STROKES, shapes.CUT
    ),
}
