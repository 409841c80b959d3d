"""Files that another program changes while they are open here."""

import contextlib
import hashlib
import threading
from collections.abc import Callable
from pathlib import Path

from ..files import read_whole

# Between two looks [s].
PERIOD = 0.5


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
