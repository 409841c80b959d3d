"""Equilibrium paths of large mechanisms, by sparse factors."""

from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..compilation.record import Record, static
from ..display import Labelled
from ..linear.linearize import DENSE, Linearization, about_state, moving_element_matrices
from ..linear.sparse_poles import is_steady
from ..mechanics.inertia import InertialLoad
from ..model.by_name import ByName
from ..model.model import Model
from ..questions.question import Along
from ..results import RESULTS
from ..statics.sparse import acting
from .critical import CriticalPoint
from .over_load import OverLoad
from .sparse_walk import SparseEquations
from .stepper import factors_at
from .walk import Step, Walker

# Attributes of dense paths and linearisations.
OF_DENSE = (*DENSE, "matrices", "eigenvalues", "frequencies", "multipliers", "iterations", "symmetric", "moving")


class SparsePath(OverLoad, ByName, Along, Labelled, Record):
    """Equilibria along a path of a large mechanism, steps as first axis.

    It answers as :class:`flexmb.paths.Path` does: frequencies, modes, compliance, stress, responses and state spaces of
    its states. It has no matrices in the degrees of freedom, and not all frequencies at each step.

    Attributes:
        load_factor: Load factor, (steps,) [-].
        x: Nodal coordinates, (steps, n_x) [m, rad, -].
        e: Deformations, (steps, n_e) [m, rad].
        sigma: Stress resultants; for FIXED deformations the multiplier, (steps, n_e) [N, N m].
        felt: Gravity, distributed along the elements.
        reactions: Forces of the supports, (steps, n_x) [N, N m].
        external: Loads except weight, plus reactions, (steps, n_x) [N, N m].
        critical_values: Up to four eigenvalues of the stiffness, in extents and radians, nearest to zero, ascending,
            (steps, n) [N m]. Without a potential their smallest modulus, with the sign of the determinant, (steps, 1).
        negative: Number of negative eigenvalues of the stiffness, (steps,); without a potential whether the determinant
            is negative, 1 or 0.
        stable: Whether all eigenvalues are positive, (steps,). Without a potential there are two conditions. The
            determinant is positive. The eight eigenvalues of stiffness and mass nearest to zero are real and positive;
            with damping instead, the sixteen nearest poles do not grow (flutter).
        critical_points: Limit and bifurcation points in the order of the path.
        critical_states: The states there, as a path in the same order, or None.
        result: Code of RESULTS.
        model: The mechanism, with its imperfections.
        stopped_by: Name of the condition of ``stop`` that ended the path, or None.
    """

    load_factor: Float[Array, "steps"]
    x: Float[Array, "steps n_x"]
    e: Float[Array, "steps n_e"]
    sigma: Float[Array, "steps n_e"]
    felt: InertialLoad
    reactions: Float[Array, "steps n_x"]
    external: Float[Array, "steps n_x"]
    critical_values: Float[np.ndarray, "steps n"]
    negative: Int[np.ndarray, "steps"]
    stable: Bool[np.ndarray, "steps"]
    critical_points: tuple[CriticalPoint, ...]
    critical_states: "SparsePath | None"
    result: Int[Array, ""]
    model: Model
    stopped_by: str | None = static(default=None)
    one_axis = "load_factor"
    picture: ClassVar[str | None] = "path"
    by_sparse: ClassVar[bool] = True

    def __getattr__(self, name: str) -> Any:
        if name in OF_DENSE:
            raise AttributeError(
                f"A path by sparse matrices has no {name}. Use one state, as in path.linearization(-1) or"
                " fm.frequencies(model, count=3, at=path, step=-1), or give fm.path(model, sparse=False)."
            )
        raise AttributeError(f"A SparsePath has no {name}.")

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization:
        """Linearised equations of motion about one step, element by element.

        Args:
            step: Number of the step, from 0; by default the last.
            time: None; a path has no times.

        Raises:
            IndexError: There are fewer steps.
            ValueError: A time is given.
        """
        chosen = self.step_of(step, time)
        rows = self.x, self.e, self.sigma, self.felt, self.reactions, self.external
        at = jax.device_put(jax.tree.map(lambda states: np.asarray(states)[chosen], rows))
        zero = jnp.zeros((), jnp.int32)
        return about_state(self.model, self.factors(chosen), (*at, zero, zero))

    def linearizations(self) -> Any:
        """Raise TypeError: a large mechanism is linearised about one state at a time."""
        raise TypeError(
            "A large mechanism is linearised about one state at a time. Use path.linearization(step), or give"
            " fm.path(model, sparse=False)."
        )

    def at_critical_points(self) -> "SparsePath":
        """Critical points as states of a path, in their order.

        Raises:
            ValueError: There are none.
        """
        self.check_critical()
        return self if self.critical_states is None else self.critical_states


def _states_at(equations: SparseEquations, steps: list[Step], critical: bool = False) -> dict[str, Any]:
    """Attributes of a path for steps of its walk; ``critical`` points are not stable."""
    topology, parameters = equations.parts
    points = [s.point for s in steps]
    x, e = np.stack([point.x for point in points]), np.stack([point.strained for point in points])
    sigma = np.stack([equations.sigma(point) for point in points])
    states = [(factors_at(parameters, point.load), *at) for point, *at in zip(points, x, e, sigma, strict=True)]
    forces = [acting(topology, parameters, *at) for at in states]
    felt, reactions, external = jax.tree.map(lambda *a: jax.device_put(np.stack(a)), *forces)
    values, below = np.stack([s.values for s in steps]), np.array([int(s.below) for s in steps])
    stable = np.all(values > 0, axis=1) & (below == 0) & (not critical)
    if equations.unsymmetric:
        for i in np.flatnonzero(stable):
            stable[i] = is_steady(moving_element_matrices(topology, parameters, *states[i]))
    return dict(
        load_factor=jax.device_put(np.array([s.load for s in steps])),
        x=jax.device_put(x),
        e=jax.device_put(e),
        sigma=jax.device_put(sigma),
        felt=felt,
        reactions=reactions,
        external=external,
        critical_values=values,
        negative=below + np.sum(values < 0, axis=1),
        stable=stable,
    )


def path_of(
    equations: SparseEquations, walker: Walker, steps: list[Step], code: RESULTS = RESULTS.successful
) -> SparsePath:
    """The path of a walk, with some of its states and the reason for its end."""
    shared: dict[str, Any] = {
        "critical_points": tuple(walker.critical),
        "result": jax.device_put(np.int32(code)),
        "model": equations.model,
    }
    critical_path = None
    if walker.critical_steps:
        critical = _states_at(equations, walker.critical_steps, critical=True)
        critical_path = SparsePath(**critical, **shared, critical_states=None)
    states = _states_at(equations, steps)
    return SparsePath(**states, **shared, critical_states=critical_path, stopped_by=walker.ended or None)
