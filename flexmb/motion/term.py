"""Equations of motion as diffrax takes them."""

import diffrax

from .protocol import Equations, MotionState


class MotionTerm(diffrax.AbstractTerm):
    """Equations of motion as a term: explicit solvers of diffrax see a vector field, others the equations.

    Attributes:
        equations: Equations of motion.
    """

    equations: Equations

    def vf(self, t, y: MotionState, args) -> MotionState:
        """Rates of the state."""
        z, _ = self.equations.acceleration(t, y)
        return MotionState(y.w, z[: y.w.shape[0]], self.equations.rate_of_memory(t, y, z))

    def contr(self, t0, t1, **kwargs):
        """Length of the interval."""
        return t1 - t0

    def prod(self, vf: MotionState, control) -> MotionState:
        """Rates times length of the interval."""
        return MotionState(*(control * rate for rate in vf))


def equations_of(terms) -> Equations:
    """Equations of motion in a term, which diffrax hands to solvers inside a term of its own."""
    while not isinstance(terms, MotionTerm):
        terms = terms.term
    return terms.equations
