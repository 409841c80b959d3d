"""The calls of a document and the fields of each call, from signatures, annotations and docstrings."""

import collections.abc
import dataclasses
import functools
import inspect
import re
import typing
from typing import Any

from .. import blocks
from ..build.builder import FORCES, MEASURED, STRAINED, Builder
from ..build.properties import ENDS, ROOTS, alternatives_of
from ..elements import materials, planar, sections, spatial
from ..elements.element import Element, _options
from ..elements.section import Damping, Material, Section
from ..model.model import MOTIONS

EMPTY = inspect.Parameter.empty
# Groups of the methods of a Builder; all others are loads.
METHODS = {
    **dict.fromkeys(("node", "rotation", "warping"), "node"),
    **dict.fromkeys(("fix", "prescribe"), "support"),
    **dict.fromkeys(("mass", "inertia", "body"), "mass"),
    **dict.fromkeys(("input", "output", "sensor", "actuator"), "signal"),
    **dict.fromkeys(("release", "dof", "start"), "freedom"),
}
# Methods that no thing calls: things name elements by their types, and a document is built and copied as a whole.
OTHERS = ("add", "build", "copy", "with_dofs")
# Kinds of the parameters of methods and building blocks that follow from no annotation.
KINDS = {
    "node": "node",
    "base": "node",
    "stage": "node",
    "of": "of",
    "element": "element",
    "component": "components",
    "components": "components",
    "deformations": "deformations",
    "weights": "weights",
    "material": "material",
    "step": "text",
}
CHOICES = {
    "kind": ("node", "element"),
    "tilt": ("fixed", "free"),
    ("input", "quantity"): (*FORCES, *MOTIONS),
    ("output", "quantity"): (*MEASURED, *STRAINED),
}
# Number of entries of a vector in the plane and in space: None for any number, 0 if there is no such vector.
COUNTS = {
    "moment": (1, 3),
    "inertia": (1, 6),
    "start": (1, 4),
    "gradient": (1, 2),
    "change": (None, None),
    "values": (None, None),
    "breaks": (None, None),
    "center": (2, 3),
    "at": (2, 3),
    "axis": (0, 3),
    "y": (0, 3),
}
# Fields for mechanisms in space.
SPATIAL = ("y", "axis", "tilt", "apart", "local")
# Words for restrained warping at the ends of a beam.
ENDS_IN_WORDS = {"neither": (False, False), "first": (True, False), "last": (False, True), "both": (True, True)}


@dataclasses.dataclass(frozen=True)
class Call:
    """One call that a document may make.

    Attributes:
        name: Name in documents, such as "planar.beam".
        kind: "method" of the Builder, "element" type, "record" (section, material, damping), "constant" material, or
            "block".
        function: Function that is called, or the constant.
        makes: Namespace of the thing's name: "node", "element", "section", "material", "damping", "block", "input" or
            "output"; None if it has no name.
        entry: Entry of the catalogue.
    """

    name: str
    kind: str
    function: Any
    makes: str | None
    entry: dict[str, Any]

    @functools.cached_property
    def fields(self) -> dict[str, dict[str, Any]]:
        """The fields by name."""
        return {field["name"]: field for field in self.entry["fields"]}


def catalogue() -> dict[str, dict[str, Any]]:
    """Entries of all calls by name, ready for JSON.

    An entry has "group" (node, element, section, material, support, load, mass, signal, freedom or block), "title",
    "doc", "dimension" (2, 3 or None for both), "name" (start of default names, or None), "makes" (what other things may
    refer to it as) and "fields". A field has "name", "kind", "unit", "default", "optional", "choices", "doc",
    "dimension", "count" (number of entries {"2": .., "3": ..}, None for any number), "whole" (a whole number, which
    chooses code) and "new" (a node that the call makes if it does not exist). Kinds are number, vector, node, nodes,
    element, of (node or element), section, sections, material, damping, components, deformations, weights (pairs of a
    part and its factor), choice, flag ("true" or "false") and text.
    """
    return {name: call.entry for name, call in calls().items()}


@functools.cache
def calls() -> dict[str, Call]:
    """All calls by name."""
    found = [_of_method(name) for name in _methods()]
    found += [_of_element(room, name) for room in (planar, spatial) for name in room.__all__ if _offered(room, name)]
    found += [_of_record(name) for name in sections.__all__ if _kind_of_record(getattr(sections, name))]
    found += [_of_constant(name) for name in materials.__all__]
    found += [_of_block(name) for name in dir(blocks)]
    return {call.name: call for call in found}


def _call(
    call: str, kind: str, function: Any, group: str, makes: str | None, fields: list[dict[str, Any]], /, **more: Any
) -> Call:
    entry = {
        "group": group,
        "title": call.rpartition(".")[2].replace("_", " "),
        "doc": " ".join((inspect.getdoc(function) or "").split("\n\n")[0].split()),
        "dimension": None,
        "name": None,
        "makes": makes,
        "fields": fields,
    }
    return Call(call, kind, function, makes, entry | more)


def _field(name: str, kind: str, default: Any = EMPTY, doc: str = "", /, **more: Any) -> dict[str, Any]:
    unit = re.search(r"(?<!flexmb)\[([^\]]+)\]", doc)
    field = {
        "name": name,
        "kind": kind,
        "unit": unit.group(1) if unit else "",
        "default": _written(default),
        "optional": default is not EMPTY,
        "choices": None,
        "count": None,
        "dimension": None,
        "whole": False,
        "new": False,
        "doc": doc,
    }
    return field | more


def _written(default: Any) -> str | None:
    """A default value as the text of a field."""
    if default is EMPTY or default is None or isinstance(default, tuple):
        return None
    if isinstance(default, bool):
        return "true" if default else "false"
    return default if isinstance(default, str) else f"{default:.15g}"


def _methods() -> list[str]:
    # Methods of the base class follow.
    found = [name for kind in Builder.__mro__[:-1] for name in vars(kind) if inspect.isfunction(getattr(Builder, name))]
    return [name for name in dict.fromkeys(found) if not name.startswith("_") and name not in OTHERS]


def _of_method(name: str) -> Call:
    function, group = getattr(Builder, name), METHODS.get(name, "load")
    fields = _of_signature(function, name, ("self",))
    makes = "node" if group == "node" else {"sensor": "output", "actuator": "input"}.get(name, name)
    makes = makes if group in ("node", "signal") else None
    return _call(name, "method", function, group, makes, fields, name=name if makes else None)


def _of_block(name: str) -> Call:
    function = getattr(blocks, name)
    fields = _of_signature(function, name, ("b",))
    prefix = inspect.signature(function).parameters["name"].default
    return _call(f"blocks.{name}", "block", function, "block", "block", fields, name=prefix)


def _of_signature(function: Any, call: str, without: tuple[str, ...]) -> list[dict[str, Any]]:
    hints, docs = typing.get_type_hints(function), _arguments(function)
    found = []
    for name, parameter in inspect.signature(function).parameters.items():
        # Numbers by name belong to another field.
        if name in (*without, "name") or parameter.kind is parameter.VAR_KEYWORD:
            continue
        # Components may be left out; the Builder raises where it needs some.
        several = parameter.kind is parameter.VAR_POSITIONAL
        default = None if several and name == "components" else parameter.default
        found.append(_of_parameter(call, name, hints.get(name), default, docs.get(name, "")))
    return sorted(found, key=lambda field: field["optional"])


def _of_parameter(call: str, name: str, hint: Any, default: Any, doc: str) -> dict[str, Any]:
    more: dict[str, Any] = {"dimension": 3 if name in SPATIAL else None}
    choices = CHOICES.get((call, name)) or CHOICES.get(name)
    if name == "element" and default is None:
        choices = _flexible()
    if choices:
        return _field(name, "choice", None if default == "" else default, doc, choices=list(choices), **more)
    if name in KINDS:
        more |= {"count": 1} if name == "component" else {}
        return _field(name, KINDS[name], default, doc, new=name == "stage", **more)
    field = _of_hint(name, hint, default, doc)
    if name in COUNTS or field["kind"] == "vector":
        field |= {"kind": "vector", "count": _count(COUNTS.get(name, (2, 3)))}
    return field | more


def _flexible() -> list[str]:
    """Element types for building blocks: flexible, between two ends, and with a section as their only property."""
    found = []
    for room in (planar, spatial):
        for name in room.__all__:
            element = getattr(room, name)
            joined = [key for key, kind in element.nodes.items() if kind.part in ("position", "rotation")]
            needed = set(element.wanted(element.deformation)) - {
                "section",
                "y",
                "curvature",
                "clamped",
                "skew",
                "clamp",
            }
            if joined == ["p", "rot_p", "q", "rot_q"] and element.resultants is not None and not needed:
                found.append(f"{room.__name__.rpartition('.')[2]}.{name}")
    return found


def _offered(room: Any, name: str) -> bool:
    """Whether a document can contain an element type: it has no function as a property, and is no second name."""
    element, place = getattr(room, name), room.__name__.rpartition(".")[2]
    return repr(element).startswith(f"<{place}.{name}:") and not any(
        typing.get_origin(kind) is collections.abc.Callable for kind, _ in _options(element).values()
    )


def _of_element(room: Any, name: str) -> Call:
    element: Element = getattr(room, name)
    place = room.__name__.rpartition(".")[2]
    dimension = 2 if room is planar else 3
    text, ends = str(element.__doc__), _ends(element)
    nodes = _field("nodes", "nodes", EMPTY, f"Nodes: {', '.join(ends)}.", count=len(ends))
    needed = {n for f in (element.deformation, element.law) if f is not None for n in element.wanted(f)}
    fields = []
    for key, parameter in element.properties.items():
        default = None if parameter.default is EMPTY and key not in needed else parameter.default
        fields.append(_of_hint(key, element.hint(key), default, _mentioned(text, key)))
    for key, (kind, default) in _options(element).items():
        fields.append(_of_hint(key, kind, default, _mentioned(text, key)))
    # The section first, then what must be given.
    fields.sort(key=lambda field: (field["name"] != "section", field["optional"]))
    hint = typing.get_type_hints(element.deformation).get("return")
    has_deformations = getattr(hint, "dim_str", "n") != "0"
    doc = "Names or numbers (from 1) of the deformations that may change, or all."
    released = [_field("released", "deformations", None, doc)] if has_deformations else []
    group = "element" if has_deformations else "mass" if element.inertia is not None else "load"
    # Elements without deformations are hidden: the Builder has methods for them.
    return _call(
        f"{place}.{name}",
        "element",
        element,
        group,
        "element",
        [nodes, *fields, *released],
        dimension=dimension,
        name=name.replace("_", " "),
        doc=text,
        hidden=not has_deformations,
    )


def _ends(element: Element) -> list[str]:
    """Parameters that need a node of their own; a node stands for its rotation and its warping too."""
    seen: set[str] = set()
    ends = []
    for name, kind in element.nodes.items():
        if kind.part == "internal":
            continue
        if not seen or kind.part in seen or kind.part == "position":
            seen = set()
            ends.append(name)
        seen.add(kind.part)
    return ends


def _fields_of(record: Any) -> tuple[dataclasses.Field, ...]:
    return dataclasses.fields(record)


def _kind_of_record(found: Any) -> str | None:
    """What a class of records, or a function that returns a record, makes; None if a document cannot contain it."""
    if inspect.isclass(found):
        usual = [(kind, base) for kind, base in _MADE if issubclass(found, base)]
        given = {f.name: f.type for f in _fields_of(found)} if usual and found is not Section else {}
        return usual[0][0] if given and "function" not in given else None
    made = typing.get_type_hints(found).get("return")
    return next((kind for kind, base in _MADE if inspect.isclass(made) and issubclass(made, base)), None)


_MADE: tuple[tuple[str, Any], ...] = (("section", Section), ("material", Material), ("damping", Damping))


def _of_record(name: str) -> Call:
    function: Any = getattr(sections, name)
    makes = _kind_of_record(function)
    hints, docs = typing.get_type_hints(function), _arguments(function)
    if inspect.isclass(function):
        # The first fields of a record are the arguments of its constructor.
        given = {f.name: EMPTY if f.default is dataclasses.MISSING else f.default for f in _fields_of(function)}
    else:
        given = {key: p.default for key, p in inspect.signature(function).parameters.items()}
    fields = [_of_hint(key, hints.get(key), default, docs.get(key, "")) for key, default in given.items()]
    group = "material" if makes == "damping" else makes
    return _call(name, "record", function, str(group), makes, fields, name=str(makes))


def _of_constant(name: str) -> Call:
    made: Any = getattr(materials, name)
    doc = ", ".join(f"{f.name} {getattr(made, f.name):g}" for f in dataclasses.fields(made) if getattr(made, f.name))
    return _call(f"materials.{name}", "constant", made, "material", "material", [], name=name, doc=doc)


def _of_hint(name: str, hint: Any, default: Any, doc: str) -> dict[str, Any]:
    """A field from the annotation of a property, an option or an entry of a record."""
    alternatives = alternatives_of(hint)
    if made := _record_in(alternatives):
        return _field(name, made, default, doc)
    origins = {typing.get_origin(one): typing.get_args(one) for one in alternatives}
    if typing.Literal in origins:
        return _field(name, "choice", default, doc, choices=list(origins[typing.Literal]))
    if ENDS in alternatives:
        return _field(name, "choice", default, doc, choices=list(ENDS_IN_WORDS))
    if any(one in ROOTS for one in alternatives):
        # As many for both ends, or those of the first and then of the last.
        return _field(name, "vector", default, doc, count=_count((None, None)))
    if bool in alternatives:
        return _field(name, "flag", default, doc)
    if collections.abc.Sequence in origins:
        inner = origins[collections.abc.Sequence][0]
        several = "sections" if inspect.isclass(inner) and issubclass(inner, Section) else "vector"
        return _field(name, several, default, doc, count=_count((None, None)) if several == "vector" else None)
    sizes = [getattr(one, "dim_str", "") for one in alternatives]
    if size := next((int(one) for one in sizes if one.isdecimal()), None):
        return _field(name, "vector", default, doc, count=_count((size, size)))
    return _field(name, "number", default, doc, whole=alternatives == (int,))


def _record_in(alternatives: tuple[Any, ...]) -> str | None:
    """Kind of record in an annotation."""
    classes = [one for one in alternatives if inspect.isclass(one)]
    return next((kind for kind, base in _MADE if any(issubclass(one, base) for one in classes)), None)


def _count(counts: tuple[int | None, int | None]) -> dict[str, int | None]:
    return {"2": counts[0], "3": counts[1]}


@functools.cache
def _arguments(function: Any) -> dict[str, str]:
    """Text of a docstring about each argument or attribute, also if it points to another function."""
    lines = (inspect.getdoc(function) or "").splitlines()
    heads = [i for i, line in enumerate(lines) if line in ("Args:", "Attributes:")]
    found: dict[str, str] = {}
    names: list[str] = []
    for line in lines[heads[0] + 1 :] if heads else []:
        if line and not line.startswith(" "):
            break
        if head := re.match(r"    (\w+(?:, \w+)*): (.*)", line):
            names = head.group(1).split(", ")
            found |= dict.fromkeys(names, head.group(2))
        else:
            found |= {name: f"{found[name]} {line.strip()}".strip() for name in names}
    named = [ref for text in found.values() for ref in re.findall(r"See :func:`(?:flexmb\.\w+\.)?(\w+)`", text)]
    other = named[0] if named else ""
    told = _arguments(getattr(blocks, other)) if other in dir(blocks) and other != function.__name__ else {}
    pointing = [name for name, text in found.items() if text.startswith(("The same.", "See :func:"))]
    return found | {name: told[name] for name in pointing if name in told}


def _mentioned(text: str, name: str) -> str:
    """Text in parentheses or after a comma behind a property in the text of an element type."""
    text = text[max(text.find("Properties:"), 0) :]
    found = re.search(rf"\b{name}(?: \(((?:[^()]|\([^()]*\))*)\)|, (whether [^.;]*))", text)
    return " ".join((found.group(1) or found.group(2)).split()) if found else ""
