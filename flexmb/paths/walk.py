"""The walk along an equilibrium path: which steps are taken, and where the critical points on them lie."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Bool, Float, Int

from ..math.linear import factorise
from ..mechanics.blocks import kernel
from ..mechanics.extent import sizes_of
from ..mechanics.residual import state
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .critical import CriticalPoint, begin_path, critical_values, null_vectors
from .stepper import (
    DENSE_PATH,
    LARGEST_MOTION,
    SHORTER,
    SMALLEST_COSINE,
    SMALLEST_STEP,
    Direction,
    Plane,
    Point,
    Ramp,
    Scale,
    begins_undeformed,
    can_be_taken,
    direction_of,
    length_of,
    load_response,
    next_length,
    normal_to,
    product,
    ramp_of,
    scale_of,
    step_along,
    unit,
)
from .stops import COUNT, Condition, Last, Stops

BISECTIONS = 60
# A value is zero where it is this share of those at the ends of the step, or between states that are this near to each
# other: there the path is straight to 1e-12.
ZERO = 1e-12
NEAR = 1e-6
# States on both sides of a zero must be found this near to each other, as share of the step or at all, and a smooth
# curve must join them: a path that bends away beside another seems to go straight on to that. Otherwise the step is
# shortened.
WIDEST = 1e-3
WIDEST_AT_LEAST = 1e-5
# Beside a bifurcation, where no states are found, a zero is drawn in from both sides by these shares of the way to
# where it seems to be.
DRAWN = (7 / 8, 1 / 2)
# The critical value that changes its sign on a step is zero where the load turns back, if it is this share of those at
# the ends of the step there: a second search would find the same point.
VANISHED = 1e-4
# A critical value below this share of the next one has no sign: where a column may buckle to any side, it goes from one
# side to another without force.
NEUTRAL = 1e-13
# A motion meets no stiffness where the critical value is this share of the largest.
NO_STIFFNESS = 1e-12
# States of a closed path agree to this (extents, radians, load factor) where it has come round: Newton's tolerance.
SAME = 1e-7
# Where two motions lose their stiffness at once, one meets none on the branch if its critical value there is this share
# of the next one: that of a motion which does meet one grows as that does.
MEETS_NONE = 1e-5
# What makes a singular stiffness regular for its null vector, as share of the critical value at the begin of the step.
SHIFT = 1e-9
# What holds a motion that meets no stiffness on a branch, as share of the critical values at the ends of the step: far
# below the stiffness of other motions, so that the corrector converges, and far above round-off.
HOLD = 1e-3
# Motion of the first step on another branch (extents, radians).
FIRST_ON_BRANCH = 0.02


class Step(NamedTuple):
    """A step's end, and what decides whether it is taken.

    Attributes:
        point: State.
        tangent: Tangent of the path there, of unit length.
        values: Values that change sign where the stiffness is singular, (n_q,) [N m].
        converged: Whether the corrector converged.
        regular: Whether the degrees of freedom determine the configuration.
        cosine: Of the angle between the direction of the step and the tangent at its end.
        corrections: Newton iterations.
        below: How many more such values there are, all of them negative and farther from zero, (); of many values few
            are told.
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
        """Number of critical values below zero, but for those that are zero to round-off all along a path."""
        sizes = np.sort(np.abs(self.values))
        next_one = sizes[1] if len(sizes) > 1 and np.isfinite(sizes[1]) else 0.0
        return int(self.below) + int(np.sum(self.values < -NEUTRAL * next_one))

    @property
    def singular(self) -> bool:
        """Whether some motion meets no stiffness, but for round-off."""
        sizes = np.abs(self.values[np.isfinite(self.values)])
        return bool(np.any(sizes <= NO_STIFFNESS * np.max(sizes, initial=0.0)))

    def critical_value(self, number: int) -> float:
        """One critical value by its number from the lowest, () [N m]; for one that is not told, the farthest told."""
        place = number - int(self.below)
        if 0 <= place < len(self.values):
            return float(self.values[place])
        return float(np.copysign(np.max(np.abs(self.values), initial=0.0), place))

    @property
    def orientation(self) -> float:
        """Sign of the determinant of [K, r_load; tangent], which a path keeps up to a bifurcation."""
        return (-1) ** self.negative * float(np.sign(self.tangent.load))

    @property
    def load(self) -> float:
        """Load factor, () [-]."""
        return float(self.point.load)


@kernel
def _begin(topology: Topology, parameters: Parameters):
    ramp, point, tangent, scale, at, result = begin_path(topology, parameters)
    values = critical_values(topology, at, scale.sizes)
    found = result == RESULTS.successful
    none = jnp.zeros((), jnp.int32)
    step = Step(point, tangent, values, found, found, jnp.array(1.0), none, none)
    return ramp, scale, step, result


@kernel
def _advance(
    topology: Topology,
    parameters: Parameters,
    ramp: Ramp,
    scale: Scale,
    begin: Point,
    direction: Direction,
    length: Float[Array, ""],
    plane: Plane,
):
    new = step_along(DENSE_PATH, topology, parameters, ramp, scale, begin, direction, length, plane)
    values = critical_values(topology, new.at, scale.sizes)
    regular = new.failure == RESULTS.successful
    none = jnp.zeros((), jnp.int32)
    return Step(new.point, new.tangent, values, new.converged, regular, new.cosine, new.corrections, none)


@kernel
def _null(
    topology: Topology,
    parameters: Parameters,
    ramp: Ramp,
    scale: Scale,
    point: Point,
    shift: Float[Array, ""],
    beside: Direction,
):
    at = state(topology, parameters, ramp.at(point.load), point.x, point.near, strained=point.strained)
    other = jnp.concatenate([beside.x[topology.x.dof], beside.strained[topology.e.dof]])
    phi, psi = null_vectors(topology, at, scale.sizes, shift, other)
    # In another direction, normal to phi, the load changes and r does not: K with phi made stiff gives it.
    z = at.transfer.DFx / scale.sizes[:, None]
    metric = z.T @ z
    stiffened = at.K0 + at.G0 + shift / SHIFT * jnp.outer(metric @ psi, metric @ phi) / (psi @ metric @ phi)
    onto, by_load = load_response(topology, parameters, ramp, at)
    dq = -factorise(stiffened).solve(by_load)
    along = onto + at.transfer.DFx @ (dq - phi * (phi @ metric @ dq) / (phi @ metric @ phi))
    return direction_of(at, at.transfer.DFx @ phi, jnp.array(0.0)), direction_of(at, along, jnp.array(1.0))


class WalkEquations(Protocol):
    """What a walk asks of a mechanism; states are arrays of NumPy."""

    def begin(self) -> tuple[Ramp, Scale, Step, Any]:
        """Ramp of the loads, what makes metres, radians and load comparable, first state, code of RESULTS."""
        ...

    def advance(self, ramp: Ramp, scale: Scale, begin: Point, direction: Direction, length: Any, plane: Plane) -> Step:
        """One step from a point along a direction, corrected in a plane."""
        ...

    def null(
        self, ramp: Ramp, scale: Scale, point: Point, shift: Any, beside: Direction
    ) -> tuple[Direction, Direction]:
        """Motion that meets no stiffness, normal to ``beside``; direction normal to it that follows a rising load."""
        ...


def begin_at(equations: Any, ramp: Ramp, point: Point) -> tuple[Ramp, Scale, Step, Any] | None:
    """What :meth:`WalkEquations.begin` finds at a known state, by a step of no length; None where it finds nothing.

    Args:
        equations: With ``parts``, the topology and the parameters.
        ramp: Load factors along the path.
        point: State at load factor zero.
    """
    topology, parameters = equations.parts
    given: Any = [np.asarray(a, float) for a in (0.0, 1.0, sizes_of(topology, parameters))]
    none, one, sizes = given
    still: Any = Direction(0 * point.x, 0 * point.strained, none, 0 * point.multipliers)
    rising: Any = Plane(0 * point.x, one)
    alike: Any = Scale(sizes, sizes**0)
    step = equations.advance(ramp, alike, point, still, none, rising)
    if not step.converged or not step.regular:
        return None
    scale = scale_of(topology, parameters, step.tangent)
    step = step._replace(point=point, tangent=unit(scale, step.tangent), cosine=one)
    return ramp, scale, step._replace(corrections=np.zeros((), np.int32)), RESULTS.successful


class DenseEquations:
    """Equations in the degrees of freedom, by dense matrices in compiled code."""

    def __init__(self, model: Model):
        self.parts = (model.topology, model.parameters)

    def begin(self) -> tuple[Ramp, Scale, Step, Any]:
        """See :class:`WalkEquations`."""
        topology, parameters = self.parts
        if begins_undeformed(topology, parameters):
            # By the compiled code of a step.
            zero: Any = np.zeros(topology.n_e)
            empty: Any = np.zeros(0)
            ramp, x = jax.device_get((ramp_of(topology, parameters), parameters.reference))
            found = begin_at(self, ramp, Point(x, zero, zero, zero.sum(), empty))
            if found is not None:
                return found
        return jax.device_get(_begin(*self.parts))

    def advance(self, ramp: Ramp, scale: Scale, begin: Point, direction: Direction, length: Any, plane: Plane) -> Step:
        """See :class:`WalkEquations`."""
        return jax.device_get(_advance(*self.parts, ramp, scale, begin, direction, length, plane))

    def null(
        self, ramp: Ramp, scale: Scale, point: Point, shift: Any, beside: Direction
    ) -> tuple[Direction, Direction]:
        """See :class:`WalkEquations`."""
        return jax.device_get(_null(*self.parts, ramp, scale, point, shift, beside))


class Zero(NamedTuple):
    """Where a value along a step is zero.

    Attributes:
        length: Place on the step.
        step: State there.
        uncertainty: By how much its load factor may be off at most, () [-]; zero where the state itself was found.
    """

    length: float
    step: Step
    uncertainty: float


class Crossing(NamedTuple):
    """A critical point on a step.

    Attributes:
        zero: Where it is.
        kind: "limit" or "bifurcation".
        number: Which critical value changes sign.
    """

    zero: Zero
    kind: str
    number: int


class Stride(NamedTuple):
    """A step that can be taken.

    Attributes:
        begin: State where it begins, its tangent the direction of the step.
        length: How long it is.
        end: State where it ends.
        crossed: Critical points on it.
        last: Where the walk ends on it; None if it does not.
    """

    begin: Step
    length: float
    end: Step
    crossed: list[Crossing]
    last: Last | None


class Departure(NamedTuple):
    """That the walk left its branch at a bifurcation.

    Attributes:
        new: First step on the other branch; None if it was not found.
        is_neutral: Whether a second motion loses its stiffness there, and meets none on the branch either.
    """

    new: Stride | None
    is_neutral: bool


class _Trial(NamedTuple):
    """A state on a step, and the value there whose zero is looked for."""

    length: float
    value: float
    step: Step


def _estimate(low: _Trial, high: _Trial) -> float:
    """Share of the way from one state to another at which the value is zero."""
    return low.value / (low.value - high.value)


def _replaced(low: _Trial, high: _Trial, new: _Trial) -> tuple[_Trial, _Trial]:
    """The ends between which the sign changes, with a new state in place of one of them."""
    return (new, high) if (new.value > 0) == (low.value > 0) else (low, new)


def _guess(low: _Trial, high: _Trial, known: list[_Trial]) -> float:
    """Share of the way at which a smooth function through the states found last is zero: place as function of value.

    Source:
        Inverse interpolation by Neville's scheme, whose order grows towards two with the states.
    """
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
    """A little beyond that, seen from the nearer end: both ends come near, and neither where a bifurcation blurs it."""
    little = 0.45 * NEAR / (high.length - low.length)
    return share + little if share < 0.5 else share - little


def _narrowed(low: _Trial, high: _Trial, trial: Callable[..., _Trial | None], small: float):
    """Ends that lie closer, and whether the zero was reached: false where no state was found on the way."""
    known = [low, high]
    before = np.inf
    for _ in range(BISECTIONS):
        best = min(abs(low.value), abs(high.value))
        if best <= small or high.length - low.length <= NEAR:
            break
        # Where a trial brought little, the next one halves the way.
        share = _beyond(low, high, _guess(low, high, known)) if best <= before / 2 else 0.5
        new = trial(low, high, share)
        if new is None:
            return low, high, False
        known.append(new)
        before = best if best <= before / 2 else np.inf
        low, high = _replaced(low, high, new)
    return low, high, True


def _drawn_in(low: _Trial, high: _Trial, trial: Callable[..., _Trial | None]) -> tuple[_Trial, _Trial]:
    """Ends that lie as close to the zero as states are found on either side of it."""
    tried = [0, 0]
    while min(tried) < len(DRAWN) and high.length - low.length > NEAR:
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
    """The walk along one path: what has been found so far, and how to find the next.

    States are kept as arrays of NumPy: what is asked of them is not worth a compiled program.

    Attributes:
        equations: What is asked of the mechanism.
        scale: What makes metres, radians and load comparable.
        code: Why the walk cannot begin, or successful.
        step: Largest change of the load factor in a step, () [-].
        steps: States found.
        critical: Critical points found.
        critical_steps: The states there.
        conditions: Values that end the walk.
        most: Number of critical points that ends it, or None.
        end: Largest load factor to which the conditions let it go, () [-].
        ended: Name of the condition that ended it, empty where the path ended by itself; None where none did.
    """

    def __init__(self, equations: WalkEquations, step: float, stops: Stops):
        self.equations = equations
        self.ramp, self.scale, first, result = equations.begin()
        self.code = RESULTS(int(result))
        self.step = step
        self.steps: list[Step] = [first]
        self.critical: list[CriticalPoint] = []
        self.critical_steps: list[Step] = []
        self.conditions, self.most, self.end = stops
        self.ended: str | None = None

    def advance(self, begin: Point, direction: Direction, length: ArrayLike, plane: Plane | None = None) -> Step:
        """One step from a point along a direction, corrected across it unless another plane is given."""
        plane = normal_to(self.scale, direction) if plane is None else plane
        arguments = (self.ramp, self.scale, begin, direction, np.asarray(length, float), plane)
        return self.equations.advance(*arguments)

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
        """Whether a smooth curve joins two states: their tangents and the chord between them have one direction."""
        chord, size = self.chord(low.point, high.point)
        return size < NEAR or min(product(self.scale, chord, at.tangent) for at in (low, high)) > SMALLEST_COSINE

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

        near = straight(low.point.near, high.point.near)
        return Point(bent("x"), near, bent("strained"), bent("load"), bent("multipliers"))

    def between(self, low: _Trial, high: _Trial) -> Zero:
        """Zero between two states close by."""
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
        widest: float = WIDEST,
        alone: bool = False,
        ends: tuple[tuple[float, Step], ...] = (),
    ) -> Zero | None:
        """Where a value that changes sign on a step is zero; None if it jumps.

        It changes its sign between the ends of the step, or between two places and states on it. Where the value is
        ``alone`` in changing its sign, states on another branch are known by their orientation.

        Beside a bifurcation the corrector's equations are nearly singular: it finds no state, or one that is astray
        along the motion that meets no stiffness, and so is its tangent. The zero is then taken between states on both
        sides.
        """
        ends = ends or ((0.0, begin), (length, end))
        low, high = (_Trial(place, value(at), at) for place, at in ends)
        small = ZERO * max(abs(low.value), abs(high.value))
        least = 2 * float(end.cosine) - 1 - 1e-3
        widest = max(widest * length, WIDEST_AT_LEAST)
        plane, still = normal_to(self.scale, begin.tangent), jax.tree.map(np.zeros_like, begin.tangent)

        def trial(low: _Trial, high: _Trial, share: float) -> _Trial | None:
            new = self.advance(self.curve(low.step, high.step, share), still, 0.0, plane)
            way, size = self.chord(begin.point, new.point)
            place = size * product(self.scale, way, begin.tangent)
            cosine = product(self.scale, begin.tangent, new.tangent)
            if not (bool(new.converged) and cosine >= least and low.length < place < high.length):
                return None
            found = _Trial(place, value(new), new._replace(cosine=np.array(cosine)))
            side = begin if (found.value > 0) == (low.value > 0) else end
            return None if alone and new.orientation != side.orientation else found

        low, high, reached = _narrowed(low, high, trial, small)
        if not reached:
            low, high = _drawn_in(low, high, trial)
        best = min(low, high, key=lambda end: abs(end.value))
        width = high.length - low.length
        if width > widest:
            # One end came to the zero alone: is there a state close by on its other side?
            share = widest / 2 / width
            new = trial(low, high, share if best is low else 1 - share)
            low, high = (low, high) if new is None else _replaced(low, high, new)
        if high.length - low.length > widest or not self.continuous(low.step, high.step):
            return None
        if abs(best.value) <= small:
            return Zero(best.length, best.step, 0.0)
        found = self.between(low, high)
        # Of values that round-off alone tells apart none is where they change their sign.
        return found if np.isfinite(found.step.load) else None

    def cross(self, begin: Step, length: float, end: Step, widest: float) -> list[Crossing] | None:
        """Critical points on a step; None if the path jumps."""
        turns = (float(begin.tangent.load) > 0) != (float(end.tangent.load) > 0)
        low, high = sorted((begin.negative, end.negative))
        # On a branch that comes through a pitchfork the stiffness only touches zero, and the load turns back there. The
        # corrector is nearly singular around that point; the load is stationary, so that half the digits do.
        touched, alone = low == high, high - low <= 1
        turn = None
        if turns:
            turn = self.zero(begin, length, end, lambda s: float(s.tangent.load), widest, alone)
            if turn is None:
                return None
            if touched:
                nearest = int(turn.step.below) + int(np.argmin(np.abs(turn.step.values)))
                return [Crossing(turn, "bifurcation", nearest)]
            if alone and self.vanishes(low, begin, turn.step, end):
                return [Crossing(turn, "limit", low)]
        found = []
        for j in range(low, high):
            at = self.zero(begin, length, end, lambda s, j=j: s.critical_value(j), widest, alone)
            if at is None:
                return None
            found.append(Crossing(at, "bifurcation", j))
        if turn is not None:
            # At a limit point psi^T r_load is not zero, so that the load's rate vanishes with the stiffness.
            i = min(range(len(found)), key=lambda i: abs(found[i].zero.length - turn.length))
            found[i] = Crossing(turn, "limit", found[i].number)
        return sorted(found, key=lambda f: f.zero.length)

    def vanishes(self, number: int, begin: Step, at: Step, end: Step) -> bool:
        """Whether a critical value that changes its sign on a step is zero where the load turns back."""
        there = abs(at.critical_value(number))
        return there <= VANISHED * max(abs(step.critical_value(number)) for step in (begin, end))

    def finish(self, begin: Step, length: float, end: Step, crossed: list[Crossing]) -> list[Last] | None:
        """Where conditions are met on a step, the first place of each; None if the path jumps."""
        found = []
        for condition in self.conditions:
            places = self.extremes(condition, begin, length, end, crossed)
            if places is None:
                return None
            places = [(0.0, begin), *places, (length, end)]
            excess = [condition.excess(at) for _, at in places]
            for i in range(len(places) - 1):
                # A path that begins at the value is to come there again.
                if excess[i] != 0 and np.sign(excess[i]) * np.sign(excess[i + 1]) <= 0:
                    last = self.met(condition, begin, length, end, (places[i], places[i + 1]))
                    if last is None:
                        return None
                    found.append(last)
                    break
        return found

    def extremes(
        self, condition: Condition, begin: Step, length: float, end: Step, crossed: list[Crossing]
    ) -> list[tuple[float, Step]] | None:
        """Places on a step at which the quantity of a condition may turn back, with the states; None for a jump."""
        if condition.at_ends:
            return []
        entry = condition.entry
        if entry is None:
            return [(f.zero.length, f.zero.step) for f in crossed]
        excess = [condition.excess(at) for at in (begin, end)]
        rates = [float(at.tangent.x[entry]) for at in (begin, end)]
        # It comes nearer at first, goes away at last, and is near enough to have been there.
        near = min(map(abs, excess)) < length * max(map(abs, rates))
        if not (near and excess[0] * excess[1] > 0 and excess[0] * rates[0] < 0 < excess[1] * rates[1]):
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
            # The corrector keeps the value itself where it is, to round-off.
            target: Any = np.array(condition.start + condition.target)
            one: Any = np.arange(len(at.x)) == condition.entry
            by_load = condition.entry is None
            at = at._replace(load=target) if by_load else at._replace(x=np.where(one, target, at.x))
            plane = Plane(one.astype(float), target * 0 + by_load)
        exact = self.advance(at, still, 0.0, plane)
        return Last(reached.length, exact if bool(exact.converged) else reached.step, condition.name)

    def motions(self, taken: Stride) -> tuple[list[Direction], list[Direction]]:
        """Motions that meet no stiffness at the critical points of a step, normal to each other where two coincide.

        Beside each the direction normal to it in which the mechanism follows a rising load.
        """
        found: list[Direction] = []
        loaded: list[Direction] = []
        for i, crossing in enumerate(taken.crossed):
            zero, before = crossing.zero, taken.crossed[i - 1].zero
            coincide = i > 0 and zero.length - before.length <= max(WIDEST * taken.length, WIDEST_AT_LEAST)
            beside = found[-1] if coincide else jax.tree.map(np.zeros_like, zero.step.tangent)
            shift = np.asarray(np.abs(taken.begin.critical_value(crossing.number)) * SHIFT)
            arguments = (self.ramp, self.scale, zero.step.point, shift, beside)
            phi, along = self.equations.null(*arguments)
            found.append(phi)
            loaded.append(along)
        return found, loaded

    def name(self, crossing: Crossing, phi: Direction) -> None:
        """Add a critical point."""
        at: Any = crossing.zero.step
        motion: Any = phi.x
        self.critical_steps.append(at)
        self.critical.append(CriticalPoint(at.load, crossing.kind, at.point.x, motion, crossing.zero.uncertainty))

    def is_neutral(self, taken: Stride, crossing: Crossing, phi: Direction) -> bool:
        """Whether a motion meets no stiffness on the branch that leaves a bifurcation along another motion."""
        begin, direction = crossing.zero.step, unit(self.scale, phi)
        value = max(abs(step.critical_value(crossing.number)) for step in (taken.begin, taken.end))
        plane = normal_to(self.scale, direction)._replace(stiffness=np.array(HOLD * value))
        # The farther along the branch, the larger is the stiffness that round-off is measured against.
        for length in self.longest(direction) / np.array([2, 8, 32]):
            new = self.advance(begin.point, direction, length, plane)
            if bool(new.converged) and float(new.cosine) > 0.5:
                sizes = np.sort(np.abs(new.values))
                return bool(sizes[0] <= MEETS_NONE * sizes[1])
        return False

    def branch(self, begin: Step, phi: Direction, others: list[Direction], sign: float) -> Stride | None:
        """First step on the branch that leaves a bifurcation along a motion.

        Where two motions lose their stiffness at once, branches leave along some of their sums only.
        """
        phi, *others = (unit(self.scale, jax.tree.map(lambda a: sign * a, one)) for one in (phi, *others))
        fan = [phi]
        for other in others:
            for angle in np.arange(1, 8) * np.pi / 8:
                fan.append(jax.tree.map(lambda a, b, t=angle: np.cos(t) * a + np.sin(t) * b, phi, other))
        for direction in fan:
            length = min(FIRST_ON_BRANCH / self.motion(direction), self.longest(direction))
            for _ in range(6):
                new = self.advance(begin.point, direction, length)
                if bool(new.converged) and float(new.cosine) > 0.5:
                    start = begin._replace(tangent=direction)
                    met = self.finish(start, length, new, [])
                    if met is not None:
                        return Stride(start, length, new, [], min(met, key=lambda last: last.length, default=None))
                    length /= 4
                    continue
                way, size = self.chord(begin.point, new.point)
                if size > 0 and product(self.scale, way, direction) > 0.5:
                    # The corrector was on its way to a branch that leaves in another direction.
                    direction = way
                else:
                    length /= 4
        return None

    def stride(self, begin: Step, length: float, end: Step, widest: float = WIDEST) -> Stride | None:
        """What lies on a step; None if the path jumps on it."""
        crossed = self.cross(begin, length, end, widest)
        if crossed is None:
            return None
        met = self.finish(begin, length, end, crossed)
        if met is None:
            return None
        return Stride(begin, length, end, crossed, min(met, key=lambda last: last.length, default=None))

    def leap(self, begin: Step) -> Stride | None:
        """A step over states that are not found, as short as can be; None if there is none."""
        directions = [begin.tangent]
        if len(self.steps) > 1:
            # Where it begins too near to a bifurcation, its own tangent is astray.
            directions.append(self.chord(self.steps[-2].point, begin.point)[0])
        for direction in directions:
            start = begin._replace(tangent=direction)
            for length in self.longest(direction) / 4.0 ** np.arange(10)[::-1]:
                end = self.advance(begin.point, direction, length)
                if can_be_taken(end.converged, end.cosine) and self.continuous(start, end):
                    taken = self.stride(start, float(length), end, widest=1.0)
                    if taken is not None:
                        return taken
        return None

    def come_round(self, taken: Stride) -> Step | None:
        """State on a step that the path passed before in the same direction: the path is closed."""
        begin, old = taken.begin, self.steps[:-1]
        if not old:
            return None
        x, load = (np.array([getattr(step.point, name) for step in old]) for name in ("x", "load"))
        dx, dload = x - begin.point.x, load - begin.point.load
        along = (dx * self.scale.weights) @ begin.tangent.x + dload * begin.tangent.load
        off = dx**2 @ self.scale.weights + dload**2 - along**2
        for i in np.flatnonzero((along > 0) & (along <= taken.length) & (off < (taken.length / 2) ** 2)):
            if product(self.scale, old[i].tangent, begin.tangent) > 0.5:
                new = self.advance(begin.point, begin.tangent, along[i])
                apart = np.abs(new.point.x - old[i].point.x) / self.scale.sizes
                # An angle that has turned once more is another state, with equal Euler parameters.
                turned = np.abs(new.point.strained - old[i].point.strained)
                same = max(np.max(apart, initial=0.0), abs(new.load - old[i].load)) < SAME and np.all(turned < 1.0)
                if bool(new.converged) and same:
                    return new
        return None

    def walk(
        self, max_steps: int, switch: dict[int, int], report: Callable[[int, float], None] | None = None
    ) -> RESULTS:
        """Walk until a condition is met; the code says why the walk ended.

        Args:
            max_steps: Steps at most.
            switch: Direction, 1 or -1, in which bifurcations are left, by their number from 1. What is used is taken
                out.
            report: Called with the number of steps and the load factor before each step.
        """
        length, regular = np.inf, True
        while self.code == RESULTS.successful:
            if len(self.steps) > max_steps:
                return RESULTS.max_steps
            begin = self.steps[-1]
            if report is not None:
                report(len(self.steps), begin.load)
            length = min(length, self.longest(begin.tangent))
            # Written so that NaN ends the walk.
            if not SMALLEST_STEP * self.step <= length < np.inf:
                taken = self.leap(begin)
                if taken is None:
                    if len(self.steps) == 1 and begin.singular:
                        return RESULTS.singular_stiffness
                    return RESULTS.not_converged if regular else RESULTS.singular_configuration
                length = taken.length
            else:
                short = self.end - begin.load - length * float(begin.tangent.load)
                if 0 <= short < 0.2 * length * float(begin.tangent.load):
                    # Stretch this step to the end rather than leave a tiny last one.
                    length *= 1.25
                end = self.advance(begin.point, begin.tangent, length)
                regular = bool(end.regular)
                if not can_be_taken(end.converged, end.cosine):
                    length /= SHORTER
                    continue
                if abs(end.negative - begin.negative) > 1 and length > 1e-2 * self.step:
                    length /= 2
                    continue
                taken = self.stride(begin, length, end)
                if taken is None:
                    length /= SHORTER
                    continue
            departure = self.pass_critical_points(taken, switch)
            if departure is not None:
                if departure.is_neutral:
                    return RESULTS.neutral_branch
                if departure.new is None:
                    return RESULTS.not_converged
                taken = departure.new
            elif self.ended is not None:
                return RESULTS.successful
            if taken.last is not None:
                self.steps.append(taken.last.step)
                self.ended = taken.last.name
                return RESULTS.successful
            if departure is not None:
                self.steps.append(taken.end)
                continue
            again = self.come_round(taken)
            if again is not None:
                self.steps.append(again)
                return RESULTS.closed_path
            self.steps.append(taken.end)
            length = next_length(length, taken.end.corrections, taken.end.cosine)
        return self.code

    def pass_critical_points(self, taken: Stride, switch: dict[int, int]) -> Departure | None:
        """Name the critical points up to where the walk leaves a step: its end, or a bifurcation to another branch."""
        motions, loaded = self.motions(taken)
        for i, (crossing, phi) in enumerate(zip(taken.crossed, motions, strict=True)):
            if taken.last is not None and crossing.zero.length > taken.last.length:
                break
            self.name(crossing, phi)
            if len(self.critical) == self.most:
                self.steps.append(crossing.zero.step)
                self.ended = COUNT
                break
            number = sum(point.kind == "bifurcation" for point in self.critical)
            if crossing.kind == "bifurcation" and number in switch:
                others, side = motions[i + 1 :], switch.pop(number)
                if len(motions) > 1 and self.is_neutral(taken, crossing, phi):
                    return Departure(None, True)
                way, _ = self.chord(taken.begin.point, taken.end.point)
                along_phi, along_load = (abs(product(self.scale, way, unit(self.scale, d))) for d in (phi, loaded[i]))
                if along_phi > along_load:
                    # The walk came along phi itself, and the other branch is the one that follows the load.
                    phi, others = loaded[i], []
                return Departure(self.branch(crossing.zero.step, phi, others, side), False)
        return None
