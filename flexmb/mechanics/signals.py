"""Inputs and outputs: their rows in the coordinates, and rotations about axes in space."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..math.indices import put
from ..math.rotation import lbar, lbody, rotation_since
from ..model.model import Signal

# Order of the time derivative that an output measures, of coordinates and of deformations.
ORDERS = {"position": 0, "velocity": 1, "acceleration": 2}
DEFORMATION_ORDERS = {"deformation": 0, "deformation rate": 1, "deformation acceleration": 2}


def rotation_row(lam: Float[Array, "4"], axis: Any, local: bool) -> Float[Array, "4"]:
    """Rotation rate about an axis per change of Euler parameters; its transpose is the force of a unit moment.

    Source: omega = 2 Lbar d(lambda)/dt, f = 2 Lbar^T M (THEORY.md 5, eq. (5.7)), with L for axes of the body.
    """
    return 2 * (lbody if local else lbar)(lam)[axis]


def along_coordinates(signal: Signal, x: Float[Array, "n_x"]) -> tuple[Any, Any]:
    """Indices of the coordinates of a signal, and its derivatives by them."""
    if signal.axis is None:
        return np.array([signal.index]), np.ones(1)
    parameters = signal.index + np.arange(4)
    return parameters, rotation_row(x[parameters], signal.axis, signal.local)


def input_row(
    signal: Signal, x: Float[Array, "n_x"], dfx: Float[Array, "n_x n_q"], dfe: Float[Array, "n_e n_q"]
) -> Float[Array, "n_q"]:
    """Generalised force of a unit input: DFx^T of a force, -DFe^T of a stress added to sigma; THEORY.md 6 and 7."""
    if signal.quantity == "stress":
        return -dfe[signal.index]
    indices, row = along_coordinates(signal, x)
    return row @ dfx[indices]


def terms_of(signals: tuple[Signal, ...]) -> tuple[Signal, ...]:
    """Terms of all inputs or outputs, in order."""
    return tuple(term for s in signals for term in s.terms)


def combined(signals: tuple[Signal, ...], weights: Any) -> Float[Array, "n terms"]:
    """Weight of each term in each signal."""
    counts = [len(s.terms) for s in signals]
    rows: Any = np.repeat(np.arange(len(counts)), counts)
    ones: Any = np.ones(len(rows)) if weights is None else weights
    places = rows, np.arange(len(rows))
    if not is_concrete(ones):
        return put(jnp.zeros((len(counts), len(rows))), places, ones)
    weight: Any = np.zeros((len(counts), len(rows)))
    weight[places] = ones
    return weight


def rotation_measured(
    lam: Float[Array, "4"], start: Float[Array, "4"], reference: Float[Array, "4"], axis: Any, local: bool
) -> Float[Array, ""]:
    """Rotation about an axis as a sensor measures it [rad].

    This is a component of the rotation vector from the undeformed mechanism to the start, plus one from the start to
    now. It is the angle about a fixed axis, and the linearised rotation to first order about the start.
    """
    return rotation_since(start, lam, local)[axis] + rotation_since(reference, start, local)[axis]
