"""A target on its way: the designs that it looks at are the document while it goes on."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from .document import Document
from .jobs import Job
from .wants import number_like

# Designs are shown no faster than this [s], with so many digits.
PACE, DIGITS = 0.1, 6


class Shown:
    """A job whose designs become the document as they come.

    Args:
        job: Told all of it.
        document: That the names are in.
        write: Edits the document, by operations.
    """

    def __init__(self, job: Job, document: Document, write: Callable[[list[dict[str, Any]]], None]):
        self._job, self._document, self._write = job, document, write
        self._last = 0.0

    @property
    def stopped(self) -> bool:
        """Whether it is to end."""
        return self._job.stopped

    def tell(self, **changes: Any) -> None:
        """Take how far it is."""
        self._job.tell(**changes)
        now = time.monotonic()
        if not changes.get("design") or now - self._last < PACE or self.stopped:
            return
        self._last = now
        own = self._document.names
        texts = {name: number_like(own[name]["value"], value, DIGITS) for name, value in changes["design"].items()}
        ops = [{"op": "name", "name": name, "to": {**own[name], "value": text}} for name, text in texts.items()]
        self._write(ops)
