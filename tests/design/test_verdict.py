"""One page on a mechanism over its stroke, against closed forms, shooting (B1) and printed numbers (T3)."""

import dataclasses
import json
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.optimize import minimize_scalar

import flexmb as fm
from flexmb import planar, spatial
from flexmb.answers.answers import plain
from flexmb.design.over_stroke import StrokeQuestions
from flexmb.design.stroke import driven
from flexmb.display import quantity_text

mpl.use("Agg")
import matplotlib.pyplot as plt

# Of a material that states what it bears.
STRENGTH, FATIGUE = 1000e6, 500e6
STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0, strength=STRENGTH, fatigue=FATIGUE)
LENGTH, WIDTH, T, DISTANCE = 0.1, 0.018, 0.5e-3, 0.1
DELTA = 1e-3 * LENGTH


def guide(t=T, length=LENGTH, load=0.0, push=0.0, material=STEEL, prescribed=False, width=WIDTH, stack=None):
    """T2 driven at half the height, P, where the force tilts nothing; its leaf springs do not stretch."""
    leaf = fm.Rectangle(width, t, material)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (DISTANCE, length), "D": (DISTANCE, 0)}.items():
        b.node(name, place)
    b.node("P", (DISTANCE / 2, length / 2))
    b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
    b.add(planar.beam, "D", "C", name="right", section=leaf, released=(2, 3))
    b.add(planar.beam, "B", "C", name="stage")
    b.add(planar.beam, "B", "P", name="arm")
    if stack is not None:
        b.add(planar.truss, "D", "P", name="stack", section=stack)
    for foot in "AD":
        b.fix(foot)
    for node in "BC":
        b.mass(node, 0.1)
    b.force("B", (0, -load))
    b.force("P", (push, 0))
    if prescribed:
        b.prescribe("P", "x", 1e-3, increment=True)
    else:
        b.dof("B", "x")
    return b.build()


def of_dimensions(t, length, width=WIDTH):
    return guide(t, length, width=width)


EI = STEEL.E * WIDTH * T**3 / 12


@pytest.fixture(scope="module")
def page():
    return fm.verdict(of_dimensions, {"P.x": DELTA}, dimensions={"t": T, "length": LENGTH, "width": WIDTH}, steps=1)


@pytest.mark.slow
def test_any_question_of_a_state_may_limit_the_stroke():
    found = fm.verdict(guide(), {"P.x": DELTA}, steps=1, count=1, limits={"stress left": 1e6, "displacement B.x": 1.0})
    # Both leaf springs bend alike.
    np.testing.assert_allclose(found.curves["stress left"], found.curves["stress"], rtol=1e-6)
    np.testing.assert_allclose(found.curves["displacement B.x"], found.stroke, rtol=1e-4, atol=1e-12)
    assert (found.units["stress left"], found.units["displacement B.x"]) == ("Pa", "m")
    assert found.limits[0].name == "stress left"
    assert found.limits[0].stroke == approx(1e6 * LENGTH**2 / (3 * STEEL.E * T), rel=1e-3)


@pytest.mark.slow
def test_guide_is_the_closed_form(page):
    # What is left out is of the order of the square of the stroke over the length, 1e-6.
    close = {"rtol": 1e-5}
    stiffness = 24 * EI / LENGTH**3
    np.testing.assert_allclose(page.stroke, [-DELTA, 0, DELTA])
    np.testing.assert_allclose(page.curves["drive stiffness"], stiffness, **close)
    np.testing.assert_allclose(page.curves["force"], stiffness * page.stroke, **close, atol=1e-12)
    stress = 3 * STEEL.E * T * DELTA / LENGTH**2
    np.testing.assert_allclose(page.curves["stress"], [stress, 0, stress], **close, atol=1e-3)
    np.testing.assert_allclose(page.curves["yield"][2], stress / STRENGTH, **close)
    np.testing.assert_allclose(page.curves["fatigue"][2], stress / FATIGUE, **close)
    np.testing.assert_allclose(page.curves["parasitic y"][2], -0.6 * DELTA**2 / LENGTH, **close)
    # The mass of cubic beams in sway, 13/35 of each, and of the stage.
    mass = 0.2 + 26 / 35 * STEEL.rho * WIDTH * T * LENGTH
    np.testing.assert_allclose(page.curves["frequency 1"], np.sqrt(stiffness / mass) / (2 * np.pi), **close)
    # Nothing stretches, so that the drive holds everything.
    assert np.all(np.isinf(page.curves["stiffness y"]))
    assert page.places[2].place in (0.0, 1.0)
    assert (page.driven, page.node, page.unit) == ("P.x", "P", "m")
    assert page.good


@pytest.mark.slow
def test_the_page_says_what_limits_and_what_moves_it(page):
    first = page.limits[0]
    stress = 3 * STEEL.E * T * DELTA / LENGTH**2
    assert (first.name, first.stroke) == ("fatigue", None)
    assert max(first.used) == approx(stress / FATIGUE, rel=1e-5)
    found = page.sensitivities
    table = {
        name: dict(zip(found.dimensions, row, strict=True))
        for name, row in zip(found.answers, found.table, strict=True)
    }
    # Closed forms: powers of thickness and length; left out is the square of the stroke over the length.
    for name, t, length in (("stress", 1, -2), ("fatigue", 1, -2), ("drive stiffness", 3, -3), ("force", 3, -3)):
        assert table[name]["t"] == approx(t, rel=1e-5)
        assert table[name]["length"] == approx(length, rel=1e-5)
    assert table["parasitic y"]["length"] == approx(-1, rel=1e-5)
    # Stress is that of any width, but for round-off, which is no advice.
    assert abs(table["fatigue"]["width"]) < 1e-9
    assert table["force"]["width"] == approx(1, rel=1e-9)
    rows = page.summary().rows
    assert rows["by dimension"] == "larger length (-2), smaller t (+1): percent of fatigue for one percent"
    assert rows["limits first"].startswith("none within the stroke; fatigue comes nearest, 0.0063 of it")
    told = dataclasses.replace(found, dimensions=("width",), table=found.table[:, 2:])
    alone = dataclasses.replace(page, sensitivities=told).summary().rows
    assert alone["by dimension"] == "none of them moves fatigue"
    assert rows["over-constraints"] == "none"
    assert "y rigid in the model" in rows["support stiffness"]
    assert "no constant loads" in rows["stability"]
    assert "good enough" in repr(page)
    assert "parasitic y [m]" in str(page)


@pytest.mark.slow
def test_what_is_not_judged_is_said(page):
    """A stack of which the rigidity alone is known: the stress of the leaf springs is judged, its own is not."""
    soft = fm.Rigidity(EA=1e-3)
    found = fm.verdict(guide(stack=soft), {"P.x": DELTA}, steps=1)
    # The stack is 1e-5 of the stiffness of the guide.
    np.testing.assert_allclose(found.curves["stress"], page.curves["stress"], rtol=1e-4, atol=1e-3)
    assert found.not_judged == ("stress of 'stack'",)
    assert found.summary().title.endswith("good enough; not judged: stress of 'stack'")
    assert "without a shape" in found.summary().rows["not answered"]
    assert plain(found.to_dict())["not_judged"] == ["stress of 'stack'"]
    assert page.not_judged == ()
    silent = fm.verdict(guide(material=dataclasses.replace(STEEL, fatigue=None)), {"P.x": DELTA}, steps=1)
    assert silent.not_judged == ("fatigue",)


@pytest.mark.slow
def test_slopes_are_central_differences(page):
    h, found = 1e-4, page.sensitivities
    # Of the two where a limit is used most, that along the stroke.
    state = 2
    up, down = (fm.verdict(guide(T * (1 + s * h)), {"P.x": DELTA}, steps=1).curves for s in (1, -1))
    for name in ("frequency 1", "stress", "force"):
        difference = (up[name][state] - down[name][state]) / (2 * h * page.curves[name][state])
        # Truncation h^2 = 1e-8, round-off 1e-16/h times the condition of the state.
        assert found.table[found.answers.index(name), 0] == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_limits_are_where_they_are_reached():
    wide = fm.verdict(guide(), {"P.x": (0, 10 * DELTA)}, steps=2, limits={"force": 0.9, "parasitic y": 1e-6})
    reached = {limit.name: limit.stroke for limit in wide.limits}
    # Closed forms; the square of the stroke over the length is 1e-4.
    assert reached["force"] == approx(0.9 * LENGTH**3 / (24 * EI), rel=1e-3)
    assert reached["parasitic y"] == approx(np.sqrt(1e-6 * LENGTH / 0.6), rel=1e-3)
    assert [limit.name for limit in wide.limits[:2]] == ["parasitic y", "force"]
    assert not wide.good
    assert "parasitic y limits it to 408.2" in wide.summary().title
    assert json.loads(json.dumps(plain(wide.to_dict())))["limits"][0]["name"] == "parasitic y"


@pytest.mark.slow
def test_of_both_sides_the_earlier_counts():
    # A force that pushes along the stroke, 0.2 N, is taken off the drive.
    found = fm.verdict(guide(push=0.2), {"P.x": 10 * DELTA}, steps=1, limits={"force": 0.5})
    assert found.limits[0].stroke == approx(-0.3 * LENGTH**3 / (24 * EI), rel=1e-3)


@pytest.mark.slow
def test_buckling_under_the_constant_loads():
    silent = fm.Material(E=210e9, G=80e9, rho=7850.0)
    model = guide(load=1.0, material=silent, prescribed=True)
    # What is prescribed with an increment is what is driven.
    found = fm.verdict(model, (0, 5e-3), steps=1)
    assert found.driven == "P.x"
    assert found.curves["buckling"][0] == approx(78.75, rel=1e-9)  # printed in T3
    at_stroke = found.curves["buckling"][1]
    assert at_stroke < 78.75
    # There, and only under that many times the load, the drive meets no stiffness: one degree of freedom.
    what = driven(model, "P.x")
    stiffness = [
        float(what.at(guide(load=f, material=silent, prescribed=True), 5e-3).stiffness) for f in (0.0, at_stroke)
    ]
    assert abs(stiffness[1]) < 1e-9 * stiffness[0]
    assert "states no strength" in found.unanswered["yield"]
    assert "states no fatigue limit" in found.summary().rows["not answered"]
    assert [limit.name for limit in found.limits] == ["buckling"]


@pytest.mark.slow
def test_support_stiffness_is_that_of_shooting():
    b = fm.Builder()
    leaf = fm.Rectangle(WIDTH, T, fm.Material(E=210e9, G=80e9, rho=7850))
    b.node("S", (DISTANCE / 2, LENGTH))
    for side, x in (("left", 0.0), ("right", DISTANCE)):
        b.node(f"{side}0", (x, 0))
        b.node(f"{side}1", (x, LENGTH))
        b.add(planar.spectral_beam(5), f"{side}0", f"{side}1", name=side, section=leaf)
        b.fix(f"{side}0")
        b.add(planar.beam, "S", f"{side}1", name=f"stage {side}")
    b.mass("S", 0.2, inertia=2e-4)
    found = fm.verdict(b.build(), {"S.x": (0, 0.05 * LENGTH)}, steps=5, count=1)
    # B1: two extensible elasticas between ground and a rigid body, solved by shooting; order 5 as in notebook 04.
    forces, stiffnesses = [0.240017862, 0.480178956, 1.202960515], [898286.668, 752989.682, 352530.027]
    states = [1, 2, 5]
    np.testing.assert_allclose(found.curves["force"][states] * LENGTH**2 / EI, forces, rtol=1e-6)
    np.testing.assert_allclose(found.curves["stiffness y"][states] * LENGTH**3 / EI, stiffnesses, rtol=1e-4)
    assert "% lost at 5 mm" in found.summary().rows["support stiffness"]
    panels = {ax.get_title(): ax for ax in fm.plot.verdict(found).axes}
    drawn = panels["support stiffness, share of the value at rest"].lines[0].get_ydata()
    # At rest 2 EA/L.
    assert drawn[5] == approx(352530.027 * (T / LENGTH) ** 2 / 24, rel=1e-4)
    plt.close("all")


def arch(stiffness=1e4, mass=1.0):
    """Two bars that snap through."""
    b = fm.Builder()
    for name, place in {"l": (-1, 0), "r": (1, 0), "t": (0, 0.2)}.items():
        b.node(name, place)
    for side in "lr":
        b.add(planar.truss, side, "t", name=f"bar {side}", section=fm.Rigidity(EA=stiffness))
        b.fix(side)
    b.mass("t", mass)
    return b.build()


@pytest.mark.slow
def test_a_drive_holds_what_snaps_through():
    found = fm.verdict(arch(), {"t.y": (-0.4, 0)}, steps=8, limits={"force": 25.0})
    y, first = 0.2 + found.stroke, np.sqrt(1 + 0.2**2)
    now = np.sqrt(1 + y**2)
    # Two bars of stiffness EA/l; round-off of a force that is a difference of lengths.
    pull = 2 * 1e4 / first * (now - first)
    np.testing.assert_allclose(found.curves["force"], pull * y / now, atol=1e-9)
    stiffness = 2 * 1e4 / first * (y / now) ** 2 + pull / now**3
    np.testing.assert_allclose(found.curves["drive stiffness"], stiffness, rtol=1e-9)
    across = 2 * 1e4 / first / now**2 + pull * y**2 / now**3
    np.testing.assert_allclose(found.curves["stiffness x"], across, rtol=1e-9)
    np.testing.assert_array_equal(found.free_stable, stiffness > 0)
    assert np.all(found.held_stable)
    hertz = np.sign(stiffness) * np.sqrt(np.abs(stiffness)) / (2 * np.pi)
    np.testing.assert_allclose(found.curves["frequency 1"], hertz, rtol=1e-9)
    assert "stable only with the drive fixed, from" in found.summary().rows["stability"]
    assert "given by its rigidities" in found.unanswered["stress"]
    limit = found.limits[0]
    assert limit.stroke is not None
    y = 0.2 + limit.stroke
    assert abs(2 * 1e4 / first * (np.sqrt(1 + y**2) - first) * y / np.sqrt(1 + y**2)) == approx(25, rel=1e-5)
    panels = {ax.get_title(): ax for ax in fm.plot.verdict(found).axes}
    drawn = panels["support stiffness, share of the value at rest"].lines[0].get_ydata()
    np.testing.assert_allclose(drawn, across / across[-1], rtol=1e-9)
    plt.close("all")


@pytest.mark.slow
def test_dimensions_of_a_page_say_what_moves_it():
    """The force is that of any mass, and that of any two bars but for their stiffness."""
    dimensions = {"stiffness": 1e4, "mass": 1.0}
    page = fm.verdict(arch, {"t.y": (-0.4, 0)}, dimensions=dimensions, steps=2, limits={"force": 25.0}, count=1)
    found = page.sensitivities
    table = dict(zip(found.answers, found.table, strict=True))
    for name, powers in (("force", (1, 0)), ("drive stiffness", (1, 0)), ("frequency 1", (0.5, -0.5))):
        np.testing.assert_allclose(table[name], powers, rtol=0, atol=1e-9)
    assert page.summary().rows["by dimension"] == "smaller stiffness (+1): percent of force for one percent"
    told = dataclasses.replace(found, dimensions=("mass",), table=found.table[:, 1:])
    alone = dataclasses.replace(page, sensitivities=told).summary().rows
    assert alone["by dimension"] == "none of them moves force"


def test_a_limit_between_strokes_is_seen():
    """At all strokes of this page the force of the arch is zero; in between it rises to what it snaps through at."""
    first = np.sqrt(1 + 0.2**2)

    def force(y):
        return 2 * 1e4 / first * (first - np.sqrt(1 + y**2)) * y / np.sqrt(1 + y**2)

    found: Any = minimize_scalar(lambda y: -force(y), bounds=(0, 0.2), method="bounded", options={"xatol": 1e-12})
    top = found.x
    for share, good in ((0.999, False), (1.001, True)):
        found = fm.verdict(arch(), {"t.y": (-0.4, 0)}, steps=2, limits={"force": share * force(top)}, count=1)
        np.testing.assert_allclose(found.curves["force"], 0, atol=1e-9)
        assert found.good is good
    limited = fm.verdict(arch(), {"t.y": (-0.4, 0)}, steps=2, limits={"force": 0.999 * force(top)}, count=1).limits[0]
    assert limited.stroke is not None
    assert force(0.2 + limited.stroke) == approx(0.999 * force(top), rel=1e-6)
    assert 0.2 + limited.stroke > top


def gimbal(axis=(0, 0, 1), tilt="fixed"):
    """A top that springs hold about three axes, whose rotation is prescribed."""
    b = fm.Builder()
    b.node("top", (0, 0, 0.1))
    b.rotation("ground")
    b.fix("ground")
    b.add(spatial.hinge, "ground", "top.rotation", axis=(0, 0, 1), stiffness=(1.0, 2.0, 3.0), released="all")
    b.fix("top", "position")
    b.body("top", 0.1, inertia=[1e-5, 0, 0, 1e-5, 0, 1e-5])
    b.prescribe("top", "rotation", 1.0, axis=axis, tilt=tilt, increment=True)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "own"), [((0, 0, 1), {"rz"}), ((1, 0, 1), set())])
def test_what_turns_a_node_in_space_is_no_parasitic_motion(axis, own):
    found = fm.verdict(gimbal(axis), 1e-3, steps=1, count=1)
    axes = {"x", "y", "z", "rx", "ry", "rz"} - own
    names = {name for name in found.curves if name.startswith(("parasitic", "stiffness"))}
    assert names == {f"{what} {one}" for what in ("parasitic", "stiffness") for one in axes}
    for one in axes & {"rx", "ry", "rz"}:
        np.testing.assert_allclose(found.curves[f"parasitic {one}"], 0, atol=1e-12)
    if own:
        np.testing.assert_allclose(found.curves["force"], 1.0 * found.stroke, rtol=1e-6)


@pytest.mark.slow
def test_a_tilt_of_a_hinge_has_another_axis_than_its_turn():
    found = fm.verdict(gimbal(tilt="free"), {"turn of top.e2": 1e-3}, steps=1, count=1)
    # Across the axis z, about x; the turn about z is still held.
    np.testing.assert_allclose(found.curves["parasitic rz"], 0, atol=1e-12)
    np.testing.assert_allclose(np.abs(found.curves["parasitic rx"]), np.abs(found.stroke), rtol=1e-6)


def spring():
    b = fm.Builder()
    b.node("l", (0, 0))
    b.node("r", (1, 0))
    b.fix("l")
    b.fix("r", "y")
    b.mass("r", 2.0)
    b.force("r", (3.0, 0))
    b.add(planar.truss, "l", "r", name="spring", section=fm.Rigidity(EA=100.0))
    return b.build()


@pytest.mark.slow
def test_a_deformation_is_driven_and_let_go():
    found = fm.verdict(spring(), {"spring.e1": 0.1}, steps=1, limits={"force": 5.0})
    np.testing.assert_allclose(found.curves["force"], 100 * found.stroke - 3, rtol=1e-12)
    np.testing.assert_allclose(found.curves["frequency 1"], np.sqrt(100 / 2) / (2 * np.pi), rtol=1e-12)
    # Of both sides, -20 mm and 80 mm, the earlier one counts.
    assert found.limits[0].stroke == approx(-0.02, rel=1e-6)
    assert found.unit == "m"
    assert "give `node`" in found.unanswered["support stiffness"]
    # A limit whose curve is unknown somewhere may be reached there.
    used = np.where(found.stroke > 0, np.nan, 0.5)
    unknown = dataclasses.replace(found, limits=(dataclasses.replace(found.limits[0], used=used, stroke=None),))
    assert "force" in unknown.not_judged
    assert "good enough; not judged: " in unknown.summary().title


def test_a_question_without_an_answer_at_a_stroke_is_told():
    model = spring()
    asked = StrokeQuestions(model, driven(model, "spring.e1"), None, 1)

    def own(at, x_at_rest):
        if float(at.force) > 3:
            raise fm.AnalysisError("not_converged", "No answer here.")
        return {"own": 1.0}

    asked.questions = {"own": own}
    assert all(asked.look(stroke) for stroke in (0.0, 0.01, 0.1, 0.12))
    np.testing.assert_array_equal(asked.curves()["own"], [1.0, 1.0, np.nan, np.nan])
    assert asked.unanswered == {"own": "at 100 mm: No answer here"}


@pytest.mark.parametrize(
    ("stroke", "more", "expected", "said"),
    [
        ({"P.y": 1e-3}, {}, ValueError, "no motion of the undeformed mechanism moves it"),
        ({"A.x": 1e-3}, {}, ValueError, "'A.x' is fixed"),
        ({"P.z": 1e-3}, {}, ValueError, "Did you mean 'P.y'"),
        ({"B.x": 1e-3, "C.x": 1e-3}, {}, ValueError, "one coordinate, not 2"),
        ((1e-3, 2e-3), {}, ValueError, "ends about zero"),
        (-1e-3, {}, ValueError, "positive"),
        (DELTA, {"dimensions": {"t": T}}, TypeError, "needs a function"),
        (DELTA, {"node": "Z"}, ValueError, "no node 'Z'"),
    ],
)
def test_what_cannot_be_asked_is_refused(stroke, more, expected, said):
    with pytest.raises(expected, match=said):
        fm.verdict(guide(), stroke, **{"steps": 1, **more})


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"stif": 1.0}, "There are: force, drive stiffness"),
        ({"stress nowhere": 1.0, "force": 1.0}, "Limit of 'stress nowhere': there is no such curve"),
        ({"force": -1.0}, "must be a positive number"),
        ({"force": (None, None)}, r"\(None, None\)"),
        ({"force": (5.0, 1.0)}, "lower 5 is not below upper 1"),
        ({"frequency": 10.0, "frequency 1": 20.0}, "'frequency' and 'frequency 1' are the same"),
    ],
)
def test_a_limit_that_cannot_be_asked_is_refused(limits, said):
    with pytest.raises(ValueError, match=said):
        fm.verdict(arch(), {"t.y": (-0.4, 0)}, steps=2, limits=limits, count=1)


def test_a_function_needs_its_dimensions():
    with pytest.raises(TypeError, match="dimensions="):
        fm.verdict(of_dimensions, DELTA)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (3.2e-3, "m", "3.2 mm"),
        (-150.11e-6, "m", "-150.11 µm"),
        (2.1e8, "Pa", "210 MPa"),
        (1e3, "N", "1 kN"),
        (0.0, "m", "0 m"),
    ],
)
def test_numbers_have_prefixes(value, unit, text):
    assert quantity_text(value, unit) == text


@pytest.mark.slow
def test_no_equilibrium_ends_the_stroke():
    found = fm.verdict(guide(), {"P.x": 1.5 * LENGTH}, steps=2)
    # The sides do not stretch.
    assert not found.good
    assert "no equilibrium was found" in found.unanswered["stroke"]
    assert dataclasses.asdict(found.limits[0])["name"] == "fatigue"


@pytest.mark.slow
def test_the_end_of_what_is_reached_is_found():
    """A rigid bar of length 1 that stands on its foot: its top cannot go further than that to either side."""
    b = fm.Builder()
    for name, place in {"foot": (0, 0), "top": (0, 1), "wall": (0, 2)}.items():
        b.node(name, place)
    b.add(planar.truss, "foot", "top", name="bar", released=())
    b.add(planar.truss, "top", "wall", name="spring", section=fm.Rigidity(EA=1.0))
    b.mass("top", 1.0)
    b.fix("foot")
    b.fix("wall")
    found = fm.verdict(b.build(), {"top.x": 1.6}, steps=4)
    np.testing.assert_array_equal(found.stroke[1:-1], [-0.8, -0.4, 0, 0.4, 0.8])
    np.testing.assert_allclose(found.curves["parasitic y"], np.sqrt(1 - found.stroke**2) - 1, rtol=0, atol=1e-9)
    # To a hundredth of the stroke that is asked: 0.0125 apart, of halves of 0.4.
    np.testing.assert_allclose(found.stroke[[0, -1]], [-0.9875, 0.9875], rtol=1e-12)
    told = "no equilibrium was found at -1 m (not_converged) and 1 m (not_converged)"
    assert found.unanswered["stroke"] == told
    assert found.summary().title == f"Verdict on top.x, -987.5 mm to 987.5 mm: no more is known, {told}"
    assert not found.good


@pytest.mark.slow
def test_the_page_is_drawn(page):
    figure = fm.plot.verdict(page)
    panels = {ax.get_title(): ax for ax in figure.axes}
    # Nothing is drawn of what is rigid or stands still.
    assert list(panels) == [
        "force of the drive",
        "share of each limit",
        "natural frequencies, let go",
        "parasitic displacement",
    ]
    force, slope = panels["force of the drive"].lines
    np.testing.assert_allclose(force.get_xydata(), np.stack([[-100, 0, 100], page.curves["force"]], axis=1))
    np.testing.assert_allclose(slope.get_ydata(), force.get_ydata(), rtol=1e-5, atol=1e-12)
    shares = {line.get_label(): line.get_ydata() for line in panels["share of each limit"].lines}
    np.testing.assert_allclose(shares["fatigue"], page.curves["fatigue"])
    assert panels["force of the drive"].get_xlabel() == "stroke P.x [µm]"
    plt.close(figure)
    with pytest.raises(TypeError, match="verdict"):
        fm.plot.verdict(3)
    assert "by dimension" in page._repr_html_()


@pytest.mark.slow
def test_what_has_no_answer_is_said():
    b = fm.Builder()
    b.node("l", (0, 0))
    b.node("r", (1, 0))
    b.add(planar.beam, "l", "r", name="leaf", section=fm.Rectangle(0.01, 1e-3, STEEL))
    b.fix("l")
    b.force("r", (0, -1.0), follower=True)
    b.force("r", (0, 1.0), increment=True)
    found = fm.verdict(b.build(), {"r.y": 1e-3}, steps=1, node="l")
    assert set(found.unanswered) == {"buckling", "frequencies", "incremental loads"}
    assert "poles" in found.unanswered["frequencies"]
    assert "follower loads" in found.unanswered["buckling"]
    assert "left out" in found.summary().rows["not answered"]
    # Of a node that is fixed nothing moves.
    assert found.summary().rows["parasitic motion"] == "none"
    assert "frequency 1" not in found.curves


@pytest.mark.slow
@pytest.mark.parametrize("prescribed", [False, True])
def test_a_stroke_about_a_global_axis(prescribed):
    """The drive turns a shaft, also where nothing in the model holds that angle or measures it."""

    def build(torsion=8.0):
        b = fm.Builder()
        b.node("A", (0, 0, 0))
        b.node("B", (1, 0, 0))
        b.add(spatial.beam, "A", "B", name="shaft", section=fm.Rigidity(EA=1e6, EIy=4.0, EIz=5.0, GIt=torsion))
        b.fix("A")
        b.body("B", 1.0, inertia=(2.0, 0, 0, 3.0, 0, 4.0))
        if prescribed:
            b.prescribe("B", "rx")
        return b.build()

    model, dimensions = (build(), None) if prescribed else (build, {"torsion": 8.0})
    found = fm.verdict(model, {"B.rx": 0.2}, dimensions=dimensions, steps=1, count=1)
    # Half of GI_t sin^2 of the angle is the energy of a cubic beam that is twisted alone. Round-off.
    np.testing.assert_allclose(found.curves["force"], 4.0 * np.sin(2 * found.stroke), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.curves["drive stiffness"], 8.0 * np.cos(2 * found.stroke), rtol=1e-9)
    assert found.driven == "B.rx"
    assert not {"parasitic rx", "stiffness rx"} & set(found.curves)
    if dimensions:
        rows = found.sensitivities
        assert rows is not None
        # The force is proportional to the torsional stiffness.
        np.testing.assert_allclose(rows.table[rows.answers.index("force")], 1.0, rtol=1e-6)


@pytest.mark.slow
def test_a_verdict_warns_of_stress_without_restrained_warping():
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    material = fm.Material(E=210e9, nu=0.3, rho=7850, strength=1e9)
    strip = fm.Rectangle(0.018, 0.5e-3, material, shear=True, warping_length=0.1)
    b.add(spatial.beam, "foot", "tip", name="strip", section=strip, y=(0, 1, 0))
    b.fix("foot")
    b.body("tip", 0.1, inertia=(1e-4, 0, 0, 1e-4, 0, 1e-4))
    with pytest.warns(fm.BeamTheoryWarning, match="torque acts on element 'strip'. Its stress leaves out"):
        fm.verdict(b.build(), {"tip.rx": 0.1}, steps=1, count=1)


@pytest.mark.slow
def test_progress_begins_before_the_first_state_and_ends_with_the_last(monkeypatch, capsys):
    seen = []
    fm.verdict(guide(), 2e-3, steps=2, progress=lambda done, total: seen.append((done, total)))
    assert seen[0] == (0, 5)
    assert seen[-1] == (5, 5)
    assert seen == sorted(seen)
    capsys.readouterr()
    # By default a bar where there is a terminal.
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    fm.verdict(guide(), 2e-3, steps=2)
    assert "strokes" in capsys.readouterr().err
