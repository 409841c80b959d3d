"""Spectral beam in the plane, with or without shear; common code is in ``spectral``."""

import functools
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import block_diag
from jaxtyping import Array, Float

from ..math.quadrature import gauss, legendre_coefficients
from ..math.rotation import cosine_and_sine, rotation_plane
from . import beams
from .curves import CurvedLine, curved_length, tilt_of, turned_to
from .element import Element
from .leaf_ends import IN_PLANE, jumps
from .nodes import Angle, Point2, Reference, Series2, Static
from .section import Scalar
from .sections import Damping, Section
from .spectral import (
    WHOLE,
    BeamPieces,
    check_curvature,
    check_section,
    check_shear,
    fields_after,
    pieces_of,
    rigidities,
    section_rigidities,
    series_matrix,
    strains,
    thermal_series,
)

# Fields in the order of the coefficients.
ELONGATION, CURVATURE, SHEAR = 0, 1, 2
FIELDS = ("EA", "EIy", "GAz")
# Deformations that join the end of the beam to node q.
CLOSURE = 3


def _rule(
    order: int, shear: bool, section: Section | None, length: Float[Array, ""], end: Float[Array, ""] | None = None
) -> SimpleNamespace:
    """Quadrature along the beam, to a place or to its last end, with the strains at its nodes and their integrals."""
    if end is None and (section is None or not section.varies):
        return _constant_rule(order, shear)
    rule = _rule_on(order, shear, section, length, pieces_of(section, length, end))
    if getattr(section, "ends", None) is not None:
        at_ends: Any = jumps(section, order, length, FIELDS[: _count(shear)])
        rule.jumps = IN_PLANE @ at_ends
    return rule


@functools.cache
def _constant_rule(order: int, shear: bool) -> SimpleNamespace:
    rule = _rule_on(order, shear, None, 1.0, WHOLE)
    # Only the first coefficient of the curvature contributes to the angle between the ends.
    rule.turn = np.eye(order)[0]
    return rule


def gauss_nodes(order: int) -> int:
    """Return the number of Gauss nodes in each smooth piece of a beam."""
    return 2 * order + 8


def _rule_on(order: int, shear: bool, section: Section | None, length: Any, pieces: BeamPieces) -> SimpleNamespace:
    nodes, weights = gauss(gauss_nodes(order))
    places = pieces.spread(nodes).ravel()
    shapes = strains(order, section, places, length, FIELDS[: _count(shear)])
    along = pieces.integrals(nodes, weights)
    weights = (pieces.sizes[:, None] * weights).ravel()
    curvatures = shapes[:, CURVATURE]
    terms = {"elongations": shapes[:, ELONGATION], "angles": along @ curvatures, "turn": weights @ curvatures}
    terms["shears"] = shapes[:, SHEAR] if shear else None
    return SimpleNamespace(pieces=pieces, inner=nodes, nodes=places, weights=weights, along=along, **terms)


def _count(shear: bool) -> int:
    """Number of strain fields."""
    return 3 if shear else 2


def _fields_of(c: Float[Array, "c"], rule: SimpleNamespace) -> Float[Array, "fields order"]:
    """Coefficients of each field."""
    return c.reshape(-1, rule.angles.shape[1])


def _stretched_along(
    c: Float[Array, "c"], length: Float[Array, ""], rule: SimpleNamespace, directions: Float[Array, "n 2"]
) -> Float[Array, "n 2"]:
    """Derivative of the position by the place at the nodes: along the normals of the sections, and across by shear."""
    fields = _fields_of(c, rule)
    slopes = (length + rule.elongations @ fields[ELONGATION])[:, None] * directions
    if rule.shears is None:
        return slopes
    across = jnp.stack([-directions[:, 1], directions[:, 0]], axis=-1)
    return slopes + (rule.shears @ fields[SHEAR])[:, None] * across


def _length(ref: Reference, curvature: Scalar | CurvedLine | None) -> Float[Array, ""]:
    return curved_length(beams.beam_length(ref), curvature)


def _bent(
    c: Float[Array, "c"],
    length: Float[Array, ""],
    curvature: Scalar | CurvedLine | None,
    s: Float[Array, "n"] | np.ndarray,
    integrals: Float[Array, "n order"] | np.ndarray,
) -> Float[Array, "n 2"]:
    """Directions at places s, in axes of end p."""
    angle = integrals @ c.reshape(-1, integrals.shape[1])[CURVATURE]
    if curvature is not None:
        angle = angle + turned_to(curvature, length, s)
    return jnp.stack(cosine_and_sine(angle), axis=-1)


def _jumps(c: Float[Array, "c"], rule: SimpleNamespace) -> Any:
    """Displacement and angle that each end adds to the line; None without compliant ends."""
    return rule.jumps @ c if hasattr(rule, "jumps") else None


def _line(
    rot_p: Angle,
    c: Float[Array, "c"],
    ref: Reference,
    order: int,
    shear: bool,
    section: Section | None,
    curvature: Scalar | CurvedLine | None,
):
    """Length, axes of end p as columns, stretched directions at the nodes in these axes, and quadrature rule."""
    length, tilt = _length(ref, curvature), 0.0
    rule = _rule(order, shear, section, length)
    if curvature is not None:
        tilt = tilt_of(curvature, length)
    x = rotation_plane(rot_p[0] - ref.rot_p[0] - tilt) @ ((ref.q - ref.p) / beams.beam_length(ref))
    axes = jnp.stack([x, jnp.stack([-x[1], x[0]])], axis=1)
    directions = _bent(c, length, curvature, rule.nodes, rule.angles)
    stretched = _stretched_along(c, length, rule, directions)
    if (at_ends := _jumps(c, rule)) is not None:
        stretched = stretched @ rotation_plane(at_ends[0, 2]).T
    return length, axes, stretched, rule


def _to_place(
    c: Float[Array, "c"],
    length: Float[Array, ""],
    order: int,
    shear: bool,
    section: Section | None,
    curvature: Scalar | CurvedLine | None,
    place: Float[Array, ""],
):
    """Direction at a place, and vector from p to this place, in axes of end p."""
    rule = _rule(order, shear, section, length, place)
    directions = _bent(c, length, curvature, rule.nodes, rule.angles)
    last = _bent(c, length, curvature, place[None], rule.turn[None])[0]
    way = rule.weights @ _stretched_along(c, length, rule, directions)
    if (at_ends := _jumps(c, rule)) is not None:
        turn = rotation_plane(at_ends[0, 2])
        last, way = turn @ last, at_ends[0, :2] + turn @ way
    return last, way


def _spectral_beam(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref: Reference,
    order: Static[int] = 5,
    shear: Static[bool] = False,
    section: Section | None = None,
    curvature: float | CurvedLine | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients."""
    _, axes, stretched, rule = _line(rot_p, c, ref, order, shear, section, curvature)
    displacement = axes.T @ (q - p) - rule.weights @ stretched
    turn = (rot_q - ref.rot_q) - (rot_p - ref.rot_p) - rule.turn @ _fields_of(c, rule)[CURVATURE]
    if (at_ends := _jumps(c, rule)) is not None:
        length = _length(ref, curvature)
        x, y = rotation_plane(at_ends[0, 2]) @ _bent(c, length, curvature, np.ones(1), rule.turn[None])[0]
        displacement = displacement - at_ends[0, :2] - jnp.array([[x, -y], [y, x]]) @ at_ends[1, :2]
        turn = turn - jnp.sum(at_ends[:, 2])
    return jnp.concatenate([jnp.concatenate([displacement, turn]), c])


def _fields(*, order: int, shear: bool):
    return fields_after(3, _count(shear), order)


def _stiffness(*, ref, section, order, shear, curvature=None):
    return series_matrix(section, section, order, _length(ref, curvature), 3, FIELDS[: _count(shear)])


def _damping(*, ref, damping: Damping, order, shear, section=None, curvature=None):
    return series_matrix(damping, section, order, _length(ref, curvature), 3, FIELDS[: _count(shear)])


def _stretched(
    turn: Float[Array, ""],
    c: Float[Array, "c"],
    ref: Reference,
    length: Float[Array, ""],
    rule: SimpleNamespace,
    curvature: Scalar | CurvedLine | None,
):
    """Directions times the stretch at the nodes of a beam turned from its reference, (n, 2)."""
    angle = turn + rule.angles @ _fields_of(c, rule)[CURVATURE]
    if curvature is not None:
        angle = angle + turned_to(curvature, length, rule.nodes) - tilt_of(curvature, length)
    x = (ref.q - ref.p) / beams.beam_length(ref)
    cosine, sine = cosine_and_sine(angle)
    directions = cosine[:, None] * x + sine[:, None] * jnp.stack([-x[1], x[0]])
    return _stretched_along(c, length, rule, directions)


def _inertia(*nodes: Array, ref, section, order, shear=False, curvature=None):
    """Vectors whose weighted sums are the positions and angles at the nodes, and their mass matrix H.

    The vectors are the position of end p and the stretched directions at the nodes, then the turn of end p and the
    coefficients of curvature, padded by zeros.
    """
    p, rot_p, *_, c = nodes
    length = _length(ref, curvature)
    rule = _rule(order, shear, section, length)
    turn = rot_p - ref.rot_p
    angle = turn[0] if (at_ends := _jumps(c, rule)) is None else turn[0] + at_ends[0, 2]
    stretched = _stretched(angle, c, ref, length, rule, curvature)
    if at_ends is not None:
        p = p + _line(rot_p, c, ref, order, shear, section, curvature)[1] @ at_ends[0, :2]
        turn = turn + at_ends[0, 2]
    turns = jnp.concatenate([turn, _fields_of(c, rule)[CURVATURE]])
    masses = rigidities(section, rule.nodes, length, ("mass", "Jy")) * (length * rule.weights)[:, None]
    sums = [
        (matrix.T * masses[:, k]) @ matrix for k, matrix in enumerate((_with_ones(rule.along), _with_ones(rule.angles)))
    ]
    vectors = jnp.concatenate([p[None], stretched, jnp.stack([turns, jnp.zeros_like(turns)], axis=1)])
    return vectors, block_diag(*sums)


def _with_ones(integrals: Float[Array, "n k"] | np.ndarray) -> Float[Array, "n 1+k"]:
    """Weights of positions or angles at the nodes: 1 for end p, then integrals from end p."""
    return jnp.concatenate([jnp.ones((integrals.shape[0], 1)), jnp.asarray(integrals)], axis=1)


def _turn(lever: Float[Array, "*n 2"], force: Float[Array, "*n 2"]):
    """Moment of forces in the plane, counter-clockwise."""
    return lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]


def _resultants(*nodes: Array, ref, place, sigma, section, order, shear=False, fall=None, curvature=None):
    """Section resultants at a place by statics of the part beyond it."""
    p, rot_p, q, _, c = nodes
    length, axes, stretched, rule = _line(rot_p, c, ref, order, shear, section, curvature)
    (cosine, sine), reached = _to_place(c, length, order, shear, section, curvature, place)
    # Force and moment about p of the part beyond the place, counter-clockwise, in axes of end p.
    force, moment = jnp.split(sigma[:3], (2,))
    wrench = jnp.append(force, moment + _turn(axes.T @ (q - p), force))
    if fall is not None:
        masses = rigidities(section, rule.nodes, length, ("mass", "Jy")) * length
        n = masses.shape[0] + 1
        pulls = masses[:, :1] * ((fall[0] + rule.along @ fall[1:n]) @ axes)
        turning = masses[:, 1] * (_with_ones(rule.angles) @ fall[n:, 0])
        levers = rule.along @ stretched
        if (at_ends := _jumps(c, rule)) is not None:
            levers = levers + at_ends[0, :2]
        moments = _turn(levers, pulls) + turning
        loads = jnp.concatenate([pulls, moments[:, None]], axis=1).reshape(-1, len(rule.inner), 3)
        wrench = wrench + rule.pieces.beyond(legendre_coefficients(rule.inner), loads, place)
    (x, y), bending = wrench[:2], wrench[2] - _turn(reached, wrench[:2])
    # The y axis of the section points into the plane: a moment about it turns clockwise.
    zero = jnp.zeros_like(x)
    return jnp.stack([cosine * x + sine * y, zero, cosine * y - sine * x, zero, -bending, zero])


def _thermal(change: Array, gradient: Array, *, ref, section, order, shear, curvature=None):
    """Thermal elongation and curvature; the warmer side becomes longer."""
    bends = {"EIy": -gradient[0]}
    return thermal_series(change, bends, section, order, _length(ref, curvature), 3, FIELDS[: _count(shear)])


def _shape(*nodes: Array, ref, place, order, shear=False, section=None, curvature=None):
    p, rot_p, *_, c = nodes
    length, axes, *_ = _line(rot_p, c, ref, order, shear, section, curvature)
    return p + axes @ _to_place(c, length, order, shear, section, curvature, place)[1]


def _end_pose(*nodes: Array, ref, order, shear, section=None, curvature=None):
    """Pose of end q relative to end p."""
    c = nodes[-1]
    length = _length(ref, curvature)
    rule = _rule(order, shear, section, length)
    stretched = _stretched(-ref.rot_p[0], c, ref, length, rule, curvature)
    return rule.weights @ stretched, ref.rot_q - ref.rot_p + rule.turn @ _fields_of(c, rule)[CURVATURE]


def _check(*, ref, order, shear, section=None, curvature=None) -> list[str]:
    faults = beams.check_length(ref=ref) or check_curvature(ref, curvature)
    faults = faults or check_section(section, ref, curvature, gauss_nodes(order))
    if section is None or faults:
        return faults
    return check_shear(shear, section_rigidities(section, ref, curvature).shear_z)


spectral_beam = Element(
    _spectral_beam,
    stiffness=_stiffness,
    damping=_damping,
    inertia=_inertia,
    resultants=_resultants,
    thermal=_thermal,
    shape=_shape,
    passage=_end_pose,
    check=_check,
    series=_fields,
    lengths=(ELONGATION, SHEAR),
    names=("closure_x", "closure_y", "closure_tilt", "elongation", "curvature", "shear"),
)
"""Geometrically exact beam; one element models a whole leaf spring in beam theory.

Deformations:
    1 to 3: the closure at q, FIXED: two displacements in axes of end p [m], and the angle [rad]. Their stress
        resultants are the force and moment at q.
    From 4 on: ``order`` coefficients of each strain, times length: elongation [m], then curvature [rad], then, with
        ``shear``, shear [m]. The first coefficient of the curvature is the angle between the ends.

Properties:
    section: EA, EIy, mass and Jy. It may vary, see :class:`flexmb.sections.Profile`.
    damping: Viscous damping of the section.
    curvature: Curvature of the undeformed beam [1/m], positive counter-clockwise. A number is an arc from p to q.
        Otherwise it is a function of the place, or :func:`flexmb.sections.curvature_through`.

Options: order, the number of coefficients of each strain, default 5; shear, whether shear deformation is counted,
default False. Order 2 bends like a cubic beam. Order 5 computes a leaf spring at a large stroke to six digits. With
shear the section must have a shear compliance.

The beam neglects the plate behaviour near clamps and the flattening of wide strips; use ``planar.leaf_spring`` for
them. If shear would change a stiffness by more than 1 %, flexmb warns.

Source: strains of the extensible elastica; theta(s) = integral of the curvature, r' = (1 + eps) t + gamma n with
t = (cos theta, sin theta), n normal to it (Reissner).
"""
