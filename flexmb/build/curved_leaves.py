"""Warnings about leaf springs with sharp curvature, straight pieces of a curve, steep edges, slots, or stocky sizes."""

import itertools
from collections.abc import Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..elements.bent_strip import curving
from ..elements.curves import curvature_at
from ..elements.holes import is_holed
from ..elements.leaf import leaf_of
from ..elements.sections import Rectangle
from ..errors import BeamTheoryWarning, warn
from ..numerical_limits import SAME_SIZE
from .clamps import FOLD, THICK, End, axes_at, elements_at, ends_at, ends_of, is_fold, opposite, section_at, span_of
from .description import Description, Member

# Thickness or width over the radius at which the stress at the inner side is 5 % above the stress of a thin beam.
SHARP = 0.15
# Largest angle between two pieces that approximate a curve, and between pieces that turn in the same sense [rad]. Two
# chords at 45 degrees have errors up to 50 %, but may be a folded leaf spring, which must not warn.
STEEPEST, STEEPEST_OF_CHAIN = np.radians(20.0), np.radians(31.0)
# Largest slope of the width compared with solid elements.
SLANT = 0.75
# Least length over width, and least width over thickness, compared with solid elements.
SHORTEST, NARROWEST = 0.5, 4.0
# Smallest relative change of a stiffness that causes a warning.
SHARE = 0.01


def warn_of_curved_leaves(builder: Description) -> None:
    """Warn of sharp curvature, steep edges, slots and stocky leaf springs, and of straight pieces that make a curve.

    Source:
        Winkler's curved bars of rectangular section: the inner stress is higher by the share h/(3 R). Flattening of a
        curved strip: THEORY.md 2, eq. (2.44).
    """
    leaves = {name: leaf for name, leaf in builder.members.items() if _is_leaf(builder, leaf)}
    joined = elements_at(builder)
    with jax.ensure_compile_time_eval():
        for name, leaf in leaves.items():
            _warn_of_sharp(name, leaf, section_at(builder, leaf, 0.5))
            _warn_of_slant(builder, name, leaf)
            _warn_of_stocky(builder, name, leaf, _length_in_line(builder, joined, leaves, name))
        if (pieces := _pieces_of_a_curve(builder, leaves)) is not None:
            warn(
                f"Elements '{pieces[0]}' and '{pieces[1]}' meet at a small angle, as straight pieces of a curved leaf"
                " spring do. The stiffness of a curved leaf spring lies between the stiffnesses of straight pieces in"
                " line and of folds. Make it one leaf spring with `curvature`.",
                BeamTheoryWarning,
            )
        for narrow, wide in _pairs_in_rigid_parts(builder, leaves):
            if _is_beside_slot(builder, narrow, wide):
                warn(
                    f"Element '{narrow.leaf}' continues '{wide.leaf}' beside its axis, as the sides of a slot do. The"
                    " joint is rigid in flexmb, but the material there deforms. The mechanism may be 35 % too stiff"
                    " across and 43 % in torsion. Model a slot in the middle of the width by `fm.sections.with_hole`."
                    " Compare another slot with solid elements.",
                    BeamTheoryWarning,
                )
                return


def _pairs_in_rigid_parts(builder: Description, leaves: dict[str, Member]) -> Iterator[tuple[End, End]]:
    """Pairs of ends of leaf springs at both ends of a rigid part in space, the narrower leaf spring first."""
    ends = ends_at(builder, leaves)
    for member in builder.members.values() if builder.dimension == 3 else ():
        rotations = member.nodes_of_kind("rotation")
        if member.properties.get("section") is None and len(member.nodes_of_kind("position")) == len(rotations) == 2:
            for pair in itertools.product(*(ends.get(rotation, ()) for rotation in rotations)):
                narrow, wide = sorted(pair, key=lambda end: float(section_at(builder, leaves[end.leaf], 0.5).width))
                yield narrow, wide


def _is_beside_slot(builder: Description, narrow: End, wide: End) -> bool:
    """Whether a leaf spring starts at the end of a wider one, within its width and in its plane, and continues it."""
    section, wide_section = (section_at(builder, builder.members[end.leaf], 0.5) for end in (narrow, wide))
    width, thickness, wide_width = float(section.width), float(section.thickness), float(wide_section.width)
    (along, _), (wide_along, wide_across) = axes_at(builder, narrow, wide)
    if not 1 / THICK < thickness / float(wide_section.thickness) < THICK or is_fold(builder, narrow, wide):
        return False
    # Directions away from both ends.
    if along @ wide_along * (1 - 2 * narrow.number) * (1 - 2 * wide.number) > 0:
        return False
    places = [builder.members[end.leaf].nodes_of_kind("position")[end.number] for end in (narrow, wide)]
    apart = np.subtract(*(np.asarray(builder.nodes[place].start, float) for place in places))
    beside = float(abs(apart @ wide_across))
    is_within = SAME_SIZE * width < beside and beside + width / 2 <= (1 + SAME_SIZE) * wide_width / 2
    return is_within and bool(np.linalg.norm(apart - apart @ wide_across * wide_across) < thickness)


def _is_leaf(builder: Description, member: Member) -> bool:
    if not member.element.fields or "clamped" not in member.properties:
        return False
    starts = [builder.nodes[node].start for node in member.nodes]
    return is_concrete((starts, member.properties)) and isinstance(section_at(builder, member, 0.5), Rectangle)


def _warn_of_sharp(name: str, leaf: Member, section: Any) -> None:
    if (curvature := leaf.properties.get("curvature")) is None:
        return
    largest = np.max(np.abs(np.atleast_2d(np.asarray(curvature_at(curvature, np.linspace(0, 1, 21))).T)), axis=1)
    thickness = float(section.thickness)
    sizes = (0.0, thickness, float(section.width))[-len(largest) :] if len(largest) > 1 else (thickness,)
    worst = max(bend * size for bend, size in zip(largest, sizes, strict=True))
    if worst > SHARP:
        warn(
            f"Element '{name}' is curved sharply: at its inner side, bending stress is about {worst / 3:.0%} higher"
            " than by the theory of thin beams.",
            BeamTheoryWarning,
        )


def _warn_of_slant(builder: Description, name: str, leaf: Member) -> None:
    if not leaf.properties["section"].varies:
        return
    length = float(span_of(builder, leaf))
    section = leaf_of(leaf.properties["section"], None)
    steepest = max(abs(float(section.slanted(place, length)[1])) for place in np.linspace(0.0, 1.0, 9))
    if steepest > SLANT:
        warn(
            f"The width of element '{name}' has a slope of up to {steepest:.2f} along it. Stiffnesses were compared"
            f" with solid elements up to a slope of {SLANT}. Divide the leaf spring, or compare it yourself.",
            BeamTheoryWarning,
        )


def _length_in_line(builder: Description, joined: dict[str, list[str]], leaves: dict[str, Member], name: str) -> float:
    """Length of a leaf spring, and of others in line if nothing clamps them to each other; inf if traced [m]."""
    length, passed = float(span_of(builder, leaves[name])), {name}
    for at in ends_of(name, leaves[name]):
        while len(others := [other for other in joined[at.rotation] if other != at.leaf]) == 1:
            other = builder.members[others[0]]
            if others[0] not in leaves:
                goes_on = "clamped" in other.properties or is_holed(other.properties.get("section"))
                length += np.inf if other.element.fields and goes_on else 0.0
                break
            near = next(end for end in ends_of(others[0], other) if end.rotation == at.rotation)
            before = section_at(builder, builder.members[at.leaf], 0.5)
            thick = float(section_at(builder, other, 0.5).thickness) >= THICK * float(before.thickness)
            if others[0] in passed or thick or is_fold(builder, at, near):
                break
            length, at = length + float(span_of(builder, other)), opposite(builder, near)
            passed.add(others[0])
    return length


def _warn_of_stocky(builder: Description, name: str, leaf: Member, length: float) -> None:
    rectangles = [section_at(builder, leaf, place) for place in (0.0, 0.5, 1.0)]
    # A piece of a longer leaf spring may be short.
    if (long := length / float(rectangles[1].width)) < SHORTEST:
        warn(
            f"Element '{name}' is {long:.2g} times as long as wide. From {SHORTEST} on, stiffnesses of leaf springs"
            " agree with solid elements. Model shorter ones by solid or shell elements, or compare it yourself.",
            BeamTheoryWarning,
        )
    wide = min(float(rectangle.width) / float(rectangle.thickness) for rectangle in rectangles)
    # A mechanism in the plane has no twist.
    if builder.dimension == 3 and wide < NARROWEST:
        warn(
            f"Element '{name}' is {wide:.2g} times as wide as thick. From {NARROWEST:g} on, stiffnesses of leaf springs"
            " agree with solid elements. Model thicker ones by beams, or compare it yourself.",
            BeamTheoryWarning,
        )


def _pieces_of_a_curve(builder: Description, leaves: dict[str, Member]) -> tuple[str, str] | None:
    """Two leaf springs in line that approximate a curved leaf spring with a different stiffness."""
    meeting = ends_at(builder, leaves)
    for name, leaf in leaves.items():
        turns: list[Any] = []
        for at in ends_of(name, leaf):
            for other in meeting[at.rotation]:
                if other.leaf == name or (turn := _turn(builder, at, other)) is None:
                    continue
                # Two folds in the same sense make a curve, one fold does not.
                folds = [before for end, before in turns if end != at.number and FOLD <= min(_angles(before, turn))]
                if any(max(_angles(before, turn)) < STEEPEST_OF_CHAIN and before @ turn > 0 for before in folds):
                    return name, other.leaf
                if _stand_for_a_curve(builder, leaf, leaves[other.leaf], _angles(turn)[0]):
                    return name, other.leaf
                turns.append((at.number, turn))
    return None


def _angles(*turns: Any) -> list[float]:
    return [float(np.arcsin(min(np.linalg.norm(turn), 1.0))) for turn in turns]


def _turn(builder: Description, at: End, other: End) -> Any:
    """Axis times the sine of the angle from a leaf spring to the next; None unless they bend about the same axis."""
    (along, across), (along_other, across_other) = axes_at(builder, at, other)
    away = along_other * (1 - 2 * other.number)
    if abs(across @ across_other) < np.cos(FOLD) or along @ away * (2 * at.number - 1) <= 0:
        return None
    first, second = (np.append(axis, 0.0)[:3] for axis in (along, away))
    return np.cross(first, second)


def _stand_for_a_curve(builder: Description, first: Member, other: Member, angle: float) -> bool:
    section = section_at(builder, first, 0.5)
    length = (float(span_of(builder, first)) + float(span_of(builder, other))) / 2
    if angle == 0 or angle >= STEEPEST or (angle >= FOLD and length > section.width):
        return False
    nu = float(section.material.poisson())
    fourth = 3 * (1 - nu**2) * (angle / length * section.width**2 / section.thickness) ** 2
    return nu**2 * (1 - float(curving(jnp.asarray(fourth, float)))) > SHARE
