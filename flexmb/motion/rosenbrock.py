"""A Rosenbrock method for second-order equations with constraints, as a diffrax solver."""

from typing import Any

import diffrax
import jax

from ..compilation.compile import jit_beside_options
from .balance import balanced_error
from .protocol import MotionState
from .solver import MotionSolver, MotionTerm, equations_of
from .stages import rosenbrock_step


class Rodas5P(MotionSolver, diffrax.AbstractAdaptiveSolver):
    """Stiffly accurate Rosenbrock method of order five with eight stages.

    One factorisation per step, one solve per stage; see :func:`rosenbrock_step`. Accelerations and multipliers are
    carried from step to step, and computed anew after a jump. After each step the state is brought back onto the
    constraints.

    Attributes:
        jumps: Whether loads may jump; each step then computes its first accelerations anew.
        balanced: Whether the error of a step includes its energy balance; :func:`simulate` sets it.

    Source:
        Steinebach (2023), BIT Numerical Mathematics 63, 27.
    """

    jumps: bool = False
    balanced: bool = False

    def order(self, terms: Any) -> int:
        """Return the order of the method.

        Args:
            terms: Not used.
        """
        return 5

    def init(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any):
        """Return accelerations and multipliers at the start.

        Args:
            terms: Equations of motion.
            t0: Start [s].
            t1: End of the first step [s].
            y0: State.
            args: Not used.
        """
        return equations_of(terms).acceleration(t0, y0)[0]

    @jit_beside_options
    def step(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any, solver_state: Any, made_jump: Any):
        """Return the result of one step.

        Args:
            terms: Equations of motion.
            t0: Start of the step [s].
            t1: End of the step [s].
            y0: State at the start of the step.
            args: Not used.
            solver_state: Accelerations and multipliers at the start of the step.
            made_jump: Whether loads jumped at the start of the step.
        """
        equations, n, z0 = equations_of(terms), y0.u.shape[0], solver_state
        if self.jumps:
            z0 = jax.lax.cond(made_jump, lambda: equations.acceleration(t0, y0)[0], lambda: solver_state)
        outcome = rosenbrock_step(equations, t0, t1 - t0, y0, z0, end=t1 if self.jumps else None)
        y1 = equations.settle(t1, outcome.end, outcome.mass)
        error: Any = outcome.error
        if self.balanced:
            error = balanced_error(equations, (t0, t1), (y0, y1), z0, outcome)
        dense = dict(y0=y0, y1=y1, a0=z0[:n], a1=outcome.z[:n])
        return y1, error, dense, outcome.z, diffrax.RESULTS.successful
