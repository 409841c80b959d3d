"""What a document of the workbench contains: names of numbers, and calls that build a mechanism, as plain JSON."""

from __future__ import annotations

import dataclasses
import functools
import json
from typing import Any, NamedTuple

from ..arguments import short_repr
from .references import Names

FORMAT = "flexmb workbench 1"
# A page cannot draw and compute more things than this in time.
MOST_ITEMS = 20_000
# Longest text of a field, in characters.
LONGEST_TEXT = 20_000


class EditError(ValueError):
    """An edit or a document is wrong at an address, such as "5/nodes/1" or "names/t/value"; "" where there is none."""

    def __init__(self, address: str, message: str):
        super().__init__(message)
        self.address, self.message = address, message


class Report(NamedTuple):
    """What edits did: ids of added things, ids of things deleted with others, and the label of the step."""

    ids: list[str]
    also: list[str]
    label: str


@dataclasses.dataclass(frozen=True, eq=False)
class Document:
    """A mechanism as a list of things, each one call of the Builder, and names of numbers.

    All numbers are texts: a number, a name, or arithmetic of names. An edit returns another document, which shares all
    unchanged parts.

    Attributes:
        data: The document as JSON, not to be changed: "format", "title", "dimension", "names" (each with "value" and
            optional "low" and "high"), "next" (id of the next thing) and "things" (each with "id", "call", "args" and
            an optional "name").
    """

    data: dict[str, Any]

    @classmethod
    def empty(cls, dimension: int = 2, title: str = "mechanism") -> Document:
        """Return a document without things.

        Args:
            dimension: 2 in the plane, 3 in space.
            title: Title of the document.
        """
        return cls.from_data({"format": FORMAT, "title": title, "dimension": dimension})

    @classmethod
    def from_data(cls, data: Any) -> Document:
        """Return the document of JSON data. It keeps things that build nothing; :func:`.building.build` reports them.

        Args:
            data: See the attribute.

        Raises:
            EditError: The format or a part of the document is wrong.
        """
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            form = short_repr(data.get("format")) if isinstance(data, dict) else "none"
            raise EditError("", f"The document has the format {form}. The workbench reads '{FORMAT}'.")
        if data.get("dimension") not in (2, 3) or isinstance(data["dimension"], bool | float):
            raise EditError("dimension", f"The dimension is {short_repr(data.get('dimension'))}. It must be 2 or 3.")
        names, items = data.get("names", {}), data.get("things", [])
        if not isinstance(names, dict) or not isinstance(items, list) or len(items) > MOST_ITEMS:
            raise EditError("", f"A document must have a dictionary of names and at most {MOST_ITEMS} things.")
        content = {
            "format": FORMAT,
            "title": checked_text("title", data.get("title", "")),
            "dimension": data["dimension"],
            "names": {name: checked_name(name, entry) for name, entry in names.items()},
            "next": 1,
            "things": [_checked_item(k, item) for k, item in enumerate(items)],
        }
        ids = [item["id"] for item in content["things"]]
        if len(set(ids)) < len(ids):
            twice = next(id for id in ids if ids.count(id) > 1)
            raise EditError(twice, f"Two things have the id {short_repr(twice)}. Each needs its own.")
        following = data.get("next", 1)
        least = max((int(id) + 1 for id in ids if id.isascii() and id.isdecimal()), default=1)
        is_whole = isinstance(following, int) and not isinstance(following, bool)
        content["next"] = max(following, least) if is_whole else least
        return cls(content)

    @functools.cached_property
    def text(self) -> str:
        """The document as JSON text, equal for equal documents."""
        return json.dumps(self.data, ensure_ascii=False, indent=1, sort_keys=False)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.data["dimension"]

    @property
    def names(self) -> dict[str, dict[str, str]]:
        """Names of numbers, each with "value" and optional "low" and "high"."""
        return self.data["names"]

    @property
    def things(self) -> list[dict[str, Any]]:
        """Things in order."""
        return self.data["things"]

    @functools.cached_property
    def kept(self) -> dict[str, Any]:
        """Results computed from the document, such as its values."""
        return {}

    @functools.cached_property
    def by_id(self) -> dict[str, dict[str, Any]]:
        """Things by their ids."""
        return {item["id"]: item for item in self.things}

    @functools.cached_property
    def known(self) -> Names:
        """Names of the things."""
        return Names(self.things)

    def thing(self, id: Any) -> dict[str, Any]:
        """Return the thing with an id.

        Args:
            id: Id of the thing, a text.

        Raises:
            EditError: No thing has this id.
        """
        if not isinstance(id, str) or id not in self.by_id:
            raise EditError("", f"There is no thing with the id {short_repr(id)}.")
        return self.by_id[id]

    def with_things(self, things: list[dict[str, Any]], **more: Any) -> Document:
        """Return the document with other things.

        Args:
            things: Things in order.
            more: Other parts of the document, by name.
        """
        return Document({**self.data, **more, "things": things})


def checked_text(address: str, text: Any) -> str:
    """Return the text of a field."""
    if isinstance(text, bool):
        return "true" if text else "false"
    if isinstance(text, int | float):
        return repr(text)
    if not isinstance(text, str):
        raise EditError(address, f"{short_repr(text)} is no text. A field needs a text.")
    if len(text) > LONGEST_TEXT or "\0" in text:
        raise EditError(address, f"The text is too long. A field has at most {LONGEST_TEXT} characters.")
    return text


def checked_value(address: str, value: Any, depth: int = 2) -> Any:
    """Return the value of an argument: a text, a list of texts, or a list of pairs."""
    if isinstance(value, list | tuple) and depth:
        return [checked_value(f"{address}/{k}", entry, depth - 1) for k, entry in enumerate(value)]
    return checked_text(address, value)


def checked_name(name: str, entry: Any) -> dict[str, str]:
    """Return the value and the bounds of a name that arithmetic can contain."""
    address = f"names/{name}"
    if not isinstance(name, str) or not name.isidentifier() or name == "pi" or len(name) > LONGEST_TEXT:
        message = f"{short_repr(name)} is no name of a number. Use letters, digits and _, no digit first, and not pi."
        raise EditError(address, message)
    if not isinstance(entry, dict) or "value" not in entry or set(entry) - {"value", "low", "high"}:
        raise EditError(address, f"Name '{name}' is {short_repr(entry)}. It needs a value, and may have low and high.")
    return {key: checked_text(f"{address}/{key}", entry[key]) for key in ("value", "low", "high") if key in entry}


def _checked_item(k: int, item: Any) -> dict[str, Any]:
    if not isinstance(item, dict) or not isinstance(item.get("args", {}), dict):
        raise EditError("", f"Thing {k + 1} of the document is {short_repr(item)}. It needs a call and arguments.")
    id, call, name = item.get("id"), item.get("call"), item.get("name")
    if not isinstance(id, str) or not id or "/" in id:
        raise EditError("", f"Thing {k + 1} of the document has the id {short_repr(id)}. It needs a text without '/'.")
    if not isinstance(call, str):
        raise EditError(id, f"Thing {k + 1} of the document calls {short_repr(call)}. A call is a text.")
    args = {str(key): checked_value(f"{id}/{key}", value) for key, value in item.get("args", {}).items()}
    named = {} if name in (None, "") else {"name": checked_text(f"{id}/name", name)}
    return {"id": id, "call": call, **named, "args": args}
