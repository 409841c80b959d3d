"""Calls of the functions of element types on all elements of a block."""

import dataclasses
import functools
from collections.abc import Callable, Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import as_primitives, traced_once
from ..compilation.kept import as_nested_text
from ..compilation.program import Captured, Code, captured, digest
from ..elements.element import NONLINEAR, Element
from ..elements.profile import Profile
from ..elements.sections import MaterialDamping, Rigidity, Section
from ..errors import ModelError
from ..model.topology import Block, Parameters, Topology

# Prefix of a companion's name: traced numbers that the companion refers to, stored among the properties.
NUMBERS = "numbers of "


def element_function(block: Block, companion: Callable[..., Any] | None, properties: dict[str, Any]):
    """One element's function ``f(x_el, ref_el, properties_el, **extra)``, to be vmapped; None if the element has none.

    The coordinates x_el may be a list by node. Companions without nodes take their own arguments in place of x_el:
    deformations, and their rates; changes of temperature; or nothing.

    Args:
        companion: Deformation function or a companion of the block's element, or None.
        properties: Stacked properties of the block, to see which of them are None.
    """
    element = block.element
    chosen = element.arguments(companion, {**dict(block.options), **properties})
    if chosen is None or companion is None:
        return None
    takes_nothing = companion in (element.stiffness, element.damping)
    takes_all = companion in [getattr(element, name) for name in (*NONLINEAR, "surface", "thermal")]

    def function(x: Any, ref: Float[Array, "c"], element_properties: dict[str, Any], **extra: Any):
        named: dict[str, Any] = element.arguments(companion, {**dict(block.options), **element_properties}) or {}
        coordinates = () if takes_nothing else x if takes_all or isinstance(x, list) else jnp.split(x, block.splits)
        return companion(*coordinates, ref=element.reference(jnp.split(ref, block.splits)), **named, **extra)

    return as_primitives(function)


def each_block(topology: Topology, parameters: Parameters, companion: str) -> Iterator[tuple[Block, Any, Any, Any]]:
    """Blocks with a companion: block, function of one element, stacked reference coordinates, stacked properties."""
    known = parameters.prepared or [None] * len(topology.blocks)
    for block, properties, prepared in zip(topology.blocks, parameters.properties, known, strict=True):
        function = dict(prepared.functions).get(companion) if prepared else None
        if prepared and function is not None:
            properties = prepared.numbers
        else:
            function, properties = companion_of(block, properties, companion)
        if function is not None:
            yield block, function, parameters.reference[block.x], properties


def companion_of(block: Block, properties: dict[str, Any], companion: str) -> tuple[Any, dict[str, Any]]:
    """Function of one element, as :func:`element_function`, or None, and the stacked properties it is mapped over."""
    if companion not in block.companions:
        return None, properties
    properties = with_rigidities(deforming(block, properties) if companion == "deformation" else properties)
    if companion == "damping" and isinstance(properties.get("damping"), MaterialDamping):
        function = _damped(element_function(block, block.element.stiffness, properties))
    else:
        function = element_function(block, getattr(block.element, companion), properties)
    meaning = dict(block.meaning or ()).get(companion)
    if isinstance(meaning, Code):
        return _with_numbers(meaning, companion), properties
    if (
        meaning is not None
        and compiles()
        and meaning != digest(_element_program(block, companion, function, properties))
    ):
        raise ModelError(
            f"Element type '{block.element.name}': its {companion} uses a number that has changed since the model was"
            " built. Build the model again, or make the number a property of the element."
        )
    return function, properties


def _damped(stiffness: Any):
    """Damping of one element by its material, THEORY.md 2, eq. (2.41)."""

    def function(x: Any, ref: Float[Array, "c"], element_properties: dict[str, Any], **extra: Any):
        return element_properties["damping"].time * stiffness(x, ref, element_properties, **extra)

    return function


def deforming(block: Block, properties: dict[str, Any]) -> dict[str, Any]:
    """Properties of a block on which its deformations may depend.

    A section matters if it varies, and for leaf springs. Otherwise it is left out, so that beams of all sections share
    one program.
    """
    if block.element.series is None or "clamped" in properties or isinstance(properties.get("section"), Profile):
        return properties
    return {name: None if name == "section" else value for name, value in properties.items()}


def with_meaning(block: Block, properties: dict[str, Any]) -> tuple[Block, dict[str, Any]]:
    """A block with digests of its user-defined functions, which show later changes, and its properties.

    Traced numbers that such a function refers to become properties, so that derivatives and batches pass through.
    """
    if is_of_package(block.element) or not compiles():
        return block, properties
    meanings: list[tuple[str, Any]] = []
    numbers = {}
    for companion in block.companions:
        function, element_properties = companion_of(block, properties, companion)
        program = _element_program(block, companion, function, element_properties)
        traced = not is_concrete(program.numbers)
        meanings.append((companion, program.code if traced else digest(program)))
        if traced:
            count = block.e.shape[0]
            numbers[NUMBERS + companion] = [jnp.broadcast_to(n, (count, *jnp.shape(n))) for n in program.numbers]
    return dataclasses.replace(block, meaning=tuple(meanings)), {**properties, **numbers}


def _with_numbers(code: Code, companion: str):
    """A function of one element that takes captured numbers from its properties."""

    def function(x: Any, ref: Float[Array, "c"], element_properties: dict[str, Any], **extra: Any):
        known = {name: value for name, value in element_properties.items() if not name.startswith(NUMBERS)}
        x = jnp.concatenate(x) if isinstance(x, list) else x
        return Captured(code, tuple(element_properties[NUMBERS + companion]))(x, ref, known, extra)

    return function


@functools.lru_cache(1000)
def is_of_package(element: Element) -> bool:
    """Whether an element uses functions of the package alone."""
    try:
        as_nested_text(element)
    except (TypeError, ValueError, AttributeError, RecursionError):
        return False
    return True


def compiles() -> bool:
    """False under ``jax.disable_jit``, where traces differ."""
    config: Any = jax.config
    return not config.jax_disable_jit


def _element_program(block: Block, companion: str, function: Any, properties: dict[str, Any]) -> Captured:
    """A function of one element as a program and its captured numbers."""
    n = block.e.shape[1]
    positional, keywords = companion_arguments(block.element, n)
    coordinates = jax.ShapeDtypeStruct(block.x.shape[1:], float)
    element_properties = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(np.shape(leaf)[1:], float), properties)
    extra = dict(keywords.get(companion, {}))
    if companion == "deformation" and block.element.tracks_angle:
        extra["near"] = vector_shape(n)
    return captured(
        lambda x, ref, element_properties, extra: function(x, ref, element_properties, **extra),
        positional.get(companion) or coordinates,
        coordinates,
        element_properties,
        extra,
    )


def vector_shape(size: int) -> jax.ShapeDtypeStruct:
    """Shape of a vector of floats."""
    return jax.ShapeDtypeStruct((size,), float)


def companion_arguments(element: Element, n: int) -> tuple[dict[str, tuple], dict[str, dict[str, Any]]]:
    """Shapes of the arguments of companions for n deformations: positional ones instead of nodes, and keywords."""
    e, place = vector_shape(n), jax.ShapeDtypeStruct((), float)
    positional = {"stiffness": (), "damping": (), "energy": (e,), "surface": (e,), "dissipation": (e, e), "law": (e, e)}
    positional["thermal"] = tuple(map(vector_shape, heat_sizes(element)))
    along = {"resultants": {"place": place, "sigma": e}, "surface": {"place": place, "resultants": vector_shape(6)}}
    return positional, along


def heat_sizes(element: Element) -> tuple[int, ...]:
    """Sizes of the arguments of an element's thermal deformations: temperature change, and its gradient."""
    axes = next(iter(element.nodes.values())).dimension
    return (2, axes - 1) if element.bends_by_heat else (2,)


def with_rigidities(properties: dict[str, Any]) -> dict[str, Any]:
    """Stacked properties with sections of several kinds converted to one stack."""
    sections = properties.get("section")
    return {**properties, "section": _rigidities(sections)} if isinstance(sections, tuple) else properties


@traced_once
def _rigidities(stacks: tuple[Section, ...]) -> Rigidity:
    """One stack of rigidities from stacks of sections of several kinds."""
    # Sections without an expansion take none.
    like = Rigidity(alpha=0.0)

    def numbers(section: Section):
        rigidity = section.rigidity()
        rigidity = rigidity if rigidity.expands else dataclasses.replace(rigidity, alpha=0.0)
        return jnp.stack([jnp.asarray(number, float) for number in jax.tree.leaves(rigidity)])

    columns = jnp.concatenate([jax.vmap(numbers)(stack) for stack in stacks])
    return jax.tree.unflatten(jax.tree.structure(like), list(columns.T))
