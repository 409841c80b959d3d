"""Rigid motions along a line: poses from strains by exponentials of six-vectors (rotation first, then translation).

A pose is a homogeneous matrix [[R, r], [0, 1]]. Along a rod dH/ds = H A(s), where A is the matrix of the six-vector
(curvatures, stretches) in axes of the section.
"""

import functools
import math

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .linear import multiplied
from .rotation import CONJUGATE, CROSS, RELATIVE

# matrix(v)[i, j] = HAT[i, j, k] v[k]
HAT = np.zeros((4, 4, 6))
HAT[:3, :3, :3] = np.einsum("ikj->ijk", CROSS)
HAT[:3, 3, 3:] = np.eye(3)
# Lie bracket of two six-vectors: matrix(a) matrix(b) - matrix(b) matrix(a) = matrix(A b) with A = a . ADJOINT.
ADJOINT = np.zeros((6, 6, 6))
ADJOINT[:3, :3, :3] = ADJOINT[:3, 3:, 3:] = ADJOINT[3:, 3:, :3] = np.moveaxis(CROSS, 1, 0)
# Quaternion product: (a b)_i = a_j b_k TURNS[4 j + k, i].
TURNS = np.swapaxes(CONJUGATE[:, None, None] * RELATIVE, 1, 2).reshape(16, 4)
# (1 - cos t)/t^2 and (t - sin t)/t^3 as power series in -t^2; ten terms are exact to rounding up to t = 2.
TERMS = 10


@functools.cache
def _terms(derivative: int) -> np.ndarray:
    """Coefficients of a derivative of both series, (terms, 2)."""
    at = range(derivative, derivative + TERMS)
    return np.array([[math.perm(k, derivative) / math.factorial(2 * k + j) for j in (2, 3)] for k in at])


@functools.partial(jax.custom_jvp, nondiff_argnums=(1,))
def _series(z: Float[Array, "n 1"], derivative: int) -> Float[Array, "n 2"]:
    """A derivative of both series, from powers of z in few operations; its tangent is the next derivative."""
    square = z * z
    four = square * square
    two = jnp.concatenate([jnp.ones_like(z), z], axis=1)
    first = jnp.concatenate([two, two * square], axis=1)
    powers = jnp.concatenate([first, first * four, two * four * four], axis=1)
    return multiplied(powers, jnp.asarray(_terms(derivative)))


@_series.defjvp
def _series_jvp(derivative: int, primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    return _series(primals[0], derivative), _series(primals[0], derivative + 1) * tangents[0]


def exponential(v: Float[Array, "n 6"]) -> Float[Array, "n 4 4"]:
    """Poses of screw motions, exp(matrix(v)), for rotations up to 2 rad; differentiable at zero rotation.

    Source: exp(V) = I + V + (1 - cos t)/t^2 V^2 + (t - sin t)/t^3 V^3 with t the angle, as V^4 = -t^2 V^2.
    """
    matrix = v @ np.moveaxis(HAT, 2, 0).reshape(6, 16)
    matrix = matrix.reshape(-1, 4, 4)
    total = _series(-jnp.sum(v[:, :3] ** 2, axis=1)[:, None], 0)
    square = multiplied(matrix, matrix)
    b, c = total[:, 0, None, None], total[:, 1, None, None]
    return jnp.eye(4) + matrix + b * square + c * multiplied(square, matrix)


def turn_parameters(v: Float[Array, "n 6"]) -> Float[Array, "n 4"]:
    """Euler parameters of the rotations of screw motions, up to 4 rad; differentiable at zero rotation.

    Source: (cos t, sin t h/t), where h is half the rotation vector and t its length: 1 - t^2 (1 - cos t)/t^2 and
    1 - t^2 (t - sin t)/t^3.
    """
    half = v[:, :3] / 2
    z = -jnp.sum(half**2, axis=1)[:, None]
    scalar_and_scale = 1.0 + z * _series(z, 0)
    return jnp.concatenate([scalar_and_scale[:, :1], scalar_and_scale[:, 1:] * half], axis=1)


def compose_turns(a: Float[Array, "*#n 4"], b: Float[Array, "*#n 4"]) -> Float[Array, "*#n 4"]:
    """Euler parameters of rotation a, then b about axes that turn with a: quaternion products."""
    both = a[..., :, None] * b[..., None, :]
    return both.reshape(*both.shape[:-2], 16) @ TURNS


def turn_product(turns: Float[Array, "n 4"]) -> Float[Array, "4"]:
    """Product of n rotations in order, n a power of two; see :func:`product`."""
    while turns.shape[0] > 1:
        turns = compose_turns(turns[0::2], turns[1::2])
    return turns[0]


def _bracket(a: Array, b: Array) -> Array:
    adjoint = (a @ ADJOINT.reshape(6, 36)).reshape(-1, 6, 6)
    return jnp.sum(adjoint * b[:, None], axis=2)


def screws(strains: Float[Array, "n 3 6"], steps: np.ndarray) -> Float[Array, "n 6"]:
    """Screw motions v over steps along a line, H(s + h) = H(s) exp(matrix(v)), of order six in h.

    Strains are curvatures and stretches in axes of the section, at three Gauss nodes per step. Constant strains give
    exact results. Source: Magnus expansion of order six by Blanes, Casas, Oteo and Ros (2009), Physics Reports 470,
    section 5.4, with reversed brackets because here the strains stand to the right of the pose.
    """
    first, middle, last = (strains[:, i] * steps[:, None] for i in range(3))
    a1 = middle
    a2 = np.sqrt(15) / 3 * (last - first)
    a3 = 10 / 3 * (last - 2 * middle + first)
    c1 = -_bracket(a1, a2)
    c2 = _bracket(a1, 2 * a3 + c1) / 60
    return a1 + a3 / 12 - _bracket(-20 * a1 - a3 + c1, a2 + c2) / 240


def product(poses: Float[Array, "n 4 4"]) -> Float[Array, "4 4"]:
    """Product of poses in order, n a power of two, in log2 n batched products."""
    while poses.shape[0] > 1:
        poses = multiplied(poses[0::2], poses[1::2])
    return poses[0]


def products(poses: Float[Array, "n 4 4"]) -> Float[Array, "n 4 4"]:
    """Products of the first 1, 2, .. n poses, n a power of two; the last one as :func:`product` computes it."""
    if poses.shape[0] == 1:
        return poses
    pairs = products(multiplied(poses[0::2], poses[1::2]))
    between = poses[:1]
    if poses.shape[0] > 2:
        between = jnp.concatenate([between, multiplied(pairs[:-1], poses[2::2])])
    return jnp.stack([between, pairs], axis=1).reshape(poses.shape)
