"""Answers that designs are asked for, where no analysis is called so already."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..analysis.compliance import compliance
from ..analysis.linearize import Linearization
from ..mechanics.inertia import mass_matrix, uniform_motion
from ..model.model import Model

AXES = {2: ("x", "y", "phi"), 3: ("x", "y", "z", "rx", "ry", "rz")}


def mass(model: Model) -> Float[Array, ""]:
    """Mass of the whole mechanism, distributed mass included.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.

    Returns:
        () [kg].

    Source:
        Twice the kinetic energy of a uniform unit velocity.
    """
    topology, parameters = model.topology, model.parameters
    along = jnp.asarray(uniform_motion(topology, np.eye(model.labels.dimension)[0]))
    return along @ mass_matrix(topology, parameters, parameters.reference) @ along


def stiffness(model: Model | Linearization, node: str, axis: str, *, local: bool = False) -> Float[Array, ""]:
    """Force on a node over its displacement along an axis, all else free to follow.

    The drive stiffness along the motion; across it the support stiffness. At a stroke, give
    ``fm.linearize(model, increment=1.0)``, or a model whose drive is prescribed.

    Args:
        model: Mechanism, or its linearisation.
        node: Name of the node.
        axis: "x", "y", "z"; "phi" for the rotation in the plane, "rx", "ry", "rz" for those in space.
        local: In axes that turn with the node instead of the global ones.

    Returns:
        () [N/m or N m/rad].

    Raises:
        KeyError: No such node.
        ValueError: No such axis.

    Source:
        Inverse of the diagonal entry of :func:`flexmb.compliance`.
    """
    labels = model.labels
    found = compliance(model, node, local=local)
    alone = labels.x[labels.coordinates(node)[0]].kind == "rotation"
    axes = AXES[labels.dimension][-found.shape[0] :] if alone else AXES[labels.dimension][: found.shape[0]]
    if axis not in axes:
        raise ValueError(f"Node '{node}' has no axis '{axis}': it is one of {', '.join(axes)}.")
    i = axes.index(axis)
    return 1 / found[i, i]
