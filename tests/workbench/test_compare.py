"""A pinned design beside the present one: what differs, and by how much."""

import pytest
from cases.documents import planar_guide
from cases.tolerances import approx

from flexmb.workbench.compare import Pinned, differences, percent
from flexmb.workbench.document import apply


def answers(**values):
    return {key: {"label": key, "value": own, "unit": "Hz", "text": f"{own} Hz"} for key, own in values.items()}


def test_what_differs_is_told_and_nothing_else():
    before = planar_guide()
    by_name = {thing.get("name", thing["call"]): thing["id"] for thing in before.things}
    ops = [
        {"op": "name", "name": "t", "to": {"value": "0.6e-3"}},
        {"op": "set", "address": f"{by_name['leaf']}/width", "to": "0.027"},
        {"op": "set", "address": f"{by_name['bar']}/released", "to": "2"},
        {"op": "add", "thing": {"call": "node", "name": "Z", "args": {"position": ["1", "1"]}}},
        {"op": "delete", "ids": [by_name["dof"]]},
    ]
    now, _ = apply(before, ops)
    width = before.by_id[by_name["leaf"]]["args"]["width"]
    found = differences(Pinned(before, 3, answers(a=10.0, b=5.0)), now, answers(a=20.0, c=1.0))
    assert [(one["label"], one["now"], one["percent"]) for one in found["names"]] == [("t", "0.6e-3", approx(20.0))]
    assert [(one["label"], one["before"], one["now"]) for one in found["fields"]] == [
        ("leaf: width", width, "0.027"),
        ("bar: released", None, "2"),
    ]
    assert found["fields"][0]["percent"] == approx(50.0)
    assert (found["added"], found["removed"], found["revision"]) == (["Z"], ["dof"], 3)
    assert [(one["key"], one["before"], one["now"], one["percent"]) for one in found["answers"]] == [
        ("a", 10.0, 20.0, 100.0),
        ("b", 5.0, None, None),
        ("c", None, 1.0, None),
    ]


def test_the_same_design_differs_in_nothing():
    document = planar_guide()
    found = differences(Pinned(document, 1, answers(a=1.0)), document, answers(a=1.0))
    assert not any(found[key] for key in ("names", "fields", "added", "removed"))
    assert found["answers"][0]["percent"] == 0


@pytest.mark.parametrize(("before", "now"), [(0.0, 1.0), (None, 1.0), (1.0, float("inf")), (1.0, None)])
def test_a_percentage_that_says_nothing_is_none(before, now):
    assert percent(before, now) is None


def test_a_percentage_is_of_the_size():
    assert percent(-2.0, -1.0) == 50.0
