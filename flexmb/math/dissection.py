"""An order of elimination by nested dissection, for meshes whose factors another order fills."""

from typing import Any

import numpy as np

# Unknowns of equal neighbours are one vertex; graphs of so many are not divided further.
SMALL = 24
# A graph is divided into two of which the smaller one has this share of the vertices at least, where that is possible.
SHARE = 0.35
# Vertices from which levels begin, each far from the last.
TRIES = 4


def dissected(matrix: Any) -> np.ndarray:
    """Order of elimination of a matrix of symmetric pattern: what separates two halves comes after both.

    Args:
        matrix: Sparse, by columns, (n, n).

    Returns:
        Of the unknowns, (n,).

    Source:
        THEORY.md 9. George (1973); George and Liu (1978), whose levels have equal distances from a vertex at the
        border; here the smallest of them about the middle separates.
    """
    import scipy.sparse

    n = matrix.shape[0]
    # Equal neighbours have equal sums of random numbers.
    graph = scipy.sparse.csr_array((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    _, first, vertex = np.unique(graph @ np.random.default_rng(0).random(n), return_index=True, return_inverse=True)
    unknowns = np.split(np.argsort(vertex, kind="stable"), np.cumsum(np.bincount(vertex))[:-1])
    graph = graph[first][:, first]
    order: list[np.ndarray] = []
    # The last ones are found first.
    left = [np.arange(len(first))]
    while left:
        among = left.pop()
        parts = _parts(graph[among][:, among]) if len(among) > SMALL else ()
        if parts:
            *halves, between = parts
            order.append(among[between])
            left.extend(among[half] for half in halves)
        else:
            order.append(among)
    vertices = np.concatenate(order[::-1]) if order else np.arange(0)
    return np.concatenate([unknowns[one] for one in vertices]) if n else np.arange(0)


def _parts(graph: Any) -> tuple[np.ndarray, ...]:
    """Vertices of parts that are not joined but by the last one; nothing where a graph cannot be divided."""
    from scipy.sparse.csgraph import connected_components, dijkstra

    count, component = connected_components(graph, directed=False)
    if count > 1:
        return *(np.flatnonzero(component == one) for one in range(count)), np.zeros(0, int)
    begin, levels = 0, np.zeros(graph.shape[0], int)
    for _ in range(TRIES):
        found = dijkstra(graph, unweighted=True, indices=begin).astype(int)
        if np.max(found) <= np.max(levels):
            break
        levels = found
        farthest = np.flatnonzero(levels == np.max(levels))
        begin = farthest[np.argmin(np.diff(graph.indptr)[farthest])]
    sizes = np.bincount(levels)
    before = np.cumsum(sizes) - sizes
    smaller = np.minimum(before, len(levels) - before - sizes)
    if np.max(smaller) == 0:
        return ()
    even = smaller >= min(SHARE * len(levels), np.max(smaller))
    middle = int(np.argmin(np.where(even, sizes, len(levels))))
    # What has no neighbour beyond does not separate.
    beyond = graph @ (levels == middle + 1) > 0
    between = (levels == middle) & beyond
    return tuple(np.flatnonzero(of) for of in ((levels <= middle) & ~between, levels > middle, between))
