"""Clamped ends of leaf springs and warping beams, found from their neighbours."""

from __future__ import annotations

import contextlib
import functools
import itertools
import operator
from collections.abc import Iterable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..elements.curves import axes_of_end, curve_length
from ..elements.holes import is_holed
from ..elements.leaf import REACHES, flags_and_distances
from ..elements.section import Rigidity, Section
from ..elements.spectral_spatial import FIELDS
from ..errors import ModelError, warn
from ..model.model import Model
from ..model.topology import HELD, Role
from ..results import RESULTS, collect
from .description import Description, Member

# A part of three times the thickness clamps a leaf spring. Leaf springs at more than five degrees form a fold [rad].
# Both limits differ slightly from round numbers, so that round-off does not decide.
THICK = 3.0 * (1 - 1e-6)
FOLD = np.radians(5.0) * (1 + 1e-6)
# Largest distance at which a clamp acts, over the width.
REACH = REACHES.max()
# Number of the twist deformation of a warping beam. A leaf spring has a strain field for twist.
TWIST = 2


class End(NamedTuple):
    """An end of a leaf spring or warping beam: its rotation, and whether it is the first end (0) or the last (1)."""

    leaf: str
    rotation: str
    number: int


class Clamped(NamedTuple):
    """Whether an end is kept flat and its warping restrained; ``traced``: the same by traced numbers of the design."""

    flat: bool
    restrained: bool
    traced: tuple[Any, Any] | None = None


class _Unknown(Exception):
    """The numbers that decide whether an end is clamped are traced or missing."""


def with_clamps(builder: Description, before: Model | None) -> Description:
    """Return a builder whose leaf springs have ``clamped`` for both ends, with restrained warping FIXED.

    An end is clamped if its rotation is held, or if it joins a body, a hinge, another rigid element or a part at least
    three times as thick. At a fold, and beside a leaf spring at least three times as thick, clamps keep the section
    flat, and the leaf springs share the warping. An element with FIXED twist does not warp. A clamp also acts on leaf
    springs in line beyond it.

    Returns:
        A copy; the builder itself without leaf springs and warping beams.

    Raises:
        ModelError: The ends depend on traced numbers or on a section without sizes; two elements contradict each other.

    Source:
        THEORY.md 2, below eq. (2.26), and eq. (2.42).
    """
    leaves = [name for name, member in builder.members.items() if "clamped" in member.properties]
    if not leaves:
        return builder
    twin, joined = builder.copy(), elements_at(builder)
    flat_ends: dict[tuple[str, int], bool] = {}
    nodes: dict[str, list[tuple[Any, tuple[bool, bool] | None, bool]]] = {}
    for name in leaves:
        member = twin.members[name]
        stated = member.properties["clamped"]
        flat, restrained = [], []
        untwisted = _is_untwisted(member)
        for end in ends_of(name, member):
            was = None
            if stated is not None:
                clamped = Clamped(bool(stated[end.number]), bool(stated[end.number]))
            else:
                was = as_before(before, end)
                clamped = is_clamped(builder, end, joined, was)
            flat.append(clamped.flat)
            flat_ends[name, end.number] = clamped.flat
            restrained.append(clamped.restrained or untwisted)
            if was is not None and clamped.traced is not None and member.element.fields:
                _note_other_clamps(was[0], [clamped.traced[0]])
            for warping in member.nodes_of_kind("warping")[end.number : end.number + 1]:
                traced = None if clamped.traced is None or untwisted else clamped.traced[1]
                own = restrained[-1] if traced is None else traced
                nodes.setdefault(warping, []).append((own, was, traced is not None))
        twin.members[name] = member.with_properties(clamped=np.array(flat, float))
        for warping, is_restrained in zip(member.nodes_of_kind("warping"), restrained, strict=False):
            _hold(twin, warping, name, joined[warping], is_restrained, stated is not None and not untwisted)
    for warping, ends in nodes.items():
        was = next((was for _, was, _ in ends if was is not None), None)
        free = builder.nodes[warping].roles[0] not in HELD
        if free and was is not None and any(is_traced for *_, is_traced in ends):
            _note_other_clamps(was[1], [own for own, *_ in ends])
    _reach_in_line(builder, twin, flat_ends)
    for name in leaves:
        member = twin.members[name]
        if not member.element.fields:
            # No clamp keeps a warping beam flat. Its ``clamped`` marks ends whose warping is held, for any reason.
            constrained = [twin.nodes[warping].roles[0] in HELD for warping in member.nodes_of_kind("warping")]
            twin.members[name] = member.with_properties(clamped=np.array(constrained, float))
    return twin


def elements_at(builder: Description) -> dict[str, list[str]]:
    """Return the names of the elements at each node, in order."""
    by_node: dict[str, list[str]] = {}
    for name, member in builder.members.items():
        for node in dict.fromkeys(member.nodes):
            by_node.setdefault(node, []).append(name)
    return by_node


def ends_of(name: str, member: Member) -> list[End]:
    """Return the first end and the last of a leaf spring or warping beam."""
    return [End(name, rotation, number) for number, rotation in enumerate(member.nodes_of_kind("rotation"))]


def ends_at(builder: Description, names: Iterable[str]) -> dict[str, list[End]]:
    """Return the ends of some elements at each rotation, in order."""
    by_rotation: dict[str, list[End]] = {}
    for name in names:
        for end in ends_of(name, builder.members[name]):
            by_rotation.setdefault(end.rotation, []).append(end)
    return by_rotation


def end_at(builder: Description, name: str, rotation: str) -> End:
    """Return the end of an element at a rotation."""
    return next(end for end in ends_of(name, builder.members[name]) if end.rotation == rotation)


def opposite(builder: Description, end: End) -> End:
    """Return the other end of the element."""
    return ends_of(end.leaf, builder.members[end.leaf])[1 - end.number]


def axes_at(builder: Description, *ends: End, library: Any = np) -> list[Any]:
    """Return unit vectors along and across leaf springs at ends, as :func:`leaf_axes` finds them."""
    return [leaf_axes(builder, builder.members[end.leaf], library, end.number) for end in ends]


def _reach_in_line(builder: Description, twin: Description, flat_ends: dict[tuple[str, int], bool]) -> None:
    """Store the distances from ends to clamps beyond leaf springs in line in the properties of ``twin``."""
    leaves = [name for name, member in builder.members.items() if (name, 0) in flat_ends and member.element.fields]
    meeting = ends_at(builder, leaves)
    distances: dict[tuple[str, int], Any] = {}
    for end in itertools.chain(*meeting.values()):
        beyond, at, passed = 0.0, end, {end.leaf}
        while not flat_ends[at.leaf, at.number]:
            following = [other for other in meeting[at.rotation] if other.leaf != at.leaf]
            if len(following) != 1 or following[0].leaf in passed or is_fold(builder, at, following[0]):
                break
            passed.add(following[0].leaf)
            beyond = beyond + span_of(builder, builder.members[following[0].leaf])
            at = opposite(builder, following[0])
        sides = _sides(builder, end) or []
        known = is_concrete((beyond, sides))
        too_far = known and bool(beyond >= REACH * max(np.asarray(side).max() for side in sides))
        if at is not end and not too_far and flat_ends[at.leaf, at.number]:
            distances[end.leaf, end.number] = beyond
    for name in leaves if distances else ():
        spring = twin.members[name]
        flags = [1.0 if (name, i) in distances else flag for i, flag in enumerate(spring.properties["clamped"])]
        beyond = [distances.get((name, i), 0.0) for i in range(2)]
        library: Any = np if is_concrete(beyond) else jnp
        clamped = library.stack([library.asarray(flags, float), library.stack(list(map(library.asarray, beyond)))])
        twin.members[name] = spring.with_properties(clamped=clamped)


def is_fold(builder: Description, *ends: End) -> bool:
    """Return whether two leaf springs meet at an angle, along or across; False for traced numbers."""
    axes = axes_at(builder, *ends)
    return is_concrete(axes) and any(abs(first @ second) < np.cos(FOLD) for first, second in zip(*axes, strict=True))


def span_of(builder: Description, member: Member) -> Any:
    """Return the length of an element [m]."""
    p, q = (builder.nodes[node].start for node in member.nodes_of_kind("position")[:2])
    curvature = member.properties.get("curvature")
    library: Any = np if is_concrete((p, q)) else jnp
    chord = library.linalg.norm(library.asarray(q, float) - library.asarray(p, float))
    with known_numbers((chord, curvature)):
        return chord if curvature is None else curve_length(chord, curvature)


def _hold(builder: Description, warping: str, leaf: str, joined: list[str], restrained: bool, stated: bool) -> None:
    """Fix the warping of a node, or raise an error if another element there has an opposite ``clamped``."""
    node = builder.nodes[warping]
    for other in joined:
        if other == leaf:
            continue
        flags = builder.members[other].properties.get("clamped")
        place = builder.members[other].nodes_of_kind("warping").index(warping)
        if stated and flags is not None and bool(flags[place]) is not restrained:
            raise ModelError(
                f"Elements '{leaf}' and '{other}' share their warping at '{warping}', but only one of them is clamped"
                " there. Give both the same `clamped` (in a file: CLAMP)."
            )
    if restrained and node.roles[0] is Role.DEPENDENT:
        node.roles[0] = Role.FIXED


def as_before(before: Model | None, end: End) -> tuple[bool, bool] | None:
    """Return whether an end was flat, and its warping held, in an earlier model of the same elements."""
    if before is None:
        return None
    labels = before.labels
    x_roles, _ = before.roles()
    warping = {entry.of: role in HELD for entry, role in zip(labels.x, x_roles, strict=True) if entry.kind == "warping"}
    nodes = next((nodes for name, _, nodes in labels.elements if name == end.leaf), ())
    constrained = [warping[node] for node in nodes if node in warping]
    for block, properties in zip(before.topology.blocks, before.parameters.properties, strict=True):
        if "clamped" in properties and block.e.shape[1]:
            names = [labels.e[i].of for i in np.asarray(block.e)[:, 0].tolist()]
            if end.leaf in names:
                clamped, beyond = flags_and_distances(np.asarray(properties["clamped"])[names.index(end.leaf)])
                flat = bool(clamped[end.number] == 1 and beyond[end.number] == 0)
                return flat, bool(constrained) and constrained[end.number]
    return None


def is_clamped(
    builder: Description, end: End, joined: dict[str, list[str]], before: tuple[bool, bool] | None = None
) -> Clamped:
    """Return whether an end is kept flat, and whether its warping is restrained."""
    rotation = builder.nodes[end.rotation]
    # Three held Euler parameters determine the fourth.
    if sum(role in HELD for role in rotation.roles) >= rotation.kind.freedoms:
        return Clamped(True, True)
    flat = restrained = False
    traced = []
    # Elements without a section come first: if one of them is rigid, sections of the others may be traced.
    others = {name: builder.members[name] for name in joined[end.rotation] if name != end.leaf}
    for name, other in sorted(others.items(), key=lambda item: item[1].properties.get("section") is not None):
        if flat and restrained:
            break
        try:
            effect = _by(builder, end, name, other)
        except _Unknown as reason:
            if before is not None:
                traced.append(end_at(builder, name, end.rotation))
                continue
            raise ModelError(
                f"Element '{end.leaf}': whether '{name}' clamps its {('first', 'last')[end.number]} end cannot be"
                f" found, since {reason}. State it by clamped=(first end, last end), each True or False, or in a file"
                " by CLAMP."
            ) from None
        flat, restrained = flat or effect[0], restrained or effect[1]
    if not traced or (flat and restrained):
        return Clamped(flat, restrained)
    return Clamped(*before or (False, False), _traced(builder, end, traced, (flat, restrained)))


def _traced(builder: Description, end: End, others: list[End], known: tuple[bool, bool]) -> tuple[Any, Any] | None:
    """Whether an end is flat and restrained, with traced neighbours; None for a section without sizes."""
    leaf, (flat, restrained) = builder.members[end.leaf], known
    for beside in others:
        other, thin, thick = builder.members[beside.leaf], _sides(builder, end), _sides(builder, beside)
        if thin is None or thick is None:
            return None
        clamps: Any = jnp.min(jnp.stack(thick)) >= THICK * jnp.min(jnp.stack(thin))
        warps = False if other.element.fields and leaf.element.fields else clamps
        if "clamped" in other.properties:
            (along, across), (along_other, across_other) = axes_at(builder, end, beside, library=jnp)
            angled = jnp.abs(across @ across_other) < np.cos(FOLD)
            clamps, warps = clamps | angled, warps | angled
            flat |= jnp.abs(along @ along_other) < np.cos(FOLD)
        flat, restrained = flat | clamps, restrained | warps
    return flat, restrained


def _note_other_clamps(was: bool, flags: list[Any]) -> None:
    """Add the code ``other_clamps`` if traced numbers change whether an end is clamped."""
    clamped: Any = functools.reduce(operator.or_, flags)
    collect(jnp.where(clamped == was, RESULTS.successful, RESULTS.other_clamps))


def _by(builder: Description, end: End, name: str, other: Member) -> tuple[bool, bool]:
    """Whether one neighbour keeps an end flat, and whether it restrains the warping."""
    element, section = other.element, other.properties.get("section")
    if other.hidden:
        return element.inertia is not None, element.inertia is not None
    # The roles that a user may choose, without measured deformations.
    roles = [role for number, role in enumerate(other.roles, 1) if number not in element.measured]
    if section is None or all(role in HELD for role in roles):
        constrained = any(role in HELD for role in roles)
        return constrained, constrained
    if is_holed(section):
        # The strip goes on beside the hole.
        return False, False
    leaf, beside = builder.members[end.leaf], end_at(builder, name, end.rotation)
    thick = _is_thick(builder, end, beside)
    # Leaf springs in line share their warping, at any ratio of thicknesses.
    if "clamped" not in other.properties or (thick and not (element.fields and leaf.element.fields)):
        return thick, thick
    axes = axes_at(builder, end, beside)
    if not is_concrete(axes):
        if thick:
            return True, False
        raise _Unknown(
            "it depends on where they are, and these numbers are traced (fm.sensitivities, fm.sweep and fm.tune"
            " know them)"
        )
    (along, across), (along_other, across_other) = axes
    if abs(across @ across_other) < np.cos(FOLD):
        warn(
            f"Elements '{end.leaf}' and '{name}' meet with their widths at an angle. flexmb assumes that they clamp"
            " each other. State by `clamped` whether they do."
        )
        return True, True
    return thick or bool(abs(along @ along_other) < np.cos(FOLD)), False


def _is_untwisted(member: Member) -> bool:
    """Whether an element with warping coordinates has FIXED twist, and thus no warping."""
    if not member.nodes_of_kind("warping"):
        return False
    fields = member.element.fields
    twist = fields[FIELDS.index("GIt")] if fields else (TWIST,)
    return all(member.roles[number - 1] is Role.FIXED for number in twist)


def _is_thick(builder: Description, end: End, beside: End) -> bool:
    """Whether an end of another element is thick enough to clamp an end of a leaf spring."""
    if _equally_thick(*(builder.members[at.leaf].properties["section"] for at in (end, beside))):
        return False
    thin, thick = _sides(builder, end), _sides(builder, beside)
    if thin is None or thick is None:
        raise _Unknown("its section is given by numbers and has no thickness")
    if not is_concrete((thin, thick)):
        raise _Unknown(
            "it depends on how thick they are, and these numbers are traced (fm.sensitivities, fm.sweep and fm.tune"
            " know them)"
        )
    return bool(min(map(np.asarray, thick)) >= THICK * min(map(np.asarray, thin)))


def _equally_thick(first: Section, other: Section) -> bool:
    """Whether two sections are the same object, or rigidities of equal numbers, and thus equally thick."""
    if first is other:
        return not first.varies
    if not (isinstance(first, Rigidity) and isinstance(other, Rigidity) and is_concrete((first, other))):
        return False
    values, others = (list(map(float, jax.tree.leaves(section))) for section in (first, other))
    return values == others


def _sides(builder: Description, end: End) -> list[Any] | None:
    """Sides of a section at an end of an element; None for a section without sides."""
    member = builder.members[end.leaf]
    beam_section, length = member.properties["section"], span_of(builder, member)
    with known_numbers(beam_section):
        section: Section = beam_section.at(float(end.number), float(length) if is_concrete(length) else 1.0)
    section = getattr(section, "outline", None) or section
    sides = [getattr(section, name) for name in ("width", "thickness", "diameter") if hasattr(section, name)]
    return sides or None


def section_at(builder: Description, member: Member, place: float) -> Any:
    """Return the section at a place of an element, from 0 to 1."""
    section, length = member.properties["section"], span_of(builder, member)
    with known_numbers((section, length)):
        return section.at(float(place), float(length) if is_concrete(length) else length)


def known_numbers(numbers: Any) -> contextlib.AbstractContextManager[Any]:
    """Return a context in which known numbers stay known while other numbers are traced."""
    return jax.ensure_compile_time_eval() if is_concrete(numbers) else contextlib.nullcontext()


def leaf_axes(builder: Description, member: Member, library: Any = np, end: int | None = None) -> Any:
    """Return unit vectors along a leaf spring and along its width; with NumPy, traced inputs as they are.

    Args:
        end: The first end (0) or the last (1). Default: the line between both ends.
    """
    p, q = (builder.nodes[node].start for node in member.nodes_of_kind("position"))
    y, curvature = member.properties.get("y"), member.properties.get("curvature")
    given = (p, q, y) if end is None else (p, q, y, curvature)
    if library is np and not is_concrete(given):
        return given
    if end is not None and curvature is not None:
        y = None if y is None else jnp.asarray(y, float)
        with known_numbers((p, q, y, curvature)):
            axes = axes_of_end(curvature, jnp.asarray(q, float) - jnp.asarray(p, float), y, end)
        return tuple(library.asarray(axis) for axis in axes)
    p, q = library.asarray(p, float), library.asarray(q, float)
    if p.size == 2:
        return (q - p) / library.linalg.norm(q - p), np.ones(1)
    along = (q - p) / library.linalg.norm(q - p)
    y = np.arange(3.0) == library.argmin(library.abs(along)) if y is None else library.asarray(y, float)
    across = y - (y @ along) * along
    return along, across / library.linalg.norm(across)
