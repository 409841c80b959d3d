"""Numbers of a document as text: values, sums, signs; and the key of the compiled function of these numbers."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal, InvalidOperation
from typing import Any

from ..errors import printable
from ..spacar.arithmetic import arithmetic_result, is_number_text, names_in
from .content import Document
from .edits import numbers
from .references import call_of, replaced


def plus(a: str, b: str) -> str:
    """Sum a + b."""
    x, y = _decimal(a), _decimal(b)
    if x is not None and y is not None:
        return _text(x + y)
    if x == 0:
        return b
    if y == 0:
        return a
    if b.startswith("-") and _is_term(b[1:]):
        return f"{a} - {b[1:]}"
    return f"{a} + {_term(b, signs=True)}"


def minus(a: str, b: str) -> str:
    """Difference a - b."""
    return plus(a, negated(b))


def negated(a: str) -> str:
    """-a."""
    if (x := _decimal(a)) is not None:
        return _text(-x)
    if a.startswith("-") and _is_term(a[1:]):
        inner = a[1:]
        return inner[1:-1] if inner.startswith("(") else inner
    return f"-{_term(a)}"


def text_product(a: str, b: str) -> str:
    """Product a * b."""
    x, y = _decimal(a), _decimal(b)
    if x is not None and y is not None:
        return _text(x * y)
    if 0 in (x, y):
        return "0"
    if x == 1 or y == 1:
        return b if x == 1 else a
    return f"{_term(a)}*{_term(b)}"


def reflected(a: str, at: str) -> str:
    """2 at - a."""
    return minus(text_product("2", at), a)


def text_between(a: str, b: str, place: str) -> str:
    """Text of a + place (b - a)."""
    return a if a.strip() == b.strip() else plus(a, text_product(place, minus(b, a)))


def _decimal(text: str) -> Decimal | None:
    if not is_number_text(text):
        return None
    try:
        number = Decimal("".join(text.split()))
    except InvalidOperation:
        return None
    return number if number.is_finite() else None


def _text(number: Decimal) -> str:
    """Short text of a number."""
    if number == 0:
        return "0"
    # A sum of numbers of different size has more digits than a float.
    rounded = Decimal(repr(float(number))) if len(number.as_tuple().digits) > 17 else number
    short = rounded.normalize()
    return format(short, "f") if -7 <= short.adjusted() <= 9 else str(short).replace("E+", "e").replace("E", "e")


def _is_term(text: str) -> bool:
    """Whether a text is one name, one number, or one parenthesis."""
    if text.strip().isidentifier() or (is_number_text(text) and not text.strip().startswith(("-", "+"))):
        return True
    if not text.startswith("(") or not text.endswith(")"):
        return False
    depth = 0
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return k == len(text) - 1
    return False


def _term(text: str, *, signs: bool = False) -> str:
    """A text as a factor, or with ``signs`` as a summand."""
    if _is_term(text) or (signs and not text.strip().startswith(("-", "+"))):
        return text
    return f"({text})"


def free_names(document: Document) -> list[str]:
    """Names whose values are numbers, for sliders and tuning."""
    return [name for name, entry in document.names.items() if is_number_text(entry["value"])]


def numeric_values(document: Document, names: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Values of numeric fields and names ("names/t/value") by address; ``names`` replaces values of free names."""
    return dict(evaluated(document, names)[0])


def arithmetic_value(document: Document, text: str) -> Any:
    """Value of arithmetic with the names of a document; ValueError if it has none."""
    values: dict[str, Any] = {}
    for name in document.names:
        _evaluate_name(document, name, {}, values, {})
    return _value(text, values, document)


def evaluated(document: Document, given: Mapping[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, str]]:
    """Values by address, and faults by address."""
    if not given:
        if "evaluated" not in document.kept:
            document.kept["evaluated"] = _evaluated(document, {})
        return document.kept["evaluated"]
    return _evaluated(document, given)


def _evaluated(document: Document, name_values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    values, faults, by_address = {}, {}, {}

    def evaluate(address: str, text: str) -> None:
        try:
            by_address[address] = _value(text, values, document)
        except ValueError as fault:
            faults[address] = str(fault)

    for name in document.names:
        _evaluate_name(document, name, name_values, values, faults)
    for name, entry in document.names.items():
        for bound in ("low", "high"):
            if entry.get(bound, "").strip():
                evaluate(f"names/{name}/{bound}", entry[bound])
        if name in values:
            by_address[f"names/{name}/value"] = values[name]
    for item in document.things:
        for path, text in numbers(item):
            evaluate(f"{item['id']}/{path}", text)
    return by_address, faults


def _evaluate_name(document: Document, name: str, name_values: Mapping[str, Any], values: dict, faults: dict) -> None:
    """Value of a name after the names in it, without recursion: a chain of names may be long."""
    path: dict[str, None] = {name: None}
    while path:
        current = next(reversed(path))
        address, text = f"names/{current}/value", document.names[current]["value"]
        missing = [n for n in names_in(text) if n in document.names and n not in values]
        open_ = [n for n in missing if f"names/{n}/value" not in faults]
        circle = next((n for n in missing if n in path), None)
        if current in name_values:
            values[current] = name_values[current]
        elif current in values or address in faults:
            pass
        elif circle is not None:
            members = list(path)
            chain = " → ".join(map(printable, [*members[members.index(circle) :], circle]))
            faults[address] = f"Name '{printable(current)}' is defined by itself: {chain}."
        elif open_:
            path[open_[0]] = None
            continue
        else:
            try:
                values[current] = _value(text, values, document)
            except ValueError as fault:
                faults[address] = str(fault)
        path.popitem()


def _value(text: str, values: Mapping[str, Any], document: Document) -> Any:
    """Value of a text; ValueError with a sentence if it has none."""
    if not text.strip():
        raise ValueError("A number, a name or arithmetic is missing.")
    for name in names_in(text):
        if name in values or name == "pi":
            continue
        if name in document.names:
            raise ValueError(f"'{printable(text)}' needs '{printable(name)}', which has no value.")
        names = ", ".join(map(printable, document.names))
        known = f"names are: {names}" if names else "there are no names yet"
        raise ValueError(f"'{printable(text)}' needs '{printable(name)}', but there is no such name; {known}.")
    try:
        return arithmetic_result(text, values)
    except ValueError as fault:
        raise ValueError(f"'{printable(text)}' {fault}.") from None


def structure(document: Document, *, arithmetic: bool = True) -> str:
    """Text that is equal for documents with equal compiled functions of their numbers.

    The Builder also chooses degrees of freedom and clamps by numbers. Keys therefore contain those of the model too.
    With ``arithmetic`` the functions depend on the free names, and texts such as "2*w" count; otherwise they depend on
    the numbers of :func:`numeric_values`.
    """
    values, _ = evaluated(document)

    def content(address: str, text: str) -> str:
        if address not in values:
            return f"! {text}"
        return "#" if is_number_text(text) or not arithmetic else text

    parts: list[Any] = [document.dimension]
    if arithmetic:
        parts.append([(name, content(f"names/{name}/value", entry["value"])) for name, entry in document.names.items()])
    for item in document.things:
        call, args = call_of(item), item["args"]
        for path, text in numbers(item):
            # A whole number chooses code.
            is_whole = call is not None and call.fields[path.partition("/")[0]]["whole"]
            address = f"{item['id']}/{path}"
            value = values.get(address, text) if is_whole else content(address, text)
            args = replaced(args, path.split("/"), value)
        parts.append((item["id"], item["call"], item.get("name"), sorted(args.items())))
    return repr(parts)
