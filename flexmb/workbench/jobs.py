"""Long work beside the session: started, observed and stopped."""

import itertools
import threading
from collections.abc import Callable
from typing import Any

from ..errors import AnalysisError, ModelError
from ..progress import Stopped

# Jobs at once. A machine has few cores, and the live answers need one.
MOST_JOBS = 4
# Longest time to wait for a job at the end of the program [s]: compiling cannot be interrupted.
PATIENCE = 10.0


class Job:
    """A job, with its name on the pages and its kind, such as "target" or "path"."""

    def __init__(self, name: str, kind: str, tell: Callable[[dict[str, Any]], None]):
        self.name = name
        self.kind = kind
        self._tell = tell
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._state: dict[str, Any] = {"status": "running", "text": ""}

    @property
    def stopped(self) -> bool:
        """Whether to end."""
        return self._stopped.is_set()

    def tell(self, **changes: Any) -> None:
        """Send the progress to pages: ``fraction`` (0 to 1), ``text``, ``design``, ``picture``, ``view``, ``rows``."""
        with self._lock:
            # A stopped job would look as if it went on.
            if self._state["status"] == "running":
                self._say(changes)

    def end(self, **changes: Any) -> None:
        """Send the end to pages; a stopped job sends what it has found so far."""
        with self._lock:
            self._say({**changes, "status": "stopped"} if self.stopped else changes)

    def _say(self, changes: dict[str, Any]) -> None:
        self._state |= changes
        self._tell({"tell": "job", "job": self.name, "kind": self.kind, **self._state})

    def stop(self) -> None:
        """Ask it to end; from then on pages see it as stopped."""
        self._stopped.set()
        self.tell(status="stopped")


class Jobs:
    """The jobs of a session; ``tell`` sends a message to all pages, from any thread."""

    def __init__(self, tell: Callable[[dict[str, Any]], None]):
        self._tell = tell
        self._numbers = itertools.count(1)
        self._running: dict[str, tuple[Job, threading.Thread]] = {}
        self._lock = threading.Lock()

    def start(self, kind: str, work: Callable[[Job], dict[str, Any] | None]) -> str:
        """Begin a job in a thread of its own; ``work(job)`` returns its last message."""
        with self._lock:
            if len(self._running) >= MOST_JOBS:
                raise ValueError(f"{MOST_JOBS} computations are running. Stop one, or wait for it.")
            name = str(next(self._numbers))
            job = Job(name, kind, self._tell)
            thread = threading.Thread(target=self._run, args=(job, work), name=f"flexmb {kind}", daemon=True)
            self._running[name] = job, thread
        job.tell(fraction=0.0)
        thread.start()
        return name

    def stop(self, name: str) -> None:
        """Stop a job that is still running."""
        with self._lock:
            running = self._running.get(name)
        if running is not None:
            running[0].stop()

    def close(self) -> None:
        """Stop all jobs, and wait a while for their threads."""
        with self._lock:
            running = list(self._running.values())
        for job, _ in running:
            job.stop()
        for _, thread in running:
            thread.join(PATIENCE)

    def _run(self, job: Job, work: Callable[[Job], dict[str, Any] | None]) -> None:
        try:
            job.end(**{"fraction": 1.0, "status": "done", **(work(job) or {})})
        except Stopped:
            job.end(status="stopped")
        except (AnalysisError, ModelError, ImportError, ValueError) as fault:
            job.end(status="failed", text=str(fault))
        except Exception as fault:
            job.end(status="failed", text=f"{type(fault).__name__}: {fault}")
        finally:
            with self._lock:
                del self._running[job.name]
