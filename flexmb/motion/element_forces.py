"""Forces of elements in motion and their derivatives, element by element.

Of each element deformations and inertia are one function of its coordinates, ``e(x), s(x)``, whose constants are worked
out once. The nodal forces ``D_x^T sigma + J^T H s_ddot`` are linear in the accelerations and in the stress resultants,
multipliers of held deformations among them; the second rate of the deformations closes the equations.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.program import split
from ..compilation.record import Record, static
from ..math.jets import jets, length
from ..math.linear import multiplied
from ..mechanics.blocks import companion_of, scatter_matrices, scatter_matrix, scatter_vector, scatter_vectors
from ..model.parameters import Parameters
from ..model.topology import Block, Topology

# Functions of an element of so few operations run quicker, and compile as quickly, differentiated time after time.
SHORT = 100


class PreparedBlock(Record):
    """Elements of one block, prepared for motion: what does not change while they move has been worked out.

    Attributes:
        function: ``(x_el, *kept_el) -> (e_el, s_el)``, from the coordinates of an element to its deformations and the
            places of its inertia, either None where there is none. Where angles are counted past full turns, the
            deformations at the last accepted state come after x_el.
        x: Index of each element's coordinates, (elements, coordinates).
        e: Index of each element's deformations, (elements, deformations); none where e_el is None.
        kept: Constants of each element, for the function.
        mass: H of each element, (elements, k, k), or None.
        counts: Whether angles are counted past full turns.
    """

    function: Callable[..., Any] = static()
    x: Int[Array, "elements coordinates"]
    e: Int[Array, "elements deformations"]
    kept: tuple[Array, ...]
    mass: Float[Array, "elements k k"] | None
    counts: bool = static()

    def over(self, function: Callable[..., Any], near: Float[Array, "n_e"], *along: Any):
        """Values for all elements of what is said of one, by its deformations and places of inertia.

        Args:
            function: Of ``(f, *along_el)`` where ``f(x_el) -> (e_el, s_el)``.
            near: Deformations at the last accepted state, (n_e,) [m, rad].
            along: Further arguments, one row for each element.
        """
        rest = (near[self.e], *self.kept) if self.counts else self.kept

        def one(rest: tuple[Array, ...], *along: Any):
            return function(lambda x: self.function(x, *rest), *along)

        return jax.vmap(one)(rest, *along)


def prepared_blocks(topology: Topology, parameters: Parameters) -> tuple[PreparedBlock, ...]:
    """All elements that deform or carry mass, with what does not change in a motion worked out."""
    pairs = zip(topology.blocks, parameters.properties, strict=True)
    found = (prepared_block(block, properties, parameters.reference) for block, properties in pairs)
    return tuple(one for one in found if one is not None)


def prepared_block(block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"]) -> PreparedBlock | None:
    """Elements of one block, with what does not change in a motion worked out; None if they neither deform nor weigh.

    Args:
        properties: Their stacked properties.
        reference: Nodal coordinates of the undeformed mechanism, (n_x,) [m, rad, -].
    """
    deformation, known = companion_of(block, properties, "deformation")
    inertia, own = companion_of(block, properties, "inertia")
    own = known if inertia is None else own
    if not block.e.shape[1]:
        deformation = None
    if deformation is None and inertia is None:
        return None
    counts = deformation is not None and block.element.tracks_angle
    ref = reference[block.x]

    def both(x: Float[Array, "c"], *rest: Any):
        *near, ref, own = rest
        e = None if deformation is None else deformation(x, ref, own, **({"near": near[0]} if counts else {}))
        return e, None if inertia is None else inertia(x, ref, own)[0]

    first = jax.tree.map(lambda rows: jax.ShapeDtypeStruct(rows.shape[1:], rows.dtype), (ref, own))
    like = jax.ShapeDtypeStruct(ref.shape[1:], ref.dtype)
    varying = (like, jax.ShapeDtypeStruct(block.e.shape[1:], ref.dtype)) if counts else (like,)
    early, late = split(both, varying, first)
    kept = jax.vmap(early)(ref, own)
    mass = None if inertia is None else jax.vmap(lambda *own: inertia(*own)[1])(ref, ref, own)
    # Another block computes the deformations of elements whose companions differ.
    measured = block.e if deformation is not None else block.e[:, :0]
    return PreparedBlock(late, block.x, measured, kept, mass, counts)


def _jacobian(f: Callable[..., Any]):
    """Function from coordinates to values and Jacobians; a Jacobian has the coordinates last."""

    def found(x: Float[Array, "c"]):
        def twice(x: Float[Array, "c"]):
            y = f(x)
            return y, y

        jacobian, y = jax.jacfwd(twice, has_aux=True)(x)
        return y, jacobian

    return found


class Moving(NamedTuple):
    """A state of motion.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
    """

    x: Float[Array, "n_x"]
    v: Float[Array, "n_x"]
    a: Float[Array, "n_x"]
    near: Float[Array, "n_e"]


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


class Acting(NamedTuple):
    """Forces of elements in motion.

    Attributes:
        kinematics: Deformations and their rates.
        sigma: Stress resultants, (n_e,) [N, N m].
        force: Nodal forces of stress and inertia, (n_x,) [N, N m].
    """

    kinematics: Kinematics
    sigma: Float[Array, "n_e"]
    force: Float[Array, "n_x"]


class Derivatives(NamedTuple):
    """Derivatives of the forces of elements in motion.

    Attributes:
        e: D_x, (n_e, n_x); of the rates by the velocities and of the second rates by the accelerations too.
        ed: Of the rates by the coordinates, (n_e, n_x); of the second rates by the velocities it is twice this.
        edd: Of the second rates by the coordinates, (n_e, n_x).
        by_x: Of the forces by the coordinates, (n_x, n_x) [N/m].
        by_v: By the velocities, (n_x, n_x) [N s/m].
        mass: By the accelerations: mass matrix, (n_x, n_x) [kg].
        kinematics: Deformations and their rates.
        sigma: Stress resultants, (n_e,) [N, N m].
    """

    e: Float[Array, "n_e n_x"]
    ed: Float[Array, "n_e n_x"]
    edd: Float[Array, "n_e n_x"]
    by_x: Float[Array, "n_x n_x"]
    by_v: Float[Array, "n_x n_x"]
    mass: Float[Array, "n_x n_x"]
    kinematics: Kinematics
    sigma: Float[Array, "n_e"]


def strained(
    elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Deformations, (n_e,) [m, rad]; arguments as for :func:`deformed`."""
    own = [(block.e, block.over(lambda f, x: f(x)[0], near, x[block.x])) for block in elements if block.e.shape[1]]
    return scatter_vector(near.shape[0], own)


def heaviness(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Diagonal of the mass matrix, (n_x,) [kg, kg m, kg m^2]; arguments as for :func:`deformed`."""
    found = []
    for block in elements:
        if block.mass is not None:
            j = block.over(lambda f, x: _jacobian(lambda x: f(x)[1])(x)[1], near, x[block.x])
            found.append((block.x, jnp.einsum("nkdx,nkl,nldx->nx", j, block.mass, j)))
    return scatter_vector(x.shape[0], found)


def mass_of(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Mass matrix, (n_x, n_x) [kg, kg m, kg m^2]; arguments as for :func:`deformed`."""
    found = []
    for block in elements:
        if block.mass is not None:
            j = block.over(lambda f, x: _jacobian(lambda x: f(x)[1])(x)[1], near, x[block.x])
            found.append((block.x, block.x, jnp.einsum("nkdx,nkl,nldy->nxy", j, block.mass, j)))
    return scatter_matrix((x.shape[0], x.shape[0]), found)


def deformed(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Deformations and their derivatives by the nodal coordinates.

    Args:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations at the last accepted state, (n_e,) [m, rad].

    Returns:
        e, (n_e,) [m, rad], and D_x, (n_e, n_x).
    """
    values, rows = [], []
    for block in elements:
        if block.e.shape[1]:
            e, jacobian = block.over(lambda f, x: _jacobian(lambda x: f(x)[0])(x), near, x[block.x])
            values.append((block.e, e))
            rows.append((block.e, block.x, jacobian))
    n_e = near.shape[0]
    return scatter_vector(n_e, values), scatter_matrix((n_e, x.shape[0]), rows)


def second_rate(function: Callable[..., Any], x: Any, v: Any, a: Any):
    """Value of a function of coordinates and its first and second rate of change along a motion."""

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
    """Values (e, s) of one element, rates and second rates; those of s less free fall, which mass does not resist.

    Each may be a tree of arrays, or None.
    """
    if length(f, x) <= SHORT:
        y, yd, (edd, sdd) = second_rate(f, x, v, a)
        if falling is not None and sdd is not None:
            sdd = sdd - jax.jvp(f, (x,), (falling,))[1][1]
        return y, yd, (edd, sdd)
    rows = jets(f, (x, v, a), falling, directed=False)
    return _of_orders(rows, 3, falling, lambda rows: rows[0])


def _with_jacobians(
    f: Callable[..., Any],
    x: Float[Array, "c"],
    v: Float[Array, "c"],
    a: Float[Array, "c"],
    falling: Float[Array, "c"] | None,
):
    """As :func:`rates_along`, and the Jacobians of e and s."""
    if length(f, x) <= SHORT:
        (y, (d, j)), (_, (dd, jd)) = jax.jvp(_jacobian(f), (x,), (v,))
        ed, edd = (None, None) if d is None else (d @ v, d @ a + dd @ v)
        sdd = None if j is None else j @ (a if falling is None else a - falling) + jd @ v
        return (y, (ed, None), (edd, sdd)), (d, j)
    rows = jets(f, (x, v), None, directed=True)
    (y, (ed, _)), ((d, j), (dd, jd)) = (_of_orders(rows, 2, None, of) for of in (lambda rows: rows[0], _by_directions))
    edd = None if d is None else d @ a + dd @ v
    sdd = None if j is None else j @ (a if falling is None else a - falling) + jd @ v
    return (y, (ed, None), (edd, sdd)), (d, j)


def derived_rates(
    f: Callable[..., Any],
    x: Float[Array, "c"],
    v: Float[Array, "c"],
    a: Float[Array, "c"],
    falling: Float[Array, "c"] | None = None,
):
    """As :func:`rates_along`, and their derivatives by the coordinates, which are the last axis."""
    if length(f, x) <= SHORT:
        return _jacobian(lambda x: rates_along(f, x, v, a, falling))(x)
    rows = jets(f, (x, v, a), falling, directed=True)
    return tuple(_of_orders(rows, 3, falling, of) for of in (lambda rows: rows[0], _by_directions))


def _of_orders(rows: Any, orders: int, falling: Float[Array, "c"] | None, chosen: Callable[[Any], Any]):
    """Pairs of value and rates, of what is chosen of the rows of two trees; the last second rate less free fall."""

    def of(number: int, k: int):
        falls = number == 1 and k == 2 and falling is not None
        return jax.tree.map(lambda row: chosen(row[k] - row[3] if falls else row[k]), rows[number])

    return tuple((of(0, k), of(1, k)) for k in range(orders))


def _by_directions(rows: Float[Array, "..."]):
    """Derivatives, with the coordinates last."""
    return jnp.moveaxis(rows[1:], 0, -1)


def _pulled(
    f: Callable[..., Any], x: Float[Array, "c"], sigma: Float[Array, "d"] | None, weight: Float[Array, "k axes"] | None
):
    return jax.vjp(f, x)[1]((sigma, weight))[0]


def _weight(block: PreparedBlock, sdd: Any):
    """H s_ddot of every element, (elements, k, d), or None."""
    return None if block.mass is None else multiplied(block.mass, sdd)


def _stressed(block: PreparedBlock, sigma: Float[Array, "n_e"]):
    """Stress resultants of every element, (elements, deformations), or None."""
    return sigma[block.e] if block.e.shape[1] else None


def own_of(e: Int[Array, "elements d"], matrix: Float[Array, "n_e n_e"]) -> Float[Array, "elements d d"]:
    """What a matrix of all deformations has for each element, whose deformations are ``e``."""
    return matrix[e[:, :, None], e[:, None, :]]


def _along(block: PreparedBlock, at: Moving, falling: Float[Array, "n_x"] | None):
    return [None if of is None else of[block.x] for of in (at.x, at.v, at.a, falling)]


def _kinematics(rates: list[Any], near: Float[Array, "n_e"]) -> Kinematics:
    """Deformations and rates of the whole, from (e, s) and rates of every block."""
    own = [(block.e, (y[0], yd[0], ydd[0])) for block, (y, yd, ydd) in rates if block.e.shape[1]]
    return Kinematics(*scatter_vectors(near.shape[0], own, 3))


def acting_forces(
    elements: tuple[PreparedBlock, ...], at: Moving, falling: Float[Array, "n_x"] | None, stress: Callable[..., Any]
) -> Acting:
    """Deformations, stress resultants and nodal forces of elements in motion.

    Args:
        falling: Accelerations of free fall, which mass does not resist, (n_x,) [1/s^2], or None.
        stress: sigma as a function of e and e_dot, (n_e,) [N, N m].

    Source:
        THEORY.md 3 and 5, eq. (3.2) and (5.2): D_x^T sigma + J^T H s_ddot.
    """
    found = [(block, block.over(rates_along, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics(found, at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    forces = []
    for block, (_, _, (_, sdd)) in found:
        pulled = block.over(_pulled, at.near, at.x[block.x], _stressed(block, sigma), _weight(block, sdd))
        forces.append((block.x, pulled))
    return Acting(kinematics, sigma, scatter_vector(at.x.shape[0], forces))


def acting_matrices(
    elements: tuple[PreparedBlock, ...], at: Moving, falling: Float[Array, "n_x"] | None, stress: Callable[..., Any]
) -> tuple[Acting, Float[Array, "n_e n_x"], Float[Array, "n_x n_x"]]:
    """As :func:`acting_forces`, with D_x and the mass matrix, from the Jacobians of the elements.

    Returns:
        Acting, D_x and M.

    Source:
        See :func:`acting_forces`; M = J^T H J.
    """
    found = [(block, *block.over(_with_jacobians, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics([each[:2] for each in found], at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    forces, rows, masses = [], [], []
    for block, (_, _, (_, sdd)), (d, j) in found:
        forces += _pulled_by(block, sigma, sdd, d, j)
        if d is not None:
            rows.append((block.e, block.x, d))
        if j is not None:
            masses.append((block.x, block.x, jnp.einsum("nkdx,nkl,nldy->nxy", j, block.mass, j)))
    n_x = at.x.shape[0]
    acting = Acting(kinematics, sigma, scatter_vector(n_x, forces))
    return acting, scatter_matrix((at.near.shape[0], n_x), rows), scatter_matrix((n_x, n_x), masses)


def _pulled_by(block: PreparedBlock, sigma: Float[Array, "n_e"], sdd: Any, d: Any, j: Any):
    """D_x^T sigma and J^T H s_ddot of every element, those that there are, each with its coordinates."""
    found = []
    if d is not None:
        found.append((block.x, jnp.einsum("ni,nix->nx", _stressed(block, sigma), d)))
    if j is not None:
        found.append((block.x, jnp.einsum("nkd,nkdx->nx", _weight(block, sdd), j)))
    return found


def _derived_forces(
    f: Callable[..., Any], x: Float[Array, "c"], sigma: Float[Array, "d"] | None, weight: Float[Array, "k axes"] | None
):
    """Derivative of D_x^T sigma + J^T weight of one element."""
    return jax.jacfwd(lambda x: _pulled(f, x, sigma, weight))(x)


class OfElements(NamedTuple):
    """Derivatives of the forces of the elements of a block, each by its own coordinates; None where there are none.

    Attributes:
        e: D_x, (elements, d, k).
        ed: Of the rates, (elements, d, k).
        edd: Of the second rates, (elements, d, k).
        by_x: Of the forces by the coordinates, (elements, k, k) [N/m].
        by_v: By the velocities, (elements, k, k) [N s/m].
        mass: By the accelerations, (elements, k, k) [kg].
    """

    e: Float[Array, "elements d k"] | None
    ed: Float[Array, "elements d k"] | None
    edd: Float[Array, "elements d k"] | None
    by_x: Float[Array, "elements k k"]
    by_v: Float[Array, "elements k k"]
    mass: Float[Array, "elements k k"]


def deformed_elements(elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Deformations and their Jacobians of each block, element by element, None where it has none; see :func:`deformed`.

    Args:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
    """

    def found(f: Callable[..., Any], x: Float[Array, "c"]):
        return _jacobian(lambda x: f(x)[0])(x)

    return [block.over(found, near, x[block.x]) if block.e.shape[1] else None for block in elements]


def derivatives_of_elements(
    elements: tuple[PreparedBlock, ...],
    at: Moving,
    falling: Float[Array, "n_x"] | None,
    stress: Callable[..., Any],
    stiffness: tuple[Float[Array, "elements d d"] | None, ...],
    damping: tuple[Float[Array, "elements d d"] | None, ...],
) -> list[OfElements]:
    """As :func:`force_derivatives`, element by element, with the stiffness and damping of each block's elements.

    Source:
        Derivative of :func:`acting_forces`.
    """
    found = [(block, *block.over(derived_rates, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics([each[:2] for each in found], at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    return [_of_elements(at, sigma, each, *own) for each, *own in zip(found, stiffness, damping, strict=True)]


def _of_elements(
    at: Moving,
    sigma: Float[Array, "n_e"],
    found: tuple[Any, ...],
    stiffness: Float[Array, "elements d d"] | None,
    damping: Float[Array, "elements d d"] | None,
) -> OfElements:
    """Derivatives of one block from what :func:`derived_rates` gives, stress resultants, and tangents of its own."""
    block, (_, _, (_, sdd)), ((d, j), (dd, jd), (d2, j2)) = found
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
    return OfElements(d, dd, d2, by_x, by_v, mass)


def by_inertia(
    mass: Float[Array, "elements k k"],
    j: Float[Array, "elements k axes x"],
    jd: Float[Array, "elements k axes x"],
    j2: Float[Array, "elements k axes x"],
):
    """Derivatives of J^T H s_ddot of every element at constant J, by coordinates, velocities and accelerations.

    Args:
        mass: H.
        j: Derivative of the places of inertia by the coordinates: J.
        jd: Of their rates.
        j2: Of their second rates.
    """
    count, k, axes, columns = j.shape
    lever = (mass @ j.reshape(count, k, axes * columns)).reshape(count, k * axes, columns)
    every = jnp.concatenate([of.reshape(lever.shape) for of in (j, 2 * jd, j2)], axis=2)
    return jnp.split(lever.mT @ every, 3, axis=2)[::-1]


def force_derivatives(
    elements: tuple[PreparedBlock, ...],
    at: Moving,
    falling: Float[Array, "n_x"] | None,
    stress: Callable[..., Any],
    tangents: Callable[..., Any] | None = None,
) -> Derivatives:
    """Derivatives of all that :func:`acting_forces` gives, with the same arguments.

    ``tangents`` gives the derivatives of sigma by e and e_dot as a function of these: two matrices (n_e, n_e) without
    entries between elements, the second or None. Where it is None, sigma stays as it is.

    Source:
        Derivative of :func:`acting_forces`.
    """
    n_e, n_x = at.near.shape[0], at.x.shape[0]
    acting, found = element_derivatives(elements, at, falling, stress, tangents)
    rows = [(block.e, block.x, rows) for block, rows, _ in found if rows is not None]
    by_e = scatter_matrices((n_e, n_x), rows, 3)
    forces = scatter_matrices((n_x, n_x), [(block.x, block.x, squares) for block, _, squares in found], 3)
    return Derivatives(by_e[0], by_e[1], by_e[2], forces[0], forces[1], forces[2], acting.kinematics, acting.sigma)


def element_derivatives(
    elements: tuple[PreparedBlock, ...],
    at: Moving,
    falling: Float[Array, "n_x"] | None,
    stress: Callable[..., Any],
    tangents: Callable[..., Any] | None = None,
):
    """As :func:`force_derivatives`, of each element by itself; arguments as there.

    Returns:
        Acting forces, and of each block it, the derivatives of deformations, rates and second rates by the element's
        coordinates (None where it does not deform), and those of the forces by coordinates, velocities and
        accelerations.
    """
    found = [(block, *block.over(derived_rates, at.near, *_along(block, at, falling))) for block in elements]
    kinematics = _kinematics([each[:2] for each in found], at.near)
    sigma = stress(kinematics.e, kinematics.ed)
    stiffness, damping = (None, None) if tangents is None else tangents(kinematics.e, kinematics.ed)
    derived, forces = [], []
    for each in found:
        block, (_, _, (_, sdd)), (jacobians, *_) = each
        forces += _pulled_by(block, sigma, sdd, *jacobians)
        own = [None if of is None or not block.e.shape[1] else own_of(block.e, of) for of in (stiffness, damping)]
        of = _of_elements(at, sigma, each, *own)
        derived.append((block, None if of.e is None else (of.e, of.ed, of.edd), (of.by_x, of.by_v, of.mass)))
    return Acting(kinematics, sigma, scatter_vector(at.x.shape[0], forces)), derived
