"""Rotations in the plane by an angle, in space by Euler parameters (scalar first, unit norm).

Functions that turn vectors by Euler parameters are polynomials, with finite derivatives everywhere. Equations: Jonker,
Aarts and van Dijk (2009), Multibody System Dynamics 21, 99-122, and ``omega = 2 Lbar d(lambda)/dt``, which defines the
dual of a moment.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerical_limits import SMALLEST_TURN

# vector @ QUARTER turns a vector of the plane counter-clockwise by a right angle, QUARTER @ vector clockwise.
QUARTER = np.array([[0.0, 1.0], [-1.0, 0.0]])


@jax.custom_jvp
def cosine_and_sine(angles: Float[Array, "n"]) -> tuple[Float[Array, "n"], Float[Array, "n"]]:
    """Cosines and sines, computed once for all their uses and derivatives.

    Without the product by an identity, XLA fuses them into every operation that needs them and computes them anew for
    each number there: half the time of a motion of planar beams.
    """
    c, s = jnp.stack([jnp.cos(angles), jnp.sin(angles)]) @ np.eye(angles.shape[0])
    return c, s


@cosine_and_sine.defjvp
def _cosine_and_sine_jvp(primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    c, s = cosine_and_sine(*primals)
    return (c, s), (-s * tangents[0], c * tangents[0])


def rotation_plane(angle: Float[Array, ""]) -> Float[Array, "2 2"]:
    """Matrix that turns a vector in the plane."""
    c, s = jnp.cos(angle), jnp.sin(angle)
    return jnp.array([[c, -s], [s, c]])


def angle_between(start: Float[Array, "2"], end: Float[Array, "2"]) -> Float[Array, ""]:
    """Counter-clockwise angle from one vector in the plane to another, between -pi and pi."""
    return polar_angle(jnp.stack([start @ end, start[0] * end[1] - start[1] * end[0]]))


@jax.custom_jvp
def polar_angle(vector: Float[Array, "2"]) -> Float[Array, ""]:
    """Counter-clockwise angle from the first axis to a vector, between -pi and pi; with a short derivative."""
    return jnp.arctan2(vector[1], vector[0])


@polar_angle.defjvp
def _polar_angle_jvp(primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    (vector,), (change,) = primals, tangents
    return polar_angle(vector), vector @ QUARTER @ change / (vector @ vector)


def nearest_turn(angle: Float[Array, ""], near: Float[Array, ""], turn: float = 2 * np.pi) -> Float[Array, ""]:
    """Angle plus the number of turns that brings it nearest to another angle; the number has no derivative."""
    return angle + turn * jnp.round((near - angle) / turn)


# lbar(lam)[i, j] = LBAR[i, j, k] lam[k]; constant tensors keep the traced graph to one product.
LBAR = np.zeros((3, 4, 4))
LBODY = np.zeros((3, 4, 4))
for _i, (_j, _k) in enumerate([(2, 3), (3, 1), (1, 2)]):
    LBAR[_i, 0, _i + 1] = LBODY[_i, 0, _i + 1] = -1.0
    LBAR[_i, _i + 1, 0] = LBODY[_i, _i + 1, 0] = 1.0
    LBAR[_i, _j, _k], LBAR[_i, _k, _j] = -1.0, 1.0
    LBODY[_i, _j, _k], LBODY[_i, _k, _j] = 1.0, -1.0
ROTATION = np.einsum("iak,jal->ijkl", LBAR, LBODY)
# (a x b)_i = CROSS[i, j, k] a_j b_k
CROSS = np.moveaxis(np.cross(np.eye(3)[:, None], np.eye(3)), 2, 0)
# Times Euler parameters: the parameters of the inverse rotation.
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
# (conjugate(p) q)_i = RELATIVE[j, i, k] p_j q_k, the product of quaternions.
RELATIVE = np.concatenate([np.eye(4)[:, None], np.transpose(LBODY, (2, 0, 1))], axis=1)
# R from the 16 products of two parameters, equal for both orders.
SQUARES = np.transpose(ROTATION + np.swapaxes(ROTATION, 2, 3), (2, 3, 0, 1)).reshape(16, 9) / 2


def lbar(lam: Float[Array, "4"]) -> Float[Array, "3 4"]:
    """Matrix of the global angular velocity, ``omega = 2 lbar(lam) lam_dot``; ``2 lbar.T @ moment`` is dual to ``lam``.

    [[-l1, l0, -l3, l2], [-l2, l3, l0, -l1], [-l3, -l2, l1, l0]]. Source: quaternion products; ``R = lbar @ lbody.T``.
    """
    matrix: Any = LBAR @ lam
    return matrix


def lbody(lam: Float[Array, "4"]) -> Float[Array, "3 4"]:
    """Matrix of the body-fixed angular velocity, ``omega_body = 2 lbody(lam) lam_dot``.

    [[-l1, l0, l3, -l2], [-l2, -l3, l0, l1], [-l3, l2, -l1, l0]]. Source: as :func:`lbar`.
    """
    matrix: Any = LBODY @ lam
    return matrix


def rotation_matrix(lam: Float[Array, "4"]) -> Float[Array, "3 3"]:
    """Rotation matrix of Euler parameters, ``R = lbar(lam) @ lbody(lam).T``; a norm off by d scales R by 1 + 2 d."""
    return ((lam[:, None] * lam).reshape(16) @ SQUARES).reshape(3, 3)


def turned(rot: Float[Array, "4"], ref_rot: Float[Array, "4"], vectors: Float[Array, "3 n"]) -> Float[Array, "3 n"]:
    """Columns that turn with a triad, as they lie now, R(rot) R(ref_rot)^T; coefficients of ``rot`` are constant."""
    coefficients = SQUARES.reshape(48, 3) @ (rotation_matrix(ref_rot).T @ vectors)
    return ((rot[:, None] * rot).reshape(16) @ coefficients.reshape(16, -1)).reshape(3, -1)


def relative_turn(
    p: Float[Array, "4"],
    q: Float[Array, "4"],
    ref_p: Float[Array, "4"],
    ref_q: Float[Array, "4"],
    axes: Float[Array, "3 n"],
) -> Float[Array, "n+1"]:
    """Euler parameters of the rotation of triad q relative to triad p since the undeformed state.

    The vector part is along columns ``axes``, given in the undeformed state and turning with p. The norm is one for
    three orthonormal axes. Source: quaternion product of p conjugate(ref_p), conjugated, and q conjugate(ref_q). It is
    bilinear in p and q with constant coefficients.
    """
    since_p, since_q = (jnp.concatenate([ref[None], lbar(ref)]) for ref in (ref_p, ref_q))
    products = since_p.T @ (RELATIVE.reshape(16, 4) @ since_q).reshape(4, 16)
    coefficients = jnp.swapaxes(products.reshape(4, 4, 4), 1, 2).reshape(16, 4)
    coefficients = jnp.concatenate([coefficients[:, :1], coefficients[:, 1:] @ axes], axis=1)
    return (p[:, None] * q).reshape(16) @ coefficients


def rotation_vector(lam: Float[Array, "4"]) -> Float[Array, "3"]:
    """Rotation vector, axis times angle, within a full turn to either side; differentiable at zero rotation."""
    square = lam[1:] @ lam[1:]
    turned = square > SMALLEST_TURN
    sine = jnp.sqrt(jnp.where(turned, square, 1.0))
    return jnp.where(turned, 2 * jnp.arctan2(sine, lam[0]) / sine, 2 * jnp.sign(lam[0])) * lam[1:]


def rotation_since(start: Float[Array, "4"], lam: Float[Array, "4"], local: bool = False) -> Float[Array, "3"]:
    """Rotation vector between two orientations, about global axes or axes of the body: lam * conj(start), or reversed.

    A small change is ``2 lbar(lam) dlam``, or ``2 lbody(lam) dlam``.
    """
    matrix = lbody if local else lbar
    return rotation_vector(jnp.concatenate([(start @ lam)[None], matrix(start) @ lam]))


def initial_frame(p: Float[Array, "3"], q: Float[Array, "3"], y: Float[Array, "3"] | None) -> Float[Array, "3 3"]:
    """Local axes of a spatial element as columns: x along p to q, y as near to vector ``y`` as possible.

    Without ``y``, it is the global axis along which p to q has its smallest component (SPACAR, edition of 2015).
    """
    ex = (q - p) / jnp.sqrt(jnp.sum((q - p) ** 2))
    if y is None:
        y = (jnp.arange(3) == jnp.argmin(jnp.abs(ex))).astype(ex.dtype)
    ey = y - (y @ ex) * ex
    ey = ey / jnp.sqrt(jnp.sum(ey**2))
    return jnp.stack([ex, ey, (CROSS @ ey) @ ex], axis=1)
