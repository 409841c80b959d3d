"""The picture of an answer of the command line."""

import io
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import plot
from ..display import Result
from ..linear.linearize import Linearization
from ..linear.stress import stress

# The same answer gives the same file: without date and random names.
CONSTANT: Any = {"backend": "agg", "svg.hashsalt": "flexmb"}
DATES = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


def image(answer: Any, format: str) -> bytes:
    """Content of a file with the picture of an answer: of its mode or result, and the stress if there is any."""
    stressed = answer.lin if answer.data.get("stress", {}).get("maximum") and not answer.picture else None
    return image_of(answer.lin if answer.picture else answer.shown, format, answer.picture, stressed)


def image_of(found: Result, format: str, picture: str = "", stressed: Linearization | None = None) -> bytes:
    """Content of a file with a picture of a result: its own or a named one."""

    def draw() -> Any:
        figure = getattr(plot, picture)(found) if picture else _figure(found)
        if stressed is not None:
            _add_stress(figure, stressed)
        return figure

    return figure_bytes(draw, format)


def figure_bytes(draw: Callable[[], Any], format: str, settings: Any = CONSTANT, dpi: float = 150) -> bytes:
    """Content of a file with a figure, which is then closed. The same figure gives the same bytes."""
    import matplotlib

    with matplotlib.rc_context(settings):
        import matplotlib.pyplot as plt

        figure = draw()
        buffer = io.BytesIO()
        figure.savefig(buffer, format=format, dpi=dpi, metadata=DATES.get(format))
        plt.close(figure)
    return buffer.getvalue()


def _figure(result: Result) -> Any:
    """The picture of a result; of several states also the mechanism in the last one."""
    import matplotlib.pyplot as plt

    draw, states = getattr(plot, result.summary().picture or "mechanism"), result.states()
    if states is None or np.ndim(states.x) == 1:
        return draw(result, **({"names": True} if draw is plot.mechanism else {})).figure
    figure = plt.figure(figsize=(10, 4.5), layout="constrained")
    draw(result, ax=figure.add_subplot(1, 2, 1))
    space = {"projection": "3d"} if states.model.labels.dimension == 3 else {}
    plot.mechanism(result, ax=figure.add_subplot(1, 2, 2, **space))
    return figure


def _add_stress(figure: Any, lin: Linearization) -> None:
    """Draw von Mises stress at the right of a figure."""
    from matplotlib.gridspec import GridSpec

    placed = [(ax, spec) for ax in figure.axes if (spec := ax.get_subplotspec()) is not None]
    rows, columns = placed[0][1].get_gridspec().get_geometry()
    grid, width = GridSpec(rows, columns + max(1, columns // 2), figure=figure), figure.get_figwidth()
    for ax, spec in placed:
        ax.set_subplotspec(grid[spec.rowspan.start : spec.rowspan.stop, spec.colspan.start : spec.colspan.stop])
    figure.set_figwidth(width * grid.ncols / columns)
    space = {"projection": "3d"} if lin.labels.dimension == 3 else {}
    plot.stress(stress(lin.model, at=lin), lin, ax=figure.add_subplot(grid[:, columns:], **space))
