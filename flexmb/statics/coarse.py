"""Warnings about deformations that are too large for accurate results, or larger than needed to reach a position."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from ..arguments import is_concrete
from ..checks.mobility import allowed_motions, constraints
from ..display import listed, short
from ..elements.curves import curvature_at
from ..elements.leaf import leaf_of
from ..elements.sections import Rectangle
from ..elements.spectral_spatial import FIELDS
from ..errors import BeamTheoryWarning, CoarseWarning, warn
from ..mechanics.stress_resultants import is_nonlinear, known_stiffness_pieces
from ..model.model import Model
from ..model.topology import coordinate_scales
from ..numerical_limits import (
    COARSE_ANGLE,
    FINE_TWIST_ORDER,
    LONGEST_CUT,
    LONGEST_STROKE,
    MOST_TWIST,
    NEEDLESS_ENERGY,
    ROUND_OFF,
    STRETCHED_BEAM,
    WIDEST_BENT,
)
from .solver_choice import LARGE

# Number of elements or deformations named in a warning.
NAMED = 3
# Index of the last point among the nodes of a leaf spring.
LAST = 3
# Warnings of leaf springs at strokes, by the stroke over the length. The errors are beside solid elements.
CUT_TEXT = "wide skew cuts at a stroke of {:.2g} of the length. Stiffnesses may be 16 % off. Compare them yourself."
TWIST_TEXT = (
    "initial twist at a stroke of {:.2g} of the length. The stiffness across the stroke may be 57 % off where it has a"
    " minimum. Compare it yourself."
)
ROUGH_TWIST_TEXT = (
    "initial twist at a stroke of {:.2g} of the length. The stiffness across the stroke may be 15 % too high. Use"
    f" order={FINE_TWIST_ORDER}."
)


def warn_of_coarse(model: Model, e: Any) -> None:
    """Warn of cubic beams that are bent, twisted or stretched too far, and of leaf springs that are bent too far.

    Leaf springs with skew cuts or initial twist have a smaller limit (BeamTheoryWarning).

    ``e`` are deformations, (*times, n_e). The check skips traced deformations and values that are not finite. A
    stretched cubic beam bends with EI (1 + strain)^2: THEORY.md 2, below eq. (2.10).
    """
    blocks = [block for block in model.topology.blocks if block.element.angles and "deformation" in block.companions]
    leaves = _leaf_springs(model)
    if not (blocks or leaves) or not is_concrete((model.parameters.reference, e)):
        return
    e = np.array(e).reshape(-1, model.topology.n_e)
    e[~np.isfinite(e)] = 0.0
    # Most states have no loads.
    if not e.any():
        return
    _warn_of_bent(model, leaves, e)
    _warn_of_strokes(model, leaves, e)
    e = np.abs(e)
    reference, dims = np.asarray(model.parameters.reference), len(model.topology.axes)
    constrained = np.concatenate([np.asarray(model.topology.e.fixed), np.asarray(model.topology.e.prescribed)])
    turned: dict[str, float] = {}
    stretched: dict[str, float] = {}
    for block in blocks:
        angles = np.asarray(block.e)[:, np.array(block.element.angles) - 1]
        largest = e[:, angles].max(axis=(0, 2), initial=0.0)
        # Both ends have the same kinds of nodes, points first.
        ends, second = np.asarray(block.x), block.splits[len(block.splits) // 2]
        chords = reference[ends[:, second : second + dims]] - reference[ends[:, :dims]]
        squares = (chords * chords).sum(axis=1)
        for i in np.flatnonzero(largest * largest > COARSE_ANGLE**2 * squares):
            turned[str(model.labels.e[angles[i, 0]].of)] = float(largest[i] / np.sqrt(squares[i]))
        if number := block.element.number_of("elongation"):
            strains = e[:, np.asarray(block.e)[:, number - 1]].max(axis=0, initial=0.0) / np.sqrt(squares)
            for i in np.flatnonzero((strains > STRETCHED_BEAM) & ~np.isin(angles, constrained).all(axis=1)):
                stretched[str(model.labels.e[angles[i, 0]].of)] = float(strains[i])
    if turned:
        advice = "Use spectral beams" if turned.keys() & stretched.keys() else "Use more beams, or spectral ones"
        warn(
            f"{_named(turned)}: an end turns by up to {max(turned.values()):.2g} rad against the chord, or twists by"
            f" this angle against the other end. Beyond {COARSE_ANGLE} rad the error of one beam is 3 % or more if"
            f" twisted, and 6 % if bent. {advice}.",
            CoarseWarning,
        )
    if stretched:
        largest = max(stretched.values())
        warn(
            f"{_named(stretched)}: the strain along the beam reaches {largest:.2g}. Cubic beams bend with EI (1 +"
            f" strain)^2 instead of EI: an error of about {2 * largest:.0%}, for any number of beams. Use spectral"
            " beams.",
            CoarseWarning,
        )


def _leaf_springs(model: Model) -> list[tuple[Any, dict[str, Any]]]:
    """Blocks of leaf springs in space with known numbers, and their properties."""
    pairs = zip(model.topology.blocks, model.parameters.properties, strict=True)
    return [
        (block, properties)
        for block, properties in pairs
        if "clamped" in properties and len(block.element.fields) == len(FIELDS)
        if properties["section"] is not None and is_concrete(properties)
    ]


def _warn_of_bent(model: Model, leaves: list[tuple[Any, dict[str, Any]]], e: np.ndarray) -> None:
    """Warn of leaf springs whose u of (2.56) at an end exceeds the range compared with solid elements."""
    bent: dict[str, float] = {}
    reference = np.asarray(model.parameters.reference)
    for block, properties in leaves:
        numbers = np.asarray(block.e)[:, np.array(block.element.fields[FIELDS.index("EIy")]) - 1]
        odd = (-1.0) ** np.arange(numbers.shape[1])
        points = np.split(reference[np.asarray(block.x)], block.splits, axis=1)
        lengths = np.linalg.norm(points[LAST] - points[0], axis=1)
        widths, thicknesses, nu, softer = _at_ends(properties["section"], lengths)
        curves = np.stack([e[:, numbers] @ odd, e[:, numbers].sum(axis=2)], axis=2) * softer / lengths[:, None]
        initial = _initial(properties, np.array([0.0, 1.0]))
        curves = np.abs(curves if initial is None else curves + initial[:, :, 1]).max(axis=0)
        u = np.max(np.sqrt(np.sqrt(3 * (1 - nu**2)) * curves / thicknesses) * widths, axis=1)
        for i in np.flatnonzero(u > WIDEST_BENT):
            bent[str(model.labels.e[numbers[i, 0]].of)] = float(u[i])
    if bent:
        warn(
            f"{_named(bent)}: bent far for its width, u = {max(bent.values()):.3g} in THEORY.md, eq. (2.23). Sideways"
            f" stiffness of a bent leaf spring was compared with solid elements up to u = {WIDEST_BENT:g}. Make it"
            " narrower or thicker, or compare it yourself.",
            CoarseWarning,
        )


def _at_ends(section: Any, lengths: np.ndarray) -> list[np.ndarray]:
    """Widths, thicknesses, Poisson's ratios, and local over mean compliance in bending, at both ends, (elements, 2)."""
    if isinstance(section, Rectangle):
        # Without a first compilation.
        sizes = section.width, section.thickness, section.material.poisson()
        return [np.broadcast_to(np.asarray(size).reshape(-1, 1), (len(lengths), 2)) for size in sizes] + [np.ones(2)]

    def at_ends(section: Any, length: Any) -> Any:
        leaf = leaf_of(section, None)
        rectangles = [leaf.rectangle(place, length) for place in (0.0, 1.0)]
        sizes = [[r.width, r.thickness, r.material.poisson()] for r in rectangles]
        softer = leaf.plain().relative(jnp.array([0.0, 1.0]), length, ("EIy",))
        return jnp.concatenate([jnp.array(sizes).T, softer.T])

    return list(np.moveaxis(np.asarray(jax.vmap(at_ends)(section, lengths)), 1, 0))


def _initial(properties: dict[str, Any], places: np.ndarray) -> np.ndarray | None:
    """Initial twist and curvatures of leaf springs at places, (elements, places, 3) [1/m]; None if straight."""
    if properties.get("curvature") is None:
        return None
    return np.asarray(jax.vmap(lambda curvature: curvature_at(curvature, places))(properties["curvature"]))


def _warn_of_strokes(model: Model, leaves: list[tuple[Any, dict[str, Any]]], e: np.ndarray) -> None:
    """Warn of leaf springs with wide skew cuts or initial twist at strokes."""
    far: dict[str, dict[str, float]] = {}
    reference = np.asarray(model.parameters.reference)
    for block, properties in leaves:
        points = np.split(reference[np.asarray(block.x)], block.splits, axis=1)
        lengths = np.linalg.norm(points[LAST] - points[0], axis=1)
        bending = block.element.fields[FIELDS.index("EIy")]
        # A single coefficient has no second one.
        first, second = (np.asarray(block.e)[:, bending[min(k, len(bending) - 1)] - 1] for k in range(2))
        # Displacement of an end from the tangent at the other end, over the length: integrals of the curvature.
        strokes = np.max(np.abs(e[:, first]) / 2 + np.abs(e[:, second]) / 6, axis=0, initial=0.0)
        of_twist = TWIST_TEXT if block.element.options["order"] >= FINE_TWIST_ORDER else ROUGH_TWIST_TEXT
        initial = _initial(properties, np.linspace(0, 1, 21))
        twists = 0 * lengths if initial is None else lengths * np.mean(np.abs(initial[:, :, 0]), axis=1)
        for text, is_odd in (
            (CUT_TEXT, _cut_lengths(properties, lengths) > LONGEST_CUT),
            (of_twist, twists > MOST_TWIST),
        ):
            for i in np.flatnonzero(is_odd & (strokes > LONGEST_STROKE)):
                far.setdefault(text, {})[str(model.labels.e[first[i]].of)] = float(strokes[i])
    for text, strokes in far.items():
        warn(f"{_named(strokes)}: {text.format(max(strokes.values()))}", BeamTheoryWarning)


def _cut_lengths(properties: dict[str, Any], lengths: np.ndarray) -> np.ndarray:
    """Distances along leaf springs between both edges of their skew cuts, the sum of both ends, over the lengths."""
    if properties.get("skew") is None:
        return np.zeros(len(lengths))

    widths = _at_ends(properties["section"], lengths)[0]
    return np.sum(np.abs(np.tan(np.asarray(properties["skew"]))) * widths, axis=1) / lengths


def _named(sizes: dict[str, float]) -> str:
    """Names of elements, in descending order of their values."""
    names = sorted(sizes, key=lambda name: -sizes[name])
    more = f", and {len(names) - NAMED} more" if len(names) > NAMED else ""
    which = listed([f"'{name}'" for name in names[:NAMED]])
    return f"Element{'s' * (len(names) > 1)} {which}{more}"


def needless_strain(
    model: Model, e: Float[np.ndarray, "n_e"], kept: Bool[np.ndarray, "n_q"]
) -> tuple[float, float, list[str]] | None:
    """Elastic energy, its minimum with some degrees of freedom kept, and names of the deformations that would relax.

    None for large mechanisms, nonlinear laws, and elements with stress-free deformations. By least squares in the
    motions of the undeformed mechanism (THEORY.md 4 and 8), exact only for small deformations.
    """
    topology, parameters = model.topology, model.parameters
    shaped = parameters.strain is not None or parameters.loads.temperature is not None
    if topology.n_x > LARGE or is_nonlinear(topology) or shaped or not np.any(e):
        return None
    roots = np.zeros((topology.n_e, topology.n_e))
    for at, _, stiffness in known_stiffness_pieces(topology, parameters):
        values, turned = np.linalg.eigh(np.asarray(stiffness))
        blocks = np.sqrt(np.maximum(values, 0.0))[:, :, None] * np.swapaxes(turned, 1, 2)
        place = np.asarray(at)
        roots[place[:, :, None], place[:, None, :]] += blocks
    energy = 0.5 * float(np.sum((roots @ e) ** 2))
    if not energy > 0:
        return None
    constraint_set = constraints(model)
    motions, _ = allowed_motions(model, constraint_set)
    changes = constraint_set.jacobian @ motions
    x_dof, e_dof = np.asarray(topology.x.dof), np.asarray(topology.e.dof)
    rows = np.concatenate([motions[x_dof], changes[e_dof]])[kept]
    _, sizes, right = np.linalg.svd(rows, full_matrices=True)
    free = changes @ right[int(np.sum(sizes > 1e-9)) :].T / constraint_set.rows[:, None]
    weighted = roots @ free
    scale = np.linalg.norm(weighted, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    relaxing = np.linalg.lstsq(weighted / scale, -(roots @ e), rcond=1e-13)[0] / scale
    relaxed = e + free @ relaxing
    least = 0.5 * float(np.sum((roots @ relaxed) ** 2))
    moved = np.abs(relaxed - e)[e_dof] * np.sqrt(np.sum(roots[:, e_dof] ** 2, axis=0))
    order = [i for i in np.argsort(-moved) if not kept[len(x_dof) + i]]
    return energy, least, [str(model.labels.e[e_dof[i]]) for i in order[:NAMED]]


def warn_of_needless_strain(model: Model, e: Float[np.ndarray, "n_e"], where: str, remedy: str) -> None:
    """Warn if zero degrees of freedom keep elements from their least strained shape; ``where`` begins the sentence."""
    # Round-off of large turns is no strain.
    extent = np.max(np.asarray(coordinate_scales(model.topology, model.parameters)), initial=0.0)
    e = np.where(np.abs(e) > ROUND_OFF * max(extent, 1.0), e, 0.0)
    dof = np.asarray(model.topology.e.dof)
    kept_freedoms = np.concatenate([np.ones(len(model.topology.x.dof), bool), e[dof] != 0])
    needless = None if np.all(kept_freedoms) else needless_strain(model, e, kept_freedoms)
    if needless is not None and needless[0] > NEEDLESS_ENERGY * needless[1]:
        energy, least, names = needless
        warn(
            f"{where} elements store {short(energy)} J, but {short(least)} J would suffice: degrees of freedom that are"
            f" zero at the start, such as {listed(names)}, stretch other elements. {remedy}"
        )


def warn_of_stressed_start(model: Model, remedy: str) -> None:
    """Warn if elements with another stress-free shape are stressed where the nodes were placed."""
    strain = model.parameters.strain
    if strain is not None and is_concrete(strain) and np.any(np.asarray(strain)):
        warn(
            "The motion starts from the positions of the nodes. Elements with a strain or an imperfection are stressed"
            f" there. {remedy}"
        )
