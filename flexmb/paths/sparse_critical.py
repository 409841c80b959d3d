"""Critical values of large mechanisms: how many are negative by the factors' pivots, the nearest to zero iterated."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import AnalysisError
from ..linear.lanczos import named
from ..math.linear import uneven
from ..math.sparse import SparseFactors, negative_where_held
from ..results import RESULTS

# Critical values that are told: those nearest to zero.
TOLD = 4
# Vectors of the Lanczos method for them, and the share to which a motion is an eigenvector; values are known to its
# square.
BASIS = 14
RESIDUAL = 1e-7
# What makes an exactly singular stiffness regular, as share of its largest entry.
SHIFT = 1e-13

# What the factors make of a residual is to be so small beside a motion, its square being the error of the value, after
# so many turns; where it is more than the last share after the first one, which finds what copies of a value iterations
# have passed over, round-off hides where the path goes beside a critical point.
SETTLED, TURNS, LOST = 1e-5, 4, 1e-3
# Pivots may miss the sign of a value that is no larger than so many times what factors and better products differ by.
DOUBTED = 100


class Stiffness(Protocol):
    """Stiffness by the deformations of elements, which round-off spoils less than the factors."""

    def between(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Between motions that constraints allow, (n, k) and (n, m): (k, m)."""
        ...

    def forces(self, motions: np.ndarray) -> np.ndarray:
        """On motions, (n, k)."""
        ...


class CriticalValues(NamedTuple):
    """Critical values at a state; of a stiffness that is not symmetric one that stands for all.

    Attributes:
        values: Those nearest to zero, ascending, (n,) [N m].
        below: How many more of them are negative.
        start: Sum of their motions in extents and radians, from which those of a state nearby are found, (n_free,).
    """

    values: np.ndarray
    below: int
    start: np.ndarray


def critical_values_of(
    tangent: Any, factored: SparseFactors, sizes: np.ndarray, start: np.ndarray, stiffness: Stiffness
) -> CriticalValues:
    """Eigenvalues of the stiffness against the square of motions in extents and radians, where constraints hold.

    They are found and counted by factors, of which round-off of many short beams spoils some digits, and then told
    apart in their motions by a better product.

    Args:
        tangent: Sparse [[K, D^T], [D, 0]], (n + h, n + h).
        factored: Its factors.
        sizes: What the coordinates that move are measured against, (n,) [m, rad].
        start: Any motion, (n,); near to those that are looked for if it can be.
        stiffness: The same by deformations.

    Raises:
        AnalysisError: lost_in_round_off.

    Source:
        Shift-inverted Lanczos method of ARPACK; Ritz's method in motions and in what factors make of their residuals
        (Davidson 1975).
    """
    rest = tangent.shape[0] - len(sizes)
    every, shift = len(sizes) - rest, 0.0
    if every <= 2 * BASIS:
        return _told(*_all_of(tangent, sizes), 0)
    if not factored.regular:
        shift = SHIFT * abs(tangent).max()
        factored = shifted(tangent, shift, sizes)
    negative = negative_where_held(tangent, factored, len(sizes))

    def settled(motions: np.ndarray):
        return _settled(stiffness, _flexibility(factored, rest, sizes), sizes, motions)

    if negative is not None:
        rough, motions = _nearest(factored, rest, sizes, start, TOLD, shift)
        values, motions = settled(motions)
        more = negative - int(np.sum(rough < -shift))
        doubted = DOUBTED * np.max(np.abs(np.sort(rough) - values))
        if np.min(np.abs(values)) < doubted < np.max(np.diff(values)):
            more = _beyond(tangent, sizes, values)
        return _told(values, np.sum(motions, axis=1), more)
    # Values become negative through zero: few are farther than those that are found, where the farthest are positive.
    count = 2 * TOLD
    while 2 * count < every:
        values, motions = _nearest(factored, rest, sizes, start, count, shift)
        if np.all(values[np.argsort(np.abs(values))[-2:]] > 0):
            values, motions = settled(motions)
            return _told(values, np.sum(motions, axis=1), 0)
        count *= 2
    return _told(*_all_of(tangent, sizes), 0)


def value_of_determinant(
    tangent: Any, factored: SparseFactors, sizes: np.ndarray, start: np.ndarray, stiffness: Stiffness
) -> CriticalValues:
    """Smallest modulus of the eigenvalues where the stiffness is not symmetric, with the sign of the determinant.

    Arguments as of :func:`critical_values_of`.

    Source:
        det K as the product of its eigenvalues; with h constraints that of [[K, D^T], [D, 0]] has the sign of that of K
        where they hold, times (-1)^h. Arnoldi method of ARPACK.
    """
    rest = tangent.shape[0] - len(sizes)
    if not factored.regular:
        return CriticalValues(np.zeros(1), 0, start)
    moved, sign = _flexibility(factored, rest, sizes), (-1) ** rest * factored.sign
    if len(sizes) - rest <= 2 * BASIS:
        motions = _allowed(tangent, sizes)
        soft = np.linalg.eigvals(motions.T @ moved(motions))
        largest = np.max(np.abs(soft), initial=0.0)
        return CriticalValues(np.array([sign / largest if largest > 0 else np.inf]), 0, start)
    soft, shapes = _softest(moved, sizes, start)
    i = int(np.argmax(np.abs(soft)))
    value, begin = sign / abs(soft[i]), np.sum(shapes.real, axis=1)
    if abs(soft[i].imag) <= RESIDUAL * abs(soft[i]):
        # A simple one: by the quotient with its left eigenvector, sign and all.
        others, left = _softest(_flexibility(factored, rest, sizes, transposed=True), sizes, start)
        j = int(np.argmin(np.abs(others - soft[i])))
        own, v, w = sizes[:, None], shapes[:, [i]].real, left[:, [j]].real
        apart = float(np.sum(w * v))
        if apart != 0:
            quotient = float(stiffness.between(own * w, own * v)[0, 0]) / apart
            rest_sign = sign * np.sign(soft[i].real)
            if abs(quotient) < DOUBTED * abs(1 / soft[i].real - quotient):
                # With so much added, no other one changes its sign, and this one is positive.
                rest_sign = (-1) ** rest * shifted(tangent, 0.5 / abs(soft[1 - i]), sizes).sign
            value = rest_sign * quotient
    return CriticalValues(np.array([value]), 0, begin)


def shifted(tangent: Any, shift: float, sizes: np.ndarray) -> SparseFactors:
    """Factors of a tangent whose critical values are all increased."""
    import scipy.sparse

    padded = np.concatenate([shift / sizes**2, np.zeros(tangent.shape[0] - len(sizes))])
    return SparseFactors((tangent + scipy.sparse.diags_array(padded)).tocsc())


def _settled(
    stiffness: Stiffness, moved: Callable[[np.ndarray], np.ndarray], sizes: np.ndarray, motions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values, ascending, and motions in extents and radians of a stiffness that factors know with some error."""
    own, count = sizes[:, None], motions.shape[1]

    def ritz(basis: np.ndarray):
        values, turned = np.linalg.eigh(stiffness.between(own * basis, own * basis))
        nearest = np.sort(np.argsort(np.abs(values))[:count])
        return values[nearest], basis @ turned[:, nearest]

    values, motions = ritz(motions)
    for turn in range(TURNS):
        step = moved(own * stiffness.forces(own * motions) - values * motions)
        for _ in range(2):
            step = step - motions @ (motions.T @ step)
        left = np.linalg.norm(step, axis=0)
        if np.all(left <= SETTLED):
            break
        # Beside one near to zero iterations do not settle the others.
        if turn > 0 and not left[np.argmin(np.abs(values))] <= LOST:
            raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
        values, motions = ritz(np.linalg.qr(np.concatenate([motions, step], axis=1))[0])
    return values, motions


def _beyond(tangent: Any, sizes: np.ndarray, values: np.ndarray) -> int:
    """How many negative values there are that are not among those nearest to zero, one of which has a doubtful sign.

    Pivots are counted of a stiffness less so much that zero lies in the widest gap between these.
    """
    i = int(np.argmax(np.diff(values)))
    middle = (values[i] + values[i + 1]) / 2
    turned = shifted(tangent, -middle, sizes)
    count = negative_where_held(tangent, turned, len(sizes))
    if count is None:
        raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
    return count - int(np.sum(values < middle))


def _told(values: np.ndarray, start: np.ndarray, more: int) -> CriticalValues:
    """Those nearest to zero of ascending values, with ``more`` negative ones that are not among them."""
    nearest = np.sort(np.argsort(np.abs(values))[:TOLD])
    left_out = np.delete(values, nearest)
    return CriticalValues(values[nearest], max(more, 0) + int(np.sum(left_out < 0)), start)


def _nearest(factored: SparseFactors, rest: int, sizes: np.ndarray, start: np.ndarray, count: int, shift: float):
    """Values nearest to zero, and their motions in extents and radians, orthonormal, with ``rest`` constraints."""
    import scipy.sparse.linalg

    n, linalg = len(sizes), scipy.sparse.linalg
    flexibility = linalg.LinearOperator((n, n), matvec=_flexibility(factored, rest, sizes), dtype=float)
    how = {"ncv": max(BASIS, 2 * count + 1), "v0": _near(start), "tol": RESIDUAL}
    with named("Take other steps (step)"):
        soft, motions = linalg.eigsh(flexibility, k=count, **how)
    return 1 / soft - shift, motions


def _softest(moved: Callable[[np.ndarray], np.ndarray], sizes: np.ndarray, start: np.ndarray) -> tuple[Any, Any]:
    """Largest eigenvalues of a flexibility that is not symmetric, a pair of them being complex perhaps, and motions."""
    import scipy.sparse.linalg

    n, linalg = len(sizes), scipy.sparse.linalg
    flexibility = linalg.LinearOperator((n, n), matvec=moved, dtype=float)
    with named("Take other steps (step)"):
        return linalg.eigs(flexibility, k=2, ncv=BASIS, v0=_near(start), tol=RESIDUAL**2)


def _flexibility(
    factored: SparseFactors, rest: int, sizes: np.ndarray, transposed: bool = False
) -> Callable[[np.ndarray], np.ndarray]:
    """Motions under forces, (n,) or (n, k), in extents and radians, with ``rest`` constraints."""
    n = len(sizes)

    def moved(force: np.ndarray):
        own = sizes if force.ndim == 1 else sizes[:, None]
        return factored.solve(np.concatenate([force / own, np.zeros((rest, *force.shape[1:]))]), transposed)[:n] / own

    return moved


def _near(start: np.ndarray) -> np.ndarray:
    """What iterations begin with: what they are near to, and uneven entries."""
    n = len(start)
    return start / max(np.linalg.norm(start), 1e-300) + uneven(n, 1) / np.sqrt(n)


def _allowed(tangent: Any, sizes: np.ndarray) -> np.ndarray:
    """Motions in extents and radians that constraints leave, orthonormal, by dense matrices."""
    import scipy.linalg

    n = len(sizes)
    return scipy.linalg.null_space(tangent[n:, :n].toarray() * sizes) if tangent.shape[0] > n else np.eye(n)


def _all_of(tangent: Any, sizes: np.ndarray):
    """All of them, ascending, by dense matrices: Lanczos iterations find a few of many."""
    n, motions = len(sizes), _allowed(tangent, sizes)
    stiffness = sizes[:, None] * tangent[:n, :n].toarray() * sizes
    return np.linalg.eigvalsh(motions.T @ stiffness @ motions), np.zeros(n)
