"""Any diffrax solver, with the state brought back onto the constraints after each step."""

from typing import Any

import diffrax
import equinox as eqx
import jax.numpy as jnp

from ..numerical_limits import ROOT_FINDER
from .protocol import MotionState
from .solver import equations_of


class Projected(diffrax.AbstractWrappedSolver):
    """A diffrax solver whose steps all end on the constraints."""

    solver: diffrax.AbstractSolver  # pyright: ignore[reportIncompatibleVariableOverride]

    @property
    def term_structure(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """From the solver."""
        return self.solver.term_structure

    @property
    def interpolation_cls(self):  # pyright: ignore[reportIncompatibleMethodOverride]
        """From the solver."""
        return self.solver.interpolation_cls

    @property
    def root_finder(self):
        """From an implicit solver."""
        return self.solver.root_finder  # pyright: ignore[reportAttributeAccessIssue]

    def with_tolerances(self, controller: Any) -> "Projected":
        """Copy whose root finder has the tolerances of an adaptive step size controller, where none were given."""
        if not isinstance(self.solver, diffrax.AbstractImplicitSolver) or not hasattr(controller, "rtol"):
            return self
        unset = diffrax.Kvaerno3().root_finder.rtol  # pyright: ignore[reportAttributeAccessIssue]
        # Far below the error of a step, but above round-off, which Newton's method would not reach.
        atol = jnp.maximum(controller.atol, ROOT_FINDER * controller.rtol)
        options = {"rtol": controller.rtol, "atol": atol, "norm": controller.norm}
        names = [name for name in options if getattr(self.solver.root_finder, name) is unset]

        def tolerances(projected: Any):
            return [getattr(projected.solver.root_finder, name) for name in names]

        return eqx.tree_at(tolerances, self, [options[name] for name in names])

    def order(self, terms: Any):
        """From the solver."""
        return self.solver.order(terms)

    def error_order(self, terms: Any):
        """From the solver."""
        return self.solver.error_order(terms)

    def init(self, terms: Any, t0: Any, t1: Any, y0: MotionState, args: Any):
        """From the solver."""
        return self.solver.init(terms, t0, t1, y0, args)

    def func(self, terms: Any, t0: Any, y0: MotionState, args: Any):
        """From the solver."""
        return self.solver.func(terms, t0, y0, args)

    def step(self, terms: Any, t0: Any, t1: Any, y0: MotionState, args: Any, solver_state: Any, made_jump: Any):
        """A step of the solver, then projection onto the constraints."""
        y1, error, dense, state, result = self.solver.step(terms, t0, t1, y0, args, solver_state, made_jump)
        return equations_of(terms).settle(t1, y1), error, dense, state, result
