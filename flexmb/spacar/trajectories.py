"""Trajectories in SPACAR input files (our own keywords): motions of coordinates, their inputs, and their outputs."""

from collections.abc import Callable
from typing import Any

from ..elements.nodes import ROTATION3
from ..errors import clean
from ..model.roles import Role
from .actions import target
from .lines import AXES, Fault, Statement, known
from .reading import Channel, Leg, Reading
from .signals import EULER, number_signal, place_of, side_of

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
    kind, of, component = target(p)
    r.single(of, component, kind)
    r.not_warping(of, component, kind)
    what, letter = ("coordinate", "X") if kind == "node" else ("deformation", "E")
    (role,) = r.entries(of, [component], kind)
    if role not in (Role.PRESCRIBED, Role.DOF):
        raise Fault(
            f"{what} {component} is {'held' if role is Role.FIXED else 'calculable'}, so it cannot follow a trajectory:"
            f" name it with INPUT{letter} or DYN{letter} in the kinematics block"
        )
    start, end, law = p["start"], p["end"], p.get("law", LAWS[0]).lower()
    if law not in LAWS:
        raise Fault(f"the law must be {', '.join(LAWS[:-1])} or {LAWS[-1]}, but is '{clean(p['law'])}'")
    if known(start) and start < 0:
        raise Fault(f"start is a time [s] from 0, but is {start}")
    if known(start) and known(end) and end <= start:
        raise Fault(f"end must be later than start, which is {start} s, but is {end}; both are times [s]")
    legs = r.settings.setdefault(s.keyword, [])
    for other in legs:
        times = (start, end, other.start, other.end)
        if other[:2] == (of, component) and all(map(known, times)) and start < other.end and other.start < end:
            raise Fault(
                f"{what} {component} moves from {other.start} s to {other.end} s already by line {other.line}; lines"
                " must follow each other in time"
            )
    legs.append(Leg(of, component, start, end, p["value"], law, s.line))
    r.given.setdefault((s.keyword, of, component), s)


def channel(r: Reading, s: Statement, p: dict[str, Any]) -> None:
    """NOMF, NOMS, REFX, REFE and the like: one nominal input or reference output, kept once all are known."""
    number_signal(r, s, p["number"])
    kind, of, component, axis = place_of(r, s, p)
    if kind == "node" and r.kind_of(of) is ROTATION3 and axis is None:
        r.warnings.append((s, EULER["input" if s.keyword in NOMINAL else "output"]))
    word = p.get("component", component)
    if s.keyword in NOMINAL:
        r.not_warping(of, component, kind)
        if all(role is Role.FIXED for role in r.entries(of, [component] if axis is None else [1, 2, 3, 4], kind)):
            what = "coordinate" if kind == "node" else "deformation"
            raise Fault(f"{what} {word} is fixed, so nothing can drive it; let the input act on one that moves")
    kept = Channel(p["number"], of, word, s.line)
    r.signals[side_of(s.keyword)][p["number"]] = s, lambda: r.settings.setdefault(s.keyword, []).append(kept)


def check(r: Reading, blame: Callable[[Statement, str, str], None]) -> None:
    """Report contradictions between lines about trajectories, once all have been read."""
    for keyword, rates in zip(WAYS, ("INPUTX", "INPUTE"), strict=True):
        about = "node" if keyword == "TRAJX" else "element"
        for of, component, _, *given in r.settings.get(rates, []):
            first = r.given.get((keyword, of, component))
            if first is not None and any(not known(rate) or rate != 0 for rate in given):
                line = r.given[rates, of, component].line
                blame(first, f"moves by the velocity or acceleration of {rates} on line {line} already", about)
    nominal, outputs = ([s for _, (s, _) in sorted(r.signals[side].items())] for side in SIDES_ALONG)
    if nominal and not outputs:
        text = "there is no output that follows the trajectory: name one with REFX, REFE and the like"
        blame(nominal[0], text, "number")
    for keyword, way in zip(NOMINAL, WAYS, strict=True):
        kind = "node" if keyword == "NOMF" else "element"
        for number, of, component, _ in r.settings.get(keyword, []):
            role = None if component in AXES else r.entries(of, [component], kind)[0]
            if role is Role.PRESCRIBED and (way, of, component) not in r.given:
                text = f"is prescribed without a motion, so nothing is driven: give its motion by {way}"
                blame(r.signals["nominal input"][number][0], text, "number")


SIDES_ALONG = ("nominal input", "reference output")
