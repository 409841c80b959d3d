"""Checks of the numbers of all sections and elements of a model. Traced numbers that fail a check become NaN."""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import jax
import numpy as np

from ..arguments import as_known, is_concrete, is_noting, nan_if_refused
from ..elements.sections import Damping, Section
from ..model.model import Model
from ..model.topology import Block, Parameters, Topology

# Function that returns faults of one or many elements, its argument, and the function that its author wrote.
Check = tuple[Callable[[Any], list[str]], Any, Callable[..., list[str]]]


def checks_of(parameters: Parameters, topology: Topology) -> Iterator[Check]:
    """All checks of a model's sections, dampings and elements."""
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        reference = parameters.reference[:, np.asarray(block.x)]
        for first, last, stacked in _by_section_kind(properties, len(block.x)):
            for record in stacked.values():
                if isinstance(record, Section | Damping):
                    yield type(record).faults, record, type(record).faults
            if block.element.check is not None:
                arguments = {**dict(block.options), **stacked}
                yield from _element_check(block, block.element.check, reference[:, first:last], arguments)


def nan_if_impossible(model: Model) -> Model:
    """A model whose traced numbers are NaN if a concrete build would refuse them.

    Checks by users are left out, since they are written for plain numbers and cannot be traced.
    """
    if is_noting() or is_concrete(model.parameters):
        return model

    def stacked(leaf: Any) -> Any:
        return as_known(leaf)[None] if is_concrete(leaf) else jax.lax.stop_gradient(leaf)[None]

    single = jax.tree.map(stacked, model.parameters)
    with nan_if_refused() as marked:
        for ask, numbers, function in checks_of(single, model.topology):
            if function.__module__.startswith("flexmb.") and not is_concrete(numbers):
                ask(numbers)
        leaves, structure = jax.tree.flatten(model.parameters)
        # Known numbers stay known: analyses depend on it.
        traced = iter(marked([leaf for leaf in leaves if not is_concrete(leaf)]))
        leaves = [leaf if is_concrete(leaf) else next(traced) for leaf in leaves]
        return dataclasses.replace(model, parameters=jax.tree.unflatten(structure, leaves))


def _by_section_kind(properties: dict[str, Any], count: int) -> Iterator[tuple[int, int, dict[str, Any]]]:
    """Elements of a block with sections of one kind: first, last, and their properties."""
    sections = properties.get("section")
    if not isinstance(sections, tuple):
        yield 0, count, properties
        return
    first = 0
    for section in sections:
        last = first + jax.tree.leaves(section)[0].shape[1]
        others = {name: value for name, value in properties.items() if name != "section"}
        yield first, last, {**jax.tree.map(lambda a, i=first, j=last: a[:, i:j], others), "section": section}
        first = last


def _element_check(
    block: Block, check: Callable[..., list[str]], reference: Any, properties: dict[str, Any]
) -> Iterator[Check]:
    """The check of an element type."""
    element = block.element
    parameters = element.wanted(check)
    if any(p.default is p.empty and n not in properties for n, p in parameters.items()):
        # A block of deformations alone; the block of the companions has the other properties.
        return
    options = {n: v for n, v in properties.items() if n in parameters and isinstance(v, bool | str)}
    numbers = {n: v for n, v in properties.items() if n in parameters and n not in options}

    def ask(pair: tuple[Any, dict[str, Any]]) -> list[str]:
        reference, values = pair
        arguments: dict[str, Any] = element.arguments(check, {**options, **values}) or {}
        library = np if is_concrete(reference) else jax.numpy
        return check(ref=element.reference(library.split(reference, block.splits, axis=-1)), **arguments)

    yield ask, (reference, numbers), check
