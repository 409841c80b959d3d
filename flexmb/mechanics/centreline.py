"""Points along elements, computed by node kinds and the companion ``shape``."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..elements.nodes import NodeKind
from ..math.rotation import ROTATION
from ..model.topology import Block
from .blocks import element_function


def curves_of(
    block: Block, properties: dict[str, Any], reference: np.ndarray, x: np.ndarray, places: np.ndarray
) -> Float[np.ndarray, "elements places d"]:
    """Points along each element of a block: its ``shape``, or cubics or straight lines between its nodes."""
    index = np.asarray(block.x)
    at, ref = x[index], reference[index]
    kinds = list(block.element.nodes.values())
    options = dict(block.options)
    if block.element.shape is not None:
        named = block.element.arguments(block.element.shape, {**options, **properties})
        if named is not None:
            named_properties = {name: value for name, value in properties.items() if name in named}
            return np.asarray(_shapes(block, named_properties, *jax.device_put((ref, at, places))))
    points = coordinates_of_kind(kinds, block.splits, at, "position")
    if not points:
        return np.zeros((len(index), 0, 0))
    turns, before = (coordinates_of_kind(kinds, block.splits, values, "rotation") for values in (at, ref))
    if len(points) == len(turns) == 2:
        start, end = coordinates_of_kind(kinds, block.splits, ref, "position")
        axis = end - start
        slopes = [
            np.einsum("eij,ej->ei", turns_of(rotation, rotation_before), axis)
            for rotation, rotation_before in zip(turns, before, strict=True)
        ]
        return cubic(points[0], slopes[0], points[1], slopes[1], places)
    return _polyline(np.stack(points, axis=1), places)


@jit
def _shapes(
    block: Block,
    properties: dict[str, Any],
    ref: Float[Array, "elements c"],
    x: Float[Array, "elements c"],
    places: Float[Array, "places"],
) -> Float[Array, "elements places d"]:
    function: Any = element_function(block, block.element.shape, properties)

    def along(x: Float[Array, "c"], ref: Float[Array, "c"], element_properties: dict[str, Any]):
        return jax.vmap(lambda place: function(x, ref, element_properties, place=place))(places)

    return jax.vmap(along)(x, ref, properties)


def coordinates_of_kind(
    kinds: list[NodeKind], splits: tuple[int, ...], values: np.ndarray, part: str
) -> list[np.ndarray]:
    """Coordinates of the nodes of one kind, an array (elements, size) for each."""
    slices = np.split(values, splits, axis=1)
    return [piece for kind, piece in zip(kinds, slices, strict=True) if kind.part == part]


def turns_of(now: np.ndarray, before: np.ndarray) -> Float[np.ndarray, "elements d d"]:
    """Rotation matrices since the undeformed state."""
    if now.shape[1] == 1:
        c, s = np.cos(now - before)[:, 0], np.sin(now - before)[:, 0]
        return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=1)
    turned, first = (np.einsum("ijkl,ek,el->eij", _QUADRATIC, lam, lam) for lam in (now, before))
    return turned @ np.swapaxes(first, 1, 2)


_QUADRATIC = np.asarray(ROTATION)


def cubic(
    p: Float[np.ndarray, "elements d"],
    slope_p: Float[np.ndarray, "elements d"],
    q: Float[np.ndarray, "elements d"],
    slope_q: Float[np.ndarray, "elements d"],
    places: Float[np.ndarray, "places"],
) -> Float[np.ndarray, "elements places d"]:
    """Hermite's cubics through end positions with end slopes, as in the inertia of beams."""
    s = places
    weights = np.stack([1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2], axis=1)
    return np.einsum("sk,ked->esd", weights, np.stack([p, slope_p, q, slope_q]))


def _polyline(
    corners: Float[np.ndarray, "elements n d"], places: Float[np.ndarray, "places"]
) -> Float[np.ndarray, "elements #places d"]:
    """Straight lines from point to point; a single point stays."""
    count = corners.shape[1]
    if count == 1:
        return corners
    at = places * (count - 1)
    first = np.minimum(at.astype(int), count - 2)
    part = (at - first)[None, :, None]
    return (1 - part) * corners[:, first] + part * corners[:, first + 1]
