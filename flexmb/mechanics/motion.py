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

from ..math.program import split
from ..math.record import Record, static
from ..model.parameters import Parameters
from ..model.topology import Topology
from .blocks import companion_of, scatter_matrices, scatter_matrix, scatter_vector, scatter_vectors

# Up to so many coordinates an element's Jacobian, and for derivatives its Hessian, is cheaper than products with it:
# the number of operations counts, not their size.
SMALL = 16


class Moving(Record):
    """Elements of one block as functions of what moves.

    Attributes:
        function: ``(x_el, *kept_el) -> (e_el, s_el)``, with the deformations at the last accepted state after x_el
            where angles are counted; e_el or s_el is None where there is none.
        x: Index of each element's coordinates, (elements, coordinates).
        e: Index of each element's deformations, (elements, deformations).
        kept: What the function needs to know of each element.
        mass: H of each element, (elements, k, k), or None.
        counts: Whether angles are counted.
    """

    function: Callable[..., Any] = static()
    x: Int[Array, "elements coordinates"]
    e: Int[Array, "elements deformations"]
    kept: tuple[Array, ...]
    mass: Float[Array, "elements k k"] | None
    counts: bool = static()

    def over(self, function, near, *along):
        """Values of a function of one element's ``e, s`` for all of them.

        Args:
            function: Of ``(f, *along_el)`` where ``f(x_el) -> (e_el, s_el)``.
            near: Deformations at the last accepted state, (n_e,) [m, rad].
            along: What it is mapped over, rows in the order of the elements.
        """
        rest = (near[self.e], *self.kept) if self.counts else self.kept

        def one(rest, *along):
            return function(lambda x: self.function(x, *rest), *along)

        return jax.vmap(one)(rest, *along)


def moving_elements(topology: Topology, parameters: Parameters) -> tuple[Moving, ...]:
    """All elements that deform or carry mass, with what does not change in a motion worked out.

    Args:
        topology: Structure.
        parameters: Numbers.
    """
    found = []
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        deformation, known = companion_of(block, properties, "deformation")
        inertia, heavy = companion_of(block, properties, "inertia")
        if not block.e.shape[1]:
            deformation = None
        if deformation is None and inertia is None:
            continue
        counts = deformation is not None and block.element.tracks_angle
        ref = parameters.reference[block.x]

        def both(x, *rest, deformation=deformation, inertia=inertia, counts=counts):
            *near, ref, known, heavy = rest
            e = None if deformation is None else deformation(x, ref, known, **({"near": near[0]} if counts else {}))
            return e, None if inertia is None else inertia(x, ref, heavy)[0]

        first = jax.tree.map(lambda rows: jax.ShapeDtypeStruct(rows.shape[1:], rows.dtype), (ref, known, heavy))
        like = jax.ShapeDtypeStruct(ref.shape[1:], ref.dtype)
        varying = (like, jax.ShapeDtypeStruct(block.e.shape[1:], ref.dtype)) if counts else (like,)
        early, late = split(both, varying, first)
        kept = jax.vmap(early)(ref, known, heavy)
        mass = None if inertia is None else jax.vmap(lambda *own, f=inertia: f(*own)[1])(ref, ref, heavy)
        found.append(Moving(late, block.x, block.e, kept, mass, counts))
    return tuple(found)


def _jacobian(f):
    """Function from coordinates to values and Jacobians; a Jacobian has the coordinates last."""

    def found(x):
        def twice(x):
            y = f(x)
            return y, y

        jacobian, y = jax.jacfwd(twice, has_aux=True)(x)
        return y, jacobian

    return found


def _second_rate(function, x, v, a):
    """Value of a function of coordinates and its first and second rate of change along a motion."""

    def first(x, v):
        return jax.jvp(function, (x,), (v,))

    (value, rate), (_, second) = jax.jvp(first, (x, v), (v, a))
    return value, rate, second


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
        jacobian: D_x, (n_e, n_x), where asked for.
        mass: Mass matrix, (n_x, n_x), where asked for.
    """

    kinematics: Kinematics
    sigma: Float[Array, "n_e"]
    force: Float[Array, "n_x"]
    jacobian: Any = None
    mass: Any = None


class Derivatives(NamedTuple):
    """Derivatives of the forces of elements in motion.

    Attributes:
        e: D_x, (n_e, n_x); of the rates by the velocities and of the second rates by the accelerations too.
        ed: Of the rates by the coordinates, (n_e, n_x); of the second rates by the velocities it is twice this.
        edd: Of the second rates by the coordinates, (n_e, n_x).
        curvature: Of the forces of stress by the coordinates, at constant sigma, (n_x, n_x) [N/m].
        inertia: Of the forces of inertia by the coordinates, (n_x, n_x) [N/m].
        by_v: Of the forces of inertia by the velocities, (n_x, n_x) [N s/m].
        mass: By the accelerations: mass matrix, (n_x, n_x) [kg].
        kinematics: Deformations and their rates.
        sigma: Stress resultants, (n_e,) [N, N m].
    """

    e: Float[Array, "n_e n_x"]
    ed: Float[Array, "n_e n_x"]
    edd: Float[Array, "n_e n_x"]
    curvature: Float[Array, "n_x n_x"]
    inertia: Float[Array, "n_x n_x"]
    by_v: Float[Array, "n_x n_x"]
    mass: Float[Array, "n_x n_x"]
    kinematics: Kinematics
    sigma: Float[Array, "n_e"]


def deformed(elements: tuple[Moving, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    """Deformations and their derivatives by the nodal coordinates.

    Args:
        elements: Elements.
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


def _rates(f, x, v, a, lifted):
    """Of one element e, its rates, s_ddot, and no Jacobians."""
    e = _second_rate(lambda x: f(x)[0], x, v, a)
    return *e, _second_rate(lambda x: f(x)[1], x, v, lifted)[2], (None, None)


def _expanded_rates(f, x, v, a, lifted):
    """Of one element e, its rates, s_ddot, and the Jacobians of e and s."""
    ((e, s), (d, j)), (_, (dd, jd)) = jax.jvp(_jacobian(f), (x,), (v,))
    ed, edd = (None, None) if e is None else (d @ v, d @ a + dd @ v)
    return e, ed, edd, None if s is None else j @ lifted + jd @ v, (d, j)


def acting_forces(
    elements: tuple[Moving, ...],
    x: Float[Array, "n_x"],
    v: Float[Array, "n_x"],
    a: Float[Array, "n_x"],
    lifted: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    stress: Callable[..., Any],
    matrices: bool = False,
) -> Acting:
    """Deformations, stress resultants and nodal forces of elements in motion.

    Args:
        elements: Elements.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].
        lifted: The same less free fall: what the mass resists, (n_x,) [1/s^2].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        stress: sigma as a function of e and e_dot, (n_e,) [N, N m].
        matrices: Whether to give D_x and the mass matrix too.

    Source:
        FORMULATION.md 3 and 5: D_x^T sigma + J^T H s_ddot.
    """
    n_e, n_x = near.shape[0], x.shape[0]
    values, found = [], []
    for block in elements:
        along = [of[block.x] for of in (x, v, a, lifted)]
        rates = _expanded_rates if matrices or block.x.shape[1] <= SMALL else _rates
        *kinematics, sdd, jacobians = block.over(rates, near, *along)
        if kinematics[0] is not None:
            values.append((block.e, tuple(kinematics)))
        found.append((block, None if sdd is None else block.mass @ sdd, jacobians))
    kinematics = Kinematics(*scatter_vectors(n_e, values, 3))
    sigma = stress(kinematics.e, kinematics.ed)
    forces, rows, masses = [], [], []
    for block, weight, (d, j) in found:
        own = None if not block.e.shape[1] else sigma[block.e]
        if d is None and j is None:
            forces.append((block.x, block.over(_pulled, near, x[block.x], own, weight)))
            continue
        if d is not None:
            forces.append((block.x, jnp.einsum("ni,nix->nx", own, d)))
            rows.append((block.e, block.x, d))
        if j is not None:
            forces.append((block.x, jnp.einsum("nkd,nkdx->nx", weight, j)))
            masses.append((block.x, block.x, _mass(block.mass, j)))
    force = scatter_vector(n_x, forces)
    if not matrices:
        return Acting(kinematics, sigma, force)
    return Acting(kinematics, sigma, force, scatter_matrix((n_e, n_x), rows), scatter_matrix((n_x, n_x), masses))


def _pulled(f, x, sigma, weight):
    return jax.vjp(f, x)[1]((sigma, weight))[0]


def _mass(mass, j):
    """Element mass matrices J^T H J, (elements, coordinates, coordinates)."""
    return jnp.einsum("nkdx,nkdy->nxy", j, jnp.einsum("nkl,nldy->nkdy", mass, j))


class _Expansion(NamedTuple):
    """Derivatives of one element's e and s by its coordinates: D_x, of e_dot, of e_ddot; J, of s_dot, of s_ddot."""

    d: Any
    d_rate: Any
    d_second: Any
    j: Any
    j_rate: Any
    j_second: Any


def _hessian(f):
    """Function from coordinates to values, Jacobians and Hessians."""

    def found(x):
        def twice(x):
            y, jacobian = _jacobian(f)(x)
            return jacobian, (y, jacobian)

        hessian, (y, jacobian) = jax.jacfwd(twice, has_aux=True)(x)
        return y, jacobian, hessian

    return found


def _expanded(f, x, v, a, lifted):
    """Of one element e, e_dot, e_ddot, s_ddot, all derivatives, and the Hessians of e and s."""
    ((e, _), (d, j), (d2, j2)), (_, (dd, jd), (dd2, jd2)) = jax.jvp(_hessian(f), (x,), (v,))
    rates, of_e = (None, None, None), (None, None, None)
    if e is not None:
        rates, of_e = (e, d @ v, d @ a + dd @ v), (d, dd, d2 @ a + dd2 @ v)
    sdd, of_s = None, (None, None, None)
    if j is not None:
        sdd, of_s = j @ lifted + jd @ v, (j, jd, j2 @ lifted + jd2 @ v)
    return rates, sdd, _Expansion(*of_e, *of_s), (d2, j2)


def _contracted(f, x, v, a, lifted, sigma, weight):
    """Of one element all derivatives, and the products of the Hessians with sigma and with weight."""

    def everything(x):
        e = _second_rate(lambda x: f(x)[0], x, v, a)
        s = _second_rate(lambda x: f(x)[1], x, v, lifted)
        of_e, of_s = (jax.vjp(lambda x, i=i: f(x)[i], x)[1] for i in (0, 1))
        return _Expansion(*e, *s), (of_e(sigma)[0], of_s(weight)[0])

    return jax.jacfwd(everything)(x)


def force_derivatives(
    elements: tuple[Moving, ...],
    x: Float[Array, "n_x"],
    v: Float[Array, "n_x"],
    a: Float[Array, "n_x"],
    lifted: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    stress: Callable[..., Any],
) -> Derivatives:
    """Derivatives of all that :func:`acting_forces` gives, at constant sigma.

    Args:
        elements: Elements.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        a: Their accelerations, (n_x,) [1/s^2].
        lifted: The same less free fall, (n_x,) [1/s^2].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        stress: sigma as a function of e and e_dot, (n_e,) [N, N m].

    Returns:
        Derivatives.

    Source:
        Derivative of :func:`acting_forces`.
    """
    n_e, n_x = near.shape[0], x.shape[0]
    values, found = [], []
    for block in elements:
        along = [of[block.x] for of in (x, v, a, lifted)]
        if block.x.shape[1] <= SMALL:
            rates, sdd, expansion, hessians = block.over(_expanded, near, *along)
        else:
            *rates, sdd, _ = block.over(_rates, near, *along)
            expansion = hessians = None
        if rates[0] is not None:
            values.append((block.e, tuple(rates)))
        found.append((block, along, None if sdd is None else block.mass @ sdd, expansion, hessians))
    kinematics = Kinematics(*scatter_vectors(n_e, values, 3))
    sigma = stress(kinematics.e, kinematics.ed)
    rows, squares = [], []
    for block, along, weight, expansion, hessians in found:
        own = None if not block.e.shape[1] else sigma[block.e]
        curvature: Any
        turning: Any
        if hessians is None:
            expansion, (curvature, turning) = block.over(_contracted, near, *along, own, weight)
        else:
            d2, j2 = hessians
            curvature = None if d2 is None else jnp.einsum("ni,nixy->nxy", own, d2)
            turning = None if j2 is None else jnp.einsum("nkd,nkdxy->nxy", weight, j2)
        nothing = jnp.zeros((*block.x.shape, block.x.shape[1]))
        if own is not None:
            rows.append((block.e, block.x, expansion[:3]))
        second = rate = mass = nothing
        if weight is not None:
            lever = jnp.einsum("nkl,nldx->nkdx", block.mass, expansion.j)
            mass, rate, second = (
                jnp.einsum("nkdx,nkdy->nxy", lever, of) for of in (expansion.j, expansion.j_rate, expansion.j_second)
            )
            second = second + turning
        curved = nothing if own is None else curvature
        squares.append((block.x, block.x, (curved, second, 2 * rate, mass)))
    by_e = scatter_matrices((n_e, n_x), rows, 3)
    forces = scatter_matrices((n_x, n_x), squares, 4)
    return Derivatives(by_e[0], by_e[1], by_e[2], forces[0], forces[1], forces[2], forces[3], kinematics, sigma)
