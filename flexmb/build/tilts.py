"""Rotations FIXED about two global axes in space: FIXED tilts of the hinge about the third axis replace both."""

from __future__ import annotations

import dataclasses

from ..model.by_name import TURN_OF, TURNS, turn_of
from ..model.model import MOTIONS
from ..model.topology import Role
from .description import Description, turn_about


def with_tilts(builder: Description) -> Description:
    """Return a builder in which rotations that are FIXED about two global axes turn about the third without limit.

    If two angles are zero, they do not determine a rotation by half a turn about the third axis. The tilts of the hinge
    about this axis determine all rotations about it.

    Returns:
        A copy. Without such rotations, or if an input moves one of the two angles: the builder itself.

    Source:
        THEORY.md 2, eq. (2.17).
    """
    found: dict[str, list[Role]] = {}
    hinges = (member for name, member in builder.members.items() if name.startswith(TURN_OF))
    inputs = [s for top in builder.signals["input"] for s in top.parts or (top,)]
    moved = {turn_of(s.key[1], TURNS[s.axis]) for s in inputs if s.axis is not None and s.quantity in MOTIONS}
    for rotation in dict.fromkeys(member.nodes[-1] for member in hinges):
        turns = [turn_about(builder, rotation, axis)[1] for axis in range(3)]
        if not builder.members.keys() >= set(turns):
            continue
        roles = {name: builder.members[name].roles for name in turns}
        free = [name for name in turns if roles[name][0] is not Role.FIXED]
        if len(free) == 1 and moved.isdisjoint({*turns} - {*free}):
            found |= {name: [Role.DEPENDENT, *roles[name][1:]] for name in turns if name not in free}
            found[free[0]] = [roles[free[0]][0], Role.FIXED, Role.FIXED]
    if not found:
        return builder
    twin = builder.copy()
    for name, roles in found.items():
        twin.members[name] = dataclasses.replace(twin.members[name], roles=roles)
    return twin
