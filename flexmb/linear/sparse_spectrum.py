"""Lowest eigenvalues of stiffness and mass of large mechanisms, by sparse factors and Lanczos iterations.

M v = mu (K + s M) v is solved in the inner product of K + s M, with omega^2 = 1/mu - s. In the inner product of M,
which is zero for motions without mass, these would grow during iterations.

:func:`lowest_of_sparse` is the entry. Poles, buckling and critical points of large mechanisms also use:

- :class:`Constrained`: motions under constraints, with factors or, if few, as a basis;
- :func:`explained_failures`, :func:`check_converged`, :func:`refuse_negative_masses`: errors by name.
"""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError
from ..math.by_deformations import forces, refined_solution
from ..math.element_matrices import AssembledEquations
from ..math.linear import uneven
from ..math.linear_solver import FactoredEquations, LinearSolver
from ..math.sparse import SparseFactors, equilibrating, negative_under_constraints
from ..numerical_limits import (
    COUNTED_BEFORE_LAST,
    EIGENVALUES_APART,
    FIRST_SHIFT,
    GOOD_MOTION,
    LANCZOS_CONVERGED,
    MASSLESS_SHARE,
    NEGATIVE_BY_ROUND_OFF,
    ROUGH_EIGENVALUE,
)
from ..results import RESULTS
from ..statics.solver_choice import refuse_all
from .spectrum import MAX_SHIFTS

# All motions are computed if constraints leave at most this number, or three times the number wanted: Lanczos
# iterations that exhaust the motions continue with round-off.
FEW = 60
# Searches for missed eigenvalues; each finds at least one copy of every repeated one.
SEARCHES = 100


@contextlib.contextmanager
def explained_failures(try_this: str = "Ask for fewer") -> Iterator[None]:
    """Context in which failures of ARPACK raise not_converged, with the advice ``try_this``."""
    import scipy.sparse.linalg

    try:
        yield
    except scipy.sparse.linalg.ArpackError as fault:
        raise AnalysisError(
            RESULTS.not_converged.name,
            "Eigenvalues were not found by sparse factors, since iterations did not converge. Stiffnesses or masses may"
            f" be far apart, as of very short elements. {try_this}, or give sparse=False and a model with degrees of"
            f" freedom. ({fault})",
        ) from None


def change_by_iteration(left: np.ndarray, motions: np.ndarray, matrix: Any) -> np.ndarray:
    """Change of motions by one more iteration, ``left``, over their own size, in the norm of a matrix."""
    wrong, size = (np.einsum("ij,ij->j", columns, matrix @ columns) for columns in (left, motions))
    return np.sqrt(np.abs(wrong) / size)


def check_converged(wrong: np.ndarray | float, what: str, most: float = LANCZOS_CONVERGED) -> None:
    """Raise not_converged if iterations for ``what`` have not converged, by :func:`change_by_iteration`."""
    if not np.all(wrong <= most):
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
        zeros = np.zeros((self.tangent.shape[0] - self.n, *forces.shape[1:]))
        return self.factors.solve(np.concatenate([forces, zeros]))

    def moved(self, forces: np.ndarray) -> np.ndarray:
        """Motions under forces, (n,) or (n, k)."""
        return self.solved(forces)[: self.n]

    def few(self, count: int) -> bool:
        """Whether constraints leave so few motions that all are computed."""
        return 2 * self.n - self.tangent.shape[0] <= max(FEW, 3 * count)

    def all_of_few(self, matrix: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Eigenvalues of A v = m K v of largest size, and motions with v^T K v = 1, from all of few allowed motions.

        LinAlgError if K is indefinite.
        """
        import scipy.sparse

        n, h, factored = self.n, self.tangent.shape[0] - self.n, SparseFactors(self.tangent)
        scale = equilibrating(self.tangent, factored.by_diagonal)
        alike = scipy.sparse.diags_array(scale)
        # In coordinates of alike stiffness, as in the factors.
        basis = orthonormal_allowed(alike @ self.tangent @ alike, n) if h else np.eye(n)
        moved = factored.solve(np.vstack([basis / scale[:n, None], np.zeros((h, n - h))]))[:n]
        flexible = basis.T @ (moved / scale[:n, None])
        values, turned = np.linalg.eigh((flexible + flexible.T) / 2)
        if len(values) and not values[0] > -NEGATIVE_BY_ROUND_OFF * values[-1]:
            raise np.linalg.LinAlgError("not positive definite")
        # Zero for motions so stiff that their flexibility is round-off.
        roots, basis = turned * np.sqrt(np.maximum(values, 0.0)), scale[:n, None] * basis
        small = roots.T @ (basis.T @ (matrix @ basis)) @ roots
        values, vectors = np.linalg.eigh((small + small.T) / 2)
        chosen = np.argsort(-np.abs(values), kind="stable")[:count]
        return values[chosen], basis @ (roots @ vectors[:, chosen])

    def searched(
        self, matrix: Any, count: int, known: Any, start: np.ndarray, try_this: str | None = None, **how: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        """Eigenvalues of A v = m K v under constraints, with v^T K v = 1, by ARPACK in the inner product of K.

        Args:
            matrix: Sparse symmetric A; K is positive definite under the constraints.
            known: Known eigenvalues (k,) and motions (n, k), or None; ``count`` others are sought.
            start: Any x; iterations start from the motion under the forces A x.
            try_this: Advice of the error if ARPACK fails, by default to ask for fewer if more than one is sought.
            how: Options of :func:`scipy.sparse.linalg.eigsh`.
        """
        import scipy.sparse.linalg

        linalg: Any = scipy.sparse.linalg
        values, motions = known or (np.zeros(0), np.zeros((self.n, 0)))
        # ARPACK uses the product with the first matrix for inner product and operator: remove known motions from this
        # matrix.
        forces = self.stiffness @ motions

        def beside(motion: np.ndarray):
            motion = np.ravel(motion)
            return matrix @ motion - forces @ (values * (forces.T @ motion))

        operator = linalg.LinearOperator(matrix.shape, matvec=beside, dtype=float)
        inverse = linalg.LinearOperator(matrix.shape, matvec=lambda force: self.moved(np.ravel(force)), dtype=float)
        first = self.moved(matrix @ start)
        with explained_failures(try_this or ("Ask for fewer" if count > 1 else "Ask for more")):
            return linalg.eigsh(operator, k=count, M=self.stiffness, Minv=inverse, v0=first, **how)

    def largest(
        self,
        matrix: Any,
        count: int,
        last: Callable[[np.ndarray], float | None],
        negative: Callable[[float], int | None],
        both: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Largest m of A v = m K v with all copies, and motions with v^T K v = 1; LinAlgError if K is indefinite.

        From one start, iterations find one motion of each eigenvalue; only round-off adds others.

        Args:
            last: Value up to which all are counted by inertia, from those found; None: no count.
            negative: Number of negative eigenvalues of K - A/m under the constraints, for m; None: not known.
            both: Whether to include negative ones, by size.
        """
        if self.few(count):
            return self.all_of_few(matrix, count)
        which, sides = ("LM", (1.0, -1.0)) if both else ("LA", (1.0,))

        def smallness(values: np.ndarray):
            return -np.abs(values) if both else -values

        def passed_over(values: np.ndarray):
            least = last(values)
            if least is None:
                return False
            return any((negative(side * least) or 0) > int(np.sum(side * values > least)) for side in sides)

        values, motions = self.searched(matrix, count, None, uneven(self.n), which=which, tol=1e-13)
        for k in range(SEARCHES):
            order = np.argsort(smallness(values), kind="stable")[:count]
            values, motions = values[order], motions[:, order]
            if not passed_over(values):
                return values, motions
            start = np.cos((k + 2) * np.arange(self.n) ** 2 + k)
            more, others = self.searched(matrix, count, (values, motions), start, which=which, tol=1e-13)
            if np.min(smallness(more)) >= smallness(values)[-1]:
                return values, motions
            values, motions = np.concatenate([values, more]), np.concatenate([motions, others], axis=1)
        raise AnalysisError(RESULTS.not_converged.name, RESULTS.not_converged.message)


def orthonormal_allowed(tangent: Any, n: int) -> np.ndarray:
    """Orthonormal basis of the motions that the constraints leave, (n, n - h)."""
    import scipy.sparse

    n_constraints, rows = tangent.shape[0] - n, tangent[n:, :n].tocsr()
    rows = scipy.sparse.diags_array(1 / abs(rows).max(axis=1).toarray().ravel()) @ rows
    projector = SparseFactors(scipy.sparse.block_array([[scipy.sparse.eye_array(n), rows.T], [rows, None]]))
    basis = np.random.default_rng(0).standard_normal((n, n - n_constraints))
    for _ in range(2):
        basis = np.linalg.qr(projector.solve(np.vstack([basis, np.zeros((n_constraints, n - n_constraints))]))[:n])[0]
    return basis


# Growth of the shift from one try to the next.
GROWTH = 10.0
# Largest number of additional iterations.
ONCE_MORE = 3


class Lowest(NamedTuple):
    """Lowest eigenvalues of a constrained mechanism in all its coordinates.

    Attributes:
        values: omega^2, ascending, infinite for motions without mass, (count,) [rad^2/s^2].
        motions: Mass-normalised, one a column, zero without mass, (n, count).
        multipliers: Of the constraints in these motions, (h, count).
    """

    values: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray


class _Shifted(Constrained):
    """K + s M of element matrices under constraints, with the shift s [rad^2/s^2] and the mass M."""

    def __init__(self, assembled: AssembledEquations, solver: LinearSolver, shift: float):
        super().__init__(assembled.at(shift), assembled.n, solver.factored(assembled.elements, mass=shift))
        self.whole, self.solver, self.shift, self.mass = assembled, solver, shift, assembled.mass

    def once_more(self, motions: np.ndarray, inverse: np.ndarray):
        """Motions and multipliers one iteration on, by a product with less round-off than the assembled matrix."""
        load, n = self.mass @ motions / inverse, self.n

        def shifted(z: np.ndarray):
            product = forces(self.whole.elements, z)
            product[:n] += self.shift * (self.mass @ z[:n])
            return product

        right = np.concatenate([load, np.zeros((self.tangent.shape[0] - n, len(inverse)))])
        return refined_solution(shifted, self.factors.solve, right, np.ones(n))


def _below_all(assembled: AssembledEquations, solver: LinearSolver) -> _Shifted:
    """Shifted by an s with all eigenvalues above -s; or singular_stiffness.

    The eigenvalue nearest to zero is the lowest only if none is below: an unstable mechanism has negative ones.
    """
    heaviest = assembled.mass.diagonal().max(initial=0.0)
    ratio = np.abs(assembled.at().diagonal()[: assembled.n]).max(initial=0.0) / heaviest if heaviest > 0 else 0.0
    shift = 0.0
    for _ in range(MAX_SHIFTS if heaviest > 0 else 1):
        shifted = _Shifted(assembled, solver, shift)
        if shifted.factors.regular and shifted.factors.negative() == 0:
            return shifted
        shift = GROWTH * shift or FIRST_SHIFT * (ratio or 1.0)
    raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def refuse_negative_masses(whole: AssembledEquations) -> None:
    """Raise singular_mass if the mass has a negative eigenvalue under the constraints.

    If no element's mass is negative, neither is their sum.
    """
    import scipy.sparse

    try:
        for *_, m in whole.elements.mass:
            least = NEGATIVE_BY_ROUND_OFF * np.max(np.abs(m), axis=(1, 2), initial=0.0) + np.finfo(float).tiny
            np.linalg.cholesky(m + least[:, None, None] * np.eye(m.shape[1]))
    except np.linalg.LinAlgError:
        pass
    else:
        return
    mass, n = whole.mass, whole.n
    size, rows = np.abs(mass.diagonal()), whole.constraints
    some = NEGATIVE_BY_ROUND_OFF * np.where(size > 0, size, np.max(size, initial=0.0))
    matrix = scipy.sparse.block_array([[mass + scipy.sparse.diags_array(some), rows.T], [rows, None]]).tocsc()
    if negative_under_constraints(matrix, SparseFactors(matrix), n) != 0:
        raise AnalysisError(RESULTS.singular_mass.name, RESULTS.singular_mass.message)


def _largest_inverses(at: _Shifted, count: int, rough: bool) -> tuple[np.ndarray, np.ndarray]:
    """Largest mu of M v = mu (K + s M) v, and motions with v^T (K + s M) v = 1, exact or ``rough``."""
    heavy = np.flatnonzero(at.mass.diagonal() != 0)
    if not at.few(count):
        if len(heavy) <= max(FEW, 3 * count):
            return _few_mass_modes(at, heavy, count)
        if rough:
            return at.searched(at.mass, count, None, uneven(at.n), which="LA", tol=ROUGH_EIGENVALUE)
    every = 2 * at.n - at.tangent.shape[0]

    def last(inverse: np.ndarray):
        # Up to the last value, or to the motions without mass.
        return max(
            inverse[-1] * (1 + COUNTED_BEFORE_LAST * abs(1 - at.shift * inverse[-1])),
            MASSLESS_SHARE * every * inverse[0],
        )

    def negative(inverse: float):
        return at.solver.factored(at.whole.elements, mass=at.shift - 1 / inverse).negative()

    try:
        return at.largest(at.mass, count, last, negative)
    except np.linalg.LinAlgError:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message) from None


def _few_mass_modes(at: _Shifted, heavy: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """As :func:`_largest_inverses` if few coordinates have mass: values of S^T C S, M = S S^T, C the flexibility."""
    masses, turned = np.linalg.eigh(at.mass[heavy][:, heavy].toarray())
    roots = np.zeros((at.mass.shape[0], len(heavy)))
    roots[heavy] = turned * np.sqrt(np.maximum(masses, 0.0))
    moved = at.moved(roots)
    inverse, shares = np.linalg.eigh(roots.T @ moved)
    inverse, motions = inverse[::-1][:count], moved @ shares[:, ::-1][:, :count]
    return inverse, motions / np.sqrt(np.where(inverse > 0, inverse, 1.0))


def lowest_of_sparse(whole: AssembledEquations, count: int, solver: LinearSolver) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, by Lanczos iterations with factors of a solver.

    M has no negative eigenvalues under the constraints.

    Source:
        THEORY.md 7, eq. (7.16); shift-inverted Lanczos method of ARPACK.
    """
    n, total = whole.n, sum(whole.elements.unknowns)
    every = 2 * n - total
    refuse_all(count, every, "frequencies")
    if every <= 0:
        return Lowest(np.zeros(0), np.zeros((n, 0)), np.zeros((total - n, 0)))
    at = _below_all(whole, solver)
    if not at.mass.count_nonzero():
        return Lowest(np.full(count, np.inf), np.zeros((n, count)), np.zeros((total - n, count)))
    if at.shift > 0:
        # Such a small shift leaves few digits for eigenvalues far above it.
        at = _better(at, _largest_inverses(at, count, rough=True)[0])
    modes, wrong = _lowest_at(at, count)
    if np.max(wrong, initial=0.0) > GOOD_MOTION:
        # So does a stiffness that is far softer in one motion than in others.
        at = _better(at, 1 / (modes.values[np.isfinite(modes.values)] + at.shift))
        modes, wrong = _lowest_at(at, count)
    check_converged(wrong, "frequencies")
    return modes


def _better(at: _Shifted, inverse: np.ndarray) -> _Shifted:
    """Shifted to the middle of the wanted eigenvalues, from rough ones."""
    above = 1 / inverse[inverse > MASSLESS_SHARE * np.max(inverse)] - at.shift
    above = above[above > max(at.shift, 0.0)]
    return _Shifted(at.whole, at.solver, float(np.sqrt(np.min(above) * np.max(above)))) if len(above) else at


def _lowest_at(at: _Shifted, count: int) -> tuple[Lowest, np.ndarray]:
    """Eigenvalues and motions, and the deviation of each from an eigenvector."""
    n, total = at.mass.shape[0], at.tangent.shape[0]
    inverse, motions = _largest_inverses(at, count, rough=False)
    order = np.argsort(-inverse)
    inverse = inverse[order]
    inverse = inverse[inverse > MASSLESS_SHARE * (2 * n - total) * inverse[0]]
    some = len(inverse)
    lowest_motions = motions[:, order[:some]]
    lowest_motions = lowest_motions / np.sqrt(np.einsum("ij,ij->j", lowest_motions, at.mass @ lowest_motions))
    # One more iteration gives the multipliers: K v + D^T m = (w^2 + s) M v.
    full = at.once_more(lowest_motions, inverse)
    multipliers, wrong = full[n:], change_by_iteration(full[:n] - lowest_motions, lowest_motions, at.mass)
    for _ in range(ONCE_MORE):
        lowest_motions, multipliers, inverse, wrong = _ritz_vectors(at.mass, lowest_motions, full, inverse)
        if np.max(wrong, initial=0.0) <= GOOD_MOTION:
            break
        full = at.once_more(lowest_motions, inverse)
    modes = Lowest(np.full(count, np.inf), np.zeros((n, count)), np.zeros((total - n, count)))
    modes.values[:some] = 1 / inverse - at.shift
    modes.motions[:, :some], modes.multipliers[:, :some] = lowest_motions, multipliers
    return modes, wrong


def _ritz_vectors(mass: Any, motions: np.ndarray, full: np.ndarray, inverse: np.ndarray):
    """Eigenvectors among motions one iteration on, by Ritz's method: motions, multipliers, inverses, changes."""
    n = len(motions)
    ahead, before = full[:n], mass @ motions
    size = np.sqrt(np.einsum("ij,ij->j", ahead, mass @ ahead))
    full, ahead = full / size, ahead / size
    elastic, massive = ahead.T @ (before / (inverse * size)), ahead.T @ (mass @ ahead)
    # Row by row from the lowest: the round-off of much higher motions stays out.
    roots = np.linalg.inv(np.linalg.cholesky((massive + massive.T) / 2))
    elastic = roots @ (elastic + elastic.T) @ roots.T / 2
    values, turned = np.diagonal(elastic).copy(), np.eye(len(inverse))
    for cluster in np.split(
        np.arange(len(values)), 1 + np.flatnonzero(values[1:] > EIGENVALUES_APART * np.abs(values[:-1]))
    ):
        square = np.ix_(cluster, cluster)
        values[cluster], turned[square] = np.linalg.eigh(elastic[square])
    full = full @ (roots.T @ turned)
    residual = motions - full[:n] @ (full[:n].T @ before)
    return full[:n], full[n:], 1 / values, change_by_iteration(residual, motions, mass)
