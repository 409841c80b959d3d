"""Progress of a long computation: a bar on the error output, or a user's function."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any


class Stopped(KeyboardInterrupt):
    """Raised by a ``progress`` function to stop a computation as Ctrl-C does; results so far are kept."""


@contextlib.contextmanager
def reporting(
    progress: Callable[..., None] | bool | None, what: str, total: int | None = None
) -> Iterator[Callable[..., None] | None]:
    """Yield a function of the number done and more: the given one, a progress bar (True), or None."""
    if progress is not True:
        yield progress or None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, TextColumn("{task.fields[more]}"), console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=total, more="")

        def report(count: int, *more: Any) -> None:
            # A sweep knows its total; a search shows its objective.
            text = "" if total is not None else "  ".join(f"{value:.4g}" for value in more)
            bar.update(task, completed=count, more=text)

        yield report
