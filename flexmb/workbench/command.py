"""The command ``flexmb edit``: serve one session until Ctrl-C."""

from __future__ import annotations

import os
import signal
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..errors import SpacarError, printable

if TYPE_CHECKING:
    from .server import Server
    from .session import Session

# Longest time to wait at the end for computations [s]; then the process ends without them.
PATIENCE = 15.0


class _EndedError(Exception):
    """A signal ends the program."""


def serve(
    path: Path | None, port: int, browser: bool, *, tell: Callable[[str], None], refuse: Callable[[str], NoReturn]
) -> None:
    """Serve a file, or a new mechanism, until Ctrl-C or another signal ends the process."""

    def end(*_: object) -> None:
        # Further signals are ignored, since the end takes time.
        for signal_number in before:
            signal.signal(signal_number, signal.SIG_IGN)
        raise _EndedError

    before = {signal_number: signal.signal(signal_number, end) for signal_number in (signal.SIGINT, signal.SIGTERM)}
    server = None
    try:
        server = _server(path, port, refuse)
        server.start()
        tell(server.address)
        if browser and _has_screen():
            threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
        while True:
            # A longer wait would delay the signal on some systems.
            threading.Event().wait(0.5)
    except _EndedError:
        pass
    finally:
        if server is not None:
            _close(server)
        for signal_number, handler in before.items():
            signal.signal(signal_number, handler)


def _server(path: Path | None, port: int, refuse: Callable[[str], NoReturn]) -> Server:
    """A server with its port and its session."""
    try:
        import websockets  # noqa: F401
    except ModuleNotFoundError:
        refuse("flexmb edit: the workbench needs the package websockets: pip install 'flexmb[workbench]'.")
    from ..setup import enable_cache, enable_x64

    enable_x64()
    try:
        # Structures change often: short compilation matters more than run time.
        enable_cache(thorough=False)
    except OSError:
        # Without a writable cache folder the program is only slower.
        pass
    session = _session(path, refuse)
    known = session.file.place.known() if session.file.place is not None else {}
    from .server import Server

    # The last port and token, so that an open page finds this server.
    for tried in (port,) if port else (known.get("port", 0), 0):
        try:
            server = Server(session, port=tried, token=known.get("token"))
        except OSError as fault:
            if tried and not port:
                continue
            session.close()
            refuse(f"flexmb edit: port {tried} is taken: {fault.strerror or fault}. --port 0 takes any free port.")
        session.file.answers_at(server.port, server.token)
        return server
    raise AssertionError


def _session(path: Path | None, refuse: Callable[[str], NoReturn]) -> Session:
    from .begin import TakenError, session_of_file, session_of_new

    name = None if path is None else printable(path)
    try:
        return session_of_new() if path is None else session_of_file(path)
    except TakenError as fault:
        refuse(f"flexmb edit: {fault}")
    except SpacarError as fault:
        refuse(str(fault))
    except OSError as fault:
        refuse(f"flexmb edit: cannot read '{name or printable(fault.filename)}': {fault.strerror or fault}.")
    except ValueError as fault:
        named = path is not None and path.name in str(fault)
        refuse(f"flexmb edit: {fault}" if named else f"flexmb edit: {name}: {fault}")


def _close(server: Server) -> None:
    """Close, but do not wait for ever: compiling cannot be interrupted."""

    def gone() -> None:
        sys.stdout.flush()
        os._exit(0)

    timer = threading.Timer(PATIENCE, gone)
    timer.daemon = True
    timer.start()
    server.close()
    timer.cancel()
    # The compiler would abort the process if the interpreter ended a compiling thread.
    if any(thread.name.startswith("flexmb ") for thread in threading.enumerate()):
        gone()


def _has_screen() -> bool:
    """Whether a browser has a screen; a browser in the terminal would take the keyboard."""
    named = "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ or "BROWSER" in os.environ
    return named or sys.platform in ("win32", "darwin")
