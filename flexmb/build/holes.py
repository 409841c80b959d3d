"""Check of leaf springs with holes: strips at both ends of a hole, and warnings outside of the range of the fits."""

from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..elements.holes import is_holed
from ..elements.sections import Rectangle
from ..errors import BeamTheoryWarning, ModelError, warn
from ..numerical_limits import SAME_SIZE
from .clamps import End, elements_at, end_at, ends_of, is_clamped, is_fold, opposite, section_at, span_of
from .description import Description
from .ends_in_line import NUS

# Ranges compared with solid elements: width of the hole over the width of the strip, largest length over width of the
# hole, least width over thickness of the material beside the hole, least distance from clamps over the width.
WIDTHS, LONGEST, NARROWEST, NEAREST = (0.1 - 1e-9, 0.7 + 1e-9), 8.0 * (1 + 1e-9), 4.0 * (1 - 1e-9), 0.5 * (1 - 1e-9)


def check_holes(builder: Description) -> None:
    """Warn of holes outside of the range of their fits, with the name of the element.

    Raises:
        ModelError: A hole has no strip of equal sizes in line at both of its ends.

    Source:
        THEORY.md 2, below eq. (2.75).
    """
    joined = elements_at(builder)
    for name, member in builder.members.items():
        starts = [builder.nodes[node].start for node in member.nodes]
        if not is_holed(member.properties.get("section")) or not is_concrete((member.properties, starts)):
            continue
        beyond = [_strip_beyond(builder, joined, end) for end in ends_of(name, member)]
        piece, length = section_at(builder, member, 0.5), float(span_of(builder, member))
        width, hole, nu = float(piece.width), float(piece.hole), float(piece.material.poisson())
        # Distances that depend on traced numbers are not checked.
        near = min(beyond) / width if is_concrete(beyond) else np.inf
        faults = []
        if not WIDTHS[0] <= hole / width <= WIDTHS[1]:
            faults.append(f"the hole is {hole / width:.2g} times as wide as the strip, and fits hold from 0.1 to 0.7")
        if length > LONGEST * hole:
            faults.append(f"the hole is {length / hole:.3g} times as long as wide, and fits hold up to 8")
        if (beside := (width - hole) / 2 / float(piece.thickness)) < NARROWEST:
            faults.append(
                f"the material beside the hole is {beside:.2g} times as wide as thick, and fits hold from 4 on"
            )
        if near < NEAREST:
            faults.append(
                f"the hole ends {near:.2g} widths of the strip from a clamp, from another hole or from the end of the"
                " strip, and fits hold from 0.5 on"
            )
        if not NUS[0] <= nu <= NUS[1]:
            faults.append(f"Poisson's ratio is {nu:.3g}, and fits hold from 0.2 to 0.4")
        if member.properties.get("curvature") is not None:
            faults.append("a curved strip")
        if faults:
            warn(f"Element '{name}' was not compared with solid elements: {'; '.join(faults)}.", BeamTheoryWarning)


def _strip_beyond(builder: Description, joined: dict[str, list[str]], end: End) -> Any:
    """Length of the strip beyond an end of a hole, up to a clamp or another hole, that may be traced [m]."""
    if (following := _goes_on(builder, joined, end)) is None:
        raise ModelError(
            f"Element '{end.leaf}' has a section with a hole, but no strip of the same width and thickness continues it"
            f" in line at node '{end.rotation}'. A hole lies inside a strip, in the middle of its width: add leaf"
            " springs with the section of the strip at both ends of the hole. Model a hole beside the axis by solid"
            " elements. If a slot reaches a clamp, model the parts on both sides of it by leaf springs."
        )
    length: Any = 0.0
    passed = {end.leaf}
    while following is not None and following.leaf not in passed:
        if is_clamped(builder, following, joined).flat:
            break
        passed.add(following.leaf)
        length = length + span_of(builder, builder.members[following.leaf])
        end = opposite(builder, following)
        following = _goes_on(builder, joined, end)
    return length


def _goes_on(builder: Description, joined: dict[str, list[str]], end: End) -> End | None:
    """End of a rectangular strip that continues an element in line with the same width and thickness."""
    for name in joined[end.rotation]:
        section = builder.members[name].properties.get("section")
        if name == end.leaf or section is None:
            continue
        following = end_at(builder, name, end.rotation)
        first, other = (section_at(builder, builder.members[at.leaf], at.number) for at in (end, following))
        if not isinstance(other, Rectangle) or is_fold(builder, end, following):
            continue
        sizes = [(getattr(first, side), getattr(other, side)) for side in ("width", "thickness")]
        # Traced sizes may be equal.
        if all(not is_concrete(pair) or abs(float(pair[1]) / float(pair[0]) - 1) < SAME_SIZE for pair in sizes):
            return following
    return None
