"""Choice between dense matrices and sparse factors."""

from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..math.linear_solver import DENSE, SPARSE, LinearSolver, asked_solver
from ..math.sparse import LARGE
from ..model.model import Model
from ..model.topology import Topology

# Least number of coordinates, and of coordinates per bandwidth, from which sparse matrices solve an equilibrium of a
# chain faster than dense; and the most bandwidth of a chain.
LONG, LINKS, WIDEST = 120, 11, 16


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
