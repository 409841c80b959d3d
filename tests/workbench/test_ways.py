"""Sensitivities of live answers, against central differences of documents that are built anew."""

import time

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb.workbench.building import build, numeric_values
from flexmb.workbench.document import Document, apply
from flexmb.workbench.live import Live
from flexmb.workbench.live_answers import Answers, Wants
from flexmb.workbench.ways import Ways, numeric_fields


def add(call: str, name: str | None = None, **args) -> dict:
    return {"op": "add", "thing": {"call": call, "args": args} | ({} if name is None else {"name": name})}


def guide(foot: str = "0", **more: str) -> Document:
    """The planar guide of the tutorial with a force, its dimensions by name."""
    names = {"t": "0.5e-3", "w": "0.018", "L": "0.1", "gap": "L + 0*w", "half": "w/2"} | more
    ops = [{"op": "name", "name": name, "to": {"value": value}} for name, value in names.items()]
    ops += [
        add("Material", "steel", E="210e9", G="80e9", rho="7850"),
        add("Rectangle", "leaf", width="2*half", thickness="t", material="steel"),
        add("node", "A", position=[foot, "0"]),
        add("node", "B", position=["0", "L"]),
        add("node", "C", position=["gap", "L"]),
        add("node", "D", position=["gap", "0"]),
        add("planar.beam", "left", nodes=["A", "B"], section="leaf", released="2 3"),
        add("planar.beam", "right", nodes=["D", "C"], section="leaf", released="2 3"),
        add("planar.beam", "bar", nodes=["B", "C"]),
        add("fix", node="A"),
        add("fix", node="D"),
        add("mass", node="B", mass="0.103"),
        add("mass", node="C", mass="0.103"),
        add("force", node="B", force=["0.5", "-20"]),
    ]
    return apply(Document.empty(2), ops)[0]


def answers(document: Document, **wants) -> Answers:
    found = Answers(build(document).builder.build(), Wants(**wants))
    for _, analyse in found.analyses():
        analyse()
    return found


# Relative: its fourth power is what differences leave out, and round-off of the equilibria is 1e-11 of it.
STEP = 1e-3
KEYS = ["frequency 1", "multiplier 1", "stress", "mass", "stiffness x", "displacement", "displacement x"]


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_slopes_are_central_differences(key):
    # Were the leaf upright, the stress would be the same at both of its ends.
    document = guide(foot="1e-3")
    told = Ways(lambda: None).of(document, answers(document, support_node="C", sensitivity_of=key), wait=True)
    assert (told["status"], told["answer"]) == ("ok", key)
    at, scale = numeric_values(document), abs(answers_at(document, {}, key))
    for address, slope in told["by_field"].items():
        step = STEP * (abs(at[address]) or 0.1)
        expected = difference(lambda by, of=address: answers_at(document, {of: at[of] + by}, key), step)
        assert slope == approx(expected, rel=1e-6, abs=1e-6 * scale / (abs(at[address]) or 0.1))
    for name, slope in told["by_name"].items():
        own = at[f"names/{name}/value"]
        expected = difference(
            lambda by, of=name, own=own: answers_at(document, numeric_values(document, {of: own + by}), key), STEP * own
        )
        assert slope == approx(expected, rel=1e-6, abs=1e-6 * scale / own)


def difference(function, step: float) -> float:
    """Central difference of the fourth order."""
    one, two = (function(k * step) - function(-k * step) for k in (1, 2))
    return (8 * one - two) / (12 * step)


def answers_at(document: Document, values: dict, key: str) -> float:
    model = build(document, values).builder.build()
    if key == "frequency 1":
        return float(fm.frequencies(model)[0])
    if key == "multiplier 1":
        return float(fm.buckling_loads(model)[0])
    if key == "stress":
        return float(fm.stress(model).maximum)
    if key == "mass":
        return float(fm.mass(model))
    if key == "stiffness x":
        return float(fm.stiffness(model, "C", "x"))
    state = fm.equilibrium(model)
    node = "C" if key == "displacement x" else "B"
    moved = np.asarray(state.position(node)) - np.asarray(fm.configuration(model).position(node))
    return float(moved[0]) if key == "displacement x" else float(np.linalg.norm(moved))


@pytest.mark.slow
def test_powers_of_dimensions_are_relative_slopes():
    # Two leaf springs in sway with a light section: f ~ sqrt(12 E w t^3/12 / L^3), and the mass at the top hardly
    # changes; without load and without density exactly.
    document = guide()
    document = apply(document, [{"op": "set", "address": "1/rho", "to": "0"}, {"op": "delete", "ids": ["14"]}])[0]
    told = Ways(lambda: None).of(document, answers(document, sensitivity_of="frequency 1"), wait=True)
    assert told["relative"]["t"] == approx(1.5, rel=1e-9)
    assert told["relative"]["w"] == approx(0.5, rel=1e-9)
    assert told["relative"]["L"] == approx(-1.5, rel=1e-9)
    assert "gap" not in told["by_name"], "it is no free name"
    # Both sides of both sections, 3/2 + 1/2, half of it each.
    assert told["by_element"] == approx({"left": 1.0, "right": 1.0, "bar": 0.0}, rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_it_is_compiled_once_for_all_numbers(monkeypatch):
    from flexmb.workbench import ways

    count = []
    own = ways._closure
    monkeypatch.setattr(ways, "_closure", lambda *given: count.append(1) or own(*given))
    found = Ways(lambda: None)
    for t in ("0.5e-3", "0.4e-3", "0.6e-3"):
        document = guide(t=t)
        told = found.of(document, answers(document, sensitivity_of="frequency 1"), wait=True)
        assert told["status"] == "ok"
    assert len(count) == 1


@pytest.mark.slow
def test_what_has_no_meaning_is_said():
    document = guide()
    found = Ways(lambda: None)
    told = found.of(document, answers(document, sensitivity_of="stress"), wait=True)
    assert "Several places have the largest stress" in told["words"][0]
    told = found.of(document, answers(document, sensitivity_of="frequency 9"), wait=True)
    assert (told["status"], told["message"]) == ("failed", "There is no frequency 9 here, so it has no sensitivity.")
    twins = apply(
        Document.empty(3),
        [
            add("Material", "steel", E="210e9", G="80e9", rho="7850"),
            add("Circle", "wire", diameter="1e-3", material="steel"),
            add("node", "A", position=["0", "0", "0"]),
            add("node", "B", position=["0", "0", "0.1"]),
            add("spatial.beam", "wire", nodes=["A", "B"], section="wire"),
            add("fix", node="A"),
            add("mass", node="B", mass="0.1"),
        ],
    )[0]
    told = found.of(twins, answers(twins, sensitivity_of="frequency 1"), wait=True)
    assert told["status"] == "failed"
    assert "repeated" in told["message"]
    assert "frequency 2" in told["message"]


def test_fields_are_numbers_and_not_what_chooses_code():
    document = apply(guide(), [add("planar.spectral_beam", "s", nodes=["A", "C"], section="leaf", order="3")])[0]
    assert not [address for address in numeric_fields(document) if address.startswith(("names/", "15/"))]


@pytest.mark.slow
def test_live_tells_them_before_the_scene_that_they_colour():
    heard: list[dict] = []
    live = Live(heard.append)
    wants = Wants(sensitivity_of="frequency 1", colour="sensitivity")
    live.show(1, guide(), wants)
    for _ in range(100):
        if any(one["tell"] == "ways" and one["status"] == "ok" for one in heard):
            break
        assert live.wait(60)
        time.sleep(0.1)
    assert live.wait(60)
    heard.clear()
    live.show(2, guide(t="0.4e-3"), wants)
    assert live.wait(60)
    live.stop()
    assert [one["tell"] for one in heard] == ["count", "answers", "ways", "scene"]
    assert heard[-1]["view"]["colours"]["label"].startswith("frequency 1")
