"""A building block taken apart: its nodes and elements become things."""

from typing import Any

from ..errors import clean
from .building import build
from .calls_of import Calls
from .content import Document, EditError, Report
from .fields import calls
from .formulas import text_of
from .references import call_of, replaced


def explode(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "explode", "id"}``: nodes and elements of a block become things, with the same names."""
    thing = document.thing(op["id"])
    call, id = call_of(thing), thing["id"]
    if call is None or call.kind != "block":
        raise EditError(id, f"'{clean(thing.get('name', thing['call']))}' is no building block.")
    built = build(document)
    if id not in built.made:
        why = next((p["message"] for p in built.problems if p["address"].startswith(f"{id}/")), "it cannot be built.")
        raise EditError(id, f"Block '{clean(thing['name'])}' cannot be taken apart: {why}")
    records = [(record, document.by_id[record_id]["name"]) for record_id, record in built.records.items()]
    sections: list[dict[str, Any]] = []

    def name_of(record: Any) -> str:
        """Name of a section in the document, or of the section that the block makes of its arguments."""
        known = next((name for other, name in records if other is record), None)
        if known is None and not sections:
            sections.append(_section(document, thing))
        return known or sections[0]["name"]

    parts = Calls(built.builder, built.made[id], name_of)
    new = [*sections, *parts.filled(list(map(text_of, parts.numbers)))]
    for part in new[len(sections) :]:
        space = "node" if part["call"] == "node" else "element"
        if part["name"] in document.known.by_space.get(space, {}):
            raise EditError(id, f"There is {space} '{clean(part['name'])}' already. Rename it first.")
    first, place = document.data["next"], document.things.index(thing)
    new = [{"id": str(first + k), **part} for k, part in enumerate(new)]
    things = [*document.things[:place], *new, *document.things[place + 1 :]]
    return document.with_things(things, next=first + len(new)), Report(
        [part["id"] for part in new], [], f"explode {thing['name']}"
    )


def _section(document: Document, block: dict[str, Any]) -> dict[str, Any]:
    """The section that a block makes: its section with shear, or the notch of its sizes."""
    if name := block["args"].get("section"):
        section = document.by_id[document.known.by_space["section"][name]]
        call, args, name = section["call"], replaced(section["args"], ["shear"], "true"), f"{name} with shear"
    else:
        # With an element of its own a hinge is a plain beam.
        call = "notch_circular" if block["args"].get("element") else "hinge_circular"
        args = {key: value for key, value in block["args"].items() if key in calls()[call].fields}
        name = f"{block['name']} notch"
    return {"call": call, "name": document.known.unused("section", name), "args": args}


OPERATIONS = {"explode": explode}
