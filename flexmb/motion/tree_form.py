"""Motion in the coordinates that no beam with strain series gives: ends of such beams are computed, not solved for."""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record
from ..math.indices import accumulate, put
from ..mechanics.deformation import zero_near
from ..mechanics.loads import LoadFactors, load_stiffness
from ..mechanics.tree import Passages, Tree, linked, passages, passed, some_of
from .coordinates_form import AllCoordinates, CoordinatesForm, bordered, onto_constraints, solved_twice
from .element_forces import (
    Moving,
    PreparedBlock,
    acting_forces,
    acting_matrices,
    deformed,
    derived_rates,
    element_derivatives,
    prepared_block,
    rates_along,
    second_rate,
    strained,
    without_last_end,
)
from .protocol import MotionState, Tangent, WholeMotion


class _Carried(NamedTuple):
    """A state of motion of the whole, and its derivatives by what moves.

    Attributes:
        at: Coordinates and their rates, with what is driven.
        x: Derivative of the coordinates; of the velocities by the velocities and of the accelerations by the
            accelerations too, (n_x, n).
        v: Derivative of the velocities by the positions; of the accelerations by the velocities it is twice this. None
            where the coordinates are what moves.
        a: Derivative of the accelerations by the positions.
        ways: Way and turn of each beam.
        passed: Derivative of these.
    """

    at: AllCoordinates
    x: Float[Array, "n_x n"]
    v: Float[Array, "n_x n"] | None
    a: Float[Array, "n_x n"] | None
    ways: Float[Array, "beams way_and_turn"] | None
    passed: Float[Array, "beams way_and_turn n"] | None


class TreeForm(Record):
    """Equations of motion X_u^T R(X(u), ..) with X(u) the coordinates as a tree of beams places them.

    Constraints that X keeps have no multipliers: the closures of its beams, and the unit norms of rotations that they
    give. The others have theirs, as in all coordinates.

    Attributes:
        form: Equations in all coordinates, but that those alone move by themselves that are not computed.
        tree: What is computed.
        passages: By what.
        felt: By what those are that something acts or depends on.
        mobility: Inverse masses of what moves, (n,).
    """

    form: CoordinatesForm
    tree: Tree
    passages: tuple[Passages, ...]
    felt: tuple[Passages, ...]
    mobility: Float[Array, "n"]

    @property
    def states(self) -> int:
        """Number of states of a controller: none."""
        return 0

    @property
    def size(self) -> int:
        """Number of coordinates that move and are not computed."""
        return self.form.size

    @property
    def linear(self) -> bool:
        """Accelerations and multipliers follow from their matrix."""
        return True

    @property
    def unknowns(self) -> int:
        """Number of accelerations and multipliers."""
        return self.size + self.tree.held_places.shape[0]

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates, of which those that are computed are not read."""
        return self.form.state_of(x, xd, near)

    def placed(self, x: Float[Array, "n_x"]):
        """Nodal coordinates with those computed that something acts or depends on, (n_x,)."""
        return x if self.tree.felt is None else linked(self.tree.felt, passed(self.felt, x), x)

    def whole(
        self, t: Float[Array, ""], u: Float[Array, "n"], w: Float[Array, "n"], a: Float[Array, "n"]
    ) -> AllCoordinates:
        """Coordinates and their rates, those computed that something acts or depends on.

        Arguments as of :meth:`CoordinatesForm.whole`.
        """
        at = self.form.whole(t, u, w, a)
        if self.tree.felt is None:
            return at

        ways = _joined([_passage_rates(one, at) for one in self.felt])
        x, v, acc = self._linked((at.x, at.v, at.a), ways)
        return at._replace(x=x, v=v, a=acc)

    def along(self, t: Float[Array, ""], u: Float[Array, "n"]) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves."""
        if self.tree.felt is None:
            return self.places
        none = jnp.zeros(self.size)
        return jax.jacfwd(lambda u: self.placed(self.form.whole(t, u, none, none).x))(u)

    @property
    def places(self) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves, where nothing is computed."""
        return (
            jnp.zeros((self.form.topology.n_x, self.size)).at[self.form.free, np.arange(self.size)].set(self.form.sizes)
        )

    def _linked(self, x: tuple[Array, ...], ways: tuple[Array, ...]):
        """Coordinates, rates and second rates of the whole, of the same of what moves and of the beams' ways."""
        poses: Any = self.tree.felt
        return second_rate(lambda both: linked(poses, both[1], both[0]), *zip(x, ways, strict=True))

    def carried(
        self, t: Float[Array, ""], u: Float[Array, "n"], w: Float[Array, "n"], a: Float[Array, "n"]
    ) -> _Carried:
        """Coordinates and their rates as :meth:`whole`, and their derivatives by what moves.

        Of each beam way and turn are differentiated by its own coefficients, and what the tree makes of them by all.
        """
        poses, places = self.tree.felt, self.places
        at = self.form.whole(t, u, w, a)
        if poses is None:
            return _Carried(at, places, None, None, None, None)
        found = [_derived_passage_rates(one, at) for one in self.felt]
        ways = _joined([ways for ways, _ in found])
        own = zip(self.felt, [slopes for _, slopes in found], strict=True)
        slopes = _joined([[slope @ places[one.c] for slope in slopes] for one, slopes in own])
        none = jnp.zeros(at.x.shape)

        def along(place: Float[Array, "n_x"], *slope: Array):
            return jax.jvp(self._linked, ((at.x, at.v, at.a), ways), ((place, none, none), slope))[1]

        x, v, acc = self._linked((at.x, at.v, at.a), ways)
        derivatives: Any = jax.vmap(along, (1, 2, 2, 2), 1)(places, *slopes)
        by_x, by_v, by_a = derivatives
        return _Carried(at._replace(x=x, v=v, a=acc), by_x, by_v, by_a, ways[0], slopes[0])

    def turned(self, t: Float[Array, ""], u: Float[Array, "n"], to: _Carried, force: Float[Array, "n_x"]):
        """Derivative by what moves of what nodal forces, (n_x,) [N, N m], do along it, (n, n)."""
        poses: Any = self.tree.felt
        places = self.places
        x = self.form.whole(t, u, u, u).x

        def pulled(x: Float[Array, "n_x"], y: Float[Array, "beams k"]):
            return jax.vjp(lambda x, y: linked(poses, y, x), x, y)[1](force)

        y: Any = to.ways
        of_x, of_y = jax.vmap(lambda *own: jax.jvp(pulled, (x, y), own)[1], (1, 2), (1, 2))(places, to.passed)
        found = places.T @ of_x + jnp.einsum("byn,bym->nm", to.passed, of_y)
        weights, first = pulled(x, y)[1], 0
        for one in self.felt:
            own = weights[first : first + one.c.shape[0]]
            first += one.c.shape[0]
            bent = _bent(one, x[one.c], own)
            found = found + jnp.einsum("bkn,bkl,blm->nm", places[one.c], bent, places[one.c])
        return found

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at = self.form.whole(t, state.u, state.w, jnp.zeros(self.size))
        x, v = jax.jvp(lambda x: linked(self.tree.poses, passed(self.passages, x), x), (at.x,), (at.v,))
        near = state.memory
        if not near.shape[0]:
            near = strained(self.form.elements, x, zero_near(self.form.topology))
        return WholeMotion(x, v, near, jnp.zeros(0))

    def stress_of(self, t: Float[Array, ""], multipliers: Float[Array, "m"]):
        """As :meth:`CoordinatesForm.stress_of`, of the multipliers that there are."""
        every = jnp.zeros(self.form.held.shape[0])
        return self.form.stress_of(t, put(every, self.tree.held_places, multipliers))

    def held(self, rows: Float[Array, "n_e *k"]):
        """Rows of the held deformations that have multipliers."""
        return rows[self.form.held[self.tree.held_places]]

    def wanted(self, values: Float[Array, "h"]):
        """What these are held at, of all that are held."""
        return values[self.tree.held_places]

    def forces(
        self, t: Float[Array, ""], at: AllCoordinates, memory: Float[Array, "k"], multipliers: Float[Array, "m"]
    ):
        """Kinematics, and nodal forces out of balance, (n_x,) [N, N m]."""
        moving = Moving(at.x, at.v, at.a, self.form.near(memory))
        acting = acting_forces(self.form.elements, moving, self.form.falling, self.stress_of(t, multipliers))
        return acting.kinematics, acting.force - self.form.applied(t, at.x)

    def pulled(self, t: Float[Array, ""], u: Float[Array, "n"], force: Float[Array, "n_x"]):
        """Forces along what moves, (n,) [N m], of nodal forces, (n_x,) [N, N m]."""
        if self.tree.felt is None:
            return force[self.form.free] * self.form.sizes
        none = jnp.zeros(self.size)
        return jax.vjp(lambda u: self.placed(self.form.whole(t, u, none, none).x), u)[1](force)[0]

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance along what moves [N m], second rates of the held deformations.

        Source:
            THEORY.md 9 (d), eq. (9.8).
        """
        n = self.size
        at = self.whole(t, state.u, state.w, z[:n])
        kin, force = self.forces(t, at, state.memory, z[n:])
        return jnp.concatenate([self.pulled(t, state.u, force), self.held(kin.edd) - self.wanted(at.edd)])

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Held deformations less what they are held at, (m,) [m, rad]."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        return self.held(strained(self.form.elements, at.x, self.form.near(state.memory))) - self.wanted(at.e)

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of the residual.

        Source:
            THEORY.md 9 (d), eq. (9.9).
        """
        n, form = self.size, self.form
        to = self.carried(t, state.u, state.w, z[:n])
        at = to.at
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))

        def following(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            return [None if of is None else put(of, form.held, 0.0) for of in form.tangents(t, e, ed)]

        stress = self.stress_of(t, z[n:])
        acting, found = element_derivatives(form.elements, moving, form.falling, stress, following)
        every = sum(_along(to, block.x, squares) for block, _, squares in found)
        by_u, by_w, mass = jnp.split(every, 3, axis=1)
        loads = self.by_loads(t, at.x)
        if loads is not None:
            by_u = by_u - to.x.T @ loads @ to.x
        if to.v is not None:
            by_u = by_u + self.turned(t, state.u, to, acting.force - form.applied(t, at.x))
        rows = jnp.zeros((0, n))
        if self.tree.held_places.shape[0]:
            pieces = [(block.e, _rows_along(to, block.x, own)) for block, own, _ in found if own is not None]
            every = jnp.zeros((form.topology.n_e, 3 * n))
            for e, own in pieces:
                every = accumulate(every, e, own)
            edd_by_u, edd_by_w, rows = jnp.split(self.held(every), 3, axis=1)
            by_u, by_w = jnp.concatenate([by_u, edd_by_u]), jnp.concatenate([by_w, edd_by_w])
        by_t = None
        if form.driven:
            by_t = jax.jvp(lambda t: self.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
        return Tangent(by_u, by_w, bordered(mass, rows, self.mobility), by_t)

    def by_loads(self, t: Float[Array, ""], x: Float[Array, "n_x"]):
        """Derivative of the nodal forces of loads by the nodal coordinates, (n_x, n_x), or None where there is none."""
        form, drive = self.form, self.form.drive(t)
        top, parameters = form.topology, form.parameters
        if parameters.increment is None and all(block.element.force is None for block in top.blocks):
            return drive.turning
        found = load_stiffness(top, parameters, LoadFactors(1.0, drive.increment), x)
        return found if drive.turning is None else found + drive.turning

    def regular(self, by_z: Float[Array, "r r"]):
        """Whether every motion that the constraints allow carries mass."""
        return self.form.regular(by_z)

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations [1/s^2] and multipliers [N, N m], and whether every motion carries mass.

        Source:
            THEORY.md 9 (b), eq. (9.2): one symmetric solve.
        """
        n, form = self.size, self.form
        at, along = self.whole(t, state.u, state.w, jnp.zeros(n)), self.along(t, state.u)
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        stress = self.stress_of(t, jnp.zeros(self.tree.held_places.shape[0]))
        acting, jacobian, mass = acting_matrices(form.elements, moving, form.falling, stress)
        mass, rows = along.T @ mass @ along, self.held(jacobian) @ along
        force = along.T @ (acting.force - form.applied(t, at.x))
        residual = jnp.concatenate([force, self.held(acting.kinematics.edd) - self.wanted(at.edd)])
        z, matrix = solved_twice(mass, rows, self.mobility, residual)
        return z, self.regular(matrix)

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Rates of the deformations, where turns are counted."""
        if not state.memory.shape[0]:
            return state.memory
        at = self.whole(t, state.u, state.w, z[: self.size])
        return deformed(self.form.elements, at.x, state.memory)[1] @ at.v

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Positions and velocities brought back onto the constraints that have multipliers.

        Source:
            THEORY.md 9, eq. (9.3).
        """
        u, w = state.u, state.w
        form, near, zero = self.form, self.form.near(state.memory), jnp.zeros_like(state.u)
        if self.tree.held_places.shape[0]:

            def excess(u: Float[Array, "n"], w: Float[Array, "n"]):
                at = self.whole(t, u, w, zero)
                e, jacobian = deformed(form.elements, at.x, near)
                of_both = [self.held(e) - self.wanted(at.e), self.held(jacobian @ at.v) - self.wanted(at.ed)]
                return jnp.stack(of_both, axis=1), self.held(jacobian) @ self.along(t, u)

            u, w = onto_constraints(u, w, excess, mass, self.mobility)
        memory = state.memory
        if memory.shape[0]:
            memory = strained(form.elements, self.whole(t, u, w, zero).x, memory)
        return MotionState(u, w, memory)


def _joined(rows: Sequence[Sequence[Array]]):
    """Of several blocks of beams one array of each kind."""
    return tuple(jnp.concatenate(own) for own in zip(*rows, strict=True))


def _passage_rates(one: Passages, at: AllCoordinates):
    """Way and turn of beams, rates and second rates, (beams, d + r) each."""

    def rates(c: Float[Array, "c"], v: Float[Array, "c"], a: Float[Array, "c"], *kept: Array):
        return [y for y, _ in rates_along(lambda c: (one.along(c, *kept), None), c, v, a)]

    return jax.vmap(rates)(*(of[one.c] for of in (at.x, at.v, at.a)), *one.kept)


def _derived_passage_rates(one: Passages, at: AllCoordinates):
    """As :func:`_passage_rates`, and their derivatives by the coefficients."""

    def rates(c: Float[Array, "c"], v: Float[Array, "c"], a: Float[Array, "c"], *kept: Array):
        return [[y for y, _ in rows] for rows in derived_rates(lambda c: (one.along(c, *kept), None), c, v, a)]

    return jax.vmap(rates)(*(of[one.c] for of in (at.x, at.v, at.a)), *one.kept)


def _bent(one: Passages, c: Float[Array, "beams c"], weights: Float[Array, "beams k"]):
    """Second derivatives of way and turn of beams, times weights, (beams, coefficients, coefficients)."""

    def gradient(c: Float[Array, "c"], weights: Float[Array, "k"], *kept: Array):
        return jax.grad(lambda c: weights @ one.along(c, *kept))(c)

    return jax.vmap(jax.jacfwd(gradient))(c, weights, *one.kept)


def _along(to: _Carried, x: Int[Array, "elements c"], squares: tuple[Array, Array, Array]):
    """Sum over elements of the derivatives of their forces, by what moves, its rates and second rates, (n, 3 n)."""
    by_x, by_v, mass = squares
    own = to.x[x]
    every = by_x @ own, by_v @ own, mass @ own
    if to.v is not None and to.a is not None:
        v, a = to.v[x], to.a[x]
        every = every[0] + by_v @ v + mass @ a, every[1] + 2 * mass @ v, every[2]
    return jnp.einsum("ekn,ekm->nm", own, jnp.concatenate(every, axis=2))


def _rows_along(to: _Carried, x: Int[Array, "elements c"], rows: tuple[Array, Array, Array]):
    """Derivatives of second rates of elements' deformations, by what moves, its rates and second rates."""
    d, dd, d2 = rows
    own = to.x[x]
    every = d2 @ own, 2 * dd @ own, d @ own
    if to.v is not None and to.a is not None:
        v, a = to.v[x], to.a[x]
        every = every[0] + 2 * dd @ v + d @ a, every[1] + 2 * d @ v, every[2]
    return jnp.concatenate(every, axis=2)


def tree_form(form: CoordinatesForm, tree: Tree) -> TreeForm:
    """Equations of motion of a model in the coordinates that its beams do not give.

    Args:
        form: The same in all coordinates.
        tree: Which poses are computed.
    """
    top, parameters = form.topology, form.parameters
    elements: list[PreparedBlock | None] = []
    for block, properties, (short, whole) in zip(top.blocks, parameters.properties, tree.rows, strict=True):
        for rows, prepare in ((short, without_last_end), (whole, prepared_block)):
            if rows.shape[0]:
                elements.append(prepare(*some_of(block, properties, rows), parameters.reference))
    own = dataclasses.replace(
        form,
        elements=tuple(one for one in elements if one is not None),
        free=tree.kept,
        sizes=form.sizes[tree.kept_places],
        mobility=form.mobility[tree.kept_places],
    )
    felt = () if tree.felt is None else passages(top, parameters, tree.felt)
    found = TreeForm(own, tree, passages(top, parameters, tree.poses), felt, own.mobility)
    return dataclasses.replace(found, mobility=_mobility(found, form)) if tree.held_places.shape[0] else found


def _mobility(found: TreeForm, form: CoordinatesForm):
    """Inverse masses of what moves, with all that it takes along, in the undeformed mechanism; as those of all."""

    def moved(u: Float[Array, "n"]):
        x = accumulate(form.parameters.reference, found.tree.kept, found.form.sizes * u)
        return found.placed(x)[form.free] / form.sizes

    along = jax.lax.stop_gradient(jax.jacfwd(moved)(jnp.zeros(found.size)))
    return 1.0 / ((along**2).T @ (1.0 / form.mobility))
