"""Eigenvalues by Lanczos iterations with sparse factors, including all copies of repeated eigenvalues."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..errors import AnalysisError
from ..math.linear import uneven
from ..math.linear_solver import FactoredEquations
from ..math.sparse import SparseFactors, equilibrating
from ..numerical_limits import INDEFINITE_FLEXIBILITY, LANCZOS_CONVERGED
from ..results import RESULTS

# All motions are computed if constraints leave at most this number, or three times the number wanted: Lanczos
# iterations that exhaust the motions continue with round-off.
FEW = 60
# Searches for missed eigenvalues; each finds at least one copy of every repeated one.
SEARCHES = 100


@contextlib.contextmanager
def named(try_this: str = "Ask for fewer") -> Iterator[None]:
    """Context in which failures of ARPACK raise not_converged, with the advice ``try_this``."""
    import scipy.sparse.linalg

    try:
        yield
    except scipy.sparse.linalg.ArpackError as fault:
        raise AnalysisError(
            RESULTS.not_converged.name,
            f"Eigenvalues were not found by sparse factors: {fault} {try_this}, or give sparse=False and a model with"
            " degrees of freedom.",
        ) from None


def with_all_copies(
    search: Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
    passed_over: Callable[[np.ndarray], bool],
    farness: Callable[[np.ndarray], np.ndarray],
    size: tuple[int, int],
) -> tuple[np.ndarray, np.ndarray]:
    """Sorted eigenvalues (count,) and motions (n, count) with all copies of repeated ones; ``size`` is (n, count).

    From one start, iterations find one motion of each eigenvalue; only round-off adds others.

    Args:
        search: Finds eigenvalues (count,) and orthonormal motions (n, count) beside known ones, from a start.
        passed_over: Whether there are more up to the last of some sorted eigenvalues.
        farness: Sorting key of eigenvalues.
    """

    def searched(*given: np.ndarray):
        with named():
            return search(*given)

    n, count = size
    start = uneven(n)
    values, motions = searched(np.zeros(0), np.zeros((n, 0)), start)
    for k in range(SEARCHES):
        order = np.argsort(farness(values), kind="stable")[:count]
        values, motions = values[order], motions[:, order]
        if not passed_over(values):
            return values, motions
        more, others = searched(values, motions, np.cos((k + 2) * np.arange(n) ** 2 + k))
        if np.min(farness(more)) >= farness(values)[-1]:
            return values, motions
        values, motions = np.concatenate([values, more]), np.concatenate([motions, others], axis=1)
    raise AnalysisError(RESULTS.not_converged.name, RESULTS.not_converged.message)


def eigenvalues_beside(
    matrix: Any,
    stiffness: Any,
    moved: Callable[[np.ndarray], np.ndarray],
    known: tuple[np.ndarray, np.ndarray],
    count: int,
    start: np.ndarray,
    **how: Any,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues of A v = m K v under constraints, with v^T K v = 1, by ARPACK in the inner product of K.

    Args:
        matrix, stiffness: Sparse symmetric A, and K, positive definite under the constraints, (n, n).
        moved: Motions under forces by K and the constraints.
        known: Known eigenvalues (k,) and motions (n, k); ``count`` others are sought.
        start: Allowed motion, (n,).
        how: Options of :func:`scipy.sparse.linalg.eigsh`.
    """
    import scipy.sparse.linalg

    linalg: Any = scipy.sparse.linalg
    values, motions = known
    # ARPACK uses the product with the first matrix for inner product and operator: remove known motions from this
    # matrix.
    forces = stiffness @ motions

    def beside(motion: np.ndarray):
        motion = np.ravel(motion)
        return matrix @ motion - forces @ (values * (forces.T @ motion))

    operator = linalg.LinearOperator(matrix.shape, matvec=beside, dtype=float)
    inverse = linalg.LinearOperator(matrix.shape, matvec=lambda force: moved(np.ravel(force)), dtype=float)
    return linalg.eigsh(operator, k=count, M=stiffness, Minv=inverse, v0=start, **how)


def changed(left: np.ndarray, motions: np.ndarray, matrix: Any) -> np.ndarray:
    """Change of motions by one more iteration, ``left``, over their own size, in the norm of a matrix."""
    wrong, size = (np.einsum("ij,ij->j", columns, matrix @ columns) for columns in (left, motions))
    return np.sqrt(np.abs(wrong) / size)


def check_modes(wrong: np.ndarray, what: str) -> None:
    """Raise not_converged if iterations for ``what`` have not converged, by :func:`changed`."""
    if not np.all(wrong <= LANCZOS_CONVERGED):
        raise AnalysisError(
            RESULTS.not_converged.name,
            f"The {what} were not found by sparse factors. Ask for fewer, or give sparse=False and a model with degrees"
            " of freedom.",
        )


class Constrained:
    """A symmetric K under constraints D v = 0, and its factors.

    Attributes:
        tangent: Sparse [[K, D^T], [D, 0]], (n + h, n + h).
        stiffness: K, (n, n).
        factors: Of the tangent.
    """

    def __init__(self, tangent: Any, n: int, factors: FactoredEquations):
        self.n, self.tangent, self.stiffness, self.factors = n, tangent, tangent[:n, :n], factors

    def solved(self, forces: np.ndarray) -> np.ndarray:
        """Motions and multipliers under forces, (n + h,) or (n + h, k)."""
        rest = np.zeros((self.tangent.shape[0] - self.n, *forces.shape[1:]))
        return self.factors.solve(np.concatenate([forces, rest]))

    def moved(self, forces: np.ndarray) -> np.ndarray:
        """Motions under forces, (n,) or (n, k)."""
        return self.solved(forces)[: self.n]

    def few(self, count: int) -> bool:
        """Whether constraints leave so few motions that all are computed."""
        return 2 * self.n - self.tangent.shape[0] <= max(FEW, 3 * count)

    def searched(self, matrix: Any, count: int, known: tuple[Any, Any] | None, start: np.ndarray, **how: Any):
        """:func:`eigenvalues_beside`, from a motion under the forces A x of a start x."""
        known = known or (np.zeros(0), np.zeros((self.n, 0)))
        first = self.moved(matrix @ start)
        return eigenvalues_beside(matrix, self.stiffness, self.moved, known, count, first, **how)

    def largest(
        self,
        matrix: Any,
        count: int,
        last: Callable[[np.ndarray], float | None],
        negative: Callable[[float], int | None],
        both: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Largest m of A v = m K v with all copies, and motions with v^T K v = 1; LinAlgError if K is indefinite.

        Args:
            last: Value up to which all are counted by inertia, from those found; None: no count.
            negative: Number of negative eigenvalues of K - A/m under the constraints, for m; None: not known.
            both: Whether to include negative ones, by size.
        """
        if self.few(count):
            return AllowedMotions(self.tangent, SparseFactors(self.tangent), self.n).largest(matrix, count)

        def search(values: np.ndarray, known: np.ndarray, start: np.ndarray):
            which = "LM" if both else "LA"
            return self.searched(matrix, count, (values, known), start, which=which, tol=1e-13)

        def passed_over(values: np.ndarray):
            least = last(values)
            if least is None:
                return False
            sides = (1.0, -1.0) if both else (1.0,)
            return any((negative(side * least) or 0) > int(np.sum(side * values > least)) for side in sides)

        return with_all_copies(search, passed_over, lambda m: -np.abs(m) if both else -m, (self.n, count))


class AllowedMotions:
    """The motions that constraints D v = 0 leave, if they are few, and an operator in them.

    Attributes:
        basis: Orthonormal columns, in coordinates of alike stiffness as in the factors, (n, n - h).
        flexibility: L of Z^T C Z = L L^T, C the motions under forces, (n - h, n - h); zero for motions so stiff that
            their flexibility is round-off.
    """

    def __init__(self, tangent: Any, factored: SparseFactors, n: int):
        """Compute them from a sparse [[K, D^T], [D, 0]] and its factors; LinAlgError if K is indefinite."""
        import scipy.sparse

        rest, scale = tangent.shape[0] - n, equilibrating(tangent, factored.by_diagonal)
        alike = scipy.sparse.diags_array(scale)
        basis = orthonormal_allowed(alike @ tangent @ alike, n) if rest else np.eye(n)
        self.basis = scale[:n, None] * basis
        moved = factored.solve(np.vstack([basis / scale[:n, None], np.zeros((rest, n - rest))]))[:n]
        flexible = basis.T @ (moved / scale[:n, None])
        values, turned = np.linalg.eigh((flexible + flexible.T) / 2)
        if len(values) and not values[0] > -INDEFINITE_FLEXIBILITY * values[-1]:
            raise np.linalg.LinAlgError("not positive definite")
        self.flexibility = turned * np.sqrt(np.maximum(values, 0.0))

    def largest(self, matrix: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The ``count`` eigenvalues of A v = m K v of largest size, and their motions with v^T K v = 1."""
        small = self.flexibility.T @ (self.basis.T @ (matrix @ self.basis)) @ self.flexibility
        values, vectors = np.linalg.eigh((small + small.T) / 2)
        chosen = np.argsort(-np.abs(values), kind="stable")[:count]
        return values[chosen], self.basis @ (self.flexibility @ vectors[:, chosen])


def orthonormal_allowed(tangent: Any, n: int) -> np.ndarray:
    """Orthonormal basis of the motions that the constraints leave, (n, n - h)."""
    import scipy.sparse

    rest, rows = tangent.shape[0] - n, tangent[n:, :n].tocsr()
    rows = scipy.sparse.diags_array(1 / abs(rows).max(axis=1).toarray().ravel()) @ rows
    projector = SparseFactors(scipy.sparse.block_array([[scipy.sparse.eye_array(n), rows.T], [rows, None]]))
    basis = np.random.default_rng(0).standard_normal((n, n - rest))
    for _ in range(2):
        basis = np.linalg.qr(projector.solve(np.vstack([basis, np.zeros((rest, n - rest))]))[:n])[0]
    return basis
