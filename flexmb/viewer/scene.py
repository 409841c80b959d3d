"""Arrays for the viewer: each element as a line of points, in its base state and in the states it moves through."""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..model.model import Model
from ..plot.geometry import PLACES, Line, lines, nodes_of, places_of_zigzag, point_extent
from ..plot.modes import AMPLITUDE, STEP
from ..plot.sections import Shape, across_of, shapes_of

# Points are left out while a line moves by less than this share of the mechanism's extent in all states looked at; by
# less than the second share in mechanisms of many lines. Colours may change by a share of their range.
CLOSE, CLOSE_OF_MANY, MANY = 3e-4, 1e-3, 500
CLOSE_COLOUR = 1e-2
LOOKED_AT = 9
# Strides through the places of a line. The largest keeps only its ends.
STRIDES = (1, 3, 6, 12, 24, 48, 96)
# A path or motion is thinned to this many states, and to this many coordinates.
MOST_STATES = 500
MOST_NUMBERS = 3_000_000


@dataclasses.dataclass(frozen=True)
class Drawn:
    """One element: kind as :class:`flexmb.plot.geometry.Line` has it, its first point and number of points."""

    name: str
    kind: str
    start: int
    count: int
    shape: Shape | None


class Lines(NamedTuple):
    """Lines of all elements.

    Attributes:
        parts: Elements in the order of the model.
        places: Place of each point along its element, from 0 to 1 [-].
        base: Points in the base state [m].
        states: Points in the other states, or their displacements in modes [m].
        across: Direction of the section's width in the base state, zero where it has none [-].
        across_states: The same in the other states, or its changes in modes [-].
    """

    parts: tuple[Drawn, ...]
    places: Float[np.ndarray, "points"]
    base: Float[np.ndarray, "points 3"]
    states: Float[np.ndarray, "states points 3"]
    across: Float[np.ndarray, "points 3"]
    across_states: Float[np.ndarray, "states points 3"]


class Nodes(NamedTuple):
    """Nodes of the mechanism, in the base state and in other states, or their displacements in modes [m]."""

    names: tuple[str, ...]
    base: Float[np.ndarray, "nodes 3"]
    states: Float[np.ndarray, "states nodes 3"]


def nodes_at(model: Model, base: np.ndarray, states: Sequence[np.ndarray]) -> Nodes:
    """Nodes in the base state and in other states, or their displacements in modes; all of them (n_x,)."""
    node_indices = nodes_of(model)
    index = np.array(list(node_indices.values()), int).reshape(len(node_indices), model.labels.dimension)
    return Nodes(
        tuple(node_indices), in_space(base[index]), in_space(_stacked([x[index] for x in states], index.shape))
    )


def lines_at(model: Model, base: np.ndarray, states: Sequence[np.ndarray], values: np.ndarray | None) -> Lines:
    """Lines of a model in its base state and in other states, all (n_x,).

    Values colour the elements, (sets, elements drawn, places), NaN where there is no colour.
    """
    shapes = shapes_of(model)
    seen = []
    for x in [base, *(states[i] for i in thinned(len(states), LOOKED_AT))]:
        state_lines = lines(model, x)
        seen.append(_with_edges(state_lines, across_of(model, x, state_lines, shapes), shapes))
    keep = _kept_indices(seen, values)
    return _lines(model, base, shapes, keep, [_drawn(model, x, shapes, keep) for x in states])


def lines_of_modes(model: Model, base: np.ndarray, moves: Sequence[np.ndarray], values: np.ndarray | None) -> Lines:
    """Lines of a model in a state, and their displacements by small changes of the coordinates, each (n_x,)."""
    shapes, still = shapes_of(model), lines(model, base)
    displacements = [_displacement(model, base, move, shapes) for move in moves]
    across = across_of(model, base, still, shapes)
    seen = [_with_edges(still, across, shapes)]
    for moved, turned in displacements:
        bent = [
            line._replace(points=line.points + AMPLITUDE * vectors) for line, vectors in zip(still, moved, strict=True)
        ]
        turn = {line.element: vectors for line, vectors in zip(still, turned, strict=True)}
        sides = {name: vectors + AMPLITUDE * turn[name] for name, vectors in across.items()}
        seen.append(_with_edges(bent, sides, shapes))
    keep = _kept_indices(seen, values)
    return _lines(model, base, shapes, keep, [(_chosen(a, keep), _chosen(b, keep)) for a, b in displacements])


def _lines(
    model: Model, base: np.ndarray, shapes: dict[str, Shape], keep: list[np.ndarray], states: list[Any]
) -> Lines:
    """Lines from the kept points and directions in all states, one pair of arrays each."""
    still = lines(model, base)
    starts = np.cumsum([0, *map(len, keep)]).tolist()
    parts = tuple(
        Drawn(line.element, line.kind, start, len(kept), shapes.get(line.element))
        for line, start, kept in zip(still, starts, keep, strict=False)
    )
    places = [kept / max(len(line.points) - 1, 1) for line, kept in zip(still, keep, strict=True)]
    points, across = _drawn(model, base, shapes, keep)
    moved, turned = (_stacked([pair[i] for pair in states], points.shape) for i in (0, 1))
    return Lines(parts, np.concatenate([*places, np.zeros(0)]), points, moved, across, turned)


def drawn_values(found: Lines, values: np.ndarray) -> Float[np.ndarray, "sets points"]:
    """Colours of the points that are drawn."""
    rows = np.repeat(np.arange(len(found.parts)), [part.count for part in found.parts])
    return values[:, rows, np.rint(found.places * (len(PLACES) - 1)).astype(int)]


def in_space(points: Float[np.ndarray, "*n d"]) -> Float[np.ndarray, "*n 3"]:
    """Points with a third coordinate, zero in the plane."""
    return np.concatenate([points, np.zeros((*points.shape[:-1], 3 - points.shape[-1]))], axis=-1)


def most_states(found: Lines) -> int:
    """Number of states of a path or motion that are shown."""
    return max(2, min(MOST_STATES, MOST_NUMBERS // max(found.base.size, 1)))


def thinned(count: int, most: int) -> np.ndarray:
    """Indices of evenly chosen states, among them the first and the last."""
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(int))


def _displacement(model: Model, base: np.ndarray, move: np.ndarray, shapes: dict[str, Shape]):
    """Displacement of every line by a mode, and the change of the directions across it."""
    step = STEP / (np.max(np.abs(move), initial=0.0) or 1.0)
    states = [base + sign * step * move for sign in (-1, 1)]
    ends = [lines(model, x, straight=True) for x in states]
    across = [across_of(model, x, state_lines, shapes) for x, state_lines in zip(states, ends, strict=True)]
    rate = 1 / (2 * step)
    moved, turned = [], []
    for before, after in zip(*ends, strict=True):
        displacement = rate * (after.points - before.points)
        if after.kind == "spring":
            s = places_of_zigzag()[:, None]
            displacement = (1 - s) * displacement[0] + s * displacement[-1]
        moved.append(displacement)
        name = after.element
        turned.append(
            rate * (across[1][name] - across[0][name]) if name in across[1] else np.zeros((len(displacement), 3))
        )
    return moved, turned


def _drawn(
    model: Model, x: np.ndarray, shapes: dict[str, Shape], keep: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Kept points of all lines, and the directions across them."""
    drawn = lines(model, x)
    across = across_of(model, x, drawn, shapes)
    sides = [across.get(line.element, np.zeros((len(line.points), 3))) for line in drawn]
    return _chosen([line.points for line in drawn], keep), _chosen(sides, keep)


def _chosen(curves: list[np.ndarray], keep: list[np.ndarray]) -> np.ndarray:
    """Kept points of all lines, one line after the other, (points, 3)."""
    points = [curve[k] for curve, k in zip(curves, keep, strict=True)]
    return in_space(np.concatenate(points) if points else np.zeros((0, 3)))


def _stacked(arrays: list[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    return in_space(np.stack(arrays)) if arrays else np.zeros((0, *shape))


def _with_edges(drawn: list[Line], across: dict[str, np.ndarray], shapes: dict[str, Shape]) -> list[np.ndarray]:
    """Points of every line beside points of an edge of its section, which twist moves too, each (places, 2 d)."""
    sides = {name: shapes[name].width / 2 * vectors for name, vectors in across.items()}
    return [np.concatenate([line.points, line.points + sides.get(line.element, 0.0)], axis=1) for line in drawn]


def _kept_indices(seen: list[list[np.ndarray]], values: np.ndarray | None) -> list[np.ndarray]:
    """Kept points of every line; ``seen`` holds the lines in several states."""
    everything = np.concatenate(seen[0]) if seen[0] else np.zeros((0, 2))
    close = (CLOSE if len(seen[0]) < MANY else CLOSE_OF_MANY) * point_extent(everything)
    finite = None if values is None else values[np.isfinite(values)]
    colour_close = CLOSE_COLOUR * float(np.max(np.abs(finite))) if finite is not None and finite.size else np.inf
    keep = [np.arange(len(points)) for points in seen[0]]
    curves = [i for i, points in enumerate(seen[0]) if len(points) == len(PLACES)]
    if not curves:
        return keep
    over = np.stack([np.stack([drawn[i] for i in curves]) for drawn in seen])
    colours = None if values is None else np.nan_to_num(values[:, curves])[..., None]
    for stride in STRIDES:
        good = np.max(_error(over, stride), axis=0) <= close
        if colours is not None:
            good &= np.max(_error(colours, stride), axis=0) <= colour_close
        for i in np.flatnonzero(good):
            keep[curves[i]] = np.arange(0, len(PLACES), stride)
    return keep


def _error(curves: Float[np.ndarray, "states n places d"], stride: int) -> Float[np.ndarray, "states n"]:
    """How far curves are from the polylines through every so many of their points."""
    count = curves.shape[2]
    first = np.minimum(np.arange(count) // stride * stride, count - 1 - stride)
    part = ((np.arange(count) - first) / stride)[:, None]
    straight = (1 - part) * curves[:, :, first] + part * curves[:, :, first + stride]
    return np.max(np.linalg.norm(straight - curves, axis=-1), axis=-1)
