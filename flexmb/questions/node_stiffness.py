"""Stiffness of a node along an axis, with all other motions free: "stiffness top.y"."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit, unguarded
from ..linear.about import linearized
from ..linear.compliance import compliance, compliance_of, compliance_of_large
from ..linear.linearize import Linearization, Matrices
from ..model.model import Model
from .question import Question, by_component, components_of, each_linearization, is_many, node_and_component


@unguarded
def stiffness(model: Model | Linearization, node: str, axis: str, *, local: bool = False) -> Float[Array, ""]:
    """Return the force on a node over its displacement along an axis, with all other motions free.

    Along the motion of the mechanism this is the drive stiffness, across it the support stiffness. For the stiffness at
    a stroke, pass ``fm.linearize(model, increment=1.0)``, or a model whose drive is prescribed.

    Args:
        model: Mechanism, or its linearisation.
        node: Name of the node.
        axis: "x", "y", "z"; "phi" for the rotation in the plane; "rx", "ry", "rz" for rotations in space.
        local: Use axes that turn with the node instead of global axes.

    Returns:
        () [N/m or N m/rad].

    Raises:
        KeyError: The node does not exist.
        ValueError: The axis does not exist.

    Source:
        Inverse of the diagonal entry of :func:`flexmb.compliance`.
    """
    lin, node = linearized(model, "stiffness"), str(node)
    flexibility = compliance(lin, node, local=local)
    axes = components_of(lin.labels, node)
    if axis not in axes:
        raise ValueError(f"Node '{node}' has no axis {axis!r}: it is one of {', '.join(map(repr, axes))}.")
    i = axes.index(axis)
    return 1 / flexibility[i, i]


def _stiffness(state: Any, argument: str) -> Any:
    node, axis = node_and_component(argument)
    if not is_many(state) and not (isinstance(state, Linearization) and state.large):
        return stiffness(state, node, axis)
    axes, places = (
        components_of(state.labels, node),
        tuple(state.labels.known(part) for part in state.labels.parts(node)),
    )
    if axis not in axes:
        raise KeyError(f"node '{node}' has no component '{axis}' here; it has {', '.join(axes)}")
    at = axes.index(axis)
    if isinstance(state, Linearization):
        return 1 / compliance_of_large(state, places)[at, at]
    if state.by_sparse:
        flexibility = np.array([compliance_of_large(lin, places)[at, at] for lin in each_linearization(state)])
    else:
        flexibility = np.asarray(_compliances(state.linearizations().matrices, places))[:, at, at]
    with np.errstate(divide="ignore"):
        return 1 / flexibility


@jit
def _compliances(found: Matrices, parts: Any) -> Float[Array, "states n n"]:
    """Compliance at a node in every state; in space a rotation is about the global axes."""
    return jax.vmap(lambda m: compliance_of(m, parts, local=False)[0])(found)


QUESTIONS = (Question("stiffness", ("node", "axis"), _stiffness, by_component("N/m", "N m/rad"), of_many=True),)
