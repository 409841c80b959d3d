"""Equations of one time step, solved by a Newton method that keeps its factors as long as they serve."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..math.linear import factorise

# The factorised matrix is kept as long as each iteration brings down the change to this share of the one before.
SERVES = 0.2
# Displacements over their sizes change by less than this once a step is solved; what stalls at round-off below the
# second number counts as solved too.
CHANGE = 1e-14
ROUND_OFF = 1e-10
MOST = 40


def solve_step(
    residual: Callable[..., Any],
    matrix: Callable[..., Any],
    first: Float[Array, "r r"],
    start: Float[Array, "r"],
    positions: int,
    lever: Float[Array, ""],
) -> tuple[Float[Array, "r"], Bool[Array, ""]]:
    """Accelerations and multipliers of one time step.

    Args:
        residual: Function of the unknowns, (r,) to (r,).
        matrix: Its derivative as a function of the unknowns, or what is close to it, (r,) to (r, r).
        first: The value of ``matrix`` at the first guess, (r, r).
        start: First guess, (r,).
        positions: How many of the unknowns, the first, are accelerations.
        lever: How much a position changes with its acceleration [s^2].

    Returns:
        Unknowns, (r,), and whether the equations are solved. Derivatives are those of the solution.

    Source:
        Newton's method; implicit function theorem.
    """

    def solve(f: Callable[..., Any], start: Float[Array, "r"]):
        def unsolved(carry: tuple[Any, ...]):
            _, _, change, before, count = carry
            stalled = (change < ROUND_OFF) & (change > 0.5 * before)
            return (change > CHANGE) & ~stalled & ~jnp.isnan(change) & (count < MOST)

        def once(carry: tuple[Any, ...]):
            z, factors, change, before, count = carry
            again = (count > 1) & (change > SERVES * before)
            factors = jax.lax.cond(again, lambda: factorise(matrix(z)), lambda: factors)
            step = factors.solve(f(z))
            now = lever * jnp.max(jnp.abs(step[:positions]), initial=0.0)
            return z - step, factors, now, change, count + 1

        factors = factorise(jax.lax.stop_gradient(first))
        z, _, change, _, _ = jax.lax.while_loop(unsolved, once, (start, factors, jnp.inf, jnp.inf, 0))
        return z, change

    def tangent(g: Callable[..., Any], right: Float[Array, "r"]):
        # What keeps redundant constraints solvable does so here too.
        corner = jax.lax.stop_gradient(first).at[:positions].set(0.0).at[:, :positions].set(0.0)
        return factorise(jax.jacfwd(g)(jnp.zeros_like(right)) + corner).solve(right)

    z, change = jax.lax.custom_root(residual, start, solve, tangent, has_aux=True)
    return z, change <= ROUND_OFF
