"""A building block taken apart: the nodes and elements that it makes, as things of their own."""

from typing import Any

from ..errors import clean
from .building import build
from .calls_of import Calls
from .content import Document, EditError, Report
from .fields import calls
from .formulas import text_of
from .references import call_of, replaced


def explode(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "explode", "id"}``: a block becomes its nodes and elements, which keep their names.

    Their positions are numbers from then on; sections stay as they are named.
    """
    thing = document.thing(op["id"])
    call, id = call_of(thing), thing["id"]
    if call is None or call.kind != "block":
        raise EditError(id, f"'{clean(thing.get('name', thing['call']))}' is no building block.")
    built = build(document)
    if id not in built.made:
        told = next((p["message"] for p in built.problems if p["address"].startswith(f"{id}/")), "it cannot be built.")
        raise EditError(id, f"Block '{clean(thing['name'])}' cannot be taken apart: {told}")
    records = [(record, document.by_id[one]["name"]) for one, record in built.records.items()]
    sections: list[dict[str, Any]] = []

    def name_of(record: Any) -> str:
        """Name of a section: that of the document, or that of the one that the block makes of its own arguments."""
        known = next((name for other, name in records if other is record), None)
        if known is None and not sections:
            sections.append(_section(document, thing))
        return known or sections[0]["name"]

    parts = Calls(built.builder, built.made[id], name_of)
    new = [*sections, *parts.said(list(map(text_of, parts.numbers)))]
    for one in new[len(sections) :]:
        space = "node" if one["call"] == "node" else "element"
        if one["name"] in document.known.by_space.get(space, {}):
            raise EditError(id, f"There is {space} '{clean(one['name'])}' already: rename it first.")
    first, place = document.data["next"], document.things.index(thing)
    new = [{"id": str(first + k), **one} for k, one in enumerate(new)]
    things = [*document.things[:place], *new, *document.things[place + 1 :]]
    report = Report([one["id"] for one in new], [], f"explode {thing['name']}")
    return document.with_things(things, next=first + len(new)), report


def _section(document: Document, block: dict[str, Any]) -> dict[str, Any]:
    """The section that a block makes: its own one with shear, or of a notch hinge that of its sizes."""
    if given := block["args"].get("section"):
        own = document.by_id[document.known.by_space["section"][given]]
        call, args, name = own["call"], replaced(own["args"], ["shear"], "true"), f"{given} with shear"
    else:
        args = {key: value for key, value in block["args"].items() if key in calls()["notch_circular"].fields}
        call, name = "notch_circular", f"{block['name']} notch"
    while name in document.known.by_space.get("section", {}):
        name += "'"
    return {"call": call, "name": name, "args": args}


OPERATIONS = {"explode": explode}
