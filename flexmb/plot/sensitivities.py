"""Bars of the effect of each dimension on each answer."""

from typing import Any

import numpy as np

from ..design.sensitivities import Sensitivities
from ..design.tolerance import Tolerances
from .canvas import plain_axes


def sensitivities(found: Sensitivities | Tolerances, *, ax: Any = None) -> Any:
    """Draw bars: the change of each answer for one percent of each dimension, or shares in the variance.

    Args:
        found: Result of ``fm.sensitivities`` or ``fm.tolerances``.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes: one group per dimension, the most important on top, and one colour per answer.

    Raises:
        TypeError: ``found`` has another type.
    """
    if isinstance(found, Sensitivities):
        bars, label = np.asarray(found.table), "percent of the answer for one percent of the dimension"
    elif isinstance(found, Tolerances):
        bars, label = 100 * np.asarray(found.shares), "share of the answer's variance [%]"
    else:
        known = "a result of fm.sensitivities(..) or fm.tolerances(..)"
        raise TypeError(f"Argument `found` must be {known}, but is a {type(found).__name__}.")
    ax = plain_axes(ax)
    finite = np.where(np.isfinite(bars), bars, 0.0)
    order = np.argsort(np.max(np.abs(finite), axis=0))
    height = 0.8 / len(found.answers)
    for i, answer in enumerate(found.answers):
        # Answers in their order from top to bottom.
        at = np.arange(len(order)) + (len(found.answers) / 2 - i - 0.5) * height
        drawn = ax.barh(at, finite[i, order], height=height, label=answer)
        texts = [f"{value:.3g}" if np.isfinite(value) else "no value" for value in bars[i, order]]
        ax.bar_label(drawn, texts, fontsize=7, padding=2)
    ax.set_yticks(np.arange(len(order)), [found.dimensions[k] for k in order])
    ax.axvline(0.0, color="#777777", linewidth=1.0)
    ax.margins(x=0.15)
    ax.set_xlabel(label)
    ax.grid(visible=True, axis="x", alpha=0.3)
    ax.legend(fontsize=8)
    return ax
