"""Base classes of the solvers of motion, which use the equations directly and satisfy their constraints."""

from typing import Any

import diffrax

from .interpolation import MotionInterpolation
from .protocol import MotionState
from .term import MotionTerm


class MotionSolver(diffrax.AbstractSolver):
    """A solver that uses the equations of motion directly, and satisfies their constraints itself.

    Decorate ``step`` with ``jit_beside_options``. diffrax traces it three times; the decorator keeps the first trace.
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
