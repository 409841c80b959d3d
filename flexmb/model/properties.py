"""Replacement of numbers of a model's elements, all at once, without building the model again."""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import check_numbers, is_concrete, nan_if_refused, shown
from ..errors import ModelError
from .parameters import Parameters
from .topology import Topology


class _Stack(NamedTuple):
    """Elements whose properties are stacked together; ``kind`` is the number of their kind of section, if several."""

    block: int
    kind: int | None
    names: list[str]
    properties: dict[str, Any]


def with_property(
    topology: Topology, parameters: Parameters, labels: Any, path: str, values: Any, elements: Sequence[str] | None
) -> Parameters:
    """Parameters with other numbers for a property; see :meth:`flexmb.model.model.Model.with_property`."""
    if not isinstance(path, str):
        raise ModelError(f"Argument `path` must name a property, such as 'section.thickness', but is {shown(path)}.")
    keys = path.split(".")
    stacks = [stack for stack in _stacks(topology, parameters, labels) if _is_number(stack.properties, keys)]
    having = {name for stack in stacks for name in stack.names}
    wanted = [name for name, *_ in labels.elements if name in having] if elements is None else list(elements)
    if strangers := [name for name in wanted if name not in having]:
        raise ModelError(f"Element '{strangers[0]}' has no property '{path}' that is one number.")
    if elements is not None and not wanted:
        raise ModelError("Argument `elements` is empty: name elements, or leave it out for all with the property.")
    if not wanted:
        raise ModelError(f"No element of this model has a property '{path}' that is one number.")
    place = {name: i for i, name in enumerate(wanted)}
    if len(place) < len(wanted):
        raise ModelError("Argument `elements` names an element twice.")
    numbers = _numbers(path, values, len(wanted))
    properties: list[dict[str, Any]] = list(parameters.properties)
    for block, kind, names, own in stacks:
        rows = [row for row, name in enumerate(names) if name in place]
        if not rows:
            continue
        changed = _put(own, keys, np.array(rows), numbers[np.array([place[names[row]] for row in rows])])
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
    return dataclasses.replace(parameters, properties=tuple(properties))


def _numbers(path: str, values: Any, count: int) -> Any:
    """One number for each element."""
    if np.ndim(values) == 0:
        values = jnp.full(count, values) if isinstance(values, jax.Array) else [values] * count
    check_numbers(f"The numbers for '{path}', one for each element,", values, (count,), fault=ModelError)
    return np.asarray(values, float) if is_concrete(values) else jnp.asarray(values, float)


def _stacks(topology: Topology, parameters: Parameters, labels: Any) -> Iterator[_Stack]:
    for i, (block, own) in enumerate(zip(topology.blocks, parameters.properties, strict=True)):
        if not block.e.shape[1]:  # Such as masses, which have no names.
            continue
        names = [labels.e[i].of for i in np.asarray(block.e)[:, 0]]
        if not isinstance(own.get("section"), tuple):
            yield _Stack(i, None, names, own)
            continue
        for kind, section in enumerate(own["section"]):
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
