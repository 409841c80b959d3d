"""Sparse systems with one additional row and column. They can be regular although the matrix alone is singular."""

from typing import Any

import numpy as np

from .sparse import SparseFactors


class Bordered:
    """Factors of [matrix, column; row, corner], built from the factors of the matrix, which may be nearly singular.

    Attributes:
        regular: Whether the bordered matrix is regular.

    Source:
        Govaerts (1991), Stable solvers and block elimination for bordered systems.
    """

    def __init__(self, matrix: Any, factored: SparseFactors, column: np.ndarray, row: np.ndarray, corner: float):
        """Prepare the solution, from the factors of the sparse matrix and its border."""
        self._column, self._row, self._corner = column, row, corner
        self._factored = factored if factored.regular else None
        if self._factored is None:
            self._whole, self.regular = self._factors_of_all(matrix)
            return
        self._across = factored.solve(column)
        left_solution = factored.solve(row, transposed=True)
        self._left, self._by_left, self._by_across = (
            left_solution,
            corner - left_solution @ column,
            corner - row @ self._across,
        )
        scalars = np.array([self._by_left, self._by_across])
        self.regular = bool(np.all(np.isfinite(scalars)) and np.all(scalars != 0) and np.all(np.isfinite(self._across)))

    def solve(self, right: np.ndarray, last: float) -> tuple[np.ndarray, float]:
        """Solution (z, w) of the bordered system for (right, last)."""
        if self._factored is None:
            z = self._whole.solve(np.append(right, self._by_row * last))
            return z[:-1], float(self._by_column * z[-1])
        first = (last - self._left @ right) / self._by_left
        z = self._factored.solve(right - first * self._column)
        second = (last - self._corner * first - self._row @ z) / self._by_across
        return z - second * self._across, float(first + second)

    def left(self) -> np.ndarray:
        """First part y of the solution of [y, w] [matrix, column; row, corner] = [0, 1]."""
        if self._factored is None:
            right_side = np.append(np.zeros_like(self._column), self._by_column)
            return self._whole.solve(right_side, transposed=True)[:-1]
        return -self._left / self._by_left

    def _factors_of_all(self, matrix: Any) -> tuple[SparseFactors, bool]:
        """Factors of the bordered matrix, scaled, if the matrix alone has none; and whether they are regular."""
        import scipy.sparse

        pivots = np.abs(matrix.diagonal())
        pivots = pivots[pivots > 0]
        # Entries of row and column get the mean size of the stiffnesses, so that pivots are chosen well.
        middle = float(np.exp(np.mean(np.log(pivots)))) if len(pivots) else 1.0
        entire = np.append(self._row, self._corner)
        self._by_row, self._by_column = (middle / max(float(np.max(np.abs(v))), 1e-300) for v in (entire, self._column))
        border = scipy.sparse.csc_array(np.asarray(self._by_column * self._column)[:, None])
        entire[-1] *= self._by_column
        below = scipy.sparse.csc_array(self._by_row * entire[None])
        factored = SparseFactors(scipy.sparse.vstack([scipy.sparse.hstack([matrix, border]), below]).tocsc())
        return factored, factored.regular
