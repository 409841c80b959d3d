"""Writing and adding at index arrays: faster, since no index is negative; sums of element vectors and matrices."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

TRUSTED = {"mode": "promise_in_bounds", "wrap_negative_indices": False}


def put(whole: Any, indices: Any, values: ArrayLike) -> Any:
    """Copy of an array of NumPy or JAX with rows replaced; no index repeats."""
    if _known(whole, values):
        result = np.array(whole)
        result[indices] = values
        return result
    return jnp.asarray(whole).at[indices].set(values, unique_indices=True, **TRUSTED)


def accumulate(whole: Any, indices: Any, values: ArrayLike) -> Any:
    """Copy of an array of NumPy or JAX with values added; indices may repeat."""
    if _known(whole, values):
        result = np.array(whole)
        np.add.at(result, indices, values)
        return result
    return jnp.asarray(whole).at[indices].add(values, **TRUSTED)


def _known(array: Any, values: ArrayLike) -> bool:
    return isinstance(array, np.ndarray) and not isinstance(values, jax.Array)


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
