"""Measured values beside the values of a fitted mechanism, their differences, and the correlation of the parameters."""

from typing import Any

import numpy as np

from ..identification.fitted import Fit
from ..identification.measurement import Measured
from .canvas import BLACK, BLUE, RED, draw_band, entitle, figure_grid

# Names of parameters are written beside the correlation up to so many.
NAMED = 12


def fit(found: Fit) -> Any:
    """Draw each measurement beside the fitted model, differences in standard deviations, and correlations.

    Bars and bands extend two standard deviations to each side. Bars show the scatter of the measured values. Bands show
    the scatter of the fitted curve due to the scatter of the data, and the scatter of the differences. A curve that
    depends on an undetermined combination of parameters has no band.

    Args:
        found: Result of ``fm.fit``.

    Returns:
        matplotlib Figure with Axes for each measurement, the differences, and the correlation of several parameters.

    Raises:
        TypeError: ``found`` is no result of ``fm.fit``.
    """
    if not isinstance(found, Fit):
        raise TypeError(f"Argument `found` must be a result of fm.fit(..), but is a {type(found).__name__}.")
    several = len(found.labels) > 1
    figure, axes = figure_grid(len(found.data) + 1 + several, size=(4.5, 3.4))
    for ax, item in zip(axes, found.data, strict=False):
        _beside(ax, item, found.computed[item.name], found.computed_deviation[item.name])
    _differences(axes[len(found.data)], found)
    if several:
        image = axes[-1].imshow(found.correlation, cmap="RdBu", vmin=-1, vmax=1)
        figure.colorbar(image, ax=axes[-1], label="correlation [-]")
        if len(found.labels) <= NAMED:
            axes[-1].set_xticks(range(len(found.labels)), found.labels, rotation=45, ha="right")
            axes[-1].set_yticks(range(len(found.labels)), found.labels)
    entitle(figure, f"{found.result.name}: {found.reason}")
    return figure


def _beside(ax: Any, item: Measured, computed: np.ndarray, band: np.ndarray) -> None:
    places = np.arange(1, len(item.values) + 1) if item.over is None else item.over
    spread = None if item.deviation is None else 2 * item.deviation
    ax.errorbar(places, item.values, spread, fmt="o", color=BLACK, markersize=3, linewidth=1, label="measured")
    # A response has real parts first, then imaginary parts at the same places.
    turns = np.flatnonzero(np.diff(places) < 0) + 1
    for part in np.split(np.arange(len(places)), turns):
        draw_band(ax, places[part], computed[part], band[part], "fitted" if part[0] == 0 else None)
    ax.set(xlabel=item.label or "number", ylabel=item.name)
    ax.grid(visible=True, alpha=0.3)
    ax.legend(fontsize=8)


def _differences(ax: Any, fit_result: Fit) -> None:
    rows = np.concatenate([fit_result.residuals[item.name] for item in fit_result.data]) / (fit_result.noise or 1.0)
    ax.axhspan(-2, 2, color=BLACK, alpha=0.1)
    ax.plot(np.arange(1, len(rows) + 1), rows, ".", color=BLUE)
    far = np.flatnonzero(np.abs(rows) > 3)
    ax.plot(far + 1, rows[far], "o", color=RED, fillstyle="none")
    ax.set(xlabel="value", ylabel="computed less measured [deviations]")
    ax.grid(visible=True, alpha=0.3)
