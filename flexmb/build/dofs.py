"""Choose or check the degrees of freedom of a model, on concrete numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.mobility import constraints, mobility
from ..errors import MechanismError
from ..math.subspace import independent_rows, null_spaces
from ..model.model import Model
from .assemble import assemble

if TYPE_CHECKING:
    from .builder import Builder

# What must be left of a candidate once those already chosen are taken out, of 1.
INDEPENDENT = 1e-5
CANNOT_MOVE = 1e-7


def complete(builder: Builder, model: Model, dofs: str, release: str) -> Model:
    """Check a model, find degrees of freedom where none are named, release over-constraints on request.

    Args:
        builder: Builder of the model; not changed.
        model: Assembled model.
        dofs: "auto" or "named".
        release: "auto" or "none".

    Returns:
        The model, assembled anew where roles have changed.

    Raises:
        MechanismError: See Builder.build.
    """
    if release == "auto":
        model, builder = _release_all(builder, model)
    motions, over = _motions(model)
    if over:
        raise MechanismError("overconstrained", f"The mechanism is over-constrained.\n{mobility(model).report()}")
    if model.topology.n_q == 0 and dofs == "auto":
        builder = builder.copy()
        for kind, of, component in _choose(model, motions):
            builder.dof(of, component, kind=kind)
        return assemble(builder)
    _check_named(model, motions)
    return model


def _motions(model: Model) -> tuple[np.ndarray, int]:
    """Scaled motions that the constraints alone allow, (n_x, f), and the number of over-constraints."""
    found, topology = constraints(model), model.topology
    held = np.concatenate([np.asarray(topology.e.fixed), np.asarray(topology.e.prescribed)])
    free = np.concatenate([np.asarray(topology.x.dependent), np.asarray(topology.x.dof)])
    rank, _, right = null_spaces(found.jacobian[np.ix_(held, free)])
    motions = np.zeros((topology.n_x, right.shape[1]))
    motions[free] = right
    return motions, len(held) - rank


def _choose(model: Model, motions: np.ndarray) -> list[tuple[str, str, int]]:
    """Independent deformations first, then coordinates, in the order of the model."""
    topology, wanted = model.topology, motions.shape[1]
    released = np.asarray(topology.e.dependent)
    # Two end nodes' worth of deformations of one element matter alike, whatever their units: rows are of unit size.
    effects = constraints(model).jacobian[released] @ motions
    first, rest = independent_rows(effects, wanted, INDEPENDENT)
    free = np.asarray(topology.x.dependent)
    second, _ = independent_rows(motions[free] @ rest, wanted - len(first), 0.0)
    chosen_e = [("element", model.labels.e[released[i]]) for i in sorted(first)]
    chosen_x = [("node", model.labels.x[free[i]]) for i in sorted(second)]
    return [(kind, entry.of, entry.component) for kind, entry in chosen_x + chosen_e]


def _check_named(model: Model, motions: np.ndarray) -> None:
    topology = model.topology
    ndof, named = motions.shape[1], topology.n_q
    rows = [motions[i] for i in np.asarray(topology.x.dof)]
    rows += list(constraints(model).jacobian[np.asarray(topology.e.dof)] @ motions)
    names = model.q_labels
    stuck = [name for name, row in zip(names, rows, strict=True) if np.linalg.norm(row) < CANNOT_MOVE]
    if stuck:
        raise MechanismError(
            "dof",
            f"Degree of freedom {', '.join(stuck)} cannot move in the undeformed mechanism. Name one that does.",
        )
    if named > ndof:
        raise MechanismError(
            "dof",
            f"NDOF = {ndof}, but {named} degrees of freedom are named: {', '.join(names)}."
            " Name fewer, or release a deformation.",
        )
    found = mobility(model)
    if named < ndof:
        raise MechanismError(
            "underconstrained",
            f"NDOF = {ndof}, but {named} degrees of freedom are named. Name {ndof - named} more, or fix what should"
            f" not move.\n{found.report()}",
        )
    if found.underconstraints:
        raise MechanismError(
            "dof",
            f"The degrees of freedom {', '.join(names)} do not determine the rest of the mechanism.\n{found.report()}",
        )


def _release_all(builder: Builder, model: Model) -> tuple[Model, Builder]:
    builder = builder.copy()
    while (found := mobility(model)).overconstraints:
        proposal = found.release[0]
        if proposal is None:
            raise MechanismError("overconstrained", f"No release removes an over-constraint.\n{found.report()}")
        builder.release(*proposal)
        model = assemble(builder)
    return model, builder
