"""What stands around the drawing, as its users have it: fields, names, answers, advice, targets and files."""

import json
import time

import numpy as np
import pytest
from cases.tolerances import approx
from cases.workbench import ask, faults, needs_browser, opened, requests, served, until, wait_for

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
    name("t", str(THICKNESS), "0.2e-3", "2e-3"),
    name("L", str(LENGTH)),
    add("Material", "steel", E="210e9", G="80e9", rho="7850"),
    add("Rectangle", "leaf", width=str(WIDTH), thickness="t", material="steel"),
    add("node", "A", position=["0", "0"]),
    add("node", "B", position=["0", "L"]),
    add("node", "C", position=["L", "L"]),
    add("node", "D", position=["L", "0"]),
    add("planar.beam", "left", nodes=["A", "B"], section="leaf"),
    add("planar.beam", "right", nodes=["D", "C"], section="leaf"),
    add("planar.rigid_body", "bar", nodes=["B", "C"]),
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
    b.add(planar.rigid_body, "B", "C", name="bar")
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


@pytest.mark.slow
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


@pytest.mark.slow
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
    # Nothing is advised about what is left without the elements of this section.
    assert not page.find_element("css selector", "#answers .advice").is_displayed()
    assert "thickness" in page.find_element("id", "mobility").text
    # What was good stays, and is called stale.
    assert page.find_element("css selector", "#answers .stamp").text == "stale"
    kept = float(page.find_element("css selector", "[data-answer='frequency 1'] data").get_attribute("value"))
    assert kept == good["frequency 1"]
    write(box, "t")
    until(page, "!document.querySelector('#inspector [aria-invalid=true]')")
    assert answered(page)["frequency 1"] == approx(good["frequency 1"], rel=1e-12)
    # What is half typed is no design: "1" never was, so what stays is what was there before.
    write(box, "1/0")
    until(page, "document.querySelector('#inspector [aria-invalid=true]')")
    until(page, "document.getElementById('answers').classList.contains('stale')")
    kept = float(page.find_element("css selector", "[data-answer='frequency 1'] data").get_attribute("value"))
    assert kept == approx(good["frequency 1"], rel=1e-12)


@pytest.mark.slow
def test_a_unit_behind_a_number_is_told_and_makes_no_name(page):
    edit(page, *GUIDE)
    answered(page)
    select(page, "leaf")
    write(field(page, "width"), "18 mm")
    until(
        page, "[...document.querySelectorAll('#inspector .problem')].some((e) => e.textContent.includes('write 18e-3'))"
    )
    assert not page.find_elements("css selector", "#inspector .problem button")


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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


SPATIAL = [
    {"op": "dimension", "to": 3},
    add("Material", "steel", E="210e9", G="80e9", rho="7850"),
    add("Rectangle", "leaf", width="18e-3", thickness="0.5e-3", material="steel"),
    *(
        add("node", f"{side} {end}", position=["0", y, z])
        for side, y in (("left", "0"), ("right", "0.05"))
        for end, z in (("foot", "0"), ("top", "0.1"))
    ),
    *(
        add(
            "spatial.beam",
            side,
            nodes=[f"{side} foot", f"{side} top"],
            section="leaf",
            y=["1", "0", "0"],
            released="2 3 4",
        )
        for side in ("left", "right")
    ),
    add("spatial.rigid_body", "bar", nodes=["left top", "right top"]),
    add("fix", node="left foot"),
    add("fix", node="right foot"),
    add("mass", node="left top", mass="0.1"),
    add("mass", node="right top", mass="0.1"),
]


@pytest.mark.slow
def test_a_button_of_the_advice_makes_a_spatial_guide_exactly_constrained(page):
    edit(page, *SPATIAL)
    until(page, "s.state.count?.status === 'overconstrained'")
    until(page, "document.getElementById('dof').textContent.includes('over')")
    assert ask(page, "document.getElementById('dof').dataset.state") == "over"
    until(page, "document.querySelector('[data-advice]')").click()
    until(page, "s.state.count.status === 'ok' && s.state.count.over === 0 && s.state.count.under === 0")
    until(page, "document.getElementById('dof').dataset.state === 'good'")
    # As the mechanics say: five degrees of freedom of ten released deformations, nothing over.
    b = _spatial(ask(page, "s.state.document.things"))
    assert fm.mobility(b.build(check=False)).overconstraints == 0
    assert answered(page)["frequency 1"] > 0
    page.find_element("id", "undo").click()
    until(page, "s.state.count.status === 'overconstrained'")


def _spatial(things):
    b = fm.Builder()
    leaf = fm.Rectangle(width=18e-3, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850))
    for one in things:
        own, call = one["args"], one["call"]
        if call == "node":
            b.node(one["name"], [float(text) for text in own["position"]])
        elif call == "spatial.beam":
            released = [int(number) for number in own["released"].split()]
            b.add(fm.spatial.beam, *own["nodes"], name=one["name"], section=leaf, y=(1, 0, 0), released=released)
        elif call == "spatial.rigid_body":
            b.add(fm.spatial.rigid_body, *own["nodes"], name=one["name"])
        elif call == "fix":
            b.fix(own["node"])
    return b


def dialog(page):
    """The dialog that is open."""
    return until(page, "document.querySelector('dialog[open]')")


def closed(page):
    until(page, "!document.querySelector('dialog[open]')")


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["json", "dat"])
def test_a_file_that_was_saved_opens_as_the_same_mechanism(page, folder, ending):
    # A .dat file knows no rigid bodies: a beam that does not deform stands in its place.
    bar = add("planar.beam", "bar", nodes=["B", "C"], section="leaf", released="none")
    edit(page, *(bar if one.get("thing", {}).get("name") == "bar" else one for one in GUIDE))
    shown = answered(page)
    page.find_element("id", "file-more").click()
    page.find_element("id", "save-as").click()
    box = dialog(page).find_element("css selector", "input")
    write(box, f"guide.{ending}")
    dialog(page).find_element("css selector", "[type=submit]").click()
    if ending == "dat":
        # What it does not hold is read first.
        until(page, "document.querySelector('dialog[open] li')?.textContent.includes('leaf')")
        page.find_element("xpath", "//dialog[@open]//button[.='Save without them']").click()
    until(page, f"s.state.saved && s.state.file?.endsWith('guide.{ending}')")
    closed(page)
    assert (folder / f"guide.{ending}").exists()
    edit(page, *clearing(page))
    page.find_element("id", "open").click()
    write(dialog(page).find_element("css selector", "input[type=text]"), f"guide.{ending}")
    dialog(page).find_element("css selector", "[type=submit]").click()
    until(page, "s.state.document.things.length > 5")
    again = answered(page)
    for key in ("frequency 1", "frequency 2", "mass"):
        assert again[key] == approx(shown[key], rel=1e-12)
    assert set(ask(page, "s.state.document.names")) == {"t", "L"}
    if document := page.find_elements("css selector", "dialog[open] .buttons button"):
        document[0].click()


@pytest.mark.slow
def test_a_script_that_was_saved_builds_the_same_mechanism(page, folder):
    edit(page, *GUIDE)
    shown = answered(page)
    assert wait_for(page, "s.ask('save', {path: 'guide.py'})")["saved"]
    space = {"__name__": "guide"}
    exec((folder / "guide.py").read_text(), space)
    makers = [own for key, own in space.items() if callable(own) and getattr(own, "__module__", "") == "guide"]
    built = next(found for found in (maker() for maker in makers) if isinstance(found, fm.Builder | fm.Model))
    model = built.build() if isinstance(built, fm.Builder) else built
    np.testing.assert_allclose(np.asarray(fm.frequencies(model))[0], shown["frequency 1"], rtol=1e-12)


@pytest.mark.slow
def test_dialogs_copy_mirror_split_and_join(page):
    edit(page, *GUIDE)
    count = "s.state.document.things.length"
    before = ask(page, count)
    select(page, "left")
    for act, steps in (("Copy …", 3), ("Mirror …", 3), ("Split …", 2)):
        page.find_element("xpath", f"//*[@id='inspector']//button[.='{act}']").click()
        if act == "Mirror …":
            write(dialog(page).find_element("css selector", "input"), "-L")
        dialog(page).find_element("css selector", "[type=submit]").click()
        closed(page)
        until(page, f"{count} > {before}")
        assert ask(page, count) == before + steps, act
        page.find_element("id", "undo").click()
        until(page, f"{count} === {before}")
        select(page, "left")
    # What is wrong with an answer is told in the dialog, which stays.
    page.find_element("xpath", "//*[@id='inspector']//button[.='Repeat …']").click()
    write(dialog(page).find_elements("css selector", "input")[-1], "0")
    dialog(page).find_element("css selector", "[type=submit]").click()
    until(page, "document.querySelector('dialog[open] .problem[role=alert]')?.textContent")
    dialog(page).find_element("xpath", ".//button[.='Cancel']").click()
    closed(page)


@pytest.mark.slow
def test_the_keyboard_alone_reaches_everything(page):
    from selenium.webdriver.common.keys import Keys

    edit(page, *GUIDE)
    answered(page)
    body = page.find_element("css selector", "body")
    page.execute_script("document.activeElement.blur(); document.getElementById('title').focus()")
    seen, describe = (
        [],
        "[document.activeElement.tagName, document.activeElement.id, document.activeElement.closest('[id]')?.id]",
    )
    for _ in range(150):
        seen.append(tuple(ask(page, describe)))
        page.switch_to.active_element.send_keys(*([Keys.ESCAPE] if seen[-1][1] == "scene" else []), Keys.TAB)
        if seen.count(seen[-1]) > 3 and seen[-1][1]:
            break
    places = {place for _, _, place in seen} | {own for _, own, _ in seen}
    wanted = set("title open save undo dof theme help tab-tools tools scene show-what play tab-inspector split".split())
    wanted |= {"tab-answers", "answer-rows", "support-node"}
    assert wanted <= places, wanted - places
    # Every control is called something.
    nodes = page.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"button", "slider", "checkbox", "combobox", "searchbox", "textbox", "tab", "listbox", "application"}
    controls = [node for node in nodes if node.get("role", {}).get("value") in roles and not node["ignored"]]
    unnamed = [node["role"]["value"] for node in controls if not node["name"]["value"]]
    assert len(controls) > 40
    assert not unnamed
    body.send_keys(Keys.F1)
    assert "Ctrl+Z" in dialog(page).text
    dialog(page).find_element("xpath", ".//button[.='Close']").send_keys(Keys.ESCAPE)
    closed(page)


@pytest.mark.slow
def test_typing_keeps_its_place_while_others_edit(page):
    edit(page, *GUIDE)
    select(page, "leaf")
    box = field(page, "width")
    write(box, "0.01")
    # Somebody else changes another field meanwhile; neither focus nor text nor caret goes away.
    material = ask(page, "s.state.document.things.find((t) => t.name === 'steel').id")
    wait_for(page, f"s.edit([{{op: 'set', address: '{material}/rho', to: '8000'}}], {{label: 'x'}})")
    box.send_keys("9")
    until(page, "s.state.document.things.find((t) => t.name === 'leaf').args.width === '0.019'")
    assert ask(page, "document.activeElement.value") == "0.019"


@pytest.mark.slow
def test_two_pages_show_the_same(page, workbench):
    edit(page, *GUIDE)
    first = page.current_window_handle
    page.switch_to.new_window("tab")
    try:
        page.get(workbench.address)
        until(page, "window.workbench && s.state.document?.things.length")
        edit(page, name("t", "0.4e-3", "0.2e-3", "1e-3"))
    finally:
        page.close()
        page.switch_to.window(first)
    until(page, "s.state.document.names.t.value === '0.4e-3'")
    tab(page, "names")
    until(page, "document.querySelector('[aria-label=\"Value of t\"]').value === '0.4e-3'")


@pytest.mark.slow
def test_a_target_is_met_at_a_click(page):
    edit(page, *GUIDE)
    answered(page)
    texts = ask(page, "s.state.document.names")
    steps = len(ask(page, "s.state.undo"))
    tab(page, "target")
    write(page.find_element("css selector", ".want input"), "20")
    page.find_element("xpath", "//*[@id='target']//label[.='L']").click()
    page.find_element("id", "find").click()
    until(page, "document.querySelector('#target .job')?.dataset.status === 'done'", 120)
    until(page, "s.state.document.names.t.value !== '0.0005'")
    tab(page, "answers")
    shown = answered(page)
    assert shown["frequency 1"] == approx(20, rel=1e-9)
    names = ask(page, "s.state.document.names")
    assert names["L"]["value"] == texts["L"]["value"]
    np.testing.assert_allclose(frequencies(float(names["t"]["value"]))[0], 20, rtol=1e-9)
    # However many designs were seen on the way, it is one step back.
    assert len(ask(page, "s.state.undo")) == steps + 1
    page.find_element("id", "undo").click()
    until(page, "s.state.document.names.t.value === '0.0005'")


@pytest.mark.slow
def test_a_table_of_measurements_is_fitted(page, tmp_path):
    edit(page, *GUIDE)
    answered(page)
    table = tmp_path / "shaker.csv"
    table.write_text(f"answer,value,deviation\nfrequency 1,{frequencies(0.6e-3)[0]},0.01\n")
    tab(page, "measured")
    assert not page.find_element("id", "fit-run").is_enabled()
    page.find_element("id", "fit-file").send_keys(str(table))
    page.find_element("xpath", "//*[@id='measured']//label[.='L']").click()
    page.find_element("id", "fit-run").click()
    until(page, "document.querySelector('#measured .job')?.dataset.status === 'done'", 120)
    assert "95 % from" in ask(page, "document.querySelector('#measured .job thead').textContent")
    assert ask(page, "s.state.document.names.t.value") == "0.0005"
    page.find_element("id", "fit-take").click()
    until(page, "s.state.document.names.t.value !== '0.0005'")
    assert float(ask(page, "s.state.document.names.t.value")) == approx(0.6e-3, rel=1e-6)


@pytest.mark.slow
def test_a_pinned_design_stands_beside_this_one(page):
    edit(page, *GUIDE)
    shown = answered(page)
    tab(page, "compare")
    page.find_element("id", "pin").click()
    until(page, "s.state.pinned?.differences")
    edit(page, name("t", "1e-3", "0.2e-3", "1e-3"))
    until(page, "[...document.querySelectorAll('#compare tr')].some((row) => row.textContent.startsWith('t'))")
    row = "[...document.querySelectorAll('#compare tr')].find((row) => row.textContent.startsWith('{}'))?.textContent"
    until(page, f"({row.format('frequency 1')} || '').includes('%')")
    assert "+100 %" in ask(page, row.format("t"))
    percent = 100 * (frequencies(1e-3)[0] / shown["frequency 1"] - 1)
    assert f"{percent:.0f} %" in ask(page, row.format("frequency 1"))
    page.find_element("xpath", "//*[@id='compare']//button[.='Unpin']").click()
    until(page, "!s.state.pinned?.differences")


@pytest.mark.slow
def test_an_analysis_runs_and_shows_its_picture(page):
    edit(page, *GUIDE)
    answered(page)
    tab(page, "analysis")
    until(page, "document.querySelector('#analysis-kind option[value=frequencies]')")
    page.execute_script(
        "const e = document.getElementById('analysis-kind'); e.value = 'buckling'; e.dispatchEvent(new Event('change'))"
    )
    until(page, "!document.getElementById('run').disabled")
    page.find_element("id", "run").click()
    until(page, "['done', 'failed'].includes(document.querySelector('#analysis .job')?.dataset.status)", 120)
    assert ask(page, "document.querySelector('#analysis .job').dataset.status") == "done"
    # A picture that the browser could read, and the multiplier of the table.
    until(page, "document.querySelector('#analysis .job img').naturalWidth > 0")
    assert "78.7" in ask(page, "document.querySelector('#analysis .job').textContent")


@pytest.mark.slow
def test_a_file_that_another_program_changed_is_offered(page, folder):
    edit(page, *GUIDE)
    assert wait_for(page, "s.ask('save', {path: 'watched.json'})")["saved"]
    file = folder / "watched.json"
    file.write_text(file.read_text().replace("210e9", "200e9"))
    until(page, "document.getElementById('file-changed')?.textContent.includes('watched.json')")
    steel = "s.state.document.things.find((t) => t.name === 'steel').args.E"
    assert ask(page, steel) == "210e9"
    page.find_element("xpath", "//*[@id='file-changed']//button[.='Take it']").click()
    until(page, f"{steel} === '200e9' && !document.getElementById('file-changed')")
    page.find_element("id", "undo").click()
    until(page, f"{steel} === '210e9'")
