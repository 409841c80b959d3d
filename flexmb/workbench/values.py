"""Values of the numbers in a document: names, arithmetic of names, and what a compiled function of them depends on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import clean
from ..spacar.arithmetic import is_number, names_in, value_of
from .content import Document
from .edits import numbers
from .references import call_of, replaced


def free_names(document: Document) -> list[str]:
    """Names whose values are numbers: those that one may slide, or tune by."""
    return [name for name, own in document.names.items() if is_number(own["value"])]


def numbers_of(document: Document, names: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Values of all numeric fields, by address; of names too, "names/t/value". What has none is left out.

    Args:
        document: The document.
        names: Values of free names in place of those in the document, () each, which may be traced.
    """
    return dict(evaluated(document, names)[0])


def value_in(document: Document, text: str) -> Any:
    """Value of arithmetic with the names of a document.

    Raises:
        ValueError: It has none.
    """
    values: dict[str, Any] = {}
    for name in document.names:
        _evaluate_name(document, name, {}, values, {})
    return _value(text, values, document)


def evaluated(document: Document, given: Mapping[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, str]]:
    """Values by address, and what is wrong by address."""
    if not given:
        if "evaluated" not in document.kept:
            document.kept["evaluated"] = _evaluated(document, {})
        return document.kept["evaluated"]
    return _evaluated(document, given)


def _evaluated(document: Document, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    values, faults, found = {}, {}, {}
    for name in document.names:
        _evaluate_name(document, name, given, values, faults)
    for name in document.names:
        for bound in ("low", "high"):
            address, text = f"names/{name}/{bound}", document.names[name].get(bound)
            if text is not None and text.strip():
                try:
                    found[address] = _value(text, values, document)
                except ValueError as fault:
                    faults[address] = str(fault)
        if name in values:
            found[f"names/{name}/value"] = values[name]
    for thing in document.things:
        for path, text in numbers(thing):
            address = f"{thing['id']}/{path}"
            try:
                found[address] = _value(text, values, document)
            except ValueError as fault:
                faults[address] = str(fault)
    return found, faults


def _evaluate_name(document: Document, name: str, given: Mapping[str, Any], values: dict, faults: dict) -> None:
    """Value of a name, after those of the names in it; without recursion, since a chain of them may be long."""
    path: dict[str, None] = {name: None}
    while path:
        one = next(reversed(path))
        address, text = f"names/{one}/value", document.names[one]["value"]
        missing = [n for n in names_in(text) if n in document.names and n not in values]
        open_ = [n for n in missing if f"names/{n}/value" not in faults]
        circle = next((n for n in missing if n in path), None)
        if one in given:
            values[one] = given[one]
        elif one in values or address in faults:
            pass
        elif circle is not None:
            members = list(path)
            told = " → ".join(map(clean, [*members[members.index(circle) :], circle]))
            faults[address] = f"Name '{clean(one)}' is defined by itself: {told}."
        elif open_:
            path[open_[0]] = None
            continue
        else:
            try:
                values[one] = _value(text, values, document)
            except ValueError as fault:
                faults[address] = str(fault)
        path.popitem()


def _value(text: str, values: Mapping[str, Any], document: Document) -> Any:
    """Value of a text, with a message that is a sentence.

    Raises:
        ValueError: It has none.
    """
    if not text.strip():
        raise ValueError("A number, a name or arithmetic is missing.")
    for name in names_in(text):
        if name in values or name == "pi":
            continue
        if name in document.names:
            raise ValueError(f"'{clean(text)}' needs '{clean(name)}', which has no value.")
        known = f"names are: {', '.join(map(clean, document.names))}" if document.names else "there are no names yet"
        raise ValueError(f"'{clean(text)}' asks for '{clean(name)}', but there is no such name; {known}.")
    try:
        return value_of(text, values)
    except ValueError as fault:
        raise ValueError(f"'{clean(text)}' {fault}.") from None


def structure(document: Document, *, arithmetic: bool = True) -> str:
    """What a document builds but for its numbers: equal texts build the same compiled functions of their numbers.

    Degrees of freedom and clamps that the Builder finds depend on numbers too: beside this key stands that of the
    model, such as its ``q_labels``.

    Args:
        document: The document.
        arithmetic: Whether functions of the free names are meant, for which texts such as "2*w" count. Without it
            those of the numbers of :func:`numbers_of`.
    """
    found, _ = evaluated(document)

    def shown(address: str, text: str) -> str:
        if address not in found:
            return f"! {text}"
        return "#" if is_number(text) or not arithmetic else text

    parts: list[Any] = [document.dimension]
    if arithmetic:
        parts.append([(name, shown(f"names/{name}/value", own["value"])) for name, own in document.names.items()])
    for thing in document.things:
        call, args = call_of(thing), thing["args"]
        for path, text in numbers(thing):
            # A whole number chooses code.
            whole = call is not None and call.fields[path.partition("/")[0]]["whole"]
            address = f"{thing['id']}/{path}"
            value = found.get(address, text) if whole else shown(address, text)
            args = replaced(args, path.split("/"), value)
        parts.append((thing["id"], thing["call"], thing.get("name"), sorted(args.items())))
    return repr(parts)
