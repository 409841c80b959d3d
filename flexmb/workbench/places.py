"""Where workbenches keep their journals, and which of them run: files of the user, in a folder that no other can read."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import http.client
import itertools
import json
import os
import sys
from pathlib import Path
from typing import Any

from ..files import write_whole

_numbers = itertools.count(1)


def state_folder() -> Path:
    """Folder of journals: ``$FLEXMB_STATE``, or flexmb in the user's folder of states."""
    if given := os.environ.get("FLEXMB_STATE"):
        return Path(given)
    windows = os.environ.get("LOCALAPPDATA") if sys.platform == "win32" else None
    base = windows or os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(base) / "flexmb"


@dataclasses.dataclass(frozen=True)
class Place:
    """Where one workbench keeps what it must not lose.

    Attributes:
        name: Of its files.
        file: That it works on; None for a new mechanism.
    """

    name: str
    file: Path | None

    @property
    def journal(self) -> Path:
        """Where the journal of its edits stands."""
        return state_folder() / f"{self.name}.journal"

    @property
    def _about(self) -> Path:
        return state_folder() / f"{self.name}.json"

    def known(self) -> dict[str, Any]:
        """What the workbench that was last here has told: "process", "port", "token"; empty where none was."""
        with contextlib.suppress(OSError, ValueError):
            found = json.loads(self._about.read_text())
            if isinstance(found, dict):
                return found
        return {}

    def address(self) -> str | None:
        """Address of the workbench that runs here now, or None: it has the token, and answers to it."""
        known = self.known()
        if not isinstance(known.get("process"), int) or not _is_running(known["process"]):
            return None
        path = f"/{known.get('token')}/"
        connection = http.client.HTTPConnection("127.0.0.1", int(known.get("port", 0)), timeout=2)
        try:
            connection.request("GET", path)
            there = connection.getresponse().status == 200
        except (OSError, http.client.HTTPException):
            return None
        finally:
            connection.close()
        return f"http://127.0.0.1:{known['port']}{path}" if there else None

    def take(self, port: int, token: str) -> None:
        """Say that this process works here now; a later one goes on with the same token, so that open pages find it."""
        about = {
            "process": os.getpid(),
            "port": port,
            "token": token,
            "file": None if self.file is None else str(self.file),
        }
        write_whole(self._about, json.dumps(about).encode())
        os.chmod(self._about, 0o600)

    def leave(self) -> None:
        """Say that nobody works here; where nothing is left to go on with, nothing stays."""
        if self.journal.exists() or self.file is not None:
            about = {**self.known(), "process": None}
            with contextlib.suppress(OSError):
                write_whole(self._about, json.dumps(about).encode())
                os.chmod(self._about, 0o600)
        else:
            self._about.unlink(missing_ok=True)


def place_of(file: Path | None) -> Place:
    """Place of a file, or of a new mechanism: then that of one that nobody works on any more, where there is one.

    Raises:
        OSError: The folder of journals cannot be made.
    """
    folder = state_folder()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    if file is not None:
        path = Path(os.path.realpath(file))
        short = hashlib.sha256(os.fsencode(path)).hexdigest()[:16]
        return Place(f"file-{short}", path)
    left = sorted(folder.glob("new-*.journal"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in left:
        found = Place(path.stem, None)
        process = found.known().get("process")
        if not (isinstance(process, int) and _is_running(process)):
            return found
    return fresh_place()


def fresh_place() -> Place:
    """Place of a new mechanism that goes on with nothing."""
    folder = state_folder()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    while (found := Place(f"new-{os.getpid()}-{next(_numbers)}", None)).journal.exists():
        pass
    return found


def _is_running(process: int) -> bool:
    """Whether a process of this machine is there."""
    if process == os.getpid():
        return True
    if sys.platform == "win32":
        # There a signal of zero would end it; whether it answers is asked of its address.
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
