"""Spectral beams: geometrically exact beams whose strains are Legendre series along a whole leaf spring.

The coordinates that such a beam owns are the coefficients of its strains; they are its elastic deformations too. The
pose of end q follows from that of end p by quadrature of the kinematics, and its difference from node q, the closure,
is the part of the deformations that stays FIXED; the closure comes first, then one strain field after the other, its
``order`` coefficients in turn. The error falls exponentially with the order (benchmarks/large_deflection.py).

Section resultants at a place are those of statics: force and moment at q and what acts on the mass beyond the place.

Here is what the beam in the plane (``spectral_planar``) and that in space (``spectral_spatial``) share. Names: p and q
are the ends, ``rot_p`` and ``rot_q`` their rotations, c the coefficients.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.quadrature import legendre_integrals_at

# Coefficients of a strain field, at most: beyond it compiling takes minutes, and round-off is reached long before.
LARGEST_ORDER = 40


def fields_after(closure: int, count: int, order: int) -> tuple[tuple[int, ...], ...]:
    """Numbers (from 1) of the deformations of each strain field.

    Args:
        closure: Number of deformations before them.
        count: Number of fields.
        order: Coefficients of each.

    Raises:
        ValueError: The order is below 1, or beyond the largest.
    """
    if not 1 <= order <= LARGEST_ORDER:
        raise ValueError(f"order must be at least 1 and at most {LARGEST_ORDER}, but is {order}.")
    firsts = range(closure + 1, closure + count * order + 1, order)
    return tuple(tuple(range(first, first + order)) for first in firsts)


def series_diagonal(rigidities: list, length: Float[Array, ""], closure: int, order: int) -> Float[Array, "n_e n_e"]:
    """Matrix of constant rigidities over length; the integral of a squared polynomial P_k is 1/(2k + 1).

    Args:
        rigidities: Of each strain field, () [N, N m^2].
        length: Of the beam, () [m].
        closure: Number of deformations before the fields, which have no stiffness.
        order: Coefficients of each field.
    """
    own = jnp.stack([jnp.asarray(r, float) for r in rigidities])[:, None] / length
    own = own / (2.0 * np.arange(order) + 1)
    return jnp.diag(jnp.concatenate([jnp.zeros(closure), own.ravel()]))


def beyond(coefficients: np.ndarray, loads: Float[Array, "n k"], place: Float[Array, ""]) -> Float[Array, "k"]:
    """Integral from a place to the end of loads at nodes, by the (n, n) Legendre coefficients of values there."""
    n = coefficients.shape[0]
    return (np.eye(n)[0] - legendre_integrals_at(n, place)) @ (coefficients @ loads)


def arc_length(chord: Float[Array, ""], half: Float[Array, ""]) -> Float[Array, ""]:
    """Length of an arc over a chord [m]; ``half`` is half the curvature times the chord [-]."""
    return chord * jnp.arcsin(half) / half


def check_curvature(ref, size: np.ndarray | None) -> list[str]:
    """Faults of an initial curvature of some size [1/m], or None for a straight beam."""
    if size is None:
        return []
    half = np.asarray(size) * np.linalg.norm(np.asarray(ref.q) - np.asarray(ref.p), axis=-1) / 2
    if not np.all((half > 0) & (half <= 1)):
        return ["has an initial curvature that no arc between its ends has: it must not be zero, nor above 2/chord"]
    return []
