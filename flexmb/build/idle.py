"""Warnings of rigidities, stress, strain and damping that a Builder describes and that do nothing."""

import dataclasses
from typing import Any

import jax
import numpy as np

from ..arguments import is_concrete
from ..elements.sections import Damping, MaterialDamping, Rigidity
from ..errors import IdleWarning, warn
from ..model.roles import HELD, Role
from .description import Description, Member

# Numbers of a section or of dampers that resist deformations.
RESISTING = ("EA", "EIy", "EIz", "GIt")


def warn_of_idle(builder: Description) -> None:
    """Warn of stress, strain and damping that act on deformations which are all held, and of numbers not asked for."""
    _warn_of_other_numbers(builder)
    for what in ("prestress", "strain"):
        for sets in builder.loads.values():
            acting: dict[str, list[int]] = {}
            for (_, of, number), value in sets.get(what, {}).items():
                if not is_concrete(value) or np.asarray(value) != 0:
                    acting.setdefault(of, []).append(number)
            for of, numbers in acting.items():
                roles = [builder.members[of].roles[n - 1] for n in numbers]
                if all(role in HELD for role in roles):
                    told = ", ".join(f"deformation {n} is {r.value}" for n, r in zip(numbers, roles, strict=True))
                    warn(
                        f"{what.capitalize()} of element '{of}': {told}, so that it does nothing there. Release the"
                        " deformation, or leave it out.",
                        IdleWarning,
                    )
    for sets in builder.loads.values():
        for _, of, _ in sets.get("temperature", {}):
            if all(role is Role.PRESCRIBED for role in builder.members[of].roles):
                warn(f"Temperature of element '{of}': all of its deformations are PRESCRIBED, so that it does nothing.")
    for of, member in builder.members.items():
        if isinstance(member.properties.get("damping"), MaterialDamping):
            # Of a material that is stated once and held here.
            continue
        dampers = [getattr(member.element, kind) for kind in ("damping", "dissipation")]
        damped = any(member.element.arguments(f, member.properties) is not None for f in dampers)
        if damped and member.roles and all(role in HELD for role in member.roles):
            warn(f"Damping of element '{of}': all of its deformations are held, so that it does nothing.")


def _warn_of_other_numbers(builder: Description) -> None:
    """Warn of elements that are given rigidities, or dampers, which they do not use in place of those that they do."""
    used: dict[Any, set[str]] = {}
    told: set[Any] = set()
    for name, member in builder.members.items():
        element = member.element
        for key, kind in (("section", "stiffness"), ("damping", "damping")):
            numbers = member.properties.get(key)
            if not isinstance(numbers, Rigidity | Damping) or (element, id(numbers)) in told:
                continue
            told.add((element, id(numbers)))
            if not is_concrete(numbers):
                continue
            given = {one for one in RESISTING if np.any(np.asarray(getattr(numbers, one)) != 0)}
            if len(given) in (0, len(RESISTING)):
                continue
            if (element, kind) not in used:
                used[element, kind] = _used(member, key, kind)
            idle, missing = given - used[element, kind], used[element, kind] - given
            # Who states no axial rigidity alone may hold the elongation.
            if idle and missing and (missing == used[element, kind] or missing != {"EA"}):
                what, lacking, every = (
                    ", ".join(one for one in RESISTING if one in some) for some in (idle, missing, used[element, kind])
                )
                warn(
                    f"{key.capitalize()} of element '{name}' ({element.name}): {lacking} is zero, and what is given as"
                    f" {what} is not used there. The element uses {every}.",
                    IdleWarning,
                )


def _used(member: Member, key: str, kind: str) -> set[str]:
    """Which of the numbers of a section, or of dampers, enter the stiffness, or the damping, of an element."""
    element = member.element
    companion: Any = getattr(element, kind)
    arguments = element.arguments(companion, member.properties)
    if arguments is None or key not in arguments:
        return set()

    def resisting(numbers: dict[str, Any], places: list[Any]):
        own = dataclasses.replace(arguments[key], **numbers)
        return companion(ref=element.reference(places), **{**arguments, key: own})

    places = [np.zeros(len(node.start)) for node in element.nodes.values()]
    program = jax.make_jaxpr(resisting)(dict.fromkeys(RESISTING, 1.0), places).jaxpr
    entering = {id(variable) for equation in program.eqns for variable in equation.invars}
    return {name for name, variable in zip(RESISTING, program.invars, strict=False) if id(variable) in entering}
