"""Parameters of a mechanism: its numbers as the user states them; differentiable."""

from typing import Any

from jaxtyping import Array, Float

from ..compilation.record import Record


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
            (:func:`flexmb.mechanics.blocks.kernel`); None elsewhere.
    """

    reference: Float[Array, "n_x"]
    properties: tuple[dict[str, Any], ...]
    loads: Loads
    increment: Loads | None = None
    strain: Float[Array, "n_e"] | None = None
    start: tuple[Float[Array, "n_q"], Float[Array, "n_q"]] | None = None
    weights: tuple[Float[Array, "_k"], Float[Array, "_l"]] | None = None
    prepared: tuple[Any, ...] | None = None
