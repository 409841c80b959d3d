"""Any solver of diffrax, with the state brought back onto the constraints after each step."""

from typing import Any

import diffrax
import equinox as eqx
import jax.numpy as jnp

from .protocol import MotionState
from .term import equations_of

# The root finder of an implicit solver may be off by so much, as share of the relative tolerance of a step.
LEFT = 1e-3


class Projected(diffrax.AbstractWrappedSolver):
    """A solver of diffrax whose every step ends on the constraints.

    Attributes:
        solver: The solver.
    """

    solver: diffrax.AbstractSolver  # pyright: ignore[reportIncompatibleVariableOverride]

    @property
    def term_structure(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """That of the solver."""
        return self.solver.term_structure

    @property
    def interpolation_cls(self):  # pyright: ignore[reportIncompatibleMethodOverride]
        """That of the solver."""
        return self.solver.interpolation_cls

    @property
    def root_finder(self):
        """That of an implicit solver."""
        return self.solver.root_finder  # pyright: ignore[reportAttributeAccessIssue]

    def with_tolerances(self, controller: Any) -> "Projected":
        """The same with the root finder of an implicit solver at the tolerances of a step size controller.

        Args:
            controller: Of diffrax; one of fixed steps has none, and the root finder needs its own.
        """
        if not isinstance(self.solver, diffrax.AbstractImplicitSolver) or not hasattr(controller, "rtol"):
            return self
        unset = diffrax.Kvaerno3().root_finder.rtol  # pyright: ignore[reportAttributeAccessIssue]
        # Far below what a step may be off by, but not down to round-off, which Newton's method would not reach.
        atol = jnp.maximum(controller.atol, LEFT * controller.rtol)
        given = {"rtol": controller.rtol, "atol": atol, "norm": controller.norm}
        names = [name for name in given if getattr(self.solver.root_finder, name) is unset]

        def tolerances(projected: Any):
            return [getattr(projected.solver.root_finder, name) for name in names]

        return eqx.tree_at(tolerances, self, [given[name] for name in names])

    def order(self, terms: Any):
        """That of the solver."""
        return self.solver.order(terms)

    def error_order(self, terms: Any):
        """That of the solver."""
        return self.solver.error_order(terms)

    def init(self, terms: Any, t0: Any, t1: Any, y0: MotionState, args: Any):
        """That of the solver."""
        return self.solver.init(terms, t0, t1, y0, args)

    def func(self, terms: Any, t0: Any, y0: MotionState, args: Any):
        """That of the solver."""
        return self.solver.func(terms, t0, y0, args)

    def step(
        self,
        terms: Any,
        t0: Any,
        t1: Any,
        y0: MotionState,
        args: Any,
        solver_state: Any,
        made_jump: Any,
    ):
        """A step of the solver, then the constraints."""
        y1, error, dense, state, result = self.solver.step(terms, t0, t1, y0, args, solver_state, made_jump)
        return equations_of(terms).settle(t1, y1), error, dense, state, result
