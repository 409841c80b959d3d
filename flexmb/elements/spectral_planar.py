"""Spectral beam in the plane, without shear deformation; what it shares with that in space stands in ``spectral``."""

import functools
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.quadrature import (
    gauss,
    integration_matrix,
    legendre_coefficients,
    legendre_integrals,
    legendre_integrals_at,
    legendre_values,
    legendre_values_at,
)
from ..math.rotation import rotation_plane
from . import beams
from .element import Element
from .nodes import Angle, Point2, Series2, Static
from .sections import Damping, Section
from .spectral import arc_length, beyond, check_curvature, fields_after, series_diagonal

# Fields in the order of the coefficients.
ELONGATION, CURVATURE = 0, 1


@functools.cache
def _rule(order: int) -> SimpleNamespace:
    """Quadrature along the beam: nodes and weights, polynomials there, their integrals, and what is made of values."""
    nodes, weights = gauss(2 * order + 8)
    return SimpleNamespace(
        nodes=nodes,
        weights=weights,
        values=legendre_values(order, nodes),
        angles=legendre_integrals(order, nodes),
        along=integration_matrix(nodes),
        coefficients=legendre_coefficients(nodes),
    )


def _length(ref, curvature) -> Float[Array, ""]:
    chord = beams.beam_length(ref)
    return chord if curvature is None else arc_length(chord, curvature * chord / 2)


def _bent(c, length, curvature, s, integrals) -> Float[Array, "n 2"]:
    """Directions at places s, in axes of end p."""
    angle = integrals @ c.reshape(2, -1)[CURVATURE]
    if curvature is not None:
        angle = angle + curvature * length * s
    return jnp.stack([jnp.cos(angle), jnp.sin(angle)], axis=-1)


def _line(rot_p, c, ref, order, curvature):
    """Length, axes of end p as columns, directions and stretched directions at the nodes in those axes."""
    length, tilt, rule = _length(ref, curvature), 0.0, _rule(order)
    if curvature is not None:
        tilt = curvature * length / 2
    x = rotation_plane(rot_p[0] - ref.rot_p[0] - tilt) @ ((ref.q - ref.p) / beams.beam_length(ref))
    axes = jnp.stack([x, jnp.stack([-x[1], x[0]])], axis=1)
    directions = _bent(c, length, curvature, rule.nodes, rule.angles)
    stretches = length + rule.values @ c.reshape(2, -1)[ELONGATION]
    return length, axes, directions, stretches[:, None] * directions


def _to_place(c, length, order, curvature, place):
    """Direction at a place, and the way from p to it, in axes of end p."""
    rule = _rule(order)
    on_the_way = place * np.append(rule.nodes, 1.0)
    directions = _bent(c, length, curvature, on_the_way, legendre_integrals_at(order, on_the_way))
    stretched = length + legendre_values_at(order, on_the_way) @ c.reshape(2, -1)[ELONGATION]
    return directions[-1], place * (rule.weights * stretched[:-1]) @ directions[:-1]


def _spectral_beam(
    p: Point2,
    rot_p: Angle,
    q: Point2,
    rot_q: Angle,
    c: Series2,
    *,
    ref,
    order: Static[int] = 5,
    curvature: float | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients themselves."""
    _, axes, _, stretched = _line(rot_p, c, ref, order, curvature)
    displacement = axes.T @ (q - p) - _rule(order).weights @ stretched
    turn = (rot_q - ref.rot_q) - (rot_p - ref.rot_p) - c[order : order + 1]
    return jnp.concatenate([jnp.concatenate([displacement, turn]), c])


def _fields(*, order):
    return fields_after(3, 2, order)


def _stiffness(*, ref, section: Section, order, curvature=None):
    s = section.rigidity()
    return series_diagonal([s.EA, s.EIy], _length(ref, curvature), 3, order)


def _damping(*, ref, damping: Damping, order, curvature=None):
    return series_diagonal([damping.EA, damping.EIy], _length(ref, curvature), 3, order)


def _inertia(p, rot_p, q, rot_q, c, *, ref, section, order, curvature=None):
    """Positions and directions at the nodes of the quadrature."""
    s, rule = section.rigidity(), _rule(order)
    length, axes, directions, stretched = _line(rot_p, c, ref, order, curvature)
    positions = p + rule.along @ stretched @ axes.T
    masses = jnp.concatenate([s.mass * length * rule.weights, s.Jy * length * rule.weights])
    return jnp.concatenate([positions, directions @ axes.T]), jnp.diag(masses)


def _turn(lever, force):
    """Moment of forces in the plane, counter-clockwise."""
    return lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]


def _resultants(p, rot_p, q, rot_q, c, *, ref, place, sigma, section, order, fall=None, curvature=None):
    """Statics of the part beyond the place."""
    length, axes, _, _ = _line(rot_p, c, ref, order, curvature)
    (cosine, sine), reached = _to_place(c, length, order, curvature, place)
    # Force, and moment about p, of all that is beyond the place; counter-clockwise, in axes of end p.
    force, moment = jnp.split(sigma[:3], (2,))
    wrench = jnp.append(force, moment + _turn(axes.T @ (q - p), force))
    if fall is not None:
        vectors, h = _inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, order=order, curvature=curvature)
        pulls, turning = jnp.split(h @ fall @ axes, 2)
        positions, normals = jnp.split(vectors @ axes, 2)
        moments = _turn(positions - axes.T @ p, pulls) + _turn(normals, turning)
        loads = jnp.concatenate([pulls, moments[:, None]], axis=1) / _rule(order).weights[:, None]
        wrench = wrench + beyond(_rule(order).coefficients, loads, place)
    (x, y), bending = wrench[:2], wrench[2] - _turn(reached, wrench[:2])
    # The section's own y axis points into the plane: a moment about it turns clockwise.
    zero = jnp.zeros_like(x)
    return jnp.stack([cosine * x + sine * y, zero, cosine * y - sine * x, zero, -bending, zero])


def _shape(p, rot_p, q, rot_q, c, *, ref, place, order, curvature=None):
    length, axes, _, _ = _line(rot_p, c, ref, order, curvature)
    return p + axes @ _to_place(c, length, order, curvature, place)[1]


def _check(*, ref, curvature=None) -> list[str]:
    return beams.check_length(ref=ref) or check_curvature(ref, None if curvature is None else np.abs(curvature))


spectral_beam = Element(
    _spectral_beam,
    stiffness=_stiffness,
    damping=_damping,
    inertia=_inertia,
    resultants=_resultants,
    shape=_shape,
    check=_check,
    series=_fields,
)
"""Geometrically exact beam, one for a whole leaf spring.

Deformations: 1 to 3 the closure at q, FIXED: two displacements in axes of end p [m] and the angle [rad]; then ``order``
coefficients of each strain, times length: elongation [m], curvature [rad], the first of which is the angle between the
ends. Stress resultants of the closure are the force and moment at q.
Properties: section (EA, EIy, mass, Jy), damping, curvature (initial, of an arc from p to q [1/m], positive
counter-clockwise).
Options: order, the number of coefficients of each strain, 5 unless given; 2 bends as a cubic beam does, 5 gives six
digits for a leaf spring at a large stroke.

Source: strains of the extensible elastica; theta(s) = integral of the curvature, r' = (1 + eps)(cos theta, sin theta).
"""
