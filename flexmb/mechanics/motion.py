"""Equations of motion in all nodal coordinates with multipliers, and their derivatives, element by element.

The residual ``R(x, v, a, sigma)`` of the nodal coordinates is linear in the accelerations and in the stress resultants,
multipliers of held deformations among them; the second derivative of the deformations closes it.
"""

from typing import NamedTuple

import jax
from jaxtyping import Array, Float

from ..model.parameters import Parameters
from ..model.topology import Topology
from .blocks import each_block, scatter_matrix, scatter_vector
from .deformation import deformation_functions


class Kinematics(NamedTuple):
    """Deformations and their two rates.

    Attributes:
        e: Deformations, (n_e,) [m, rad].
        ed: Rates, (n_e,) [m/s, rad/s].
        edd: Second rates, (n_e,) [m/s^2, rad/s^2].
    """

    e: Float[Array, "n_e"]
    ed: Float[Array, "n_e"]
    edd: Float[Array, "n_e"]


class ForceDerivatives(NamedTuple):
    """Derivatives of inertia forces by coordinates, velocities and accelerations.

    Attributes:
        by_x: (n_x, n_x) [N/m].
        by_v: (n_x, n_x) [N s/m].
        by_a: Mass matrix, (n_x, n_x) [kg].
    """

    by_x: Float[Array, "n_x n_x"]
    by_v: Float[Array, "n_x n_x"]
    by_a: Float[Array, "n_x n_x"]


class KinematicDerivatives(NamedTuple):
    """Derivatives of deformations and rates by the coordinates.

    Attributes:
        e: D_x, (n_e, n_x); of the rates by the velocities and of the second rates by the accelerations too.
        ed: Of the rates, (n_e, n_x); of the second rates by the velocities it is twice this.
        edd: Of the second rates, (n_e, n_x).
        curvature: Second derivative of sigma . D at constant sigma, (n_x, n_x).
    """

    e: Float[Array, "n_e n_x"]
    ed: Float[Array, "n_e n_x"]
    edd: Float[Array, "n_e n_x"]
    curvature: Float[Array, "n_x n_x"]


def _second_rate(function, x, v, a):
    """Value of a function of coordinates and its first and second rate of change along a motion."""

    def first(x, v):
        return jax.jvp(function, (x,), (v,))

    (value, rate), (_, second) = jax.jvp(first, (x, v), (v, a))
    return value, rate, second


def stressed_kinematics(
    topology: Topology, parameters: Parameters, x, v, a, near, stress
) -> tuple[Kinematics, Float[Array, "n_e"], Float[Array, "n_x"]]:
    """Kinematics, and the nodal forces D_x^T sigma with sigma a function of the kinematics.

    Args:
        topology: Structure.
        parameters: Numbers.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        stress: sigma as a function of e and e_dot, (n_e,) [N, N m].

    Returns:
        Kinematics, sigma (n_e,) [N, N m], and forces, (n_x,) [N, N m].

    Source:
        FORMULATION.md 5.
    """
    found, pulls = [], []
    for block, function, arguments in deformation_functions(topology, parameters, near):
        at = (x[block.x], v[block.x], a[block.x])

        def rates(x, v, a, *rest, function=function):
            return _second_rate(lambda x: function(x, *rest), x, v, a)

        found.append((block, jax.vmap(rates)(*at, *arguments)))

        def pull(x, sigma, *rest, function=function):
            return jax.vjp(lambda x: function(x, *rest), x)[1](sigma)[0]

        pulls.append((block, pull, at[0], arguments))
    values = [scatter_vector(topology.n_e, [(block.e, f[i]) for block, f in found]) for i in range(3)]
    kin = Kinematics(*values)
    sigma = stress(kin.e, kin.ed)
    pieces = [(b.x, jax.vmap(pull)(at, sigma[b.e], *arguments)) for b, pull, at, arguments in pulls]
    return kin, sigma, scatter_vector(topology.n_x, pieces)


def kinematic_derivatives(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    v: Float[Array, "n_x"],
    a: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
) -> KinematicDerivatives:
    """Derivatives by the coordinates of all that :func:`stressed_kinematics` gives, at constant sigma.

    Args:
        topology: Structure.
        parameters: Numbers.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        sigma: Stress resultants and multipliers, (n_e,) [N, N m].

    Returns:
        KinematicDerivatives.

    Source:
        Derivative of :func:`stressed_kinematics`.
    """
    by_e, by_ed, by_edd, hessians = [], [], [], []
    for block, function, arguments in deformation_functions(topology, parameters, near):

        def all_of(x, v, a, sigma, *rest, function=function):
            def own(x):
                return function(x, *rest)

            return *_second_rate(own, x, v, a), jax.vjp(own, x)[1](sigma)[0]

        matrices = jax.vmap(jax.jacfwd(all_of))(x[block.x], v[block.x], a[block.x], sigma[block.e], *arguments)
        for pieces, matrix in zip((by_e, by_ed, by_edd), matrices[:3], strict=True):
            pieces.append((block.e, block.x, matrix))
        hessians.append((block.x, block.x, matrices[3]))
    size = (topology.n_e, topology.n_x)
    n_x = topology.n_x
    e, ed, edd = (scatter_matrix(size, pieces) for pieces in (by_e, by_ed, by_edd))
    return KinematicDerivatives(e, ed, edd, scatter_matrix((n_x, n_x), hessians))


def _inertia_functions(topology, parameters):
    for block, function, ref, properties in each_block(topology, parameters, "inertia"):

        def force(x, v, a, ref, own, function=function):
            def vectors(x):
                return function(x, ref, own)

            def first(x, v):
                return jax.jvp(vectors, (x,), (v,), has_aux=True)[1]

            _, second = jax.jvp(first, (x, v), (v, a))
            _, pull, h = jax.vjp(vectors, x, has_aux=True)
            return pull(h @ second)[0]

        yield block, force, (ref, properties)


def inertia_forces(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    v: Float[Array, "n_x"],
    a: Float[Array, "n_x"],
) -> Float[Array, "n_x"]:
    """Forces that the mass needs to move so: M a and the convective terms.

    Args:
        topology: Structure.
        parameters: Numbers.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].

    Returns:
        J^T H s_ddot, (n_x,) [N, N m].

    Source:
        FORMULATION.md 3.
    """
    pieces = []
    for block, force, arguments in _inertia_functions(topology, parameters):
        pieces.append((block.x, jax.vmap(force)(x[block.x], v[block.x], a[block.x], *arguments)))
    return scatter_vector(topology.n_x, pieces)


def inertia_derivatives(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    v: Float[Array, "n_x"],
    a: Float[Array, "n_x"],
) -> ForceDerivatives:
    """Derivatives of :func:`inertia_forces`.

    Args:
        topology: Structure.
        parameters: Numbers.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].

    Returns:
        ForceDerivatives.

    Source:
        Derivative of :func:`inertia_forces`.
    """
    found: tuple[list, list, list] = ([], [], [])
    for block, force, arguments in _inertia_functions(topology, parameters):
        matrices = jax.vmap(jax.jacfwd(force, argnums=(0, 1, 2)))(x[block.x], v[block.x], a[block.x], *arguments)
        for pieces, matrix in zip(found, matrices, strict=True):
            pieces.append((block.x, block.x, matrix))
    size = (topology.n_x, topology.n_x)
    return ForceDerivatives(*(scatter_matrix(size, pieces) for pieces in found))
