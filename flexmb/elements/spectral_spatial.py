"""Spectral beam in space, with or without shear; what it shares with that in the plane stands in ``spectral``."""

import functools
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.linear import multiplied
from ..math.quadrature import gauss, legendre_coefficients, legendre_values, legendre_values_at, lobatto
from ..math.rigid import exponential, product, products, screws
from ..math.rotation import CROSS, initial_frame, rotation_matrix
from . import beams
from .element import Element
from .nodes import Point3, Rotation3, Series3, Static
from .sections import Damping, Section
from .spectral import arc_length, beyond, check_curvature, fields_after, series_diagonal


@functools.cache
def _rule(order: int, shear: bool) -> SimpleNamespace:
    """Quadrature along the beam, in steps over each of which the pose goes by an exponential."""
    steps = 8 * 2 ** max(0, int(np.ceil(np.log2(order / 6))))
    ends, weights = lobatto(steps + 1)
    lengths = np.diff(ends)
    # Three nodes within each step; the six-vector (twist, curvatures, stretch, shears) of each field; both together.
    inner = (ends[:-1, None] + lengths[:, None] * gauss(3)[0]).ravel()
    places = np.eye(6)[[3, 0, 1, 2, 4, 5][: _count(shear)]]
    whole = np.einsum("pk,fs->psfk", legendre_values(order, inner), places)
    own = {"lengths": lengths, "inner": inner, "places": places, "whole": whole}
    return SimpleNamespace(weights=weights, coefficients=legendre_coefficients(ends), **own)


def _count(shear: bool) -> int:
    """Number of strain fields."""
    return 6 if shear else 4


def _length(ref, curvature) -> Float[Array, ""]:
    chord = beams.beam_length(ref)
    return chord if curvature is None else arc_length(chord, beams.length(curvature) * chord / 2)


def _frames(rot_p, rot_q, ref, y, curvature, length):
    """Section axes at both ends as columns."""
    frame = initial_frame(ref.p, ref.q, y)
    at_p = multiplied(rotation_matrix(rot_p), rotation_matrix(ref.rot_p).T @ frame)
    at_q = multiplied(rotation_matrix(rot_q), rotation_matrix(ref.rot_q).T @ frame)
    if curvature is None:
        return at_p, at_q
    half = exponential(jnp.concatenate([curvature * length / 2, jnp.zeros(3)])[None])[0, :3, :3]
    return at_p @ half.T, at_q @ half


def _steps(c, length, order, shear, curvature, place=None):
    """Screw motions of the steps from end p to a place, to end q unless given, (steps, 4, 4)."""
    rule = _rule(order, shear)
    basis = rule.whole
    if place is not None:
        basis = jnp.einsum("pk,fs->psfk", legendre_values_at(order, place * rule.inner), rule.places)
    own = (basis.reshape(-1, c.size) @ c).reshape(-1, 6) / length + np.array([0.0, 0, 0, 1, 0, 0])
    if curvature is not None:
        own = own + jnp.concatenate([curvature, jnp.zeros(3)])
    return exponential(screws(own.reshape(-1, 3, 6) * (length * (1.0 if place is None else place)), rule.lengths))


def _spectral_beam(
    p: Point3,
    rot_p: Rotation3,
    q: Point3,
    rot_q: Rotation3,
    c: Series3,
    *,
    ref,
    order: Static[int] = 5,
    shear: Static[bool] = False,
    y: Float[Array, "3"] | None = None,
    curvature: Float[Array, "3"] | None = None,
) -> Float[Array, "n_e"]:
    """Closure at q, then the coefficients themselves."""
    length = _length(ref, curvature)
    at_p, at_q = _frames(rot_p, rot_q, ref, y, curvature, length)
    pose = product(_steps(c, length, order, shear, curvature))
    displacement = jnp.sum(at_p * (q - p)[:, None], axis=0) - pose[:3, 3]
    between = multiplied(multiplied(at_p, pose[:3, :3]).T, at_q)
    tilt = 0.5 * jnp.sum(CROSS * between.T, axis=(1, 2))
    return jnp.concatenate([jnp.concatenate([displacement, tilt]), c])


def _fields(*, order, shear):
    return fields_after(6, _count(shear), order)


def _stiffness(*, ref, section: Section, order, shear, curvature=None):
    s = section.rigidity()
    rigidities = [s.EA, s.GIt, s.EIy, s.EIz]
    if shear:
        rigidities += [s.EIz / s.shear_y, s.EIy / s.shear_z]
    return series_diagonal(rigidities, _length(ref, curvature), 6, order)


def _damping(*, ref, damping: Damping, order, shear, curvature=None):
    rigidities = [damping.EA, damping.GIt, damping.EIy, damping.EIz] + [0.0] * (_count(shear) - 4)
    return series_diagonal(rigidities, _length(ref, curvature), 6, order)


def _inertia(p, rot_p, q, rot_q, c, *, ref, section, order, shear, y=None, curvature=None):
    """Positions and triads at the ends of the steps."""
    s, length, weights = section.rigidity(), _length(ref, curvature), _rule(order, shear).weights
    at_p, _ = _frames(rot_p, rot_q, ref, y, curvature, length)
    poses = jnp.concatenate([jnp.eye(4)[None], products(_steps(c, length, order, shear, curvature))])
    turned = multiplied(at_p, poses[:, :3])
    vectors = jnp.concatenate([p + turned[:, :, 3], jnp.swapaxes(turned[:, :, :3], 1, 2).reshape(-1, 3)])
    moments = beams.combine([s.Jx, s.Jy, s.Jz, s.Jyz], beams.SECOND_MOMENTS)
    n = weights.size
    h = jnp.zeros((4 * n, 4 * n)).at[:n, :n].set(s.mass * np.diag(weights))
    return vectors, length * h.at[n:, n:].set(jnp.kron(np.diag(weights), moments))


def _resultants(p, rot_p, q, rot_q, c, *, ref, place, sigma, section, order, shear, fall=None, y=None, curvature=None):
    """Statics of the part beyond the place."""
    length = _length(ref, curvature)
    at_p, at_q = _frames(rot_p, rot_q, ref, y, curvature, length)
    pose = product(_steps(c, length, order, shear, curvature, place))
    # Force, and moment about p, of all that is beyond the place, in axes of end p.
    force, moment = jnp.split(sigma[:6], 2)
    moment = at_p.T @ (at_q @ moment) + jnp.cross(at_p.T @ (q - p), force)
    if fall is not None:
        rule, own = _rule(order, shear), {"order": order, "shear": shear, "y": y, "curvature": curvature}
        vectors, h = _inertia(p, rot_p, q, rot_q, c, ref=ref, section=section, **own)
        pulls, n = h @ fall @ at_p, rule.weights.size
        levers = jnp.concatenate([vectors[:n] - p, vectors[n:]]) @ at_p
        moments = jnp.cross(levers, pulls)
        moments = moments[:n] + jnp.sum(moments[n:].reshape(-1, 3, 3), axis=1)
        loads = jnp.concatenate([pulls[:n], moments], axis=1) / rule.weights[:, None]
        force, moment = jnp.stack([force, moment]) + beyond(rule.coefficients, loads, place).reshape(2, 3)
    moment = moment - jnp.cross(pose[:3, 3], force)
    return (jnp.stack([force, moment]) @ pose[:3, :3]).ravel()


def _shape(p, rot_p, q, rot_q, c, *, ref, place, order, shear, y=None, curvature=None):
    length = _length(ref, curvature)
    at_p, _ = _frames(rot_p, rot_q, ref, y, curvature, length)
    return p + at_p @ product(_steps(c, length, order, shear, curvature, place))[:3, 3]


def _check(*, ref, shear, section=None, y=None, curvature=None) -> list[str]:
    size = None if curvature is None else np.linalg.norm(np.asarray(curvature), axis=-1)
    faults = beams.check_length(ref=ref) or beams.check_across(ref, y) or check_curvature(ref, size)
    if not faults and curvature is not None and np.any(np.asarray(curvature)[..., 0] != 0):
        faults = ["has an initial twist, the first component of its curvature: only plane arcs are provided for"]
    if section is None:
        return faults
    s = section.rigidity()
    compliant = [np.asarray(number) > 0 for number in (s.shear_y, s.shear_z)]
    if shear and not np.all(compliant):
        faults.append("counts shear, but its section has none: give the section shear=True")
    if not shear and np.any(compliant):
        faults.append("does not count shear, but its section has it: make the element with shear=True")
    return faults


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

Deformations: 1 to 6 the closure at q, FIXED: three displacements [m] and three tilts [rad] in axes of end p and of end
q; then ``order`` coefficients of each strain, times length: elongation [m], twist, curvature about local y, curvature
about local z [rad], with ``shear`` also the shears along y and along z [m]. Stress resultants of the closure are the
force and moment at q.
Properties: section, damping, y (vector that fixes local y), curvature (initial, (0, about y, about z) in local axes, of
an arc from p to q [1/m]).
Options: order, the number of coefficients of each strain, 5 unless given; shear, whether shear deformation is counted,
False unless given: the section must then have a shear compliance.

Source: strains of Simo (1985) and Reissner: r' = R (1 + eps, gamma_y, gamma_z), R' = R hat(kappa); poses by the
exponentials of :mod:`flexmb.math.rigid`.
"""
