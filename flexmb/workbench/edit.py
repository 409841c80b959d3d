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
# Environment variables of kernels on another machine than the browser.
REMOTE = {
    "JUPYTERHUB_USER": "JupyterHub",
    "BINDER_SERVICE_HOST": "Binder",
    "COLAB_RELEASE_TAG": "Colab",
    "KAGGLE_KERNEL_RUN_TYPE": "Kaggle",
    "CODESPACES": "Codespaces",
    "SSH_CONNECTION": "a machine behind SSH",
}


def edit(model: Any = None, *, port: int = 0, browser: bool | None = None, **names: Any) -> Workbench:
    """Open the workbench: a page to draw and change a mechanism, with its answers beside it.

    A notebook shows the page in the cell; a script opens it in the browser, and ``.wait()`` waits for Ctrl-C. ``edit``
    does not change its argument: read the mechanism from the result.

    Args:
        model: A :class:`flexmb.Builder`, a Model, a result of :func:`flexmb.read_spacar`, the path of a file (.dat, or
            a .json of the workbench), or a function of ``names`` that builds a mechanism; None for a new mechanism.
        port: Port on this machine; 0 for any free port.
        browser: Whether to open the browser; by default only outside of notebooks.
        names: Arguments of the function: numbers, or (value, lowest, highest) for a slider.

    Returns:
        The open workbench, with ``.document``, ``.builder()``, ``.model()`` and ``.python()``.

    Raises:
        ModuleNotFoundError: websockets is not installed.
        OSError: The file cannot be read, or the port is taken.
        TypeError: The model has another type.
        ValueError: The contents of the file are wrong.

    Warns:
        FlexmbWarning: The document cannot contain a part of the mechanism.
    """
    from ..setup import enable_x64

    enable_x64()
    session = session_of(model, names)
    if session.notes:
        warn(f"The workbench cannot contain all of the mechanism: {'; '.join(session.notes)}.")
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    in_notebook = getattr(shell, "kernel", None) is not None
    try:
        server = Server(session, port=port, framed=True)
    except BaseException:
        session.close()
        raise
    session.file.answers_at(server.port, server.token)
    server.start()
    if browser or (browser is None and not in_notebook):
        threading.Thread(target=webbrowser.open, args=(server.address,), daemon=True).start()
    return Workbench(server)


class Workbench:
    """An open workbench.

    Attributes:
        address: Address of its page. It contains the token: anyone with the address can change the mechanism.
    """

    def __init__(self, server: Server):
        self._server = server
        self.address = server.address

    @property
    def document(self) -> Any:
        """Present document: names, and the calls that build the mechanism."""
        return self._server.session.history.document

    def builder(self) -> Builder:
        """Return a builder with the present mechanism.

        Raises:
            ModelError: A part cannot be built; the message lists all problems.
        """
        return self._server.session.builder()

    def model(self) -> Model:
        """Return the present mechanism.

        Raises:
            ModelError: As of :meth:`builder`, or the mechanism is not valid.
        """
        return self.builder().build()

    def python(self) -> str:
        """Return a script that builds the present mechanism."""
        from .python_file import python_of

        return python_of(self.document)

    def save(self, path: str | os.PathLike) -> None:
        """Write the mechanism to a file.

        Args:
            path: Path that ends in .dat, .py, or .json, which contains the whole document.
        """
        self._server.session.save(Path(path))

    def wait(self) -> None:
        """Wait for Ctrl-C, and close."""
        ended = threading.Event()
        try:
            # A plain wait would not pass the interrupt on some systems.
            while not ended.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Close the page; the results stay."""
        self._server.close()

    def __enter__(self) -> Workbench:
        return self

    def __exit__(self, *fault: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Workbench({self.address})"

    def _repr_html_(self) -> str:
        return page_frame(self.address, self._server.port)


def page_frame(address: str, port: int) -> str:
    """The page in a frame, with advice for a browser that cannot reach it."""
    where = next((name for variable, name in REMOTE.items() if os.environ.get(variable)), None)
    beyond = (
        f"This kernel runs on {where}, and only that machine can open the page. Forward the port to yours:"
        if where
        else "Is the frame empty? Only the machine of the kernel can open the page. Forward the port to yours:"
    )
    tunnel = f"ssh -L {port}:127.0.0.1:{port} MACHINE"
    link = html.escape(address, quote=True)
    note = (
        f'<p style="margin: 4px 0"><a href="{link}" target="_blank" rel="noreferrer">Open in a tab of its own</a>.'
        f" {html.escape(beyond)} <code>{tunnel}</code></p>"
    )
    page = (
        f'<iframe src="{link}" title="flexmb workbench" referrerpolicy="no-referrer"'
        f' style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
    )
    return note + page if where else page + note
