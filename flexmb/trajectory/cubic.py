"""Cubic splines through arrays of any shape at given times."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.record import Record


class Spline(Record):
    """Cubic spline through values at ascending times [s], with slopes there; its curvature is continuous."""

    t: Float[Array, "n_t"]
    values: Float[Array, "n_t ..."]
    slopes: Float[Array, "n_t ..."]

    def __call__(self, t: Float[Array, ""]) -> Float[Array, "..."]:
        """Value at one time; outside of the given times the first or last polynomial continues."""
        i = jnp.clip(jnp.searchsorted(self.t, t, side="right") - 1, 0, self.t.shape[0] - 2)
        h = self.t[i + 1] - self.t[i]
        s = (t - self.t[i]) / h
        p, v0, v1 = self.values[i], h * self.slopes[i], h * self.slopes[i + 1]
        change = self.values[i + 1] - p
        return p + s * (v0 + s * (3 * change - 2 * v0 - v1 + s * (v0 + v1 - 2 * change)))


def cubic_spline(t: Float[Array, "n_t"], values: Float[Array, "n_t ..."]) -> Spline:
    """Cubic spline without knots at the second and the last but one time, as SciPy's ``CubicSpline``.

    Times ascend. Through two values the spline is a line, through three a parabola. Source: THEORY.md 14, eq. (14.20):
    de Boor, A Practical Guide to Splines, ch. IV.
    """
    flat = values.reshape(t.shape[0], -1)
    return Spline(t, values, _slopes(t, flat).reshape(values.shape))


def _slopes(t: Float[Array, "n_t"], y: Float[Array, "n_t k"]):
    h = jnp.diff(t)
    chord = jnp.diff(y, axis=0) / h[:, None]
    if t.shape[0] == 2:
        return jnp.concatenate([chord, chord])
    if t.shape[0] == 3:
        middle = (h[1] * chord[0] + h[0] * chord[1]) / (h[0] + h[1])
        return jnp.stack([2 * chord[0] - middle, middle, 2 * chord[1] - middle])
    first, last = t[2] - t[0], t[-1] - t[-3]
    none = jnp.zeros(1)
    below = jnp.concatenate([none, h[1:], last[None]])
    diagonal = jnp.concatenate([h[1:2], 2 * (h[:-1] + h[1:]), h[-2:-1]])
    above = jnp.concatenate([first[None], h[:-1], none])
    begin = ((h[0] + 2 * first) * h[1] * chord[0] + h[0] ** 2 * chord[1]) / first
    end = (h[-1] ** 2 * chord[-2] + (2 * last + h[-1]) * h[-2] * chord[-1]) / last
    inside = 3 * (h[1:, None] * chord[:-1] + h[:-1, None] * chord[1:])
    right = jnp.concatenate([begin[None], inside, end[None]])
    return jax.lax.linalg.tridiagonal_solve(below, diagonal, above, right)
