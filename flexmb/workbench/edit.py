"""``fm.edit``: the workbench from a script or a notebook."""

from typing import Any


def edit(model: Any = None) -> Any:
    """Open the workbench."""
    raise NotImplementedError
