"""Long work beside the session: started, told about as it goes on, and stopped."""

import itertools
import threading
from collections.abc import Callable
from typing import Any

from ..errors import AnalysisError, ModelError

# At once [-]; a machine has few cores, and what is seen live needs one.
MOST_JOBS = 4
# How long the end of the program waits for a job [s]; what is being compiled cannot be interrupted.
PATIENCE = 10.0


class JobStopped(Exception):
    """Raised in a job by :meth:`Job.check` after it was stopped."""


class Job:
    """A job, as the work in it sees it.

    Attributes:
        name: By which pages know it.
        kind: What it does, such as "target" or "path".
    """

    def __init__(self, name: str, kind: str, tell: Callable[[dict[str, Any]], None]):
        self.name = name
        self.kind = kind
        self._tell = tell
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._state: dict[str, Any] = {"status": "running", "text": ""}

    @property
    def stopped(self) -> bool:
        """Whether it is to end."""
        return self._stopped.is_set()

    def check(self) -> None:
        """Raise JobStopped where it is to end; call it as often as the work allows."""
        if self.stopped:
            raise JobStopped

    def tell(self, **changes: Any) -> None:
        """Tell pages how far it is; what was told before stays.

        Args:
            changes: Of ``fraction`` (0 to 1), ``text``, ``design``, ``picture``, ``view``, ``rows``; plain values.
        """
        with self._lock:
            # Who stopped it has been told so, and what comes later would look as if it went on.
            if self._state["status"] == "running":
                self._say(changes)

    def end(self, **changes: Any) -> None:
        """Tell pages how it ended, and of a job that was stopped what it had found by then."""
        with self._lock:
            self._say({**changes, "status": "stopped"} if self.stopped else changes)

    def _say(self, changes: dict[str, Any]) -> None:
        self._state |= changes
        self._tell({"tell": "job", "job": self.name, "kind": self.kind, **self._state})

    def stop(self) -> None:
        """Ask it to end; pages see it as stopped from here on."""
        self._stopped.set()
        self.tell(status="stopped")


class Jobs:
    """The jobs of a session.

    Args:
        tell: Pushes a message to all pages, from any thread.
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None]):
        self._tell = tell
        self._numbers = itertools.count(1)
        self._running: dict[str, tuple[Job, threading.Thread]] = {}
        self._lock = threading.Lock()

    def start(self, kind: str, work: Callable[[Job], dict[str, Any] | None]) -> str:
        """Begin a job in a thread of its own.

        Args:
            kind: What it does.
            work: Gets the job; returns what is told at its end, as :meth:`Job.tell` takes it, or raises.

        Raises:
            ValueError: So many run already.
        """
        with self._lock:
            if len(self._running) >= MOST_JOBS:
                raise ValueError(f"{MOST_JOBS} computations run at once at most: stop one, or wait for it.")
            name = str(next(self._numbers))
            job = Job(name, kind, self._tell)
            thread = threading.Thread(target=self._run, args=(job, work), name=f"flexmb {kind}", daemon=True)
            self._running[name] = job, thread
        job.tell(fraction=0.0)
        thread.start()
        return name

    def stop(self, name: str) -> None:
        """Stop a job; one that has ended already stays as it is."""
        with self._lock:
            found = self._running.get(name)
        if found is not None:
            found[0].stop()

    def close(self) -> None:
        """Stop all, and wait for their threads for a while."""
        with self._lock:
            running = list(self._running.values())
        for job, _ in running:
            job.stop()
        for _, thread in running:
            thread.join(PATIENCE)

    def _run(self, job: Job, work: Callable[[Job], dict[str, Any] | None]) -> None:
        try:
            job.end(**{"fraction": 1.0, "status": "done", **(work(job) or {})})
        except JobStopped:
            job.end(status="stopped")
        except (AnalysisError, ModelError, ImportError, ValueError) as fault:
            job.end(status="failed", text=str(fault))
        except Exception as fault:
            job.end(status="failed", text=f"{type(fault).__name__}: {fault}")
        finally:
            with self._lock:
                del self._running[job.name]
