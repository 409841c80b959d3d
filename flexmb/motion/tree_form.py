"""Motion in the coordinates that no beam with strain series gives: ends of such beams are computed, not solved for."""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record
from ..math.indices import accumulate, put
from ..math.linear import factorise, is_positive_definite
from ..mechanics.deformation import zero_near
from ..mechanics.loads import LoadFactors, load_stiffness
from ..mechanics.tree import Passages, Tree, passages, placed_on_tree, some_of
from .coordinates_form import CoordinatesForm, Whole, bordered
from .element_forces import (
    Moving,
    PreparedBlock,
    acting_forces,
    acting_matrices,
    deformed,
    force_derivatives,
    prepared_block,
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
        v: Derivative of the velocities by the positions; of the accelerations by the velocities it is twice this.
        a: Derivative of the accelerations by the positions.
    """

    at: Whole
    x: Float[Array, "n_x n"]
    v: Float[Array, "n_x n"]
    a: Float[Array, "n_x n"]


class TreeForm(Record):
    """Equations of motion X_u^T R(X(u), ..) with X(u) the coordinates as a tree of beams places them.

    Constraints that X keeps have no multipliers: the closures of its beams, and the unit norms of rotations that they
    give. The others have theirs, as in all coordinates.

    Attributes:
        form: Equations in all coordinates, but that those alone move by themselves that are not computed.
        tree: What is computed.
        passages: By what.
        mobility: Inverse masses of what moves, (n,).
    """

    form: CoordinatesForm
    tree: Tree
    passages: tuple[Passages, ...]
    mobility: Float[Array, "n"]

    @property
    def states(self) -> int:
        """Number of states of a controller: none."""
        return 0

    @property
    def size(self) -> int:
        """Number of coordinates that move and are not computed."""
        return self.form.size

    def state_of(self, x, xd, near) -> MotionState:
        """State of nodal coordinates, of which those that are computed are not read."""
        return self.form.state_of(x, xd, near)

    def placed(self, x):
        """Nodal coordinates with those computed that the beams give, (n_x,)."""
        return placed_on_tree(self.tree, self.passages, x)

    def whole(self, t, u, w, a) -> Whole:
        """All coordinates from those that move; arguments as of :meth:`CoordinatesForm.whole`."""
        at = self.form.whole(t, u, w, a)

        def first(x, v):
            return jax.jvp(self.placed, (x,), (v,))

        (x, v), (_, acc) = jax.jvp(first, (at.x, at.v), (at.v, at.a))
        return at._replace(x=x, v=v, a=acc)

    def along(self, t, u) -> Float[Array, "n_x n"]:
        """Derivative of the coordinates by what moves."""
        none = jnp.zeros(self.size)
        return jax.jacfwd(lambda u: self.placed(self.form.whole(t, u, none, none).x))(u)

    def carried(self, t, u, w, a) -> _Carried:
        """All coordinates, and their derivatives by what moves."""

        def rates(u):
            at = self.whole(t, u, w, a)
            return (at.x, at.v, at.a), at

        derivatives, at = jax.jacfwd(rates, has_aux=True)(u)
        return _Carried(at, *derivatives)

    def whole_motion(self, t, state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        near = state.memory
        if not near.shape[0]:
            near = strained(self.form.elements, at.x, zero_near(self.form.topology))
        return WholeMotion(at.x, at.v, near, jnp.zeros(0))

    def stress_of(self, t, multipliers):
        """As :meth:`CoordinatesForm.stress_of`, of the multipliers that there are."""
        every = jnp.zeros(self.form.held.shape[0])
        return self.form.stress_of(t, put(every, self.tree.held_places, multipliers))

    def held(self, rows):
        """Rows of the held deformations that have multipliers."""
        return rows[self.form.held[self.tree.held_places]]

    def wanted(self, values):
        """What these are held at, of all that are held."""
        return values[self.tree.held_places]

    def forces(self, t, at: Whole, memory, multipliers):
        """Kinematics, and nodal forces out of balance, (n_x,) [N, N m]."""
        moving = Moving(at.x, at.v, at.a, self.form.near(memory))
        acting = acting_forces(self.form.elements, moving, self.form.falling, self.stress_of(t, multipliers))
        return acting.kinematics, acting.force - self.form.applied(t, at.x)

    def pulled(self, t, u, force):
        """Forces along what moves, (n,) [N m], of nodal forces, (n_x,) [N, N m]."""
        none = jnp.zeros(self.size)
        return jax.vjp(lambda u: self.placed(self.form.whole(t, u, none, none).x), u)[1](force)[0]

    def residual(self, t, state: MotionState, z):
        """Forces out of balance along what moves [N m], second rates of the held deformations.

        Source:
            THEORY.md 9 (d), eq. (9.8).
        """
        n = self.size
        at = self.whole(t, state.u, state.w, z[:n])
        kin, force = self.forces(t, at, state.memory, z[n:])
        return jnp.concatenate([self.pulled(t, state.u, force), self.held(kin.edd) - self.wanted(at.edd)])

    def gap(self, t, state: MotionState):
        """Held deformations less what they are held at, (m,) [m, rad]."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        return self.held(strained(self.form.elements, at.x, self.form.near(state.memory))) - self.wanted(at.e)

    def tangent(self, t, state: MotionState, z) -> Tangent:
        """Derivatives of the residual.

        Source:
            THEORY.md 9 (d), eq. (9.9).
        """
        n, form = self.size, self.form
        to = self.carried(t, state.u, state.w, z[:n])
        at = to.at
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))

        def following(e, ed):
            return [None if of is None else put(of, form.held, 0.0) for of in form.tangents(t, e, ed)]

        by = force_derivatives(form.elements, moving, form.falling, self.stress_of(t, z[n:]), following)
        drive = form.drive(t)
        by_x = by.by_x - load_stiffness(form.topology, form.parameters, LoadFactors(1.0, drive.increment), at.x)
        if drive.turning is not None:
            by_x = by_x - drive.turning
        _, force = self.forces(t, at, state.memory, z[n:])
        turned = jax.jacfwd(lambda u: self.pulled(t, u, force))(state.u)
        by_u = to.x.T @ (by_x @ to.x + by.by_v @ to.v + by.mass @ to.a) + turned
        by_w = to.x.T @ (by.by_v @ to.x + 2 * by.mass @ to.v)
        mass, rows = to.x.T @ by.mass @ to.x, self.held(by.e) @ to.x
        if rows.shape[0]:
            edd_by_u = self.held(by.edd) @ to.x + 2 * self.held(by.ed) @ to.v + self.held(by.e) @ to.a
            edd_by_w = 2 * (self.held(by.ed) @ to.x + self.held(by.e) @ to.v)
            by_u, by_w = jnp.concatenate([by_u, edd_by_u]), jnp.concatenate([by_w, edd_by_w])
        by_t = None
        if form.driven:
            by_t = jax.jvp(lambda t: self.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
        return Tangent(by_u, by_w, bordered(mass, rows, self.mobility), by_t)

    @jit_beside_options
    def acceleration(self, t, state: MotionState):
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
        regular = is_positive_definite(mass + jnp.max(jnp.abs(mass), initial=0.0) * rows.T @ rows)
        force = along.T @ (acting.force - form.applied(t, at.x))
        residual = jnp.concatenate([force, self.held(acting.kinematics.edd) - self.wanted(at.edd)])
        factors = factorise(bordered(mass, rows, self.mobility))
        z = factors.solve(-residual)
        # Once more with the constraints as they are: what keeps redundant ones solvable is not to bias the others.
        left = jnp.concatenate([mass @ z[:n] + rows.T @ z[n:], rows @ z[:n]])
        return z - factors.solve(residual + left), regular

    def rate_of_memory(self, t, state: MotionState, z):
        """Rates of the deformations, where turns are counted."""
        if not state.memory.shape[0]:
            return state.memory
        at = self.whole(t, state.u, state.w, z[: self.size])
        return deformed(self.form.elements, at.x, state.memory)[1] @ at.v

    @jit_beside_options
    def settle(self, t, state: MotionState, mass=None) -> MotionState:
        """Positions and velocities brought back onto the constraints that have multipliers.

        Source:
            THEORY.md 9, eq. (9.3).
        """
        u, w = state.u, state.w
        form, near, zero = self.form, self.form.near(state.memory), jnp.zeros_like(state.u)
        if self.tree.held_places.shape[0]:
            heavy = jnp.diag(1 / self.mobility) if mass is None else mass

            def corrected(_, moving):
                at, along = self.whole(t, *moving, zero), self.along(t, moving[0])
                e, jacobian = deformed(form.elements, at.x, near)
                excess = jnp.stack(
                    [self.held(e) - self.wanted(at.e), self.held(jacobian @ at.v) - self.wanted(at.ed)], axis=1
                )
                right = jnp.concatenate([jnp.zeros((self.size, 2)), excess])
                rows = self.held(jacobian) @ along
                change = factorise(bordered(heavy, rows, self.mobility)).solve(right)
                return moving[0] - change[: self.size, 0], moving[1] - change[: self.size, 1]

            u, w = jax.lax.fori_loop(0, 2, corrected, (u, w))
        memory = state.memory
        if memory.shape[0]:
            memory = strained(form.elements, self.whole(t, u, w, zero).x, memory)
        return MotionState(u, w, memory)


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
    found = TreeForm(own, tree, passages(top, parameters, tree), own.mobility)
    return dataclasses.replace(found, mobility=_mobility(found, form)) if tree.held_places.shape[0] else found


def _mobility(found: TreeForm, form: CoordinatesForm):
    """Inverse masses of what moves, with all that it takes along, in the undeformed mechanism; as those of all."""

    def moved(u):
        x = accumulate(form.parameters.reference, found.tree.kept, found.form.sizes * u)
        return found.placed(x)[form.free] / form.sizes

    along = jax.lax.stop_gradient(jax.jacfwd(moved)(jnp.zeros(found.size)))
    return 1.0 / ((along**2).T @ (1.0 / form.mobility))
