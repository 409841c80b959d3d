"""Nested dissection: an order of elimination. For meshes it causes less fill-in than other orders."""

from typing import Any

import numpy as np

# Unknowns with equal neighbours are one vertex. Smaller graphs are not divided further.
SMALL = 24
# Least share of the vertices in the smaller half, where possible.
SHARE = 0.35
# Attempts to find two vertices far apart.
TRIES = 4


def dissected(matrix: Any) -> np.ndarray:
    """Order of elimination of a sparse matrix of symmetric pattern; each separator comes after both of its halves.

    Source:
        THEORY.md 9. George (1973); George and Liu (1978): levels have equal distances from a vertex at the border. Here
        the smallest level near the middle separates.
    """
    import scipy.sparse

    n = matrix.shape[0]
    # Equal neighbours have equal sums of random numbers.
    graph = scipy.sparse.csr_array((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    _, first, vertex = np.unique(graph @ np.random.default_rng(0).random(n), return_index=True, return_inverse=True)
    unknowns = np.split(np.argsort(vertex, kind="stable"), np.cumsum(np.bincount(vertex))[:-1])
    graph = graph[first][:, first]
    order: list[np.ndarray] = []
    # Separators are eliminated last and found first: the order is reversed at the end.
    pending = [np.arange(len(first))]
    while pending:
        among = pending.pop()
        parts = _parts(graph[among][:, among]) if len(among) > SMALL else ()
        if parts:
            *halves, between = parts
            order.append(among[between])
            pending.extend(among[half] for half in halves)
        else:
            order.append(among)
    vertices = np.concatenate(order[::-1]) if order else np.arange(0)
    return np.concatenate([unknowns[place] for place in vertices]) if n else np.arange(0)


def _parts(graph: Any) -> tuple[np.ndarray, ...]:
    """Parts joined only by the last one, a separator; empty if the graph cannot be divided."""
    from scipy.sparse.csgraph import connected_components, dijkstra

    count, component = connected_components(graph, directed=False)
    if count > 1:
        return *(np.flatnonzero(component == number) for number in range(count)), np.zeros(0, int)
    begin, levels = 0, np.zeros(graph.shape[0], int)
    for _ in range(TRIES):
        distances = dijkstra(graph, unweighted=True, indices=begin).astype(int)
        if np.max(distances) <= np.max(levels):
            break
        levels = distances
        farthest = np.flatnonzero(levels == np.max(levels))
        begin = farthest[np.argmin(np.diff(graph.indptr)[farthest])]
    sizes = np.bincount(levels)
    before = np.cumsum(sizes) - sizes
    smaller = np.minimum(before, len(levels) - before - sizes)
    if np.max(smaller) == 0:
        return ()
    even = smaller >= min(SHARE * len(levels), np.max(smaller))
    middle = int(np.argmin(np.where(even, sizes, len(levels))))
    # Vertices without a neighbour beyond do not separate.
    beyond = graph @ (levels == middle + 1) > 0
    between = (levels == middle) & beyond
    return tuple(np.flatnonzero(part) for part in ((levels <= middle) & ~between, levels > middle, between))
