"""Two designs side by side: different names, fields and things, and their answers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ..errors import printable
from .building import numeric_values
from .document import Document
from .references import call_of


class Pinned(NamedTuple):
    """A design to compare with: document, revision, and answers by key (label, value, unit and text)."""

    document: Document
    revision: int
    answers: dict[str, dict[str, Any]]


def differences(pinned: Pinned, document: Document, answers: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Differences between a pinned design and the present one.

    Returns:
        "names" and "fields" that differ, each with label, before and now (texts or None) and percent; "added" and
        "removed" things; all "answers", each with key, label, unit, before and now (values), their texts and percent.
    """
    old, new = numeric_values(pinned.document), numeric_values(document)
    return {
        "revision": pinned.revision,
        "names": list(_names(pinned.document, document, old, new)),
        "fields": list(_fields(pinned.document, document, old, new)),
        "added": [_title(item) for item in document.things if item["id"] not in pinned.document.by_id],
        "removed": [_title(item) for item in pinned.document.things if item["id"] not in document.by_id],
        "answers": [_answer(key, pinned.answers.get(key), answers.get(key)) for key in {**pinned.answers, **answers}],
    }


def percent(before: Any, now: Any) -> float | None:
    """Change of a number in percent of its former size; None if that has no meaning."""
    numbers = isinstance(before, int | float) and isinstance(now, int | float)
    if not numbers or not (math.isfinite(before) and math.isfinite(now)) or before == 0:
        return None
    return 100 * (now - before) / abs(before)


def _names(before: Document, present: Document, old: Mapping, new: Mapping) -> Iterator[dict[str, Any]]:
    for name in {**before.names, **present.names}:
        texts = [version.names.get(name, {}).get("value") for version in (before, present)]
        address = f"names/{name}/value"
        if texts[0] != texts[1] or old.get(address) != new.get(address):
            yield _change(address, name, texts, old, new)


def _fields(before: Document, present: Document, old: Mapping, new: Mapping) -> Iterator[dict[str, Any]]:
    """Fields with different texts, of things in both; a different value of a name counts there."""
    for item in present.things:
        former, texts = (dict(_texts(t)) for t in (before.by_id.get(item["id"], item), item))
        for path in {**former, **texts}:
            if former.get(path) != texts.get(path):
                label = f"{_title(item)}: {path.split('/')[0].replace('_', ' ')}"
                yield _change(f"{item['id']}/{path}", label, [former.get(path), texts.get(path)], old, new)


def _change(address: str, label: str, texts: list[Any], old: Mapping, new: Mapping) -> dict[str, Any]:
    change = percent(old.get(address), new.get(address))
    return {"address": address, "label": label, "before": texts[0], "now": texts[1], "percent": change}


def _texts(item: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Texts of a thing, with their places in it."""
    if item.get("name"):
        yield "name", item["name"]
    waiting = list(reversed(item["args"].items()))
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, str):
            yield path, value
        else:
            waiting += [(f"{path}/{k}", entry) for k, entry in reversed(list(enumerate(value)))]


def _title(item: Mapping[str, Any]) -> str:
    call = call_of(dict(item))
    return printable(item.get("name") or (call.entry["title"] if call else item["call"]))


def _answer(key: str, before: Mapping[str, Any] | None, present: Mapping[str, Any] | None) -> dict[str, Any]:
    known, old, new = present or before or {}, before or {}, present or {}
    change = {"before": old.get("value"), "now": new.get("value")}
    texts = {"before_text": old.get("text"), "now_text": new.get("text"), "percent": percent(*change.values())}
    return {"key": key, "label": known.get("label", key), "unit": known.get("unit", ""), **change, **texts}
