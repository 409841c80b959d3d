"""Newton's method for the equations of one time step, which reuses its factors while it converges fast."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..math.linear import factorise
from ..numerical_limits import REUSED_FACTORS, STEP_CONVERGED, STEP_STALLED

# Largest number of iterations.
MOST = 40


def solve_step(
    residual: Callable[..., Any],
    matrix: Callable[..., Any],
    first: Float[Array, "r r"],
    start: Float[Array, "r"],
    positions: int,
    lever: Float[Array, ""],
) -> tuple[Float[Array, "r"], Bool[Array, ""]]:
    """Accelerations and multipliers of one time step, and whether the equations are solved; differentiable.

    Args:
        residual: Function of the unknowns.
        matrix: Its derivative, or an approximation, as a function of the unknowns.
        first: Value of ``matrix`` at the first guess.
        start: First guess.
        positions: Number of accelerations, the first unknowns.
        lever: Change of a position per change of its acceleration [s^2].
    """

    def solve(f: Callable[..., Any], start: Float[Array, "r"]):
        def unsolved(carry: tuple[Any, ...]):
            _, _, change, before, count = carry
            stalled = (change < STEP_STALLED) & (change > 0.5 * before)
            return (change > STEP_CONVERGED) & ~stalled & ~jnp.isnan(change) & (count < MOST)

        def once(carry: tuple[Any, ...]):
            z, factors, change, before, count = carry
            again = (count > 1) & (change > REUSED_FACTORS * before)
            factors = jax.lax.cond(again, lambda: factorise(matrix(z)), lambda: factors)
            step = factors.solve(f(z))
            step_size = lever * jnp.max(jnp.abs(step[:positions]), initial=0.0)
            return z - step, factors, step_size, change, count + 1

        factors = factorise(jax.lax.stop_gradient(first))
        z, _, change, _, _ = jax.lax.while_loop(unsolved, once, (start, factors, jnp.inf, jnp.inf, 0))
        return z, change

    def tangent(g: Callable[..., Any], right: Float[Array, "r"]):
        # The corner keeps redundant constraints solvable, as in the step.
        corner = jax.lax.stop_gradient(first).at[:positions].set(0.0).at[:, :positions].set(0.0)
        return factorise(jax.jacfwd(g)(jnp.zeros_like(right)) + corner).solve(right)

    z, change = jax.lax.custom_root(residual, start, solve, tangent, has_aux=True)
    return z, change <= STEP_STALLED
