"""Compliance of the mechanism at its nodes, about the static equilibrium."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..elements.nodes import ROTATION3
from ..math.compile import jit
from ..math.linear import factorise
from ..math.rotation import lbar, rotation_matrix
from ..model.model import Model
from .linearize import Linearization, Matrices, linearize


def _rates(coordinates: Float[Array, "n"]) -> Float[Array, "m n"]:
    """Matrix from rates of a node's coordinates to its velocity or angular velocity about global axes."""
    return 2 * lbar(coordinates) if coordinates.shape[0] == ROTATION3.size else jnp.eye(coordinates.shape[0])


@jit
def _flexibility(found: Matrices):
    return factorise(found.K).solve(found.DFx.T)


def compliance(model: Model | Linearization, node: str, *, local: bool = False) -> Float[Array, "n n"]:
    """Displacements and rotations of a node under unit forces and moments on it.

    Args:
        model: Mechanism, or its linearisation.
        node: Name of the node. A position with a rotation "name.rotation" gives both.
        local: In axes that turn with the node instead of the global ones; needs a rotation.

    Returns:
        u = C f with u = (displacements, rotations) and f = (forces, moments): (3, 3) in the plane, (6, 6) in space,
        or the node's own coordinates if it has no rotation [m/N, rad/N, m/(N m), rad/(N m)].

    Raises:
        KeyError: No such node.

    Source:
        FORMULATION.md 7: (K0 + N0 + G0)^-1 through DFx; rotations by omega = 2 Lbar d(lambda)/dt.
    """
    lin = model if isinstance(model, Linearization) else linearize(model)
    labels = lin.labels
    parts = [p for p in (node, f"{node}.rotation") if labels.coordinates(p)]
    if not parts:
        raise KeyError(f"no node '{node}' in this model")
    return _compliance(lin.matrices, tuple(np.array(labels.coordinates(part)) for part in parts), local=local)


@jit
def _compliance(found: Matrices, parts: tuple[Int[Array, "_n"], ...], local: bool) -> Float[Array, "n n"]:
    rows = [_rates(found.x[part]) @ found.DFx[part] for part in parts]
    if local:
        rotation = found.x[parts[-1]]
        if rotation.shape[0] == ROTATION3.size:
            rows = [rotation_matrix(rotation).T @ row for row in rows]
        elif len(parts) == 2:
            c, s = jnp.cos(rotation[0]), jnp.sin(rotation[0])
            rows[0] = jnp.array([[c, s], [-s, c]]) @ rows[0]
    jacobian = jnp.concatenate(rows)
    return jacobian @ factorise(found.K).solve(jacobian.T)


def directional_compliance(model: Model | Linearization) -> dict[str, np.ndarray]:
    """Displacement of every node along each axis under a unit force along that axis.

    Args:
        model: Mechanism, or its linearisation.

    Returns:
        For each node: one value a coordinate [m/N]; three rotations about global axes, or the angle [rad/(N m)].

    Source:
        Diagonal of DFx (K0 + N0 + G0)^-1 DFx^T, with rotations by omega = 2 Lbar d(lambda)/dt.
    """
    lin = model if isinstance(model, Linearization) else linearize(model)
    flexibility, dfx = np.asarray(_flexibility(lin.matrices)), np.asarray(lin.matrices.DFx)
    found = {}
    for node in dict.fromkeys(entry.of for entry in lin.labels.x):
        indices = lin.labels.coordinates(node)
        axes = np.asarray(_rates(lin.matrices.x[np.array(indices)]))
        found[node] = np.diagonal(axes @ dfx[indices] @ flexibility[:, indices] @ axes.T)
    return found
