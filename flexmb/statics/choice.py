"""Whether a model is solved by sparse factors."""

from typing import Any

from ..math.linear_solver import DENSE, SPARSE, LinearSolver, asked_solver
from ..math.sparse import LARGE
from ..model.model import Model


def solver_for(model: Model, sparse: bool | None, solver: Any = None) -> LinearSolver:
    """Solver that a public function is asked for; unless one is, sparse factors where the model is large.

    Args:
        sparse, solver: What the public function was given.

    Raises:
        TypeError, ValueError: As of :func:`flexmb.math.linear_solver.asked_solver`.
    """
    return asked_solver(sparse, solver) or (SPARSE if model.topology.n_x >= LARGE else DENSE)


def by_sparse(model: Model, sparse: bool | None, solver: Any = None) -> bool:
    """Whether a model is solved in all coordinates; arguments as of :func:`solver_for`."""
    return solver_for(model, sparse, solver) != DENSE


def named(solver: Any) -> Any:
    """The same, for a function that takes no :class:`LinearSolver` but the two of this package.

    Raises:
        TypeError: It is another one.
    """
    if isinstance(solver, LinearSolver) and solver not in (SPARSE, DENSE):
        raise TypeError('Argument `solver` must be "sparse" or "dense" here: fm.equilibrium takes other solvers too.')
    return solver
