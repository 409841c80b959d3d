"""Read SPACAR input files (.dat) as Builders: every line has an effect, or raises an error or a warning."""

import contextlib
import dataclasses
import difflib
import os
import re
from collections.abc import Callable, Iterator, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..build.builder import Builder
from ..build.clamps import with_clamps
from ..build.description import Member
from ..compilation.compile import unguarded
from ..display import Result, Summary, listed
from ..elements import spatial
from ..errors import ModelError, SpacarError, heard, printable
from ..model.topology import Role
from . import actions as act
from . import outlines, trajectories
from . import series as series
from .keywords import APPLY, DECLARE, DESCRIBE, DRAWN, KEYWORDS, REFUSED, ROWS, TABLE, UNKNOWN_MOTION, Row
from .kinds import KINDS, ElementKind
from .lines import BLOCKS, DRAWING, Fault, Statement, known, parse, placeholders, read_text, statements
from .reading import MOST_FAULTS, AlreadyReported, Declared, EnoughFaults, Reading

SHOWN_LINES = 20


@dataclasses.dataclass(frozen=True, repr=False)
class SpacarModel(Result):
    """The contents of a SPACAR input file.

    Attributes:
        builder: Mechanism; nodes and elements have their numbers as names, "3" and "1".
        warnings: Lines without effect, one text each with file, line and keyword.
        name: Name of the file.
        settings: Lines beside the mechanism, by keyword: TIMESTEP, ERROR and ITERSTEP as dictionaries; STARTDX, STARTDE
            as lists of (node or element, component, value, velocity); INPUTX, INPUTE as lists of (.., value, velocity,
            acceleration); TRAJX, TRAJE as lists of (.., start, end, value, law, line); NOMF, NOMS, REFX, REFE and the
            like as lists of (number, node or element, component, line); USERSIG, USERINP as (name, function);
            VISUALIZATION as a list of lines.
        text: Text of the file.
        parameters: Names in the placeholders of the file.
    """

    builder: Builder
    warnings: list[str]
    name: str
    settings: dict[str, Any]
    text: str = ""
    parameters: tuple[str, ...] = ()

    def summary(self) -> Summary:
        """Return the contents beside the mechanism."""
        rows = {"elements": str(len(self.builder.members)), "settings": listed(sorted(self.settings))}
        rows |= {"parameters": listed(self.parameters), "warnings": str(len(self.warnings))}
        return Summary(f"SpacarModel: {self.name}", rows)


@unguarded
def read_spacar(
    path_or_text: str | os.PathLike,
    *,
    callables: Mapping[str, Callable[..., Any]] | None = None,
    numbers: Mapping[str, Any] | None = None,
) -> SpacarModel:
    """Read a SPACAR input file.

    Deformations are FIXED and coordinates DEPENDENT by default. Some keywords are flexmb's own:

    - PLSBEAM and SBEAM are spectral beams of order p (default 4). In RLSE, DYNE, ESIG and EINIT the numbers of a beam's
      deformations mean whole strain fields; numbers from 4 in the plane and 7 in space mean single coefficients.
    - LEAF and PLLEAF are leaf springs of order p (default 6) with the rectangle of SECTION. RLSE and DYNE accept the
      same numbers as for spectral beams; single coefficients in space start at 9. Free warping is a separate degree of
      freedom. CLAMP states the clamped ends; without CLAMP flexmb finds them.
    - PLBELT has radii, positive if the belt passes to the left of the centre on the way from p to q.
    - SCREW has the deformations 1: displacement minus pitch times turn, 2: turn, 3 and 4: displacement off the axis, 5
      and 6: tilt.

    Args:
        path_or_text: Path of a file, or its text if it has more than one line.
        callables: User routines by the names in USERSIG and USERINP.
        numbers: Values of the names in placeholders such as "{t}" or "{pi*t**2/4}"; they may be traced. pi is known.

    Returns:
        SpacarModel with a Builder that is not built yet, so that you can add nodes and elements.

    Raises:
        SpacarError: The file is wrong. The message has one line per fault, with file, line number and keyword.
        OSError: The file cannot be read.
        TypeError, ValueError: A number or a user routine is wrong.
    """
    # A placeholder without names, such as "{2*pi}", needs no numbers.
    callables, numbers = callables or {}, numbers or {}
    _check_arguments(callables, numbers)
    name, text = _source(path_or_text)
    r = Reading(dict(callables))
    with contextlib.suppress(EnoughFaults):
        _read(r, statements(text, numbers))
    if r.faults:
        more = [f"{name}: more than {MOST_FAULTS} faults; the others are not listed"] * (len(r.faults) >= MOST_FAULTS)
        raise SpacarError("\n".join([*(f"{name}:{line}: {text}" for line, text in sorted(r.faults)), *more]))
    warnings = [f"{name}:{s.line}: {s.keyword}: {text}" for s, text in sorted(r.warnings, key=lambda w: w[0].line)]
    parameters = placeholders(r.statements)
    routines = {r.settings[keyword][0] for keyword in ("USERSIG", "USERINP") if keyword in r.settings}
    unused = [f"parameter '{printable(n)}'" for n in numbers if n not in parameters]
    unused += [f"user routine '{printable(n)}'" for n in callables if n not in routines]
    warnings += [f"{name}: {what} does not occur in the file" for what in unused]
    return SpacarModel(r.builder, warnings, name, r.settings, text, parameters)


def _check_arguments(callables: Mapping[str, Any], numbers: Mapping[str, Any]) -> None:
    for name, value in callables.items():
        if not callable(value):
            raise TypeError(f"Argument `callables`: '{printable(name)}' must be a function, but is {printable(value)}.")
    if "pi" in numbers:
        raise ValueError("Argument `numbers`: 'pi' is 3.14159.. in every file; give the parameter another name.")
    for name, value in numbers.items():
        where = f"Argument `numbers`: '{printable(name)}'"
        scalar = isinstance(value, Real) or getattr(value, "shape", None) == ()
        if not scalar or isinstance(value, bool) or (known(value) and np.asarray(value).dtype.kind not in "iuf"):
            raise TypeError(f"{where} must be a real number, but is {printable(value)}.")
        if known(value) and not np.isfinite(float(value)):
            raise ValueError(f"{where} must be a finite number, but is {printable(value)}.")


def _source(path_or_text: str | os.PathLike) -> tuple[str, str]:
    """Name and text of a file."""
    if isinstance(path_or_text, str) and (set("\r\n") & set(path_or_text) or not path_or_text.strip()):
        return "text", path_or_text.removeprefix("\ufeff")
    return printable(Path(path_or_text).name), read_text(path_or_text)


def _read(r: Reading, lines: Iterator[Statement]) -> None:
    """Act on all lines, in the order in which they depend on each other."""
    placed = list(_Blocks(r).rows(lines))
    for stage in (DECLARE, DESCRIBE):
        _run(r, placed, stage)
    outlines.take(r)
    _build(r)
    _run(r, placed, APPLY)
    _connect_signals(r)
    if not r.faults:
        trajectories.check_trajectories(r)
    if not r.faults:
        _check_clamps(r)
    for number, declared in r.elements.items():
        if (member := r.builder.members.get(str(number))) is not None:
            for text in _without_effect(number, declared.kind, member, r.lines.get(number, {})):
                r.warn(declared.statement, text)
    _warn_of_expansion(r)
    _warn_of_drawing(r)
    if not r.elements and not r.faults:
        problem = "has no element" if r.statements else "is empty"
        r.faults.append((1, f"file {problem}; it needs at least one, such as {KINDS[0].keyword} {KINDS[0].form}"))


class _Blocks:
    """The place of a line in the file: in a block, after END, or in the visualization section."""

    def __init__(self, r: Reading):
        self.reading, self.block, self.ends, self.drawing = r, 0, 0, False

    def rows(self, lines: Iterator[Statement]) -> Iterator[tuple[Row, Statement]]:
        """Rows of the keyword table for lines that have one; other lines are handled here."""
        for s in lines:
            self.reading.statements.append(s)
            try:
                row = self._row(s)
            except Fault as fault:
                self.reading.blame(s, str(fault), _form(s.keyword))
                if _may_declare(s.keyword):
                    self.reading.excused |= s.numbers
                if _similar_keyword(s.keyword) == "SECTION":
                    self.reading.unsized |= s.numbers
            else:
                if row is not None:
                    yield row, s
        if self.reading.statements and self.ends < 2:
            last = Statement(self.reading.statements[-1].line, "END", "END")
            text = f"{2 - self.ends} END missing at the end; flexmb reads the file as if it were there"
            self.reading.warn(last, text)

    def _row(self, s: Statement) -> Row | None:
        if s.keyword in ("END", "HALT"):
            parse(s.keyword, "", s.words)
            return self._end() if s.keyword == "END" else self._halt(s)
        self.drawing = self.drawing or s.keyword == DRAWING.upper()
        if s.keyword in DRAWN or (self.drawing and not _homes(s.keyword)):
            return act.drawing(self.reading, s)
        if s.keyword in REFUSED or (s.keyword.startswith("TR") and not _homes(s.keyword)):
            raise Fault(REFUSED.get(s.keyword, UNKNOWN_MOTION))
        if self.drawing:
            raise Fault(f"belongs in the {_homes(s.keyword)[0]} block, but is in the visualization section")
        if self.ends and _homes(s.keyword):
            self._resume(s)
        return _row(s, BLOCKS[self.block])

    def _end(self) -> None:
        self.ends += 1
        if self.ends > 2 and not self.drawing:
            raise Fault("comes after the last END; a file ends with END END")

    def _halt(self, s: Statement) -> None:
        if self.block + 1 == len(BLOCKS):
            raise Fault(f"announces another block, but none is known after {BLOCKS[-1]}")
        if self.ends != 1:
            self.reading.blame(s, "must follow the END of a block" if not self.ends else "stands after the last END")
        self.block, self.ends = self.block + 1, 0

    def _resume(self, s: Statement) -> None:
        """Continue after END as if HALT stood there: one missing line is one fault."""
        later = [i for i in range(self.block + 1, len(BLOCKS)) if BLOCKS[i] in _homes(s.keyword)]
        if self.ends > 1 or not later:
            raise Fault("comes after END; only HALT and a later block, or a VISUALIZATION section, may follow")
        self.reading.blame(s, f"HALT is missing before the {BLOCKS[later[0]]} block", _form(s.keyword))
        self.block, self.ends = later[0], 0


def _homes(keyword: str) -> list[str]:
    return [row.block for row in ROWS if row.keyword == keyword]


def _form(keyword: str) -> str:
    """Form of a keyword; for a refused one, its subject."""
    if keyword in REFUSED:
        return "node" if keyword == "KINX" else "element"
    return next((row.form for row in ROWS if row.keyword == keyword), "")


def _similar_keyword(keyword: str) -> str | None:
    if len(keyword) > 2 * max(map(len, KEYWORDS)):
        return None
    return next(iter(difflib.get_close_matches(keyword, KEYWORDS, 1, 0.7)), None)


def _may_declare(keyword: str) -> bool:
    """Whether a faulty line may have been one that introduces nodes and elements."""
    similar = _similar_keyword(keyword)
    return similar is None or similar in REFUSED or similar in {kind.keyword for kind in KINDS}


def _row(s: Statement, block: str) -> Row:
    if (s.keyword, block) in TABLE:
        return TABLE[s.keyword, block]
    if homes := _homes(s.keyword):
        raise Fault(f"belongs in the {homes[0]} block, but is in the {block} block; END, HALT separate the blocks")
    similar = _similar_keyword(s.keyword)
    raise Fault("unknown keyword" + (f"; did you mean {similar}?" if similar else ""))


def _run(r: Reading, placed: list[tuple[Row, Statement]], stage: int) -> None:
    """Act on the lines of one stage."""
    for row, s in placed:
        if row.stage != stage:
            continue
        try:
            row.action(r, s, parse(row.keyword, row.form, s.words))
        except AlreadyReported:
            pass
        except (Fault, ModelError) as fault:
            r.blame(s, _without_name(str(fault)), row.form)
            if stage == DECLARE:
                r.excused |= s.numbers
            elif row.action is act.position:
                r.misplaced |= s.numbers
            elif row.action is act.section:
                r.unsized |= s.numbers


def _without_name(text: str) -> str:
    """A message without the name of the element, which stands before it."""
    return re.sub(r"^Element '\d+' (\(\w+\) )?", "", text)


def _build(r: Reading) -> None:
    """Add nodes in the order of their numbers, then elements in the order of the file."""
    first = next(iter(r.elements.values()), None)
    r.builder.dimension = first.kind.dimension if first else None
    for number, (kind, line) in sorted(r.nodes.items()):
        if kind.part in ("rotation", "warping"):
            (r.builder.rotation if kind.part == "rotation" else r.builder.warping)(str(number))
            continue
        if number in r.misplaced:
            # Any place apart from the others, to find further faults of its elements.
            r.positions.setdefault(number, [float(number) ** (i + 1) for i in range(kind.size)])
        if number not in r.positions:
            r.warn(line, f"node {number} has no X and is placed at the origin")
        r.builder.node(str(number), r.positions.get(number, [0.0] * kind.size))
    for number, declared in r.elements.items():
        kind, lines = declared.kind, r.lines.get(number, {})
        if kind.sized and "SECTION" not in lines and number in r.unsized:
            continue
        try:
            _check_rigid(r, declared)
            if kind.sized and "SECTION" not in lines:
                form = f"SECTION {number} width thickness E G rho [alpha]"
                raise Fault(f"needs its section in the dynamics block: {form}")
            element = kind.element_of(declared.order, lines.get("ESTIFF", []))
            properties = kind.properties(lines, declared.vector, declared.numbers)
            if number in r.outlines:
                properties["section"] = dataclasses.replace(properties["section"], outline=r.outlines[number])
                if text := outlines.disagreement(properties["section"]):
                    r.warn(declared.statement, f"element {number}: {text}")
            r.builder.add(element, *_names_of_nodes(r, declared), name=str(number), released=(), **properties)
        except (Fault, ModelError) as fault:
            if r.misplaced.isdisjoint(declared.nodes):
                r.blame(declared.statement, _without_name(str(fault)), kind.form)


def _names_of_nodes(r: Reading, declared: Declared) -> list[str]:
    """Nodes of an element; for a leaf spring in space with the warping of BEAMW at its ends, or its own."""
    names = [str(n) for n in declared.nodes]
    if not declared.kind.sized or declared.kind.dimension == 2:
        return names
    node_names = []
    for name, node in zip(names, declared.nodes, strict=True):
        node_names.append(name)
        if r.nodes[node][0].part == "rotation":
            beams = [d.nodes for d in r.elements.values() if d.kind.warps and node in d.nodes]
            shared = sorted({nodes[nodes.index(node) + 1] for nodes in beams})
            if len(shared) > 1:
                several = listed([str(n) for n in shared])
                raise Fault(f"shares the warping of node {node}, where BEAMW names several: {several}")
            node_names.append(str(shared[0]) if shared else f"{name}.warping")
    return node_names


def _check_rigid(r: Reading, declared: Declared) -> None:
    """Refuse a rigid beam without length."""
    if declared.kind.keyword in ("RBEAM", "PLRBEAM"):
        p, q = (r.builder.nodes[str(n)].start for n in (declared.nodes[0], declared.nodes[-1]))
        if all(map(known, (*p, *q))) and not np.linalg.norm(np.subtract(q, p)):
            pin = "PINBODY" if declared.kind.dimension == 3 else "PLPINBODY"
            raise Fault(f"has zero length: its two ends have the same position; {pin} joins coincident nodes")


def _check_clamps(r: Reading) -> None:
    """Report at its line if clamped ends of a leaf spring cannot be found."""
    members = r.builder.members.values()
    if not is_concrete(([n.start for n in r.builder.nodes.values()], [m.properties for m in members])):
        return
    try:
        with heard():
            with_clamps(r.builder, None)
    except ModelError as fault:
        declared = r.elements[int(re.findall(r"'(\d+)'", str(fault))[0])]
        r.blame(declared.statement, re.sub(r"^Element '\d+': ", "", str(fault)), declared.kind.form)


def _without_effect(number: int, kind: ElementKind, member: Member, lines: dict[str, Any]) -> Iterator[str]:
    """Warnings of an element that is rigid despite its lines, or that lacks stiffness."""
    rigid = all(role is Role.FIXED for role in member.roles)
    words = [keyword for keyword in ("ESTIFF", "EDAMP") if keyword in lines]
    if kind.element is spatial.screw and member.roles[1] is Role.FIXED:
        yield f"the turn of screw {number}, deformation 2, is fixed; release it by RLSE, DYNE or INPUTE"
    if kind.sized and all(member.roles[n - 1] is Role.FIXED for field in member.element.fields for n in field):
        numbers = " ".join(map(str, range(1, series.closure(member.element) + 1)))
        yield f"element {number} is rigid: RLSE {number} {numbers} makes it a leaf spring that deforms freely"
    free = any(role in (Role.DEPENDENT, Role.DOF) for role in member.roles)
    if free and "EM" in lines and kind.stiffness and "ESTIFF" not in words:
        yield f"element {number} has mass and free deformations, but no ESTIFF: it has no stiffness"
    if words and rigid:
        numbers = " ".join(map(str, range(1, len(member.roles) + 1)))
        yield (
            f"{' and '.join(words)} of element {number} {'has' if len(words) == 1 else 'have'} no effect: the element"
            f" is rigid; RLSE {number} {numbers} lets it deform"
        )


def _warn_of_expansion(r: Reading) -> None:
    """Warn of ALPHA at constant temperature."""
    for number, lines in r.lines.items():
        if "ALPHA" in lines and ("TEMP", number) not in r.given and ("DELTEMP", number) not in r.given:
            lines_needed = f"TEMP {number} value or DELTEMP {number} value"
            text = f"of element {number} has no effect without a temperature: {lines_needed}"
            r.warn(r.given["ALPHA", number], text)


def _warn_of_drawing(r: Reading) -> None:
    """Warn once of all lines for drawing."""
    if r.drawn:
        named = [f"{printable(s.keyword)} (line {s.line})" for s in r.drawn[:SHOWN_LINES]]
        named += [f"{len(r.drawn) - SHOWN_LINES} more"] * (len(r.drawn) > SHOWN_LINES)
        text = f"drawing keywords are stored in settings and have no effect on results: {', '.join(named)}"
        r.warn(r.drawn[0], text)


def _connect_signals(r: Reading) -> None:
    """Add inputs and outputs in the order of their numbers, which must be complete."""
    for side, signals in r.signals.items():
        for place, (number, (s, add)) in enumerate(sorted(signals.items()), 1):
            if number > place and place not in signals:
                r.blame(s, f"{side} {place} is missing; {side}s are numbered from 1 without gap", "number")
                break
            if add is not None:
                add()
