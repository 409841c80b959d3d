"""Which of many designs cannot be built: the checks of a concrete build, on the numbers of every design.

A traced build sees no numbers and refuses none: a thickness below zero would have a frequency like any other.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import noting
from ..build.carry import carried, recorded
from ..compilation.compile import QUICK
from ..elements.sections import Section
from ..errors import ModelError
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Block, Topology
from .evaluate import told_of, traceable


def refusal(
    build: Callable[..., Any], models: list[Model], example: Mapping[str, Any]
) -> Callable[[Mapping[str, Any]], np.ndarray]:
    """What says of many designs whether a concrete build would refuse their numbers.

    The build is traced to a program from dimensions to the numbers of its models, and to the conditions that arguments
    of blocks and sections must meet (:func:`flexmb.arguments.noting`). On the host numbers must be finite, and
    sections and the elements' companions ``check`` are asked for faults, as in a concrete build. A check that finds
    fault with the example, which was built, is not asked.

    Args:
        models: Those it builds of the example, see :func:`flexmb.design.evaluate.build_once`.
        example: Dimensions of a design that can be built, by name.

    Returns:
        Function of dimensions with the designs first, (designs, ...) by name, to (designs,) of bool.
    """

    def numbers(dimensions: dict[str, Any]):
        with carried(models), recorded() as made, noting() as conditions, traceable(told_of(build)):
            build(**dimensions)
        return [model.parameters for model in made], conditions, [model.topology for model in made]

    # Which elements there are is the same in all designs.
    program = jax.jit(jax.vmap(numbers, out_axes=(0, 0, None)), compiler_options=QUICK)

    def refused(designs: Mapping[str, Any]) -> np.ndarray:
        # The example comes first.
        whole = {name: np.concatenate([np.asarray(example[name], float)[None], v]) for name, v in designs.items()}
        count = len(next(iter(whole.values())))
        found = np.zeros(count, bool)
        every, conditions, topologies = jax.tree.map(np.asarray, program(whole))
        for fine in conditions:
            found |= ~fine & fine[0]
        for parameters, topology in zip(every, topologies, strict=True):
            for faulty in _faulty(parameters, topology):
                found |= np.any(faulty & ~faulty[0], axis=1)
        return found[1:]

    return refused


def _faulty(parameters: Parameters, topology: Topology) -> Iterator[np.ndarray]:
    """Each check of a model of many designs, (designs, places), True where there is a fault."""
    for leaf in jax.tree.leaves(parameters):
        yield ~np.isfinite(leaf.reshape(len(leaf), -1))
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        reference = parameters.reference[:, block.x]
        for first, last, own in _of_one_kind(properties, len(block.x)):
            if isinstance(own.get("section"), Section):
                yield _of_sections(own["section"])
            if (check := block.element.check) is not None:
                yield _of_check(block, check, reference[:, first:last], {**dict(block.options), **own})


def _of_one_kind(properties: dict[str, Any], count: int) -> Iterator[tuple[int, int, dict[str, Any]]]:
    """Elements of a block whose sections are of one kind: from, to, and their properties."""
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


def _of_sections(sections: Section) -> np.ndarray:
    """Whether each section has a fault, (designs, elements)."""
    return _each(lambda section: section.faults(), sections, type(sections).faults)


def _of_check(block: Block, check: Callable[..., list[str]], reference: Any, properties: dict[str, Any]) -> np.ndarray:
    """Whether the check of each element has a fault, (designs, elements)."""
    element = block.element
    wanted = element.wanted(check)
    if any(p.default is p.empty and n not in properties for n, p in wanted.items()):
        # A block of deformations alone; the one of the companions has the other properties.
        return np.zeros((len(reference), 0), bool)
    options = {n: v for n, v in properties.items() if n in wanted and isinstance(v, bool | str)}
    numbers = {n: v for n, v in properties.items() if n in wanted and n not in options}

    def ask(one: tuple[Any, dict[str, Any]]):
        reference, own = one
        given: dict[str, Any] = element.arguments(check, {**options, **own}) or {}
        return check(ref=element.reference(np.split(reference, block.splits, axis=-1)), **given)

    return _each(ask, (reference, numbers), check)


def _each(faults: Callable[[Any], list[str]], trees: Any, function: Callable[..., Any]) -> np.ndarray:
    """Whether there are faults, of each of a tree of numbers stacked twice, (designs, elements); equal ones once."""
    leaves, structure = jax.tree.flatten(trees)
    designs, elements = leaves[0].shape[:2]
    if function.__module__.startswith("flexmb.") and not faults(trees):
        # Ours are asked about all at once; a user's may be written for one.
        return np.zeros((designs, elements), bool)
    shapes = [leaf.shape[2:] for leaf in leaves]
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
    rows = np.concatenate([leaf.reshape(designs * elements, -1) for leaf in leaves], axis=1)
    different, places = np.unique(rows, axis=0, return_inverse=True)

    def faulty(row: np.ndarray) -> bool:
        parts = zip(np.split(row, ends[:-1]), shapes, strict=True)
        try:
            return bool(faults(jax.tree.unflatten(structure, [part.reshape(shape) for part, shape in parts])))
        except ModelError:
            return True

    # What is not finite has its fault already, and a check need not be ready for it.
    found = np.array([np.all(np.isfinite(row)) and faulty(row) for row in different], bool)
    return found[places.ravel()].reshape(designs, elements)
