"""Two designs side by side: which names, fields and things differ, and what that does to the answers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ..errors import clean
from .building import numbers_of
from .document import Document
from .references import call_of


class Pinned(NamedTuple):
    """A design that others are compared with.

    Attributes:
        document: The design.
        revision: Its own.
        answers: That belong to it, by key: label, value, unit and text.
    """

    document: Document
    revision: int
    answers: dict[str, dict[str, Any]]


def differences(pinned: Pinned, document: Document, answers: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """What differs between a pinned design and the present one.

    Returns:
        "names" and "fields" that differ, each with label, before and now (texts, None where there is none) and
        percent; "added" and "removed" things; "answers", all of both, each with key, label, unit, before and now
        (values), texts of them and percent, of those whose size is told.
    """
    old, new = numbers_of(pinned.document), numbers_of(document)
    return {
        "revision": pinned.revision,
        "names": list(_names(pinned.document, document, old, new)),
        "fields": list(_fields(pinned.document, document, old, new)),
        "added": [_called(thing) for thing in document.things if thing["id"] not in pinned.document.by_id],
        "removed": [_called(thing) for thing in pinned.document.things if thing["id"] not in document.by_id],
        "answers": [_answer(key, pinned.answers.get(key), answers.get(key)) for key in {**pinned.answers, **answers}],
    }


def percent(before: Any, now: Any) -> float | None:
    """By how much a number is larger than another, in percent of its size; None where that says nothing."""
    numbers = isinstance(before, int | float) and isinstance(now, int | float)
    if not numbers or not (math.isfinite(before) and math.isfinite(now)) or before == 0:
        return None
    return 100 * (now - before) / abs(before)


def _names(before: Document, now: Document, old: Mapping, new: Mapping) -> Iterator[dict[str, Any]]:
    for name in {**before.names, **now.names}:
        texts = [own.names.get(name, {}).get("value") for own in (before, now)]
        address = f"names/{name}/value"
        if texts[0] != texts[1] or old.get(address) != new.get(address):
            yield _change(address, name, texts, old, new)


def _fields(before: Document, now: Document, old: Mapping, new: Mapping) -> Iterator[dict[str, Any]]:
    """Fields of things of both whose texts differ; what differs by the value of a name is told there."""
    for thing in now.things:
        other = before.by_id.get(thing["id"])
        if other is None:
            continue
        own, its = dict(_texts(thing)), dict(_texts(other))
        for path in {**its, **own}:
            if its.get(path) != own.get(path):
                label = f"{_called(thing)}: {path.split('/')[0].replace('_', ' ')}"
                yield _change(f"{thing['id']}/{path}", label, [its.get(path), own.get(path)], old, new)


def _change(address: str, label: str, texts: list[Any], old: Mapping, new: Mapping) -> dict[str, Any]:
    change = percent(old.get(address), new.get(address))
    return {"address": address, "label": label, "before": texts[0], "now": texts[1], "percent": change}


def _texts(thing: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Texts of a thing by their places in it."""
    if thing.get("name"):
        yield "name", thing["name"]
    waiting = list(reversed(thing["args"].items()))
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, str):
            yield path, value
        else:
            waiting += [(f"{path}/{k}", one) for k, one in reversed(list(enumerate(value)))]


def _called(thing: Mapping[str, Any]) -> str:
    call = call_of(dict(thing))
    return clean(thing.get("name") or (call.entry["title"] if call else thing["call"]))


def _answer(key: str, before: Mapping[str, Any] | None, now: Mapping[str, Any] | None) -> dict[str, Any]:
    known = now or before or {}
    values = [None if own is None else own.get("value") for own in (before, now)]
    texts = [None if own is None else own.get("text") for own in (before, now)]
    return {
        "key": key,
        "label": known.get("label", key),
        "unit": known.get("unit", ""),
        "before": values[0],
        "now": values[1],
        "before_text": texts[0],
        "now_text": texts[1],
        "percent": percent(*values),
    }
