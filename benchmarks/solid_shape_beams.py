"""The cases of ``solid_shapes.py`` as mechanisms of flexmb, one element a leaf spring, and those it cannot describe."""

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
import solid_shapes as shapes
from solid_beams import ACROSS, Leaf, cantilever, fold, guided_leaf, tip_of
from solid_cases import THICKNESS

import flexmb as fm
from flexmb import spatial

# Elements that are compared in these cases.
KINDS = ("one leaf_spring",)
# Cases whose solid models take a quarter of an hour; no results of theirs are committed.
NOT_SOLVED = ("arc at strokes", "cosine arch at strokes")
# Cases that no element describes, or no mechanism here: their solid results stand by themselves.
NOT_YET = {
    **dict.fromkeys(("arc at strokes", "cosine arch", "cosine arch at strokes"), "no mechanism of it is written yet"),
    "slot": "no section has a hole",
}


def plain(sizes) -> Callable:
    """Question about one strip of a length, a width and a thickness, which may vary."""
    length, width, thickness = sizes
    return lambda kind: tip_of(cantilever(kind, Leaf(width, thickness), tip=length)[0])


def tapered(sizes) -> Callable:
    """Strip whose width varies linearly."""
    length, foot, tip = sizes
    return plain((length, lambda place: foot + (tip - foot) * place, THICKNESS))


def waisted(kind):
    """Strip whose width narrows to its middle."""
    length, wide, narrow = shapes.WAIST
    return plain((length, lambda place: wide + (narrow - wide) * jnp.sin(jnp.pi * place) ** 2, THICKNESS))(kind)


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


def stiffened(thick: float) -> Callable:
    """Strip whose middle part is thicker."""
    width, lengths = shapes.STIFFENED
    return in_line(lengths, [Leaf(width), Leaf(width, thick), Leaf(width)])


CASES: dict[str, Callable] = {
    "short leaf spring": plain(shapes.SHORT),
    "broad leaf spring": plain(shapes.BROAD),
    "thick leaf spring": plain(shapes.THICK),
    "trapezoid": tapered(shapes.TRAPEZOID),
    "triangle": tapered(shapes.TRIANGLE),
    "waist": waisted,
    "steps in width": in_line(
        (shapes.STEPS[0],) * 3, [Leaf(shapes.STEPS[1]), Leaf(shapes.STEPS[2]), Leaf(shapes.STEPS[1])]
    ),
    "steps in thickness, 1.75 mm": stiffened(0.00175),
    "steps in thickness, 5 mm": stiffened(0.005),
    "arc": arc(),
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
}
