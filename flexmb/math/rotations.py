"""Rotations in space by Euler parameters, for elements and results: ``fm.rotations``.

The Euler parameters of a turn by the angle a are (cos(a/2), n sin(a/2)), scalar first, with the unit vector n of the
axis. The turn is counter-clockwise for an observer who looks against n. All axes are global. Every function is
differentiable everywhere, at zero rotation too.
"""

import jax.numpy as jnp
from jax.typing import ArrayLike
from jaxtyping import Array, Float

from ..arguments import as_reals
from ..lazy import only
from ..numerical_limits import ANGLE_BY_SERIES
from .rotation import CONJUGATE, rotation_matrix, rotation_vector


def from_vector(vector: Float[ArrayLike, "3"]) -> Float[Array, "4"]:
    """Euler parameters of a rotation vector.

    Args:
        vector: Axis times angle, (3,) [rad].

    Returns:
        (4,) [-], scalar first.

    Source:
        Definition; near zero by the series of sine and cosine.
    """
    vector = as_reals("Argument `vector`", vector)
    square = vector @ vector
    is_small = square < ANGLE_BY_SERIES
    half = jnp.sqrt(jnp.where(is_small, 1.0, square)) / 2
    scalar = jnp.where(is_small, 1 - square / 8 + square**2 / 384, jnp.cos(half))
    along = jnp.where(is_small, 0.5 - square / 48 + square**2 / 3840, jnp.sin(half) / (2 * half))
    return jnp.concatenate([scalar[None], along * vector])


def from_axis_angle(axis: Float[ArrayLike, "3"], angle: Float[ArrayLike, ""]) -> Float[Array, "4"]:
    """Euler parameters of a rotation about an axis.

    Args:
        axis: Axis, of any nonzero length, (3,).
        angle: Angle, counter-clockwise for an observer towards whom the axis points, () [rad].

    Returns:
        (4,) [-], scalar first.

    Source:
        Definition.
    """
    axis, half = as_reals("Argument `axis`", axis), as_reals("Argument `angle`", angle) / 2
    return jnp.concatenate([jnp.cos(half)[None], jnp.sin(half) * axis / jnp.sqrt(axis @ axis)])


def to_vector(rotation: Float[ArrayLike, "4"]) -> Float[Array, "3"]:
    """Rotation vector of Euler parameters: axis times angle.

    Args:
        rotation: Euler parameters, (4,) [-].

    Returns:
        (3,) [rad], with a length of at most one full turn.

    Source:
        Definition.
    """
    return rotation_vector(as_reals("Argument `rotation`", rotation))


def to_matrix(rotation: Float[ArrayLike, "4"]) -> Float[Array, "3 3"]:
    """Rotation matrix of Euler parameters.

    Args:
        rotation: Euler parameters, (4,) [-].

    Returns:
        (3, 3) [-], whose columns are the turned axes.

    Source:
        Quaternion products; see :func:`flexmb.math.rotation.rotation_matrix`.
    """
    return rotation_matrix(as_reals("Argument `rotation`", rotation))


def rotate(rotation: Float[ArrayLike, "4"], vector: Float[ArrayLike, "3"]) -> Float[Array, "3"]:
    """Vector turned by a rotation.

    Args:
        rotation: Euler parameters, (4,) [-].
        vector: Vector, (3,), of any unit.

    Returns:
        (3,), of the unit of the vector.

    Source:
        Rotation matrix times vector.
    """
    return to_matrix(rotation) @ as_reals("Argument `vector`", vector)


def quaternion_product(second: Float[ArrayLike, "4"], first: Float[ArrayLike, "4"]) -> Float[Array, "4"]:
    """Euler parameters of two successive rotations about global axes: ``first``, then ``second``.

    Args:
        second: Euler parameters, (4,) [-].
        first: Euler parameters, (4,) [-].

    Returns:
        (4,) [-], scalar first. The rotation of a body since its start is ``quaternion_product(now, inverse(start))``.

    Source:
        Quaternion product second * first.
    """
    second, first = as_reals("Argument `second`", second), as_reals("Argument `first`", first)
    scalar = second[0] * first[0] - second[1:] @ first[1:]
    return jnp.concatenate(
        [scalar[None], second[0] * first[1:] + first[0] * second[1:] + jnp.cross(second[1:], first[1:])]
    )


def inverse(rotation: Float[ArrayLike, "4"]) -> Float[Array, "4"]:
    """Euler parameters of the inverse rotation.

    Args:
        rotation: Euler parameters, (4,) [-].

    Returns:
        (4,) [-], scalar first.

    Source:
        Conjugate quaternion.
    """
    return as_reals("Argument `rotation`", rotation) * CONJUGATE


__all__, __dir__ = only(globals(), lambda value: getattr(value, "__module__", "") == __name__)
