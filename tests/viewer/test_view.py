"""What the page is given, by its numbers: coordinates, displacements, sections, colours, marks; and what is refused."""

import base64
import hashlib
import html
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from cases.commands import command
from cases.mechanisms import LENGTH, THICKNESS, WIDTH, leaf, planar_guide, spatial_guide
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.answers.answers import Answer
from flexmb.mechanisms import mechanism_path
from flexmb.plot.geometry import PLACES, lines
from flexmb.plot.modes import factor_of
from flexmb.viewer.view import page

SOURCE = Path(fm.__file__).parent / "viewer" / "src"


@pytest.fixture(scope="module")
def guide():
    return planar_guide(force=(0, -1.0)).build()


@pytest.fixture(scope="module")
def modes(guide):
    return fm.modes(guide)


def bent(element, force, *, dimension=2, **properties):
    """A cantilever, and its linearisation under a force at its tip."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0)[:dimension])
    b.node("tip", (LENGTH, 0, 0)[:dimension])
    b.add(element, "foot", "tip", name="leaf", section=leaf(), **properties)
    b.fix("foot")
    b.force("tip", force)
    model = b.build()
    return model, fm.linearize(model)


@pytest.fixture(scope="module")
def swinging():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", name="rod", section=fm.Rigidity(EA=100.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 4.0)
    b.start("cart", "x", 0.01)
    return fm.simulate(b.build(), np.linspace(0, 1, 11), rtol=1e-8)


@pytest.fixture(scope="module")
def pressed():
    """A shallow truss under a load below its limit."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("top", (1, 0.2))
    b.add(planar.truss, "foot", "top", section=leaf())
    b.fix("foot")
    b.fix("top", "x")
    b.mass("top", 1.0)
    b.force("top", (0, -1000.0))
    return fm.path(b.build())


def data_of(view):
    """What the page reads."""
    return json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', view.html(), re.DOTALL).group(1))


def array(text, *shape):
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(*shape, 3)


# Numbers.


@pytest.mark.slow
def test_page_has_the_points_and_names_that_were_computed(guide, modes):
    view = fm.view(modes)
    data = data_of(view)
    at = {line.element: line.points for line in lines(guide, np.asarray(modes.lin.x))}
    base = array(data["base"], -1)
    for name, kind, start, count, _ in data["parts"]:
        own = base[start : start + count, :2]
        np.testing.assert_allclose(own[[0, -1]], at[name][[0, -1]], atol=1e-8)
        # Between its points a line is where it was computed but for a small part of the extent.
        steps = np.linspace(0, 1, count)
        drawn = np.stack([np.interp(PLACES, steps, own[:, k]) for k in (0, 1)], axis=1)
        assert np.max(np.linalg.norm(drawn - at[name], axis=1)) < 5e-4 * LENGTH
        assert kind == ("rigid" if name == "bar" else "beam")
        # A bar has two points, a leaf spring in sway some more.
        assert count == 2 if name == "bar" else 4 <= count <= 33
    assert data["nodes"]["names"] == ["left0", "left1", "right0", "right1"]
    assert data["choices"] == [f"mode 1: {float(modes.frequencies[0]):.5g} Hz"]
    assert data["supports"] == {"clamped": [0, 2], "supported": [], "prescribed": []}
    assert data["masses"] == [1, 3]
    assert {mark["text"] for mark in data["marks"]} == {"left1.x", "1 N"}
    assert (data["dimension"], data["kind"]) == (2, "modes")


def test_modes_move_as_their_shape(guide, modes):
    view = fm.view(modes)
    x, shape = np.asarray(modes.lin.x), np.asarray(modes.shapes[:, 0])
    scaled = factor_of(guide, x, shape, 1.0) * shape
    moved = array(data_of(view)["nodes"]["states"], 1, 4)[0]
    for i, name in enumerate(view.nodes.names):
        np.testing.assert_allclose(moved[i, :2], scaled[guide.labels.known(name)], rtol=1e-6, atol=1e-9)
    # An amplitude of 1 moves by the extent, some point of the lines by just that.
    displaced = np.linalg.norm(view.lines.states[0], axis=1)
    assert np.max(displaced) == approx(LENGTH, rel=1e-3)
    # The displacement of a cubic: it is linear in its ends, so that a finite step gives it too.
    step = 1e-3 * scaled
    ends = [np.concatenate([line.points for line in lines(guide, x + s * step)]) for s in (-1, 1)]
    places = np.concatenate(
        [len(PLACES) * i + np.rint(96 * view.lines.places[p.start : p.start + p.count]).astype(int)
         for i, p in enumerate(view.lines.parts)]
    )  # fmt: skip
    np.testing.assert_allclose(view.lines.states[0][:, :2], ((ends[1] - ends[0]) / 2e-3)[places], atol=1e-4 * LENGTH)


@pytest.mark.slow
def test_a_single_state_moves_from_the_undeformed_one():
    model, lin = bent(planar.spectral_beam(4), (0, 0.5))
    view = fm.view(lin)
    assert view.kind == "state"
    drawn = {line.element: line for line in lines(model, np.asarray(lin.x))}["leaf"]
    chosen = np.rint(96 * view.lines.places).astype(int)
    np.testing.assert_allclose(view.lines.states[0][:, :2], drawn.points[chosen], atol=1e-12)
    np.testing.assert_allclose(view.lines.base[[0, -1]], [[0, 0, 0], [LENGTH, 0, 0]], atol=1e-12)
    same = fm.view(model, at=fm.equilibrium(model))
    np.testing.assert_allclose(same.lines.states, view.lines.states, atol=1e-9)
    assert len(fm.view(model).lines.states) == 0


@pytest.mark.slow
def test_motion_has_all_its_states_and_times(swinging):
    view = fm.view(swinging)
    assert view.kind == "motion"
    np.testing.assert_allclose(view.along, np.linspace(0, 1, 11))
    np.testing.assert_allclose(view.nodes.states[:, 1, 0], np.asarray(swinging.at("cart"))[:, 0])
    np.testing.assert_allclose(view.lines.states[:, -1], view.nodes.states[:, 1], atol=1e-12)
    data = data_of(view)
    assert array(data["states"], 11, 2).shape == (11, 2, 3)
    assert view.lines.parts[0].kind == "bar"


@pytest.mark.slow
def test_a_long_motion_is_thinned_evenly(swinging, monkeypatch):
    monkeypatch.setattr("flexmb.viewer.scene.MOST_STATES", 6)
    np.testing.assert_allclose(fm.view(swinging).along, np.linspace(0, 1, 6))


# Sections.


def test_sections_are_those_of_the_model():
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.1 * i, 0, 0))
    steel = fm.Material(E=210e9, G=80e9)
    sections = [leaf(), fm.Circle(0.002, steel), fm.Rigidity(EA=1.0, EIy=1.0, EIz=1.0, GIt=1.0)]
    for i, section in enumerate(sections):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", name=f"beam {i}", section=section)
    b.fix("n0")
    parts = fm.view(b.build()).lines.parts
    assert [part.shape for part in parts] == [(WIDTH, THICKNESS, False), (0.002, 0.002, True), None]


def bent_by_hand(axis, angle, *, y, section):
    """A spectral beam along x, turned at its tip about an axis: an arc, or twisted. No equilibrium is solved."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    b.add(spatial.spectral_beam(5), "foot", "tip", name="leaf", section=section, y=y)
    model = b.build(check=False)
    x = np.asarray(model.parameters.reference).copy()
    x[model.labels.known("tip.rotation")] = [np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)[axis])]
    # The first coefficient of a strain is its mean times the length; fields: elongation, twist, about y, about z.
    own = [i for i, entry in enumerate(model.labels.x) if entry.kind == "internal"]
    local = np.stack([[1.0, 0, 0], y, np.cross([1.0, 0, 0], y)])[:, axis]
    x[own[5:20:5]] = angle * local
    if axis == 2:
        x[model.labels.known("tip")] = LENGTH / angle * np.array([np.sin(angle), 1 - np.cos(angle), 0])
    return fm.view(model, at=SimpleNamespace(x=x))


@pytest.mark.slow
def test_width_of_a_ribbon_stays_across_an_arc():
    # Local y along the axis of bending: it stays there.
    view = bent_by_hand(2, np.pi / 2, y=(0, 0, 1), section=leaf())
    np.testing.assert_allclose(view.lines.across_states[0], [[0, 0, 1]] * len(view.lines.base), atol=1e-9)
    # Local y in the plane of the arc, a turn and a half: it stays normal to the line.
    view = bent_by_hand(2, 3 * np.pi, y=(0, 1, 0), section=leaf())
    angle = 3 * np.pi * view.lines.places
    expected = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(view.lines.across_states[0], expected, atol=5e-3)


@pytest.mark.slow
def test_a_twisted_ribbon_shares_its_twist_evenly():
    view = bent_by_hand(0, 0.5, y=(0, 0, 1), section=leaf())
    across = view.lines.across_states[0]
    # From z towards -y, in proportion to the place.
    np.testing.assert_allclose(np.arctan2(-across[:, 1], across[:, 2]), 0.5 * view.lines.places, atol=1e-9)
    # It is a straight line, yet its edges ask for points between its ends.
    assert len(across) > 2


# Colours.


@pytest.mark.slow
def test_colours_of_a_cantilever():
    _, lin = bent(planar.beam, (0, 0.01))
    view = fm.view(lin, fm.stress(lin.model, at=lin))
    clamp = 6 * 0.01 * LENGTH / (WIDTH * THICKNESS**2) / 1e6
    assert view.colours.label == "von Mises stress [MPa]"
    assert (view.colours.low, view.colours.high) == approx((0, clamp), rel=1e-4)
    np.testing.assert_allclose(view.colours.values[0], clamp * (1 - view.lines.places), atol=3e-3)
    told = data_of(view)["colours"]
    assert told["high"] == view.colours.high
    # The lower end of viridis, as matplotlib has it.
    np.testing.assert_allclose(told["table"][0], [0.267, 0.0049, 0.3294], atol=1e-3)
    signed = fm.view(lin, fm.linear.section_resultants(lin.model, at=lin), "shear force z").colours
    assert signed.low == -signed.high
    np.testing.assert_allclose(np.abs(signed.values), 0.01, rtol=1e-3)


@pytest.mark.slow
def test_rigid_elements_have_no_colour(guide):
    view = fm.view(guide, fm.linear.section_resultants(guide))
    for part in view.lines.parts:
        values = view.colours.values[0, part.start : part.start + part.count]
        assert np.all(np.isnan(values)) == (part.name == "bar")


@pytest.mark.slow
def test_colours_along_a_path(pressed):
    stresses = [fm.stress(pressed.model, at=pressed.linearization(i)) for i in range(len(pressed.load_factor))]
    view = fm.view(pressed, stresses, "sigma_x")
    together = fm.view(pressed, fm.stress(pressed.model, at=pressed), "sigma_x")
    np.testing.assert_allclose(together.colours.values, view.colours.values, rtol=1e-12)
    # A truss: the same stress all along, of every step its own.
    force = np.array([float(s.resultants.values[0, 0, 0]) for s in stresses])
    expected = np.repeat(force[:, None] / (WIDTH * THICKNESS) / 1e6, len(view.lines.base), axis=1)
    np.testing.assert_allclose(view.colours.values, expected, rtol=1e-6)
    assert -view.colours.low == view.colours.high == approx(np.max(np.abs(expected)))
    np.testing.assert_allclose(view.along, pressed.load_factor)


def test_self_stress_has_the_colours_of_its_parts():
    found = fm.mobility(spatial_guide().build(check=False))
    view = fm.view(found)
    largest = {}
    for share in found.stresses():
        largest[share.of] = max(largest.get(share.of, 0), abs(share.share))
    for part in view.lines.parts:
        values = view.colours.values[0, part.start : part.start + part.count]
        np.testing.assert_allclose(values, largest.get(part.name, np.nan))
    released = found.release[0]
    assert released is not None
    element, number = released
    assert view.choices == (f"self-stress 1 of 1: release e{number} of '{element}' to remove it",)


# The page.


def test_page_is_one_file_that_fetches_nothing(tmp_path, modes):
    target = tmp_path / "modes.html"
    fm.view(modes).save(target)
    text = target.read_text()
    assert 300_000 < len(text) < 1_000_000
    # One address is left: the name of a namespace, which nothing fetches.
    assert set(re.findall(r"(?:https?|wss?)://[^\s\"'`<]*", text)) == {"http://www.w3.org/1999/xhtml"}
    assert not re.search(r"<(?:link|script|img)[^>]+(?:href|src)=[\"'](?!data:)", text)
    assert "default-src 'none'" in text
    assert "The MIT License" in text
    assert "three.js authors" in text


def test_bundle_is_built_from_the_source():
    text = (Path(fm.__file__).parent / "viewer" / "viewer.js").read_text()
    total = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(SOURCE.glob("*.js")))).hexdigest()
    assert text.startswith(f"/* source {total}\n"), "run npm ci && npm run build in flexmb/viewer/src"


def test_names_cannot_end_the_script():
    b = fm.Builder()
    name = "</script><b>&{{script}}<!--"
    b.node(name, (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.beam, name, "tip", section=leaf())
    b.fix(name)
    view = fm.view(b.build())
    assert data_of(view)["nodes"]["names"][0] == name
    assert view.html().count("</script>") == 2


def test_notebook_gets_a_frame_with_the_whole_page(modes):
    view = fm.view(modes)
    frame = view._repr_html_()
    assert html.unescape(re.search(r'srcdoc="(.*?)"', frame, re.DOTALL).group(1)) == view.html()
    assert 'title="Modes: 3 elements, 4 nodes"' in frame
    # Notebooks keep the text beside it: a short one.
    assert repr(view) == "View(Modes: 3 elements, 4 nodes)"


# Refusals.


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda m, s: fm.view(3), TypeError, "not a int"),
        (lambda m, s: fm.view(m, at=3), TypeError, "state of the model"),
        (lambda m, s: fm.view(m, which=[0]), ValueError, "needs Modes"),
        (lambda m, s: fm.view(fm.modes(m), which=[4]), ValueError, "no mode 4"),
        (lambda m, s: fm.view(fm.modes(m), which=[]), ValueError, "no mode to show"),
        (lambda m, s: fm.view(fm.modes(m), at=m), ValueError, "has its own state"),
        (lambda m, s: fm.view(m, 3), TypeError, "fm.stress"),
        (lambda m, s: fm.view(m, [s, s]), ValueError, "but there are 2"),
        (lambda m, s: fm.view(m, []), ValueError, "is an empty list"),
        (lambda m, s: fm.view(m, s, "colour"), ValueError, "must be one of"),
        (lambda m, s: fm.view(m, None, "tau"), ValueError, "give both"),
        (lambda m, s: fm.view(bent(planar.beam, (0, 1e-3))[0], s), ValueError, "belongs to another model"),
        (lambda m, s: fm.view(fm.mobility(m), s), ValueError, "its own colours"),
        (lambda m, s: fm.view(m).save("picture.png"), ValueError, "writes .html"),
        (lambda m, s: fm.view(m).save("nowhere/picture.html"), OSError, "nowhere"),
    ],
)
def test_bad_calls(guide, call, kind, words):
    with pytest.raises(kind, match=words):
        call(guide, fm.stress(guide))


@pytest.mark.slow
def test_a_path_takes_one_stress_for_each_state(pressed):
    with pytest.raises(ValueError, match=f"each of the {len(pressed.load_factor)} states, but there are 1"):
        fm.view(pressed, fm.stress(pressed.model, at=pressed.linearization()))


# The command line.


@pytest.mark.slow("pf2db-8-buckling mode 1: ", 'pf1dtrx-9-"kind":"state"')
@pytest.mark.parametrize(
    ("name", "mode", "words"),
    [
        ("pf3dover", 0, "self-stress 1 of 1"),
        ("pf2d", 0, '"kind":"state"'),
        ("pf1dtrx", 7, "mode 1: 10.658 Hz"),
        ("pf2db", 8, "buckling mode 1: "),
        ("pf1dtrx", 9, '"kind":"state"'),
    ],
)
def test_plot_on_the_command_line(tmp_path, name, mode, words):
    target = tmp_path / "page.html"
    result = command("run", mechanism_path(name), "--mode", mode, "--plot", target)
    assert result.exit_code == 0, result.output
    assert words in target.read_text()


@pytest.mark.slow
def test_path_and_motion_of_an_answer(pressed, swinging):
    for found, kind in ((pressed, "path"), (swinging, "motion")):
        assert f'"kind":"{kind}"' in page(Answer({}, 0, found.model, found=found)).decode()
