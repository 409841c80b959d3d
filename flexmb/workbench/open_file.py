"""The file of a session: opened, saved, changed by another program, and found again with its journal."""

from __future__ import annotations

import contextlib
import hashlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..display import counted
from ..errors import printable
from ..files import read_whole
from .document import Document
from .filing import difference, files_of, opened, received, write_document
from .undo import History, Storage, file_place

# Time between two looks at the file [s].
PERIOD = 0.5

Tell = Callable[[dict[str, Any]], None]


class ChangedError(ValueError):
    """Another program has changed the file."""


class OpenFile:
    """The file of a history, and the place of its journal.

    Attributes:
        recovered: Whether the document came from a journal, and nobody has kept or saved it yet.
        settled: Called when the document equals its file again without an edit.
    """

    def __init__(self, history: History, place: Storage | None, tell: Tell, lock: threading.RLock):
        """Watch nothing yet; :meth:`know` begins."""
        self.history = history
        self.place = place
        self.recovered = False
        self._tell, self._lock = tell, lock
        self._answers_at: tuple[int, str] | None = None
        self._watch = Watch(self._changed_on_disk)
        self.settled: Callable[[], None] = lambda: None

    @property
    def path(self) -> Path | None:
        """Path of the file, or None."""
        return None if self.history.file is None else Path(self.history.file)

    def know(self) -> None:
        """Take the present content of the file as known."""
        self._watch.know(*files_of(self.path))

    def follow(self) -> None:
        """Watch the present file, which an undone step may have changed."""
        self._watch.look(*files_of(self.path))

    def begin(self) -> None:
        """Report edits that came from a journal."""
        if self.recovered:
            summary = f"{counted(len(self.history.undo_labels), 'unsaved step')} recovered."
            name = "the new mechanism" if self.path is None else self.path.name
            self._tell({"tell": "file", "changed": False, "recovered": True, "name": name, "summary": summary})

    def answers_at(self, port: int, token: str) -> None:
        """Write where pages find this session, now and after a restart."""
        self._answers_at = port, token
        if self.place is not None:
            self.place.take(port, token)

    def open(self, path: Path, key: str | None) -> list[str]:
        """Replace the document by a file, as one step; notes about it."""
        document, notes = opened(path)
        self._take(document, path, f"Open {printable(path.name)}", key)
        return notes

    def receive(self, name: str, text: str, key: str | None) -> list[str]:
        """Replace the document by a text, as one step; notes about it."""
        document, notes = received(name, text)
        self._take(document, None, f"Open {printable(name)}", key)
        return notes

    def take(self, key: str | None) -> list[str]:
        """Replace the document by the file, or by an empty one without a file, as one step; notes about it."""
        path = self.path
        document, notes = opened(path) if path else (Document.empty(self.history.document.dimension), [])
        self._take(document, path, f"Take {printable(path.name)} from the disk" if path else "Begin anew", key)
        self._settle()
        return notes

    def keep(self) -> None:
        """Keep the document; the next save overwrites the change of another program."""
        if not self.recovered:
            self.history.saved = None
        self.know()
        self._settle()

    def save(self, path: Path) -> list[str]:
        """Write the document; a file that can be opened again becomes the file of the document."""
        if path == self.path and (changed := self._watch.differs()):
            self._changed_on_disk(changed[0])
            name = printable(path.name)
            raise ChangedError(f"Another program has changed '{name}'. Choose which content stays, and save again.")
        notes = write_document(self.history.document, path)
        if path.suffix != ".py":
            self.history.mark_saved(str(path))
            self.know()
            self._move_to(path)
            self._settle()
        return notes

    def close(self, keep: bool | None) -> None:
        """End the watch and the journal."""
        self._watch.close()
        with self._lock:
            keep = not self.history.is_saved if keep is None else keep
            self.history.close(keep=keep)
            if self.place is not None and not keep and self.path is None:
                self.place.leave()

    def _take(self, document: Document, path: Path | None, label: str, key: str | None) -> None:
        self.history.replace(document, label, None if path is None else str(path), key)
        self.know()
        if path is not None:
            self._move_to(path)

    def _move_to(self, path: Path) -> None:
        """Move the journal to the place of another file."""
        place = file_place(path)
        if self.place is None or place == self.place or place.is_taken():
            return
        old, self.place = self.place, place
        self.history.move_journal(place.journal)
        old.leave()
        if self._answers_at is not None:
            place.take(*self._answers_at)

    def _changed_on_disk(self, path: Path) -> None:
        """Offer the change of another program if it builds another mechanism."""
        with self._lock:
            path_here = self.path
            if path_here is None or path not in files_of(path_here):
                return
            try:
                summary = difference(self.history.document, opened(path_here)[0])
            except (OSError, ValueError) as fault:
                summary = f"The file cannot be opened now: {fault}"
            if summary:
                self._tell({"tell": "file", "changed": True, "name": path.name, "summary": summary})
                return
            self.know()
            self.history.mark_saved(str(path_here))
            self.settled()

    def _settle(self) -> None:
        self.recovered = False
        self._tell({"tell": "file", "changed": False})


class Watch:
    """Watches files, and calls ``changed(file)`` in a thread once for each new content.

    A file counts once it has stayed the same from one look to the next: an editor may be writing it.
    """

    def __init__(self, changed: Callable[[Path], None]):
        self._changed = changed
        self._known: dict[Path, str | None] = {}
        self._watched: tuple[Path, ...] = ()
        self._seen: dict[Path, tuple[int, int] | None] = {}
        self._read: dict[Path, tuple[int, int] | None] = {}
        self._told: dict[Path, str | None] = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="flexmb watch", daemon=True)

    def know(self, *paths: Path) -> None:
        """Watch only these files, with their present contents as known."""
        with self._lock:
            for path in paths:
                self._known.pop(path, None)
        self.look(*paths)

    def look(self, *paths: Path) -> None:
        """Watch only these files; contents that were known stay known."""
        with self._lock:
            for path in paths:
                if path not in self._known:
                    self._known[path] = content_digest(path)
            self._watched = paths
            self._seen, self._read, self._told = {}, {}, {}
        if not self._thread.is_alive() and not self._ended.is_set() and paths:
            self._thread.start()

    def differs(self) -> list[Path]:
        """Files whose contents are not known."""
        with self._lock:
            known = {path: self._known[path] for path in self._watched}
        return [path for path, content in known.items() if content_digest(path) != content]

    def close(self) -> None:
        """End the watch; a second call does nothing."""
        self._ended.set()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        while not self._ended.wait(PERIOD):
            with self._lock:
                paths = self._watched
            for path in paths:
                if self._is_new(path):
                    self._changed(path)

    def _is_new(self, path: Path) -> bool:
        """Whether a file is at rest with a content that is neither known nor reported."""
        look = _look(path)
        with self._lock:
            at_rest = look == self._seen.get(path, "not looked at yet") and look != self._read.get(path, "not read yet")
            self._seen[path] = look
        if not at_rest:
            return False
        content = content_digest(path)
        with self._lock:
            if path not in self._watched:
                return False
            last = self._told.get(path, self._known[path])
            self._read[path], self._told[path] = look, content
        return content not in (last, self._known[path])


def content_digest(path: Path) -> str | None:
    """Digest of a file's content, or None."""
    with contextlib.suppress(OSError):
        return hashlib.sha256(read_whole(path)).hexdigest()
    return None


def _look(path: Path) -> tuple[int, int] | None:
    with contextlib.suppress(OSError):
        state = path.stat()
        return state.st_mtime_ns, state.st_size
    return None
