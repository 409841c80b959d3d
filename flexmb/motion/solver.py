"""Base classes of the solvers of motion, their term and interpolation for diffrax; they satisfy the constraints."""

from collections.abc import Callable
from typing import Any, ClassVar

import diffrax
from jaxtyping import Array, Float

from .protocol import Equations, MotionState
from .stages import state_within_step


class MotionTerm(diffrax.AbstractTerm):
    """Equations of motion as a term: a vector field for explicit solvers, the equations for others."""

    equations: Equations

    def vf(self, t: Any, y: MotionState, args: Any) -> MotionState:
        """Rates of the state."""
        z, _ = self.equations.acceleration(t, y)
        return MotionState(y.w, z[: y.w.shape[0]], self.equations.rate_of_memory(t, y, z))

    def contr(self, t0: Any, t1: Any, **kwargs: Any):
        """Length of the interval."""
        return t1 - t0

    def prod(self, vf: MotionState, control: Any) -> MotionState:
        """Rates times length of the interval."""
        return MotionState(*(control * rate for rate in vf))


def equations_of(terms: Any) -> Equations:
    """Equations of motion in a term, which diffrax may wrap in another term."""
    while not isinstance(terms, MotionTerm):
        terms = terms.term
    return terms.equations


class MotionInterpolation(diffrax.AbstractLocalInterpolation):
    """Positions and velocities between two steps: Hermite polynomials of order three in each."""

    t0: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    t1: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    y0: MotionState
    y1: MotionState
    a0: Float[Array, "n"]
    a1: Float[Array, "n"]
    within: ClassVar[Callable[..., MotionState]] = staticmethod(state_within_step)

    def evaluate(self, t0: Any, t1: Any = None, left: bool = True) -> MotionState:
        """State at a time, or its change over an interval."""
        del left
        if t1 is not None:
            first, last = self.evaluate(t0), self.evaluate(t1)
            return MotionState(*(b - a for a, b in zip(first, last, strict=True)))
        return self.within((self.t0, self.t1), (self.y0, self.y1), (self.a0, self.a1), t0)


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
