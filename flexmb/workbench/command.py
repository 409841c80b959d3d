"""What ``flexmb edit`` does: serve one session until the keyboard ends it."""

import os
import signal
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from ..errors import clean
from .server import Server
from .session import Session


def serve(
    path: Path | None, port: int, browser: bool, *, tell: Callable[[str], None], refuse: Callable[[str], NoReturn]
) -> None:
    """Serve a file, or a new mechanism, until Ctrl-C or the end of the process is asked for.

    Args:
        path: The file; None for a new mechanism.
        port: Where to listen; 0 for any port that is free.
        browser: Whether to open the page.
        tell: Prints a line on standard output.
        refuse: Ends with a line on standard error.
    """
    ended = threading.Event()
    before = {one: signal.signal(one, lambda *_: ended.set()) for one in (signal.SIGINT, signal.SIGTERM)}
    try:
        server = _opened(path, port, refuse)
        server.start()
        try:
            tell(server.address)
            if browser and _has_screen():
                threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
            # A plain wait would not let the signal through everywhere.
            while not ended.wait(0.5):
                pass
        finally:
            server.close()
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


def _opened(path: Path | None, port: int, refuse: Callable[[str], NoReturn]) -> Server:
    if path is not None and not path.is_file():
        refuse(f"flexmb edit: cannot read '{clean(path)}': there is no such file.")
    try:
        return Server(Session(file=path), port=port)
    except ModuleNotFoundError as fault:
        refuse(f"flexmb edit: {fault}")
    except OSError as fault:
        refuse(f"flexmb edit: port {port} is taken: {fault.strerror}.")


def _has_screen() -> bool:
    """Whether a browser can show itself; without a screen one in the terminal would take the keyboard."""
    named = "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ or "BROWSER" in os.environ
    return named or sys.platform in ("win32", "darwin")
