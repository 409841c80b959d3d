"""Degrees of freedom, over- and under-constraints of a drawing, also of one that is not finished."""

import dataclasses
from collections.abc import Iterable
from typing import Any

from ..build.builder import Builder
from ..checks.mobility import Mobility, mobility
from ..display import counted
from ..elements.nodes import NodeKind
from ..errors import MechanismError, ModelError, first_line, heard
from ..model.model import Model
from ..model.roles import HELD

# Names listed in a message.
LISTED = 4


@dataclasses.dataclass(frozen=True)
class Part:
    """Nodes that elements join to each other.

    Attributes:
        nodes: Their names, those with a position alone.
        elements: What joins them; none of a node that stands alone.
        held: Whether something in it is fixed or prescribed.
    """

    nodes: tuple[str, ...]
    elements: tuple[str, ...]
    held: bool


@dataclasses.dataclass(frozen=True)
class Count:
    """What there is to count, and what it means.

    Attributes:
        status: "ok", "empty", "loose" (something floats), "overconstrained", "underconstrained", "both", "dof" (what is
            named does not fit) or "failed".
        message: What is to be known, and what to do.
        numbers: nx, ne, nxo, neo and ndof = nx - nxo - neo.
        over: Number of states of self-stress; None where it is not known.
        under: Number of motions that nothing determines; None where it is not known.
        dofs: Names of the degrees of freedom.
        model: The checked model, or None.
        drawn: A model to be drawn: the checked one, or one that is not valid; None without elements.
        mobility: Of a model that is not valid.
        parts: What hangs together.
        warnings: What the builder warns of.
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

    def told(self) -> dict[str, Any]:
        """As a message to a page; shares are those of the elements in every state of self-stress."""
        shares = [] if self.mobility is None else [dict(own) for own in self.mobility.states().shares or ()]
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
    """The numbers of NDOF = NX - NXO - NEO, from the roles alone: nothing is compiled."""
    if builder.members:
        try:
            return builder.build(check=False).counts()
        except ModelError:
            pass
    nx = nxo = 0
    for node in builder.nodes.values():
        held = sum(role in HELD for role in node.roles)
        nx += node.kind.freedoms
        nxo += min(held, node.kind.freedoms)
    shown = [member for member in builder.members.values() if not member.hidden]
    ne = sum(len(member.roles) for member in shown)
    neo = sum(role in HELD for member in shown for role in member.roles)
    return {"nx": nx, "ne": ne, "nxo": nxo, "neo": neo, "ndof": nx - nxo - neo}


def count(builder: Builder) -> Count:
    """Count the degrees of freedom of a drawing, and find what is over- and under-constrained."""
    parts = tuple(_parts(builder))
    if not builder.nodes:
        return Count("empty", "Nothing is drawn yet. Add a node.", quick_numbers(builder))
    if not any(not member.hidden for member in builder.members.values()):
        there = counted(sum(len(part.nodes) for part in parts), "node")
        message = f"{there}, and no element that joins any. Add an element between two nodes."
        return Count("empty", message, quick_numbers(builder), parts=parts)
    with heard() as said:
        try:
            model = builder.build()
        except MechanismError as fault:
            return _invalid(builder, fault, parts)
        except ModelError as fault:
            return Count("failed", str(fault), quick_numbers(builder), parts=parts, drawn=_unchecked(builder))
    numbers, told = model.counts(), _of_loose(parts)
    named = tuple(model.q_labels)
    exact = f"{counted(len(named), 'degree')} of freedom, and nothing is over-constrained."
    return Count(
        "loose" if told else "ok",
        " ".join([*told, "" if told else exact]).strip(),
        numbers,
        over=0,
        under=0,
        dofs=named,
        model=model,
        drawn=model,
        parts=parts,
        warnings=tuple(dict.fromkeys(said)),
    )


def _unchecked(builder: Builder) -> Model | None:
    """A model to be drawn; None where there is none."""
    try:
        return builder.build(check=False)
    except ModelError:
        return None


def _invalid(builder: Builder, fault: MechanismError, parts: tuple[Part, ...]) -> Count:
    """Count of a mechanism that is over- or under-constrained, or whose degrees of freedom do not fit."""
    model = builder.build(check=False)
    found = mobility(model)
    told = _of_loose(parts)
    if found.overconstraints:
        own = list(dict.fromkeys(share.of for i in range(found.overconstraints) for share in found.stresses(i)))
        told.append(
            f"Over-constrained: {counted(found.overconstraints, 'state')} of self-stress in {_listed(own)}."
            f" {_release_of(found)}"
        )
    if fault.code != "overconstrained" or not found.overconstraints:
        told.append(first_line(fault))
    # Where degrees of freedom are to be found, no motion is left undetermined.
    under = found.underconstraints if builder.dofs else 0
    over = found.overconstraints
    status = "both" if over and under else "overconstrained" if over else "underconstrained" if under else fault.code
    named = tuple(model.q_labels)
    return Count(status, " ".join(told), model.counts(), over, under, named, drawn=model, mobility=found, parts=parts)


def _release_of(found: Mobility) -> str:
    """Which deformations and supports to release."""
    releases = [own[0].words for own in found.candidates if own]
    if not releases:
        return "Only rigid elements take part: replace one by a flexible or a pinned one."
    left = len(found.release) - len(releases)
    more = f" {counted(left, 'state')} more lie between rigid elements alone." if left else ""
    return f"Release {', and '.join(releases)}.{more}"


def _of_loose(parts: Iterable[Part]) -> list[str]:
    """Sentences about what is joined to nothing, and what floats."""
    parts = list(parts)
    alone = [part.nodes[0] for part in parts if part.nodes and not part.elements]
    floating = [part for part in parts if part.elements and not part.held]
    told = []
    if alone:
        are, them = ("are", "them") if len(alone) > 1 else ("is", "it")
        told.append(f"{_listed(alone, 'node')} {are} joined to nothing: join {them} by an element, or delete {them}.")
    if floating and len(floating) == sum(bool(part.elements) for part in parts):
        told.append("Nothing is fixed: the mechanism floats. Fix a node.")
    elif floating:
        names = [name for part in floating for name in part.elements]
        told.append(
            f"{_listed(names, 'element')} {'float' if len(names) > 1 else 'floats'}: nothing joins"
            f" {'them' if len(names) > 1 else 'it'} to a support."
        )
    return told


def _listed(names: list[str], what: str = "") -> str:
    """The first of some names, in words."""
    shown = [f"'{name}'" for name in names[:LISTED]]
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    several = ", ".join(shown) + more if more or len(shown) < 2 else f"{', '.join(shown[:-1])} and {shown[-1]}"
    if not what:
        return several
    return f"{what.capitalize()}{'s' if len(names) > 1 else ''} {several}"


def _parts(builder: Builder) -> list[Part]:
    """What elements join, in the order in which nodes were added."""
    leader = {name: name for name in builder.nodes}

    def first(name: str) -> str:
        while leader[name] != name:
            leader[name] = leader[leader[name]]
            name = leader[name]
        return name

    def join(one: str, other: str) -> None:
        a, b = first(one), first(other)
        if a != b:
            leader[b] = a

    for name in builder.nodes:
        owner = name.removesuffix(".rotation").removesuffix(".warping")
        if owner != name and owner in builder.nodes:
            join(owner, name)
    for member in builder.members.values():
        for node in member.nodes[1:]:
            join(member.nodes[0], node)
    groups: dict[str, tuple[list[str], list[str], list[bool]]] = {}
    for name, node in builder.nodes.items():
        own = groups.setdefault(first(name), ([], [], []))
        if node.kind.part == "position":
            own[0].append(name)
        own[2].append(_is_held(node.kind, node.roles))
    for name, member in builder.members.items():
        if not member.hidden and member.nodes:
            groups[first(member.nodes[0])][1].append(name)
    return [Part(tuple(nodes), tuple(elements), any(held)) for nodes, elements, held in groups.values()]


def _is_held(kind: NodeKind, roles: list[Any]) -> bool:
    """Whether a position or a rotation is held by something, in part or as a whole."""
    return kind.part in ("position", "rotation") and any(role in HELD for role in roles)
