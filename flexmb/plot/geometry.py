"""Lines of the elements of a mechanism, from node kinds and companions alone."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..elements.element import ELASTIC
from ..mechanics.centreline import curves_of
from ..model.model import Model
from ..model.topology import Block, Role

# Places along an element: multiples of 1/96 include halves and thirds, where a shape may have a corner.
PLACES = np.linspace(0.0, 1.0, 97)
# Teeth of a spring to either side.
TEETH = 5


class Line(NamedTuple):
    """An element as it is drawn.

    Attributes:
        element: Its name.
        kind: "beam" or "bar", which are elastic, with rotations and without; "rigid"; "spring", which has a law;
            "joint", a line that is neither elastic nor rigid; "hinge", which has no points of its own.
        points: Along the element, (places, d) [m]; of a hinge the one place where its bodies meet.
    """

    element: str
    kind: str
    points: Float[np.ndarray, "places d"]


def nodes_of(model: Model, part: str = "position") -> dict[str, np.ndarray]:
    """Indices in x of every node of one kind. Returns the indices by node name, in the order of the model."""
    by_name: dict[str, list[int]] = {}
    for i, entry in enumerate(model.labels.x):
        if entry.kind == part:
            by_name.setdefault(entry.of, []).append(i)
    return {name: np.array(indices) for name, indices in by_name.items()}


def point_extent(points: Float[np.ndarray, "n d"]) -> float:
    """Largest size of a set of points along an axis, 1 of a single point [m]."""
    return (float(np.max(np.ptp(points, axis=0))) if len(points) else 0.0) or 1.0


def places_of_rotations(model: Model) -> dict[str, list[str]]:
    """Names of the points of each rotation. In the signature of an element, a rotation follows its point."""
    points_by_name: dict[str, list[str]] = {}
    for block in model.topology.blocks:
        kinds = list(block.element.nodes.values())
        starts = [0, *block.splits]
        for row in np.asarray(block.x).tolist():
            point = None
            for kind, start in zip(kinds, starts, strict=True):
                name = model.labels.x[row[start]].of
                if kind.part == "position":
                    point = name
                elif kind.part == "rotation" and point is not None:
                    points_by_name.setdefault(name, []).append(point)
    return points_by_name


def lines(model: Model, x: Float[np.ndarray, "n_x"], straight: bool = False) -> list[Line]:
    """Every element with deformations as a line, at given coordinates, in the order of the model.

    An element's ``shape`` companion says where its points are. Without one, two points and two rotations are joined by
    the cubic along the axis that the undeformed element had, and other points by straight lines.
    """
    by_element: dict[str, Line] = {}
    companions: dict[str, set[str]] = {}
    for block in model.topology.blocks:
        for name in element_names(model, block):
            companions.setdefault(name, set()).update(block.companions)
    roles, paired = model.roles()[1], places_of_rotations(model)
    reference = np.asarray(model.parameters.reference)
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        names = element_names(model, block)
        if "deformation" not in block.companions or not names:
            continue
        curves = curves_of(block, properties, reference, x, PLACES)
        for i, (name, deformations) in enumerate(zip(names, np.asarray(block.e).tolist(), strict=True)):
            kind = _kind(block, companions[name], all(roles[k] is Role.FIXED for k in deformations))
            points = _meeting(model, block, i, x, paired) if kind == "hinge" else curves[i]
            if kind == "spring" and not straight:
                points = zigzag(points[0], points[-1])
            if len(points):
                by_element[name] = Line(name, kind, points)
    return [by_element[name] for name, *_ in model.labels.elements if name in by_element]


def scaled_lines(
    model: Model, base: Float[np.ndarray, "n_x"], x: Float[np.ndarray, "n_x"], factor: float
) -> list[Line]:
    """Every element as a line, its displacement from one state to another multiplied."""
    if factor == 1:
        return lines(model, x)
    scaled = []
    # A beam that bends is no linear function of its coordinates, and would end beside the nodes that it joins.
    for still, moved in zip(lines(model, base, straight=True), lines(model, x, straight=True), strict=True):
        points = still.points + factor * (moved.points - still.points)
        scaled.append(moved._replace(points=zigzag(points[0], points[-1]) if moved.kind == "spring" else points))
    return scaled


def masses(model: Model) -> list[np.ndarray]:
    """Indices in x of every point that carries a lumped mass, or a body."""
    point_indices = []
    for block in model.topology.blocks:
        first = next(iter(block.element.nodes.values()))
        if block.e.shape[1] == 0 and "inertia" in block.companions and first.part == "position":
            point_indices += list(np.asarray(block.x)[:, : first.size])
    return point_indices


def zigzag(p: Float[np.ndarray, "d"], q: Float[np.ndarray, "d"]) -> Float[np.ndarray, "n d"]:
    """A spring from p to q. Returns its corners, (n, d) [m]."""
    along = q - p
    across = np.eye(len(p))[np.argmin(np.abs(along))]
    across = across - (across @ along) * along / max(along @ along, 1e-300)
    across *= 0.08 * np.linalg.norm(along) / np.linalg.norm(across)
    places = places_of_zigzag()
    # 0, 1, 0, -1, 0, ...
    sides = np.concatenate([[0.0], np.sin(np.pi / 2 * np.arange(2 * TEETH + 1)), [0.0]])
    return p + places[:, None] * along + sides[:, None] * across


def places_of_zigzag() -> Float[np.ndarray, "n"]:
    """Where the corners of a :func:`zigzag` lie between its ends, from 0 to 1, (n,) [-]."""
    return np.concatenate([[0.0], np.linspace(0.2, 0.8, 2 * TEETH + 1), [1.0]])


def element_names(model: Model, block: Block) -> list[str]:
    """Names of a block's elements; none for what has no deformations or is a unit norm."""
    if block.e.shape[1] == 0:
        return []
    entries = [model.labels.e[k] for k in np.asarray(block.e)[:, 0].tolist()]
    return [] if entries[0].kind == "norm" else [entry.of for entry in entries]


def _kind(block: Block, companions: set[str], fixed: bool) -> str:
    parts = [kind.part for kind in block.element.nodes.values()]
    if "position" not in parts:
        return "hinge"
    if fixed:
        return "rigid"
    if "law" in companions and parts == ["position", "position"]:
        return "spring"
    if companions.isdisjoint(ELASTIC):
        return "joint"
    return "beam" if "rotation" in parts else "bar"


def _meeting(
    model: Model, block: Block, row: int, x: np.ndarray, paired: dict[str, list[str]]
) -> Float[np.ndarray, "n d"]:
    """The common point of the bodies that an element joins, else a point of the first body; (0, d) if there is none."""
    index, starts = np.asarray(block.x)[row], [0, *block.splits]
    points = [paired.get(model.labels.x[index[k]].of, []) for k in starts]
    points = [names for names in points if names]
    if not points:
        return np.zeros((0, 0))
    common = [name for name in points[0] if all(name in names for names in points)]
    return x[nodes_of(model)[(common or points[0])[0]]][None]
