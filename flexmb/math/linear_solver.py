"""Solvers of the linear equations of a mechanism: the interface (factors, solutions, inertia), and two solvers.

A new solver is one class with the method of :class:`LinearSolver`. Pass it as ``solver=`` to a public function.
"""

import dataclasses
from typing import Protocol, runtime_checkable

import numpy as np

from ..numerical_limits import ZERO_SINGULAR_VALUE
from .element_matrices import AssembledEquations, ElementMatrices
from .sparse import negative_under_constraints


class FactoredEquations(Protocol):
    """Factors of [[A, D^T], [D, 0]], A = K + a M + b C, on the host.

    Attributes:
        regular: Whether the factors can be trusted.
    """

    regular: bool

    def solve(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        """Motions of the coordinates that move, then multipliers.

        Args:
            right: Forces on these coordinates, then deformations of the constraints, (n + h,) or (n + h, k).
            transposed: Whether A is transposed.
        """
        ...

    def negative(self) -> int | None:
        """Count negative eigenvalues of a symmetric A in the space D v = 0; None if the factors do not determine it."""
        ...


@runtime_checkable
class LinearSolver(Protocol):
    """Factors the equations of a mechanism. A solver is hashable and must not call JAX."""

    def factored(self, elements: ElementMatrices, mass: float = 0.0, damping: float = 0.0) -> FactoredEquations:
        """Factors of [[K + a M + b C, D^T], [D, 0]].

        Args:
            elements: Element matrices, with arrays of NumPy.
            mass: a, such as -shift [1/s^2].
            damping: b [1/s].

        Raises:
            AnalysisError: out_of_memory.
        """
        ...


@dataclasses.dataclass(frozen=True)
class SparseSolver:
    """Solver with sparse factors on the host. It finds the order of elimination once for a mechanism."""

    def factored(self, elements: ElementMatrices, mass: float = 0.0, damping: float = 0.0) -> "SparseFactored":
        """See :class:`LinearSolver`."""
        return SparseFactored(AssembledEquations(elements), mass, damping)


class SparseFactored:
    """See :class:`FactoredEquations`.

    Attributes:
        matrix: The matrix, sparse, (n + h, n + h).
        factors: Its factors.
        regular: Whether they can be trusted.
    """

    def __init__(self, assembled: AssembledEquations, mass: float, damping: float):
        self.matrix, self._n = assembled.at(mass, damping), assembled.n
        self.factors = assembled.factors(self.matrix)
        self.regular = self.factors.regular

    def solve(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        """See :class:`FactoredEquations`."""
        return self.factors.solve(right, transposed)

    def negative(self) -> int | None:
        """See :class:`FactoredEquations`."""
        return negative_under_constraints(self.matrix, self.factors, self._n)


@dataclasses.dataclass(frozen=True)
class DenseSolver:
    """Solver with dense matrices in the motions that the constraints allow, for a mechanism of few coordinates."""

    def factored(self, elements: ElementMatrices, mass: float = 0.0, damping: float = 0.0) -> "DenseFactored":
        """See :class:`LinearSolver`."""
        assembled = AssembledEquations(elements)
        return DenseFactored(assembled.at(mass, damping).toarray(), assembled.n, elements.sizes[elements.free])


class DenseFactored:
    """See :class:`FactoredEquations`.

    Attributes:
        regular: Whether the constraints are independent, and A regular in the motions that they allow.
    """

    def __init__(self, matrix: np.ndarray, n: int, sizes: np.ndarray):
        scaled = np.concatenate([sizes, np.ones(len(matrix) - n)])
        self._n, self._sizes, self._a = n, sizes, (scaled[:, None] * matrix * scaled)[:n, :n]
        rows = matrix[n:, :n] * sizes
        self._scale = 1 / np.maximum(np.max(np.abs(rows), axis=1, initial=0.0), np.finfo(float).tiny)
        left_vectors, values, right_vectors = np.linalg.svd(rows * self._scale[:, None], full_matrices=True)
        rank = int(np.sum(values > ZERO_SINGULAR_VALUE * np.max(values, initial=0.0)))
        self._inverse = right_vectors[:rank].T @ (left_vectors[:, :rank].T / values[:rank, None])
        self._allowed = right_vectors[rank:].T
        self._reduced = self._allowed.T @ self._a @ self._allowed
        pivots = np.linalg.svd(self._reduced, compute_uv=False)
        some = pivots.size == 0 or bool(np.all(np.isfinite(pivots)) and pivots[-1] > ZERO_SINGULAR_VALUE * pivots[0])
        self.regular = rank == len(rows) and some

    def solve(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        """See :class:`FactoredEquations`."""
        columns = right.reshape(len(right), -1)
        force, excess = self._sizes[:, None] * columns[: self._n], self._scale[:, None] * columns[self._n :]
        a, reduced = (self._a.T, self._reduced.T) if transposed else (self._a, self._reduced)
        onto = self._inverse @ excess
        moved = onto + self._allowed @ np.linalg.solve(reduced, self._allowed.T @ (force - a @ onto))
        pulled = self._scale[:, None] * (self._inverse.T @ (force - a @ moved))
        return np.concatenate([self._sizes[:, None] * moved, pulled]).reshape(right.shape)

    def negative(self) -> int | None:
        """See :class:`FactoredEquations`."""
        if not self.regular:
            return None
        return int(np.sum(np.linalg.eigvalsh((self._reduced + self._reduced.T) / 2) < 0))


SPARSE, DENSE = SparseSolver(), DenseSolver()
# By the text that ``solver=`` accepts.
SOLVERS: dict[str, LinearSolver] = {"sparse": SPARSE, "dense": DENSE}
