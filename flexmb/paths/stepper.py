"""Steps along an equilibrium path: predictor along the tangent, Newton's corrector in the plane across it."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..arguments import library_of
from ..math.linear import diagonal_of, factorise
from ..mechanics.deformation import deformations
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, load_factors, nodal_forces, scaled_loads
from ..mechanics.residual import State, iterate, reduced_response, state
from ..mechanics.stress_resultants import is_nonlinear, stress_of_loads
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..statics.newton import ACROSS_PATH, STEP_TOLERANCE, Number
from ..statics.solve import held_values

# Cosine of the angle by which the tangent may turn in a step: 25 degrees.
SMALLEST_COSINE = 0.9
# A path that gets no further than this share of its load has met no stiffness but that of round-off.
NO_LOAD = 1e-12
# Motion in a step, at most (extents of the mechanism, radians).
LARGEST_MOTION = 0.2
# Steps shorter than this share of the first are not tried.
SMALLEST_STEP = 1e-6
# A step that is refused is divided by this. One that took at most so many corrections, and in which the tangent turned
# by an angle of a larger cosine (11 degrees), is followed by one of twice its length.
SHORTER = 4
FEW_CORRECTIONS = 4
STRAIGHT = 0.98
# Motion that weighs as much as the whole load in the length of the path, at least (extents, radians).
SMALLEST_SCALE = 0.05


class Ramp(NamedTuple):
    """Load factors along a path: ``base`` plus the load factor times ``rate``."""

    base: LoadFactors
    rate: LoadFactors

    def at(self, load: Float[Array, ""]) -> LoadFactors:
        """Factors of the two sets of loads.

        Args:
            load: Load factor of the path, () [-].
        """
        return LoadFactors(
            self.base.initial + load * self.rate.initial, self.base.increment + load * self.rate.increment
        )


class Point(NamedTuple):
    """A state on the path: coordinates, deformations that count turns, those that give the stress, load factor."""

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    load: Float[Array, ""]


class Direction(NamedTuple):
    """Change of a point: coordinates, deformations, load factor."""

    x: Float[Array, "n_x"]
    strained: Float[Array, "n_e"]
    load: Float[Array, ""]


class Plane(NamedTuple):
    """Plane in which a corrector stays.

    Attributes:
        x: Its normal as a covector of x, (n_x,).
        load: Its normal as a covector of the load factor, ().
        stiffness: Added to every critical value in the corrector's equations, not in their residual, () [N m]. Where a
            motion meets no stiffness, these equations are singular without it, and round-off moves the state at will.
    """

    x: Float[Array, "n_x"]
    load: Float[Array, ""]
    stiffness: Any = np.zeros(())


class Scale(NamedTuple):
    """What makes metres, radians and load comparable.

    Attributes:
        sizes: Extent of the mechanism for positions, 1 for rotations, (n_x,) [m, rad].
        weights: Of squared changes of x in the length of a path, (n_x,); the load factor has weight 1.
    """

    sizes: Float[Array, "n_x"]
    weights: Float[Array, "n_x"]


class Stepped(NamedTuple):
    """A step: where it ends, unit tangent and static equations there, and how it was found.

    ``cosine`` is that of the angle between the direction of the step and the tangent at its end.
    """

    point: Point
    tangent: Direction
    at: State
    converged: Bool[Array, ""]
    cosine: Float[Array, ""]
    corrections: Array


def can_be_taken(converged: Any, cosine: Number) -> Any:
    """Whether a step ends on the path that it began on, as far as one can tell from its end."""
    return converged & (cosine > SMALLEST_COSINE)


def next_length(length: Number, corrections: Any, cosine: Number) -> Any:
    """Length to try after a step that was taken, by its length and how easily it was found."""
    quick = (corrections <= FEW_CORRECTIONS) & (cosine > STRAIGHT)
    return length * library_of(cosine).where(quick, 2.0, 1.0)


def scales_increment(topology: Topology, parameters: Parameters) -> bool:
    """Whether there are incremental loads; known before tracing."""
    elements = any(dict(block.options).get("incremental", False) for block in topology.blocks)
    return elements or parameters.increment is not None


def ramp_of(topology: Topology, parameters: Parameters) -> Ramp:
    """Incremental loads are scaled while the others stay; without incremental loads all are."""
    if scales_increment(topology, parameters):
        return Ramp(load_factors(1.0, 0.0), load_factors(0.0, 1.0))
    return Ramp(load_factors(0.0, 0.0), load_factors(1.0, 0.0))


def begins_undeformed(topology: Topology, parameters: Parameters) -> bool:
    """Whether nothing is stressed at load factor zero; known before tracing."""
    stressed = parameters.strain is not None or is_nonlinear(topology)
    return not stressed and not scales_increment(topology, parameters)


def load_response(
    topology: Topology, parameters: Parameters, ramp: Ramp, at: State
) -> tuple[Float[Array, "n_x"], Float[Array, "n_q"]]:
    """Derivatives by the load factor at constant q: of x, and of the residual.

    Returns:
        dx, (n_x,) [m, rad, -], and dr, (n_q,) [N, N m].

    Source:
        Loads are linear in their factors (THEORY.md 5).
    """
    wanted_x, wanted_e = held_values(topology, parameters, ramp.rate)
    shift = wanted_x - parameters.reference
    imbalance = -nodal_forces(topology, parameters, ramp.rate, at.x)
    extra = stress_of_loads(topology, parameters, scaled_loads(parameters, ramp.rate), at.S)
    if extra is not None:
        imbalance = imbalance + at.jacobian.T @ extra
    return reduced_response(topology, at, at.jacobian @ shift - wanted_e, shift, imbalance)


def _bordered_solve(
    at: State,
    onto: Float[Array, "n_x"],
    by_load: Float[Array, "n_q"],
    plane: Plane,
    residual: Float[Array, "n_q"],
    distance: Float[Array, ""],
    added: Any = 0.0,
):
    """Solve [K + added, r_load; plane] (dq, dload) = (-residual, -distance); regular at limit points, unlike K."""
    k = at.K0 + at.G0 + added
    across = plane.x @ at.transfer.DFx
    corner = plane.x @ onto + plane.load
    pivots = jnp.abs(diagonal_of(k))
    # The row is brought to the middle of the stiffnesses, for the choice of pivots.
    weight = jnp.exp(jnp.mean(jnp.log(jnp.where(pivots > 0, pivots, 1.0)))) if k.shape[0] else jnp.array(1.0)
    row = jnp.concatenate([across, corner[None]])
    weight = weight / jnp.max(jnp.abs(row))
    matrix = jnp.concatenate([jnp.concatenate([k, by_load[:, None]], axis=1), weight * row[None]])
    right = jnp.concatenate([-residual, -(weight * distance)[None]])
    solved = factorise(matrix).solve(right)
    return solved[:-1], solved[-1]


def direction_of(at: State, dx: Float[Array, "n_x"], load: Float[Array, ""]) -> Direction:
    """Direction of a change of x and the load factor, deformations to first order.

    Args:
        dx: Change of x, (n_x,) [m, rad, -].
        load: Change of the load factor, () [-].
    """
    return Direction(dx, at.jacobian @ dx, load)


def tangent_at(topology: Topology, parameters: Parameters, ramp: Ramp, at: State, plane: Plane) -> Direction:
    """Tangent of the path, on the side that the plane's normal points to; not of unit length.

    Args:
        at: State on the path.
        plane: Normal of a plane across the path.
    """
    onto, by_load = load_response(topology, parameters, ramp, at)
    dq, load = _bordered_solve(at, onto, by_load, plane, jnp.zeros_like(by_load), jnp.array(-1.0))
    return direction_of(at, onto * load + at.transfer.DFx @ dq, load)


def product(scale: Scale, one: Direction, other: Direction) -> Any:
    """Scalar product of two directions, positions and angles weighed against load, () [-]."""
    return scale.weights @ (one.x * other.x) + one.load * other.load


def length_of(scale: Scale, d: Direction) -> Any:
    """Length of a change of the state, () [-]; it and what it takes are of JAX, or of NumPy for the walk."""
    return library_of(d.load).sqrt(product(scale, d, d))


def normal_to(scale: Scale, d: Direction) -> Plane:
    """Plane across a direction."""
    return Plane(scale.weights * d.x, d.load)


def unit(scale: Scale, d: Direction) -> Direction:
    """Direction of unit length."""
    size = length_of(scale, d)
    return Direction(d.x / size, d.strained / size, d.load / size)


def scale_of(topology: Topology, parameters: Parameters, tangent: Direction) -> Scale:
    """Weights by which the motion under the first load and the load itself count alike.

    Args:
        tangent: Tangent at the begin of the path, of JAX or of NumPy.
    """
    xp = library_of(tangent.load)
    sizes = sizes_of(topology, parameters)
    motion = xp.max(xp.abs(tangent.x) / sizes, initial=0.0) / xp.abs(tangent.load)
    motion = xp.where(xp.isfinite(motion), xp.clip(motion, SMALLEST_SCALE, 1.0), 1.0)
    return Scale(sizes, 1 / (sizes * motion) ** 2 / max(topology.n_x, 1))


class _Correcting(NamedTuple):
    point: Point
    before: Float[Array, ""]
    tries: Array
    done: Bool[Array, ""]
    bad: Bool[Array, ""]
    at: State
    tangent: Direction
    finished: Bool[Array, ""]


def step_along(
    topology: Topology,
    parameters: Parameters,
    ramp: Ramp,
    scale: Scale,
    begin: Point,
    direction: Direction,
    step: Float[Array, ""],
    plane: Plane,
) -> Stepped:
    """One step: predictor along a direction, then Newton's method in the plane through the predicted point.

    Deformations are carried as numbers of their own, as in the equilibrium's search; and as there the last turn of the
    loop evaluates the state that was found: outside the loop its equations would be compiled once more.

    Args:
        begin: Where the step begins.
        direction: Where to.
        step: How much of it, () [-].
        plane: Normal of the plane of the corrector.

    Returns:
        Stepped, the tangent of unit length on the side of the plane's normal.

    Source:
        The tangent bordered with the plane's normal is regular where K has rank n_q - 1 and the load is not in its
        range: at limit points.
    """
    tracks = topology.counts_turns
    predicted = Point(
        begin.x + step * direction.x,
        begin.near,
        begin.strained + step * direction.strained,
        begin.load + step * direction.load,
    )

    def turn(c: _Correcting) -> _Correcting:
        x, near, strained, load = c.point
        factors = ramp.at(load)
        wanted = held_values(topology, parameters, factors)
        at, particular, residual = iterate(topology, parameters, factors, x, near, strained, wanted)
        onto, by_load = load_response(topology, parameters, ramp, at)
        # The last turn asks for the tangent alone.
        last = c.done | c.bad
        distance = plane.x @ (x - predicted.x + particular) + plane.load * (load - predicted.load)
        residual, distance = jnp.where(last, 0.0, residual), jnp.where(last, -1.0, distance)
        z = at.transfer.DFx / scale.sizes[:, None]
        dq, dload = _bordered_solve(at, onto, by_load, plane, residual, distance, plane.stiffness * (z.T @ z))
        along = onto * dload + at.transfer.DFx @ dq
        change = particular + along
        size = jnp.maximum(jnp.max(jnp.abs(change) / scale.sizes, initial=0.0), jnp.abs(dload))
        bad = ACROSS_PATH.astray(size, c.before, c.tries) | ~at.transfer.regular
        trial = x + change
        near = deformations(topology, parameters, trial, at.e) if tracks else at.e
        point = Point(trial, near, at.e + at.jacobian @ change, load + dload)
        done = (size < STEP_TOLERANCE) | (ACROSS_PATH.slow(size, c.before) & (size <= ACROSS_PATH.round_off))
        new = _Correcting(point, size, c.tries + 1, done & ~bad, bad, at, direction_of(at, along, dload), last)
        kept = c._replace(at=at, tangent=new.tangent, finished=last)
        return jax.tree.map(lambda a, b: jnp.where(last, a, b), kept, new)

    no = jnp.array(False)
    point, none = predicted, jnp.zeros((), jnp.int32)
    nothing = jax.eval_shape(lambda x, near: state(topology, parameters, ramp.at(point.load), x, near), *point[:2])
    nothing = jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing)
    start = _Correcting(predicted, jnp.array(jnp.inf), none, no, no, nothing, direction, no)
    end = jax.lax.while_loop(lambda c: ~c.finished, turn, start)
    point, at = end.point, end.at
    tangent = unit(scale, end.tangent)
    finite = jnp.all(jnp.isfinite(tangent.x)) & jnp.isfinite(tangent.load)
    return Stepped(point, tangent, at, end.done & finite, product(scale, direction, tangent), end.tries)
