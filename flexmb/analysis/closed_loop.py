"""Controllers around a mechanism: python-control systems and functions, as feedback for a simulation."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial
from jaxtyping import Array

from ..errors import ModelError
from ..math.program import captured
from ..math.record import Record, static
from ..mechanics.controlled_form import ControlledForm, Feedback, driven_by_inputs
from ..mechanics.coordinates_form import CoordinatesForm
from ..model.model import Model

MEASURED = ("position", "velocity", "deformation", "deformation rate")


class Sampled(Record):
    """A controller that acts at equal intervals from the start of the simulation; its output is held in between.

    Attributes:
        step: ``u, z_next = step(t, z, y)``: inputs of the mechanism, (n_u,) [N, N m], from its outputs at the
            sample, in the order in which the builder named them.
        period: Interval [s].
        start: State at the start, (n_z,).
    """

    step: Callable[..., Any]
    period: float = static()
    start: Any = ()


def _seen(y, t, reference):
    return y if reference is None else jnp.atleast_1d(jnp.asarray(reference(t), float)) - y


def _linear_output(c, d, reference, t, z, y):
    return c @ z + d @ _seen(y, t, reference)


def _linear_rate(a, b, reference, t, z, y):
    return a @ z + b @ _seen(y, t, reference)


def _static_output(function, reference, t, z, y):
    return function(t, _seen(y, t, reference))


def _sampled_step(a, b, c, d, reference, t, z, y):
    seen = _seen(y, t, reference)
    return c @ z + d @ seen, a @ z + b @ seen


def as_feedback(model: Model, control: Any, reference: Callable | None) -> Feedback | Sampled:
    """Feedback of a controller given as python-control system, function or Feedback.

    Args:
        model: Mechanism with named inputs and outputs.
        control: See :func:`flexmb.simulate`.
        reference: Wanted outputs as a function of time, or None.

    Raises:
        ModelError: No inputs or outputs, sizes that do not agree, a sampled controller without an interval, an output
            that cannot be fed back.
    """
    inputs, outputs = model.labels.inputs, model.labels.outputs
    if not inputs or not outputs:
        raise ModelError(
            "A controller needs an input and an output of the mechanism: name them with input() and output()."
        )
    for signal in outputs:
        if signal.quantity not in MEASURED:
            raise ModelError(
                f"Output '{signal.name}' is a {signal.quantity} and cannot be fed back. Feed back one of:"
                f" {', '.join(MEASURED)}."
            )
    if isinstance(control, Feedback | Sampled):
        if reference is not None:
            raise ModelError(f"A {type(control).__name__} has its reference inside: leave `reference` out.")
        return _now(control, len(outputs))
    if reference is not None:
        reference = captured(reference, jax.ShapeDtypeStruct((), jnp.float64))
    if hasattr(control, "A") and hasattr(control, "D"):
        period = getattr(control, "dt", 0)
        if period is True:
            raise ModelError("The controller is sampled, but says not how often: give it dt in seconds.")
        a, b, c, d = (jnp.asarray(np.asarray(getattr(control, name)), float) for name in "ABCD")
        if d.shape != (len(inputs), len(outputs)):
            raise ModelError(
                f"The controller has {d.shape[1]} inputs and {d.shape[0]} outputs, but the mechanism has {len(outputs)}"
                f" outputs ({', '.join(s.name for s in outputs)}) and {len(inputs)} inputs"
                f" ({', '.join(s.name for s in inputs)})."
            )
        start = jnp.zeros(a.shape[0])
        if period:
            return Sampled(Partial(_sampled_step, a, b, c, d, reference), float(period), start)
        return Feedback(Partial(_linear_output, c, d, reference), Partial(_linear_rate, a, b, reference), start)
    if callable(control):
        return _now(Feedback(Partial(_static_output, control, reference)), len(outputs))
    raise ModelError("Argument `control` must be a control.StateSpace, a function u = f(t, y), a Feedback or Sampled.")


def _now(controller: Feedback | Sampled, count: int):
    """A controller as it is now, for so many outputs of the mechanism."""
    states = jnp.zeros(0) if controller.start is None else controller.start
    like = (jax.ShapeDtypeStruct((), jnp.float64), states, jax.ShapeDtypeStruct((count,), jnp.float64))
    names = ("step",) if isinstance(controller, Sampled) else ("output", "rate")
    functions = {name: getattr(controller, name) for name in names}
    taken = {name: captured(f, *like) for name, f in functions.items() if f is not None}
    return dataclasses.replace(controller, **taken)


def _nothing(t, z, y):
    return jnp.zeros(0)


def _places(model: Model) -> tuple[Array, Array]:
    """Index of what each input acts on, and its place among the inputs: forces, then stresses, (2, k) each."""
    pairs: dict[str, list[tuple[int, int]]] = {"force": [], "stress": []}
    for place, signal in enumerate(model.labels.inputs):
        pairs[signal.quantity].append((signal.index, place))
    forces, stresses = (jnp.array(pairs[kind], int).reshape(-1, 2).T for kind in ("force", "stress"))
    return forces, stresses


def under_inputs(model: Model, form: CoordinatesForm, u) -> CoordinatesForm:
    """Equations of motion under given inputs.

    Args:
        model: Mechanism.
        form: Its equations of motion.
        u: Inputs, (n_u,), or (0,) for none.
    """
    forces, stresses = _places(model)
    return driven_by_inputs(form, forces, stresses, u) if u.shape[0] else form


def controlled_form(model: Model, form: CoordinatesForm, feedback: Feedback) -> ControlledForm:
    """Equations of motion of a mechanism with a controller.

    Args:
        model: Mechanism.
        form: Its equations of motion.
        feedback: Controller.
    """
    return dataclasses.replace(measuring(model, form), feedback=feedback)


def measuring(model: Model, form: CoordinatesForm) -> ControlledForm:
    """A mechanism with its sensors and actuators, whose inputs nothing gives.

    Args:
        model: Mechanism.
        form: Its equations of motion.
    """
    forces, stresses = _places(model)
    outputs = model.labels.outputs
    indices = jnp.array([s.index for s in outputs], int)
    return ControlledForm(form, Feedback(_nothing), forces, stresses, indices, tuple(s.quantity for s in outputs))
