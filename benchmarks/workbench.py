"""How quickly the workbench answers: updates a second, slider to picture, bursts, structure, many elements.

``python benchmarks/workbench.py`` prints what README quotes and writes results/workbench.json. What a user sees takes
Debian's chromium and chromium-driver, and selenium; without them only the mechanics are timed.
"""

import contextlib
import importlib.util
import json
import os
import shutil
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

# For the browser, which the tests drive in the same way.
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

EVENTS, BURST, UPDATES = 50, 300, 100
LEAST, MOST = 0.4e-3, 0.6e-3
MANY, SECONDS = 200, 8

# What the page keeps of itself: when answers came, and when a picture of which revision was drawn [ms].
NOTES = """
const {store, canvas} = window.workbench, {stage} = canvas.eye;
const drawing = stage.draw.bind(stage), replacing = canvas.swing.replace.bind(canvas.swing);
window.notes = {answers: [], drawn: [], counts: []};
let shown = -1;
canvas.swing.playing = true;
canvas.swing.replace = (scene) => { replacing(scene); shown = scene?.of_revision ?? -1; };
stage.draw = (...given) => { drawing(...given); notes.drawn.push([performance.now(), shown]); };
const hearing = store.hear.bind(store);
store.hear = (message) => {
  const {tell, revision, of_revision, stale, status} = message, now = performance.now();
  if (tell === "answers") notes.answers.push([now, of_revision, stale, status]);
  if (tell === "count") notes.counts.push([now, revision, status]);
  return hearing(message);
};
window.slide = (value) => store.edit([{op: "name", name: "t", to: {value: String(value), low: "1e-4", high: "2e-3"}}],
  {label: "Slide t", merge: "slider t"});
window.until = async (there) => { for (let found; ; ) { if ((found = there())) return found;
  await new Promise((done) => setTimeout(done, 0)); } };
window.answered = (revision) => notes.answers.find(([, of, stale, status]) =>
  of >= revision && !stale && status === "ok");
window.seen = (revision) => notes.drawn.find(([, of]) => of >= revision);
"""
SINGLE = """
const done = arguments[arguments.length - 1], values = arguments[0];
(async () => {
  const found = [];
  for (const value of values) {
    const start = performance.now(), {revision} = await slide(value);
    const [answer] = await until(() => answered(revision)), [picture] = await until(() => seen(revision));
    found.push([answer - start, picture - start]);
    await new Promise((next) => setTimeout(next, 40));
  }
  return found;
})().then(done, (fault) => done(String(fault)));
"""
OF_MANY = """
const done = arguments[arguments.length - 1], values = arguments[0];
(async () => {
  const before = notes.answers.length, start = performance.now();
  let last = null;
  for (const value of values) {
    last = slide(value);
    await new Promise((next) => setTimeout(next, 2));
  }
  const end = performance.now(), {revision} = await last;
  const [answer] = await until(() => answered(revision)), [picture] = await until(() => seen(revision));
  return {lasted: end - start, answer: answer - end, picture: picture - end, answers: notes.answers.length - before};
})().then(done, (fault) => done(String(fault)));
"""
STRUCTURE = """
const done = arguments[arguments.length - 1], ops = arguments[0];
(async () => {
  const start = performance.now(), {revision} = await window.workbench.store.edit(ops, {label: "Draw"});
  const first = await until(() => notes.counts.find(([, of]) => of >= revision));
  const counted = await until(() => notes.counts.find(([, of, status]) => of >= revision && status !== "counting"));
  const answer = await until(() => notes.answers.find(([, of, stale]) => of >= revision && !stale));
  const all = await until(() => answered(revision));
  return [first, counted, answer, all].map(([time]) => time - start);
})().then(done, (fault) => done(String(fault)));
"""


def add(call: str, name: str | None = None, **arguments: Any) -> dict[str, Any]:
    """Operation that adds a thing."""
    return {"op": "add", "thing": {"call": call, "args": arguments} | ({"name": name} if name else {})}


def start() -> list[dict[str, Any]]:
    """Operations that begin every mechanism here: a thickness with a slider, a material, a section."""
    return [
        {"op": "name", "name": "t", "to": {"value": "0.5e-3", "low": "1e-4", "high": "2e-3"}},
        add("Material", "steel", E="210e9", G="80e9", rho="7850"),
        add("Rectangle", "leaf", width="0.018", thickness="t", material="steel"),
    ]


def guide(dimension: int) -> list[dict[str, Any]]:
    """Operations that draw the guide of the tutorial, in the plane or in space, loaded.

    Args:
        dimension: 2 or 3.
    """
    places = {"A": ("0", "0"), "B": ("0", "0.1"), "C": ("0.1", "0.1"), "D": ("0.1", "0")}
    more = {"y": ["1", "0", "0"]} if dimension == 3 else {}
    room, soft, softer = ("planar", "2 3", "2 3") if dimension == 2 else ("spatial", "2 3 4", "2 3 4 6")
    nodes = [add("node", n, position=["0", *own] if dimension == 3 else list(own)) for n, own in places.items()]
    down = ["0", "-1"] if dimension == 2 else ["0", "0", "-1"]
    return [
        *start(),
        *nodes,
        add(f"{room}.beam", "left", nodes=["A", "B"], section="leaf", released=soft, **more),
        add(f"{room}.beam", "right", nodes=["D", "C"], section="leaf", released=softer, **more),
        add(f"{room}.beam", "bar", nodes=["B", "C"], released="none", **more),
        add("fix", node="A"),
        add("fix", node="D"),
        add("mass", node="B", mass="0.103"),
        add("mass", node="C", mass="0.103"),
        add("force", node="B", force=down),
    ]


def grid(count: int) -> list[dict[str, Any]]:
    """Operations that draw a comb of beams in the plane, clamped at its foot.

    Args:
        count: Number of beams.
    """
    ops, joined = start(), 0
    rows = max(int((count / 2) ** 0.5), 1)
    for i in range(count):
        for j in range(rows + 1):
            ops.append(add("node", f"{i},{j}", position=[f"{0.1 * i:.6g}", f"{0.1 * j:.6g}"]))
            for near in ([(i, j - 1)] if j else []) + ([(i - 1, j)] if i and j else []):
                if joined < count:
                    ops.append(
                        add("planar.beam", f"b{joined}", nodes=[f"{near[0]},{near[1]}", f"{i},{j}"], section="leaf")
                    )
                    joined += 1
        ops.append(add("fix", node=f"{i},0"))
        if joined >= count:
            break
    used = {node for op in ops if "thing" in op for node in op["thing"]["args"].get("nodes", ())}

    def belongs(op: dict[str, Any]) -> bool:
        thing = op.get("thing", {"call": "", "args": {}})
        node = {"node": thing.get("name"), "fix": thing["args"].get("node")}.get(thing["call"])
        return node is None or node in used

    return [op for op in ops if belongs(op)]


def updates(dimension: int, wants: dict[str, Any]) -> dict[str, float]:
    """Time of one update of everything that is shown, in one process, and how many a second that is.

    Args:
        dimension: Of the guide.
        wants: What is shown.
    """
    import statistics

    import numpy as np

    import flexmb as fm
    from flexmb.workbench.building import build
    from flexmb.workbench.document import Document, apply
    from flexmb.workbench.live import Live
    from flexmb.workbench.live_answers import Wants

    heard: list[dict[str, Any]] = []
    live, own = Live(heard.append), apply(Document.empty(dimension), guide(dimension))[0]
    times, asked = [], Wants().changed(wants)
    for i, t in enumerate(np.linspace(LEAST, MOST, UPDATES + 1).tolist()):
        document = apply(own, [{"op": "name", "name": "t", "to": {"value": repr(t)}}])[0]
        begin = time.perf_counter()
        live.show(i, document, asked)
        if not live.wait(120):
            raise RuntimeError("No answer within two minutes.")
        times.append(time.perf_counter() - begin)
        if not i:
            # What sensitivities need is compiled beside, and shown once it is there.
            until = time.monotonic() + 120
            while asked.sensitivity_of and time.monotonic() < until:
                if any(one["tell"] == "ways" and one["status"] == "ok" for one in heard):
                    break
                time.sleep(0.1)
            live.wait(120)
    live.stop()
    told = [one for one in heard if one["tell"] == "answers"][-1]["values"]["frequency 1"]["value"]
    _check(told, float(fm.frequencies(build(document).model())[0]))
    median = statistics.median(times[1:])
    p95 = sorted(times[1:])[int(0.95 * UPDATES)]
    return {"first": times[0], "least": min(times), "median": median, "p95": p95, "a second": 1 / median}


def _check(found: float, expected: float) -> None:
    if not abs(found - expected) <= 1e-9 * abs(expected):
        raise RuntimeError(f"The page says {found!r} Hz where fm.frequencies says {expected!r}.")


def in_browser() -> dict[str, Any]:
    """Times from the slider to the answer and to the picture, as a user has them [ms]."""
    import numpy as np
    from cases.workbench import ask, browsing, opened, served, wait_for

    import flexmb as fm
    from flexmb.workbench.building import build
    from flexmb.workbench.document import Document

    def drawn(page: Any, dimension: int, ops: list[dict[str, Any]]) -> None:
        things = ask(page, "s.state.document.things.map(({id}) => id)")
        begin = [{"op": "delete", "ids": things}] if things else []
        reply = wait_for(page, f"s.edit({json.dumps([*begin, {'op': 'dimension', 'to': dimension}, *ops])})")
        if "problem" in reply:
            raise RuntimeError(reply["problem"])
        page.execute_async_script(
            "const done = arguments[1]; until(() => answered(arguments[0])).then(done)", reply["revision"]
        )

    def checked(page: Any) -> None:
        document = Document.from_data(ask(page, "s.state.document"))
        told = ask(page, "s.state.answers.values['frequency 1'].value")
        _check(told, float(fm.frequencies(build(document).model())[0]))

    def run(page: Any, script: str, given: Any) -> Any:
        found = page.execute_async_script(script, given)
        if isinstance(found, str):
            raise RuntimeError(found)
        return found

    found: dict[str, Any] = {}
    random = np.random.default_rng(1)
    with contextlib.ExitStack() as held:
        folder = Path(held.enter_context(tempfile.TemporaryDirectory()))
        os.environ["FLEXMB_CACHE"] = str(folder / "cache")
        own = held.enter_context(served(folder=folder, state=folder / "state"))
        page = held.enter_context(browsing(folder / "browser"))
        page.set_script_timeout(300)
        opened(page, own.address)
        page.execute_script(NOTES)
        for dimension in (2, 3):
            drawn(page, dimension, guide(dimension))
            run(page, SINGLE, random.uniform(LEAST, MOST, 5).tolist())
            times = np.array(run(page, SINGLE, random.uniform(LEAST, MOST, EVENTS).tolist()))
            checked(page)
            own_name = f"guide in {'the plane' if dimension == 2 else 'space'}"
            found[own_name] = {
                "answer": _spread(times[:, 0]),
                "picture": _spread(times[:, 1]),
                "burst": run(page, OF_MANY, np.linspace(LEAST, MOST, BURST).tolist()),
                "frames": ask(page, "w.canvas.framesPerSecond"),
            }
            checked(page)
        drawn(page, 2, guide(2))
        more = [add("node", "E", position=["0.05", "0.2"]), add("planar.beam", "up", nodes=["B", "E"], section="leaf")]
        again = [add("node", "F", position=["0.15", "0.2"]), add("planar.beam", "on", nodes=["C", "F"], section="leaf")]
        names = ("number of freedoms", "constraints", "frequencies", "everything")
        for what, ops in (("one beam more", more), ("and another", again)):
            found[what] = dict(zip(names, run(page, STRUCTURE, ops), strict=True))
        drawn(page, 2, grid(MANY))
        time.sleep(SECONDS)
        found[f"{MANY} beams"] = {
            "frames": ask(page, "w.canvas.framesPerSecond"),
            "answer": _spread(np.array(run(page, SINGLE, [0.45e-3, 0.5e-3, 0.55e-3]))[:, 0]),
        }
    return found


def _spread(times: Any) -> dict[str, float]:
    import numpy as np

    least, median, p95, most = np.percentile(times, [0, 50, 95, 100]).tolist()
    return {"least": least, "median": median, "p95": p95, "most": most}


def main() -> None:
    """Measure, and write what was found."""
    from record import save

    import flexmb as fm

    fm.enable_x64()
    warnings.simplefilter("ignore", fm.BeamTheoryWarning)
    found: dict[str, Any] = {"updates": {}, "browser": None}
    for dimension, where in ((2, "the plane"), (3, "space")):
        for what, wants in (("all answers", {}), ("and sensitivities", {"sensitivity_of": "frequency 1"})):
            own = found["updates"][f"guide in {where}, {what}"] = updates(dimension, wants)
            times = f"{1e3 * own['median']:.1f} ms, p95 {1e3 * own['p95']:.1f}"
            print(f"{where}, {what}: {times}, {own['a second']:.0f} a second", flush=True)
    if shutil.which("chromium") and shutil.which("chromedriver") and importlib.util.find_spec("selenium"):
        found["browser"] = in_browser()
        print(json.dumps(found["browser"], indent=1))
    else:
        print("The browser is left out: it takes chromium, chromium-driver and selenium (pip install -e '.[test]').")
    save("workbench", found)


if __name__ == "__main__":
    main()
