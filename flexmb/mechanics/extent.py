"""Sizes of positions and rotations of a mechanism, used to scale changes of coordinates."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..model.parameters import Parameters
from ..model.topology import Topology


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
