"""The walk of large mechanisms: steps in all coordinates and one multiplier a constraint, by sparse factors."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..compilation.compile import jit
from ..errors import AnalysisError
from ..linear.spectrum import lowest_of_sparse
from ..math.sparse import SparseFactors
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, nodal_forces
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.newton import ACROSS_PATH, STEP_TOLERANCE
from ..statics.solve import held_values
from ..statics.sparse import balanced
from ..statics.tangent import Assembled, assemble, elastic_stress, unknowns
from .stepper import Direction, Plane, Point, Ramp, Scale, product, ramp_of, scale_of, unit
from .walk import Step

# Critical values that are followed: the lowest of those that are nearest to zero, among which are all negative ones.
FOLLOWED = 12


@jit
def _rates(topology: Topology, parameters: Parameters, factors: LoadFactors, rate: LoadFactors, x, strained):
    """Change with the load factor at a constant state: of nodal forces, of stress, and of what is held, x and e."""

    def at(load):
        own = LoadFactors(factors.initial + load * rate.initial, factors.increment + load * rate.increment)
        force = nodal_forces(topology, parameters, own, x)
        return force, elastic_stress(topology, parameters, own, strained), *held_values(topology, parameters, own)

    return jax.jvp(at, (jnp.zeros(()),), (jnp.ones(()),))[1]


@jit
def _held(topology: Topology, parameters: Parameters, factors: LoadFactors):
    return held_values(topology, parameters, factors)


@jit
def _deformations(topology: Topology, parameters: Parameters, x, near):
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
    told: Any = np.zeros(0), np.array(False), np.array(False), np.ones(()), np.array(0)
    return Step(point, _toward(0 * point.x, 0 * point.strained, 0.0), *told)


class _Tangent(NamedTuple):
    """Tangent of the equations at a state, bordered by the plane of a corrector.

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
    """

    def __init__(self, model: Model):
        self.parts = model.topology, model.parameters
        self.free, self.fast, self.held = (np.asarray(i) for i in unknowns(model.topology))
        self.sizes = np.asarray(sizes_of(*self.parts))

    def begin(self) -> tuple[Ramp, Scale, Step, Any]:
        """State at load factor zero, and the direction in which the path leaves it."""
        topology, parameters = self.parts
        ramp: Any = jax.device_get(ramp_of(topology, parameters))
        sizes: Any = self.sizes
        x, near, multipliers, code = np.asarray(parameters.reference), np.zeros(topology.n_e), 0.0, RESULTS.successful
        try:
            start = balanced(topology, parameters, ramp_of(topology, parameters).base)
            x, multipliers = np.asarray(start.x), np.asarray(start.multipliers)
            near = np.asarray(_deformations(topology, parameters, x, zero_near(topology)))
        except AnalysisError as fault:
            code = RESULTS[fault.code]
        strained = near.copy()
        strained[self.held] = multipliers
        point = _point(x, near, strained, np.zeros(()))
        if code != RESULTS.successful:
            return ramp, Scale(sizes, sizes), _failed(point), code
        tangent = self._tangent(ramp, point)
        rising: Any = np.zeros(topology.n_x), np.ones(())
        ahead, regular = self._direction(tangent, Plane(*rising))
        if not regular:
            # A hanging body has no stiffness without stress.
            return ramp, Scale(sizes, sizes), _failed(point), RESULTS.singular_stiffness
        scale: Any = jax.tree.map(np.asarray, scale_of(topology, parameters, jax.tree.map(jnp.asarray, ahead)))
        return ramp, scale, self._step(point, unit(scale, ahead), tangent.at), code

    def advance(self, ramp: Ramp, scale: Scale, begin: Point, direction: Direction, length: Any, plane: Plane) -> Step:
        """One step: predictor along a direction, then Newton's method in the plane through the predicted point."""
        length = float(length)
        start = Point(
            begin.x + length * direction.x,
            begin.near,
            begin.strained + length * direction.strained,
            begin.load + length * direction.load,
        )
        point, before, tries, done, bad = start, np.inf, 0, False, False
        while not (done or bad):
            tangent = self._tangent(ramp, point)
            distance = plane.x @ (point.x - start.x) + plane.load * (point.load - start.load)
            change, multipliers, load, regular = self._solve(tangent, plane, tangent.right, distance, tangent.shift)
            size = np.maximum(np.max(np.abs(change) / self.sizes, initial=0.0), abs(load))
            bad = bool(ACROSS_PATH.astray(size, before, tries)) or not regular
            if bad:
                break
            strained = tangent.at.e + tangent.at.jacobian @ change
            near = strained.copy()
            strained[self.held] = multipliers
            point = Point(point.x + change, near, strained, point.load + load)
            tries += 1
            done = size < STEP_TOLERANCE or bool(ACROSS_PATH.slow(size, before) and size <= ACROSS_PATH.round_off)
            before = size
        tangent = self._tangent(ramp, point)
        ahead, regular = self._direction(tangent, plane)
        fine = regular and not bad
        ahead = unit(scale, ahead) if fine else ahead
        return self._step(point, ahead, tangent.at, fine, float(product(scale, direction, ahead)), tries)

    def null(
        self, ramp: Ramp, scale: Scale, point: Point, shift: Any, beside: Direction
    ) -> tuple[Direction, Direction]:
        """Motion that meets no stiffness, and the direction normal to it that follows a rising load."""
        import scipy.sparse

        tangent = self._tangent(ramp, point)
        n, rest = len(self.free), len(self.held)
        weight = 1 / self.sizes[self.free] ** 2
        padded = scipy.sparse.block_diag([scipy.sparse.diags_array(float(shift) * weight), _nothing(rest)])
        factors = SparseFactors((tangent.at.tangent + padded).tocsc())
        other = beside.x[self.free]

        def normalised(v):
            square = other @ (weight * other)
            v = v - other * (other @ (weight * v)) / square if square > 0 else v
            motion = v / self.sizes[self.free]
            largest = np.max(np.abs(motion))
            return v / motion[int(np.argmax(np.abs(motion) > (1 - 1e-6) * largest))]

        phi, m = np.cos(np.arange(1.0, n + 1) ** 2) * self.sizes[self.free], np.zeros(rest)
        for _ in range(5):
            solved = factors.solve(np.concatenate([weight * phi, np.zeros(rest)]))
            phi, m = normalised(solved[:n]), solved[n:]
        border = np.concatenate([weight * phi, np.zeros(rest)])
        along = _bordered(tangent.at.tangent, border, border, 0.0, -tangent.by_load, 0.0)[0]
        moved = self._change(np.zeros(len(self.fast)), phi), self._change(tangent.following, along[:n])
        found = []
        for change, multipliers, load in zip(moved, (0 * m, along[n : n + rest]), (0.0, 1.0), strict=True):
            strained = tangent.at.jacobian @ change
            strained[self.held] = multipliers
            found.append(_toward(change, strained, load))
        return found[0], found[1]

    def sigma(self, ramp: Ramp, point: Point) -> Float[np.ndarray, "n_e"]:
        """Stress resultants at a state, multipliers among them [N, N m]."""
        found = np.array(elastic_stress(*self.parts, self._factors(ramp, point), jnp.asarray(point.strained)))
        found[self.held] = point.strained[self.held]
        return found

    def _factors(self, ramp: Ramp, point: Point) -> LoadFactors:
        return LoadFactors(*(jnp.asarray(factor, float) for factor in ramp.at(point.load)))

    def _tangent(self, ramp: Ramp, point: Point) -> _Tangent:
        """Equations and their derivatives at a state."""
        factors = self._factors(ramp, point)
        at = assemble(*self.parts, factors, point.x, point.near, self.sigma(ramp, point))
        rate = LoadFactors(*(jnp.asarray(factor, float) for factor in ramp.rate))
        rates = _rates(*self.parts, factors, rate, jnp.asarray(point.x), jnp.asarray(point.strained))
        force, stress, moving, growing = (np.array(one) for one in rates)
        stress[self.held] = 0.0
        wanted_x, wanted_e = (np.asarray(one) for one in _held(*self.parts, factors))
        following, shift = moving[self.fast], wanted_x[self.fast] - point.x[self.fast]
        right = (at.force - at.jacobian.T @ at.sigma)[self.free]
        right = np.concatenate([right, wanted_e[self.held] - at.e[self.held]]) - at.coupling @ shift
        by_load = np.concatenate([(at.jacobian.T @ stress - force)[self.free], -growing[self.held]])
        return _Tangent(at, by_load + at.coupling @ following, following, right, shift)

    def _change(self, fast: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Change of all coordinates."""
        change = np.zeros(len(self.sizes))
        change[self.free], change[self.fast] = free, fast
        return change

    def _solve(self, t: _Tangent, plane: Plane, right: np.ndarray, distance: Any, shift: np.ndarray):
        """Change of all coordinates, multipliers, change of the load factor, and whether the equations are regular."""
        n = len(self.free)
        row = np.concatenate([plane.x[self.free], np.zeros(len(self.held))])
        corner = float(plane.load) + plane.x[self.fast] @ t.following
        lacking = -(float(distance) + plane.x[self.fast] @ shift)
        z, load, regular = _bordered(t.at.tangent, t.by_load, row, corner, right, lacking)
        return self._change(shift + load * t.following, z[:n]), z[n:], load, regular

    def _direction(self, t: _Tangent, plane: Plane) -> tuple[Direction, bool]:
        """Tangent of the path on the side of the plane's normal, not of unit length."""
        nothing = np.zeros_like(t.shift)
        change, multipliers, load, regular = self._solve(t, plane, np.zeros_like(t.right), -1.0, nothing)
        strained = t.at.jacobian @ change
        strained[self.held] = multipliers
        return _toward(change, strained, load), regular

    def _step(self, point: Point, tangent: Direction, at: Assembled, fine=True, cosine=1.0, tries=0) -> Step:
        """A step's end with its critical values: those nearest to zero, ascending."""
        count = min(FOLLOWED, len(self.free) - len(self.held))
        values = self._critical(at) if fine else np.full(count, np.nan)
        told: Any = values, np.array(fine), np.array(fine), np.array(cosine), np.array(tries)
        return Step(point, tangent, *told)

    def _critical(self, at: Assembled) -> np.ndarray:
        import scipy.sparse

        weight = scipy.sparse.diags_array(1 / self.sizes[self.free] ** 2).tocsr()
        all_of = len(self.free) - len(self.held)
        count = kept = min(FOLLOWED, all_of)
        while True:
            if 2 * count >= all_of:
                return self._all_critical(at)[:kept]
            values = lowest_of_sparse(at.tangent, weight, count).values
            # On a path values become negative through zero: none is farther than those that were found, unless one of
            # the farthest is negative itself.
            farthest = values[np.argsort(np.abs(values))[-2:]]
            if np.all(farthest > 0):
                return values[:kept]
            count *= 2

    def _all_critical(self, at: Assembled) -> np.ndarray:
        """All of them by dense matrices: Lanczos iterations find a few of many."""
        import scipy.linalg

        n = len(self.free)
        whole = at.tangent.toarray()
        motions = scipy.linalg.null_space(whole[n:, :n] * self.sizes[self.free])
        stiffness = self.sizes[self.free, None] * whole[:n, :n] * self.sizes[self.free]
        return np.linalg.eigvalsh(motions.T @ stiffness @ motions)


def _nothing(size: int) -> Any:
    import scipy.sparse

    return scipy.sparse.csr_array((size, size))


def _bordered(matrix: Any, column: np.ndarray, row: np.ndarray, corner: Any, right: np.ndarray, last: Any):
    """Solution of [matrix, column; row, corner] (z, w) = (right, last), at limit points too, and whether it is one.

    Source:
        Govaerts 1991, Stable solvers and block elimination for bordered systems: the factors are those of the matrix,
        which may be nearly singular, since a border fills them.
    """
    factored = SparseFactors(matrix)
    if not factored.regular:
        return _bordered_whole(matrix, column, row, corner, right, last)
    left, across = factored.solve(row), factored.solve(column)
    by_left, by_across = corner - left @ column, corner - row @ across
    first = (last - left @ right) / by_left
    z = factored.solve(right - first * column)
    second = (last - corner * first - row @ z) / by_across
    z, w = z - second * across, first + second
    return z, float(w), bool(np.all(np.isfinite(z)) and np.isfinite(w))


def _bordered_whole(matrix: Any, column: np.ndarray, row: np.ndarray, corner: Any, right: np.ndarray, last: Any):
    """The same by factors of the whole, where the matrix alone has none."""
    import scipy.sparse

    pivots = np.abs(matrix.diagonal())
    pivots = pivots[pivots > 0]
    # Row and column are brought to the middle of the stiffnesses, for the choice of pivots.
    middle = float(np.exp(np.mean(np.log(pivots)))) if len(pivots) else 1.0
    by_row, by_column = (middle / max(float(np.max(np.abs(v))), 1e-300) for v in (np.append(row, corner), column))
    border = scipy.sparse.csc_array(np.asarray(by_column * column)[:, None])
    below = scipy.sparse.csc_array(np.append(by_row * row, by_row * by_column * corner)[None])
    factored = SparseFactors(scipy.sparse.vstack([scipy.sparse.hstack([matrix, border]), below]).tocsc())
    if not factored.regular:
        return np.zeros_like(right), 0.0, False
    z = factored.solve(np.append(right, by_row * last))
    return z[:-1], float(by_column * z[-1]), bool(np.all(np.isfinite(z)))
