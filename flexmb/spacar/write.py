"""Write Builders as SPACAR input files."""

from __future__ import annotations

import dataclasses
import itertools
import os
import re
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..build.assemble import stack
from ..build.builder import Builder
from ..build.clamps import with_clamps
from ..build.description import Member
from ..elements import planar, spatial
from ..elements.element import Element
from ..elements.general import General
from ..elements.nodes import ROTATION3
from ..elements.sections import MaterialDamping, Rectangle, Section
from ..errors import ModelError, printable
from ..files import write_whole
from ..model.by_name import TURNS
from ..model.topology import Role
from ..numerical_limits import ROUND_OFF
from . import outlines, trajectories
from . import series as series
from .actions import start_of
from .kinds import KINDS, NOTHING, ElementKind
from .lines import DRAWING, LARGEST, MOST, SMALLEST, is_zero, known, within
from .read import SpacarModel
from .trajectories import keyword_of

# Elements that become lines of a node, by their property.
_LUMPED = {
    "mass": (planar.mass, spatial.mass),
    "inertia": (planar.inertia, spatial.inertia),
    "moment": (spatial.moment,),
}


@dataclasses.dataclass(frozen=True)
class WrittenLine:
    """One line of a file: keyword, and words, whole numbers and real numbers, which may be traced."""

    keyword: str
    values: tuple[Any, ...]


def line_text(line: WrittenLine | str) -> str:
    """One line as text, real numbers with all their digits."""
    if isinstance(line, str):
        return line
    text = " ".join([line.keyword, *(str(v) if isinstance(v, int | str) else repr(float(v)) for v in line.values)])
    for value in line.values:
        if not isinstance(value, int | str) and not within(value):
            size = f"0 or from {SMALLEST:g} to {LARGEST:g} in size"
            raise ModelError(f"'{printable(text)}' cannot be written to a SPACAR input file: numbers must be {size}.")
    return text


def line_of(keyword: str, *values: Any) -> WrittenLine:
    """A line of a keyword and what follows it."""
    return WrittenLine(keyword, values)


def flat_numbers(value: Any) -> list[Any]:
    """Numbers of a scalar, an array or a sequence, which may be traced."""
    if is_concrete(value):
        return np.ravel(np.asarray(value, float)).tolist()
    if isinstance(value, list | tuple):
        return [number for entry in value for number in flat_numbers(entry)]
    return [value] if np.ndim(value) == 0 else [value[i] for i in range(len(value))]


def number_for_line(value: Any) -> Any:
    """A number for a line."""
    return float(np.asarray(value)) if known(value) else value


def trimmed(values: list[Any]) -> list[Any]:
    """Values without zeros at the end, except the first."""
    while len(values) > 1 and is_zero(values[-1]):
        values = values[:-1]
    return values


def write_spacar(model: SpacarModel | Builder, path: str | os.PathLike) -> None:
    """Write a mechanism as a SPACAR input file that :func:`read_spacar` reads back to the same mechanism.

    Nodes and elements whose names are no numbers get numbers; comments contain their names. Sections become rigidities,
    and sizes for drawing (CROSSTYPE, CROSSDIM). From these sizes, a model read from the file computes stress, but does
    not compare it with strength or fatigue limit. Sections of leaf springs become SECTION. The file does not contain
    comments of a file that was read, names of inputs and outputs, and user routines. It contains only degrees of
    freedom that are named with ``dof()``, not the ones that ``build()`` finds.

    Args:
        model: Builder, or a result of read_spacar with its settings.
        path: Path of the file. If writing fails, an existing file stays unchanged.

    Raises:
        ModelError: The format cannot express a part of the mechanism.
        OSError: The folder is missing or not writable.
    """
    builder = model if isinstance(model, Builder) else getattr(model, "builder", None)
    if not isinstance(builder, Builder):
        raise ModelError(f"write_spacar needs a Builder or a result of read_spacar, not {type(model).__name__}.")
    settings = {} if isinstance(model, Builder) else model.settings
    write_whole(path, ("\n".join(map(line_text, lines_of(builder, settings))) + "\n").encode())


def lines_of(builder: Builder, settings: dict[str, Any], like: Builder | None = None) -> list[WrittenLine | str]:
    """Lines of the file of a mechanism; ``like`` is the same mechanism with concrete numbers, if it is traced."""
    numbers = [n.start for n in builder.nodes.values()], [m.properties for m in builder.members.values()]
    if like is None and not is_concrete((numbers, builder.loads)):
        raise ModelError("The model has traced numbers. Write it outside of the transformation.")
    return _Writer(builder, settings, like).lines()


def _numbered(names: list[str]) -> dict[str, int]:
    """Number of each name: the name itself if it is a number, otherwise the next free one."""
    numbers = {name: int(name) for name in names if re.fullmatch("[1-9][0-9]{0,8}", name)}
    used, last = set(numbers.values()), max(numbers.values(), default=0)
    free = (n for n in itertools.chain(range(last + 1, MOST + 1), itertools.count(1)) if n not in used)
    return {name: numbers[name] if name in numbers else next(free) for name in names}


def no_element_message(node: str) -> str:
    """Message about a node that no element joins."""
    return f"Node '{node}' is in no element. A SPACAR input file cannot contain it."


def _refuse(refused: bool, label: str, instead: str = "") -> None:
    if refused:
        raise ModelError(f"{label}, which a SPACAR input file cannot express{instead}.")


class _Nodes(dict[str, int]):
    """Number of each node with a number in the format."""

    def __missing__(self, name: str):
        if name.endswith(".warping"):
            raise ModelError(
                f"'{name}' has a role, a load or a signal, but a SPACAR input file has no number for warping. Leave it"
                " out: free warping is a separate degree of freedom, and `clamped` of the element constrains it."
            )
        raise ModelError(
            f"'{name}' contains coordinates of an element, for which a SPACAR input file has no number. Name the"
            " deformations of the element instead."
        )


class _Writer:
    """Lines of the file, block by block."""

    def __init__(self, builder: Builder, settings: dict[str, Any], like: Builder | None = None):
        self.builder, self.settings = builder, settings
        self.concrete = like or builder
        self.rigidities: dict[int, Any] = {}
        self.warmed = {owner for loads in builder.loads.values() for _, owner, _ in loads.get("temperature", {})}
        self.shown = {name: m for name, m in builder.members.items() if not m.hidden}
        self.hidden = [m for m in builder.members.values() if m.hidden]
        self.kinds = {name: self._kind(name, m) for name, m in self.shown.items()}
        named = {node for name, m in self.shown.items() for node in self._named(name, m)}
        self.node = _Nodes(_numbered([n for n in builder.nodes if n in named]))
        self.element = _numbered(list(self.shown))
        # Files state which warping is held; a build finds it.
        warps = any(kind.warps for kind in self.kinds.values())
        self.clamped = with_clamps(self.concrete, None) if warps else builder
        if like is None:
            self._check()

    def lines(self) -> list[WrittenLine | str]:
        """All lines of the file."""
        signals, drawn = self._signals(), self.settings.get(DRAWING.upper(), [])
        third = ["END", "HALT", *signals, "END", "END"] if signals else ["END", "END"]
        drawn = self._outlines(drawn) + [line for line in drawn if line.upper().split() != [outlines.TITLE]]
        drawn = [outlines.TITLE, *drawn] if drawn else []
        return [*self._legend(), *self._kinematics(), "END", "HALT", *self._dynamics(), *third, *drawn]

    def _outlines(self, drawn: list[str]) -> list[WrittenLine]:
        """Sizes of cross-sections, without elements whose lines are kept unchanged."""
        words = [line.split() for line in drawn]
        existing = {word for first, *rest in words if first.upper() == outlines.PROPS for word in rest}
        groups: dict[tuple, tuple[Any, list[int]]] = {}
        for name, m in self.shown.items():
            section, number = m.properties.get("section"), self.element[name]
            outline = (
                None if section is None or "EA" not in self.kinds[name].stiffness else outlines.outline_sizes(section)
            )
            if outline is not None and str(number) not in existing:
                sizes = [number_for_line(size) for size in outline[1]]
                key = (outline[0], *(size if known(size) else id(section) for size in sizes))
                groups.setdefault(key, (sizes, []))[1].append(number)
        lines = []
        for (kind, *_), (sizes, numbers) in groups.items():
            lines += [line_of(outlines.PROPS, *numbers), line_of(outlines.TYPE, kind), line_of(outlines.SIZES, *sizes)]
        return lines

    def _named(self, name: str, member: Member) -> list[str]:
        """Nodes on the line of an element."""
        parts = [kind.part for kind in self.kinds[name].node_kinds]
        kinds = member.element.nodes.values()
        return [node for node, kind in zip(member.nodes, kinds, strict=True) if kind.part in parts]

    def _kind(self, name: str, member: Member) -> ElementKind:
        kinds = [kind for kind in KINDS if kind.element.usual == member.element.usual]
        label = f"Element '{name}' ({member.element.name})"
        if not kinds:
            known = ", ".join(sorted({f"{k.element.name}" for k in KINDS}))
            raise ModelError(
                f"{label} has no keyword in a SPACAR input file. There are: {known}. Use a beam without section and"
                " without released deformations as a body that is clamped at both ends."
            )
        given = {key for key, value in member.properties.items() if value is not None}
        first_order = member.element.options.get("second_order", True) is not True
        _refuse(first_order, f"{label} has second_order=False")
        _refuse("curvature" in given, f"{label} has an initial curvature")
        _refuse(bool(given & {"skew", "clamp"}), f"{label} has skew or elastic ends")
        if member.element.fields:
            return kinds[0]
        # The format calls a rigid beam without length a pinned body.
        p, q = (np.asarray(self.concrete.nodes[n].start, float) for n in (member.nodes[0], member.nodes[-1]))
        return kinds[-1] if len(kinds) > 1 and np.array_equal(p, q) else kinds[0]

    def _check(self) -> None:
        """Refuse everything that the format cannot express."""
        joined = {node for m in self.shown.values() for node in m.nodes}
        if not self.shown:
            raise ModelError("The model has no elements. Add at least one.")
        for m in self.builder.members.values():
            if m.element in (planar.follower_force, spatial.follower_force, spatial.follower_moment):
                raise ModelError(f"The load that follows node '{m.nodes[0]}' cannot be expressed in a SPACAR file.")
            if m.element in (planar.body, spatial.body):
                raise ModelError(
                    f"The body on node '{m.nodes[0]}' cannot be expressed in a SPACAR file. Put its mass and inertia on"
                    " a node in its centre, and join it by a rigid beam."
                )
        for name, m in self.shown.items():
            label, section = f"Element '{name}' ({m.element.name})", m.properties.get("section")
            self._check_closure(label, name, m)
            _refuse(section is not None and section.varies, f"{label} has a section that varies along it")
            _refuse(isinstance(section, General), f"{label} has a section of general stiffness")
            if section is not None and isinstance(m.properties.get("damping"), MaterialDamping):
                self._check_damping(label, self.kinds[name], section)
            if self.kinds[name].sized:
                self._check_leaf(label, m)
        for name, node in self.builder.nodes.items():
            if name not in joined:
                raise ModelError(no_element_message(name))
            turned = node.kind.part == "rotation" and tuple(flat_numbers(node.start)) != node.kind.start
            _refuse(turned, f"Node '{name}' starts turned")
        if "gravity" in self.builder.loads["increment"]:
            raise ModelError("Gravity as an increment cannot be expressed in a SPACAR input file.")

    def _check_closure(self, label: str, name: str, m: Member) -> None:
        """Refuse statements about the closure, whose numbers mean strain fields in a file, and about warping."""
        closed = range(1, series.closure(m.element) + 1)
        warping = series.warping(m.element)
        # Temperatures belong to whole elements.
        sets = [load for loads in self.builder.loads.values() for kind, load in loads.items() if kind != "temperature"]
        loaded = [key for load in sets for key, value in load.items() if value != 0]
        inputs, outputs = ([signal.key for signal in self.builder.signals[side]] for side in ("input", "output"))
        values = [*loaded, *inputs, *outputs]
        taken = any(m.roles[n - 1] is not Role.FIXED or ("element", name, n) in values for n in closed)
        _refuse(taken, f"{label} has a role, a load or a signal at deformations 1 to {len(closed)} (closure)")
        acted_on = [*loaded, *inputs]
        taken = any(m.roles[n - 1] is not Role.DEPENDENT or ("element", name, n) in acted_on for n in warping)
        numbers = " and ".join(f"{n}" for n in (*warping[:1], *warping[-1:]))
        _refuse(taken, f"{label} has a role, a load or an input at its warping, deformations {numbers}")

    @staticmethod
    def _check_damping(what: str, kind: ElementKind, section: Section) -> None:
        """Refuse material damping of warping or shear, for which EDAMP has no numbers."""
        without = ["warping"] if kind.warps else []
        sheared = [n for n in kind.stiffness if n.startswith("shear")]
        if sheared and not all(is_zero(getattr(section.rigidity(), n)) for n in sheared):
            without.append("shear")
        damped = f"{what} is damped by its material and its {' and its '.join(without)} too"
        _refuse(bool(without), damped, ": give `damping`")

    def _check_leaf(self, label: str, m: Member) -> None:
        """Refuse leaf springs that are no rectangle of one material, or whose warping belongs to other rotations."""
        section: Rectangle = m.properties["section"]
        material = section.material
        extras = [f for f in ("strength", "fatigue", "damping") if getattr(material, f) is not None]
        if material.nu is not None:
            difference = abs(float(material.nu) - float(material.E / (2 * material.shear_modulus()) - 1))
            extras += ["nu other than E/(2 G) - 1"] if difference > ROUND_OFF else []
        extras += ["torsion by an approximation"] if section.torsion != "series" else []
        extras += [] if section.rotary else ["no rotary inertia"]
        numbers = ": SECTION gives width, thickness, E, G, rho and alpha"
        _refuse(bool(extras), f"{label}: its section has {', '.join(extras)}", numbers)
        for rotation, warping in zip(m.nodes_of_kind("rotation"), m.nodes_of_kind("warping"), strict=False):
            beams = [b.nodes for n, b in self.shown.items() if self.kinds[n].warps and rotation in b.nodes]
            shared = {nodes[nodes.index(rotation) + 1] for nodes in beams}
            if {warping} != (shared or {f"{rotation.removesuffix('.rotation')}.warping"}):
                raise ModelError(
                    f"{label} has the warping '{warping}' at '{rotation}'. In a SPACAR input file it has the warping of"
                    " the rotation, or the warping of all warping beams there."
                )

    def _legend(self) -> list[str]:
        """Comments with names that are no numbers."""
        named = [("node", *entry) for entry in self.node.items()]
        named += [("element", *entry) for entry in self.element.items()]
        return [f"% {kind} {number}: {' '.join(name.split())}" for kind, name, number in named if str(number) != name]

    def _kinematics(self) -> list[WrittenLine]:
        lines, clamps = [], []
        for name, m in self.shown.items():
            keyword, vector = self.kinds[name].keyword, m.properties.get("y", m.properties.get("axis"))
            if keyword in ("RBEAM", "SBEAM", "LEAF") and vector is None:
                vector = self._across(m)
            nodes = [self.node[n] for n in self._named(name, m)]
            order = [len(m.element.fields[0])] if m.element.fields else []
            across = [] if vector is None else flat_numbers(vector)
            others = [number_for_line(m.properties[prop]) for _, prop in self.kinds[name].numbers]
            lines.append(line_of(keyword, self.element[name], *nodes, *across, *others, *order))
            # FIX holds the ends of warping beams.
            clamped = None if self.kinds[name].warps else m.properties.get("clamped")
            clamps += [] if clamped is None else [line_of("CLAMP", self.element[name], *map(int, clamped))]
        lines += clamps
        places = [(name, node.start) for name, node in self.builder.nodes.items() if node.kind.part == "position"]
        lines += [line_of("X", self.node[name], *flat_numbers(start)) for name, start in places]
        for name, node in self.builder.nodes.items():
            if name in self.node or any(role is not Role.DEPENDENT for role in node.roles):
                roles = self.clamped.nodes[name].roles
                lines += self._roles(self.node[name], roles, {Role.FIXED: "FIX", Role.PRESCRIBED: "INPUTX"})
        for name, m in self.shown.items():
            keywords = {Role.DEPENDENT: "RLSE", Role.PRESCRIBED: "INPUTE"}
            lines += self._roles(self.element[name], m.roles, keywords, m.element)
        # One line each: their order is the order of q.
        for (kind, owner), run in itertools.groupby(self.builder.dofs, key=lambda key: key[:2]):
            numbers = [number for *_, number in run]
            numbers = numbers if kind == "node" else series.shortened(self.shown[owner].element, numbers)
            letter, at = self._place(kind, owner)
            lines += [line_of(f"DYN{letter}", at, number) for number in numbers]
        return lines

    def _across(self, m: Member) -> np.ndarray:
        """Default local y of a beam that needs one in the format."""
        nodes = [self.concrete.nodes[n] for n in m.nodes]
        p, q = (np.asarray(node.start, float) for node in nodes if node.kind.part == "position")
        return np.eye(3)[np.argmin(np.abs(q - p))]

    @staticmethod
    def _roles(
        number: int, roles: list[Role], keywords: dict[Role, str], element: Element | None = None
    ) -> list[WrittenLine]:
        lines = []
        for role, keyword in keywords.items():
            having = [i for i, r in enumerate(roles, 1) if r is role]
            if element is not None and keyword == "RLSE":
                having = [n for n in having if n not in element.measured]
                having = series.shortened(element, series.in_whole_fields(element, having))
            if having:
                all_fixed = keyword == "FIX" and len(having) == len(roles)
                lines.append(line_of(keyword, number, *([] if all_fixed else having)))
        return lines

    def _dynamics(self) -> list[WrittenLine]:
        lines = [line for name, m in self.shown.items() for line in self._section(name, m)]
        lines += self._lumped()
        for increment, prefix in (("initial", ""), ("increment", "DEL")):
            lines += self._loads(self.builder.loads[increment], prefix)
        return lines + self._settings()

    def _section(self, name: str, m: Member) -> list[WrittenLine]:
        kind, number = self.kinds[name], self.element[name]
        lines: list[WrittenLine] = []
        if "stiffness" in kind.stiffness:
            for keyword, value in (("ESTIFF", m.properties["stiffness"]), ("EDAMP", m.properties["damping"])):
                if value is not None:
                    values = flat_numbers(value)
                    values = values * (len(kind.stiffness) if len(values) == 1 else 1)
                    lines.append(line_of(keyword, number, *trimmed(values)))
            return lines
        section, damping, alpha = (m.properties.get(name) for name in ("section", "damping", "alpha"))
        if kind.sized:
            lines.append(line_of("SECTION", number, *_sizes(m.properties["section"])))
        elif section is not None:
            # Many elements share a section, and its torsional rigidity is a long series.
            s = self.rigidities.get(id(section)) or section.rigidity()
            self.rigidities[id(section)] = s
            alpha = s.alpha if alpha is None else alpha
            stiffness, mass = (
                [0.0 if n == NOTHING else number_for_line(getattr(s, n)) for n in names]
                for names in (kind.stiffness, kind.mass)
            )
            # The reader would warn that stiffness of a rigid body has no effect.
            idle = all(role is Role.FIXED for role in m.roles) and all(map(is_zero, stiffness))
            lines += [line_of("ESTIFF", number, *trimmed(stiffness))] if stiffness and not idle else []
            heavy = not all(map(is_zero, mass)) or (mass and not stiffness)
            lines += [line_of("EM", number, *trimmed(mass))] if heavy else []
        # The reader would warn that it has no effect on an element with constant temperature.
        if alpha is not None and name in self.warmed and not kind.sized and m.element.thermal is not None:
            lines.append(line_of("ALPHA", number, number_for_line(alpha)))
        if isinstance(damping, MaterialDamping):
            damping = damping.rigidities(section)
        if damping is not None:
            values = [number_for_line(getattr(damping, n)) for n in kind.damping]
            lines.append(line_of("EDAMP", number, *trimmed(values)))
        return lines

    def _lumped(self) -> list[WrittenLine]:
        """Masses, rotary inertias and moments about fixed axes, summed over each node."""
        totals: dict[tuple[str, str], Any] = {}
        for m in self.hidden:
            names = [name for name, kinds in _LUMPED.items() if m.element in kinds]
            if not names:
                continue
            value, key = m.properties[names[0]], ("XM", m.nodes[0])
            if names == ["moment"]:
                key = ("DELXF" if m.properties.get("incremental") else "XF"), m.nodes[0]
                value = stack(flat_numbers(value))
            totals[key] = totals.get(key, 0.0) + (np.asarray(value, float) if known(value) else value)
            if names == ["mass"] and known(totals[key]) and totals[key] < 0:
                raise ModelError(f"Node '{m.nodes[0]}' has a negative mass. A SPACAR input file cannot contain it.")
        moments_last = sorted(totals.items(), key=lambda item: item[0][0] != "XM")
        return [line_of(keyword, self.node[n], *flat_numbers(v)) for (keyword, n), v in moments_last]

    def _loads(self, loads: dict[str, dict], prefix: str) -> list[WrittenLine]:
        lines = []
        for (_, owner), values in _rows(loads.get("force", {})).items():
            size = 4 if self.builder.nodes[owner].kind is ROTATION3 else 0
            lines.append(line_of(f"{prefix}XF", self.node[owner], *_filled(values, size)))
        for load, keyword in (("prestress", f"{prefix}ESIG"), ("strain", "EINIT")):
            for (_, owner), values in _rows(loads.get(load, {})).items():
                lines.append(line_of(keyword, self.element[owner], *_filled(values)))
        for (kind, owner, number), value in loads.get("prescribed", {}).items():
            start, (letter, at) = start_of(self.builder, kind, owner, number), self._place(kind, owner)
            if prefix:
                lines.append(line_of(f"DELINP{letter}", at, number, value))
            else:
                lines.append(line_of(f"INPUT{letter}", at, number, start + value, *self._rates(letter, at, number)))
        for (_, owner, _), (first, last, *across) in loads.get("temperature", {}).items():
            bent = not all(map(is_zero, flat_numbers(across)))
            is_uniform = first is last or (known(first) and known(last) and np.array_equal(first, last))
            values = [first, last, *across] if bent else [first] if is_uniform else [first, last]
            lines.append(line_of(f"{prefix}TEMP", self.element[owner], *flat_numbers(values)))
        if "gravity" in loads:
            lines.append(line_of("GRAVITY", *loads["gravity"]["all"]))
        return lines

    def _place(self, kind: str, owner: str) -> tuple[str, int]:
        """Letter of keywords about a node or an element, and its number."""
        return ("X", self.node[owner]) if kind == "node" else ("E", self.element[owner])

    def _rates(self, letter: str, owner: int, number: int) -> list[float]:
        motions = self.settings.get(f"INPUT{letter}", [])
        rates = next((g[3:] for g in motions if g[:2] == (owner, number)), ())
        return list(rates) if any(rates) else []

    def _settings(self) -> list[WrittenLine]:
        lines = []
        for keyword in ("ITERSTEP", "TIMESTEP", "ERROR"):
            if keyword in self.settings:
                lines.append(line_of(keyword, *self.settings[keyword].values()))
        for (kind, owner, number), (value, velocity) in self.builder.starts.items():
            start, (letter, at) = start_of(self.builder, kind, owner, number), self._place(kind, owner)
            lines.append(line_of(f"STARTD{letter}", at, number, start + value, velocity))
        for keyword in ("USERSIG", "USERINP"):
            lines += [line_of(keyword, self.settings[keyword][0])] if keyword in self.settings else []
        for keyword, numbers in zip(trajectories.WAYS, (self.node, self.element), strict=True):
            for way in self.settings.get(keyword, []):
                times = way.start, way.end, way.value
                lines.append(line_of(keyword, numbers[str(way.of)], way.component, *map(float, times), way.law))
        return lines

    def _signals(self) -> list[WrittenLine]:
        lines = []
        for side in ("input", "output"):
            for i, signal in enumerate(self.builder.signals[side], 1):
                _refuse(signal.local, f"The {side} '{signal.name}' is about an axis that turns")
                _refuse(bool(signal.parts), f"The {side} '{signal.name}' is a linear combination")
                kind, owner, number = signal.key
                component = number if signal.axis is None else TURNS[signal.axis]
                keyword = keyword_of(side, kind, signal.quantity)
                lines.append(line_of(keyword, i, self._place(kind, owner)[1], component))
        for keyword in (*trajectories.NOMINAL, *trajectories.REFERENCES):
            numbers = self.node if keyword in ("NOMF", "REFX", "REFXP", "REFXDP") else self.element
            for channel in self.settings.get(keyword, []):
                lines.append(line_of(keyword, channel.number, numbers[str(channel.of)], channel.component))
        return lines


def _sizes(section: Rectangle) -> list[Any]:
    """Numbers of SECTION."""
    material = section.material
    values = (section.width, section.thickness, material.E, material.shear_modulus(), material.rho, material.alpha)
    return [number_for_line(value) for value in values if value is not None]


def _rows(entries: dict) -> dict[tuple[str, str], dict[int, Any]]:
    """Values by owner and number."""
    rows: dict[tuple[str, str], dict[int, Any]] = {}
    for (kind, owner, number), value in entries.items():
        rows.setdefault((kind, owner), {})[number] = value
    return rows


def _filled(values: dict[int, Any], size: int = 0) -> list[Any]:
    """Values in order, with zeros for missing ones."""
    return [number_for_line(values.get(i, 0.0)) for i in range(1, max(size, *values) + 1)]
