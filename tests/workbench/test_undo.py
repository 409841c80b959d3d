"""Histories: undone, done again, and recovered from the journal of a process that was killed."""

import os
import signal
import subprocess
import sys
import time

import pytest

from flexmb.workbench.document import Document, EditError
from flexmb.workbench.undo import History, journals, new_journal, recover


def node(x="0"):
    return [{"op": "add", "thing": {"call": "node", "args": {"position": [x, "0"]}}}]


def to(x):
    return [{"op": "set", "address": "1/position/0", "to": x}]


def test_a_drag_is_one_step_and_a_new_edit_ends_what_could_be_redone():
    history = History()
    history.edit(node(), label="a node")
    for k in range(5):
        history.edit(to(str(k)), merge="drag 1")
    assert history.undo_labels == ["A: position", "a node"]
    assert history.revision == 6
    assert history.undo() == "A: position"
    assert history.document.things[0]["args"]["position"] == ["0", "0"]
    assert history.redo_labels == ["A: position"]
    history.edit(to("7"), merge="drag 1")
    assert history.redo() is None
    assert history.undo_labels == ["A: position", "a node"]


def test_a_drag_that_was_parted_is_two_steps():
    history = History()
    history.edit(node())
    history.edit(to("1"), merge="drag")
    history.part()
    history.edit(to("2"), merge="drag")
    history.undo()
    assert history.document.things[0]["args"]["position"] == ["1", "0"]


def test_what_cannot_be_is_neither_done_nor_journalled(tmp_path):
    history = History(journal=tmp_path / "j.jsonl")
    with pytest.raises(EditError):
        history.edit([{"op": "set", "address": "9/mass", "to": "1"}])
    assert (history.revision, history.undo_labels) == (0, [])
    assert len((tmp_path / "j.jsonl").read_text().splitlines()) == 1
    history.close()


def test_a_history_comes_back_from_its_journal_with_its_steps(tmp_path):
    path = new_journal(tmp_path)
    history = History(Document.empty(3), journal=path)
    history.edit(node(), label="<b>")
    history.edit(to("1"), merge="drag")
    history.edit(to("2"), merge="drag")
    history.undo()
    history.redo()
    history.replace(Document.empty(2), "open")
    history.undo()
    history.close(keep=True)
    with open(path, "ab") as file:
        file.write(b'{"edit": [{"op"')
    again = recover(path)
    assert again.document.text == history.document.text
    assert (again.undo_labels, again.redo_labels) == (history.undo_labels, history.redo_labels)
    assert again.revision == history.revision
    again.edit(to("3"))
    again.close(keep=True)
    third = recover(path)
    assert third.document.text == again.document.text
    third.close()
    assert not path.exists()


def test_what_is_no_journal_is_told(tmp_path):
    (tmp_path / "j.jsonl").write_text("nothing\n")
    with pytest.raises(EditError, match="no journal"):
        recover(tmp_path / "j.jsonl")


@pytest.mark.slow
def test_a_killed_process_leaves_its_journal_and_a_living_one_is_not_offered(tmp_path):
    code = (
        "import sys, time\n"
        "from flexmb.workbench.undo import History, new_journal\n"
        f"history = History(journal=new_journal({str(tmp_path)!r}))\n"
        "history.edit([{'op': 'add', 'thing': {'call': 'node', 'args': {'position': ['0', '0']}}}])\n"
        "for k in range(1000000):\n"
        "    history.edit([{'op': 'set', 'address': '1/position/0', 'to': str(k)}])\n"
        "    print(k, flush=True)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        lines = [process.stdout.readline() for _ in range(20)]
        assert lines[-1].strip() == "19"
        if os.name == "posix":
            assert journals(tmp_path) == []
        process.send_signal(signal.SIGKILL)
        told = process.stdout.read().split()
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    deadline = time.time() + 10
    while not journals(tmp_path) and time.time() < deadline:
        time.sleep(0.05)
    (path,) = journals(tmp_path)
    history = recover(path)
    last = int(history.document.things[0]["args"]["position"][0])
    # What was answered is there; one edit more may have been written but not answered.
    assert last - int(told[-1] if told else lines[-1]) in (0, 1)
    assert len(history.undo_labels) == last + 2
    history.close()
    assert journals(tmp_path) == []
