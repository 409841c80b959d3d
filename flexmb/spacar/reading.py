"""State of one reading of a SPACAR input file: what its lines have said so far."""

import dataclasses
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from ..build.builder import Builder
from ..display import among
from ..elements.nodes import NodeKind
from ..model.roles import Role
from . import series as series
from .kinds import ElementKind
from .lines import Fault, Statement

# What is numbered, each by itself: inputs and outputs, and what drives a trajectory and what is to follow it.
SIDES = ("input", "output", "nominal input", "reference output")


class AlreadyReported(Exception):
    """A line refers to a node or element whose own line is at fault."""


class Setting(dict[str, float]):
    """Numbers of a line that is not part of the mechanism, and where it stands.

    Attributes:
        line: Its number.
    """

    def __init__(self, line: int, numbers: Mapping[str, float]):
        super().__init__(numbers)
        self.line = line


class Leg(NamedTuple):
    """One way of a coordinate or a deformation, as TRAJX and TRAJE say it; it starts from where the last one ended.

    Attributes:
        of: Number of the node or element.
        component: Number of the coordinate or deformation.
        start, end: From when to when [s].
        value: Where it goes: the coordinate or the deformation itself [m, rad].
        law: "quintic", "septic" or "scurve".
        line: Number of its line.
    """

    of: int
    component: int
    start: float
    end: float
    value: float
    law: str
    line: int


class Channel(NamedTuple):
    """A nominal input or a reference output, as NOMF, REFX and the like say it.

    Attributes:
        number: Its place, from 1.
        of: Number of the node or element.
        component: Number of the coordinate or deformation, or the axis of a rotation in space, "rx", "ry" or "rz".
        line: Number of its line.
    """

    number: int
    of: int
    component: int | str
    line: int


@dataclasses.dataclass(frozen=True)
class Declared:
    """An element as its line describes it.

    Attributes:
        statement: The line.
        kind: Element type.
        nodes: Node numbers in the order of the element's parameters.
        vector: Local y vector or axis, if given.
        order: Order of a spectral beam, if given.
        numbers: Other numbers, by property.
    """

    statement: Statement
    kind: ElementKind
    nodes: tuple[int, ...]
    vector: list[float] | None
    order: int | None = None
    numbers: dict[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass
class Reading:
    """State of one reading.

    Attributes:
        callables: User routines by name.
        builder: What is being built.
        elements: Element lines by number.
        nodes: Kind of each node, and the line that says so.
        positions: Coordinates that X gives.
        misplaced: Nodes whose X line is at fault.
        lines: Numbers of ESTIFF, EM, EDAMP, ALPHA, SECTION and CLAMP by element and keyword.
        unsized: Numbers in faulty SECTION lines, whose elements are not blamed for having none.
        roles: Which line gave an entry its role.
        given: Which line gave what can be given once.
        signals: Inputs and outputs, and those along a trajectory, by number: their line, and the call that adds them.
        excused: Numbers in faulty element lines, about which no other line is blamed.
        settings: What is not part of the mechanism.
        outlines: Sizes of cross-sections by element, as CROSSDIM has them.
        drawn: Lines that draw.
        warnings: Line and text.
    """

    callables: Mapping[str, Callable[..., Any]]
    builder: Builder = dataclasses.field(default_factory=Builder)
    elements: dict[int, Declared] = dataclasses.field(default_factory=dict)
    nodes: dict[int, tuple[NodeKind, Statement]] = dataclasses.field(default_factory=dict)
    positions: dict[int, list[float]] = dataclasses.field(default_factory=dict)
    misplaced: set[int] = dataclasses.field(default_factory=set)
    lines: dict[int, dict[str, list[float]]] = dataclasses.field(default_factory=dict)
    unsized: set[int] = dataclasses.field(default_factory=set)
    roles: dict[tuple[str, int, int], Statement] = dataclasses.field(default_factory=dict)
    given: dict[tuple, Statement] = dataclasses.field(default_factory=dict)
    signals: dict[str, dict[int, tuple[Statement, Callable[[], None] | None]]] = dataclasses.field(
        default_factory=lambda: {side: {} for side in SIDES}
    )
    excused: set[int] = dataclasses.field(default_factory=set)
    settings: dict[str, Any] = dataclasses.field(default_factory=dict)
    outlines: dict[int, Any] = dataclasses.field(default_factory=dict)
    drawn: list[Statement] = dataclasses.field(default_factory=list)
    warnings: list[tuple[Statement, str]] = dataclasses.field(default_factory=list)

    def once(self, statement: Statement, *key: Any) -> None:
        """Refuse what is given a second time."""
        first = self.given.setdefault((statement.keyword, *key), statement)
        if first is not statement:
            raise Fault(f"is given already on line {first.line}; give it once")

    def kind_of(self, number: int) -> NodeKind:
        """Kind of a node that elements name."""
        if number in self.nodes:
            return self.nodes[number][0]
        if number in self.excused:
            raise AlreadyReported
        raise Fault(f"node {number} is in no element; a node exists by being named in one ({_listed(self.nodes)})")

    def declared(self, number: int) -> Declared:
        """An element by its number."""
        if number in self.elements:
            return self.elements[number]
        if number in self.excused:
            raise AlreadyReported
        raise Fault(f"there is no element {number} ({_listed(self.elements)})")

    def entries(self, of: int, components: list[int], kind: str) -> list[Role]:
        """Roles of the coordinates of a node or the deformations of an element, which must have those named."""
        if kind == "node":
            self.kind_of(of)
            owner = self.builder.nodes.get(str(of))
        else:
            self.declared(of)
            owner = self.builder.members.get(str(of))
        if owner is None:
            raise AlreadyReported
        what = "coordinates" if kind == "node" else "deformations"
        for component in components:
            if component > len(owner.roles):
                raise Fault(f"{what[:-1]} {component} is out of range: {kind} {of} has {what} 1 to {len(owner.roles)}")
        return [owner.roles[c - 1] for c in components]

    def meant(self, of: int, component: int, kind: str) -> tuple[int, ...]:
        """Coordinates or deformations that a number stands for: all of a strain field, of a spectral beam."""
        self.entries(of, [component], kind)
        self.not_warping(of, component, kind)
        return (component,) if kind == "node" else series.meant(self.builder.members[str(of)].element, component)

    def not_warping(self, of: int, component: int, kind: str) -> None:
        """Refuse the warping of a leaf spring's end where something is given or held."""
        if kind == "element" and component in series.warping(self.builder.members[str(of)].element):
            raise Fault(
                f"deformation {component} of {self.declared(of).kind.keyword} is the warping of an end, which what is"
                " joined there holds, or CLAMP; where it is free it is a degree of freedom by itself"
            )

    def single(self, of: int, component: int, kind: str) -> None:
        """Refuse a whole strain field where one number is wanted."""
        self.entries(of, [component], kind)
        if kind == "node":
            return
        element = self.builder.members[str(of)].element
        if component <= series.closure(element):
            raise Fault(
                f"{self.declared(of).kind.keyword} has a strain field there; name one of its coefficients by its number"
                f" in e, from {element.fields[0][0]} on, not {component}"
            )

    def require(self, of: int, component: int, kind: str, role: Role) -> None:
        """Refuse a value for an entry that has another role."""
        self.single(of, component, kind)
        self.not_warping(of, component, kind)
        if self.entries(of, [component], kind) != [role]:
            letter = "X" if kind == "node" else "E"
            keyword = f"INPUT{letter}" if role is Role.PRESCRIBED else f"DYN{letter}"
            what = "coordinate" if kind == "node" else "deformation"
            wanted = "prescribed" if role is Role.PRESCRIBED else "a degree of freedom"
            raise Fault(f"{what} {component} is not {wanted}: name it with {keyword} in the kinematics block")


def _listed(numbers: Collection[int]) -> str:
    return f"there are: {among(map(str, sorted(numbers)))}" if numbers else "there are none"
