"""What is counted of finished and unfinished drawings, and what is advised about them."""

import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.workbench.advice import advice, mass_advice
from flexmb.workbench.counts import count, quick_numbers


def a_leaf(*, fixed: bool = True) -> fm.Builder:
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("top", (0, 0.1))
    b.add(planar.beam, "foot", "top", name="leaf", section=mechanisms.leaf())
    if fixed:
        b.fix("foot")
    return b


def done(b: fm.Builder, ops: list[dict]) -> fm.Builder:
    """What a button does, on a Builder: the document would make the same calls."""
    twin = b.copy()
    for op in ops:
        thing, args = op["thing"], op["thing"]["args"]
        if thing["call"] == "release":
            twin.release(args["element"], *map(int, args["deformations"].split()))
        elif thing["call"] == "fix":
            twin.fix(args["node"], *args.get("components", "").split())
        elif thing["call"] == "dof":
            twin.dof(args["of"], *args["components"].split())
        elif thing["call"] == "mass":
            twin.mass(args["node"], float(args["mass"]))
    return twin


def test_nothing_nodes_alone_and_disconnected_nodes_are_counted_and_helped():
    b = fm.Builder()
    assert count(b).status == "empty"
    assert "Add a node" in count(b).message
    b.node("A", (0, 0))
    b.node("B", (1, 0))
    assert count(b).status == "empty"
    assert count(b).numbers["ndof"] == 4
    b = a_leaf()
    b.node("C", (1, 1))
    found = count(b)
    assert found.status == "loose"
    assert "Node 'C' is joined to nothing" in found.message
    assert found.numbers["ndof"] == 5
    things = [{"id": "7", "call": "node", "name": "C", "args": {}}]
    assert advice(found, things) == [{"text": "Delete node 'C'", "ops": [{"op": "delete", "ids": ["7"]}]}]


def test_what_floats_is_named_and_can_be_fixed():
    floats = count(a_leaf(fixed=False))
    assert (floats.status, floats.numbers["ndof"]) == ("loose", 6)
    assert "Nothing is fixed" in floats.message
    (own,) = advice(floats, [])
    assert count(done(a_leaf(fixed=False), own["ops"])).status == "ok"
    b = a_leaf()
    b.node("C", (1, 0))
    b.node("D", (1, 1))
    b.add(planar.beam, "C", "D", name="other", section=mechanisms.leaf())
    assert "Element 'other' floats" in count(b).message


def test_counts_are_those_of_the_tutorial():
    # WA 1239 (2012), section 2.2: the spatial guide has NDOF = 0 and one over-constraint; released, NDOF = 1.
    over = count(mechanisms.spatial_guide())
    assert (over.status, over.over, over.numbers["ndof"]) == ("overconstrained", 1, 0)
    assert set(over.message_data()["shares"][0]) == {"left 1", "right 1", "bar"}
    exact = count(mechanisms.spatial_guide(extra=(6,)))
    assert (exact.status, exact.over, exact.numbers["ndof"], exact.dofs) == ("ok", 0, 1, ("left1.y",))
    assert exact.warnings, "of plain beams"
    assert quick_numbers(mechanisms.spatial_guide()) == over.numbers


def test_the_advice_makes_an_over_constrained_guide_exactly_constrained():
    guide = mechanisms.spatial_guide()
    (own,) = advice(count(guide), [])
    assert count(done(guide, own["ops"])).status == "ok"
    things = [{"id": "4", "call": "spatial.beam", "name": "left 1", "args": {"nodes": ["a", "b"], "released": "2 3 4"}}]
    (own,) = advice(count(guide), things)
    assert own["ops"] == [{"op": "set", "address": "4/released", "to": "2 3 4 5"}]


@pytest.mark.slow
def test_too_few_degrees_of_freedom_are_named_or_fixed_by_the_advice():
    guide = mechanisms.spatial_guide(beams=2, extra=(6,))
    found = count(guide)
    assert (found.status, found.under) == ("underconstrained", 7)
    named = [{"id": "9", "call": "dof", "args": {}}]
    given = {one["text"].split()[0]: one["ops"] for one in advice(found, named)}
    assert given["Have"] == [{"op": "delete", "ids": ["9"]}]
    assert count(done(guide, given["Name"])).status == "ok"
    planar_guide = mechanisms.planar_guide(elongation=True, dofs=False)
    planar_guide.dof("left1", "x")
    given = {one["text"].split()[0]: one["ops"] for one in advice(count(planar_guide), named)}
    assert count(done(planar_guide, given["Fix"])).status == "ok"


@pytest.mark.slow
def test_mass_is_advised_where_none_is():
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, 0.1))
    b.add(planar.truss, "A", "B", name="bar", section=fm.Rigidity(EA=1e6))
    b.fix("A")
    b.fix("B", "x")
    (own,) = mass_advice(b.build())
    assert own["text"] == "Put a mass on node 'B'"
    assert fm.frequencies(done(b, own["ops"]).build())[0] == approx(
        # One mass of 0.1 kg on a spring EA/L of 1e7 N/m.
        (1e7 / 0.1) ** 0.5 / (2 * 3.141592653589793),
        rel=1e-12,
    )


@pytest.mark.slow
def test_what_the_builder_refuses_is_told_and_counted():
    b = a_leaf()
    b.input("foot", "x")
    found = count(b)
    assert found.status == "failed"
    assert "acts on a coordinate that is fixed" in found.message
    assert found.numbers["ndof"] == 3
    assert found.drawn is not None
