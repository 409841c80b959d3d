"""The picture of an answer of the command line."""

import io
from typing import Any

import numpy as np

from .. import plot
from ..display import Result

# The same file for the same answer: no date in it, no random names.
CONSTANT: Any = {"backend": "agg", "svg.hashsalt": "flexmb"}
DATES = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


def image(answer: Any, format: str) -> bytes:
    """Draw an answer: by the picture that its mode names, or by that of its result.

    Args:
        answer: Answer of :func:`flexmb.answers.answers.answer`.
        format: "png", "svg" or "pdf".

    Returns:
        Content of the file.
    """
    return image_of(answer.lin if answer.picture else answer.shown, format, answer.picture)


def image_of(found: Result, format: str, picture: str = "") -> bytes:
    """Content of a file with the picture of a result: its own, or that which is named."""
    import matplotlib

    with matplotlib.rc_context(CONSTANT):
        import matplotlib.pyplot as plt

        figure = getattr(plot, picture)(found) if picture else _figure(found)
        buffer = io.BytesIO()
        figure.savefig(buffer, format=format, dpi=150, metadata=DATES.get(format))
        plt.close(figure)
    return buffer.getvalue()


def _figure(found: Result) -> Any:
    """The picture of a result; where it has several states, beside it where the mechanism ends."""
    import matplotlib.pyplot as plt

    draw, states = getattr(plot, found.summary().picture or "mechanism"), found.states()
    if states is None or np.ndim(states.x) == 1:
        return draw(found, **({"names": True} if draw is plot.mechanism else {})).figure
    figure = plt.figure(figsize=(10, 4.5), layout="constrained")
    draw(found, ax=figure.add_subplot(1, 2, 1))
    space = {"projection": "3d"} if states.model.labels.dimension == 3 else {}
    plot.mechanism(found, ax=figure.add_subplot(1, 2, 2, **space))
    return figure
