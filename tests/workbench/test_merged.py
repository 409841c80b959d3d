"""Rotations of a file beside their positions, and the names that its comments tell."""

import flexmb as fm
from flexmb import planar
from flexmb.workbench.building import build
from flexmb.workbench.calls_of import Calls
from flexmb.workbench.content import FORMAT, Document
from flexmb.workbench.from_builder import merged


def document(b: fm.Builder) -> Document:
    known = Calls(b)
    things = known.filled([f"{float(number):g}" for number in known.numbers])
    own = [{"id": str(k), **thing} for k, thing in enumerate(things, 1)]
    return Document.from_data({"format": FORMAT, "title": "", "dimension": 2, "names": {}, "things": own})


def frame() -> fm.Builder:
    b = fm.Builder()
    for name, place in {"1": (0, 0), "3": (1, 0), "5": (0, 1), "6": (1, 1)}.items():
        b.node(name, place)
    for name in ("2", "4", "7"):
        b.rotation(name)
    b.add(planar.beam, "1", "2", "3", "4", name="1")
    b.add(planar.beam, "5", "2", "6", "7", name="2")
    return b


def test_a_rotation_beside_two_positions_stays_by_itself():
    found = build(merged(document(frame()), "")).builder
    assert found.members["1"].nodes == ("1", "2", "3", "3.rotation")
    assert found.members["2"].nodes == ("5", "2", "6", "6.rotation")


def test_what_is_fixed_and_named_stays_so():
    b = frame()
    b.fix("1")
    b.fix("3")
    b.fix("4")
    b.fix("7", 1)
    b.dof("6", 1, kind="node")
    b.dof("2", 1, kind="element")
    b.moment("4", 1.0)
    after = merged(document(b), "% node 3: foot\n% element 2: roof\n% node 2: hub")
    said = [(t["call"], t["args"]) for t in after.things if t["call"] in ("fix", "dof", "moment")]
    assert said == [
        ("fix", {"node": "1"}),
        ("fix", {"node": "foot"}),
        ("fix", {"node": "6", "components": "phi"}),
        ("dof", {"of": "6", "components": "x", "kind": "node"}),
        ("dof", {"of": "roof", "components": "1", "kind": "element"}),
        ("moment", {"node": "foot", "moment": ["1"]}),
    ]
    found = build(after).builder
    assert found.members["1"].nodes == ("1", "hub", "foot", "foot.rotation")
    counts = [one.build(check=False).counts() for one in (b, found)]
    assert counts[0] == counts[1]
    # Fixed at its position alone, it may turn.
    c = frame()
    c.fix("3")
    assert merged(document(c), "").things[-1]["args"] == {"node": "3", "components": "position"}
