"""How the nodes of a mechanism have turned since its matrices were computed: what turns as a whole keeps them."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..compilation.record import Record
from ..math.indices import put
from ..math.rigid import compose_turns
from ..math.rotation import CONJUGATE, rotation_matrix, rotation_plane
from ..model.topology import Block, Topology


class Turning(Record):
    """Which unknowns turn, and with which rotations.

    Attributes:
        vectors: Of each position whose node turns, its places among the unknowns, (k, axes).
        by: Its rotation among the nodal coordinates, (k, 1 or 4).
        parameters: Of each rotation in space its places among the unknowns, (j, 4); none in the plane.
        own: The same among the nodal coordinates, (j, 4).
    """

    vectors: Int[Array, "k axes"]
    by: Int[Array, "k parameters"]
    parameters: Int[Array, "j four"]
    own: Int[Array, "j four"]

    def since(self, x: Float[Array, "n_x"], before: Float[Array, "n_x"]) -> "Turns":
        """How everything has turned between two places."""
        if self.vectors.shape[1] == 2:
            angles = (x - before)[self.by[:, 0]]
            return Turns(jax.vmap(rotation_plane)(angles), jnp.zeros((0, 4, 4)))

        def relative(places: Int[Array, "n 4"]):
            turn = compose_turns(x[places], before[places] * CONJUGATE)
            return turn / jnp.sqrt(jnp.sum(turn**2, axis=1, keepdims=True))

        units = jnp.eye(4)[:, None]
        products = compose_turns(relative(self.own), jnp.broadcast_to(units, (4, *self.own.shape)))
        return Turns(jax.vmap(rotation_matrix)(relative(self.by)), jnp.moveaxis(products, 0, 2))

    def turned(self, turns: "Turns", along: Float[Array, "r"]) -> Float[Array, "r"]:
        """Forces or displacements of the unknowns, turned along with their nodes."""
        for places, matrices in ((self.vectors, turns.of_vectors), (self.parameters, turns.of_parameters)):
            along = put(along, places, jnp.sum(matrices * along[places][:, None, :], axis=2))
        return along

    def turned_back(self, turns: "Turns", along: Float[Array, "r"]) -> Float[Array, "r"]:
        """The inverse of :meth:`turned`."""
        return self.turned(Turns(turns.of_vectors.mT, turns.of_parameters.mT), along)


class Turns(NamedTuple):
    """Matrices by which vectors and Euler parameters have turned.

    Attributes:
        of_vectors: (k, axes, axes).
        of_parameters: (j, 4, 4).
    """

    of_vectors: Float[Array, "k axes axes"]
    of_parameters: Float[Array, "j 4 4"]


def turning_of(topology: Topology, blocks: list[Block]) -> Turning:
    """What turns in a mechanism, on the host: positions that an element names beside a rotation, and rotations."""
    free = np.asarray(topology.x.free)
    unknown = np.full(topology.n_x, -1)
    unknown[free] = np.arange(len(free))
    positions, rotations = [], []
    for block in blocks:
        kinds = list(block.element.nodes.values())
        columns = np.split(np.asarray(block.x), block.splits, axis=1)
        for i, (kind, own) in enumerate(zip(kinds, columns, strict=True)):
            if kind.part == "rotation":
                rotations.append(own)
                if i and kinds[i - 1].part == "position":
                    positions.append(np.concatenate([columns[i - 1], own], axis=1))
    axes = 2 if not rotations or rotations[0].shape[1] == 1 else 3
    size = 1 if axes == 2 else 4

    def once(rows: list[np.ndarray], width: int, moving: int):
        """Each but once, those of which all first entries move."""
        whole = np.concatenate(rows) if rows else np.zeros((0, width), int)
        whole = whole[np.unique(whole[:, 0], return_index=True)[1]]
        return whole[np.all(unknown[whole[:, :moving]] >= 0, axis=1)]

    pairs = once(positions, axes + size, axes)
    own = once(rotations, 4, 4) if axes == 3 else np.zeros((0, 4), int)
    return Turning(*jax.device_put((unknown[pairs[:, :axes]], pairs[:, axes:], unknown[own], own)))
