"""Warnings of stress, strain and damping that a Builder describes and that do nothing."""

import numpy as np

from ..arguments import is_concrete
from ..elements.sections import MaterialDamping
from ..errors import IdleWarning, warn
from ..model.roles import HELD, Role
from .description import Description


def warn_of_idle(builder: Description) -> None:
    """Warn of stress, strain and damping that act on deformations which are all held."""
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
