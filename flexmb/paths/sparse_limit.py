"""Limit load of large mechanisms: its first limit point by sparse factors, and the derivative of the load there."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..compilation.threads import one_thread
from ..math.derivative import jvp_of_varied
from ..mechanics.loads import LoadFactors
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.sparse import Balanced, lacking_at
from .sparse_walk import SparseEquations, as_arrays
from .stepper import LARGEST_MOTION, NO_LOAD, SHORTER, SMALLEST_STEP, Point, can_be_taken, next_length, normal_to
from .stops import Stops
from .walk import Walker

# Between states on either side of the limit point its load is known to this share: it is stationary there.
NEAR = 1e-9


class NumbersTraced(Exception):
    """Numbers are traced, and the search on the host asks for them."""


class _LimitPoint(NamedTuple):
    point: Point
    left: np.ndarray
    factors: LoadFactors
    result: RESULTS


def sparse_limit_load(model: Model, step: float, most: int) -> tuple[Any, Any]:
    """Load factor at the first limit point, NaN where none is found, and a code of RESULTS; differentiable once.

    Args:
        model: Mechanism, which needs no degrees of freedom.
        step: First step of the load factor, () [-].
        most: Steps to try.

    Raises:
        NumbersTraced: Numbers are traced by more than a derivative.

    Source:
        As :func:`flexmb.limit_load`, THEORY.md 7, eq. (7.10), in all coordinates and multipliers; the left null vector
        is that of the equations bordered by the plane of the last step.
    """

    def found_for(topology: Topology, parameters: Parameters) -> _LimitPoint:
        if not is_concrete((topology, parameters)):
            raise NumbersTraced
        # Known numbers stay so, though the rule of a derivative is traced around them.
        with one_thread(), jax.core.eval_context():
            return _limit_of(dataclasses.replace(model, topology=topology, parameters=parameters), step, most)

    @jax.custom_jvp
    def limit(topology: Topology, parameters: Parameters):
        return _told(found_for(topology, parameters))

    def changed(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
        found = found_for(*primals)
        (topology, _), (x, near, strained, _) = primals, found.point
        multipliers = strained[np.asarray(topology.e.held)]
        none: Any = np.array(0)
        at = Balanced(jnp.asarray(x), jnp.asarray(multipliers), jnp.asarray(near), none, none)

        def lacking(topology: Topology, parameters: Parameters):
            return lacking_at(topology, parameters, as_arrays(found.factors), jnp.asarray(near), at)

        _, change = jvp_of_varied(lacking, primals, tangents)
        no_change: Any = np.zeros((), jax.dtypes.float0)
        return _told(found), (-jnp.asarray(found.left) @ change, no_change)

    limit.defjvp(changed, symbolic_zeros=True)
    return limit(model.topology, model.parameters)


def _told(found: _LimitPoint) -> tuple[Any, Any]:
    good = found.result == RESULTS.successful
    return jnp.asarray(found.point.load if good else np.nan, float), jnp.asarray(int(found.result), jnp.int32)


def _limit_of(model: Model, first: float, most: int) -> _LimitPoint:
    """The limit point, and the left null vector of the equations there, of a product of one with their rate."""
    equations = SparseEquations(model, critical=False)
    walker = Walker(equations, first, Stops((), None, np.inf))
    (at,), length = walker.steps, first

    def failed(why: RESULTS) -> _LimitPoint:
        return _LimitPoint(at.point, np.full(len(equations.free) + len(equations.held), np.nan), ramp.base, why)

    ramp = walker.ramp
    if walker.code != RESULTS.successful:
        return failed(walker.code)
    for _ in range(most):
        load, rate = abs(float(at.point.load)), abs(float(at.tangent.load))
        length = min(length, LARGEST_MOTION / walker.motion(at.tangent), max(first, 0.1 * load) / rate)
        new, turn = walker.advance(at.point, at.tangent, length), None
        good = can_be_taken(new.converged, new.cosine)
        if good and new.tangent.load > 0:
            length, at = float(next_length(length, new.corrections, new.cosine)), new
            continue
        if good:
            turn = walker.zero(at, length, new, lambda step: float(step.tangent.load))
        if turn is not None and turn.uncertainty <= NEAR * max(first, load):
            if abs(float(turn.step.point.load)) < NO_LOAD:
                return failed(RESULTS.singular_stiffness)
            point, plane = turn.step.point, normal_to(walker.scale, at.tangent)
            return _LimitPoint(point, equations.left(ramp, point, plane), ramp.at(point.load), RESULTS.successful)
        length /= SHORTER
        if length < SMALLEST_STEP * first:
            return failed(RESULTS.not_converged)
    return failed(RESULTS.max_steps)
