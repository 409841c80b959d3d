"""Equations of motion in which ends of beams with strain series are computed, not solved for."""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..math.indices import TRUSTED, accumulate, put
from ..mechanics.deformation import zero_strain
from ..mechanics.tree import Tree, block_part, linked, tree_forces
from .coordinates_form import AllCoordinates, CoordinatesForm, numbers_among
from .element_forces import (
    Kinematics,
    Moving,
    PreparedBlock,
    acting_forces,
    deformations_and_slopes,
    element_derivatives,
    mass_of,
    own_tangents,
    prepared_block,
    second_rate,
)
from .protocol import MotionState, Tangent, WholeMotion, by_time
from .tree_beams import Bent, TreeBeams, tree_beams


class _Carried(NamedTuple):
    """A state of motion of all coordinates, and its derivatives by what moves.

    Attributes:
        at: Coordinates and their rates.
        x: Derivative of the coordinates; also of velocities by velocities and of accelerations by accelerations.
        v: Derivative of the velocities by the positions; of the accelerations by the velocities it is twice this. None
            if nothing is computed.
        a: Derivative of the accelerations by the positions.
        ways, passed: Way and turn of each beam, and their derivative.
        bent, slopes: Functions of the coefficients of each block's beams with rates and second rates, and derivatives.
    """

    at: AllCoordinates
    x: Float[Array, "n_x n"]
    v: Float[Array, "n_x n"] | None
    a: Float[Array, "n_x n"] | None
    ways: Float[Array, "beams way_and_turn"] | None
    passed: Float[Array, "beams way_and_turn n"] | None
    bent: list[tuple[Bent, Bent, Bent]]
    slopes: list[tuple[Bent, Bent, Bent]]


class TreeForm(CoordinatesForm):
    """Equations of motion X_u^T R(X(u), ..) with X(u) the coordinates that a tree of beams places.

    Constraints that X satisfies have no multipliers: closures of the beams, and unit norms of computed rotations.
    Others have multipliers, as in all coordinates. Only coordinates that are not computed move; ``elements`` and what
    follows from them are without ``beams``.

    Attributes:
        tree: Computed coordinates.
        beams: Beams that compute them.
        strain_of: Coordinate that each deformation equals, or their number.
        slots: Of each block of beams, the place of each moving coordinate among its coefficients, or their number.
    """

    tree: Tree
    beams: tuple[TreeBeams, ...]
    strain_of: Int[Array, "n_e"]
    slots: tuple[Int[Array, "n"], ...]

    def with_ends(self, x: Float[Array, "n_x"]):
        """Nodal coordinates, with computed ones that something depends on."""
        if self.tree.felt is None:
            return x
        return linked(
            self.tree.felt, jnp.concatenate([beams.ways(x, beams.parts) for beams in self.beams if beams.parts]), x
        )

    def whole(self, t: Float[Array, ""], u: Any = None, w: Any = None, a: Any = None) -> AllCoordinates:
        """:meth:`CoordinatesForm.whole`, with computed coordinates that something depends on."""
        at = super().whole(t, u, w, a)
        return self._moved_ends(at, [beams.rates(at) for beams in self.beams if beams.parts])

    def along(self, t: Float[Array, ""], u: Float[Array, "n"]) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves."""
        if self.tree.felt is None:
            return self.selection
        return jax.jacfwd(lambda u: self.with_ends(super(TreeForm, self).whole(t, u).x))(u)

    @property
    def selection(self) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves, if nothing is computed."""
        return jnp.where(self.place[:, None] == np.arange(1, self.size + 1), self.sizes, 0.0)

    def _moved_ends(self, at: AllCoordinates, bent: list[tuple[Bent, Bent, Bent]]) -> AllCoordinates:
        """Coordinates and their rates, with computed ones that something depends on."""
        if self.tree.felt is None:
            return at
        x, v, a = self._linked((at.x, at.v, at.a), _ways(bent))
        return at._replace(x=x, v=v, a=a)

    def _linked(self, x: tuple[Array, ...], ways: tuple[Array, ...]):
        """Coordinates, rates and second rates, from those of what moves and of the beams' ways."""
        poses: Any = self.tree.felt
        return second_rate(lambda pair: linked(poses, pair[1], pair[0]), *zip(x, ways, strict=True))

    def carried(
        self, t: Float[Array, ""], u: Float[Array, "n"], w: Float[Array, "n"], a: Float[Array, "n"]
    ) -> _Carried:
        """:meth:`whole`, and derivatives by what moves.

        Way and turn of each beam are differentiated by its own coefficients, then the tree by all ways.
        """
        selected = self.selection
        at = super().whole(t, u, w, a)
        pairs = [beams.derived(at) for beams in self.beams]
        bent, derived = [rates for rates, _ in pairs], [by_c for _, by_c in pairs]
        if self.tree.felt is None:
            return _Carried(at, selected, None, None, None, None, bent, derived)
        # Derivatives by each block's own coefficients, (beams, way and turn, coefficients).
        blocks = [(beams.c, by_c) for beams, by_c in zip(self.beams, derived, strict=True) if beams.parts]
        slopes = _joined([[_beside(derivative) @ selected[c] for derivative in by_c] for c, by_c in blocks])
        ways, none = _ways(bent), jnp.zeros(at.x.shape)

        def along(place: Float[Array, "n_x"], *slope: Array):
            return jax.jvp(self._linked, ((at.x, at.v, at.a), ways), ((place, none, none), slope))[1]

        x, v, acc = self._linked((at.x, at.v, at.a), ways)
        derivatives: Any = jax.vmap(along, (1, 2, 2, 2), 1)(selected, *slopes)
        by_x, by_v, by_a = derivatives
        return _Carried(at._replace(x=x, v=v, a=acc), by_x, by_v, by_a, ways[0], slopes[0], bent, derived)

    def turned(self, to: _Carried, force: Float[Array, "n_x"]):
        """Forces on way and turn of each beam from nodal forces, and the derivative of nodal forces along what moves.

        The derivative leaves out what beams add whose way and turn bend.
        """
        poses: Any = self.tree.felt
        selected, x = self.selection, to.at.x

        def along(*way: Array):
            return jax.jvp(lambda x, y: tree_forces(poses, y, x, force), (x, to.ways), way)

        passed: Any = to.passed
        (on_ways, _), (of_y, of_x) = jax.vmap(along, (1, 2), (None, (2, 1)))(selected, passed)
        return on_ways, selected.T @ of_x + jnp.einsum("byn,bym->nm", passed, of_y)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at = super().whole(t, state.u, state.w)

        def everywhere(x: Float[Array, "n_x"]):
            return linked(
                self.tree.poses, jnp.concatenate([beams.ways(x, 2) for beams in self.beams if beams.gives]), x
            )

        x, v = jax.jvp(everywhere, (at.x,), (at.v,))
        last_strain = state.memory
        if not last_strain.shape[0]:
            last_strain = self.strained(x, zero_strain(self.topology))
        return WholeMotion(x, v, last_strain, jnp.zeros(0))

    def _strains(self, at: AllCoordinates) -> Kinematics:
        """Deformations of the beams, which are their coefficients, and rates; zero for others."""
        rates = jnp.pad(jnp.stack([at.x, at.v, at.a], axis=1), ((0, 1), (0, 0)))
        return Kinematics(*rates.at[self.strain_of].get(**TRUSTED).T)

    def strained(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
        """Deformations except closures."""
        return super().strained(x, near) + jnp.append(x, 0.0).at[self.strain_of].get(**TRUSTED)

    def deformed(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
        """:meth:`strained`, and the derivatives by the nodal coordinates."""
        jacobian = deformations_and_slopes(self.elements, x, near)[1]
        return self.strained(x, near), jacobian + (self.strain_of[:, None] == np.arange(x.shape[0])).astype(float)

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance along what moves and second rates of held deformations (THEORY.md 9 (d), eq. (9.8))."""
        n = self.size
        at = super().whole(t, state.u, state.w, z[:n])
        bent = [beams.rates(at) for beams in self.beams]
        at = self._moved_ends(at, bent)
        strain, stress = self._strains(at), self.stress_of(t, z[n:])
        moving = Moving(at.x, at.v, at.a, self.near(state.memory))
        acting = acting_forces(self.elements, moving, self.falling, lambda *e: stress(*map(jnp.add, strain, e)))
        on_beams = []
        for beams, functions in zip(self.beams, bent, strict=True):
            weights = None if beams.mass is None else beams.weights(beams.moved(at, self.falling, functions))
            on_beams.append(beams.pulled(at.x, functions[0], weights))
        on_ends = [(beams.ends, force) for beams, (force, _) in zip(self.beams, on_beams, strict=True)]
        force = acting.force + self._besides(t, at, on_ends)
        ways: list[tuple[Array, ...]] = [()] * len(self.beams)
        if self.tree.felt is not None:
            on_ways, force = tree_forces(self.tree.felt, _ways(bent)[0], at.x, force)
            ways = self._apart(on_ways)
        force = force[self.free]
        for beams, way, (_, shape), slots in zip(self.beams, ways, on_beams, self.slots, strict=True):
            along = beams.pulled_along(at.x, Bent(way, shape))
            if beams.e.shape[1]:
                along = along + acting.sigma[beams.e]
            force = force + jnp.append(along, 0.0).at[slots].get(**TRUSTED)
        edd = acting.kinematics.edd + strain.edd
        return jnp.concatenate([force * self.sizes, edd[self.held] - at.edd])

    def _besides(self, t: Float[Array, ""], at: AllCoordinates, on_ends: list[tuple[Array, Array]]):
        """Nodal forces of beams on their first ends, minus applied forces."""
        places = np.arange(self.topology.n_x)[:, None]
        # Products, since the compiler makes a loop of a scatter.
        forces = [(places == ends.reshape(-1)).astype(float) @ force.reshape(-1) for ends, force in on_ends]
        return sum(forces, -self.applied(t, at.x))

    def _apart(self, rows: Float[Array, "beams k"]) -> list[tuple[Array, ...]]:
        """Rows of ways and turns of each block's beams, as in :class:`Bent`."""
        poses: Any = self.tree.felt
        blocks, first = [], 0
        for beams in self.beams:
            count = beams.c.shape[0] if beams.parts else 0
            parts = jnp.split(rows[first : first + count], [poses.ends.shape[1]], axis=1)
            blocks.append(tuple(parts[: beams.parts]))
            first += count
        return blocks

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of the residual (THEORY.md 9 (d), eq. (9.9))."""
        n = self.size
        to = self.carried(t, state.u, state.w, z[:n])
        at = to.at
        moving = Moving(at.x, at.v, at.a, self.near(state.memory))
        strain, stress = self._strains(at), self.stress_of(t, z[n:])

        def following(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            return self.loose_tangents(t, strain.e + e, strain.ed + ed)

        acting, block_derivatives = element_derivatives(
            self.elements,
            moving,
            self.falling,
            lambda *e: stress(*map(jnp.add, strain, e)),
            lambda *e: own_tangents(self.elements, following(*e)),
        )
        moved = [
            None if beams.mass is None else beams.moved_and_derived(at, self.falling, *functions)
            for beams, *functions in zip(self.beams, to.bent, to.slopes, strict=True)
        ]
        weights = [
            None if places is None else b.weights(places[0]) for b, places in zip(self.beams, moved, strict=True)
        ]
        ways: list[tuple[Array, ...]] = [()] * len(self.beams)
        every = sum((_along(to, block.x, derived[3:]) for block, derived in block_derivatives), jnp.zeros((n, 3 * n)))
        if self.tree.felt is not None:
            on_ends = [
                (beams.ends, jnp.einsum("bka,bkax->bx", weight, derived[1].s[..., : beams.ends.shape[1]]))
                for beams, weight, derived in zip(self.beams, weights, moved, strict=True)
                if weight is not None and derived is not None
            ]
            force = acting.force + self._besides(t, at, on_ends)
            on_ways, bending = self.turned(to, force)
            ways, every = self._apart(on_ways), every + jnp.pad(bending, ((0, 0), (0, 2 * n)))
        tangents: Any = following(acting.kinematics.e, acting.kinematics.ed)
        for beams, way, weight, derived in zip(self.beams, ways, weights, moved, strict=True):
            squares = beams.derivatives(at.x, weight, way, None if derived is None else derived[1], *tangents)
            every = every + _along(to, beams.x, squares)
        by_u, by_w, mass = jnp.split(every, 3, axis=1)
        loads = self.by_loads(t, at.x)
        if loads is not None:
            by_u = by_u - to.x.T @ loads @ to.x
        rows = jnp.zeros((0, n))
        if self.held.shape[0]:
            by_e = [
                (block.e, _rows_along(to, block.x, derived[:3]))
                for block, derived in block_derivatives
                if derived.e is not None
            ]
            # Of deformations that are coordinates.
            columns = ((0, 0), (0, 0), (2 * n, 0))
            by_e += [(beams.e, jnp.pad(to.x[beams.c], columns)) for beams in self.beams if beams.e.shape[1]]
            every = jnp.zeros((self.topology.n_e, 3 * n))
            for e, block_rows in by_e:
                every = accumulate(every, e, block_rows)
            edd_by_u, edd_by_w, rows = jnp.split(every[self.held], 3, axis=1)
            by_u, by_w = jnp.concatenate([by_u, edd_by_u]), jnp.concatenate([by_w, edd_by_w])
        by_t = by_time(self, t, state, z) if self.driven else None
        return Tangent(by_u, by_w, self.system(mass, rows), by_t)

    def unaccelerated(self, t: Float[Array, ""], state: MotionState):
        """Residual at zero accelerations and multipliers, mass matrix, derivatives of the held deformations."""
        x, along = self.whole(t, state.u).x, self.along(t, state.u)
        last_strain = self.near(state.memory)
        residual = self.residual(t, state, jnp.zeros(self.unknowns))
        mass = along.T @ mass_of(self.elements, x, last_strain) @ along
        mass = mass + sum(b.mass_along(x, along) for b in self.beams if b.mass is not None)
        return residual, mass, self.deformed(x, last_strain)[1][self.held] @ along

    def rows_of(self, t: Float[Array, ""], u: Float[Array, "n"], jacobian: Float[Array, "n_e n_x"]):
        """Derivatives of the held deformations by what moves."""
        return jacobian[self.held] @ self.along(t, u)


def _joined(rows: Sequence[Sequence[Array]]):
    """Arrays of several blocks of beams, concatenated kind by kind."""
    return tuple(jnp.concatenate(arrays) for arrays in zip(*rows, strict=True))


def _ways(bent: Sequence[tuple[Bent, Bent, Bent]]):
    """Needed ways and turns of all beams, rates and second rates."""
    return _joined([[_beside(block_rates) for block_rates in rates] for rates in bent if rates[0].way])


def _beside(bent: Bent) -> Float[Array, "beams k *c"]:
    """Way and turn side by side."""
    return jnp.concatenate(bent.way, axis=1)


def _along(to: _Carried, x: Int[Array, "elements c"], squares: tuple[Array, Array, Array]):
    """Sum over elements of the derivatives of their forces by what moves, its rates and second rates, (n, 3 n)."""
    by_x, by_v, mass = squares
    by_moving = to.x[x]
    products = by_x @ by_moving, by_v @ by_moving, mass @ by_moving
    if to.v is not None and to.a is not None:
        v, a = to.v[x], to.a[x]
        products = products[0] + by_v @ v + mass @ a, products[1] + 2 * mass @ v, products[2]
    return jnp.einsum("ekn,ekm->nm", by_moving, jnp.concatenate(products, axis=2))


def _rows_along(to: _Carried, x: Int[Array, "elements c"], rows: tuple[Array, Array, Array]):
    """Derivatives of second rates of elements' deformations by what moves, its rates and second rates."""
    d, dd, d2 = rows
    by_moving = to.x[x]
    products = d2 @ by_moving, 2 * dd @ by_moving, d @ by_moving
    if to.v is not None and to.a is not None:
        v, a = to.v[x], to.a[x]
        products = products[0] + 2 * dd @ v + d @ a, products[1] + 2 * d @ v, products[2]
    return jnp.concatenate(products, axis=2)


def tree_form(form: CoordinatesForm, tree: Tree) -> TreeForm:
    """Equations of motion of a model in the coordinates that its beams do not compute."""
    top, parameters = form.topology, form.parameters
    elements: list[PreparedBlock | None] = []
    for block, properties, (_, rows) in zip(top.blocks, parameters.properties, tree.rows, strict=True):
        if rows.shape[0]:
            elements.append(prepared_block(*block_part(block, properties, rows), parameters.reference))
    place, held = numbers_among(top.n_x, tree.kept), form.held[tree.held_places]
    beams = tree_beams(top, parameters, tree)
    strain_of = jnp.full(top.n_e, top.n_x)
    for block in beams:
        strain_of = put(strain_of, block.e, block.c) if block.e.shape[1] else strain_of
    slots = []
    for block in beams:
        # Place zero belongs to coefficients that do not move.
        slot = jnp.full(tree.kept.shape[0] + 1, block.c.size).at[place[block.c.reshape(-1)]]
        slots.append(slot.set(np.arange(block.c.size), **TRUSTED)[1:])
    changed = dict(
        elements=tuple(block for block in elements if block is not None),
        free=tree.kept,
        place=place,
        held=held,
        held_place=numbers_among(top.n_e, held),
        sizes=form.sizes[tree.kept_places],
        mobility=form.mobility[tree.kept_places],
    )
    options: dict[str, Any] = {**vars(form), **changed}
    in_tree = TreeForm(**options, tree=tree, beams=beams, strain_of=strain_of, slots=tuple(slots))
    return dataclasses.replace(in_tree, mobility=_mobility(in_tree, form)) if held.shape[0] else in_tree


def _mobility(in_tree: TreeForm, form: CoordinatesForm):
    """Inverse masses of what moves, with everything that it moves, in the undeformed mechanism."""

    def moved(u: Float[Array, "n"]):
        x = accumulate(form.parameters.reference, in_tree.tree.kept, in_tree.sizes * u)
        return in_tree.with_ends(x)[form.free] / form.sizes

    along = jax.lax.stop_gradient(jax.jacfwd(moved)(jnp.zeros(in_tree.size)))
    return 1.0 / ((along**2).T @ (1.0 / form.mobility))
