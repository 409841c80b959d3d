"""SPACAR input files as documents and back, with names in braces, and their bounds in the study beside the file."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..build.builder import Builder
from ..build.description import Description, NamedSignal
from ..display import listed
from ..errors import ModelError, SpacarError, printable
from ..files import write_whole
from ..spacar.arithmetic import names_in
from ..spacar.lines import placeholders, read_text, statements
from ..spacar.read import SpacarModel, read_spacar
from ..spacar.reading import Setting
from ..spacar.write import WrittenLine, line_text, lines_of, no_element_message
from .building import build, free_names, numeric_values
from .document import Document, apply
from .formulas import formulas
from .from_builder import document_of
from .references import call_and_name, call_of
from .study_beside import names_beside, write_beside

# Keywords of analyses that name no node or element: they stay when a file is saved again.
ANALYSIS_KEYWORDS = ("TIMESTEP", "ERROR", "ITERSTEP")
# Numbers of a leaf spring's material that a file contains.
PLAIN_MATERIAL = {"E", "G", "rho", "alpha"}
# Number of faults reported at once.
MOST_FAULTS = 30


class NoValueError(ValueError):
    """Names in the braces of a file have no values."""

    def __init__(self, file: str, names: list[str]):
        names_text, study = ", ".join(map(printable, names)), printable(Path(file).with_suffix(".toml").name)
        they = "they are" if names[1:] else "it is"
        super().__init__(
            f"{file} has {{{names_text}}}, but no study beside it says which number {they}. Write {study} with the"
            f" lines model = '{file}', [parameters] and {printable(names[0])} = 1e-3 or the like."
        )
        self.names = names


def open_dat(path: str | os.PathLike, numbers: Mapping[str, Any] | None = None) -> tuple[Document, list[str]]:
    """Open a SPACAR input file.

    Text in braces becomes names and arithmetic of fields. Their values come from ``numbers`` (a value, or a tuple of
    value, lowest and highest), or from the study beside the file, such as ``guide.toml`` beside ``guide.dat``. The
    workbench never calls functions of a study.

    Returns:
        The document, and notes: warnings of the reader, and what a document cannot contain.
    """
    path = Path(path)
    text = read_text(path)
    names = list(placeholders(statements(text, {})))
    beside, notes = names_beside(path) if names or not numbers else ({}, [])
    known: dict[str, Any] = {**beside, **(numbers or {})}
    if missing := [name for name in names if name not in known]:
        raise NoValueError(printable(path.name), missing)
    # In the order of the study.
    names = [name for name in dict.fromkeys([*beside, *names]) if name in names]
    several = {n: v if isinstance(v := known[n], tuple | list) else (v,) for n in names}
    values = {n: tuple(map(float, v)) if len(v) == 3 else float(v[0]) for n, v in several.items()}
    warnings: list[str] = []

    def read(**placeholder_values: Any) -> SpacarModel:
        # The reader names the file in messages. It would take text of one line for a path.
        spacar_model = read_spacar(path, numbers=placeholder_values)
        if spacar_model.text != text:
            raise SpacarError(f"{printable(path.name)}:1: the file changed while it was read. Open it again.")
        warnings[:] = spacar_model.warnings
        return spacar_model

    title = path.stem if path.stem.isprintable() else "mechanism"
    document, left_out = document_of(read, values, title=title) if names else document_of(read(), title=title)
    unused = [name for name in beside if name not in values]
    notes += [f"'{printable(name)}' of the study does not occur in {printable(path.name)}" for name in unused]
    notes += [text for text in warnings if "drawing keywords are kept" not in text]
    return document, [*notes, *left_out]


def cannot_hold(document: Document) -> list[str]:
    """What a SPACAR input file cannot contain, and what it contains in another form."""
    return [*incomplete(document), *not_expressible(document), *other_forms(document)]


def incomplete(document: Document) -> list[str]:
    """Things with problems, which neither answers nor files contain."""
    pairs = [(call_and_name(document.by_id, p["address"]), p["message"]) for p in build(document).problems]
    return [f"{printable(subject)}: {message}" for subject, message in pairs]


def not_expressible(document: Document) -> list[str]:
    """What a SPACAR input file cannot express; without it there would be another mechanism."""
    refusals: list[str] = []
    # Nodes that elements joined before anything was removed.
    joined: set[str] = set()
    # Remove one fault after the other, to report all at once.
    for _ in range(MOST_FAULTS):
        builder = build(document).builder
        joined = joined or {n for m in builder.members.values() if not m.hidden for n in m.nodes}
        try:
            lines_of(_without_strength(builder), {})
            break
        except ModelError as fault:
            message = str(fault)
        if refusals and not builder.members:
            break
        if message not in map(no_element_message, joined):
            refusals.append(message.removesuffix("."))
        culprit = _culprit(document, message)
        if culprit is None:
            break
        document = apply(document, [{"op": "delete", "ids": [culprit]}])[0]
    return list(dict.fromkeys(refusals))


def _without_strength(builder: Builder) -> Builder:
    """A builder without strengths of sections: the format has none, and no motion depends on them."""
    twin, known = builder.copy(), {}
    for member in twin.members.values():
        section: Any = member.properties.get("section")
        if getattr(section, "material", None) is not None:
            if id(section) not in known:
                material = dataclasses.replace(section.material, strength=None, fatigue=None)
                known[id(section)] = dataclasses.replace(section, material=material)
            member.properties = {**member.properties, "section": known[id(section)]}
    return twin


def _culprit(document: Document, message: str) -> str | None:
    """Id of the thing that a message is about: by a name in it, by a load on that node, or by its first word."""
    for name in re.findall(r"'([^']+)'", message):
        loads = [t for t in document.things if t["call"] in ("body", "force", "moment", "mass")]
        on_it = [item["id"] for item in loads if item["args"].get("node") == name]
        known = [document.known.thing((space,), name) for space in ("element", "input", "output")]
        if culprit_id := next((id for id in [*known, *on_it, document.known.thing(("node",), name)] if id), None):
            return culprit_id
    about = [item["id"] for item in document.things if message.lower().startswith(item["call"])]
    return about[-1] if about else None


def other_forms(document: Document) -> list[str]:
    """What a SPACAR input file contains in another form, which builds the same."""
    changes, free = [], set(free_names(document))
    if derived := [name for name in document.names if name not in free]:
        names = ", ".join(derived)
        changes.append(f"names that follow from others, {names}: their arithmetic is written where they are used")
    if shapes := _named(document, "section", _is_other_section):
        changes.append(f"section {shapes}: as rigidities (ESTIFF, EM) and sizes (CROSSDIM), of leaf springs as SECTION")
    if materials := _named(document, "material", lambda item, _: not set(item["args"]) <= PLAIN_MATERIAL):
        changes.append(f"material {materials}: as numbers of the elements, without its strength, fatigue and damping")
    if blocks := _named(document, "block", lambda *_: True):
        changes.append(f"block {blocks}: as its nodes and elements")
    try:
        _, lost = _texts(document)
    except ModelError:
        lost = []
    return changes + lost


def _named(document: Document, kind: str, counts: Callable[[dict[str, Any], Document], bool]) -> str:
    """Names of the things of a kind that count."""
    known = [(item, call_of(item)) for item in document.things]
    matching = [t for t, call in known if call is not None and call.makes == kind and counts(t, document)]
    return ", ".join(printable(str(item.get("name"))) for item in matching)


def _is_other_section(section: dict[str, Any], document: Document) -> bool:
    """Whether a section is neither a Rigidity nor only a rectangle of leaf springs."""
    if section["call"] == "Rigidity":
        return False
    leaf = ("planar.leaf_spring", "spatial.leaf_spring")
    name = section.get("name")
    users = [t for t in document.things if name in (t["args"].get(key) for key in ("section", "outline"))]
    return any(item["call"] not in (*leaf, "Rigidity") for item in users) or not users


def save_dat(document: Document, path: str | os.PathLike) -> list[str]:
    """Save a SPACAR input file with names in braces, and their values and bounds as the study beside it.

    Lines of an analysis such as TIMESTEP stay in an existing file; an existing study keeps all but [parameters].
    """
    path = Path(path)
    if problems := not_expressible(document):
        faults = "; ".join(problems)
        raise ModelError(f"A SPACAR input file cannot contain this: {faults}. Save Python or the document instead.")
    settings, notes = _analysis_lines(path)
    lines, _ = _texts(document, settings)
    study = write_beside(document, path)
    write_whole(path, ("\n".join(lines) + "\n").encode())
    if study is not None:
        write_whole(path.with_suffix(".toml"), study.encode())
    return notes


def _analysis_lines(path: Path) -> tuple[dict[str, Any], list[str]]:
    """Lines of an analysis in an existing file that stay, and a note about the others."""
    try:
        text = read_text(path)
        names = placeholders(statements(text, {}))
        file_settings = read_spacar(path, numbers=dict.fromkeys(names, 1.0)).settings
    except (OSError, ValueError):
        return {}, []
    settings = {name: value for name, value in file_settings.items() if name in ANALYSIS_KEYWORDS}
    retained = {k: Setting(v.line, v) if isinstance(v, Setting) else v for k, v in settings.items()}
    gone = [name for name in file_settings if not name.startswith((*ANALYSIS_KEYWORDS, "STARTD", "INPUT"))]
    notes = [f"{printable(path.name)} had {', '.join(gone)}. A document cannot contain this. It is lost."]
    return retained, notes * bool(gone)


def _texts(document: Document, settings: dict[str, Any] | None = None) -> tuple[list[str], list[str]]:
    """Lines of the file, and numbers that do not follow from names by arithmetic."""
    built = build(document)
    known: Any = numeric_values(document)
    free = {n: float(known[f"names/{n}/value"]) for n in free_names(document) if f"names/{n}/value" in known}
    builder = _with_file_names(_without_strength(built.builder))
    plain = [*_signals(builder), *map(line_text, lines_of(builder, settings or {}))]
    if not free:
        return plain, []
    written_lines: list[WrittenLine | str] = []

    def traced(names: dict[str, Any]) -> list[Any]:
        other = _with_file_names(_without_strength(build(document, numeric_values(document, names)).builder))
        written_lines[:] = lines_of(other, settings or {}, like=builder)
        every = [v for line in written_lines if isinstance(line, WrittenLine) for v in line.values]
        return [v for v in every if not isinstance(v, int | str)]

    formulas_, values = formulas(traced, free)
    numbers = iter(zip((entry.item() for entry in formulas_), values, strict=True))
    lines: list[str] = list(_signals(builder))
    lost: dict[tuple[str, int], list[str]] = {}
    for line in written_lines:
        if isinstance(line, str):
            lines.append(line)
            continue
        words = []
        for value in line.values:
            if isinstance(value, int | str):
                words.append(str(value))
                continue
            formula, number = next(numbers)
            if formula.text is None:
                lost.setdefault((line.keyword, len(words)), []).append(words[0])
            named = formula.text is not None and set(names_in(formula.text)) - {"pi"}
            words.append(f"{{{formula.text}}}" if named else repr(float(number)))
        while line.keyword in ("ESTIFF", "EM", "EDAMP") and len(words) > 2 and words[-1] == "0.0":
            words.pop()
        lines.append(" ".join([line.keyword, *words]))
    how = "follows from names by more than + - * / ** and stays unchanged"
    return lines, [f"number {n} of {keyword} {listed(subjects)} {how}" for (keyword, n), subjects in lost.items()]


def _with_file_names(builder: Builder) -> Builder:
    """A builder in which the rotation of node 1 is node 2 if no other node is, as in files."""
    new: dict[str, str] = {}
    for name in builder.nodes:
        owner, _, part = name.rpartition(".")
        if part == "rotation" and owner in builder.nodes and owner.isascii() and owner.isdecimal():
            number = str(int(owner) + 1)
            if number not in builder.nodes and number not in new.values():
                new |= {name: number, f"{owner}.warping": f"{number}.warping"}

    def key(entry: Any) -> Any:
        is_node = isinstance(entry, tuple) and entry[0] == "node"
        return (entry[0], new.get(entry[1], entry[1]), entry[2]) if is_node else entry

    def signal(named_signal: NamedSignal) -> NamedSignal:
        return named_signal._replace(key=key(named_signal.key), parts=tuple(map(signal, named_signal.parts)))

    twin = builder.copy()
    twin.nodes = {new.get(name, name): node for name, node in twin.nodes.items()}
    for member in twin.members.values():
        member.nodes = tuple(new.get(node, node) for node in member.nodes)
    twin.dofs = list(map(key, twin.dofs))
    twin.starts = {key(entry): value for entry, value in twin.starts.items()}
    twin.loads = {
        which: {kind: {key(entry): value for entry, value in entries.items()} for kind, entries in sets.items()}
        for which, sets in twin.loads.items()
    }
    twin.signals = {side: list(map(signal, entries)) for side, entries in twin.signals.items()}
    return twin


def _signals(builder: Description) -> list[str]:
    """Comments with the names of inputs and outputs."""
    numbered = [(side, i, s) for side in ("input", "output") for i, s in enumerate(builder.signals[side], 1)]
    return [f"% {side} {i}: {' '.join(signal.name.split())}" for side, i, signal in numbered]
