"""Motion of beams whose last ends follow from their first ends and strains; shared functions are computed once."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int

from ..compilation.program import split_in_stages
from ..compilation.record import Record, static
from ..math.linear import multiplied
from ..mechanics.blocks import companion_of, deforming, element_function, with_rigidities
from ..mechanics.staged import derivative_in_stages, hessian_in_stages
from ..mechanics.tree import Tree, block_part
from ..model.topology import Block, Parameters, Topology
from .coordinates_form import AllCoordinates
from .element_forces import by_inertia, derived_rates, own_of, rates_along, second_rate


class Bent(NamedTuple):
    """Functions of the coefficients of a beam.

    Attributes:
        way: Displacement from the first to the last end, and rotation; only the needed parts.
        shape: Inputs of the inertia vectors, beside the first end.
    """

    way: tuple[Float[Array, "*beams k"], ...]
    shape: tuple[Array, ...]


class Moved(NamedTuple):
    """Inertia vectors of beams, their rates, and second rates minus free-fall acceleration."""

    s: Float[Array, "*beams k axes"]
    sd: Float[Array, "*beams k axes"]
    sdd: Float[Array, "*beams k axes"]


class TreeBeams(Record):
    """Beams of one block, prepared for motion. The last end follows from the first end and the coefficients.

    Attributes:
        bent: ``(c_el, *kept_el)`` to :class:`Bent` of one beam, with all parts of its way.
        placed: ``(ends_el, *kept_el, *shape_el) -> s_el``: inertia vectors of one beam; None without mass.
        ends: Index of the coordinates of the first ends.
        c: Index of the coefficients.
        e: Index of the deformations that equal the coefficients; empty if they belong to another block.
        kept: Constants of each beam, for both functions.
        mass: H of each beam.
        gives: Whether the beams compute last ends; a separate block may have the mass.
        parts: Needed parts of a way: 0 (none), 1 (displacement), or 2 (displacement and rotation).
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

    def ways(self, x: Float[Array, "n_x"], parts: int) -> Float[Array, "beams k"]:
        """Return the first parts of the ways, displacement and rotation, of each beam in one row."""
        return jax.vmap(lambda c, constants: jnp.concatenate(self.bent(c, *constants).way[:parts]))(
            x[self.c], self.kept
        )

    def rates(self, at: AllCoordinates) -> tuple[Bent, Bent, Bent]:
        """Return the needed functions of the coefficients, their rates and second rates."""
        return self._over(rates_along, at)

    def derived(self, at: AllCoordinates) -> tuple[tuple[Bent, Bent, Bent], tuple[Bent, Bent, Bent]]:
        """Return :meth:`rates` and their derivatives by the coefficients, which are the last axis."""
        return self._over(derived_rates, at)

    def _over(self, function: Callable[..., Any], at: AllCoordinates):
        of_beam = jax.vmap(lambda constants, *motion: function(self._felt(constants), *motion))
        return of_beam(self.kept, *[array[self.c] for array in (at.x, at.v, at.a)])

    def _felt(self, constants: tuple[Array, ...]):
        """Return the needed functions of the coefficients of one beam."""

        def needed(c: Float[Array, "c"]) -> Bent:
            bent = self.bent(c, *constants)
            return bent._replace(way=bent.way[: self.parts])

        return needed

    def moved(self, at: AllCoordinates, falling: Float[Array, "n_x"] | None, bent: tuple[Bent, ...]) -> Moved:
        """Return inertia vectors and their rates; `bent` comes from :meth:`rates`."""
        return jax.vmap(self._moved)(self.kept, *self._ends(at, falling), *(part.shape for part in bent))

    def _ends(self, at: AllCoordinates, free_fall: Float[Array, "n_x"] | None) -> list[Any]:
        return [None if array is None else array[self.ends] for array in (free_fall, at.x, at.v, at.a)]

    def _moved(self, constants: tuple[Array, ...], free_fall: Float[Array, "k"] | None, *along: Any) -> Moved:
        """Return the inertia vectors of one beam from the motion of its first end and its shape."""
        placed: Any = self.placed

        def places(at: tuple[Array, tuple[Array, ...]]):
            return placed(at[0], *constants, *at[1])

        x, v, a = zip(along[:3], along[3:], strict=True)
        s, sd, sdd = second_rate(places, x, v, a)
        if free_fall is not None:
            sdd = sdd - jax.jvp(lambda ends: places((ends, x[1])), (x[0],), (free_fall,))[1]
        return Moved(s, sd, sdd)

    def moved_and_derived(
        self, at: AllCoordinates, falling: Float[Array, "n_x"] | None, bent: tuple[Bent, ...], slopes: tuple[Bent, ...]
    ) -> tuple[Moved, Moved]:
        """Return :meth:`moved` and its derivatives by the beams' coordinates, which are the last axis."""

        def of_beam(constants: tuple[Array, ...], free_fall: Float[Array, "k"] | None, *along: Any):
            ends, shapes, by_coefficients = along[:3], along[3:6], along[6:]
            by_ends = jax.jacfwd(lambda x: self._moved(constants, free_fall, x, *ends[1:], *shapes))(ends[0])

            def changed(*changes: Any):
                return jax.jvp(lambda *shapes: self._moved(constants, free_fall, *ends, *shapes), shapes, changes)

            moved, by_c = jax.vmap(changed, -1, (None, -1))(*by_coefficients)
            return moved, jax.tree.map(lambda a, b: jnp.concatenate([a, b], axis=-1), by_ends, by_c)

        shapes = [part.shape for part in (*bent, *slopes)]
        return jax.vmap(of_beam)(self.kept, *self._ends(at, falling), *shapes)

    def pulled(
        self, x: Float[Array, "n_x"], bent: Bent, weights: Float[Array, "beams k axes"] | None
    ) -> tuple[Float[Array, "beams ends"], tuple[Array, ...]]:
        """Return forces on the first ends and on the shape from forces on the inertia vectors."""
        if weights is None:
            return jnp.zeros(self.ends.shape), ()
        placed: Any = self.placed

        def of_beam(constants: tuple[Array, ...], ends: Float[Array, "k"], shape: Any, weight: Float[Array, "k axes"]):
            return jax.vjp(lambda ends, shape: placed(ends, *constants, *shape), ends, shape)[1](weight)

        return jax.vmap(of_beam)(self.kept, x[self.ends], bent.shape, weights)

    def pulled_along(self, x: Float[Array, "n_x"], force: Bent) -> Float[Array, "beams coefficients"]:
        """Return forces on the coefficients from forces on their functions."""

        def of_beam(constants: tuple[Array, ...], c: Float[Array, "c"], force: Bent):
            return jax.vjp(self._felt(constants), c)[1](force)[0]

        return jax.vmap(of_beam)(self.kept, x[self.c], force)

    def weights(self, moved: Moved) -> Float[Array, "beams k axes"]:
        """H s_ddot."""
        mass: Any = self.mass
        return multiplied(mass, moved.sdd)

    def mass_along(self, x: Float[Array, "n_x"], along: Float[Array, "n_x n"]) -> Float[Array, "n n"]:
        """Return the mass matrix of the beams; `along` is the derivative of the coordinates by the free coordinates."""
        inner_first = jnp.concatenate([self.c, self.ends], axis=1)

        def derived(constants: tuple[Array, ...], c: Float[Array, "c"], ends: Float[Array, "k"]):
            bend, closed = self._stages(constants, c)
            return derivative_in_stages(bend, lambda ends, shape: closed(ends, shape)[1], c, ends)[1]

        j = jax.vmap(derived)(self.kept, x[self.c], x[self.ends])
        by_moving = jnp.einsum("bkax,bxn->bkan", j, along[inner_first])
        return jnp.einsum("bkan,bkl,blam->nm", by_moving, self.mass, by_moving)

    def _stages(self, constants: tuple[Array, ...], c: Float[Array, "c"]):
        """Return the stages of one beam: coefficients to one array, first end and array to way and inertia vectors."""
        bend, placed = self._felt(constants), self.placed
        unravel = ravel_pytree(bend(c))[1]

        def closed(ends: Float[Array, "k"], shape: Float[Array, "s"]):
            bent = unravel(shape)
            return bent.way, None if placed is None else placed(ends, *constants, *bent.shape)

        return lambda c: ravel_pytree(bend(c))[0], closed

    def derivatives(
        self,
        x: Float[Array, "n_x"],
        weights: Float[Array, "beams k axes"] | None,
        way: tuple[Array, ...],
        derived: Moved | None,
        stiffness: Float[Array, "n_e n_e"],
        damping: Float[Array, "n_e n_e"] | None = None,
    ) -> tuple[Float[Array, "beams k k"], Float[Array, "beams k k"], Float[Array, "beams k k"]]:
        """Derivatives of the forces by the beams' coordinates, their rates and second rates.

        Args:
            weights: Forces on the inertia vectors.
            way: Forces on way and turn, as in :class:`Bent`.
            derived: Derivatives of the inertia vectors from :meth:`moved_and_derived`.
            stiffness, damping: Of all deformations, and of their rates.
        """
        by_x = self._derived_forces(x, weights, way)
        by_v = by_a = jnp.zeros_like(by_x)
        if derived is not None and self.mass is not None:
            more, by_v, by_a = by_inertia(self.mass, *derived)
            by_x = by_x + more
        c = self.ends.shape[1]
        if self.e.shape[1]:
            beside = ((0, 0), (c, 0), (c, 0))
            by_x = by_x + jnp.pad(own_of(self.e, stiffness), beside)
            if damping is not None:
                by_v = by_v + jnp.pad(own_of(self.e, damping), beside)
        return by_x, by_v, by_a

    def _derived_forces(
        self, x: Float[Array, "n_x"], weights: Float[Array, "beams k axes"] | None, way: tuple[Array, ...]
    ) -> Float[Array, "beams k k"]:
        """Return derivatives by the beams' coordinates of their generalised forces from constant forces."""

        def of_beam(constants: tuple[Array, ...], c: Float[Array, "c"], ends: Float[Array, "k"], *forces: Any):
            bend, closed = self._stages(constants, c)

            def work(ends: Float[Array, "k"], shape: Float[Array, "s"]):
                way, places = closed(ends, shape)
                pairs = zip(jax.tree.leaves(forces), jax.tree.leaves((places, way)), strict=True)
                return sum((jnp.sum(force * quantity) for force, quantity in pairs), jnp.zeros(()))

            return jnp.roll(hessian_in_stages(bend, work, c, ends), ends.size, (0, 1))

        return jax.vmap(of_beam)(self.kept, x[self.c], x[self.ends], weights, way)


def tree_beams(topology: Topology, parameters: Parameters, tree: Tree) -> tuple[TreeBeams, ...]:
    """All beams with computed last ends, prepared for motion."""
    beams, part_counts = [], [0] * len(topology.blocks)
    if tree.felt is not None:
        parts = 2 if tree.felt.turns.shape[1] else 1
        part_counts = [parts if rows.shape[0] else 0 for rows in tree.felt.rows]
    blocks = zip(topology.blocks, parameters.properties, tree.rows, part_counts, strict=True)
    for block, properties, (rows, _), needed in blocks:
        if rows.shape[0]:
            beams.append(_prepared(*block_part(block, properties, rows), parameters.reference, needed))
    return tuple(beams)


def _prepared(block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"], parts: int) -> TreeBeams:
    inertia, properties = companion_of(block, with_rigidities(properties), "inertia")
    deforms = "deformation" in block.companions
    way_function: Any = (
        element_function(block, block.element.passage, deforming(block, properties)) if deforms else None
    )
    # Coordinates are position and rotation of the first end, of the last end, and coefficients.
    ends, first = block.splits[1], block.splits[-1]
    ref = reference[block.x]

    def every(constant: tuple[Any, ...], c: tuple[Array], end: tuple[Array]):
        ref, element_properties = constant
        known = jnp.split(ref, block.splits)[:-1]
        # In one array, functions of the coefficients alone would seem to depend on all coordinates.
        x = [*jnp.split(end[0], block.splits[:1]), *known[2:], *c]
        way = tuple(way_function([*known, *c], ref, deforming(block, element_properties))) if deforms else ()
        return (), way, None if inertia is None else inertia(x, ref, element_properties)[0]

    like = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype), (ref, properties))
    groups = [like, *((jax.ShapeDtypeStruct((n,), ref.dtype),) for n in (block.x.shape[1] - first, ends))]
    early, along, last = split_in_stages(every, groups)

    def bent(c: Float[Array, "c"], *constants: Array) -> Bent:
        return Bent(*along(c, *constants))

    def placed(ends: Float[Array, "k"], *kept_and_shape: Array):
        return last(ends, *kept_and_shape)[0]

    mass = None if inertia is None else jax.vmap(lambda *numbers: inertia(*numbers)[1])(ref, ref, properties)
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
