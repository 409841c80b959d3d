"""The state of an analysis: an equilibrium or a given state, in the degrees of freedom or element by element."""

import dataclasses
from typing import Any, NamedTuple

import jax
import numpy as np

from ..arguments import differs_beyond_round_off, is_concrete, require_double_precision
from ..display import kind_of
from ..math.linear_solver import DENSE, SPARSE, LinearSolver
from ..mechanics.loads import load_factors_of
from ..model.model import Model, as_determined, as_model
from ..results import check
from ..statics.equilibrium import Equilibrium
from ..statics.solver_choice import by_sparse
from .linearize import Linearization, ManyStates, linearized_about, linearized_by_elements, linearized_by_freedoms

# Numbers of a material that do not affect a state.
BEARS = frozenset({"strength", "fatigue"})


class Where(NamedTuple):
    """State of a mechanism that a public function is asked about; all None for the equilibrium.

    Attributes:
        at: Equilibrium, Linearization, Path or Motion of the model.
        step: Number of a state of a path or a motion.
        time: Time of a state of a motion [s].
        increment: Factor of the incremental loads of an equilibrium [-].
    """

    at: Any = None
    step: int | None = None
    time: float | None = None
    increment: float | None = None

    def refuse(self, function: str, *, given: bool = False) -> None:
        """Raise ValueError for arguments that exclude each other; `given`: a linearisation replaces the model."""
        for name, value in (("step", self.step), ("time", self.time)):
            if value is not None and not isinstance(self.at, ManyStates):
                raise ValueError(f"Argument `{name}` of fm.{function} needs at=, a path or a motion.")
        stated = "at=" if self.at is not None else "a linearisation" if given else ""
        if self.increment is not None and stated:
            raise ValueError(f"Argument `increment` of fm.{function} contradicts {stated}, which has its loads.")
        if given and self.at is not None:
            raise ValueError(
                f"fm.{function} got a linearisation and `at`. Give the model and `at`, or only the linearisation."
            )

    def state(self, model: Model, function: str) -> Linearization:
        """Linearised equations about the state that ``at`` names; raise TypeError or ValueError for a wrong ``at``."""
        at = self.at
        if isinstance(at, ManyStates):
            states = at.states()
            if self.step is None and self.time is None:
                also = ", or its time=" if states.kind == "motion" else ""
                raise ValueError(
                    f"Argument `at` of fm.{function} is a {type(at).__name__} with {len(states.x)} states. Choose one"
                    f" by step=, such as step=-1 for the last{also}."
                )
            at = at.linearization(self.step, self.time)
        if isinstance(at, Equilibrium):
            check_state(at, model, function)
            return linearized_about(model, at, function)
        if not isinstance(at, Linearization):
            raise TypeError(
                f"Argument `at` of fm.{function} must be an Equilibrium, a Path, a Motion or a Linearization of the"
                f" model, not {kind_of(at)}."
            )
        check_state(at, model, function)
        return at


def _key(entry: Any) -> str:
    return str(getattr(entry, "name", getattr(entry, "key", "")))


def check_state(at: Any, model: Model, function: str) -> None:
    """Raise ValueError for a state of another model, by its names or known numbers, also under ``jax.grad``.

    TypeError for a known state of a model with traced numbers: its derivative would be zero.

    Loads and strains may differ, as those of a path's steps and imperfections do.
    """
    of_state = getattr(at, "model", None) or getattr(at, "asked_of", None)
    if of_state is model:
        return
    labels = model.labels
    if (at.labels.x, at.labels.elements) != (labels.x, labels.elements):
        raise ValueError(
            f"Argument `at` of fm.{function} belongs to another model: its nodes or elements have other names."
        )
    if of_state is None:
        return
    numbers = [(source.parameters.reference, source.parameters.properties) for source in (of_state, model)]
    (ours, shape), (theirs, their_shape) = (jax.tree_util.tree_flatten_with_path(part) for part in numbers)
    pairs = [(a, b) for (path, a), (_, b) in zip(ours, theirs, strict=False) if not BEARS.intersection(map(_key, path))]
    if shape != their_shape or any(np.any(differs_beyond_round_off(*pair)) for pair in pairs):
        raise ValueError(
            f"Argument `at` of fm.{function} belongs to a model with other dimensions. Give that model, or a state of"
            " this model."
        )
    if any(is_concrete(a) and not is_concrete(b) for a, b in pairs):
        raise TypeError(
            f"Argument `at` of fm.{function} has known numbers, but the numbers of the model are traced, as under"
            " jax.grad and jax.jit: the answer would not follow them. Compute the state from the traced model, such as"
            " at=fm.linearize(model)."
        )


def linearized(given: Any, function: str, throw: bool = True, where: Where | None = None) -> Linearization:
    """Linearization in the degrees of freedom for a public function: ``given`` itself, or computed from a model."""
    require_double_precision()
    where = where or Where()
    is_linearized = isinstance(given, Linearization)
    where.refuse(function, given=is_linearized and not given.large)
    if is_linearized and given.large:
        raise TypeError(f"fm.{function} accepts no sparse linearisation. Give fm.linearize(model), which is dense.")
    if where.at is not None:
        given = where.state(as_model(given, function), function)
        if given.large:
            instead = "fm.path(model, sparse=False)" if where.at is not given else "fm.linearize(model)"
            raise TypeError(f"fm.{function} accepts no sparse linearisation. Give {instead}, which is dense.")
    if not isinstance(given, Linearization):
        model = as_determined(given, function)
        return linearized_by_freedoms(model, load_factors_of(model, 1.0, where.increment, function), throw)
    if given.matrices.M0.ndim > 2:
        raise ValueError(
            f"fm.{function} needs the linearisation of one state, but this is along a motion, at"
            f" {len(given.matrices.M0)} times. Give lin.at_time(0)."
        )
    if is_concrete(given.matrices.result):
        check(given.matrices.result, throw)
    return given


def by_elements(
    given: Any, function: str, where: Where, solver: LinearSolver | None, *, few: bool = True, throw: bool = True
) -> Linearization | None:
    """Linearization for sparse matrices; None if dense matrices answer.

    Without a ``solver``, a large mechanism has sparse factors if ``few`` and ``throw``: ``few`` states that they are
    worth it, ``throw`` that a failure raises an error, as it always does with sparse matrices.
    """
    at, is_linearized = where.at, isinstance(given, Linearization)
    of_path = isinstance(at, ManyStates) and at.by_sparse
    if of_path or any(isinstance(argument, Linearization) and argument.large for argument in (at, given)):
        if solver == DENSE:
            raise ValueError(f"fm.{function} got a sparse linearisation, which contradicts sparse=False.")
        where.refuse(function, given=is_linearized)
        about: Any = given if at is None else where.state(as_model(given, function), function)
        if solver in (None, about.solver):
            return about
        return Linearization(dataclasses.replace(about.matrices, solver=solver), about.model)
    if isinstance(at, Equilibrium) and solver != DENSE and (solver or (few and throw and by_sparse(given, None))):
        where.refuse(function)
        model = as_model(given, function)
        check_state(at, model, function)
        return linearized_about(model, at, function, solver=solver or SPARSE)
    if is_linearized or at is not None:
        if solver not in (None, DENSE):
            raise ValueError(
                f"With `sparse` give fm.{function} a Model, or fm.linearize(model, sparse=True). Dense matrices and"
                " states of a path or a motion stay dense."
            )
        return None
    model = as_model(given, function)
    if solver == DENSE or (solver is None and not (few and throw and by_sparse(model, None))):
        return None
    if not throw:
        raise ValueError(
            f"With sparse matrices fm.{function} always raises if it fails. Leave `throw` or `sparse` out."
        )
    where.refuse(function)
    target = load_factors_of(model, 1.0, where.increment, function)
    return linearized_by_elements(model, target, solver=solver or SPARSE)


def asked_about(
    given: Any, function: str, where: Where | None = None, solver: LinearSolver | None = None, *, few: bool = True
) -> Linearization:
    """Linearization for a public function, by elements or in the degrees of freedom."""
    where = where or Where()
    large = by_elements(given, function, where, solver, few=few)
    return linearized(given, function, where=where) if large is None else large
