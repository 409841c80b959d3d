"""Numbers of a model's elements, replaced all at once: a thousand of them without building anew."""

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
    """Elements whose properties are stacked together.

    Attributes:
        block: Which block of the topology.
        kind: Which of the kinds of section of that block; None where it has one.
        names: Of the elements, in the order of the stack.
        properties: Theirs, every leaf stacked.
    """

    block: int
    kind: int | None
    names: list[str]
    properties: dict[str, Any]


def with_property(
    topology: Topology, parameters: Parameters, labels: Any, path: str, values: Any, elements: Sequence[str] | None
) -> Parameters:
    """Parameters with other numbers for one property, see :meth:`flexmb.model.model.Model.with_property`."""
    if not isinstance(path, str):
        raise ModelError(f"Argument `path` must name a property, such as 'section.thickness', but is {shown(path)}.")
    keys = path.split(".")
    stacks = [own for own in _stacks(topology, parameters, labels) if _is_number(own.properties, keys)]
    having = {name for own in stacks for name in own.names}
    wanted = [name for name, *_ in labels.elements if name in having] if elements is None else list(elements)
    if strangers := [name for name in wanted if name not in having]:
        raise ModelError(f"Element '{strangers[0]}' has no property '{path}' that is one number.")
    if elements is not None and not wanted:
        raise ModelError("Argument `elements` is empty: name elements, or leave it out for all that have the property.")
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
    """One number for each element, (count,)."""
    if np.ndim(values) == 0:
        values = jnp.full(count, values) if isinstance(values, jax.Array) else [values] * count
    check_numbers(f"The numbers for '{path}', one for each element,", values, (count,), fault=ModelError)
    return np.asarray(values, float) if is_concrete(values) else jnp.asarray(values, float)


def _stacks(topology: Topology, parameters: Parameters, labels: Any) -> Iterator[_Stack]:
    for i, (block, own) in enumerate(zip(topology.blocks, parameters.properties, strict=True)):
        if not block.e.shape[1]:  # such as a mass, which has no name here
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
    """Whether a path ends at one number for each element."""
    for key in keys:
        tree = tree.get(key) if isinstance(tree, dict) else getattr(tree, key, None)
    return isinstance(tree, np.ndarray | jax.Array) and tree.ndim == 1


def _put(tree: Any, keys: list[str], rows: np.ndarray, values: Any) -> Any:
    """A tree with other numbers in some rows of the array at the end of a path."""
    if not keys:
        return jnp.asarray(values) if len(rows) == len(tree) else jnp.asarray(tree).at[rows].set(values)
    changed = {
        keys[0]: _put(tree[keys[0]] if isinstance(tree, dict) else getattr(tree, keys[0]), keys[1:], rows, values)
    }
    return {**tree, **changed} if isinstance(tree, dict) else dataclasses.replace(tree, **changed)
