"""Which of many designs cannot be built: the checks of a concrete build, on the numbers of every design.

A traced build sees no numbers and refuses none: a thickness below zero would have a frequency like any other.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import noting
from ..build.carry import carried, recorded
from ..build.sound import checks_of
from ..compilation.compile import QUICK
from ..errors import ModelError
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from .evaluate import told_of, traceable


def refusal(
    build: Callable[..., Any], models: list[Model], example: Mapping[str, Any]
) -> Callable[[Mapping[str, Any]], np.ndarray]:
    """What says of many designs whether a concrete build would refuse their numbers.

    The build is traced to a program from dimensions to the numbers of its models, and to the conditions that arguments
    of blocks and sections must meet (:func:`flexmb.arguments.noting`). On the host numbers must be finite, and
    sections and the elements' companions ``check`` are asked for faults, as in a concrete build. A check that finds
    fault with the example, which was built, is not asked.
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
    for ask, numbers, function in checks_of(parameters, topology):
        yield _each(ask, numbers, function)


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
