"""Beams whose last end is computed, in motion: what follows from their coefficients alone is worked out once."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.program import split_in_stages
from ..compilation.record import Record, static
from ..math.linear import multiplied
from ..mechanics.blocks import companion_of, deforming, element_function, with_rigidities
from ..mechanics.tree import Tree, some_of
from ..model.parameters import Parameters
from ..model.topology import Block, Topology
from .coordinates_form import AllCoordinates
from .element_forces import by_inertia, derived_rates, own_of, rates_along, second_rate


class Bent(NamedTuple):
    """What follows from the coefficients of a beam.

    Attributes:
        way: Way from the first end to the last, and turn; without what is not asked for.
        shape: What places of inertia are computed from, together with the first end.
    """

    way: tuple[Float[Array, "*beams k"], ...]
    shape: tuple[Array, ...]


class Moved(NamedTuple):
    """Places of inertia of beams, as they move.

    Attributes:
        s: The places, (beams, k, axes).
        sd: Their rates.
        sdd: Their second rates, less free fall.
    """

    s: Float[Array, "*beams k axes"]
    sd: Float[Array, "*beams k axes"]
    sdd: Float[Array, "*beams k axes"]


class TreeBeams(Record):
    """Beams of one block whose last end follows from the first and from their coefficients, prepared for motion.

    Attributes:
        bent: ``(c_el, *kept_el)`` to :class:`Bent` of one beam, with all parts of its way.
        placed: ``(ends_el, *kept_el, *shape_el) -> s_el``, its places of inertia; None where it has none.
        ends: Index of the coordinates of the first ends, (beams, ends).
        c: Index of the coefficients, (beams, coefficients).
        e: Index of the deformations that these are, (beams, coefficients); none where another block has them.
        kept: Constants of each beam, for both functions.
        mass: H of each beam, (beams, k, k), or None.
        gives: Whether these give last ends; beams may have their mass in a block of its own.
        parts: On how many parts of a way something acts or depends: none, the way alone, or way and turn.
    """

    bent: Callable[..., Bent] = static()
    placed: Callable[..., Any] | None = static()
    ends: Int[Array, "beams ends"]
    c: Int[Array, "beams coefficients"]
    e: Int[Array, "beams deformations"]
    kept: tuple[Array, ...]
    mass: Float[Array, "beams k k"] | None
    gives: bool = static()
    parts: int = static()

    @property
    def x(self) -> Int[Array, "beams k"]:
        """Index of the coordinates that the beams depend on."""
        return jnp.concatenate([self.ends, self.c], axis=1)

    def ways(self, x: Float[Array, "n_x"]) -> Float[Array, "beams way_and_turn"]:
        """Way and turn of each beam, side by side, of nodal coordinates (n_x,) [m, rad, -]."""
        return jax.vmap(lambda c, kept: jnp.concatenate(self.bent(c, *kept).way))(x[self.c], self.kept)

    def felt_ways(self, x: Float[Array, "n_x"]) -> Float[Array, "beams k"]:
        """As :meth:`ways`, as far as something depends on them."""
        found = jax.vmap(lambda c, kept: self._felt(kept)(c).way)(x[self.c], self.kept)
        return jnp.concatenate(found, axis=1)

    def rates(self, at: AllCoordinates) -> tuple[Bent, Bent, Bent]:
        """What follows from the coefficients, its rates and second rates."""
        found = jax.vmap(lambda kept, *motion: rates_along(self._felt(kept), *motion))(self.kept, *self._motion(at))
        return _bent_of(found)

    def derived(self, at: AllCoordinates) -> tuple[tuple[Bent, Bent, Bent], tuple[Bent, Bent, Bent]]:
        """As :meth:`rates`, and their derivatives by the coefficients, which are the last axis of each array."""
        found = jax.vmap(lambda kept, *motion: derived_rates(self._felt(kept), *motion))(self.kept, *self._motion(at))
        return _bent_of(found[0]), _bent_of(found[1])

    def _motion(self, at: AllCoordinates) -> list[Array]:
        return [own[self.c] for own in (at.x, at.v, at.a)]

    def _felt(self, kept: tuple[Array, ...]):
        """What follows from the coefficients of one beam, without what nothing depends on."""

        def of(c: Float[Array, "c"]) -> Bent:
            found = self.bent(c, *kept)
            return found._replace(way=found.way[: self.parts])

        return of

    def moved(self, at: AllCoordinates, falling: Float[Array, "n_x"] | None, bent: tuple[Bent, ...]) -> Moved:
        """Places of inertia and their rates.

        Args:
            falling: Accelerations of free fall, which mass does not resist, (n_x,) [1/s^2], or None.
            bent: As :meth:`rates` gives it.
        """
        return jax.vmap(self._moved)(self.kept, *self._ends(at, falling), *(own.shape for own in bent))

    def _ends(self, at: AllCoordinates, falling: Float[Array, "n_x"] | None) -> list[Any]:
        return [None if own is None else own[self.ends] for own in (falling, at.x, at.v, at.a)]

    def _moved(self, kept: tuple[Array, ...], falling: Float[Array, "k"] | None, *along: Any) -> Moved:
        """Of one beam, from its first end and its shape: each with rates and second rates."""
        placed: Any = self.placed

        def of(at: tuple[Array, tuple[Array, ...]]):
            return placed(at[0], *kept, *at[1])

        x, v, a = zip(along[:3], along[3:], strict=True)
        s, sd, sdd = second_rate(of, x, v, a)
        if falling is not None:
            sdd = sdd - jax.jvp(lambda ends: of((ends, x[1])), (x[0],), (falling,))[1]
        return Moved(s, sd, sdd)

    def moved_and_derived(
        self,
        at: AllCoordinates,
        falling: Float[Array, "n_x"] | None,
        bent: tuple[Bent, ...],
        slopes: tuple[Bent, ...],
    ) -> tuple[Moved, Moved]:
        """As :meth:`moved`, and the derivatives by the coordinates that the beams depend on, which are the last axis.

        Args:
            falling: As there.
            bent: As there.
            slopes: Its derivatives, as :meth:`derived` gives them.
        """

        def of(kept: tuple[Array, ...], falling: Float[Array, "k"] | None, *along: Any):
            ends, shapes, own = along[:3], along[3:6], along[6:]
            by_ends = jax.jacfwd(lambda x: self._moved(kept, falling, x, *ends[1:], *shapes))(ends[0])

            def changed(*changes: Any):
                return jax.jvp(lambda *shapes: self._moved(kept, falling, *ends, *shapes), shapes, changes)

            found, by_c = jax.vmap(changed, -1, (None, -1))(*own)
            return found, jax.tree.map(lambda a, b: jnp.concatenate([a, b], axis=-1), by_ends, by_c)

        shapes = [own.shape for own in (*bent, *slopes)]
        return jax.vmap(of)(self.kept, *self._ends(at, falling), *shapes)

    def pulled(
        self, x: Float[Array, "n_x"], bent: Bent, weights: Float[Array, "beams k axes"] | None
    ) -> tuple[Float[Array, "beams ends"], tuple[Array, ...]]:
        """Forces on the first ends, and on the shape, of forces on the places of inertia.

        Args:
            x: Nodal coordinates, (n_x,) [m, rad, -].
            bent: What follows from the coefficients.
            weights: The forces, or None where there are no places.
        """
        if weights is None:
            return jnp.zeros(self.ends.shape), ()
        placed: Any = self.placed

        def of(kept: tuple[Array, ...], ends: Float[Array, "k"], shape: Any, weight: Float[Array, "k axes"]):
            return jax.vjp(lambda ends, shape: placed(ends, *kept, *shape), ends, shape)[1](weight)

        return jax.vmap(of)(self.kept, x[self.ends], bent.shape, weights)

    def pulled_along(self, x: Float[Array, "n_x"], force: Bent) -> Float[Array, "beams coefficients"]:
        """Forces on the coefficients, of those on what follows from them.

        Args:
            x: Nodal coordinates, (n_x,) [m, rad, -].
            force: Their forces, as :class:`Bent`.
        """

        def of(kept: tuple[Array, ...], c: Float[Array, "c"], force: Bent):
            return jax.vjp(self._felt(kept), c)[1](force)[0]

        return jax.vmap(of)(self.kept, x[self.c], force)

    def weights(self, moved: Moved) -> Float[Array, "beams k axes"]:
        """H s_ddot."""
        mass: Any = self.mass
        return multiplied(mass, moved.sdd)

    def mass_along(self, x: Float[Array, "n_x"], along: Float[Array, "n_x n"]) -> Float[Array, "n n"]:
        """Mass matrix of what moves, as far as the beams go.

        Args:
            x: Nodal coordinates, (n_x,) [m, rad, -].
            along: Their derivative by what moves.
        """
        placed: Any = self.placed
        first = self.ends.shape[1]

        def of(kept: tuple[Array, ...], x: Float[Array, "k"]):
            return placed(x[:first], *kept, *self.bent(x[first:], *kept).shape)

        j = jax.vmap(jax.jacfwd(of, 1))(self.kept, x[self.x])
        own = jnp.einsum("bkax,bxn->bkan", j, along[self.x])
        return jnp.einsum("bkan,bkl,blam->nm", own, self.mass, own)

    def derivatives(
        self,
        x: Float[Array, "n_x"],
        weights: Float[Array, "beams k axes"] | None,
        way: tuple[Array, ...],
        derived: Moved | None,
        stiffness: Float[Array, "n_e n_e"],
        damping: Float[Array, "n_e n_e"] | None = None,
    ) -> tuple[Float[Array, "beams k k"], Float[Array, "beams k k"], Float[Array, "beams k k"]]:
        """Derivatives of the forces by the coordinates that the beams depend on, by their rates and second rates.

        Args:
            x: Nodal coordinates, (n_x,) [m, rad, -].
            weights: Forces on the places of inertia, or None where there are none.
            way: Forces on way and turn, as :class:`Bent` has these.
            derived: Derivatives of the places of inertia, as :meth:`moved_and_derived` gives them.
            stiffness: Of all deformations [N/m].
            damping: Of their rates [N s/m], or None.
        """
        by_x = self._derived_forces(x, weights, way)
        by_v = by_a = jnp.zeros_like(by_x)
        if derived is not None and self.mass is not None:
            more, by_v, by_a = by_inertia(self.mass, *derived)
            by_x = by_x + more
        c = self.ends.shape[1]
        if self.e.shape[1]:
            by_x = by_x.at[:, c:, c:].add(own_of(self.e, stiffness))
        if self.e.shape[1] and damping is not None:
            by_v = by_v.at[:, c:, c:].add(own_of(self.e, damping))
        return by_x, by_v, by_a

    def _derived_forces(
        self, x: Float[Array, "n_x"], weights: Float[Array, "beams k axes"] | None, way: tuple[Array, ...]
    ) -> Float[Array, "beams k k"]:
        """Derivatives of what forces on places of inertia, on ways and on turns do, by what the beams depend on."""
        first, placed = self.ends.shape[1], self.placed

        def of(kept: tuple[Array, ...], x: Float[Array, "k"], *weights: Any):
            def given(x: Float[Array, "k"]):
                bent = self._felt(kept)(x[first:])
                places = None if placed is None else placed(x[:first], *kept, *bent.shape)
                return places, bent.way

            return jax.jacfwd(lambda x: jax.vjp(given, x)[1](weights)[0])(x)

        return jax.vmap(of)(self.kept, x[self.x], weights, way)


def _bent_of(rates: tuple[Any, ...]) -> tuple[Bent, Bent, Bent]:
    first, second, third = (Bent(*pair) for pair in rates)
    return first, second, third


def tree_beams(topology: Topology, parameters: Parameters, tree: Tree) -> tuple[TreeBeams, ...]:
    """All beams whose last end is computed, with what does not change in a motion worked out.

    Args:
        tree: Which they are.
    """
    found, felt = [], [0] * len(topology.blocks)
    if tree.felt is not None:
        parts = 2 if tree.felt.turns.shape[1] else 1
        felt = [parts if rows.shape[0] else 0 for rows in tree.felt.rows]
    for block, properties, (rows, _), own in zip(topology.blocks, parameters.properties, tree.rows, felt, strict=True):
        if rows.shape[0]:
            found.append(_prepared(*some_of(block, properties, rows), parameters.reference, own))
    return tuple(found)


def _prepared(block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"], parts: int) -> TreeBeams:
    inertia, properties = companion_of(block, with_rigidities(properties), "inertia")
    deforms = "deformation" in block.companions
    passage: Any = element_function(block, block.element.passage, deforming(block, properties)) if deforms else None
    # Position and rotation of the first end, of the last, and the coefficients.
    ends, first = block.splits[1], block.splits[-1]
    ref = reference[block.x]

    def every(constant: tuple[Any, ...], c: tuple[Array], end: tuple[Array]):
        ref, own = constant
        known = jnp.split(ref, block.splits)[:-1]
        # Not side by side in one array: what follows from the coefficients alone would seem to follow from all.
        x = [*jnp.split(end[0], block.splits[:1]), *known[2:], *c]
        way = tuple(passage([*known, *c], ref, deforming(block, own))) if deforms else ()
        return (), way, None if inertia is None else inertia(x, ref, own)[0]

    like = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype), (ref, properties))
    groups = [like, *((jax.ShapeDtypeStruct((n,), ref.dtype),) for n in (block.x.shape[1] - first, ends))]
    early, along, last = split_in_stages(every, groups)

    def bent(c: Float[Array, "c"], *kept: Array) -> Bent:
        return Bent(*along(c, *kept))

    def placed(ends: Float[Array, "k"], *kept_and_shape: Array):
        return last(ends, *kept_and_shape)[0]

    mass = None if inertia is None else jax.vmap(lambda *own: inertia(*own)[1])(ref, ref, properties)
    closure = block.e.shape[1] - (block.x.shape[1] - first)
    return TreeBeams(
        bent,
        None if inertia is None else placed,
        block.x[:, :ends],
        block.x[:, first:],
        block.e[:, closure:] if deforms else block.e[:, :0],
        jax.vmap(lambda *constant: early(*constant)[1])(ref, properties),
        mass,
        deforms,
        parts if deforms else 0,
    )
