"""The walk along an equilibrium path: which steps are taken, and where the critical points on them lie."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..math.compile import jit
from ..mechanics.residual import state
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .continuation import Direction, Plane, Point, Ramp, Scale, direction_of, normal_to, step_along, unit
from .critical import (
    LARGEST_MOTION,
    SMALLEST_COSINE,
    SMALLEST_STEP,
    CriticalPoint,
    begin_path,
    critical_values,
    null_vectors,
)

BISECTIONS = 60
# A sign that changes although the value stays above this share of those at the ends of the step is no zero but a jump:
# the step is refused. A zero is located to a millionth of that.
JUMPED = 1e-6
TOUCHED = 1e-2
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
    """

    point: Point
    tangent: Direction
    values: Float[Array, "n_q"]
    converged: Bool[Array, ""]
    regular: Bool[Array, ""]
    cosine: Float[Array, ""]
    corrections: Int[Array, ""]

    @property
    def negative(self) -> int:
        """Number of critical values below zero."""
        return int(np.sum(np.asarray(self.values) < 0))

    @property
    def load(self) -> float:
        """Load factor, () [-]."""
        return float(self.point.load)


@jit
def _begin(topology: Topology, parameters: Parameters):
    ramp, point, tangent, scale, at, result = begin_path(topology, parameters)
    values = critical_values(topology, at, scale.sizes)
    found = result == RESULTS.successful
    step = Step(point, tangent, values, found, found, jnp.array(1.0), jnp.zeros((), jnp.int32))
    return ramp, scale, step, result


@jit
def _advance(topology: Topology, parameters: Parameters, ramp: Ramp, scale: Scale, begin, direction, length, plane):
    new = step_along(topology, parameters, ramp, scale, begin, direction, length, plane)
    values = critical_values(topology, new.at, scale.sizes)
    cosine = scale.weights @ (direction.x * new.tangent.x) + direction.load * new.tangent.load
    regular = new.at.transfer.regular
    return Step(new.point, new.tangent, values, new.converged, regular, cosine, new.corrections)


@jit
def _null(topology: Topology, parameters: Parameters, ramp: Ramp, scale: Scale, point: Point, shift):
    at = state(topology, parameters, ramp.at(point.load), point.x, point.near, strained=point.strained)
    phi, _ = null_vectors(topology, at, scale.sizes, shift)
    return direction_of(at, at.transfer.DFx @ phi, jnp.array(0.0))


class Walker:
    """The walk along one path: what has been found so far, and how to find the next.

    Attributes:
        parts: Topology and parameters.
        ramp: Load factors along the path.
        scale: What makes metres, radians and load comparable.
        code: Why the walk cannot begin, or successful.
        step: Largest change of the load factor in a step, () [-].
        steps: States found.
        critical: Critical points found.
    """

    def __init__(self, model: Model, step: float):
        self.parts = (model.topology, model.parameters)
        self.ramp, self.scale, first, result = _begin(*self.parts)
        self.code = RESULTS(int(result))
        self.step = step
        self.steps: list[Step] = [first]
        self.critical: list[CriticalPoint] = []

    def advance(self, begin: Point, direction: Direction, length, plane: Plane | None = None) -> Step:
        """One step from a point along a direction, corrected across it unless another plane is given."""
        plane = normal_to(self.scale, direction) if plane is None else plane
        return _advance(*self.parts, self.ramp, self.scale, begin, direction, jnp.asarray(length, float), plane)

    def longest(self, tangent: Direction) -> float:
        """Length within which neither the load nor the motion changes too much."""
        return min(self.step / max(abs(float(tangent.load)), 1e-300), LARGEST_MOTION / self.motion(tangent))

    def motion(self, direction: Direction) -> float:
        """Largest change of a coordinate, in extents and radians."""
        return float(np.max(np.abs(np.asarray(direction.x)) / np.asarray(self.scale.sizes), initial=1e-300))

    def zero(self, begin: Step, length: float, end: Step, value, jumped=JUMPED) -> tuple[float, Step] | None:
        """Where a value that changes sign on a step is zero, and the state there; None if it jumps."""
        low, high = 0.0, length
        f_low, f_high = value(begin), value(end)
        largest = max(abs(f_low), abs(f_high))
        best = (low, f_low, begin) if abs(f_low) < abs(f_high) else (high, f_high, end)
        w_low, w_high, side = f_low, f_high, 0
        failed = False
        for i in range(BISECTIONS):
            if abs(best[1]) <= 1e-6 * jumped * largest or high - low <= 1e-15 * length:
                break
            halve = failed or i % 4 == 3
            middle = low + (high - low) * (0.5 if halve else w_low / (w_low - w_high))
            new = self.advance(begin.point, begin.tangent, middle)
            if not bool(new.converged):
                if failed:
                    break
                failed = True
                continue
            failed = False
            f = value(new)
            best = min(best, (middle, f, new), key=lambda found: abs(found[1]))
            # The value of an end that stays twice is halved, so that both ends approach (Illinois).
            if (f > 0) == (f_low > 0):
                low, f_low, w_low = middle, f, f
                w_high, side = (w_high / 2 if side < 0 else f_high), -1
            else:
                high, f_high, w_high = middle, f, f
                w_low, side = (w_low / 2 if side > 0 else f_low), 1
        return (best[0], best[2]) if abs(best[1]) <= jumped * largest else None

    def cross(self, begin: Step, length: float, end: Step) -> list[tuple[float, Step, str, int]] | None:
        """Critical points on a step: length, state, kind, number of the critical value; None if the path jumps."""
        turns = (float(begin.tangent.load) > 0) != (float(end.tangent.load) > 0)
        low, high = sorted((begin.negative, end.negative))
        # On a branch that comes through a pitchfork the stiffness only touches zero, and the load turns back there. The
        # corrector is nearly singular around that point; the load is stationary, so that half the digits do. So it is
        # where several motions lose their stiffness at once.
        touched = low == high
        jumped = JUMPED if high - low == 1 else TOUCHED
        found = []
        for j in range(low, high):
            at = self.zero(begin, length, end, lambda s, j=j: float(s.values[j]), jumped)
            if at is None:
                return None
            found.append((*at, "bifurcation", j))
        if turns:
            turn = self.zero(begin, length, end, lambda s: float(s.tangent.load), jumped)
            if turn is None:
                return None
            if touched:
                found.append((*turn, "bifurcation", int(np.argmin(np.abs(turn[1].values)))))
            else:
                # At a limit point psi^T r_load is not zero, so that the load's rate vanishes with the stiffness.
                i = min(range(len(found)), key=lambda i: abs(found[i][0] - turn[0]))
                found[i] = (*turn, "limit", found[i][3])
        return sorted(found, key=lambda f: f[0])

    def finish(self, begin: Step, length: float, end: Step) -> tuple[float, Step] | None:
        """Where a step reaches load factor 1, and the state there."""
        reached = self.zero(begin, length, end, lambda s: s.load - 1.0)
        if reached is None:
            return None
        share, step = reached
        still = jax.tree.map(jnp.zeros_like, step.tangent)
        level = Plane(jnp.zeros_like(step.point.x), jnp.array(1.0))
        exact = self.advance(step.point._replace(load=jnp.array(1.0)), still, 0.0, level)
        return share, exact if bool(exact.converged) else step

    def name(self, begin: Step, at: Step, kind: str, j: int) -> Direction:
        """Add a critical point; returns the motion that meets no stiffness there."""
        shift = jnp.abs(begin.values[j]) * 1e-9
        phi = _null(*self.parts, self.ramp, self.scale, at.point, shift)
        self.critical.append(CriticalPoint(at.load, kind, np.asarray(at.point.x), np.asarray(phi.x)))
        return phi

    def branch(self, begin: Step, phi: Direction, sign: float) -> Step | None:
        """First step on the branch that leaves a bifurcation along a motion."""
        direction = unit(self.scale, jax.tree.map(lambda a: sign * a, phi))
        length = FIRST_ON_BRANCH / self.motion(direction)
        for _ in range(6):
            new = self.advance(begin.point, direction, length)
            if bool(new.converged) and float(new.cosine) > 0.5:
                return new
            length /= 4
        return None

    def walk(self, max_steps: int, switch: float) -> RESULTS:
        """Walk until load factor 1; the code says why the walk ended."""
        length, regular = np.inf, True
        smallest = SMALLEST_STEP * self.step
        while self.code == RESULTS.successful:
            if len(self.steps) > max_steps:
                return RESULTS.max_steps
            begin = self.steps[-1]
            length = min(length, self.longest(begin.tangent))
            if length < smallest:
                return RESULTS.not_converged if regular else RESULTS.singular_configuration
            short = 1.0 - begin.load - length * float(begin.tangent.load)
            if 0 <= short < 0.2 * length * float(begin.tangent.load):
                # No crumb is left before the end.
                length *= 1.25
            end = self.advance(begin.point, begin.tangent, length)
            regular = bool(end.regular)
            if not (bool(end.converged) and float(end.cosine) > SMALLEST_COSINE):
                length /= 4
                continue
            several = abs(end.negative - begin.negative) > 1
            if several and length > 1e-2 * self.step:
                length /= 2
                continue
            crossed = self.cross(begin, length, end)
            if crossed is None:
                length /= 4
                continue
            peaks = [f for f in crossed if f[2] == "limit" and f[1].load >= 1.0]
            last = None
            if end.load >= 1.0 or peaks:
                top = peaks[0] if peaks else (length, end)
                last = self.finish(begin, top[0], top[1])
                if last is None:
                    length /= 4
                    continue
            new = end if last is None else last[1]
            for s, at, kind, j in crossed:
                if last is not None and s > last[0]:
                    break
                phi = self.name(begin, at, kind, j)
                if switch and kind == "bifurcation":
                    new = self.branch(at, phi, switch)
                    if new is None:
                        return RESULTS.not_converged
                    switch, last = 0.0, None
                    break
            self.steps.append(new)
            if last is not None:
                return RESULTS.successful
            quick = int(end.corrections) <= 4 and float(end.cosine) > 0.98
            length *= 2.0 if quick else 1.0
        return self.code
