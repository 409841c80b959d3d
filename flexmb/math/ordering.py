"""Orders in which the rows of a symmetric sparse matrix are eliminated."""

from typing import Any

import numpy as np


def postponed(matrix: Any, ordering: np.ndarray, least: float) -> np.ndarray:
    """Order in which rows without a diagonal entry come after their neighbours, which fill it.

    Those are the rows of constraints, and of what only constraints hold. So no rows change places, and the signs of
    the pivots tell the matrix's inertia.

    Args:
        matrix: Sparse, (n, n), of entries near one.
        ordering: Order of elimination that keeps the factors sparse, (n,).
        least: Entries below this are none.

    Source:
        The Schur complement -D K^-1 D^T of independent constraints is regular where K is.
    """
    diagonal = np.abs(matrix.diagonal())
    known = diagonal > least
    if np.all(known):
        return ordering
    place = np.empty(len(ordering))
    place[ordering] = np.arange(len(ordering))
    entries = matrix.tocoo()
    rows, columns = entries.coords
    joined = (np.abs(entries.data) > least) & (rows != columns) & ~known[rows]
    rows, columns = rows[joined], columns[joined]
    time, level = place.copy(), np.zeros(len(ordering))
    for turn in range(1, len(ordering)):
        # Rows that have a neighbour of those whose turn has come.
        beside = known[columns] & ~known[rows]
        if not np.any(beside):
            break
        np.maximum.at(time, rows[beside], time[columns[beside]])
        level[rows[beside]] = turn
        known[rows[beside]] = True
    return np.lexsort((place, level, time))
