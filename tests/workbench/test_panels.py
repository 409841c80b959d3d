"""What stands around the drawing, as its users have it: fields, names, answers, advice, targets and files."""

import json
import time

import numpy as np
import pytest
from cases.workbench import ask, browsing, faults, needs_browser, opened, requests, served, until, wait_for

import flexmb as fm
from flexmb import planar

pytestmark = [needs_browser, pytest.mark.timeout(180)]

LENGTH, WIDTH, THICKNESS, MASS = 0.1, 18e-3, 0.5e-3, 0.5
SCRIPT = "<script>document.title = 'taken over'</script>"


def add(call, name=None, **arguments):
    """Operation that adds a thing."""
    return {"op": "add", "thing": {"call": call, **({"name": name} if name else {}), "args": arguments}}


def name(of, value, low="", high=""):
    """Operation that sets a name."""
    return {"op": "name", "name": of, "to": {"value": value, "low": low, "high": high}}


GUIDE = [
    name("t", str(THICKNESS), "0.2e-3", "1e-3"),
    name("L", str(LENGTH)),
    add("Material", "steel", E="210e9", G="80e9", rho="7850"),
    add("Rectangle", "leaf", width=str(WIDTH), thickness="t", material="steel"),
    add("node", "A", position=["0", "0"]),
    add("node", "B", position=["0", "L"]),
    add("node", "C", position=["L", "L"]),
    add("node", "D", position=["L", "0"]),
    add("planar.beam", "left", nodes=["A", "B"], section="leaf"),
    add("planar.beam", "right", nodes=["D", "C"], section="leaf"),
    add("planar.rigid_beam", "bar", nodes=["B", "C"]),
    add("fix", node="A"),
    add("fix", node="D"),
    add("mass", node="B", mass=str(MASS)),
    add("force", node="B", force=["0.2", "-1"]),
]


def frequencies(thickness, length=LENGTH):
    """Frequencies of the guide by the public function alone [Hz]."""
    b = fm.Builder()
    for node, place in {"A": (0, 0), "B": (0, length), "C": (length, length), "D": (length, 0)}.items():
        b.node(node, place)
    leaf = fm.Rectangle(width=WIDTH, thickness=thickness, material=fm.Material(E=210e9, G=80e9, rho=7850))
    b.add(planar.beam, "A", "B", name="left", section=leaf)
    b.add(planar.beam, "D", "C", name="right", section=leaf)
    b.add(planar.rigid_beam, "B", "C", name="bar")
    b.fix("A")
    b.fix("D")
    b.mass("B", MASS)
    b.force("B", (0.2, -1))
    return np.asarray(fm.frequencies(b.build()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("workbench")


@pytest.fixture(scope="module")
def workbench(folder):
    with served(folder=folder) as own:
        yield own


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with browsing(tmp_path_factory.mktemp("browser")) as own:
        yield own


@pytest.fixture
def page(browser, workbench):
    """The page with nothing in it; whatever a test does, it writes nothing to the console and asks nobody else."""
    opened(browser, workbench.address)
    edit(browser, *clearing(browser))
    yield browser
    assert not faults(browser)
    foreign = [one for one in requests(browser) if not one.startswith((workbench.address, "data:", "blob:", "chrome:"))]
    assert not foreign


def clearing(page):
    document = ask(page, "s.state.document")
    things = [{"op": "delete", "ids": [one["id"] for one in document["things"]]}] if document["things"] else []
    ops = [*things, *({"op": "name", "name": one, "to": None} for one in document["names"])]
    return ops + ([{"op": "dimension", "to": 2}] if document["dimension"] != 2 else [])


def edit(page, *ops):
    """Change the document as the page does, and wait until the page has it."""
    if not ops:
        return {}
    reply = wait_for(page, f"s.edit({json.dumps(ops)}, {{label: 'test'}})")
    assert "problem" not in reply, reply
    until(page, f"s.state.revision >= {reply['revision']}")
    return reply


def answered(page, seconds=60):
    """Wait for answers to the drawing as it is now; their values by key, as they stand in the list."""
    until(page, "s.state.answers && s.state.answers.status === 'ok' && s.state.answers.of_revision === s.state.revision"
                " && !document.getElementById('answers').classList.contains('stale')", seconds)  # fmt: skip
    shown = "Object.fromEntries([...document.querySelectorAll('[data-answer]')].map((row) =>" \
            " [row.dataset.answer, Number(row.querySelector('data').value)]))"  # fmt: skip
    return ask(page, shown)


def tab(page, which):
    page.find_element("id", f"tab-{which}").click()


def field(page, label):
    """A field of the form that is seen, by its label."""
    return page.find_element("xpath", f"//*[@id='inspector']//label[.='{label}']/following-sibling::*//input")


def select(page, of):
    page.execute_script(
        "const s = window.workbench.store; s.select([s.state.document.things.find((t) => t.name === arguments[0]).id])",
        of,
    )
    until(page, f"document.querySelector('#inspector h2')?.textContent === {json.dumps(of)}")


def write(box, text):
    """Type a text in the place of another."""
    from selenium.webdriver.common.keys import Keys

    box.send_keys(Keys.CONTROL, "a")
    box.send_keys(Keys.NULL, text)


def test_a_slider_moves_the_numbers_of_the_public_function(page):
    edit(page, *GUIDE)
    shown = answered(page)
    np.testing.assert_allclose(shown["frequency 1"], frequencies(THICKNESS)[0], rtol=1e-9)
    tab(page, "names")
    slider = page.find_element("css selector", "input[type=range][data-name=t]")
    undone = len(ask(page, "s.state.undo"))
    from selenium.webdriver.common.keys import Keys

    slider.send_keys(*[Keys.ARROW_RIGHT] * 25)
    until(page, "Number(s.state.document.names.t.value) > 0.5e-3 && !s.merging.size")
    shown = answered(page)
    thickness = float(ask(page, "s.state.document.names.t.value"))
    expected = frequencies(thickness)
    for k, own in enumerate(expected[:3], 1):
        np.testing.assert_allclose(shown[f"frequency {k}"], own, rtol=1e-9)
    # The whole way of the slider is one step back, and its text is what it was.
    assert len(ask(page, "s.state.undo")) == undone + 1
    page.find_element("id", "undo").click()
    until(page, f"s.state.document.names.t.value === '{THICKNESS}'")
    until(page, f"document.querySelector('[aria-label=\"Value of t\"]').value === '{THICKNESS}'")


def test_bad_input_is_marked_at_its_field_and_the_last_good_answers_are_greyed(page):
    edit(page, *GUIDE)
    good = answered(page)
    select(page, "leaf")
    box = field(page, "thickness")
    write(box, "-1e-3")
    until(page, "document.querySelector('#inspector [aria-invalid=true]')")
    until(page, "document.getElementById('answers').classList.contains('stale')")
    # The message of the one who builds it, where a screen reader finds it.
    described = "document.getElementById(document.activeElement.getAttribute('aria-describedby'))?.textContent"
    until(page, f"({described} || '').includes('thickness')")
    # What was good stays, and is called stale.
    assert page.find_element("css selector", "#answers .stamp").text == "stale"
    kept = float(page.find_element("css selector", "[data-answer='frequency 1'] data").get_attribute("value"))
    assert kept == good["frequency 1"]
    write(box, "t")
    until(page, "!document.querySelector('#inspector [aria-invalid=true]')")
    assert answered(page)["frequency 1"] == pytest.approx(good["frequency 1"], rel=1e-12)


def test_an_unknown_name_becomes_one(page):
    edit(page, *GUIDE)
    answered(page)
    select(page, "leaf")
    box = field(page, "width")
    write(box, "2*half")
    until(page, "document.querySelector('#inspector .problem button')").click()
    until(page, "s.state.document.names.half")
    until(page, "!document.querySelector('#inspector [aria-invalid=true]')")
    tab(page, "names")
    assert page.find_element("css selector", "input[type=range][data-name=half]").is_displayed()


def test_texts_of_others_stay_texts(page):
    long = "a" * 100
    edit(page, add("node", SCRIPT, position=["0", "0"]), add("node", long, position=["0.1", "0"]), name("b" * 100, "1"))
    edit(page, {"op": "title", "to": SCRIPT})
    tab(page, "things")
    row = page.find_element("xpath", f"//*[@role='option'][.//*[.=\"{SCRIPT}\"]]")
    row.click()
    until(page, f"document.querySelector('#inspector h2')?.textContent === {json.dumps(SCRIPT)}")
    tab(page, "names")
    time.sleep(0.2)
    assert ask(page, "document.title").endswith(SCRIPT)
    assert ask(page, "document.querySelectorAll('script').length") == 1
    # Nothing is wider than its place.
    wide = (
        "[...document.querySelectorAll('body > *')].filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.id)"
    )
    assert ask(page, wide) == []
    edit(page, {"op": "title", "to": "guide"})


def test_undo_all_gives_texts_back(page):
    before = ask(page, "s.state.document")
    steps = len(ask(page, "s.state.undo"))
    edit(page, *GUIDE)
    edit(page, {"op": "set", "address": ask(page, "s.state.document.things[0].id") + "/E", "to": "200e9"})
    while len(ask(page, "s.state.undo")) > steps:
        revision = ask(page, "s.state.revision")
        page.find_element("css selector", "body").send_keys(_control("z"))
        until(page, f"s.state.revision > {revision}")
    after = ask(page, "s.state.document")
    assert {key: after[key] for key in ("names", "things")} == {key: before[key] for key in ("names", "things")}


def _control(letter):
    from selenium.webdriver.common.keys import Keys

    return Keys.CONTROL + letter + Keys.NULL
