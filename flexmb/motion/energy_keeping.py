"""An energy-keeping method for long motions without losses, as a diffrax solver of fixed steps."""

from typing import Any, cast

import diffrax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from .newton import solve_step
from .protocol import EnergyEquations, MotionState
from .solver import MotionTerm, SecondOrderSolver, equations_of


def _equations_of(terms: Any) -> EnergyEquations:
    """The equations in a term; :func:`flexmb.simulate` has checked that they suit this method."""
    return cast(EnergyEquations, equations_of(terms))


class EnergyKeeping(SecondOrderSolver):
    """Implicit method of second order that keeps energy: forces do exactly the work that the elements store.

    For constant stiffness and constant forces, the energy is constant to round-off, for any step size. The method damps
    nothing: vibrations that the steps do not resolve persist. Needs ``form="coordinates"`` and no controller.

    Source:
        Gonzalez (1996), J. Nonlinear Science 6, 449; with constraints (1999), Physica D 132, 165. Here the kinetic
        energy is a quadratic form of the rates of the inertia vectors s(x) (THEORY.md 3, eq. (3.1)). Each step passes
        these rates to the next step.
    """

    def init(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any):
        """Return accelerations and multipliers at the start, and the rates of the inertia vectors.

        Args:
            terms: Equations of motion.
            t0: Start [s].
            t1: End of the first step [s].
            y0: State.
            args: Not used.
        """
        equations = _equations_of(terms)
        return equations.acceleration(t0, y0)[0], equations.inertia_rates(t0, y0)

    @jit_beside_options
    def step(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any, solver_state: Any, made_jump: Any):
        """Return the result of one step.

        Args:
            terms: Equations of motion.
            t0: Start of the step [s].
            t1: End of the step [s].
            y0: State at the start of the step.
            args: Not used.
            solver_state: From :meth:`init`.
            made_jump: Not used.
        """
        equations = _equations_of(terms)
        h, n = t1 - t0, y0.u.shape[0]
        z0, rates = solver_state

        def at_end(z: Float[Array, "r"]):
            return MotionState(y0.u + h * y0.w + h**2 / 2 * z[:n], y0.w + h * z[:n], y0.memory)

        def residual(z: Float[Array, "r"]):
            state = at_end(z)
            force, _ = equations.forces_over_step((t0, t1), (y0, state), rates, z[n:])
            return jnp.concatenate([force, equations.gap(t1, state) / (h**2 / 2)])

        def matrix(z: Float[Array, "r"]):
            u = y0.u + h / 2 * y0.w + h**2 / 8 * z[:n]
            at = equations.tangent((t0 + t1) / 2, MotionState(u, y0.w + h / 2 * z[:n], y0.memory), z)
            return at.by_z.at[:n, :n].add(h / 2 * at.by_w[:n] + h**2 / 4 * at.by_u[:n])

        z1, solved = solve_step(residual, matrix, matrix(z0), z0, n, h**2 / 2)
        state = at_end(z1)
        _, rates = equations.forces_over_step((t0, t1), (y0, state), rates, z1[n:])
        y1 = MotionState(state.u, equations.velocities_of(t1, state, rates), state.memory)
        y1 = y1._replace(memory=equations.settle(t1, y1).memory)
        dense = dict(y0=y0, y1=y1, a0=z0[:n], a1=z1[:n])
        ok: Any = diffrax.RESULTS
        return y1, None, dense, (z1, rates), ok.where(solved, ok.successful, ok.nonlinear_divergence)
