"""What inputs do and what outputs measure: rows in the coordinates, and rotations about axes in space."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..math.indices import put
from ..math.rotation import lbar, lbody, rotation_since
from ..model.model import Signal

# How often what an output measures is differentiated by time, of coordinates and of deformations.
ORDERS = {"position": 0, "velocity": 1, "acceleration": 2}
DEFORMATION_ORDERS = {"deformation": 0, "deformation rate": 1, "deformation acceleration": 2}


def rotation_row(lam: Float[Array, "4"], axis: Any, local: bool) -> Float[Array, "4"]:
    """Infinitesimal rotation, or angular velocity, about an axis, by the change of Euler parameters.

    Its transpose is the force dual to them of a unit moment about that axis. Returns (4,) [rad]. Source: omega = 2 Lbar
    d(lambda)/dt, f = 2 Lbar^T M (THEORY.md 5, eq. (5.7)); with L for axes of the body.
    """
    return 2 * (lbody if local else lbar)(lam)[axis]


def along_coordinates(signal: Signal, x: Float[Array, "n_x"]) -> tuple[Any, Any]:
    """Coordinates that a signal is about, and its derivative by them. Returns indices, (k,), and row, (k,)."""
    if signal.axis is None:
        return np.array([signal.index]), np.ones(1)
    own = signal.index + np.arange(4)
    return own, rotation_row(x[own], signal.axis, signal.local)


def input_row(
    signal: Signal, x: Float[Array, "n_x"], dfx: Float[Array, "n_x n_q"], dfe: Float[Array, "n_e n_q"]
) -> Float[Array, "n_q"]:
    """Generalised force of a unit input. Source: THEORY.md 6 and 7: forces by DFx^T, a stress adds to sigma: -DFe^T."""
    if signal.quantity == "stress":
        return -dfe[signal.index]
    own, row = along_coordinates(signal, x)
    return row @ dfx[own]


def terms_of(signals: tuple[Signal, ...]) -> tuple[Signal, ...]:
    """What inputs or outputs are made of, those of each after those of the one before."""
    return tuple(term for s in signals for term in s.terms)


def combined(signals: tuple[Signal, ...], weights: Any) -> Float[Array, "n terms"]:
    """Weight of each term in each signal."""
    counts = [len(s.terms) for s in signals]
    rows: Any = np.repeat(np.arange(len(counts)), counts)
    ones: Any = np.ones(len(rows)) if weights is None else weights
    places = rows, np.arange(len(rows))
    if not is_concrete(ones):
        return put(jnp.zeros((len(counts), len(rows))), places, ones)
    whole: Any = np.zeros((len(counts), len(rows)))
    whole[places] = ones
    return whole


def rotation_measured(
    lam: Float[Array, "4"], start: Float[Array, "4"], reference: Float[Array, "4"], axis: Any, local: bool
) -> tuple[Float[Array, ""], Float[Array, "4"]]:
    """Rotation about an axis as a sensor gives it, and its derivative by the Euler parameters.

    It is a component of the rotation vector from the undeformed mechanism to the start, plus that from the start to
    now: about a fixed axis the angle itself, about the start to first order that of the linearised equations. Returns
    () [rad] and (4,) [rad].
    """

    def since(lam: Float[Array, "4"]):
        return rotation_since(start, lam, local)[axis]

    value, slope = jax.value_and_grad(since)(lam)
    return value + rotation_since(reference, start, local)[axis], slope
