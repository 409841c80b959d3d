"""Rank, null spaces and independent rows, on the host: decisions about a model are made from concrete numbers."""

import numpy as np

from ..compilation.threads import one_thread

# Singular values below this share of the largest count as zero: the predecessor's choice, square root of round-off.
RANK_TOLERANCE = float(np.sqrt(np.finfo(float).eps))
# Rows are projected for so many directions at once, or as soon as their squares are below this share of what they were:
# differences have lost so many digits then.
TOGETHER, REFRESHED = 32, 1e-6


@one_thread()
def null_spaces(matrix: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
    """Rank and orthonormal bases of the left and right null space.

    Returns:
        Rank, left null vectors as columns (m, m - rank), right null vectors as columns (n, n - rank).
    """
    m, n = matrix.shape
    if m == 0 or n == 0:
        return 0, np.eye(m), np.eye(n)
    u, s, vt = np.linalg.svd(matrix)
    rank = int(np.sum(s > RANK_TOLERANCE * s[0])) if s[0] > 0 else 0
    return rank, u[:, rank:], vt[rank:].T


@one_thread()
def independent_rows(candidates: np.ndarray, wanted: int, threshold: float) -> tuple[list[int], np.ndarray]:
    """Choose rows that are as independent as can be, by pivoted Gram-Schmidt.

    Args:
        wanted: How many rows to choose at most.
        threshold: A row is taken only while what is left of it exceeds this.

    Returns:
        Indices of the chosen rows, and the projector (n, n) onto what they do not span.
    """
    rest = np.array(candidates, float)
    count = min(wanted, *rest.shape)
    directions = np.zeros((max(count, 0), rest.shape[1]))
    chosen: list[int] = []
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
        size = np.linalg.norm(direction)
        if size <= threshold:
            break
        directions[len(chosen)] = direction = direction / size
        chosen.append(best)
        squares = np.maximum(squares - (rest @ direction) ** 2, 0.0)
        squares[chosen] = 0.0
    taken = directions[: len(chosen)]
    projector = np.eye(rest.shape[1]) - taken.T @ taken
    return chosen, projector
