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
from ..mechanics.blocks import scatter_vector, scatter_vectors
from ..mechanics.deformation import zero_near
from ..mechanics.loads import LoadFactors, load_stiffness
from ..mechanics.tree import Tree, linked, some_of
from .coordinates_form import AllCoordinates, CoordinatesForm, bordered, onto_constraints, places_of, solved_twice
from .element_forces import (
    Kinematics,
    Moving,
    PreparedBlock,
    acting_forces,
    deformed,
    element_derivatives,
    mass_of,
    prepared_block,
    second_rate,
    strained,
)
from .protocol import MotionState, Tangent, WholeMotion
from .tree_beams import Bent, TreeBeams, tree_beams


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
        bent: Of the beams of each block what follows from their coefficients, with rates and second rates.
        slopes: Derivatives of these.
    """

    at: AllCoordinates
    x: Float[Array, "n_x n"]
    v: Float[Array, "n_x n"] | None
    a: Float[Array, "n_x n"] | None
    ways: Float[Array, "beams way_and_turn"] | None
    passed: Float[Array, "beams way_and_turn n"] | None
    bent: list[tuple[Bent, Bent, Bent]]
    slopes: list[tuple[Bent, Bent, Bent]]


class TreeForm(Record):
    """Equations of motion X_u^T R(X(u), ..) with X(u) the coordinates as a tree of beams places them.

    Constraints that X keeps have no multipliers: the closures of its beams, and the unit norms of rotations that they
    give. The others have theirs, as in all coordinates.

    Attributes:
        form: Equations in all coordinates, but that those alone move by themselves that are not computed, and that
            ``beams`` are not among its elements.
        tree: What is computed.
        beams: By what.
        mobility: Inverse masses of what moves, (n,).
    """

    form: CoordinatesForm
    tree: Tree
    beams: tuple[TreeBeams, ...]
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
        if self.tree.felt is None:
            return x
        return linked(self.tree.felt, jnp.concatenate([one.felt_ways(x) for one in self.beams if one.parts]), x)

    def whole(
        self, t: Float[Array, ""], u: Float[Array, "n"], w: Float[Array, "n"], a: Float[Array, "n"]
    ) -> AllCoordinates:
        """Coordinates and their rates, those computed that something acts or depends on.

        Arguments as of :meth:`CoordinatesForm.whole`.
        """
        at = self.form.whole(t, u, w, a)
        return self._with_ends(at, [one.rates(at) for one in self.beams if one.parts])

    def along(self, t: Float[Array, ""], u: Float[Array, "n"]) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves."""
        if self.tree.felt is None:
            return self.selection
        none = jnp.zeros(self.size)
        return jax.jacfwd(lambda u: self.placed(self.form.whole(t, u, none, none).x))(u)

    @property
    def selection(self) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves, where nothing is computed."""
        return (
            jnp.zeros((self.form.topology.n_x, self.size)).at[self.form.free, np.arange(self.size)].set(self.form.sizes)
        )

    def _with_ends(self, at: AllCoordinates, bent: list[tuple[Bent, Bent, Bent]]) -> AllCoordinates:
        """Coordinates and their rates, with those computed that something acts or depends on."""
        if self.tree.felt is None:
            return at
        x, v, a = self._linked((at.x, at.v, at.a), _ways(bent))
        return at._replace(x=x, v=v, a=a)

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
        selected = self.selection
        at = self.form.whole(t, u, w, a)
        found = [one.derived(at) for one in self.beams]
        bent, derived = [own for own, _ in found], [own for _, own in found]
        if self.tree.felt is None:
            return _Carried(at, selected, None, None, None, None, bent, derived)
        # Of each block by its own coefficients, (beams, way and turn, coefficients).
        of = [(one.c, own) for one, own in zip(self.beams, derived, strict=True) if one.parts]
        slopes = _joined([[_beside(each) @ selected[c] for each in own] for c, own in of])
        ways, none = _ways(bent), jnp.zeros(at.x.shape)

        def along(place: Float[Array, "n_x"], *slope: Array):
            return jax.jvp(self._linked, ((at.x, at.v, at.a), ways), ((place, none, none), slope))[1]

        x, v, acc = self._linked((at.x, at.v, at.a), ways)
        derivatives: Any = jax.vmap(along, (1, 2, 2, 2), 1)(selected, *slopes)
        by_x, by_v, by_a = derivatives
        return _Carried(at._replace(x=x, v=v, a=acc), by_x, by_v, by_a, ways[0], slopes[0], bent, derived)

    def turned(self, to: _Carried, force: Float[Array, "n_x"]):
        """What nodal forces, (n_x,) [N, N m], do on the ways and turns of beams, and along what moves as that turns.

        Returns:
            Forces on way and turn of each beam, and the derivative by what moves of those along it, (n, n), but for
            what beams add whose way and turn bend.
        """
        poses: Any = self.tree.felt
        selected, x = self.selection, to.at.x

        def pulled(x: Float[Array, "n_x"], y: Float[Array, "beams k"]):
            return jax.vjp(lambda x, y: linked(poses, y, x), x, y)[1](force)

        y: Any = to.ways
        of_x, of_y = jax.vmap(lambda *own: jax.jvp(pulled, (x, y), own)[1], (1, 2), (1, 2))(selected, to.passed)
        return pulled(x, y)[1], selected.T @ of_x + jnp.einsum("byn,bym->nm", to.passed, of_y)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at = self.form.whole(t, state.u, state.w, jnp.zeros(self.size))

        def everywhere(x: Float[Array, "n_x"]):
            return linked(self.tree.poses, jnp.concatenate([one.ways(x) for one in self.beams if one.gives]), x)

        x, v = jax.jvp(everywhere, (at.x,), (at.v,))
        near = state.memory
        if not near.shape[0]:
            near = self.strained(x, zero_near(self.form.topology))
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

    def _strains(self, at: AllCoordinates) -> Kinematics:
        """Deformations of the beams, which are their coefficients, and their rates; zero for all others."""
        own = [(one.e, (at.x[one.c], at.v[one.c], at.a[one.c])) for one in self.beams if one.e.shape[1]]
        return Kinematics(*scatter_vectors(self.form.topology.n_e, own, 3))

    def strained(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
        """Deformations, (n_e,) [m, rad], but closures; arguments as of :func:`.element_forces.deformed`."""
        own = [(one.e, x[one.c]) for one in self.beams if one.e.shape[1]]
        return strained(self.form.elements, x, near) + scatter_vector(near.shape[0], own)

    def deformed(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
        """As :meth:`strained`, and the derivatives by the nodal coordinates, (n_e, n_x)."""
        jacobian = deformed(self.form.elements, x, near)[1]
        for one in self.beams:
            if one.e.shape[1]:
                jacobian = jacobian.at[one.e, one.c].set(1.0)
        return self.strained(x, near), jacobian

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance along what moves [N m], second rates of the held deformations.

        Source:
            THEORY.md 9 (d), eq. (9.8).
        """
        n, form = self.size, self.form
        at = form.whole(t, state.u, state.w, z[:n])
        bent = [one.rates(at) for one in self.beams]
        at = self._with_ends(at, bent)
        strain, stress = self._strains(at), self.stress_of(t, z[n:])
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        acting = acting_forces(form.elements, moving, form.falling, lambda *e: stress(*map(jnp.add, strain, e)))
        pulled = []
        for one, own in zip(self.beams, bent, strict=True):
            weights = None if one.mass is None else one.weights(one.moved(at, form.falling, own))
            pulled.append(one.pulled(at.x, own[0], weights))
        on_ends = [(one.ends, force) for one, (force, _) in zip(self.beams, pulled, strict=True)]
        force = acting.force + self._besides(t, at, on_ends)
        ways: list[tuple[Array, ...]] = [()] * len(self.beams)
        if self.tree.felt is not None:
            poses, values = self.tree.felt, _ways(bent)[0]
            force, on_ways = jax.vjp(lambda x, y: linked(poses, y, x), at.x, values)[1](force)
            ways = self._apart(on_ways)
        for one, way, (_, shape) in zip(self.beams, ways, pulled, strict=True):
            along = one.pulled_along(at.x, Bent(way, shape))
            if one.e.shape[1]:
                along = along + acting.sigma[one.e]
            force = accumulate(force, one.c, along)
        edd = acting.kinematics.edd + strain.edd
        return jnp.concatenate([force[form.free] * form.sizes, self.held(edd) - self.wanted(at.edd)])

    def _besides(self, t: Float[Array, ""], at: AllCoordinates, on_ends: list[tuple[Array, Array]]):
        """Nodal forces, (n_x,) [N, N m], of beams on their first ends, less those that are applied."""
        return scatter_vector(self.form.topology.n_x, on_ends) - self.form.applied(t, at.x)

    def _apart(self, rows: Float[Array, "beams k"]) -> list[tuple[Array, ...]]:
        """Of the beams of each block what is theirs of rows of ways and turns, as :class:`Bent` has it."""
        poses: Any = self.tree.felt
        found, first = [], 0
        for one in self.beams:
            count = one.c.shape[0] if one.parts else 0
            parts = jnp.split(rows[first : first + count], [poses.ends.shape[1]], axis=1)
            found.append(tuple(parts[: one.parts]))
            first += count
        return found

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Held deformations less what they are held at, (m,) [m, rad]."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        return self.held(self.strained(at.x, self.form.near(state.memory))) - self.wanted(at.e)

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of the residual.

        Source:
            THEORY.md 9 (d), eq. (9.9).
        """
        n, form = self.size, self.form
        to = self.carried(t, state.u, state.w, z[:n])
        at = to.at
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        strain, stress = self._strains(at), self.stress_of(t, z[n:])

        def following(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            tangents = form.tangents(t, strain.e + e, strain.ed + ed)
            return [None if of is None else put(of, form.held, 0.0) for of in tangents]

        acting, found = element_derivatives(
            form.elements, moving, form.falling, lambda *e: stress(*map(jnp.add, strain, e)), following
        )
        moved = [
            None if one.mass is None else one.moved_and_derived(at, form.falling, *own)
            for one, *own in zip(self.beams, to.bent, to.slopes, strict=True)
        ]
        weights = [None if own is None else one.weights(own[0]) for one, own in zip(self.beams, moved, strict=True)]
        ways: list[tuple[Array, ...]] = [()] * len(self.beams)
        every = sum((_along(to, block.x, squares) for block, _, squares in found), jnp.zeros((n, 3 * n)))
        if self.tree.felt is not None:
            on_ends = [
                (one.ends, jnp.einsum("bka,bkax->bx", own, derived[1].s[..., : one.ends.shape[1]]))
                for one, own, derived in zip(self.beams, weights, moved, strict=True)
                if own is not None and derived is not None
            ]
            force = acting.force + self._besides(t, at, on_ends)
            on_ways, bending = self.turned(to, force)
            ways, every = self._apart(on_ways), every.at[:, :n].add(bending)
        tangents: Any = following(acting.kinematics.e, acting.kinematics.ed)
        for one, way, own, derived in zip(self.beams, ways, weights, moved, strict=True):
            squares = one.derivatives(at.x, own, way, None if derived is None else derived[1], *tangents)
            every = every + _along(to, one.x, squares)
        by_u, by_w, mass = jnp.split(every, 3, axis=1)
        loads = self.by_loads(t, at.x)
        if loads is not None:
            by_u = by_u - to.x.T @ loads @ to.x
        rows = jnp.zeros((0, n))
        if self.tree.held_places.shape[0]:
            pieces = [(block.e, _rows_along(to, block.x, own)) for block, own, _ in found if own is not None]
            pieces += [(one.e, _coefficients_along(to, one.c)) for one in self.beams if one.e.shape[1]]
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
        near = form.near(state.memory)
        residual = self.residual(t, state, jnp.zeros(self.unknowns))
        mass = mass_of(form.elements, at.x, near)
        mass = along.T @ mass @ along + sum(one.mass_along(at.x, along) for one in self.beams if one.mass is not None)
        rows = self.held(self.deformed(at.x, near)[1]) @ along
        z, matrix = solved_twice(mass, rows, self.mobility, residual)
        return z, self.regular(matrix)

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Rates of the deformations, where turns are counted."""
        if not state.memory.shape[0]:
            return state.memory
        at = self.whole(t, state.u, state.w, z[: self.size])
        return self.deformed(at.x, state.memory)[1] @ at.v

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Positions and velocities brought back onto the constraints that have multipliers.

        Source:
            THEORY.md 9, eq. (9.3).
        """
        u, w = state.u, state.w
        near, zero = self.form.near(state.memory), jnp.zeros_like(state.u)
        if self.tree.held_places.shape[0]:

            def excess(u: Float[Array, "n"], w: Float[Array, "n"]):
                at = self.whole(t, u, w, zero)
                e, jacobian = self.deformed(at.x, near)
                of_both = [self.held(e) - self.wanted(at.e), self.held(jacobian @ at.v) - self.wanted(at.ed)]
                return jnp.stack(of_both, axis=1), self.held(jacobian) @ self.along(t, u)

            u, w = onto_constraints(u, w, excess, mass, self.mobility)
        memory = state.memory
        if memory.shape[0]:
            memory = self.strained(self.whole(t, u, w, zero).x, memory)
        return MotionState(u, w, memory)


def _joined(rows: Sequence[Sequence[Array]]):
    """Of several blocks of beams one array of each kind."""
    return tuple(jnp.concatenate(own) for own in zip(*rows, strict=True))


def _ways(bent: Sequence[tuple[Bent, Bent, Bent]]):
    """Way and turn of all beams, as far as something depends on them, rates and second rates."""
    return _joined([[_beside(each) for each in own] for own in bent if own[0].way])


def _beside(bent: Bent) -> Float[Array, "beams k *c"]:
    """Way and turn side by side."""
    return jnp.concatenate(bent.way, axis=1)


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


def _coefficients_along(to: _Carried, c: Int[Array, "beams c"]):
    """As :func:`_rows_along`, of deformations that are coordinates which move by themselves."""
    none = jnp.zeros((*c.shape, 2 * to.x.shape[1]))
    return jnp.concatenate([none, to.x[c]], axis=2)


def tree_form(form: CoordinatesForm, tree: Tree) -> TreeForm:
    """Equations of motion of a model in the coordinates that its beams do not give.

    Args:
        form: The same in all coordinates.
        tree: Which poses are computed.
    """
    top, parameters = form.topology, form.parameters
    elements: list[PreparedBlock | None] = []
    for block, properties, (_, rows) in zip(top.blocks, parameters.properties, tree.rows, strict=True):
        if rows.shape[0]:
            elements.append(prepared_block(*some_of(block, properties, rows), parameters.reference))
    own = dataclasses.replace(
        form,
        elements=tuple(one for one in elements if one is not None),
        free=tree.kept,
        place=places_of(top, tree.kept),
        sizes=form.sizes[tree.kept_places],
        mobility=form.mobility[tree.kept_places],
    )
    found = TreeForm(own, tree, tree_beams(top, parameters, tree), own.mobility)
    return dataclasses.replace(found, mobility=_mobility(found, form)) if tree.held_places.shape[0] else found


def _mobility(found: TreeForm, form: CoordinatesForm):
    """Inverse masses of what moves, with all that it takes along, in the undeformed mechanism; as those of all."""

    def moved(u: Float[Array, "n"]):
        x = accumulate(form.parameters.reference, found.tree.kept, found.form.sizes * u)
        return found.placed(x)[form.free] / form.sizes

    along = jax.lax.stop_gradient(jax.jacfwd(moved)(jnp.zeros(found.size)))
    return 1.0 / ((along**2).T @ (1.0 / form.mobility))
