"""Drawing in the workbench by mouse and by keys, as its users do, and what the picture then shows."""

import json
import time

import numpy as np
import pytest
from cases.mechanisms import BAR, COIL, LENGTH, WIDTH, leaf
from cases.workbench import ask, browsing, faults, needs_browser, opened, served, until

import flexmb as fm
from flexmb import planar

pytestmark = [needs_browser, pytest.mark.timeout(240)]

# Tutorial, section 3.1, as printed: the first frequency [Hz] and the buckling load [N] of the planar guide.
FREQUENCY, BUCKLING = 10.6448, 78.75
MASS = str((BAR + COIL) / 2)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with browsing(tmp_path_factory.mktemp("browser")) as driver:
        yield driver


@pytest.fixture(scope="module")
def workbench(tmp_path_factory):
    with served(folder=tmp_path_factory.mktemp("work")) as own:
        yield own


@pytest.fixture
def page(browser, workbench):
    """An empty page in the plane."""
    opened(browser, workbench.address)
    yield blank(browser, 2)
    assert not faults(browser)


def blank(page, dimension):
    """Take everything away, so that the next test begins from nothing."""
    ops = ask(page, "s.state.document.things.map(({id}) => id)")
    edits = [{"op": "delete", "ids": ops}] if ops else []
    edits += [{"op": "name", "name": name, "to": None} for name in ask(page, "Object.keys(s.state.document.names)")]
    edits += [{"op": "dimension", "to": dimension}] if ask(page, "s.state.document.dimension") != dimension else []
    if edits:
        edit(page, edits)
    until(page, f"!s.state.document.things.length && s.state.document.dimension === {dimension}")
    page.execute_script("window.workbench.store.setTool({kind: 'select'}); window.workbench.canvas.fit();")
    focus(page)
    settle(page)
    return page


def edit(page, ops):
    reply = page.execute_async_script(
        "const done = arguments[1]; window.workbench.store.edit(arguments[0], {label: 'test'}).then(done, (e) => done(e.message));",
        ops,
    )
    assert isinstance(reply, dict), reply
    until(page, f"s.state.revision >= {reply['revision']}")
    settle(page)
    return reply


def settle(page):
    """Wait until the page has drawn what it knows."""
    page.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done));")


def focus(page):
    page.execute_script("document.getElementById('scene').focus();")


def add(call, name=None, **args):
    return {"op": "add", "thing": {"call": call, **({"name": name} if name else {}), "args": args}}


PLAIN_GUIDE = [
    add("Material", "steel", E="210e9", G="80e9", rho="7850"),
    add("Rectangle", "leaf", width=str(WIDTH), thickness="0.5e-3", material="steel"),
    *(add("node", name, position=place) for name, place in zip("ABCD", (["0", "0"], ["0", "0.1"], ["0.1", "0.1"], ["0.1", "0"]), strict=True)),
    add("planar.beam", "left", nodes=["A", "B"], section="leaf", released="2 3"),
    add("planar.beam", "right", nodes=["D", "C"], section="leaf", released="2 3"),
    add("planar.beam", "bar", nodes=["B", "C"]),
    add("fix", node="A"),
    add("fix", node="D"),
    add("mass", node="B", mass=MASS),
    add("mass", node="C", mass=MASS),
]


# What hands do.


def actions(page, slow=20):
    from selenium.webdriver import ActionChains

    return ActionChains(page, duration=slow)


def screen(page, place):
    """Offset of a place in the mechanism from the middle of the drawing [px]."""
    x, y = ask(page, f"w.canvas.eye.project({json.dumps([*place, 0][:3])})")
    stage = page.find_element("id", "scene").rect
    return round(x - stage["width"] / 2), round(y - stage["height"] / 2)


def click(page, *places, shift=False):
    from selenium.webdriver import Keys

    scene = page.find_element("id", "scene")
    for place in places:
        chain = actions(page).move_to_element_with_offset(scene, *screen(page, place))
        (chain.key_down(Keys.SHIFT).click().key_up(Keys.SHIFT) if shift else chain.click()).perform()
        idle(page)


def drag(page, start, end, steps=6, let_go=True):
    scene = page.find_element("id", "scene")
    (x, y), (u, v) = screen(page, start), screen(page, end)
    chain = actions(page, 15).move_to_element_with_offset(scene, x, y).click_and_hold()
    for k in range(1, steps + 1):
        chain.move_to_element_with_offset(scene, round(x + (u - x) * k / steps), round(y + (v - y) * k / steps))
    if let_go:
        chain.release()
    chain.perform()
    idle(page)


def idle(page):
    """Wait until everything that was asked is done and drawn."""
    settle(page)
    until(page, "s.asked.size === 0 && !w.canvas.tool.making && !w.canvas.stale")
    settle(page)


def press(page, *keys):
    """Keys to whatever is in focus."""
    for key in keys:
        page.switch_to.active_element.send_keys(key)
    idle(page)


def typed(page, *places):
    """Coordinates by keyboard, each followed by Enter."""
    from selenium.webdriver import Keys

    for place in places:
        press(page, "=")
        press(page, place, Keys.ENTER)


def take(page, key, call):
    """Take a tool by its letter."""
    press(page, key)
    until(page, f"s.state.tool.call === '{call}' && w.canvas.tool.call === '{call}'")
    idle(page)


def things(page, call=None):
    found = ask(page, "s.state.document.things")
    return [one for one in found if call is None or one["call"] == call]


def nodes(page):
    return {one["name"]: one["args"]["position"] for one in things(page, "node")}


def answer(page, key, seconds=60):
    """An answer that is of the document of now."""
    current = "s.state.answers && s.state.answers.of_revision === s.state.revision && s.state.answers.status === 'ok'"
    until(page, f"{current} && s.state.answers.values['{key}']", seconds)
    return ask(page, f"s.state.answers.values['{key}'].value")


def field(page, label):
    """The field of the properties with a label."""
    return page.find_element(
        "xpath", f"//div[@id='inspector']//label[normalize-space()='{label}']/following::*[self::input or self::select][1]"
    )


def put(page, label, text):
    """Write into a field of the properties."""
    from selenium.webdriver import Keys

    own = field(page, label)
    own.click()
    own.send_keys(Keys.CONTROL, "a")
    own.send_keys(text, Keys.ENTER)
    idle(page)


def go_to(page, label):
    """Go through the page by Tab to the field of the properties with a label."""
    from selenium.webdriver import Keys

    wanted = field(page, label)
    for _ in range(60):
        if page.switch_to.active_element == wanted:
            return
        page.switch_to.active_element.send_keys(Keys.TAB)
    raise AssertionError(f"{label} is not reached by Tab")


def write(page, label, text):
    """The same by keyboard alone."""
    from selenium.webdriver import Keys

    go_to(page, label)
    page.switch_to.active_element.send_keys(Keys.CONTROL, "a")
    press(page, text, Keys.ENTER)


def test_the_guide_of_the_tutorial_from_an_empty_page_by_mouse(page):
    """Section 3.1: its frequency, and the load under which it buckles; the mouse draws, the keyboard writes numbers."""
    from selenium.webdriver import Keys

    def tool(name):
        page.find_element("xpath", f"//div[@id='tools']//button[contains(@class, 'tool')]/span[normalize-space()='{name}']").click()
        idle(page)

    tool("Beam")
    until(page, "w.canvas.tool.call === 'planar.beam'")
    put(page, "released", "2 3")
    click(page, (0, 0), (0, 0.1), (0.1, 0), (0.1, 0.1))
    # A beam without a section is rigid.
    put(page, "section", "–")
    put(page, "released", Keys.DELETE)
    click(page, (0, 0.1), (0.1, 0.1))
    tool("Fix")
    click(page, (0, 0), (0.1, 0))
    tool("Mass")
    until(page, "w.canvas.tool.call === 'mass'")
    put(page, "mass", MASS)
    click(page, (0, 0.1), (0.1, 0.1))
    assert nodes(page) == {"A": ["0", "0"], "B": ["0", "0.1"], "C": ["0.1", "0"], "D": ["0.1", "0.1"]}
    page.execute_script("window.workbench.store.setTool({kind: 'select'});")
    page.execute_script("window.workbench.store.select(arguments[0]);", [one["id"] for one in things(page, "Rectangle")])
    idle(page)
    put(page, "width", str(WIDTH))
    put(page, "thickness", "0.5e-3")
    assert answer(page, "frequency 1") == pytest.approx(FREQUENCY, abs=5e-5)
    tool("Force")
    click(page, (0, 0.1))
    assert things(page, "force")[0]["args"] == {"node": "B", "force": ["0", "-1"]}
    assert answer(page, "multiplier 1") == pytest.approx(BUCKLING, abs=5e-5)
    frequency = fm.frequencies(guide().build())[0]
    click(page, (0.05, 0.03))
    assert answer(page, "frequency 1") == pytest.approx(float(frequency), rel=1e-9)


def guide(corner=(0.1, 0.1), force=(0, -1)):
    """The guide of the tutorial by the Builder."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, LENGTH), "C": (0.1, 0), "D": corner}.items():
        b.node(name, place)
    for ends in ("AB", "CD"):
        b.add(planar.beam, *ends, section=leaf(), released=(2, 3))
    b.add(planar.beam, "B", "D")
    for node in "AC":
        b.fix(node)
    for node in "BD":
        b.mass(node, (BAR + COIL) / 2)
    if force:
        b.force("B", force)
    return b


def test_the_guide_by_keyboard_alone(page):
    from selenium.webdriver import Keys

    take(page, "b", "planar.beam")
    press(page, Keys.F6)
    write(page, "released", "2 3")
    focus_by_keys(page)
    typed(page, "0, 0", "@ 0, 100 mm", "100 mm, 0")
    # The last end by the cursor: from where the beam began, up by the steps of the grid.
    step = ask(page, "w.canvas.step")
    press(page, *[Keys.ARROW_UP] * round(0.1 / step), Keys.ENTER)
    press(page, Keys.F6)
    write(page, "section", "–")
    write(page, "released", Keys.DELETE)
    focus_by_keys(page)
    typed(page, "0, 0.1", "0.1, 0.1")
    take(page, "h", "fix")
    typed(page, "0, 0", "0.1, 0")
    take(page, "w", "mass")
    typed(page, "0, 0.1", "0.1, 0.1")
    # Esc ends the tool, and then the selection; Tab goes from thing to thing.
    press(page, Keys.ESCAPE, Keys.ESCAPE)
    for chosen in things(page, "mass"):
        for _ in things(page):
            if ask(page, "s.state.selection.at(-1)") != chosen["id"]:
                press(page, Keys.TAB)
        press(page, "e")
        write(page, "mass", MASS)
        focus_by_keys(page)
    assert [one["args"]["mass"] for one in things(page, "mass")] == [MASS, MASS]
    take(page, "l", "force")
    typed(page, "0, 0.1")
    press(page, Keys.ESCAPE)
    leaf_by_keys(page)
    assert nodes(page) == {"A": ["0", "0"], "B": ["0", "0.1"], "C": ["0.1", "0"], "D": ["0.1", "0.1"]}
    assert answer(page, "multiplier 1") == pytest.approx(BUCKLING, abs=5e-5)
    assert answer(page, "frequency 1") == pytest.approx(float(fm.frequencies(guide().build())[0]), rel=1e-9)


def focus_by_keys(page):
    """Back to the drawing, through the parts of the page."""
    from selenium.webdriver import Keys

    for _ in range(6):
        if ask(page, "document.activeElement.id === 'scene'"):
            return
        page.switch_to.active_element.send_keys(Keys.F6)
        settle(page)
    raise AssertionError("The drawing is not reached by F6.")


def leaf_by_keys(page):
    """Choose the section in the list of sections, and write its width and thickness."""
    from selenium.webdriver import Keys

    press(page, Keys.F6)
    tab = page.find_element("id", "tab-sections")
    for _ in range(4):
        if page.switch_to.active_element == tab:
            break
        page.switch_to.active_element.send_keys(Keys.ARROW_RIGHT)
        settle(page)
    assert page.switch_to.active_element == tab
    for _ in range(20):
        page.switch_to.active_element.send_keys(Keys.TAB)
        if ask(page, "document.activeElement.getAttribute('role') === 'listbox'"):
            break
    wanted = things(page, "Rectangle")[0]["id"]
    for _ in range(10):
        if ask(page, "s.state.selection.at(-1)") == wanted:
            break
        press(page, Keys.ARROW_DOWN)
    press(page, Keys.ENTER)
    write(page, "width", str(WIDTH))
    write(page, "thickness", "0.5e-3")


def test_a_node_that_is_dragged_takes_the_frequencies_along_and_undo_brings_all_back(page):
    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    before = answer(page, "frequency 1")
    text, picture = ask(page, "JSON.stringify(s.state.document)"), shown(page)
    steps = len(ask(page, "s.state.undo"))
    drag(page, (0.1, 0.1), (0.12, 0.12))
    assert nodes(page)["C"] == ["0.12", "0.12"]
    assert len(ask(page, "s.state.undo")) == steps + 1
    moved = guide((0.12, 0.12), None)
    assert answer(page, "frequency 1") == pytest.approx(float(fm.frequencies(moved.build())[0]), rel=1e-9)
    assert answer(page, "frequency 1") != pytest.approx(before, rel=1e-3)
    assert shown(page) != picture
    page.execute_script("window.workbench.store.select([]);")
    undone = page.execute_async_script("window.workbench.store.ask('undo').then(arguments[0]);")
    until(page, f"s.state.revision >= {undone['revision']}")
    assert answer(page, "frequency 1") == before
    assert ask(page, "JSON.stringify(s.state.document)") == text
    assert shown(page) == picture


def shown(page):
    """The picture, without what the pointer adds."""
    page.execute_script(
        "const c = window.workbench.canvas; document.activeElement.blur(); window.workbench.store.select([]);"
        "c.hands.leave(); c.keyed = false;"
    )
    until(page, "!s.state.scene || s.state.scene.of_revision === s.state.revision")
    idle(page)
    return ask(page, "w.canvas.picture().toDataURL()")


def test_a_drag_that_is_left_by_escape_changes_nothing(page):
    from selenium.webdriver import Keys

    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    text = ask(page, "JSON.stringify(s.state.document.things)")
    drag(page, (0.1, 0.1), (0.13, 0.13), let_go=False)
    assert ask(page, "JSON.stringify(s.state.document.things)") != text
    press(page, Keys.ESCAPE)
    until(page, f"JSON.stringify(s.state.document.things) === {json.dumps(text)}")
    actions(page).release().perform()
    idle(page)
    assert ask(page, "JSON.stringify(s.state.document.things)") == text


def test_arrow_keys_move_what_is_selected_in_one_step_of_the_history(page):
    from selenium.webdriver import Keys

    edit(page, PLAIN_GUIDE)
    press(page, Keys.TAB)
    assert ask(page, "s.state.selection") == [things(page, "node")[0]["id"]]
    step, steps = ask(page, "w.canvas.step"), len(ask(page, "s.state.undo"))
    press(page, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_DOWN)
    until(page, f"s.state.positions.A[0] > {1.9 * step} && s.state.positions.A[1] < {-0.9 * step}")
    assert [float(value) for value in nodes(page)["A"]] == pytest.approx([2 * step, -step], rel=1e-9)
    assert len(ask(page, "s.state.undo")) == steps + 1


def test_a_node_on_names_keeps_its_arithmetic(page):
    edit(page, [
        {"op": "name", "name": "w", "to": {"value": "0.1", "low": "0.05", "high": "0.2"}},
        add("node", "A", position=["0", "0"]),
        add("node", "B", position=["w", "w/2"]),
        add("planar.beam", "one", nodes=["A", "B"]),
    ])
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    drag(page, (0.1, 0.05), (0.12, 0.08))
    # Its x is a name, which the hand moves; its y follows from that and is left alone.
    assert nodes(page)["B"] == ["w", "w/2"]
    assert float(ask(page, "s.state.document.names.w.value")) == pytest.approx(0.12)
    assert "w/2" in ask(page, "w.canvas.spoken.textContent")


def test_a_node_dropped_on_another_becomes_part_of_it(page):
    edit(page, [
        add("node", "A", position=["0", "0"]),
        add("node", "B", position=["0.1", "0"]),
        add("node", "C", position=["0.1", "0.05"]),
        add("node", "D", position=["0.1", "0.1"]),
        add("planar.beam", "one", nodes=["A", "B"]),
        add("planar.beam", "two", nodes=["C", "D"]),
    ])
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    steps = len(ask(page, "s.state.undo"))
    drag(page, (0.1, 0.05), (0.1, 0), let_go=False)
    assert "join C to B" in ask(page, "w.canvas.tipBox.textContent")
    actions(page).release().perform()
    until(page, "!s.state.document.things.some(({name}) => name === 'C')")
    assert things(page, "planar.beam")[1]["args"]["nodes"] == ["B", "D"]
    assert len(ask(page, "s.state.undo")) == steps + 1


def test_clicks_meet_nodes_middles_and_lines_through_other_nodes(page):
    edit(page, [
        add("node", "A", position=["0", "0"]),
        add("node", "B", position=["0.1", "0"]),
        add("node", "C", position=["0.0333", "0.0777"]),
        add("planar.beam", "one", nodes=["A", "B"]),
    ])
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    met = "w.canvas.snapAt(...w.canvas.eye.project([{}, {}, 0]).map((v) => v + 3), {{lines: true}})"
    assert ask(page, met.format(0.1, 0) + ".node.name") == "B"
    assert ask(page, met.format(0.05, 0) + ".share") == 0.5
    # Above C, off the grid: in line with it, and on the grid along the other axis.
    x, y, _ = ask(page, met.format(0.0333, 0.04) + ".point")
    assert (x, y) == (0.0333, pytest.approx(0.04, abs=ask(page, "w.canvas.step")))
    assert y == pytest.approx(round(y / ask(page, "w.canvas.step")) * ask(page, "w.canvas.step"), rel=1e-12)
    # A beam from the middle of another divides that one, in one step.
    steps = len(ask(page, "s.state.undo"))
    take(page, "b", "planar.beam")
    click(page, (0.05, 0), (0.05, 0.06))
    assert len(things(page, "planar.beam")) == 3
    # The section that came with the tool is a step of its own.
    assert len(ask(page, "s.state.undo")) <= steps + 2


def test_a_rectangle_chooses_what_lies_in_it_or_also_what_it_touches(page):
    from selenium.webdriver import Keys

    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    names = "s.state.selection.map((id) => s.state.document.things.find((one) => one.id === id).name).filter(Boolean).sort()"
    drag(page, (-0.03, 0.12), (0.13, 0.08))
    assert ask(page, names) == ["B", "C", "bar"]
    drag(page, (0.13, 0.12), (-0.03, 0.08))
    assert ask(page, names) == ["B", "C", "bar", "left", "right"]
    click(page, (0, 0.1), shift=True)
    assert "B" not in ask(page, names)
    press(page, Keys.ESCAPE)
    assert ask(page, "s.state.selection") == []


def test_delete_takes_along_what_hangs_on_it_and_a_copy_is_selected(page):
    from selenium.webdriver import Keys

    edit(page, PLAIN_GUIDE)
    press(page, Keys.CONTROL + "a")
    press(page, "d")
    until(page, "s.state.document.things.filter(({call}) => call === 'node').length === 8")
    chosen = ask(page, "s.state.selection")
    assert chosen
    press(page, Keys.DELETE)
    assert len(nodes(page)) == 4
    assert "Deleted" in ask(page, "w.canvas.spoken.textContent")


def test_in_space_a_node_goes_along_the_axis_that_is_pulled(browser, workbench):
    page = blank(opened(browser, workbench.address), 3)
    edit(page, [add("node", "A", position=["0", "0", "0"]), add("node", "B", position=["0.1", "0.05", "0.1"])])
    page.execute_script("window.workbench.canvas.fit();")
    b = things(page, "node")[1]["id"]
    page.execute_script("window.workbench.store.select([arguments[0]]);", b)
    idle(page)
    place = [0.1, 0.05, 0.1]
    reach = 30 * ask(page, "w.canvas.eye.scale")
    start, end = [*place[:2], place[2] + reach], [*place[:2], place[2] + reach + 0.04]
    drag(page, start, end)
    x, y, z = (float(value) for value in nodes(page)["B"])
    assert (x, y) == (0.1, 0.05)
    assert z == pytest.approx(0.14, abs=ask(page, "w.canvas.step"))
    # On the plane zx at another height, by keys alone.
    press(page, "n", "y", "]")
    typed(page, "0, 0, 0")
    assert ask(page, "w.canvas.eye.axis") == 1
    assert not faults(page)


def test_names_stay_text_however_long_they_are(page):
    script = "<script>document.title = 'taken'</script>"
    edit(page, [
        add("node", script, position=["0", "0"]),
        add("node", "n" * 100, position=["0.1", "0"]),
        add("planar.beam", "<img src=x onerror=alert(1)>" + "e" * 100, nodes=[script, "n" * 100]),
    ])
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    actions(page).move_to_element_with_offset(page.find_element("id", "scene"), *screen(page, (0, 0))).perform()
    idle(page)
    assert script in ask(page, "w.canvas.tipBox.textContent")
    assert ask(page, "document.title") != "taken"
    assert ask(page, "document.querySelectorAll('#stage img, #stage script').length") == 0


def test_two_hundred_elements_stay_fluid(page):
    """At least 20 pictures a second in software, while the mode swings and a node is pulled about."""
    b, ops = fm.Builder(), []
    for k in range(51):
        for r in (0, 1):
            b.node(f"n{k}.{r}", (0.05 * k, 0.05 * r))
            ops.append(add("node", f"n{k}.{r}", position=[str(0.05 * k), str(0.05 * r)]))
    ends = [pair for k in range(50) for pair in ((f"n{k}.0", f"n{k + 1}.0"), (f"n{k}.1", f"n{k + 1}.1"), (f"n{k}.0", f"n{k}.1"), (f"n{k}.1", f"n{k + 1}.0"))]
    for k, pair in enumerate(ends):
        b.add(planar.beam, *pair, name=f"e{k}", section=leaf(), released=(1, 2, 3))
        ops.append(add("planar.beam", f"e{k}", nodes=list(pair)))
    for node in ("n0.0", "n0.1"):
        b.fix(node)
    assert len(ends) == 200
    edit(page, ops)
    page.execute_script("window.workbench.canvas.fit();")
    from flexmb.viewer.page import page_data

    scene = page_data(fm.view(fm.modes(b.build()), which=[0]))
    page.execute_script(
        "const {store, canvas} = window.workbench; store.put({scene: {view: arguments[0], kind: 'modes'}}); canvas.play();"
        "let turn = 0; window.pull = setInterval(() => {"
        "  turn += 0.1; canvas.moved = {'n25.1': [1.25, 0.05 + 0.02 * Math.sin(turn), 0]}; canvas.replan();}, 10);",
        scene,
    )
    time.sleep(3)
    rate = ask(page, "w.canvas.framesPerSecond")
    page.execute_script("clearInterval(window.pull); window.workbench.canvas.moved = {}; window.workbench.canvas.play(false);")
    assert rate >= 20


def test_a_new_scene_keeps_eye_and_phase_and_the_sign_of_a_mode(page):
    edit(page, PLAIN_GUIDE)
    answer(page, "frequency 1")
    until(page, "s.state.scene && s.state.scene.of_revision === s.state.revision && w.canvas.swing.data")
    page.execute_script("window.workbench.canvas.zoom(1.7); window.workbench.canvas.swing.state.position = 0.31;")
    told = "[w.canvas.eye.scale, w.canvas.swing.state.position, Array.from(w.canvas.eye.matrix)]"
    before, moves = ask(page, told), np.array(ask(page, "Array.from(w.canvas.swing.data.nodes.states)"))
    edit(page, [{"op": "set", "address": f"{things(page, 'Rectangle')[0]['id']}/thickness", "to": "0.6e-3"}])
    until(page, "s.state.scene.of_revision === s.state.revision")
    settle(page)
    assert ask(page, told) == before
    after = np.array(ask(page, "Array.from(w.canvas.swing.data.nodes.states)"))
    assert after @ moves > 0.99 * np.linalg.norm(after) * np.linalg.norm(moves)
    # The same scene turned about comes out the same.
    page.execute_script(
        "const {store, canvas} = window.workbench; const raw = store.state.scene.view;"
        "const turn = (text) => { const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0)); const own = new Float32Array(bytes.buffer);"
        "own.forEach((v, i) => (own[i] = -v)); return btoa(String.fromCharCode(...new Uint8Array(own.buffer))); };"
        "canvas.swing.replace({view: {...raw, states: turn(raw.states), acrossStates: raw.acrossStates && turn(raw.acrossStates),"
        "nodes: {...raw.nodes, states: turn(raw.nodes.states)}}});"
    )
    assert ask(page, "Array.from(w.canvas.swing.data.nodes.states)") == pytest.approx(after)
