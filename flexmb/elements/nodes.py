"""Node kinds: annotations of an element's positional parameters.

An annotation such as ``Point2`` contains a :class:`NodeKind`. The signature of an element function is the only
declaration of the element.
"""

import dataclasses
from typing import Annotated, Any, TypeVar

import jax.numpy as jnp
from jaxtyping import Array, Float


@dataclasses.dataclass(frozen=True)
class NodeKind:
    """A kind of node.

    Attributes:
        name: Name in messages.
        part: Part of a named node: "position", "rotation" or "warping"; "internal" for coordinates that an element
            owns.
        dimension: 2 in the plane, 3 in space.
        start: Default coordinates.
        components: Name of each coordinate.
        freedoms: Number of independent coordinates in (2.13): 3 of 4 for Euler parameters.
        powers: Power of length in the unit of each coordinate. Empty: zero for all.
    """

    name: str
    part: str
    dimension: int
    start: tuple[float, ...]
    components: tuple[str, ...]
    freedoms: int
    powers: tuple[int, ...] = ()

    def sized(self, count: int, powers: tuple[int, ...] = ()) -> "NodeKind":
        """The kind with ``count`` coordinates, all free and zero by default."""
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
# Warping of the sections of the beams that meet in the node: their twist rate there [rad/m].
WARPING = NodeKind("Warping", "warping", 3, (0.0,), ("w",), 1, (-1,))

Point2 = Annotated[Float[Array, "2"], POINT2]
Angle = Annotated[Float[Array, "1"], ANGLE]
Point3 = Annotated[Float[Array, "3"], POINT3]
Rotation3 = Annotated[Float[Array, "4"], ROTATION3]
Warping = Annotated[Float[Array, "1"], WARPING]


# Coordinates that an element owns, the coefficients of its strains. The builder makes a node of them,
# "element.internal". Their number depends on the element's options, see :attr:`flexmb.Element.series`.
SERIES2 = NodeKind("Internal", "internal", 2, (), (), 0)
SERIES3 = NodeKind("Internal", "internal", 3, (), (), 0)

Series2 = Annotated[Float[Array, "_n"], SERIES2]
Series3 = Annotated[Float[Array, "_n"], SERIES3]
# Coordinates of an element in the undeformed mechanism, by the names of its positional parameters: ``ref.p`` for ``p``.
# Each element type has its own, so that no static type lists them.
Reference = Any

STATIC = "static"
Kind = TypeVar("Kind")
Static = Annotated[Kind, STATIC]
"""Annotation of an option, ``order: Static[int] = 5``: any hashable value that selects code and is no number."""


def unit_norm(rotation: Rotation3, *, ref: Reference) -> Float[Array, "1"]:
    """Squared norm of Euler parameters minus one, the constraint of every spatial rotational node.

    Returns (1,) [-], zero for a unit norm. Source: Definition.
    """
    return (rotation @ rotation - 1.0)[None]


def length(vector: Float[Array, "d"]) -> Float[Array, ""]:
    """Euclidean length of a nonzero vector (the derivative at zero is not finite).

    Returns () [m].
    """
    return jnp.sqrt(vector @ vector)
