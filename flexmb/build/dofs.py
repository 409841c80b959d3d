"""Choose or check the degrees of freedom of a model, on concrete numbers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..checks.mobility import Constraints, allowed_motions, constraints, mobility_of
from ..errors import MechanismError, ModelError, warn
from ..math.subspace import above, determines, independent_rows, row_sizes
from ..model.by_name import TURN_OF, TURNS, turn_of
from ..model.model import MOTIONS, Entry, Model
from ..model.topology import HELD
from ..numerical_limits import CANNOT_MOVE, CLEARLY_INDEPENDENT, INDEPENDENT, TURNS_BACK
from .assemble import assemble
from .clamps import with_clamps
from .description import Description

# Most undetermined motions that a message names.
MOST_TOLD = 100


def complete_model(builder: Description, model: Model, dofs: str, release: str) -> Model:
    """Check a model, find degrees of freedom if none are named, release over-constraints on request.

    Raises MechanismError: see Builder.build.
    """
    if release == "auto":
        model, builder = _release_all(builder, model)
    # Constraints depend on numbers, not on roles: the completed model has the same ones.
    constraint_set = constraints(model)
    motions, over = allowed_motions(model, constraint_set)
    if over:
        report = mobility_of(model, constraint_set).report()
        raise MechanismError("overconstrained", f"The mechanism is over-constrained.\n{report}")
    if model.topology.n_q == 0 and dofs == "auto":
        builder = with_started(builder)
        started = assemble(builder) if builder.dofs else model
        x, e = choose(started, motions, named_rows(started, motions, constraint_set), constraint_set)
        model = _with_found(builder, [model.labels.x[i] for i in x], [model.labels.e[i] for i in e])
    else:
        model = _with_coefficients(builder, model, motions)
    _check_named(model, motions, constraint_set)
    return model


def _with_found(builder: Description, x: list[Entry], e: list[Entry]) -> Model:
    """The model of a builder with further degrees of freedom, which its labels name as found."""
    builder = builder.copy()
    for kind, entries in (("node", x), ("element", e)):
        for entry in entries:
            builder.dof(entry.of, entry.component, kind=kind)
    model = assemble(builder)
    return dataclasses.replace(model, labels=dataclasses.replace(model.labels, found=tuple(map(str, (*x, *e)))))


def with_started(builder: Description) -> Description:
    """A builder whose start values belong to degrees of freedom; unchanged if degrees of freedom are named."""
    if builder.dofs or not builder.starts:
        return builder
    twin = builder.copy()
    for kind, of, component in builder.starts:
        twin.dof(of, component, kind=kind)
    return twin


def check_inputs(model: Model, builder: Description | None = None) -> Model:
    """Refuse inputs that act on held things, and motions and reactions of things that are not held (ModelError).

    Args:
        model: Mechanism with its final roles.
        builder: Builder of the model. Its roles are used if the roles of the model are traced.
    """
    labels = model.labels
    if not labels.inputs and not labels.outputs:
        return model
    if builder is None:
        x_roles, e_roles = model.roles()
    else:
        owners = builder.nodes, builder.members
        x_roles, e_roles = ([role for entry in several.values() for role in entry.roles] for several in owners)
    for side, signals in (("Input", labels.inputs), ("Output", labels.outputs)):
        for s, part in [(whole, part) for whole in signals for part in whole.terms]:
            called = f"{side} '{s.name}'" + (f": its part '{part.name}'" if s.parts else "")
            kind = "deformation" if part.of_element else "coordinate" if part.axis is None else "rotation"
            owner = "" if part.of_element else labels.x[part.index].of
            end = part.index + (1 if part.axis is None else 4)
            roles = (e_roles if part.of_element else x_roles)[part.index : end]
            if part.quantity == "moment" and not part.local and any(role not in HELD for role in roles):
                # Hinges that turn or hold the rotation about this axis.
                turning = [e_roles[i] for i in labels.holding(f"{owner}.{TURNS[part.axis or 0]}")]
                roles = [role for role in turning if role in HELD] or roles[:1]
            free = next((role for role in roles if role not in HELD), None)
            moves = side == "Input" and part.quantity in MOTIONS
            if side == "Input" and free is None and not moves:
                raise ModelError(
                    f"{called} acts on a {kind} that is {roles[0].value}, so it has no effect. Let it act on a"
                    " coordinate that can move, make it a displacement, velocity or acceleration, or leave it out."
                )
            if free is not None and (part.quantity == "reaction" or moves):
                turn = "" if part.axis is None else turn_of(owner)
                has_hinge = any(turn == element for element, *_ in labels.elements)
                hint = f" Its rotation is deformation 1 of the element '{turn}'." if has_hinge else ""
                raise ModelError(
                    f"{called} is the {part.quantity} of a {kind} that is {free.value}, but it needs a FIXED or"
                    f" PRESCRIBED one.{hint or ' Fix or prescribe it, or leave this out.'}"
                )
    return model


def complete_series(builder: Description, model: Model) -> Model:
    """Make degrees of freedom of coefficients of spectral beams that named degrees of freedom leave undetermined.

    The model is assembled anew if there are such coefficients and nothing else is undetermined.
    """
    if not _coefficients(model):
        return model
    return _with_coefficients(with_started(with_clamps(builder, None)), model, allowed_motions(model)[0])


def _coefficients(model: Model) -> list[int]:
    """DEPENDENT coefficients of spectral beams with stiffness, and warpings of their ends, as indices in e."""
    released = set(np.asarray(model.topology.e.dependent).tolist())
    indices = []
    for block in model.topology.blocks:
        if block.element.fields and "stiffness" in block.companions:
            columns = [n - 1 for n in (*(n for field in block.element.fields for n in field), *block.element.measured)]
            indices += [i for i in np.asarray(block.e)[:, columns].ravel().tolist() if i in released]
    return indices


def _with_coefficients(builder: Description, model: Model, motions: Any) -> Model:
    """In a loop, whole strain fields may have the wrong number of coefficients: add single ones."""
    missing, candidates = motions.shape[1] - model.topology.n_q, _coefficients(model)
    if missing <= 0 or not candidates:
        return model
    rows = named_rows(model, motions)
    _, undetermined = independent_rows(rows, rows.shape[0], CANNOT_MOVE)
    effects = constraints(model).jacobian[candidates] @ motions
    chosen, _ = _independent(model, candidates, effects, undetermined, missing, rows.shape[0] > 0)
    if len(chosen) < missing:
        return model
    return _with_found(builder, [], [model.labels.e[i] for i in sorted(chosen)])


def _independent(
    model: Model, candidates: Sequence[int], effects: Any, undetermined: Any, count: int, beside: bool
) -> tuple[list[int], Any]:
    """Deformations that determine a mechanism with the named ones, and the projector onto undetermined motions.

    Found degrees of freedom stay zero unless something moves them. So elongations and shears of strain series come
    first beside named ones (``beside``). Of the rest, those that move least with the named ones are the most
    independent: what varies along a beam more than linearly. Without named ones, the most independent deformations suit
    all designs of a sweep. ``effects``: changes of the candidates in each motion, (m, f).
    """
    chosen: list[int] = []
    tiers = [np.arange(len(candidates))]
    if isinstance(effects, np.ndarray) and beside:
        tiers.insert(0, np.flatnonzero(np.isin(candidates, _stretches(model))))
    for i, tier in enumerate(tiers):
        least = INDEPENDENT if i == len(tiers) - 1 else CLEARLY_INDEPENDENT
        rows, remaining = independent_rows(effects[tier] @ undetermined, count - len(chosen), least)
        chosen += [int(candidates[tier[k]]) for k in rows]
        undetermined = undetermined @ remaining
    return chosen, undetermined


def _candidates(model: Model) -> np.ndarray:
    """DEPENDENT deformations that may become degrees of freedom.

    Displacements relative to the ground are coordinates already, or have a turning point. Hinges that only name a
    rotation come last, first their angles, then their tilts, which reach no further than half a turn.
    """
    released = np.asarray(model.topology.e.dependent)
    grounded = [np.ravel(block.e) for block in model.topology.blocks if block.element.grounded]
    released = np.setdiff1d(released, np.concatenate([*grounded, np.zeros(0, int)]))
    entries = [model.labels.e[i] for i in released]
    last = [entry.of.startswith(TURN_OF) * (1 + (entry.component > 1)) for entry in entries]
    return released[np.argsort(last, kind="stable")]


def _stretches(model: Model) -> np.ndarray:
    """Coefficients of elongations and shears, and warpings of ends."""
    indices = []
    for block in model.topology.blocks:
        fields = block.element.fields
        columns = [n - 1 for i in block.element.lengths if i < len(fields) for n in fields[i]]
        columns += [n - 1 for n in block.element.measured] if fields else []
        indices += np.asarray(block.e)[:, columns].ravel().tolist()
    return np.array(indices, int)


def named_rows(model: Model, motions: Any, found: Constraints | None = None) -> Any:
    """Changes of the named degrees of freedom in each motion, (n_q, f)."""
    by_deformation = (found or constraints(model)).jacobian[np.asarray(model.topology.e.dof)] @ motions
    return above(motions[np.asarray(model.topology.x.dof)], by_deformation)


def choose(model: Model, motions: Any, named: Any, found: Constraints | None = None) -> tuple[list[int], list[int]]:
    """Independent degrees of freedom, deformations first, as indices of coordinates and of deformations.

    For large mechanisms, with sparse motions, all free deformations if they determine the mechanism, as in chains and
    trees. Otherwise coordinates alone, since deformations are connected from end to end.

    Args:
        model: Mechanism; DEPENDENT entries may be chosen.
        motions: Scaled motions to be determined, (n_x, f).
        named: Changes of the named degrees of freedom, (n, f).
        found: Constraints of the model, if known.
    """
    topology = model.topology
    released = _candidates(model)
    first, undetermined = independent_rows(named, named.shape[0], CANNOT_MOVE)
    count = motions.shape[1] - len(first)
    # Rows of unit size: all deformations of an element matter alike, whatever their units.
    effects = (found or constraints(model)).jacobian[released] @ motions
    if not isinstance(motions, np.ndarray):
        effects = effects @ undetermined
        if effects.shape[0] == count == effects.shape[1] and determines(effects):
            return [], sorted(released.tolist())
        first = []
    else:
        first, undetermined = _independent(model, released.tolist(), effects, undetermined, count, named.shape[0] > 0)
    free = np.asarray(topology.x.dependent)
    effects = motions[free] @ undetermined
    if isinstance(motions, np.ndarray):
        # A rotation reaches further than a position, which turns back after a quarter of a turn.
        effects[[model.labels.x[i].kind == "position" for i in free]] /= TURNS_BACK
    second, _ = independent_rows(effects, count - len(first), 0.0)
    return [int(free[i]) for i in sorted(second)], sorted(first)


def _check_named(model: Model, motions: Any, constraint_set: Constraints) -> None:
    topology = model.topology
    ndof, named = motions.shape[1], topology.n_q
    sizes = row_sizes(named_rows(model, motions, constraint_set))
    names = model.q_labels
    stuck = [name for name, size in zip(names, sizes, strict=True) if size < CANNOT_MOVE]
    if stuck:
        raise MechanismError(
            "dof", f"Degree of freedom {', '.join(stuck)} cannot move in the undeformed mechanism. Name one that can."
        )
    if named > ndof:
        raise MechanismError(
            "dof",
            f"NDOF = {ndof}, but {named} degrees of freedom are named: {', '.join(names)}."
            " Name fewer, or release a deformation.",
        )
    missing = ndof - named
    if missing > MOST_TOLD:
        raise MechanismError(
            "underconstrained",
            f"NDOF = {ndof}, but {named} degrees of freedom are named. Name none, and build() finds all of them.",
        )
    independent, dependent = np.asarray(model.topology.e.given), np.asarray(model.topology.x.dependent)
    if not missing and not isinstance(motions, np.ndarray) and len(independent) == len(dependent):
        if determines(constraint_set.jacobian[independent][:, dependent]):
            return
    result = mobility_of(model, constraint_set)
    if missing > 0:
        raise MechanismError(
            "underconstrained",
            f"NDOF = {ndof}, but {named} degrees of freedom are named. Name {missing} more, or fix what should"
            f" not move.\n{result.report()}",
        )
    if result.underconstraints:
        raise MechanismError(
            "dof",
            f"The degrees of freedom {', '.join(names)} do not determine the rest of the mechanism.\n{result.report()}",
        )


def _release_all(builder: Description, model: Model) -> tuple[Model, Description]:
    builder = builder.copy()
    while (mobility := mobility_of(model, constraints(model))).overconstraints:
        for alternatives in mobility.candidates:
            if not alternatives:
                text = "Rigid elements alone are over-constrained. release='auto' does not release their deformations."
                raise MechanismError("overconstrained", f"{text}\n{mobility.report()}")
            proposal = alternatives[0]
            builder.release(proposal.of, proposal.component, kind=proposal.kind)
            if proposal.fails:
                warn(f"release='auto' releases {proposal.words}. This release loses rank near {proposal.fails}.")
        model = assemble(builder)
    return model, builder
