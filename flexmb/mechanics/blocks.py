"""Call element functions on all elements of a block, and scatter what they return."""

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
from ..compilation.kept import described
from ..compilation.program import Captured, Code, captured, digest, split_together
from ..compilation.record import Record, static
from ..elements.element import NONLINEAR, Element
from ..elements.profile import Profile
from ..elements.sections import MaterialDamping, Rigidity, Section
from ..errors import ModelError
from ..math.indices import accumulate
from ..model.parameters import Parameters
from ..model.topology import Block, Topology
from .staged import Staged

# Before the name of a companion: traced numbers that it refers to, among the properties.
NUMBERS = "numbers of "
# Companions of series elements that a kernel calls several times.
REPEATED = ("deformation", "stiffness", "inertia", "energy")
# Those that take coordinates of nodes.
OF_NODES = ("deformation", "inertia")


class Prepared(Record):
    """Companions of a block, with what they make of the reference and the properties alone worked out.

    Attributes:
        functions: Of each companion, ``f(x_el, *numbers_el)`` of one element, without x_el where it depends on none.
        numbers: What was worked out, stacked over the elements.
    """

    functions: tuple[tuple[str, Callable[..., Any]], ...] = static()
    numbers: tuple[Array, ...]


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """As :func:`flexmb.jit`, of a function of a topology, its parameters, and more.

    What the functions of elements with strain series make of reference and properties alone, such as the quadrature
    along a section that varies, is worked out once: a kernel calls them in many places, and each would be compiled.

    """

    @functools.wraps(function)
    def whole(topology: Topology, parameters: Parameters, *arguments: Any, **options: Any):
        return function(topology, _prepared(topology, parameters), *arguments, **options)

    return jit(whole)


def _prepared(topology: Topology, parameters: Parameters) -> Parameters:
    """Parameters with the :class:`Prepared` companions of the blocks whose elements have strain series."""
    if parameters.prepared is not None:
        return parameters
    found = []
    for block, properties in zip(topology.blocks, parameters.properties, strict=True):
        found.append(None)
        if block.element.series is None or not _of_package(block.element) or not _compiles():
            continue
        names = tuple(name for name in REPEATED if companion_of(block, properties, name)[0] is not None)
        if names:
            stacked = parameters.reference[block.x], with_rigidities(properties)
            leaves, structure = jax.tree.flatten(stacked)
            shapes = tuple((leaf.shape[1:], leaf.dtype) for leaf in leaves)
            early, functions = _apart(
                names, block.element, block.options, block.splits, block.e.shape[1], structure, shapes
            )
            found[-1] = Prepared(functions, jax.vmap(early)(*stacked))
    return dataclasses.replace(parameters, prepared=tuple(found)) if any(found) else parameters


@functools.lru_cache(256)
def _apart(
    names: tuple[str, ...],
    element: Element,
    options: tuple[tuple[str, object], ...],
    splits: tuple[int, ...],
    n_e: int,
    structure: Any,
    shapes: tuple[tuple[tuple[int, ...], Any], ...],
):
    """Companions of one element taken apart into what follows from reference and properties, and the rest of each."""
    ref, own = jax.tree.unflatten(structure, [jax.ShapeDtypeStruct(*leaf) for leaf in shapes])
    x: Any = np.zeros((1, 0), int)
    e: Any = np.zeros((1, n_e), int)
    block = Block(element, names, options, x, e, splits)
    sizes = np.diff([0, *splits, *ref.shape])
    nodes = [jax.ShapeDtypeStruct((int(size),), ref.dtype) for size in sizes]
    varying: dict[str, tuple] = {"stiffness": (), "energy": ((jax.ShapeDtypeStruct((n_e,), float),),)}
    varying |= dict.fromkeys(OF_NODES, (nodes,))
    taken = [(_alone(block, own, name), varying.get(name, (ref,))) for name in names]
    early, late = split_together(taken, (ref, own))
    found = dict(zip(names, late, strict=True))
    kinds = list(element.nodes.values())
    # In the plane it takes too few operations to gain by that.
    if all(kind.dimension == 3 for kind in kinds):
        is_inner = [kind.part not in ("position", "rotation") for kind in kinds]
        numbers = jax.eval_shape(early, ref, own)
        found |= {name: Staged(found[name], nodes, is_inner, numbers) for name in names if name in OF_NODES}
    return early, tuple(found.items())


def _alone(block: Block, like: dict[str, Any], name: str):
    """A companion of one element of the arguments that it depends on, and of its reference and properties."""
    # It is taken apart operation by operation anyway.
    function: Any = inspect.unwrap(companion_of(block, like, name)[0])
    chosen = deforming if name == "deformation" else lambda block, own: own
    if name == "stiffness":
        return lambda ref, own: function(ref, ref, own)
    return lambda x, ref, own: function(x, ref, chosen(block, own))


def element_function(block: Block, companion: Callable[..., Any] | None, properties: dict[str, Any]):
    """One element's function of its coordinates alone but for ``ref`` and the properties, or None if it has none.

    Args:
        companion: The deformation function or a companion of the block's element, or None.
        properties: Stacked properties of the block; only which of them are None is looked at.

    Returns:
        ``f(x_el, ref_el, properties_el, **extra)``, to be vmapped, or None. The coordinates x_el may be a list of those
        of each node. Where a companion takes no nodes, x_el are the arguments that it takes in their place:
        deformations, and their rates; changes of temperature; or nothing that matters.
    """
    element = block.element
    chosen = element.arguments(companion, {**dict(block.options), **properties})
    if chosen is None or companion is None:
        return None
    takes_nothing = companion in (element.stiffness, element.damping)
    takes_all = companion in [getattr(element, name) for name in (*NONLINEAR, "surface", "thermal")]

    def function(x: Any, ref: Float[Array, "c"], own: dict[str, Any], **extra: Any):
        named: dict[str, Any] = element.arguments(companion, {**dict(block.options), **own}) or {}
        taken = () if takes_nothing else x if takes_all or isinstance(x, list) else jnp.split(x, block.splits)
        return companion(*taken, ref=element.reference(jnp.split(ref, block.splits)), **named, **extra)

    return as_primitives(function)


def each_block(topology: Topology, parameters: Parameters, companion: str) -> Iterator[tuple[Block, Any, Any, Any]]:
    """Blocks that have a companion, with the function of one element and the stacked arguments it is mapped over.

    Yields:
        Block, function of one element, stacked reference coordinates, stacked properties.
    """
    known = parameters.prepared or [None] * len(topology.blocks)
    for block, properties, prepared in zip(topology.blocks, parameters.properties, known, strict=True):
        rest = dict(prepared.functions).get(companion) if prepared else None
        if prepared and rest:
            yield block, _called(rest, companion, block.splits), parameters.reference[block.x], prepared.numbers
            continue
        function, properties = companion_of(block, properties, companion)
        if function is not None:
            yield block, function, parameters.reference[block.x], properties


def _called(rest: Callable[..., Any], companion: str, splits: tuple[int, ...]):
    """What is left of a companion, called as the companion is."""
    if isinstance(rest, Staged):
        return rest

    def function(x: Any, ref: Float[Array, "c"], numbers: tuple[Array, ...]):
        if companion in OF_NODES:
            x = x if isinstance(x, list) else jnp.split(x, splits)
        return rest(*numbers) if companion == "stiffness" else rest(x, *numbers)

    return function


def companion_of(block: Block, properties: dict[str, Any], companion: str) -> tuple[Any, dict[str, Any]]:
    """Function of one element of a block, or None if it has none, and the stacked properties to map it over.

    Returns the function, which takes what :func:`element_function` says, and the properties.
    """
    if companion not in block.companions:
        return None, properties
    properties = with_rigidities(deforming(block, properties) if companion == "deformation" else properties)
    if companion == "damping" and isinstance(properties.get("damping"), MaterialDamping):
        function = _damped(element_function(block, block.element.stiffness, properties))
    else:
        function = element_function(block, getattr(block.element, companion), properties)
    then = dict(block.meaning or ()).get(companion)
    if isinstance(then, Code):
        return _with_numbers(then, companion), properties
    if then is not None and _compiles() and then != digest(_taken(block, companion, function, properties)):
        raise ModelError(
            f"Element type '{block.element.name}': a number that its {companion} refers to has changed since the model"
            " was built. Build the model again, or make the number a property of the element."
        )
    return function, properties


def _damped(stiffness: Any):
    """Damping of one element by its material, from its stiffness; THEORY.md 2, eq. (2.41)."""

    def function(x: Any, ref: Float[Array, "c"], own: dict[str, Any], **extra: Any):
        return own["damping"].time * stiffness(x, ref, own, **extra)

    return function


def deforming(block: Block, properties: dict[str, Any]) -> dict[str, Any]:
    """Properties of a block that its deformations may depend on.

    How strains are spread along a spectral beam its section says, but only one that varies, along a leaf spring any:
    others are left out, so that beams with all kinds of them are the same program.
    """
    if block.element.series is None or "clamped" in properties or isinstance(properties.get("section"), Profile):
        return properties
    return {name: None if name == "section" else value for name, value in properties.items()}


def with_meaning(block: Block, properties: dict[str, Any]) -> tuple[Block, dict[str, Any]]:
    """A block that knows what functions of a user's own do now, so that none is taken for what it did before.

    Traced numbers that such a function refers to become properties, so that derivatives and batches go through them.
    Returns the two with the values found.
    """
    if _of_package(block.element) or not _compiles():
        return block, properties
    found: list[tuple[str, Any]] = []
    numbers = {}
    for companion in block.companions:
        function, own = companion_of(block, properties, companion)
        taken = _taken(block, companion, function, own)
        traced = not is_concrete(taken.numbers)
        found.append((companion, taken.code if traced else digest(taken)))
        if traced:
            count = block.e.shape[0]
            numbers[NUMBERS + companion] = [jnp.broadcast_to(n, (count, *jnp.shape(n))) for n in taken.numbers]
    return dataclasses.replace(block, meaning=tuple(found)), {**properties, **numbers}


def _with_numbers(code: Code, companion: str):
    """A function of one element whose numbers from outside are among its properties."""

    def function(x: Any, ref: Float[Array, "c"], own: dict[str, Any], **extra: Any):
        known = {name: value for name, value in own.items() if not name.startswith(NUMBERS)}
        x = jnp.concatenate(x) if isinstance(x, list) else x
        return Captured(code, tuple(own[NUMBERS + companion]))(x, ref, known, extra)

    return function


@functools.lru_cache(1000)
def _of_package(element: Element) -> bool:
    """Whether no function of a user's own takes part in an element."""
    try:
        described(element)
    except (TypeError, ValueError, AttributeError, RecursionError):
        return False
    return True


def _compiles() -> bool:
    """False under ``jax.disable_jit``, where a program has other parts."""
    config: Any = jax.config
    return not config.jax_disable_jit


def _taken(block: Block, companion: str, function: Any, properties: dict[str, Any]) -> Captured:
    """A function of one element as a program and the numbers in it."""
    n, place = block.e.shape[1], jax.ShapeDtypeStruct((), float)
    e, coordinates = jax.ShapeDtypeStruct((n,), float), jax.ShapeDtypeStruct(block.x.shape[1:], float)
    own = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(np.shape(leaf)[1:], float), properties)
    heat = tuple(jax.ShapeDtypeStruct((k,), float) for k in heat_sizes(block.element))
    of = {"energy": (e,), "surface": (e,), "dissipation": (e, e), "law": (e, e), "thermal": heat}
    taken: Any = of.get(companion, coordinates)
    wrench = jax.ShapeDtypeStruct((6,), float)
    along = {"resultants": {"place": place, "sigma": e}, "surface": {"place": place, "resultants": wrench}}
    extra: dict[str, Any] = dict(along.get(companion, {}))
    if companion == "deformation" and block.element.tracks_angle:
        extra["near"] = e
    return captured(lambda x, ref, own, extra: function(x, ref, own, **extra), taken, coordinates, own, extra)


def heat_sizes(element: Element) -> tuple[int, ...]:
    """How many numbers each argument of an element's thermal deformations has: the change, and the gradient."""
    axes = next(iter(element.nodes.values())).dimension
    return (2, axes - 1) if element.bends_by_heat else (2,)


def with_rigidities(properties: dict[str, Any]) -> dict[str, Any]:
    """Stacked properties with one stack of sections, where they are of several kinds."""
    sections = properties.get("section")
    return {**properties, "section": _rigidities(sections)} if isinstance(sections, tuple) else properties


@traced_once
def _rigidities(stacks: tuple[Section, ...]) -> Rigidity:
    """Numbers of stacked sections of several kinds, one after the other, as one stack."""
    # What does not state how it expands takes no temperature.
    like = Rigidity(alpha=0.0)

    def numbers(section: Section):
        own = section.rigidity()
        own = own if own.expands else dataclasses.replace(own, alpha=0.0)
        return jnp.stack([jnp.asarray(number, float) for number in jax.tree.leaves(own)])

    columns = jnp.concatenate([jax.vmap(numbers)(stack) for stack in stacks])
    return jax.tree.unflatten(jax.tree.structure(like), list(columns.T))


def scatter_matrix(size: tuple[int, int], pieces: list[tuple[Array, Array, Array]]) -> Float[Array, "rows columns"]:
    """Sum of element matrices in a matrix of the whole.

    Args:
        pieces: Row indices (elements, r), column indices (elements, c) and matrices (elements, r, c).
    """
    return scatter_matrices(size, [(rows, columns, (matrices,)) for rows, columns, matrices in pieces], 1)[0]


def scatter_matrices(
    size: tuple[int, int], pieces: list[tuple[Array, Array, tuple[Array, ...]]], count: int
) -> list[Float[Array, "rows columns"]]:
    """Sums of element matrices in several matrices of the whole.

    Args:
        pieces: Row indices (elements, r), column indices (elements, c) and matrices (elements, r, c), one a whole.
    """
    flat = [(rows[:, :, None] * size[1] + columns[:, None, :], matrices) for rows, columns, matrices in pieces]
    return [whole.reshape(size) for whole in scatter_vectors(size[0] * size[1], flat, count)]


def scatter_vector(size: int, pieces: list[tuple[Array, Array]]) -> Float[Array, "size"]:
    """Sum of element vectors in a vector of the whole."""
    return scatter_vectors(size, [(indices, (vectors,)) for indices, vectors in pieces], 1)[0]


def scatter_vectors(size: int, pieces: list[tuple[Array, tuple[Array, ...]]], count: int) -> list[Float[Array, "size"]]:
    """Sums of element vectors in several vectors of the whole, in one loop: each costs one to compile."""
    if not pieces:
        return [jnp.zeros(size)] * count
    indices = jnp.concatenate([indices.reshape(-1) for indices, _ in pieces])
    values = [jnp.concatenate([own[i].reshape(-1) for _, own in pieces]) for i in range(count)]
    if count == 1:
        return [accumulate(jnp.zeros(size), indices, values[0])]
    whole = accumulate(jnp.zeros((size, count)), indices, jnp.stack(values, axis=1))
    return [whole[:, i] for i in range(count)]
