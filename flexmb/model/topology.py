"""Structure of a model: shapes and element functions (static), connectivity and roles (integer arrays)."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from ..arguments import is_concrete
from ..compilation.record import Record, static
from ..elements.element import Element


class Block(Record):
    """Elements of equal type and equal property structure, stacked.

    Attributes:
        element: Their type, with its options.
        companions: Functions of the element that this block serves.
        options: Properties that select code (booleans, strings) without the annotation ``Static``, as sorted pairs.
        x: Index of each element's coordinates.
        e: Index of each element's deformations.
        splits: Places where the coordinates of the next node begin.
        meaning: Digests of user-defined functions when the model was built, by companion; None for the package's.
    """

    element: Element = static()
    companions: tuple[str, ...] = static()
    options: tuple[tuple[str, object], ...] = static()
    x: Int[Array, "elements coordinates"]
    e: Int[Array, "elements deformations"]
    splits: tuple[int, ...] = static()
    meaning: tuple[tuple[str, object], ...] | None = static(default=None)


class RoleIndices(Record):
    """Indices of the entries of x or e with each role, ascending; ``dof`` in the order of q."""

    fixed: Int[Array, "_f"]
    dependent: Int[Array, "_d"]
    dof: Int[Array, "_q"]
    prescribed: Int[Array, "_p"]

    @property
    def held(self) -> Int[Array, "_h"]:
        """Entries with a value from outside: FIXED, then PRESCRIBED."""
        return _joined(self.fixed, self.prescribed)

    @property
    def free(self) -> Int[Array, "_m"]:
        """Entries that can change: DEPENDENT, then DOF."""
        return _joined(self.dependent, self.dof)

    @property
    def given(self) -> Int[Array, "_g"]:
        """Entries that determine the DEPENDENT ones: FIXED, PRESCRIBED, then DOF."""
        return _joined(self.fixed, self.prescribed, self.dof)

    @property
    def size(self) -> int:
        """Number of entries with any role."""
        return sum(a.shape[0] for a in (self.fixed, self.dependent, self.dof, self.prescribed))


def _joined(*indices: Array) -> Any:
    """Indices of several roles in one array; by NumPy outside a trace, without compiling."""
    return (np if is_concrete(indices) else jnp).concatenate(indices)


class Topology(Record):
    """Structure of a mechanism. Compiled code depends only on its shapes and element functions.

    Attributes:
        blocks: Elements by block.
        x: Roles of the nodal coordinates.
        e: Roles of the deformations, including unit norms of Euler parameters.
        axes: Index of the coordinate along each axis of every point.
        powers: Power of length in the unit of each coordinate.
    """

    blocks: tuple[Block, ...]
    x: RoleIndices
    e: RoleIndices
    axes: Int[Array, "axes points"]
    powers: Int[Array, "n_x"]

    @property
    def n_x(self) -> int:
        """Number of nodal coordinates, Euler parameters counted as four."""
        return self.x.size

    @property
    def n_e(self) -> int:
        """Number of deformations, unit norms included."""
        return self.e.size

    @property
    def n_q(self) -> int:
        """Number of degrees of freedom."""
        return self.x.dof.shape[0] + self.e.dof.shape[0]

    @property
    def counts_turns(self) -> bool:
        """Whether a deformation is an angle that counts full turns from its value at the last state."""
        return any(block.element.tracks_angle for block in self.blocks)
