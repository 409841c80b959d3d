"""Forces of elements in motion and their derivatives, element by element.

Deformations and inertia vectors of an element are one function of its coordinates, ``e(x), s(x)``. Its constants are
computed once. The nodal forces ``D_x^T sigma + J^T H s_ddot`` are linear in accelerations, stress resultants and
multipliers. The second rates of held deformations close the equations.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.program import split_constants
from ..compilation.record import Record, static
from ..math.indices import scatter_matrices, scatter_matrix, scatter_vector, scatter_vectors
from ..math.linear import multiplied
from ..mechanics.blocks import companion_of
from ..model.topology import Block, Parameters, Topology


class PreparedBlock(Record):
    """Elements of one block, prepared for motion: constants are computed.

    Attributes:
        function: ``(x_el, *kept_el) -> (e_el, s_el)``: deformations and inertia vectors of an element, or None. If
            angles are counted past full turns, the deformations at the last accepted state follow x_el.
        x: Index of each element's coordinates.
        e: Index of each element's deformations; none if e_el is None.
        kept: Constants of each element, for the function.
        mass: H of each element.
        counts: Whether angles are counted past full turns.
    """

    function: Callable[..., Any] = static()
    x: Int[Array, "elements coordinates"]
    e: Int[Array, "elements deformations"]
    kept: tuple[Array, ...]
    mass: Float[Array, "elements k k"] | None
    counts: bool = static()

    def over(self, function: Callable[..., Any], near: Float[Array, "n_e"], *along: Any):
        """Values of ``function(f, *along_el)`` for all elements, with ``f(x_el) -> (e_el, s_el)``."""
        constants = (near[self.e], *self.kept) if self.counts else self.kept

        def of_element(constants: tuple[Array, ...], *along: Any):
            return function(lambda x: self.function(x, *constants), *along)

        return jax.vmap(of_element)(constants, *along)


def prepared_blocks(topology: Topology, parameters: Parameters) -> tuple[PreparedBlock, ...]:
    """All elements that deform or carry mass, prepared for motion."""
    pairs = zip(topology.blocks, parameters.properties, strict=True)
    blocks = (prepared_block(block, properties, parameters.reference) for block, properties in pairs)
    return tuple(block for block in blocks if block is not None)


def prepared_block(block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"]) -> PreparedBlock | None:
    """Elements of one block, prepared for motion; None if they neither deform nor carry mass."""
    deformation, known = companion_of(block, properties, "deformation")
    inertia, element_properties = companion_of(block, properties, "inertia")
    element_properties = known if inertia is None else element_properties
    if not block.e.shape[1]:
        deformation = None
    if deformation is None and inertia is None:
        return None
    counts = deformation is not None and block.element.tracks_angle
    ref = reference[block.x]

    def element_values(x: Float[Array, "c"], *constants: Any):
        *last_strain, ref, element_properties = constants
        e = (
            None
            if deformation is None
            else deformation(x, ref, element_properties, **({"near": last_strain[0]} if counts else {}))
        )
        return e, None if inertia is None else inertia(x, ref, element_properties)[0]

    first = jax.tree.map(lambda rows: jax.ShapeDtypeStruct(rows.shape[1:], rows.dtype), (ref, element_properties))
    like = jax.ShapeDtypeStruct(ref.shape[1:], ref.dtype)
    varying = (like, jax.ShapeDtypeStruct(block.e.shape[1:], ref.dtype)) if counts else (like,)
    early, late = split_constants(element_values, varying, first)
    early_values = jax.vmap(early)(ref, element_properties)
    mass = None if inertia is None else jax.vmap(lambda *numbers: inertia(*numbers)[1])(ref, ref, element_properties)
    # Another block computes the deformations of elements with separate companions.
    measured = block.e if deformation is not None else block.e[:, :0]
    return PreparedBlock(late, block.x, measured, early_values, mass, counts)


def _jacobian(f: Callable[..., Any]):
    """Function from coordinates to values and Jacobians, coordinates last."""

    def with_jacobian(x: Float[Array, "c"]):
        def twice(x: Float[Array, "c"]):
            y = f(x)
            return y, y

        jacobian, y = jax.jacfwd(twice, has_aux=True)(x)
        return y, jacobian

    return with_jacobian


class Moving(NamedTuple):
    """Nodal coordinates, velocities, accelerations, and deformations at the last accepted state."""

    x: Float[Array, "n_x"]
    v: Float[Array, "n_x"]
    a: Float[Array, "n_x"]
    near: Float[Array, "n_e"]


class Kinematics(NamedTuple):
    """Deformations, their rates and second rates."""

    e: Float[Array, "n_e"]
    ed: Float[Array, "n_e"]
    edd: Float[Array, "n_e"]


class Acting(NamedTuple):
    """Kinematics, stress resultants, and nodal forces of stress and inertia."""

    kinematics: Kinematics
    sigma: Float[Array, "n_e"]
    force: Float[Array, "n_x"]


class Derivatives(NamedTuple):
    """Derivatives of the forces of elements in motion, assembled or of each element by its own coordinates.

    Attributes:
        e: D_x; also of the rates by the velocities and of the second rates by the accelerations. None, as the next two,
            of elements without deformations.
        ed: Of the rates by the coordinates; of the second rates by the velocities it is twice this.
        edd: Of the second rates by the coordinates.
        by_x, by_v, mass: Of the forces by coordinates, velocities and accelerations.
    """

    e: Float[Array, "*elements n_e n_x"]
    ed: Float[Array, "*elements n_e n_x"]
    edd: Float[Array, "*elements n_e n_x"]
    by_x: Float[Array, "*elements n_x n_x"]
    by_v: Float[Array, "*elements n_x n_x"]
    mass: Float[Array, "*elements n_x n_x"]


def strained(
    elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Deformations [m, rad]."""
    element_strains = [
        (block.e, block.over(lambda f, x: f(x)[0], near, x[block.x])) for block in elements if block.e.shape[1]
    ]
    return scatter_vector(near.shape[0], element_strains)


def _with_inertia(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], last_strain: Float[Array, "n_e"]):
    """Blocks with mass, and the Jacobians of their inertia vectors."""
    heavy = (block for block in elements if block.mass is not None)
    return [(b, b.over(lambda f, x: _jacobian(lambda x: f(x)[1])(x)[1], last_strain, x[b.x])) for b in heavy]


def heaviness(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Diagonal of the mass matrix [kg, kg m, kg m^2]."""
    blocks = _with_inertia(elements, x, near)
    element_masses = [(block.x, jnp.einsum("nkdx,nkl,nldx->nx", j, block.mass, j)) for block, j in blocks]
    return scatter_vector(x.shape[0], element_masses)


def mass_of(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Mass matrix [kg, kg m, kg m^2]."""
    blocks = _with_inertia(elements, x, near)
    element_matrices = [(block.x, block.x, jnp.einsum("nkdx,nkl,nldy->nxy", j, block.mass, j)) for block, j in blocks]
    return scatter_matrix((x.shape[0], x.shape[0]), element_matrices)


def deformations_and_slopes(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Deformations and their derivatives by the nodal coordinates, D_x."""
    values, rows = [], []
    for block, pair in zip(elements, deformed_elements(elements, x, near), strict=True):
        if pair is not None:
            values.append((block.e, pair[0]))
            rows.append((block.e, block.x, pair[1]))
    n_e = near.shape[0]
    return scatter_vector(n_e, values), scatter_matrix((n_e, x.shape[0]), rows)


def second_rate(function: Callable[..., Any], x: Any, v: Any, a: Any):
    """Value of a function of coordinates, and its first and second rates along a motion."""

    def first(x: Any, v: Any):
        return jax.jvp(function, (x,), (v,))

    (value, rate), (_, second) = jax.jvp(first, (x, v), (v, a))
    return value, rate, second


def rates_along(
    f: Callable[..., Any],
    x: Float[Array, "c"],
    v: Float[Array, "c"],
    a: Float[Array, "c"],
    falling: Float[Array, "c"] | None = None,
):
    """Values (e, s) of one element, rates and second rates; free fall is subtracted, since mass does not resist it."""
    y, yd, ydd = second_rate(f, x, v, a)
    if falling is not None and ydd[1] is not None:
        ydd = ydd[0], ydd[1] - jax.jvp(f, (x,), (falling,))[1][1]
    return y, yd, ydd


def _with_jacobians(
    f: Callable[..., Any],
    x: Float[Array, "c"],
    v: Float[Array, "c"],
    a: Float[Array, "c"],
    free_fall: Float[Array, "c"] | None,
):
    """:func:`rates_along`, and the Jacobians of e and s."""
    (y, (d, j)), (_, (dd, jd)) = jax.jvp(_jacobian(f), (x,), (v,))
    ed, edd = (None, None) if d is None else (d @ v, d @ a + dd @ v)
    sdd = None if j is None else j @ (a if free_fall is None else a - free_fall) + jd @ v
    return (y, (ed, None), (edd, sdd)), (d, j)


def derived_rates(
    f: Callable[..., Any],
    x: Float[Array, "c"],
    v: Float[Array, "c"],
    a: Float[Array, "c"],
    falling: Float[Array, "c"] | None = None,
):
    """:func:`rates_along`, and their derivatives by the coordinates, coordinates last."""
    return _jacobian(lambda x: rates_along(f, x, v, a, falling))(x)


def _pulled(
    f: Callable[..., Any], x: Float[Array, "c"], sigma: Float[Array, "d"] | None, weight: Float[Array, "k axes"] | None
):
    return jax.vjp(f, x)[1]((sigma, weight))[0]


def _weight(block: PreparedBlock, sdd: Any):
    """H s_ddot of each element."""
    return None if block.mass is None else multiplied(block.mass, sdd)


def _stressed(block: PreparedBlock, sigma: Float[Array, "n_e"]):
    """Stress resultants of each element."""
    return sigma[block.e] if block.e.shape[1] else None


def own_of(e: Int[Array, "elements d"], matrix: Float[Array, "n_e n_e"]) -> Float[Array, "elements d d"]:
    """Blocks of a matrix of all deformations, for elements with the deformations ``e``."""
    return matrix[e[:, :, None], e[:, None, :]]


def own_tangents(elements: tuple[PreparedBlock, ...], matrices: Sequence[Any]) -> list[list[Any]]:
    """:func:`own_of` of each block's elements, for each matrix that is not None."""
    return [[None if m is None or not b.e.shape[1] else own_of(b.e, m) for m in matrices] for b in elements]


def _along(block: PreparedBlock, at: Moving, free_fall: Float[Array, "n_x"] | None):
    return [None if array is None else array[block.x] for array in (at.x, at.v, at.a, free_fall)]


def _kinematics(rates: list[Any], last_strain: Float[Array, "n_e"]) -> Kinematics:
    """Kinematics of the mechanism from the kinematics of each block."""
    element_values = [(block.e, (y[0], yd[0], ydd[0])) for block, (y, yd, ydd) in rates if block.e.shape[1]]
    return Kinematics(*scatter_vectors(last_strain.shape[0], element_values, 3))


def acting_forces(
    elements: tuple[PreparedBlock, ...], at: Moving, falling: Float[Array, "n_x"] | None, stress: Callable[..., Any]
) -> Acting:
    """Kinematics, stress resultants and nodal forces D_x^T sigma + J^T H s_ddot (THEORY.md 3 and 5, eq. (3.2), (5.2)).

    `stress` returns sigma from e and e_dot. Mass does not resist the accelerations `falling` of free fall.
    """
    rates = [(block, block.over(rates_along, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics(rates, at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    forces = []
    for block, (_, _, (_, sdd)) in rates:
        pulled = block.over(_pulled, at.near, at.x[block.x], _stressed(block, sigma), _weight(block, sdd))
        forces.append((block.x, pulled))
    return Acting(kinematics, sigma, scatter_vector(at.x.shape[0], forces))


def acting_matrices(
    elements: tuple[PreparedBlock, ...], at: Moving, falling: Float[Array, "n_x"] | None, stress: Callable[..., Any]
) -> tuple[Acting, Float[Array, "n_e n_x"], Float[Array, "n_x n_x"]]:
    """:func:`acting_forces`, D_x and M = J^T H J, from the Jacobians of the elements."""
    rates = [(block, *block.over(_with_jacobians, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics([block_rates[:2] for block_rates in rates], at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    forces, rows, masses = [], [], []
    for block, (_, _, (_, sdd)), (d, j) in rates:
        forces += _pulled_by(block, sigma, sdd, d, j)
        if d is not None:
            rows.append((block.e, block.x, d))
        if j is not None:
            masses.append((block.x, block.x, jnp.einsum("nkdx,nkl,nldy->nxy", j, block.mass, j)))
    n_x = at.x.shape[0]
    acting = Acting(kinematics, sigma, scatter_vector(n_x, forces))
    return acting, scatter_matrix((at.near.shape[0], n_x), rows), scatter_matrix((n_x, n_x), masses)


def _pulled_by(block: PreparedBlock, sigma: Float[Array, "n_e"], sdd: Any, d: Any, j: Any):
    """D_x^T sigma and J^T H s_ddot of each element, with its coordinates."""
    forces = []
    if d is not None:
        forces.append((block.x, jnp.einsum("ni,nix->nx", _stressed(block, sigma), d)))
    if j is not None:
        forces.append((block.x, jnp.einsum("nkd,nkdx->nx", _weight(block, sdd), j)))
    return forces


def _derived_forces(
    f: Callable[..., Any], x: Float[Array, "c"], sigma: Float[Array, "d"] | None, weight: Float[Array, "k axes"] | None
):
    """Derivative of D_x^T sigma + J^T weight of one element."""
    return jax.jacfwd(lambda x: _pulled(f, x, sigma, weight))(x)


def deformed_elements(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Deformations and Jacobians of each block's elements; None for a block without deformations."""

    def derived(f: Callable[..., Any], x: Float[Array, "c"]):
        return _jacobian(lambda x: f(x)[0])(x)

    return [block.over(derived, near, x[block.x]) if block.e.shape[1] else None for block in elements]


def _block_derivatives(
    at: Moving,
    sigma: Float[Array, "n_e"],
    rates: tuple[Any, ...],
    stiffness: Float[Array, "elements d d"] | None,
    damping: Float[Array, "elements d d"] | None,
) -> Derivatives:
    """Derivatives of one block from :func:`derived_rates`, stress resultants, and tangents."""
    block, (_, _, (_, sdd)), ((d, j), (dd, jd), (d2, j2)) = rates
    slopes: Any = (d, dd, d2)
    by_x = block.over(_derived_forces, at.near, at.x[block.x], _stressed(block, sigma), _weight(block, sdd))
    by_v = mass = jnp.zeros_like(by_x)
    if d is not None and stiffness is not None:
        by_x = by_x + multiplied(d.mT, multiplied(stiffness, d))
    if d is not None and damping is not None:
        by_x = by_x + multiplied(d.mT, multiplied(damping, dd))
        by_v = multiplied(d.mT, multiplied(damping, d))
    if block.mass is not None:
        more_x, more_v, mass = by_inertia(block.mass, j, jd, j2)
        by_x, by_v = by_x + more_x, by_v + more_v
    return Derivatives(slopes[0], slopes[1], slopes[2], by_x, by_v, mass)


def by_inertia(
    mass: Float[Array, "elements k k"],
    j: Float[Array, "elements k axes x"],
    jd: Float[Array, "elements k axes x"],
    j2: Float[Array, "elements k axes x"],
):
    """Derivatives of J^T H s_ddot at constant J, by coordinates, velocities and accelerations."""
    count, k, axes, columns = j.shape
    lever = (mass @ j.reshape(count, k, axes * columns)).reshape(count, k * axes, columns)
    jacobians = jnp.concatenate([jacobian.reshape(lever.shape) for jacobian in (j, 2 * jd, j2)], axis=2)
    return jnp.split(lever.mT @ jacobians, 3, axis=2)[::-1]


def force_derivatives(
    elements: tuple[PreparedBlock, ...],
    at: Moving,
    falling: Float[Array, "n_x"] | None,
    stress: Callable[..., Any],
    tangents: Callable[..., Any] | None = None,
) -> Derivatives:
    """Derivatives of :func:`acting_forces`; arguments as for :func:`element_derivatives`."""
    n_e, n_x = at.near.shape[0], at.x.shape[0]
    _, derived = element_derivatives(elements, at, falling, stress, tangents)
    rows = [(block.e, block.x, of_block[:3]) for block, of_block in derived if of_block.e is not None]
    squares = [(block.x, block.x, of_block[3:]) for block, of_block in derived]
    return Derivatives(*scatter_matrices((n_e, n_x), rows, 3), *scatter_matrices((n_x, n_x), squares, 3))


def element_derivatives(
    elements: tuple[PreparedBlock, ...],
    at: Moving,
    falling: Float[Array, "n_x"] | None,
    stress: Callable[..., Any],
    tangents: Callable[..., Any] | None,
) -> tuple[Acting, list[tuple[PreparedBlock, Derivatives]]]:
    """Acting forces, and each block with the derivatives of its elements.

    `tangents` returns, for each block, the derivatives of sigma by e and e_dot of its elements, or None. Without
    `tangents`, sigma is constant.
    """
    rates = [(block, *block.over(derived_rates, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics([of_block[:2] for of_block in rates], at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    pairs = [(None, None)] * len(rates) if tangents is None else tangents(kinematics.e, kinematics.ed)
    derived, forces = [], []
    for of_block, pair in zip(rates, pairs, strict=True):
        block, (_, _, (_, sdd)), (jacobians, *_) = of_block
        forces += _pulled_by(block, sigma, sdd, *jacobians)
        derived.append((block, _block_derivatives(at, sigma, of_block, *pair)))
    return Acting(kinematics, sigma, scatter_vector(at.x.shape[0], forces)), derived
