"""Settling time: the time after which an output of a linear system stays within a level."""

from functools import partial
from typing import Annotated, Any

import jax
import jax.numpy as jnp
import jax.scipy.linalg
import numpy as np
from jaxtyping import Array, Float

from ..arguments import Positive, check_number, check_numbers, check_whole, checked
from ..math.derivative import DIFFERENTIATED

# Largest number of halvings of a matrix before its exponential; number of iterations that balance the units.
SQUARINGS, BALANCED = 64, 40


@checked
def settling_time(
    matrix: Float[Array, "n n"],
    start: Float[Array, "n"],
    output: Float[Array, "n"],
    level: Float[Array, ""] | float,
    *,
    horizon: Positive,
    samples: Annotated[int, partial(check_whole, least=2)] = 500,
) -> Float[Array, ""]:
    """Return the time after which an output of a linear system stays within a level.

    The system is z' = A z with start z(0) and output c z. For a step response, z is the state minus the final state.

    Args:
        matrix: A of the closed loop, (n, n) [1/s].
        start: z(0), (n,).
        output: c, (n,).
        level: Level for |c z|, () [unit of the output].
        horizon: Time to consider [s].
        samples: Number of time steps up to the horizon. flexmb may miss vibrations with a period of a few steps.

    Returns:
        () [s]; zero if the output never exceeds the level, infinite if it exceeds the level at the horizon. The time
        jumps when a further swing exceeds the level. Between the jumps it is differentiable.

    Raises:
        ValueError: level or horizon is not positive, there are fewer than two samples, or sizes do not agree.

    Source:
        Definition; z(t) = exp(A t) z(0), and Newton's method for the last crossing.
    """
    check_number("level", level, above=0)
    n = (np.size(start),)
    for name, value, shape in (("matrix", matrix, n * 2), ("start", start, n), ("output", output, n)):
        check_numbers(f"Argument `{name}`", value, shape)
    a, z0, c = (jnp.asarray(part, float) for part in (matrix, start, output))
    times = horizon * np.arange(samples + 1) / samples
    a, z0, c = _balanced(a, z0, c)
    exponential = partial(jax.scipy.linalg.expm, max_squarings=SQUARINGS)
    onward = exponential(a * times[1])
    _, z = jax.lax.scan(lambda z, _: (onward @ z, z), z0, length=samples + 1)
    y = jax.lax.stop_gradient(z @ c)
    # This also counts overflowed numbers as outside.
    outside = ~(jnp.abs(y) <= level)
    last = samples - jnp.argmax(outside[::-1])
    side, after = jnp.sign(y[last]), jnp.minimum(last + 1, samples)
    begin, end = jnp.asarray(times)[last], jnp.asarray(times)[after]
    before, past = jnp.abs(y[last]) - level, side * y[after] - level
    t = begin + (end - begin) * before / jnp.where(before == past, 1.0, before - past)
    for i in range(4):
        # The last steps carry the derivatives.
        t = jnp.clip(t if i > 4 - DIFFERENTIATED else jax.lax.stop_gradient(t), begin, end)
        at = exponential(a * (t - begin)) @ z[last]
        rate = side * (c @ a @ at)
        t = t - (side * (c @ at) - level) / jnp.where(rate == 0, 1.0, rate)
    t = jnp.where(jnp.any(outside), t, 0.0)
    t = jnp.where(outside[samples], jnp.inf, t)
    # An overflow does not settle. The result is NaN only if the input has a NaN.
    unknown = jnp.isnan(level) | jnp.any(jnp.isnan(jnp.concatenate([a.ravel(), z0, c])))
    return jnp.where(unknown, jnp.nan, t)


def _balanced(a: Float[Array, "n n"], z: Float[Array, "n"], c: Float[Array, "n"]) -> tuple[Any, Any, Any]:
    """Return the same system with the units of its states scaled until row and column sums are equal.

    Osborne (1960) scales the states one after the other, each unit by the square root of row sum over column sum. Here
    each iteration scales all states at once by the fourth root.
    """
    sizes, none = jax.lax.stop_gradient(jnp.abs(a) * (1 - jnp.eye(len(z)))), jnp.ones(len(z))

    def closer(_: Array, unit: Float[Array, "n"]):
        scaled = sizes * unit / unit[:, None]
        row, column = jnp.sum(scaled, axis=1), jnp.sum(scaled, axis=0)
        positive = (row > 0) & (column > 0)
        return unit * jnp.where(positive, row / jnp.where(positive, column, 1.0), 1.0) ** 0.25

    unit = jax.lax.fori_loop(0, BALANCED, closer, none)
    return a * unit / unit[:, None], z / unit, c * unit
