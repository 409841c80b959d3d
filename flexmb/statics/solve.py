"""Equilibrium in the degrees of freedom, by dense matrices, and its derivatives."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..math.linear import diagonal_of, factorise
from ..mechanics.deformation import deformation_jacobian, zero_strain
from ..mechanics.inertia import InertialLoad, weight
from ..mechanics.loads import LoadFactors, has_loads, nodal_forces, scaled_loads
from ..mechanics.residual import State, iterate, linear_response, state
from ..mechanics.stress_resultants import element_stiffness, is_nonlinear_at_rest, stress_resultants
from ..model.topology import Parameters, Topology
from ..numerical_limits import DEFORMATION_ROUND_OFF
from ..results import RESULTS
from .newton_search import Begin, Correction, Iterate, MatrixForm, Searched, prescribed_values, search_equilibrium
from .newton_search import unloaded_start as undeformed_of


class TurnInFreedoms:
    """:class:`flexmb.statics.newton_search.Turn` in the degrees of freedom."""

    def __init__(
        self, topology: Topology, parameters: Parameters, factors: LoadFactors, trial: Iterate, prescribed: Any
    ):
        x, last_strain, strained, _ = trial
        at, self.onto, self.residual = iterate(topology, parameters, factors, x, last_strain, strained, prescribed)
        self.last, self.e, self._k0 = at, at.e, at.K0

    def deformed(self, change: Float[Array, "n_x"]) -> Float[Array, "n_e"]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        return self.last.jacobian @ change

    def is_round_off(self, sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        at = self.last
        error = DEFORMATION_ROUND_OFF * jnp.abs(at.jacobian) @ sizes
        largest = jnp.abs(at.transfer.DFe).T @ (jnp.abs(at.S) @ error)
        return jnp.all(jnp.abs(self.residual) <= largest)

    def stiffnesses(self) -> Float[Array, "n_q"]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        return diagonal_of(self._k0)

    def energy(self, motion: Float[Array, "n_q"]) -> Float[Array, ""]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        return motion @ self._k0 @ motion

    def corrected(self, soft: Float[Array, "n_q"]) -> Correction:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        at, k0 = self.last, self._k0
        dq, softer = factorise(k0 + at.G0).solve(jnp.stack([-self.residual, k0 @ soft], axis=1)).T
        change = self.onto + at.transfer.DFx @ dq
        singular = ~jnp.all(jnp.isfinite(change))
        why = jnp.where(singular, RESULTS.singular_stiffness, RESULTS.not_converged)
        why = jnp.where(at.transfer.regular, why, RESULTS.singular_configuration)
        return Correction(change, softer, jnp.zeros(0), why)


FREEDOMS = MatrixForm(TurnInFreedoms, lambda topology: (topology.n_q, 0), looks_at_end=True, knows_stress=True)
undeformed = functools.partial(undeformed_of, FREEDOMS)


@jax.custom_jvp
def _solve(topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin) -> Searched:
    return search_equilibrium(FREEDOMS, topology, parameters, target, begin)


def change_of_equations(
    topology: Topology, at: State, near: Float[Array, "n_e"], primals: tuple, tangents: tuple
) -> tuple[Float[Array, "n_e"], Float[Array, "n_x"], Float[Array, "n_x"]]:
    """Changes (excess, shift, imbalance) of the equilibrium equations with parameters and load factors, at constant x.

    They are arguments of ``reduced_response``; the particular solution keeps the DOF deformations. A leaf of
    ``tangents`` may be a ``SymbolicZero``. Implicit function theorem on THEORY.md 5, eq. (5.1); THEORY.md 10, eq.
    (10.1).
    """

    def equations(parameters: Parameters, target: LoadFactors):
        e, jacobian = deformation_jacobian(topology, parameters, at.x, near)
        stiffness = element_stiffness(topology, parameters)
        sigma = stress_resultants(topology, parameters, scaled_loads(parameters, target), stiffness, e)
        constrained = topology.e.held
        sigma = put(sigma, constrained, at.sigma[constrained])
        wanted_x, wanted_e = prescribed_values(topology, parameters, target)
        force = nodal_forces(topology, parameters, target, at.x)
        return jacobian.T @ sigma - force, e - wanted_e, wanted_x

    _, (imbalance, excess, prescribed) = jvp_of_varied(equations, primals, tangents)
    constrained = topology.x.held
    shift = put(jnp.zeros(topology.n_x), constrained, prescribed[constrained])
    return put(excess, topology.e.dof, 0.0) + at.jacobian @ shift, shift, imbalance


def _solve_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """The derivative of the equations at constant x, solved by the tangent; the start of the search has no effect."""
    topology, parameters, target, begin = primals
    solved = _solve(topology, parameters, target, begin)
    last_strain, at = jax.lax.stop_gradient(solved.reached.at.near), solved.last
    excess, shift, imbalance = change_of_equations(topology, at, last_strain, primals[1:3], tangents[1:3])
    dx, _ = linear_response(topology, at, excess, shift, imbalance)

    def evaluated(parameters: Parameters, target: LoadFactors, x: Float[Array, "n_x"]):
        return state(topology, parameters, target, x, last_strain)

    _, changed = jvp_of_varied(evaluated, (parameters, target, at.x), (*tangents[1:3], dx))
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return solved, Searched(changed, jax.tree.map(jnp.zeros_like, solved.reached), no_change, no_change)


_solve.defjvp(_solve_jvp, symbolic_zeros=True)


def solve_state(
    topology: Topology, parameters: Parameters, target: LoadFactors, tell_critical: bool = False
) -> tuple[State, Float[Array, "n_e"], Int[Array, ""], Int[Array, ""], LoadFactors]:
    """Equilibrium with everything of first order about it; differentiable.

    ``tell_critical``: whether the code reports a critical state, which is correct nevertheless. Returns state,
    ``last_strain``, code of RESULTS, number of Newton iterations, and the load factors that load steps reached.
    """
    # The pull of laws in the undeformed mechanism is only known as a number.
    if has_loads(topology, parameters) or is_nonlinear_at_rest(topology):
        begin = undeformed(topology, parameters)
        at, result, iterations, reached = solve_onward(topology, parameters, target, begin)
        if not tell_critical:
            result = jnp.where(result == RESULTS.critical_state, RESULTS.successful, result)
        return at, reached.at.near, result, iterations, reached.factors
    last_strain, zero = zero_strain(topology), jnp.zeros((), jnp.int32)
    at = state(topology, parameters, target, parameters.reference, last_strain, loaded=False)
    return at, last_strain, _singular_if_irregular(at, zero), zero, target


def solve_onward(
    topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin
) -> tuple[State, Int[Array, ""], Int[Array, ""], Begin]:
    """Equilibrium from a known one, with loads between them; differentiable, but not by the start.

    Returns state, code of RESULTS, critical_state included, number of Newton iterations, and the start for the next
    equilibrium.
    """
    at, reached, iterations, result = _solve(topology, parameters, target, begin)
    return at, _singular_if_irregular(at, result), iterations, jax.lax.stop_gradient(reached)


def _singular_if_irregular(at: State, result: Int[Array, ""]) -> Int[Array, ""]:
    converged = (result == RESULTS.successful) | (result == RESULTS.critical_state)
    return jnp.where(converged & ~at.transfer.regular, RESULTS.singular_configuration, result).astype(jnp.int32)


def acting_at(topology: Topology, parameters: Parameters, at: State) -> tuple[InertialLoad, Array, Array]:
    """Gravity, forces of the supports on the mechanism, and external forces (loads except weight, plus reactions).

    Reactions are D_x^T sigma - f at FIXED and PRESCRIBED coordinates, zero elsewhere.
    """
    constrained = topology.x.held
    reactions = put(jnp.zeros(topology.n_x), constrained, (at.jacobian.T @ at.sigma - at.force)[constrained])
    loads = at.force if at.gravity is None else at.force - weight(topology, parameters, at.x, at.gravity)
    return InertialLoad(at.gravity), reactions, loads + reactions
