"""Lowest eigenvalues of stiffness and mass of large mechanisms, by sparse factors and Lanczos iterations.

M v = mu (K + s M) v is solved in the inner product of K + s M, with omega^2 = 1/mu - s. In the inner product of M,
which is zero for motions without mass, these would grow during iterations.
"""

from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError, ModelError
from ..math.by_deformations import forces, refined
from ..math.element_matrices import Whole
from ..math.linear import uneven
from ..math.linear_solver import LinearSolver
from ..math.sparse import SparseFactors, negative_where_held
from ..numerical_limits import (
    COUNTED_BEFORE_LAST,
    EIGENVALUES_APART,
    FIRST_SHIFT,
    GOOD_MOTION,
    MASSLESS_SHARE,
    NEGATIVE_MASS,
    ROUGH_EIGENVALUE,
)
from ..results import RESULTS
from .lanczos import FEW, Constrained, changed, check_modes
from .spectrum import MAX_SHIFTS

# Above this number of motions, sparse matrices do not compute all.
MANY = 2000
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

    def __init__(self, whole: Whole, solver: LinearSolver, shift: float):
        super().__init__(whole.at(shift), whole.n, solver.factored(whole.elements, mass=shift))
        self.whole, self.solver, self.shift, self.mass = whole, solver, shift, whole.mass

    def is_definite(self) -> bool:
        """Whether K + s M is known to be positive definite under the constraints."""
        return self.factors.regular and self.factors.negative() == 0

    def once_more(self, motions: np.ndarray, inverse: np.ndarray):
        """Motions and multipliers one iteration on, by a product with less round-off than the assembled matrix."""
        load, n = self.mass @ motions / inverse, self.n

        def shifted(z: np.ndarray):
            product = forces(self.whole.elements, z)
            product[:n] += self.shift * (self.mass @ z[:n])
            return product

        right = np.concatenate([load, np.zeros((self.tangent.shape[0] - n, len(inverse)))])
        return refined(shifted, self.factors.solve, right, np.ones(n))


def _below_all(whole: Whole, solver: LinearSolver) -> _Shifted:
    """Shifted by an s with all eigenvalues above -s; or singular_stiffness.

    The eigenvalue nearest to zero is the lowest only if none is below: an unstable mechanism has negative ones.
    """
    heaviest = whole.mass.diagonal().max(initial=0.0)
    ratio = np.abs(whole.at().diagonal()[: whole.n]).max(initial=0.0) / heaviest if heaviest > 0 else 0.0
    shift = 0.0
    for _ in range(MAX_SHIFTS if heaviest > 0 else 1):
        shifted = _Shifted(whole, solver, shift)
        if shifted.is_definite():
            return shifted
        shift = GROWTH * shift or FIRST_SHIFT * (ratio or 1.0)
    raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def refuse_negative_masses(whole: Whole) -> None:
    """Raise singular_mass if the mass has a negative eigenvalue under the constraints.

    If no element's mass is negative, neither is their sum.
    """
    import scipy.sparse

    try:
        for *_, m in whole.elements.mass:
            least = NEGATIVE_MASS * np.max(np.abs(m), axis=(1, 2), initial=0.0) + np.finfo(float).tiny
            np.linalg.cholesky(m + least[:, None, None] * np.eye(m.shape[1]))
    except np.linalg.LinAlgError:
        pass
    else:
        return
    mass, n = whole.mass, whole.n
    size, rows = np.abs(mass.diagonal()), whole.constraints
    some = NEGATIVE_MASS * np.where(size > 0, size, np.max(size, initial=0.0))
    matrix = scipy.sparse.block_array([[mass + scipy.sparse.diags_array(some), rows.T], [rows, None]]).tocsc()
    if negative_where_held(matrix, SparseFactors(matrix), n) != 0:
        raise AnalysisError(RESULTS.singular_mass.name, RESULTS.singular_mass.message)


def _found(at: _Shifted, count: int, rough: bool) -> tuple[np.ndarray, np.ndarray]:
    """Largest mu of M v = mu (K + s M) v, and motions with v^T (K + s M) v = 1, exact or ``rough``."""
    heavy = np.flatnonzero(at.mass.diagonal() != 0)
    if not at.few(count):
        if len(heavy) <= max(FEW, 3 * count):
            return _of_few_masses(at, heavy, count)
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


def _of_few_masses(at: _Shifted, heavy: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """:func:`_found` if few coordinates have mass: M = S S^T, and S^T C S has these values, C the flexibility."""
    masses, turned = np.linalg.eigh(at.mass[heavy][:, heavy].toarray())
    roots = np.zeros((at.mass.shape[0], len(heavy)))
    roots[heavy] = turned * np.sqrt(np.maximum(masses, 0.0))
    moved = at.moved(roots)
    inverse, shares = np.linalg.eigh(roots.T @ moved)
    inverse, motions = inverse[::-1][:count], moved @ shares[:, ::-1][:, :count]
    return inverse, motions / np.sqrt(np.where(inverse > 0, inverse, 1.0))


def lowest_of_sparse(whole: Whole, count: int, solver: LinearSolver) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, by Lanczos iterations with factors of a solver.

    M has no negative eigenvalues under the constraints.

    Raises:
        ModelError: ``count`` is too large a part of very many.
        AnalysisError: singular_stiffness or not_converged.

    Source:
        THEORY.md 7, eq. (7.16); shift-inverted Lanczos method of ARPACK.
    """
    n, total = whole.n, sum(whole.elements.unknowns)
    every = 2 * n - total
    if asks_for_all(count, every):
        raise ModelError(
            f"Argument `count` = {count}: sparse matrices give few of the {every} frequencies, not all. Ask for fewer,"
            " or give sparse=False and a model with degrees of freedom."
        )
    if every <= 0:
        return Lowest(np.zeros(0), np.zeros((n, 0)), np.zeros((total - n, 0)))
    at = _below_all(whole, solver)
    if not at.mass.count_nonzero():
        return Lowest(np.full(count, np.inf), np.zeros((n, count)), np.zeros((total - n, count)))
    if at.shift > 0:
        # Such a small shift leaves few digits for eigenvalues far above it.
        at = _better(at, _found(at, count, rough=True)[0])
    modes, wrong = _lowest_at(at, count)
    if np.max(wrong, initial=0.0) > GOOD_MOTION:
        # So does a stiffness that is far softer in one motion than in others.
        at = _better(at, 1 / (modes.values[np.isfinite(modes.values)] + at.shift))
        modes, wrong = _lowest_at(at, count)
    check_modes(wrong, "frequencies")
    return modes


def _better(at: _Shifted, inverse: np.ndarray) -> _Shifted:
    """Shifted to the middle of the wanted eigenvalues, from rough ones."""
    above = 1 / inverse[inverse > MASSLESS_SHARE * np.max(inverse)] - at.shift
    above = above[above > max(at.shift, 0.0)]
    return _Shifted(at.whole, at.solver, float(np.sqrt(np.min(above) * np.max(above)))) if len(above) else at


def _lowest_at(at: _Shifted, count: int) -> tuple[Lowest, np.ndarray]:
    """Eigenvalues and motions, and the deviation of each from an eigenvector."""
    n, total = at.mass.shape[0], at.tangent.shape[0]
    inverse, motions = _found(at, count, rough=False)
    order = np.argsort(-inverse)
    inverse = inverse[order]
    inverse = inverse[inverse > MASSLESS_SHARE * (2 * n - total) * inverse[0]]
    some = len(inverse)
    kept = motions[:, order[:some]]
    kept = kept / np.sqrt(np.einsum("ij,ij->j", kept, at.mass @ kept))
    # One more iteration gives the multipliers: K v + D^T m = (w^2 + s) M v.
    full = at.once_more(kept, inverse)
    multipliers, wrong = full[n:], changed(full[:n] - kept, kept, at.mass)
    for _ in range(ONCE_MORE):
        kept, multipliers, inverse, wrong = _told_apart(at.mass, kept, full, inverse)
        if np.max(wrong, initial=0.0) <= GOOD_MOTION:
            break
        full = at.once_more(kept, inverse)
    modes = Lowest(np.full(count, np.inf), np.zeros((n, count)), np.zeros((total - n, count)))
    modes.values[:some] = 1 / inverse - at.shift
    modes.motions[:, :some], modes.multipliers[:, :some] = kept, multipliers
    return modes, wrong


def _told_apart(mass: Any, motions: np.ndarray, full: np.ndarray, inverse: np.ndarray):
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
    for near in np.split(
        np.arange(len(values)), 1 + np.flatnonzero(values[1:] > EIGENVALUES_APART * np.abs(values[:-1]))
    ):
        square = np.ix_(near, near)
        values[near], turned[square] = np.linalg.eigh(elastic[square])
    full = full @ (roots.T @ turned)
    left = motions - full[:n] @ (full[:n].T @ before)
    return full[:n], full[n:], 1 / values, changed(left, motions, mass)


def asks_for_all(count: int, every: int) -> bool:
    """Whether too many of all eigenvalues are wanted for sparse matrices."""
    return 3 * count >= every > MANY
