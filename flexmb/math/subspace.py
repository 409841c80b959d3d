"""Rank, null spaces and independent rows by NumPy, since decisions about a model need concrete numbers.

Results are dense for a dense matrix and sparse for a sparse one. Each connected part of a sparse matrix is dense.
"""

from typing import Any, NamedTuple

import numpy as np

from ..compilation.threads import one_thread
from ..errors import MechanismError
from ..numerical_limits import EQUAL_ROWS, RANK_TOLERANCE, REPROJECTED
from .linear import uneven
from .sparse import SparseFactors

# Number of directions that are removed from all rows in one product.
DIRECTIONS_AT_ONCE = 32
# Most rows or columns in a connected part of a sparse matrix: singular values of 3000 take a minute.
MOST_CONNECTED = 3000
# Most numbers in a dense matrix, 1 GB.
MOST_NUMBERS = 2**27


class _Together(NamedTuple):
    """Rows and columns that are connected, (m,) and (n,), and their entries, (m, n)."""

    rows: np.ndarray
    columns: np.ndarray
    entries: np.ndarray


@one_thread()
def null_spaces(matrix: Any) -> tuple[int, Any, Any]:
    """Rank, and orthonormal bases of the left and right null space as columns; sparse for a sparse matrix.

    Raises MechanismError: too_large: too many rows of a sparse matrix are connected.
    """
    if isinstance(matrix, np.ndarray):
        return _null_spaces([matrix])[0]
    parts, rows, columns = _parts(matrix)
    decompositions = _null_spaces([part.entries for part in parts])
    left_parts = [(part.rows, vectors) for part, (_, vectors, _) in zip(parts, decompositions, strict=True)]
    right_parts = [(part.columns, vectors) for part, (_, _, vectors) in zip(parts, decompositions, strict=True)]
    m, n = matrix.shape
    return sum(rank for rank, _, _ in decompositions), _beside(left_parts, m, rows), _beside(right_parts, n, columns)


def _null_spaces(matrices: list[np.ndarray]) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Rank and null spaces of matrices that are parts of one; its largest singular value sets the tolerance."""
    decompositions = [
        np.linalg.svd(matrix) if matrix.size else (np.eye(matrix.shape[0]), np.zeros(0), np.eye(matrix.shape[1]))
        for matrix in matrices
    ]
    least = RANK_TOLERANCE * max((values[0] for _, values, _ in decompositions if values.size), default=0.0)
    ranks = [int(np.sum(values > least)) for _, values, _ in decompositions]
    return [
        (rank, left_vectors[:, rank:], right_vectors[rank:].T)
        for rank, (left_vectors, _, right_vectors) in zip(ranks, decompositions, strict=True)
    ]


@one_thread()
def independent_rows(candidates: Any, wanted: int, threshold: float) -> tuple[list[int], Any]:
    """Indices of the most independent rows, by pivoted Gram-Schmidt, and the projector onto their complement.

    Raises MechanismError: too_large: too many rows of sparse candidates are connected.
    """
    if isinstance(candidates, np.ndarray):
        chosen, directions, _ = _pivoted(candidates, wanted, threshold)
        return chosen, np.eye(candidates.shape[1]) - directions.T @ directions
    import scipy.sparse

    chosen, span_parts, sizes = [], [], []
    for part in _parts(candidates)[0]:
        row_indices, directions, part_sizes = _pivoted(part.entries, wanted, threshold)
        chosen += part.rows[row_indices].tolist()
        sizes += part_sizes
        span_parts += [(part.columns, direction[:, None]) for direction in directions]
    # Rows of different parts are independent of each other.
    best = np.argsort(-np.array(sizes), kind="stable")[: max(wanted, 0)]
    n = candidates.shape[1]
    span = _beside([span_parts[i] for i in best], n)
    return [chosen[i] for i in best], (scipy.sparse.eye_array(n) - span @ span.T).tocsr()


def _pivoted(candidates: np.ndarray, max_count: int, threshold: float) -> tuple[list[int], np.ndarray, list[float]]:
    """Indices of chosen rows, the unit directions that they add, as rows, and the sizes of these additions."""
    residual = np.array(candidates, float)
    count = max(min(max_count, *residual.shape), 0)
    directions = np.zeros((count, residual.shape[1]))
    chosen: list[int] = []
    sizes: list[float] = []
    # Chosen directions are removed from all rows, several at once; meanwhile only the squares of the rows follow.
    first, squares = 0, np.sum(residual**2, axis=1)
    before = np.max(squares, initial=0.0)
    while len(chosen) < count:
        largest = np.max(squares)
        if first < len(chosen) and (largest < REPROJECTED * before or len(chosen) - first == DIRECTIONS_AT_ONCE):
            recent = directions[first : len(chosen)]
            residual -= (residual @ recent.T) @ recent
            residual[chosen] = 0.0
            first, squares = len(chosen), np.sum(residual**2, axis=1)
            before = largest = np.max(squares)
        # Of equal rows choose the first, so that round-off does not decide.
        best = int(np.argmax(squares > EQUAL_ROWS**2 * largest))
        recent = directions[first : len(chosen)]
        direction = residual[best] - (residual[best] @ recent.T) @ recent
        size = float(np.linalg.norm(direction))
        if size <= threshold:
            break
        directions[len(chosen)] = direction = direction / size
        chosen.append(best)
        sizes.append(size)
        squares = np.maximum(squares - (residual @ direction) ** 2, 0.0)
        squares[chosen] = 0.0
    return chosen, directions[: len(chosen)], sizes


def determines(matrix: Any) -> bool:
    """Whether a square sparse matrix with entries of about one is regular."""
    import scipy.sparse

    if not matrix.shape[0]:
        return True
    factored = SparseFactors(scipy.sparse.csc_array(matrix))
    if not factored.regular:
        return False
    # Error of a product and solution by the factors: a measure of singularity.
    v = uneven(matrix.shape[0])
    solution = factored.solve(matrix @ v)
    return bool(np.max(np.abs(solution - v)) < RANK_TOLERANCE)


def row_sizes(matrix: Any) -> np.ndarray:
    """Euclidean norms of the rows of a dense or sparse matrix."""
    return np.sqrt(np.asarray((matrix * matrix).sum(axis=1)))


def scattered_rows(matrix: Any, rows: np.ndarray, size: int) -> Any:
    """A dense or sparse matrix with its rows among rows of zeros, (size, n)."""
    if isinstance(matrix, np.ndarray):
        full = np.zeros((size, matrix.shape[1]))
        full[rows] = matrix
        return full
    import scipy.sparse

    entries = matrix.tocoo()
    return scipy.sparse.csr_array(
        (entries.data, (rows[entries.coords[0]], entries.coords[1])), shape=(size, matrix.shape[1])
    )


def above(*matrices: Any) -> Any:
    """Matrices with equally many columns, stacked; sparse if one is."""
    if all(isinstance(matrix, np.ndarray) for matrix in matrices):
        return np.concatenate(matrices)
    import scipy.sparse

    return scipy.sparse.vstack(matrices).tocsr()


def dense(matrix: Any) -> np.ndarray:
    """Any matrix as a dense one. Raises MechanismError: too_large."""
    if isinstance(matrix, np.ndarray):
        return matrix
    if matrix.shape[0] * matrix.shape[1] > MOST_NUMBERS:
        m, n = matrix.shape
        raise MechanismError("too_large", f"{n} vectors of {m} numbers each take more than 1 GB. Name or fix more.")
    return matrix.toarray()


def _parts(matrix: Any) -> tuple[list[_Together], np.ndarray, np.ndarray]:
    """Connected parts of a sparse matrix, and its rows and columns without entries."""
    import scipy.sparse
    from scipy.sparse.csgraph import connected_components

    matrix = scipy.sparse.coo_array(matrix)
    matrix.eliminate_zeros()
    (m, _), (rows, columns) = matrix.shape, matrix.coords
    graph = scipy.sparse.coo_array((np.ones(len(rows)), (rows, m + columns)), shape=(sum(matrix.shape),) * 2)
    count, labels = connected_components(graph, directed=False)
    members = _split(np.arange(len(labels)), labels, count)
    place = np.empty(len(labels), int)
    for indices in members:
        place[indices] = np.arange(len(indices))
    of_row = np.bincount(labels[:m], minlength=count)
    parts = []
    for part, entries in zip(members, _split(np.arange(len(rows)), labels[rows], count), strict=True):
        if not len(entries):
            continue
        m_own = of_row[labels[part[0]]]
        if max(m_own, len(part) - m_own) > MOST_CONNECTED:
            raise MechanismError(
                "too_large",
                f"{m_own} deformations and {len(part) - m_own} coordinates are connected, too many to find the"
                f" remaining motions: {MOST_CONNECTED} at most. Leave that out with build(check=False): sparse"
                " solvers need no degrees of freedom.",
            )
        block = np.zeros((m_own, len(part) - m_own))
        block[place[rows[entries]], place[m + columns[entries]] - m_own] = matrix.data[entries]
        parts.append(_Together(part[:m_own], part[m_own:] - m, block))
    lonely = np.concatenate([indices for indices in members if len(indices) == 1] or [np.zeros(0, int)])
    return parts, lonely[lonely < m], lonely[lonely >= m] - m


def _split(items: np.ndarray, labels: np.ndarray, count: int) -> list[np.ndarray]:
    """Items of each label, in order."""
    order = np.argsort(labels, kind="stable")
    return np.split(items[order], np.searchsorted(labels[order], np.arange(1, count)))


def _beside(blocks: list[tuple[np.ndarray, np.ndarray]], size: int, alone: Any = ()) -> Any:
    """Sparse matrix of blocks of columns side by side, each in its rows, and then unit columns at rows ``alone``."""
    import scipy.sparse

    rows, columns, entries, count = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)], 0
    for places, block in blocks:
        more = block.shape[1]
        rows.append(np.repeat(places, more))
        columns.append(np.tile(np.arange(count, count + more), len(places)))
        entries.append(block.ravel())
        count += more
    rows.append(np.asarray(alone, int))
    columns.append(np.arange(count, count + len(alone)))
    entries.append(np.ones(len(alone)))
    at = np.concatenate(rows), np.concatenate(columns)
    return scipy.sparse.csr_array((np.concatenate(entries), at), shape=(size, count + len(alone)))
