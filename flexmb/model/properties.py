"""Replacement of numbers of a model's elements, all at once, without building the model again."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import check_numbers, is_concrete, nan_if_refused, short_repr
from ..elements.sections import Rectangle
from ..errors import ModelError
from .topology import Parameters

# Sizes of a rectangle, whose changes along leaf springs in line are steps.
SIZES = ("width", "thickness")


class _Stack(NamedTuple):
    """Elements whose properties are stacked together; ``kind`` is the number of their kind of section, if several."""

    block: int
    kind: int | None
    names: list[str]
    properties: dict[str, Any]


def with_property(model: Any, path: str, values: Any, elements: Sequence[str] | None) -> Parameters:
    """Parameters with other numbers for a property; see :meth:`flexmb.model.model.Model.with_property`."""
    if not isinstance(path, str):
        raise ModelError(
            f"Argument `path` must name a property, such as 'section.thickness', but is {short_repr(path)}."
        )
    keys = path.split(".")
    stacks = [stack for stack in _stacks(model) if _is_number(stack.properties, keys)]
    having = {name for stack in stacks for name in stack.names}
    targets = [name for name, *_ in model.labels.elements if name in having] if elements is None else list(elements)
    if strangers := [name for name in targets if name not in having]:
        raise ModelError(f"Element '{strangers[0]}' has no property '{path}' that is one number.")
    if elements is not None and not targets:
        raise ModelError("Argument `elements` is empty: name elements, or leave it out for all with the property.")
    if not targets:
        raise ModelError(f"No element of this model has a property '{path}' that is one number.")
    place = {name: i for i, name in enumerate(targets)}
    if len(place) < len(targets):
        raise ModelError("Argument `elements` names an element twice.")
    numbers = _numbers(path, values, len(targets))
    if len(keys) == 2 and keys[0] == "section" and keys[1] in SIZES:
        # What is traced equals nothing, unless it is one number for all.
        known = numbers if is_concrete(numbers) else np.full(len(targets), np.nan)
        sizes = [values] * len(targets) if np.ndim(values) == 0 else known
        _check_steps(model, keys[1], dict(zip(targets, sizes, strict=True)))
    properties: list[dict[str, Any]] = list(model.parameters.properties)
    for block, kind, names, stacked in stacks:
        rows = [row for row, name in enumerate(names) if name in place]
        if not rows:
            continue
        changed = _put(stacked, keys, np.array(rows), numbers[np.array([place[names[row]] for row in rows])])
        section = changed.get("section")
        with nan_if_refused() as marked:
            if section is not None and (faults := section.faults()):
                raise ModelError(f"With these numbers for '{path}' a section has {' '.join(faults[0].split())}.")
            changed = marked(changed)
            section = changed.get("section")
        if kind is None:
            properties[block] = changed
        else:
            kinds = properties[block]["section"]
            properties[block] = {**properties[block], "section": (*kinds[:kind], section, *kinds[kind + 1 :])}
    return dataclasses.replace(model.parameters, properties=tuple(properties))


def _check_steps(model: Any, size: str, numbers: dict[str, Any]) -> None:
    """Refuse sizes that make or change a step between two leaf springs in line, which only a build can find."""
    rotations = {entry.of for entry in model.labels.x if entry.kind == "rotation"}
    ends_of = {name: [node for node in nodes if node in rotations] for name, _, nodes in model.labels.elements}
    meeting: dict[str, dict[str, tuple[bool, bool, Any]]] = {}
    for stack in _stacks(model):
        if not model.topology.blocks[stack.block].element.fields or "clamped" not in stack.properties:
            continue
        clamped, section = stack.properties["clamped"], stack.properties["section"]
        for row, name in enumerate(stack.names):
            sizes = [getattr(section, key)[row] for key in SIZES] if isinstance(section, Rectangle) else [None, None]
            number = numbers.get(name, sizes[SIZES.index(size)])
            for end, node in enumerate(ends_of[name]):
                goes_on = stepped = True
                if is_concrete((clamped, sizes)):
                    goes_on, stepped = _goes_on(np.asarray(clamped[row]), end, sizes)
                meeting.setdefault(node, {})[name] = goes_on, stepped, number
    for ends in meeting.values():
        if len(ends) != 2 or not numbers.keys() & ends.keys() or not all(goes_on for goes_on, *_ in ends.values()):
            continue
        first, other = (number for *_, number in ends.values())
        alike = first is other or (
            None not in (first, other) and is_concrete((first, other)) and float(first) == float(other)
        )
        if not alike or any(stepped for _, stepped, _ in ends.values()):
            raise ModelError(
                f"Leaf springs {' and '.join(map(repr, ends))} are in line. Only build() finds a step between their"
                f" sizes: build the model again with these numbers for 'section.{size}'."
            )


def _goes_on(clamped: np.ndarray, end: int, sizes: list[Any]) -> tuple[bool, bool]:
    """Whether an end of a leaf spring goes on in line, as far as known, and whether there is a step."""
    if clamped.ndim == 1:
        return bool(clamped[end] == 0), False
    stepped = len(clamped) > 2 and any(value != size for value, size in zip(clamped[2:, end], sizes, strict=True))
    return bool(stepped or clamped[0, end] == 0 or clamped[1, end] > 0), stepped


def _numbers(path: str, values: Any, count: int) -> Any:
    """One number for each element."""
    if np.ndim(values) == 0:
        values = jnp.full(count, values) if isinstance(values, jax.Array) else [values] * count
    check_numbers(f"The numbers for '{path}', one for each element,", values, (count,), fault=ModelError)
    return np.asarray(values, float) if is_concrete(values) else jnp.asarray(values, float)


def _stacks(model: Any) -> Iterator[_Stack]:
    for i, (block, properties) in enumerate(zip(model.topology.blocks, model.parameters.properties, strict=True)):
        if not block.e.shape[1]:  # Such as masses, which have no names.
            continue
        names = [model.labels.e[i].of for i in np.asarray(block.e)[:, 0]]
        if not isinstance(properties.get("section"), tuple):
            yield _Stack(i, None, names, properties)
            continue
        for kind, section in enumerate(properties["section"]):
            count = jax.tree.leaves(section)[0].shape[0]
            yield _Stack(i, kind, names[:count], {"section": section})
            names = names[count:]


def _is_number(tree: Any, keys: list[str]) -> bool:
    """Whether a path leads to one number per element."""
    for key in keys:
        tree = tree.get(key) if isinstance(tree, dict) else getattr(tree, key, None)
    return isinstance(tree, np.ndarray | jax.Array) and tree.ndim == 1


def _put(tree: Any, keys: list[str], rows: np.ndarray, values: Any) -> Any:
    """A tree with other numbers in rows of the array at a path."""
    if not keys:
        return jnp.asarray(values) if len(rows) == len(tree) else jnp.asarray(tree).at[rows].set(values)
    changed = {
        keys[0]: _put(tree[keys[0]] if isinstance(tree, dict) else getattr(tree, keys[0]), keys[1:], rows, values)
    }
    return {**tree, **changed} if isinstance(tree, dict) else dataclasses.replace(tree, **changed)
