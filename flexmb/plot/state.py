"""Model and coordinates of a picture."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ..arguments import is_concrete
from ..display import Result, States, kind_of
from ..model.model import Model
from .geometry import nodes_of


def states_of(shown: Any, at: Any = None) -> States:
    """States of the result to be drawn, in concrete numbers; ``at`` is the state of a Model."""
    if not is_concrete((shown, at)):
        raise TypeError("A picture needs concrete numbers: draw it outside jax.jit and jax.grad.")
    states = shown.states() if isinstance(shown, Result) else None
    if states is None:
        known = "a Model (with at= for a configuration), an Equilibrium with its model, a Linearization, a Path"
        raise TypeError(f"A picture needs {known} or a Motion, not {kind_of(shown)}.")
    if at is not None and states.model is not shown:
        raise ValueError(f"Argument `at` needs a Model; {kind_of(shown)} has its own state.")
    if at is not None and not hasattr(at, "x"):
        raise TypeError(f"Argument `at` must be a state of the model such as an equilibrium, but is {kind_of(at)}.")
    x = np.asarray(states.x if at is None else at.x, float)
    n_x, labels = states.model.topology.n_x, getattr(at, "labels", None)
    if labels is not None and labels.x != states.model.labels.x:
        raise ValueError("Argument `at` belongs to another model: its nodes have other names.")
    if at is not None and x.shape != (n_x,):
        what = f"a state of this model, which has {n_x} coordinates"
        raise ValueError(f"Argument `at` must be {what}, but its x has shape {x.shape}.")
    return states._replace(x=x)


def state_of(
    shown: Any, at: Any = None, step: int | None = None, time: float | None = None
) -> tuple[Model, Float[np.ndarray, "n_x"]]:
    """Model and coordinates of the result to be drawn, at a step or a time."""
    states = states_of(shown, at)
    if time is not None:
        if states.kind != "motion" or step is not None:
            raise ValueError("Argument `time` needs a Motion, and no `step`.")
        times = np.asarray(states.along)
        if not times[0] <= time <= times[-1]:
            raise ValueError(f"Argument `time` must be from {times[0]:g} to {times[-1]:g} s, but is {time:g}.")
        step = int(np.argmin(np.abs(times - time)))
    if states.x.ndim == 1:
        if step is not None:
            raise ValueError(f"Argument `step` needs a Path or a Motion; this {type(shown).__name__} is one state.")
        return states.model, states.x
    step = -1 if step is None else step
    if not -len(states.x) <= step < len(states.x):
        raise ValueError(f"Argument `step` must be below {len(states.x)}, the number of states, but is {step}.")
    return states.model, states.x[step]


def checked_factor(scale: float) -> float:
    """A factor of displacements. Raises ValueError: It is not finite."""
    if not np.isfinite(scale):
        raise ValueError(f"Argument `scale` must be a finite number, but is {scale}.")
    return scale


def displaced(
    model: Model, x: Float[np.ndarray, "n_x"], scale: float = 1.0, base: Float[np.ndarray, "n_x"] | None = None
) -> Float[np.ndarray, "n_x"]:
    """Coordinates with displacements multiplied, from ``base`` or the undeformed mechanism on, (n_x,) [m, rad, -]."""
    if checked_factor(scale) == 1:
        return x
    base = np.asarray(model.parameters.reference) if base is None else base
    moved = base + scale * (x - base)
    for indices in nodes_of(model, "rotation").values():
        if len(indices) == 4:
            moved[indices] /= np.linalg.norm(moved[indices])
    return moved
