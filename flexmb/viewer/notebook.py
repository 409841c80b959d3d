"""Results in notebooks: a small table of the main numbers, and a small picture."""

import base64
import html
import io
from collections.abc import Mapping
from typing import Any

from .. import plot
from ..display import Result
from ..plot.answer import figure_bytes

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
    """Small picture of a result as PNG in base64, with a palette, as notebooks keep every picture."""
    from PIL import Image

    # The first figure loads a backend for good, even within a context. It must be the user's backend.
    settings = {"font.size": 9}
    picture = figure_bytes(lambda: getattr(plot, name)(result, **small).figure, "png", settings, DOTS_PER_INCH)
    buffer = io.BytesIO()
    Image.open(io.BytesIO(picture)).convert("RGB").quantize(COLOURS).save(buffer, format="png", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode()
