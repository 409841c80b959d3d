"""Inputs and outputs of SPACAR input files, and trajectories (our own keywords) with their signals."""

from collections.abc import Callable
from typing import Any

from ..build.description import NamedSignal
from ..elements.nodes import ROTATION3
from ..errors import printable
from ..model.by_name import TURNS
from ..model.model import MOTIONS
from ..model.roles import Role
from .actions import target
from .lines import AXES, Fault, Statement, known
from .reading import Channel, Leg, Reading

HELD = (Role.FIXED, Role.PRESCRIBED)
# Quantity of each keyword, in the words of Builder.input and Builder.output.
QUANTITIES: dict[tuple[str, str], dict[str, str]] = {
    ("input", "node"): {"INPUTF": "force", **dict(zip(("INX", "INXP", "INXDP"), MOTIONS, strict=True))},
    ("input", "element"): {"INPUTS": "stress", **dict(zip(("INE", "INEP", "INEDP"), MOTIONS, strict=True))},
    ("output", "node"): {"OUTX": "position", "OUTXP": "velocity", "OUTXDP": "acceleration", "OUTF": "reaction"},
    ("output", "element"): {
        "OUTE": "deformation",
        "OUTEP": "deformation rate",
        "OUTEDP": "deformation acceleration",
        "OUTS": "stress",
    },
}
EULER = {
    "input": "a coordinate of a spatial rotation is an Euler parameter: the input is the force dual to it, twice a"
    " moment at an unturned node; rx, ry or rz in its place is a moment",
    "output": "a coordinate of a spatial rotation is an Euler parameter: half an angle at an unturned node; rx, ry or"
    " rz in its place is a rotation",
}


def keyword_of(side: str, kind: str, quantity: str) -> str:
    """Keyword of an input or output, by its quantity and the kind of its owner."""
    # A moment is a force on a rotation.
    sought = "force" if quantity == "moment" else quantity
    return next(keyword for keyword, candidate in QUANTITIES[side, kind].items() if candidate == sought)


def signal_place(r: Reading, s: Statement, p: dict[str, Any]) -> tuple[str, int, int, int | None]:
    """Node or element of a signal, and its coordinate or deformation, or the axis of its rotation in space."""
    kind, owner, component = target(p)
    if component not in TURNS:
        r.single(owner, component, kind)
        return kind, owner, component, None
    node = r.kind_of(owner)
    if node is not ROTATION3:
        has = "1" if node.size == 1 else f"1 to {node.size}"
        raise Fault(f"{component} is an axis of a rotation in space, but node {owner} is none; its coordinate is {has}")
    r.entries(owner, [1], kind)
    return kind, owner, 1, TURNS.index(component)


def signal(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """INPUTF, INX, OUTX, OUTF and the like: one input or output, added once all are known."""
    side = side_of(s.keyword)
    number_signal(r, s, p["number"])
    kind, owner, component, axis = signal_place(r, s, p)
    quantity = QUANTITIES[side, kind][s.keyword]
    noun, word = ("coordinate" if kind == "node" else "deformation"), p.get("component", component)
    roles = r.entries(owner, [component] if axis is None else [1, 2, 3, 4], kind)
    constrained, moves = all(role in HELD for role in roles), quantity in MOTIONS and side == "input"
    if side == "input":
        r.not_warping(owner, component, kind)
    if kind == "node" and r.kind_of(owner) is ROTATION3 and axis is None:
        if moves or quantity == "reaction":
            raise Fault(f"{noun} {component} is an Euler parameter of a rotation in space: name an axis, rx, ry or rz")
        r.warnings.append((s, EULER[side]))
    if moves and not constrained:
        raise Fault(f"{noun} {word} is free to move; act on it by INPUTF or INPUTS")
    if quantity == "reaction" and not constrained:
        raise Fault(f"{noun} {word} is free, so no support acts there; name one that is fixed or prescribed")
    if side == "input" and kind == "node" and not moves and constrained:
        raise Fault(
            f"{noun} {word} is fixed or prescribed, so a force on it has no effect; let it act on one that moves, or"
            " move it: INX"
        )

    def add():
        label, known = f"{quantity} {owner}.{word}", r.builder.signals[side]
        meant = "moment" if axis is not None and quantity == "force" else quantity
        label = label.replace("force", meant, 1) if meant == "moment" else label
        name = f"{label} ({p['number']})" if label in {signal.name for signal in known} else label
        if kind == "node" and r.kind_of(owner) is ROTATION3 and axis is None:
            # The Builder refuses an Euler parameter.
            known.append(NamedSignal(name, meant, (kind, str(owner), component), axis))
            return
        word_of = component if axis is None else TURNS[axis]
        getattr(r.builder, side)(str(owner), word_of, meant, name=name, kind=kind)

    r.signals[side][p["number"]] = s, add


def side_of(keyword: str) -> str:
    """Numbering of a keyword's signals."""
    sides = {"IN": "input", "NOM": "nominal input", "REF": "reference output"}
    return next((side for start, side in sides.items() if keyword.startswith(start)), "output")


def number_signal(r: Reading, s: Statement, number: int) -> None:
    """Take a number of an input or output, each once."""
    side = side_of(s.keyword)
    first = r.signals[side].get(number)
    if first is not None:
        raise Fault(f"{side} {number} is defined already on line {first[0].line}; {side}s share one numbering")
    r.signals[side][number] = s, None


LAWS = ("quintic", "septic", "scurve")
WAYS = ("TRAJX", "TRAJE")
NOMINAL = ("NOMF", "NOMS")
# Quantities in the words of Builder.output.
REFERENCES = {
    "REFX": "position",
    "REFXP": "velocity",
    "REFXDP": "acceleration",
    "REFE": "deformation",
    "REFEP": "deformation rate",
    "REFEDP": "deformation acceleration",
}


def leg(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """TRAJX, TRAJE: motion of a coordinate or a deformation; lines follow each other in time."""
    kind, owner, component = target(p)
    r.single(owner, component, kind)
    r.not_warping(owner, component, kind)
    noun, letter = ("coordinate", "X") if kind == "node" else ("deformation", "E")
    (role,) = r.entries(owner, [component], kind)
    if role not in (Role.PRESCRIBED, Role.DOF):
        raise Fault(
            f"{noun} {component} is {'held' if role is Role.FIXED else 'calculable'}, so it cannot follow a trajectory:"
            f" name it with INPUT{letter} or DYN{letter} in the kinematics block"
        )
    start, end, law = p["start"], p["end"], p.get("law", LAWS[0]).lower()
    if law not in LAWS:
        raise Fault(f"the law must be {', '.join(LAWS[:-1])} or {LAWS[-1]}, but is '{printable(p['law'])}'")
    if known(start) and start < 0:
        raise Fault(f"start is a time [s] from 0, but is {start}")
    if known(start) and known(end) and end <= start:
        raise Fault(f"end must be later than start, which is {start} s, but is {end}; both are times [s]")
    legs = r.settings.setdefault(s.keyword, [])
    for other in legs:
        times = (start, end, other.start, other.end)
        if other[:2] == (owner, component) and all(map(known, times)) and start < other.end and other.start < end:
            raise Fault(
                f"{noun} {component} moves from {other.start} s to {other.end} s already by line {other.line}; lines"
                " must follow each other in time"
            )
    legs.append(Leg(owner, component, start, end, p["value"], law, s.line))
    r.given.setdefault((s.keyword, owner, component), s)


def channel(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """NOMF, NOMS, REFX, REFE and the like: one nominal input or reference output, kept once all are known."""
    number_signal(r, s, p["number"])
    kind, owner, component, axis = signal_place(r, s, p)
    if kind == "node" and r.kind_of(owner) is ROTATION3 and axis is None:
        r.warnings.append((s, EULER["input" if s.keyword in NOMINAL else "output"]))
    word = p.get("component", component)
    if s.keyword in NOMINAL:
        r.not_warping(owner, component, kind)
        if all(role is Role.FIXED for role in r.entries(owner, [component] if axis is None else [1, 2, 3, 4], kind)):
            noun = "coordinate" if kind == "node" else "deformation"
            raise Fault(f"{noun} {word} is fixed, so nothing can drive it; let the input act on one that moves")
    signal_channel = Channel(p["number"], owner, word, s.line)
    r.signals[side_of(s.keyword)][p["number"]] = s, lambda: r.settings.setdefault(s.keyword, []).append(signal_channel)


def check_trajectories(r: Reading, blame: Callable[[Statement, str, str], None]) -> None:
    """Report contradictions between lines about trajectories, once all have been read."""
    for keyword, rates in zip(WAYS, ("INPUTX", "INPUTE"), strict=True):
        about = "node" if keyword == "TRAJX" else "element"
        for owner, component, _, *values in r.settings.get(rates, []):
            first = r.given.get((keyword, owner, component))
            if first is not None and any(not known(rate) or rate != 0 for rate in values):
                line = r.given[rates, owner, component].line
                blame(first, f"moves by the velocity or acceleration of {rates} on line {line} already", about)
    nominal, outputs = ([s for _, (s, _) in sorted(r.signals[side].items())] for side in SIDES_ALONG)
    if nominal and not outputs:
        text = "there is no output that follows the trajectory: name one with REFX, REFE and the like"
        blame(nominal[0], text, "number")
    for keyword, way in zip(NOMINAL, WAYS, strict=True):
        kind = "node" if keyword == "NOMF" else "element"
        for number, owner, component, _ in r.settings.get(keyword, []):
            role = None if component in AXES else r.entries(owner, [component], kind)[0]
            if role is Role.PRESCRIBED and (way, owner, component) not in r.given:
                text = f"is prescribed without a motion, so nothing is driven: give its motion by {way}"
                blame(r.signals["nominal input"][number][0], text, "number")


SIDES_ALONG = ("nominal input", "reference output")
