"""The run of a search for dimensions."""

from typing import Any

import numpy as np

from ..design.tune import Tuned


def tuning(found: Tuned) -> Any:
    """Objective, violation, dimensions and answers at every evaluation of a search.

    Dimensions and answers are drawn relative to their first value. The vertical line marks the design that is returned.

    Args:
        found: Of ``fm.tune``.

    Returns:
        matplotlib Figure with four Axes: objective, violation, dimensions, answers.

    Raises:
        TypeError: ``found`` is not of ``fm.tune``.
    """
    if not isinstance(found, Tuned):
        raise TypeError(f"Argument `found` must be of fm.tune(..), but is a {type(found).__name__}.")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(9, 6), sharex=True, layout="constrained")
    objective, violation, dimensions, answers = axes.ravel()
    count = np.arange(1, found.evaluations + 1)
    objective.plot(count, found.history["objective"])
    objective.set_ylabel("objective [-]")
    # Nothing violated is no point of a logarithmic axis.
    positive = found.history["violation"] > 0
    violation.semilogy(count[positive], found.history["violation"][positive], marker=".", linestyle="none")
    violation.set_ylabel("violation [-]")
    for ax, names, label in (
        (dimensions, found.dimensions, "dimension over its start [-]"),
        (answers, found.answers, "answer over its start [-]"),
    ):
        for name in names:
            _relative(ax, count, name, np.asarray(found.history[name], float))
        ax.set_ylabel(label)
        ax.set_xlabel("evaluation")
        ax.legend(fontsize=8)
    for ax in axes.ravel():
        ax.axvline(_returned(found), color="#777777", linewidth=1.0, linestyle=":")
        ax.grid(visible=True, alpha=0.3)
    figure.suptitle(f"{found.result.name}: {found.reason}", fontsize=10)
    return figure


def _relative(ax: Any, count: np.ndarray, name: str, values: np.ndarray) -> None:
    """Lines of a quantity, all its entries, over the first value."""
    for place in np.ndindex(values.shape[1:]):
        own = values[(slice(None), *place)]
        first = own[0] if np.isfinite(own[0]) and own[0] != 0 else 1.0
        label = name + (f"[{', '.join(map(str, place))}]" if place else "")
        ax.plot(count, own / first, label=label)


def _returned(found: Tuned) -> int:
    """Number of the evaluation whose dimensions are those returned, or the nearest to them."""
    distance = np.zeros(found.evaluations)
    for name, value in found.dimensions.items():
        along = np.asarray(found.history[name], float).reshape(found.evaluations, -1)
        wanted = np.asarray(value, float).ravel()
        size = np.maximum(np.abs(wanted), 1e-300)
        distance += np.sum(((along - wanted) / size) ** 2, axis=1)
    return 1 + int(np.argmin(distance))
