"""Base classes of the solvers of motion, which take the equations as they are and keep their constraints."""

from typing import Any

import diffrax

from .interpolation import MotionInterpolation
from .protocol import MotionState
from .term import MotionTerm


class MotionSolver(diffrax.AbstractSolver):
    """A solver that takes the equations of motion as they are, and keeps their constraints itself.

    Its ``step`` is to be under ``jit_beside_options``: diffrax traces it three times, and this keeps the first trace.
    """

    term_structure = MotionTerm
    interpolation_cls = MotionInterpolation

    def func(self, terms: MotionTerm, t0: Any, y0: MotionState, args: Any) -> MotionState:
        """Rates of the state."""
        return terms.vf(t0, y0, args)


class SecondOrderSolver(MotionSolver):
    """A method of order two with steps of a fixed size."""

    def order(self, terms: Any) -> int:
        """Order of the method."""
        return 2
