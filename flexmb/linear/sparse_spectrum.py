"""Lowest eigenvalues of stiffness and mass of large mechanisms, by sparse factors and Lanczos iterations.

M v = mu (K + s M) v is solved in the inner product of K + s M, with omega^2 = 1/mu - s. In that of M, which motions
without mass leave no measure of, these would grow among what iterations find.
"""

from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError, ModelError
from ..math.by_deformations import forces, refined
from ..math.element_matrices import Whole
from ..math.linear import uneven
from ..math.linear_solver import LinearSolver
from ..math.sparse import SparseFactors, negative_where_held
from ..results import RESULTS
from .lanczos import BEFORE, FEW, Constrained, changed, check_modes
from .spectrum import FIRST_SHIFT, MASSLESS, MAX_SHIFTS

# Of more motions than these all are not found by sparse matrices.
MANY = 2000
# How much longer each shift is than the one tried before.
GROWTH = 10.0
# Eigenvalues that tell how large a shift is to be are as good as this.
ROUGH = 1e-4
# Where one more iteration changes motions by more than this, whose square is the error of an eigenvalue, another shift
# is tried.
GOOD = 1e-6
# Eigenvalues so much above the one before are told apart by the iterations alone: together with it, their round-off
# would be its error.
APART = 1e4
# So many iterations more, at most, make motions good.
ONCE_MORE = 3
# A mass is negative below this share of the largest, or of what its own motion has in stiffness.
NEGATIVE = 1e-10


class Lowest(NamedTuple):
    """Lowest eigenvalues of a constrained mechanism in all its coordinates.

    Attributes:
        values: omega^2, ascending, infinite for motions without mass, (count,) [rad^2/s^2].
        motions: Mass-normalised motions, one a column, zero for those without mass, (n, count).
        multipliers: Those of the constraints in these motions, (h, count).
    """

    values: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray


class _Shifted(Constrained):
    """K + s M of element matrices where constraints hold, with the shift s [rad^2/s^2] and the mass M, (n, n)."""

    def __init__(self, whole: Whole, solver: LinearSolver, shift: float):
        super().__init__(whole.at(shift), whole.n, solver.factored(whole.elements, mass=shift))
        self.whole, self.solver, self.shift, self.mass = whole, solver, shift, whole.mass

    def is_definite(self) -> bool:
        """Whether K + s M is known to be positive definite where the constraints hold."""
        return self.factors.regular and self.factors.negative() == 0

    def once_more(self, motions: np.ndarray, inverse: np.ndarray):
        """Motions and multipliers one iteration on, by a product that round-off spoils less than its entries."""
        load, n = self.mass @ motions / inverse, self.n

        def shifted(z: np.ndarray):
            found = forces(self.whole.elements, z)
            found[:n] += self.shift * (self.mass @ z[:n])
            return found

        right = np.concatenate([load, np.zeros((self.tangent.shape[0] - n, len(inverse)))])
        return refined(shifted, self.factors.solve, right, np.ones(n))


def _below_all(whole: Whole, solver: LinearSolver) -> _Shifted:
    """Shifted by an s that no eigenvalue is below -s of; or singular_stiffness.

    What is nearest to zero is the lowest only where nothing is below: an unstable mechanism has negative eigenvalues.
    """
    heaviest = whole.mass.diagonal().max(initial=0.0)
    ratio = np.abs(whole.at().diagonal()[: whole.n]).max(initial=0.0) / heaviest if heaviest > 0 else 0.0
    shift = 0.0
    for _ in range(MAX_SHIFTS if heaviest > 0 else 1):
        found = _Shifted(whole, solver, shift)
        if found.is_definite():
            return found
        shift = GROWTH * shift or FIRST_SHIFT * (ratio or 1.0)
    raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def refuse_negative_masses(whole: Whole) -> None:
    """Raise singular_mass where the mass has a negative eigenvalue where the constraints hold.

    Where no element's mass is negative, nor is their sum.
    """
    import scipy.sparse

    try:
        for *_, own in whole.elements.mass:
            largest = np.max(np.abs(own), axis=(1, 2), initial=0.0)
            np.linalg.cholesky(own + (NEGATIVE * largest + np.finfo(float).tiny)[:, None, None] * np.eye(own.shape[1]))
    except np.linalg.LinAlgError:
        pass
    else:
        return
    mass, n = whole.mass, whole.n
    size, rows = np.abs(mass.diagonal()), whole.constraints
    some = NEGATIVE * np.where(size > 0, size, np.max(size, initial=0.0))
    matrix = scipy.sparse.block_array([[mass + scipy.sparse.diags_array(some), rows.T], [rows, None]]).tocsc()
    if negative_where_held(matrix, SparseFactors(matrix), n) != 0:
        raise AnalysisError(RESULTS.singular_mass.name, RESULTS.singular_mass.message)


def _found(at: _Shifted, count: int, rough: bool) -> tuple[np.ndarray, np.ndarray]:
    """Largest mu of M v = mu (K + s M) v, and their motions with v^T (K + s M) v = 1; about right, or right."""
    heavy = np.flatnonzero(at.mass.diagonal() != 0)
    if not at.few(count):
        if len(heavy) <= max(FEW, 3 * count):
            return _of_few_masses(at, heavy, count)
        if rough:
            return at.searched(at.mass, count, None, uneven(at.n), which="LA", tol=ROUGH)
    every = 2 * at.n - at.tangent.shape[0]

    def last(inverse: np.ndarray):
        # Up to the last, or where motions without mass begin.
        return max(inverse[-1] * (1 + BEFORE * abs(1 - at.shift * inverse[-1])), MASSLESS * every * inverse[0])

    def negative(inverse: float):
        return at.solver.factored(at.whole.elements, mass=at.shift - 1 / inverse).negative()

    try:
        return at.largest(at.mass, count, last, negative)
    except np.linalg.LinAlgError:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message) from None


def _of_few_masses(at: _Shifted, heavy: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The same where few coordinates have mass: M = S S^T, and S^T C S has these values, C the motions under forces."""
    own, turned = np.linalg.eigh(at.mass[heavy][:, heavy].toarray())
    roots = np.zeros((at.mass.shape[0], len(heavy)))
    roots[heavy] = turned * np.sqrt(np.maximum(own, 0.0))
    moved = at.moved(roots)
    inverse, shares = np.linalg.eigh(roots.T @ moved)
    inverse, motions = inverse[::-1][:count], moved @ shares[:, ::-1][:, :count]
    return inverse, motions / np.sqrt(np.where(inverse > 0, inverse, 1.0))


def lowest_of_sparse(whole: Whole, count: int, solver: LinearSolver) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, by Lanczos iterations with factors of a solver.

    M has no negative eigenvalues where the constraints hold.

    Raises:
        ModelError: ``count`` is so large a part of very many.
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
        # As small a shift leaves few digits to what is far above it.
        at = _better(at, _found(at, count, rough=True)[0])
    found, wrong = _lowest_at(at, count)
    if np.max(wrong, initial=0.0) > GOOD:
        # Nor does a stiffness that is far softer in one motion than in others.
        at = _better(at, 1 / (found.values[np.isfinite(found.values)] + at.shift))
        found, wrong = _lowest_at(at, count)
    check_modes(wrong, "frequencies")
    return found


def _better(at: _Shifted, inverse: np.ndarray) -> _Shifted:
    """Shifted to amidst the eigenvalues that are asked for, of which about right ones are given."""
    above = 1 / inverse[inverse > MASSLESS * np.max(inverse)] - at.shift
    above = above[above > max(at.shift, 0.0)]
    return _Shifted(at.whole, at.solver, float(np.sqrt(np.min(above) * np.max(above)))) if len(above) else at


def _lowest_at(at: _Shifted, count: int) -> tuple[Lowest, np.ndarray]:
    """Eigenvalues and motions, and how far from eigenvectors these are, (count,)."""
    n, total = at.mass.shape[0], at.tangent.shape[0]
    inverse, motions = _found(at, count, rough=False)
    order = np.argsort(-inverse)
    inverse = inverse[order]
    inverse = inverse[inverse > MASSLESS * (2 * n - total) * inverse[0]]
    some = len(inverse)
    kept = motions[:, order[:some]]
    kept = kept / np.sqrt(np.einsum("ij,ij->j", kept, at.mass @ kept))
    # Once more, for the multipliers too: K v + D^T m = (w^2 + s) M v.
    full = at.once_more(kept, inverse)
    multipliers, wrong = full[n:], changed(full[:n] - kept, kept, at.mass)
    for _ in range(ONCE_MORE):
        kept, multipliers, inverse, wrong = _told_apart(at.mass, kept, full, inverse)
        if np.max(wrong, initial=0.0) <= GOOD:
            break
        full = at.once_more(kept, inverse)
    found = Lowest(np.full(count, np.inf), np.zeros((n, count)), np.zeros((total - n, count)))
    found.values[:some] = 1 / inverse - at.shift
    found.motions[:, :some], found.multipliers[:, :some] = kept, multipliers
    return found, wrong


def _told_apart(mass: Any, motions: np.ndarray, full: np.ndarray, inverse: np.ndarray):
    """Eigenvectors among motions one iteration on, by Ritz's method, their multipliers, inverses, and their changes."""
    n = len(motions)
    ahead, before = full[:n], mass @ motions
    size = np.sqrt(np.einsum("ij,ij->j", ahead, mass @ ahead))
    full, ahead = full / size, ahead / size
    elastic, massive = ahead.T @ (before / (inverse * size)), ahead.T @ (mass @ ahead)
    # Row by row from the lowest: what is far above, with its round-off, does not come into it.
    roots = np.linalg.inv(np.linalg.cholesky((massive + massive.T) / 2))
    elastic = roots @ (elastic + elastic.T) @ roots.T / 2
    values, turned = np.diagonal(elastic).copy(), np.eye(len(inverse))
    for near in np.split(np.arange(len(values)), 1 + np.flatnonzero(values[1:] > APART * np.abs(values[:-1]))):
        own = np.ix_(near, near)
        values[near], turned[own] = np.linalg.eigh(elastic[own])
    full = full @ (roots.T @ turned)
    left = motions - full[:n] @ (full[:n].T @ before)
    return full[:n], full[n:], 1 / values, changed(left, motions, mass)


def asks_for_all(count: int, every: int) -> bool:
    """Whether so many eigenvalues are asked for, of all that there are, that sparse matrices do not give them."""
    return 3 * count >= every > MANY
