"""A mechanism over its stroke, on one page."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..design.judgement import Verdict
from ..display import prefix_of
from ..numerical_limits import NEGLIGIBLE
from .canvas import BLACK, GREY, RED, entitle, figure_grid

# Panels: title, first words of the curves' names, and whether they are drawn as share of the value at rest.
PANELS = (
    ("force of the drive", ("force",), False),
    ("support stiffness, share of the value at rest", ("stiffness",), True),
    ("natural frequencies, let go", ("frequency",), False),
    ("parasitic displacement", ("parasitic x", "parasitic y", "parasitic z"), False),
    ("parasitic rotation", ("parasitic phi", "parasitic rx", "parasitic ry", "parasitic rz"), False),
)


def verdict(found: Verdict) -> Any:
    """Draw force, shares of the limits, support stiffness, frequencies and parasitic motion over the stroke.

    Panels without data are left out. A red line marks the stroke at which the first limit is reached.

    Args:
        found: Result of ``fm.verdict``.

    Returns:
        matplotlib Figure.

    Raises:
        TypeError: ``found`` is no Verdict.
    """
    if not isinstance(found, Verdict):
        raise TypeError(f"Argument `found` must be a result of fm.verdict(..), but is a {type(found).__name__}.")
    by, prefix = prefix_of(float(np.max(np.abs(found.stroke))))
    drawn: list[tuple[str, Callable[[Any], None]]] = []
    for title, names, as_share in PANELS:
        if curves := _curves(found, names, as_share):
            drawn.append((title, lambda ax, curves=curves, as_share=as_share: _lines(ax, found, by, curves, as_share)))
    if any(np.any(np.isfinite(limit.used)) and np.nanmax(limit.used) > 0 for limit in found.limits):
        drawn.insert(1, ("share of each limit", lambda ax: _shares(ax, found, by)))
    elif "stress" in found.curves:
        drawn.insert(1, ("largest stress", lambda ax: _lines(ax, found, by, {"stress": found.curves["stress"]}, False)))
    figure, axes = figure_grid(len(drawn), size=(3.7, 2.9))
    # Room for the title of all.
    figure.set_figheight(figure.get_figheight() + 0.3)
    for ax, (title, draw) in zip(axes, drawn, strict=True):
        draw(ax)
        if found.limits and (stroke := found.limits[0].stroke) is not None:
            ax.axvline(stroke / by, color=RED, linewidth=1.0, linestyle="--")
        ax.set_title(title, fontsize=10)
        ax.set_xlabel(f"stroke {found.driven} [{prefix}{found.unit}]")
        ax.grid(visible=True, alpha=0.3)
        ax.tick_params(labelsize=8)
    entitle(figure, found.summary().title)
    return figure


def _curves(assessment: Verdict, names: tuple[str, ...], as_share: bool) -> dict[str, np.ndarray]:
    """Named curves in which there is something to see."""
    zero_stroke, curves = assessment.stroke == 0, {}
    for name, values in assessment.curves.items():
        finite = np.where(np.isfinite(values), values, np.nan)
        if not name.startswith(names) or np.sum(np.isfinite(finite)) < 2:
            continue
        straight = NEGLIGIBLE * np.max(np.abs(assessment.stroke))
        if name.startswith("parasitic") and np.nanmax(np.abs(finite)) <= straight:
            continue
        if not as_share:
            curves[name] = finite
        elif np.isfinite(finite[zero_stroke][0]):
            curves[name] = finite / finite[zero_stroke]
    return curves


def _lines(ax: Any, assessment: Verdict, by: float, curves: dict[str, np.ndarray], as_share: bool) -> None:
    """Curves over the stroke; of the force also its slope at the start."""
    from matplotlib.ticker import EngFormatter, PercentFormatter

    for name, values in curves.items():
        label = name.replace("frequency ", "f").split()[-1]
        ax.plot(assessment.stroke / by, values, ".-", label=label if label != name else None)
    if "force" in curves:
        zero_stroke = np.flatnonzero(assessment.stroke == 0)[0]
        slope = curves["force"][zero_stroke] + assessment.curves["drive stiffness"][zero_stroke] * assessment.stroke
        seen = ax.get_ylim()
        ax.plot(assessment.stroke / by, slope, color=GREY, linewidth=1.0, zorder=1, label="slope at rest")
        ax.set_ylim(seen)
    if as_share:
        ax.yaxis.set_major_formatter(PercentFormatter(1.0))
        ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    else:
        ax.yaxis.set_major_formatter(EngFormatter(unit=assessment.units[next(iter(curves))], sep=" "))
    if len(ax.lines) > 1 or not {"force", "stress"} & curves.keys():
        ax.legend(fontsize=8)


def _shares(ax: Any, assessment: Verdict, by: float) -> None:
    """Used share of each limit, and the limit as a line."""
    for limit in assessment.limits:
        used = np.where(np.isfinite(limit.used), limit.used, np.nan)
        if np.any(np.isfinite(used)):
            ax.plot(assessment.stroke / by, used, ".-", label=limit.name)
    ax.axhline(1.0, color=BLACK, linewidth=1.0)
    ax.set_ylim(0, max(1.1, min(2.0, ax.get_ylim()[1])))
    ax.legend(fontsize=8)
