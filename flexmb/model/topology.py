"""Structure of a model (roles, connectivity, element functions), its numbers, and the scales of its coordinates."""

import enum
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import is_concrete
from ..compilation.record import Record, static
from ..elements.element import Element


class Role(enum.Enum):
    """Role of a coordinate or deformation (THEORY.md 1).

    FIXED: a coordinate at its start value, a deformation at zero or its thermal value. DEPENDENT: follows from the
    others ("released" for a deformation). DOF: a degree of freedom. PRESCRIBED: a given value.
    """

    FIXED = "fixed"
    DEPENDENT = "dependent"
    DOF = "dof"
    PRESCRIBED = "prescribed"


# Roles of known values.
HELD = (Role.FIXED, Role.PRESCRIBED)


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


class Loads(Record):
    """Constant loads. Loads that a scene does not have are None and are not traced.

    Attributes:
        force: Nodal forces dual to the coordinates, (n_x,) [N, N m].
        gravity: Acceleration of gravity, (axes,) [m/s^2].
        prestress: Stress resultants in addition to elastic ones, (n_e,) [N, N m].
        x: Values of the PRESCRIBED coordinates, in their order [m, rad].
        e: Values of the PRESCRIBED deformations, in their order [m, rad].
        temperature: Change of temperature of elements, in the row of the first deformation of each, (n_e, 3 or 4):
            at its first and last end [K], then gradients along the section's local y and z, in the plane z alone [K/m].
    """

    force: Float[Array, "n_x"] | None = None
    gravity: Float[Array, "axes"] | None = None
    prestress: Float[Array, "n_e"] | None = None
    x: Float[Array, "_p"] | None = None
    e: Float[Array, "_p"] | None = None
    temperature: Float[Array, "n_e _t"] | None = None


class Parameters(Record):
    """Numbers of a mechanism; a pytree to differentiate, batch and optimise.

    Attributes:
        reference: Nodal coordinates of the undeformed mechanism, (n_x,) [m, rad, -].
        properties: Properties of each block, every leaf stacked over its elements.
        loads: Constant loads.
        increment: Loads that a path or a buckling analysis scales while ``loads`` stay; None: all loads are scaled.
        strain: Deformations without stress, (n_e,), or None: zero.
        start: Degrees of freedom and their rates at the start of a simulation, twice (n_q,), or None: zero.
        weights: Weights of the terms of all inputs, and of all outputs, in their order, or None: one each.
        prepared: Within a compiled kernel, results of elements that depend on reference and properties alone, by block
            (:func:`flexmb.mechanics.prepared.kernel`); None elsewhere.
    """

    reference: Float[Array, "n_x"]
    properties: tuple[dict[str, Any], ...]
    loads: Loads
    increment: Loads | None = None
    strain: Float[Array, "n_e"] | None = None
    start: tuple[Float[Array, "n_q"], Float[Array, "n_q"]] | None = None
    weights: tuple[Float[Array, "_k"], Float[Array, "_l"]] | None = None
    prepared: tuple[Any, ...] | None = None


def extent_of(topology: Topology, parameters: Parameters) -> float:
    """Largest distance of nodes along any axis, or 1 if zero [m]; of concrete numbers."""
    points = np.asarray(parameters.reference)[np.asarray(topology.axes)]
    return (float(np.max(np.ptp(points, axis=1))) if points.size else 0.0) or 1.0


def coordinate_scales(topology: Topology, parameters: Parameters) -> Any:
    """Scales of all coordinates [m, -, 1/m]: the extent to the power of length in the unit of each coordinate.

    A displacement or an elongation of a beam with strain series counts as a share of the extent, a rotation in radians,
    a warping in radians over the extent. Computed by NumPy outside a trace, without compiling.
    """
    if is_concrete((topology.axes, topology.powers, parameters.reference)):
        return extent_of(topology, parameters) ** np.asarray(topology.powers, float)
    points = parameters.reference[topology.axes]
    extent = jnp.max(jnp.max(points, axis=1) - jnp.min(points, axis=1)) if points.size else jnp.array(0.0)
    extent = jnp.where(extent > 0, extent, 1.0)
    return jnp.where(topology.powers > 0, extent, jnp.where(topology.powers < 0, 1 / extent, 1.0))
