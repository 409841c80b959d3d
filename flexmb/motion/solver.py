"""Base classes of the solvers of motion, their term and interpolation for diffrax, and any diffrax solver projected."""

from collections.abc import Callable
from typing import Any, ClassVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..math.linear import factorise
from ..numerical_limits import REUSED_FACTORS, ROOT_FINDER, STEP_CONVERGED, STEP_STALLED
from .protocol import Equations, MotionState
from .stages import state_within_step

# Largest number of iterations of Newton's method in one step.
MOST = 40


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


def solve_step(
    residual: Callable[..., Any],
    matrix: Callable[..., Any],
    first: Float[Array, "r r"],
    start: Float[Array, "r"],
    positions: int,
    lever: Float[Array, ""],
) -> tuple[Float[Array, "r"], Bool[Array, ""]]:
    """Accelerations and multipliers of one time step, and whether the equations are solved; differentiable.

    Newton's method reuses its factors while it converges fast.

    Args:
        residual: Function of the unknowns.
        matrix: Its derivative, or an approximation, as a function of the unknowns.
        first: Value of ``matrix`` at the first guess.
        start: First guess.
        positions: Number of accelerations, the first unknowns.
        lever: Change of a position per change of its acceleration [s^2].
    """

    def solve(f: Callable[..., Any], start: Float[Array, "r"]):
        def unsolved(carry: tuple[Any, ...]):
            _, _, change, before, count = carry
            stalled = (change < STEP_STALLED) & (change > 0.5 * before)
            return (change > STEP_CONVERGED) & ~stalled & ~jnp.isnan(change) & (count < MOST)

        def once(carry: tuple[Any, ...]):
            z, factors, change, before, count = carry
            again = (count > 1) & (change > REUSED_FACTORS * before)
            factors = jax.lax.cond(again, lambda: factorise(matrix(z)), lambda: factors)
            step = factors.solve(f(z))
            step_size = lever * jnp.max(jnp.abs(step[:positions]), initial=0.0)
            return z - step, factors, step_size, change, count + 1

        factors = factorise(jax.lax.stop_gradient(first))
        z, _, change, _, _ = jax.lax.while_loop(unsolved, once, (start, factors, jnp.inf, jnp.inf, 0))
        return z, change

    def tangent(g: Callable[..., Any], right: Float[Array, "r"]):
        # The corner keeps redundant constraints solvable, as in the step.
        corner = jax.lax.stop_gradient(first).at[:positions].set(0.0).at[:, :positions].set(0.0)
        return factorise(jax.jacfwd(g)(jnp.zeros_like(right)) + corner).solve(right)

    z, change = jax.lax.custom_root(residual, start, solve, tangent, has_aux=True)
    return z, change <= STEP_STALLED
