"""Derivatives that are cheaper to compile than those that JAX finds by itself."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
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

    def of_varied(values):
        whole = list(leaves)
        for i, value in zip(varied, values, strict=True):
            whole[i] = value
        return function(*jax.tree.unflatten(structure, whole))

    return jax.jvp(of_varied, ([leaves[i] for i in varied],), ([changes[i] for i in varied],))


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
    def applied(x):
        return function(x)

    @applied.defjvp
    def _(primals, tangents):
        (x,), (change,) = primals, tangents
        slope = pointwise(lambda x: jax.jvp(function, (x,), (jnp.ones_like(x),))[1])
        return applied(x), slope(x) * change

    return applied
