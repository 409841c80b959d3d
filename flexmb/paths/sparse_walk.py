"""Continuation for large mechanisms: steps in all coordinates and one multiplier per constraint, by sparse factors."""

import functools
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.host import call_host
from ..compilation.threads import one_thread
from ..errors import AnalysisError
from ..math.bordered import Bordered
from ..math.element_matrices import AssembledEquations, ElementMatrices
from ..math.indices import put
from ..math.linear import uneven
from ..math.sparse import on_host_thread
from ..mechanics.loads import lacks_potential, nodal_forces
from ..mechanics.prepared import kernel
from ..model.model import Model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import LARGEST_ALIKE
from ..results import RESULTS
from ..statics.newton_search import Iterate, prescribed_values
from ..statics.sparse import TurnInCoordinates, balanced, elements_times
from ..statics.tangent import Assembled, elastic_stress, unknowns
from .sparse_critical import critical_values_of, shifted, value_of_determinant
from .stepper import Direction, Move, Plane, Point, Predictor, Scale, factors_at, step_along
from .walk import Step, begin_at, unloaded_point


class InCoordinates:
    """:class:`flexmb.paths.stepper.PathEquations` in coordinates that move, and multipliers.

    Attributes:
        by_load: Derivative of the equations by the load factor, (n + h,).
    """

    reuses: ClassVar[bool] = True

    def __init__(self, topology: Topology, parameters: Parameters, point: Point):
        (free, fast, constrained), x, strained = unknowns(topology), point.x, point.strained

        def at_load(load: Float[Array, ""]):
            factors = factors_at(parameters, load)
            stress = elastic_stress(topology, parameters, factors, strained)
            force = nodal_forces(topology, parameters, factors, x)
            return *prescribed_values(topology, parameters, factors), stress, force

        (*prescribed, _, _), (moving, growing, by_stress, by_force) = jax.jvp(at_load, (point.load,), (jnp.ones(()),))
        trial = Iterate(x, point.near, strained, point.multipliers)
        factors = factors_at(parameters, point.load)
        self._turn = turn = TurnInCoordinates(topology, parameters, factors, trial, prescribed)
        self.last, self.e, self.onto, self.deformed = turn.last, turn.e, turn.onto, turn.deformed
        self.following = put(jnp.zeros(topology.n_x), fast, moving[fast])
        rising = elements_times(topology.n_x, turn.transposed, put(by_stress, constrained, 0.0)) - by_force
        by_state = jnp.concatenate([rising[free], -growing[constrained]])
        self.by_load = by_state + turn.forces_of(self.following)

    def bordering(self, plane: Plane) -> tuple[Array, Array, Array, Array]:
        """Column, row and corner of the border, and the added stiffness."""
        row = jnp.concatenate([plane.x[self.last.free], jnp.zeros(len(self.last.held))])
        corner = plane.load + plane.x @ self.following
        return self.by_load, row, corner, jnp.asarray(plane.stiffness, float)

    def move(self, factored: Any, plane: Plane, sizes: Any, share: Any, distance: Any, idle: Any) -> Move:
        """See :class:`flexmb.paths.stepper.PathEquations`."""
        right, n = share * self._turn.right, self.last.unknowns[0]
        shapes = tuple(jax.ShapeDtypeStruct(*like) for like in ((right.shape, float), ((), float), ((), np.int32)))
        host = functools.partial(on_host_thread, _move)
        z, load, failure = call_host(host, shapes, factored, self.bordering(plane), right, -distance, idle)
        return Move(self._turn.spread(z[:n]), z[n:], load, failure)


def _bordered(elements: ElementMatrices, border: tuple[Any, ...]) -> Bordered:
    """Factors of the bordered equations, by NumPy and SciPy alone."""
    assembled, (column, row, corner, stiffness) = AssembledEquations(elements), border
    tangent = assembled.at()
    if stiffness:
        factored = shifted(tangent, float(stiffness), elements.sizes[elements.free])
    else:
        factored = assembled.factors(tangent)
    return Bordered(tangent, factored, column, row, float(corner))


def _move(elements: ElementMatrices, border: tuple[Any, ...], right: Any, last: Any, idle: Any):
    """Solution of the bordered equations and a code of RESULTS, by NumPy and SciPy alone."""
    why = RESULTS.successful
    if not idle:
        why = RESULTS.singular_configuration
        try:
            bordered = _bordered(elements, border)
            if bordered.regular:
                z, load = bordered.solve(right, float(last))
                return z, np.array(load), np.array(RESULTS.successful, np.int32)
        except AnalysisError as fault:
            why = RESULTS[fault.code]
    return np.full_like(right, np.nan), np.array(np.nan), np.array(why, np.int32)


def _left_null(elements: ElementMatrices, border: tuple[Any, ...]) -> tuple[np.ndarray]:
    bordered = _bordered(elements, border)
    return (bordered.left() if bordered.regular else np.full_like(border[0], np.nan),)


def left_null_vector(topology: Topology, parameters: Parameters, point: Point, plane: Plane) -> Float[Array, "r"]:
    """Vector y of [0, 1] = [y, w] [K, r_load; plane]: at a limit point w is zero, and y the left null vector."""
    at = InCoordinates(topology, parameters, point)
    like = (jax.ShapeDtypeStruct(at.by_load.shape, float),)
    known = jax.lax.stop_gradient((at.last, at.bordering(plane)))
    return call_host(functools.partial(on_host_thread, _left_null), like, *known)[0]


@kernel
def _step(topology: Topology, parameters: Parameters, scale: Scale, predictor: Predictor):
    return step_along(InCoordinates, topology, parameters, scale, predictor)


@kernel
def _at(topology: Topology, parameters: Parameters, point: Point):
    """Element matrices at a state, derivatives by the load factor of the equations and of following coordinates."""
    at = InCoordinates(topology, parameters, point)
    return at.last, at.by_load, at.following


class SparseEquations:
    """:class:`flexmb.paths.walk.WalkEquations` in all coordinates.

    Attributes:
        parts: Topology and parameters.
        free: Coordinates that move.
        held: Held deformations.
        unsymmetric: Whether loads or laws have no potential.
    """

    def __init__(self, model: Model):
        self.model, self.parts = model, (model.topology, model.parameters)
        self.unsymmetric = lacks_potential(model.topology)
        self.free, _, self.held = (np.asarray(i) for i in unknowns(model.topology))
        self.sizes = np.asarray(coordinate_scales(*self.parts))
        # Near the motions of the last critical values.
        self._soft = np.zeros(len(self.free))

    def begin(self) -> tuple[Scale, Step, Any]:
        """See :class:`flexmb.paths.walk.WalkEquations`."""
        code, start = RESULTS.singular_stiffness, unloaded_point(*self.parts, len(self.held))
        try:
            at = jax.device_get(balanced(*self.parts, factors_at(self.model.parameters, 0.0)))
            start = start._replace(x=at.x, near=at.near, strained=at.near, multipliers=at.multipliers)
            begin = begin_at(self, start)
            if begin is not None:
                return begin
        except AnalysisError as fault:
            code = RESULTS[fault.code]
        # A hanging body has no stiffness without stress.
        still = Direction(0 * start.x, 0 * start.strained, 0 * start.load, 0 * start.multipliers)
        assessment: Any = np.zeros(0), np.array(False), np.array(False), np.ones(()), np.array(0), np.array(0)
        sizes: Any = self.sizes
        return Scale(sizes, sizes), Step(start, still, *assessment), code

    def advance(self, scale: Scale, predictor: Predictor) -> Step:
        """See :class:`flexmb.paths.walk.WalkEquations`."""
        new: Any = jax.device_get(_step(*self.parts, scale, predictor))
        if new.failure == RESULTS.out_of_memory:
            raise AnalysisError(RESULTS.out_of_memory.name, RESULTS.out_of_memory.message)
        values, below, regular = np.zeros(0), 0, np.asarray(new.failure == RESULTS.successful)
        if new.converged:
            with one_thread():
                find = value_of_determinant if self.unsymmetric else critical_values_of
                values, below, self._soft = on_host_thread(_critical, find, new.at, self._soft)
        assessment: Any = values, new.converged, regular, new.cosine, new.corrections, np.array(below)
        return Step(new.point, new.tangent, *assessment)

    def null(self, scale: Scale, point: Point, shift: Any, beside: Direction) -> tuple[Direction, Direction]:
        """See :class:`flexmb.paths.walk.WalkEquations`."""
        elements, by_load, following = jax.device_get(_at(*self.parts, point))
        return on_host_thread(self._null, elements, by_load, following, float(shift), beside)

    def _null(self, elements: ElementMatrices, by_load: Any, following: Any, shift: float, beside: Direction):
        at = Assembled(elements)
        n, zeros, sizes = len(self.free), np.zeros(len(self.held)), self.sizes[self.free]
        factors = shifted(at.tangent, shift, sizes)
        other, weight = beside.x[self.free], 1 / sizes**2

        def normalised(v: np.ndarray):
            square = other @ (weight * other)
            v = v - other * (other @ (weight * v)) / square if square > 0 else v
            motion = v / sizes
            largest = np.max(np.abs(motion))
            return v / motion[int(np.argmax(np.abs(motion) > (1 - LARGEST_ALIKE) * largest))]

        def direction(change: np.ndarray, multipliers: np.ndarray, load: float) -> Direction:
            parts: Any = change, at.deformed(change), np.array(load), multipliers
            return Direction(*parts)

        phi, m = uneven(n, 1) * sizes, zeros
        psi = phi
        for _ in range(5):
            solved = factors.solve(np.concatenate([weight * phi, zeros]))
            phi, m = normalised(solved[:n]), solved[n:]
            if self.unsymmetric:
                psi = normalised(factors.solve(np.concatenate([weight * psi, zeros]), transposed=True)[:n])
        # Regular with both null vectors, even if they are almost normal to each other.
        row, column = (np.concatenate([weight * v, zeros]) for v in (phi, psi if self.unsymmetric else phi))
        solved, _ = Bordered(at.tangent, at.factors(), column, row, 0.0).solve(-by_load, 0.0)
        still, loaded = np.zeros(len(self.sizes)), np.array(following)
        still[self.free], loaded[self.free] = phi, solved[:n]
        return direction(still, 0 * m, 0.0), direction(loaded, solved[n:], 1.0)

    def sigma(self, point: Point) -> Float[np.ndarray, "n_e"]:
        """Stress resultants at a state, multipliers included [N, N m]."""
        factors = factors_at(self.model.parameters, point.load)
        stress = np.array(elastic_stress(*self.parts, factors, point.strained))
        stress[self.held] = point.multipliers
        return stress


def _critical(find: Any, elements: ElementMatrices, start: np.ndarray) -> tuple[np.ndarray, int, np.ndarray]:
    """Critical values nearest to zero, number of further negative ones, and the start for the next state."""
    at = Assembled(elements)
    return find(at.tangent, at.factors(), elements.sizes[elements.free], start, at)[:3]
