"""A session of the workbench: files, journals, what another program changes, targets, pins."""

import collections
import json
import os
import time
from pathlib import Path

import pytest
from cases.disk import full, not_regular
from cases.documents import planar_guide
from cases.tolerances import approx
from cases.workbench import cantilever, thing

import flexmb as fm
from flexmb.spacar.lines import LARGEST_FILE
from flexmb.workbench import open_file
from flexmb.workbench.begin import TakenError, session_of_file, session_of_new
from flexmb.workbench.document import Document
from flexmb.workbench.jobs import Job
from flexmb.workbench.server import guarded
from flexmb.workbench.session import Refused, Session, VisibleJob

pytestmark = pytest.mark.timeout(120)
LENGTH, DEPTH, THICKNESS, MASS = 0.1, 0.02, 0.5e-3, 0.1


@pytest.fixture(autouse=True)
def _state(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_STATE", str(tmp_path / "state"))


class Told:
    """What a session tells: the newest of every kind, and all."""

    def __init__(self, session):
        self.newest, self.all = collections.defaultdict(dict), []
        session.listen(self.take)

    def take(self, message):
        self.newest[message["tell"]] = message
        self.all.append(message)

    def until(self, there, seconds=60):
        end = time.monotonic() + seconds
        while not (found := there(self.newest)):
            assert time.monotonic() < end, self.newest.keys()
            time.sleep(0.01)
        return found


@pytest.fixture
def opened():
    """A function that opens sessions, which are closed in the end."""
    sessions = []

    def open_(own=None):
        session = own if own is not None else Session()
        sessions.append(session)
        return session, Told(session)

    yield open_
    for session in sessions:
        session.close()


def killed(session):
    """What is left of a session whose process was killed: its journal, which nobody holds any more."""
    session.close(keep=True)


def things(told):
    return [one.get("name", one["call"]) for one in told.newest["document"]["document"]["things"]]


@pytest.mark.slow
def test_answers_follow_an_edit(opened):
    session, told = opened()
    reply = session.ask("edit", {"ops": cantilever()})
    assert reply["revision"] == 1
    assert len(reply["ids"]) == 7
    document = told.newest["document"]
    assert document["positions"] == {"A": [0, 0], "B": [0.1, 0]}
    assert document["values"] == {"t": 0.5e-3}
    found = told.until(lambda n: n["answers"].get("status") == "ok" and n["answers"])
    assert found["of_revision"] == 1
    # Massless beam with a mass at its end, loaded across: k = 3 E I / L^3.
    stiffness = 3 * 210e9 * DEPTH * THICKNESS**3 / 12 / LENGTH**3
    expected = (stiffness / MASS) ** 0.5 / (2 * 3.141592653589793)
    assert found["values"]["frequency 1"]["value"] == approx(expected, rel=1e-3)
    assert found["values"]["frequency 1"]["value"] == approx(
        float(fm.frequencies(session.builder().build())[0]), rel=1e-9
    )


@pytest.mark.slow
def test_a_wrong_field_is_told_at_its_address_and_the_last_good_answer_stays(opened):
    session, told = opened()
    ids = session.ask("edit", {"ops": cantilever()})["ids"]
    good = told.until(lambda n: n["answers"].get("status") == "ok" and n["answers"])
    session.ask("edit", {"ops": [{"op": "set", "address": f"{ids[1]}/width", "to": "2*q"}]})
    (problem, *_) = told.newest["document"]["problems"]
    assert problem["address"] == f"{ids[1]}/width"
    assert "q" in problem["message"]
    failed = told.until(lambda n: n["answers"].get("status") == "failed" and n["answers"])
    assert failed["stale"]
    assert failed["of_revision"] == good["of_revision"]
    assert failed["values"] == good["values"]
    with pytest.raises(fm.ModelError):
        session.builder()


@pytest.mark.slow
def test_a_refused_edit_changes_nothing(opened):
    session, told = opened()
    session.ask("edit", {"ops": cantilever()})
    before = told.newest["document"]
    with pytest.raises(ValueError, match="no thing"):
        session.ask(
            "edit", {"ops": [thing("node", "C", position=["0", "1"]), {"op": "set", "address": "99/x", "to": ""}]}
        )
    assert told.newest["document"] is before


@pytest.mark.slow
def test_a_json_file_is_saved_opened_and_undone(opened, tmp_path):
    session, told = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    assert told.newest["document"]["saved"] is False
    with pytest.raises(Refused, match="no file yet"):
        session.ask("save", {})
    path = tmp_path / "guide.json"
    assert session.ask("save", {"path": str(path)})["saved"]
    assert told.newest["document"]["saved"] is True
    assert told.newest["document"]["file"] == str(path)
    assert Document.from_data(json.loads(path.read_text())).data == session.history.document.data
    # Another file in its place is a step; undone, the first file is the one that is worked on.
    other = tmp_path / "other.json"
    other.write_text(Document.empty(3).text)
    session.ask("open", {"path": str(other)})
    assert told.newest["document"]["file"] == str(other)
    assert told.newest["document"]["document"]["dimension"] == 3
    session.ask("undo", {})
    assert told.newest["document"]["file"] == str(path)
    assert things(told)[0] == "steel"
    session.ask("redo", {})
    assert told.newest["document"]["file"] == str(other)


def test_saving_over_a_file_that_is_another_asks(opened, tmp_path):
    session, _ = opened()
    path = tmp_path / "there.json"
    path.write_text("mine")
    assert session.ask("save", {"path": str(path)}) == {"saved": False, "over": "there.json"}
    assert path.read_text() == "mine"
    assert session.ask("save", {"path": str(path), "over": True})["saved"]
    with pytest.raises(ValueError, match="saves"):
        session.ask("save", {"path": str(tmp_path / "guide.exe")})
    with pytest.raises(ValueError, match="opens"):
        session.ask("open", {"path": str(tmp_path / "guide.py")})


def test_a_text_from_the_page_is_opened(opened):
    session, told = opened()
    session.ask("open", {"name": "../guide.json", "text": Document.empty(3).text})
    assert told.newest["document"]["document"]["dimension"] == 3
    assert told.newest["document"]["file"] is None
    with pytest.raises(ValueError, match="no JSON"):
        session.ask("open", {"name": "guide.json", "text": "{"})
    with pytest.raises(Refused, match="path, or a text"):
        session.ask("open", {})


@pytest.mark.slow
def test_a_killed_process_comes_back(opened, tmp_path):
    session, told = opened(session_of_new())
    session.ask("edit", {"ops": cantilever(), "label": "all"})
    session.ask("edit", {"ops": [thing("node", "C", position=["0", "1"])], "label": "C"})
    session.ask("undo", {})
    before, revision = session.history.document.text, session.history.revision
    killed(session)
    again, told = opened(session_of_new())
    assert again.history.document.text == before
    assert again.history.revision == revision
    assert told.newest["document"]["undo"] == ["all"]
    assert told.newest["document"]["redo"] == ["C"]
    assert told.newest["file"]["recovered"]
    assert "1 unsaved step" in told.newest["file"]["summary"]
    # Text and all return on undo.
    again.ask("undo", {})
    assert again.history.document.data == Document.empty().data
    # Somebody wants none of it.
    again.ask("redo", {})
    again.ask("take_disk", {})
    assert things(told) == []
    assert not told.newest["file"].get("recovered")
    again.close()
    assert not list((tmp_path / "state").glob("*"))


@pytest.mark.slow
def test_a_killed_process_comes_back_with_its_file(opened, tmp_path):
    path = tmp_path / "guide.json"
    path.write_text(Document.empty().text)
    session, _ = opened(session_of_file(path))
    session.ask("edit", {"ops": cantilever()})
    with pytest.raises(TakenError, match=r"'guide.json' is already open in another workbench"):
        session_of_file(path)
    killed(session)
    again, told = opened(session_of_file(path))
    assert things(told)[0] == "steel"
    assert told.newest["document"]["file"] == str(path)
    assert told.newest["document"]["saved"] is False
    again.ask("save", {})
    killed(again)
    # What was saved is nothing to bring back.
    last, told = opened(session_of_file(path))
    assert "file" not in told.newest
    assert told.newest["document"]["undo"] == []
    assert things(told)[0] == "steel"
    # Saved under another name, it is found with that one.
    other = tmp_path / "other.json"
    last.ask("save", {"path": str(other)})
    last.ask("edit", {"ops": [thing("node", "C", position=["0", "1"])]})
    killed(last)
    _, told = opened(session_of_file(other))
    assert things(told)[-1] == "C"


def test_a_broken_journal_is_put_aside(opened, tmp_path):
    session, _ = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    journal = session.file.place.journal
    killed(session)
    journal.write_bytes(b"nothing of that kind")
    _, told = opened(session_of_new())
    assert things(told) == []
    assert journal.with_suffix(".unreadable").exists()


@pytest.mark.parametrize("damage", [b"\0", b'{"edit": [{"op": "none"}]}', b'{"document": 1}', b"[]"])
def test_a_journal_that_is_damaged_in_its_middle_is_kept_and_told(opened, damage):
    session, _ = opened(session_of_new())
    for name in "ABCD":
        session.ask("edit", {"ops": [thing("node", name, position=["0", "1"])]})
    journal = session.file.place.journal
    killed(session)
    # The third line is that of B.
    lines = journal.read_bytes().splitlines(keepends=True)
    lines[2] = damage + b"\n"
    journal.write_bytes(b"".join(lines))
    again, told = opened(session_of_new())
    assert things(told) == ["A"]
    (note,) = again.notes
    copy = journal.with_suffix(".unreadable")
    assert "damaged at line 3. 1 steps before it" in note
    assert f"3 lines are lost. The whole journal is kept as '{copy}'" in note
    assert copy.read_bytes() == b"".join(lines)
    # It goes on from there, and a second damage takes nothing of the first.
    again.ask("edit", {"ops": [thing("node", "E", position=["0", "1"])]})
    killed(again)
    journal.write_bytes(b"nothing of that kind\n")
    empty, told = opened(session_of_new())
    assert things(told) == []
    assert f"cannot be read. It is kept as '{copy}-1'" in empty.notes[0]
    assert copy.read_bytes() == b"".join(lines)


def test_what_is_no_regular_file_is_neither_opened_nor_written(opened, tmp_path):
    """A pipe would hold up every page, and /dev/zero fill the memory."""
    session, _ = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    for ending in (".dat", ".json"):
        for path in not_regular(tmp_path, ending):
            with pytest.raises(OSError, match="it is no regular file"):
                session.ask("open", {"path": str(path)})
            with pytest.raises(OSError, match="it is no regular file"):
                session.ask("save", {"path": str(path), "over": True, "anyway": True})
            assert open_file.content_digest(path) is None
    with (tmp_path / "large.json").open("wb") as file:
        file.truncate(LARGEST_FILE + 1)
    with pytest.raises(OSError, match=f"it has more than {LARGEST_FILE} bytes: '.*large.json'"):
        session.ask("open", {"path": str(tmp_path / "large.json")})
    # The study beside a file is one, too.
    os.mkfifo(tmp_path / "guide.toml")
    with pytest.raises(OSError, match=r"it is no regular file: '.*guide.toml'"):
        session.ask("save", {"path": str(tmp_path / "guide.dat"), "anyway": True})


def test_a_full_disk_is_told_with_the_name_of_the_file(opened, tmp_path):
    session, _ = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    with full(100), pytest.raises(Refused, match=r"'.*/guide.json( .[0-9]+ characters.)?': File too large."):
        guarded(session.ask, "save", {"path": str(tmp_path / "guide.json")})
    assert not list(tmp_path.glob("*guide*"))


def test_half_a_line_of_a_journal_is_left_out(opened):
    session, _ = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    before, journal = session.history.document.text, session.file.place.journal
    killed(session)
    with journal.open("a") as file:
        file.write('{"edit": [{"op": "add", "thing": {"call": "no')
    again, _ = opened(session_of_new())
    assert again.history.document.text == before


def test_a_request_that_a_killed_process_did_is_not_done_again(opened):
    session, _ = opened(session_of_new())
    reply = session.ask("edit", {"ops": cantilever()}, "page/5")
    killed(session)
    again, told = opened(session_of_new())
    assert again.ask("edit", {"ops": cantilever()}, "page/5") == reply
    assert len(things(told)) == 7


def test_a_file_that_another_program_changes_is_offered(opened, tmp_path, monkeypatch):
    # Files are looked at five times as often as for users.
    monkeypatch.setattr(open_file, "PERIOD", open_file.PERIOD / 5)
    path = tmp_path / "guide.json"
    path.write_text(Document.empty().text)
    session, told = opened(session_of_file(path))
    session.ask("edit", {"ops": cantilever()})
    data = Document.empty().data
    path.write_text(Document.from_data({**data, "names": {"w": {"value": "1"}}}).text)
    found = told.until(lambda n: n["file"], 3)
    assert found["changed"]
    assert found["name"] == "guide.json"
    assert "7 things and the names" in found["summary"]
    # Nothing is written over it unasked.
    with pytest.raises(ValueError, match="program has changed"):
        session.ask("save", {})
    assert "w" in path.read_text()
    session.ask("take_disk", {})
    assert told.newest["document"]["values"] == {"w": 1}
    assert told.newest["file"]["changed"] is False
    assert told.newest["document"]["saved"] is True
    session.ask("undo", {})
    assert len(things(told)) == 7
    # Kept, and then saved over the next one.
    path.write_text(Document.from_data({**data, "names": {"v": {"value": "1"}}}).text)
    told.until(lambda n: n["file"].get("changed"), 3)
    session.ask("keep_disk", {})
    assert told.newest["file"]["changed"] is False
    assert session.ask("save", {})["saved"]
    assert len(json.loads(path.read_text())["things"]) == 7


def test_a_file_that_comes_to_hold_what_is_here_is_no_news(opened, tmp_path, monkeypatch):
    monkeypatch.setattr(open_file, "PERIOD", open_file.PERIOD / 5)
    path = tmp_path / "guide.json"
    path.write_text(Document.empty().text)
    session, told = opened(session_of_file(path))
    session.ask("edit", {"ops": cantilever()})
    path.write_text(session.history.document.text)
    told.until(lambda n: n["document"].get("saved"), 3)
    assert "file" not in told.newest


def test_a_name_that_a_search_leaves_as_it_was_has_its_value_again():
    document, written = planar_guide(), []
    job = VisibleJob(Job("1", "target", lambda message: None), document, written.append)
    job.tell(design={"t": 0.6e-3, "L": 0.12})
    job.end([{"op": "name", "name": "L", "to": {"value": "0.11"}}])
    assert {op["name"]: op["to"]["value"] for op in written[0]} == {"t": "0.0006", "L": "0.12"}
    assert {op["name"]: op["to"] for op in written[1]} == {"t": document.names["t"], "L": {"value": "0.11"}}
    written.clear()
    # What no page has seen needs no return.
    VisibleJob(Job("1", "target", lambda message: None), document, written.append).end([])
    assert not written


@pytest.mark.slow
def test_a_target_is_one_step_that_is_seen_as_it_goes(opened):
    session, told = opened()
    session.ask("edit", {"ops": cantilever(), "label": "all"})
    text = session.history.document.text
    told.until(lambda n: n["answers"].get("status") == "ok")
    wants = [{"answer": "frequency 1", "kind": "equal", "value": "20"}]
    job = session.ask("target", {"wants": wants, "free": ["t"]})["job"]
    found = told.until(lambda n: n["job"].get("status") == "done" and n["job"])
    assert found["job"] == job
    assert found["met"]
    assert len(told.newest["document"]["undo"]) == 2
    told.until(lambda n: n["answers"].get("of_revision") == session.history.revision)
    assert told.newest["answers"]["values"]["frequency 1"]["value"] == approx(20, rel=1e-9)
    session.ask("undo", {})
    assert session.history.document.text == text
    # What cannot be is told, and changes nothing.
    session.ask("target", {"wants": [{"answer": "farce", "kind": "equal", "value": "20"}], "free": ["t"]})
    failed = told.until(lambda n: n["job"].get("status") == "failed" and n["job"])
    assert "farce" in failed["text"]
    assert session.history.document.text == text


@pytest.mark.slow
def test_a_fit_tells_its_values_and_leaves_the_document(opened):
    session, told = opened()
    session.ask("edit", {"ops": cantilever()})
    text = session.history.document.text
    told.until(lambda n: n["answers"].get("status") == "ok")
    now = told.newest["answers"]["values"]["frequency 1"]["value"]
    table = f"answer,value,deviation\nfrequency 1,{1.1 * now},{0.01 * now}\n"
    session.ask("fit", {"text": table, "name": "shaker.csv", "free": ["t"]})
    found = told.until(lambda n: n["job"].get("status") == "done" and n["job"])
    assert (found["kind"], found["title"]) == ("fit", "Fit to shaker.csv")
    assert session.history.document.text == text
    session.ask("edit", {"ops": found["ops"], "label": found["title"]})
    told.until(lambda n: n["answers"].get("of_revision") == session.history.revision)
    assert told.newest["answers"]["values"]["frequency 1"]["value"] == approx(1.1 * now, rel=1e-5)


def test_a_pinned_design_is_compared(opened):
    session, told = opened()
    session.ask("edit", {"ops": cantilever()})
    session.ask("pin", {})
    told.until(lambda n: n["pinned"])
    session.ask("edit", {"ops": [{"op": "name", "name": "t", "to": {"value": "1e-3"}}]})
    found = told.until(lambda n: n["pinned"]["differences"]["names"] and n["pinned"]["differences"])
    (name,) = found["names"]
    assert [name["before"], name["now"]] == ["0.5e-3", "1e-3"]
    one = next(one for one in found["answers"] if one["key"] == "frequency 1")
    # Bending stiffness goes as the third power of the thickness, the mass stays.
    assert one["now"] / one["before"] == approx(2**1.5, rel=1e-2)
    session.ask("unpin", {})
    assert set(told.newest["pinned"]) == {"tell"}


def test_advice_is_applied_and_old_advice_is_refused(opened):
    session, told = opened()
    session.ask("edit", {"ops": [*cantilever(), thing("dof", of="B", components="y")]})
    count = told.until(lambda n: n["count"].get("advice") and session.live.wait(60) and n["count"])
    assert session.ask("advise", {"index": 0})["label"] == count["advice"][0]["text"]
    with pytest.raises(Refused, match="changed since"):
        session.ask("advise", {"index": 99})


def test_wants_are_checked(opened):
    session, _ = opened()
    session.ask("want", {"mode": 1})
    with pytest.raises(ValueError, match="no question 'nonsense'"):
        session.ask("want", {"nonsense": 1})
    assert session.wants.mode == 1


def test_edits_are_taken_while_something_is_computed(opened):
    session, told = opened()
    session.ask("edit", {"ops": cantilever()})
    for k in range(50):
        session.ask("edit", {"ops": [{"op": "name", "name": "t", "to": {"value": f"{k + 1}e-4"}}], "merge": "slider"})
    assert session.live.wait(60)
    answers = [one for one in told.all if one["tell"] == "answers" and one["status"] == "ok"]
    # The newest wins, and no more is computed than was asked.
    assert answers[-1]["of_revision"] == session.history.revision == 51
    assert len(answers) <= 52
    assert len(told.newest["document"]["undo"]) == 2


def test_a_path_of_a_home_is_understood(opened, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    session, _ = opened()
    assert session.ask("save", {"path": "~/guide.json"})["file"] == str(tmp_path / "guide.json")
    assert Path(tmp_path / "guide.json").exists()


@pytest.mark.slow
def test_a_journal_that_cannot_be_written_refuses_the_edit(opened, monkeypatch):
    session, told = opened(session_of_new())
    session.ask("edit", {"ops": cantilever()})
    before = session.history.document

    def full(_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("flexmb.workbench.undo.os.fsync", full)
        with pytest.raises(ValueError, match="Nothing is changed: the journal"):
            session.ask("edit", {"ops": [thing("node", "C", position=["0", "1"])]})
    assert session.history.document is before
    session.ask("edit", {"ops": [thing("node", "D", position=["0", "1"])]})
    killed(session)
    _, told = opened(session_of_new())
    assert things(told)[-1] == "D"
    assert "C" not in things(told)


@pytest.mark.slow
def test_a_file_that_an_undone_step_brings_back_is_watched_again(opened, tmp_path):
    paths = [tmp_path / "one.json", tmp_path / "two.json"]
    for path in paths:
        path.write_text(Document.empty().text)
    session, told = opened(session_of_file(paths[0]))
    session.ask("open", {"path": str(paths[1])})
    # Changed while another file was open: known after all.
    paths[0].write_text(Document.empty(3).text)
    session.ask("undo", {})
    assert told.newest["document"]["file"] == str(paths[0])
    with pytest.raises(ValueError, match="program has changed"):
        session.ask("save", {})
