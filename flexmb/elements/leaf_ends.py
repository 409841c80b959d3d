"""Compliances of the ends of a leaf spring: skew cuts, steps in width or thickness, and elastic roots.

Each compliance relates the six resultants at an end to a small motion of this end, (6, 6). It may be negative: a skew
clamp holds a part of the leaf spring. Each compliance therefore acts on a zone of the leaf spring near its end. The
resultants at the end are fitted to the strains of this zone, which has no loads.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, holds
from ..compilation.record import Record
from ..math.quadrature import gauss, legendre_values
from .roots import STRETCHED, bent_spread, spreading_length
from .sections import Rectangle
from .spectral import relative, rigidities

# Order of the resultants N, Vy, Vz, T, My, Mz, named by their rigidities, and of the six motions of an end.
FIELDS = ("EA", "GAy", "GAz", "GIt", "EIy", "EIz")
# Signs of resultants and motions after half a turn about z.
TURNED = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])
# Signs of a compliance at the first end and at the last.
SIGNS = np.stack([np.ones((6, 6)), np.outer(TURNED, TURNED)])
# Motions in the plane by the six motions: along, to the left, and minus the rotation about the section's y axis.
IN_PLANE = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 0, -1, 0]])
# Places of both ends.
ENDS = np.array([0.0, 1.0])
# Order of a screw motion: rotation first.
SCREW = np.eye(6)[[3, 4, 5, 0, 1, 2]]
# Length of the zone of an end: ZONE times the width, but at most HALF of the length of the leaf spring.
ZONE, HALF = 1.0, 0.5
# The zone of an elastic root is this share of the zone of a cut, since a root acts at the end itself.
AT_ROOT = 0.05
# Mean distance from a skew end, over the width, of the part that the clamp holds in bending: the ratio of the terms
# VzMy and MyMy of (2.48), from 0.11 at small angles to 0.15 at 30 degrees.
HELD_AT = 0.13
# Limit of the angles of skew cuts, just below a right angle [rad].
STEEPEST = np.radians(89.0)
# The fits of skew cuts are polynomials in Poisson's ratio minus this number.
USUAL = 0.3
# Terms of a skew cut by row and column: power n and rigidity of the unit w^n/rigidity, powers of tan(angle), and their
# coefficients, in rows by powers of nu - 0.3. THEORY.md 2, eq. (2.48).
EVEN, ODD = (2, 4, 6), (1, 3, 5)
SKEW = {
    (2, 4): (2, "EIy", EVEN, ((-0.0409, -0.0248, 0.0054), (-0.0230, 0.0060, 0), (-0.0950, 0.0150, 0))),
    (2, 2): (3, "EIy", EVEN, ((0.0038, -0.0173, 0.0017), (-0.0073, -0.0007, 0), (-0.0775, 0.0075, 0))),
    (2, 3): (2, "EIy", ODD, ((-0.0265, 0.0272, -0.0058), (-0.0798, 0.0003, 0), (0.0395, -0.0145, 0))),
    (3, 3): (1, "EIy", EVEN, ((-0.0889, -0.0145, 0.0064), (-0.1842, 0.0397, 0), (-0.0675, 0.0225, 0))),
    (3, 4): (1, "EIy", ODD, ((0.1649, -0.0742, 0.0204), (-0.1403, 0.0363, 0), (-0.1209, 0.0509, 0))),
    (4, 4): (1, "EIy", EVEN, ((-0.3697, 0.1180, -0.0278), (0.0913, -0.0308, 0), (0.0675, -0.0225, 0))),
    (0, 0): (1, "EA", EVEN, ((0.0802, -0.1416, 0.0417), (0.2998, -0.1208, 0), (0.0975, -0.0675, 0))),
    (0, 1): (1, "EA", ODD, ((0.1012, -0.3495, 0.0920), (0.3669, -0.1784, 0), (0.0894, -0.0344, 0))),
    (0, 5): (2, "EIz", ODD, ((0.0920, -0.0300, 0.0073), (0.0295, -0.0080, 0), (-0.0105, 0.0055, 0))),
    (1, 1): (3, "EIz", EVEN, ((-0.0796, 0.0270, -0.0086), (-0.0687, 0.0217, 0), (-0.0175, 0.0075, 0))),
    (1, 5): (2, "EIz", EVEN, ((-0.0198, 0.0419, -0.0093), (-0.0153, 0.0053, 0), (0.0175, -0.0075, 0))),
    (5, 5): (1, "EIz", EVEN, ((-0.2705, 0.0604, -0.0120), (0.0153, -0.0053, 0), (0.0275, -0.0375, 0))),
}
# Coefficients, (terms, powers of nu - 0.3 from 0, powers of tan(angle) from 1).
COEFFICIENTS = np.stack([np.array(row[3]) @ np.eye(6)[np.array(row[2]) - 1] for row in SKEW.values()])
# Terms of a step in width by row and column: power n and rigidity of the unit w^n/rigidity.
STEP = {
    (0, 0): (1, "EA"),
    (3, 3): (1, "GIt"),
    (4, 4): (1, "EIy"),
    (2, 4): (2, "EIy"),
    (2, 2): (3, "EIy"),
    (5, 5): (1, "EIz"),
    (1, 5): (2, "EIz"),
    (1, 1): (3, "EIz"),
}
# 1 for the terms of a step in width from membrane stress, bending and twist (columns), (terms, 3).
KINDS = np.array(
    [[rigidity in kind for kind in (("EA", "EIz"), ("EIy",), ("GIt",))] for _, rigidity in STEP.values()], float
)
# 1 for the terms of a step in thickness, (terms, 2): from spreading in tension (column 0) and in bending (column 1).
THICKNESS = np.array([[place in ((0, 0), (5, 5)), place == (4, 4)] for place in STEP], float)


# Stiffnesses of the roots at the first end and at the last; None for a rigid root. In space: along and about local x,
# y, z. In the plane: along, to the left and about the normal.
Roots = tuple[Float[Array, "6"] | None, Float[Array, "6"] | None]
PlanarRoots = tuple[Float[Array, "3"] | None, Float[Array, "3"] | None]


class Ends(Record):
    """Skew cuts, elastic roots and steps at both ends of a leaf spring; None for each kind that is absent.

    Attributes:
        skew: Angles of the cuts, (2,) [rad].
        clamp: Stiffnesses of the roots at both ends, each (6,), (3,) in the plane, or None for a rigid root.
        beside: Widths (row 0) and thicknesses (row 1) in line beyond both ends, (2, 2) [m]; own sizes without a step.
    """

    skew: Any = None
    clamp: Any = None
    beside: Any = None


def ends_of(skew: Any, clamp: Any, clamped: Any) -> Ends | None:
    """Return cuts, roots and steps of a leaf spring; None if both ends are straight and rigid, without steps."""
    beside = clamped[2:] if clamped is not None and clamped.shape[0] > 2 else None
    return None if skew is None and clamp is None and beside is None else Ends(skew, clamp, beside)


def skew_compliance(angle: Any, rectangle: Rectangle) -> Float[Array, "6 6"]:
    """Return the compliance that a skew cut of the first end adds to a straight clamp in the middle of the cut.

    Args:
        angle: Angle of the cut, () [rad]. At a positive angle the edge at +y begins further along local x.
        rectangle: Section at the end.

    Returns:
        Displacements and rotations of the end under N, Vy, Vz, T, My, Mz, (6, 6).

    Source:
        THEORY.md 2, eq. (2.48): fits to solid elements for angles up to 50 degrees and nu from 0.2 to 0.4.
    """
    slope, change = jnp.tan(jnp.asarray(angle, float)), rectangle.material.poisson() - USUAL
    square = slope * slope
    odd = jnp.stack([slope, slope * square, slope * square**2])
    powers = jnp.stack([odd, slope * odd], axis=1).reshape(6)
    by_nu = COEFFICIENTS[:, 0] + change * COEFFICIENTS[:, 1] + change**2 * COEFFICIENTS[:, 2]
    return _matrix_of_terms(SKEW, by_nu @ powers, rectangle)


def _matrix_of_terms(
    terms: dict[tuple[int, int], tuple[Any, ...]], numbers: Any, rectangle: Rectangle
) -> Float[Array, "6 6"]:
    """Symmetric matrix whose entries are numbers, (terms,), times the unit w^n/rigidity of each term."""
    rigidity, width = rectangle.rigidity(), rectangle.width
    kinds = list(dict.fromkeys(row[:2] for row in terms.values()))
    units = jnp.stack([jnp.asarray(width**power / getattr(rigidity, kind), float) for power, kind in kinds])
    spots = np.zeros((len(terms), 6, 6))
    for k, (i, j) in enumerate(terms):
        spots[k, i, j] = spots[k, j, i] = 1.0
    chosen = np.eye(len(kinds))[[kinds.index(row[:2]) for row in terms.values()]]
    return jnp.tensordot(numbers * (chosen @ units), spots, 1)


def step_compliance(width: Any, thickness: Any, rectangle: Rectangle) -> Float[Array, "6 6"]:
    """Return the compliance that a wider or thicker part in line before the first end adds; zero for other parts.

    Args:
        width: Width of the part in line, () [m].
        thickness: Thickness of the part in line, () [m].
        rectangle: Section of the leaf spring.

    Returns:
        Displacements and rotations of the end under N, Vy, Vz, T, My, Mz, (6, 6).

    Source:
        THEORY.md 2, eq. (2.49) to (2.51), and (2.70): fits to solid elements, narrow/wide from 0.2, nu from 0.2 to 0.4.
    """
    rigidity, nu, w = rectangle.rigidity(), rectangle.material.poisson(), jnp.asarray(rectangle.width, float)
    a = w / width
    stretched, sideways = STRETCHED * spreading_length(a), bent_spread(a)
    bent = (1 + nu) / (3 + nu) * spreading_length(a)
    # Parts that share their warping are stiffer than parts that warp freely, to which the fit refers.
    shared = (1 - a) ** 2 / (1 + a**2) * jnp.sqrt(rigidity.EIw / rigidity.GIt) / w
    twisted = 0.985 * 2 / (3 + nu) * spreading_length(a) + jnp.where(a < 1, shared, 0.0)
    inside = 0.142 + 0.095 / a
    in_width = [
        stretched,
        twisted,
        bent,
        -bent * inside,
        bent * 0.1 * a ** (-5 / 3),
        sideways,
        sideways * (0.0445 - 0.455 * a**2),
        sideways * 0.034 * (1 / a - 1),
    ]
    # A load that spreads through the thickness causes no strain along the width: plane strain.
    b = rectangle.thickness / thickness
    root = (1 - nu**2) * jnp.asarray(rectangle.thickness, float) / w
    in_thickness = root * jnp.stack([STRETCHED * spreading_length(b), bent_spread(b)])
    # The wide part deforms. A narrow part that is thicker stays straight and leaves less to the wide part.
    over = jnp.maximum(b - 1, 0.0)
    softer = KINDS @ jnp.stack([b, b**3 * (1 - 0.5 * (over / b) ** 2), b**1.5 + 1.4 * over**3])
    numbers = softer * jnp.stack([jnp.asarray(number, float) for number in in_width])
    return _matrix_of_terms(STEP, numbers + THICKNESS @ in_thickness, rectangle)


def root_compliance(stiffness: Any) -> Float[Array, "6 6"]:
    """Return the compliance of an elastic root from six stiffnesses, or from three in the plane, (6, 6)."""
    compliance = 1 / jnp.asarray(stiffness, float)
    if compliance.shape[0] == 3:
        return jnp.diag(jnp.abs(IN_PLANE.T) @ compliance)
    return jnp.diag(compliance)


def cuts(leaf: Any, length: Any) -> Any:
    """Return the compliances of the skew cuts of both ends of a leaf spring, in axes of the end sections, (2, 6, 6)."""
    return jax.vmap(lambda place, sign, angle: sign * skew_compliance(angle, leaf.rectangle(place, length)))(
        ENDS, SIGNS, leaf.ends.skew
    )


def compliances(leaf: Any, length: Any) -> list[tuple[float, Float[Array, "2 6 6"]]]:
    """Return the compliances of steps and roots at both ends of a leaf spring, in axes of the end sections.

    Returns:
        Factor on the length of the zone, and the compliances of both ends. Steps come first, then roots. An absent
        kind has no entry.
    """
    clamp, beside, parts = leaf.ends.clamp, leaf.ends.beside, []
    if beside is not None:
        steps = jax.vmap(lambda place, sizes: step_compliance(sizes[0], sizes[1], leaf.rectangle(place, length)))
        parts.append((1.0, SIGNS * steps(ENDS, beside.T)))
    if clamp is not None:
        roots = [jnp.zeros((6, 6)) if root is None else root_compliance(root) for root in clamp]
        parts.append((AT_ROOT, jnp.stack(roots)))
    return parts


def _rigidities(leaf: Any, length: Any, names: Sequence[str]) -> dict[str, Any]:
    """Resultant times length over coefficient, by the rigidity of each field; constant along the leaf spring."""
    section = leaf.plain()
    values = rigidities(section if section.varies else leaf.rectangle(0.0, length), jnp.zeros(1), length, names)[0]
    if section.varies:
        values = values * relative(section, jnp.zeros(1), length, names)[0]
    # In the plane a positive curvature bends to the left, opposite to the section's y axis.
    signs = {"EIy": 1.0 if "GIt" in names else -1.0}
    return {name: signs.get(name, 1.0) * values[i] for i, name in enumerate(names)}


def _torque(layer: Any, order: int, places: Any) -> Float[Array, "n order"]:
    """Torque at places by each coefficient of twist, over the torque by the first coefficient.

    The functions of (2.24) that decay from the ends cause no torque. Source: THEORY.md 2, eq. (2.66).

    Args:
        layer: Distance over which twist builds up at the end, over the length, () [-].
        places: Distances from the end over the length, (n,) [-].
    """
    twice = np.zeros((order, order))
    for k in range(2, order):
        # Second derivatives by the place, which goes from 0 to 1.
        twice[: k - 1, k] = 4 * np.polynomial.legendre.legder(np.eye(k + 1)[k], 2)
    return legendre_values(order, places) @ (np.eye(order) - layer**2 * twice)


def end_resultants(leaf: Any, order: int, length: Any, names: Sequence[str], share: float) -> Float[Array, "2 6 c"]:
    """Return the resultants at both ends by the coefficients of a leaf spring.

    The zone of an end has no loads, so forces are constant there and moments are linear. The fit to the strains of this
    zone minimises the elastic energy of the difference. Source: THEORY.md 2, eq. (2.47).

    Args:
        names: Rigidities of the strain fields, in order.
        share: Factor on the length of the zone, see :func:`compliances`.
    """
    stiff = {name: number / length for name, number in _rigidities(leaf, length, names).items()}
    nodes, weights = gauss(order // 2 + 3)
    tests = np.stack([weights, weights * nodes])
    none, spots = jnp.zeros((len(names), order)), np.eye(len(names))[:, :, None]
    layers = jnp.stack(leaf.layers(length)) if "GIt" in names else ENDS
    # The weight is zero at both ends of the zone: the energy then bounds the mean torque.
    mean_torque = weights * 6 * nodes * (1 - nodes)

    def at_end(place: Any, turned: Any, alternating: Any, layer: Any):
        zone = share * jnp.minimum(ZONE * leaf.rectangle(place, length).width, HALF * length)
        shapes = legendre_values(order, zone / length * nodes) * alternating
        mean, first = tests @ shapes
        placed = {name: stiff[name] * spots[i] for i, name in enumerate(names)}
        rows = {name: placed[name] * mean if name in names else none for name in FIELDS}
        if "GIt" in names:
            # The torque is a mean value: its zone may be longer than half of the leaf spring.
            far = share * jnp.minimum(ZONE * leaf.rectangle(place, length).width, length)
            rows["GIt"] = placed["GIt"] * (mean_torque @ _torque(layer, order, far / length * nodes) * alternating)
        for bend, shear, sign in (("EIy", "GAz", 1.0), ("EIz", "GAy", -1.0)):
            if bend not in names:
                continue
            # The distance from an end grows along the leaf spring at the first end, and against it at the last.
            sign, ratio, moment = sign * turned, 0.0, placed[bend] * mean
            slope = sign * placed[bend] * first
            if shear in names:
                ratio = jnp.abs(stiff[bend]) / (stiff[shear] * zone**2)
                slope = slope + ratio * zone * placed[shear] * mean
            rows[shear] = (slope - sign / 2 * moment) / ((1 / 12 + ratio) * zone)
            rows[bend] = ((1 / 3 + ratio) * moment - sign / 2 * slope) / (1 / 12 + ratio)
        return jnp.stack([rows[name].reshape(-1) for name in FIELDS])

    signs = np.array([1.0, -1.0])
    resultants = jax.vmap(at_end)(ENDS, signs, signs[:, None] ** np.arange(order), layers)
    return jnp.pad(resultants, ((0, 0), (0, 0), (0, 2 if "GIt" in names else 0)))


def jumps(leaf: Any, order: int, length: Any, names: Sequence[str]) -> Float[Array, "2 6 c"] | None:
    """Return displacements and rotations of the line at both ends, by the coefficients, in axes of the ends.

    Returns None without steps and roots.
    """
    end_compliances = compliances(leaf, length)
    moved = [matrix @ end_resultants(leaf, order, length, names, share) for share, matrix in end_compliances]
    return sum(moved[1:], moved[0]) if moved else None


def spread_cuts(leaf: Any, order: int, steps: Any, length: Any, names: Sequence[str]) -> Float[Array, "s 3 6 c"]:
    """Return the strains that skew cuts add at the three Gauss nodes of each step, times length.

    Returns stretch, shears, twist and curvatures by the coefficients, (s, 3, 6, c) [-]. Over a step, they have the same
    moments as the weights of (2.67).

    Args:
        steps: Sizes of the steps over the length of the leaf spring, (s,).
    """
    motions = cuts(leaf, length) @ end_resultants(leaf, order, length, names, 1.0)
    ends = jnp.cumsum(jnp.asarray(steps))
    starts = ends - steps
    layers = jnp.stack(leaf.layers(length))

    def of_end(place: Any, motion: Any, layer: Any):
        held = HELD_AT * leaf.rectangle(place, length).width / length
        within = jnp.stack([jnp.abs(place - ends), jnp.abs(place - starts)])
        turned = 1 - 2 * place
        weights = [_weights(jnp.min(within, axis=0), jnp.max(within, axis=0), mean, turned) for mean in (held, layer)]
        # The same motion, seen from the middle of the part where it arises.
        away = turned * held * length
        moved = motion.at[2].add(-away * motion[4]).at[1].add(away * motion[5])
        twisted = np.arange(6)[:, None] == 3
        return sum(
            weight[:, :, None, None] * jnp.where(chosen, moved, 0.0)
            for weight, chosen in zip(weights, (~twisted, twisted), strict=True)
        )

    return jnp.sum(jax.vmap(of_end)(ENDS, motions, layers), axis=0)


def _weights(near: Any, far: Any, mean: Any, turned: Any) -> Float[Array, "s 3"]:
    """Weights at the three Gauss nodes of steps whose sum along the leaf spring is 1 and whose mean distance is given.

    The weight is 12 x (1 - x)^2 of the distance x over 2.5 times the mean distance.

    Args:
        near: Distances of the nearer ends of the steps from an end of the leaf spring, over its length, (s,).
        far: Distances of the farther ends, (s,).
        mean: Mean distance, () [-].
        turned: 1 at the first end, -1 at the last.
    """
    reach = 2.5 * mean
    nodes, weights = gauss(3)
    sizes = jnp.minimum(far, reach) - jnp.minimum(near, reach)
    x = (jnp.minimum(near, reach)[:, None] + sizes[:, None] * nodes) / reach
    whole = jnp.where(far > near, far - near, 1.0)[:, None]
    # Places within the steps count from their first ends.
    inside = 0.5 + turned * ((x * reach - near[:, None]) / whole - 0.5)
    share = 12 * x * (1 - x) ** 2 / reach * weights * sizes[:, None] / whole
    back = legendre_values(3, nodes) * (2.0 * np.arange(3) + 1)
    return jnp.einsum("gk,snk,sn->sg", back, legendre_values(3, inside.reshape(-1)).reshape(*inside.shape, 3), share)


def ends_matrix(leaf: Any, order: int, length: Any, names: Sequence[str]) -> Float[Array, "c c"]:
    """Return the matrix that the ends add to the stiffness matrix of a leaf spring. Source: THEORY.md 2, eq. (2.47)."""
    total, parts = jnp.zeros(()), compliances(leaf, length)
    if leaf.ends.skew is not None:
        parts.append((1.0, cuts(leaf, length)))
    for share, matrix in parts:
        resultants = end_resultants(leaf, order, length, names, share)
        total = total + jnp.einsum("eic,eij,ejd->cd", resultants, matrix, resultants)
    return total


def free_of_jumps(leaf: Any, order: int, length: Any, names: Sequence[str], free: Array, matrix: Array) -> Array:
    """Return the thermal coefficients of a free leaf spring, corrected for the compliances of its ends.

    Free thermal strains cause no stress, so the ends must add no motion. The correction puts the last end at the place
    that the thermal strains alone determine, to first order.

    Args:
        free: Coefficients of the thermal strains, (fields order,).
        matrix: Stiffness matrix of the leaf spring with its ends, (c, c).
    """
    if order < 2:
        # A linear moment needs two coefficients.
        return free
    stiff = _rigidities(leaf, length, names)
    columns = []
    for force, bend, sign in (("EA", "", 0), ("GIt", "", 0), ("GAy", "EIz", 1.0), ("GAz", "EIy", -1.0)):
        column = np.zeros((len(names), order))
        if force in names:
            column = jnp.asarray(column).at[names.index(force), 0].set(length / stiff[force])
        if bend in names:
            # A force at the last end causes a linear moment, zero there; a moment causes a constant moment.
            spot = np.zeros((len(names), order))
            spot[names.index(bend), 0] = 1.0
            columns.append(length / stiff[bend] * spot)
            spot = np.zeros((len(names), order))
            spot[names.index(bend), :2] = sign / 2, -sign / 2
            column = column + length**2 / stiff[bend] * spot
        if force in names or bend in names:
            columns.append(column)
    flat = jnp.stack([jnp.asarray(column, float).reshape(-1) for column in columns], axis=1)
    flat = jnp.pad(flat, ((0, matrix.shape[0] - free.shape[0]), (0, 0)))
    added = ends_matrix(leaf, order, length, names) @ jnp.pad(free, (0, matrix.shape[0] - free.shape[0]))
    less = flat @ jnp.linalg.solve(flat.T @ matrix @ flat, flat.T @ added)
    return free - less[: free.shape[0]]


def faults_of_ends(skew: Any, clamp: Any) -> list[str]:
    """Return the faults of the cuts and roots of a leaf spring."""
    if skew is not None and not holds(abs(as_floats(skew)) < STEEPEST):
        return [
            "has an end that is cut along its length: angles of `skew` count from a straight cut, in radians, below"
            " pi/2"
        ]
    if any(root is not None and not holds(as_floats(root) > 0) for root in clamp or ()):
        return ["has a root without stiffness: the stiffnesses of `clamp` must be positive"]
    return []
