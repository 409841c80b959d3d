"""``fm.edit``: the workbench from a script or a notebook."""

from __future__ import annotations

import html
import os
import sys
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import warn
from .begin import session_of
from .server import Server

if TYPE_CHECKING:
    from ..build.builder import Builder
    from ..model.model import Model

# Height of the frame [px].
FRAME_HEIGHT = 760
# Environment variables by which a kernel tells that it runs on another machine than the browser.
REMOTE = {
    "JUPYTERHUB_USER": "JupyterHub",
    "BINDER_SERVICE_HOST": "Binder",
    "COLAB_RELEASE_TAG": "Colab",
    "KAGGLE_KERNEL_RUN_TYPE": "Kaggle",
    "CODESPACES": "Codespaces",
    "SSH_CONNECTION": "a machine that is reached by SSH",
}


def edit(model: Any = None, *, port: int = 0, browser: bool | None = None, **names: Any) -> Workbench:
    """Open the workbench: a page on which a mechanism is drawn and changed, with its answers beside it.

    In a notebook the page stands in the cell; in a script it opens in the browser, and ``.wait()`` keeps the script
    there until the keyboard ends it. The mechanism that was given stays as it is: take what was made from the result.

    Args:
        model: A :class:`flexmb.Builder`, a Model, what :func:`flexmb.read_spacar` returns, the path of a file (.dat, or
            .json as the workbench saves it), or a function that builds a mechanism of ``names``; None for a new one.
        port: Where to listen on this machine; 0 for any port that is free.
        browser: Whether to open the browser; by default outside of notebooks alone.
        names: Arguments of the function: numbers, or (value, lowest, highest), which get a slider each.

    Returns:
        The open workbench; ``.document``, ``.builder()``, ``.model()`` and ``.python()`` give what is in it.

    Raises:
        ModuleNotFoundError: websockets is not installed.
        OSError: The file cannot be read, or the port is taken.
        TypeError: The mechanism is none of these.
        ValueError: A file holds what cannot be opened.
    """
    from ..setup import enable_x64

    enable_x64()
    session = session_of(model, names)
    if session.notes:
        warn(f"The workbench does not hold all of it: {'; '.join(session.notes)}.")
    notebook = in_notebook()
    try:
        server = Server(session, port=port, framed=True)
    except BaseException:
        session.close()
        raise
    session.file.answers_at(server.port, server.token)
    server.start()
    if browser or (browser is None and not notebook):
        threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
    return Workbench(server)


class Workbench:
    """A workbench that is open.

    Attributes:
        address: Of its page, which holds the token: who has it can change the mechanism.
    """

    def __init__(self, server: Server):
        self._server = server
        self.address = server.address

    @property
    def document(self) -> Any:
        """What has been drawn, as it is now: names, and the calls that build the mechanism."""
        return self._server.session.history.document

    def builder(self) -> Builder:
        """A builder with the mechanism as it is now.

        Raises:
            ModelError: Something in it cannot be built; the message lists it.
        """
        return self._server.session.builder()

    def model(self) -> Model:
        """The mechanism as it is now.

        Raises:
            ModelError: As of :meth:`builder`, or the mechanism is not valid.
        """
        return self.builder().build()

    def python(self) -> str:
        """A script that builds the mechanism as it is now."""
        from .python_file import python_of

        return python_of(self.document)

    def save(self, path: str | os.PathLike) -> None:
        """Write the mechanism to a file: .dat, .py, or .json, which keeps everything.

        Args:
            path: Where.
        """
        self._server.session.save(Path(path))

    def wait(self) -> None:
        """Stay until the keyboard interrupts, and close: for scripts."""
        ended = threading.Event()
        try:
            # A plain wait would not let the interrupt through everywhere.
            while not ended.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """End the page; what was made can still be taken."""
        self._server.close()

    def __enter__(self) -> Workbench:
        return self

    def __exit__(self, *fault: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Workbench({self.address})"

    def _repr_html_(self) -> str:
        return frame(self.address, self._server.port)


def in_notebook() -> bool:
    """Whether this runs in the kernel of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def remote() -> str | None:
    """Where the kernel runs, where the browser is likely on another machine; otherwise None."""
    return next((name for variable, name in REMOTE.items() if os.environ.get(variable)), None)


def frame(address: str, port: int) -> str:
    """The page in a frame, with what to do where the browser does not reach it."""
    where = remote()
    beyond = (
        f"This kernel runs on {where}, and the page answers to its own machine alone: with"
        if where
        else "An empty frame? The page answers to the machine of the kernel alone; where that is not this one, with"
    )
    tunnel = f"ssh -L {port}:127.0.0.1:{port} MACHINE"
    link = html.escape(address, quote=True)
    note = (
        f'<p style="margin: 4px 0"><a href="{link}" target="_blank" rel="noreferrer">Open in a tab of its own</a>.'
        f" {html.escape(beyond)} <code>{tunnel}</code> it is reached from here.</p>"
    )
    page = (
        f'<iframe src="{link}" title="flexmb workbench" referrerpolicy="no-referrer"'
        f' style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
    )
    return note + page if where else page + note
