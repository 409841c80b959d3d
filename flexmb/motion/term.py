"""Equations of motion as a term of diffrax."""

from typing import Any

import diffrax

from .protocol import Equations, MotionState


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
