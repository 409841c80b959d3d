"""Limit load: the first limit point of a path, with the derivative of its load."""

import functools
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_number, check_whole
from ..compilation.compile import unguarded
from ..math.derivative import jvp_of_varied
from ..mechanics.prepared import kernel
from ..mechanics.residual import reduced_response, state
from ..model.model import Model, as_determined, as_model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import (
    LARGEST_MOTION,
    ROUND_OFF,
    SETTLED_LIMIT,
    SHORTEST_PATH_STEP,
    STATIONARY_LOAD,
    TURNED_LOAD,
)
from ..results import RESULTS
from ..statics.equilibrium import check_stiffness
from ..statics.solve import change_of_equations
from ..statics.solver_choice import by_sparse, known_solver
from ..statics.sparse import Balanced, Loaded, lacking_at, search_in_coordinates
from .critical import begin_path, null_vectors
from .sparse_walk import InCoordinates, left_null_vector
from .stepper import (
    SHORTER,
    Direction,
    InFreedoms,
    Plane,
    Point,
    Predictor,
    Scale,
    Stepped,
    factors_at,
    first_step,
    is_acceptable,
    load_response,
    next_length,
    normal_to,
    scale_of,
    step_along,
    unit,
)

# Largest number of iterations between two states on either side.
TURNS = 20


class _Limit(NamedTuple):
    load: Float[Array, ""]
    point: Point
    plane: Plane
    result: Int[Array, ""]


class _Approach(NamedTuple):
    point: Point
    tangent: Direction
    step: Float[Array, ""]
    steps: Int[Array, ""]
    passed: Bool[Array, ""]
    failed: Bool[Array, ""]


def _step_past_limit(
    advance: Callable[..., Stepped], scale: Scale, point: Point, tangent: Direction, first: Any, max_steps: Any
) -> _Approach:
    """Steps until the next one, ``step`` of the result, passes a limit point."""

    def turn(w: _Approach) -> _Approach:
        motion = jnp.max(jnp.abs(w.tangent.x) / scale.sizes, initial=0.0)
        most = jnp.maximum(first, 0.1 * jnp.abs(w.point.load))
        step = jnp.minimum(w.step, jnp.minimum(LARGEST_MOTION / motion, most / jnp.abs(w.tangent.load)))
        new = advance(w.point, w.tangent, step, normal_to(scale, w.tangent))
        good = is_acceptable(new.converged, new.cosine)
        passed = good & (new.tangent.load <= 0)
        on = good & ~passed
        longer = next_length(step, new.corrections, new.cosine)
        return _Approach(
            jax.tree.map(lambda a, b: jnp.where(on, a, b), new.point, w.point),
            jax.tree.map(lambda a, b: jnp.where(on, a, b), new.tangent, w.tangent),
            jnp.where(passed, step, jnp.where(good, longer, step / SHORTER)),
            w.steps + 1,
            passed,
            ~good & (step < SHORTEST_PATH_STEP * first),
        )

    no = jnp.array(False)
    start = _Approach(point, tangent, first, jnp.zeros((), jnp.int32), no, no)
    return jax.lax.while_loop(lambda w: ~w.passed & ~w.failed & (w.steps < max_steps), turn, start)


def _begin(topology: Topology, parameters: Parameters, in_coordinates: bool):
    """Point, unit tangent, scale and code of RESULTS at the begin of a path."""
    if not in_coordinates:
        point, tangent, scale, _, result = begin_path(topology, parameters)
        return point, tangent, scale, result
    at = search_in_coordinates(topology, parameters, factors_at(parameters, 0.0))
    point = Point(at.x, at.near, at.near, jnp.array(0.0), at.multipliers)
    new = step_along(InCoordinates, topology, parameters, *first_step(coordinate_scales(topology, parameters), point))
    scale = scale_of(topology, parameters, new.tangent)
    # A hanging body has no stiffness without stress.
    why = jnp.where(new.failure == RESULTS.out_of_memory, new.failure, RESULTS.singular_stiffness)
    converged = (at.result == RESULTS.successful) | (at.result == RESULTS.critical_state)
    result = jnp.where(converged, jnp.where(new.converged, RESULTS.successful, why), at.result)
    return point, unit(scale, new.tangent), scale, result


def _find_limit(
    topology: Topology, parameters: Parameters, first: Float[Array, ""], max_steps: Int[Array, ""], in_coordinates: bool
) -> _Limit:
    form = InCoordinates if in_coordinates else InFreedoms
    point, tangent, scale, result = _begin(topology, parameters, in_coordinates)

    def advance(*arguments: Any):
        return step_along(form, topology, parameters, scale, Predictor(*arguments))

    most = jnp.where(result == RESULTS.successful, max_steps, 0)
    before = _step_past_limit(advance, scale, point, tangent, first, most)
    plane = normal_to(scale, before.tangent)

    def unfinished(bracket: tuple[Any, ...]):
        *_, rate, _, moved, turn, _ = bracket
        settled = (jnp.abs(rate) <= STATIONARY_LOAD) | (moved <= SETTLED_LIMIT * before.step)
        return before.passed & (turn < TURNS) & ~settled

    def narrower(bracket: tuple[Any, ...]):
        low, low_rate, high, high_rate, last, place, _, turn, _ = bracket
        share = jnp.clip(low_rate / (low_rate - high_rate), 0.0, 1.0)
        middle = low + share * (high - low)
        new = advance(before.point, before.tangent, middle, plane)
        rate = new.tangent.load
        rising = rate > 0
        # Illinois method: halve the value of an end that stays twice, so that both ends approach.
        again = jnp.where((rate * last > 0) & (turn > 0), 0.5, 1.0)
        return (
            jnp.where(rising, middle, low),
            jnp.where(rising, rate, again * low_rate),
            jnp.where(rising, high, middle),
            jnp.where(rising, again * high_rate, rate),
            rate,
            middle,
            jnp.abs(middle - place),
            turn + 1,
            new.point,
        )

    end = advance(before.point, before.tangent, before.step, plane)
    rate, zero, none = end.tangent.load, jnp.array(0.0), jnp.zeros((), jnp.int32)
    bracket = (zero, before.tangent.load, before.step, rate, rate, before.step, jnp.array(jnp.inf), none, end.point)
    *_, rate, _, _, _, limit_point = jax.lax.while_loop(unfinished, narrower, bracket)
    # Without a state between, the path jumps.
    passed = jnp.where(jnp.abs(rate) < TURNED_LOAD, RESULTS.successful, RESULTS.not_converged)
    why = jnp.where(before.failed, RESULTS.not_converged, jnp.where(before.passed, passed, RESULTS.max_steps))
    why = jnp.where(jnp.abs(limit_point.load) < ROUND_OFF, RESULTS.singular_stiffness, why)
    result = jnp.where(result == RESULTS.successful, why, result)
    return _Limit(limit_point.load, limit_point, plane, result.astype(jnp.int32))


_find_limit_once = jax.custom_jvp(_find_limit, nondiff_argnums=(4,))


@_find_limit_once.defjvp
def _no_second_derivative(in_coordinates: bool, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    raise NotImplementedError("The limit load has a first derivative, and no second one.")


@functools.partial(jax.custom_jvp, nondiff_argnums=(1,))
def _limit_load(given: tuple[Any, Any, Any, Any], in_coordinates: bool):
    limit = _find_limit(*given, in_coordinates)
    return limit.load, limit.result


def _limit_load_jvp(in_coordinates: bool, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """d(load) = -psi^T dr/dp / (psi^T dr/d(load)) with the left null vector psi of K, without a change of state."""
    ((topology, parameters, first, most),), ((_, changes, *_),) = primals, tangents
    limit = _find_limit_once(topology, parameters, first, most, in_coordinates)
    changed = _change_in_coordinates if in_coordinates else _change_in_freedoms
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return (limit.load, limit.result), (changed(topology, parameters, limit, changes), no_change)


def _change_in_freedoms(topology: Topology, parameters: Parameters, limit: _Limit, tangents: Any):
    x, last_strain, *_ = limit.point
    target = factors_at(parameters, limit.load)
    at = state(topology, parameters, target, x, last_strain)
    still = jax.tree.map(jnp.zeros_like, target)
    changes = change_of_equations(topology, at, last_strain, (parameters, target), (tangents, still))
    _, by_parameter = reduced_response(topology, at, *changes)
    _, by_load = load_response(topology, parameters, at)
    tiny = 1e-12 * jnp.max(jnp.abs(at.K0), initial=0.0)
    _, psi = null_vectors(topology, at, coordinate_scales(topology, parameters), tiny)
    return -(psi @ by_parameter) / (psi @ by_load)


def _change_in_coordinates(topology: Topology, parameters: Parameters, limit: _Limit, tangents: Any):
    """:func:`_change_in_freedoms` in coordinates; the left vector has psi^T dr/d(load) = 1."""
    point, factors = limit.point, factors_at(parameters, limit.load)
    at = Balanced(point.x, point.multipliers, point.near)

    def lacking(parameters: Parameters):
        return lacking_at(topology, parameters, Loaded(factors, point.near, at))

    _, change = jvp_of_varied(lacking, (parameters,), (tangents,))
    return -left_null_vector(topology, parameters, point, limit.plane) @ change


_limit_load.defjvp(_limit_load_jvp, symbolic_zeros=True)


@kernel
def _compiled_limit_load(topology: Topology, parameters: Parameters, first: Any, most: Any, *, in_coordinates: bool):
    return _limit_load((topology, parameters, first, most), in_coordinates)


@unguarded
def limit_load(
    model: Model,
    *,
    step: float = 0.1,
    max_steps: int = 200,
    sparse: bool | None = None,
    solver: Literal["dense", "sparse"] | None = None,
    throw: bool = True,
) -> Float[Array, ""]:
    """Return the load factor at the first limit point of the path from the unloaded mechanism.

    The path continues through bifurcations without a change of branch, also beyond factor 1. ``path`` shows the
    critical points before the limit point.

    Args:
        model: Mechanism with loads; differentiable once in ``model.parameters``.
        step: First step of the load factor, () [-].
        max_steps: Largest number of steps.
        sparse: True is ``solver="sparse"``, False ``solver="dense"``.
        solver: "sparse" for sparse matrices in all coordinates; the model needs no degrees of freedom. "dense" for
            dense matrices. None: the size of the model decides.
        throw: Raise if no limit point is found; otherwise the result is NaN.

    Returns:
        () [-], with derivative -psi^T dr/dp / (psi^T dr/dlambda). This derivative is finite, although the derivative of
        the displacement is infinite there.

    Raises:
        AnalysisError: max_steps: no limit point within the steps; not_converged or singular_configuration;
            singular_stiffness: no stiffness at the start.
        NotImplementedError: A second derivative is computed.
        ValueError: ``sparse`` contradicts ``solver``.

    Source:
        Differentiate the equilibrium by a parameter and multiply the result by psi^T. At a limit point psi^T K = 0, so
        that the product does not contain the derivative of the displacement.
    """
    model = as_model(model, "limit_load")
    large = by_sparse(model, sparse, known_solver(solver))
    check_number("step", step, above=0)
    first, turns = jnp.asarray(step, float), jnp.asarray(check_whole("max_steps", max_steps, 1), jnp.int32)
    model = model if large else as_determined(model, "limit_load")
    load, result = _compiled_limit_load(model.topology, model.parameters, first, turns, in_coordinates=large)
    check_stiffness(model, result, throw)
    return load * jnp.where(result == RESULTS.successful, 1.0, jnp.nan)
