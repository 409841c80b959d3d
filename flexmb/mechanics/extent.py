"""How large positions and rotations of a mechanism are, with which changes of coordinates are compared."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..model.parameters import Parameters
from ..model.topology import Topology


def extent_of(topology: Topology, parameters: Parameters) -> float:
    """Largest distance of the nodes along any axis, 1 where there is none, () [m]; of concrete numbers."""
    points = np.asarray(parameters.reference)[np.asarray(topology.axes)]
    return (float(np.max(np.ptp(points, axis=1))) if points.size else 0.0) or 1.0


def sizes_of(topology: Topology, parameters: Parameters) -> Any:
    """What a change of each coordinate is divided by, so that displacements and rotations can be compared.

    A displacement counts as a share of the mechanism's extent, and so does an elongation of a beam with strain series;
    a rotation counts in radians, an Euler parameter as it is, a warping in radians over the extent.

    Returns:
        The extent to the power of length in the unit of each coordinate, (n_x,) [m, -, 1/m]; outside a trace by NumPy,
        for which nothing is compiled.
    """
    if is_concrete((topology.axes, topology.powers, parameters.reference)):
        return extent_of(topology, parameters) ** np.asarray(topology.powers, float)
    points = parameters.reference[topology.axes]
    extent = jnp.max(jnp.max(points, axis=1) - jnp.min(points, axis=1)) if points.size else jnp.array(0.0)
    extent = jnp.where(extent > 0, extent, 1.0)
    return jnp.where(topology.powers > 0, extent, jnp.where(topology.powers < 0, 1 / extent, 1.0))
