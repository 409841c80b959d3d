"""Mass matrix and weight from each element's vectors s(x) and constant matrix H: T = 1/2 s_dot^T H s_dot."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import traced_once
from ..math.indices import put, scatter_matrix, scatter_vector
from ..model.topology import Block, Parameters, Topology
from .blocks import each_block
from .staged import derivative


class InertialLoad(NamedTuple):
    """What acts on mass in a state.

    Attributes:
        gravity: Acceleration of free fall [m/s^2]; None without gravity.
        v: Nodal velocities [1/s]; None at rest.
        a: Nodal accelerations [1/s^2]; None at rest.
    """

    gravity: Float[Array, "axes"] | None = None
    v: Float[Array, "n_x"] | None = None
    a: Float[Array, "n_x"] | None = None


def mass_pieces(topology: Topology, parameters: Parameters, x: Float[Array, "n_x"]) -> list[tuple[Array, Array, Array]]:
    """Mass matrices of each block, with row and column indices."""
    element_matrices = []
    for block, function, *arguments in each_block(topology, parameters, "inertia"):
        matrix = functools.partial(_element_mass, function)
        element_matrices.append((block.x, block.x, jax.vmap(matrix)(x[block.x], *arguments)))
    return element_matrices


def _element_mass(function: Callable[..., Any], x: Float[Array, "c"], *arguments: Any) -> Float[Array, "c c"]:
    (j, _), (_, h) = derivative(function)(x, *arguments)
    return jnp.einsum("akc,ab,bkd->cd", j, h, j)


@traced_once
def mass_matrix(topology: Topology, parameters: Parameters, x: Float[Array, "n_x"]) -> Float[Array, "n_x n_x"]:
    """Mass matrix of the nodal coordinates, M = J^T H J with J = ds/dx; THEORY.md 3, eq. (3.2)."""
    return scatter_matrix((topology.n_x, topology.n_x), mass_pieces(topology, parameters, x))


def kinetic_energy(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], v: Float[Array, "n_x"]
) -> Float[Array, ""]:
    """Kinetic energy of nodal velocities [J]; THEORY.md 3, eq. (3.1)."""
    total = jnp.array(0.0)
    for block, function, *arguments in each_block(topology, parameters, "inertia"):
        energy = functools.partial(_element_energy, function)
        total = total + jnp.sum(jax.vmap(energy)(x[block.x], v[block.x], *arguments))
    return total


def _element_energy(function: Callable[..., Any], x: Float[Array, "c"], v: Float[Array, "c"], *arguments: Any):
    _, rate, h = jax.jvp(lambda x: function(x, *arguments), (x,), (v,), has_aux=True)
    return 0.5 * jnp.einsum("ak,ab,bk->", rate, h, rate)


def uniform_motion(topology: Topology, acceleration: Float[Array, "axes"]) -> Float[Array, "n_x"]:
    """Nodal acceleration of a mechanism in uniform translation, zero at rotations."""
    columns = jnp.broadcast_to(acceleration[:, None], topology.axes.shape)
    return put(jnp.zeros(topology.n_x), topology.axes, columns)


def total_mass(topology: Topology, parameters: Parameters) -> Float[Array, ""]:
    """Mass of the mechanism [kg], distributed mass included: twice the kinetic energy of a uniform unit velocity."""
    along = uniform_motion(topology, jnp.eye(len(topology.axes))[0])
    return along @ mass_matrix(topology, parameters, parameters.reference) @ along


def fall(
    topology: Topology,
    felt: InertialLoad,
    x: Float[Array, "n_x"],
    block: Block,
    function: Callable[..., Any],
    *arguments: Any,
) -> Any:
    """Free fall minus acceleration of the vectors s of each element, (elements, k, d) [m/s^2]; None without both.

    Gravity acts as a uniform acceleration; s_ddot = J a + (dJ/dt) v. Arguments as :func:`each_block` yields them.
    """
    free_fall = None if felt.gravity is None else uniform_motion(topology, felt.gravity)
    along = [None if rate is None else rate[block.x] for rate in (free_fall, felt.v, felt.a)]
    if all(rate is None for rate in along):
        return None

    def element_fall(x: Float[Array, "c"], along: list[Float[Array, "c"] | None], *arguments: Any):
        free_fall, v, a = along

        def rate(x: Float[Array, "c"], v: Float[Array, "c"]):
            return jax.jvp(lambda x: function(x, *arguments)[0], (x,), (v,))[1]

        total: Any = 0.0 if free_fall is None else rate(x, free_fall)
        return total if v is None else total - jax.jvp(rate, (x, v), (v, a))[1]

    return jax.vmap(element_fall)(x[block.x], along, *arguments)


def _weight_potential(topology: Topology, parameters: Parameters, gravity: Float[Array, "axes"]):
    """Blocks with mass, a function whose gradient is an element's weight, and the function's stacked arguments."""
    motion = uniform_motion(topology, gravity)
    for block, function, *arguments in each_block(topology, parameters, "inertia"):
        yield block, functools.partial(_work, function), (motion[block.x], *arguments)


def _work(
    function: Callable[..., Any], x: Float[Array, "c"], at: Float[Array, "c"], along: Float[Array, "c"], *arguments: Any
) -> Float[Array, ""]:
    """The product s(x) . H ds of an element, with ds of a uniform motion at a configuration."""

    def vectors(x: Float[Array, "c"]):
        return function(x, *arguments)

    _, rate, h = jax.jvp(vectors, (at,), (along,), has_aux=True)
    return jnp.einsum("ak,ab,bk->", vectors(x)[0], h, rate)


def work_of_weight(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], gravity: Float[Array, "axes"]
) -> Float[Array, ""]:
    """Work of gravity from the undeformed mechanism on [J]."""
    total = jnp.array(0.0)
    for block, work, arguments in _weight_potential(topology, parameters, gravity):
        at, start = x[block.x], parameters.reference[block.x]
        total = total + jnp.sum(jax.vmap(work)(at, at, *arguments) - jax.vmap(work)(start, start, *arguments))
    return total


@traced_once
def weight(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], gravity: Float[Array, "axes"]
) -> Float[Array, "n_x"]:
    """Nodal forces of gravity on all mass, distributed mass included: f = M(x) t, t the translation at g.

    A uniform field acts as the inertia of a uniform acceleration, and translation does not change kinetic energy.
    """
    element_forces = []
    for block, work, arguments in _weight_potential(topology, parameters, gravity):
        at = x[block.x]
        element_forces.append((block.x, jax.vmap(jax.grad(work))(at, at, *arguments)))
    return scatter_vector(topology.n_x, element_forces)


def weight_pieces(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], gravity: Float[Array, "axes"]
) -> list[tuple[Array, Array, Array]]:
    """Derivatives of the weight of each block, with row and column indices."""
    element_matrices = []
    for block, work, arguments in _weight_potential(topology, parameters, gravity):
        at = x[block.x]
        element_matrices.append((block.x, block.x, jax.vmap(jax.jacfwd(jax.grad(work)))(at, at, *arguments)))
    return element_matrices


@traced_once
def weight_stiffness(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], gravity: Float[Array, "axes"]
) -> Float[Array, "n_x n_x"]:
    """Derivative of :func:`weight`, symmetric: Hessian of s(x) . H s_dot, whose s_dot does not depend on x."""
    return scatter_matrix((topology.n_x, topology.n_x), weight_pieces(topology, parameters, x, gravity))
