"""One session of the workbench: document, history, computed results, and the requests of pages."""

from __future__ import annotations

import dataclasses
import inspect
import secrets
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import ModelError, printable
from .building import build, numeric_values, positions
from .compare import Pinned, differences
from .document import Document, Report
from .fields import catalogue
from .filing import exported, lost_in
from .jobs import Job, Jobs
from .live import Live
from .live_answers import Wants
from .open_file import OpenFile
from .targets import meet
from .undo import History, Storage
from .wants import label_of, name_ops

# Shortest time between two designs on the page [s], and their number of digits.
PACE, DIGITS = 0.1, 6


class VisibleJob:
    """A job whose designs become the document, by operations for ``write``."""

    def __init__(self, job: Job, document: Document, write: Callable[[list[dict[str, Any]]], None]):
        self._job, self._document, self._write = job, document, write
        self._last, self._shown = 0.0, []

    @property
    def stopped(self) -> bool:
        """Whether to end."""
        return self._job.stopped

    def tell(self, **changes: Any) -> None:
        """Send the progress, and edit the document."""
        self._job.tell(**changes)
        now = time.monotonic()
        if not changes.get("design") or now - self._last < PACE or self.stopped:
            return
        self._last = now
        self._shown = list(changes["design"])
        self._write(name_ops(self._document, changes["design"], DIGITS))

    def end(self, ops: list[dict[str, Any]]) -> None:
        """Write the last design; names that it does not change return to their values before the search."""
        changed = {op["name"] for op in ops}
        same = [name for name in self._shown if name not in changed]
        if ops := [*ops, *({"op": "name", "name": name, "to": self._document.names[name]} for name in same)]:
            self._write(ops)


# Longest time that a pinned design waits for its answers [s].
LONGEST_WAIT = 5.0


class Refused(Exception):
    """A request of a page is refused, with a message and the address of a field."""

    def __init__(self, message: str, address: str | None = None):
        super().__init__(message)
        self.problem = {"message": message} | ({"address": address} if address else {})


class Session:
    """A document with a method ``do_<verb>`` for each request of a page.

    Verbs run one after the other in one thread. Each returns its reply, or a function that makes the reply beside the
    verbs that follow; the function must use only its own data.

    Attributes:
        run: Name of this session, another one after a restart of the program.
        notes: Notes about the beginning.
    """

    def __init__(self, history: History | None = None, *, place: Storage | None = None, notes: list[str] | None = None):
        """Begin; :meth:`listen` starts the messages."""
        self.run = secrets.token_hex(8)
        self.history = history or History()
        self.notes = notes or []
        self.wants = Wants()
        self.jobs = Jobs(self.tell)
        self._lock = threading.RLock()
        self.file = OpenFile(self.history, place, self.tell, self._lock)
        self.file.settled = self._tell_changes
        self._listeners: list[Callable[[dict[str, Any]], None]] = []
        self._agreed: set[str] = set()
        self._is_closed = False
        self._answers: dict[str, Any] = {}
        self._pinned: Pinned | None = None
        self._offered: dict[str, Any] = {}
        self.live = Live(self._live_tells)

    def listen(self, listener: Callable[[dict[str, Any]], None]) -> None:
        """Call a function with every message to pages, from any thread."""
        self._listeners.append(listener)
        with self._lock:
            self._tell_changes()
            self.file.begin()

    def tell(self, message: dict[str, Any]) -> None:
        """Send a message to all pages, from any thread."""
        for listener in list(self._listeners):
            listener(message)

    def ask(self, verb: str, arguments: dict[str, Any], key: str | None = None) -> Any:
        """Do a request of a page."""
        method = getattr(self, f"do_{verb}", None) if verb.isidentifier() else None
        if method is None:
            raise Refused(f"There is no verb '{printable(verb)}'.")
        signature = inspect.signature(method)
        try:
            bound = signature.bind(**arguments, **({"key": key} if "key" in signature.parameters else {}))
        except TypeError as fault:
            raise Refused(f"{verb}: {fault}.") from None
        with self._lock:
            if key is not None and key in self.history.requests:
                # A killed process did this before it could reply.
                return self._reply(self.history.requests[key])
            return method(*bound.args, **bound.kwargs) or {}

    def builder(self) -> Any:
        """A new builder with the present mechanism; ModelError with all problems if something cannot be built."""
        built = build(self.history.document)
        if built.problems:
            raise ModelError("\n".join(problem["message"] for problem in built.problems))
        return built.builder

    def close(self, *, keep: bool | None = None) -> None:
        """End everything that runs; a second call does nothing."""
        if self._is_closed:
            return
        self._is_closed = True
        self.jobs.close()
        self.live.stop()
        self.file.close(keep)

    def do_hello(self, run: str | None = None) -> dict[str, Any]:
        """Data for a new page."""
        return {
            "run": self.run,
            "version": __version__,
            "file": self.history.file,
            "catalogue": catalogue(),
            "notes": self.notes,
            "want": dataclasses.asdict(self.wants),
        }

    def do_edit(self, ops: list, label: str | None = None, merge: str | None = None, key: str | None = None) -> Any:
        """Change the document."""
        return self._changed(self.history.edit(ops, label or None, merge, key))

    def do_undo(self, key: str | None = None) -> Any:
        """Go back one step."""
        return self._stepped(self.history.undo(key))

    def do_redo(self, key: str | None = None) -> Any:
        """Go forward again."""
        return self._stepped(self.history.redo(key))

    def do_part(self) -> None:
        """End a step: the next edit is another one, whatever its merge key."""
        self.history.part()

    def do_want(self, **changes: Any) -> None:
        """Change what is computed and shown."""
        self.wants = self.wants.changed(changes)
        self.tell({"tell": "want", **dataclasses.asdict(self.wants)})
        self.live.show(self.history.revision, self.history.document, self.wants)

    def do_advise(self, index: int, key: str | None = None) -> Any:
        """Carry out a piece of advice."""
        counted = self.live.counted
        suggestions = counted.get("advice", [])
        if counted.get("revision") != self.history.revision or not 0 <= index < len(suggestions):
            raise Refused("The mechanism has changed since this advice. Look at the new advice.")
        return self._changed(self.history.edit(suggestions[index]["ops"], suggestions[index]["text"], None, key))

    def do_target(self, wants: list, free: list) -> dict[str, Any]:
        """Find dimensions that meet targets, as one step that moves during the search."""
        document, node, label = self.history.document, self.wants.support_node, label_of(wants)
        merge = f"target {secrets.token_hex(8)}"

        def written(ops: list[dict[str, Any]], label: str) -> None:
            with self._lock:
                self._changed(self.history.edit(ops, label, merge))

        def work(job: Job) -> dict[str, Any]:
            visible, ops = VisibleJob(job, document, lambda ops: written(ops, label)), []
            try:
                result = meet(document, wants, free, visible, node)
                ops = result["ops"]
                return result
            finally:
                visible.end(ops)

        return {"job": self.jobs.start("target", work)}

    def do_fit(self, text: str, name: str, free: list) -> dict[str, Any]:
        """Fit names to a table of measurements; the document stays as it is."""
        from .fit_table import fitted_names

        document, node = self.history.document, self.wants.support_node
        return {"job": self.jobs.start("fit", lambda job: fitted_names(document, printable(name), text, free, node))}

    def do_run(self, analysis: str, options: dict | None = None) -> dict[str, Any]:
        """Run an analysis."""
        from .analyses import run

        document = self.history.document
        return {"job": self.jobs.start(printable(analysis), lambda job: run(document, analysis, options or {}, job))}

    def do_pin(self) -> None:
        """Keep this design for comparison."""
        if self._answers.get("of_revision") != self.history.revision:
            self.live.wait(LONGEST_WAIT)
        values = self._answers["values"] if self._answers.get("of_revision") == self.history.revision else {}
        self._pinned = Pinned(self.history.document, self.history.revision, values)
        self._tell_pinned()

    def do_unpin(self) -> None:
        """End the comparison."""
        self._pinned = None
        self.tell({"tell": "pinned"})

    def do_stop(self, job: str) -> None:
        """Stop a job."""
        self.jobs.stop(job)

    def do_open(
        self, path: str | None = None, text: str | None = None, name: str | None = None, key: str | None = None
    ) -> Any:
        """Replace the document by a file, or by a text from the page, as one step."""
        if path is not None and text is None and name is None:
            notes = self.file.open(Path(path).expanduser().absolute(), key)
        elif path is None and isinstance(text, str) and isinstance(name, str):
            notes = self.file.receive(name, text, key)
        else:
            raise Refused("open: there is no path and no text. Give a path, or a text and its name.")
        return self._changed(None, notes=notes)

    def do_save(self, path: str | None = None, anyway: bool = False, over: bool = False) -> Any:
        """Write the file; if something would be lost or overwritten, only report it."""
        current = self.file.path
        file = Path(path).expanduser().absolute() if path else current
        if file is None:
            raise Refused("save: this mechanism has no file yet. Give a path.")
        lost = lost_in(self.history.document, file)
        if not anyway and not self._agreed.issuperset(lost):
            return {"saved": False, "cannot_hold": lost}
        if file != current and not over and file.exists():
            return {"saved": False, "over": file.name}
        notes = self.save(file)
        self._agreed.update(lost)
        return {"saved": True, "file": str(file), "notes": notes}

    def do_export(self, kind: str, deformed: bool = False) -> Callable[[], dict[str, Any]]:
        """Content of a file of another format."""
        document, file = self.history.document, self.file.path
        name = file.stem if file else "".join(c if c.isalnum() else "_" for c in document.data["title"])[:60]
        return lambda: exported(document, kind, name or "mechanism", deformed)

    def do_keep_disk(self) -> None:
        """Keep the document; the next save overwrites the change of another program."""
        self.file.keep()
        self._tell_changes()

    def do_take_disk(self, key: str | None = None) -> Any:
        """Replace the document by the file, or by an empty one without a file, as one step."""
        return self._changed(None, notes=self.file.take(key))

    def save(self, file: Path) -> list[str]:
        """Write the document to a file."""
        with self._lock:
            notes = self.file.save(file)
            self._tell_changes()
        return notes

    def _reply(self, report: Report | str | None, **more: Any) -> dict[str, Any]:
        content = {"label": report} if report is None or isinstance(report, str) else report._asdict()
        return {"revision": self.history.revision, **content, **more}

    def _changed(self, report: Report | str | None, **more: Any) -> dict[str, Any]:
        self._tell_changes()
        return self._reply(report, **more)

    def _stepped(self, label: str | None) -> dict[str, Any]:
        self.file.follow()
        return self._changed(label)

    def _tell_changes(self) -> None:
        history = self.history
        built = build(history.document)
        values = numeric_values(history.document)
        self.tell(
            {
                "tell": "document",
                "revision": history.revision,
                "document": history.document.data,
                "undo": history.undo_labels,
                "redo": history.redo_labels,
                "problems": built.problems,
                "positions": positions(history.document, built),
                "values": {name: values.get(f"names/{name}/value") for name in history.document.names},
                "saved": history.is_saved,
                "file": history.file,
            }
        )
        self.live.show(history.revision, history.document, self.wants)

    def _live_tells(self, message: dict[str, Any]) -> None:
        self.tell(message)
        if message["tell"] == "answers" and message["status"] == "ok":
            self._answers = message
            self._tell_pinned()
        if message["tell"] == "scene" or message.get("status") == "failed":
            self._tell_offered()

    def _tell_offered(self) -> None:
        """Send the analyses of the present document, after all else, since they load much of the package."""
        from .analyses import offered_analyses

        if (offers := offered_analyses(self.history.document)) != self._offered:
            self._offered = offers
            self.tell({"tell": "analyses", "analyses": offers})

    def _tell_pinned(self) -> None:
        known = self._answers
        if self._pinned is not None and known.get("of_revision") == self.history.revision:
            changes = differences(self._pinned, self.history.document, known["values"])
            self.tell({"tell": "pinned", "differences": changes})
