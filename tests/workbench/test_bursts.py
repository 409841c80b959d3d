"""Many edits one after the other, as a slider sends them: the last answer is that of the last, and none too much.

Only numbers and order are looked at: how long it takes benchmarks/workbench.py measures.
"""

import numpy as np
import pytest
from cases import documents
from cases.mechanisms import THICKNESS
from cases.tolerances import approx
from cases.workbench import Client, served

import flexmb as fm
from flexmb.workbench.building import build
from flexmb.workbench.document import Document

pytestmark = pytest.mark.timeout(180)
EVENTS = 60


def guide() -> list[dict]:
    """Operations that draw the planar guide of the tutorial."""
    document = documents.planar_guide()
    names = [{"op": "name", "name": name, "to": own} for name, own in document.names.items()]
    things = [{key: own for key, own in thing.items() if key != "id"} for thing in document.things]
    # Degrees of freedom are found, so that the mechanism may grow.
    return names + [{"op": "add", "thing": thing} for thing in things if thing["call"] != "dof"]


def slide(value: float) -> list[dict]:
    return [{"op": "name", "name": "t", "to": {"value": repr(value), "low": "1e-4", "high": "2e-3"}}]


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bursts")
    with served(folder=folder, state=folder) as own:
        found = Client(own.address)
        yield found
        found.close()


def current(client: Client, revision: int) -> dict:
    """Answers to a revision."""

    def there():
        told = client.told.get("answers", {})
        return told if told.get("of_revision") == revision and told["status"] == "ok" else None

    return client.until(there, 120)


def frequency(client: Client) -> float:
    document = Document.from_data(client.told["document"]["document"])
    return float(fm.frequencies(build(document).model())[0])


@pytest.mark.slow
def test_after_a_burst_the_last_value_is_answered_and_nothing_comes_twice(client):
    revision = client.ask("edit", ops=guide(), label="Guide")["revision"]
    current(client, revision)
    before = len(client.heard)
    numbers = [
        client.send("edit", ops=slide(t), label="Slide t", merge="slider t")
        for t in np.linspace(4e-4, 6e-4, EVENTS).tolist()
    ]
    last = client.reply(numbers[-1])["revision"]
    told = current(client, last)
    assert told["values"]["frequency 1"]["value"] == approx(frequency(client), rel=1e-9)
    heard = client.heard[before:]
    answers = [one for one in heard if one["tell"] == "answers" and one["status"] == "ok"]
    revisions = [one["of_revision"] for one in answers]
    assert revisions == sorted(set(revisions)), "in order, and none twice"
    assert len(answers) <= EVENTS
    for kind in ("count", "scene"):
        own = [one["revision"] for one in heard if one["tell"] == kind]
        assert own == sorted(own), "none of an older document after one of a newer"
    # A burst is one step: undone, the first value is back, and the same number.
    client.ask("undo")
    client.until(lambda: client.told["document"]["document"]["names"]["t"]["value"] == repr(THICKNESS))


@pytest.mark.slow
def test_a_new_structure_is_counted_before_it_is_answered(client):
    begin = len(client.heard)
    ops = [
        {"op": "add", "thing": {"call": "node", "name": "E", "args": {"position": ["0.05", "0.2"]}}},
        {"op": "add", "thing": {"call": "planar.beam", "args": {"nodes": ["left1", "E"], "section": "leaf"}}},
    ]
    revision = client.ask("edit", ops=ops, label="Draw")["revision"]
    told = current(client, revision)
    assert told["values"]["frequency 1"]["value"] == approx(frequency(client), rel=1e-9)
    counted, *_ = [k for k, one in enumerate(client.heard) if is_of(one, "count", "ok", revision)]
    answered, *_ = [k for k, one in enumerate(client.heard) if is_of(one, "answers", "ok", revision)]
    assert begin <= counted < answered


def is_of(message: dict, kind: str, status: str, revision: int) -> bool:
    return (message["tell"], message.get("status"), message.get("revision")) == (kind, status, revision)
