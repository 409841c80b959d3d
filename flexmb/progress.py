"""How far a long computation is: a bar on the error output, or a function of the user's own."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any


class Stopped(KeyboardInterrupt):
    """Raised by a ``progress`` function to stop what it watches, as Ctrl-C does: what there is so far is kept."""


@contextlib.contextmanager
def reporting(
    progress: Callable[..., None] | bool | None, what: str, total: int | None = None
) -> Iterator[Callable[..., None] | None]:
    """Yield what to call with the number done and more: the given function, a bar with words and a total, or None."""
    if progress is not True:
        yield progress or None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, TextColumn("{task.fields[more]}"), console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=total, more="")

        def report(done: int, *more: Any) -> None:
            # A whole sweep says how many there are, a search how good it is.
            text = "" if total is not None else "  ".join(f"{value:.4g}" for value in more)
            bar.update(task, completed=done, more=text)

        yield report
