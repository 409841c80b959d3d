"""What a change of each coordinate is measured against."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..math.indices import put
from ..model.parameters import Parameters
from ..model.topology import Topology


def sizes_of(topology: Topology, parameters: Parameters) -> Float[Array, "n_x"]:
    """What a change of each coordinate is measured against: the mechanism's extent for positions, 1 for rotations.

    Args:
        topology: Structure.
        parameters: Numbers.

    Returns:
        (n_x,) [m, -].
    """
    points = parameters.reference[topology.axes]
    extent = jnp.max(jnp.max(points, axis=1) - jnp.min(points, axis=1)) if points.size else jnp.array(0.0)
    extent = jnp.where(extent > 0, extent, 1.0)
    return put(jnp.ones(topology.n_x), topology.axes, extent)
