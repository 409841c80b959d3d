"""Undo and redo of all edits of a session, and a journal that restores a killed session, with its place.

No other user can read these files.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import http.client
import itertools
import json
import os
import shutil
import time
from pathlib import Path
from typing import Any, NamedTuple

try:
    import fcntl
except ImportError:  # Systems without such locks offer all journals.
    fcntl = None

from ..files import naming, write_whole
from .document import Document, EditError, Report, apply

# Number of remembered requests: a request that is sent again is done once.
MOST_REQUESTS = 1000
# Faults of a damaged line of a journal.
UNREADABLE = (EditError, ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError)


class _Step(NamedTuple):
    """One step: its label, the document before it, and the file before it if the step changed the file."""

    label: str
    before: Document
    merge: str | None
    file: tuple[str | None] | None = None


class History:
    """A document and its edits.

    Attributes:
        document: Present document.
        revision: Number of changes, including undone and redone ones.
        file: Path of the document's file, or None.
        saved: The document in its file, or None.
        requests: Results of the last requests by their keys: a report of edits, or a label.
        damage: What could not be recovered from the journal, in words.
    """

    def __init__(
        self, document: Document | None = None, journal: str | os.PathLike | None = None, *, file: str | None = None
    ):
        """Begin a history, with a journal if a path is given: each edit is in the journal before it is answered."""
        self.document = document or Document.empty()
        self.revision = 0
        self.file = file
        self.saved: Document | None = self.document
        self.requests: dict[str, Report | str | None] = {}
        self.damage = ""
        self._back: list[_Step] = []
        self._forth: list[_Step] = []
        self._file = None
        if journal is not None:
            self._open(Path(journal), "x")
            self._write({"document": self.document.data, "file": file})

    @property
    def undo_labels(self) -> list[str]:
        """Labels of steps to undo, the last first."""
        return [step.label for step in reversed(self._back)]

    @property
    def redo_labels(self) -> list[str]:
        """Labels of steps to redo, the next first."""
        return [step.label for step in reversed(self._forth)]

    @property
    def is_saved(self) -> bool:
        """Whether a file contains the document, or there was nothing to save so far."""
        return self.document is self.saved or (self.saved is not None and self.document.data == self.saved.data)

    def edit(self, ops: Any, label: str | None = None, merge: str | None = None, key: str | None = None) -> Report:
        """Edit the document as one step, with a label; edits with equal ``merge`` keys in a row are one step."""
        document, report = apply(self.document, ops)
        report = report._replace(label=label or report.label)
        self._write({"edit": ops, "label": report.label, "merge": merge, "key": key})
        self._take(document, report.label, merge)
        self._remember(key, report)
        return report

    def replace(self, document: Document, label: str, file: str | None = None, key: str | None = None) -> None:
        """Replace the document by one that counts as saved in a file, as one step."""
        self._write({"document": document.data, "label": label, "file": file, "key": key})
        self._take(document, label, None)
        self._back[-1] = self._back[-1]._replace(file=(self.file,))
        self.file, self.saved = file, document
        self._remember(key, label)

    def undo(self, key: str | None = None) -> str | None:
        """Go one step back; its label, or None if there is none."""
        return self._go(self._back, self._forth, "undo", key)

    def redo(self, key: str | None = None) -> str | None:
        """Redo the last undone step; its label, or None if there is none."""
        return self._go(self._forth, self._back, "redo", key)

    def mark_saved(self, file: str | None) -> None:
        """Note that a file contains the present document."""
        self._write({"saved": True, "file": file})
        self.file, self.saved = file, self.document

    def part(self) -> None:
        """End a step: the next edit is another one, whatever its key."""
        if self._back and self._back[-1].merge is not None:
            self._write({"part": True})
            self._back[-1] = self._back[-1]._replace(merge=None)

    def close(self, *, keep: bool = False) -> None:
        """End the journal."""
        if self._file is not None:
            self._file.close()
            if not keep:
                Path(self._file.name).unlink(missing_ok=True)
            self._file = None

    def move_journal(self, path: Path) -> None:
        """Continue in another file, which is replaced if it exists."""
        if self._file is not None:
            old = Path(self._file.name)
            self._file.close()
            os.replace(old, path)
            self._open(path, "a")

    def _take(self, document: Document, label: str, merge: str | None) -> None:
        if merge is None or not self._back or self._back[-1].merge != merge or self._forth:
            self._back.append(_Step(label, self.document, merge))
        self._forth.clear()
        self.document = document
        self.revision += 1

    def _go(self, source: list[_Step], other: list[_Step], direction: str, key: str | None) -> str | None:
        if not source:
            return None
        self._write({direction: True, "key": key})
        step = source.pop()
        other.append(_Step(step.label, self.document, None, step.file and (self.file,)))
        self.document = step.before
        self.file = step.file[0] if step.file else self.file
        self.revision += 1
        self._remember(key, step.label)
        return step.label

    def _remember(self, key: str | None, report: Report | str | None) -> None:
        if key is not None:
            self.requests[key] = report
            while len(self.requests) > MOST_REQUESTS:
                del self.requests[next(iter(self.requests))]

    def _replay(self, line: dict[str, Any]) -> None:
        """Repeat a line of a journal."""
        if "edit" in line:
            self.edit(line["edit"], line.get("label"), line.get("merge"), line.get("key"))
        elif "document" in line:
            document = Document.from_data(line["document"])
            self.replace(document, line.get("label", ""), line.get("file"), line.get("key"))
        elif "undo" in line:
            self.undo(line.get("key"))
        elif "redo" in line:
            self.redo(line.get("key"))
        elif "saved" in line:
            self.mark_saved(line.get("file"))
        elif "part" in line:
            self.part()

    def _open(self, path: Path, mode: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        # Only its user can read it.
        self._file = open(path, f"{mode}b", buffering=0, opener=lambda name, flags: os.open(name, flags, 0o600))
        # Locked for the life of the process, if the system can.
        if fcntl is not None:
            with contextlib.suppress(OSError):
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _write(self, line: dict[str, Any]) -> None:
        """Write a line of the journal to the disk, before anything else is done."""
        if self._file is None:
            return
        content = json.dumps(line, ensure_ascii=False).encode() + b"\n"
        end = self._file.tell()
        try:
            if self._file.write(content) < len(content):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._file.fileno())
        except OSError as fault:
            # Half a line would hide the lines after it.
            with contextlib.suppress(OSError):
                self._file.truncate(end)
                self._file.seek(end)
            why = fault.strerror or fault
            message = f"Nothing is changed: the journal '{self._file.name}' cannot be written: {why}."
            raise EditError("", message) from None


def recover(path: str | os.PathLike) -> History:
    """The history of a journal, which continues in the same file.

    An unfinished last line is left out: its edit was never answered. If another line is damaged, the steps before it
    are recovered, and a copy of the journal stays beside it.
    """
    path = Path(path)
    history, valid_bytes, count = None, 0, 0
    content = path.read_bytes()
    for raw in content.splitlines(keepends=True):
        try:
            line = json.loads(raw) if raw.endswith(b"\n") else {}
            if history is None:
                history = History(Document.from_data(line["document"]), file=line.get("file"))
            elif line:
                history._replay(line)
            else:
                break
        except UNREADABLE:
            break
        valid_bytes, count = valid_bytes + len(raw), count + 1
    if history is None:
        raise EditError("", f"'{path}' is no journal of the workbench.")
    if lost := content[valid_bytes:].count(b"\n"):
        copy = unreadable(path)
        with naming(copy):
            shutil.copyfile(path, copy)
            copy.chmod(0o600)
        history.damage = (
            f"The journal of this mechanism is damaged at line {count + 1}. {len(history.undo_labels)} steps before it"
            f" are recovered. {lost} lines are lost. The whole journal is kept as '{copy}'."
        )
    with open(path, "r+b") as file:
        file.truncate(valid_bytes)
    history._open(path, "a")
    return history


def unreadable(path: Path) -> Path:
    """An unused file name beside a journal, for what cannot be read."""
    names = (path.with_suffix(f".unreadable{f'-{k}' if k else ''}") for k in itertools.count())
    return next(name for name in names if not name.exists())


def journals(folder: Path) -> list[Path]:
    """Journals that ended processes left behind, the newest first."""
    paths = sorted(folder.glob("*.jsonl"), key=lambda path: path.stat().st_mtime, reverse=True)
    return [path for path in paths if not is_locked(path)]


def new_journal(folder: str | os.PathLike) -> Path:
    """An unused file name for a journal."""
    stamp = time.strftime("%Y%m%d-%H%M%S")
    names = (f"{stamp}-{os.getpid()}{f'-{k}' if k else ''}.jsonl" for k in itertools.count())
    return next(path for name in names if not (path := Path(folder) / name).exists())


def journal_folder() -> Path:
    """Folder of journals: ``$FLEXMB_STATE``, or flexmb/workbench in the folder of states or in ``$FLEXMB_CACHE``."""
    if known := os.environ.get("FLEXMB_STATE"):
        folder = Path(known)
    elif known := os.environ.get("FLEXMB_CACHE"):
        folder = Path(known) / "workbench"
    else:
        folder = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "flexmb" / "workbench"
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder


def is_locked(path: Path) -> bool:
    """Whether a running process writes a journal."""
    if fcntl is None:
        return False
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return True
        fcntl.flock(file, fcntl.LOCK_UN)
        return False


class Storage(NamedTuple):
    """The journal of one workbench."""

    journal: Path

    def known(self) -> dict[str, Any]:
        """Data of the last workbench here: "port" and "token"; empty if there was none."""
        with contextlib.suppress(OSError, ValueError):
            data = json.loads(self._about.read_text(encoding="utf-8"))
            if isinstance(data, dict) and isinstance(data.get("port"), int) and isinstance(data.get("token"), str):
                return data
        return {}

    def take(self, port: int, token: str) -> None:
        """Write the address of this process. A later one takes over port and token, and open pages find it."""
        write_whole(self._about, json.dumps({"port": port, "token": token}).encode())
        self._about.chmod(0o600)

    def leave(self) -> None:
        """Remove the address: there is nothing to continue with."""
        self._about.unlink(missing_ok=True)

    def is_taken(self) -> bool:
        """Whether another process works here."""
        return self.journal.exists() and is_locked(self.journal)

    def address(self) -> str | None:
        """Address of the workbench that answers here, or None."""
        known = self.known()
        if not known:
            return None
        path = f"/{known['token']}/"
        connection = http.client.HTTPConnection("127.0.0.1", known["port"], timeout=2)
        try:
            connection.request("GET", path)
            is_answering = connection.getresponse().status == 200
        except (OSError, ValueError, http.client.HTTPException):
            is_answering = False
        finally:
            connection.close()
        return f"http://127.0.0.1:{known['port']}{path}" if is_answering else None

    @property
    def _about(self) -> Path:
        return self.journal.with_suffix(".json")


def file_place(file: Path) -> Storage:
    """Place of a file."""
    path = os.path.realpath(file)
    return Storage(journal_folder() / f"file-{hashlib.sha256(os.fsencode(path)).hexdigest()[:16]}.jsonl")


def unsaved_storage() -> Storage | None:
    """Place of the last new mechanism that was never saved, or None."""
    paths = (path for path in journals(journal_folder()) if path.name[:1].isdigit())
    return next(map(Storage, paths), None)


def new_place() -> Storage:
    """Place of a new mechanism."""
    return Storage(new_journal(journal_folder()))
