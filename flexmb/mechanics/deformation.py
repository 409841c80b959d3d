"""Deformations e = D(x) of all elements, their first and second derivatives, and the transfer functions DF."""

import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..compilation.compile import jit, traced_once
from ..math.indices import accumulate, put, scatter_matrix, scatter_vector
from ..math.linear import Factors, factorise
from ..model.topology import Block, Parameters, Topology
from .blocks import companion_of, each_block, with_rigidities
from .staged import curvature, derivative

# With more coordinates, matrices on the host are sparse. Dense ones take ten seconds for 600 beams and seven gigabytes
# for 10 000.
MANY = 600


def deformation_functions(
    topology: Topology, parameters: Parameters, near: Float[Array, "n_e"]
) -> Iterator[tuple[Block, Callable[..., Any], tuple[Any, ...]]]:
    """Blocks that deform, ``f(x_el, *arguments_el) -> (n_el,)`` of one element, and its stacked arguments."""
    for block, function, *arguments in each_block(topology, parameters, "deformation"):
        if block.e.shape[1] and block.element.tracks_angle:
            yield block, functools.partial(_tracked, function), (*arguments, near[block.e])
        elif block.e.shape[1]:
            yield block, function, tuple(arguments)


def _tracked(function: Callable[..., Any], x: Any, ref: Array, properties: Any, near: Float[Array, "n"]):
    return function(x, ref, properties, near=near)


@traced_once
def deformations(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Deformations of all elements, unit norms included [m, rad].

    ``near``: deformations at the last accepted state, so that angles count turns.
    """
    element_deformations = [
        (block.e, jax.vmap(function)(x[block.x], *arguments))
        for block, function, arguments in deformation_functions(topology, parameters, near)
    ]
    return scatter_vector(topology.n_e, element_deformations)


def jacobian_pieces(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array, Array]]]:
    """Deformations of each block with their indices, and derivatives with row and column indices."""
    values, matrices = [], []
    for block, function, arguments in deformation_functions(topology, parameters, near):
        jacobian, e = jax.vmap(derivative(function))(x[block.x], *arguments)
        values.append((block.e, e))
        matrices.append((block.e, block.x, jacobian))
    return values, matrices


@traced_once
def deformation_jacobian(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> tuple[Float[Array, "n_e"], Float[Array, "n_e n_x"]]:
    """Deformations, and their derivatives by the nodal coordinates."""
    values, matrices = jacobian_pieces(topology, parameters, x, near)
    size = (topology.n_e, topology.n_x)
    return scatter_vector(topology.n_e, values), scatter_matrix(size, matrices)


@jit
def _jacobians(
    block: Block,
    properties: dict[str, Any],
    x: Float[Array, "elements c"],
    ref: Float[Array, "elements c"],
    near: Float[Array, "elements n"],
):
    function: Any = companion_of(block, properties, "deformation")[0]
    if block.element.tracks_angle:
        return jax.vmap(derivative(functools.partial(_tracked, function)))(x, ref, properties, near)
    return jax.vmap(derivative(function))(x, ref, properties)


def in_undeformed(block: Block, properties: dict[str, Any]) -> dict[str, Any]:
    """Properties of a block on which deformations in the undeformed mechanism depend.

    The section of a spectral beam is left out: it has no effect on which motions the strains allow.
    """
    chosen = block.element.of_deformation(properties)
    return chosen | {"section": None} if block.element.series and "section" in chosen else chosen


def _padded(rows: np.ndarray) -> np.ndarray:
    """Rows with the last one repeated up to a power of two, so that numbers of elements share programs."""
    more = 2 ** (len(rows) - 1).bit_length() - len(rows)
    return np.concatenate([rows, np.repeat(rows[-1:], more, axis=0)]) if more else rows


def undeformed(topology: Topology, parameters: Parameters) -> tuple[np.ndarray, Any]:
    """Deformations in the undeformed mechanism, which should vanish, and derivatives; see :func:`host_deformations`."""
    return host_deformations(topology, parameters, np.asarray(parameters.reference), np.zeros(topology.n_e))


def host_deformations(
    topology: Topology, parameters: Parameters, at: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, Any]:
    """Deformations of concrete coordinates and their derivatives, sparse above MANY coordinates.

    Compiles one program for each type of element and power of two of their number, whatever else the mechanism has.
    """
    alike: dict[Any, list[Any]] = {}
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        if "deformation" in block.companions and block.e.shape[1]:
            chosen = with_rigidities(in_undeformed(block, properties))
            fixed = tuple(block.element.of_deformation(dict(block.options)).items())
            law = block.element.alone(), dict(block.meaning or ()).get("deformation")
            shapes = tuple(np.shape(leaf)[1:] for leaf in jax.tree.leaves(chosen))
            key = (law, fixed, jax.tree.structure(chosen), shapes, block.splits, block.e.shape[1])
            alike.setdefault(key, []).append((np.asarray(block.x), np.asarray(block.e), chosen))
    values, element_matrices = np.zeros(topology.n_e), []
    for ((element, meaning), fixed, _, _, splits, _), members in alike.items():
        x, e, chosen = jax.tree.map(lambda *rows: _padded(np.concatenate(rows)), *members)
        meanings = (("deformation", meaning),)
        block = Block(element, ("deformation",), fixed, np.zeros_like(x), np.zeros_like(e), splits, meanings)
        derivatives = _jacobians(block, chosen, at[x], np.asarray(parameters.reference)[x], near[e])
        matrices, values[e] = map(np.asarray, derivatives)
        count = sum(len(elements) for elements, _, _ in members)
        element_matrices.append((e[:count, :, None], x[:count, None, :], matrices[:count]))
    if topology.n_x > MANY:
        return values, _sparse(element_matrices, (topology.n_e, topology.n_x))
    jacobian = np.zeros((topology.n_e, topology.n_x))
    for rows, columns, entries in element_matrices:
        np.add.at(jacobian, (rows, columns), entries)
    return values, jacobian


def _sparse(element_matrices: list[tuple[np.ndarray, np.ndarray, np.ndarray]], shape: tuple[int, int]) -> Any:
    import scipy.sparse

    flat = [[array.ravel() for array in np.broadcast_arrays(*piece)] for piece in element_matrices]
    rows, columns, entries = (np.concatenate(side) for side in zip(*flat, strict=True))
    return scipy.sparse.coo_array((entries, (rows, columns)), shape=shape).tocsr()


def curvature_pieces(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
) -> list[tuple[Array, Array, Array]]:
    """Second derivatives of each block for :func:`deformation_curvature`, with row and column indices."""
    return [
        (block.x, block.x, jax.vmap(curvature(function))(x[block.x], sigma[block.e], *arguments))
        for block, function, arguments in deformation_functions(topology, parameters, near)
    ]


@traced_once
def deformation_curvature(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
) -> Float[Array, "n_x n_x"]:
    """Stiffness of the stress resultants: second derivative of ``sigma . D(x)`` at constant sigma, symmetric.

    Multipliers of FIXED deformations and unit norms are included. Source: THEORY.md 6, eq. (6.3).
    """
    element_matrices = curvature_pieces(topology, parameters, x, near, sigma)
    return scatter_matrix((topology.n_x, topology.n_x), element_matrices)


def zero_strain(topology: Topology) -> Float[Array, "n_e"]:
    """Last accepted strain of the undeformed mechanism, which is zero."""
    return jnp.zeros(topology.n_e)


# From this number of entries of DFe on, products skip its rows of zeros and of the identity.
MANY_ENTRIES = 1000


class Transfer(NamedTuple):
    """First-order transfer functions at a configuration, and factors of A = dD^{o,m}/dx_dep.

    Attributes:
        DFx: Derivative of the nodal coordinates by q.
        DFe: Derivative of the deformations by q.
        factors: LU factors of A. Rows: FIXED, PRESCRIBED and DOF deformations; columns: DEPENDENT coordinates.
        regular: Whether A can be trusted.
        rows: DOF and DEPENDENT deformations if most are DOF: all other rows of DFe are zero. Otherwise None.
    """

    DFx: Float[Array, "n_x n_q"]
    DFe: Float[Array, "n_e n_q"]
    factors: Factors
    regular: Bool[Array, ""]
    rows: tuple[Int[Array, "n_dof"], Int[Array, "n_dep"]] | None = None

    def between(self, stiffness: Float[Array, "n_e n_e"]) -> Float[Array, "n_q n_q"]:
        """DFe^T S DFe."""
        if self.rows is None:
            return self.DFe.T @ stiffness @ self.DFe
        dof, dependent = self.rows
        first, follow = self.DFe.shape[1] - dof.shape[0], self.DFe[dependent]
        of_dof, of_dependent = stiffness[dof], stiffness[dependent]
        product = follow.T @ (of_dependent[:, dependent] @ follow)
        product = product.at[:, first:].add(follow.T @ of_dependent[:, dof])
        return product.at[first:].add(of_dof[:, dependent] @ follow).at[first:, first:].add(of_dof[:, dof])


@traced_once
def transfer(topology: Topology, jacobian: Float[Array, "n_e n_x"]) -> Transfer:
    """Transfer functions by implicit differentiation of D(x) = e: DFx = -A^-1 dD/dq-part, DFe = D_x DFx.

    Source: THEORY.md 4, eq. (4.3); tutorial WA 1239 (2012), ch. 1 and reference [10] there.
    """
    rows, dependent = topology.e.given, topology.x.dependent
    constrained_rows = jacobian[rows]
    factors = factorise(constrained_rows[:, dependent])
    by_coordinates = -constrained_rows[:, topology.x.dof]
    n_held, n_dof = rows.shape[0], topology.e.dof.shape[0]
    by_deformations = jnp.eye(n_held, n_dof, k=-(n_held - n_dof)) if n_dof else jnp.zeros((n_held, 0))
    solved = factors.solve(jnp.concatenate([by_coordinates, by_deformations], axis=1))
    n_coordinates = topology.x.dof.shape[0]
    dfx = put(jnp.zeros((topology.n_x, topology.n_q)), dependent, solved)
    dfx = put(dfx, topology.x.dof, jnp.eye(n_coordinates, topology.n_q))
    free, n_e = topology.e.dependent, topology.n_e
    if n_e * topology.n_q < MANY_ENTRIES or 2 * (n_e - n_dof) > n_e:
        return Transfer(dfx, jacobian @ dfx, factors, factors.regular())
    dfe = put(jnp.zeros((n_e, topology.n_q)), topology.e.dof, jnp.eye(n_dof, topology.n_q, k=n_coordinates))
    dfe = put(dfe, free, jacobian[free] @ dfx)
    return Transfer(dfx, dfe, factors, factors.regular(), (topology.e.dof, free))


def multipliers(
    topology: Topology,
    tangent: Transfer,
    jacobian: Float[Array, "n_e n_x"],
    sigma: Float[Array, "n_e"],
    force: Float[Array, "n_x"],
) -> Float[Array, "n_e"]:
    """Stress resultants with multipliers at FIXED and PRESCRIBED deformations, whose entries in ``sigma`` are ignored.

    They balance the forces on the DEPENDENT coordinates, A^T s = f - D_x^T sigma there. At an equilibrium the part of s
    of DOF deformations vanishes. Source: THEORY.md 5, eq. (5.5).
    """
    fixed = topology.e.held
    sigma = put(sigma, fixed, 0.0)
    out_of_balance = (force - jacobian.T @ sigma)[topology.x.dependent]
    solved = tangent.factors.solve_transposed(out_of_balance)
    return put(sigma, fixed, solved[: fixed.shape[0]])


def correction(
    topology: Topology, tangent: Transfer, excess: Float[Array, "n_e"], shift: Float[Array, "n_x"]
) -> Float[Array, "n_x"]:
    """Change of x that removes, to first order, an excess of held deformations; THEORY.md 4, eq. (4.2).

    Args:
        excess: Deformations minus their wanted values; DEPENDENT entries are ignored.
        shift: Change already decided of other coordinates, whose effect ``excess`` includes.
    """
    right = -excess[topology.e.given]
    return accumulate(shift, topology.x.dependent, tangent.factors.solve(right))
