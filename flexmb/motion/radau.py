"""Radau's method of order five for long chains, as a diffrax solver: few large steps, whose matrices stay sparse."""

from typing import Any, cast

import diffrax
import jax

from ..compilation.compile import jit_beside_options
from .chain_form import ChainForm
from .collocation import between_steps, carried_from, collocated, foretold, matrices_of_step, pieces_of_step
from .interpolation import MotionInterpolation
from .protocol import MotionState
from .solver import MotionSolver
from .term import MotionTerm, equations_of


class RadauInterpolation(MotionInterpolation):
    """Positions between two steps by polynomials of order five, which also have the accelerations at both ends."""

    within = staticmethod(between_steps)


class Radau(MotionSolver, diffrax.AbstractAdaptiveSolver):
    """Radau IIA method of order five with three stages, stiffly accurate, solved by a simplified Newton method.

    One real and one complex factorisation a step, at a state near its middle that the last step foretells.

    Attributes:
        rtol: Of the steps, see :class:`flexmb.motion.Integrator`.
        atol: As well.
        jumps: Whether loads may jump, so that accelerations are found anew there.

    Source:
        See :func:`flexmb.motion.collocation.collocated`.
    """

    rtol: Any = 1e-5
    atol: Any = 1e-13
    jumps: bool = False
    interpolation_cls = RadauInterpolation

    def order(self, terms: Any) -> int:
        """Order of the method."""
        return 5

    def error_order(self, terms: Any) -> int:
        """Order of the error estimate."""
        return 4

    def init(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any):
        """What is carried, at the start."""
        return carried_from(equations_of(terms).acceleration(t0, y0)[0])

    @jit_beside_options
    def step(
        self,
        terms: MotionTerm,
        t0: Any,
        t1: Any,
        y0: MotionState,
        args: Any,
        solver_state: Any,
        made_jump: Any,
    ):
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
        equations, n, h = cast(ChainForm, equations_of(terms)), y0.u.shape[0], t1 - t0
        last = solver_state
        if self.jumps:
            last = jax.lax.cond(made_jump, lambda: carried_from(equations.acceleration(t0, y0)[0]), lambda: last)
        z = foretold(last, h)
        pieces, at = pieces_of_step(equations, t0, h, y0, z)
        matrices = matrices_of_step(equations, pieces, h, at)
        taken = collocated(equations, t0, h, y0, last, z, matrices, (self.rtol, self.atol), t1 if self.jumps else None)
        dense = dict(y0=y0, y1=taken.end, a0=last.z[:n], a1=taken.carried.z[:n])
        return taken.end, taken.error, dense, taken.carried, diffrax.RESULTS.successful
