"""What a document of the workbench holds: names of numbers, and calls that build a mechanism, as plain JSON."""

from __future__ import annotations

import dataclasses
import functools
import json
from typing import Any, NamedTuple

from ..arguments import shown
from .references import Names

FORMAT = "flexmb workbench 1"
# A document with more things than this is no drawing, and nothing would answer in time.
MOST_THINGS = 20_000
# A text in a field is no longer than this.
LONGEST_TEXT = 20_000


class EditError(ValueError):
    """An edit that cannot be done, or a document that is none.

    Attributes:
        address: Field that is at fault, such as "5/nodes/1" or "names/t/value"; "" where there is none.
        message: What is wrong with it.
    """

    def __init__(self, address: str, message: str):
        super().__init__(message)
        self.address, self.message = address, message


class Report(NamedTuple):
    """What edits did.

    Attributes:
        ids: Of the things that were added, in order.
        also: Ids of the things that went along with what was deleted.
        label: What the edits are called in lists.
    """

    ids: list[str]
    also: list[str]
    label: str


@dataclasses.dataclass(frozen=True, eq=False)
class Document:
    """A mechanism as it is drawn: names, and things in order, each one call of the Builder.

    All numbers are texts: a number, a name, or arithmetic of names. An edit gives another document, which shares with
    this one what has not changed.

    Attributes:
        data: The document as JSON has it; not to be changed. "format", "title", "dimension", "names" (each with
            "value", and "low" and "high" where it is bounded), "next" (id of the next thing) and "things", each with
            "id", "call", "args" and, where it bears one, "name".
    """

    data: dict[str, Any]

    @classmethod
    def empty(cls, dimension: int = 2, title: str = "mechanism") -> Document:
        """A document without things.

        Args:
            dimension: 2 in the plane, 3 in space.
            title: What it is called.
        """
        return cls.from_data(
            {"format": FORMAT, "title": title, "dimension": dimension, "names": {}, "next": 1, "things": []}
        )

    @classmethod
    def from_data(cls, data: Any) -> Document:
        """A document from what JSON gives; what builds nothing is kept, and told by :func:`.building.build`.

        Args:
            data: See the attribute.

        Raises:
            EditError: It is no document: another format, or parts that are none.
        """
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            form = shown(data.get("format")) if isinstance(data, dict) else "none"
            raise EditError("", f"This is no document of format '{FORMAT}': its format is {form}.")
        if data.get("dimension") not in (2, 3) or isinstance(data["dimension"], bool | float):
            raise EditError("dimension", f"A document is of dimension 2 or 3, not {shown(data.get('dimension'))}.")
        names, things = data.get("names", {}), data.get("things", [])
        if not isinstance(names, dict) or not isinstance(things, list) or len(things) > MOST_THINGS:
            raise EditError("", f"A document has names and at most {MOST_THINGS} things.")
        whole = {
            "format": FORMAT,
            "title": checked_text("title", data.get("title", "")),
            "dimension": data["dimension"],
            "names": {name: checked_name(name, own) for name, own in names.items()},
            "next": 1,
            "things": [_checked_thing(k, thing) for k, thing in enumerate(things)],
        }
        ids = [thing["id"] for thing in whole["things"]]
        if len(set(ids)) < len(ids):
            twice = next(one for one in ids if ids.count(one) > 1)
            raise EditError(twice, f"Two things have the id {shown(twice)}.")
        given = data.get("next", 1)
        least = max((int(one) + 1 for one in ids if one.isascii() and one.isdecimal()), default=1)
        whole["next"] = max(given, least) if isinstance(given, int) and not isinstance(given, bool) else least
        return cls(whole)

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
        """Names of numbers: "value", and "low" and "high" where they are bounded."""
        return self.data["names"]

    @property
    def things(self) -> list[dict[str, Any]]:
        """The things in order."""
        return self.data["things"]

    @functools.cached_property
    def kept(self) -> dict[str, Any]:
        """What has been computed of the document, such as its values: not to be computed again."""
        return {}

    @functools.cached_property
    def by_id(self) -> dict[str, dict[str, Any]]:
        """The things by their ids."""
        return {thing["id"]: thing for thing in self.things}

    @functools.cached_property
    def known(self) -> Names:
        """Names of the things."""
        return Names(self.things)

    def thing(self, id: Any) -> dict[str, Any]:
        """The thing with an id.

        Args:
            id: Its id, a text.

        Raises:
            EditError: There is none.
        """
        found = self.by_id.get(id) if isinstance(id, str) else None
        if found is None:
            raise EditError("", f"There is no thing with the id {shown(id)}.")
        return found

    def with_things(self, things: list[dict[str, Any]], **more: Any) -> Document:
        """The document with other things.

        Args:
            things: In order.
            more: Other parts of the document, by name.
        """
        return Document({**self.data, **more, "things": things})


# -- what a document may hold ----------------------------------------------------------------------------------------


def checked_text(address: str, text: Any) -> str:
    """A text of a field.

    Raises:
        EditError: It is something else, or too long.
    """
    if isinstance(text, bool):
        return "true" if text else "false"
    if isinstance(text, int | float):
        return repr(text)
    if not isinstance(text, str):
        raise EditError(address, f"A field holds a text, not {shown(text)}.")
    if len(text) > LONGEST_TEXT or "\0" in text:
        raise EditError(address, f"A field holds a text of at most {LONGEST_TEXT} characters.")
    return text


def checked_value(address: str, value: Any, depth: int = 2) -> Any:
    """What an argument holds: a text, a list of them, or of pairs of them.

    Raises:
        EditError: It is something else.
    """
    if isinstance(value, list | tuple) and depth:
        return [checked_value(f"{address}/{k}", one, depth - 1) for k, one in enumerate(value)]
    return checked_text(address, value)


def checked_name(name: str, own: Any) -> dict[str, str]:
    """A name of a number: its value and its bounds.

    Raises:
        EditError: It is no name that arithmetic can hold, or something else than texts stands there.
    """
    address = f"names/{name}"
    if not isinstance(name, str) or not name.isidentifier() or name == "pi" or len(name) > LONGEST_TEXT:
        raise EditError(
            address,
            f"{shown(name)} is no name of a number: it takes letters, digits and _, begins with no digit, and"
            " is not pi.",
        )
    if not isinstance(own, dict) or "value" not in own or set(own) - {"value", "low", "high"}:
        raise EditError(address, f"Name '{name}' has a value, and may have low and high, not {shown(own)}.")
    return {key: checked_text(f"{address}/{key}", own[key]) for key in ("value", "low", "high") if key in own}


def _checked_thing(k: int, thing: Any) -> dict[str, Any]:
    if not isinstance(thing, dict) or not isinstance(thing.get("args", {}), dict):
        raise EditError("", f"Thing {k + 1} of the document is {shown(thing)}, but it must have a call and arguments.")
    id = thing.get("id")
    if not isinstance(id, str) or not id or "/" in id:
        raise EditError("", f"Thing {k + 1} of the document needs an id, a text without '/', not {shown(id)}.")
    if not isinstance(thing.get("call"), str):
        raise EditError(id, f"Thing {k + 1} of the document calls {shown(thing.get('call'))}.")
    args = {str(key): checked_value(f"{id}/{key}", value) for key, value in thing.get("args", {}).items()}
    own = {"id": id, "call": thing["call"]}
    if thing.get("name") not in (None, ""):
        own["name"] = checked_text(f"{id}/name", thing["name"])
    return {**own, "args": args}
