"""The file that a session works on: opened, saved, changed by another program, found again with its journal."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import clean
from .document import Document
from .filing import Opened, difference, files_of, opened, received, write
from .history import History
from .places import Storage, place_of
from .watch import Watch

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
