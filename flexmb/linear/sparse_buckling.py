"""Load multipliers and buckling modes of large mechanisms by sparse factors, with derivatives of the multipliers.

:func:`smallest_of_sparse` finds the multipliers from the matrices of elements, by Lanczos iterations.
:func:`sparse_multipliers` finds the multipliers of a model.
"""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, is_concrete, library_of
from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.by_deformations import energies, motions_from_free
from ..math.derivative import jvp_of_varied
from ..math.element_matrices import AssembledEquations, BlockMatrices, ElementMatrices, matrix_times, times_transposed
from ..math.indices import accumulate, put
from ..math.linear import uneven
from ..math.linear_solver import LinearSolver
from ..mechanics.deformation import curvature_pieces, deformations
from ..mechanics.inertia import weight_pieces, work_of_weight
from ..mechanics.loads import LoadFactors, scaled_loads
from ..mechanics.prepared import kernel
from ..model.model import Model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import COUNTED_BEFORE_LAST, NEGLIGIBLE, STRESS_ROUND_OFF, UNBOUNDED_MULTIPLIER
from ..results import RESULTS
from ..statics.newton_search import prescribed_values
from ..statics.solver_choice import refuse_all
from ..statics.sparse import Balanced, Loaded, balanced, lacking_at, refuse_what_is_not_sparse, solution_at
from ..statics.tangent import elastic_stress, element_matrices, unknowns
from .linearize import Linearization
from .sparse_solve import call_on_host
from .sparse_spectrum import Constrained, change_by_iteration, check_converged


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
    parts = elements.structural, elements.constraints, elements.elastic, given.preload or [], given.scaled, given.noise
    if not all(np.all(np.isfinite(matrices)) for pieces in parts for *_, matrices in pieces):
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    _refuse_negative(elements.elastic)
    scaled, noise = (AssembledEquations(elements._replace(curved=g)).curved for g in (given.scaled, given.noise))
    staying = AssembledEquations(elements._replace(curved=given.preload or []))
    if abs(staying.curved).max() > 0:
        _refuse_unstable(staying, solver)
    buckled = _smallest(staying, (scaled, given.scaled), noise, count, solver)
    # By deformations: the round-off of a matrix of many short beams is much larger.
    bounded, motions = np.isfinite(buckled.values), motions_from_free(elements, buckled.motions)
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
        if np.any(values[:, 0] < -NEGLIGIBLE * np.abs(values[:, -1])):
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
        most, _ = at.all_of_few(-staying.curved, at.n)
    else:
        how: Any = {"try_this": "Lower the constant loads", "which": "LA", "tol": 1e-6}
        most, _ = at.searched(-staying.curved, 1, None, uneven(at.n), **how)
    if np.max(most, initial=0.0) >= 1:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message)


def _smallest(
    staying: AssembledEquations, scales: tuple[Any, BlockMatrices], noise: Any, count: int, solver: LinearSolver
) -> Buckled:
    """Multipliers of smallest size: -G v = (1/lambda) K v under the constraints (THEORY.md 7, eq. (7.4))."""
    (scaled, pieces), n = scales, staying.n
    at, n_constraints = _constrained(staying, solver), staying.elements.unknowns[1]
    if abs(scaled).max() == 0:
        return Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((n_constraints, count)), np.zeros(count))

    def last(inverse: np.ndarray):
        bounded = abs(inverse[-1]) > abs(inverse[0]) / UNBOUNDED_MULTIPLIER
        return abs(inverse[-1]) / (1 - COUNTED_BEFORE_LAST) if bounded else None

    def negative(inverse: float):
        curved = [*staying.elements.curved, *((rows, columns, g / inverse) for rows, columns, g in pieces)]
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


class _Growth(NamedTuple):
    """Displacements and stress resultants that the incremental loads add, to first order."""

    x: Float[Array, "n_x"]
    sigma: Float[Array, "n_e"]


@jax.custom_jvp
def _rates(topology: Topology, parameters: Parameters, loaded: Loaded) -> Array:
    """Rates of coordinates that move and of multipliers with the increment's factor, in this state."""
    still = jnp.zeros(sum(indices.shape[0] for indices in unknowns(topology)[::2]))
    right = -_imbalance(topology, parameters, loaded, still)
    rates, code = solution_at(topology, parameters, loaded, right)
    if is_concrete(code) and int(code) != RESULTS.successful:
        raise AnalysisError(RESULTS(int(code)).name, RESULTS(int(code)).message)
    return rates


@kernel
def _imbalance(topology: Topology, parameters: Parameters, loaded: Loaded, rates: Float[Array, "r"]) -> Array:
    """Rate of the residual when the state changes at given rates."""
    factors, last_strain, at = loaded
    free = unknowns(topology)[0]
    n = free.shape[0]
    motion = put(jnp.zeros(topology.n_x), free, rates[:n])

    def lacking(more: Float[Array, ""]):
        more_load = LoadFactors(factors.initial, factors.increment + more)
        moved = at._replace(x=at.x + more * motion, multipliers=at.multipliers + more * rates[n:])
        return lacking_at(topology, parameters, Loaded(more_load, last_strain, moved))

    return jax.jvp(lacking, (jnp.zeros(()),), (jnp.ones(()),))[1]


@_rates.defjvp
def _rates_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, own_parameters, loaded = primals
    rates = _rates(*primals)

    def equations(parameters: Parameters, factors: LoadFactors, at: Balanced):
        return _imbalance(topology, parameters, Loaded(factors, loaded.near, at), rates)

    varied = tangents[1], tangents[2].factors, tangents[2].at
    _, change = jvp_of_varied(equations, (own_parameters, loaded.factors, loaded.at), varied)
    return rates, solution_at(topology, own_parameters, loaded, -change)[0]


def _growth(topology: Topology, parameters: Parameters, loaded: Loaded) -> _Growth | None:
    """What the incremental loads add; None if all loads are scaled."""
    if parameters.increment is None:
        return None
    loaded = loaded._replace(near=jax.lax.stop_gradient(loaded.near))
    return _grown(topology, parameters, loaded, _rates(topology, parameters, loaded))


@kernel
def _grown(topology: Topology, parameters: Parameters, loaded: Loaded, rates: Float[Array, "r"]) -> _Growth:
    """Displacements and stress resultants from rates of the unknowns."""
    (factors, last_strain, at), (free, fast, constrained) = loaded, unknowns(topology)

    def moving(increment: Float[Array, ""]):
        return prescribed_values(topology, parameters, LoadFactors(factors.initial, increment))[0]

    def stress(increment: Float[Array, ""], e: Float[Array, "n_e"]):
        return elastic_stress(topology, parameters, LoadFactors(factors.initial, increment), e)

    increment, unit = jnp.asarray(factors.increment, float), jnp.ones(())
    following = jax.jvp(moving, (increment,), (unit,))[1]
    moved = put(put(jnp.zeros(topology.n_x), free, rates[: free.shape[0]]), fast, following[fast])
    e, stretched = jax.jvp(lambda x: deformations(topology, parameters, x, last_strain), (at.x,), (moved,))
    sigma = jax.jvp(stress, (increment, e), (unit, stretched))[1]
    return _Growth(moved, put(sigma, constrained, rates[free.shape[0] :]))


@kernel
def _matrices(topology: Topology, parameters: Parameters, loaded: Loaded, growth: _Growth | None) -> MultiplierMatrices:
    """Constant and scaled stiffness as in :func:`.buckling.scaled_stiffness`, element by element."""
    factors, last_strain, at = loaded
    elastic, x = elastic_stress(topology, parameters, factors, last_strain), at.x
    sigma = put(elastic, unknowns(topology)[2], at.multipliers)
    elements, _ = element_matrices(topology, parameters, factors, x, last_strain, sigma)
    sizes, stressed, preload, moved = elements.sizes, elements.curved, None, elements.sizes

    def of_stress(factors: LoadFactors, sigma: Float[Array, "n_e"]):
        curvature_matrices = curvature_pieces(topology, parameters, x, last_strain, sigma)
        gravity = scaled_loads(parameters, factors).gravity
        heavy = [] if gravity is None else weight_pieces(topology, parameters, x, gravity)
        return [*curvature_matrices, *((rows, columns, -matrix) for rows, columns, matrix in heavy)]

    if growth is not None:
        moved, sigma, preload = growth.x, growth.sigma, stressed
        stressed = of_stress(LoadFactors(0.0, 1.0), sigma)
    sized = [(r, c, jnp.abs(d) * sizes[c][:, None, :]) for r, c, d in elements.constraints]
    forces = times_transposed(sized, jnp.abs(sigma)[:, None], size=topology.n_x)
    reach = jnp.zeros(topology.n_e)
    for r, _, d in sized:
        reach = accumulate(reach, r, jnp.max(d, axis=2, initial=0.0))
    stretched = matrix_times(sized, (jnp.abs(moved) / sizes)[:, None], size=topology.n_e)
    elastic = matrix_times([(r, c, jnp.abs(k)) for r, c, k in elements.elastic], stretched, size=topology.n_e)[:, 0]
    share = jnp.where(reach > 0, jnp.max(forces, initial=0.0) / jnp.where(reach > 0, reach, 1.0), 0.0)
    noise = of_stress(LoadFactors(0.0, 0.0), STRESS_ROUND_OFF * (elastic + share))
    return MultiplierMatrices(elements._replace(curved=[]), preload, stressed, noise)


@functools.partial(jax.custom_jvp, nondiff_argnums=(5,))
def _smallest_multipliers(
    topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced, count: Array, solver: LinearSolver
) -> tuple[Buckled, Float[Array, ""]]:
    """Smallest multipliers about a state with their modes, and the motion by the scaled loads."""
    loaded, (free, _, constrained) = Loaded(factors, _deformed(topology, parameters, at), at), unknowns(topology)
    growth = _growth(topology, parameters, loaded)
    matrices = _matrices(topology, parameters, loaded, growth)
    n, h, k = free.shape[0], constrained.shape[0], count.shape[0]
    like = [jax.ShapeDtypeStruct(shape, float) for shape in ((k,), (n, k), (h, k), (k,))]
    moved = moved_by_loads(topology, parameters, at.x, None if growth is None else growth.x)
    return call_on_host(functools.partial(smallest_of_sparse, count=k, solver=solver), Buckled(*like), matrices), moved


@_smallest_multipliers.defjvp
def _no_second_derivative(*_: Any):
    raise NotImplementedError("Load multipliers by sparse factors can be differentiated once. Give sparse=False.")


@kernel
def _deformed(topology: Topology, parameters: Parameters, at: Balanced) -> Array:
    return deformations(topology, parameters, at.x, at.near)


@functools.partial(jax.custom_jvp, nondiff_argnums=(5,))
def _load_multipliers(
    topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced, count: Array, solver: LinearSolver
) -> tuple[Buckled, Float[Array, ""]]:
    return _smallest_multipliers(topology, parameters, factors, at, count, solver)


def moved_by_loads(
    topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], grown: Float[Array, "n_x"] | None
) -> Float[Array, ""]:
    """Largest motion of the mechanism by the scaled loads at a multiplier of one [extents, rad].

    ``grown`` is the change of the coordinates by the incremental loads, or None if all loads are scaled.
    """
    if grown is None and (topology.x.prescribed.shape[0] or topology.e.prescribed.shape[0]):
        # A stroke is no load.
        return jnp.zeros(())
    # NumPy for known numbers: it compiles nothing.
    x, reference, grown, sizes = as_known((x, parameters.reference, grown, coordinate_scales(topology, parameters)))
    dx = x - reference if grown is None else grown
    share = as_known(jax.lax.stop_gradient(abs(dx) / sizes))
    return library_of(share).max(share, initial=0.0)


@jit
def _quotients(
    topology: Topology, parameters: Parameters, loaded: Loaded, growth: _Growth | None, modes: Buckled
) -> Array:
    """Second variations of the Lagrangian along modes. Their changes equal the changes of the multipliers."""
    (factors, last_strain, at), (free, _, constrained) = loaded, unknowns(topology)
    loads = scaled_loads(parameters, factors)
    strained = deformations(topology, parameters, at.x, last_strain)
    sigma = put(elastic_stress(topology, parameters, factors, strained), constrained, at.multipliers)
    grown = scaled_loads(parameters, LoadFactors(0.0, 1.0)).gravity

    def along(motion: Float[Array, "n"], multipliers: Float[Array, "h"], value: Float[Array, ""]):
        phi = put(jnp.zeros(topology.n_x), free, motion)

        def rates(x: Float[Array, "n_x"]):
            return jax.jvp(lambda x: deformations(topology, parameters, x, last_strain), (x,), (phi,))

        (e, first), (_, second) = jax.jvp(rates, (at.x,), (phi,))
        stress = jax.jvp(
            lambda e: elastic_stress(topology, parameters, factors, e), (e,), (put(first, constrained, 0.0),)
        )[1]

        def of_stress(sigma: Float[Array, "n_e"], gravity: Float[Array, "axes"] | None):
            if gravity is None:
                return sigma @ second

            def slope(x: Float[Array, "n_x"]):
                return jax.jvp(lambda x: work_of_weight(topology, parameters, x, gravity), (x,), (phi,))[1]

            return sigma @ second - jax.jvp(slope, (at.x,), (phi,))[1]

        elastic = first @ put(stress, constrained, 0.0) + 2 * multipliers @ first[constrained]
        if growth is None:
            return elastic + value * of_stress(sigma, loads.gravity)
        return elastic + of_stress(sigma, loads.gravity) + value * of_stress(growth.sigma, grown)

    values = jnp.where(jnp.isfinite(modes.values), modes.values, 0.0)
    return jax.vmap(along, (1, 1, 0))(modes.motions, modes.multipliers, values)


@_load_multipliers.defjvp
def _load_multipliers_jvp(solver: LinearSolver, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, parameters, factors, at, count = primals
    buckled, moved = _smallest_multipliers(topology, parameters, factors, at, count, solver)
    last_strain = _deformed(topology, parameters, at)
    bounded = jnp.isfinite(buckled.values)

    def quotients(parameters: Parameters, factors: LoadFactors, at: Balanced):
        loaded = Loaded(factors, last_strain, at)
        return _quotients(topology, parameters, loaded, _growth(topology, parameters, loaded), buckled)

    _, change = jvp_of_varied(quotients, primals[1:4], tangents[1:4])
    changes = jnp.where(bounded, -1 / jnp.where(bounded, buckled.geometric, 1.0), 0.0) * change
    # Modes have no derivative.
    unknown = jax.tree.map(lambda number: jnp.full_like(number, jnp.nan), buckled)
    return (buckled, moved), (unknown._replace(values=changes), jnp.zeros(()))


def _about(model: Model, target: LoadFactors, count: int, about: Linearization | None):
    """Topology, parameters, factors and state of load multipliers, and their number as a shape."""
    topology, parameters = model.topology, model.parameters
    refuse_what_is_not_sparse(topology)
    free, _, constrained = unknowns(topology)
    every = len(free) - len(constrained)
    refuse_all(count, every, "load multipliers")
    if about is None:
        at = balanced(topology, parameters, target)
    else:
        at = Balanced(about.x, about.sigma[constrained], about.e, jnp.zeros((), jnp.int32), jnp.zeros((), jnp.int32))
    factors = LoadFactors(*(jnp.asarray(factor, float) for factor in target))
    # The number is a shape, which stays known under a trace.
    return topology, parameters, factors, at, np.zeros(min(count, every))


@one_thread()
def sparse_multipliers(
    model: Model, target: LoadFactors, count: int, about: Linearization | None, solver: LinearSolver
) -> tuple[Float[Array, "k"], Float[Array, "n_x k"], Float[Array, ""]]:
    """Load multipliers of smallest size by a solver, their modes, and the result of :func:`moved_by_loads`.

    About the equilibrium under ``target``, or another state ``about`` with these loads. THEORY.md 7, eq. (7.4), with
    multipliers in place of degrees of freedom; derivative eq. (7.19), of the multipliers alone.
    """
    topology, parameters, factors, at, number = _about(model, target, count, about)
    buckled, moved = _load_multipliers(topology, parameters, factors, at, number, solver)
    # Under a trace, an equilibrium that was not found cannot raise.
    code = jnp.asarray(at.result)
    values = jnp.where((code == RESULTS.successful) | (code == RESULTS.critical_state), buckled.values, jnp.nan)
    motions = as_known(buckled.motions)
    zeros = library_of(motions).zeros((topology.n_x, motions.shape[1]))
    return values, put(zeros, unknowns(topology)[0], motions), moved
