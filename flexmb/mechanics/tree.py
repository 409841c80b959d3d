"""Beams with strain series whose last end follows from the first end and the strains, found from the topology.

The search starts from held nodes, or from any node of a part without held nodes. Each such beam determines the pose of
its other end, unless this end is held or another beam determines it. The remaining beams close loops.
"""

from __future__ import annotations

import collections
from collections.abc import Collection
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import is_concrete
from ..compilation.record import Record, static
from ..elements.nodes import unit_norm
from ..math.rigid import compose_turns
from ..math.rotation import CONJUGATE, cosine_and_sine, rotation_matrix
from ..model.topology import Block, Topology
from .blocks import with_rigidities


class Poses(Record):
    """Poses determined by beams, with beams in the order of their blocks.

    Attributes:
        rows: Of each block the beams that determine poses.
        ends: Coordinates of the position that each beam determines.
        turns: Coordinates of the rotation; (beams, 0) if only positions are asked for.
        whence: Coordinates of the position from which the chain of each beam starts.
        turned_from: Coordinates of the rotation from which it starts.
        place: Places of all coordinates among themselves, followed by determined rotations and positions.
        along: 1 for beams on the way to each position.
        before: 1 for the beam whose rotation comes one before each, two before, four before, ..
        floats: Whether some chain starts from coordinates that move.
        back: Whether a beam starts from its last end; None if none does.
    """

    rows: tuple[Int[Array, "_s"], ...]
    ends: Int[Array, "beams d"]
    turns: Int[Array, "beams r"]
    whence: Int[Array, "beams d"]
    turned_from: Int[Array, "beams r"]
    place: Int[Array, "n_x"]
    along: Float[Array, "beams beams"]
    before: Float[Array, "levels beams beams"]
    floats: bool = static()
    back: Bool[Array, "beams"] | None


class Tree(Record):
    """Beams whose last end is computed.

    Attributes:
        rows: Of each block the elements without their last end, and the elements that stay as they are.
        poses: All computed poses.
        felt: Computed poses on which something acts or depends, all of a block or none; None without any.
        kept: Free coordinates that are not computed.
        kept_places: Their places among the free ones.
        held_places: Indices of the held deformations that computed poses do not satisfy automatically.
    """

    rows: tuple[tuple[Int[Array, "_s"], Int[Array, "_w"]], ...]
    poses: Poses
    felt: Poses | None
    kept: Int[Array, "n"]
    kept_places: Int[Array, "n"]
    held_places: Int[Array, "m"]


class _Beam(NamedTuple):
    """A beam with strain series: block and row, coordinates of its nodes, and its closure."""

    block: int
    row: int
    ends: tuple[tuple[int, ...], tuple[int, ...]]
    turns: tuple[tuple[int, ...], tuple[int, ...]]
    closure: tuple[int, ...]


class _Visit(NamedTuple):
    """A beam of a walk: whether it starts from its last end, and the beams before it by position and by rotation."""

    beam: _Beam
    back: bool
    after: int | None
    turned_after: int | None


def tree_of(topology: Topology, acted: Collection[int] | None = None) -> Tree | None:
    """Beams whose last end can be computed; None without any, or for a traced topology."""
    if not is_concrete(topology):
        return None
    walked = _visits(list(_beams(topology)), set(np.asarray(topology.x.free).tolist()))
    if not walked:
        return None
    poses = _poses(topology, walked)
    computed = {*poses.ends.ravel().tolist(), *poses.turns.ravel().tolist()}
    rows, closed = _rows(topology, {visit.beam.closure[0] for visit in walked}, computed)
    closed |= {e for visit in walked for e in visit.beam.closure}
    free, constrained = np.asarray(topology.x.free), np.asarray(topology.e.held)
    constructor: Any = Tree
    kept_places = np.flatnonzero(~np.isin(free, list(computed)))
    read = computed if acted is None else _read(topology, rows) | set(acted)
    needed_visits = _determining_beams(walked, read)
    # A beam needs its rotation, at its first end.
    turning = any(read.intersection(_at(visit, "turns")) for visit in needed_visits)
    return constructor(
        rows,
        poses,
        _poses(topology, needed_visits, turning) if needed_visits else None,
        free[kept_places],
        kept_places,
        np.flatnonzero(~np.isin(constrained, list(closed))),
    )


def _poses(topology: Topology, walked: list[_Visit], turning: bool = True) -> Poses:
    """Poses of beams in a walk, renumbered; positions alone unless ``turning``."""
    order = sorted(range(len(walked)), key=lambda i: walked[i].beam[:2])
    number = {i: k for k, i in enumerate(order)} | {None: None}
    walked = [walked[i] for i in order]
    after, turned_after = ([number[key] for key in column] for column in list(zip(*walked, strict=True))[2:])
    # Arrays of NumPy, as in a topology outside a trace.
    constructor: Any = Poses
    nodes = {name: np.array([_at(visit, name) for visit in walked]) for name in ("ends", "turns", "near", "base")}
    whence, turned_from = (
        np.array([nodes[key][_way(before, i)[-1]] for i in range(len(walked))])
        for key, before in (("near", after), ("base", turned_after))
    )
    if not turning:
        nodes["turns"] = nodes["turns"][:, :0]
    place = np.arange(topology.n_x)
    for name in ("turns", "ends"):
        place[nodes[name]] = place.max() + 1 + np.arange(nodes[name].size).reshape(nodes[name].shape)
    blocks = range(len(topology.blocks))
    return constructor(
        tuple(np.array([visit.beam.row for visit in walked if visit.beam.block == k], int) for k in blocks),
        nodes["ends"],
        nodes["turns"],
        whence,
        turned_from,
        place,
        np.array([np.isin(np.arange(len(walked)), _way(after, i)) for i in range(len(walked))], float),
        _jumps(turned_after),
        bool(np.isin(np.concatenate([whence, turned_from], axis=1), np.asarray(topology.x.free)).any()),
        np.array([visit.back for visit in walked]) if any(visit.back for visit in walked) else None,
    )


def _read(topology: Topology, rows: tuple[tuple[np.ndarray, np.ndarray], ...]) -> set[int]:
    """Coordinates on which elements depend; beams with a computed last end do not depend on it."""
    indices: set[int] = set()
    for block, (short, complete) in zip(topology.blocks, rows, strict=True):
        x = np.asarray(block.x)
        indices |= set(x[complete].ravel().tolist())
        if short.shape[0]:
            indices |= set(x[short, : block.splits[1]].ravel().tolist())
    return indices


def _determining_beams(walked: list[_Visit], read: set[int]) -> list[_Visit]:
    """Beams that determine coordinates in ``read``, those before them, and all others of their blocks, renumbered."""
    needed: set[int] = set()
    more = {i for i, visit in enumerate(walked) if read.intersection((*_at(visit, "ends"), *_at(visit, "turns")))}
    while not more <= needed:
        needed |= more
        blocks = {walked[i].beam.block for i in needed}
        more = {i for i, visit in enumerate(walked) if visit.beam.block in blocks}
        more |= {index for i in needed for index in (walked[i].after, walked[i].turned_after) if index is not None}
    number = {i: k for k, i in enumerate(sorted(needed))} | {None: None}
    return [
        visit._replace(after=number[visit.after], turned_after=number[visit.turned_after])
        for i, visit in enumerate(walked)
        if i in needed
    ]


def _at(visit: _Visit, name: str) -> tuple[int, ...]:
    """Coordinates of the end that a beam determines, or of the end from which it starts."""
    columns = visit.beam.turns if name in ("turns", "base") else visit.beam.ends
    return columns[visit.back if name in ("near", "base") else not visit.back]


def _beams(topology: Topology):
    """All beams with strain series and FIXED closure."""
    fixed = set(np.asarray(topology.e.fixed).tolist())
    for number, block in enumerate(topology.blocks):
        if block.element.passage is None or "deformation" not in block.companions:
            continue
        closure = block.element.fields[0][0] - 1
        for row, (x, e) in enumerate(zip(np.asarray(block.x), np.asarray(block.e), strict=True)):
            p, turn_p, q, turn_q, _ = (tuple(part.tolist()) for part in np.split(x, block.splits))
            closure_indices = tuple(e[:closure].tolist())
            if fixed.issuperset(closure_indices):
                yield _Beam(number, row, (p, q), (turn_p, turn_q), closure_indices)


def _visits(beams: list[_Beam], free: set[int]) -> list[_Visit]:
    """Beams in the order of a walk from held positions first."""
    at: dict[tuple[int, ...], list[tuple[_Beam, bool]]] = {}
    for beam in beams:
        for back in (False, True):
            at.setdefault(beam.ends[back], []).append((beam, back))
    reached: dict[tuple[int, ...], int | None] = {}
    visits: list[_Visit] = []
    for start in sorted(at, key=lambda position: bool(free.intersection(position))):
        queue = collections.deque([start] if start not in reached else [])
        if queue:
            reached[start] = None
        while queue:
            position = queue.popleft()
            for beam, back in at[position]:
                (base, turn), end = (beam.turns[back], beam.turns[not back]), beam.ends[not back]
                is_reached = end in reached or turn in reached or turn == base
                if is_reached or not free.issuperset((*end, *turn)):
                    continue
                visits.append(_Visit(beam, back, reached[position], reached.setdefault(base)))
                reached[end] = reached[turn] = len(visits) - 1
                queue.append(end)
    return visits


def _way(before: list[int | None], last: int) -> list[int]:
    """A beam, the one before it, and so on."""
    way = [last]
    while (previous := before[way[-1]]) is not None:
        way.append(previous)
    return way


def _jumps(before: list[int | None]) -> np.ndarray:
    """The beam one before each, two before, four before, and so on, while there is one."""
    none = len(before)
    current, jumps = np.array([none if index is None else index for index in before] + [none]), []
    while np.any(current != none):
        jumps.append(current[:-1])
        current = current[current]
    return np.array([np.eye(none + 1)[jump, :none] for jump in jumps]).reshape(-1, none, none)


def _rows(topology: Topology, first: set[int], computed: set[int]) -> tuple[tuple, set[int]]:
    """Of each block the elements without last end, and those that stay; unit norms that poses satisfy by themselves."""
    rows, norms = [], set()
    for block in topology.blocks:
        x, e, none = np.asarray(block.x), np.asarray(block.e), np.zeros(len(block.x), bool)
        short, computed_rows = none, none
        if block.element.passage is not None:
            short = np.isin(e[:, 0], list(first))
        elif block.element.deformation is unit_norm:
            computed_rows = np.all(np.isin(x, list(computed)), axis=1)
            norms |= set(e[computed_rows].ravel().tolist())
        rows.append((np.flatnonzero(short), np.flatnonzero(~short & ~computed_rows)))
    return tuple(rows), norms


def block_part(block: Block, properties: dict[str, Any], rows: Int[Array, "_s"]) -> tuple[Block, dict[str, Any]]:
    """Some elements of a block, with their properties."""
    if rows.shape[0] == block.x.shape[0]:
        return block, properties
    row_properties = jax.tree.map(lambda leaf: jnp.asarray(leaf)[rows], with_rigidities(properties))
    parts = {name: getattr(block, name) for name in ("element", "companions", "options", "splits", "meaning")}
    return Block(x=block.x[rows], e=block.e[rows], **parts), row_properties


def linked(poses: Poses, passed: Float[Array, "beams way_and_turn"], x: Float[Array, "n_x"]) -> Float[Array, "n_x"]:
    """Nodal coordinates with computed ones filled in; arguments as of :func:`link`."""
    turns, ends = link(poses, passed, x)
    # A gather, since the compiler makes a loop of a scatter.
    return jnp.concatenate([x, turns.reshape(-1), ends.reshape(-1)])[poses.place]


def tree_forces(
    poses: Poses, passed: Float[Array, "beams way_and_turn"], x: Float[Array, "n_x"], force: Float[Array, "n_x"]
) -> tuple[Float[Array, "beams way_and_turn"], Float[Array, "n_x"]]:
    """Forces on ways and turns, and on coordinates that are not computed, from nodal forces.

    Computed coordinates are gathered, and roots that stay are left out: the reverse of a gather would be a loop.
    """
    ends = force[poses.turns], force[poses.ends]
    if not poses.floats:
        return jax.vjp(lambda y: link(poses, y, x), passed)[1](ends)[0], force
    on_passed, on_x = jax.vjp(lambda y, x: link(poses, y, x), passed, x)[1](ends)
    return on_passed, force + on_x


def link(
    poses: Poses, passed: Float[Array, "beams way_and_turn"], x: Float[Array, "n_x"]
) -> tuple[Float[Array, "beams r"], Float[Array, "beams d"]]:
    """Rotations and positions that beams determine, THEORY.md 9 (d), eq. (9.7).

    ``passed``: way and turn of each beam, or the way alone if no rotation is asked for. Computed ones of x are not
    read.
    """
    ways, turns = jnp.split(passed, [poses.ends.shape[1]], axis=1)
    spatial = ways.shape[1] == 3
    compose, turned = (compose_turns, _turned) if spatial else (jnp.add, _turned_in_plane)
    if poses.back is not None:
        inverse = turns * CONJUGATE if spatial else -turns
        back = poses.back[:, None]
        # A beam walked backwards starts at its last end.
        ways, turns = jnp.where(back, -turned(inverse, ways), ways), jnp.where(back, inverse, turns)
    base = x[poses.turned_from]
    if poses.before.shape[0]:
        none, sums = jnp.asarray([1.0, 0, 0, 0] if spatial else [0.0]), turns

        def earlier(before: Float[Array, "beams beams"]):
            return before @ sums + (1 - jnp.sum(before, axis=1))[:, None] * none

        for before in poses.before:
            sums = compose(earlier(before), sums)
        base = compose(base, earlier(poses.before[0]))
    if turns.shape[1]:
        turns = compose(base, turns)
    return turns, x[poses.whence] + poses.along @ turned(base, ways)


def _turned(turns: Float[Array, "n 4"], vectors: Float[Array, "n 3"]):
    return jnp.sum(jax.vmap(rotation_matrix)(turns) * vectors[:, None, :], axis=2)


def _turned_in_plane(turns: Float[Array, "n 1"], vectors: Float[Array, "n 2"]):
    c, s = cosine_and_sine(turns[:, 0])
    return jnp.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)
