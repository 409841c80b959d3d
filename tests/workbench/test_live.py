"""What is told of documents one after the other: counts, answers, scenes, in order, and never an old number as new."""

import itertools
import json
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.workbench.live import Live
from flexmb.workbench.live_answers import Wants


def drawn(own) -> SimpleNamespace:
    """What stands for a document."""
    return SimpleNamespace(own=own, things=[])


def built(builder: fm.Builder) -> SimpleNamespace:
    return SimpleNamespace(builder=builder, problems=[])


class Page:
    """What a page hears of a Live thread that is given Builders in place of documents."""

    def __init__(self, build=None):
        self.heard: list[dict] = []
        made = build or built
        self.live = Live(self.heard.append, lambda document: made(document.own))
        self.revision = 0

    def show(self, document, **wants) -> list[dict]:
        """All that is told of one document."""
        before, self.revision = len(self.heard), self.revision + 1
        self.live.show(self.revision, drawn(document), Wants(**wants))
        assert self.live.wait(60)
        return self.heard[before:]


@pytest.fixture(scope="module")
def page():
    found = Page()
    yield found
    found.live.stop()


def last(told: list[dict], what: str) -> dict:
    return [one for one in told if one["tell"] == what][-1]


def guide(thickness=5e-4):
    return mechanisms.planar_guide(thickness, force=(0, -1.0))


@pytest.mark.slow
def test_counts_come_first_then_answers_then_the_scene(page):
    page.show(guide())
    told = page.show(guide(4e-4))
    assert [one["tell"] for one in told] == ["count", "answers", "scene"]
    assert {one["revision"] for one in told} == {page.revision}
    json.dumps(told, allow_nan=False)


@pytest.mark.slow
def test_answers_are_those_of_the_public_functions(page):
    told = last(page.show(guide(), support_node="left1"), "answers")
    model, values = guide().build(), told["values"]
    assert (told["status"], told["stale"], told["of_revision"]) == ("ok", False, page.revision)
    assert values["frequency 1"]["value"] == approx(float(fm.frequencies(model)[0]), rel=1e-12)
    assert values["multiplier 1"]["value"] == approx(float(fm.buckling_loads(model)[0]), rel=1e-12)
    found = fm.stress(model)
    assert values["stress"]["value"] == approx(float(found.maximum), rel=1e-12)
    assert values["stress"]["where"]["element"] == found.where.element
    assert values["mass"]["value"] == float(fm.mass(model))
    assert values["stiffness x"]["value"] == approx(float(fm.stiffness(model, "left1", "x")), rel=1e-12)
    assert values["stiffness y"]["value"] is None
    assert values["stiffness y"]["text"] == "rigid"
    # Tutorial WA 1239 (2012): two leaf springs in sway buckle at pi^2 EI/L^2 each; one beam each gives 78.75 N.
    assert values["multiplier 1"]["value"] == approx(78.75, abs=0.005)


@pytest.mark.slow
def test_a_new_structure_is_counted_at_once_and_told_to_be_computing(page):
    told = page.show(mechanisms.spatial_guide(extra=(6,), force=(0, 0, -1.0)))
    assert [one["status"] for one in told if one["tell"] == "count"] == ["counting", "ok"]
    answers = [one for one in told if one["tell"] == "answers"]
    assert [one["status"] for one in answers][:2] == ["computing", "computing"]
    assert answers[0]["stale"], "of the mechanism before"
    assert answers[0]["of_revision"] == page.revision - 1
    # What is told as new is new, and grows.
    parts = [set(one["values"]) for one in answers if not one["stale"]]
    assert all(one <= other for one, other in itertools.pairwise(parts))
    assert answers[-1]["status"] == "ok"


def test_a_failure_keeps_the_last_good_answers_and_says_what_to_try(page):
    good = last(page.show(guide()), "answers")
    told = last(page.show(mechanisms.planar_guide(force=(0, -1e5), elongation=True)), "answers")
    assert told["status"] == "failed"
    assert "load may be beyond" in told["message"]
    assert (told["stale"], told["of_revision"], told["values"]) == (True, page.revision - 1, good["values"])
    told = page.show(mechanisms.spatial_guide())
    assert last(told, "answers")["status"] == "failed"
    assert last(told, "scene")["kind"] == "self-stress"
    told = page.show(guide())
    assert last(told, "answers")["status"] == "ok"


def test_a_document_with_problems_shows_no_number_of_the_rest(page):
    problem = [{"address": "2/thickness", "message": "Must be positive."}]
    other = Page(lambda b: SimpleNamespace(builder=b, problems=problem if b is wrong else []))
    wrong = guide()
    other.show(guide())
    told = last(other.show(wrong), "answers")
    other.live.stop()
    assert (told["status"], told["message"], told["stale"]) == ("failed", "Must be positive.", True)


@pytest.mark.slow
def test_unstable_and_loose_mechanisms_are_named(page):
    values = last(page.show(mechanisms.planar_guide(force=(0, -100.0))), "answers")["values"]
    # Beyond the buckling load the square of the frequency is negative.
    assert values["frequency 1"]["value"] < 0
    assert values["frequency 1"]["text"].startswith("unstable")
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, 0.1))
    b.add(planar.beam, "A", "B", name="leaf", section=mechanisms.leaf())
    told = page.show(b)
    assert last(told, "count")["status"] == "loose"
    assert last(told, "answers")["values"]["frequency 1"]["text"] == "0 Hz, moves freely"
    assert "no buckling" in " ".join(last(told, "answers")["words"])


def test_an_empty_drawing_keeps_no_answer_of_the_last_mechanism(page):
    assert last(page.show(guide()), "answers")["values"]
    assert last(page.show(fm.Builder()), "answers")["values"] == {}


@pytest.mark.slow
def test_loads_that_are_zero_yet_are_none(page):
    # A motion that is prescribed and not given yet moves nothing: round-off is no displacement, stress or multiplier.
    for value, there in ((0.0, False), (1e-3, True)):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (0, 0.1))
        b.add(planar.beam, "A", "B", name="leaf", section=mechanisms.leaf())
        b.mass("B", 0.1)
        b.fix("A")
        b.prescribe("B", "x", value)
        told = last(page.show(b), "answers")
        assert ({"displacement", "stress"} <= set(told["values"])) is there
        assert ("no buckling" in " ".join(told["words"])) is not there
    assert told["values"]["displacement"]["value"] == approx(1e-3, rel=1e-2)


@pytest.mark.slow
def test_the_newest_wins_and_there_are_no_more_answers_than_documents():
    entered, go = threading.Event(), threading.Event()

    def build(thickness):
        entered.set()
        assert go.wait(30)
        return SimpleNamespace(builder=guide(thickness), problems=[])

    page = Page(build)
    sizes = np.linspace(4e-4, 6e-4, 50)
    page.live.show(0, drawn(sizes[0]))
    assert entered.wait(30)
    for i, size in enumerate(sizes):
        page.live.show(i, drawn(size))
    go.set()
    assert page.live.wait(60)
    page.live.stop()
    answers = [one for one in page.heard if one["tell"] == "answers" and one["status"] == "ok"]
    assert [one["revision"] for one in answers] in ([0, 49], [49])
    assert answers[-1]["values"]["frequency 1"]["value"] == approx(
        float(fm.frequencies(guide(sizes[-1]).build())[0]), rel=1e-12
    )


def test_an_unforeseen_fault_is_told_and_the_next_document_answered(caplog):
    def build(document):
        if document == "bad":
            raise ZeroDivisionError("of its own")
        return SimpleNamespace(builder=guide(), problems=[])

    page = Page(build)
    with caplog.at_level("CRITICAL", "flexmb"):
        told = last(page.show("bad"), "answers")
    assert (told["status"], told["message"]) == ("failed", "ZeroDivisionError: of its own")
    assert last(page.show("good"), "answers")["status"] == "ok"
    page.live.stop()
    count = len(page.heard)
    page.live.show(9, drawn("good"))
    assert len(page.heard) == count, "nothing is told after the end"


def test_modes_do_not_turn_over_while_dimensions_change(page):
    def shape(told):
        import base64

        return np.frombuffer(base64.b64decode(last(told, "scene")["view"]["states"]), "<f4")

    first = shape(page.show(guide(5e-4)))
    for size in (4.5e-4, 4e-4, 6e-4):
        assert shape(page.show(guide(size))) @ first > 0


@pytest.mark.slow
def test_wants_that_there_are_not_are_refused():
    assert Wants().changed({"mode": 2, "support_node": "A"}) == Wants(mode=2, support_node="A")
    with pytest.raises(ValueError, match="no question 'modus'"):
        Wants().changed({"modus": 2})
    with pytest.raises(ValueError, match="state"):
        Wants().changed({"state": "nothing"})
