"""The run of a search for dimensions."""

from typing import Any

import numpy as np

from ..design.tuned import Tuned
from .canvas import BLACK, BLUE, GREY, entitle

# Most entries of a quantity with colours of their own, and most lines in a column of a legend.
MOST_LINES = 6


def tuning(found: Tuned) -> Any:
    """Draw objective, violation, dimensions and answers at every evaluation of a search, and target curves.

    Dimensions and answers are relative to their first value. The vertical line marks the returned design. A target
    curve is drawn over its places: wanted, at the start, and found.

    Args:
        found: Result of ``fm.tune``.

    Returns:
        matplotlib Figure with Axes for objective, violation (if any), dimensions, answers that are no curves, and each
        curve.

    Raises:
        TypeError: ``found`` is no result of ``fm.tune``.
    """
    if not isinstance(found, Tuned):
        raise TypeError(f"Argument `found` must be a result of fm.tune(..), but is a {type(found).__name__}.")
    import matplotlib.pyplot as plt

    others = [name for name in found.answers if name not in found.curves]
    # A logarithmic axis has no zero.
    positive = found.history["violation"] > 0
    panels = 2 + bool(np.any(positive)) + bool(others)
    columns = -(-(panels + len(found.curves)) // 2)
    figure = plt.figure(figsize=(4.5 * columns, 6), layout="constrained")
    axes: list[Any] = []
    for i in range(panels + len(found.curves)):
        axes.append(figure.add_subplot(2, columns, 1 + i, sharex=axes[0] if 0 < i < panels else None))
    waiting = iter(axes)
    count, ax = np.arange(1, found.evaluations + 1), next(waiting)
    ax.plot(count, found.history["objective"])
    ax.set_ylabel("objective [-]")
    if np.any(positive):
        ax = next(waiting)
        ax.semilogy(count[positive], found.history["violation"][positive], marker=".", linestyle="none")
        ax.set_ylabel("violation [-]")
    for names, label in ((list(found.dimensions), "dimension"), (others, "answer")):
        if names:
            ax = next(waiting)
            for name in names:
                _relative(ax, count, name, np.asarray(found.history[name], float))
            ax.set_ylabel(f"{label} over its start [-]")
            ax.legend(fontsize=8, ncols=1 + len(ax.get_legend_handles_labels()[0]) // (MOST_LINES + 1))
    for ax in axes[:panels]:
        ax.axvline(_returned(found), color="#777777", linewidth=1.0, linestyle=":")
        ax.set_xlabel("evaluation")
    for ax, (name, curve) in zip(waiting, found.curves.items(), strict=True):
        ax.plot(curve.over, curve.values, color=BLACK, linestyle="--", label="wanted", zorder=3)
        ax.plot(curve.over, np.asarray(found.start[name]), color=GREY, marker=".", label="start")
        ax.plot(curve.over, np.asarray(found.answers[name]), color=BLUE, marker=".", label="found")
        ax.set(ylabel=name, xlabel=curve.label)
        ax.legend(fontsize=8)
    for ax in axes:
        ax.grid(visible=True, alpha=0.3)
    entitle(figure, f"{found.result.name}: {found.reason}")
    return figure


def _relative(ax: Any, count: np.ndarray, name: str, values: np.ndarray) -> None:
    """Lines of all entries of a quantity over its first value; many entries share a colour."""
    places = list(np.ndindex(values.shape[1:]))
    color = ax.plot([], [], label=f"{name}, {len(places)} entries")[0].get_color() if len(places) > MOST_LINES else None
    for place in places:
        entry_values = values[(slice(None), *place)]
        first = entry_values[0] if np.isfinite(entry_values[0]) and entry_values[0] != 0 else 1.0
        label = name + (f"[{', '.join(map(str, place))}]" if place else "")
        ax.plot(count, entry_values / first, label=label if color is None else None, color=color)


def _returned(tuned: Tuned) -> int:
    """Number of the evaluation with the returned dimensions, or the nearest to them."""
    distance = np.zeros(tuned.evaluations)
    for name, value in tuned.dimensions.items():
        along = np.asarray(tuned.history[name], float).reshape(tuned.evaluations, -1)
        returned = np.asarray(value, float).ravel()
        size = np.maximum(np.abs(returned), 1e-300)
        distance += np.sum(((along - returned) / size) ** 2, axis=1)
    return 1 + int(np.argmin(distance))
