"""Limit load: the first limit point of a path alone, with the derivative of its load."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_number, check_whole
from ..compilation.compile import unguarded
from ..mechanics.blocks import kernel
from ..mechanics.extent import sizes_of
from ..mechanics.residual import reduced_response, state
from ..model.model import Model, as_determined, as_model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.choice import by_sparse
from ..statics.equilibrium import check_stiffness
from ..statics.solve import change_of_equations
from .critical import begin_path, null_vectors
from .sparse_limit import NumbersTraced, sparse_limit_load
from .stepper import (
    LARGEST_MOTION,
    NO_LOAD,
    SHORTER,
    SMALLEST_STEP,
    Direction,
    Point,
    Ramp,
    Scale,
    can_be_taken,
    load_response,
    next_length,
    normal_to,
    ramp_of,
    step_along,
)

# Of the load's rate along the path, at most one, so much is none: the load is stationary there, and has all its digits
# long before, while its derivative is off by as much as the place is.
STATIONARY = 1e-13
# Turns of a superlinear method between two states on either side.
TURNS = 20


class _Limit(NamedTuple):
    load: Float[Array, ""]
    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    result: Int[Array, ""]


class _Approach(NamedTuple):
    point: Point
    tangent: Direction
    step: Float[Array, ""]
    steps: Int[Array, ""]
    passed: Bool[Array, ""]
    failed: Bool[Array, ""]


def _walk_past_limit(
    topology: Topology,
    parameters: Parameters,
    ramp: Ramp,
    scale: Scale,
    point: Point,
    tangent: Direction,
    first: Float[Array, ""],
    max_steps: Int[Array, ""],
) -> _Approach:
    """Steps until the next one passes a limit point; ``step`` of the result is that one."""

    def turn(w: _Approach) -> _Approach:
        motion = jnp.max(jnp.abs(w.tangent.x) / scale.sizes, initial=0.0)
        most = jnp.maximum(first, 0.1 * jnp.abs(w.point.load))
        step = jnp.minimum(w.step, jnp.minimum(LARGEST_MOTION / motion, most / jnp.abs(w.tangent.load)))
        new = step_along(topology, parameters, ramp, scale, w.point, w.tangent, step, normal_to(scale, w.tangent))
        good = can_be_taken(new.converged, new.cosine)
        passed = good & (new.tangent.load <= 0)
        on = good & ~passed
        longer = next_length(step, new.corrections, new.cosine)
        return _Approach(
            jax.tree.map(lambda a, b: jnp.where(on, a, b), new.point, w.point),
            jax.tree.map(lambda a, b: jnp.where(on, a, b), new.tangent, w.tangent),
            jnp.where(passed, step, jnp.where(good, longer, step / SHORTER)),
            w.steps + 1,
            passed,
            ~good & (step < SMALLEST_STEP * first),
        )

    no = jnp.array(False)
    start = _Approach(point, tangent, first, jnp.zeros((), jnp.int32), no, no)
    return jax.lax.while_loop(lambda w: ~w.passed & ~w.failed & (w.steps < max_steps), turn, start)


def _find_limit(
    topology: Topology, parameters: Parameters, first: Float[Array, ""], max_steps: Int[Array, ""]
) -> _Limit:
    ramp, point, tangent, scale, _, result = begin_path(topology, parameters)
    walk = _walk_past_limit(topology, parameters, ramp, scale, point, tangent, first, max_steps)
    plane = normal_to(scale, walk.tangent)

    def unfinished(bracket: tuple[Any, ...]):
        *_, rate, turn, _ = bracket
        return (turn < TURNS) & (jnp.abs(rate) > STATIONARY)

    def narrower(bracket: tuple[Any, ...]):
        low, low_rate, high, high_rate, last, turn, _ = bracket
        share = jnp.clip(low_rate / (low_rate - high_rate), 0.0, 1.0)
        middle = low + share * (high - low)
        new = step_along(topology, parameters, ramp, scale, walk.point, walk.tangent, middle, plane)
        rate = new.tangent.load
        rising = rate > 0
        # The value of an end that stays once more is halved, so that both ends approach (Illinois).
        again = jnp.where((rate * last > 0) & (turn > 0), 0.5, 1.0)
        return (
            jnp.where(rising, middle, low),
            jnp.where(rising, rate, again * low_rate),
            jnp.where(rising, high, middle),
            jnp.where(rising, again * high_rate, rate),
            rate,
            turn + 1,
            new.point,
        )

    end = step_along(topology, parameters, ramp, scale, walk.point, walk.tangent, walk.step, plane)
    rate = end.tangent.load
    bracket = (jnp.array(0.0), walk.tangent.load, walk.step, rate, rate, jnp.zeros((), jnp.int32), end.point)
    found = jax.lax.while_loop(unfinished, narrower, bracket)[-1]
    why = jnp.where(walk.failed, RESULTS.not_converged, jnp.where(walk.passed, result, RESULTS.max_steps))
    why = jnp.where(jnp.abs(found.load) < NO_LOAD, RESULTS.singular_stiffness, why)
    result = jnp.where(result == RESULTS.successful, why, result)
    return _Limit(found.load, found.x, found.near, result.astype(jnp.int32))


@jax.custom_jvp
def _find_limit_once(
    topology: Topology, parameters: Parameters, first: Float[Array, ""], max_steps: Int[Array, ""]
) -> _Limit:
    return _find_limit(topology, parameters, first, max_steps)


@_find_limit_once.defjvp
def _no_second_derivative(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    raise NotImplementedError("The limit load can be differentiated once; its second derivative is not there.")


@jax.custom_jvp
def _limit_load(topology: Topology, parameters: Parameters, first: Float[Array, ""], max_steps: Int[Array, ""]):
    found = _find_limit(topology, parameters, first, max_steps)
    return found.load, found.result


def _limit_load_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """d(load) = -psi^T dr/dp / (psi^T dr/d(load)) with psi the left null vector of K: no state changes in it."""
    topology, parameters, first, max_steps = primals
    found = _find_limit_once(topology, parameters, first, max_steps)
    ramp = ramp_of(topology, parameters)
    target = ramp.at(found.load)
    at = state(topology, parameters, target, found.x, found.near)

    still = jax.tree.map(jnp.zeros_like, target)
    changes = change_of_equations(topology, at, found.near, (parameters, target), (tangents[1], still))
    _, by_parameter = reduced_response(topology, at, *changes)
    _, by_load = load_response(topology, parameters, ramp, at)
    tiny = 1e-12 * jnp.max(jnp.abs(at.K0), initial=0.0)
    _, psi = null_vectors(topology, at, sizes_of(topology, parameters), tiny)
    change = -(psi @ by_parameter) / (psi @ by_load)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return (found.load, found.result), (change, no_change)


_limit_load.defjvp(_limit_load_jvp, symbolic_zeros=True)
_compiled_limit_load = kernel(_limit_load)


@unguarded
def limit_load(
    model: Model, *, step: float = 0.1, max_steps: int = 200, sparse: bool | None = None, throw: bool = True
) -> Float[Array, ""]:
    """Load factor at the first limit point of the path from the unloaded mechanism.

    The path is followed through bifurcations, also beyond factor 1; ``path`` tells which critical points come before.

    Args:
        model: Mechanism with loads; differentiable once in ``model.parameters``.
        step: First step of the load factor, () [-].
        max_steps: Steps to try.
        sparse: By sparse factors in all coordinates, of a model that needs no degrees of freedom, outside ``jax.jit``.
            Chosen by size unless given.
        throw: Raise where no limit point is found; otherwise the answer is NaN.

    Returns:
        () [-], with derivative -psi^T dr/dp / (psi^T dr/dlambda), finite where that of the displacement is not.

    Raises:
        AnalysisError: max_steps, no limit point within the steps; not_converged or singular_configuration;
            singular_stiffness, where it begins without stiffness.
        TypeError: ``sparse`` is given under ``jax.jit``, ``jax.vmap`` or for second derivatives.

    Source:
        At a limit point psi^T K = 0, so that psi^T of the differentiated equilibrium holds no displacement.
    """
    model = as_model(model, "limit_load")
    large = by_sparse(model, sparse)
    check_number("step", step, above=0)
    most = check_whole("max_steps", max_steps, 1)
    if large:
        try:
            load, result = sparse_limit_load(model, float(step), most)
        except NumbersTraced:
            if sparse:
                raise TypeError(
                    "By sparse factors fm.limit_load takes known numbers, and first derivatives of them, outside"
                    " jax.jit and jax.vmap: leave these or `sparse` out."
                ) from None
        else:
            check_stiffness(model, result, throw)
            return load
    as_determined(model, "limit_load")
    first, turns = jnp.asarray(step, float), jnp.asarray(most, jnp.int32)
    load, result = _compiled_limit_load(model.topology, model.parameters, first, turns)
    check_stiffness(model, result, throw)
    return load * jnp.where(result == RESULTS.successful, 1.0, jnp.nan)
