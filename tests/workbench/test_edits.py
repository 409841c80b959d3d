"""Edits of documents: each gives what it says, refuses what cannot be, and leaves the old document as it was."""

import json

import numpy as np
import pytest
from cases import documents
from cases.tolerances import approx
from hypothesis import given, settings
from hypothesis import strategies as st

import flexmb as fm
from flexmb.workbench.building import build, numeric_values, positions
from flexmb.workbench.document import Document, EditError, apply
from flexmb.workbench.undo import History


def edited(document, *ops):
    return apply(document, list(ops))[0]


def names(document):
    return [thing.get("name", thing["call"]) for thing in document.things]


def thing(document, name):
    return next(t for t in document.things if t.get("name") == name)


def frequency(document):
    built = build(document)
    assert (built.problems, built.skipped) == ([], [])
    return float(fm.frequencies(built.model())[0])


GUIDE = documents.planar_guide()


def test_a_document_is_not_changed_by_an_edit_and_returns_from_its_text():
    before = GUIDE.text
    other = edited(GUIDE, {"op": "set", "address": "2/thickness", "to": "2*t"})
    assert GUIDE.text == before
    assert other.text != before
    assert Document.from_data(json.loads(other.text)).text == other.text


def test_a_thing_that_is_added_gets_an_id_and_a_name():
    document, report = apply(
        Document.empty(2),
        [
            {"op": "add", "thing": {"call": "node", "args": {"position": ["0", "0"]}}},
            {"op": "add", "thing": {"call": "node", "args": {"position": ["1", "0"]}}},
            {"op": "add", "thing": {"call": "planar.beam", "args": {"nodes": ["A", "B"], "released": ""}}},
            {"op": "add", "thing": {"call": "materials.stainless_301", "args": {}}, "before": "1"},
        ],
    )
    assert report.ids == ["1", "2", "3", "4"]
    assert names(document) == ["stainless_301", "A", "B", "beam 1"]
    assert thing(document, "beam 1")["args"] == {"nodes": ["A", "B"]}


@pytest.mark.parametrize(
    ("op", "address", "said"),
    [
        ({"op": "add", "thing": {"call": "node", "name": "left0", "args": {}}}, "15/name", "already"),
        ({"op": "add", "thing": {"call": "nodes", "args": {}}}, "", "Did you mean 'node'"),
        ({"op": "add", "thing": {"call": "node", "args": {"place": ["0"]}}}, "15/place", "takes no 'place'"),
        ({"op": "add", "thing": {"call": "spatial.beam", "args": {}}}, "", "space"),
        ({"op": "add", "thing": {"call": "node", "name": "A.rotation", "args": {}}}, "15/name", "part of a node"),
        ({"op": "add", "thing": {"call": "node", "name": "\n", "args": {}}}, "15/name", "printable"),
        ({"op": "add", "thing": {"call": "fix", "name": "foot", "args": {}}}, "15/name", "takes no name"),
        ({"op": "set", "address": "99/mass", "to": "1"}, "", "no thing"),
        ({"op": "set", "address": "12/weight", "to": "1"}, "12/weight", "takes no 'weight'"),
        ({"op": "set", "address": "12/mass/0/0", "to": "1"}, "12/mass/0/0", "no list"),
        ({"op": "set", "address": "12", "to": "1"}, "", "no address"),
        ({"op": "set", "address": "12/mass", "to": {"a": 1}}, "12/mass", "a text"),
        ({"op": "name", "name": "2t", "to": {"value": "1"}}, "names/2t", "no name of a number"),
        ({"op": "name", "name": "<script>", "to": {"value": "1"}}, "names/<script>", "no name of a number"),
        ({"op": "name", "name": "pi", "to": {"value": "1"}}, "names/pi", "pi"),
        ({"op": "name", "name": "t", "to": None}, "names/t", "is used: 2/thickness"),
        ({"op": "name", "name": "u", "to": {"value": ""}}, "names/u/value", "has no value"),
        ({"op": "rename", "name": "t", "to": "L"}, "names/t", "already"),
        ({"op": "rename", "id": "3", "to": "right0"}, "3/name", "already"),
        ({"op": "dimension", "to": 3}, "dimension", "Delete them before"),
        ({"op": "delete", "ids": ["99"]}, "", "no thing"),
        ({"op": "swap"}, "", "no operation"),
        ({"op": "join", "from": "left0", "into": "left0"}, "", "itself"),
        ({"op": "split", "element": "nothing"}, "", "no element"),
        ({"op": "copy", "ids": ["3"], "by": ["1"]}, "", "2 numbers"),
        ({"op": "copy", "ids": ["3"], "by": ["1", "0"], "count": 0}, "", "number of copies"),
        ({"op": "mirror", "ids": ["3"], "axis": "z"}, "", "must be x or y"),
        ({"op": "explode", "id": "3"}, "3", "no building block"),
    ],
)
def test_an_edit_that_cannot_be_is_refused_with_the_field(op, address, said):
    with pytest.raises(EditError) as fault:
        apply(GUIDE, [op])
    assert fault.value.address == address
    assert said in fault.value.message


@pytest.mark.slow
def test_names_of_things_stay_text():
    for name in ("x" * 100, "<script>alert(1)</script>", "ä ö 'quoted' \"twice\"", "1"):
        document = edited(GUIDE, {"op": "rename", "id": "3", "to": name})
        assert thing(document, "left 1")["args"]["nodes"] == [name, "left1"]
        assert frequency(document) == approx(10.6448474, rel=1e-8)


def test_references_follow_a_name():
    document = documents.drawn(
        2,
        {"t": "1e-3"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0", "0"]}),
            ("fix", None, {"node": "A"}),
            ("blocks.cross_pivot", "pivot", {"base": "A", "stage": "S", "section": "leaf", "length": "0.1"}),
            ("planar.beam", "arm", {"nodes": ["S", "pivot axis"], "section": "leaf"}),
            ("mass", None, {"node": "S", "mass": "1"}),
            ("sensor", "turn", {"weights": [["velocity S.x", "1/t"], ["S.rotation.phi", "2"]]}),
            ("prestress", None, {"element": "pivot leaf 1", "values": ["0", "0", "0", "1"]}),
        ],
    )
    assert build(document).problems == []
    ops = [{"op": "rename", "id": "5", "to": "joint"}, {"op": "set", "address": "5/stage", "to": "top"}]
    other = edited(document, *ops, {"op": "rename", "id": "3", "to": "foot"}, {"op": "rename", "name": "t", "to": "th"})
    assert build(other).problems == []
    assert thing(other, "arm")["args"]["nodes"] == ["top", "joint axis"]
    assert other.by_id["8"]["args"]["weights"] == [["velocity top.x", "1/th"], ["top.rotation.phi", "2"]]
    assert other.by_id["9"]["args"]["element"] == "joint leaf 1"
    assert other.by_id["5"]["args"]["base"] == other.by_id["4"]["args"]["node"] == "foot"
    assert other.by_id["2"]["args"]["thickness"] == "th"
    assert list(other.names) == ["th"]


def test_a_node_and_an_element_may_bear_the_same_name():
    document = documents.drawn(
        2,
        {},
        [
            ("node", "1", {"position": ["0", "0"]}),
            ("node", "2", {"position": ["0", "1"]}),
            ("planar.beam", "1", {"nodes": ["1", "2"], "section": "s"}),
            ("Rigidity", "s", {"EA": "1", "EIy": "1"}),
            ("fix", None, {"node": "1"}),
            ("mass", None, {"node": "2", "mass": "1", "inertia": "1"}),
            ("output", "o", {"of": "1", "component": "1", "kind": "element"}),
            ("sensor", "both", {"weights": [["2.y", "1"], ["velocity 2.x", "1"]]}),
        ],
    )
    assert build(document).problems == []
    other = edited(document, {"op": "rename", "id": "1", "to": "foot"}, {"op": "rename", "id": "3", "to": "arm"})
    other = edited(other, {"op": "rename", "id": "2", "to": "top"})
    assert build(other).problems == []
    assert other.by_id["3"]["args"]["nodes"] == ["foot", "top"]
    assert other.by_id["7"]["args"]["of"] == "arm"
    assert other.by_id["8"]["args"]["weights"] == [["top.y", "1"], ["velocity top.x", "1"]]


def test_arithmetic_is_renamed_by_names_alone():
    document = edited(
        GUIDE,
        {"op": "name", "name": "t2", "to": {"value": "2*t + 1e-3*t/t"}},
        {"op": "rename", "name": "t", "to": "e"},
    )
    assert document.names["t2"]["value"] == "2*e + 1e-3*e/e"


def test_what_refers_to_what_is_deleted_goes_along():
    document, report = apply(GUIDE, [{"op": "delete", "ids": ["4"]}])
    assert report.also == ["5", "11", "12", "14"]
    assert [t["id"] for t in document.things] == ["1", "2", "3", "6", "7", "8", "9", "10", "13"]
    assert build(document).problems == []
    assert apply(GUIDE, [{"op": "delete", "ids": ["1"]}])[1].also == ["2", "5", "9"]


@pytest.mark.slow
def test_a_copy_stands_beside_its_original_and_refers_to_its_own():
    ids = [t["id"] for t in GUIDE.things]
    document, report = apply(GUIDE, [{"op": "copy", "ids": ids, "by": ["3*d", "0"], "count": 2}])
    assert len(report.ids) == 2 * (len(ids) - 2)
    places, problems = positions(document), build(document).problems
    assert problems == []
    assert places["right5"] == approx([0.7, 0.1], rel=1e-12)
    one = fm.frequencies(build(GUIDE).model())
    three = fm.frequencies(build(document).model())
    assert np.asarray(three) == approx(np.repeat(np.asarray(one), 3), rel=1e-9)


def test_an_element_that_is_copied_takes_its_nodes_along():
    document, report = apply(GUIDE, [{"op": "copy", "ids": ["5"], "by": ["0.01", "0"]}])
    assert names(document)[-3:] == ["left2", "left3", "left 2"]
    assert thing(document, "left 2")["args"]["nodes"] == ["left2", "left3"]
    assert thing(document, "left2")["args"]["position"] == ["0.01", "0"]
    assert thing(document, "left3")["args"]["position"] == ["0.01", "L"]
    assert len(report.ids) == 3


def test_a_mirrored_half_shares_the_nodes_on_the_plane():
    half = documents.drawn(
        2,
        {"d": "0.1"},
        [
            ("node", "M", {"position": ["d/2", "0.1"]}),
            ("node", "B", {"position": ["0", "0.1"]}),
            ("planar.beam", "bar", {"nodes": ["B", "M"]}),
        ],
    )
    document, report = apply(half, [{"op": "mirror", "ids": ["1", "2", "3"], "axis": "x", "at": "d/2"}])
    assert len(report.ids) == 2
    assert thing(document, "bar 2")["args"]["nodes"] == ["C", "M"]
    assert thing(document, "C")["args"]["position"] == ["2*(d/2)", "0.1"]
    assert positions(document)["C"] == [0.1, 0.1]


def test_a_joined_node_gives_all_it_has():
    document = edited(GUIDE, {"op": "set", "address": "8/position", "to": ["0.11", "0.1"]})
    document = edited(document, {"op": "add", "thing": {"call": "node", "name": "X", "args": {"position": ["d", "L"]}}})
    document, report = apply(document, [{"op": "join", "from": "right1", "into": "X"}])
    assert report.also == []
    assert thing(document, "bar")["args"]["nodes"] == ["left1", "X"]
    assert frequency(document) == approx(10.6448474, rel=1e-8)
    _, report = apply(GUIDE, [{"op": "join", "from": "right1", "into": "left1"}])
    assert report.also == ["11"]


@pytest.mark.slow
def test_a_split_element_is_two_that_act_as_one():
    elastic = edited(
        GUIDE,
        *({"op": "set", "address": f"{id}/released", "to": ""} for id in ("5", "9")),
        {"op": "delete", "ids": ["14"]},
    )
    document, report = apply(elastic, [{"op": "split", "element": "left 1", "at": "0.25"}])
    assert names(document)[4:7] == ["left2", "left 1", "left 2"]
    assert report.ids == ["15", "16"]
    assert positions(document)["left2"] == approx([0, 0.025])
    assert thing(document, "left2")["args"]["position"] == ["0", "0.25*L"]
    # Without loads along them beams are exact; their mass is not lumped alike.
    light = edited(document, {"op": "set", "address": "1/rho", "to": "0"})
    assert frequency(light) == approx(
        frequency(edited(elastic, {"op": "set", "address": "1/rho", "to": "0"})), rel=1e-6
    )


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", ["parallel_guide", "notch_hinge", "wire_flexure"])
def test_an_exploded_block_is_the_same_mechanism(name, dimension):
    own = {"length": "0.1", "spacing": "0.05", "section": "leaf"}
    own = {k: v for k, v in own.items() if name != "notch_hinge" and (k != "spacing" or name == "parallel_guide")}
    if name == "notch_hinge":
        own = {"width": "w", "height": "0.01", "neck": "0.001", "radius": "0.005", "material": "steel"}
    inertia = ["1e-4"] if dimension == 2 else ["1e-4", "0", "0", "1e-4", "0", "1e-4"]
    document = documents.drawn(
        dimension,
        {"t": "1e-3", "w": "0.01"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0"] * dimension}),
            ("fix", None, {"node": "A"}),
            (f"blocks.{name}", "block", {"base": "A", "stage": "S", **own}),
            ("mass", None, {"node": "S", "mass": "0.1", "inertia": inertia}),
        ],
    )
    parts, report = apply(document, [{"op": "explode", "id": "5"}])
    assert len(report.ids) > 2
    assert all(t["call"] != f"blocks.{name}" for t in parts.things)
    built = build(parts)
    assert (built.problems, built.skipped) == ([], [])
    here, there = (np.asarray(fm.frequencies(build(one).model())) for one in (document, parts))
    assert there[:5] == approx(here[:5], rel=1e-9)


def test_problems_name_the_field_and_the_rest_is_built():
    def problems(*ops):
        built = build(edited(GUIDE, *ops))
        return [(p["address"], p["message"]) for p in built.problems], built.skipped

    def set_(address, to):
        return {"op": "set", "address": address, "to": to}

    for ops, address, said, skipped in (
        ([set_("2/thickness", "2**")], "2/thickness", "something is missing", ["2", "5", "9"]),
        ([set_("2/thickness", "q")], "2/thickness", "no such name; names are: t, L, d", ["2", "5", "9"]),
        ([set_("2/thickness", "-1")], "2/thickness", "must be positive", ["2", "5", "9"]),
        ([set_("2/thickness", "1/0")], "2/thickness", "division by zero", ["2", "5", "9"]),
        ([set_("1/E", "")], "1/E", "needs its E", ["1", "2", "5", "9"]),
        ([set_("1/G", "10e9")], "1/E", "by E and G", ["1", "2", "5", "9"]),
        ([set_("5/section", "leave")], "5/section", "no section 'leave'", ["5"]),
        ([set_("5/nodes/1", "nowhere")], "5/nodes/1", "No node 'nowhere'", ["5"]),
        ([set_("5/nodes", ["left0"])], "5/nodes", "joins", ["5"]),
        ([set_("5/released", "7")], "5/released", "deformations 1 to 3, not 7", ["5"]),
        ([set_("5/released", "some")], "5/released", "deformations 1 to 3, not 'some'", ["5"]),
        ([set_("5/second_order", "maybe")], "5/second_order", "true or false", ["5"]),
        ([set_("3/position", ["0"])], "3/position", "2 numbers", ["3", "5", "6"]),
        ([set_("4/position", ["0", "0"])], "5/nodes", "length", ["5"]),
        ([set_("12/mass", "-1")], "12/mass", "negative", ["12"]),
        ([set_("12/mass", "1e300")], "12/mass", "too large", ["12"]),
        ([set_("12/inertia", ["1", "2"])], "12/inertia", "1 number, not 2", ["12"]),
        ([set_("14/components", "z")], "14/components", "no coordinate 'z'", ["14"]),
        ([set_("14/of", "nobody")], "14/of", "nobody", ["14"]),
        ([set_("names/t/value", "2*")], "names/t/value", "missing", ["2", "5", "9"]),
        ([set_("names/t/value", "2*t")], "names/t/value", "defined by itself: t → t", ["2", "5", "9"]),
    ):
        found, left_out = problems(*ops)
        assert found, ops
        assert found[0][0] == address, (ops, found)
        assert said in found[0][1], (ops, found)
        assert left_out[: len(skipped)] == skipped, (ops, left_out)


def test_a_circle_of_names_is_told_and_a_long_chain_is_none():
    circle = edited(
        GUIDE, {"op": "name", "name": "a", "to": {"value": "b+1"}}, {"op": "name", "name": "b", "to": {"value": "2*a"}}
    )
    found = build(circle).problems
    assert [p["address"] for p in found] == ["names/b/value", "names/a/value"] or {p["address"] for p in found} == {
        "names/a/value",
        "names/b/value",
    }
    assert any("a → b → a" in p["message"] or "b → a → b" in p["message"] for p in found)
    ops = [{"op": "name", "name": f"n{k}", "to": {"value": f"n{k + 1}" if k < 3000 else "7"}} for k in range(3001)]
    assert numeric_values(edited(Document.empty(), *ops))["names/n0/value"] == 7


@pytest.mark.slow
def test_things_are_built_after_what_they_need_in_whatever_order_they_stand():
    document = GUIDE
    for thing_ in GUIDE.things:
        document = edited(document, {"op": "order", "id": thing_["id"], "before": document.things[0]["id"]})
    assert [t["id"] for t in document.things] == [t["id"] for t in reversed(GUIDE.things)]
    assert frequency(document) == approx(10.6448474, rel=1e-8)


# -- any edits whatever ----------------------------------------------------------------------------------------------

ADDRESSES = [
    "2/thickness",
    "3/position/0",
    "4/position",
    "5/released",
    "5/nodes/1",
    "12/mass",
    "names/t/value",
    "3/name",
]
VALUES = ["0.1", "2*t", "", "-1", "q", "all", "left1", "\u2028<b>", "1e308*10", ["1"], ["left1", ["left0"]], []]
IDS = [str(k) for k in range(1, 20)]
OPS = st.one_of(
    st.builds(lambda a, v: {"op": "set", "address": a, "to": v}, st.sampled_from(ADDRESSES), st.sampled_from(VALUES)),
    st.builds(lambda a: {"op": "delete", "ids": [a]}, st.sampled_from(IDS)),
    st.builds(lambda a, n: {"op": "rename", "id": a, "to": n}, st.sampled_from(IDS), st.sampled_from(VALUES)),
    st.builds(
        lambda n, v: {"op": "name", "name": n, "to": {"value": v}}, st.sampled_from("tuv"), st.sampled_from(VALUES)
    ),
    st.builds(lambda n, v: {"op": "rename", "name": n, "to": v}, st.sampled_from("tuv"), st.sampled_from("tuvw")),
    st.builds(
        lambda a, n: {"op": "copy", "ids": [a], "by": ["t", "0.1"], "count": n}, st.sampled_from(IDS), st.integers(0, 2)
    ),
    st.builds(
        lambda a, n: {"op": "mirror", "ids": [a], "axis": n, "at": "d"}, st.sampled_from(IDS), st.sampled_from("xyz")
    ),
    st.builds(lambda a, b: {"op": "join", "from": a, "into": b}, st.sampled_from(IDS), st.sampled_from(IDS)),
    st.builds(lambda a: {"op": "split", "element": a, "at": "0.3"}, st.sampled_from(IDS)),
    st.builds(lambda a, b: {"op": "order", "id": a, "before": b}, st.sampled_from(IDS), st.sampled_from(IDS)),
)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(OPS, max_size=8))
def test_undo_gives_the_text_back_after_any_edits(ops):
    history = History(GUIDE)
    texts = [GUIDE.text]
    for op in ops:
        try:
            history.edit([op])
        except EditError:
            assert history.document.text == texts[-1]
            continue
        texts.append(history.document.text)
        built = build(history.document)
        known = {one["id"] for one in history.document.things} | {"names"}
        assert all(p["address"].partition("/")[0] in known for p in built.problems)
        assert set(built.skipped) | set(built.made) == {one["id"] for one in history.document.things}
    for text in reversed(texts[:-1]):
        history.undo()
        assert history.document.text == text
    for text in texts[1:]:
        history.redo()
        assert history.document.text == text
