"""The generalised-alpha method for second-order equations with constraints, as a diffrax solver of fixed steps."""

from typing import Any

import diffrax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..arguments import check_number
from ..compilation.compile import jit_beside_options
from .protocol import MotionState, Tangent
from .solver import MotionTerm, SecondOrderSolver, equations_of, solve_step


class GeneralizedAlpha(SecondOrderSolver):
    """Generalised-alpha method: second order, with adjustable damping of vibrations that the steps do not resolve.

    The positions of each step satisfy the constraints; afterwards its velocities are projected onto them.

    Attributes:
        radius: Spectral radius: share of an unresolved vibration that remains after a step, from 0 to 1 [-]. With 1,
            the method is the trapezoidal rule: it keeps the whole vibration and may gain energy when bodies turn.

    Source:
        Chung, Hulbert (1993), J. Applied Mechanics 60, 371; with constraints: Arnold, Bruels (2007), Multibody System
        Dynamics 18, 185.
    """

    radius: float = 0.8

    def __check_init__(self):
        """Raise ValueError for a radius beyond its range, with which errors grow without limit."""
        check_number("radius", self.radius, least=0, most=1)

    def init(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any):
        """Return accelerations and multipliers at the start, and the mean accelerations of the method.

        Args:
            terms: Equations of motion.
            t0: Start [s].
            t1: End of the first step [s].
            y0: State.
            args: Not used.
        """
        z, _ = equations_of(terms).acceleration(t0, y0)
        return z, z[: y0.u.shape[0]]

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
        equations, h, n = equations_of(terms), t1 - t0, y0.u.shape[0]
        z0, mean0 = solver_state
        mass_share, force_share = (2 * self.radius - 1) / (self.radius + 1), self.radius / (self.radius + 1)
        gamma = 0.5 + force_share - mass_share
        beta = (0.5 + gamma) ** 2 / 4
        share = (1 - force_share) / (1 - mass_share)
        by_w, by_u = h * gamma * share, h**2 * beta * share

        def at_end(z: Float[Array, "r"]):
            mean = ((1 - force_share) * z[:n] + force_share * z0[:n] - mass_share * mean0) / (1 - mass_share)
            u = y0.u + h * y0.w + h**2 * ((0.5 - beta) * mean0 + beta * mean)
            return MotionState(u, y0.w + h * ((1 - gamma) * mean0 + gamma * mean), y0.memory), mean

        def residual(z: Float[Array, "r"]):
            state, _ = at_end(z)
            return jnp.concatenate([equations.residual(t1, state, z)[:n], equations.gap(t1, state) / by_u])

        def assembled(at: Tangent):
            return at.by_z.at[:n, :n].add(by_w * at.by_w[:n] + by_u * at.by_u[:n])

        def matrix(z: Float[Array, "r"]):
            return assembled(equations.tangent(t1, at_end(z)[0], z))

        tangent = equations.tangent(t1, at_end(z0)[0], z0)
        z1, solved = solve_step(residual, matrix, assembled(tangent), z0, n, by_u)
        state, mean = at_end(z1)
        y1 = equations.settle(t1, state, tangent.by_z[:n, :n])
        dense = dict(y0=y0, y1=y1, a0=z0[:n], a1=z1[:n])
        ok: Any = diffrax.RESULTS
        return y1, None, dense, (z1, mean), ok.where(solved, ok.successful, ok.nonlinear_divergence)
