"""Controllers as feedback around a mechanism in a simulation."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import (
    as_floats,
    as_reals,
    check_number,
    check_numbers,
    check_real,
    is_concrete,
    numbers,
    returned,
    short_repr,
)
from ..checks.mobility import locked_inputs
from ..compilation.program import captured
from ..compilation.record import Record
from ..display import kind_of
from ..errors import ModelError, first_line, warn
from ..mechanics.signals import combined, terms_of
from ..model.model import MOTIONS, Model
from .controlled_form import Constant, ControlledForm, Feedback, PortPlaces, driven_by_inputs
from .controllers import Sampled, check_sizes, connected, controller_of, matrices_of
from .coordinates_form import CoordinatesForm

# With this number of coordinates a controlled motion takes tens of seconds: 1000 or more steps of 10 ms.
MANY = 60


class Loop(Record):
    """Controller around a mechanism in a simulation. :func:`simulate` accepts each attribute as a keyword too.

    Attributes:
        control: Controller from the model's outputs y to its inputs u: a ``control.StateSpace`` or proper
            ``control.TransferFunction``, continuous or sampled (with dt; its output is constant between samples); a
            function ``u = control(t, y)``; a :class:`Feedback` or a :class:`Sampled`, which functions of
            :mod:`flexmb.control` return. flexmb connects a system by name if it has the names of the model's inputs and
            outputs, otherwise by order.
        reference: Wanted outputs, as a function of time or constant: the controller reads reference - y. One value for
            each output of the model, in the order of the builder; or for each output that a system reads by name, in
            the order of its inputs. ``reference=0`` is zero for all outputs.
        sign: As for :func:`flexmb.control.closed_loop`, without a reference: 1 if the controller reads y, -1 if it
            reads -y, as with ``reference=0``. The default is 1; flexmb then warns if the controller is a linear system,
            for which negative feedback is usual.
    """

    control: Any = None
    reference: Callable | ArrayLike | None = None
    sign: Literal[1, -1] | None = None


# Functions of controllers.
FUNCTIONS = ("step", "output", "rate")


def with_reference_as_function(loop: Loop) -> Loop:
    """Loop whose reference is a function of time, or None with a sign; raise for a wrong reference or sign."""
    control, reference, sign = loop.control, loop.reference, loop.sign
    if sign is not None and (isinstance(sign, bool) or sign not in (-1, 1)):
        raise ValueError(f"Argument `sign` must be -1 or 1, but is {short_repr(sign)}.")
    if control is None:
        for name, value in (("reference", reference), ("sign", sign)):
            if value is not None:
                raise ValueError(f"Argument `{name}` needs a controller. Give `control` too.")
    if reference is None:
        return loop
    if sign == 1:
        raise ValueError("With a `reference`, the controller reads reference - y, which is sign=-1. Leave out `sign`.")
    if callable(reference):
        return dataclasses.replace(loop, sign=-1)
    if is_concrete(reference) and numbers(reference) is None:
        raise TypeError(
            "Argument `reference` must be a number, numbers, or a function of time that returns a number for each"
            f" output that the controller reads, such as lambda t: 1e-3, not {kind_of(reference)}."
        )
    check_numbers("Argument `reference`", reference)
    zero = np.ndim(reference) == 0 and is_concrete(reference) and float(np.asarray(reference)) == 0.0
    return dataclasses.replace(loop, reference=None if zero else Constant(as_floats(reference)), sign=-1)


def _seen(
    y: Float[Array, "n_y"], t: Float[Array, ""], places: Any, reference: Callable[..., Any] | None, sign: int
) -> Any:
    """Outputs at places, or their references minus these outputs."""
    read = y if places is None else y[places]
    if reference is None:
        return sign * read
    target = reference(t)
    if places is not None and target.shape == y.shape:
        target = target[places]
    if target.shape != read.shape:
        by_name = f", or for each of the {len(places)} outputs that the controller reads" if places is not None else ""
        raise ModelError(
            f"`reference` returns shape {target.shape}, but the mechanism has {y.shape[0]} outputs. Return one value"
            f" for each output, in the order of the builder{by_name}."
        )
    return target - read


def check_signals(model: Model, needs: str) -> None:
    """Raise ModelError for a mechanism without inputs or outputs, or an input that is a motion or moves nothing."""
    inputs, outputs = model.labels.inputs, model.labels.outputs
    if not inputs or not outputs:
        raise ModelError(f"{needs} needs an input and an output of the mechanism. Name them with input() and output().")
    for signal in inputs:
        moved = next((part for part in signal.terms if part.quantity in MOTIONS), None)
        if moved is not None:
            owner = (model.labels.e if moved.of_element else model.labels.x)[moved.index]
            raise ModelError(
                f"{needs} needs inputs that are forces, moments or stresses, but input '{signal.name}' is the"
                f" {moved.quantity} of {owner}, which is FIXED or PRESCRIBED. Leave it out, and prescribe the motion as"
                f" a function of time: prescribe() and motion={{'{owner}': f}}. Or let a force act on a heavy support"
                " that can move."
            )
    if is_concrete(model):
        for signal in locked_inputs(model):
            raise ModelError(
                f"Input '{signal.name}' (a {signal.quantity}) moves nothing, in any position of the mechanism. Let it"
                " act on a coordinate that can move, or leave it out."
            )


def as_feedback(model: Model, loop: Loop) -> Feedback | Sampled | None:
    """Feedback of a controller around a mechanism with named inputs and outputs; None without a controller."""
    control, reference = loop.control, loop.reference
    if control is None:
        return None
    inputs, outputs = ([s.name for s in signals] for signals in (model.labels.inputs, model.labels.outputs))
    check_signals(model, "A controller")
    moving = model.topology.n_x - model.topology.x.fixed.shape[0]
    if moving >= MANY:
        warn(
            f"A controller acts on a mechanism of {moving} coordinates: each step solves for all of them. A sudden"
            " action takes many steps, since it excites the stiffest elements. For fewer degrees of freedom use"
            " `fm.lean(model, bandwidth=...).model`. For small motions"
            " `control.feedback(fm.to_statespace(model, modes=...) * controller)` is faster still."
        )
    controller = controller_of(control)
    if hasattr(control, "D") or hasattr(control, "num"):
        check_sizes(control, inputs, outputs)
    if loop.sign is None and controller.reads is not None and _acts(control):
        warn(
            "The controller is a linear system without a reference: it reads y, so the feedback is positive, as in"
            " fm.control.closed_loop(model, controller, sign=1). For negative feedback, give `reference`, such as"
            " reference=0. If the controller must read y, give sign=1."
        )
    if reference is not None:
        reference_law: Any = reference
        reference = captured(
            lambda t: returned("Argument `reference`", reference_law(t)), jax.ShapeDtypeStruct((), jnp.float64)
        )
    sign = loop.sign or 1
    controller = connected(controller, inputs, outputs, lambda t, y, places: _seen(y, t, places, reference, sign))
    if isinstance(controller, Sampled):
        _check_sampled(controller, len(inputs), len(outputs))
    elif (controller.rate is None) != (controller.start is None):
        raise ModelError("A Feedback needs both `rate` and `start` of its states, or neither.")
    check_real("The `start` of the controller", controller.start, ModelError)
    # Names and windup are used before; left in, they would only split the compilation cache.
    plain = dataclasses.replace(controller, windup=None, reads=None, drives=None)
    return with_functions(plain, len(outputs), **{name: getattr(controller, name, None) for name in FUNCTIONS})


def _acts(control: Any) -> bool:
    """Whether a controller may have an output that is not zero."""
    if not hasattr(control, "D") and not hasattr(control, "num"):
        return True
    _, _, c, d = matrices_of(control)[0]
    return not is_concrete((c, d)) or bool(np.any(c) or np.any(d))


def with_functions(controller: Feedback | Sampled, count: int, **functions: Any):
    """Controller with other functions by name, captured at this call, for a number of outputs of the mechanism."""
    states = jnp.zeros(0) if controller.start is None else controller.start
    like = (jax.ShapeDtypeStruct((), jnp.float64), states, jax.ShapeDtypeStruct((count,), jnp.float64))
    existing = {name: f for name, f in functions.items() if getattr(controller, name, None) is not None}
    return dataclasses.replace(controller, **{name: captured(f, *like) for name, f in existing.items()})


def _check_sampled(control: Sampled, inputs: int, outputs: int) -> None:
    """Refuse a sampled controller without a period, or whose step does not return inputs and a state like its start."""
    check_number("period", control.period, above=0)
    start = jax.tree.map(lambda leaf: as_reals("The `start` of the controller", leaf, ModelError), control.start)
    try:
        result = jax.eval_shape(control.step, jnp.zeros(()), start, jnp.zeros(outputs))
    except Exception as fault:
        first = first_line(fault)
        raise ModelError(f"The step of the sampled controller cannot be computed, by jax.numpy: {first}") from fault
    if not isinstance(result, tuple) or len(result) != 2:
        raise ModelError("The step of the sampled controller must return the inputs and the next state.")
    check_real("The result of the step of the sampled controller", result, ModelError)
    shapes = [jax.tree.map(jnp.shape, part) for part in (start, result[1])]
    if jax.tree.structure(start) != jax.tree.structure(result[1]) or shapes[0] != shapes[1]:
        raise ModelError(f"The step of the sampled controller returns a state {shapes[1]}, but starts at {shapes[0]}.")
    u = jax.tree.map(jnp.shape, result[0])
    if u != (inputs,) and not (u == () and inputs == 1):
        raise ModelError(f"The controller returns shape {u}, but the mechanism has {inputs} inputs.")


def _nothing(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
    return jnp.zeros(0)


def _places(model: Model) -> PortPlaces:
    """Indices of coordinates and deformations on which inputs act and that outputs measure."""
    labels, weights = model.labels, model.parameters.weights
    indices: dict[str, list[tuple[int, ...]]] = {"force": [], "stress": [], "moment": [], "local moment": []}
    for place, signal in enumerate(terms_of(labels.inputs)):
        if signal.quantity in MOTIONS:
            # A prescribed motion follows such an input; its force is unknown.
            continue
        if signal.axis is None:
            indices[signal.quantity].append((signal.index, place))
        else:
            indices["local moment" if signal.local else "moment"].append((signal.index, place, signal.axis))
    outputs = terms_of(labels.outputs)

    def columns(kind: str, size: int):
        return jnp.asarray(np.array(indices[kind], int).reshape(-1, size).T)

    return PortPlaces(
        forces=columns("force", 2),
        stresses=columns("stress", 2),
        moments=columns("moment", 3),
        local_moments=columns("local moment", 3),
        outputs=jnp.array([s.index for s in outputs], int),
        axes=jnp.array([s.axis or 0 for s in outputs], int),
        read=None if weights is None else combined(labels.outputs, weights[1]),
        mix=None if weights is None else combined(labels.inputs, weights[0]).T,
        quantities=tuple(
            s.quantity if s.axis is None else ("local " if s.local else "") + TURNED[s.quantity] for s in outputs
        ),
        inputs=len(labels.inputs),
    )


# Quantity of an output about a rotation in space.
TURNED = {
    "position": "rotation",
    "velocity": "angular velocity",
    "acceleration": "angular acceleration",
    "reaction": "moment",
}


def under_inputs(model: Model, form: CoordinatesForm, u: Float[Array, "n_u"]) -> CoordinatesForm:
    """Equations of motion under given inputs."""
    return driven_by_inputs(form, _places(model), u) if u.shape[0] else form


def controlled_form(
    model: Model, form: CoordinatesForm, start: Float[Array, "n_x"] | None, feedback: Feedback | None = None
) -> ControlledForm:
    """A mechanism with sensors, actuators and a controller; rotations in space are measured from `start`."""
    whence = form.parameters.reference if start is None else start
    return ControlledForm(form, Feedback(_nothing) if feedback is None else feedback, _places(model), whence)
