"""Continuation along an equilibrium path: its steps, and the critical points within steps."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Bool, Float, Int

from ..math.linear import factorise
from ..mechanics.prepared import kernel
from ..mechanics.residual import state
from ..model.model import Model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import (
    FIRST_ON_BRANCH,
    HOLD_ON_BRANCH,
    LARGEST_MOTION,
    NEAR_STATES,
    NEUTRAL_ON_BRANCH,
    NEUTRAL_VALUE,
    NO_STIFFNESS,
    NULL_VECTOR_SHIFT,
    ROUND_OFF,
    SAME_STATE,
    SHORTEST_PATH_STEP,
    SMALLEST_COSINE,
    VANISHED_VALUE,
    WIDEST_GAP,
    WIDEST_GAP_AT_LEAST,
)
from ..results import RESULTS
from .critical import CriticalPoint, begin_path, critical_values, null_vectors
from .stepper import (
    SHORTER,
    Direction,
    InFreedoms,
    Plane,
    Point,
    Predictor,
    Scale,
    begins_undeformed,
    direction_of,
    factors_at,
    first_step,
    is_acceptable,
    length_of,
    load_response,
    next_length,
    normal_to,
    scale_of,
    step_along,
    unit,
    weighted_product,
)
from .stops import COUNT, Condition, Last, Stops

BISECTIONS = 60
# Beside a bifurcation, where no states are found, both sides approach a zero by these shares of the way to its
# estimate.
DRAWN = (7 / 8, 1 / 2)


class Step(NamedTuple):
    """The end of a step, and what decides whether it is taken.

    Attributes:
        point: State.
        tangent: Unit tangent of the path there.
        values: Values that change sign where the stiffness is singular [N m].
        converged: Whether the corrector converged.
        regular: Whether the degrees of freedom determine the configuration.
        cosine: Of the angle between the direction of the step and the tangent at its end.
        corrections: Newton iterations.
        below: Number of further such values, all negative and farther from zero.
    """

    point: Point
    tangent: Direction
    values: Float[Array, "n_q"]
    converged: Bool[Array, ""]
    regular: Bool[Array, ""]
    cosine: Float[Array, ""]
    corrections: Int[Array, ""]
    below: Int[Array, ""]

    @property
    def negative(self) -> int:
        """Number of negative critical values, except values that are zero to round-off along the whole path."""
        sizes = np.sort(np.abs(self.values))
        next_one = sizes[1] if len(sizes) > 1 and np.isfinite(sizes[1]) else 0.0
        return int(self.below) + int(np.sum(self.values < -NEUTRAL_VALUE * next_one))

    @property
    def singular(self) -> bool:
        """Whether some motion meets no stiffness, but for round-off."""
        sizes = np.abs(self.values[np.isfinite(self.values)])
        return bool(np.any(sizes <= NO_STIFFNESS * np.max(sizes, initial=0.0)))

    def critical_value(self, number: int) -> float:
        """One critical value by its number from the lowest [N m]; the farthest known for one that is not computed."""
        place = number - int(self.below)
        if 0 <= place < len(self.values):
            return float(self.values[place])
        return float(np.copysign(np.max(np.abs(self.values), initial=0.0), place))

    @property
    def orientation(self) -> float:
        """Sign of the determinant of [K, r_load; tangent], constant along a path up to a bifurcation."""
        return (-1) ** self.negative * float(np.sign(self.tangent.load))

    @property
    def load(self) -> float:
        """Load factor."""
        return float(self.point.load)


@kernel
def _begin(topology: Topology, parameters: Parameters):
    point, tangent, scale, at, result = begin_path(topology, parameters)
    values = critical_values(topology, at, scale.sizes)
    converged = result == RESULTS.successful
    none = jnp.zeros((), jnp.int32)
    step = Step(point, tangent, values, converged, converged, jnp.array(1.0), none, none)
    return scale, step, result


@kernel
def _advance(topology: Topology, parameters: Parameters, scale: Scale, predictor: Predictor):
    new = step_along(InFreedoms, topology, parameters, scale, predictor)
    values = critical_values(topology, new.at, scale.sizes)
    regular = new.failure == RESULTS.successful
    none = jnp.zeros((), jnp.int32)
    return Step(new.point, new.tangent, values, new.converged, regular, new.cosine, new.corrections, none)


@kernel
def _null(
    topology: Topology,
    parameters: Parameters,
    scale: Scale,
    point: Point,
    shift: Float[Array, ""],
    beside: Direction,
):
    factors = factors_at(parameters, point.load)
    at = state(topology, parameters, factors, point.x, point.near, strained=point.strained)
    other = jnp.concatenate([beside.x[topology.x.dof], beside.strained[topology.e.dof]])
    phi, psi = null_vectors(topology, at, scale.sizes, shift, other)
    # In another direction, normal to phi, the load changes and r does not: K with phi made stiff gives it.
    z = at.transfer.DFx / scale.sizes[:, None]
    metric = z.T @ z
    stiffened = at.K0 + at.G0 + shift / NULL_VECTOR_SHIFT * jnp.outer(metric @ psi, metric @ phi) / (psi @ metric @ phi)
    onto, by_load = load_response(topology, parameters, at)
    dq = -factorise(stiffened).solve(by_load)
    along = onto + at.transfer.DFx @ (dq - phi * (phi @ metric @ dq) / (phi @ metric @ phi))
    return direction_of(at, at.transfer.DFx @ phi, jnp.array(0.0)), direction_of(at, along, jnp.array(1.0))


class WalkEquations(Protocol):
    """Equations of a mechanism for a walk; states are NumPy arrays."""

    def begin(self) -> tuple[Scale, Step, Any]:
        """Scale, first state, code of RESULTS."""
        ...

    def advance(self, scale: Scale, predictor: Predictor) -> Step:
        """One step from a point along a direction, corrected in a plane."""
        ...

    def null(self, scale: Scale, point: Point, shift: Any, beside: Direction) -> tuple[Direction, Direction]:
        """Motion without stiffness, normal to ``beside``; direction normal to it that follows a rising load."""
        ...


def unloaded_point(topology: Topology, parameters: Parameters, multipliers: int = 0) -> Point:
    """The undeformed mechanism at load factor zero, as arrays of NumPy."""
    none, reference = np.zeros(topology.n_e), np.asarray(parameters.reference)
    state: Any = reference, none, none, np.zeros(()), np.zeros(multipliers)
    return Point(*state)


def begin_at(equations: Any, point: Point) -> tuple[Scale, Step, Any] | None:
    """Result of :meth:`WalkEquations.begin` at a known state, by a step of no length; None if that fails."""
    topology, parameters = equations.parts
    step = equations.advance(*first_step(np.asarray(coordinate_scales(topology, parameters)), point))
    if not step.converged or not step.regular:
        return None
    scale, one = scale_of(topology, parameters, step.tangent), np.ones(())
    step = step._replace(point=point, tangent=unit(scale, step.tangent), cosine=one)
    return scale, step._replace(corrections=np.zeros((), np.int32)), RESULTS.successful


class DenseEquations:
    """Equations in the degrees of freedom, by dense matrices in compiled code."""

    def __init__(self, model: Model):
        self.parts = (model.topology, model.parameters)

    def begin(self) -> tuple[Scale, Step, Any]:
        """See :class:`WalkEquations`."""
        topology, parameters = self.parts
        if begins_undeformed(topology, parameters):
            # By the compiled code of a step.
            begun = begin_at(self, unloaded_point(topology, parameters))
            if begun is not None:
                return begun
        return jax.device_get(_begin(*self.parts))

    def advance(self, scale: Scale, predictor: Predictor) -> Step:
        """See :class:`WalkEquations`."""
        return jax.device_get(_advance(*self.parts, scale, predictor))

    def null(self, scale: Scale, point: Point, shift: Any, beside: Direction) -> tuple[Direction, Direction]:
        """See :class:`WalkEquations`."""
        return jax.device_get(_null(*self.parts, scale, point, shift, beside))


class Zero(NamedTuple):
    """Zero of a value along a step: place, state, and largest error of its load factor, zero if the state was found."""

    length: float
    step: Step
    uncertainty: float


class Crossing(NamedTuple):
    """A critical point on a step: its zero, "limit" or "bifurcation", and the number of the critical value."""

    zero: Zero
    kind: str
    number: int


class AcceptedStep(NamedTuple):
    """A step that can be taken.

    Attributes:
        begin: State at its begin, whose tangent is the direction of the step.
        length: Its length.
        end: State at its end.
        crossed: Critical points on it.
        last: Where the walk ends on it, or None.
    """

    begin: Step
    length: float
    end: Step
    crossed: list[Crossing]
    last: Last | None


class _Trial(NamedTuple):
    """A state on a step, and the value there whose zero is sought."""

    length: float
    value: float
    step: Step


def _estimate(low: _Trial, high: _Trial) -> float:
    """Share of the way from one state to another at which a linear value is zero."""
    return low.value / (low.value - high.value)


def _replaced(low: _Trial, high: _Trial, new: _Trial) -> tuple[_Trial, _Trial]:
    """The ends between which the sign changes, with a new state in place of one."""
    return (new, high) if (new.value > 0) == (low.value > 0) else (low, new)


def _guess(low: _Trial, high: _Trial, known: list[_Trial]) -> float:
    """Share of the way to the zero of a smooth function through the last states, by inverse interpolation (Neville)."""
    values, places = [t.value for t in known[-4:]], [t.length for t in known[-4:]]
    if len(set(values)) == len(values):
        for k in range(1, len(values)):
            for i in range(len(values) - k):
                gap = values[i] - values[i + k]
                places[i] = (values[i] * places[i + 1] - values[i + k] * places[i]) / gap
        share = (places[0] - low.length) / (high.length - low.length)
        if 0 < share < 1:
            return share
    return _estimate(low, high)


def _beyond(low: _Trial, high: _Trial, share: float) -> float:
    """A share a little beyond a given share, seen from the nearer end, so that both ends approach the zero."""
    little = 0.45 * NEAR_STATES / (high.length - low.length)
    return share + little if share < 0.5 else share - little


def _narrowed(low: _Trial, high: _Trial, trial: Callable[..., _Trial | None], small: float):
    """Closer ends, and whether the zero was reached; False if no state was found on the way."""
    known = [low, high]
    before = np.inf
    for _ in range(BISECTIONS):
        best = min(abs(low.value), abs(high.value))
        if best <= small or high.length - low.length <= NEAR_STATES:
            break
        # After a trial with little progress, the next one halves the way.
        share = _beyond(low, high, _guess(low, high, known)) if best <= before / 2 else 0.5
        new = trial(low, high, share)
        if new is None:
            return low, high, False
        known.append(new)
        before = best if best <= before / 2 else np.inf
        low, high = _replaced(low, high, new)
    return low, high, True


def _drawn_in(low: _Trial, high: _Trial, trial: Callable[..., _Trial | None]) -> tuple[_Trial, _Trial]:
    """Ends as close to the zero as states are found on either side."""
    tried = [0, 0]
    while min(tried) < len(DRAWN) and high.length - low.length > NEAR_STATES:
        middle = _estimate(low, high)
        ways = [middle, middle - 1]
        side = max((k for k in (0, 1) if tried[k] < len(DRAWN)), key=lambda k: abs(ways[k]))
        new = trial(low, high, side + DRAWN[tried[side]] * ways[side])
        if new is None:
            tried[side] += 1
        else:
            low, high = _replaced(low, high, new)
    return low, high


class Walker:
    """The walk along one path: states found so far, and the search for the next.

    States are NumPy arrays: operations on them do not pay for compiled programs.

    Attributes:
        code: Why the walk cannot begin, or successful.
        step: Largest change of the load factor in a step.
        steps: States found.
        critical: Critical points found.
        critical_steps: The states there.
        conditions: Values that end the walk.
        most: Number of critical points that ends it, or None.
        end: Largest load factor that the conditions allow.
        ended: Name of the condition that ended it, empty if the path ended by itself; None if neither did.
    """

    def __init__(self, equations: WalkEquations, step: float, stops: Stops):
        self.equations = equations
        self.scale, first, result = equations.begin()
        self.code = RESULTS(int(result))
        self.step = step
        self.steps: list[Step] = [first]
        self.critical: list[CriticalPoint] = []
        self.critical_steps: list[Step] = []
        self.conditions, self.most, self.end = stops
        self.ended: str | None = None

    def advance(self, begin: Point, direction: Direction, length: ArrayLike, plane: Plane | None = None) -> Step:
        """One step from a point along a direction, corrected across it or in a given plane."""
        plane = normal_to(self.scale, direction) if plane is None else plane
        return self.equations.advance(self.scale, Predictor(begin, direction, np.asarray(length, float), plane))

    def longest(self, tangent: Direction) -> float:
        """Length within which neither the load nor the motion changes too much."""
        return min(self.step / max(abs(float(tangent.load)), 1e-300), LARGEST_MOTION / self.motion(tangent))

    def motion(self, direction: Direction) -> float:
        """Largest change of a coordinate, in extents and radians."""
        return float(np.max(np.abs(direction.x) / self.scale.sizes, initial=1e-300))

    def chord(self, begin: Point, end: Point) -> tuple[Direction, float]:
        """Direction from one state to another, and the distance."""
        way = Direction(*(getattr(end, name) - getattr(begin, name) for name in Direction._fields))
        size = length_of(self.scale, way)
        return jax.tree.map(lambda a: a / (size if size > 0 else 1.0), way), float(size)

    def continuous(self, low: Step, high: Step) -> bool:
        """Whether a smooth curve joins two states: their tangents and the chord have one direction."""
        chord, size = self.chord(low.point, high.point)
        return (
            size < NEAR_STATES
            or min(weighted_product(self.scale, chord, at.tangent) for at in (low, high)) > SMALLEST_COSINE
        )

    def curve(self, low: Step, high: Step, share: float) -> Point:
        """Point between two states, on the cubic through both with their tangents."""
        _, size = self.chord(low.point, high.point)

        def straight(a: Any, b: Any):
            return a + share * (b - a)

        def bent(name: str):
            a, b = getattr(low.point, name), getattr(high.point, name)
            leaving = size * getattr(low.tangent, name) - (b - a)
            arriving = size * getattr(high.tangent, name) - (b - a)
            return straight(a, b) + share * (1 - share) * ((1 - share) * leaving - share * arriving)

        last_strain = straight(low.point.near, high.point.near)
        return Point(bent("x"), last_strain, bent("strained"), bent("load"), bent("multipliers"))

    def between(self, low: _Trial, high: _Trial) -> Zero:
        """Zero between two close states."""
        begin, end, share = low.step, high.step, _estimate(low, high)
        tangent, values = jax.tree.map(
            lambda a, b: (1 - share) * a + share * b, (begin.tangent, begin.values), (end.tangent, end.values)
        )
        point = self.curve(begin, end, share)
        step = begin._replace(point=point, tangent=unit(self.scale, tangent), values=values)
        return Zero(low.length + share * (high.length - low.length), step, abs(end.load - begin.load) / 2)

    def zero(
        self,
        begin: Step,
        length: float,
        end: Step,
        value: Callable[[Step], float],
        widest: float = WIDEST_GAP,
        alone: bool = False,
        ends: tuple[tuple[float, Step], ...] = (),
    ) -> Zero | None:
        """Zero of a value that changes sign on a step, or between two ``ends`` on it; None if the value jumps.

        If the value is ``alone`` in changing its sign, states on another branch are recognised by their orientation.
        Beside a bifurcation the corrector's equations are nearly singular: it finds no state, or one displaced along
        the motion without stiffness, with a wrong tangent. The zero is then taken between states on both sides.
        """
        ends = ends or ((0.0, begin), (length, end))
        low, high = (_Trial(place, value(at), at) for place, at in ends)
        small = ROUND_OFF * max(abs(low.value), abs(high.value))
        least = 2 * float(end.cosine) - 1 - 1e-3
        widest = max(widest * length, WIDEST_GAP_AT_LEAST)
        plane, still = normal_to(self.scale, begin.tangent), jax.tree.map(np.zeros_like, begin.tangent)

        def trial(low: _Trial, high: _Trial, share: float) -> _Trial | None:
            new = self.advance(self.curve(low.step, high.step, share), still, 0.0, plane)
            way, size = self.chord(begin.point, new.point)
            place = size * weighted_product(self.scale, way, begin.tangent)
            cosine = weighted_product(self.scale, begin.tangent, new.tangent)
            if not (bool(new.converged) and cosine >= least and low.length < place < high.length):
                return None
            candidate = _Trial(place, value(new), new._replace(cosine=np.array(cosine)))
            side = begin if (candidate.value > 0) == (low.value > 0) else end
            return None if alone and new.orientation != side.orientation else candidate

        low, high, reached = _narrowed(low, high, trial, small)
        if not reached:
            low, high = _drawn_in(low, high, trial)
        best = min(low, high, key=lambda end: abs(end.value))
        width = high.length - low.length
        if width > widest:
            # One end approached the zero alone: search a state close by on its other side.
            share = widest / 2 / width
            new = trial(low, high, share if best is low else 1 - share)
            low, high = (low, high) if new is None else _replaced(low, high, new)
        if high.length - low.length > widest or not self.continuous(low.step, high.step):
            return None
        if abs(best.value) <= small:
            return Zero(best.length, best.step, 0.0)
        estimate = self.between(low, high)
        # Values that only round-off separates have no change of sign.
        return estimate if np.isfinite(estimate.step.load) else None

    def cross(self, begin: Step, length: float, end: Step, widest: float) -> list[Crossing] | None:
        """Critical points on a step; None if the path jumps."""
        turns = (float(begin.tangent.load) > 0) != (float(end.tangent.load) > 0)
        low, high = sorted((begin.negative, end.negative))
        # On a branch through a pitchfork the stiffness only touches zero, and the load turns back there. The corrector
        # is nearly singular around that point; the load is stationary, so that half the digits suffice.
        touched, alone = low == high, high - low <= 1
        turn = None
        if turns:
            turn = self.zero(begin, length, end, lambda s: float(s.tangent.load), widest, alone)
            if turn is None:
                return None
            if touched:
                nearest = int(turn.step.below) + int(np.argmin(np.abs(turn.step.values)))
                return [Crossing(turn, "bifurcation", nearest)]
            # Whether the value that changes its sign is zero where the load turns back.
            at_turn, *at_ends = (abs(step.critical_value(low)) for step in (turn.step, begin, end))
            if alone and at_turn <= VANISHED_VALUE * max(at_ends):
                return [Crossing(turn, "limit", low)]
        crossings = []
        for j in range(low, high):
            at = self.zero(begin, length, end, lambda s, j=j: s.critical_value(j), widest, alone)
            if at is None:
                return None
            crossings.append(Crossing(at, "bifurcation", j))
        if turn is not None:
            # At a limit point psi^T r_load is not zero, so that the load's rate vanishes with the stiffness.
            i = min(range(len(crossings)), key=lambda i: abs(crossings[i].zero.length - turn.length))
            crossings[i] = Crossing(turn, "limit", crossings[i].number)
        return sorted(crossings, key=lambda f: f.zero.length)

    def finish(self, begin: Step, length: float, end: Step, crossed: list[Crossing]) -> AcceptedStep | None:
        """The step up to the first place where a condition is met; None if the path jumps."""
        endings = []
        for condition in self.conditions:
            places = self.extremes(condition, begin, length, end, crossed)
            if places is None:
                return None
            places = [(0.0, begin), *places, (length, end)]
            excess = [condition.excess(at) for _, at in places]
            for i in range(len(places) - 1):
                # A path that begins at the value must come back to it.
                if excess[i] != 0 and np.sign(excess[i]) * np.sign(excess[i + 1]) <= 0:
                    last = self.met(condition, begin, length, end, (places[i], places[i + 1]))
                    if last is None:
                        return None
                    endings.append(last)
                    break
        return AcceptedStep(begin, length, end, crossed, min(endings, key=lambda last: last.length, default=None))

    def extremes(
        self, condition: Condition, begin: Step, length: float, end: Step, crossed: list[Crossing]
    ) -> list[tuple[float, Step]] | None:
        """Places and states on a step at which the quantity of a condition may turn back; None for a jump."""
        if condition.at_ends:
            return []
        entry = condition.entry
        if entry is None:
            return [(f.zero.length, f.zero.step) for f in crossed]
        excess = [condition.excess(at) for at in (begin, end)]
        rates = [float(at.tangent.x[entry]) for at in (begin, end)]
        # It approaches first, recedes last, and is near enough to have been there.
        close = min(map(abs, excess)) < length * max(map(abs, rates))
        if not (close and excess[0] * excess[1] > 0 and excess[0] * rates[0] < 0 < excess[1] * rates[1]):
            return []
        turn = self.zero(begin, length, end, lambda s: float(s.tangent.x[entry]))
        return None if turn is None else [(turn.length, turn.step)]

    def met(
        self, condition: Condition, begin: Step, length: float, end: Step, ends: tuple[tuple[float, Step], ...]
    ) -> Last | None:
        """Where a condition is met between two places of a step, and the state there."""
        reached = self.zero(begin, length, end, condition.excess, ends=ends)
        if reached is None:
            return None
        still = jax.tree.map(np.zeros_like, reached.step.tangent)
        at, plane = reached.step.point, normal_to(self.scale, reached.step.tangent)
        if not condition.at_ends:
            # The corrector keeps the value itself, to round-off.
            target: Any = np.array(condition.start + condition.target)
            selected: Any = np.arange(len(at.x)) == condition.entry
            by_load = condition.entry is None
            at = at._replace(load=target) if by_load else at._replace(x=np.where(selected, target, at.x))
            plane = Plane(selected.astype(float), target * 0 + by_load)
        exact = self.advance(at, still, 0.0, plane)
        return Last(reached.length, exact if bool(exact.converged) else reached.step, condition.name)

    def motions(self, taken: AcceptedStep) -> tuple[list[Direction], list[Direction]]:
        """Motions without stiffness at the critical points of a step, normal to each other if two coincide.

        Also, for each, the direction normal to it in which the mechanism follows a rising load.
        """
        directions: list[Direction] = []
        loaded: list[Direction] = []
        for i, crossing in enumerate(taken.crossed):
            zero, before = crossing.zero, taken.crossed[i - 1].zero
            coincide = i > 0 and zero.length - before.length <= max(WIDEST_GAP * taken.length, WIDEST_GAP_AT_LEAST)
            beside = directions[-1] if coincide else jax.tree.map(np.zeros_like, zero.step.tangent)
            shift = np.asarray(np.abs(taken.begin.critical_value(crossing.number)) * NULL_VECTOR_SHIFT)
            phi, along = self.equations.null(self.scale, zero.step.point, shift, beside)
            directions.append(phi)
            loaded.append(along)
        return directions, loaded

    def is_neutral(self, taken: AcceptedStep, crossing: Crossing, phi: Direction) -> bool:
        """Whether a motion meets no stiffness on the branch that leaves a bifurcation along another motion."""
        begin, direction = crossing.zero.step, unit(self.scale, phi)
        value = max(abs(step.critical_value(crossing.number)) for step in (taken.begin, taken.end))
        plane = normal_to(self.scale, direction)._replace(stiffness=np.array(HOLD_ON_BRANCH * value))
        # The farther along the branch, the larger is the stiffness beside round-off.
        for length in self.longest(direction) / np.array([2, 8, 32]):
            new = self.advance(begin.point, direction, length, plane)
            if bool(new.converged) and float(new.cosine) > 0.5:
                sizes = np.sort(np.abs(new.values))
                return bool(sizes[0] <= NEUTRAL_ON_BRANCH * sizes[1])
        return False

    def branch(self, begin: Step, phi: Direction, others: list[Direction], sign: float) -> AcceptedStep | None:
        """First step on the branch that leaves a bifurcation along a motion.

        If two motions lose their stiffness together, branches leave only along some of their sums.
        """
        phi, *others = (unit(self.scale, jax.tree.map(lambda a: sign * a, motion)) for motion in (phi, *others))
        fan = [phi]
        for other in others:
            for angle in np.arange(1, 8) * np.pi / 8:
                fan.append(jax.tree.map(lambda a, b, t=angle: np.cos(t) * a + np.sin(t) * b, phi, other))
        for direction in fan:
            length = min(FIRST_ON_BRANCH / self.motion(direction), self.longest(direction))
            for _ in range(6):
                new = self.advance(begin.point, direction, length)
                if bool(new.converged) and float(new.cosine) > 0.5:
                    taken = self.finish(begin._replace(tangent=direction), length, new, [])
                    if taken is not None:
                        return taken
                    length /= 4
                    continue
                way, size = self.chord(begin.point, new.point)
                if size > 0 and weighted_product(self.scale, way, direction) > 0.5:
                    # The corrector moved towards a branch in another direction.
                    direction = way
                else:
                    length /= 4
        return None

    def stride(self, begin: Step, length: float, end: Step, widest: float = WIDEST_GAP) -> AcceptedStep | None:
        """Critical points and conditions on a step; None if the path jumps on it."""
        crossed = self.cross(begin, length, end, widest)
        return None if crossed is None else self.finish(begin, length, end, crossed)

    def leap(self, begin: Step) -> AcceptedStep | None:
        """Shortest step over states that are not found; None without one."""
        directions = [begin.tangent]
        if len(self.steps) > 1:
            # Too near to a bifurcation, its own tangent is wrong.
            directions.append(self.chord(self.steps[-2].point, begin.point)[0])
        for direction in directions:
            start = begin._replace(tangent=direction)
            for length in self.longest(direction) / 4.0 ** np.arange(10)[::-1]:
                end = self.advance(begin.point, direction, length)
                if is_acceptable(end.converged, end.cosine) and self.continuous(start, end):
                    path_step = self.stride(start, float(length), end, widest=1.0)
                    if path_step is not None:
                        return path_step
        return None

    def come_round(self, taken: AcceptedStep) -> Step | None:
        """State on a step that the path passed before in the same direction; None if the path is not closed."""
        begin, old = taken.begin, self.steps[:-1]
        if not old:
            return None
        x, load = (np.array([getattr(step.point, name) for step in old]) for name in ("x", "load"))
        dx, dload = x - begin.point.x, load - begin.point.load
        along = (dx * self.scale.weights) @ begin.tangent.x + dload * begin.tangent.load
        off = dx**2 @ self.scale.weights + dload**2 - along**2
        for i in np.flatnonzero((along > 0) & (along <= taken.length) & (off < (taken.length / 2) ** 2)):
            if weighted_product(self.scale, old[i].tangent, begin.tangent) > 0.5:
                new = self.advance(begin.point, begin.tangent, along[i])
                distances = np.abs(new.point.x - old[i].point.x) / self.scale.sizes
                # An angle after another full turn is another state, with equal Euler parameters.
                turned = np.abs(new.point.strained - old[i].point.strained)
                same = max(np.max(distances, initial=0.0), abs(new.load - old[i].load)) < SAME_STATE and np.all(
                    turned < 1.0
                )
                if bool(new.converged) and same:
                    return new
        return None

    def walk(
        self, max_steps: int, switch: dict[int, int], report: Callable[[int, float], None] | None = None
    ) -> RESULTS:
        """Walk until a condition is met; return why the walk ended.

        ``switch`` has directions, 1 or -1, at bifurcations by their number from 1; used ones are removed. ``report`` is
        called with the number of steps and the load factor before each step.
        """
        length, regular = np.inf, True
        while self.code == RESULTS.successful:
            if len(self.steps) > max_steps:
                return RESULTS.max_steps
            begin = self.steps[-1]
            if report is not None:
                report(len(self.steps), begin.load)
            length = min(length, self.longest(begin.tangent))
            # This form ends the walk for NaN.
            if not SHORTEST_PATH_STEP * self.step <= length < np.inf:
                path_step = self.leap(begin)
                if path_step is None:
                    if len(self.steps) == 1 and begin.singular:
                        return RESULTS.singular_stiffness
                    return RESULTS.not_converged if regular else RESULTS.singular_configuration
                length = path_step.length
            else:
                short = self.end - begin.load - length * float(begin.tangent.load)
                if 0 <= short < 0.2 * length * float(begin.tangent.load):
                    # Stretch this step to the end to avoid a tiny last one.
                    length *= 1.25
                end = self.advance(begin.point, begin.tangent, length)
                regular = bool(end.regular)
                if not is_acceptable(end.converged, end.cosine):
                    length /= SHORTER
                    continue
                if abs(end.negative - begin.negative) > 1 and length > 1e-2 * self.step:
                    length /= 2
                    continue
                path_step = self.stride(begin, length, end)
                if path_step is None:
                    length /= SHORTER
                    continue
            departure = self.pass_critical_points(path_step, switch)
            if isinstance(departure, RESULTS):
                return departure
            if departure is not None:
                path_step = departure
            elif self.ended is not None:
                return RESULTS.successful
            if path_step.last is not None:
                self.steps.append(path_step.last.step)
                self.ended = path_step.last.name
                return RESULTS.successful
            if departure is not None:
                self.steps.append(path_step.end)
                continue
            again = self.come_round(path_step)
            if again is not None:
                self.steps.append(again)
                return RESULTS.closed_path
            self.steps.append(path_step.end)
            length = next_length(length, path_step.end.corrections, path_step.end.cosine)
        return self.code

    def pass_critical_points(self, taken: AcceptedStep, switch: dict[int, int]) -> AcceptedStep | RESULTS | None:
        """Add the critical points up to the end of a step, or to a bifurcation where the walk changes the branch.

        Returns the first step on another branch, or why there is none; None if the walk stays on the path.
        """
        motions, loaded = self.motions(taken)
        for i, (crossing, phi) in enumerate(zip(taken.crossed, motions, strict=True)):
            if taken.last is not None and crossing.zero.length > taken.last.length:
                break
            at = crossing.zero.step
            self.critical_steps.append(at)
            numbers: Any = at.load, crossing.kind, at.point.x, phi.x, crossing.zero.uncertainty
            self.critical.append(CriticalPoint(*numbers))
            if len(self.critical) == self.most:
                self.steps.append(at)
                self.ended = COUNT
                break
            number = sum(point.kind == "bifurcation" for point in self.critical)
            if crossing.kind == "bifurcation" and number in switch:
                others, side = motions[i + 1 :], switch.pop(number)
                if len(motions) > 1 and self.is_neutral(taken, crossing, phi):
                    return RESULTS.neutral_branch
                way, _ = self.chord(taken.begin.point, taken.end.point)
                along_phi, along_load = (
                    abs(weighted_product(self.scale, way, unit(self.scale, d))) for d in (phi, loaded[i])
                )
                if along_phi > along_load:
                    # The walk came along phi: the other branch follows the load.
                    phi, others = loaded[i], []
                return self.branch(at, phi, others, side) or RESULTS.not_converged
        return None
