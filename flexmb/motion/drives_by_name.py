"""Loads, inputs and prescribed motion as functions of time, by name."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import check_numbers, check_real, is_concrete, short_repr
from ..checks.mobility import locked_inputs
from ..compilation.program import Captured, captured, captured_of_time
from ..compilation.record import Record
from ..display import among
from ..elements.element import Element
from ..errors import ModelError, first_line
from ..mechanics.blocks import heat_sizes
from ..mechanics.loads import warn_of_increment
from ..model.by_name import turn_of
from ..model.model import Labels, Model, Signal
from .drive import MOMENTS, Driven, Table, has_table


class Drives(Record):
    """Functions of time in a simulation. :func:`simulate` accepts each attribute as a keyword too.

    Attributes:
        loads: Loads as functions of time, by name; they add to constant loads. A :class:`Table` is a piecewise linear
            function. Names and values are:

            - "tip.x": force at a coordinate [N]; "leaf.e2": stress resultant added at a deformation;
            - "tip": force components at a node, (axes,) [N]; "tip.rotation": moment about global axes [N m];
            - "leaf.temperature": change of temperature, or (2,) for both ends [K]; "leaf.gradient": gradient across it
              [K/m]. Both need :meth:`flexmb.Builder.temperature`.
        motion: Values of PRESCRIBED coordinates, rotations and deformations, by names such as "tip.x", "tip.rotation"
            or "leaf.e1"; twice differentiable functions of time. The value of a coordinate is its displacement from
            its start.
        inputs: Named inputs of the model (forces, moments, stresses) as functions of time. They add to loads and to a
            controller's inputs.
        increment: Factor of the incremental loads as a function of time; zero by default.
        jumps: Times at which loads jump or bend, (k,) [s]. flexmb knows the times of tables, and finds pulses that are
            at least 1/10000 of the whole time long. Name the times of shorter pulses, and of pulses whose numbers
            ``jax.jit`` traces. To differentiate by the time of a jump, name this time. If you do not name it, the
            derivative is zero, and flexmb warns. Under ``jax.jit`` it does not warn.
    """

    loads: Mapping[str, Callable] | None = None
    motion: Mapping[str, Callable] | None = None
    inputs: Mapping[str, Callable] | None = None
    increment: Callable | None = None
    jumps: ArrayLike | None = None


def acted_on(model: Model, driven: tuple[Driven, ...]) -> set[int] | None:
    """Coordinates that forces and moments may act on, apart from weight; None for all."""
    top, loads = model.topology, model.parameters.loads
    at: list[Any] = [block.x for block in top.blocks if block.element.force is not None]
    at += [drive.at for drive in driven if drive.quantity in ("force", *MOMENTS)]
    if model.parameters.increment is not None or not is_concrete((at, loads.force)):
        return None
    if loads.force is not None:
        at.append(np.flatnonzero(np.asarray(loads.force)))
    return {int(i) for indices in at for i in np.asarray(indices).ravel()}


def jump_times(drives: Drives, driven: tuple[Driven, ...]) -> Float[Array, "k"] | None:
    """Ascending times at which loads jump or bend; None without any. Raise ValueError for wrong `jumps`."""
    # Times of bends carry no derivative: the motion does not depend on where steps end.
    tables = (drive.value for drive in driven if isinstance(drive.value, Table))
    kinks = [jax.lax.stop_gradient(jnp.asarray(table.times, float)) for table in tables]
    if drives.jumps is not None:
        check_numbers("Argument `jumps`", drives.jumps)
        jumps = jnp.asarray(drives.jumps, float)
        if jumps.ndim != 1:
            raise ValueError(f"Argument `jumps` must be a list of times, not {short_repr(drives.jumps)}.")
        kinks.append(jumps)
    return jnp.sort(jnp.concatenate(kinks)) if kinks else None


def driven_by(model: Model, drives: Drives) -> tuple[Driven, ...]:
    """Functions of time with the indices that they drive; raise ModelError for unknown or wrong names."""
    loads, motion, inputs = (
        {} if functions is None else functions for functions in (drives.loads, drives.motion, drives.inputs)
    )
    for argument, functions in (("loads", loads), ("motion", motion), ("inputs", inputs)):
        if not isinstance(functions, Mapping):
            raise ModelError(
                f"Argument `{argument}` must be a dictionary of names and functions, not {short_repr(functions)}."
            )
    driven = [_load(model, name, value) for name, value in loads.items()]
    moved: dict[tuple[str, int], str] = {}
    for name, value in motion.items():
        quantity, place, value = _prescribed(model, name, value)
        first = moved.setdefault((quantity, place), name)
        if first != name:
            raise ModelError(f"Motions '{first}' and '{name}' drive the same coordinate. Give one of them.")
        driven.append(Driven(quantity, jax.device_put(np.array([place])), value))
    _check_inputs(model, inputs)
    weights, count = model.parameters.weights, 0
    for number, signal in enumerate(model.labels.inputs):
        if signal.name in inputs:
            function = _function(f"Input '{signal.name}'", inputs[signal.name], 1)
            parts = []
            for place, term in enumerate(signal.terms, count):
                weight = None if weights is None or not signal.parts else weights[0][place]
                parts.append(_input(term, function, weight))
            driven += [dataclasses.replace(parts[0], of_input=number, given=function), *parts[1:]]
        count += len(signal.terms)
    if drives.increment is not None:
        incremental = model.parameters.increment
        if incremental is None:
            raise ModelError("The model has no incremental loads for `increment` to scale. Give them increment=True.")
        if incremental.gravity is not None:
            raise ModelError("Gravity among the incremental loads does not change with time. Make it a constant load.")
        factor = _function("Argument `increment`", drives.increment, 1)
        driven.append(Driven("increment", jnp.zeros(0, int), factor))
    return tuple(driven)


def warn_of_left_out(model: Model, driven: tuple[Driven, ...], function: str) -> None:
    """Warn of incremental loads that a prescribed motion neither scales nor replaces."""
    more = model.parameters.increment
    if more is None or not is_concrete((model, [drive.at for drive in driven])):
        return
    left_out = any("incremental" in dict(block.options) for block in model.topology.blocks)
    left_out |= any(getattr(more, name) is not None for name in ("force", "gravity", "prestress", "temperature"))
    for kind, values in (("x", more.x), ("e", more.e)):
        places = [np.asarray(drive.at) for drive in driven if drive.quantity == kind]
        moved = [] if values is None else np.flatnonzero(np.asarray(values))
        left_out |= not np.all(np.isin(moved, np.concatenate([np.zeros(0), *places])))
    if left_out:
        warn_of_increment(model, function)


def _load(model: Model, name: str, value: Any) -> Driven:
    """A load by the name of a coordinate, a deformation, a node, a rotation in space, or a temperature."""
    labels = model.labels
    nodes, subject = labels.coordinates(name), f"Load '{name}'"
    if (place := labels.place(name)) is not None:
        _check_acts(model, subject, place[0], [place[1]])
    if (turned := labels.rotation_of(name)) is not None:
        indices, axis = turned
        _check_acts(model, subject, "x", indices)
        for holding in labels.holding(str(name)):
            _check_acts(model, subject, "e", [holding])
        return _input(Signal(str(name), "moment", indices[0], axis), _function(subject, value, 1), None)
    if place is not None:
        kind, index = place
        return Driven("force" if kind == "x" else "stress", jnp.array([index]), _function(subject, value, 1))
    element, _, quantity = str(name).rpartition(".")
    if not nodes and quantity in ("temperature", "gradient") and element in [name for name, *_ in labels.elements]:
        return _warmed(model, int(labels.deformations(element)[0]), element, quantity, subject, value)
    if not nodes:
        known = among(labels.names(), str(name))
        raise ModelError(f"{subject} names no coordinate, deformation or node. There are: {known}.")
    _check_acts(model, subject, "x", nodes)
    spatial = labels.dimension == 3 and labels.x[nodes[0]].kind == "rotation"
    value = _function(subject, value, 3 if spatial else len(nodes))
    return Driven("moment" if spatial else "force", jnp.array(nodes), value)


def _check_acts(model: Model, load: str, kind: str, indices: list[int]) -> None:
    """Refuse a load on FIXED coordinates or deformations."""
    if is_concrete(model.topology) and set(indices) <= set(np.asarray(getattr(model.topology, kind).fixed).tolist()):
        raise ModelError(
            f"{load} acts on a FIXED coordinate or deformation and has no effect. Let it act on one that can move, or"
            " leave it out."
        )


def _check_inputs(model: Model, inputs: Mapping[str, Any]) -> None:
    """Refuse unknown inputs, and inputs that can move nothing."""
    known = [signal.name for signal in model.labels.inputs]
    for name in inputs:
        if name not in known:
            hint = f"There are: {among(known, name)}." if known else "The model has none: name them with input()."
            raise ModelError(f"Argument `inputs` names '{name}', which is no input of the model. {hint}")
    for signal in model.labels.inputs:
        moved = next((term for term in signal.terms if term.order is not None), None)
        if signal.name in inputs and moved is not None:
            owner = (model.labels.e if moved.of_element else model.labels.x)[moved.index]
            raise ModelError(
                f"Input '{signal.name}' is the {moved.quantity} of {owner}, which is FIXED or PRESCRIBED. Argument"
                " `inputs` accepts forces, moments and stresses. Call prescribe() for it in the builder, and give"
                f" motion={{'{owner}': f}}."
            )
    if not inputs or not is_concrete(model):
        return
    for signal in locked_inputs(model):
        if signal.name in inputs:
            raise ModelError(f"Input '{signal.name}' moves nothing, in any position of the mechanism. Leave it out.")


def _input(signal: Signal, value: Any, weight: Any) -> Driven:
    """An input, or one part of an actuator with its weight, as a function of time."""
    if weight is not None and isinstance(value, Table):
        value = Table(value.times, weight * jnp.asarray(value.values, float))
    elif weight is not None:
        value = captured(lambda t, function=value: weight * function(t), jax.ShapeDtypeStruct((), float))
    if signal.axis is None:
        return Driven(signal.quantity, jnp.array([signal.index]), value)
    about = jnp.eye(3)[signal.axis]
    if isinstance(value, Table):
        value = Table(value.times, jnp.reshape(jnp.asarray(value.values, float), (-1, 1)) * about)
    else:
        value = captured(
            lambda t, function=value: jnp.reshape(function(t), ()) * about, jax.ShapeDtypeStruct((), float)
        )
    kind = "local moment" if signal.local else "moment"
    return Driven(kind, signal.index + jnp.arange(4), value)


def _warmed(model: Model, first: int, element: str, quantity: str, subject: str, value: Any) -> Driven:
    """A change of temperature of an element, or its gradient across; `first` is its first deformation."""
    if element not in model.labels.warm:
        raise ModelError(
            f"{subject}: the element has no temperature. Call temperature('{element}', 0.0) in the builder."
        )
    block = next(b for b in model.topology.blocks if "thermal" in b.companions and first in np.asarray(b.e)[:, 0])
    sizes = heat_sizes(block.element)
    if quantity == "gradient" and len(sizes) == 1:
        raise ModelError(f"{subject}: an element of type {block.element.name} does not bend.")
    fixed_indices = set(np.asarray(model.topology.e.fixed).tolist()) - {
        first + n for n in range(_closure(block.element))
    }
    row = np.asarray(block.e)[np.asarray(block.e)[:, 0] == first][0]
    if has_table(value) and not fixed_indices.isdisjoint(row.tolist()):
        raise ModelError(
            f"{subject} is a table, but deformations of the element are FIXED. Their velocity would jump. Give a smooth"
            " function of time."
        )
    columns = np.arange(2) if quantity == "temperature" else 2 + np.arange(sizes[1])
    numbers = _function(subject, value, len(columns), one_for_all=quantity == "temperature")
    return Driven("temperature", jnp.array([np.full(len(columns), first), columns]), numbers)


def _closure(element: Element) -> int:
    """Number of deformations before the strain fields of an element; they are zero at any temperature."""
    return min((field[0] for field in element.fields), default=1) - 1


def _prescribed(model: Model, name: str, value: Any):
    """Kind ("x" or "e"), place among the PRESCRIBED ones, and the function of time of a prescribed motion."""
    labels, topology, subject = model.labels, model.topology, f"Motion '{name}'"
    place = labels.place(_rotation_prescribed(labels, name))
    if place is not None:
        kind, index = place
        order = np.asarray(getattr(topology, kind).prescribed).tolist()
        if index not in order:
            raise ModelError(f"{subject} is not PRESCRIBED. Call prescribe() for it in the builder.")
        if has_table(value):
            raise ModelError(f"{subject} is a table. Its velocity jumps. Give a smooth function of time.")
        return kind, order.index(index), _function(subject, value, 1)
    node, _, component = str(name).rpartition(".")
    if labels.rotation_of(name) is not None:
        raise ModelError(f"{subject} is not PRESCRIBED. Call prescribe('{node}', '{component}') in the builder.")
    if labels.coordinates(name) and labels.x[labels.coordinates(name)[0]].kind == "rotation":
        call = f"prescribe('{name.removesuffix('.rotation')}', \"rotation\", axis=..)"
        raise ModelError(f"{subject} is not PRESCRIBED. Call {call} in the builder.")
    prescribed = [
        str(entries[i])
        for entries, roles in ((labels.x, topology.x), (labels.e, topology.e))
        for i in np.asarray(roles.prescribed).tolist()
    ]
    hint = (
        f"PRESCRIBED are: {among(prescribed, name)}."
        if prescribed
        else "Nothing is PRESCRIBED. Call prescribe() first."
    )
    raise ModelError(f"{subject} names no coordinate or deformation. {hint}")


def _rotation_prescribed(labels: Labels, name: str) -> str:
    """Name of the prescribed angle of a rotation: a coordinate in the plane, a hinge's deformation in space."""
    indices = labels.coordinates(name)
    if not indices or labels.x[indices[0]].kind != "rotation":
        return name
    if labels.dimension == 2:
        return f"{name}.{labels.x[indices[0]].symbol}"
    return f"{turn_of(name)}.e1"


def _function(subject: str, value: Any, size: int, one_for_all: bool = False) -> Captured | Table:
    """A function of time as it is now, with as many numbers as it drives, or one for all if allowed."""
    if not callable(value):
        raise ModelError(f"{subject} must be a function of time, such as lambda t: 3.0, not {short_repr(value)}.")
    if isinstance(value, Table):
        _check_table(subject, value)
    try:
        function, shape = captured_of_time(value)
    except Exception as fault:
        first = first_line(fault)
        raise ModelError(f"{subject} cannot be computed as a function of time, by jax.numpy: {first}") from fault
    if shape != (size,) and not ((size == 1 or one_for_all) and shape == ()):
        expected = "one number" if size == 1 else f"{size} numbers, one for each component"
        expected = f"one number, or {size}, one for each end" if one_for_all else expected
        raise ModelError(f"{subject} must return {expected}, but returns shape {shape}.")
    return function


def _check_table(subject: str, table: Table) -> None:
    check_real(f"{subject}, a table,", table, ModelError)
    if not is_concrete(table):
        return
    times, values = np.asarray(table.times), np.asarray(table.values)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise ModelError(f"{subject}: the times of a table must be finite and ascending, two at least.")
    if values.ndim < 1 or len(values) != len(times):
        raise ModelError(f"{subject}: a table needs as many values as times, {len(times)}, not {np.shape(values)[:1]}.")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{subject}: the values of a table must be finite.")
