"""Critical values of large mechanisms: pivots count negative values, iterations find the values nearest to zero."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError
from ..linear.sparse_spectrum import explained_failures
from ..math.linear import uneven
from ..math.sparse import SparseFactors, negative_under_constraints
from ..numerical_limits import CRITICAL_RESIDUAL, DOUBTED_SIGN, LOST_MOTION, SETTLED_MOTION, SUPPORTED
from ..results import RESULTS

# Number of critical values that are computed, nearest to zero.
TOLD = 4
# Vectors of the Lanczos method.
BASIS = 14

# Largest number of corrections.
TURNS = 4


class CriticalValues(NamedTuple):
    """Critical values at a state; one represents all for an unsymmetric stiffness.

    Attributes:
        values: Those nearest to zero, ascending, (n,) [N m].
        below: Number of further negative ones.
        start: Sum of their motions in extents and radians, where iterations for a state nearby start, (n_free,).
    """

    values: np.ndarray
    below: int
    start: np.ndarray


def critical_values_of(
    tangent: Any, factored: SparseFactors, sizes: np.ndarray, start: np.ndarray, stiffness: Any
) -> CriticalValues:
    """Eigenvalues of the stiffness against the square of motions in extents and radians, under the constraints.

    They are found and counted by factors, whose round-off for many short beams spoils some digits, and then separated
    in their motions by the better products of ``stiffness``, an :class:`flexmb.statics.tangent.Assembled`. ``start`` is
    a motion near the wanted ones.

    Source:
        Shift-inverted Lanczos method of ARPACK; Ritz's method in motions and in flexibility times residuals (Davidson
        1975).
    """
    n_constraints = tangent.shape[0] - len(sizes)
    every, shift = len(sizes) - n_constraints, 0.0
    if every <= 2 * BASIS:
        return _critical_values(*_all_of(tangent, sizes), 0)
    if not factored.regular:
        shift = SUPPORTED * abs(tangent).max()
        factored = shifted(tangent, shift, sizes)
    negative = negative_under_constraints(tangent, factored, len(sizes))

    def settled(motions: np.ndarray):
        return _settled(stiffness, _flexibility(factored, n_constraints, sizes), sizes, motions)

    if negative is not None:
        rough, motions = _values_near_zero(factored, n_constraints, sizes, start, TOLD, shift)
        values, motions = settled(motions)
        more = negative - int(np.sum(rough < -shift))
        doubted = DOUBTED_SIGN * np.max(np.abs(np.sort(rough) - values))
        if np.min(np.abs(values)) < doubted < np.max(np.diff(values)):
            more = _beyond(tangent, sizes, values)
        return _critical_values(values, np.sum(motions, axis=1), more)
    # Values become negative through zero: if the farthest ones found are positive, few beyond are negative.
    count = 2 * TOLD
    while 2 * count < every:
        values, motions = _values_near_zero(factored, n_constraints, sizes, start, count, shift)
        if np.all(values[np.argsort(np.abs(values))[-2:]] > 0):
            values, motions = settled(motions)
            return _critical_values(values, np.sum(motions, axis=1), 0)
        count *= 2
    return _critical_values(*_all_of(tangent, sizes), 0)


def value_of_determinant(
    tangent: Any, factored: SparseFactors, sizes: np.ndarray, start: np.ndarray, stiffness: Any
) -> CriticalValues:
    """Smallest modulus of the eigenvalues of an unsymmetric stiffness, with the sign of the determinant.

    det K is the product of its eigenvalues; with h constraints det [[K, D^T], [D, 0]] has the sign of det K under them,
    times (-1)^h. By the Arnoldi method of ARPACK.
    """
    n_constraints = tangent.shape[0] - len(sizes)
    if not factored.regular:
        return CriticalValues(np.zeros(1), 0, start)
    moved, sign = _flexibility(factored, n_constraints, sizes), (-1) ** n_constraints * factored.sign
    if len(sizes) - n_constraints <= 2 * BASIS:
        motions = _allowed(tangent, sizes)
        soft = np.linalg.eigvals(motions.T @ moved(motions))
        largest = np.max(np.abs(soft), initial=0.0)
        return CriticalValues(np.array([sign / largest if largest > 0 else np.inf]), 0, start)
    soft, shapes = _softest(moved, sizes, start)
    i = int(np.argmax(np.abs(soft)))
    value, begin = sign / abs(soft[i]), np.sum(shapes.real, axis=1)
    if abs(soft[i].imag) <= CRITICAL_RESIDUAL * abs(soft[i]):
        # A simple real value follows from the quotient with its left eigenvector, with its sign.
        others, left_shapes = _softest(_flexibility(factored, n_constraints, sizes, transposed=True), sizes, start)
        j = int(np.argmin(np.abs(others - soft[i])))
        row_sizes, v, w = sizes[:, None], shapes[:, [i]].real, left_shapes[:, [j]].real
        overlap = float(np.sum(w * v))
        if overlap != 0:
            quotient = float(stiffness.between(row_sizes * w, row_sizes * v)[0, 0]) / overlap
            rest_sign = sign * np.sign(soft[i].real)
            if abs(quotient) < DOUBTED_SIGN * abs(1 / soft[i].real - quotient):
                # With this shift, no other value changes its sign, and this one is positive.
                rest_sign = (-1) ** n_constraints * shifted(tangent, 0.5 / abs(soft[1 - i]), sizes).sign
            value = rest_sign * quotient
    return CriticalValues(np.array([value]), 0, begin)


def shifted(tangent: Any, shift: float, sizes: np.ndarray) -> SparseFactors:
    """Factors of a tangent whose critical values are all increased."""
    import scipy.sparse

    padded = np.concatenate([shift / sizes**2, np.zeros(tangent.shape[0] - len(sizes))])
    return SparseFactors((tangent + scipy.sparse.diags_array(padded)).tocsc())


def _settled(
    stiffness: Any, moved: Callable[[np.ndarray], np.ndarray], sizes: np.ndarray, motions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Ascending values and motions, in extents and radians, of a stiffness that factors know with some error."""
    row_sizes, count = sizes[:, None], motions.shape[1]

    def ritz(basis: np.ndarray):
        values, turned = np.linalg.eigh(stiffness.between(row_sizes * basis, row_sizes * basis))
        nearest = np.sort(np.argsort(np.abs(values))[:count])
        return values[nearest], basis @ turned[:, nearest]

    values, motions = ritz(motions)
    for turn in range(TURNS):
        step = moved(row_sizes * stiffness.forces(row_sizes * motions) - values * motions)
        for _ in range(2):
            step = step - motions @ (motions.T @ step)
        step_sizes = np.linalg.norm(step, axis=0)
        if np.all(step_sizes <= SETTLED_MOTION):
            break
        # Next to a value near zero, iterations do not settle the others.
        if turn > 0 and not step_sizes[np.argmin(np.abs(values))] <= LOST_MOTION:
            raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
        values, motions = ritz(np.linalg.qr(np.concatenate([motions, step], axis=1))[0])
    return values, motions


def _beyond(tangent: Any, sizes: np.ndarray, values: np.ndarray) -> int:
    """Number of negative values beyond those nearest to zero, one of which has a doubtful sign.

    Pivots are counted for a stiffness whose zero is shifted to the widest gap between these.
    """
    i = int(np.argmax(np.diff(values)))
    middle = (values[i] + values[i + 1]) / 2
    turned = shifted(tangent, -middle, sizes)
    count = negative_under_constraints(tangent, turned, len(sizes))
    if count is None:
        raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
    return count - int(np.sum(values < middle))


def _critical_values(values: np.ndarray, start: np.ndarray, more: int) -> CriticalValues:
    """Those nearest to zero of ascending values, with ``more`` negative ones beyond them."""
    nearest = np.sort(np.argsort(np.abs(values))[:TOLD])
    left_out = np.delete(values, nearest)
    return CriticalValues(values[nearest], max(more, 0) + int(np.sum(left_out < 0)), start)


def _values_near_zero(
    factored: SparseFactors, n_constraints: int, sizes: np.ndarray, start: np.ndarray, count: int, shift: float
):
    """Values nearest to zero, and their orthonormal motions in extents and radians."""
    import scipy.sparse.linalg

    n, linalg = len(sizes), scipy.sparse.linalg
    flexibility = linalg.LinearOperator((n, n), matvec=_flexibility(factored, n_constraints, sizes), dtype=float)
    how = {"ncv": max(BASIS, 2 * count + 1), "v0": _start_motions(start), "tol": CRITICAL_RESIDUAL}
    with explained_failures("Take other steps (step)"):
        soft, motions = linalg.eigsh(flexibility, k=count, **how)
    return 1 / soft - shift, motions


def _softest(moved: Callable[[np.ndarray], np.ndarray], sizes: np.ndarray, start: np.ndarray) -> tuple[Any, Any]:
    """The two largest eigenvalues of an unsymmetric flexibility, possibly a complex pair, and motions."""
    import scipy.sparse.linalg

    n, linalg = len(sizes), scipy.sparse.linalg
    flexibility = linalg.LinearOperator((n, n), matvec=moved, dtype=float)
    with explained_failures("Take other steps (step)"):
        return linalg.eigs(flexibility, k=2, ncv=BASIS, v0=_start_motions(start), tol=CRITICAL_RESIDUAL**2)


def _flexibility(
    factored: SparseFactors, h: int, sizes: np.ndarray, transposed: bool = False
) -> Callable[[np.ndarray], np.ndarray]:
    """Function from forces to motions, (n,) or (n, k), in extents and radians, with ``h`` constraints."""
    n = len(sizes)

    def moved(force: np.ndarray):
        size = sizes if force.ndim == 1 else sizes[:, None]
        return factored.solve(np.concatenate([force / size, np.zeros((h, *force.shape[1:]))]), transposed)[:n] / size

    return moved


def _start_motions(start: np.ndarray) -> np.ndarray:
    """Start of iterations: nearby motions, and uneven entries."""
    n = len(start)
    return start / max(np.linalg.norm(start), 1e-300) + uneven(n, 1) / np.sqrt(n)


def _allowed(tangent: Any, sizes: np.ndarray) -> np.ndarray:
    """Orthonormal motions in extents and radians that constraints leave, by dense matrices."""
    import scipy.linalg

    n = len(sizes)
    return scipy.linalg.null_space(tangent[n:, :n].toarray() * sizes) if tangent.shape[0] > n else np.eye(n)


def _all_of(tangent: Any, sizes: np.ndarray):
    """All values, ascending, by dense matrices; Lanczos iterations find few of many."""
    n, motions = len(sizes), _allowed(tangent, sizes)
    stiffness = sizes[:, None] * tangent[:n, :n].toarray() * sizes
    return np.linalg.eigvalsh(motions.T @ stiffness @ motions), np.zeros(n)
