"""The planar guide of the tutorial, drawn in the workbench: by mouse, by keys alone, and pulled about."""

import pytest
from cases.drawing import (
    MASS,
    PLAIN_GUIDE,
    actions,
    answer,
    click,
    drag,
    edit,
    focus_by_keys,
    idle,
    nodes,
    press,
    put,
    settle,
    take,
    things,
    typed,
    write,
)
from cases.mechanisms import BAR, COIL, LENGTH, WIDTH, leaf
from cases.tolerances import approx
from cases.workbench import ask, needs_browser, until

import flexmb as fm
from flexmb import planar

pytestmark = [needs_browser, pytest.mark.timeout(240)]

# Tutorial, section 3.1, as printed: the first frequency [Hz] and the buckling load [N] of the planar guide.
FREQUENCY, BUCKLING = 10.6448, 78.75


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


@pytest.mark.slow
def test_the_guide_of_the_tutorial_from_an_empty_page_by_mouse(page):
    """Section 3.1: its frequency, and the load under which it buckles; the mouse draws, the keyboard writes numbers."""
    from selenium.webdriver import Keys

    def tool(name):
        page.find_element(
            "xpath", f"//div[@id='tools']//button[contains(@class, 'tool')]/span[normalize-space()='{name}']"
        ).click()
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
    page.execute_script(
        "window.workbench.store.select(arguments[0]);", [one["id"] for one in things(page, "Rectangle")]
    )
    idle(page)
    put(page, "width", str(WIDTH))
    put(page, "thickness", "0.5e-3")
    assert answer(page, "frequency 1") == approx(FREQUENCY, abs=5e-5)
    tool("Force")
    click(page, (0, 0.1))
    assert things(page, "force")[0]["args"] == {"node": "B", "force": ["0", "-1"]}
    assert answer(page, "multiplier 1") == approx(BUCKLING, abs=5e-5)
    frequency = fm.frequencies(guide().build())[0]
    click(page, (0.05, 0.03))
    assert answer(page, "frequency 1") == approx(float(frequency), rel=1e-9)


@pytest.mark.slow
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
    assert answer(page, "multiplier 1") == approx(BUCKLING, abs=5e-5)
    assert answer(page, "frequency 1") == approx(float(fm.frequencies(guide().build())[0]), rel=1e-9)


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


@pytest.mark.slow
def test_a_node_that_is_dragged_takes_the_frequencies_along_and_undo_brings_all_back(page):
    nothing, blank_picture = ask(page, "JSON.stringify(s.state.document)"), shown(page)
    steps_before = len(ask(page, "s.state.undo"))
    edit(page, PLAIN_GUIDE)
    page.execute_script("window.workbench.canvas.fit();")
    before = answer(page, "frequency 1")
    text, picture = ask(page, "JSON.stringify(s.state.document)"), shown(page)
    steps = len(ask(page, "s.state.undo"))
    drag(page, (0.1, 0.1), (0.12, 0.12))
    assert nodes(page)["C"] == ["0.12", "0.12"]
    assert len(ask(page, "s.state.undo")) == steps + 1
    moved = guide((0.12, 0.12), None)
    assert answer(page, "frequency 1") == approx(float(fm.frequencies(moved.build())[0]), rel=1e-9)
    assert answer(page, "frequency 1") != approx(before, rel=1e-3)
    assert shown(page) != picture
    step_back(page)
    assert answer(page, "frequency 1") == before
    assert ask(page, "JSON.stringify(s.state.document)") == text
    assert shown(page) == picture
    while len(ask(page, "s.state.undo")) > steps_before:
        step_back(page)
    page.execute_script("window.workbench.canvas.fit();")
    assert ask(page, "JSON.stringify(s.state.document)") == nothing
    assert shown(page) == blank_picture


def step_back(page):
    """Undo by its keys."""
    from selenium.webdriver import Keys

    revision = ask(page, "s.state.revision")
    actions(page).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
    until(page, f"s.state.revision > {revision}")
    idle(page)


def shown(page):
    """The picture, without what the pointer adds."""
    page.execute_script(
        "const c = window.workbench.canvas; document.activeElement.blur(); window.workbench.store.select([]);"
        "c.hands.leave(); c.keyed = false;"
    )
    until(page, "!s.state.document.things.length || s.state.scene?.of_revision === s.state.revision")
    idle(page)
    return ask(page, "w.canvas.picture().toDataURL()")
