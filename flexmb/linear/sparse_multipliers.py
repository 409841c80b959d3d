"""Load multipliers of smallest size from the matrices of elements, by sparse factors and Lanczos iterations."""

from typing import Any, NamedTuple

import numpy as np

from ..errors import AnalysisError, ModelError
from ..math.by_deformations import energies
from ..math.element_matrices import AssembledEquations, BlockMatrices, ElementMatrices
from ..math.linear import uneven
from ..math.linear_solver import LinearSolver
from ..math.sparse import SparseFactors
from ..numerical_limits import COUNTED_BEFORE_LAST, NEGATIVE_STIFFNESS, STRESS_ROUND_OFF, UNBOUNDED_MULTIPLIER
from ..results import RESULTS
from .sparse_spectrum import AllowedMotions, Constrained, change_by_iteration, check_converged, explained_failures


class MultiplierMatrices(NamedTuple):
    """Matrices of elements.

    Attributes:
        elements: Of the state, without curvature.
        preload: Stiffness of constant stress resultants and loads, in pieces; None if all are scaled.
        scaled: Stiffness of scaled ones.
        noise: Stiffness of the round-off of scaled stress resultants.
    """

    elements: ElementMatrices
    preload: BlockMatrices | None
    scaled: BlockMatrices
    noise: BlockMatrices


class Buckled(NamedTuple):
    """Load multipliers of a constrained mechanism in all its coordinates.

    Attributes:
        values: By magnitude, infinite if unbounded, (count,) [-].
        motions: Of the coordinates that move, one a column, (n, count).
        multipliers: Of the constraints in these motions, (h, count).
        geometric: v^T G v of each, (count,).
    """

    values: Any
    motions: Any
    multipliers: Any
    geometric: Any


def smallest_of_sparse(given: MultiplierMatrices, *, count: int, solver: LinearSolver) -> Buckled:
    """The ``count`` multipliers of smallest size, and their motions; raise ModelError or AnalysisError."""
    elements = given.elements
    n, h = elements.unknowns
    if n <= h:
        # Nothing can move and buckle.
        return Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((h, count)), np.zeros(count))
    for element_matrices in (
        elements.structural,
        elements.constraints,
        elements.elastic,
        given.preload or [],
        given.scaled,
        given.noise,
    ):
        if not all(np.all(np.isfinite(matrices)) for *_, matrices in element_matrices):
            raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    _refuse_negative(elements.elastic)
    scaled, noise = (
        AssembledEquations(elements._replace(curved=element_matrices)).curved
        for element_matrices in (given.scaled, given.noise)
    )
    staying = AssembledEquations(elements._replace(curved=given.preload or []))
    if abs(staying.curved).max() > 0:
        _refuse_unstable(staying, solver)
    buckled = _smallest(staying, (scaled, given.scaled), noise, count, solver)
    # By deformations: the round-off of a matrix of many short beams is much larger.
    bounded, motions = np.isfinite(buckled.values), np.zeros((len(elements.sizes), count))
    motions[elements.free] = buckled.motions
    # As for dense matrices: no load acts if all scaled stiffness is round-off.
    bounded &= np.any(np.abs(buckled.geometric) > _round_off(elements.sizes, given.scaled, motions))
    elastic = energies(elements, motions)
    elastic += np.einsum("ij,ij->j", buckled.motions, staying.curved @ buckled.motions)
    return buckled._replace(values=np.where(bounded, -elastic / np.where(bounded, buckled.geometric, 1.0), np.inf))


def _round_off(sizes: np.ndarray, scaled: BlockMatrices, motions: np.ndarray) -> np.ndarray:
    """Part of v^T G v of motions, (n_x, count), that may be round-off of each element's largest curvature."""
    most = np.zeros(motions.shape[1])
    for rows, columns, g in scaled:
        largest = np.max(np.abs(g) * sizes[rows][:, :, None] * sizes[columns][:, None, :], axis=(1, 2), initial=0.0)
        by_rows, by_columns = (np.sum(np.abs(motions[at]) / sizes[at][:, :, None], axis=1) for at in (rows, columns))
        most += np.einsum("e,ek,ek->k", largest, by_rows, by_columns)
    return STRESS_ROUND_OFF * most


def _refuse_negative(elastic: BlockMatrices) -> None:
    """Raise for an element of negative stiffness, which the inner product of the method excludes."""
    for *_, matrices in elastic:
        values = np.linalg.eigvalsh(matrices)
        if np.any(values[:, 0] < -NEGATIVE_STIFFNESS * np.abs(values[:, -1])):
            raise ModelError(
                "An element has a negative stiffness. Load multipliers by sparse factors do not allow this. Give"
                " sparse=False and a model with degrees of freedom."
            )


def _constrained(assembled: AssembledEquations, solver: LinearSolver) -> Constrained:
    """The stiffness of element matrices with constraints; raise singular_stiffness."""
    at = Constrained(assembled.at(), assembled.n, solver.factored(assembled.elements))
    if not at.factors.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    return at


def _refuse_unstable(staying: AssembledEquations, solver: LinearSolver) -> None:
    """Raise if the preload is beyond its own buckling load: K0 + G0 is not positive definite."""
    at = _constrained(AssembledEquations(staying.elements._replace(curved=[])), solver)
    if at.few(1):
        most = AllowedMotions(at.tangent, SparseFactors(at.tangent), at.n).largest(-staying.curved, at.n)[0]
    else:
        with explained_failures("Lower the constant loads"):
            most = at.searched(-staying.curved, 1, None, uneven(at.n), which="LA", tol=1e-6)[0]
    if np.max(most, initial=0.0) >= 1:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message)


def _smallest(
    staying: AssembledEquations, scales: tuple[Any, BlockMatrices], noise: Any, count: int, solver: LinearSolver
) -> Buckled:
    """Multipliers of smallest size: -G v = (1/lambda) K v under the constraints (THEORY.md 7, eq. (7.4))."""
    (scaled, element_matrices), n = scales, staying.n
    at, n_constraints = _constrained(staying, solver), staying.elements.unknowns[1]
    if abs(scaled).max() == 0:
        return Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((n_constraints, count)), np.zeros(count))

    def last(inverse: np.ndarray):
        bounded = abs(inverse[-1]) > abs(inverse[0]) / UNBOUNDED_MULTIPLIER
        return abs(inverse[-1]) / (1 - COUNTED_BEFORE_LAST) if bounded else None

    def negative(inverse: float):
        curved = [*staying.elements.curved, *((rows, columns, g / inverse) for rows, columns, g in element_matrices)]
        return solver.factored(staying.elements._replace(curved=curved)).negative()

    try:
        inverse, motions = at.largest(-scaled, count, last, negative, both=True)
    except np.linalg.LinAlgError:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message) from None
    order = np.argsort(-np.abs(inverse))
    inverse, motions = inverse[order], motions[:, order]
    size = np.einsum("ij,ij->j", motions, at.stiffness @ motions)
    false = np.abs(np.einsum("ij,ij->j", motions, noise @ motions)) / size
    bounded = np.abs(inverse) > np.maximum(np.max(np.abs(inverse)) / UNBOUNDED_MULTIPLIER, false)
    values = np.where(bounded, 1 / np.where(bounded, inverse, 1.0), np.inf)
    # One more iteration gives the multipliers: K v + D^T m = -lambda G v.
    full = at.solved(-(scaled @ motions) / np.where(bounded, inverse, 1.0))
    check_converged(
        change_by_iteration((full[:n] - motions)[:, bounded], motions[:, bounded], at.stiffness), "load multipliers"
    )
    return Buckled(values, motions, full[n:], np.einsum("ij,ij->j", motions, scaled @ motions))
