"""One step of Radau's method of order five for long chains, whose matrices stay block tridiagonal."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..mechanics.sparse_order import Factors
from ..mechanics.turning import Turns
from .chain_form import ChainForm, ResidualPieces
from .protocol import MotionState
from .step_size import LARGE

NODES = np.array([(4 - 6**0.5) / 10, (4 + 6**0.5) / 10, 1.0])
_POWERS = np.vander(NODES, 3, increasing=True)
# Weights of the stages in the velocities at the stages, and twice so in the positions.
ONCE = (NODES[:, None] ** [1, 2, 3] / [1, 2, 3]) @ np.linalg.inv(_POWERS)
TWICE = ONCE @ ONCE
_EIGEN: Any = np.linalg.eig(ONCE)
_VALUES, _VECTORS = _EIGEN
_REAL, _COMPLEX = int(np.argmin(np.abs(_VALUES.imag))), int(np.argmax(_VALUES.imag))
# The three stages fall apart into a real system and a complex one, whose conjugate is the third.
STEP, COMPLEX_STEP = float(_VALUES[_REAL].real), complex(_VALUES[_COMPLEX])
TO_PARTS = np.linalg.inv(_VECTORS)[[_REAL, _COMPLEX]]
FROM_PARTS = _VECTORS[:, [_REAL, _COMPLEX]]
# Weights of the changes at the stages in the error estimate.
ERROR = STEP / 3 * np.array([-13 - 7 * 6**0.5, -13 + 7 * 6**0.5, -1.0])
# Newton's method ends where what is left is this share of the tolerance of a step; round-off is no sooner overcome.
LEFT, ROUND_OFF = 0.01, 1e-14
MOST = 10
# Convergence slower than this is none, and the first turn of a step is not trusted to converge quicker than that.
SLOW, TRUSTED = 0.99, 1e-3
# A change as small as this share of what may be left ends it at any rate: nothing else is to be had at rest.
SMALL = 1e-3


class Carried(NamedTuple):
    """What is carried from step to step.

    Attributes:
        stages: Accelerations and multipliers at the stages of the last step, (3, r).
        length: Of the last step, () [s]; zero where there is none.
        rate: At which Newton's method converged last.
    """

    stages: Float[Array, "3 r"]
    length: Float[Array, ""]
    rate: Float[Array, ""]

    @property
    def z(self) -> Float[Array, "r"]:
        """Accelerations and multipliers at the end of the last step, (r,)."""
        return self.stages[2]


class StepMatrices(NamedTuple):
    """Matrices of one step.

    Attributes:
        pieces: Derivatives of the residual, element by element.
        real: Factors of the real system.
        other: Factors of the complex one.
        at: Nodal coordinates that they belong to, (n_x,) [m, rad, -].
    """

    pieces: ResidualPieces
    real: Factors
    other: Factors
    at: Float[Array, "n_x"]


class Collocated(NamedTuple):
    """What a step leads to.

    Attributes:
        end: State at its end, brought back onto the constraints.
        error: Estimate of its error; without bound where the equations were not solved.
        carried: To the next step.
        turns: How many turns Newton's method took.
        solved: Whether it converged.
    """

    end: MotionState
    error: MotionState
    carried: Carried
    turns: Int[Array, ""]
    solved: Bool[Array, ""]


def carried_from(z: Float[Array, "r"]) -> Carried:
    """What is carried where no step went before.

    Args:
        z: Accelerations and multipliers, (r,).
    """
    return Carried(jnp.broadcast_to(z, (3, *z.shape)), jnp.zeros(()), jnp.ones(()))


def foretold(last: Carried, h: Float[Array, ""]):
    """Guess of the stages: the polynomial through those of the last step goes on."""
    ratio = jnp.where(last.length > 0, h / jnp.where(last.length > 0, last.length, 1.0), 0.0)
    at = 1 + ratio * jnp.asarray(NODES)
    powers = jnp.stack([jnp.ones(3), at, at**2], axis=1)
    return powers @ jnp.asarray(np.linalg.inv(_POWERS)) @ last.stages


def states_at(state: MotionState, h: Float[Array, ""], z: Float[Array, "3 r"]) -> MotionState:
    """States at the stages of a step, rows of the accelerations z there, (3, r)."""
    n = state.u.shape[0]
    nodes, once, twice = (jnp.asarray(of) for of in (NODES, ONCE, TWICE))
    u = state.u + h * nodes[:, None] * state.w + h**2 * (twice @ z[:, :n])
    return MotionState(u, state.w + h * (once @ z[:, :n]), jnp.broadcast_to(state.memory, (3, *state.memory.shape)))


def pieces_of_step(
    equations: ChainForm, t: Float[Array, ""], h: Float[Array, ""], state: MotionState, z: Float[Array, "3 r"]
) -> tuple[ResidualPieces, Float[Array, "n_x"]]:
    """Derivatives of the residual near the middle of a step, whose stages are guessed to be z, (3, r), and where."""
    t, at = t + NODES[1] * h, jax.tree.map(lambda rows: rows[1], states_at(state, h, z))
    return equations.pieces(t, at, z[1]), equations.form.whole(t, at.u, at.w, at.u).x


def matrices_of_step(
    equations: ChainForm, pieces: ResidualPieces, h: Float[Array, ""], x: Float[Array, "n_x"]
) -> StepMatrices:
    """Factors of one step."""
    real = equations.factors_of_step(pieces, h * STEP)
    return StepMatrices(pieces, real, equations.factors_of_step(pieces, h.astype(complex) * COMPLEX_STEP), x)


class Stages(NamedTuple):
    """Solution of the equations of a step.

    Attributes:
        z: Accelerations and multipliers at the stages, (3, r).
        rate: At which Newton's method converged.
        turns: How many turns it took.
        solved: Whether it converged.
    """

    z: Float[Array, "3 r"]
    rate: Float[Array, ""]
    turns: Int[Array, ""]
    solved: Bool[Array, ""]


def times_of_stages(t: Float[Array, ""], h: Float[Array, ""], end: Any = None) -> Float[Array, "3"]:
    """Times of the stages of a step, none later than its end where that is given [s]."""
    times = t + jnp.asarray(NODES) * h
    return times if end is None else jnp.minimum(times, end)


def turned_stages(equations: ChainForm, times: Float[Array, "3"], states: MotionState, x: Float[Array, "n_x"]) -> Turns:
    """How the nodes have turned from a place, x, until the stages of a step, whose states are rows."""

    def since(t: Float[Array, ""], u: Float[Array, "n"]):
        return equations.order.turning.since(equations.form.whole(t, u, u, u).x, x)

    return jax.vmap(since)(times, states.u)


def _by_parts(order: Any, matrices: StepMatrices, right: Float[Array, "3 r"], into: Any, back: Any, transposed: bool):
    """The three stages, or their transposed equations, by the real system and the complex one."""
    parts = jnp.asarray(into) @ right.astype(complex)
    first = order.solved(matrices.real, parts[0].real, transposed)
    second = order.solved(matrices.other, parts[1], transposed)
    return jnp.asarray(back[:, 0].real)[:, None] * first + 2 * (jnp.asarray(back[:, 1])[:, None] * second).real


def correction(equations: ChainForm, matrices: StepMatrices, turns: Turns, residuals: Float[Array, "3 r"]):
    """Change of the stages by a turn of Newton's method, (3, r).

    Nodes turn between the stages, which stiff beams feel first of all: the matrices turn along.

    Args:
        matrices: Of the step, or of one like it.
        turns: Of each stage, since what the matrices belong to.
        residuals: At the stages.
    """
    n, turning = equations.size, equations.order.turning
    right = jax.vmap(turning.turned_back)(turns, residuals)
    change = _by_parts(equations.order, matrices, right, TO_PARTS, FROM_PARTS, False)
    # It is displacements that turn, not accelerations.
    moved = jax.vmap(turning.turned)(turns, jnp.asarray(TWICE) @ change)[:, :n]
    return jnp.concatenate([jnp.asarray(np.linalg.inv(TWICE)) @ moved, change[:, n:]], axis=1)


def transposed_correction(equations: ChainForm, matrices: StepMatrices, turns: Turns, along: Float[Array, "3 r"]):
    """The transpose of :func:`correction`, (3, r)."""
    n, turning = equations.size, equations.order.turning
    moved = jnp.asarray(np.linalg.inv(TWICE).T) @ along[:, :n]
    moved = jnp.concatenate([moved, jnp.zeros_like(along[:, n:])], axis=1)
    change = jnp.asarray(TWICE.T) @ jax.vmap(turning.turned_back)(turns, moved)
    change = jnp.concatenate([change[:, :n], along[:, n:]], axis=1)
    right = _by_parts(equations.order, matrices, change, FROM_PARTS.T, TO_PARTS.T, True)
    return jax.vmap(turning.turned)(turns, right)


def size_of(change: Float[Array, "3 n"], h: Float[Array, ""]) -> Float[Array, ""]:
    """Greatest change of a position at the stages, of changes of the accelerations there, in a step of length h [s]."""
    return h**2 * jnp.max(jnp.abs(jnp.asarray(TWICE) @ change))


def share_of(size: Float[Array, ""], reached: MotionState, allowed: tuple[Any, Any]) -> Float[Array, ""]:
    """Size of a change over what Newton's method may leave.

    Args:
        size: See :func:`size_of`.
        reached: States at the stages, in rows.
        allowed: Relative and absolute tolerance.
    """
    rtol, atol = allowed
    scale = jnp.minimum(jnp.max(jnp.abs(reached.u)), LARGE)
    return size / (LEFT * (rtol * scale + atol) + ROUND_OFF)


def solved_stages(
    equations: ChainForm,
    times: Float[Array, "3"],
    h: Float[Array, ""],
    state: MotionState,
    before: Float[Array, ""],
    z: Float[Array, "3 r"],
    matrices: StepMatrices,
    allowed: tuple[Any, Any],
) -> Stages:
    """The stages of a step, by Newton's method.

    Args:
        times: Of the stages [s].
        h: Length [s].
        state: State at the begin.
        before: Rate at which it converged in the last step.
        z: Guess of the stages.
        matrices: Of this step, or of one like it.
        allowed: Relative and absolute tolerance.
    """
    n = state.u.shape[0]
    turns = turned_stages(equations, times, states_at(state, h, z), matrices.at)

    def unsolved(carry: tuple[Any, ...]):
        _, _, _, left, count = carry
        return (left > 1.0) & (count < MOST)

    def once_more(carry: tuple[Any, ...]):
        z, before, rate, _, count = carry
        reached = states_at(state, h, z)
        residuals = jax.vmap(equations.residual)(times, reached, z)
        change = correction(equations, matrices, turns, residuals)
        z = z - change
        size = size_of(change[:, :n], h)
        share = share_of(size, reached, allowed)
        # Of three and more turns the mean of two rates.
        rate = jnp.where(count == 0, rate, jnp.where(count == 1, size / before, jnp.sqrt(rate * size / before)))
        # What is still to come, were all later changes smaller at this rate.
        left = share * rate / (1 - rate)
        hopeless = (rate >= SLOW) | (left * rate ** (MOST - 1 - count) > 1.0)
        left = jnp.where(jnp.isnan(size) | (hopeless & (count > 0)), jnp.nan, jnp.where(rate < 1, left, jnp.inf))
        return z, size, rate, jnp.where(share <= SMALL, 0.0, left), count + 1

    one = jnp.ones(())
    # As RADAU5 has it: the rate of the last step, trusted a little less.
    expected = jnp.maximum(before**0.8, TRUSTED)
    start = (z, one, expected, jnp.array(jnp.inf), jnp.array(0))
    z, _, rate, left, count = jax.lax.while_loop(unsolved, once_more, start)
    solved = left <= 1.0
    return Stages(z, jnp.where(solved, rate, one), count, solved)


def collocated(
    equations: ChainForm,
    t: Float[Array, ""],
    h: Float[Array, ""],
    state: MotionState,
    last: Carried,
    z: Float[Array, "3 r"],
    matrices: StepMatrices,
    allowed: tuple[Any, Any],
    end: Any = None,
) -> Collocated:
    """One step.

    Args:
        t: Begin [s].
        h: Length [s].
        state: State at the begin.
        last: From the last step.
        z: Guess of the stages, (3, r).
        matrices: Of this step, or of one like it.
        allowed: Relative and absolute tolerance.
        end: End, where round-off of begin and length must not lead beyond it, as over a jump of the loads [s].

    Source:
        Hairer, Wanner (1996), Solving Ordinary Differential Equations II, sections IV.5 and IV.8; for equations of
        second order THEORY.md 9, eq. (9.10).
    """
    n = state.u.shape[0]
    weights, order, turning = jnp.asarray(ERROR), equations.order, equations.order.turning
    solution = solved_stages(equations, times_of_stages(t, h, end), h, state, last.rate, z, matrices, allowed)
    z, solved = solution.z, solution.solved
    reached = states_at(state, h, z)
    # Filtered by the matrix of the step, so that stiff parts do not count.
    error_u = STEP * h * state.w + weights @ (reached.u - state.u)
    error_w = STEP * h * last.z[:n] + weights @ (reached.w - state.w)
    turn = turning.since(equations.form.whole(t, state.u, state.u, state.u).x, matrices.at)
    own_u, own_w = (turning.turned_back(turn, of) for of in (error_u, error_w))
    moved = equations.product(matrices.pieces.by_w, own_w)
    moved = moved + equations.product(matrices.pieces.by_u, own_u + STEP * h * own_w)
    error_w = error_w - STEP * h * turning.turned(turn, order.solved(matrices.real, moved)[:n])
    error_u = error_u + STEP * h * error_w
    error = MotionState(_unless(solved, error_u), _unless(solved, error_w), jnp.zeros_like(state.memory))
    settled = equations.settle(t + h, MotionState(reached.u[2], reached.w[2], state.memory))
    carried = Carried(z, h, solution.rate)
    return Collocated(settled, error, carried, solution.turns, solved)


def _unless(solved: Bool[Array, ""], error: Float[Array, "n"]):
    """A step that went wrong has an error without bound, so that it is refused and shortened."""
    return jnp.where(solved & jnp.isfinite(error), error, jnp.inf)


def between_steps(
    times: tuple[Any, Any], states: tuple[MotionState, MotionState], rates: tuple[Any, Any], t: Float[Array, ""]
):
    """State within a step: positions by polynomials of order five, which have the accelerations at both ends.

    Args:
        times: Begin and end of the step [s].
        states: There.
        rates: Accelerations there, (n,) [1/s^2].
        t: Time [s].
    """
    (t0, t1), (y0, y1), (a0, a1) = times, states, rates
    h = t1 - t0
    s = (t - t0) / jnp.where(h == 0, 1.0, h)
    # What the accelerations at the begin alone would not bring.
    u = y1.u - y0.u - h * y0.w - h**2 / 2 * a0
    w = h * (y1.w - y0.w) - h**2 * a0
    a = h**2 * (a1 - a0)
    third, fourth, fifth = 10 * u - 4 * w + a / 2, -15 * u + 7 * w - a, 6 * u - 3 * w + a / 2
    position = y0.u + s * h * (y0.w + s * h / 2 * a0) + s**3 * (third + s * (fourth + s * fifth))
    rate = s**2 * (3 * third + s * (4 * fourth + 5 * s * fifth))
    velocity = y0.w + s * h * a0 + rate / jnp.where(h == 0, 1.0, h)
    return MotionState(position, velocity, y0.memory + s * (y1.memory - y0.memory))
