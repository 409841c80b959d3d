"""Which model and which coordinates a picture is of."""

from typing import Any

import jax.core
import numpy as np
from jaxtyping import Float

from ..linear.linearize import Linearization
from ..model.model import Model
from ..motion.motion import Motion
from ..paths.path import Path
from .geometry import nodes_of


def state_of(shown: Any, at: Any = None, step: int | None = None, time: float | None = None):
    """Model and coordinates of what is to be drawn.

    Args:
        shown: Model, Linearization, Path or Motion.
        at: Where it is an equilibrium, configuration or linearisation of the model; with a Model only.
        step: Which step of a path, or number of a time; the last unless given.
        time: Time of a motion; the output time nearest to it [s].

    Returns:
        Model, and x (n_x,) [m, rad, -].

    Raises:
        TypeError: ``shown`` or ``at`` is none of these; or is traced.
        ValueError: ``at`` is no state of the model, step or time is out of range or has no meaning here.
    """
    if isinstance(shown, Model):
        source: Any = None if at is None else at.matrices if isinstance(at, Linearization) else at
        if source is not None and not hasattr(source, "x"):
            raise TypeError(f"Argument `at` must be a state of the model such as an equilibrium, but is a {_kind(at)}.")
        model, x = shown, shown.parameters.reference if source is None else source.x
    elif isinstance(shown, Linearization | Path):
        model, x = shown.model, shown.matrices.x
    elif isinstance(shown, Motion):
        model, x = shown.model, shown.x
    else:
        raise TypeError(
            "A picture is drawn of a Model (with at= for an equilibrium or configuration), a Linearization, a Path or"
            f" a Motion, not of a {_kind(shown)}."
        )
    if at is not None and not isinstance(shown, Model):
        raise ValueError(f"Argument `at` goes with a Model; a {_kind(shown)} says itself where it is.")
    if isinstance(x, jax.core.Tracer):
        raise TypeError("A picture takes concrete numbers: draw it outside jax.jit and jax.grad.")
    x = np.asarray(x, float)
    if x.shape[-1] != model.topology.n_x:
        raise ValueError(
            f"Argument `at` must be a state of this model, which has {model.topology.n_x} coordinates, but its x has"
            f" shape {x.shape}."
        )
    return model, _one(shown, x, step, time)


def _kind(value: Any) -> str:
    return type(value).__name__


def _one(shown: Any, x: np.ndarray, step: int | None, time: float | None) -> Float[np.ndarray, "n_x"]:
    """One of several states."""
    if time is not None:
        if not isinstance(shown, Motion) or step is not None:
            raise ValueError("Argument `time` goes with a Motion, and without `step`.")
        times = np.asarray(shown.t)
        if not times[0] <= time <= times[-1]:
            raise ValueError(f"Argument `time` must be from {times[0]:g} to {times[-1]:g} s, but is {time:g}.")
        step = int(np.argmin(np.abs(times - time)))
    if x.ndim == 1:
        if step is not None:
            raise ValueError(f"Argument `step` goes with a Path or a Motion; this {_kind(shown)} is one state.")
        return x
    step = -1 if step is None else step
    if not -len(x) <= step < len(x):
        raise ValueError(f"Argument `step` must be below {len(x)}, the number of states, but is {step}.")
    return x[step]


def checked(scale: float) -> float:
    """A factor of displacements.

    Args:
        scale: The factor.

    Raises:
        ValueError: It is not finite.
    """
    if not np.isfinite(scale):
        raise ValueError(f"Argument `scale` must be a finite number, but is {scale}.")
    return scale


def displaced(
    model: Model, x: Float[np.ndarray, "n_x"], scale: float = 1.0, base: Float[np.ndarray, "n_x"] | None = None
) -> Float[np.ndarray, "n_x"]:
    """Coordinates with displacements multiplied.

    Args:
        model: Mechanism.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        scale: Factor; Euler parameters are brought back to unit norm.
        base: Coordinates that displacements are counted from, (n_x,); by default those of the undeformed mechanism.

    Returns:
        (n_x,) [m, rad, -].
    """
    if checked(scale) == 1:
        return x
    base = np.asarray(model.parameters.reference) if base is None else base
    moved = base + scale * (x - base)
    for indices in nodes_of(model, "rotation").values():
        if len(indices) == 4:
            moved[indices] /= np.linalg.norm(moved[indices])
    return moved
