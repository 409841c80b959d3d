"""Choice between dense matrices and sparse factors."""

from typing import Any

from ..math.linear_solver import DENSE, SPARSE, LinearSolver, asked_solver
from ..math.sparse import LARGE
from ..model.model import Model


def solver_for(model: Model, sparse: bool | None, solver: Any) -> LinearSolver:
    """Solver of a public function; by default sparse factors for a large model."""
    return asked_solver(sparse, solver) or (SPARSE if model.topology.n_x >= LARGE else DENSE)


def by_sparse(model: Model, sparse: bool | None, solver: Any = None) -> bool:
    """Whether a model is solved in all coordinates."""
    return solver_for(model, sparse, solver) != DENSE


def named(solver: Any) -> Any:
    """The solver, for a function that accepts no :class:`LinearSolver` but the two of this package; else TypeError."""
    if isinstance(solver, LinearSolver) and solver not in (SPARSE, DENSE):
        raise TypeError('Argument `solver` must be "sparse" or "dense" here. fm.equilibrium accepts other solvers too.')
    return solver
