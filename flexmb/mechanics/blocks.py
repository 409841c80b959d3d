"""Calls of element functions on all elements of a block, and sums of their results over the mechanism."""

import dataclasses
import functools
import inspect
from collections.abc import Callable, Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import as_primitives, jit, traced_once
from ..compilation.kept import as_nested_text
from ..compilation.program import Captured, Code, captured, digest, split_together
from ..compilation.record import Record, static
from ..elements.element import NONLINEAR, Element
from ..elements.profile import Profile
from ..elements.sections import MaterialDamping, Rigidity, Section
from ..errors import ModelError
from ..math.indices import accumulate
from ..model.topology import Block, Parameters, Topology
from .staged import Staged

# Prefix of a companion's name: traced numbers that the companion refers to, stored among the properties.
NUMBERS = "numbers of "
# Companions of series elements that a kernel calls several times.
REPEATED = ("deformation", "stiffness", "inertia", "energy")
# Companions that take coordinates of nodes.
OF_NODES = ("deformation", "inertia")


class Prepared(Record):
    """Companions of a block after the part that depends on the reference and the properties alone.

    Attributes:
        functions: For each companion, ``f(x_el, *numbers_el)`` of one element; without x_el if it needs none.
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
    prepared = []
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        prepared.append(None)
        if block.element.series is None or not _is_of_package(block.element) or not _compiles():
            continue
        names = tuple(name for name in REPEATED if companion_of(block, properties, name)[0] is not None)
        if names:
            stacked = parameters.reference[block.x], with_rigidities(properties)
            leaves, structure = jax.tree.flatten(stacked)
            shapes = tuple((leaf.shape[1:], leaf.dtype) for leaf in leaves)
            early, functions = _split_companions(
                names, block.element, block.options, block.splits, block.e.shape[1], structure, shapes
            )
            prepared[-1] = Prepared(functions, jax.vmap(early)(*stacked))
    return dataclasses.replace(parameters, prepared=tuple(prepared)) if any(prepared) else parameters


@functools.lru_cache(256)
def _split_companions(
    names: tuple[str, ...],
    element: Element,
    options: tuple[tuple[str, object], ...],
    splits: tuple[int, ...],
    n_e: int,
    structure: Any,
    shapes: tuple[tuple[tuple[int, ...], Any], ...],
):
    """Companions of one element, split into what needs reference and properties alone, and the rest of each."""
    ref, element_properties = jax.tree.unflatten(structure, [jax.ShapeDtypeStruct(*leaf) for leaf in shapes])
    x: Any = np.zeros((1, 0), int)
    e: Any = np.zeros((1, n_e), int)
    block = Block(element, names, options, x, e, splits)
    sizes = np.diff([0, *splits, *ref.shape])
    nodes = [jax.ShapeDtypeStruct((int(size),), ref.dtype) for size in sizes]
    varying: dict[str, tuple] = {"stiffness": (), "energy": ((jax.ShapeDtypeStruct((n_e,), float),),)}
    varying |= dict.fromkeys(OF_NODES, (nodes,))
    pairs = [(_alone(block, element_properties, name), varying.get(name, (ref,))) for name in names]
    early, late = split_together(pairs, (ref, element_properties))
    functions = dict(zip(names, late, strict=True))
    kinds = list(element.nodes.values())
    # Planar elements have too few operations to gain by stages.
    if all(kind.dimension == 3 for kind in kinds):
        is_inner = [kind.part not in ("position", "rotation") for kind in kinds]
        numbers = jax.eval_shape(early, ref, element_properties)
        functions |= {name: Staged(functions[name], nodes, is_inner, numbers) for name in names if name in OF_NODES}
    return early, tuple(functions.items())


def _alone(block: Block, like: dict[str, Any], name: str):
    """A companion of one element as a function of its arguments, its reference and its properties."""
    # Unwrapped, since it is split operation by operation anyway.
    function: Any = inspect.unwrap(companion_of(block, like, name)[0])
    chosen = deforming if name == "deformation" else lambda block, element_properties: element_properties
    if name == "stiffness":
        return lambda ref, element_properties: function(ref, ref, element_properties)
    return lambda x, ref, element_properties: function(x, ref, chosen(block, element_properties))


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
        late = dict(prepared.functions).get(companion) if prepared else None
        if prepared and late:
            yield block, _called(late, companion, block.splits), parameters.reference[block.x], prepared.numbers
            continue
        function, properties = companion_of(block, properties, companion)
        if function is not None:
            yield block, function, parameters.reference[block.x], properties


def _called(late: Callable[..., Any], companion: str, splits: tuple[int, ...]):
    """The remaining part of a companion, with the signature of the companion."""
    if isinstance(late, Staged):
        return late

    def function(x: Any, ref: Float[Array, "c"], numbers: tuple[Array, ...]):
        if companion in OF_NODES:
            x = x if isinstance(x, list) else jnp.split(x, splits)
        return late(*numbers) if companion == "stiffness" else late(x, *numbers)

    return function


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
        and _compiles()
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
    if _is_of_package(block.element) or not _compiles():
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
def _is_of_package(element: Element) -> bool:
    """Whether an element uses functions of the package alone."""
    try:
        as_nested_text(element)
    except (TypeError, ValueError, AttributeError, RecursionError):
        return False
    return True


def _compiles() -> bool:
    """False under ``jax.disable_jit``, where traces differ."""
    config: Any = jax.config
    return not config.jax_disable_jit


def _element_program(block: Block, companion: str, function: Any, properties: dict[str, Any]) -> Captured:
    """A function of one element as a program and its captured numbers."""
    n, place = block.e.shape[1], jax.ShapeDtypeStruct((), float)
    e, coordinates = jax.ShapeDtypeStruct((n,), float), jax.ShapeDtypeStruct(block.x.shape[1:], float)
    element_properties = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(np.shape(leaf)[1:], float), properties)
    heat = tuple(jax.ShapeDtypeStruct((k,), float) for k in heat_sizes(block.element))
    own_arguments = {"energy": (e,), "surface": (e,), "dissipation": (e, e), "law": (e, e), "thermal": heat}
    arguments: Any = own_arguments.get(companion, coordinates)
    wrench = jax.ShapeDtypeStruct((6,), float)
    along = {"resultants": {"place": place, "sigma": e}, "surface": {"place": place, "resultants": wrench}}
    extra: dict[str, Any] = dict(along.get(companion, {}))
    if companion == "deformation" and block.element.tracks_angle:
        extra["near"] = e
    return captured(
        lambda x, ref, element_properties, extra: function(x, ref, element_properties, **extra),
        arguments,
        coordinates,
        element_properties,
        extra,
    )


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


def scatter_matrix(size: tuple[int, int], pieces: list[tuple[Array, Array, Array]]) -> Float[Array, "rows columns"]:
    """Matrix assembled from element matrices: row indices (elements, r), column indices (elements, c), matrices."""
    return scatter_matrices(size, [(rows, columns, (matrices,)) for rows, columns, matrices in pieces], 1)[0]


def scatter_matrices(
    size: tuple[int, int], pieces: list[tuple[Array, Array, tuple[Array, ...]]], count: int
) -> list[Float[Array, "rows columns"]]:
    """Several matrices assembled from element matrices with the same places; see :func:`scatter_matrix`."""
    flat = [(rows[:, :, None] * size[1] + columns[:, None, :], matrices) for rows, columns, matrices in pieces]
    return [vector.reshape(size) for vector in scatter_vectors(size[0] * size[1], flat, count)]


def scatter_vector(size: int, pieces: list[tuple[Array, Array]]) -> Float[Array, "size"]:
    """Vector assembled from element vectors."""
    return scatter_vectors(size, [(indices, (vectors,)) for indices, vectors in pieces], 1)[0]


def scatter_vectors(size: int, pieces: list[tuple[Array, tuple[Array, ...]]], count: int) -> list[Float[Array, "size"]]:
    """Several vectors assembled in one loop, since each loop takes time to compile."""
    if not pieces:
        return [jnp.zeros(size)] * count
    indices = jnp.concatenate([indices.reshape(-1) for indices, _ in pieces])
    values = [jnp.concatenate([vectors[i].reshape(-1) for _, vectors in pieces]) for i in range(count)]
    if count == 1:
        return [accumulate(jnp.zeros(size), indices, values[0])]
    assembled = accumulate(jnp.zeros((size, count)), indices, jnp.stack(values, axis=1))
    return [assembled[:, i] for i in range(count)]


def derivative(function: Callable[..., Any]) -> Callable[..., tuple[Any, Any]]:
    """Return a function for the derivatives by the coordinates, on the last axis of each array, and the value."""
    if isinstance(function, Staged):
        return function.derivative

    def with_value(x: Float[Array, "c"], *arguments: Any):
        value = function(x, *arguments)
        return value, value

    return jax.jacfwd(with_value, has_aux=True)


def curvature(function: Callable[..., Float[Array, "n"]]) -> Callable[..., Float[Array, "c c"]]:
    """Return ``f(x_el, sigma_el, *arguments_el) -> (c, c)`` for second derivatives of sigma . e of an element."""
    if isinstance(function, Staged):
        return function.curvature

    def energy(x: Float[Array, "c"], sigma: Float[Array, "n"], *arguments: Any):
        return sigma @ function(x, *arguments)

    return jax.jacfwd(jax.grad(energy))
