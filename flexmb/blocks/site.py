"""Assembly of a building block: its axes, its bodies, and the leaf springs between them."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, holds, is_concrete, nan_if_refused
from ..build.assemble import stack
from ..build.builder import Builder
from ..build.given import name_text, number_list
from ..elements import planar, spatial
from ..elements.sections import Circle, Profile, Rectangle, Scalar, Section
from ..errors import ModelError
from ..numerical_limits import SHORTEST_DIRECTION

Vector = Sequence[Scalar] | Float[Array, "d"]
# A body, by the node of its rotation, and a point of it: along, across and, in space, along the width.
End = tuple[str, tuple[Scalar, ...]]


class Site:
    """A block under construction.

    Points have coordinates along its leaf springs, across them in the plane of motion, and along their width.

    Attributes:
        base: Name of the node that carries the block.
        stage: Name of the node that the block carries.
        name: Name of the block, which begins the names of its nodes and elements.
    """

    def __init__(
        self,
        b: Builder,
        base: str,
        stage: str,
        name: str,
        at: Vector | None,
        along: Vector | None,
        y: Vector | None,
        element: Any,
        **sizes: Any,
    ):
        with nan_if_refused() as marked:
            for size, value in sizes.items():
                check_number(size, value, above=0, fault=ModelError)
        self.b, self.name, self.element = b, name_text("A block", name), element
        self.base, self.stage = name_text("A node", base), name_text("A node", stage)
        self._check_position(self.base)
        if self.base not in b.nodes:
            similar = difflib.get_close_matches(self.base, b.nodes, 1)
            hint = f"Did you mean '{similar[0]}'?" if similar else "Add it with node() first."
            raise ModelError(f"No node '{self.base}' (base of block '{name}'). {hint}")
        if self.base == self.stage:
            raise ModelError(f"Block '{name}' joins node '{base}' to itself. Give it two nodes.")
        self._check_position(self.stage)
        # Origin of all nodes of the block.
        self.origin = marked(stack(b.nodes[self.base].start) if at is None else self._vector("at", at))
        self._set_axes(along, y)

    def _check_position(self, node: str) -> None:
        if node in self.b.nodes and self.b.nodes[node].kind.part != "position":
            raise ModelError(f"Node '{node}' of block '{self.name}' has no position: it is a rotation.")

    def _vector(self, argument: str, vector: Vector) -> Any:
        values = number_list(f"Argument `{argument}` of block '{self.name}'", vector)
        if len(values) != self.b.dimension:
            raise ModelError(
                f"Argument `{argument}` of block '{self.name}' must have {self.b.dimension} components, but has"
                f" {len(values)}."
            )
        return stack(values)

    def _set_axes(self, along: Vector | None, y: Vector | None) -> None:
        """Unit vectors along the leaf springs, across them and, in space, along their width."""
        plane = self.b.dimension == 2
        if plane and y is not None:
            raise ModelError(f"Argument `y` of block '{self.name}' is for mechanisms in space.")
        direction = (0.0, 1.0, 0.0)[: self.b.dimension] if along is None else along
        first = self._unit("along", self._vector("along", direction))
        if plane:
            self.y, self.axes = None, stack([first, stack([first[1], -first[0]])])
            return
        width = self._vector("y", (0.0, 0.0, 1.0) if y is None else y)
        self.y = self._unit("y", width - (width @ first) * first)
        across = np.cross(first, self.y) if is_concrete((first, self.y)) else jnp.cross(first, self.y)
        self.axes = stack([first, across, self.y])

    def _unit(self, argument: str, vector: Any) -> Any:
        size = (vector @ vector) ** 0.5
        with nan_if_refused() as marked:
            if not holds(size >= SHORTEST_DIRECTION):
                problem = "has no length" if argument == "along" else "must not be parallel to `along`"
                raise ModelError(f"Argument `{argument}` of block '{self.name}' {problem}.")
            return marked(vector / size)

    def place(self, *coordinates: Scalar) -> Any:
        """A point of the block in global axes; missing coordinates are zero."""
        return sum((c * axis for c, axis in zip(coordinates, self.axes, strict=False)), self.origin)

    def body(self, node: str, *coordinates: Scalar) -> str:
        """A node, made at a place unless it exists; returns its name."""
        if node not in self.b.nodes:
            self.b.node(node, self.place(*coordinates))
        return node

    def inner(self, label: str, *coordinates: Scalar) -> str:
        """A node of the block; returns its name."""
        node = f"{self.name} {label}"
        if node in self.b.nodes:
            raise ModelError(
                f"Block '{self.name}' exists already, with node '{node}'. Give each block a name of its own."
            )
        return self.body(node, *coordinates)

    def clamp(self, label: str, end: End) -> str:
        """A node at a point of a body, rigidly attached to it; returns its name."""
        body, coordinates = end
        node = self.inner(label, *coordinates)
        rigid = planar.rigid_beam if self.b.dimension == 2 else spatial.rigid_beam
        self.b.add(rigid, body, f"{body}.rotation", node, name=f"{node} clamp")
        return node

    def leaf(self, label: str, first: End, last: End, section: Section) -> None:
        """A leaf spring between points of two bodies, clamped to both."""
        p, q = (self.clamp(f"{end} {label}", at) for end, at in (("foot", first), ("top", last)))
        self.beam(f"leaf {label}", (p, first[0]), (q, last[0]), *self.leaf_spring(section))

    def beam(self, label: str, first: tuple[str, str], last: tuple[str, str], element: Any, section: Section) -> None:
        """A flexible beam between two nodes, each with the node of its rotation."""
        across = {} if self.y is None else {"y": self.y}
        nodes = [part for node, body in (first, last) for part in (node, f"{body}.rotation")]
        self.b.add(element, *nodes, name=f"{self.name} {label}", section=section, **across)

    def leaf_spring(self, section: Section) -> tuple[Any, Section]:
        """Element type and section of a leaf spring; a beam for sections that jump or have no width."""
        smooth = isinstance(section, Rectangle) or (isinstance(section, Profile) and not section.breaks)
        if self.element is not None or not smooth:
            return self.slender(section)
        if self.b.dimension == 3:
            return spatial.leaf_spring, section
        return planar.leaf_spring(shear=isinstance(section, Rectangle) and section.shear), section

    def slender(self, section: Section) -> tuple[Any, Section]:
        """Element type and section of a wire or a notch hinge, with shear if possible."""
        if self.element is not None:
            return self.element, section
        if isinstance(section, Profile):
            # Stress resultants along a hinge are smooth although the section is not; order 3 suffices at any stroke.
            return self.spectral_beam(order=3), section
        if isinstance(section, Rectangle | Circle):
            return self.spectral_beam(shear=True), dataclasses.replace(section, shear=True)
        return self.spectral_beam, section

    @property
    def spectral_beam(self) -> Any:
        """Element type of a spectral beam."""
        return planar.spectral_beam if self.b.dimension == 2 else spatial.spectral_beam
