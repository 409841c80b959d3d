"""Steps along an equilibrium path: predictor along the tangent, Newton's corrector in the plane across it."""

from typing import Any, ClassVar, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import library_of
from ..math.linear import diagonal_of, factorise
from ..mechanics.deformation import deformations
from ..mechanics.loads import LoadFactors, load_factors, nodal_forces, scaled_loads
from ..mechanics.residual import State, reduced_response
from ..mechanics.stress_resultants import is_nonlinear, stress_of_loads
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import REUSED_CORRECTION, SMALLEST_COSINE, SMALLEST_SCALE, STEP_TOLERANCE, STRAIGHT_PATH
from ..results import RESULTS
from ..statics.newton_search import ACROSS_PATH, Iterate, Number, prescribed_values
from ..statics.solve import TurnInFreedoms

# A refused step is divided by this. Steps with at most so few corrections and a straight path are doubled.
SHORTER = 4
FEW_CORRECTIONS = 4


class Point(NamedTuple):
    """A state on the path.

    Attributes:
        near: Deformations from which angles are counted.
        strained: Deformations of the stress.
        load: Load factor [-].
        multipliers: Stress resultants of the held deformations if they are unknowns; otherwise (0,).
    """

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    load: Float[Array, ""]
    multipliers: Float[Array, "h"]


class Direction(NamedTuple):
    """Change of a point: coordinates, deformations, load factor, multipliers."""

    x: Float[Array, "n_x"]
    strained: Float[Array, "n_e"]
    load: Float[Array, ""]
    multipliers: Float[Array, "h"]


class Plane(NamedTuple):
    """Plane of a corrector, by its normal as a covector of x and of the load factor.

    ``stiffness`` is added to each critical value in the corrector's equations, not in their residual [N m]. For a
    motion without stiffness these equations are singular without it, and round-off moves the state.
    """

    x: Float[Array, "n_x"]
    load: Float[Array, ""]
    stiffness: Any = np.zeros(())


class Predictor(NamedTuple):
    """A step to try: from a point along a direction by a length, then corrected in a plane through its end."""

    begin: Point
    direction: Direction
    length: Any
    plane: Plane

    @property
    def end(self) -> Point:
        """The predicted point."""
        change, length = self.direction, self.length
        return Point(
            self.begin.x + length * change.x,
            self.begin.near,
            self.begin.strained + length * change.strained,
            self.begin.load + length * change.load,
            self.begin.multipliers + length * change.multipliers,
        )


class Scale(NamedTuple):
    """Scale that makes metres, radians and load comparable.

    Attributes:
        sizes: Extent of the mechanism for positions, 1 for rotations [m, rad].
        weights: Of squared changes of x in the length of a path; the load factor has weight 1.
    """

    sizes: Float[Array, "n_x"]
    weights: Float[Array, "n_x"]


class Stepped(NamedTuple):
    """A step.

    Attributes:
        point: Its end.
        tangent: Unit tangent of the path there.
        at: Equations there, as kept by the form of matrices.
        converged: Whether the corrector converged.
        cosine: Of the angle between the direction of the step and the tangent at its end.
        corrections: Newton iterations.
        failure: Code of RESULTS if the equations were not regular.
    """

    point: Point
    tangent: Direction
    at: Any
    converged: Bool[Array, ""]
    cosine: Float[Array, ""]
    corrections: Array
    failure: Int[Array, ""]


class Move(NamedTuple):
    """Changes of coordinates, multipliers and load factor that solve the bordered equations, and a code of RESULTS."""

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    load: Float[Array, ""]
    failure: Int[Array, ""]


class PathEquations(Protocol):
    """Equations of equilibrium at a point of a path, linearised.

    Attributes:
        last: Parts that are kept and factored, a pytree of arrays.
        e: Deformations.
        onto: Part of the change of the coordinates that is known.
        following: Change of the coordinates with the load factor at constant unknowns.
        reuses: Whether factors of the last correction may be reused.
    """

    reuses: ClassVar[bool]
    last: Any
    e: Any
    onto: Any
    following: Any

    def __init__(self, topology: Topology, parameters: Parameters, point: Point): ...

    def deformed(self, change: Float[Array, "n_x"]) -> Float[Array, "n_e"]:
        """Change of the deformations with the coordinates, to first order."""
        ...

    def move(self, factored: Any, plane: Plane, sizes: Any, share: Any, distance: Any, idle: Any) -> Move:
        """Solve [K, r_load; plane] (dz, dload) = (-share r, -distance), with ``factored`` in place of ``last``.

        ``sizes`` are those of a :class:`Scale`. ``idle``: no answer is needed.
        """
        ...


def is_acceptable(converged: Any, cosine: Number) -> Any:
    """Whether a step ends on the path that it began on, as far as its end shows."""
    return converged & (cosine > SMALLEST_COSINE)


def next_length(length: Number, corrections: Any, cosine: Number) -> Any:
    """Length of the step after one that was taken."""
    quick = (corrections <= FEW_CORRECTIONS) & (cosine > STRAIGHT_PATH)
    return length * library_of(cosine).where(quick, 2.0, 1.0)


def factors_at(parameters: Parameters, load: Any) -> LoadFactors:
    """Load factors at a load factor of the path, which scales the incremental loads; without any, all loads."""
    return load_factors(load, 0.0) if parameters.increment is None else load_factors(1.0, load)


def begins_undeformed(topology: Topology, parameters: Parameters) -> bool:
    """Whether nothing is stressed at load factor zero; known before tracing."""
    stressed = parameters.strain is not None or is_nonlinear(topology)
    return not stressed and parameters.increment is None


def load_response(topology: Topology, parameters: Parameters, at: State) -> tuple[Array, Array]:
    """Derivatives by the load factor at constant q of x and of the residual; loads are linear in it (THEORY.md 5)."""
    rates = load_factors(1.0, 0.0) if parameters.increment is None else load_factors(0.0, 1.0)
    wanted_x, wanted_e = prescribed_values(topology, parameters, rates)
    shift = wanted_x - parameters.reference
    imbalance = -nodal_forces(topology, parameters, rates, at.x)
    extra = stress_of_loads(topology, parameters, scaled_loads(parameters, rates), at.S)
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
    # Scale the row to the mean stiffness, for the choice of pivots.
    weight = jnp.exp(jnp.mean(jnp.log(jnp.where(pivots > 0, pivots, 1.0)))) if k.shape[0] else jnp.array(1.0)
    row = jnp.concatenate([across, corner[None]])
    weight = weight / jnp.max(jnp.abs(row))
    matrix = jnp.concatenate([jnp.concatenate([k, by_load[:, None]], axis=1), weight * row[None]])
    right = jnp.concatenate([-residual, -(weight * distance)[None]])
    solved = factorise(matrix).solve(right)
    return solved[:-1], solved[-1]


def direction_of(at: State, dx: Float[Array, "n_x"], load: Float[Array, ""]) -> Direction:
    """Direction of a change of x and the load factor, deformations to first order."""
    return Direction(dx, at.jacobian @ dx, load, jnp.zeros(0))


def tangent_at(at: State, onto: Float[Array, "n_x"], by_load: Float[Array, "n_q"], plane: Plane) -> Direction:
    """Tangent of the path from :func:`load_response`, on the side of the plane's normal; not of unit length."""
    dq, load = _bordered_solve(at, onto, by_load, plane, jnp.zeros_like(by_load), jnp.array(-1.0))
    return direction_of(at, onto * load + at.transfer.DFx @ dq, load)


def weighted_product(scale: Scale, one: Direction, other: Direction) -> Any:
    """Scalar product of two directions, with positions and angles weighed against load."""
    return scale.weights @ (one.x * other.x) + one.load * other.load


def length_of(scale: Scale, d: Direction) -> Any:
    """Length of a change of the state, by JAX, or by NumPy for the walk."""
    return library_of(d.load).sqrt(weighted_product(scale, d, d))


def normal_to(scale: Scale, d: Direction) -> Plane:
    """Plane across a direction."""
    return Plane(scale.weights * d.x, d.load)


def unit(scale: Scale, d: Direction) -> Direction:
    """Direction of unit length."""
    size = length_of(scale, d)
    return Direction(*(change / size for change in d))


def first_step(sizes: Any, point: Point) -> tuple[Scale, Predictor]:
    """A scale of equal weights, and a step of length zero along the load. It finds the tangent at a known state."""
    xp = library_of(point)
    zero = xp.zeros_like(point.load)
    still = Direction(0 * point.x, 0 * point.strained, zero, 0 * point.multipliers)
    plane = Plane(0 * point.x, xp.ones_like(point.load))
    return Scale(sizes, xp.ones_like(sizes)), Predictor(point, still, zero, plane)


def scale_of(topology: Topology, parameters: Parameters, tangent: Direction) -> Scale:
    """Weights by which the motion under the first load and the load itself count alike."""
    xp = library_of(tangent.load)
    sizes = coordinate_scales(topology, parameters)
    motion = xp.max(xp.abs(tangent.x) / sizes, initial=0.0) / xp.abs(tangent.load)
    motion = xp.where(xp.isfinite(motion), xp.clip(motion, SMALLEST_SCALE, 1.0), 1.0)
    return Scale(sizes, 1 / (sizes * motion) ** 2 / max(topology.n_x, 1))


class InFreedoms:
    """:class:`PathEquations` in the degrees of freedom."""

    reuses: ClassVar[bool] = False

    def __init__(self, topology: Topology, parameters: Parameters, point: Point):
        factors = factors_at(parameters, point.load)
        trial = Iterate(point.x, point.near, point.strained, point.multipliers)
        prescribed = prescribed_values(topology, parameters, factors)
        self._turn = turn = TurnInFreedoms(topology, parameters, factors, trial, prescribed)
        self.last, self.e, self.onto, self.deformed = turn.last, turn.e, turn.onto, turn.deformed
        self.following, self._by_load = load_response(topology, parameters, turn.last)

    def move(self, factored: State, plane: Plane, sizes: Any, share: Any, distance: Any, idle: Any) -> Move:
        """See :class:`PathEquations`."""
        z = factored.transfer.DFx / sizes[:, None]
        residual = jnp.where(share == 0, 0.0, self._turn.residual)
        added = plane.stiffness * (z.T @ z)
        dq, load = _bordered_solve(factored, self.following, self._by_load, plane, residual, distance, added)
        failure = jnp.where(factored.transfer.regular, RESULTS.successful, RESULTS.singular_configuration)
        return Move(factored.transfer.DFx @ dq, jnp.zeros(0), load, failure)


class _Correcting(NamedTuple):
    point: Point
    before: Float[Array, ""]
    leaves: Float[Array, ""]
    tries: Array
    done: Bool[Array, ""]
    bad: Bool[Array, ""]
    at: Any
    tangent: Direction
    finished: Bool[Array, ""]
    failure: Int[Array, ""]


def step_along(
    form: type[PathEquations], topology: Topology, parameters: Parameters, scale: Scale, predictor: Predictor
) -> Stepped:
    """One step: predictor along a direction, then Newton's method in the plane through the predicted point.

    Deformations are iterated as separate numbers, and the last turn evaluates the state, as in the search for an
    equilibrium. Outside the loop the equations would be compiled again. The tangent has unit length and points to the
    side of the plane's normal. The system bordered with this normal is regular at limit points too: K has rank n_q - 1
    there, and the load is not in its range.
    """
    predicted, direction, plane = predictor.end, predictor.direction, predictor.plane

    def turn(c: _Correcting) -> _Correcting:
        x, _, _, load, multipliers = c.point
        at = form(topology, parameters, c.point)
        # The last turn computes the tangent alone.
        last = c.done | c.bad
        distance = plane.x @ (x - predicted.x + at.onto) + plane.load * (load - predicted.load)
        factored = at.last
        if form.reuses:
            again = ~last & (c.leaves < REUSED_CORRECTION * STEP_TOLERANCE)
            factored = jax.tree.map(lambda a, b: jnp.where(again, a, b), c.at, at.last)
        share, distance = jnp.where(last, 0.0, 1.0), jnp.where(last, -1.0, distance)
        move = at.move(factored, plane, scale.sizes, share, distance, c.bad)
        along = at.following * move.load + move.x
        change = at.onto + along
        size = jnp.maximum(jnp.max(jnp.abs(change) / scale.sizes, initial=0.0), jnp.abs(move.load))
        failure = jnp.where(c.failure == RESULTS.successful, move.failure, c.failure).astype(jnp.int32)
        bad = ACROSS_PATH.astray(size, c.before, c.tries) | (failure != RESULTS.successful)
        trial, strained = x + change, at.e + at.deformed(change)
        last_strain = deformations(topology, parameters, trial, at.e) if topology.counts_turns else strained
        point = Point(trial, last_strain, strained, load + move.load, multipliers + move.multipliers)
        converged = (size < STEP_TOLERANCE) | (ACROSS_PATH.slow(size, c.before) & (size <= ACROSS_PATH.round_off))
        # Newton's method leaves c size^2 of a correction; factors that are one correction old leave c size of it.
        leaves = jnp.where(jnp.isfinite(c.before), (size / c.before**2) ** 2 * size**3, jnp.inf)
        tangent = Direction(along, at.deformed(along), move.load, move.multipliers)
        new = _Correcting(point, size, leaves, c.tries + 1, converged & ~bad, bad, factored, tangent, last, failure)
        unchanged = c._replace(at=factored, tangent=tangent, finished=last, failure=failure)
        return jax.tree.map(lambda a, b: jnp.where(last, a, b), unchanged, new)

    no, none, infinite = jnp.array(False), jnp.zeros((), jnp.int32), jnp.array(jnp.inf)
    nothing = jax.eval_shape(lambda point: form(topology, parameters, point).last, predicted)
    nothing = jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing)
    start = _Correcting(predicted, infinite, infinite, none, no, no, nothing, direction, no, none)
    end = jax.lax.while_loop(lambda c: ~c.finished, turn, start)
    tangent = unit(scale, end.tangent)
    finite = jnp.all(jnp.isfinite(tangent.x)) & jnp.isfinite(tangent.load)
    converged = end.done & finite & (end.failure == RESULTS.successful)
    cosine = weighted_product(scale, direction, tangent)
    return Stepped(end.point, tangent, end.at, converged, cosine, end.tries, end.failure)
