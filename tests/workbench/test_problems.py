"""Whatever stands in a field, a document is built as far as it goes, and what is wrong is told of the thing."""

import pytest
from cases import documents

from flexmb.workbench.building import build, numeric_values, positions, structure
from flexmb.workbench.document import Document, EditError, apply
from flexmb.workbench.fields import calls

ODD = [
    "",
    "x",
    "A",
    "1",
    "-1",
    "0",
    "1e200",
    "1e-400",
    "all",
    "true",
    "2*t",
    "t t",
    "9" * 400,
    "<script>",
    "A.rotation",
]
LISTS = [[], ["1"], ["1", "2", "3"], ["A", "A"], ["A", "B"], ["A", ["B"]], [["A.x", "1"]], [["A.x", "2*"]], [["A"]]]


def surrounded(dimension) -> Document:
    """A document with one of each that others refer to."""
    zeros = ["0"] * (dimension - 1)
    return documents.drawn(
        dimension,
        {"t": "1e-3"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0", *zeros]}),
            ("node", "B", {"position": ["0.1", *zeros]}),
            ("spatial.beam" if dimension == 3 else "planar.beam", "it", {"nodes": ["A", "B"], "section": "leaf"}),
        ],
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", calls())
def test_no_field_of_a_call_breaks_the_building(name):
    call = calls()[name]
    document = surrounded(call.entry["dimension"] or 2)
    document, report = apply(document, [{"op": "add", "thing": {"call": name, "args": {}}}])
    (id,) = report.ids
    needed = [field for field in call.entry["fields"] if not field["optional"]]
    built = build(document)
    assert {p["address"] for p in built.problems} >= {f"{id}/{field['name']}" for field in needed}
    assert (id in built.skipped) == bool(built.problems)
    for field in call.fields:
        for value in (*ODD, *LISTS):
            other, _ = apply(document, [{"op": "set", "address": f"{id}/{field}", "to": value}])
            built = build(other)
            assert {p["address"].partition("/")[0] for p in built.problems} <= {id}, (field, value, built.problems)
            assert all(p["message"] for p in built.problems)
            assert len(built.skipped) == (1 if built.problems else 0)
            structure(other)
            positions(other, built)
            numeric_values(other)


def test_a_document_of_another_version_is_kept_and_told():
    data = surrounded(2).data
    data = {
        **data,
        "things": [*data["things"], {"id": "77", "call": "planar.cam", "name": "c", "args": {"nodes": ["A"]}}],
    }
    document = Document.from_data(data)
    built = build(document)
    assert [p["address"] for p in built.problems] == ["77"]
    assert "This version has no call" in built.problems[0]["message"]
    other, _ = apply(document, [{"op": "set", "address": "77/nodes", "to": ["B"]}, {"op": "delete", "ids": ["77"]}])
    assert build(other).problems == []


FORMAT = {"format": "flexmb workbench 1", "dimension": 2}
NODE = {"id": "1", "call": "node", "args": {}}


@pytest.mark.slow("data12")
@pytest.mark.parametrize(
    "data",
    [
        None,
        [],
        {},
        {"format": FORMAT["format"]},
        {**FORMAT, "dimension": True},
        {**FORMAT, "things": {}},
        {**FORMAT, "things": [1]},
        {**FORMAT, "things": [{**NODE, "args": {"position": {}}}]},
        {**FORMAT, "things": [{**NODE, "id": "1/2"}]},
        {**FORMAT, "things": [NODE, NODE]},
        {**FORMAT, "names": {"1": {"value": "1"}}},
        {**FORMAT, "names": {"t": {"value": "1", "step": "2"}}},
        {**FORMAT, "names": {"t": "1"}},
    ],
)
def test_what_is_no_document_is_refused(data):
    with pytest.raises(EditError):
        Document.from_data(data)
