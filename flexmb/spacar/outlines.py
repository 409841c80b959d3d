"""Sizes of cross-sections in the VISUALIZATION section: BEAMPROPS, CROSSTYPE, CROSSDIM, read and written.

ESTIFF and EM state how stiff and heavy a beam is, not its sizes: without these lines it has no stress. The first size
lies along local y, the second along local z. A circle has its diameter, and hollow sections have outer sizes before
inner ones; this is our reading, since the predecessor's manual is not known.
"""

from typing import Any

import numpy as np

from ..elements.section import Material, Rigidity, Section
from ..elements.sections import Circle, HollowRectangle, Rectangle, Tube
from ..errors import printable
from ..numerical_limits import SIZES_ALIKE
from .lines import DRAWING, Fault, Statement, known, parse
from .reading import AlreadyReported, Reading

TITLE, PROPS, TYPE, SIZES = DRAWING.upper(), "BEAMPROPS", "CROSSTYPE", "CROSSDIM"
# The material of an outline has no effect.
NONE = Material(E=1.0, G=0.5, rho=1.0)
# Number of sizes of each type.
COUNTS = {"rect": 2, "recthol": 4, "circ": 1, "circhol": 2, "line": 0}


def take(r: Reading) -> None:
    """Act on the lines with sizes once elements are declared; they no longer cause a warning."""
    effective: list[Statement] = []
    unchanged = list(r.drawn)
    for group in _groups(r.drawn):
        try:
            used, complete = _take_group(r, group)
        except AlreadyReported:
            continue
        except Fault as fault:
            r.blame(group[PROPS], str(fault), "element")
            continue
        effective += group.values() if used else ()
        # Lines about elements without use for them, such as rigid ones, are kept unchanged.
        unchanged = [s for s in unchanged if not (complete and s in group.values())]
    if effective:
        r.drawn = _without_title([s for s in r.drawn if s not in effective])
        if lines := [s.raw for s in _without_title(unchanged)]:
            r.settings[TITLE] = lines
        else:
            del r.settings[TITLE]


def _without_title(drawn: list[Statement]) -> list[Statement]:
    """Lines for drawing; none if only the title is left."""
    return drawn if any(s.keyword != TITLE for s in drawn) else []


def _groups(drawn: list[Statement]) -> list[dict[str, Statement]]:
    """BEAMPROPS with the CROSSTYPE and the CROSSDIM after it, if both exist."""
    groups: list[dict[str, Statement]] = []
    open_group: dict[str, Statement] = {}
    for s in drawn:
        if s.keyword == PROPS:
            open_group = {PROPS: s}
            groups.append(open_group)
        elif s.keyword in (TYPE, SIZES) and s.keyword not in open_group:
            open_group[s.keyword] = s
        else:
            open_group = {}
    return [group for group in groups if TYPE in group and (SIZES in group or group[TYPE].words == ("line",))]


def _take_group(r: Reading, group: dict[str, Statement]) -> tuple[bool, bool]:
    """Note the outlines of the named elements; whether one of them uses it, and whether all do."""
    kind = parse(TYPE, "name", group[TYPE].words)["name"].lower()
    if kind not in COUNTS:
        raise Fault(f"{TYPE} must be one of {', '.join(COUNTS)}, but is '{printable(kind)}'")
    numbers = parse(PROPS, "element ...", group[PROPS].words)["element"]
    sizes = parse(SIZES, "value ...", group[SIZES].words)["value"] if COUNTS[kind] else []
    if len(sizes) != COUNTS[kind]:
        raise Fault(f"{SIZES} of {kind} takes {COUNTS[kind]} sizes, but has {len(sizes)}")
    outline = of_sizes(kind, sizes) if sizes else None
    if outline is not None and all(map(known, sizes)):
        for fault in outline.faults():
            raise Fault(f"{SIZES}: {fault}")
    rigid = [number for number in numbers if "EA" not in r.declared(number).kind.stiffness]
    used = [n for n in numbers if outline is not None and n not in rigid and "ESTIFF" in r.lines.get(n, {})]
    for number in used:
        r.once(group[PROPS], number)
        r.outlines[number] = outline
    return bool(used), len(used) == len(numbers)


def of_sizes(kind: str, sizes: list[Any]) -> Section:
    """Outline from the sizes of a type."""
    if kind == "rect":
        width, thickness = sizes
        return Rectangle(width, thickness, NONE)
    if kind == "recthol":
        width, thickness, inner_y, inner_z = sizes
        return HollowRectangle(width, thickness, (width - inner_y) / 2, (thickness - inner_z) / 2, NONE)
    if kind == "circ":
        return Circle(sizes[0], NONE)
    outer, inner = sizes
    return Tube(outer, (outer - inner) / 2, NONE)


def outline_sizes(section: Section) -> tuple[str, list[Any]] | None:
    """Type and sizes of a section with an outline; None for another section."""
    outline: Any = section.outline if isinstance(section, Rigidity) else section
    if isinstance(outline, Rectangle):
        return "rect", [outline.width, outline.thickness]
    if isinstance(outline, HollowRectangle):
        inner = outline.width - 2 * outline.wall_y, outline.thickness - 2 * outline.wall_z
        return "recthol", [outline.width, outline.thickness, *inner]
    if isinstance(outline, Circle):
        return "circ", [outline.diameter]
    if isinstance(outline, Tube):
        return "circhol", [outline.diameter, outline.diameter - 2 * outline.wall]
    return None


def disagreement(section: Rigidity) -> str:
    """Disagreement of the rigidities and the sizes of a section; empty if they agree or are traced."""
    if section.outline is None or not known(section.EA) or not known(section.EIy) or not known(section.EIz):
        return ""
    sized_by = section.outline.rigidity()
    if not all(map(known, (sized_by.EA, sized_by.EIy, sized_by.EIz))) or not section.EA:
        return ""
    stated = {n: float(getattr(section, n)) / float(section.EA) for n in ("EIy", "EIz") if getattr(section, n)}
    sized = {n: float(np.asarray(getattr(sized_by, n) / sized_by.EA)) for n in ("EIy", "EIz")}
    wrong = [n for n in stated if abs(sized[n] / stated[n] - 1) > SIZES_ALIKE]
    if not wrong:
        return ""
    values = ", ".join(f"{n}/EA is {stated[n]:.4g} m^2 by ESTIFF and {sized[n]:.4g} by {SIZES}" for n in wrong)
    other = {"EIy": "EIz", "EIz": "EIy"}
    turned = all(abs(sized[other[n]] / value - 1) <= SIZES_ALIKE for n, value in stated.items())
    hint = ": the first size lies along local y, the second along local z; exchanged they agree" if turned else ""
    return f"sizes do not agree with the stiffness: {values}{hint}; stress follows from the sizes"
