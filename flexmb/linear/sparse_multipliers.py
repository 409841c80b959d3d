"""Load multipliers of smallest size from the matrices of elements, by sparse factors and Lanczos iterations."""

from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError, ModelError
from ..math.by_deformations import energies
from ..math.element_matrices import ElementMatrices, Pieces, Whole
from ..math.linear import uneven
from ..math.linear_solver import LinearSolver
from ..math.sparse import SparseFactors
from ..results import RESULTS
from .lanczos import BEFORE, AllowedMotions, Constrained, changed, check_modes, named

# Multipliers beyond this many times the smallest are called unbounded: the load does not act in that motion.
UNBOUNDED = 1e9
# Stress resultants are wrong by their round-off: that of a deformation beside what the whole mechanism's extent would
# make of it, and that of a constraint force beside the largest of the forces that it balances. An
# element's curvature is wrong by that of its largest entry.
ROUND_OFF = 1e-15
# Stiffness of an element below zero by more than this share is negative.
NEGATIVE = 1e-9


class MultiplierMatrices(NamedTuple):
    """Matrices of elements.

    Attributes:
        elements: Those of the state; what is curved is not looked at.
        preload: Stiffness of stress resultants and loads that stay, in pieces; None where all are scaled.
        scaled: The same of what is scaled.
        noise: The same of the round-off of its stress resultants.
    """

    elements: ElementMatrices
    preload: Pieces | None
    scaled: Pieces
    noise: Pieces


class Buckled(NamedTuple):
    """Load multipliers of a constrained mechanism in all its coordinates.

    Attributes:
        values: By magnitude, infinite where unbounded, (count,) [-].
        motions: Of the coordinates that move, one a column, (n, count).
        multipliers: Those of the constraints in these motions, (h, count).
        geometric: v^T G v of each, (count,).
    """

    values: Any
    motions: Any
    multipliers: Any
    geometric: Any


def smallest_of_sparse(given: MultiplierMatrices, *, count: int, solver: LinearSolver) -> Buckled:
    """The ``count`` multipliers of smallest size, and their motions.

    Raises:
        ModelError: An element has a negative stiffness.
        AnalysisError: singular_stiffness, unstable or not_converged.
    """
    own = given.elements
    n, h = own.unknowns
    if n <= h:
        # Nothing moves that could buckle.
        return Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((h, count)), np.zeros(count))
    for pieces in (own.structural, own.constraints, own.elastic, given.preload or [], given.scaled, given.noise):
        if not all(np.all(np.isfinite(matrices)) for *_, matrices in pieces):
            raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    _refuse_negative(own.elastic)
    scaled, noise = (Whole(own._replace(curved=pieces)).curved for pieces in (given.scaled, given.noise))
    staying = Whole(own._replace(curved=given.preload or []))
    if abs(staying.curved).max() > 0:
        _refuse_unstable(staying, solver)
    found = _smallest(staying, (scaled, given.scaled), noise, count, solver)
    # By deformations: round-off of the matrix of many short beams is in the square of what it is in the values.
    bounded, motions = np.isfinite(found.values), np.zeros((len(own.sizes), count))
    motions[own.free] = found.motions
    # As of dense matrices: where all of what is scaled is but round-off, no load acts.
    bounded &= np.any(np.abs(found.geometric) > _round_off(own.sizes, given.scaled, motions))
    elastic = energies(own, motions)
    elastic += np.einsum("ij,ij->j", found.motions, staying.curved @ found.motions)
    return found._replace(values=np.where(bounded, -elastic / np.where(bounded, found.geometric, 1.0), np.inf))


def _round_off(sizes: np.ndarray, scaled: Pieces, motions: np.ndarray) -> np.ndarray:
    """How much of v^T G v of motions, (n_x, count), may be but round-off of curvatures: of each element's largest."""
    most = np.zeros(motions.shape[1])
    for rows, columns, own in scaled:
        largest = np.max(np.abs(own) * sizes[rows][:, :, None] * sizes[columns][:, None, :], axis=(1, 2), initial=0.0)
        left, right = (np.sum(np.abs(motions[of]) / sizes[of][:, :, None], axis=1) for of in (rows, columns))
        most += np.einsum("e,ek,ek->k", largest, left, right)
    return ROUND_OFF * most


def _refuse_negative(elastic: Pieces) -> None:
    """Raise where an element's stiffness is negative: the method's inner product relies on it."""
    for *_, matrices in elastic:
        values = np.linalg.eigvalsh(matrices)
        if np.any(values[:, 0] < -NEGATIVE * np.abs(values[:, -1])):
            raise ModelError(
                "An element has a negative stiffness, which load multipliers by sparse factors cannot take: give"
                " sparse=False and a model with degrees of freedom."
            )


def _constrained(whole: Whole, solver: LinearSolver) -> Constrained:
    """The stiffness of element matrices with constraints; or singular_stiffness."""
    at = Constrained(whole.at(), whole.n, solver.factored(whole.elements))
    if not at.factors.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    return at


def _refuse_unstable(staying: Whole, solver: LinearSolver) -> None:
    """Raise where the preload is beyond a buckling load of its own: K0 + G0 is not positive definite."""
    at = _constrained(Whole(staying.elements._replace(curved=[])), solver)
    if at.few(1):
        most = AllowedMotions(at.tangent, SparseFactors(at.tangent), at.n).largest(-staying.curved, at.n)[0]
    else:
        with named("Lower the constant loads"):
            most = at.searched(-staying.curved, 1, None, uneven(at.n), which="LA", tol=1e-6)[0]
    if np.max(most, initial=0.0) >= 1:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message)


def _smallest(staying: Whole, scales: tuple[Any, Pieces], noise: Any, count: int, solver: LinearSolver) -> Buckled:
    """Multipliers of smallest size: -G v = (1/lambda) K v where the constraints hold, THEORY.md 7, eq. (7.4)."""
    (scaled, pieces), n = scales, staying.n
    at, rest = _constrained(staying, solver), staying.elements.unknowns[1]
    if abs(scaled).max() == 0:
        return Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((rest, count)), np.zeros(count))

    def last(inverse: np.ndarray):
        bounded = abs(inverse[-1]) > abs(inverse[0]) / UNBOUNDED
        return abs(inverse[-1]) / (1 - BEFORE) if bounded else None

    def negative(inverse: float):
        own = staying.elements
        curved = [*own.curved, *((rows, columns, g / inverse) for rows, columns, g in pieces)]
        return solver.factored(own._replace(curved=curved)).negative()

    try:
        inverse, motions = at.largest(-scaled, count, last, negative, both=True)
    except np.linalg.LinAlgError:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message) from None
    order = np.argsort(-np.abs(inverse))
    inverse, motions = inverse[order], motions[:, order]
    size = np.einsum("ij,ij->j", motions, at.stiffness @ motions)
    false = np.abs(np.einsum("ij,ij->j", motions, noise @ motions)) / size
    bounded = np.abs(inverse) > np.maximum(np.max(np.abs(inverse)) / UNBOUNDED, false)
    values = np.where(bounded, 1 / np.where(bounded, inverse, 1.0), np.inf)
    # Once more, for the multipliers too: K v + D^T m = -lambda G v.
    full = at.solved(-(scaled @ motions) / np.where(bounded, inverse, 1.0))
    check_modes(changed((full[:n] - motions)[:, bounded], motions[:, bounded], at.stiffness), "load multipliers")
    return Buckled(values, motions, full[n:], np.einsum("ij,ij->j", motions, scaled @ motions))
