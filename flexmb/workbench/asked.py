"""What an analysis of the page is, and what it gets."""

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

# pyplot keeps figures by number for the whole process: one picture is drawn at a time.
PICTURES = threading.Lock()


class Analysis(NamedTuple):
    """One analysis.

    Attributes:
        title: What it is called.
        doc: What it answers, in a sentence.
        needs: As :class:`flexmb.answers.mode.Mode` has them.
        run: Gets what is asked, and answers what is told at its end.
    """

    title: str
    doc: str
    needs: tuple[str, ...]
    run: Callable[[Request], dict[str, Any]]


@dataclasses.dataclass
class Request:
    """What an analysis gets.

    Attributes:
        document: The document.
        builder: The mechanism.
        options: Checked, by name: numbers, texts and flags.
        job: Told how far it is.
    """

    document: Document
    builder: Builder
    options: dict[str, Any]
    job: Watched

    @property
    def name(self) -> str:
        """Title of the document."""
        return clean(self.document.data["title"]) or "mechanism"

    def watch(self, what: str, total: float | None = None) -> Callable[..., None]:
        """A function to be called with the number of things done, which stops where the job does."""

        def report(done: float, *more: Any) -> None:
            if self.job.stopped:
                raise Stopped
            of = total if total is not None or not more else more[0]
            self.job.tell(fraction=min(1.0, done / of) if of else None, text=f"{what}: {done:g}")

        return report
