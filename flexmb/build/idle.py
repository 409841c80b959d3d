"""Warnings of rigidities, stresses, strains, dampings and laws in a Builder that have no effect."""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..arguments import is_concrete
from ..compilation.compile import jit_beside_options
from ..elements.element import ELASTIC, Element
from ..elements.general import General
from ..elements.sections import Damping, MaterialDamping, Rigidity
from ..errors import IdleWarning, warn
from ..model.topology import HELD, Role
from .description import Description, Member

# Numbers of a section and of dampers that resist deformation, in alphabetical order.
RESISTING = {"section": ("EA", "EIy", "EIz", "GIt"), "damping": ("EA", "EIy", "EIz", "GAy", "GAz", "GIt")}
RESISTS = {"section": "resists", "damping": "damps"}
# Companion that these numbers serve.
KINDS = {"section": "stiffness", "damping": "damping"}


def warn_of_idle(builder: Description) -> None:
    """Warn of stress, strain, damping and laws that act only on held deformations, and of unused numbers."""
    _warn_of_other_numbers(builder)
    for noun in ("prestress", "strain"):
        for sets in builder.loads.values():
            acting: dict[str, list[int]] = {}
            for (_, name, number), value in sets.get(noun, {}).items():
                if not is_concrete(value) or np.asarray(value) != 0:
                    acting.setdefault(name, []).append(number)
            for name, numbers in acting.items():
                member = builder.members[name]
                roles = {n: role for n in numbers if (role := member.roles[n - 1]) in HELD}
                loose = [] if noun == "prestress" else _loose(builder, member, [n for n in numbers if n not in roles])
                reasons = [f"deformation {member.element.called(n)} is {role.value}" for n, role in roles.items()]
                reasons += [f"nothing resists deformation {member.element.called(n)}" for n in loose]
                if reasons:
                    advice = "Release the deformation" if roles else "Give it a stiffness"
                    warn(
                        f"{noun.capitalize()} of element '{name}': {', '.join(reasons)}, so it has no effect there."
                        f" {advice}, or leave it out.",
                        IdleWarning,
                    )
    for sets in builder.loads.values():
        for _, name, _ in sets.get("temperature", {}):
            if all(role is Role.PRESCRIBED for role in builder.members[name].roles):
                warn(f"Temperature of element '{name}': all of its deformations are PRESCRIBED, so it has no effect.")
    for name, member in builder.members.items():
        if not member.roles or any(role not in HELD for role in member.roles):
            continue
        for noun, kinds in {"Damping": ("damping", "dissipation"), "Law": ("law", "energy")}.items():
            # Damping of a material is stated once, for elements with held deformations too.
            of_material = noun == "Damping" and isinstance(member.properties.get("damping"), MaterialDamping)
            functions = [getattr(member.element, kind) for kind in kinds]
            acts = any(member.element.arguments(f, member.properties) is not None for f in functions)
            if acts and not of_material:
                warn(
                    f"{noun} of element '{name}': all of its deformations are FIXED or PRESCRIBED, so it has no effect."
                )


def _loose(builder: Description, member: Member, numbers: list[int]) -> list[int]:
    """The given deformations that the stiffness of an element does not resist; empty if this is unknown."""
    element = member.element
    arguments: Any = element.arguments(element.stiffness, member.properties)
    starts = [builder.nodes[node].start for node in member.nodes]
    others = [element.arguments(getattr(element, kind), member.properties) for kind in ELASTIC if kind != "stiffness"]
    alone = arguments is not None and all(other is None for other in others)
    if not numbers or not alone or not is_concrete((starts, arguments)):
        return []
    companion: Any = element.stiffness
    with jax.core.eval_context():
        matrix = companion(ref=element.reference([np.asarray(start, float) for start in starts]), **(arguments or {}))
    return [n for n in numbers if not np.any(np.asarray(matrix)[n - 1])]


def _warn_of_other_numbers(builder: Description) -> None:
    """Warn of elements whose section or damping has unused numbers and lacks needed numbers."""
    used: dict[Any, set[str]] = {}
    resisted: dict[Any, Any] = {}
    reported: set[Any] = set()
    for name, member in builder.members.items():
        element = member.element
        free = tuple(i for i, role in enumerate(member.roles) if role not in HELD)
        for key in KINDS:
            numbers = member.properties.get(key)
            seen = element, id(numbers), free
            if not isinstance(numbers, Rigidity | Damping) or seen in reported or not is_concrete(numbers):
                continue
            reported.add(seen)
            stated = {entry for entry in RESISTING[key] if np.any(np.asarray(getattr(numbers, entry)) != 0)}
            if len(stated) in (0, len(RESISTING[key])):
                continue
            if (element, key) not in used:
                used[element, key] = _used(member, key)
            every = used[element, key] - _unsheared(member)
            idle, missing = stated - every, every - stated
            if missing and every & stated and 0 < len(free) < len(member.roles):
                present = frozenset(n for n, value in member.properties.items() if value is not None)
                alike = element, key, frozenset(stated), present
                if alike not in resisted:
                    resisted[alike] = _resisted(builder, member, key, [{}])
                if resisted[alike] is not None:
                    acting = [entry for entry in RESISTING[key] if entry in every & stated]
                    _warn_of_constrained(name, member, key, acting, resisted[alike][0] != 0, free)
            lacking = [entry for entry in RESISTING[key] if entry in missing] if idle else []
            lacking = [entry for entry in lacking if _is_lacked(builder, member, key, entry, free)]
            if lacking:
                unused, uses = (", ".join(entry for entry in RESISTING[key] if entry in some) for some in (idle, every))
                warn(
                    f"{key.capitalize()} of element '{name}' ({element.name}): without {', '.join(lacking)}, nothing"
                    f" {RESISTS[key]} some of its free deformations. The element uses {uses}. It does not use"
                    f" {unused}."
                )


def _unsheared(member: Member) -> set[str]:
    """Dampers of shear that a section without shear does not use."""
    section: Any = member.properties.get("section")
    if section is None or section.varies or isinstance(section, General) or not is_concrete(section):
        return set()
    rigidity = section.rigidity()
    return {f"GA{axis}" for axis in "yz" if np.asarray(getattr(rigidity, f"shear_{axis}")) == 0}


def _matrix(element: Element, key: str, numbers: Mapping[str, Any], arguments: Any, places: list[Any]):
    """Stiffness or damping of an element with other numbers."""
    companion: Any = getattr(element, KINDS[key])
    changed = dataclasses.replace(arguments[key], **numbers)
    return companion(ref=element.reference(places), **{**arguments, key: changed})


@jit_beside_options
def _diagonals(
    element: Element, key: str, numbers: list[dict[str, Any]], arguments: Any, places: list[Any]
) -> list[Float[Array, "n_e"]]:
    """Diagonals of such matrices, in one program instead of one per operation."""
    return [jnp.diagonal(_matrix(element, key, values, arguments, places)) for values in numbers]


def _used(member: Member, key: str) -> set[str]:
    """Numbers of a section or of dampers that enter a matrix of an element; none if other functions use them too."""
    element = member.element
    # Dampers only share between bending and shear by the section.
    serving = ELASTIC if key == "section" else ("damping", "dissipation")
    takes = [
        companion
        for companion in serving
        if key in (element.arguments(getattr(element, companion), member.properties) or ())
    ]
    if takes != [KINDS[key]]:
        return set()
    places = [np.zeros(len(node.start)) for node in element.nodes.values()]
    arguments = element.arguments(getattr(element, KINDS[key]), member.properties)
    matrix = functools.partial(_matrix, element, key, arguments=arguments)
    program = jax.make_jaxpr(matrix)(dict.fromkeys(RESISTING[key], 1.0), places=places).jaxpr
    # The first variables are the numbers: JAX orders a dictionary by its keys, in the order of RESISTING.
    entering = {id(variable) for equation in program.eqns for variable in equation.invars}
    return {name for name, variable in zip(RESISTING[key], program.invars, strict=False) if id(variable) in entering}


def _warn_of_constrained(
    name: str, member: Member, key: str, names: list[str], resisted: Bool[np.ndarray, "n_e"], free: tuple[int, ...]
) -> None:
    """Warn if the numbers of an element act only on constrained deformations."""
    if not np.any(resisted) or np.any(resisted[list(free)]):
        return
    numbers = [str(i + 1) for i in np.flatnonzero(resisted)]
    which = f"deformation{'s' * (len(numbers) > 1)} {', '.join(numbers)}"
    acts, has = (RESISTS[key].removesuffix("s"), "have") if names[1:] else (RESISTS[key], "has")
    warn(
        f"{key.capitalize()} of element '{name}' ({member.element.name}): {', '.join(names)} {acts} only {which}, which"
        f" {'are' if numbers[1:] else 'is'} constrained here. {', '.join(names)} {has} no effect. Release {which}, or"
        f" give a number that {RESISTS[key]} a free deformation.",
        IdleWarning,
    )


def _resisted(
    builder: Description, member: Member, key: str, numbers: list[dict[str, Any]]
) -> Float[np.ndarray, "n n_e"] | None:
    """Diagonals of a matrix of an element with changed numbers; None if not all are known."""
    starts = [builder.nodes[node].start for node in member.nodes]
    arguments = member.element.arguments(getattr(member.element, KINDS[key]), member.properties)
    if not is_concrete((starts, arguments)):
        return None
    places = [np.asarray(start, float) for start in starts]
    stated = {entry: getattr(member.properties[key], entry) for entry in RESISTING[key]}
    every = [{entry: np.asarray(value, float) for entry, value in (stated | more).items()} for more in numbers]
    # Properties other than arrays select code.
    arguments = jax.tree.map(lambda one: np.asarray(one) if isinstance(one, float) else one, arguments)
    return np.asarray(_diagonals(member.element, key, every, arguments, places))


def _is_lacked(builder: Description, member: Member, key: str, name: str, free: tuple[int, ...]) -> bool:
    """Whether a number would resist a free deformation that nothing resists."""
    value = getattr(member.properties[key], name)
    diagonals = _resisted(builder, member, key, [{name: value}, {name: value + 1.0}])
    if diagonals is None:
        return False
    without, beside = diagonals[:, list(free)]
    return bool(np.any((without == 0) & (beside != 0)))
