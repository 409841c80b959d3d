"""Load multipliers and buckling modes of large mechanisms by sparse factors, with derivatives of the multipliers."""

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
from ..math.derivative import jvp_of_varied
from ..math.element_matrices import matrix_times, times_transposed
from ..math.indices import accumulate, put
from ..math.linear_solver import LinearSolver
from ..mechanics.blocks import kernel
from ..mechanics.deformation import curvature_pieces, deformations
from ..mechanics.extent import coordinate_scales
from ..mechanics.inertia import weight_pieces, work_of_weight
from ..mechanics.loads import LoadFactors, scaled_loads
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..numerical_limits import STRESS_ROUND_OFF
from ..results import RESULTS
from ..statics.newton_search import prescribed_values
from ..statics.solver_choice import asks_for_all
from ..statics.sparse import Balanced, balanced, lacking_at, refuse_what_is_not_sparse, solution_at
from ..statics.tangent import elastic_stress, element_matrices, unknowns
from .linearize import Linearization
from .sparse_multipliers import Buckled, MultiplierMatrices, smallest_of_sparse
from .sparse_solve import call_on_host


class _Loaded(NamedTuple):
    """A state under loads.

    Attributes:
        factors: Load factors.
        near: Its deformations, without a derivative.
        at: The state.
    """

    factors: LoadFactors
    near: Float[Array, "n_e"]
    at: Balanced


class _Growth(NamedTuple):
    """Displacements and stress resultants that the incremental loads add, to first order."""

    x: Float[Array, "n_x"]
    sigma: Float[Array, "n_e"]


@jax.custom_jvp
def _rates(topology: Topology, parameters: Parameters, loaded: _Loaded) -> Array:
    """Rates of coordinates that move and of multipliers with the increment's factor, in this state."""
    still = jnp.zeros(sum(indices.shape[0] for indices in unknowns(topology)[::2]))
    right = -_imbalance(topology, parameters, loaded, still)
    rates, code = solution_at(topology, parameters, *loaded, right)
    if is_concrete(code) and int(code) != RESULTS.successful:
        raise AnalysisError(RESULTS(int(code)).name, RESULTS(int(code)).message)
    return rates


@kernel
def _imbalance(topology: Topology, parameters: Parameters, loaded: _Loaded, rates: Float[Array, "r"]) -> Array:
    """Rate of the residual when the state changes at given rates."""
    factors, last_strain, at = loaded
    free = unknowns(topology)[0]
    n = free.shape[0]
    motion = put(jnp.zeros(topology.n_x), free, rates[:n])

    def lacking(more: Float[Array, ""]):
        more_load = LoadFactors(factors.initial, factors.increment + more)
        moved = at._replace(x=at.x + more * motion, multipliers=at.multipliers + more * rates[n:])
        return lacking_at(topology, parameters, more_load, last_strain, moved)

    return jax.jvp(lacking, (jnp.zeros(()),), (jnp.ones(()),))[1]


@_rates.defjvp
def _rates_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, own_parameters, loaded = primals
    rates = _rates(*primals)

    def equations(parameters: Parameters, factors: LoadFactors, at: Balanced):
        return _imbalance(topology, parameters, _Loaded(factors, loaded.near, at), rates)

    varied = tangents[1], tangents[2].factors, tangents[2].at
    _, change = jvp_of_varied(equations, (own_parameters, loaded.factors, loaded.at), varied)
    return rates, solution_at(topology, own_parameters, *loaded, right=-change)[0]


def _growth(topology: Topology, parameters: Parameters, loaded: _Loaded) -> _Growth | None:
    """What the incremental loads add; None if all loads are scaled."""
    if parameters.increment is None:
        return None
    loaded = loaded._replace(near=jax.lax.stop_gradient(loaded.near))
    return _grown(topology, parameters, loaded, _rates(topology, parameters, loaded))


@kernel
def _grown(topology: Topology, parameters: Parameters, loaded: _Loaded, rates: Float[Array, "r"]) -> _Growth:
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
def _matrices(
    topology: Topology, parameters: Parameters, loaded: _Loaded, growth: _Growth | None
) -> MultiplierMatrices:
    """Constant and scaled stiffness as in :func:`.buckling.scaled_stiffness`, element by element."""
    factors, last_strain, at = loaded
    x, sigma = (
        at.x,
        put(elastic_stress(topology, parameters, factors, last_strain), unknowns(topology)[2], at.multipliers),
    )
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
    loaded, (free, _, constrained) = _Loaded(factors, _deformed(topology, parameters, at), at), unknowns(topology)
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
) -> tuple[Float[Array, "k"], Float[Array, ""]]:
    buckled, moved = _smallest_multipliers(topology, parameters, factors, at, count, solver)
    return buckled.values, moved


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
    topology: Topology, parameters: Parameters, loaded: _Loaded, growth: _Growth | None, modes: Buckled
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
        loaded = _Loaded(factors, last_strain, at)
        return _quotients(topology, parameters, loaded, _growth(topology, parameters, loaded), buckled)

    _, change = jvp_of_varied(quotients, primals[1:4], tangents[1:4])
    changes = jnp.where(bounded, -1 / jnp.where(bounded, buckled.geometric, 1.0), 0.0) * change
    return (buckled.values, moved), (changes, jnp.zeros(()))


def _about(model: Model, target: LoadFactors, count: int, about: Linearization | None):
    """Topology, parameters, factors and state of load multipliers, and their number as a shape."""
    topology, parameters = model.topology, model.parameters
    refuse_what_is_not_sparse(topology)
    free, _, constrained = unknowns(topology)
    every = len(free) - len(constrained)
    if asks_for_all(count, every):
        raise ModelError(
            f"Argument `count` = {count}: sparse matrices give few of the {every} load multipliers, not all. Ask for"
            " fewer, or give sparse=False and a model with degrees of freedom."
        )
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
) -> tuple[Float[Array, "k"], Float[Array, ""]]:
    """Load multipliers of smallest size by a solver, and the result of :func:`moved_by_loads`.

    About the equilibrium under ``target``, or another state ``about`` with these loads. THEORY.md 7, eq. (7.4), with
    multipliers in place of degrees of freedom; derivative eq. (7.19).
    """
    arguments = _about(model, target, count, about)
    values, moved = _load_multipliers(*arguments, solver)
    # Under a trace, an equilibrium that was not found cannot raise.
    code = jnp.asarray(arguments[3].result)
    return jnp.where((code == RESULTS.successful) | (code == RESULTS.critical_state), values, jnp.nan), moved


@one_thread()
def sparse_modes(
    model: Model, target: LoadFactors, count: int, about: Linearization, solver: LinearSolver
) -> tuple[Float[Array, "k"], Float[Array, "n_x k"], Float[Array, ""]]:
    """:func:`sparse_multipliers`, with the buckling modes in the coordinates as second result."""
    topology, *arguments = _about(model, target, count, about)
    buckled, moved = _smallest_multipliers(topology, *arguments, solver)
    zeros = jnp.zeros((topology.n_x, buckled.motions.shape[1]))
    return buckled.values, put(zeros, unknowns(topology)[0], buckled.motions), moved
