"""The page in a browser without a network: what moves, what answers, and that nothing is fetched."""

import re
import time

import numpy as np
import pytest
from cases.mechanisms import LENGTH, leaf, planar_guide, spatial_guide
from cases.tolerances import approx
from cases.workbench import browsing, faults, needs_browser, requests

import flexmb as fm
from flexmb import planar, spatial

pytestmark = [needs_browser, pytest.mark.timeout(90)]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with browsing(tmp_path_factory.mktemp("browser"), reached="", size=(1000, 700)) as driver:
        yield driver


@pytest.fixture(scope="module")
def modes():
    return fm.modes(planar_guide(force=(0.2, -1.0), elongation=True).build())


@pytest.fixture(scope="module")
def view(modes):
    return fm.view(modes, fm.linear.section_resultants(modes.lin.model, at=modes.lin))


@pytest.fixture
def page(browser, view, tmp_path):
    """The browser with the page of a view in it, newly loaded."""
    return opened(browser, view, tmp_path)


def opened(browser, view, folder):
    view.save(folder / "page.html")
    for log in ("browser", "performance"):
        browser.get_log(log)
    browser.get((folder / "page.html").as_uri())
    return browser


def ask(page, expression):
    return page.execute_script(f"const v = window.flexmb; return {expression};")


def points(page):
    return np.reshape(ask(page, "Array.from(v.motion.points)"), (-1, 3))


def until(page, expression, seconds=20):
    """Wait for something to become true."""
    end = time.monotonic() + seconds
    while not ask(page, expression):
        assert time.monotonic() < end, f"{expression} did not become true"
        time.sleep(0.05)


def move(page, name, value):
    """Set a slider or a list as a reader does."""
    page.execute_script(
        "const own = document.getElementById(arguments[0]); own.value = arguments[1];"
        "own.dispatchEvent(new Event('input')); own.dispatchEvent(new Event('change'));",
        name,
        str(value),
    )


def press(page, *keys):
    for key in keys:
        page.find_element("id", "scene").send_keys(key)


def swung(view, mode, amplitude, phase):
    """Where the points are, from the numbers that were computed."""
    return view.lines.base + amplitude * np.sin(2 * np.pi * phase) * view.lines.states[mode]


@pytest.mark.slow
def test_the_page_loads_without_a_network_and_without_a_fault(page):
    until(page, "Boolean(v && v.project)")
    press(page, "t", "n", "m")
    page.find_element("id", "save").click()
    until(page, "document.getElementById('live').textContent === 'Picture saved.'")
    assert not faults(page)
    asked = {address.split(":")[0] for address in requests(page)}
    # The page itself, and the picture that was saved from it.
    assert "file" in asked
    assert asked <= {"file", "data", "blob"}


def hinged():
    """A leaf spring in space, a rigid arm on a hinge, a wire to its end and a mass."""
    b = fm.Builder()
    for name, place in {"wall": (0, 0, 0), "tip": (0.1, 0, 0), "far": (0.2, 0, 0.05), "anchor": (0.2, 0.1, 0)}.items():
        b.node(name, place)
    b.rotation("turning")
    b.add(spatial.beam, "wall", "tip", name="leaf", section=leaf(), y=(0, 1, 0))
    b.add(spatial.hinge, "tip", "turning", axis=(0, 1, 0), stiffness=1.0)
    b.add(spatial.rigid_beam, "tip", "turning", "far", name="arm")
    b.add(spatial.truss, "far", "anchor", name="wire", section=fm.Rigidity(EA=1e3))
    b.fix("wall")
    b.fix("anchor")
    b.mass("far", 0.1)
    return b.build()


PAGES = (
    "model",
    "equilibrium",
    "linearization",
    "linearization with stress",
    "modes",
    "modes with resultants",
    "modes in space",
    "buckling",
    "path",
    "path with stress",
    "motion",
    "motion with stress",
    "mobility",
    "mobility without fault",
)


@pytest.fixture(scope="module")
def pages(modes):
    """One of each kind that README names; the bar of the guide and the mast on the cart have no stress."""
    model, lin = modes.lin.model, modes.lin
    moved = cart().build()
    path, motion = fm.path(moved, step=0.5), swing(moved)
    along = fm.motion.linearize_motion(motion)
    free = hinged()
    return {
        "model": fm.view(model),
        "equilibrium": fm.view(model, at=fm.equilibrium(model)),
        "linearization": fm.view(lin),
        "linearization with stress": fm.view(lin, fm.stress(model, at=lin)),
        "modes": fm.view(modes),
        "modes with resultants": fm.view(modes, fm.linear.section_resultants(model, at=lin)),
        "modes in space": fm.view(fm.modes(free)),
        "buckling": fm.view(fm.buckling(model)),
        "path": fm.view(path),
        "path with stress": fm.view(
            path, [fm.linear.section_resultants(moved, at=path.linearization(i)) for i in range(len(path.load_factor))]
        ),
        "motion": fm.view(motion),
        "motion with stress": fm.view(
            motion, [fm.linear.section_resultants(moved, at=along.at_time(i)) for i in range(4)]
        ),
        "mobility": fm.view(fm.mobility(spatial_guide().build(check=False))),
        "mobility without fault": fm.view(fm.mobility(model)),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_every_kind_of_page_is_drawn(browser, pages, name, tmp_path):
    page = opened(browser, pages[name], tmp_path)
    until(page, "Boolean(v && v.project)")
    if ask(page, "v.plays"):
        page.find_element("id", "play").click()
        until(page, "v.framesPerSecond > 0")
        page.execute_script("window.flexmb.seek(0.3)")
    # The elements in the scene without what is drawn over them, and all of it in the picture that is saved.
    colours, saved = page.execute_async_script(
        """
        const [done] = arguments, v = window.flexmb, picture = new Image();
        const distinct = (image) => {
          const canvas = new OffscreenCanvas(image.width, image.height), pen = canvas.getContext("2d");
          pen.drawImage(image, 0, 0);
          return new Set(new Uint32Array(pen.getImageData(0, 0, image.width, image.height).data.buffer)).size;
        };
        v.draw();
        const scene = distinct(document.getElementById("scene"));
        picture.onload = () => done([scene, distinct(picture)]);
        picture.src = v.save();
        """
    )
    assert colours > 1
    assert saved >= colours
    assert not faults(page)
    assert ask(page, "document.getElementById('fault').hidden")
    coloured = pages[name].colours is not None
    assert ask(page, "document.getElementById('legend').hidden") == (not coloured)


@pytest.mark.slow
def test_a_mode_swings_as_computed(page, view):
    for phase in (0.0, 0.25, 0.6):
        page.execute_script("window.flexmb.seek(arguments[0])", phase)
        np.testing.assert_allclose(points(page), swung(view, 0, view.amplitude, phase), atol=1e-6 * LENGTH)
    page.find_element("id", "play").click()
    until(page, "v.framesPerSecond > 0")
    # Between two frames, at the phase that the page tells.
    frames = []
    for _ in range(2):
        phase, place = ask(page, "[v.state.position, Array.from(v.motion.points)]")
        np.testing.assert_allclose(
            np.reshape(place, (-1, 3)), swung(view, 0, view.amplitude, phase), atol=1e-6 * LENGTH
        )
        frames.append(place)
        until(page, f"v.state.position !== {phase}")
    assert frames[0] != frames[1]
    # The mesh goes along with its lines: every vertex is near a point of them.
    vertices, place = (
        np.reshape(own, (-1, 3)) for own in ask(page, "[Array.from(v.sweep.positions), Array.from(v.motion.points)]")
    )
    distance = np.min(np.linalg.norm(vertices[:, None] - place, axis=2), axis=1)
    assert np.max(distance) < 0.01 * LENGTH
    page.find_element("id", "play").click()
    assert not ask(page, "v.playing")


@pytest.mark.slow
def test_mode_amplitude_and_position_are_chosen(page, view):
    page.execute_script("window.flexmb.seek(0.25)")
    move(page, "choice", 1)
    np.testing.assert_allclose(points(page), swung(view, 1, view.amplitude, 0.25), atol=1e-6 * LENGTH)
    assert ask(page, "document.getElementById('live').textContent") == view.choices[1]
    move(page, "amplitude", 0.3)
    np.testing.assert_allclose(points(page), swung(view, 1, 0.3, 0.25), atol=1e-6 * LENGTH)
    move(page, "position", 0.4)
    np.testing.assert_allclose(points(page), swung(view, 1, 0.3, 0.4), atol=1e-6 * LENGTH)
    assert ask(page, "document.getElementById('position').getAttribute('aria-valuetext')") == "phase 144°"
    press(page, "M")
    assert ask(page, "v.state.choice") == 0


def test_parts_are_hidden_by_kind_and_by_name(page):
    whole = ask(page, "v.sweep.geometry.index.count")
    page.find_element("id", "show-rigid").click()
    without = ask(page, "v.sweep.geometry.index.count")
    assert ask(page, "v.visible") == [True, True, False]
    assert without == whole - 6
    page.find_element("id", "elements-title").click()
    until(page, "document.getElementById('elements-list').childElementCount > 0")
    ticks = page.find_elements("css selector", "#elements-list label")
    assert [tick.text.strip() for tick in ticks] == ["left 1 (beam)", "right 1 (beam)", "bar (rigid)"]
    ticks[0].click()
    assert ask(page, "v.visible") == [False, True, False]
    move(page, "filter", "BAR")
    assert [tick.is_displayed() for tick in ticks] == [False, False, True]


def test_pointing_tells_names_and_values(page, view, modes):
    until(page, "Boolean(v.project)")
    page.execute_script("window.flexmb.seek(0)")
    place = "v.project(v.motion.nodes, 1)"
    over = "document.getElementById('scene').dispatchEvent(new PointerEvent('pointermove', {clientX: x, clientY: y}))"
    page.execute_script(f"const v = window.flexmb; const [x, y] = {place}; {over}")
    told = ask(page, "document.getElementById('tip').textContent")
    at = np.asarray(modes.lin.x)[modes.lin.labels.known("left1")]
    assert told == f"node left1: x = {at[0]:.5g}, y = {at[1]:.5g} m"
    # By keyboard the first element, with its values.
    press(page, "e")
    told = ask(page, "document.getElementById('live').textContent")
    part = view.lines.parts[0]
    values = view.colours.values[0, part.start : part.start + part.count]
    found = re.fullmatch(r"beam left 1, 18 × 0.5 mm, bending moment y (\S+) N m here, (\S+) N m at most", told)
    assert found, told
    expected = values[part.count // 2], values[np.argmax(np.abs(values))]
    assert [float(number) for number in found.groups()] == approx(expected, rel=1e-4)


@pytest.mark.slow
def test_colours_are_those_of_the_scale(page, view):
    until(page, "Boolean(v.project)")
    assert ask(page, "document.getElementById('legend-label').textContent") == view.colours.label
    assert float(ask(page, "document.getElementById('legend-high').textContent")) == approx(view.colours.high, rel=1e-3)
    # coolwarm is blue at its lower end and red at its upper end; the moment is largest at both ends of a leaf spring.
    part = view.lines.parts[0]
    values = view.colours.values[0, part.start : part.start + part.count]
    first, last = (ask(page, f"Array.from(v.sweep.colours.slice({6 * i}, {6 * i + 3}))") for i in (0, part.count - 1))
    assert np.sign(values[0]) == -np.sign(values[-1])
    assert np.sign(first[0] - first[2]) == np.sign(values[0])
    assert np.sign(last[0] - last[2]) == np.sign(values[-1])
    page.find_element("id", "show-colours").click()
    assert ask(page, "document.getElementById('legend').hidden")
    assert ask(page, "Array.from(v.sweep.colours.slice(0, 3))") == [0, 114, 178]


@pytest.mark.slow
def test_dark_and_light(page):
    background = "getComputedStyle(document.body).backgroundColor"
    assert ask(page, background) == "rgb(255, 255, 255)"
    page.find_element("id", "theme").click()
    assert ask(page, background) == "rgb(20, 24, 28)"
    assert ask(page, "document.getElementById('theme').getAttribute('aria-pressed')") == "true"


@pytest.mark.slow
def test_the_saved_picture_shows_the_mechanism(page):
    until(page, "Boolean(v.project)")
    page.execute_script("window.flexmb.seek(0)")
    corner, middle = page.execute_async_script(
        """
        const [done] = arguments, picture = new Image(), v = window.flexmb;
        picture.onload = () => {
          const canvas = new OffscreenCanvas(picture.width, picture.height), pen = canvas.getContext("2d");
          pen.drawImage(picture, 0, 0);
          const [left] = v.project(v.motion.nodes, 1), [right, y] = v.project(v.motion.nodes, 3);
          const colour = (u, w) => Array.from(pen.getImageData(u, w, 1, 1).data);
          done([colour(picture.width - 2, 2), colour((0.3 * left + 0.7 * right) * v.stage.ratio, y * v.stage.ratio)]);
        };
        picture.src = v.save();
        """
    )
    assert corner == [255, 255, 255, 255]
    # The rigid bar, in its own grey.
    assert middle == approx([107, 111, 115, 255], abs=3)


@pytest.mark.slow
def test_every_control_has_a_name_for_a_screen_reader(page):
    nodes = page.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"button", "slider", "checkbox", "combobox", "searchbox", "application"}
    controls = [node for node in nodes if node.get("role", {}).get("value") in roles and not node["ignored"]]
    names = [node["name"]["value"] for node in controls]
    assert len(controls) >= 12
    assert all(names), [node["role"]["value"] for node in controls if not node["name"]["value"]]
    assert any(name.startswith("Modes: 3 elements, 4 nodes") for name in names)


def cart():
    """A mass on a wire, and a mast on it."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=100.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 4.0)
    b.force("cart", (1.0, 0))
    b.start("cart", "x", 0.1)
    b.node("mast", (1, 0.5))
    b.rotation("top")
    b.add(planar.rigid_beam, "cart", "top", "mast", name="pole")
    b.fix("top")
    return b


def swing(model):
    return fm.simulate(model, np.array([0, 0.1, 0.3, 1.0]), rtol=1e-6)


@pytest.mark.slow
def test_a_motion_plays_its_states(browser, tmp_path):
    model = cart().build()
    motion = swing(model)
    forces = [fm.linear.section_resultants(model, load_factor=factor) for factor in (0.0, 1.0, 3.0, -4.0)]
    page = opened(browser, fm.view(motion, forces, "normal force"), tmp_path)
    page.execute_script("window.flexmb.seek(0.2)")
    # Half way between 0.1 and 0.3 s, however the times are spaced.
    x = np.asarray(motion.at("cart"))[:, 0]
    assert points(page)[-1, 0] == approx((x[1] + x[2]) / 2, abs=1e-6)
    assert ask(page, "document.getElementById('position-text').textContent") == "0.2000 s"
    # So are the colours: 2 N on a scale that ends at 4 N, then its lower end.
    assert ask(page, "v.motion.values[0]") == approx(2.0, rel=1e-6)
    red, _, blue = ask(page, "Array.from(v.sweep.colours.slice(0, 3))")
    assert red > blue + 50
    move(page, "position", 1)
    assert ask(page, "Array.from(v.sweep.colours.slice(0, 3))") == approx([59, 76, 192], abs=1)
    move(page, "position", 0.2)
    move(page, "amplitude", 3)
    assert points(page)[-1, 0] == approx(1 + 3 * ((x[1] + x[2]) / 2 - 1), abs=1e-5)


@pytest.mark.slow
def test_a_notebook_shows_it_in_a_frame(browser, view, tmp_path):
    (tmp_path / "notebook.html").write_text(f"<!doctype html><meta charset='utf-8'>{view._repr_html_()}")
    browser.get_log("browser")
    browser.get((tmp_path / "notebook.html").as_uri())
    browser.switch_to.frame(0)
    try:
        until(browser, "Boolean(v && v.project)")
        browser.execute_script("window.flexmb.seek(0.25)")
        np.testing.assert_allclose(points(browser), swung(view, 0, view.amplitude, 0.25), atol=1e-6 * LENGTH)
        assert not faults(browser)
    finally:
        browser.switch_to.default_content()


@pytest.mark.slow
def test_two_thousand_beams_are_played(browser, tmp_path):
    """That they play; how fast depends on who draws (README)."""
    b = fm.Builder()
    for i in range(25):
        for j in range(41):
            b.node(f"{i},{j}", (0.1 * j, 0.1 * i))
            if i:
                b.add(planar.beam, f"{i - 1},{j}", f"{i},{j}", section=leaf())
            if j:
                b.add(planar.beam, f"{i},{j - 1}", f"{i},{j}", section=leaf())
    model = b.build(check=False)
    x = np.asarray(model.parameters.reference)
    moved = x + 0.2 * np.sin(np.arange(len(x)))
    page = opened(browser, fm.view(model, at=type("State", (), {"x": moved})), tmp_path)
    assert (tmp_path / "page.html").stat().st_size < 2_500_000
    assert len(ask(page, "v.data.parts")) == 1984
    # Few draws: the elements are one, their ghost another.
    page.execute_script("window.flexmb.draw()")
    assert ask(page, "v.stage.renderer.info.render.calls") == 2
    # What the page itself computes for a frame takes a small part of the 50 ms of 20 frames a second.
    spent = ask(page, "(() => { const t = performance.now(); for (let i = 0; i < 10; i += 1) v.update();"
                      " return (performance.now() - t) / 10; })()")  # fmt: skip
    assert spent < 25
