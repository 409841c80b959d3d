"""Results in notebooks: a small table of the main numbers, and a small picture."""

import base64
import html
import io
from collections.abc import Mapping
from typing import Any

from .. import plot
from ..display import Result

DOTS_PER_INCH = 60
COLOURS = 32


def card(found: Result) -> str | None:
    """Summary of a result as HTML without a script: a table beside a picture; None if it has neither."""
    _, rows, picture, small = found.summary()
    if not rows and picture is None:
        return None
    cells = "".join(
        f'<tr><th style="text-align: left">{html.escape(name)}</th>'
        f'<td style="text-align: left">{html.escape(text)}</td></tr>'
        for name, text in rows.items()
    )
    name, image = type(found).__name__, ""
    if picture is not None and small is not None:
        image = f'<img alt="{name}" src="data:image/png;base64,{_picture(found, picture, small)}">'
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: center">'
        f"<table><caption>{name}</caption>{cells}</table>{image}</div>"
    )


def _picture(result: Result, name: str, small: Mapping[str, Any]) -> str:
    """Small picture of a result as PNG in base64."""
    import matplotlib
    import matplotlib.pyplot as plt

    # The first figure loads a backend for good, even within a context. It must be the user's backend.
    with matplotlib.rc_context({"font.size": 9}):
        figure = getattr(plot, name)(result, **small).figure
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
        plt.close(figure)
    return base64.b64encode(_small(buffer)).decode()


def _small(picture: io.BytesIO) -> bytes:
    """A PNG with a palette, as notebooks keep every picture."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.open(picture).convert("RGB").quantize(COLOURS).save(buffer, format="png", optimize=True)
    return buffer.getvalue()
