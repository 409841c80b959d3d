"""Radau's method of order five for long chains, as a diffrax solver: few large steps, whose matrices stay sparse."""

from typing import Any, NamedTuple, cast

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from .chain_form import ChainForm
from .interpolation import MotionInterpolation
from .protocol import MotionState
from .solver import MotionSolver
from .step_control import LARGE
from .term import MotionTerm, equations_of

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
LEFT, ROUND_OFF = 0.02, 1e-14
MOST = 10


class Carried(NamedTuple):
    """What is carried from step to step.

    Attributes:
        z: Accelerations and multipliers at the end of the last step, (r,).
        stages: At its stages, (3, r).
        length: Of the last step, () [s]; zero where there is none.
    """

    z: Float[Array, "r"]
    stages: Float[Array, "3 r"]
    length: Float[Array, ""]


class RadauInterpolation(MotionInterpolation):
    """Positions between two steps by polynomials of order five, which also have the accelerations at both ends."""

    def evaluate(self, t0, t1=None, left: bool = True) -> MotionState:
        """State at a time, or its change over an interval."""
        del left
        if t1 is not None:
            first, last = self.evaluate(t0), self.evaluate(t1)
            return MotionState(*(b - a for a, b in zip(first, last, strict=True)))
        h = self.t1 - self.t0
        s = (t0 - self.t0) / jnp.where(h == 0, 1.0, h)
        y0, y1 = self.y0, self.y1
        # What the accelerations at the begin alone would not bring.
        u = y1.u - y0.u - h * y0.w - h**2 / 2 * self.a0
        w = h * (y1.w - y0.w) - h**2 * self.a0
        a = h**2 * (self.a1 - self.a0)
        third, fourth, fifth = 10 * u - 4 * w + a / 2, -15 * u + 7 * w - a, 6 * u - 3 * w + a / 2
        position = y0.u + s * h * (y0.w + s * h / 2 * self.a0) + s**3 * (third + s * (fourth + s * fifth))
        rate = s**2 * (3 * third + s * (4 * fourth + 5 * s * fifth))
        velocity = y0.w + s * h * self.a0 + rate / jnp.where(h == 0, 1.0, h)
        return MotionState(position, velocity, y0.memory + s * (y1.memory - y0.memory))


class Radau(MotionSolver, diffrax.AbstractAdaptiveSolver):
    """Radau IIA method of order five with three stages, stiffly accurate, solved by a simplified Newton method.

    One real and one complex factorisation a step, at a state near its middle that the last step foretells.

    Attributes:
        rtol: Of the steps, see :class:`flexmb.motion.Integrator`.
        atol: As well.
        jumps: Whether loads may jump, so that accelerations are found anew there.

    Source:
        Hairer, Wanner (1996), Solving Ordinary Differential Equations II, sections IV.5 and IV.8; for equations of
        second order THEORY.md 9, eq. (9.10).
    """

    rtol: Any = 1e-5
    atol: Any = 1e-13
    jumps: bool = False
    interpolation_cls = RadauInterpolation

    def order(self, terms) -> int:
        """Order of the method."""
        return 5

    def error_order(self, terms) -> int:
        """Order of the error estimate."""
        return 4

    def init(self, terms: MotionTerm, t0, t1, y0: MotionState, args):
        """What is carried, at the start."""
        return carried_from(equations_of(terms).acceleration(t0, y0)[0])

    @jit_beside_options
    def step(self, terms: MotionTerm, t0, t1, y0: MotionState, args, solver_state, made_jump):
        """One step.

        Args:
            terms: Equations of motion, in the form of chains.
            t0: Begin [s].
            t1: End [s].
            y0: State at the begin.
            args: Not used.
            solver_state: Of :meth:`init`.
            made_jump: Whether the loads jumped at the begin.
        """
        equations = cast(ChainForm, equations_of(terms))
        n = y0.u.shape[0]
        h: Any = t1 - t0
        last: Carried = solver_state
        if self.jumps:
            last = jax.lax.cond(made_jump, lambda: carried_from(equations.acceleration(t0, y0)[0]), lambda: last)
        nodes, once, twice = (jnp.asarray(of) for of in (NODES, ONCE, TWICE))

        def states(z):
            u = y0.u + h * nodes[:, None] * y0.w + h**2 * (twice @ z[:, :n])
            return MotionState(u, y0.w + h * (once @ z[:, :n]), jnp.broadcast_to(y0.memory, (3, *y0.memory.shape)))

        def residuals(z):
            return jax.vmap(equations.residual)(t0 + nodes * h, states(z), z)

        z = _foretold(last, h)
        pieces = equations.pieces(t0 + NODES[1] * h, jax.tree.map(lambda rows: rows[1], states(z)), z[1])
        real = equations.factors_of_step(pieces, h * STEP)
        other = equations.factors_of_step(pieces, h.astype(complex) * COMPLEX_STEP)

        def unsolved(carry):
            _, _, left, _, count = carry
            return (left > 1.0) & (count < MOST)

        def once_more(carry):
            z, before, _, _, count = carry
            right = jnp.asarray(TO_PARTS) @ residuals(z).astype(complex)
            first = equations.levels.solved(real, right[0].real)
            second = equations.levels.solved(other, right[1])
            change = jnp.asarray(FROM_PARTS[:, 0].real)[:, None] * first
            change = change + 2 * (jnp.asarray(FROM_PARTS[:, 1])[:, None] * second).real
            z = z - change
            size = h**2 * jnp.max(jnp.abs(twice @ change[:, :n]))
            scale = jnp.minimum(jnp.max(jnp.abs(states(z).u)), LARGE)
            allowed = LEFT * (self.rtol * scale + self.atol) + ROUND_OFF
            rate = jnp.where(count == 0, 0.5, size / before)
            # What is still to come, were all later changes smaller at this rate; no end is in sight at one and more.
            left = size / allowed * jnp.where(rate < 1, rate / jnp.maximum(1 - rate, 1e-3), 1e3)
            left = jnp.where(jnp.isnan(size) | ((rate > 2) & (count > 1)), jnp.nan, left)
            return z, size, left, rate, count + 1

        start = (z, jnp.array(jnp.inf), jnp.array(jnp.inf), jnp.array(1.0), jnp.array(0))
        z, _, left, _, _ = jax.lax.while_loop(unsolved, once_more, start)
        reached = states(z)
        # Filtered by the matrix of the step, so that stiff parts do not count.
        weights = jnp.asarray(ERROR)
        error_u = STEP * h * y0.w + weights @ (reached.u - y0.u)
        error_w = STEP * h * last.z[:n] + weights @ (reached.w - y0.w)
        moved = equations.product(pieces.by_w, error_w)
        moved = moved + equations.product(pieces.by_u, error_u + STEP * h * error_w)
        rate = -equations.levels.solved(real, moved)[:n]
        error_w = error_w + STEP * h * rate
        error_u = error_u + STEP * h * error_w
        wrong = ~(left <= 1.0)
        error = MotionState(_unless(wrong, error_u), _unless(wrong, error_w), jnp.zeros_like(y0.memory))
        y1 = equations.settle(t1, MotionState(reached.u[2], reached.w[2], y0.memory))
        dense = dict(y0=y0, y1=y1, a0=last.z[:n], a1=z[2, :n])
        return y1, error, dense, Carried(z[2], z, h), diffrax.RESULTS.successful


def carried_from(z) -> Carried:
    """What is carried where no step went before.

    Args:
        z: Accelerations and multipliers, (r,).
    """
    return Carried(z, jnp.broadcast_to(z, (3, *z.shape)), jnp.zeros(()))


def _foretold(last: Carried, h):
    """Guess of the stages: the polynomial through those of the last step goes on."""
    ratio = jnp.where(last.length > 0, h / jnp.where(last.length > 0, last.length, 1.0), 0.0)
    at = 1 + ratio * jnp.asarray(NODES)
    powers = jnp.stack([jnp.ones(3), at, at**2], axis=1)
    return powers @ jnp.asarray(np.linalg.inv(_POWERS)) @ last.stages


def _unless(wrong, error):
    """A step that went wrong has an error without bound, so that it is refused and shortened."""
    return jnp.where(wrong | ~jnp.isfinite(error), jnp.inf, error)
