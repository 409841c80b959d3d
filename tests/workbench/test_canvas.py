"""Drawing in the workbench by mouse and by keys, as its users do, and what the picture then shows."""

import json
import time

import numpy as np
import pytest
from cases.drawing import (
    PLAIN_GUIDE,
    actions,
    add,
    answer,
    blank,
    click,
    drag,
    edit,
    idle,
    nodes,
    press,
    screen,
    settle,
    take,
    things,
    typed,
)
from cases.mechanisms import leaf
from cases.tolerances import approx
from cases.workbench import ask, faults, needs_browser, opened, until

import flexmb as fm
from flexmb import planar

pytestmark = [needs_browser, pytest.mark.timeout(240)]


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
    assert [float(value) for value in nodes(page)["A"]] == approx([2 * step, -step], rel=1e-9)
    assert len(ask(page, "s.state.undo")) == steps + 1


def test_a_node_on_names_keeps_its_arithmetic(page):
    edit(
        page,
        [
            {"op": "name", "name": "w", "to": {"value": "0.1", "low": "0.05", "high": "0.2"}},
            add("node", "A", position=["0", "0"]),
            add("node", "B", position=["w", "w/2"]),
            add("planar.beam", "one", nodes=["A", "B"]),
        ],
    )
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    drag(page, (0.1, 0.05), (0.12, 0.08))
    # Its x is a name, which the hand moves; its y follows from that and is left alone.
    assert nodes(page)["B"] == ["w", "w/2"]
    assert float(ask(page, "s.state.document.names.w.value")) == approx(0.12)
    assert "w/2" in ask(page, "w.canvas.spoken.textContent")


def test_a_node_dropped_on_another_becomes_part_of_it(page):
    edit(
        page,
        [
            add("node", "A", position=["0", "0"]),
            add("node", "B", position=["0.1", "0"]),
            add("node", "C", position=["0.1", "0.05"]),
            add("node", "D", position=["0.1", "0.1"]),
            add("planar.beam", "one", nodes=["A", "B"]),
            add("planar.beam", "two", nodes=["C", "D"]),
        ],
    )
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    steps = len(ask(page, "s.state.undo"))
    drag(page, (0.1, 0.05), (0.1, 0), let_go=False)
    assert "join C to B" in ask(page, "w.canvas.tipBox.textContent")
    actions(page).release().perform()
    until(page, "!s.state.document.things.some(({name}) => name === 'C')")
    assert things(page, "planar.beam")[1]["args"]["nodes"] == ["B", "D"]
    assert len(ask(page, "s.state.undo")) == steps + 1


@pytest.mark.slow
def test_clicks_meet_nodes_middles_and_lines_through_other_nodes(page):
    edit(
        page,
        [
            add("node", "A", position=["0", "0"]),
            add("node", "B", position=["0.1", "0"]),
            add("node", "C", position=["0.0333", "0.0777"]),
            add("planar.beam", "one", nodes=["A", "B"]),
        ],
    )
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    met = "w.canvas.snapAt(...w.canvas.eye.project([{}, {}, 0]).map((v) => v + 3), {{lines: true}})"
    assert ask(page, met.format(0.1, 0) + ".node.name") == "B"
    assert ask(page, met.format(0.05, 0) + ".share") == 0.5
    # Above C, off the grid: in line with it, and on the grid along the other axis.
    x, y, _ = ask(page, met.format(0.0333, 0.04) + ".point")
    assert (x, y) == (0.0333, approx(0.04, abs=ask(page, "w.canvas.step")))
    assert y == approx(round(y / ask(page, "w.canvas.step")) * ask(page, "w.canvas.step"), rel=1e-12)
    # A beam from the middle of another divides that one, in one step.
    steps = len(ask(page, "s.state.undo"))
    take(page, "b", "planar.beam")
    click(page, (0.05, 0), (0.05, 0.06))
    assert len(things(page, "planar.beam")) == 3
    # The section that came with the tool is a step of its own.
    assert len(ask(page, "s.state.undo")) <= steps + 2


@pytest.mark.slow
def test_a_rectangle_chooses_what_lies_in_it_or_also_what_it_touches(page):
    from selenium.webdriver import Keys

    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    names = "s.state.selection.map((id) => w.canvas.thing(id).name).filter(Boolean).sort()"
    drag(page, (-0.03, 0.12), (0.13, 0.08))
    assert ask(page, names) == ["B", "C", "bar"]
    drag(page, (0.13, 0.12), (-0.03, 0.08))
    assert ask(page, names) == ["B", "C", "bar", "left", "right"]
    click(page, (0, 0.1), shift=True)
    assert "B" not in ask(page, names)
    press(page, Keys.ESCAPE)
    assert ask(page, "s.state.selection") == []


@pytest.mark.slow
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


@pytest.mark.slow
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
    assert z == approx(0.14, abs=ask(page, "w.canvas.step"))
    # On the plane zx at another height, by keys alone.
    press(page, "n", "y", "]")
    typed(page, "0, 0, 0")
    assert ask(page, "w.canvas.eye.axis") == 1
    assert not faults(page)


@pytest.mark.slow
def test_a_hinge_is_drawn_by_its_node_and_the_element_that_turns_there(page):
    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    steps = len(ask(page, "s.state.undo"))
    page.execute_script("window.workbench.store.setTool({kind: 'element', call: 'planar.hinge', args: {}});")
    idle(page)
    click(page, (0.1, 0.1), (0.1, 0.05))
    assert things(page, "planar.hinge")[0]["args"]["nodes"] == ["C", "C turn 1"]
    assert len(ask(page, "s.state.undo")) == steps + 1
    assert not ask(page, "s.state.problems")
    until(page, "s.state.count.revision === s.state.revision && s.state.count.ndof === 2")


@pytest.mark.slow
def test_one_finger_moves_a_node_and_two_move_the_page(page):
    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    stage = page.find_element("id", "scene").rect

    def touch(kind, *places):
        points = [{"x": stage["x"] + x, "y": stage["y"] + y, "id": k} for k, (x, y) in enumerate(places)]
        page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    x, y = ask(page, "w.canvas.eye.project([0.1, 0.1, 0])")
    # A finger is wide: it takes a node that lies beside it.
    touch("touchStart", (x + 8, y + 6))
    for k in range(1, 6):
        touch("touchMove", (x + 8 + 8 * k, y + 6))
    touch("touchEnd")
    idle(page)
    moved = nodes(page)
    assert float(moved["C"][0]) > 0.1
    scale = ask(page, "w.canvas.eye.scale")
    touch("touchStart", (200, 300))
    touch("touchStart", (200, 300), (400, 300))
    for k in range(1, 6):
        touch("touchMove", (200 - 10 * k, 300), (400 + 10 * k, 300))
    touch("touchEnd")
    idle(page)
    assert ask(page, "w.canvas.eye.scale") < 0.9 * scale
    assert nodes(page) == moved


@pytest.mark.slow
def test_names_stay_text_however_long_they_are(page):
    script = "<script>document.title = 'taken'</script>"
    edit(
        page,
        [
            add("node", script, position=["0", "0"]),
            add("node", "n" * 100, position=["0.1", "0"]),
            add("planar.beam", "<img src=x onerror=alert(1)>" + "e" * 100, nodes=[script, "n" * 100]),
        ],
    )
    page.execute_script("window.workbench.canvas.fit();")
    idle(page)
    actions(page).move_to_element_with_offset(page.find_element("id", "scene"), *screen(page, (0, 0))).perform()
    idle(page)
    assert script in ask(page, "w.canvas.tipBox.textContent")
    assert ask(page, "document.title") != "taken"
    assert ask(page, "document.querySelectorAll('#stage img, #stage script').length") == 0


@pytest.mark.slow
def test_two_hundred_elements_stay_fluid(page):
    """At least 20 pictures a second in software, while the mode swings and a node is pulled about."""
    b, ops = fm.Builder(), []
    for k in range(51):
        for r in (0, 1):
            b.node(f"n{k}.{r}", (0.05 * k, 0.05 * r))
            ops.append(add("node", f"n{k}.{r}", position=[str(0.05 * k), str(0.05 * r)]))
    ends = [
        pair
        for k in range(50)
        for pair in (
            (f"n{k}.0", f"n{k + 1}.0"),
            (f"n{k}.1", f"n{k + 1}.1"),
            (f"n{k}.0", f"n{k}.1"),
            (f"n{k}.1", f"n{k + 1}.0"),
        )
    ]
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
        "const {store, canvas} = window.workbench; let turn = 0;"
        "store.put({scene: {view: arguments[0], kind: 'modes'}}); canvas.play();"
        "window.pull = setInterval(() => {"
        "  turn += 0.1; canvas.moved = {'n25.1': [1.25, 0.05 + 0.02 * Math.sin(turn), 0]}; canvas.replan();}, 10);",
        scene,
    )
    time.sleep(3)
    rate = ask(page, "w.canvas.framesPerSecond")
    page.execute_script(
        "clearInterval(window.pull); window.workbench.canvas.moved = {}; window.workbench.canvas.play(false);"
    )
    assert rate >= 20


@pytest.mark.slow
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
        "const {store: {state: {scene: {view}}}, canvas: {swing}} = window.workbench;"
        "const turned = (text) => {"
        "  const own = new Float32Array(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);"
        "  return btoa(String.fromCharCode(...new Uint8Array(own.map((value) => -value).buffer)));};"
        "const acrossStates = view.acrossStates && turned(view.acrossStates);"
        "const nodes = {...view.nodes, states: turned(view.nodes.states)};"
        "swing.replace({view: {...view, states: turned(view.states), acrossStates, nodes}});"
    )
    assert ask(page, "Array.from(w.canvas.swing.data.nodes.states)") == approx(after)
