"""Drawn cross-sections: their sides, and the direction of their width along an element."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..elements.curves import CurvedLine, frames_of_ends
from ..elements.sections import Circle, HollowRectangle, Rectangle, Rigidity, Section, Tube
from ..math.rotation import initial_frame
from ..mechanics.centreline import coordinates_of_kind, turns_of
from ..model.model import Model
from ..model.topology import Block
from ..numerical_limits import OPPOSITE_TANGENTS
from .geometry import Line, element_names


class Shape(NamedTuple):
    """Outline of a cross-section.

    Attributes:
        width: Side along local y, or diameter [m].
        thickness: Side along local z, or diameter [m].
        round: Whether it is a circle.
    """

    width: float
    thickness: float
    round: bool


def unstacked(section: Any) -> list[Section]:
    """Section of each element of a block, from its sections as they are stacked by kind."""
    stacks = jax.tree.map(np.asarray, section if isinstance(section, tuple) else (section,))
    counts = [len(jax.tree.leaves(stack)[0]) for stack in stacks]
    return [
        jax.tree.map(lambda leaf, i=i: leaf[i] if leaf.ndim else leaf, stack)
        for stack, count in zip(stacks, counts, strict=True)
        for i in range(count)
    ]


def sections_of(model: Model) -> dict[str, Section]:
    """Section of each element with one, by the element's name."""
    sections: dict[str, Section] = {}
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        names = element_names(model, block)
        if names and properties.get("section") is not None:
            sections.update(zip(names, unstacked(properties["section"]), strict=True))
    return sections


def shapes_of(model: Model) -> dict[str, Shape]:
    """Outlines of the elements whose section has one, by the element's name."""
    shapes = {name: shape_of(section) for name, section in sections_of(model).items()}
    return {name: shape for name, shape in shapes.items() if shape is not None}


def shape_of(section: Any) -> Shape | None:
    """Outline of a section; None if it has no shape."""
    if isinstance(section, Rigidity):
        return shape_of(section.outline)
    if isinstance(section, Rectangle | HollowRectangle):
        return Shape(float(section.width), float(section.thickness), False)
    if isinstance(section, Circle | Tube):
        return Shape(float(section.diameter), float(section.diameter), True)
    return None


def across_of(
    model: Model, x: np.ndarray, drawn: list[Line], shapes: dict[str, Shape]
) -> dict[str, Float[np.ndarray, "places 3"]]:
    """Direction of the width of every rectangular section in space, at the places of its line.

    At both ends it turns with the nodes; in between it goes along with the line without twist, and the twist that is
    left between the ends is spread evenly. Returns the unit vectors, by name of the element, each (places, 3) [-].
    """
    if model.labels.dimension == 2:
        return {}
    points = {line.element: line.points for line in drawn}
    directions: dict[str, np.ndarray] = {}
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        kinds = list(block.element.nodes.values())
        parts = [kind.part for kind in kinds]
        names = element_names(model, block)
        rectangular = [i for i, name in enumerate(names) if name in shapes and not shapes[name].round]
        ends_only = parts.count("position") == parts.count("rotation") == 2
        if not rectangular or not ends_only or "deformation" not in block.companions:
            continue
        axes, sides = _ends(block, properties, x, np.asarray(model.parameters.reference), rectangular)
        along = np.stack([points[names[i]] for i in rectangular])
        directions.update(zip((names[i] for i in rectangular), _carried(along, axes, sides), strict=True))
    return directions


def _ends(block: Block, properties: dict[str, Any], x: np.ndarray, reference: np.ndarray, rows: list[int]):
    """Local x and y axes at both ends of some elements, each (ends, elements, 3)."""
    index = np.asarray(block.x)[rows]
    kinds = list(block.element.nodes.values())
    p, q = coordinates_of_kind(kinds, block.splits, reference[index], "position")
    y = properties.get("y")
    curve = properties.get("curvature") if isinstance(properties.get("curvature"), CurvedLine) else None
    y, curve = jax.tree.map(lambda numbers: np.asarray(numbers)[rows], (y, curve))
    frames = np.asarray(_frames(p, q, y, curve))
    rotations, before = (
        coordinates_of_kind(kinds, block.splits, values[index], "rotation") for values in (x, reference)
    )
    turned = np.stack([turns_of(*pair) @ frame for *pair, frame in zip(rotations, before, frames, strict=True)])
    return turned[..., 0], turned[..., 1]


@jit
def _frames(
    p: Float[Array, "n 3"], q: Float[Array, "n 3"], y: Float[Array, "n 3"] | None, curve: CurvedLine | None
) -> Float[Array, "2 n 3 3"]:
    """Section axes in the undeformed mechanism, of both ends; of an arc both are those of its chord."""
    if curve is not None:
        return jnp.swapaxes(jax.vmap(frames_of_ends)(curve, q - p, y), 0, 1)
    frames = jax.vmap(initial_frame, (0, 0, None if y is None else 0))(p, q, y)
    return jnp.stack([frames, frames])


def _carried(
    points: Float[np.ndarray, "n places 3"], axes: Float[np.ndarray, "2 n 3"], sides: Float[np.ndarray, "2 n 3"]
) -> Float[np.ndarray, "n places 3"]:
    """Sides of the sections along lines, from the sides at the ends, (ends, n, 3)."""
    tangents = unit_vectors(np.gradient(points, axis=1, edge_order=2))
    # The ends of an arc are tilted, in its plane, against the axis that turns with them.
    first, last = (_bent(axes[i], tangents[:, at], sides[i]) for i, at in ((0, 0), (1, -1)))
    carried = (_along(tangents) @ first[:, None, :, None])[..., 0]
    sides_along = unit_vectors(carried - np.einsum("npi,npi->np", carried, tangents)[..., None] * tangents)
    end = tangents[:, -1]
    sine = np.einsum("ni,ni->n", _cross(sides_along[:, -1], last), end)
    twist = np.arctan2(sine, np.einsum("ni,ni->n", sides_along[:, -1], last))
    angle = twist[:, None] * np.linspace(0.0, 1.0, points.shape[1])
    others = _cross(tangents, sides_along)
    return unit_vectors(np.cos(angle)[..., None] * sides_along + np.sin(angle)[..., None] * others)


def _along(tangents: Float[np.ndarray, "n places 3"]) -> Float[np.ndarray, "n places 3 3"]:
    """Rotation from the first tangent of a line to each, one smallest rotation after the other."""
    start, end = tangents[:, :-1], tangents[:, 1:]
    axis, cosine = _cross(start, end), np.einsum("npi,npi->np", start, end)[..., None, None]
    steps = np.empty((*tangents.shape, 3))
    steps[:, 0] = np.eye(3)
    below = np.maximum(1 + cosine, OPPOSITE_TANGENTS)
    steps[:, 1:] = cosine * np.eye(3) + axis[..., :, None] * axis[..., None, :] / below
    # The matrix of the cross product.
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        steps[:, 1:, k, j] += axis[..., i]
        steps[:, 1:, j, k] -= axis[..., i]
    # Products of all steps up to each place, by doubling their reach.
    reach, count = 1, tangents.shape[1]
    while reach < count:
        steps[:, reach:] = steps[:, reach:] @ steps[:, :-reach]
        reach *= 2
    return steps


def _bent(
    start: Float[np.ndarray, "n 3"], end: Float[np.ndarray, "n 3"], vectors: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    """Vectors turned by the smallest rotation that takes one unit vector to another, made normal to the latter."""
    axis, cosine = _cross(start, end), np.einsum("ni,ni->n", start, end)[:, None]
    along = np.einsum("ni,ni->n", axis, vectors)[:, None] * axis
    turned = cosine * vectors + _cross(axis, vectors) + along / np.maximum(1 + cosine, OPPOSITE_TANGENTS)
    return unit_vectors(turned - np.einsum("ni,ni->n", turned, end)[:, None] * end)


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length one; zero stays zero."""
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(size > 0, size, 1.0)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """``np.cross`` of vectors in space, in a quarter of its time."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


# Stride of the corners of a strip among the places of a line.
STRIDE = 6


def strips(model: Model, x: np.ndarray, drawn: list[Line]) -> dict[str, Float[np.ndarray, "quads 4 d"]]:
    """Quadrilaterals of each element with an outline [m]: widths in space, thicknesses or diameters in the plane."""
    shapes = shapes_of(model)
    across = across_of(model, x, drawn, shapes)
    quads: dict[str, np.ndarray] = {}
    for line in drawn:
        shape = shapes.get(line.element)
        if shape is None or (model.labels.dimension == 3 and line.element not in across):
            continue
        points = line.points[::STRIDE]
        if model.labels.dimension == 3:
            side = shape.width / 2 * across[line.element][::STRIDE]
        else:
            tangents = unit_vectors(np.gradient(line.points, axis=0))[::STRIDE]
            side = shape.thickness / 2 * np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
        left, right = points + side, points - side
        quads[line.element] = np.stack([left[:-1], left[1:], right[1:], right[:-1]], axis=1)
    return quads
