"""Equilibrium paths of large mechanisms, by sparse factors."""

from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..compilation.record import Record, static
from ..compilation.threads import one_thread
from ..display import Result
from ..model.by_name import ByName
from ..model.model import Model
from ..results import RESULTS
from ..statics.sparse import refuse_what_is_not_sparse
from .critical import CriticalPoint
from .over_load import OverLoad
from .sparse_walk import SparseEquations
from .stops import Stops
from .walk import Walker


class SparsePath(OverLoad, ByName, Result, Record):
    """Equilibria along a path of a large mechanism, steps first.

    Attributes:
        load_factor: Load factor, (steps,) [-].
        x: Nodal coordinates, (steps, n_x) [m, rad, -].
        e: Deformations, (steps, n_e) [m, rad].
        sigma: Stress resultants; for FIXED deformations the multiplier, (steps, n_e) [N, N m].
        critical_values: Those eigenvalues of the stiffness, in extents and radians, that are nearest to zero, four of
            them or all, ascending, (steps, n) [N m].
        negative: How many eigenvalues of the stiffness are negative, those that are not told too, (steps,).
        stable: Whether all eigenvalues are positive, (steps,).
        critical_points: Limit and bifurcation points in the order of the path.
        result: Code of RESULTS.
        model: The mechanism.
        stopped_by: Name of the condition of ``stop`` that ended the path; None where none did.
    """

    load_factor: Float[Array, "steps"]
    x: Float[Array, "steps n_x"]
    e: Float[Array, "steps n_e"]
    sigma: Float[Array, "steps n_e"]
    critical_values: Float[np.ndarray, "steps n"]
    negative: Int[np.ndarray, "steps"]
    stable: Bool[np.ndarray, "steps"]
    critical_points: tuple[CriticalPoint, ...]
    result: Int[Array, ""]
    model: Model
    stopped_by: str | None = static(default=None)
    one_axis = "load_factor"
    picture: ClassVar[str | None] = None


@one_thread()
def walk_of_sparse(
    model: Model, step: float, stops: Stops, max_steps: int, left: dict[int, int], report: Any
) -> tuple[SparsePath, Walker]:
    """Path of a mechanism by sparse factors, and the walk that found it.

    Args:
        model: As for :func:`sparse_equilibrium`.
        step: Largest change of the load factor in a step, () [-].
        stops: Where it ends.
        max_steps: Steps at most.
        left: Direction in which bifurcations are left, by their number from 1; what is used is taken out.
        report: Called with the number of steps and the load factor before each step.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`.
    """
    refuse_what_is_not_sparse(model.topology)
    equations = SparseEquations(model)
    walker = Walker(equations, step, stops)
    try:
        code = walker.walk(max_steps, left, report)
    except KeyboardInterrupt:
        if report is None:
            raise
        code = RESULTS.stopped
    points = [s.point for s in walker.steps]
    e = np.stack([point.strained for point in points])
    e[:, equations.held] = np.stack([point.near[equations.held] for point in points])
    values, below = np.stack([s.values for s in walker.steps]), np.array([int(s.below) for s in walker.steps])
    found = SparsePath(
        load_factor=jnp.asarray([s.load for s in walker.steps]),
        x=jnp.asarray(np.stack([point.x for point in points])),
        e=jnp.asarray(e),
        sigma=jnp.asarray(np.stack([equations.sigma(walker.ramp, point) for point in points])),
        critical_values=values,
        negative=below + np.sum(values < 0, axis=1),
        stable=np.all(values > 0, axis=1) & (below == 0),
        critical_points=tuple(walker.critical),
        result=jnp.asarray(int(code), jnp.int32),
        model=model,
        stopped_by=walker.ended or None,
    )
    return found, walker
