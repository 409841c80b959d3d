"""An analysis of the page, and the request that it receives."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from typing import Any, NamedTuple

from ..build.builder import Builder
from ..errors import clean
from ..progress import Stopped
from .document import Document
from .targets import Watched

# pyplot numbers figures of the whole process: draw one picture at a time.
PICTURES = threading.Lock()


class Analysis(NamedTuple):
    """An analysis: title, answer in a sentence, needs as of :class:`flexmb.answers.mode.Mode`, and what runs it."""

    title: str
    doc: str
    needs: tuple[str, ...]
    run: Callable[[Request], dict[str, Any]]


@dataclasses.dataclass
class Request:
    """What an analysis receives: document, mechanism, checked options by name, and the job."""

    document: Document
    builder: Builder
    options: dict[str, Any]
    job: Watched

    @property
    def name(self) -> str:
        """Title of the document."""
        return clean(self.document.data["title"]) or "mechanism"

    def watch(self, what: str, total: float | None = None) -> Callable[..., None]:
        """A function to call with the number of things done; it stops when the job does."""

        def report(done: float, *more: Any) -> None:
            if self.job.stopped:
                raise Stopped
            goal = total if total is not None or not more else more[0]
            self.job.tell(fraction=min(1.0, done / goal) if goal else None, text=f"{what}: {done:g}")

        return report
