"""The choice of a solver: dense or sparse matrices, by the arguments of a public function or the size of the model."""

from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..arguments import check_flag, short_repr
from ..errors import ModelError, warn
from ..math.linear_solver import DENSE, SOLVERS, SPARSE, LinearSolver
from ..mechanics.loads import lacks_potential
from ..model.model import Model
from ..model.topology import Topology

# Mechanisms with at least this number of coordinates use sparse factors by default. For static loads on a rack, dense
# matrices take equal time at 170 coordinates, four times as long at 270, and 25 times as long at 500.
LARGE = 300
# Least number of coordinates, and of coordinates per bandwidth, from which sparse matrices solve an equilibrium of a
# chain faster than dense; and the most bandwidth of a chain.
LONG, LINKS, WIDEST = 120, 11, 16
# Above this number of motions, sparse matrices do not compute all.
MANY = 2000


def asked_solver(sparse: Any, solver: Any) -> LinearSolver | None:
    """Return the solver that ``solver`` or ``sparse`` selects; None if the size of the model decides."""
    if sparse is not None:
        check_flag("sparse", sparse)
    by_flag = None if sparse is None else (SPARSE if sparse else DENSE)
    if solver is None:
        return by_flag
    if isinstance(solver, str):
        if solver not in SOLVERS:
            raise ValueError(f'Argument `solver` must be "sparse" or "dense", but is {short_repr(solver)}.')
        chosen: Any = SOLVERS[solver]
    elif isinstance(solver, LinearSolver):
        chosen = solver
    else:
        raise TypeError(f'Argument `solver` must be "sparse", "dense" or a LinearSolver, but is {short_repr(solver)}.')
    if sparse is not None and bool(sparse) != (chosen != DENSE):
        raise ValueError(
            f"Arguments `solver` and `sparse` contradict each other: sparse={sparse}. Give `solver` alone."
        )
    return chosen


def solver_for(model: Model, sparse: bool | None, solver: Any) -> LinearSolver:
    """Solver of a public function; by default sparse factors for a large model."""
    return asked_solver(sparse, solver) or (SPARSE if model.topology.n_x >= LARGE else DENSE)


def by_sparse(model: Model, sparse: bool | None, solver: Any = None) -> bool:
    """Whether a model is solved in all coordinates."""
    return solver_for(model, sparse, solver) != DENSE


def known_solver(solver: Any) -> Any:
    """The solver, for a function that accepts no :class:`LinearSolver` but the two of this package; else TypeError."""
    if isinstance(solver, LinearSolver) and solver not in (SPARSE, DENSE):
        raise TypeError('Argument `solver` must be "sparse" or "dense" here. fm.equilibrium accepts other solvers too.')
    return solver


def is_long_chain(topology: Topology) -> bool:
    """Whether sparse matrices solve an equilibrium although the mechanism is not large: its matrices are narrow."""
    if topology.n_x < LONG or any("force" in block.companions for block in topology.blocks):
        return False
    elements = [np.asarray(block.x) for block in topology.blocks]
    pairs = [(np.repeat(x, x.shape[1], axis=1).ravel(), np.tile(x, x.shape[1]).ravel()) for x in elements]
    rows, columns = (np.concatenate(side) for side in zip(*pairs, strict=True))
    joined = csr_array((np.ones(len(rows)), (rows, columns)), shape=(topology.n_x, topology.n_x))
    free = np.asarray(topology.x.free)
    graph = joined[free][:, free]
    place = np.argsort(reverse_cuthill_mckee(graph, symmetric_mode=True))
    rows, columns = graph.nonzero()
    bandwidth = int(np.max(np.abs(place[rows] - place[columns]), initial=0))
    return bandwidth <= WIDEST and len(free) > LINKS * bandwidth


def is_large(model: Model) -> bool:
    """Whether a mechanism has a potential and is large enough for sparse matrices to be faster."""
    return by_sparse(model, None) and not lacks_potential(model.topology)


def few_of(given: Any, count: int | None) -> bool:
    """Whether the number of modes wanted is small enough for sparse matrices."""
    if count is None or not isinstance(given, Model):
        return count is not None
    return not asks_for_all(count, _motions_of(given))


def _motions_of(model: Model) -> int:
    """Number of motions that the constraints leave, the largest possible number of modes."""
    return model.topology.x.free.shape[0] - model.topology.e.held.shape[0]


def up_to(count: int, model: Model) -> int:
    """The number of modes wanted, or the number of motions of a model if that is smaller; at least 1."""
    return max(min(count, _motions_of(model)), 1)


def warn_of_fewer(function: str, count: int | None, answers: int, what: str) -> None:
    """Warn of fewer answers than the ``count`` wanted. ``what`` is their name, such as "frequencies"."""
    if count is not None and answers < count:
        warn(f"Argument `count` of fm.{function} is {count}, but the mechanism has fewer {what}: {answers}.")


def asks_for_all(count: int, every: int, many: int = MANY) -> bool:
    """Whether too many of all eigenvalues are wanted for sparse matrices."""
    return 3 * count >= every > many


def refuse_all(count: int, every: int, what: str, many: int = MANY) -> None:
    """Raise ModelError if :func:`asks_for_all`. ``what`` is the name of the answers, such as "frequencies"."""
    if asks_for_all(count, every, many):
        raise ModelError(
            f"Argument `count` = {count}: sparse matrices give few of the {every} {what}, not all. Ask for fewer, or"
            " give sparse=False and a model with degrees of freedom."
        )
