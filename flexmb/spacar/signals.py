"""Inputs and outputs of SPACAR input files, and the numbering of signals along a trajectory."""

from typing import Any

from ..build.description import NamedSignal
from ..elements.nodes import ROTATION3
from ..model.by_name import TURNS
from ..model.model import MOTIONS
from ..model.roles import Role
from .actions import target
from .lines import Fault, Statement
from .reading import Reading

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
    wanted = "force" if quantity == "moment" else quantity
    return next(keyword for keyword, own in QUANTITIES[side, kind].items() if own == wanted)


def place_of(r: Reading, s: Statement, p: dict[str, Any]) -> tuple[str, int, int, int | None]:
    """Node or element of a signal, and its coordinate or deformation, or the axis of its rotation in space."""
    kind, of, component = target(p)
    if component not in TURNS:
        r.single(of, component, kind)
        return kind, of, component, None
    node = r.kind_of(of)
    if node is not ROTATION3:
        has = "1" if node.size == 1 else f"1 to {node.size}"
        raise Fault(f"{component} is an axis of a rotation in space, but node {of} is none; its coordinate is {has}")
    r.entries(of, [1], kind)
    return kind, of, 1, TURNS.index(component)


def signal(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """INPUTF, INX, OUTX, OUTF and the like: one input or output, added once all are known."""
    side = side_of(s.keyword)
    number_signal(r, s, p["number"])
    kind, of, component, axis = place_of(r, s, p)
    quantity = QUANTITIES[side, kind][s.keyword]
    what, word = ("coordinate" if kind == "node" else "deformation"), p.get("component", component)
    roles = r.entries(of, [component] if axis is None else [1, 2, 3, 4], kind)
    held, moves = all(role in HELD for role in roles), quantity in MOTIONS and side == "input"
    if side == "input":
        r.not_warping(of, component, kind)
    if kind == "node" and r.kind_of(of) is ROTATION3 and axis is None:
        if moves or quantity == "reaction":
            raise Fault(f"{what} {component} is an Euler parameter of a rotation in space: name an axis, rx, ry or rz")
        r.warnings.append((s, EULER[side]))
    if moves and not held:
        raise Fault(f"{what} {word} is free to move; act on it by INPUTF or INPUTS")
    if quantity == "reaction" and not held:
        raise Fault(f"{what} {word} is free, so no support acts there; name one that is fixed or prescribed")
    if side == "input" and kind == "node" and not moves and held:
        raise Fault(
            f"{what} {word} is fixed or prescribed, so a force on it has no effect; let it act on one that moves, or"
            " move it: INX"
        )

    def add():
        label, known = f"{quantity} {of}.{word}", r.builder.signals[side]
        meant = "moment" if axis is not None and quantity == "force" else quantity
        label = label.replace("force", meant, 1) if meant == "moment" else label
        name = f"{label} ({p['number']})" if label in {signal.name for signal in known} else label
        if kind == "node" and r.kind_of(of) is ROTATION3 and axis is None:
            # The Builder refuses an Euler parameter.
            known.append(NamedSignal(name, meant, (kind, str(of), component), axis))
            return
        word_of = component if axis is None else TURNS[axis]
        getattr(r.builder, side)(str(of), word_of, meant, name=name, kind=kind)

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
