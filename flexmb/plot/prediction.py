"""Predicted answers of a fitted mechanism, with bands, beside measured values."""

from typing import Any

import numpy as np

from ..display import kind_of
from ..identification.fitted import Prediction
from .canvas import BLACK, draw_band, plain_axes


def prediction(
    found: Prediction, over: Any = None, *, measured: Any = None, label: str = "", name: str = "", ax: Any = None
) -> Any:
    """Draw predicted values with a band of two standard deviations.

    Args:
        found: An entry of the result of ``fitted.predict``.
        over: Place of each value on the horizontal axis, (m,); by default the numbers from 1.
        measured: Values to draw as points, (m,) [unit of the answer].
        label: Name of the horizontal axis, such as "load [N]".
        name: Name of the vertical axis, such as "displacement [m]".
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes.

    Raises:
        TypeError: ``found`` is no prediction.
        ValueError: The numbers of values and places differ.
    """
    if not isinstance(found, Prediction):
        raise TypeError(f"A picture of a prediction needs an entry of fitted.predict(..), not {kind_of(found)}.")
    values, deviations = np.ravel(found.value), np.ravel(found.deviation)
    places = np.arange(1, len(values) + 1) if over is None else np.ravel(np.asarray(over, float))
    for what, given in (("over", places), ("measured", measured)):
        if given is not None and np.size(given) != len(values):
            raise ValueError(f"Argument `{what}` has {np.size(given)} numbers, but the prediction has {len(values)}.")
    ax = plain_axes(ax)
    draw_band(ax, places, values, deviations, "predicted")
    if measured is not None:
        ax.plot(places, np.ravel(measured), "o", color=BLACK, markersize=3, label="measured")
    ax.set(xlabel=label or "number", ylabel=name)
    ax.grid(visible=True, alpha=0.3)
    ax.legend(fontsize=8)
    return ax
