"""Lowest eigenvalues of stiffness and mass of large mechanisms, by sparse factors and Lanczos iterations."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError, ModelError
from ..math.sparse import SparseFactors, negative_where_held
from ..results import RESULTS
from .lanczos import BEFORE, FEW, AllowedMotions, check_modes, more_below, with_all_copies
from .spectrum import FIRST_SHIFT, MASSLESS

# Of more motions than these all are not found by sparse matrices.
MANY = 2000


class Lowest(NamedTuple):
    """Lowest eigenvalues of a constrained mechanism in all its coordinates.

    Attributes:
        values: omega^2, ascending, (count,) [rad^2/s^2].
        motions: Mass-normalised motions, one a column, (n, count).
        multipliers: Those of the constraints in these motions, (h, count).
    """

    values: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray


def _below_all(tangent: Any, mass: Any) -> tuple[float, SparseFactors]:
    """A shift s that no eigenvalue is below -s of, and the factors of [[K + s M, D^T], [D, 0]].

    What is nearest to zero is the lowest only where nothing is below: an unstable mechanism has negative eigenvalues,
    some of them perhaps far from it.

    Raises:
        AnalysisError: singular_stiffness.
    """
    import scipy.sparse

    n, total = mass.shape[0], tangent.shape[0]
    ratio = tangent.diagonal()[:n].max() / mass.diagonal().max()
    none = scipy.sparse.csr_array((total - n, total - n))
    shift = 0.0
    while shift <= ratio:
        padded = tangent if shift == 0.0 else (tangent + scipy.sparse.block_diag([shift * mass, none])).tocsc()
        factored = SparseFactors(padded)
        if factored.regular and not negative_where_held(padded, factored, n):
            return shift, factored
        shift = 10 * shift or FIRST_SHIFT * ratio
    raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def _few_lowest(tangent: Any, mass: Any, shift: float, factored: SparseFactors, count: int):
    """Lowest eigenvalues and their motions, of few motions that constraints leave; factors are those of a shift.

    Raises:
        AnalysisError: singular_stiffness.
        ModelError: Fewer motions have mass.
    """
    n = mass.shape[0]
    try:
        inverse, motions = AllowedMotions(tangent, factored, n).largest(mass, count)
    except np.linalg.LinAlgError:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message) from None
    return _with_mass(inverse, shift, count), motions


def _with_mass(inverse: np.ndarray, shift: float, count: int) -> np.ndarray:
    """Eigenvalues of those of the inverse, all with mass."""
    found = int(np.sum(inverse > MASSLESS * np.max(inverse, initial=0.0)))
    if found < count:
        raise ModelError(
            f"Argument `count` = {count}: only {found} motions of this mechanism have mass. Ask for as many, or give"
            " sparse=False and a model with degrees of freedom."
        )
    return 1 / inverse - shift


def _few_heavy(solved: Callable[[np.ndarray], np.ndarray], mass: Any, shift: float, heavy: np.ndarray, count: int):
    """Lowest eigenvalues and their motions, where few coordinates have mass: M = S S^T, and S^T C S has the same ones.

    Raises:
        ModelError: Fewer motions have mass.
    """
    own, turned = np.linalg.eigh(mass[heavy][:, heavy].toarray())
    roots = np.zeros((mass.shape[0], len(heavy)))
    roots[heavy] = turned * np.sqrt(np.maximum(own, 0.0))
    moved = np.reshape([solved(root) for root in roots.T], (len(heavy), -1)).T[: len(roots)]
    inverse, shares = np.linalg.eigh(roots.T @ moved)
    values = _with_mass(inverse[::-1][:count], shift, count)
    return values, moved @ shares[:, ::-1][:, :count]


def lowest_of_sparse(tangent: Any, mass: Any, count: int) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, by Lanczos iterations with sparse factors.

    Args:
        tangent: Sparse [[K, D^T], [D, 0]], (n + h, n + h).
        mass: Sparse M, (n, n).

    Raises:
        ModelError: There are not so many.
        AnalysisError: singular_stiffness or not_converged.

    Source:
        Shift-inverted Lanczos method of ARPACK.
    """
    import scipy.sparse
    import scipy.sparse.linalg

    linalg: Any = scipy.sparse.linalg
    n, total = mass.shape[0], tangent.shape[0]
    every = 2 * n - total
    if 3 * count >= every > MANY:
        raise ModelError(f"Argument `count` = {count}: sparse matrices give few of the {every} frequencies, not all.")
    heavy = np.flatnonzero(mass.diagonal() > 0)
    if not len(heavy):
        _with_mass(np.zeros(0), 0.0, count)
    shift, factored = _below_all(tangent, mass)

    def solved(right):
        return factored.solve(np.concatenate([np.ravel(right), np.zeros(total - n)]))

    if every <= max(FEW, 3 * count):
        values, motions = _few_lowest(tangent, mass, shift, factored, count)
    elif len(heavy) <= max(FEW, 3 * count):
        values, motions = _few_heavy(solved, mass, shift, heavy, count)
    else:

        def search(_, known, start):
            def moved(right):
                z = solved(right)[:n]
                return z - known @ (known.T @ (mass @ z))

            operator = linalg.LinearOperator((n, n), matvec=moved, dtype=float)
            how: Any = {"M": mass, "sigma": -shift, "OPinv": operator, "which": "LM", "tol": 1e-13}
            return linalg.eigsh(mass, k=count, v0=moved(mass @ start), **how)

        def passed_over(values):
            limit = values[-1] - BEFORE * abs(values[-1])
            lowered = scipy.sparse.block_diag([limit * mass, scipy.sparse.csr_array((total - n, total - n))])
            return more_below((tangent - lowered).tocsc(), n, int(np.sum(values < limit)))

        values, motions = with_all_copies(search, passed_over, lambda values: values, (n, count))
    order = np.argsort(values)
    values, motions = values[order], motions[:, order]
    motions = motions / np.sqrt(np.einsum("ij,ij->j", motions, mass @ motions))
    # Once more, for the multipliers too: K v + D^T m = (w^2 + s) M v.
    full = np.stack([solved((w + shift) * (mass @ v)) for w, v in zip(values, motions.T, strict=True)], axis=1)
    check_modes(full[:n] - motions, motions, mass, "frequencies")
    return Lowest(values, motions, full[n:])
