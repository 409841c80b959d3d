"""Stability along a path, critical points, and the limit load with its derivative."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_number, check_whole
from ..math.indices import put
from ..math.linear import factorise
from ..mechanics.blocks import kernel
from ..mechanics.deformation import zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.loads import lacks_potential
from ..mechanics.residual import State, reduced_response, state
from ..model.model import Model, as_determined
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check
from ..statics.solve import change_of_equations, solve_state
from .stepper import (
    LARGEST_MOTION,
    SHORTER,
    SMALLEST_STEP,
    Direction,
    Plane,
    Point,
    Ramp,
    Scale,
    begins_undeformed,
    can_be_taken,
    direction_of,
    load_response,
    next_length,
    normal_to,
    ramp_of,
    scale_of,
    step_along,
    tangent_at,
    unit,
)


class CriticalPoint(NamedTuple):
    """A state at which the stiffness is singular.

    Attributes:
        load_factor: Load factor there, () [-].
        kind: "limit": the load turns back; "bifurcation": another branch crosses.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        phi: Motion that meets no stiffness, in the coordinates, its largest entry 1 (extents, radians), (n_x,).
        uncertainty: By how much the load factor may be off at most, () [-]: zero where the state itself was found;
            otherwise half of what it changes between the states on either side, the nearest that were found.
    """

    load_factor: float
    kind: str
    x: Float[np.ndarray, "n_x"]
    phi: Float[np.ndarray, "n_x"]
    uncertainty: float = 0.0

    def __repr__(self) -> str:
        within = f" within {self.uncertainty:.2g}" if self.uncertainty else ""
        return f"CriticalPoint: {self.kind} at load factor {self.load_factor:.5g}{within}, x and phi {np.shape(self.x)}"


def critical_values(topology: Topology, at: State, sizes: Float[Array, "n_x"]) -> Float[Array, "n_q"]:
    """Values that change sign, one at a time, where the stiffness is singular, and are continuous along a path.

    Symmetric: all eigenvalues of (K, Z^T Z) with Z = DFx in extents and radians, the lowest solved from the side of the
    flexibility, which knows them to full relative accuracy. Unsymmetric: the smallest modulus with the
    sign of the determinant; the rest is infinite.

    Args:
        sizes: What changes of x are measured against, (n_x,) [m, rad].

    Returns:
        (n_q,) [N m], ascending if symmetric.

    Source:
        Sylvester's law of inertia; det K as the product of its eigenvalues.
    """
    z = at.transfer.DFx / sizes[:, None]
    k = at.K0 + at.G0
    lower = jnp.linalg.cholesky(z.T @ z)
    flexibility = lower.T @ factorise(k).solve(lower)
    if lacks_potential(topology):
        sign, _ = jnp.linalg.slogdet(k)
        largest = jnp.max(jnp.abs(jnp.linalg.eigvals(flexibility)), initial=0.0)
        lowest = jnp.where(jnp.isfinite(largest) & (sign != 0), sign / largest, 0.0)
        return put(jnp.full(topology.n_q, jnp.inf), jnp.arange(min(1, topology.n_q)), lowest)
    half = jax.lax.linalg.triangular_solve(lower, (k + k.T) / 2, left_side=True, lower=True)
    stiffness = jax.lax.linalg.triangular_solve(lower, half.T, left_side=True, lower=True)
    regular = jnp.all(jnp.isfinite(flexibility))
    soft = jnp.linalg.eigvalsh(jnp.where(regular, (flexibility + flexibility.T) / 2, jnp.eye(topology.n_q)))
    stiff = jnp.linalg.eigvalsh((stiffness + stiffness.T) / 2)
    soft, stiff = soft[jnp.argsort(-jnp.abs(soft))], stiff[jnp.argsort(jnp.abs(stiff))]
    # Beside a nearly singular motion the flexibility no longer knows the sign of the stiff ones.
    known = regular & (jnp.abs(soft) > 1e-8 * jnp.max(jnp.abs(soft), initial=0.0))
    return jnp.sort(jnp.where(known, 1 / jnp.where(known, soft, 1.0), stiff))


def null_vectors(
    topology: Topology,
    at: State,
    sizes: Float[Array, "n_x"],
    shift: Float[Array, ""],
    beside: Float[Array, "n_q"] | None = None,
) -> tuple[Float[Array, "n_q"], Float[Array, "n_q"]]:
    """Right and left null vector of a nearly singular stiffness, by inverse iteration.

    Args:
        at: State near a critical point.
        sizes: What changes of x are measured against, (n_x,) [m, rad].
        shift: Small beside the other eigenvalues of (K, Z^T Z), so that an exact zero does no harm, () [N m].
        beside: Another null vector, to which these are normal, or zero, (n_q,) [m, rad].

    Returns:
        phi and psi, (n_q,) [m, rad], the largest entry of DFx phi 1 in extents and radians, positive if first.

    Source:
        Inverse iteration with (K + shift Z^T Z).
    """
    z = at.transfer.DFx / sizes[:, None]
    metric = z.T @ z
    factors = factorise(at.K0 + at.G0 + shift * metric)
    # No symmetric mechanism has a mode orthogonal to these uneven entries.
    start = z.T @ jnp.cos(jnp.arange(1.0, topology.n_x + 1) ** 2)

    def normalised(v: Float[Array, "n_q"]):
        if beside is not None:
            square = beside @ metric @ beside
            v = v - beside * (beside @ metric @ v) / jnp.where(square > 0, square, 1.0)
        motion = z @ v
        largest = jnp.max(jnp.abs(motion), initial=0.0)
        first = jnp.argmax(jnp.abs(motion) > (1 - 1e-6) * largest)
        return v / motion[first]

    def turn(_: Array, pair: tuple[Array, Array]):
        phi, psi = pair
        return normalised(factors.solve(metric @ phi)), normalised(factors.solve_transposed(metric @ psi))

    begin = normalised(factors.solve(start)), normalised(factors.solve_transposed(start))
    return jax.lax.fori_loop(0, 4, turn, begin)


def begin_path(
    topology: Topology, parameters: Parameters
) -> tuple[Ramp, Point, Direction, Scale, State, Int[Array, ""]]:
    """State at load factor zero and the direction in which the path leaves it.

    Returns:
        Ramp, point, unit tangent with rising load, scale, state, code of RESULTS.
    """
    ramp = ramp_of(topology, parameters)
    zero = jnp.array(0.0)
    if not begins_undeformed(topology, parameters):
        at, near, result, _ = solve_state(topology, parameters, ramp.at(zero))
        x, near = jax.lax.stop_gradient((at.x, near))
    else:
        x, near, result = parameters.reference, zero_near(topology), jnp.zeros((), jnp.int32)
    at = state(topology, parameters, ramp.at(zero), x, near)
    point = Point(x, near, at.e, zero)
    regular = at.transfer.regular
    result = jnp.where((result == RESULTS.successful) & ~regular, RESULTS.singular_configuration, result)
    rising = Plane(jnp.zeros(topology.n_x), jnp.array(1.0))
    tangent = tangent_at(topology, parameters, ramp, at, rising)
    # Without stress a hanging body has no stiffness: what meets none is taken not to move at first.
    onto, by_load = load_response(topology, parameters, ramp, at)
    dq = -jnp.linalg.pinv(at.K0 + at.G0, rtol=1e-13) @ by_load
    resting = direction_of(at, onto + at.transfer.DFx @ dq, jnp.array(1.0))
    finite = jnp.all(jnp.isfinite(tangent.x))
    tangent = jax.tree.map(lambda a, b: jnp.where(finite, a, b), tangent, resting)
    scale = scale_of(topology, parameters, tangent)
    return ramp, point, unit(scale, tangent), scale, at, result.astype(jnp.int32)


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

    def bisect(_: Array, bracket: tuple[Any, ...]):
        low, low_rate, high, high_rate, _ = bracket
        share = jnp.clip(low_rate / (low_rate - high_rate), 0.0, 1.0)
        middle = low + share * (high - low)
        new = step_along(topology, parameters, ramp, scale, walk.point, walk.tangent, middle, plane)
        rate = new.tangent.load
        rising = rate > 0
        # The value of an end that stays is halved, so that both ends approach (Illinois).
        return (
            jnp.where(rising, middle, low),
            jnp.where(rising, rate, low_rate / 2),
            jnp.where(rising, high, middle),
            jnp.where(rising, high_rate / 2, rate),
            new.point,
        )

    end = step_along(topology, parameters, ramp, scale, walk.point, walk.tangent, walk.step, plane)
    bracket = (jnp.array(0.0), walk.tangent.load, walk.step, end.tangent.load, walk.point)
    # Twenty turns of a superlinear method; the load is stationary, so that half the digits of the place suffice.
    found = jax.lax.fori_loop(0, 20, bisect, bracket)[-1]
    why = jnp.where(walk.failed, RESULTS.not_converged, jnp.where(walk.passed, result, RESULTS.max_steps))
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


def limit_load(model: Model, *, step: float = 0.1, max_steps: int = 200, throw: bool = True) -> Float[Array, ""]:
    """Load factor at the first limit point of the path from the unloaded mechanism.

    The path is followed through bifurcations, also beyond factor 1; ``path`` tells which critical points come before.

    Args:
        model: Mechanism with loads; differentiable once in ``model.parameters``.
        step: First step of the load factor, () [-].
        max_steps: Steps to try.
        throw: Raise where no limit point is found; otherwise the answer is NaN.

    Returns:
        () [-], with derivative -psi^T dr/dp / (psi^T dr/dlambda), finite where that of the displacement is not.

    Raises:
        AnalysisError: max_steps, no limit point within the steps; not_converged or singular_configuration.

    Source:
        At a limit point psi^T K = 0, so that psi^T of the differentiated equilibrium holds no displacement.
    """
    as_determined(model, "limit_load")
    check_number("step", step, above=0)
    first, most = jnp.asarray(step, float), jnp.asarray(check_whole("max_steps", max_steps, 1), jnp.int32)
    load, result = _compiled_limit_load(model.topology, model.parameters, first, most)
    check(result, throw)
    return jnp.where(result == RESULTS.successful, load, jnp.nan)
