"""The file that a session works on: opened, saved, changed by another program, found again with its journal."""

from __future__ import annotations

import contextlib
import hashlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import clean
from ..files import read_whole
from .document import Document
from .filing import Opened, difference, files_of, opened, received, write
from .places import Storage, place_of
from .undo import History

# Between two looks [s].
PERIOD = 0.5

Tell = Callable[[dict[str, Any]], None]


class ChangedError(ValueError):
    """Another program has changed the file that is to be written."""


class OpenFile:
    """The file of a history, and the place of its journal.

    Attributes:
        history: The document, whose ``file`` it is.
        place: Where the journal stands, and how it is found; None without a journal.
        recovered: Whether what is here came back from a journal, and nobody has said yet that it shall stay.
    """

    def __init__(self, history: History, place: Storage | None, tell: Tell, lock: threading.RLock):
        """Watch nothing yet: see :meth:`know`."""
        self.history = history
        self.place = place
        self.recovered = False
        self._tell, self._lock = tell, lock
        self._answers_at: tuple[int, str] | None = None
        self._watch = Watch(self._changed_on_disk)
        # What is told where the document is as its file again, without an edit.
        self.settled: Callable[[], None] = lambda: None

    @property
    def path(self) -> Path | None:
        """The file; None where there is none yet."""
        return None if self.history.file is None else Path(self.history.file)

    def know(self) -> None:
        """Take what the file holds now as what was read."""
        self._watch.know(*files_of(self.path))

    def follow(self) -> None:
        """Look at the file of now, which an undone step may have changed."""
        self._watch.look(*files_of(self.path))

    def begin(self) -> None:
        """Say what came back from a journal."""
        if self.recovered:
            count = len(self.history.undo_labels)
            summary = f"{count} {'step' if count == 1 else 'steps'} that nobody saved came back."
            name = "the new mechanism" if self.path is None else self.path.name
            self._tell({"tell": "file", "changed": False, "recovered": True, "name": name, "summary": summary})

    def answers_at(self, port: int, token: str) -> None:
        """Say where pages find this session, now and after it was started again."""
        self._answers_at = port, token
        if self.place is not None:
            self.place.take(port, token)

    def open(self, path: Path, key: str | None) -> list[str]:
        """Put the document of a file in the place of this one, as a step; what is to be said about it."""
        found = opened(path)
        self._take(found, path, f"Open {clean(path.name)}", key)
        return found.notes

    def receive(self, name: str, text: str, key: str | None) -> list[str]:
        """Put the document of a text in the place of this one, as a step; what is to be said about it."""
        found = received(name, text)
        self._take(found, None, f"Open {clean(name)}", key)
        return found.notes

    def take(self, key: str | None) -> list[str]:
        """Put what the file holds now in the place of this document, or nothing where there is no file, as a step."""
        path = self.path
        if path is None:
            empty = Document.empty(self.history.document.dimension)
            self._take(Opened(empty, []), None, "Begin anew", key)
            notes = []
        else:
            found = opened(path)
            self._take(found, path, f"Take {clean(path.name)} from the disk", key)
            notes = found.notes
        self._settle()
        return notes

    def keep(self) -> None:
        """Keep what is here: the next save writes over what another program has written."""
        if not self.recovered:
            self.history.saved = None
        self.know()
        self._settle()

    def save(self, path: Path) -> list[str]:
        """Write the document; the file is its own from then on, unless that cannot be opened again.

        Raises:
            ChangedError: Another program has changed it since it was read.
            OSError: It cannot be written.
            ValueError: It ends otherwise, or cannot hold the document.
        """
        if path == self.path and (changed := self._watch.differs()):
            self._changed_on_disk(changed[0])
            raise ChangedError(
                f"'{clean(path.name)}' was changed by another program: say which is to stay, and save again."
            )
        notes = write(self.history.document, path)
        if path.suffix != ".py":
            self.history.mark_saved(str(path))
            self.know()
            self._move_to(path)
            self._settle()
        return notes

    def close(self, keep: bool | None) -> None:
        """End watching and journal."""
        self._watch.close()
        with self._lock:
            keep = not self.history.is_saved if keep is None else keep
            self.history.close(keep=keep)
            if self.place is not None and not keep and self.path is None:
                self.place.leave()

    def _take(self, found: Opened, path: Path | None, label: str, key: str | None) -> None:
        self.history.replace(found.document, label, None if path is None else str(path), key)
        self.know()
        if path is not None:
            self._move_to(path)

    def _move_to(self, path: Path) -> None:
        """Take the journal to the place of another file, so that it is found with that."""
        place = place_of(path)
        if self.place is None or place == self.place or place.is_taken():
            return
        old, self.place = self.place, place
        self.history.move_journal(place.journal)
        old.leave()
        if self._answers_at is not None:
            place.take(*self._answers_at)

    def _changed_on_disk(self, path: Path) -> None:
        """Offer what another program has written, where it builds something else."""
        with self._lock:
            own = self.path
            if own is None or path not in files_of(own):
                return
            try:
                summary = difference(self.history.document, opened(own).document)
            except (OSError, ValueError) as fault:
                summary = f"It cannot be opened as it is now: {fault}"
            if summary:
                self._tell({"tell": "file", "changed": True, "name": path.name, "summary": summary})
                return
            self.know()
            self.history.mark_saved(str(own))
            self.settled()

    def _settle(self) -> None:
        self.recovered = False
        self._tell({"tell": "file", "changed": False})


class Watch:
    """Looks at files, and says when one holds something else than what was last read or written here.

    A file is looked at until it has stayed the same from one look to the next: an editor may be writing it.

    Args:
        changed: Called with the file, in a thread; once for every new content.
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
        """Watch these files and no others, and take what they hold now as known."""
        with self._lock:
            for path in paths:
                self._known.pop(path, None)
        self.look(*paths)

    def look(self, *paths: Path) -> None:
        """Watch these files and no others; those that were known once as they were then."""
        with self._lock:
            for path in paths:
                if path not in self._known:
                    self._known[path] = content_of(path)
            self._watched = paths
            self._seen, self._read, self._told = {}, {}, {}
        if not self._thread.is_alive() and not self._ended.is_set() and paths:
            self._thread.start()

    def differs(self) -> list[Path]:
        """Files that hold something else than what is known."""
        with self._lock:
            known = {path: self._known[path] for path in self._watched}
        return [path for path, content in known.items() if content_of(path) != content]

    def close(self) -> None:
        """Look no longer; a second call does nothing."""
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
        """Whether a file has come to rest with a content that is neither known nor told about."""
        look = _look(path)
        with self._lock:
            at_rest = look == self._seen.get(path, "not looked at yet") and look != self._read.get(path, "not read yet")
            self._seen[path] = look
        if not at_rest:
            return False
        content = content_of(path)
        with self._lock:
            if path not in self._watched:
                return False
            last = self._told.get(path, self._known[path])
            self._read[path], self._told[path] = look, content
        return content not in (last, self._known[path])


def content_of(path: Path) -> str | None:
    """What a file holds, as a short text; None where there is none."""
    with contextlib.suppress(OSError):
        return hashlib.sha256(read_whole(path)).hexdigest()
    return None


def _look(path: Path) -> tuple[int, int] | None:
    with contextlib.suppress(OSError):
        state = path.stat()
        return state.st_mtime_ns, state.st_size
    return None
