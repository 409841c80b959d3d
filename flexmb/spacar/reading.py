"""The state of one reading of a SPACAR input file: everything that its lines have stated so far."""

import dataclasses
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from ..build.builder import Builder
from ..display import among
from ..elements.nodes import NodeKind
from ..errors import printable
from ..model.topology import Role
from . import series as series
from .kinds import ElementKind
from .lines import Fault, Statement

# Numberings of their own: inputs and outputs, and signals along a trajectory.
SIDES = ("input", "output", "nominal input", "reference output")
# What the numbers of a node and of an element count.
NOUNS = {"node": "coordinate", "element": "deformation"}


# A file of another kind has a fault in each line.
MOST_FAULTS = 100


class EnoughFaults(Exception):
    """There are more faults than anyone reads."""


class AlreadyReported(Exception):
    """A line refers to a node or element whose own line has a fault."""


class Setting(dict[str, float]):
    """Numbers of a line beside the mechanism, and the number of the line."""

    def __init__(self, line: int, numbers: Mapping[str, float]):
        super().__init__(numbers)
        self.line = line


class Leg(NamedTuple):
    """One motion of a coordinate or a deformation by TRAJX or TRAJE, which starts at the end of the motion before.

    Attributes:
        of: Number of the node or element.
        component: Number of the coordinate or deformation.
        start, end: Times [s].
        value: Value of the coordinate or the deformation at the end [m, rad].
        law: "quintic", "septic" or "scurve".
        line: Number of the line.
    """

    of: int
    component: int
    start: float
    end: float
    value: float
    law: str
    line: int


class Channel(NamedTuple):
    """A nominal input or a reference output by NOMF, REFX and the like.

    Attributes:
        number: Number from 1.
        of: Number of the node or element.
        component: Number of the coordinate or deformation, or axis "rx", "ry" or "rz" of a rotation in space.
        line: Number of the line.
    """

    number: int
    of: int
    component: int | str
    line: int


@dataclasses.dataclass(frozen=True)
class Declared:
    """An element from its line: node numbers in the order of parameters, a vector y or axis, the order of a series."""

    statement: Statement
    kind: ElementKind
    nodes: tuple[int, ...]
    vector: list[float] | None
    order: int | None = None
    numbers: dict[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass
class Reading:
    """The state of one reading.

    Attributes:
        callables: User routines by name.
        builder: Builder so far.
        elements: Element lines by number.
        nodes: Kind of each node, and its first line.
        positions: Coordinates from X.
        misplaced: Nodes with a faulty X line.
        lines: Numbers of ESTIFF, EM, EDAMP, ALPHA, SECTION and CLAMP by element and keyword.
        unsized: Numbers in faulty SECTION lines; a missing section of these elements is no further fault.
        roles: Line that gave an entry its role.
        given: Line of everything that may occur once.
        signals: Inputs, outputs and signals along a trajectory by number: their line, and the call that adds them.
        excused: Numbers in faulty element lines; other lines about them are no further faults.
        settings: Lines beside the mechanism.
        outlines: Sizes of cross-sections by element, from CROSSDIM.
        drawn: Lines for drawing.
        warnings: Lines with their warnings.
        statements: Lines so far.
        faults: Faults so far, by the number of their line.
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
    statements: list[Statement] = dataclasses.field(default_factory=list)
    faults: list[tuple[int, str]] = dataclasses.field(default_factory=list)

    def warn(self, statement: Statement, text: str) -> None:
        """Note a warning about a line."""
        self.warnings.append((statement, text))

    def blame(self, s: Statement, text: str, form: str = "") -> None:
        """Note a fault, with the node or element of its line."""
        about = form.split()[0].strip("[]") if form else ""
        if about == "number":
            about = "input" if s.keyword.startswith(("IN", "NOM")) else "output"
        if about in ("node", "element", "input", "output") and s.words and s.words[0].isdecimal():
            subject = f"{about} {printable(s.words[0])}"
            text = f"{subject}: {text.removeprefix(subject).lstrip()}"
        self.faults.append((s.line, f"{printable(s.keyword)}: {text}"))
        if len(self.faults) >= MOST_FAULTS:
            raise EnoughFaults

    def once(self, statement: Statement, *key: Any) -> None:
        """Refuse a second statement."""
        first = self.given.setdefault((statement.keyword, *key), statement)
        if first is not statement:
            raise Fault(f"is given already on line {first.line}; give it once")

    def kind_of(self, number: int) -> NodeKind:
        """Kind of a node in an element."""
        if number in self.nodes:
            return self.nodes[number][0]
        if number in self.excused:
            raise AlreadyReported
        raise Fault(f"node {number} is in no element; a node exists if an element names it ({_existing(self.nodes)})")

    def declared(self, number: int) -> Declared:
        """An element by its number."""
        if number in self.elements:
            return self.elements[number]
        if number in self.excused:
            raise AlreadyReported
        raise Fault(f"there is no element {number} ({_existing(self.elements)})")

    def entries(self, of: int, components: list[int], kind: str) -> list[Role]:
        """Roles of existing coordinates of a node, or deformations of an element."""
        if kind == "node":
            self.kind_of(of)
            owner = self.builder.nodes.get(str(of))
        else:
            self.declared(of)
            owner = self.builder.members.get(str(of))
        if owner is None:
            raise AlreadyReported
        noun, count = NOUNS[kind], len(owner.roles)
        for component in components:
            if component > count:
                raise Fault(f"{noun} {component} is out of range: {kind} {of} has {noun}s 1 to {count}")
        return [owner.roles[c - 1] for c in components]

    def meant(self, of: int, component: int, kind: str) -> tuple[int, ...]:
        """Coordinates or deformations of a number: a whole strain field of a spectral beam."""
        self.entries(of, [component], kind)
        if kind == "node":
            return (component,)
        self.not_warping(of, component, kind)
        return series.deformations_meant(self.builder.members[str(of)].element, component)

    def not_warping(self, of: int, component: int, kind: str) -> None:
        """Refuse a value or a role for the warping of a leaf spring's end."""
        if kind == "element" and component in series.warping(self.builder.members[str(of)].element):
            raise Fault(
                f"deformation {component} of {self.declared(of).kind.keyword} is the warping of an end: joined parts or"
                " CLAMP constrain it; otherwise it is a separate degree of freedom"
            )

    def single(self, of: int, component: int, kind: str) -> None:
        """Refuse a whole strain field where one number is needed."""
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
        """Refuse a value for an entry with another role."""
        self.single(of, component, kind)
        self.not_warping(of, component, kind)
        if self.entries(of, [component], kind) != [role]:
            keyword, expected = ("INPUT", "prescribed") if role is Role.PRESCRIBED else ("DYN", "a degree of freedom")
            keyword += "X" if kind == "node" else "E"
            raise Fault(f"{NOUNS[kind]} {component} is not {expected}: name it with {keyword} in the kinematics block")


def _existing(numbers: Collection[int]) -> str:
    return f"there are: {among(map(str, sorted(numbers)))}" if numbers else "there are none"
