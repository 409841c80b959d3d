"""Sparse matrices and their factors, on the host."""

from typing import Any

import numpy as np

# Pivots this much smaller than the largest, of a matrix scaled to entries of one, are round-off.
SINGULAR = 1e-14


def sparse_matrix(size: tuple[int, int], pieces) -> Any:
    """Sum of element matrices, as ``mechanics.blocks.scatter_matrix`` for a dense one.

    Args:
        size: Shape of the whole.
        pieces: Row indices (elements, r), column indices (elements, c) and matrices (elements, r, c).
    """
    import scipy.sparse

    if not pieces:
        return scipy.sparse.csr_array(size)
    shapes = [np.asarray(matrices).shape for _, _, matrices in pieces]
    rows = [np.broadcast_to(np.asarray(r)[:, :, None], s).ravel() for (r, _, _), s in zip(pieces, shapes, strict=True)]
    columns = [
        np.broadcast_to(np.asarray(c)[:, None, :], s).ravel() for (_, c, _), s in zip(pieces, shapes, strict=True)
    ]
    data = np.concatenate([np.asarray(matrices).ravel() for _, _, matrices in pieces])
    return scipy.sparse.coo_array((data, (np.concatenate(rows), np.concatenate(columns))), shape=size).tocsr()


class SparseFactors:
    """Sparse factors of a symmetric matrix, rows and columns scaled alike, with one step of refinement.

    Attributes:
        matrix: The scaled matrix.
        scale: What its rows and columns were multiplied by, (n,).
        factors: LU factors by SuperLU, where the matrix is regular.
        regular: Whether the factors can be trusted.
    """

    def __init__(self, matrix: Any):
        import scipy.sparse
        import scipy.sparse.linalg

        largest = np.sqrt(abs(matrix).max(axis=1).toarray().ravel())
        self.scale = 1 / np.where(largest > 0, largest, 1.0)
        scaling = scipy.sparse.diags_array(self.scale)
        self.matrix = (scaling @ matrix @ scaling).tocsc()
        try:
            self.factors = scipy.sparse.linalg.splu(self.matrix, permc_spec="COLAMD")
            pivots = np.abs(self.factors.U.diagonal())
            self.regular = bool(np.all(np.isfinite(pivots)) and np.min(pivots) > SINGULAR * np.max(pivots))
        except RuntimeError:
            self.regular = False

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solution of A z = right."""
        wanted = self.scale * np.asarray(right)
        z = self.factors.solve(wanted)
        return self.scale * (z + self.factors.solve(wanted - self.matrix @ z))
