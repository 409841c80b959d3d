"""A target in progress: the designs of the search become the document."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from .document import Document
from .jobs import Job
from .wants import number_like

# Shortest time between two designs on the page [s], and their number of digits.
PACE, DIGITS = 0.1, 6


class Shown:
    """A job whose designs become the document, by operations for ``write``."""

    def __init__(self, job: Job, document: Document, write: Callable[[list[dict[str, Any]]], None]):
        self._job, self._document, self._write = job, document, write
        self._last = 0.0

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
        names = self._document.names
        texts = {name: number_like(names[name]["value"], value, DIGITS) for name, value in changes["design"].items()}
        ops = [{"op": "name", "name": name, "to": {**names[name], "value": text}} for name, text in texts.items()]
        self._write(ops)
