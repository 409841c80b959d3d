"""The place of a workbench's journal, and how another process finds it; no other user can read these files."""

from __future__ import annotations

import contextlib
import hashlib
import http.client
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

from ..files import write_whole
from .undo import is_locked, journal_folder, journals, new_journal


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
    return Storage(_folder() / f"file-{hashlib.sha256(os.fsencode(path)).hexdigest()[:16]}.jsonl")


def unsaved_storage() -> Storage | None:
    """Place of the last new mechanism that was never saved, or None."""
    paths = (path for path in journals(_folder()) if path.name[:1].isdigit())
    return next(map(Storage, paths), None)


def new_place() -> Storage:
    """Place of a new mechanism."""
    return Storage(new_journal(_folder()))


def _folder() -> Path:
    folder = journal_folder()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    return folder
