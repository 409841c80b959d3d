"""Writing and adding at index arrays without a negative or a repeated entry, which JAX would otherwise provide for."""

from typing import Any

from jaxtyping import Array, ArrayLike

TRUSTED = {"mode": "promise_in_bounds", "wrap_negative_indices": False}


def put(whole: Array, indices: Any, values: ArrayLike) -> Array:
    """Copy of an array with rows replaced.

    Args:
        indices: Where, each at most once; arrays within bounds.

    Returns:
        Array of the shape of ``whole``.
    """
    return whole.at[indices].set(values, unique_indices=True, **TRUSTED)


def accumulate(whole: Array, indices: Any, values: ArrayLike) -> Array:
    """Copy of an array with values added; an index may repeat.

    Args:
        indices: Where; arrays within bounds.

    Returns:
        Array of the shape of ``whole``.
    """
    return whole.at[indices].add(values, **TRUSTED)
