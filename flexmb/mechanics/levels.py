"""Levels of a chain: groups of unknowns. Each element joins unknowns of one level or of two neighbouring levels."""

import functools
from collections import deque
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Inexact, Int

from ..compilation.record import Record, static
from ..math.block_tridiagonal import BlockFactors, factorise_blocks, parts_of
from ..model.topology import Block, Topology
from .blocks import scatter_vector

# Largest number of unknowns in a level for which chains use this form by default. Up to this number, the first motion
# takes no longer, with compilation (benchmarks/chains.py).
WIDE = 16
# Least numbers of coordinates and of levels from which sparse matrices solve an equilibrium of a chain faster than
# dense.
LONG, LINKS = 120, 20


class Levels(Record):
    """Unknowns, coordinates and multipliers, in levels: an element joins unknowns of one level or of two neighbours.

    Attributes:
        place: Number of the unknown at each place of each level; one past the last for none.
        back: Index of each unknown in the flattened ``place``.
        table: Entries of the element matrices, in sequence, that make up each entry of the lower, diagonal and upper
            blocks; one past the last for none.
        empty: Ones on the diagonal of places without an unknown.
        unknowns: Of each element of the blocks that move: its coordinates, then its deformations if some are held.
        holds: Whether deformations of each such block are held.
    """

    place: Int[Array, "b count"]
    back: Int[Array, "unknowns"]
    table: Int[Array, "three b b count most"]
    empty: Float[Array, "b b count"]
    unknowns: tuple[Int[Array, "elements k"], ...]
    holds: tuple[bool, ...] = static()

    def factors(self, pieces: tuple[Array, ...], diagonal: Array | None = None) -> BlockFactors:
        """Factors of the sum of element matrices, ordered by ``unknowns``, with a diagonal added at the unknowns."""
        entries = jnp.concatenate([*(piece.reshape(-1) for piece in pieces), jnp.zeros(1, pieces[0].dtype)])
        lower, middle, upper = jnp.sum(entries[self.table], axis=-1)
        middle = middle + self.empty.astype(middle.dtype)
        if diagonal is not None:
            more = jnp.append(diagonal, 0.0)[self.place]
            middle = middle + jnp.eye(more.shape[0])[:, :, None] * more
        return factorise_blocks(lower, middle, upper)

    def solved(
        self, factors: BlockFactors, right: Inexact[Array, "unknowns"], transposed: bool = False
    ) -> Inexact[Array, "unknowns"]:
        """Solution by factors, or of the transposed equations, in the order of the unknowns."""
        if transposed:
            return jax.linear_transpose(functools.partial(self.solved, factors), right)(right)[0]
        blocks = jnp.append(right, jnp.zeros((), right.dtype))[self.place]
        return factors.solve(blocks).reshape(-1)[self.back]

    def product(self, pieces: tuple[Array, ...], change: Float[Array, "unknowns"]) -> Float[Array, "unknowns"]:
        """Product of the sum of element matrices and a change of the unknowns."""
        return product_of(self.unknowns, pieces, change)


def product_of(
    unknowns: tuple[Int[Array, "elements k"], ...], pieces: tuple[Array, ...], change: Float[Array, "unknowns"]
) -> Float[Array, "unknowns"]:
    """Product of the sum of element matrices and a change of the unknowns; unknowns one past the last mean none."""
    padded = jnp.append(change, 0.0)
    every = zip(unknowns, pieces, strict=True)
    products = [(places, jnp.sum(own * padded[places][:, None, :], axis=2)) for places, own in every]
    return scatter_vector(padded.shape[0], products)[:-1]


def bordered(
    square: Float[Array, "elements c c"],
    rows: Float[Array, "elements d c"],
    columns: Float[Array, "elements c d"] | None = None,
    corner: Float[Array, "elements d d"] | None = None,
) -> Float[Array, "elements k k"]:
    """Element matrices by coordinates, bordered by rows and columns of the element's deformations, or by zeros."""
    count, d, _ = rows.shape
    columns = jnp.zeros_like(rows.mT) if columns is None else columns
    corner = jnp.zeros((count, d, d)) if corner is None else corner
    upper, lower = (jnp.concatenate(pair, axis=2) for pair in ((square, columns), (rows, corner)))
    return jnp.concatenate([upper, lower], axis=1)


def moving_blocks(topology: Topology) -> list[Block]:
    """Blocks whose elements deform or have mass, which :class:`Levels` orders."""
    return [
        block
        for block in topology.blocks
        if ("deformation" in block.companions and block.e.shape[1]) or "inertia" in block.companions
    ]


def is_elastic(topology: Topology) -> bool:
    """Whether only norms of Euler parameters are held: such systems need no exchange of rows."""
    held = np.zeros(topology.n_e, bool)
    held[np.asarray(topology.e.held)] = True
    return all(block.x.shape[1] <= 4 or not np.any(held[np.asarray(block.e)]) for block in topology.blocks)


def is_long_chain(topology: Topology) -> bool:
    """Whether sparse matrices solve an equilibrium although the mechanism is not large."""
    if topology.n_x < LONG or any("force" in block.companions for block in topology.blocks):
        return False
    levels = levels_of(topology, WIDE)
    return levels is not None and levels.place.shape[1] > LINKS


def levels_of(topology: Topology, widest: int | None = None) -> Levels | None:
    """Levels of a mechanism, found once for equal structures; None if one has more than ``widest`` unknowns."""
    moving = moving_blocks(topology)
    unknowns, holds, count = unknowns_of(topology, moving)
    key = tuple((own.shape, own.tobytes()) for own in unknowns)
    found = _levels(key, topology.x.free.shape[0], count, widest)
    if found is None:
        return None
    # Put on the device here: arrays made within a trace would belong to that trace alone.
    place, back, table, empty, unknowns = jax.device_put(found)
    return Levels(place, back, table, empty, unknowns, holds)


def unknowns_of(topology: Topology, moving: list[Block]) -> tuple[list[np.ndarray], tuple[bool, ...], int]:
    """Unknowns of the elements of each moving block, whether some of its deformations are held, and their number.

    Unknowns (elements, k) are free coordinates, then multipliers if some are held; one past the last means none.
    """
    free, held = np.asarray(topology.x.free), np.asarray(topology.e.held)
    n, count = len(free), len(free) + len(held)
    of_x, of_e = np.full(topology.n_x, count), np.full(topology.n_e, count)
    of_x[free], of_e[held] = np.arange(n), n + np.arange(len(held))
    unknowns, holds = [], []
    for block in moving:
        x, e = np.asarray(block.x), np.asarray(block.e)
        own = of_e[e if "deformation" in block.companions else e[:, :0]]
        holds.append(bool(np.any(own < count)))
        unknowns.append(np.concatenate([of_x[x], own], axis=1) if holds[-1] else of_x[x])
    return unknowns, tuple(holds), count


@functools.lru_cache(8)
def _levels(key: tuple[tuple[tuple[int, ...], bytes], ...], n: int, count: int, widest: int | None) -> Any:
    unknowns = [np.frombuffer(data, np.int64).reshape(shape) for shape, data in key]
    elements = [row[row < count] for rows in unknowns for row in rows]
    level = _level_of_each(elements, n, count)
    order = np.argsort(level, kind="stable")
    sizes = np.bincount(level)
    wide, many = int(np.max(sizes)), int(np.prod(parts_of(len(sizes))))
    if widest is not None and wide > widest:
        return None
    within = np.empty(count, int)
    within[order] = np.arange(count) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    place = np.full((wide, many), count)
    place[within, level] = np.arange(count)
    table = _table(unknowns, np.append(level, -9), np.append(within, 0), wide, many, count)
    empty = np.eye(wide)[:, :, None] * (place == count)
    back = within * many + level
    return place, back, table, empty, tuple(unknowns)


def _level_of_each(elements: list[np.ndarray], n: int, count: int) -> np.ndarray:
    """Level of each unknown: steps from one end, counted over elements; multipliers follow their last coordinate."""
    groups = [own[own < n] for own in elements]
    groups = [own for own in groups if len(own)]
    of_each: list[list[frozenset[int]]] = [[] for _ in range(n)]
    sets = [frozenset(own.tolist()) for own in groups]
    for mine in sets:
        for i in mine:
            of_each[i].append(mine)
    # Elements within others, such as masses and norms, do not matter. An element that contains one also has the unknown
    # of it that fewest elements share.
    wide = []
    for own, mine in zip(groups, sets, strict=True):
        rarest = min(mine, key=lambda i: len(of_each[i]))
        if not any(mine < other for other in of_each[rarest]):
            wide.append(own)
    joined: list[list[int]] = [[] for _ in range(n)]
    for number, own in enumerate(wide):
        for i in own:
            joined[i].append(number)
    # Unknowns of the same elements are one node.
    alike: dict[tuple[int, ...], int] = {}
    node = np.array([alike.setdefault(tuple(numbers) or (-1 - i,), len(alike)) for i, numbers in enumerate(joined)])
    members = [sorted(set(node[own].tolist())) for own in wide]
    near: list[set[int]] = [set() for _ in range(len(alike))]
    for own in members:
        for i in own:
            near[i].update(own)
    found = np.full(len(alike), -1)
    ends = sorted(range(len(alike)), key=lambda i: len(near[i]))
    base = 0
    for start in ends:
        if found[start] < 0:
            # Start at the far end of the part that is reached.
            reached = _steps(near, start)
            reached = _steps(near, max(reached, key=lambda i: (reached[i], -len(near[i]))))
            for i, steps in reached.items():
                found[i] = base + steps
            base = int(np.max(found)) + 1
    level = np.zeros(count, int)
    level[:n] = found[node]
    for own in elements:
        coordinates = own[own < n]
        level[own[own >= n]] = np.max(level[coordinates], initial=0)
    return level


def _steps(near: list[set[int]], start: int) -> dict[int, int]:
    reached, queue = {start: 0}, deque([start])
    while queue:
        i = queue.popleft()
        for j in near[i]:
            if j not in reached:
                reached[j] = reached[i] + 1
                queue.append(j)
    return reached


def _table(unknowns: list[np.ndarray], level: np.ndarray, within: np.ndarray, wide: int, many: int, count: int):
    """Entries of the element matrices that make up each entry of the blocks."""
    rows = np.concatenate([np.repeat(u, u.shape[1], axis=1).ravel() for u in unknowns])
    columns = np.concatenate([np.tile(u, (1, u.shape[1])).ravel() for u in unknowns])
    kept = np.flatnonzero((rows < count) & (columns < count))
    i, j = rows[kept], columns[kept]
    # This raises if an element joins levels further apart.
    places = (level[j] - level[i] + 1, within[i], within[j], level[i])
    slot = np.asarray(np.ravel_multi_index(places, (3, wide, wide, many)))
    order = np.argsort(slot, kind="stable")
    slot, kept = slot[order], kept[order]
    numbers = np.bincount(slot, minlength=3 * wide * wide * many)
    first = np.cumsum(numbers) - numbers
    table = np.full((len(numbers), int(np.max(numbers))), len(rows))
    table[slot, np.arange(len(slot)) - first[slot]] = kept
    return table.reshape(3, wide, wide, many, -1)
