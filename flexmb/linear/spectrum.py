"""The one place that solves stiffness and mass: natural frequencies, poles, and motions that carry no mass.

M v = mu K v is solved, with omega^2 = 1/mu: the lowest omega^2 come out with full relative accuracy, and motions
without mass have mu = 0 where K v = omega^2 M v has no solution. Where K alone will not do, K + s M stands in its
place, with omega^2 = 1/mu - s.
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Bool, Complex, Float, Int

from ..arguments import computed
from ..errors import AnalysisError
from ..math.linear import diagonal_of, factorise, is_positive_definite, is_positive_semidefinite, leading, pencil
from ..math.subspace import independent_rows
from ..results import RESULTS

# A stiffness is taken as it is where its lowest eigenvalue is above this share of |K|/|M|.
LOWEST = 1e-14
# Otherwise the shift starts at this share and grows by this factor until K + sM is positive definite, so that it is not
# much larger than the most negative eigenvalue asks for. A smaller one leaves no digits for the others beside a free
# motion.
FIRST_SHIFT = 1e-8
SHIFT_GROWTH = 8.0
# Of an unsymmetric K, whose definiteness no factors tell: beside a free motion, eigenvalues from 1e-12 to 1 of |K|/|M|
# then keep nine digits.
GENERAL_SHIFT = 1e-6
MAX_SHIFTS = 40
# Beside a shift an eigenvalue is told from zero that is above this share of it. The next shift tried is this share of
# the lowest that is told: what is below both shares of that is zero beside it.
TOLD = 1e-10
NEXT_SHIFT = 1e-4
EPS = float(np.finfo(float).eps)
# An eigenvalue is told where it is so many times what round-off makes of it, and lost where that is this share of it,
# and this share of others: a zero beside them, as at a critical state, is not.
SURE = 10.0
LOST = 1e-3
FAINT = 1e-9
# A motion has no mass where its mu is below this share of the largest, for each degree of freedom.
MASSLESS = 100 * float(np.finfo(float).eps)
# A combination of degrees of freedom has no mass where that is below this share of what the degrees of freedom have
# that meet in it, for each of them.
WITHOUT_MASS = 1e-13
# Poles are solved from the stiffness side where it is as well conditioned as this, and taken apart where sizes differ.
REGULAR = 1e12
APART = 1e-6
# A value is real where its imaginary part is below this share of it.
REAL = 1e-8
# A pole grows whose real part is above this share of its size, unless that is round-off beside the largest.
GROWS, NOTHING = 1e-9, 1e-12


def shift_to_definite(
    k: Float[Array, "n n"], m: Float[Array, "n n"]
) -> tuple[Float[Array, ""], Bool[Array, ""], Bool[Array, ""]]:
    """Smallest tried s >= 0 for which K + s M is positive definite, THEORY.md 7, eq. (7.2).

    Returns:
        s, () [rad^2/s^2]; whether K itself is positive definite; whether an s was found.
    """
    s, stable, found, _ = _shift(k, m)
    return s, stable, found


def _shift(k: Float[Array, "n n"], m: Float[Array, "n n"]) -> tuple[Any, Any, Any, Any]:
    """As :func:`shift_to_definite`, and whether eigenvalues are lost in round-off."""
    k, m = lax.stop_gradient(k), lax.stop_gradient(m)
    ratio = jnp.max(jnp.abs(diagonal_of(k)), initial=0.0) / jnp.max(diagonal_of(m), initial=0.0)
    ratio = jnp.where(jnp.isfinite(ratio) & (ratio > 0), ratio, 1.0)
    s, found, tries = _smallest(k, m, jnp.zeros(()), FIRST_SHIFT * ratio, LOWEST * ratio)
    stable = found & (tries == 1)

    # That is a share of the largest stiffness, which may be of a beam so short that no other motion has any of it, with
    # eigenvalues far below the digits of s. Each turn tells lower ones, until none is left but zeros.
    def unfinished(carry: tuple[Any, ...]):
        s, after, *_ = carry
        return after < s

    def lower(carry: tuple[Any, ...]):
        s, after, lowest, told, lost = carry
        values, _, doubt = _eigenvalues(k, m, after, *pencil(m, k + after * m))
        sure = values > jnp.maximum(SURE * doubt, TOLD * after)
        own = jnp.min(jnp.where(sure, values, jnp.inf), initial=jnp.inf)
        more = (own < lowest / 2) | jnp.isinf(s)
        s, lowest = jnp.where(more, after, s), jnp.where(more, own, lowest)
        told, lost = jnp.where(more, jnp.all(sure), told), jnp.where(more, is_lost(values, doubt), lost)
        goal, definite, _ = _smallest(k, m, NEXT_SHIFT * lowest, SHIFT_GROWTH * NEXT_SHIFT * lowest, 0.0)
        return s, jnp.where(more & definite & (lowest < s), goal, s), lowest, told, lost

    no = jnp.array(False)
    start = jnp.where(found & ~stable, jnp.inf, s), s, jnp.array(jnp.inf), no, no
    s, _, _, told, lost = lax.while_loop(unfinished, lower, start)
    return s, stable | (told & is_positive_definite(k)), found, lost


def _smallest(
    k: Float[Array, "n n"],
    m: Float[Array, "n n"],
    first: Float[Array, ""],
    second: Float[Array, ""],
    margin: float | Float[Array, ""],
) -> tuple[Any, Any, Any]:
    """Smallest shift tried with K + (s - margin) M positive definite, whether there is one, and how many were tried."""

    def attempt(carry: tuple[Any, ...]):
        _, after, _, tries = carry
        found = is_positive_definite(k + (after - margin) * m)
        return after, jnp.where(tries == 0, second, SHIFT_GROWTH * after), found, tries + 1

    def unfinished(carry: tuple[Any, ...]):
        _, _, found, tries = carry
        return ~found & (tries <= MAX_SHIFTS)

    start = (jnp.zeros(()), first, jnp.array(False), jnp.zeros((), jnp.int32))
    s, _, found, tries = lax.while_loop(unfinished, attempt, start)
    return s, found, tries


def _eigenvalues(
    k: Float[Array, "n n"],
    m: Float[Array, "n n"],
    shift: Float[Array, ""],
    mu: Float[Array, "k"],
    w: Float[Array, "n k"],
) -> tuple[Any, Any, Any]:
    """Eigenvalues, infinite for motions without mass, their vectors, and how far round-off may move them.

    Round-off is that of the terms whose sum v^T (K + s M) v is.
    """
    massive = mu > MASSLESS * k.shape[0] * jnp.max(mu, initial=0.0)
    positive = jnp.where(massive, mu, 1.0)
    values = jnp.where(massive, 1 / positive - shift, jnp.inf)
    sizes = jnp.abs(lax.stop_gradient(w))
    meeting = jnp.sum(sizes * (jnp.abs(lax.stop_gradient(k + shift * m)) @ sizes), axis=0)
    doubt = EPS * meeting / lax.stop_gradient(positive)
    return values, jnp.where(massive, w / jnp.sqrt(positive), 0.0), jnp.where(massive, doubt, 0.0)


def is_lost(values: Any, doubt: Any) -> Any:
    """Whether round-off hides an eigenvalue that is no zero beside the lowest of those that are known well."""
    values = jnp.where(jnp.isfinite(values), values, 0.0)
    lowest = jnp.min(jnp.where(LOST * values > doubt, values, jnp.inf), initial=jnp.inf)
    return jnp.any((doubt > LOST * jnp.abs(values)) & (doubt > FAINT * lowest))


def spectrum(
    k: Float[Array, "n n"], m: Float[Array, "n n"], count: int | None = None
) -> tuple[Float[Array, "n"], Float[Array, "n n"], Bool[Array, ""], Int[Array, ""]]:
    """Eigenvalues and M-orthonormal vectors of K v = omega^2 M v, THEORY.md 7, eq. (7.2).

    M v = mu K v is solved, where the lowest omega^2 = 1/mu come out with full relative accuracy; solved as (K, M),
    they are known only to round-off times the largest.

    Args:
        k, m: Symmetric stiffness of any definiteness, and mass, positive semidefinite, (n, n).
        count: How many of the lowest; all unless given.

    Returns:
        omega^2 ascending, infinite for massless motions, (n,) [rad^2/s^2]; vectors, zero for these, (n, n); whether K
        is positive definite; code of RESULTS: singular_mass where M has a negative eigenvalue, lost_in_round_off where
        stiffnesses are too far apart.
    """
    shift, stable, found, lost = _shift(k, m)
    n = k.shape[0]
    if count is None or count >= n:
        mu, w = pencil(m, k + shift * m)
        mu, w = mu[::-1], w[:, ::-1]
    else:
        mu, w = leading(m, k + shift * m, count)
    values, vectors, doubt = _eigenvalues(k, m, shift, mu, w)
    lost = lost | is_lost(lax.stop_gradient(values), doubt)
    result = jnp.where(lost, RESULTS.lost_in_round_off, RESULTS.successful)
    result = jnp.where(is_positive_semidefinite(lax.stop_gradient(m)), result, RESULTS.singular_mass)
    result = jnp.where(found, result, RESULTS.singular_stiffness)
    return values, vectors, stable, result.astype(jnp.int32)


def to_frequency(eigenvalues: Any) -> Any:
    """Frequencies sqrt(|omega^2|)/2 pi with the sign of omega^2, (n,) [Hz]; the derivative at zero is taken as zero."""

    def found(xp: Any, values: Any):
        usual = xp.isfinite(values) & (values != 0)
        root = xp.sqrt(xp.abs(xp.where(usual, values, 1.0))) / (2 * np.pi)
        return xp.where(usual, xp.sign(values) * root, values)

    return computed(found, eigenvalues)


def is_real(values: Any) -> Any:
    """Which of several complex values are real but for round-off, (n,)."""
    return abs(values.imag) <= REAL * abs(values)


def _with_shift(
    k: np.ndarray, m: np.ndarray, solve: Callable[[np.ndarray], Any], first: float = FIRST_SHIFT
) -> tuple[float, Any]:
    """Smallest tried s >= 0 for which a problem in K + s M has a solution, and that solution; on the host."""
    heaviest = np.max(np.diag(m), initial=0.0)
    ratio = np.max(np.abs(np.diag(k)), initial=0.0) / heaviest if heaviest > 0 else 1.0
    ratio, shift = ratio or 1.0, 0.0

    def attempt(shift: float):
        try:
            return solve(k + shift * m)
        except np.linalg.LinAlgError:
            return None

    def lowest_told(shift: float, found: Any):
        mu = found[0][np.abs(found[0]) > MASSLESS * len(m) * np.max(np.abs(found[0]), initial=0.0)]
        values = np.real(1 / mu - shift)
        return np.min(values[values > TOLD * shift], initial=np.inf)

    for _ in range(MAX_SHIFTS + 1):
        found = attempt(shift)
        # Zero stiffness but for round-off would leave no digits for the others.
        if found is not None and np.all(np.abs(found[0]) * LOWEST * ratio < 1):
            break
        shift = max(SHIFT_GROWTH * shift, first * ratio)
    else:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    lowest = lowest_told(shift, found)
    # As in :func:`shift_to_definite`, of a shift that is longer than eigenvalues.
    while lowest < shift:
        after = NEXT_SHIFT * lowest
        beside = attempt(after)
        own = np.inf if beside is None else lowest_told(after, beside)
        if not own < lowest / 2:
            break
        shift, found, lowest = after, beside, own
    return shift, found


def symmetric_eigenvalues(k: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Eigenvalues of the motions with mass as of :func:`spectrum`, on the host, where compiling takes longer."""
    import scipy.linalg

    shift, (mu,) = _with_shift(k, m, lambda shifted: (scipy.linalg.eigh(m, shifted, eigvals_only=True)[::-1],))
    return 1 / mu[mu > MASSLESS * len(mu) * np.max(mu, initial=0.0)] - shift


def general_spectrum(k: np.ndarray, m: np.ndarray) -> tuple[Any, Any]:
    """Eigenvalues and vectors of K v = omega^2 M v where K may be unsymmetric, on the host; or singular_stiffness.

    Returns:
        omega^2 by ascending real part, complex, infinite for motions without mass, (n,) [rad^2/s^2]; vectors, (n, n).
    """
    shift, (mu, vectors) = _with_shift(k, m, lambda shifted: np.linalg.eig(np.linalg.solve(shifted, m)), GENERAL_SHIFT)
    massive = np.abs(mu) > MASSLESS * len(mu) * np.max(np.abs(mu), initial=0.0)
    values: Any = np.where(massive, 1 / np.where(massive, mu, 1.0) - shift, np.inf).astype(complex)
    order = np.argsort(values.real, kind="stable")
    return values[order], vectors[:, order]


def poles_of(k: np.ndarray, c: np.ndarray, m: np.ndarray) -> Complex[np.ndarray, "n"]:
    """Solutions of det(lambda^2 M + lambda C + K) = 0 on the host, ordered by |Im|, at most (2 n,) [rad/s].

    Those at infinity are left out. THEORY.md 7, eq. (7.3): companion form with the mass on the right, by the QZ method.
    """
    import scipy.linalg

    n = len(m)
    if not n:
        return np.zeros(0, complex)
    # Degrees of freedom in units that make their stiffness and mass alike, and time in the unit w that makes both of
    # one size: else the QZ method is right to round-off of the largest entry alone, and slow poles have wrong damping.
    stiff, heavy = (np.max(np.abs(of), initial=0.0) or 1.0 for of in (k, m))
    size = np.abs(np.diag(k)) / stiff + np.abs(np.diag(m)) / heavy
    scale = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    k, c, m = (of * scale[:, None] * scale for of in (k, c, m))
    stiff, heavy = (np.linalg.norm(of) or 1.0 for of in (k, m))
    w = np.sqrt(stiff / heavy)
    eye, zero = np.eye(n), np.zeros((n, n))
    left = np.block([[zero, eye], [-k / stiff, -c / (w * heavy)]])
    right = np.block([[eye, zero], [zero, m / heavy]])
    # By the QZ method, as quotients.
    quotients: Any = scipy.linalg.eigvals(left, right, homogeneous_eigvals=True)
    top, bottom = quotients[0], quotients[1].real
    finite = np.abs(bottom) > MASSLESS * n * np.abs(top) / np.max(np.abs(left))
    return in_order(_with_slow(w * top[finite] / bottom[finite], k, c, m))


def in_order(poles: Any) -> Complex[np.ndarray, "n"]:
    """Poles ordered by |Im|."""
    return poles[np.lexsort((poles.imag, np.round(np.abs(poles.imag), 9)))]


def slowest(poles: Any, count: int | None) -> Complex[np.ndarray, "n"]:
    """Poles nearest to zero, in their order: ``count``, or one more where the last is one of a complex pair."""
    if count is None or count >= len(poles):
        return poles
    near = np.argsort(np.abs(poles), kind="stable")
    last, after = poles[near[count - 1]], poles[near[count]]
    pair = last.imag != 0 and abs(after - np.conj(last)) <= REAL * abs(last)
    return poles[np.sort(near[: count + int(pair)])]


def _with_slow(fast: np.ndarray, k: np.ndarray, c: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Poles of which the slower half, by orders of size, is solved anew from the stiffness side.

    The QZ method is right to round-off of the fastest pole; those of K^-1 M and K^-1 C, 1/lambda, to that of the
    slowest.
    """
    scale = 1 / np.sqrt(np.where(np.diag(k) > 0, np.diag(k), 1.0))
    k, c, m = (of * scale[:, None] * scale for of in (k, c, m))
    if not len(fast) or np.linalg.cond(k) > REGULAR:
        return fast
    n, by_mass, by_damping = len(k), np.linalg.solve(k, m), np.linalg.solve(k, c)
    unit = np.sqrt(np.linalg.norm(by_mass)) + np.linalg.norm(by_damping)
    inverse = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-by_mass / unit**2, -by_damping / unit]]))
    inverse = inverse[np.argsort(-np.abs(inverse))][: len(fast)]
    fast = fast[np.argsort(np.abs(fast))]
    sizes = np.abs(inverse)
    # Cut at the gap nearest to the middle.
    apart = 1 + np.flatnonzero(sizes[1:] < (1 - APART) * sizes[:-1])
    if not len(apart) or sizes[0] == 0 or sizes[-1] == 0:
        return fast
    middle = np.sqrt(sizes[0] * 1 / (np.abs(fast[-1]) * unit))
    cut = apart[np.argmin(np.abs(np.log(sizes[apart] / middle)))]
    return np.concatenate([1 / (unit * inverse[:cut]), fast[cut:]])


def masses_of_motions(mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending eigenvalues [-] and vectors of a mass matrix, in units that make each freedom's own mass one."""
    size = np.abs(np.diag(mass))
    scale = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    values, vectors = np.linalg.eigh((mass + mass.T) / 2 * scale[:, None] * scale)
    return values, vectors * scale[:, None]


def massless_freedoms(mass: np.ndarray) -> list[int]:
    """Degrees of freedom to condense, so that the mass matrix of the others is regular."""
    values, motions = masses_of_motions(mass)
    null = motions[:, values <= WITHOUT_MASS * len(values)]
    chosen, _ = independent_rows(null, null.shape[1], 0.0)
    return sorted(chosen)


def response_without_mass(mass: Any, stiffness: Any, condensed: tuple[int, ...], forces: Any, solve: Any = None) -> Any:
    """Displacements under forces of the motions that carry no mass: N (N^T K N)^-1 N^T f with M N = 0, as forces lie.

    Args:
        condensed: Degrees of freedom without which the mass matrix is regular, (k,).
        solve: Function of a matrix and right-hand sides; by default one for traced numbers.
    """
    solve = solve or (lambda matrix, right: factorise(matrix).solve(right))
    out, kept = np.array(condensed, int), np.array([i for i in range(len(mass)) if i not in condensed], int)
    eye = np.eye(len(mass))
    null = eye[:, out] - eye[:, kept] @ solve(mass[np.ix_(kept, kept)], mass[np.ix_(kept, out)])
    return null @ solve(null.T @ stiffness @ null, null.T @ forces)


def without_growth(k: np.ndarray, c: np.ndarray, m: np.ndarray) -> bool:
    """Whether no motion about a state of stiffness K, damping C and mass M, of known numbers, grows.

    By THEORY.md 7, eq. (7.3): no pole has a positive real part, or without damping all omega^2 are real and positive. A
    motion without mass loses its stability where the determinant of the stiffness changes sign, which is not asked.

    Raises:
        AnalysisError: singular_stiffness.
    """
    if np.any(c):
        return not any_grows(poles_of(k, c, m))
    values, _ = general_spectrum(k, m)
    values = values[np.isfinite(values)]
    return bool(np.all(is_real(values) & (values.real > 0)))


def any_grows(poles: Any, share: float = GROWS) -> bool:
    """Whether some pole has a real part above a share of its size that is no round-off beside the largest."""
    sizes = np.abs(poles)
    return bool(np.any((np.real(poles) > share * sizes) & (sizes > NOTHING * np.max(sizes, initial=0.0))))
