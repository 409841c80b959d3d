"""What ``flexmb edit`` does: serve one session until the keyboard ends it."""

from __future__ import annotations

import os
import signal
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..errors import SpacarError, clean

if TYPE_CHECKING:
    from .server import Server
    from .session import Session

# What is computed when the program ends is waited for so long [s]; then the process goes without it.
PATIENCE = 15.0


class _EndedError(Exception):
    """The keyboard, or who runs this machine, ends the program."""


def serve(
    path: Path | None, port: int, browser: bool, *, tell: Callable[[str], None], refuse: Callable[[str], NoReturn]
) -> None:
    """Serve a file, or a new mechanism, until Ctrl-C or the end of the process is asked for."""

    def end(*_: object) -> None:
        # Once is enough: what ends takes its time.
        for one in before:
            signal.signal(one, signal.SIG_IGN)
        raise _EndedError

    before = {one: signal.signal(one, end) for one in (signal.SIGINT, signal.SIGTERM)}
    server = None
    try:
        server = _server(path, port, refuse)
        server.start()
        tell(server.address)
        if browser and _has_screen():
            threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
        while True:
            # A longer wait would not let the signal through everywhere.
            threading.Event().wait(0.5)
    except _EndedError:
        pass
    finally:
        if server is not None:
            _close(server)
        for one, handler in before.items():
            signal.signal(one, handler)


def _server(path: Path | None, port: int, refuse: Callable[[str], NoReturn]) -> Server:
    """A server that has its port and its session."""
    try:
        import websockets  # noqa: F401
    except ModuleNotFoundError:
        refuse("flexmb edit: the workbench needs the package websockets: pip install 'flexmb[workbench]'.")
    from ..setup import enable_cache, enable_x64

    enable_x64()
    try:
        # Structures change all the time: what is compiled is to be there soon, and runs in a millisecond anyway.
        enable_cache(thorough=False)
    except OSError:
        # Without a writable cache folder the program is slower and otherwise the same.
        pass
    session = _session(path, refuse)
    known = session.file.place.known() if session.file.place is not None else {}
    from .server import Server

    # Where the last one was, so that a page which is still open finds this one.
    for tried in (port,) if port else (known.get("port", 0), 0):
        try:
            server = Server(session, port=tried, token=known.get("token"))
        except OSError as fault:
            if tried and not port:
                continue
            session.close()
            refuse(f"flexmb edit: port {tried} is taken: {fault.strerror or fault}; --port 0 takes any that is free.")
        session.file.answers_at(server.port, server.token)
        return server
    raise AssertionError


def _session(path: Path | None, refuse: Callable[[str], NoReturn]) -> Session:
    from .begin import TakenError, session_of_file, session_of_new

    name = None if path is None else clean(path)
    try:
        return session_of_new() if path is None else session_of_file(path)
    except TakenError as fault:
        refuse(f"flexmb edit: {fault}")
    except SpacarError as fault:
        refuse(str(fault))
    except OSError as fault:
        refuse(f"flexmb edit: cannot read '{name or clean(fault.filename)}': {fault.strerror or fault}.")
    except ValueError as fault:
        named = path is not None and path.name in str(fault)
        refuse(f"flexmb edit: {fault}" if named else f"flexmb edit: {name}: {fault}")


def _close(server: Server) -> None:
    """Close, and do not wait for ever for what cannot be interrupted."""

    def gone() -> None:
        sys.stdout.flush()
        os._exit(0)

    timer = threading.Timer(PATIENCE, gone)
    timer.daemon = True
    timer.start()
    server.close()
    timer.cancel()
    # A thread that still compiles would be torn down with the interpreter, which the compiler answers with an abort.
    if any(thread.name.startswith("flexmb ") for thread in threading.enumerate()):
        gone()


def _has_screen() -> bool:
    """Whether a browser can show itself; without a screen one in the terminal would take the keyboard."""
    named = "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ or "BROWSER" in os.environ
    return named or sys.platform in ("win32", "darwin")
