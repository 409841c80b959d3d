"""Steps of Radau's method taken anew on the way back over the motion of a chain or a net, with their derivatives."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float

from .chain_form import ChainForm
from .collocation import (
    ONCE,
    TWICE,
    Carried,
    between_steps,
    carried_from,
    correction,
    foretold,
    matrices_of_step,
    pieces_of_step,
    share_of,
    size_of,
    states_at,
    times_of_stages,
    transposed_correction,
    turned_stages,
)
from .march_back import Method
from .protocol import MotionState

# Linear equations of a step are solved once what they change becomes this share; what stalls at round-off below the
# second number counts as solved too.
CHANGE, ROUND_OFF = 1e-10, 1e-7
MOST = 1000
# A step that is taken anew is solved once a turn of Newton's method changes this share of what may be left, and lost
# after so many turns.
SOLVED, TURNS = 0.1, 50


def radau(allowed: tuple[Any, Any]) -> Method:
    """How its steps are taken anew.

    Args:
        allowed: Relative and absolute tolerance.
    """
    step = functools.partial(stepped, allowed=allowed)
    return Method(step, between_steps, lambda carried: carried.z, carried_from, False)


def stepped(
    equations: ChainForm,
    times: tuple[Array, Array],
    state: MotionState,
    last: Carried,
    _: Any,
    near: Carried,
    *,
    allowed: tuple[Any, Any],
) -> tuple[MotionState, Carried]:
    """State at the end of a step and what is carried over to the next; differentiable in equations, times and state.

    Args:
        times: Its begin and end [s].
        state: State at its begin.
        last: From the step before.
        near: What is carried over from this step, as far as that is known; of length zero where it is not.
        allowed: Relative and absolute tolerance.

    Source:
        Implicit function theorem, THEORY.md 10, eq. (10.6).
    """
    own, at, begun, before, known = _constant(equations, times, state, last, near)
    found = lax.cond(known.length > 0, lambda: known.stages, lambda: _anew(own, at, begun, before, allowed))
    n, (begin, end) = state.u.shape[0], times
    h, linear = end - begin, _linear(own, at, begun, found)

    def residuals(z: Float[Array, "3 r"]):
        return jax.vmap(equations.residual)(times_of_stages(begin, h, end), states_at(state, h, z), z)

    def tangent(product: Callable[..., Any], right: Float[Array, "3 r"]):
        def solve(product: Callable[..., Any], right: Float[Array, "3 r"]):
            return _iterated(product, linear.correct, right, n)

        def transposed(_: Callable[..., Any], right: Float[Array, "3 r"]):
            return _iterated(linear.multiply_transposed, linear.correct_transposed, right, n)

        return lax.custom_linear_solve(product, right, solve, transpose_solve=transposed)

    z: Any = lax.custom_root(residuals, found, lambda _, z: z, tangent)
    reached = states_at(state, h, z)
    after = equations.settle(end, MotionState(reached.u[2], reached.w[2], state.memory))
    return after, Carried(z, lax.stop_gradient(h), before.rate)


def _constant(*arguments: Any) -> Any:
    """The same without derivatives."""
    return jax.tree.map(lax.stop_gradient, arguments)


def _anew(
    equations: ChainForm, times: tuple[Array, Array], state: MotionState, last: Carried, allowed: tuple[Any, Any]
) -> Float[Array, "3 r"]:
    """Stages of a step by Newton's method, NaN where it fails.

    On the way there matrices may have been those of an earlier step, which here are not at hand: each turn takes those
    of where it has come to.
    """
    begin, end = times
    h, n = end - begin, equations.size
    at = times_of_stages(begin, h, end)

    def unsolved(found: tuple[Array, Array, Array]):
        return (found[1] > SOLVED) & (found[2] < TURNS)

    def once_more(found: tuple[Array, Array, Array]):
        z, _, count = found
        pieces, x = pieces_of_step(equations, begin, h, state, z)
        reached = states_at(state, h, z)
        turns = turned_stages(equations, at, reached, x)
        residuals = jax.vmap(equations.residual)(at, reached, z)
        change = correction(equations, matrices_of_step(equations, pieces, h, x), turns, residuals)
        return z - change, share_of(size_of(change[:, :n], h), reached, allowed), count + 1

    z, share, _ = lax.while_loop(unsolved, once_more, (foretold(last, h), jnp.array(jnp.inf), jnp.array(0)))
    return jnp.where(share <= SOLVED, z, jnp.nan)


class _Linear(NamedTuple):
    """Linear equations of a step, for changes of its stages.

    Attributes:
        correct: What nearly solves them.
        correct_transposed: What nearly solves the transposed ones.
        multiply_transposed: Product of their transposed matrix.
    """

    correct: Callable[..., Any]
    correct_transposed: Callable[..., Any]
    multiply_transposed: Callable[..., Any]


def _linear(equations: ChainForm, times: tuple[Array, Array], state: MotionState, z: Float[Array, "3 r"]) -> _Linear:
    """Linear equations of a step at its stages, z; loads that depend on places are none of this form's."""
    begin, end = times
    h, n = end - begin, equations.size
    at, reached = times_of_stages(begin, h, end), states_at(state, h, z)
    pieces: Any = jax.vmap(equations.pieces)(at, reached, z)
    form, (t, u) = equations.form, (at[1], reached.u[1])
    # As those of every step, near its middle.
    matrices = matrices_of_step(equations, jax.tree.map(lambda of: of[1], pieces), h, form.whole(t, u, u, u).x)
    turns = turned_stages(equations, at, reached, matrices.at)
    by_z, by_w, by_u = (tuple(own.mT for own in of) for of in pieces)
    product = jax.vmap(equations.order.product)

    def multiply(forces: Float[Array, "3 r"]):
        by_rate, by_place = (product(of, forces)[:, :n] for of in (by_w, by_u))
        moved = h * (jnp.asarray(ONCE.T) @ by_rate) + h**2 * (jnp.asarray(TWICE.T) @ by_place)
        return product(by_z, forces).at[:, :n].add(moved)

    def by(correct: Callable[..., Any]):
        return lambda right: correct(equations, matrices, turns, right)

    return _Linear(by(correction), by(transposed_correction), multiply)


def _iterated(
    product: Callable[..., Any], correct: Callable[..., Any], right: Float[Array, "3 r"], n: int
) -> Float[Array, "3 r"]:
    """Solution of linear equations, corrected by what nearly solves them; NaN where that does not converge.

    Args:
        product: What is to become the right-hand side.
        correct: What nearly solves them.
        right: Right-hand side.
        n: How many of the unknowns of a stage, the first, tell the size of a change.
    """

    def size(of: Float[Array, "3 r"]):
        return jnp.max(jnp.abs(of[:, :n]), initial=0.0)

    def unsolved(carry: tuple[Any, ...]):
        _, change, before, count = carry
        stalled = (change < ROUND_OFF) & (change >= before)
        return (change > CHANGE) & ~stalled & (count < MOST)

    def once_more(carry: tuple[Any, ...]):
        z, before, _, count = carry
        step = correct(right - product(z))
        z = z + step
        whole = size(z)
        return z, jnp.where(whole > 0, size(step) / jnp.where(whole > 0, whole, 1.0), 0.0), before, count + 1

    start = (jnp.zeros_like(right), jnp.array(jnp.inf), jnp.array(jnp.inf), jnp.array(0))
    z, change, _, _ = lax.while_loop(unsolved, once_more, start)
    return jnp.where(change < ROUND_OFF, z, jnp.nan)
