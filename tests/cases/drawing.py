"""What hands do in the drawing of the workbench: clicks and drags at places of the mechanism, keys, typed numbers."""

import json

from .mechanisms import BAR, COIL, WIDTH
from .workbench import ask, until

MASS = str((BAR + COIL) / 2)


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
        "const [ops, done] = arguments; const asked = window.workbench.store.edit(ops, {label: 'test'});"
        "asked.then(done, (fault) => done(fault.message));",
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
        "xpath",
        f"//div[@id='inspector']//label[normalize-space()='{label}']/following::*[self::input or self::select][1]",
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


def focus_by_keys(page):
    """Back to the drawing, through the parts of the page."""
    from selenium.webdriver import Keys

    for _ in range(6):
        if ask(page, "document.activeElement.id === 'scene'"):
            return
        page.switch_to.active_element.send_keys(Keys.F6)
        settle(page)
    raise AssertionError("The drawing is not reached by F6.")


PLAIN_GUIDE = [
    add("Material", "steel", E="210e9", G="80e9", rho="7850"),
    add("Rectangle", "leaf", width=str(WIDTH), thickness="0.5e-3", material="steel"),
    *(
        add("node", name, position=place)
        for name, place in zip("ABCD", (["0", "0"], ["0", "0.1"], ["0.1", "0.1"], ["0.1", "0"]), strict=True)
    ),
    add("planar.beam", "left", nodes=["A", "B"], section="leaf", released="2 3"),
    add("planar.beam", "right", nodes=["D", "C"], section="leaf", released="2 3"),
    add("planar.beam", "bar", nodes=["B", "C"]),
    add("fix", node="A"),
    add("fix", node="D"),
    add("mass", node="B", mass=MASS),
    add("mass", node="C", mass=MASS),
]
