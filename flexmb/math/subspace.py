"""Rank, null spaces and independent rows, on the host: decisions about a model are made from concrete numbers.

Of a dense matrix they are dense, of a sparse one sparse: what hangs together by its entries is a dense matrix each.
"""

from typing import Any, NamedTuple

import numpy as np

from ..compilation.threads import one_thread
from ..errors import MechanismError
from .linear import uneven
from .sparse import SparseFactors

# Singular values below this share of the largest count as zero: the predecessor's choice, square root of round-off.
RANK_TOLERANCE = float(np.sqrt(np.finfo(float).eps))
# Rows are projected for so many directions at once, or as soon as their squares are below this share of what they were:
# differences have lost so many digits then.
TOGETHER, REFRESHED = 32, 1e-6
# So many rows or columns of a sparse matrix may hang together: of 3000 the singular values take a minute.
MOST_TOGETHER = 3000
# Numbers of a dense matrix, of 1 GB.
MOST_NUMBERS = 2**27


class _Together(NamedTuple):
    """Rows and columns that hang together, (m,) and (n,), and their entries, (m, n)."""

    rows: np.ndarray
    columns: np.ndarray
    entries: np.ndarray


@one_thread()
def null_spaces(matrix: Any) -> tuple[int, Any, Any]:
    """Rank and orthonormal bases of the left and right null space.

    Raises MechanismError: too_large, of a sparse matrix of which too many rows hang together.

    Returns:
        Rank, left null vectors as columns (m, m - rank), right null vectors as columns (n, n - rank); sparse where the
        matrix is.
    """
    if isinstance(matrix, np.ndarray):
        return _null_spaces([matrix])[0]
    parts, rows, columns = _parts(matrix)
    found = _null_spaces([part.entries for part in parts])
    left = [(part.rows, own) for part, (_, own, _) in zip(parts, found, strict=True)]
    right = [(part.columns, own) for part, (_, _, own) in zip(parts, found, strict=True)]
    m, n = matrix.shape
    return sum(rank for rank, _, _ in found), _beside(left, m, rows), _beside(right, n, columns)


def _null_spaces(matrices: list[np.ndarray]) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Of several matrices that are parts of one, the largest singular value of which says what counts as zero."""
    found = [
        np.linalg.svd(own) if own.size else (np.eye(own.shape[0]), np.zeros(0), np.eye(own.shape[1]))
        for own in matrices
    ]
    least = RANK_TOLERANCE * max((values[0] for _, values, _ in found if values.size), default=0.0)
    ranks = [int(np.sum(values > least)) for _, values, _ in found]
    return [(rank, left[:, rank:], right[rank:].T) for rank, (left, _, right) in zip(ranks, found, strict=True)]


@one_thread()
def independent_rows(candidates: Any, wanted: int, threshold: float) -> tuple[list[int], Any]:
    """Choose rows that are as independent as can be, by pivoted Gram-Schmidt.

    Raises MechanismError: too_large, of a sparse matrix of which too many rows hang together.

    Returns:
        Indices of the chosen rows, the first chosen first, and the projector (n, n) onto what they do not span; sparse
        where the candidates are.
    """
    if isinstance(candidates, np.ndarray):
        chosen, directions, _ = _pivoted(candidates, wanted, threshold)
        return chosen, np.eye(candidates.shape[1]) - directions.T @ directions
    import scipy.sparse

    chosen, taken, sizes = [], [], []
    for part in _parts(candidates)[0]:
        own, directions, left = _pivoted(part.entries, wanted, threshold)
        chosen += part.rows[own].tolist()
        sizes += left
        taken += [(part.columns, direction[:, None]) for direction in directions]
    # What is left of a row does not depend on the rows of other parts.
    best = np.argsort(-np.array(sizes), kind="stable")[: max(wanted, 0)]
    n = candidates.shape[1]
    span = _beside([taken[i] for i in best], n)
    return [chosen[i] for i in best], (scipy.sparse.eye_array(n) - span @ span.T).tocsr()


def _pivoted(candidates: np.ndarray, wanted: int, threshold: float) -> tuple[list[int], np.ndarray, list[float]]:
    """Indices of chosen rows, the directions that each of them adds, as rows, and what was left of it."""
    rest = np.array(candidates, float)
    count = max(min(wanted, *rest.shape), 0)
    directions = np.zeros((count, rest.shape[1]))
    chosen: list[int] = []
    sizes: list[float] = []
    # What chosen directions take out is taken out of all rows for several at once; in between, of their sizes alone.
    first, squares = 0, np.sum(rest**2, axis=1)
    before = np.max(squares, initial=0.0)
    while len(chosen) < count:
        largest = np.max(squares)
        if first < len(chosen) and (largest < REFRESHED * before or len(chosen) - first == TOGETHER):
            own = directions[first : len(chosen)]
            rest -= (rest @ own.T) @ own
            rest[chosen] = 0.0
            first, squares = len(chosen), np.sum(rest**2, axis=1)
            before = largest = np.max(squares)
        # Among equals the first: a rounding difference must not decide.
        best = int(np.argmax(squares > (1 - 1e-6) ** 2 * largest))
        own = directions[first : len(chosen)]
        direction = rest[best] - (rest[best] @ own.T) @ own
        size = float(np.linalg.norm(direction))
        if size <= threshold:
            break
        directions[len(chosen)] = direction = direction / size
        chosen.append(best)
        sizes.append(size)
        squares = np.maximum(squares - (rest @ direction) ** 2, 0.0)
        squares[chosen] = 0.0
    return chosen, directions[: len(chosen)], sizes


def determines(matrix: Any) -> bool:
    """Whether a square sparse matrix, its rows and columns of about unit size, is regular; by sparse factors."""
    import scipy.sparse

    if not matrix.shape[0]:
        return True
    factored = SparseFactors(scipy.sparse.csc_array(matrix))
    if not factored.regular:
        return False
    # What it makes of a vector, and back again: round-off says how near to singular it is.
    v = uneven(matrix.shape[0])
    found = factored.solve(matrix @ v)
    return bool(np.max(np.abs(found - v)) < RANK_TOLERANCE)


def row_sizes(matrix: Any) -> np.ndarray:
    """Euclidean norm of each row of a dense or sparse matrix (m, n), (m,)."""
    return np.sqrt(np.asarray((matrix * matrix).sum(axis=1)))


def spread(matrix: Any, rows: np.ndarray, size: int) -> Any:
    """Rows of a dense or sparse matrix among others that are zero, (size, n)."""
    if isinstance(matrix, np.ndarray):
        full = np.zeros((size, matrix.shape[1]))
        full[rows] = matrix
        return full
    import scipy.sparse

    own = matrix.tocoo()
    return scipy.sparse.csr_array((own.data, (rows[own.coords[0]], own.coords[1])), shape=(size, matrix.shape[1]))


def above(*matrices: Any) -> Any:
    """Matrices of as many columns one above the other, sparse where one is."""
    if all(isinstance(matrix, np.ndarray) for matrix in matrices):
        return np.concatenate(matrices)
    import scipy.sparse

    return scipy.sparse.vstack(matrices).tocsr()


def dense(matrix: Any) -> np.ndarray:
    """A dense or sparse matrix as a dense one. Raises MechanismError: too_large."""
    if isinstance(matrix, np.ndarray):
        return matrix
    if matrix.shape[0] * matrix.shape[1] > MOST_NUMBERS:
        m, n = matrix.shape
        raise MechanismError("too_large", f"{n} vectors of {m} numbers each take more than 1 GB. Name or fix more.")
    return matrix.toarray()


def _parts(matrix: Any) -> tuple[list[_Together], np.ndarray, np.ndarray]:
    """What hangs together by the entries of a sparse matrix, and rows and columns without an entry."""
    import scipy.sparse
    from scipy.sparse.csgraph import connected_components

    matrix = scipy.sparse.coo_array(matrix)
    matrix.eliminate_zeros()
    (m, _), (rows, columns) = matrix.shape, matrix.coords
    graph = scipy.sparse.coo_array((np.ones(len(rows)), (rows, m + columns)), shape=(sum(matrix.shape),) * 2)
    count, labels = connected_components(graph, directed=False)
    members = _split(np.arange(len(labels)), labels, count)
    place = np.empty(len(labels), int)
    for own in members:
        place[own] = np.arange(len(own))
    of_row = np.bincount(labels[:m], minlength=count)
    parts = []
    for part, entries in zip(members, _split(np.arange(len(rows)), labels[rows], count), strict=True):
        if not len(entries):
            continue
        m_own = of_row[labels[part[0]]]
        if max(m_own, len(part) - m_own) > MOST_TOGETHER:
            raise MechanismError(
                "too_large",
                f"{m_own} deformations and {len(part) - m_own} coordinates hang together, and which motions are left"
                f" is found of {MOST_TOGETHER} at most. Leave that out with build(check=False), after which"
                " sparse factors need no degrees of freedom.",
            )
        own = np.zeros((m_own, len(part) - m_own))
        own[place[rows[entries]], place[m + columns[entries]] - m_own] = matrix.data[entries]
        parts.append(_Together(part[:m_own], part[m_own:] - m, own))
    lonely = np.concatenate([own for own in members if len(own) == 1] or [np.zeros(0, int)])
    return parts, lonely[lonely < m], lonely[lonely >= m] - m


def _split(things: np.ndarray, labels: np.ndarray, count: int) -> list[np.ndarray]:
    """Things of each label, in their order."""
    order = np.argsort(labels, kind="stable")
    return np.split(things[order], np.searchsorted(labels[order], np.arange(1, count)))


def _beside(blocks: list[tuple[np.ndarray, np.ndarray]], size: int, alone: Any = ()) -> Any:
    """Columns beside each other, (size, all), sparse: of each block, with the rows where it stands; then unit ones."""
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
