"""Steps in width and thickness between leaf springs in line, and warnings about skew cuts, steps and roots."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..arguments import holds, is_concrete, nan_if_refused
from ..compilation.compile import jit
from ..elements.leaf import REACHES, flags_and_distances, leaf_of
from ..elements.sections import Rectangle
from ..elements.spectral_spatial import FIELDS
from ..errors import BeamTheoryWarning, ModelError, warn
from ..model.topology import HELD
from ..numerical_limits import SAME_SIZE
from .clamps import FOLD, THICK, End, axes_at, ends_at, ends_of, is_clamped, is_fold, opposite, section_at, span_of
from .description import Description, Member

# Ranges compared with solid elements: angle of cuts [rad], Poisson's ratio, narrow over wide part; least length over
# width of skew leaf springs and of parts beside a step; thickness of the narrow over that of the wide part.
SKEWEST, NUS, NARROWEST = np.radians(50.0) * (1 + 1e-9), (0.2 - 1e-9, 0.4 + 1e-9), 0.2 * (1 - 1e-9)
SHORTEST_SKEW, SHORTEST_PART, THICKER = 1.5 * (1 - 1e-9), 0.8 * (1 - 1e-9), 5.0 * (1 + 1e-9)


def with_steps(described: Description, builder: Description) -> Description:
    """Add the sizes beyond both ends to leaf springs that continue in line with another width or thickness.

    Ends that another part clamps have no step.

    Args:
        described: Copy of the builder, with ``clamped`` of its leaf springs; its properties are replaced.
        builder: The builder of the caller.

    Returns:
        ``described``. Leaf springs without a step do not change.

    Source:
        THEORY.md 2, eq. (2.49) to (2.51).
    """
    leaves = {name: member for name, member in builder.members.items() if _may_step(member)}
    steps: dict[str, dict[int, tuple[Any, Any]]] = {}
    for ends in ends_at(builder, leaves).values():
        for end, other in (ends, ends[::-1]) if len(ends) == 2 else ():
            sizes = _size_beyond(builder, end, other)
            if sizes is not None and not is_fold(builder, *ends) and _goes_on(described, builder, end, other):
                steps.setdefault(end.leaf, {})[end.number] = _unless_fold(builder, sizes, end, other)
    for name, sizes in steps.items():
        member = described.members[name]
        own = [_sizes(builder, leaves[name], number) for number in range(2)]
        rows = [sizes.get(number) or own[number] for number in range(2)]
        library: Any = np if is_concrete((rows, own, member.properties["clamped"])) else jnp
        beside = library.asarray(rows, float).T
        clamped = member.properties["clamped"]
        flags = clamped if clamped.ndim == 2 else np.stack([clamped, np.zeros(2)])
        # The curvature across a thicker part is smaller by the cube of the thicknesses: the end is partly flat.
        widths, thicknesses = library.asarray(own, float).T
        partly = 1 - library.minimum(thicknesses / beside[1], 1.0) ** 3
        # Unless the user states what clamps the ends, or a clamp beyond has a larger effect.
        if leaves[name].properties["clamped"] is None:
            reach = REACHES.max() * widths
            prevails = partly * reach >= flags[0] * reach - flags[1]
            flags = library.where(prevails, library.stack([partly, 0 * partly]), flags)
        described.members[name] = member.with_properties(clamped=library.concatenate([flags, beside]))
    return described


def _may_step(member: Member) -> bool:
    properties = member.properties
    is_leaf = bool(member.element.fields) and "clamped" in properties
    return is_leaf and isinstance(properties["section"].at(0.5, 1.0), Rectangle)


def _sizes(builder: Description, member: Member, number: int) -> tuple[Any, Any]:
    """Width and thickness at an end [m]."""
    section = section_at(builder, member, number)
    return section.width, section.thickness


def _size_beyond(builder: Description, end: End, other: End) -> tuple[Any, Any] | None:
    """Width and thickness of the leaf spring beyond an end; None for equal sizes."""
    leaf, following = builder.members[end.leaf], builder.members[other.leaf]
    if leaf.properties["section"] is following.properties["section"] and not leaf.properties["section"].varies:
        return None
    (width, thickness), (wide, thick) = _sizes(builder, leaf, end.number), _sizes(builder, following, other.number)
    known = is_concrete((width, thickness, wide, thick))
    if known and abs(wide / width - 1) < SAME_SIZE and abs(thick / thickness - 1) < SAME_SIZE:
        return None
    return wide, thick


def _goes_on(described: Description, builder: Description, end: End, other: End) -> bool:
    """Whether no part clamps an end, except a thick leaf spring in line."""
    if (stated := builder.members[end.leaf].properties["clamped"]) is not None:
        return stated[end.number] == 0
    flags, distances = flags_and_distances(described.members[end.leaf].properties["clamped"])
    if is_concrete((flags, distances)) and (flags[end.number] == 0 or distances[end.number] > 0):
        return True
    others = [name for name, member in builder.members.items() if end.rotation in member.nodes and name != other.leaf]
    return not is_clamped(builder, end, {end.rotation: others}, (True, True)).flat


def _unless_fold(builder: Description, sizes: tuple[Any, Any], *ends: End) -> tuple[Any, Any]:
    """Return the sizes beyond an end, or its own sizes if traced directions meet at an angle."""
    if is_concrete(axes_at(builder, *ends)):
        return sizes
    axes = axes_at(builder, *ends, library=jnp)
    in_line = jnp.all(jnp.stack([jnp.abs(first @ second) >= np.cos(FOLD) for first, second in zip(*axes, strict=True)]))
    end_sizes = _sizes(builder, builder.members[ends[0].leaf], ends[0].number)
    beyond, before = (jnp.where(in_line, size, at_end) for size, at_end in zip(sizes, end_sizes, strict=True))
    return beyond, before


def warn_of_ends(described: Description) -> None:
    """Warn of skew cuts and steps outside the ranges of their fits, with the name of the leaf spring.

    Args:
        described: Builder from :func:`with_steps`.

    Raises:
        ModelError: A leaf spring is too short for its skew cuts: its stiffness is not positive definite.
    """
    for name, member in described.members.items():
        if not _may_step(member) or not is_concrete(member.properties):
            continue
        clamped: Any = member.properties["clamped"]
        skew = member.properties.get("skew")
        stepped = clamped is not None and len(clamped) > 2
        if skew is None and not stepped:
            continue
        if not is_concrete(length := span_of(described, member)):
            continue
        sizes = np.array([_sizes(described, member, number) for number in range(2)], float)
        lengths = [_length_of_part(described, name, number) for number in range(2)]
        faults = []
        if skew is not None:
            # At folds and beside thick leaf springs an end is flat, but warps.
            rigid = [described.nodes[node].roles[0] in HELD for node in member.nodes_of_kind("warping")]
            rigid = np.array(rigid) & (np.atleast_2d(np.asarray(clamped))[0] != 0)
            faults = _about_skew(np.asarray(skew, float), sizes[:, 0], min(lengths), rigid)
            if member.properties["curvature"] is not None and np.any(np.asarray(skew)):
                faults.append("cuts at an angle and curvature together")
        if stepped:
            faults += _about_steps(np.asarray(clamped)[2:].T, sizes, lengths)
        nu = float(member.properties["section"].at(0.5, 1.0).material.poisson())
        if not NUS[0] <= nu <= NUS[1]:
            faults.append(f"Poisson's ratio of its material is {nu:.3g}, and fits hold from 0.2 to 0.4")
        if faults:
            warn(
                f"Element '{name}' has ends that differ from solid elements or were not compared with them:"
                f" {'; '.join(faults)}.",
                BeamTheoryWarning,
            )
        if skew is not None and float(_least(member, float(length))) < 0:
            raise ModelError(
                f"Element '{name}' is too short for its skew cuts: its stiffness cannot be computed. Make it longer, or"
                " use solid elements."
            )


def _about_skew(angles: np.ndarray, widths: np.ndarray, length: float, rigid: np.ndarray) -> list[str]:
    faults = []
    if np.any((angles != 0) & ~rigid):
        faults.append("an end that is cut at an angle, but not held by a rigid clamp")
    if (steepest := float(np.max(np.abs(angles)))) > SKEWEST:
        faults.append(f"a cut of {np.degrees(steepest):.3g} degrees, and fits hold up to 50")
    if length < SHORTEST_SKEW * np.max(widths) and np.any(angles):
        faults.append(
            f"it is {length / np.max(widths):.2g} times as long as wide, and fits of skew cuts hold from 1.5 on"
        )
    return faults


def _about_steps(beside: np.ndarray, sizes: np.ndarray, lengths: list[float]) -> list[str]:
    faults = []
    for (wide, thick), (width, thickness), length in zip(beside, sizes, lengths, strict=True):
        share, ratio = width / wide, thick / thickness
        if share < NARROWEST:
            faults.append(f"a step to {1 / share:.3g} times its width, and fits hold up to 5")
        if abs(share - 1) > SAME_SIZE:
            wide_over_narrow = ratio if share < 1 else 1 / ratio
            # A wide part that clamps the narrow part deforms little, at any length.
            if length < SHORTEST_PART * width and wide_over_narrow < THICK:
                faults.append(
                    f"beside a step it is {length / width:.2g} times as long as wide, and fits hold from 0.8 on"
                )
            if wide_over_narrow < 1 / THICKER:
                faults.append("a step in width where the narrow part is more than 5 times as thick as the wide part")
    return list(dict.fromkeys(faults))


def _length_of_part(described: Description, name: str, number: int) -> float:
    """Length of the part beside an end: a leaf spring and its neighbours of equal size in line [m]."""
    length, passed, at = 0.0, {name}, ends_of(name, described.members[name])[1 - number]
    while True:
        member = described.members[at.leaf]
        length += float(span_of(described, member))
        if at.leaf != name and len(member.properties["clamped"]) > 2:
            return length
        leaves = [leaf for leaf, other in described.members.items() if leaf not in passed and _may_step(other)]
        others = ends_at(described, leaves).get(at.rotation, [])
        if len(others) != 1 or not is_concrete(described.members[others[0].leaf].properties):
            return length
        if is_fold(described, at, others[0]) or _size_beyond(described, at, others[0]) is not None:
            return length
        passed.add(others[0].leaf)
        at = opposite(described, others[0])


def nan_if_not_stiff(described: Description) -> Description:
    """Return the builder with NaN for traced skew cuts that a build with numbers refuses."""
    twin = described
    for name, member in described.members.items():
        if not _may_step(member) or member.properties.get("skew") is None:
            continue
        length = span_of(described, member)
        if is_concrete((member.properties, length)):
            continue
        with nan_if_refused() as marked:
            holds(_least(member, length) >= 0)
            skew = marked(jnp.asarray(member.properties["skew"], float))
        twin = twin.copy() if twin is described else twin
        twin.members[name] = member.with_properties(skew=skew)
    return twin


def _least(member: Member, length: Any) -> Any:
    """Return the least eigenvalue of the scaled stiffness matrix of a leaf spring and its ends."""
    properties = {name: member.properties[name] for name in ("section", "clamped", "curvature", "skew", "clamp")}
    return _least_of(properties, length, order=member.element.options["order"])


@jit
def _least_of(own: dict[str, Any], length: Array, order: int) -> Array:
    own, length = jax.lax.stop_gradient((own, length))
    leaf = leaf_of(own["section"], own["clamped"], own["curvature"], own["skew"], own["clamp"])
    matrix = leaf.matrix(None, order, length, FIELDS)
    strained = matrix[: len(FIELDS) * order, : len(FIELDS) * order]
    scale = jnp.sqrt(jnp.abs(jnp.diag(strained)))
    return jnp.linalg.eigvalsh(strained / jnp.outer(scale, scale))[0]
