"""A constraint between the deformations of several elements: weighted sums that are FIXED at zero."""

import functools
from typing import Annotated, Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .element import Element
from .nodes import NodeKind, Reference


class TiePart(NamedTuple):
    """Tied elements of one type.

    Attributes:
        element: Their type.
        options: Properties that select code, as sorted pairs.
        splits: Indices at which the coordinates of the next node begin.
        rows: Indices of the coordinates of each element among the coordinates of the tie.
    """

    element: Element
    options: tuple[tuple[str, object], ...]
    splits: tuple[int, ...]
    rows: tuple[tuple[int, ...], ...]


def _part_deformations(part: TiePart, x: Float[Array, "n_x"], ref: Float[Array, "n_x"], properties: dict[str, Any]):
    """Deformations of the elements of a part, (elements, n)."""

    def one(x: Float[Array, "c"], ref: Float[Array, "c"], values: dict[str, Any]):
        at, start = (jnp.split(vector, part.splits) for vector in (x, ref))
        named: dict[str, Any] = part.element.arguments(part.element.deformation, {**dict(part.options), **values}) or {}
        return part.element.deformation(*at, ref=part.element.reference(start), **named)

    rows = jnp.array(part.rows)
    return jax.vmap(one)(x[rows], ref[rows], properties)


@functools.cache
def tie(parts: tuple[TiePart, ...], size: int, dimension: int) -> Element:
    """Element type whose deformations are weighted sums of the deformations of other elements.

    It has one node with all coordinates of those elements, and two properties: ``weights``, (n, m), for the m
    deformations of one part after the other, and ``of``, the properties of the elements of each part.
    """
    everything = NodeKind("Coordinates", "internal", dimension, (0.0,) * size, ("c",) * size, size)

    def tied(
        coordinates: Annotated[Float[Array, "_n"], everything],
        *,
        ref: Reference,
        weights: Float[Array, "n m"],
        of: tuple,
    ) -> Float[Array, "n"]:
        """Weighted sums of deformations. Returns (n,) [m, rad]. Source: Definition."""
        deformations = [
            _part_deformations(part, coordinates, ref[0], properties).ravel()
            for part, properties in zip(parts, of, strict=True)
        ]
        return weights @ jnp.concatenate(deformations)

    return Element(tied)
