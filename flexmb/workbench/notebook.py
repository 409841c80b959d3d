"""The workbench in a notebook: its page in a frame of the cell."""

import html
import os
import sys

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
