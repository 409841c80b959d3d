"""Spectral beam in space, with or without shear; common code is in ``spectral``."""

from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.linear import multiplied
from ..math.quadrature import gauss, legendre_coefficients, legendre_values, lobatto
from ..math.rigid import Chain, chain, compose_turns, screw_line, screws
from ..math.rotation import CONJUGATE, CROSS, initial_frame, rotation_matrix, turned
from . import beams
from .curves import CurvedLine, curvature_at, curved_length, pose_steps, turns_of_ends
from .element import Element
from .general import General
from .leaf import Leaf
from .leaf_ends import SCREW, jumps, spread_cuts
from .nodes import Point3, Reference, Rotation3, Series3, Static
from .sections import Damping, Section
from .spectral import (
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

# Rigidities of the fields, the last two only with shear. Places of their strains in a six-vector of twist, curvatures,
# stretch and shears.
FIELDS = ("EA", "GIt", "EIy", "EIz", "GAy", "GAz")
PLACES = np.eye(6)[[3, 0, 1, 2, 4, 5]]
# Gauss nodes of a step with smooth strains that are not polynomials.
DENSE = 8


def _rule(
    order: int, shear: bool, section: Section | None, length: Float[Array, ""], end: Float[Array, ""] | None = None
) -> SimpleNamespace:
    """Quadrature along the beam to a place or to its last end; each step is one exponential of the pose."""
    if isinstance(section, Leaf):
        # Strains have small jumps within steps. The values at three Gauss nodes reproduce their moments.
        plain = _rule(order, shear, None, length, end)
        basis = section.moments(order, plain.lengths, length, FIELDS)
        rule = SimpleNamespace(**vars(plain) | {"basis": jnp.einsum("sgfo,fx->sgxo", basis, PLACES)})
        if section.ends is None:
            return rule
        if (at_ends := jumps(section, order, length, FIELDS)) is not None:
            rule.jumps = SCREW @ (at_ends if end is None else at_ends[:1])
        if section.ends.skew is not None:
            rule.basis = rule.basis + SCREW @ spread_cuts(section, order, plain.lengths, length, FIELDS)
        return rule
    # Steps in each piece.
    pieces, steps = pieces_of(section, length, end), pose_steps(order)
    ends, weights = lobatto(steps + 1)
    lengths = np.diff(ends)
    # Three Gauss nodes in each step, or one for constant strains. A varying section uses DENSE nodes first: the strains
    # at three nodes then have the same moments.
    varies = section is not None and section.varies
    nodes, quadrature = gauss(DENSE if varies else 3 if order > 1 else 1)
    places = pieces.spread((ends[:-1, None] + lengths[:, None] * nodes).ravel()).ravel()
    names = _names(shear)
    shapes = strains(order, section, places, length, names).reshape(-1, len(nodes), len(names), order)
    if varies:
        moments = (2.0 * np.arange(3) + 1)[:, None] * legendre_values(3, nodes).T * quadrature
        shapes = jnp.einsum("gk,kn,snfo->sgfo", legendre_values(3, gauss(3)[0]), moments, shapes)
    sizes = (pieces.sizes[:, None] * lengths).ravel()
    basis = np.einsum if isinstance(shapes, np.ndarray) else jnp.einsum
    basis = basis("sgfo,fx->sgxfo", shapes, PLACES[: len(names)])
    # Nodes of the mass move slightly inside the pieces, since adjacent pieces share their ends.
    masses = pieces.spread(np.clip(ends, 1e-9, 1 - 1e-9)).ravel()
    return SimpleNamespace(
        pieces=pieces,
        lengths=sizes,
        basis=basis,
        nodes=masses,
        inner=ends,
        weights=(pieces.sizes[:, None] * weights).ravel(),
        # Indices of the poses at the ends of the steps of each piece; adjacent pieces share a pose.
        ends=np.add.outer(steps * np.arange(pieces.sizes.shape[0]), np.arange(steps + 1)).ravel(),
    )


def _names(shear: bool) -> tuple[str, ...]:
    """Rigidities of the strain fields."""
    return FIELDS if shear else FIELDS[:4]


def _length(ref: Reference, curvature: Float[Array, "3"] | CurvedLine | None, order: int) -> Float[Array, ""]:
    return curved_length(beams.beam_length(ref), curvature, pose_steps(order))


def _frames(
    rot_p: Rotation3,
    rot_q: Rotation3,
    ref: Reference,
    y: Float[Array, "3"] | None,
    curvature: Float[Array, "3"] | CurvedLine | None,
    length: Float[Array, ""],
    order: int,
):
    """Section axes at both ends, as columns."""
    frame = initial_frame(ref.p, ref.q, y)
    at_p, at_q = turned(rot_p, ref.rot_p, frame), turned(rot_q, ref.rot_q, frame)
    if curvature is None:
        return at_p, at_q
    first, last = turns_of_ends(curvature, length, pose_steps(order))
    return at_p @ rotation_matrix(first).T, at_q @ rotation_matrix(last)


def _poses(c: Float[Array, "c"], length: Float[Array, ""], rule: SimpleNamespace, curvature: Any) -> Chain:
    """Poses at the ends of the steps, relative to the first end; with compliant ends also the poses beyond them."""
    rates = (rule.basis.reshape(-1, c.size) @ c).reshape(rule.basis.shape[:3]) / length + np.eye(6)[3]
    if curvature is None and rule.basis.shape[1] == 1:
        # Constant strains are one screw motion.
        ends = np.tri(rule.lengths.size + 1, rule.lengths.size, -1) @ rule.lengths
        return screw_line(rates[0, 0] * length, ends)
    if curvature is not None:
        starts = np.tri(rule.lengths.size, k=-1) @ rule.lengths
        places = (starts[:, None] + jnp.asarray(rule.lengths)[:, None] * gauss(3)[0]).ravel()
        rates = rates + jnp.pad(curvature_at(curvature, places), ((0, 0), (0, 3))).reshape(-1, 3, 6)
    motions = screws(rates * length, rule.lengths)
    if (jumps := getattr(rule, "jumps", None)) is not None:
        at_ends = jumps @ c
        motions = jnp.concatenate([at_ends[:1], motions, at_ends[1:]])
    return chain(motions)


def _spectral_beam(
    p: Point3,
    rot_p: Rotation3,
    q: Point3,
    rot_q: Rotation3,
    c: Series3,
    *,
    ref: Reference,
    order: Static[int] = 5,
    shear: Static[bool] = False,
    section: Section | None = None,
    y: Float[Array, "3"] | None = None,
    curvature: Float[Array, "3"] | CurvedLine | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients."""
    length = _length(ref, curvature, order)
    at_p, at_q = _frames(rot_p, rot_q, ref, y, curvature, length, order)
    line = _poses(c, length, _rule(order, shear, section, length), curvature)
    displacement = jnp.sum(at_p * (q - p)[:, None], axis=0) - line.places[-1]
    between = multiplied(line.axes[-1], multiplied(at_p.T, at_q))
    tilt = 0.5 * jnp.sum(CROSS * between.T, axis=(1, 2))
    return jnp.concatenate([jnp.concatenate([displacement, tilt]), c])


def _fields(*, order: int, shear: bool):
    return fields_after(6, len(_names(shear)), order)


def _stiffness(*, ref, section, order, shear, curvature=None):
    if isinstance(section, General):
        return jnp.pad(section.series_matrix(order, _length(ref, curvature, order), shear), (6, 0))
    return series_matrix(section, section, order, _length(ref, curvature, order), 6, _names(shear))


def _damping(*, ref, damping: Damping, order, shear, section=None, curvature=None):
    return series_matrix(damping, section, order, _length(ref, curvature, order), 6, _names(shear))


def _masses(section: Section, rule: SimpleNamespace, length: Float[Array, ""]):
    """Mass and second moments of the section per place, at the nodes: (n,) [kg], (n, 3, 3) [kg m^2]."""
    if isinstance(section, General):
        mass, _, second = section.moments_of_mass()
        return jnp.full(rule.weights.size, mass * length), jnp.broadcast_to(second * length, (rule.weights.size, 3, 3))
    numbers = rigidities(section, rule.nodes, length, ("mass", "Jx", "Jy", "Jz", "Jyz")) * length
    return numbers[:, 0], jnp.tensordot(numbers[:, 1:], beams.SECOND_MOMENTS, 1)


def _inertia(*nodes: Array, ref, section, order, shear, y=None, curvature=None):
    """Positions and triads at the ends of the steps."""
    p, rot_p, _, rot_q, c = nodes
    length = _length(ref, curvature, order)
    rule = _rule(order, shear, section, length)
    at_p, _ = _frames(rot_p, rot_q, ref, y, curvature, length, order)
    line = _poses(c, length, rule, curvature)
    n = rule.weights.size
    places, axes = line.places, line.axes
    if n != places.shape[0]:
        # Smooth pieces share their ends; a jump comes before the first.
        chosen = rule.ends + hasattr(rule, "jumps")
        places, axes = places[chosen], axes[chosen]
    within = jnp.concatenate([places, axes.reshape(-1, 3)])
    vectors = within @ at_p.T + np.repeat([1.0, 0.0], [n, 3 * n])[:, None] * p
    mass, moments = _masses(section, rule, length)
    h = jnp.zeros((4 * n, 4 * n)).at[:n, :n].set(jnp.diag(mass * rule.weights))
    spread = jnp.einsum("n,nij,nm->nimj", rule.weights, moments, np.eye(n))
    h = h.at[n:, n:].set(spread.reshape(3 * n, 3 * n))
    if isinstance(section, General):
        beside = jnp.einsum("n,nm,i->nmi", rule.weights, np.eye(n), section.moments_of_mass()[1] * length)
        h = h.at[:n, n:].set(beside.reshape(n, 3 * n)).at[n:, :n].set(beside.reshape(n, 3 * n).T)
    return vectors, h


def _resultants(*nodes: Array, ref, place, sigma, section, order, shear, fall=None, y=None, curvature=None):
    """Section resultants at a place by statics of the part beyond it."""
    p, rot_p, q, rot_q, c = nodes
    length = _length(ref, curvature, order)
    at_p, at_q = _frames(rot_p, rot_q, ref, y, curvature, length, order)
    line = _poses(c, length, _rule(order, shear, section, length, place), curvature)
    # Force and moment about p of the part beyond the place, in axes of end p.
    force, moment = jnp.split(sigma[:6], 2)
    moment = at_p.T @ (at_q @ moment) + jnp.cross(at_p.T @ (q - p), force)
    if fall is not None:
        rule, options = _rule(order, shear, section, length), {"order": order, "shear": shear, "y": y}
        vectors, _ = _inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, curvature=curvature, **options)
        mass, second = _masses(section, rule, length)
        n = rule.weights.size
        pulls = mass[:, None] * (fall[:n] @ at_p)
        turning = second @ (fall[n:].reshape(n, 3, 3) @ at_p)
        if isinstance(section, General):
            beside = section.moments_of_mass()[1] * length
            pulls = pulls + beside @ (fall[n:].reshape(n, 3, 3) @ at_p)
            turning = turning + beside[:, None] * (fall[:n] @ at_p)[:, None]
        moments = jnp.cross((vectors[:n] - p) @ at_p, pulls)
        moments = moments + jnp.sum(jnp.cross((vectors[n:] @ at_p).reshape(n, 3, 3), turning), axis=1)
        loads = jnp.concatenate([pulls, moments], axis=1).reshape(-1, len(rule.inner), 6)
        acting = rule.pieces.beyond(legendre_coefficients(rule.inner), loads, place)
        force, moment = jnp.stack([force, moment]) + acting.reshape(2, 3)
    moment = moment - jnp.cross(line.places[-1], force)
    return (jnp.stack([force, moment]) @ line.axes[-1].T).ravel()


def _thermal(change: Array, gradient: Array, *, ref, section, order, shear, curvature=None):
    """Thermal elongation and curvatures; the warmer side becomes longer."""
    bends = {"EIy": gradient[1], "EIz": -gradient[0]}
    return thermal_series(change, bends, section, order, _length(ref, curvature, order), 6, _names(shear))


def _shape(*nodes: Array, ref, place, order, shear, section=None, y=None, curvature=None):
    p, rot_p, _, rot_q, c = nodes
    length = _length(ref, curvature, order)
    at_p, _ = _frames(rot_p, rot_q, ref, y, curvature, length, order)
    return p + at_p @ _poses(c, length, _rule(order, shear, section, length, place), curvature).places[-1]


def _end_pose(*nodes: Array, ref, order, shear, section=None, y=None, curvature=None):
    """Pose of end q relative to end p; its Euler parameters have no jump of sign at a full turn."""
    c = nodes[-1]
    length = _length(ref, curvature, order)
    line = _poses(c, length, _rule(order, shear, section, length), curvature)
    frame = initial_frame(ref.p, ref.q, y)
    axes = rotation_matrix(ref.rot_p).T @ frame
    # Matrix on the Euler parameters of the turn; it does not depend on the deformation.
    units = jnp.eye(4)
    if curvature is not None:
        first, last = turns_of_ends(curvature, length, pose_steps(order))
        axes = axes @ rotation_matrix(first).T
        units = compose_turns(compose_turns(first * CONJUGATE, units), last * CONJUGATE)
    # From axes of the undeformed beam to global axes, and from the reference of p to the reference of q.
    units = jnp.concatenate([units[:, :1], units[:, 1:] @ frame.T], axis=1)
    units = compose_turns(compose_turns(ref.rot_p * CONJUGATE, units), ref.rot_q)
    return axes @ line.places[-1], line.turns[-1] @ units


def _check(*, ref, shear, section=None, y=None, curvature=None) -> list[str]:
    faults = beams.check_length(ref=ref) or beams.check_across(ref=ref, y=y) or check_curvature(ref, curvature, y)
    faults = faults or check_section(section, ref, curvature)
    if section is None or faults:
        return faults
    if isinstance(section, General):
        return []
    numbers = section_rigidities(section, ref, curvature)
    return check_shear(shear, numbers.shear_y, numbers.shear_z)


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
    lengths=(0, 4, 5),
    names=(
        *("closure_x", "closure_y", "closure_z", "closure_tilt_x", "closure_tilt_y", "closure_tilt_z"),
        *("elongation", "twist", "curvature_y", "curvature_z", "shear_y", "shear_z"),
    ),
)
"""Geometrically exact beam; one element models a whole leaf spring in beam theory.

Deformations: 1 to 6 the closure at q, FIXED: three displacements [m] and three tilts [rad] in axes of end p and of end
q; then ``order`` coefficients of each strain, times length: elongation [m], twist, curvature about local y, curvature
about local z [rad], with ``shear`` also the shears along y and along z [m]. Stress resultants of the closure are the
force and moment at q.
Properties: section (it may vary, see :class:`flexmb.sections.Profile`, or couple strains, see
:class:`flexmb.sections.General`), damping, y (vector that fixes local y), curvature (initial [1/m]: (0, about y, about
z) in local axes for an arc from p to q, a function of the place that returns twist and curvatures, or
:func:`flexmb.sections.curvature_through`).
Options: order, the number of coefficients of each strain, default 5; shear, whether shear deformation is counted,
default False. With shear the section must have a shear compliance.

The beam neglects restrained warping, the plate behaviour near clamps and the flattening of wide strips; use
``spatial.leaf_spring`` for them. If shear or warping would change a stiffness by more than 1 %, flexmb warns.

Source: strains of Simo (1985) and Reissner: r' = R (1 + eps, gamma_y, gamma_z), R' = R hat(kappa); poses by the
exponentials of :mod:`flexmb.math.rigid`.
"""
