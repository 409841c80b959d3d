"""Designs that cannot be built, found by the checks of an untraced build, for many designs at once.

A traced build cannot check its numbers: it would compute a frequency for a negative thickness.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import noting
from ..build.carry import carried_choices, collected_models
from ..build.sound import checks_of
from ..compilation.compile import QUICK
from ..errors import ModelError
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from .evaluate import subject_of, traceable


def refusal_of_designs(
    build: Callable[..., Any], models: list[Model], example: Mapping[str, Any]
) -> Callable[[Mapping[str, Any]], np.ndarray]:
    """Return a function from many designs to whether a concrete build would refuse each design, (designs,).

    A program, traced from the build, computes the numbers of the models and the conditions on arguments of blocks and
    sections (:func:`flexmb.arguments.noting`). The host then checks that all numbers are finite and runs the checks of
    sections and elements. It ignores each check that finds a fault in the example, which was built.
    """

    def numbers(dimensions: dict[str, Any]):
        with carried_choices(models), collected_models() as built, noting() as conditions, traceable(subject_of(build)):
            build(**dimensions)
        return [model.parameters for model in built], conditions, [model.topology for model in built]

    # All designs have the same elements.
    program = jax.jit(jax.vmap(numbers, out_axes=(0, 0, None)), compiler_options=QUICK)

    def refused(designs: Mapping[str, Any]) -> np.ndarray:
        # The example is the first design.
        every_design = {
            name: np.concatenate([np.asarray(example[name], float)[None], v]) for name, v in designs.items()
        }
        impossible = np.zeros(len(next(iter(every_design.values()))), bool)
        every, conditions, topologies = jax.tree.map(np.asarray, program(every_design))
        for fine in conditions:
            impossible |= ~fine & fine[0]
        for parameters, topology in zip(every, topologies, strict=True):
            for faulty in _faulty(parameters, topology):
                impossible |= np.any(faulty & ~faulty[0], axis=1)
        return impossible[1:]

    return refused


def _faulty(parameters: Parameters, topology: Topology) -> Iterator[np.ndarray]:
    """Yield the result of each check of a model, (designs, places): True for a fault."""
    for leaf in jax.tree.leaves(parameters):
        yield ~np.isfinite(leaf.reshape(len(leaf), -1))
    for ask, numbers, function in checks_of(parameters, topology):
        yield _impossible_elements(ask, numbers, function)


def _impossible_elements(faults: Callable[[Any], list[str]], trees: Any, function: Callable[..., Any]) -> np.ndarray:
    """Return whether each element of each design has a fault, (designs, elements); equal numbers are checked once."""
    leaves, structure = jax.tree.flatten(trees)
    designs, elements = leaves[0].shape[:2]
    if function.__module__.startswith("flexmb.") and not faults(trees):
        # Our checks accept stacked numbers; a user's check may not.
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

    # The first check finds numbers that are not finite. Other checks may raise on them.
    is_faulty = np.array([np.all(np.isfinite(row)) and faulty(row) for row in different], bool)
    return is_faulty[places.ravel()].reshape(designs, elements)
