"""Derivatives that are cheaper to compile than those that JAX finds by itself."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero


def jvp_of_varied(function: Callable[..., Any], primals: tuple, tangents: tuple) -> tuple[Any, Any]:
    """As ``jax.jvp``, for tangents of which many are symbolic zeros: nothing is traced for those.

    Args:
        function: Function of positional pytrees.
        primals: Its arguments.
        tangents: Their changes; a leaf may be a ``SymbolicZero``.

    Returns:
        Value of the function and its change.
    """
    leaves, structure = jax.tree.flatten(primals)
    changes = jax.tree.leaves(tangents, is_leaf=lambda t: isinstance(t, SymbolicZero))
    varied = [i for i, change in enumerate(changes) if not isinstance(change, SymbolicZero)]

    def of_varied(values: list[Any]):
        whole = list(leaves)
        for i, value in zip(varied, values, strict=True):
            whole[i] = value
        return function(*jax.tree.unflatten(structure, whole))

    return jax.jvp(of_varied, ([leaves[i] for i in varied],), ([changes[i] for i in varied],))


def _number_of(change: Any) -> Any:
    """A change, zeros where it is known to be none."""
    shaped: Any = change
    return jnp.zeros(shaped.shape, shaped.dtype) if isinstance(change, SymbolicZero) else change


def with_derivative(function: Callable[..., Any], derived: Callable[..., Any], *arguments: Any) -> Any:
    """Value of a function whose derivatives, in reverse mode, are those of another one that gives the same.

    Args:
        function: Function of positional pytrees, which may hold more than arrays.
        derived: What is evaluated in its place where a derivative is asked for.
        arguments: What both are given.
    """
    leaves, structure = jax.tree.flatten(arguments)
    places = [i for i, leaf in enumerate(leaves) if isinstance(leaf, jax.Array | np.ndarray)]

    def called(which: Callable[..., Any], numbers: Sequence[Any]):
        whole = list(leaves)
        for i, number in zip(places, numbers, strict=True):
            whole[i] = number
        return which(*jax.tree.unflatten(structure, whole))

    @jax.custom_vjp
    def value(*numbers: Any):
        return called(function, numbers)

    def forward(*numbers: Any):
        values = [number.value for number in numbers]
        varied = [i for i, number in enumerate(numbers) if number.perturbed]

        def of_varied(*changed: Any):
            whole = list(values)
            for i, number in zip(varied, changed, strict=True):
                whole[i] = number
            return called(derived, whole)

        found, pulled = jax.vjp(of_varied, *[values[i] for i in varied])
        # An empty tuple marks what varies: what is carried over may hold arrays alone.
        return found, (pulled, [() if number.perturbed else None for number in numbers])

    def backward(carried: tuple[Any, ...], changes: Any):
        pulled, marks = carried
        whole = [_number_of(change) for change in jax.tree.leaves(changes)]
        found = iter(pulled(jax.tree.unflatten(jax.tree.structure(changes), whole)))
        return tuple(None if mark is None else next(found) for mark in marks)

    value.defvjp(forward, backward, symbolic_zeros=True)
    return value(*[leaves[i] for i in places])


def pointwise(function: Callable[[jax.Array], jax.Array]) -> Callable[[jax.Array], jax.Array]:
    """A function of one number, applied to each of an array, whose derivatives are found once a number.

    JAX carries all directions of a derivative through each operation of the function; here its slope is one number,
    by which each direction is multiplied.

    Args:
        function: Of an array of any shape, element by element.

    Returns:
        The same function, which may be differentiated any number of times.
    """

    @jax.custom_jvp
    def applied(x: jax.Array):
        return function(x)

    @applied.defjvp
    def _(primals: tuple[jax.Array, ...], tangents: tuple[jax.Array, ...]):
        (x,), (change,) = primals, tangents
        slope = pointwise(lambda x: jax.jvp(function, (x,), (jnp.ones_like(x),))[1])
        return applied(x), slope(x) * change

    return applied
