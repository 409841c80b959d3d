"""The walk of large mechanisms: steps in all coordinates and one multiplier a constraint, by sparse factors."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..errors import AnalysisError
from ..math.bordered import Bordered
from ..math.linear import uneven
from ..math.sparse import SparseFactors
from ..mechanics.deformation import deformations
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, lacks_potential, nodal_forces
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.newton import ACROSS_PATH, STEP_TOLERANCE
from ..statics.solve import held_values
from ..statics.sparse import balanced
from ..statics.tangent import Assembled, assemble, elastic_stress, unknowns
from .sparse_critical import critical_values_of, shifted, value_of_determinant
from .stepper import Direction, Plane, Point, Ramp, Scale, length_of, product, ramp_of, scale_of, unit
from .walk import Step

# The factors of the last correction serve for the next one too if what that leaves will be this share of the tolerance.
LEFT = 0.1


@jit
def _at_load(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    rate: LoadFactors,
    x: Float[Array, "n_x"],
    strained: Float[Array, "n_e"],
):
    """Stress, and what is held, x and e; their change with the load factor at a constant state, and nodal forces'."""

    def at(load: Float[Array, ""]):
        own = LoadFactors(factors.initial + load * rate.initial, factors.increment + load * rate.increment)
        stress = elastic_stress(topology, parameters, own, strained)
        return stress, *held_values(topology, parameters, own), nodal_forces(topology, parameters, own, x)

    (stress, wanted_x, wanted_e, _), rates = jax.jvp(at, (jnp.zeros(()),), (jnp.ones(()),))
    return stress, wanted_x, wanted_e, *rates


@jit
def _deformations(topology: Topology, parameters: Parameters, x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
    return deformations(topology, parameters, x, near)


def _point(x: Any, near: Any, strained: Any, load: Any) -> Point:
    """A point of arrays of NumPy."""
    return Point(x, near, strained, load)


def _toward(x: Any, strained: Any, load: Any) -> Direction:
    """A direction of arrays of NumPy."""
    own: Any = np.array(load)
    return Direction(x, strained, own)


def _failed(point: Point) -> Step:
    """What stands for the first step of a walk that cannot begin."""
    told: Any = np.zeros(0), np.array(False), np.array(False), np.ones(()), np.array(0), np.array(0)
    return Step(point, _toward(0 * point.x, 0 * point.strained, 0.0), *told)


class _Tangent(NamedTuple):
    """Equations at a state, and their derivatives.

    Attributes:
        at: Matrices there.
        by_load: Derivative of the equations by the load factor, (n + h,).
        following: Change with the load factor of the coordinates that do not move by themselves, (n_fast,).
        right: What the equations lack, (n + h,).
        shift: How far those coordinates are from where they belong, (n_fast,).
    """

    at: Assembled
    by_load: np.ndarray
    following: np.ndarray
    right: np.ndarray
    shift: np.ndarray


class SparseEquations:
    """Equations in all coordinates, for a walk as :class:`flexmb.paths.walk.Equations`.

    Of the held deformations ``strained`` of a point holds the multipliers: they have no stress of their own.

    Attributes:
        model: Mechanism.
        parts: Its topology and its parameters.
        free: Coordinates that move.
        fast: Coordinates that do not.
        held: Deformations that are held.
        sizes: What coordinates are measured against.
        unsymmetric: Whether the tangent is not symmetric, of loads or laws without a potential.
    """

    def __init__(self, model: Model, critical: bool = True):
        """Prepare the walk.

        Args:
            model: Mechanism.
            critical: Whether critical values are found.
        """
        self.model, self.parts = model, (model.topology, model.parameters)
        self._tells = critical
        self.unsymmetric = lacks_potential(model.topology)
        self.free, self.fast, self.held = (np.asarray(i) for i in unknowns(model.topology))
        self.sizes = np.asarray(sizes_of(*self.parts))
        # Near to the motions of the critical values that were found last.
        self._soft = np.zeros(len(self.free))

    def begin(self) -> tuple[Ramp, Scale, Step, Any]:
        """State at load factor zero, and the direction in which the path leaves it."""
        topology, parameters = self.parts
        ramp: Any = jax.device_get(ramp_of(topology, parameters))
        sizes: Any = self.sizes
        x, near, multipliers, code = np.asarray(parameters.reference), np.zeros(topology.n_e), 0.0, RESULTS.successful
        try:
            start = balanced(topology, parameters, ramp_of(topology, parameters).base)
            x, multipliers = np.asarray(start.x), np.asarray(start.multipliers)
            near = np.asarray(_deformations(topology, parameters, x, start.near))
        except AnalysisError as fault:
            code = RESULTS[fault.code]
        strained = near.copy()
        strained[self.held] = multipliers
        point = _point(x, near, strained, np.zeros(()))
        if code != RESULTS.successful:
            return ramp, Scale(sizes, sizes), _failed(point), code
        tangent = self._tangent(ramp, point)
        rising: Any = np.zeros(topology.n_x), np.ones(())
        factored = tangent.at.factors()
        bordered = self._bordered(tangent, factored, Plane(*rising))
        if not bordered.regular:
            # A hanging body has no stiffness without stress.
            return ramp, Scale(sizes, sizes), _failed(point), RESULTS.singular_stiffness
        ahead = self._direction(tangent, bordered)
        scale: Any = jax.tree.map(np.asarray, scale_of(topology, parameters, jax.device_put(ahead)))
        values, below = self._critical(tangent.at, factored)
        told: Any = values, np.array(True), np.array(True), np.ones(()), np.array(0), np.array(below)
        return ramp, scale, Step(point, unit(scale, ahead), *told), code

    def advance(self, ramp: Ramp, scale: Scale, begin: Point, direction: Direction, length: Any, plane: Plane) -> Step:
        """One step: predictor along a direction, then Newton's method in the plane through the predicted point."""
        length = float(length)
        start = Point(
            begin.x + length * direction.x,
            begin.near,
            begin.strained + length * direction.strained,
            begin.load + length * direction.load,
        )
        point, tries, regular, done = self._corrected(ramp, start, plane)
        if not done:
            return _failed(point)._replace(regular=np.array(regular), corrections=np.array(tries))
        tangent = self._tangent(ramp, point)
        factored = tangent.at.factors()
        bordered = self._bordered(tangent, factored, plane)
        ahead = self._direction(tangent, bordered)
        if not (bordered.regular and np.isfinite(length_of(scale, ahead))):
            return _failed(point)._replace(regular=np.array(False), corrections=np.array(tries))
        ahead = unit(scale, ahead)
        values, below = self._critical(tangent.at, factored)
        cosine = np.array(product(scale, direction, ahead))
        told: Any = values, np.array(True), np.array(True), cosine, np.array(tries), np.array(below)
        return Step(point, ahead, *told)

    def _corrected(self, ramp: Ramp, start: Point, plane: Plane) -> tuple[Point, int, bool, bool]:
        """Point in a plane, corrections made, whether the equations were regular, and whether it was found."""
        point, before, bordered, leaves = start, np.inf, None, np.inf
        for tries in range(ACROSS_PATH.most):
            tangent = self._tangent(ramp, point)
            if bordered is None or not leaves < LEFT * STEP_TOLERANCE:
                bordered = self._bordered(tangent, tangent.at.factors(), plane)
                if not bordered.regular:
                    return point, tries, False, False
            distance = plane.x @ (point.x - start.x) + plane.load * (point.load - start.load)
            z, load = bordered.solve(tangent.right, -float(distance + plane.x[self.fast] @ tangent.shift))
            change = self._change(tangent.shift + load * tangent.following, z)
            size = np.maximum(np.max(np.abs(change) / self.sizes, initial=0.0), abs(load))
            if bool(ACROSS_PATH.astray(size, before, tries)):
                return point, tries, True, False
            near = tangent.at.e + tangent.at.deformed(change)
            strained = near.copy()
            strained[self.held] = point.strained[self.held] + z[len(self.free) :]
            point = Point(point.x + change, near, strained, point.load + load)
            if size < STEP_TOLERANCE or bool(ACROSS_PATH.slow(size, before) and size <= ACROSS_PATH.round_off):
                return point, tries + 1, True, True
            # Newton's method leaves c size^2 of a correction, and factors that are one correction old c size of that.
            leaves, before = (size / before**2) ** 2 * size**3 if np.isfinite(before) else np.inf, size
        return point, ACROSS_PATH.most, True, False

    def null(
        self, ramp: Ramp, scale: Scale, point: Point, shift: Any, beside: Direction
    ) -> tuple[Direction, Direction]:
        """Motion that meets no stiffness, and the direction normal to it that follows a rising load."""
        tangent = self._tangent(ramp, point)
        n, rest, sizes = len(self.free), np.zeros(len(self.held)), self.sizes[self.free]
        factors = shifted(tangent.at.tangent, float(shift), sizes)
        other, weight = beside.x[self.free], 1 / sizes**2

        def normalised(v: np.ndarray):
            square = other @ (weight * other)
            v = v - other * (other @ (weight * v)) / square if square > 0 else v
            motion = v / sizes
            largest = np.max(np.abs(motion))
            return v / motion[int(np.argmax(np.abs(motion) > (1 - 1e-6) * largest))]

        phi, m = uneven(n, 1) * sizes, rest
        psi = phi
        for _ in range(5):
            solved = factors.solve(np.concatenate([weight * phi, rest]))
            phi, m = normalised(solved[:n]), solved[n:]
            if self.unsymmetric:
                psi = normalised(factors.solve(np.concatenate([weight * psi, rest]), transposed=True)[:n])
        # Regular with both, however nearly right and left null vector are normal to each other.
        row, column = (np.concatenate([weight * v, rest]) for v in (phi, psi if self.unsymmetric else phi))
        bordered = Bordered(tangent.at.tangent, tangent.at.factors(), column, row, 0.0)
        along, _ = bordered.solve(-tangent.by_load, 0.0)
        still = self._change(np.zeros(len(self.fast)), phi)
        loaded = self._change(tangent.following, along)
        return self._toward(tangent, still, 0 * m, 0.0), self._toward(tangent, loaded, along[n:], 1.0)

    def left(self, ramp: Ramp, point: Point, plane: Plane) -> Float[np.ndarray, "r"]:
        """Of [y, w] with [0, 1] = [y, w] [K, r_load; plane]: at a limit point w is zero, and y the left null vector.

        Args:
            plane: Across the path.
        """
        tangent = self._tangent(ramp, point)
        return self._bordered(tangent, tangent.at.factors(), plane).left()

    def sigma(self, ramp: Ramp, point: Point) -> Float[np.ndarray, "n_e"]:
        """Stress resultants at a state, multipliers among them [N, N m]."""
        found = np.array(
            elastic_stress(*self.parts, as_arrays(ramp.at(point.load)), jax.device_put(self._strained(point)))
        )
        found[self.held] = point.strained[self.held]
        return found

    def _strained(self, point: Point) -> np.ndarray:
        """Deformations that the stress is of, where elements couple held ones with others too, (n_e,) [m, rad]."""
        found = np.array(point.strained)
        found[self.held] = point.near[self.held]
        return found

    def _tangent(self, ramp: Ramp, point: Point) -> _Tangent:
        """Equations and their derivatives at a state."""
        factors, rate = as_arrays(ramp.at(point.load)), as_arrays(ramp.rate)
        found = _at_load(*self.parts, factors, rate, jax.device_put(point.x), jax.device_put(self._strained(point)))
        sigma, wanted_x, wanted_e, by_stress, moving, growing, by_force = (np.array(one) for one in found)
        sigma[self.held], by_stress[self.held] = point.strained[self.held], 0.0
        at = assemble(*self.parts, factors, point.x, point.near, sigma)
        following, shift = moving[self.fast], wanted_x[self.fast] - point.x[self.fast]
        balancing = at.sigma.copy()
        balancing[self.held] = point.strained[self.held]
        lacking, rising = at.force - at.pulled(balancing), at.pulled(by_stress) - by_force
        right = np.concatenate([lacking[self.free], wanted_e[self.held] - at.e[self.held]])
        by_load = np.concatenate([rising[self.free], -growing[self.held]])
        moved = np.stack([shift, following], axis=1)
        if np.any(moved):
            motions = np.zeros((len(self.sizes), 2))
            motions[self.fast] = moved
            by_shift, by_following = at.forces_of(motions).T
            right, by_load = right - by_shift, by_load + by_following
        return _Tangent(at, by_load, following, right, shift)

    def _change(self, fast: np.ndarray, solved: np.ndarray) -> np.ndarray:
        """Change of all coordinates, from that of those that do not move by themselves and what was solved for."""
        change = np.zeros(len(self.sizes))
        change[self.free], change[self.fast] = solved[: len(self.free)], fast
        return change

    def _bordered(self, t: _Tangent, factored: SparseFactors, plane: Plane) -> Bordered:
        """Equations for a change of the free coordinates, the multipliers and the load factor, with a plane."""
        row = np.concatenate([plane.x[self.free], np.zeros(len(self.held))])
        corner = float(plane.load) + float(plane.x[self.fast] @ t.following)
        if plane.stiffness:
            factored = shifted(t.at.tangent, float(plane.stiffness), self.sizes[self.free])
        return Bordered(t.at.tangent, factored, t.by_load, row, corner)

    def _direction(self, t: _Tangent, bordered: Bordered) -> Direction:
        """Tangent of the path on the side of the plane's normal, not of unit length."""
        z, load = bordered.solve(np.zeros_like(t.right), 1.0)
        return self._toward(t, self._change(load * t.following, z), z[len(self.free) :], load)

    def _toward(self, t: _Tangent, change: np.ndarray, multipliers: np.ndarray, load: float) -> Direction:
        """Direction of a change of the coordinates, deformations to first order."""
        strained = t.at.deformed(change)
        strained[self.held] = multipliers
        return _toward(change, strained, load)

    def _critical(self, at: Assembled, factored: SparseFactors) -> tuple[np.ndarray, int]:
        """Critical values nearest to zero, ascending, and how many more are negative."""
        if not self._tells:
            return np.zeros(0), 0
        find = value_of_determinant if self.unsymmetric else critical_values_of
        found = find(at.tangent, factored, self.sizes[self.free], self._soft, at)
        self._soft = found.start
        return found.values, found.below


def as_arrays(given: LoadFactors) -> LoadFactors:
    """Load factors as arrays of JAX."""
    return LoadFactors(*jax.device_put([np.asarray(factor, float) for factor in given]))
