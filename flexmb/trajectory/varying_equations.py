"""Linear second-order equations with time-dependent matrices: cubic splines, and collocation with halved steps."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, check_whole
from ..compilation.record import Record
from ..errors import warn
from ..math.linear import factorise

ROOT = 6**0.5
# Radau IIA of three stages: places of the stages in a step, and weights of their rates.
PLACES = np.array([(4 - ROOT) / 10, (4 + ROOT) / 10, 1.0])
WEIGHTS = np.array(
    [
        [(88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225],
        [(296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225],
        [(16 - ROOT) / 36, (16 + ROOT) / 36, 1 / 9],
    ]
)
# Error of the finer of two runs over their difference, for order five and halved steps.
SHARE = 1 / 31
# Steps from one time to the next: at most, and under a trace, where errors are unknown.
MOST_SUBSTEPS, TRACED = 2**12, 4


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


def integrate_varying(
    equation: Callable, times: Float[Array, "n_t"], q: Float[Array, "n"], v: Float[Array, "n"], substeps: int | Array
) -> tuple[Float[Array, "n_t n"], Float[Array, "n_t n"]]:
    """Solution q, qd at the times of M qdd + C qd + K q = f, all time-dependent.

    The accelerations at the three stages of a step are one linear system; the mass may be singular. The method has
    order five and damps vibrations that are much faster than the steps. Reverse mode needs a Python integer
    ``substeps``, the number of equal steps from each time to the next. Source: THEORY.md 14, eq. (14.21): Hairer and
    Wanner (1996), Solving Ordinary Differential Equations II, table IV.5.6.
    """
    n, stages = q.shape[0], len(PLACES)
    # Displacements integrate the weights twice.
    first, second = jnp.asarray(WEIGHTS), jnp.asarray(WEIGHTS @ WEIGHTS)
    eye = jnp.eye(stages)

    def step(t: Float[Array, ""], h: Float[Array, ""], q: Float[Array, "n"], v: Float[Array, "n"]):
        mass, damping, stiffness, force = jax.vmap(equation)(t + h * PLACES)
        blocks = (
            eye[:, :, None, None] * mass[:, None]
            + h * first[:, :, None, None] * damping[:, None]
            + h**2 * second[:, :, None, None] * stiffness[:, None]
        )
        moved = q + h * jnp.asarray(PLACES)[:, None] * v
        right = force - damping @ v - jnp.einsum("sij,sj->si", stiffness, moved)
        matrix = jnp.transpose(blocks, (0, 2, 1, 3)).reshape(stages * n, stages * n)
        a = factorise(matrix).solve(right.reshape(-1)).reshape(stages, n)
        return q + h * v + h**2 * second[-1] @ a, v + h * first[-1] @ a

    def interval(state: tuple[Array, Array], ends: Float[Array, "2"]):
        begin, h = ends[0], (ends[1] - ends[0]) / jnp.asarray(substeps, float)

        def once(i: Array, state: tuple[Array, Array]):
            return step(begin + i.astype(float) * h, h, *state)

        state = jax.lax.fori_loop(0, substeps, once, state)
        return state, state

    _, (qs, vs) = jax.lax.scan(interval, (q, v), jnp.stack([times[:-1], times[1:]], axis=1))
    return jnp.concatenate([q[None], qs]), jnp.concatenate([v[None], vs])


def with_halved_steps(
    run: Callable[..., Any],
    apart: Callable[[Any, Any], float],
    substeps: int | None,
    rtol: float | None,
    default: float,
    traced: bool,
    what: str,
) -> tuple[Any, float, int]:
    """Result of a run of order five, with twice as many steps until it hardly changes; its error; its number of steps.

    The error is NaN if ``substeps`` is given or under a trace.

    Args:
        run: Function of the number of steps from one time to the next: the keyword ``substeps``, a Python integer, if
            given or under a trace, else an array, so that one program serves all numbers.

    Raises:
        ValueError: ``rtol`` is given beside ``substeps`` or under a trace, where it has no effect.

    Warns:
        FlexmbWarning: The error does not reach ``rtol``, or ``default`` if ``rtol`` is None.
    """
    if rtol is not None and substeps is not None:
        raise ValueError("Give either `rtol` or `substeps`: with `substeps` the number of steps is fixed.")
    if rtol is not None and traced:
        raise ValueError("Under a trace the number of steps is fixed; `rtol` has no effect. Give `substeps`.")
    wanted: float = check_number("rtol", default if rtol is None else rtol, above=0)
    if substeps is not None or traced:
        count = TRACED if substeps is None else check_whole("substeps", substeps, 1)
        return run(substeps=count), np.nan, count
    count, coarse = 1, run(jnp.asarray(1))
    while True:
        count *= 2
        fine = run(jnp.asarray(count))
        error = SHARE * apart(fine, coarse)
        if error <= wanted or count >= MOST_SUBSTEPS:
            break
        coarse = fine
    if not error <= wanted:
        warn(
            f"{what} has an error of {error:.1e}, more than rtol = {wanted:g}, with {MOST_SUBSTEPS} steps between two"
            " times. Give more times."
        )
    return fine, error, count
