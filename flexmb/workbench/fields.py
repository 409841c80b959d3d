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
# Kinds of the parameters of methods and building blocks that follow from no annotation; most are named so.
KINDS = {name: name for name in ("node", "of", "element", "components", "deformations", "weights", "material")}
KINDS |= {"base": "node", "stage": "node", "component": "components", "step": "text"}
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
    **dict.fromkeys(("change", "values", "breaks"), (None, None)),
    **dict.fromkeys(("center", "at"), (2, 3)),
    **dict.fromkeys(("axis", "y"), (0, 3)),
}
# Fields for mechanisms in space.
SPATIAL = ("y", "axis", "tilt", "apart", "local")
# Properties that the elements of building blocks may have.
OPTIONAL = {"section", "y", "curvature", "clamped", "skew", "clamp"}
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
    # Methods of the base class follow.
    names = dict.fromkeys(name for kind in Builder.__mro__[:-1] for name in vars(kind))
    public = [name for name in names if not name.startswith("_") and name not in OTHERS]
    elements = [(room, name) for room in (planar, spatial) for name in room.__all__ if _offered(room, name)]
    all_calls = [_method_call(name) for name in public if inspect.isfunction(getattr(Builder, name))]
    all_calls += [_element_call(room, name) for room, name in elements]
    all_calls += [_record_call(name) for name in sections.__all__ if _kind_of_record(getattr(sections, name))]
    all_calls += [_constant_call(name) for name in materials.__all__]
    all_calls += [_block_call(name) for name in dir(blocks)]
    return {call.name: call for call in all_calls}


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


def _method_call(name: str) -> Call:
    function, group = getattr(Builder, name), METHODS.get(name, "load")
    fields = _signature_fields(function, name)
    makes = "node" if group == "node" else {"sensor": "output", "actuator": "input"}.get(name, name)
    makes = makes if group in ("node", "signal") else None
    return _call(name, "method", function, group, makes, fields, name=name if makes else None)


def _block_call(name: str) -> Call:
    function = getattr(blocks, name)
    fields = _signature_fields(function, name)
    prefix = inspect.signature(function).parameters["name"].default
    return _call(f"blocks.{name}", "block", function, "block", "block", fields, name=prefix)


def _signature_fields(function: Any, call: str) -> list[dict[str, Any]]:
    """Fields of the parameters after the Builder."""
    hints, docs = typing.get_type_hints(function), _arguments(function)
    fields = []
    for name, parameter in list(inspect.signature(function).parameters.items())[1:]:
        # Numbers by name belong to another field.
        if name == "name" or parameter.kind is parameter.VAR_KEYWORD:
            continue
        # Components may be left out; the Builder raises where it needs some.
        several = parameter.kind is parameter.VAR_POSITIONAL
        default = None if several and name == "components" else parameter.default
        fields.append(_parameter_field(call, name, hints.get(name), default, docs.get(name, "")))
    return sorted(fields, key=lambda field: field["optional"])


def _parameter_field(call: str, name: str, hint: Any, default: Any, doc: str) -> dict[str, Any]:
    more: dict[str, Any] = {"dimension": 3 if name in SPATIAL else None}
    choices = CHOICES.get((call, name)) or CHOICES.get(name)
    if name == "element" and default is None:
        choices = _flexible()
    if choices:
        return _field(name, "choice", None if default == "" else default, doc, choices=list(choices), **more)
    if name in KINDS:
        more |= {"count": 1} if name == "component" else {}
        return _field(name, KINDS[name], default, doc, new=name == "stage", **more)
    field = _annotation_field(name, hint, default, doc)
    if name in COUNTS or field["kind"] == "vector":
        field |= {"kind": "vector", "count": _count(COUNTS.get(name, (2, 3)))}
    return field | more


def _flexible() -> list[str]:
    """Element types for building blocks: flexible, between two ends, and with a section as their only property."""
    type_names = []
    for room in (planar, spatial):
        for name in room.__all__:
            element = getattr(room, name)
            joined = [key for key, kind in element.nodes.items() if kind.part in ("position", "rotation")]
            needed = set(element.wanted(element.deformation)) - OPTIONAL
            if joined == ["p", "rot_p", "q", "rot_q"] and element.resultants is not None and not needed:
                type_names.append(f"{room.__name__.rpartition('.')[2]}.{name}")
    return type_names


def _offered(room: Any, name: str) -> bool:
    """Whether a document can contain an element type: it has no function as a property, and is no second name."""
    element, place = getattr(room, name), room.__name__.rpartition(".")[2]
    origins = [typing.get_origin(kind) for kind, _ in _options(element).values()]
    return repr(element).startswith(f"<{place}.{name}:") and collections.abc.Callable not in origins


def _element_call(room: Any, name: str) -> Call:
    element: Element = getattr(room, name)
    place = room.__name__.rpartition(".")[2]
    dimension = 2 if room is planar else 3
    text, ends = str(element.__doc__), _ends(element)
    nodes = _field("nodes", "nodes", EMPTY, f"Nodes: {', '.join(ends)}.", count=len(ends))
    needed = {n for f in (element.deformation, element.law) if f is not None for n in element.wanted(f)}
    wanted = {
        key: (element.hint(key), None if parameter.default is EMPTY and key not in needed else parameter.default)
        for key, parameter in element.properties.items()
    }
    fields = [
        _annotation_field(key, hint, default, _mentioned(text, key))
        for key, (hint, default) in (*wanted.items(), *_options(element).items())
    ]
    # The section first, then what must be given.
    fields.sort(key=lambda field: (field["name"] != "section", field["optional"]))
    hint = typing.get_type_hints(element.deformation).get("return")
    has_deformations = getattr(hint, "dim_str", "n") != "0"
    doc = "Names or numbers (from 1) of the deformations that may change, or all."
    released = [_field("released", "deformations", None, doc)] if has_deformations else []
    group = "element" if has_deformations else "mass" if element.inertia is not None else "load"
    # Elements without deformations are hidden: the Builder has methods for them.
    more = {"dimension": dimension, "name": name.replace("_", " "), "doc": text, "hidden": not has_deformations}
    return _call(f"{place}.{name}", "element", element, group, "element", [nodes, *fields, *released], **more)


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


def _kind_of_record(maker: Any) -> str | None:
    """What a class of records, or a function that returns a record, makes; None if a document cannot contain it."""
    if not isinstance(maker, type):
        return _record_in(typing.get_type_hints(maker).get("return"))
    kind = _record_in(maker)
    names = [field.name for field in dataclasses.fields(maker)] if kind and maker is not Section else []
    return kind if names and "function" not in names else None


_RECORD_KINDS: tuple[tuple[str, Any], ...] = (("section", Section), ("material", Material), ("damping", Damping))


def _record_call(name: str) -> Call:
    function: Any = getattr(sections, name)
    makes = _kind_of_record(function)
    hints, docs = typing.get_type_hints(function), _arguments(function)
    if isinstance(function, type):
        # The first fields of a record are the arguments of its constructor.
        fields: Any = dataclasses.fields(function)
        defaults = {f.name: EMPTY if f.default is dataclasses.MISSING else f.default for f in fields}
    else:
        defaults = {key: p.default for key, p in inspect.signature(function).parameters.items()}
    fields = [_annotation_field(key, hints.get(key), default, docs.get(key, "")) for key, default in defaults.items()]
    group = "material" if makes == "damping" else makes
    return _call(name, "record", function, str(group), makes, fields, name=str(makes))


def _constant_call(name: str) -> Call:
    constant: Any = getattr(materials, name)
    values = {field.name: getattr(constant, field.name) for field in dataclasses.fields(constant)}
    doc = ", ".join(f"{key} {value:g}" for key, value in values.items() if value)
    return _call(f"materials.{name}", "constant", constant, "material", "material", [], name=name, doc=doc)


def _annotation_field(name: str, hint: Any, default: Any, doc: str) -> dict[str, Any]:
    """A field from the annotation of a property, an option or an entry of a record."""
    alternatives = alternatives_of(hint)
    if record_kind := _record_in(*alternatives):
        return _field(name, record_kind, default, doc)
    origins = {typing.get_origin(candidate): typing.get_args(candidate) for candidate in alternatives}
    if typing.Literal in origins:
        return _field(name, "choice", default, doc, choices=list(origins[typing.Literal]))
    if ENDS in alternatives:
        return _field(name, "choice", default, doc, choices=list(ENDS_IN_WORDS))
    if any(candidate in ROOTS for candidate in alternatives):
        # As many for both ends, or those of the first and then of the last.
        return _field(name, "vector", default, doc, count=_count((None, None)))
    if bool in alternatives:
        return _field(name, "flag", default, doc)
    if collections.abc.Sequence in origins:
        inner = origins[collections.abc.Sequence][0]
        several = "sections" if inspect.isclass(inner) and issubclass(inner, Section) else "vector"
        return _field(name, several, default, doc, count=_count((None, None)) if several == "vector" else None)
    sizes = [getattr(candidate, "dim_str", "") for candidate in alternatives]
    if size := next((int(text) for text in sizes if text.isdecimal()), None):
        return _field(name, "vector", default, doc, count=_count((size, size)))
    return _field(name, "number", default, doc, whole=alternatives == (int,))


def _record_in(*alternatives: Any) -> str | None:
    """Kind of record in an annotation."""
    classes = [candidate for candidate in alternatives if inspect.isclass(candidate)]
    return next((kind for kind, base in _RECORD_KINDS if any(issubclass(c, base) for c in classes)), None)


def _count(counts: tuple[int | None, int | None]) -> dict[str, int | None]:
    return {"2": counts[0], "3": counts[1]}


@functools.cache
def _arguments(function: Any) -> dict[str, str]:
    """Text of a docstring about each argument or attribute, also if it points to another function."""
    lines = (inspect.getdoc(function) or "").splitlines()
    heads = [i for i, line in enumerate(lines) if line in ("Args:", "Attributes:")]
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in lines[heads[0] + 1 :] if heads else []:
        if line and not line.startswith(" "):
            break
        if head := re.match(r"    (\w+(?:, \w+)*): (.*)", line):
            names = head.group(1).split(", ")
            texts |= dict.fromkeys(names, head.group(2))
        else:
            texts |= {name: f"{texts[name]} {line.strip()}".strip() for name in names}
    named = [ref for text in texts.values() for ref in re.findall(r"See :func:`(?:flexmb\.\w+\.)?(\w+)`", text)]
    other = named[0] if named else ""
    other_texts = _arguments(getattr(blocks, other)) if other in dir(blocks) and other != function.__name__ else {}
    pointing = [name for name, text in texts.items() if text.startswith(("The same.", "See :func:"))]
    return texts | {name: other_texts[name] for name in pointing if name in other_texts}


def _mentioned(text: str, name: str) -> str:
    """Text in parentheses or after a comma behind a property in the text of an element type."""
    text = text[max(text.find("Properties:"), 0) :]
    match = re.search(rf"\b{name}(?: \(((?:[^()]|\([^()]*\))*)\)|, (whether [^.;]*))", text)
    return " ".join((match.group(1) or match.group(2)).split()) if match else ""
