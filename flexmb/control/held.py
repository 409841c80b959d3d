"""Motion of held coordinates: its effects on the linearised equations, and the forces that hold the coordinates."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import library_of
from ..linear.linearize import Matrices, Rates
from ..linear.spectrum import shift_to_definite
from ..math.indices import put
from ..math.linear import factorise
from ..mechanics.deformation import correction, deformation_curvature, deformation_jacobian, transfer
from ..mechanics.inertia import mass_matrix, weight_stiffness
from ..mechanics.loads import load_stiffness, without_gravity
from ..mechanics.signals import rotation_row
from ..model.model import Signal
from ..model.topology import Parameters, Topology
from ..motion.element_forces import Moving, force_derivatives, prepared_blocks
from ..numerical_limits import ENTRY_ROUND_OFF


class ConstrainedCoordinate(NamedTuple):
    """A held coordinate, rotation about an axis, or deformation.

    Attributes:
        of_element: Whether it is a deformation.
        at: Index in x or e; of a rotation in space, its first Euler parameter.
        axis: Axis of a rotation in space; None for others.
        local: Whether the axis turns with the node.
    """

    of_element: bool
    at: int
    axis: int | None
    local: bool


def constrained_by(signals: tuple[Signal, ...]) -> tuple[ConstrainedCoordinate, ...]:
    """Held coordinates that inputs move, or whose forces outputs measure, each once, in their order."""
    held = [s for s in signals if s.held and (s.order is not None or s.quantity in ("reaction", "stress"))]
    return tuple(dict.fromkeys(map(constrained_of, held)))


def constrained_of(signal: Signal) -> ConstrainedCoordinate:
    """Held coordinate that a signal moves, or whose force it measures."""
    return ConstrainedCoordinate(signal.of_element, signal.index, signal.axis, signal.local)


def moved_by(causes: tuple[Signal, ...], held: tuple[ConstrainedCoordinate, ...]) -> np.ndarray:
    """Which held coordinate each input moves, (held, inputs)."""
    rows = [[s.order is not None and constrained_of(s) == coordinate for s in causes] for coordinate in held]
    return np.array(rows, float).reshape(len(held), len(causes))


def with_constrained(
    topology: Topology, parameters: Parameters, m: Matrices, held: tuple[ConstrainedCoordinate, ...]
) -> Matrices:
    """Linearised equations in the degrees of freedom, then in held coordinates, about any state.

    The degrees of freedom stay constant when held coordinates move. The force on held coordinates is M0 qdd + (C0 + D0)
    qd + K q along them; for a deformation it is minus its stress resultant (THEORY.md 14, eq. (14.2) and (14.3)).
    """
    last_strain = jax.lax.stop_gradient(m.e)
    n, x = m.M0.shape[0], m.x
    _, jacobian = deformation_jacobian(topology, parameters, x, last_strain)
    tangent = transfer(topology, jacobian)
    seed_x, seed_e = seeds(topology, x, held)

    def answer(excess: Float[Array, "n_e k"], shift: Float[Array, "n_x k"]):
        """Change of all coordinates at constant degrees of freedom."""
        return jax.vmap(lambda e, x: correction(topology, tangent, e, x), (1, 1), 1)(excess, shift)

    moved = answer(jacobian @ seed_x - seed_e, seed_x)
    independent = topology.e.given
    deformed = put(jacobian @ moved, independent, seed_e[independent])
    z, dfe = jnp.concatenate([m.DFx, moved], axis=1), jnp.concatenate([m.DFe, deformed], axis=1)
    if m.factors is None:
        raise ValueError("These matrices do not include the factors of their loads. Use fm.linearize(model).")
    loads = load_stiffness(topology, without_gravity(parameters, increment=True), m.factors, x)
    if m.felt.gravity is not None:
        loads = loads + weight_stiffness(topology, parameters, x, m.felt.gravity)
    if m.turning is not None:
        loads = loads + m.turning
    # The force on held deformations is their total stress resultant, which includes the stress of their stiffness.
    stiffness, damping = (put(matrix, topology.e.held, 0.0) for matrix in (m.S, m.S_d))
    moving, velocity, dynamic = None, jnp.zeros((z.shape[1],) * 2), jnp.zeros((z.shape[1],) * 2)
    curvature = deformation_curvature(topology, parameters, x, last_strain, m.sigma)
    if m.moving is None:
        mass = mass_matrix(topology, parameters, x)
    else:
        v, a = m.moving.xd, m.moving.xdd
        elements = prepared_blocks(topology, parameters)
        by_x = force_derivatives(elements, Moving(x, v, a, last_strain), None, lambda e, ed: m.sigma)
        mass, still = by_x.mass, jnp.zeros_like(z)
        rates = by_x.ed @ z
        turning = answer(rates, still)
        second = by_x.edd @ z + 2 * by_x.ed @ turning
        by_q = answer(second, still)
        rate_of_dfe = rates + jacobian @ turning
        velocity = z.T @ (by_x.by_v @ z + 2 * mass @ turning)
        dynamic = z.T @ ((by_x.by_x - curvature) @ z + by_x.by_v @ turning + mass @ by_q)
        dynamic = dynamic + dfe.T @ damping @ rate_of_dfe
        moving = Rates(v, a, turning, by_q, rate_of_dfe, second + jacobian @ by_q)
    geometric = z.T @ (curvature - loads) @ z + about_axes(m, held, n)
    structural = dfe.T @ stiffness @ dfe

    def joined(by_freedoms: Float[Array, "n n"], extended: Float[Array, "w w"]):
        """The matrix with the known part of the degrees of freedom."""
        return extended.at[:n, :n].set(by_freedoms)

    k0, n0, g0 = joined(m.K0, _exact(structural)), joined(m.N0, dynamic), joined(m.G0, geometric)
    k = k0 + n0 + g0
    by_elements = _exact(dfe.T @ damping @ dfe)
    added = m.D0 - m.DFe.T @ damping @ m.DFe
    return dataclasses.replace(
        m,
        M0=joined(m.M0, _exact(z.T @ mass @ z)),
        C0=joined(m.C0, velocity),
        D0=joined(m.D0, by_elements + _beside_elements(m, added, k[:n, n:], k[n:, :n])),
        K0=k0,
        N0=n0,
        G0=g0,
        DFx=z,
        DFe=dfe,
        moving=moving,
    )


def seeds(
    topology: Topology, x: Float[Array, "n_x"], held: tuple[ConstrainedCoordinate, ...]
) -> tuple[Float[Array, "n_x k"], Float[Array, "n_e k"]]:
    """Changes of held coordinates and deformations by a unit of each."""
    library = library_of(x)
    seed_x, seed_e = library.zeros((topology.n_x, len(held))), library.zeros((topology.n_e, len(held)))
    for i, coordinate in enumerate(held):
        if coordinate.of_element:
            seed_e = put(seed_e, (coordinate.at, i), 1.0)
        elif coordinate.axis is None:
            seed_x = put(seed_x, (coordinate.at, i), 1.0)
        else:
            euler = coordinate.at + np.arange(4)
            # d(lambda)/dt = Lbar^T omega / 2, the inverse of omega = 2 Lbar d(lambda)/dt.
            seed_x = put(seed_x, (euler, i), rotation_row(x[euler], coordinate.axis, coordinate.local) / 4)
    return seed_x, seed_e


def _exact(matrix: Float[Array, "w w"]) -> Float[Array, "w w"]:
    """A positive semidefinite matrix with zeros for round-off; its derivatives stay.

    Round-off would make an output depend on a rate of an input, which no state space includes.
    """
    known = jax.lax.stop_gradient(matrix)
    size = jnp.sqrt(jnp.abs(jnp.diag(known)))
    small = jnp.abs(known) <= ENTRY_ROUND_OFF * size[:, None] * size
    return jnp.where(small, matrix - known, matrix)


def about_axes(m: Any, held: tuple[ConstrainedCoordinate, ...], n: int) -> Float[Array, "w w"]:
    """Change of moments that hold a turned node, since they are about axes: 2 Lbar(lambda) turns with it."""
    stiffness = library_of((m.x, m.reactions)).zeros((n + len(held), n + len(held)))
    for i, coordinate in enumerate(held):
        for j, by in enumerate(held):
            if coordinate.axis is not None and by.axis is not None and coordinate.at == by.at:
                euler = coordinate.at + np.arange(4)
                turned = rotation_row(m.x[euler], by.axis, by.local) / 4
                change = rotation_row(turned, coordinate.axis, coordinate.local) / 4 @ m.reactions[euler]
                stiffness = put(stiffness, (n + i, n + j), change)
    return stiffness


def _beside_elements(
    m: Matrices, added: Float[Array, "n_q n_q"], by_held: Float[Array, "n_q k"], of_held: Float[Array, "k n_q"]
) -> Float[Array, "w w"]:
    """Damping ``added`` to the damping of the elements, for motion beyond the motion at rest.

    ``by_held`` and ``of_held`` are the stiffness between the degrees of freedom and held coordinates.
    """
    shift, *_ = shift_to_definite((m.K + m.K.T) / 2, m.M0)
    # Round-off of no added damping would need a regular stiffness.
    has_added = jnp.max(jnp.abs(added), initial=0.0) > 10 * ENTRY_ROUND_OFF * jnp.max(jnp.abs(m.D0), initial=0.0)
    factors = factorise(jnp.where(has_added, m.K + shift * m.M0, jnp.eye(len(added))))
    added = jnp.where(has_added, added, 0.0)
    right = jnp.concatenate([jnp.eye(len(added)), factors.solve(by_held)], axis=1)
    left = jnp.concatenate([jnp.eye(len(added)), factors.solve_transposed(of_held.T)], axis=1)
    return left.T @ added @ right
