"""Directional derivatives for the derivative rules of solvers."""

from collections.abc import Callable
from typing import Any

import jax
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
