"""Eigenvalues of dense stiffness and mass: natural frequencies, poles, and motions without mass.

M v = mu K v is solved, with omega^2 = 1/mu: the lowest omega^2 have full relative accuracy, and motions without mass
have mu = 0, while K v = omega^2 M v has no solution for them. If K alone is not definite, K + s M replaces it, with
omega^2 = 1/mu - s.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Bool, Complex, Float, Int

from ..arguments import computed
from ..errors import AnalysisError
from ..math.linear import (
    diagonal_of,
    factorise,
    is_positive_definite,
    is_positive_semidefinite,
    leading,
    pencil,
    unit_scale,
)
from ..math.subspace import independent_rows
from ..numerical_limits import (
    DEFINITE_STIFFNESS,
    FAINT,
    FIRST_SHIFT,
    GENERAL_SHIFT,
    GROWING_POLE,
    LOST_EIGENVALUE,
    MASSLESS_SHARE,
    NEXT_SHIFT,
    REAL_VALUE,
    REGULAR_STIFFNESS,
    ROUND_OFF,
    SIZES_APART,
    SURE_EIGENVALUE,
    TOLD_BESIDE_SHIFT,
    WITHOUT_MASS,
)
from ..results import RESULTS

# Growth of the shift from one try to the next, and number of tries.
SHIFT_GROWTH, MAX_SHIFTS = 8.0, 40
EPS = float(np.finfo(float).eps)


class Shift(NamedTuple):
    """A shift s >= 0 for which K + s M is positive definite.

    Attributes:
        value: s [rad^2/s^2].
        stable: Whether K itself is positive definite.
        exists: Whether such an s was found.
        lost: Whether eigenvalues are lost in round-off.
    """

    value: Float[Array, ""]
    stable: Bool[Array, ""]
    exists: Bool[Array, ""]
    lost: Bool[Array, ""]


class _Lowering(NamedTuple):
    """State of the search for a smaller shift; it ends when ``next_one`` is no smaller than ``shift``.

    Attributes:
        shift: Smallest useful shift so far; infinite before the first turn.
        next_one: Shift to try in the next turn.
        lowest: Lowest eigenvalue that is known beside round-off.
        all_sure: Whether all eigenvalues are known beside round-off, and positive.
        lost: Whether round-off hides some.
    """

    shift: Any
    next_one: Any
    lowest: Any
    all_sure: Any
    lost: Any


def shift_to_definite(k: Float[Array, "n n"], m: Float[Array, "n n"]) -> Shift:
    """Smallest tried shift for which K + s M is positive definite (THEORY.md 7, eq. (7.2)).

    The first shift found is a share of the largest stiffness, possibly of a beam too short to matter in any other
    motion. Then the eigenvalues are far below the digits of s. Each turn finds lower ones, until only zeros are left.
    """
    k, m = lax.stop_gradient(k), lax.stop_gradient(m)
    ratio = jnp.max(jnp.abs(diagonal_of(k)), initial=0.0) / jnp.max(diagonal_of(m), initial=0.0)
    ratio = jnp.where(jnp.isfinite(ratio) & (ratio > 0), ratio, 1.0)
    first, exists, tries = _smallest(k, m, jnp.zeros(()), FIRST_SHIFT * ratio, DEFINITE_STIFFNESS * ratio)
    stable = exists & (tries == 1)

    def lower(at: _Lowering) -> _Lowering:
        tried = at.next_one
        values, _, doubt = _eigenvalues(k, m, tried, *pencil(m, k + tried * m))
        sure = values > jnp.maximum(SURE_EIGENVALUE * doubt, TOLD_BESIDE_SHIFT * tried)
        lowest = jnp.min(jnp.where(sure, values, jnp.inf), initial=jnp.inf)
        # The shift of the first turn always counts.
        better = (lowest < at.lowest / 2) | jnp.isinf(at.shift)
        shift, lowest = jnp.where(better, tried, at.shift), jnp.where(better, lowest, at.lowest)
        goal, definite, _ = _smallest(k, m, NEXT_SHIFT * lowest, SHIFT_GROWTH * NEXT_SHIFT * lowest, 0.0)
        return _Lowering(
            shift=shift,
            next_one=jnp.where(better & definite & (lowest < shift), goal, shift),
            lowest=lowest,
            all_sure=jnp.where(better, jnp.all(sure), at.all_sure),
            lost=jnp.where(better, is_lost(values, doubt), at.lost),
        )

    no = jnp.array(False)
    start = _Lowering(jnp.where(exists & ~stable, jnp.inf, first), first, jnp.array(jnp.inf), no, no)
    end = lax.while_loop(lambda at: at.next_one < at.shift, lower, start)
    return Shift(end.shift, stable | (end.all_sure & is_positive_definite(k)), exists, end.lost)


def _smallest(
    k: Float[Array, "n n"], m: Float[Array, "n n"], first: Any, second: Any, margin: Any
) -> tuple[Any, Any, Any]:
    """Smallest shift tried with K + (s - margin) M positive definite, whether there is one, and number of tries."""

    def attempt(carry: tuple[Any, ...]):
        _, tried, _, tries = carry
        is_definite = is_positive_definite(k + (tried - margin) * m)
        return tried, jnp.where(tries == 0, second, SHIFT_GROWTH * tried), is_definite, tries + 1

    def unfinished(carry: tuple[Any, ...]):
        _, _, is_definite, tries = carry
        return ~is_definite & (tries <= MAX_SHIFTS)

    start = (jnp.zeros(()), first, jnp.array(False), jnp.zeros((), jnp.int32))
    s, _, is_definite, tries = lax.while_loop(unfinished, attempt, start)
    return s, is_definite, tries


def _eigenvalues(
    k: Float[Array, "n n"], m: Float[Array, "n n"], shift: Any, mu: Float[Array, "k"], w: Float[Array, "n k"]
) -> tuple[Any, Any, Any]:
    """Eigenvalues, infinite without mass, their vectors, and their round-off from the terms of v^T (K + s M) v."""
    massive = mu > MASSLESS_SHARE * k.shape[0] * jnp.max(mu, initial=0.0)
    positive = jnp.where(massive, mu, 1.0)
    values = jnp.where(massive, 1 / positive - shift, jnp.inf)
    sizes = jnp.abs(lax.stop_gradient(w))
    meeting = jnp.sum(sizes * (jnp.abs(lax.stop_gradient(k + shift * m)) @ sizes), axis=0)
    doubt = EPS * meeting / lax.stop_gradient(positive)
    return values, jnp.where(massive, w / jnp.sqrt(positive), 0.0), jnp.where(massive, doubt, 0.0)


def is_lost(values: Any, doubt: Any) -> Any:
    """Whether round-off hides an eigenvalue that is not negligible beside the lowest accurate eigenvalue."""
    values = jnp.where(jnp.isfinite(values), values, 0.0)
    lowest = jnp.min(jnp.where(LOST_EIGENVALUE * values > doubt, values, jnp.inf), initial=jnp.inf)
    return jnp.any((doubt > LOST_EIGENVALUE * jnp.abs(values)) & (doubt > FAINT * lowest))


def spectrum(
    k: Float[Array, "n n"], m: Float[Array, "n n"], count: int | None = None
) -> tuple[Float[Array, "n"], Float[Array, "n n"], Bool[Array, ""], Int[Array, ""]]:
    """Eigenvalues and M-orthonormal vectors of K v = omega^2 M v (THEORY.md 7, eq. (7.2)).

    M v = mu K v is solved, which gives the lowest omega^2 = 1/mu full relative accuracy; solved as (K, M), their error
    is round-off times the largest.

    Args:
        k, m: Symmetric stiffness of any definiteness, and mass, positive semidefinite.
        count: Number of the lowest; all by default.

    Returns:
        omega^2 ascending, infinite for massless motions, (n,) [rad^2/s^2]; vectors, zero for these, (n, n); whether K
            is positive definite; code of RESULTS: singular_mass if M has a negative eigenvalue, lost_in_round_off if
            stiffnesses are too far apart.
    """
    shift = shift_to_definite(k, m)
    shifted = k + shift.value * m
    if count is None or count >= k.shape[0]:
        mu, w = pencil(m, shifted)
        mu, w = mu[::-1], w[:, ::-1]
    else:
        mu, w = leading(m, shifted, count)
    values, vectors, doubt = _eigenvalues(k, m, shift.value, mu, w)
    lost = shift.lost | is_lost(lax.stop_gradient(values), doubt)
    result = jnp.where(lost, RESULTS.lost_in_round_off, RESULTS.successful)
    result = jnp.where(is_positive_semidefinite(lax.stop_gradient(m)), result, RESULTS.singular_mass)
    result = jnp.where(shift.exists, result, RESULTS.singular_stiffness)
    return values, vectors, shift.stable, result.astype(jnp.int32)


def to_frequency(eigenvalues: Any) -> Any:
    """Frequencies sqrt(|omega^2|)/2 pi with the sign of omega^2 [Hz]; the derivative at zero is zero."""

    def convert(xp: Any, values: Any):
        usual = xp.isfinite(values) & (values != 0)
        root = xp.sqrt(xp.abs(xp.where(usual, values, 1.0))) / (2 * np.pi)
        return xp.where(usual, xp.sign(values) * root, values)

    return computed(convert, eigenvalues)


def is_real(values: Any) -> Any:
    """Whether each of several complex values is real but for round-off."""
    return abs(values.imag) <= REAL_VALUE * abs(values)


def _with_shift(
    k: np.ndarray, m: np.ndarray, solve: Callable[[np.ndarray], Any], first: float = FIRST_SHIFT
) -> tuple[float, Any]:
    """Smallest tried s >= 0 for which a problem in K + s M has a solution, and the solution; on the host."""
    heaviest = np.max(np.diag(m), initial=0.0)
    ratio = np.max(np.abs(np.diag(k)), initial=0.0) / heaviest if heaviest > 0 else 1.0
    ratio, shift = ratio or 1.0, 0.0

    def attempt(shift: float):
        try:
            return solve(k + shift * m)
        except np.linalg.LinAlgError:
            return None

    def lowest_told(shift: float, solution: Any):
        mu = solution[0][np.abs(solution[0]) > MASSLESS_SHARE * len(m) * np.max(np.abs(solution[0]), initial=0.0)]
        values = np.real(1 / mu - shift)
        return np.min(values[values > TOLD_BESIDE_SHIFT * shift], initial=np.inf)

    for _ in range(MAX_SHIFTS + 1):
        eigenpairs = attempt(shift)
        # A stiffness of round-off would leave no digits for the others.
        if eigenpairs is not None and np.all(np.abs(eigenpairs[0]) * DEFINITE_STIFFNESS * ratio < 1):
            break
        shift = max(SHIFT_GROWTH * shift, first * ratio)
    else:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    lowest = lowest_told(shift, eigenpairs)
    # As in :func:`shift_to_definite`, for a shift above the eigenvalues.
    while lowest < shift:
        after = NEXT_SHIFT * lowest
        beside = attempt(after)
        lowest_beside = np.inf if beside is None else lowest_told(after, beside)
        if not lowest_beside < lowest / 2:
            break
        shift, eigenpairs, lowest = after, beside, lowest_beside
    return shift, eigenpairs


def symmetric_eigenvalues(k: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Eigenvalues of the motions with mass as in :func:`spectrum`, on the host, without compilation."""
    import scipy.linalg

    shift, (mu,) = _with_shift(k, m, lambda shifted: (scipy.linalg.eigh(m, shifted, eigvals_only=True)[::-1],))
    return 1 / mu[mu > MASSLESS_SHARE * len(mu) * np.max(mu, initial=0.0)] - shift


def general_spectrum(k: np.ndarray, m: np.ndarray) -> tuple[Any, Any]:
    """Eigenvalues and vectors of K v = omega^2 M v for an unsymmetric K, on the host; or singular_stiffness.

    Complex omega^2 by ascending real part, infinite for motions without mass [rad^2/s^2].
    """
    shift, (mu, vectors) = _with_shift(k, m, lambda shifted: np.linalg.eig(np.linalg.solve(shifted, m)), GENERAL_SHIFT)
    massive = np.abs(mu) > MASSLESS_SHARE * len(mu) * np.max(np.abs(mu), initial=0.0)
    values: Any = np.where(massive, 1 / np.where(massive, mu, 1.0) - shift, np.inf).astype(complex)
    order = np.argsort(values.real, kind="stable")
    return values[order], vectors[:, order]


def real_frequencies(k: np.ndarray, m: np.ndarray) -> Float[np.ndarray, "n"]:
    """Frequencies for an unsymmetric K, ascending [Hz]; NaN if complex."""
    values, _ = general_spectrum(k, m)
    return np.sort(to_frequency(np.where(is_real(values), values.real, np.nan)))


def poles_of(k: np.ndarray, c: np.ndarray, m: np.ndarray) -> Complex[np.ndarray, "n"]:
    """Finite solutions of det(lambda^2 M + lambda C + K) = 0, ordered by |Im| [rad/s], on the host.

    THEORY.md 7, eq. (7.3): companion form with the mass on the right, by the QZ method.
    """
    import scipy.linalg

    n = len(m)
    if not n:
        return np.zeros(0, complex)
    # Scale degrees of freedom to alike stiffness and mass, and time to make both of one size. Otherwise the QZ method
    # is accurate to round-off of the largest entry alone, and slow poles have wrong damping.
    stiff, heavy = (np.max(np.abs(matrix), initial=0.0) or 1.0 for matrix in (k, m))
    size = np.abs(np.diag(k)) / stiff + np.abs(np.diag(m)) / heavy
    scale = unit_scale(size)
    k, c, m = (part * scale[:, None] * scale for part in (k, c, m))
    stiff, heavy = (np.linalg.norm(matrix) or 1.0 for matrix in (k, m))
    w = np.sqrt(stiff / heavy)
    eye, zero = np.eye(n), np.zeros((n, n))
    left_pencil = np.block([[zero, eye], [-k / stiff, -c / (w * heavy)]])
    right_pencil = np.block([[eye, zero], [zero, m / heavy]])
    quotients: Any = scipy.linalg.eigvals(left_pencil, right_pencil, homogeneous_eigvals=True)
    top, bottom = quotients[0], quotients[1].real
    finite = np.abs(bottom) > MASSLESS_SHARE * n * np.abs(top) / np.max(np.abs(left_pencil))
    return in_order(_with_slow(w * top[finite] / bottom[finite], k, c, m))


def in_order(poles: Any) -> Complex[np.ndarray, "n"]:
    """Poles ordered by |Im|."""
    return poles[np.lexsort((poles.imag, np.round(np.abs(poles.imag), 9)))]


def slowest(poles: Any, count: int | None) -> Complex[np.ndarray, "n"]:
    """The ``count`` poles nearest to zero in their order, one more if the last is one of a complex pair."""
    if count is None or count >= len(poles):
        return poles
    order = np.argsort(np.abs(poles), kind="stable")
    last, after = poles[order[count - 1]], poles[order[count]]
    pair = last.imag != 0 and abs(after - np.conj(last)) <= REAL_VALUE * abs(last)
    return poles[np.sort(order[: count + int(pair)])]


def _with_slow(fast: np.ndarray, k: np.ndarray, c: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Poles whose slower half, by orders of size, is solved again from the stiffness side.

    The QZ method is accurate to round-off of the fastest pole. The eigenvalues 1/lambda of K^-1 M and K^-1 C are
    accurate to round-off of the slowest pole.
    """
    scale = unit_scale(np.diag(k))
    k, c, m = (matrix * scale[:, None] * scale for matrix in (k, c, m))
    if not len(fast) or np.linalg.cond(k) > REGULAR_STIFFNESS:
        return fast
    n, by_mass, by_damping = len(k), np.linalg.solve(k, m), np.linalg.solve(k, c)
    unit = np.sqrt(np.linalg.norm(by_mass)) + np.linalg.norm(by_damping)
    inverse = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-by_mass / unit**2, -by_damping / unit]]))
    inverse = inverse[np.argsort(-np.abs(inverse))][: len(fast)]
    fast = fast[np.argsort(np.abs(fast))]
    sizes = np.abs(inverse)
    # Cut at the gap nearest to the middle.
    gaps = 1 + np.flatnonzero(sizes[1:] < (1 - SIZES_APART) * sizes[:-1])
    if not len(gaps) or sizes[0] == 0 or sizes[-1] == 0:
        return fast
    middle = np.sqrt(sizes[0] * 1 / (np.abs(fast[-1]) * unit))
    cut = gaps[np.argmin(np.abs(np.log(sizes[gaps] / middle)))]
    return np.concatenate([1 / (unit * inverse[:cut]), fast[cut:]])


def masses_of_motions(mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending eigenvalues [-] and vectors of a mass matrix, scaled to one on the diagonal."""
    size = np.abs(np.diag(mass))
    scale = unit_scale(size)
    values, vectors = np.linalg.eigh((mass + mass.T) / 2 * scale[:, None] * scale)
    return values, vectors * scale[:, None]


def massless_freedoms(mass: np.ndarray) -> list[int]:
    """Degrees of freedom to condense, so that the mass matrix of the others is regular."""
    values, motions = masses_of_motions(mass)
    null = motions[:, values <= WITHOUT_MASS * len(values)]
    chosen, _ = independent_rows(null, null.shape[1], 0.0)
    return sorted(chosen)


def response_without_mass(mass: Any, stiffness: Any, condensed: tuple[int, ...], forces: Any, solve: Any = None) -> Any:
    """Displacements of motions without mass under forces: N (N^T K N)^-1 N^T f with M N = 0.

    The mass matrix is regular without the degrees of freedom ``condensed``. ``solve`` solves a matrix for right-hand
    sides.
    """
    solve = solve or (lambda matrix, right: factorise(matrix).solve(right))
    out, remaining = np.array(condensed, int), np.array([i for i in range(len(mass)) if i not in condensed], int)
    eye = np.eye(len(mass))
    null = eye[:, out] - eye[:, remaining] @ solve(mass[np.ix_(remaining, remaining)], mass[np.ix_(remaining, out)])
    return null @ solve(null.T @ stiffness @ null, null.T @ forces)


def without_growth(k: np.ndarray, c: np.ndarray, m: np.ndarray) -> bool:
    """Whether no motion about a state of stiffness K, damping C and mass M, of known numbers, grows.

    THEORY.md 7, eq. (7.3): no pole has a positive real part; without damping all omega^2 are real and positive. A
    motion without mass loses its stability when the determinant of the stiffness changes sign, which is not checked.
    """
    if np.any(c):
        return not any_grows(poles_of(k, c, m))
    values, _ = general_spectrum(k, m)
    values = values[np.isfinite(values)]
    return bool(np.all(is_real(values) & (values.real > 0)))


def any_grows(poles: Any, share: float = GROWING_POLE) -> bool:
    """Whether some pole has a real part above a share of its size, and is no round-off beside the largest."""
    sizes = np.abs(poles)
    return bool(np.any((np.real(poles) > share * sizes) & (sizes > ROUND_OFF * np.max(sizes, initial=0.0))))
