"""Compiled functions of a mechanism, in which elements with strain series compute some of their numbers only once."""

import dataclasses
import functools
import inspect
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..compilation.program import split_together
from ..compilation.record import Record, static
from ..elements.element import Element
from ..model.topology import Block, Parameters, Topology
from .blocks import companion_of, compiles, deforming, is_of_package, with_rigidities
from .staged import Staged

# Companions of series elements that a kernel calls several times.
REPEATED = ("deformation", "stiffness", "inertia", "energy")
# Companions that take coordinates of nodes.
OF_NODES = ("deformation", "inertia")


class Prepared(Record):
    """Companions of a block after the part that depends on the reference and the properties alone.

    Attributes:
        functions: For each companion, ``f(x_el, ref_el, numbers_el)`` of one element.
        numbers: Results of that part, stacked over the elements.
    """

    functions: tuple[tuple[str, Callable[..., Any]], ...] = static()
    numbers: tuple[Array, ...]


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """As :func:`flexmb.jit`, for a function of a topology, its parameters, and more.

    Elements with strain series compute some numbers only from reference and properties, such as the quadrature along a
    varying section. These numbers are computed once, since a kernel uses them in many places and would compile each.
    """

    @functools.wraps(function)
    def prepared(topology: Topology, parameters: Parameters, *arguments: Any, **options: Any):
        return function(topology, _prepared(topology, parameters), *arguments, **options)

    return jit(prepared)


def _prepared(topology: Topology, parameters: Parameters) -> Parameters:
    """Parameters with :class:`Prepared` companions for blocks with strain series."""
    if parameters.prepared is not None:
        return parameters
    prepared: list[Prepared | None] = []
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        prepared.append(None)
        if block.element.series is None or not is_of_package(block.element) or not compiles():
            continue
        names = tuple(name for name in REPEATED if companion_of(block, properties, name)[0] is not None)
        if names:
            stacked = parameters.reference[block.x], with_rigidities(properties)
            leaves, structure = jax.tree.flatten(stacked)
            shapes = tuple((leaf.shape[1:], leaf.dtype) for leaf in leaves)
            law = block.element, block.options, block.splits, block.e.shape[1]
            early, functions = _split_companions(names, law, structure, shapes)
            prepared[-1] = Prepared(functions, jax.vmap(early)(*stacked))
    return dataclasses.replace(parameters, prepared=tuple(prepared)) if any(prepared) else parameters


@functools.lru_cache(256)
def _split_companions(names: tuple[str, ...], law: tuple[Element, tuple, tuple, int], structure: Any, shapes: tuple):
    """Companions of one element, split into what needs reference and properties alone, and the rest of each."""
    element, options, splits, n_e = law
    ref, element_properties = jax.tree.unflatten(structure, [jax.ShapeDtypeStruct(*leaf) for leaf in shapes])
    x: Any = np.zeros((1, 0), int)
    e: Any = np.zeros((1, n_e), int)
    block = Block(element, names, options, x, e, splits)
    nodes = [jax.ShapeDtypeStruct((int(size),), ref.dtype) for size in np.diff([0, *splits, *ref.shape])]
    varying: dict[str, tuple] = {"stiffness": (), "energy": ((jax.ShapeDtypeStruct((n_e,), float),),)}
    varying |= dict.fromkeys(OF_NODES, (nodes,))
    pairs = [(_alone(block, element_properties, name), varying[name]) for name in names]
    early, late = split_together(pairs, (ref, element_properties))
    kinds = list(element.nodes.values())
    is_inner = [kind.part not in ("position", "rotation") for kind in kinds]
    # Planar elements have too few operations to gain by stages.
    in_stages = all(kind.dimension == 3 for kind in kinds)
    numbers = jax.eval_shape(early, ref, element_properties) if in_stages else ()
    functions: list[Any] = []
    for name, function in zip(names, late, strict=True):
        if in_stages and name in OF_NODES:
            functions.append((name, Staged(function, nodes, is_inner, numbers)))
        else:
            functions.append((name, _called(function, name, splits)))
    return early, tuple(functions)


def _alone(block: Block, like: dict[str, Any], name: str):
    """A companion of one element as a function of its arguments, its reference and its properties."""
    # Unwrapped, since it is split operation by operation anyway.
    function: Any = inspect.unwrap(companion_of(block, like, name)[0])
    if name == "stiffness":
        return lambda ref, properties: function(ref, ref, properties)
    if name == "deformation":
        return lambda x, ref, properties: function(x, ref, deforming(block, properties))
    return function


def _called(late: Callable[..., Any], companion: str, splits: tuple[int, ...]):
    """The remaining part of a companion, with the signature of the companion."""

    def function(x: Any, ref: Float[Array, "c"], numbers: tuple[Array, ...]):
        if companion == "stiffness":
            return late(*numbers)
        return late(jnp.split(x, splits) if companion in OF_NODES and not isinstance(x, list) else x, *numbers)

    return function
