"""Node kinds: what an element's positional parameters are annotated with.

An annotation such as ``Point2`` carries a :class:`NodeKind`; an element function's signature is read for it, so
that the signature is the element's only declaration.
"""

import dataclasses
from typing import Annotated, Any, TypeVar

import jax.numpy as jnp
from jaxtyping import Array, Float


@dataclasses.dataclass(frozen=True)
class NodeKind:
    """What one kind of node is.

    Attributes:
        name: Name as it appears in messages.
        part: Which part of a named node it is, "position", "rotation" or "warping"; "internal" for coordinates that an
            element owns.
        dimension: 2 in the plane, 3 in space.
        start: Coordinates before a position is given.
        components: Name of each coordinate.
        freedoms: Independent coordinates, the number that (2.13) counts: 3 of 4 for Euler parameters.
        powers: Of length, in the unit of each coordinate; of none unless given.
    """

    name: str
    part: str
    dimension: int
    start: tuple[float, ...]
    components: tuple[str, ...]
    freedoms: int
    powers: tuple[int, ...] = ()

    def sized(self, count: int, powers: tuple[int, ...] = ()) -> "NodeKind":
        """The kind with so many coordinates, all of them free and zero at the start."""
        names = tuple(f"c{i + 1}" for i in range(count))
        return dataclasses.replace(self, start=(0.0,) * count, components=names, freedoms=count, powers=powers)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.start)


POINT2 = NodeKind("Point2", "position", 2, (0.0, 0.0), ("x", "y"), 2, (1, 1))
ANGLE = NodeKind("Angle", "rotation", 2, (0.0,), ("phi",), 1)
POINT3 = NodeKind("Point3", "position", 3, (0.0, 0.0, 0.0), ("x", "y", "z"), 3, (1, 1, 1))
ROTATION3 = NodeKind("Rotation3", "rotation", 3, (1.0, 0.0, 0.0, 0.0), ("l0", "l1", "l2", "l3"), 3)
# By how much the sections of the beams that meet there warp: their twist rate there [rad/m].
WARPING = NodeKind("Warping", "warping", 3, (0.0,), ("w",), 1, (-1,))

Point2 = Annotated[Float[Array, "2"], POINT2]
Angle = Annotated[Float[Array, "1"], ANGLE]
Point3 = Annotated[Float[Array, "3"], POINT3]
Rotation3 = Annotated[Float[Array, "4"], ROTATION3]
Warping = Annotated[Float[Array, "1"], WARPING]


# Coordinates that an element owns, coefficients of its strains; the builder makes a node of them, "element.internal".
# How many there are the element's options say, see :attr:`flexmb.Element.series`.
SERIES2 = NodeKind("Internal", "internal", 2, (), (), 0)
SERIES3 = NodeKind("Internal", "internal", 3, (), (), 0)

Series2 = Annotated[Float[Array, "_n"], SERIES2]
Series3 = Annotated[Float[Array, "_n"], SERIES3]
# Coordinates of an element in the undeformed mechanism, under the names of its positional parameters: ``ref.p`` beside
# ``p``. Which there are its signature says, so that no one type has them all.
Reference = Any

STATIC = "static"
Kind = TypeVar("Kind")
Static = Annotated[Kind, STATIC]
"""Annotation of an option, ``order: Static[int] = 5``: any hashable value, which chooses code and is no number."""


def unit_norm(rotation: Rotation3, *, ref: Reference) -> Float[Array, "1"]:
    """Excess of the squared norm of Euler parameters: the constraint every spatial rotational node brings along.

    Returns (1,) [-], zero for a unit norm. Source: Definition.
    """
    return (rotation @ rotation - 1.0)[None]


def length(vector: Float[Array, "d"]) -> Float[Array, ""]:
    """Euclidean length, () [m]; not for a vector that may vanish (its derivative is not finite there).

    Returns () [m].
    """
    return jnp.sqrt(vector @ vector)
