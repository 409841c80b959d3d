"""Functions of the curvature of a wide strip: its curvature across, the stress of twist, and the sideways stiffness.

The strip is a plate with free edges. Its functions depend on u^4 = 3 (1 - nu^2) (curvature width^2/thickness)^2.
Source: THEORY.md 2, eq. (2.23), (2.56), (2.65) and (2.68).
"""

import math
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerical_limits import STRIP_RATIOS

# Terms of the power series in u^4. Its nearest singularity is at u^4 = -125, so that the rest is round-off.
TERMS = 32


def curving(fourth: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """Return the curvature across a bent strip over its value for small bending, by u^4.

    Returns (2/u) (cosh u - cos u)/(sinh u + sin u), the same shape [-]: 1 for small u, 2/u for large. Source: THEORY.md
    2, eq. (2.23).
    """
    return 1 - fourth * relaxing_and_distorting(fourth)[0] / 180


def relaxing_and_distorting(fourth: Float[Array, "*n"]) -> Float[Array, "2 *n"]:
    """Return the share of the stress of twist that a bent strip keeps, and its relative sideways stiffness, by u^4.

    The first is 180 (1 - F)/u^4 with F of :func:`curving`: 1 for small u, 180/u^4 for large. The second is (3/u) (sinh
    u - sin u)/(cosh u - cos u): 1 for small u, 3/u for large. Source: THEORY.md 2, eq. (2.65) and (2.56).
    """
    return _slopes(0, fourth)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _slopes(order: int, fourth: Float[Array, "*n"]) -> Float[Array, "2 *n"]:
    """Return derivatives by u^4 of :func:`relaxing_and_distorting`, each found once for all directions."""
    small = fourth < STRIP_RATIOS
    v, large = jnp.where(small, fourth, 0.0), jnp.where(small, STRIP_RATIOS, fourth)
    powers = np.arange(float(TERMS - order))
    factors = np.prod([powers + k for k in range(1, order + 1)], axis=0)
    by_series = (factors * SERIES[:, order:]) @ (v.ravel() ** powers[:, None])

    def closed(v: Float[Array, "*n"]):
        distorting, curving, _ = _ratios(v)
        return jnp.stack([180 * (1 - 2 * curving) / v, 3 * distorting])

    for _ in range(order):
        closed = _slope(closed)
    return jnp.where(small, by_series.reshape(2, *v.shape), closed(large))


@_slopes.defjvp
def _(order: int, primals: tuple, tangents: tuple):
    return _slopes(order, *primals), _slopes(order + 1, *primals) * tangents[0]


def _slope(function):
    return lambda v: jax.jvp(function, (v,), (jnp.ones_like(v),))[1]


@jax.custom_jvp
def _ratios(fourth: Float[Array, "*n"]) -> tuple[Float[Array, "*n"], ...]:
    """Return s/(a u), a/(b u) and u e/b of s = sinh u - sin u and its derivatives a, b and e by u."""
    u = jnp.sqrt(jnp.sqrt(fourth))
    # All over exp(u)/2, which would overflow.
    once = jnp.exp(-u)
    sinh, cosh, sine, cosine = 1 - once**2, 1 + once**2, 2 * once * jnp.sin(u), 2 * once * jnp.cos(u)
    s, a, b, e = sinh - sine, cosh - cosine, sinh + sine, cosh + cosine
    return s / (u * a), a / (u * b), u * e / b


@_ratios.defjvp
def _(primals: tuple, tangents: tuple):
    """Derivatives of the ratios by log u^4 are polynomials in the ratios, eq. (2.68)."""
    ratios = p, q, r = _ratios(*primals)
    change = tangents[0] / (4 * primals[0])
    slopes = 1 - p / q - p, 1 - q * r - q, r + primals[0] * p * q - r**2
    return ratios, tuple(slope * change for slope in slopes)


def _series() -> np.ndarray:
    """Coefficients of the powers of u^4 of :func:`relaxing_and_distorting`, (2, TERMS)."""
    s, a, b = (np.array([1 / math.factorial(4 * k + n) for k in range(TERMS + 1)]) for n in (3, 2, 1))
    return np.stack([-360 * _quotient(a, b)[1:], 3 * _quotient(s, a)[:-1]])


def _quotient(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    quotient = np.zeros_like(above)
    for k in range(len(above)):
        quotient[k] = (above[k] - below[1 : k + 1][::-1] @ quotient[:k]) / below[0]
    return quotient


SERIES = _series()
