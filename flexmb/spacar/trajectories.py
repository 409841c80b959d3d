"""Inputs and outputs of SPACAR input files, and trajectories (our own keywords) with their signals and laws of time."""

from typing import Any, NamedTuple

import jax
import numpy as np

from ..build.builder import Builder
from ..build.description import Key, NamedSignal
from ..elements.nodes import ROTATION3
from ..errors import printable
from ..mechanics.signals import DEFORMATION_ORDERS, ORDERS
from ..model.by_name import TURNS
from ..model.model import MOTIONS, Labels
from ..model.topology import Role
from ..trajectory.laws import Law, quintic, scurve, septic
from .actions import start_of, target
from .lines import AXES, Fault, Statement, is_zero, known
from .reading import NOUNS, Channel, Leg, Reading

HELD = (Role.FIXED, Role.PRESCRIBED)
# Quantity of each keyword, in the words of Builder.input and Builder.output.
QUANTITIES: dict[tuple[str, str], dict[str, str]] = {
    ("input", "node"): {"INPUTF": "force", **dict(zip(("INX", "INXP", "INXDP"), MOTIONS, strict=True))},
    ("input", "element"): {"INPUTS": "stress", **dict(zip(("INE", "INEP", "INEDP"), MOTIONS, strict=True))},
    ("output", "node"): {**dict(zip(("OUTX", "OUTXP", "OUTXDP"), ORDERS, strict=True)), "OUTF": "reaction"},
    ("output", "element"): {
        **dict(zip(("OUTE", "OUTEP", "OUTEDP"), DEFORMATION_ORDERS, strict=True)),
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


def signal_place(r: Reading, p: dict[str, Any]) -> tuple[str, int, int, int | None, list[Role]]:
    """Node or element of a signal, its coordinate or deformation, or the axis of its rotation in space, and roles."""
    kind, owner, component = target(p)
    if component not in TURNS:
        r.single(owner, component, kind)
        return kind, owner, component, None, r.entries(owner, [component], kind)
    node = r.kind_of(owner)
    if node is not ROTATION3:
        has = "1" if node.size == 1 else f"1 to {node.size}"
        raise Fault(f"{component} is an axis of a rotation in space, but node {owner} is none; its coordinate is {has}")
    return kind, owner, 1, TURNS.index(component), r.entries(owner, [1, 2, 3, 4], kind)


def signal(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """INPUTF, INX, OUTX, OUTF and the like: one input or output, added once all are known."""
    side = side_of(s.keyword)
    number_signal(r, s, p["number"])
    kind, owner, component, axis, roles = signal_place(r, p)
    quantity = QUANTITIES[side, kind][s.keyword]
    noun, word = NOUNS[kind], p.get("component", component)
    constrained, moves = all(role in HELD for role in roles), quantity in MOTIONS and side == "input"
    if side == "input":
        r.not_warping(owner, component, kind)
    is_euler = kind == "node" and r.kind_of(owner) is ROTATION3 and axis is None
    if is_euler:
        if moves or quantity == "reaction":
            raise Fault(f"{noun} {component} is an Euler parameter of a rotation in space: name an axis, rx, ry or rz")
        r.warn(s, EULER[side])
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
        known = r.builder.signals[side]
        meant = "moment" if axis is not None and quantity == "force" else quantity
        label = f"{meant} {owner}.{word}"
        name = f"{label} ({p['number']})" if label in {signal.name for signal in known} else label
        if is_euler:
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
    **dict(zip(("REFX", "REFXP", "REFXDP"), ORDERS, strict=True)),
    **dict(zip(("REFE", "REFEP", "REFEDP"), DEFORMATION_ORDERS, strict=True)),
}


def leg(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """TRAJX, TRAJE: motion of a coordinate or a deformation; lines follow each other in time."""
    kind, owner, component = target(p)
    r.single(owner, component, kind)
    r.not_warping(owner, component, kind)
    noun = NOUNS[kind]
    (role,) = r.entries(owner, [component], kind)
    if role not in (Role.PRESCRIBED, Role.DOF):
        letter, state = s.keyword[-1], "held" if role is Role.FIXED else "calculable"
        raise Fault(
            f"{noun} {component} is {state}, so it cannot follow a trajectory: name it with INPUT{letter} or"
            f" DYN{letter} in the kinematics block"
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
    kind, owner, component, axis, roles = signal_place(r, p)
    if kind == "node" and r.kind_of(owner) is ROTATION3 and axis is None:
        r.warn(s, EULER["input" if s.keyword in NOMINAL else "output"])
    word = p.get("component", component)
    if s.keyword in NOMINAL:
        r.not_warping(owner, component, kind)
        if all(role is Role.FIXED for role in roles):
            raise Fault(f"{NOUNS[kind]} {word} is fixed, so nothing can drive it; let the input act on one that moves")
    signal_channel = Channel(p["number"], owner, word, s.line)
    r.signals[side_of(s.keyword)][p["number"]] = s, lambda: r.settings.setdefault(s.keyword, []).append(signal_channel)


def check_trajectories(r: Reading) -> None:
    """Report contradictions between lines about trajectories, once all have been read."""
    for keyword, rates in zip(WAYS, ("INPUTX", "INPUTE"), strict=True):
        about = "node" if keyword == "TRAJX" else "element"
        for owner, component, _, *values in r.settings.get(rates, []):
            first = r.given.get((keyword, owner, component))
            if first is not None and any(not is_zero(rate) for rate in values):
                line = r.given[rates, owner, component].line
                r.blame(first, f"moves by the velocity or acceleration of {rates} on line {line} already", about)
    nominal, outputs = r.signals["nominal input"], r.signals["reference output"]
    if nominal and not outputs:
        text = "there is no output that follows the trajectory: name one with REFX, REFE and the like"
        r.blame(nominal[min(nominal)][0], text, "number")
    for keyword, way in zip(NOMINAL, WAYS, strict=True):
        kind = "node" if keyword == "NOMF" else "element"
        for number, owner, component, _ in r.settings.get(keyword, []):
            role = None if component in AXES else r.entries(owner, [component], kind)[0]
            if role is Role.PRESCRIBED and (way, owner, component) not in r.given:
                text = f"is prescribed without a motion, so nothing is driven: give its motion by {way}"
                r.blame(nominal[number][0], text, "number")


# Limits of an S-curve over a distance of 1 in a time of 1. It accelerates in the first third and decelerates in the
# last; the acceleration grows, stays and falls in a third of each.
THIRDS = {"velocity": 1.5, "acceleration": 6.75, "jerk": 60.75}


class Way(NamedTuple):
    """Lines of one coordinate or deformation, in the order of time, and their keyword."""

    keyword: str
    legs: list[Leg]


def role_of(builder: Builder, key: Key) -> Role:
    """Role of a coordinate or deformation."""
    kind, owner, number = key
    return (builder.nodes if kind == "node" else builder.members)[owner].roles[number - 1]


def ways_of(settings: dict[str, Any]) -> dict[Key, Way]:
    """Lines of TRAJX and TRAJE in the settings of a file, by coordinate or deformation."""
    ways: dict[Key, Way] = {}
    for keyword, kind in zip(WAYS, ("node", "element"), strict=True):
        for leg in sorted(settings.get(keyword, []), key=lambda leg: leg.start):
            key = (kind, str(leg.of), leg.component)
            ways.setdefault(key, Way(keyword, [])).legs.append(leg)
    return ways


def _name(labels: Labels, key: Key) -> str:
    """Name of a coordinate or deformation."""
    kind, owner, number = key
    entries = labels.x if kind == "node" else labels.e
    return next(str(entry) for entry in entries if entry.of == owner and entry.component == number)


def _move(leg: Leg, start: float, end: float) -> Law:
    """One motion from rest to rest."""
    duration = leg.end - leg.start
    if leg.law == "scurve" and end != start:
        far = abs(end - start)
        limits = {name: THIRDS[name] * far / duration ** (i + 1) for i, name in enumerate(THIRDS)}
        return scurve(start, end, **limits, begin=leg.start)
    return (septic if leg.law == "septic" else quintic)(start, end, duration, begin=leg.start)


def law_of(legs: list[Leg], start: float, reference: float = 0.0) -> Law:
    """One law of several motions in the order of time, with rest between them.

    The first motion begins at ``start``, from the undeformed mechanism; values of lines count from ``reference`` [m,
    rad].
    """
    breaks, polynomials, at = [legs[0].start], [], start
    for leg in legs:
        if leg.start > breaks[-1]:
            polynomials.append(np.array([[at]]))
            breaks.append(leg.start)
        motion, at = _move(leg, at, leg.value - reference), leg.value - reference
        polynomials.append(np.asarray(motion.coefficients))
        # The phases of an S-curve miss the end by round-off.
        breaks += [*np.asarray(motion.breaks)[1:-1].tolist(), leg.end]
    widest = max(piece.shape[1] for piece in polynomials)
    padded = [np.pad(piece, ((0, 0), (0, widest - piece.shape[1]))) for piece in polynomials]
    # jnp.asarray compiles a program for each shape.
    return Law(jax.device_put(np.array(breaks)), jax.device_put(np.concatenate(padded)))


def laws_of(builder: Builder, labels: Labels, settings: dict[str, Any], only: Role | None = None) -> dict[str, Law]:
    """Laws of all motions in a file, or of one role, by names: displacements from the undeformed mechanism."""
    prescribed, laws = builder.loads["initial"].get("prescribed", {}), {}
    for key, way in ways_of(settings).items():
        kind, owner, number = key
        if only in (None, role_of(builder, key)):
            start = prescribed.get(key, builder.starts.get(key, (0.0, 0.0))[0])
            reference = start_of(builder, kind, owner, number)
            laws[_name(labels, key)] = law_of(way.legs, float(start), float(reference))
    return laws
