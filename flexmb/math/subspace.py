"""Rank, null spaces and independent rows, on the host: decisions about a model are made from concrete numbers."""

import numpy as np

from ..compilation.threads import one_thread

# Singular values below this share of the largest count as zero: the predecessor's choice, square root of round-off.
RANK_TOLERANCE = float(np.sqrt(np.finfo(float).eps))


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
    projector = np.eye(rest.shape[1])
    chosen: list[int] = []
    while len(chosen) < wanted and rest.shape[0]:
        sizes = np.linalg.norm(rest, axis=1)
        # Among equals the first: a rounding difference must not decide.
        best = int(np.argmax(sizes > (1 - 1e-6) * sizes.max()))
        if sizes[best] <= threshold:
            break
        chosen.append(best)
        direction = rest[best] / sizes[best]
        rest = rest - np.outer(rest @ direction, direction)
        rest[chosen] = 0.0
        projector = projector - np.outer(projector @ direction, direction)
    return chosen, projector
