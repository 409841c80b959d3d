"""Whether a question about a linearised mechanism is answered with sparse or with dense matrices."""

from typing import Any

from ..arguments import check_flag
from ..mechanics.loads import lacks_potential
from ..model.model import Model, as_model
from ..statics.choice import by_sparse
from ..statics.equilibrium import load_factors_of
from .linearize import Linearization, ManyStates, Where
from .sparse_linearize import SparseLinearization, sparse_linearization
from .sparse_spectrum import asks_for_all


def is_large(model: Model) -> bool:
    """Whether a mechanism is large enough for sparse matrices to be quicker, and has a potential."""
    return by_sparse(model, None) and not lacks_potential(model.topology)


def few_of(given: Any, count: int | None) -> bool:
    """Whether so few of the modes of a model, or of its linearisation, are asked for that sparse matrices give them."""
    if count is None or not isinstance(given, Model):
        return count is not None
    topology = given.topology
    return not asks_for_all(count, topology.x.free.shape[0] - topology.e.held.shape[0])


def sparsely(
    given: Any, function: str, where: Where, sparse: bool | None, *, few: bool = True, throw: bool = True
) -> SparseLinearization | None:
    """What a public function is asked about, where sparse matrices are to answer; None where dense ones are.

    Args:
        given: Model, or its linearisation.
        function: Name of the public function.
        where: Which state.
        sparse: Whether to; None: where a mechanism is large.
        few: Whether so little is asked for that sparse matrices are worth it.
        throw: Whether a failure is an error, as it always is by sparse matrices.

    Raises:
        ValueError: ``sparse`` does not go with what is given, or ``at`` is of another model.
        AnalysisError: The equilibrium was not found.
    """
    if sparse is not None:
        check_flag("sparse", sparse)
    at: Any = where.at
    of_path = isinstance(at, ManyStates) and at.by_sparse
    if of_path or isinstance(at, SparseLinearization) or isinstance(given, SparseLinearization):
        if sparse is False:
            raise ValueError(f"fm.{function} is given a sparse linearisation, which sparse=False does not go with.")
        where.refuse(function, given=isinstance(given, Linearization | SparseLinearization))
        about: Any = given if at is None else where.state(as_model(given, function), function)
        return about
    if isinstance(given, Linearization) or where.at is not None:
        if sparse:
            raise ValueError(
                f"With `sparse` give fm.{function} a Model, or what fm.linearize(model, sparse=True) answers: dense"
                " matrices and states of a path or a motion stay dense."
            )
        return None
    model = as_model(given, function)
    if not (few and throw and by_sparse(model, None) if sparse is None else sparse):
        return None
    if not throw:
        raise ValueError(
            f"By sparse matrices fm.{function} always raises where it fails: leave `throw` or `sparse` out."
        )
    where.refuse(function)
    return sparse_linearization(model, load_factors_of(model, 1.0, where.increment, function))
