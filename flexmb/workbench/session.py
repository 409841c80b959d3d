"""One session of the workbench: the document and its history, what is computed of it, and what pages ask for."""

import inspect
import secrets
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import clean
from .jobs import Jobs


class Refused(Exception):
    """What a page asked for is not done.

    Attributes:
        problem: Its message, and the address of the field where one is meant.
    """

    def __init__(self, message: str, address: str | None = None):
        super().__init__(message)
        self.problem = {"message": message} | ({} if address is None else {"address": address})


class Session:
    """A document that is worked on, as a method ``do_<verb>`` for everything that a page may ask for.

    Verbs run one after the other in one thread. Each answers what its reply holds, or a function that makes it, which
    runs beside the verbs that follow: it must be of what it was given alone.

    Attributes:
        run: Name of this session: another one after the program was started again.
    """

    def __init__(self, document: Any = None, file: Path | None = None):
        from .stand_in import History

        self.run = secrets.token_hex(8)
        self.file = file
        self.history = History(document)
        self.revision = 0
        self._lock = threading.RLock()
        self._listeners: list[Callable[[dict[str, Any]], None]] = []
        self.jobs = Jobs(self.tell)

    def listen(self, listener: Callable[[dict[str, Any]], None]) -> None:
        """Tell a function everything that pages are to know, from any thread."""
        self._listeners.append(listener)

    def tell(self, message: dict[str, Any]) -> None:
        """Tell all pages, from any thread."""
        for listener in list(self._listeners):
            listener(message)

    def close(self) -> None:
        """End what is running; a second call does nothing."""
        self.jobs.close()

    def ask(self, verb: str, arguments: dict[str, Any], key: str | None = None) -> Any:
        """Do what a page asks for.

        Args:
            verb: What.
            arguments: By name.
            key: Of the request, the same where it is sent again.

        Returns:
            Content of the reply, or a function that makes it.

        Raises:
            Refused: It cannot be done, and why.
        """
        method = getattr(self, f"do_{verb}", None) if verb.isidentifier() else None
        if method is None:
            raise Refused(f"There is no verb '{clean(verb)}'.")
        try:
            inspect.signature(method).bind(**arguments)
        except TypeError as fault:
            raise Refused(f"{verb}: {fault}.") from None
        with self._lock:
            return method(**arguments) or {}

    # Verbs.

    def do_hello(self, run: str | None = None) -> dict[str, Any]:
        """What a page needs to begin."""
        self._tell_document()
        return {"run": self.run, "version": __version__, "file": self._name(), "catalogue": {}}

    def do_edit(self, ops: list, label: str = "", merge: str | None = None) -> dict[str, Any]:
        """Change the document."""
        report = self.history.edit(ops, label, merge)
        return {"revision": self._changed(), **report}

    def do_undo(self) -> dict[str, Any]:
        """Go back one step."""
        label = self.history.undo()
        return {"revision": self._changed(), "label": label}

    def do_redo(self) -> dict[str, Any]:
        """Go forward again."""
        label = self.history.redo()
        return {"revision": self._changed(), "label": label}

    def do_stop(self, job: str) -> None:
        """Stop a job."""
        self.jobs.stop(job)

    def _name(self) -> str | None:
        return None if self.file is None else str(self.file)

    def _changed(self) -> int:
        self.revision += 1
        self._tell_document()
        return self.revision

    def _tell_document(self) -> None:
        history = self.history
        self.tell(
            {
                "tell": "document",
                "revision": self.revision,
                "document": history.document,
                "undo": history.undone,
                "redo": history.redone,
                "problems": [],
                "positions": {},
                "values": {},
                "saved": not history.undone,
                "file": self._name(),
            }
        )
