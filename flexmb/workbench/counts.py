"""Degrees of freedom, over- and under-constraints of a drawing, also of an unfinished one."""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..build.builder import Builder
from ..checks.mobility import Mobility, mobility
from ..display import counted
from ..errors import MechanismError, ModelError, first_line, heard
from ..model.model import Model
from ..model.topology import HELD

# Number of names in a message.
LISTED = 4


@dataclasses.dataclass(frozen=True)
class Part:
    """Nodes that elements join: names of nodes with a position, names of elements, and whether anything is held."""

    nodes: tuple[str, ...]
    elements: tuple[str, ...]
    held: bool


@dataclasses.dataclass(frozen=True)
class Count:
    """Counts of a drawing, and what they mean.

    Attributes:
        status: "ok", "empty", "loose" (something floats), "overconstrained", "underconstrained", "both", "dof" (named
            degrees of freedom do not fit) or "failed".
        message: What to know, and what to do.
        numbers: nx, ne, nxo, neo and ndof = nx - nxo - neo.
        over: Number of states of self-stress, or None if unknown.
        under: Number of undetermined motions, or None if unknown.
        dofs: Names of the degrees of freedom.
        model: Checked model, or None.
        drawn: Model for the picture, also if it is not valid; None without elements.
        mobility: Mobility of a model that is not valid.
        parts: Connected parts.
        warnings: Warnings of the Builder.
    """

    status: str
    message: str
    numbers: dict[str, int]
    over: int | None = None
    under: int | None = None
    dofs: tuple[str, ...] = ()
    model: Model | None = None
    drawn: Model | None = None
    mobility: Mobility | None = None
    parts: tuple[Part, ...] = ()
    warnings: tuple[str, ...] = ()

    def message_data(self) -> dict[str, Any]:
        """Contents of a message to pages; shares belong to the elements in each state of self-stress."""
        shares = [] if self.mobility is None else [dict(pairs) for pairs in self.mobility.states().shares or ()]
        return {
            **self.numbers,
            "over": self.over,
            "under": self.under,
            "status": self.status,
            "message": self.message,
            "dofs": list(self.dofs),
            "shares": shares,
            "warnings": list(self.warnings),
        }


def quick_numbers(builder: Builder) -> dict[str, int]:
    """Numbers of NDOF = NX - NXO - NEO from the roles alone, without compiling."""
    if builder.members and (model := _unchecked(builder)) is not None:
        return model.counts()
    nx = nxo = 0
    for node in builder.nodes.values():
        n_constrained = sum(role in HELD for role in node.roles)
        nx += node.kind.freedoms
        nxo += min(n_constrained, node.kind.freedoms)
    visible = [member for member in builder.members.values() if not member.hidden]
    ne = sum(len(member.roles) for member in visible)
    neo = sum(role in HELD for member in visible for role in member.roles)
    return {"nx": nx, "ne": ne, "nxo": nxo, "neo": neo, "ndof": nx - nxo - neo}


def count(builder: Builder) -> Count:
    """Count the degrees of freedom of a drawing, and find over- and under-constraints."""
    parts = tuple(_parts(builder))
    if not builder.nodes:
        return Count("empty", "Nothing is drawn yet. Add a node.", quick_numbers(builder))
    if not any(not member.hidden for member in builder.members.values()):
        nodes_text = counted(sum(len(part.nodes) for part in parts), "node")
        message = f"{nodes_text}, and no element between them. Add an element between two nodes."
        return Count("empty", message, quick_numbers(builder), parts=parts)
    with heard() as warnings:
        try:
            model = builder.build()
        except MechanismError as fault:
            return _invalid(builder, fault, parts)
        except ModelError as fault:
            return Count("failed", str(fault), quick_numbers(builder), parts=parts, drawn=_unchecked(builder))
    faults, named = _loose_sentences(parts), tuple(model.q_labels)
    message = " ".join(faults) or f"{counted(len(named), 'degree')} of freedom, and no over-constraint."
    known: dict[str, Any] = {"over": 0, "under": 0, "dofs": named, "model": model, "drawn": model, "parts": parts}
    known["warnings"] = tuple(dict.fromkeys(warnings))
    return Count("loose" if faults else "ok", message, model.counts(), **known)


def _unchecked(builder: Builder) -> Model | None:
    """An unchecked model for the picture; None if there is none."""
    try:
        return builder.build(check=False)
    except ModelError:
        return None


def _invalid(builder: Builder, fault: MechanismError, parts: tuple[Part, ...]) -> Count:
    """Count of a mechanism that is over- or under-constrained, or whose degrees of freedom do not fit."""
    model = builder.build(check=False)
    model_mobility = mobility(model)
    faults, over = _loose_sentences(parts), model_mobility.overconstraints
    if over:
        stressed = list(dict.fromkeys(share.of for i in range(over) for share in model_mobility.stresses(i)))
        faults.append(f"Over-constrained: {counted(over, 'state')} of self-stress in {_listed(stressed)}.")
        faults.append(_release_sentence(model_mobility))
    if fault.code != "overconstrained" or not over:
        faults.append(first_line(fault))
    # Without named degrees of freedom the Builder finds them: no motion is left undetermined.
    under = model_mobility.underconstraints if builder.dofs else 0
    status = "both" if over and under else "overconstrained" if over else "underconstrained" if under else fault.code
    known: dict[str, Any] = {"dofs": tuple(model.q_labels), "drawn": model, "mobility": model_mobility, "parts": parts}
    return Count(status, " ".join(faults), model.counts(), over, under, **known)


def _release_sentence(model_mobility: Mobility) -> str:
    """Sentence on deformations and supports to release."""
    releases = [state_candidates[0].words for state_candidates in model_mobility.candidates if state_candidates]
    if not releases:
        return "Only rigid elements take part. Replace one by a flexible or a pinned one."
    n_rigid_only = len(model_mobility.release) - len(releases)
    more = f" {counted(n_rigid_only, 'state')} more involve only rigid elements." if n_rigid_only else ""
    return f"Release {', and '.join(releases)}.{more}"


def _loose_sentences(parts: Iterable[Part]) -> list[str]:
    """Sentences about nodes that nothing joins, and about parts that float."""
    parts = list(parts)
    alone = [part.nodes[0] for part in parts if part.nodes and not part.elements]
    floating = [part for part in parts if part.elements and not part.held]
    sentences = []
    if alone:
        are, them = ("are", "them") if len(alone) > 1 else ("is", "it")
        joined = f"{_listed(alone, 'node')} {are} joined to nothing"
        sentences.append(f"{joined}: join {them} by an element, or delete {them}.")
    if floating and len(floating) == sum(bool(part.elements) for part in parts):
        sentences.append("Nothing is fixed: the mechanism floats. Fix a node.")
    elif floating:
        names = [name for part in floating for name in part.elements]
        float_, them = ("float", "them") if len(names) > 1 else ("floats", "it")
        sentences.append(f"{_listed(names, 'element')} {float_}: nothing joins {them} to a support.")
    return sentences


def _listed(names: list[str], kind: str = "") -> str:
    """The first names, in words."""
    quoted = [f"'{name}'" for name in names[:LISTED]]
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    several = ", ".join(quoted) + more if more or len(quoted) < 2 else f"{', '.join(quoted[:-1])} and {quoted[-1]}"
    if not kind:
        return several
    return f"{kind.capitalize()}{'s' if len(names) > 1 else ''} {several}"


def _parts(builder: Builder) -> list[Part]:
    """Connected parts, in the order in which nodes were added."""
    index = {name: i for i, name in enumerate(builder.nodes)}
    owners = {name: name.removesuffix(".rotation").removesuffix(".warping") for name in index}
    pairs = [(index[owner], index[name]) for name, owner in owners.items() if owner in index]
    pairs += [(index[m.nodes[0]], index[node]) for m in builder.members.values() for node in m.nodes[1:]]
    first, second = np.array(pairs, int).reshape(-1, 2).T
    graph = coo_array((np.ones(len(pairs)), (first, second)), (len(index), len(index)))
    count, labels = connected_components(graph, directed=False)
    part_of = dict(zip(index, labels.tolist(), strict=True))
    nodes, elements, constrained = ([[] for _ in range(count)] for _ in range(3))
    for name, node in builder.nodes.items():
        if node.kind.part == "position":
            nodes[part_of[name]].append(name)
        is_place = node.kind.part in ("position", "rotation")
        constrained[part_of[name]].append(is_place and any(role in HELD for role in node.roles))
    for name, member in builder.members.items():
        if not member.hidden and member.nodes:
            elements[part_of[member.nodes[0]]].append(name)
    return [Part(tuple(nodes[k]), tuple(elements[k]), any(constrained[k])) for k in range(count)]
