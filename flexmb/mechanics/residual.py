"""Reduced static equation at a configuration: residual, stiffnesses, and a Newton step."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..math.indices import put
from ..math.linear import factorise
from ..model.topology import Parameters, Topology
from .deformation import Transfer, correction, deformation_curvature, deformation_jacobian, multipliers, transfer
from .loads import LoadFactors, load_stiffness, nodal_forces, scaled_loads
from .stress_resultants import element_stiffness, stress_and_tangent


class State(NamedTuple):
    """First-order quantities of the static equations at a configuration [SI].

    Attributes:
        sigma: Stress resultants, multipliers included.
        force: Nodal forces of the loads.
        jacobian: D_x.
        S: Stiffness of the elements, or their tangent stiffness.
        curvature: Stiffness of stress resultants and loads in the coordinates, or None without loads.
        gravity: Acceleration of free fall, or None.
    """

    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    force: Float[Array, "n_x"]
    jacobian: Float[Array, "n_e n_x"]
    transfer: Transfer
    S: Float[Array, "n_e n_e"]
    curvature: Float[Array, "n_x n_x"] | None
    gravity: Float[Array, "axes"] | None

    @property
    def K0(self) -> Float[Array, "n_q n_q"]:
        """Structural stiffness DFe^T S DFe."""
        return self.transfer.between(self.S)

    @property
    def G0(self) -> Float[Array, "n_q n_q"]:
        """Geometric stiffness from stress resultants, multipliers and loads."""
        if self.curvature is None:
            return jnp.zeros_like(self.K0)
        return self.transfer.DFx.T @ self.curvature @ self.transfer.DFx

    @property
    def residual(self) -> Float[Array, "n_q"]:
        """Imbalance along each degree of freedom: DFe^T sigma - DFx^T f."""
        return self.transfer.DFe.T @ self.sigma - self.transfer.DFx.T @ self.force


def state(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    loaded: bool = True,
    strained: Float[Array, "n_e"] | None = None,
) -> State:
    """State at a configuration; THEORY.md 5 and 6, eq. (5.1), (5.5), (6.2) and (6.3).

    Args:
        loaded: False for the undeformed mechanism without loads, which has no stress to trace.
        strained: Deformations that cause stress, in place of D(x); None: D(x).
    """
    e, jacobian = deformation_jacobian(topology, parameters, x, near)
    tangent = transfer(topology, jacobian)
    stiffness = element_stiffness(topology, parameters)
    if not loaded:
        nothing = jnp.zeros(topology.n_e)
        return State(x, e, nothing, jnp.zeros(topology.n_x), jacobian, tangent, stiffness, None, None)
    force = nodal_forces(topology, parameters, factors, x)
    stressed = e if strained is None else strained
    loads = scaled_loads(parameters, factors)
    elastic, stiffness = stress_and_tangent(topology, parameters, loads, stiffness, stressed)
    sigma = multipliers(topology, tangent, jacobian, elastic, force)
    curvature = deformation_curvature(topology, parameters, x, near, sigma)
    curvature = curvature - load_stiffness(topology, parameters, factors, x)
    return State(x, e, sigma, force, jacobian, tangent, stiffness, curvature, loads.gravity)


def iterate(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    strained: Float[Array, "n_e"],
    wanted: tuple[Float[Array, "n_x"], Float[Array, "n_e"]],
) -> tuple[State, Float[Array, "n_x"], Float[Array, "n_q"]]:
    """State of an iterate with independent deformations, the change of x onto the constraints, and the residual.

    A step that bends a leaf spring is straight in x and causes a false elongation, second order in the step. The stress
    of this elongation and its constraint forces would spoil the tangent. So Newton's method takes x and e as unknowns
    of D(x) = e and the equilibrium, and eliminates e. The residual r belongs to K dq = -r.

    Args:
        strained: Deformations of the iterate: e + D_x dx of the step to it.
        wanted: Coordinates and deformations with PRESCRIBED ones at their values.
    """
    at = state(topology, parameters, factors, x, near, strained=strained)
    wanted_x, wanted_e = wanted
    constrained = topology.x.held
    shift = put(jnp.zeros(topology.n_x), constrained, wanted_x[constrained] - x[constrained])
    wanted_e = put(wanted_e, topology.e.dof, strained[topology.e.dof])
    onto = correction(topology, at.transfer, at.e - wanted_e + at.jacobian @ shift, shift)
    strain = at.e + at.jacobian @ onto - strained
    imbalance = at.jacobian.T @ (at.sigma + at.S @ strain) - at.force
    if at.curvature is not None:
        imbalance = imbalance + at.curvature @ onto
    return at, onto, at.transfer.DFx.T @ imbalance


def reduced_response(
    topology: Topology,
    at: State,
    excess: Float[Array, "n_e"],
    shift: Float[Array, "n_x"],
    imbalance: Float[Array, "n_x"],
) -> tuple[Float[Array, "n_x"], Float[Array, "n_q"]]:
    """Change of x at constant q, and the residual r of K dq = -r after it, to first order; THEORY.md 6, eq. (6.3).

    Args:
        excess: FIXED, PRESCRIBED and DOF deformations minus their wanted values, with the effect of ``shift``.
        shift: Change already decided of coordinates that are not DEPENDENT.
        imbalance: Forces out of balance at the coordinates.
    """
    onto_constraints = correction(topology, at.transfer, excess, shift)
    # DOF deformations already have the stress of their wanted values.
    strain = put(at.jacobian @ onto_constraints, topology.e.dof, 0.0)
    imbalance = imbalance + at.jacobian.T @ (at.S @ strain)
    if at.curvature is not None:
        imbalance = imbalance + at.curvature @ onto_constraints
    return onto_constraints, at.transfer.DFx.T @ imbalance


def linear_response(
    topology: Topology,
    at: State,
    excess: Float[Array, "n_e"],
    shift: Float[Array, "n_x"],
    imbalance: Float[Array, "n_x"],
) -> tuple[Float[Array, "n_x"], Float[Array, "n_q"]]:
    """Changes of x, and of q from its wanted value, to first order; arguments as for :func:`reduced_response`.

    This linear system serves Newton's step and the derivative of the equilibrium by any parameter.
    """
    onto_constraints, residual = reduced_response(topology, at, excess, shift, imbalance)
    dq = factorise(at.K0 + at.G0).solve(-residual)
    return onto_constraints + at.transfer.DFx @ dq, dq
