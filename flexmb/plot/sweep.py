"""Answers of many designs, over their dimensions and over each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..design.robust import Robustness
from ..design.swept import Front, Sweep
from .canvas import BLUE, GREY, RED, figure_grid, label_axis, largest_finite, plain_axes

# More designs are drawn as density: their markers would cover each other.
MANY = 2000
# Most hexagons in a row, and mean number of designs in a hexagon.
HEXAGONS, EACH = 60, 16


def sweep(
    found: Sweep | Front | Robustness,
    answer: str | None = None,
    over: Sequence[str] | str | None = None,
    *,
    x: str | None = None,
    y: str | None = None,
    ax: Any = None,
) -> Any:
    """Draw an answer over one dimension (curve), over two (map), or over another answer with the Pareto front.

    If a grid has more axes than the picture, the other dimensions have their middle value, and the title states it.
    Designs without a grid are points; over two dimensions, the answer colours them. More than 2000 points become
    hexagons. Over two dimensions their colour is the mean answer, otherwise the number of designs. Failed designs are
    grey if they have a position, and the title states their number.

    Args:
        found: Result of ``fm.sweep`` or ``fm.design.robustness``, or a front by ``pareto``, whose designs are marked.
        answer: Name of the answer, or of an entry such as "frequencies[0]"; by default each answer of one number, in
            separate Axes.
        over: One dimension or two; by default the first two that vary.
        x: Quantity of the horizontal axis, instead of ``answer`` and ``over``: an answer, a dimension or an entry. For
            a front by default its first criterion.
        y: Quantity of the vertical axis; for a front by default its second criterion.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes; without ``answer`` and ``ax`` a Figure with Axes for each answer.

    Raises:
        TypeError: ``found`` is no result of ``fm.sweep``.
        KeyError: An answer or dimension does not exist.
        ValueError: The answer, or each answer, has several numbers; ``over`` is not one or two dimensions; ``x`` is
            given without ``y``; or ``ax`` is given for several answers.
    """
    if isinstance(found, Robustness):
        found = found.samples
    if not isinstance(found, Sweep | Front):
        raise TypeError(f"Argument `found` must be a result of fm.sweep(..), but is a {type(found).__name__}.")
    front = found if isinstance(found, Front) else None
    sweep_result = front.whole if front else found
    assert isinstance(sweep_result, Sweep)
    if front and answer is None and over is None:
        names = [*front.criteria, *sweep_result.designs]
        x = names[0] if x is None else x
        y = next((name for name in names if name != x), None) if y is None else y
    if x is not None or y is not None:
        if x is None or y is None:
            raise ValueError("Give both `x` and `y`, the names of the quantities of both axes.")
        if answer is not None or over is not None:
            raise ValueError("Give either `x` and `y`, or `answer` and `over`.")
        return _against(sweep_result, front, x, y, plain_axes(ax))
    if answer is None:
        names = [name for name, values in sweep_result.answers.items() if values.ndim == 1]
        if not names:
            example = f"{next(iter(sweep_result.answers), 'f')}[0]"
            raise ValueError(f"No answer is one number; name an entry, such as '{example}'.")
        if ax is not None and len(names) > 1:
            why = f"there are {len(names)} answers of one number, each with Axes of its own"
            raise ValueError(f"Argument `ax` needs `answer`: {why}. Choose one of {', '.join(names)}.")
        if ax is None:
            figure, axes = figure_grid(len(names))
            for name, panel in zip(names, axes, strict=False):
                sweep(found, name, over, ax=panel)
            return figure
        answer = names[0]
    if answer in sweep_result.designs:
        raise KeyError(f"'{answer}' is a dimension; there are the answers {', '.join(sweep_result.answers)}")
    z = sweep_result.column(answer)
    dimensions = _dimensions_to_draw(sweep_result, over)
    ax = plain_axes(ax)
    titles = []
    mask = np.ones(len(z), bool)
    for name, values in sweep_result.axes.items():
        if name not in dimensions:
            middle = np.sort(values)[len(values) // 2]
            mask &= np.asarray(sweep_result.designs[name]) == middle
            titles.append(f"{name} = {middle:.4g}")
    places = [np.asarray(sweep_result.designs[name])[mask] for name in dimensions]
    z = z[mask]
    failed = ~np.isfinite(z)
    unit = sweep_result.unit_of(answer)
    label = f"{answer} [{unit}]" if unit else answer
    if len(dimensions) == 1:
        _curve(ax, sweep_result, places[0], z, label)
    else:
        _map(ax, sweep_result, dimensions, places, z, label)
    if front:
        front_rows = front.rows[mask[front.rows]]
        at = [sweep_result.column(name)[front_rows] for name in [*dimensions, answer][:2]]
        ax.plot(*at, "o", color=RED, fillstyle="none", markersize=5, label="front")
    _name(ax.yaxis, sweep_result, answer if len(dimensions) == 1 else dimensions[1])
    _name(ax.xaxis, sweep_result, dimensions[0])
    _title(ax, titles, failed)
    return ax


def _against(sweep_result: Sweep, front: Front | None, x: str, y: str, ax: Any) -> Any:
    """One number of each design over another; designs of the front are marked and joined."""
    horizontal, vertical = sweep_result.column(x), sweep_result.column(y)
    failed = ~(np.isfinite(horizontal) & np.isfinite(vertical))
    _points(ax, horizontal[~failed], vertical[~failed], "designs")
    if front:
        rows = front.rows[np.argsort(horizontal[front.rows])]
        # A front of two criteria is a line. Of more criteria it would zigzag.
        line = "-" if set(front.criteria) == {x, y} else "none"
        style = {"color": RED, "marker": "o", "markersize": 4, "linewidth": 1.2, "linestyle": line}
        ax.plot(horizontal[rows], vertical[rows], label=f"front, {len(rows)} designs", zorder=3, **style)
        ax.legend(fontsize=8)
    _name(ax.xaxis, sweep_result, x)
    _name(ax.yaxis, sweep_result, y)
    _title(ax, [], failed)
    return ax


def _points(ax: Any, x: np.ndarray, y: np.ndarray, label: str) -> None:
    """Markers of designs, or their density where markers would cover each other."""
    if len(x) <= MANY:
        ax.plot(x, y, ".", color=BLUE, markersize=4, label=label)
        return
    import matplotlib as mpl
    from matplotlib.colors import ListedColormap

    # A single design needs a marker to be seen.
    colours = ListedColormap(mpl.colormaps["Blues"](np.linspace(0.25, 1, 256)))
    drawn = ax.hexbin(x, y, bins="log", cmap=colours, **_hexagons(x))
    ax.figure.colorbar(drawn, ax=ax, label="number of designs")


def _curve(ax: Any, sweep_result: Sweep, x: np.ndarray, z: np.ndarray, label: str) -> None:
    """An answer over one dimension: a line of a grid, points of other designs."""
    failed = ~np.isfinite(z)
    if sweep_result.axes:
        order = np.argsort(x)
        ax.plot(x[order], z[order], color=BLUE, label=label, marker=".")
    else:
        _points(ax, x[~failed], z[~failed], label)
    low = np.nanmin(z) if np.any(~failed) else 0.0
    _failed(ax, x[failed], np.full(failed.sum(), low), len(x))


def _map(
    ax: Any, sweep_result: Sweep, dimensions: list[str], places: list[np.ndarray], z: np.ndarray, label: str
) -> None:
    """An answer over two dimensions: fields with contours of a grid, points or hexagons of other designs."""
    x, y = places
    failed = ~np.isfinite(z)
    if sweep_result.axes:
        # Axes of a grid may have any order.
        columns, rows = (np.unique(sweep_result.axes[name]) for name in dimensions)
        field = np.full((len(rows), len(columns)), np.nan)
        field[np.searchsorted(rows, y), np.searchsorted(columns, x)] = z
        drawn = ax.pcolormesh(columns, rows, field, shading="nearest", cmap="viridis")
        if min(field.shape) > 2 and np.nanmin(field) < np.nanmax(field):
            lines = ax.contour(columns, rows, field, colors="white", linewidths=0.8)
            ax.clabel(lines, fontsize=7)
    elif len(z) > MANY:
        drawn = ax.hexbin(x[~failed], y[~failed], C=z[~failed], reduce_C_function=np.mean, **_hexagons(z))
        label = f"{label}, mean"
    else:
        drawn = ax.scatter(x[~failed], y[~failed], c=z[~failed], s=12, cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=label)
    _failed(ax, x[failed], y[failed], len(x))


def _failed(ax: Any, x: np.ndarray, y: np.ndarray, count: int) -> None:
    """Failed designs, drawn below the hexagons."""
    style = {"marker": "x"} if count <= MANY else {"marker": ".", "markersize": 3, "zorder": 0}
    ax.plot(x, y, color=GREY, linestyle="none", label="failed", **style)


def _hexagons(values: np.ndarray) -> dict[str, Any]:
    """Style of hexagons for a number of designs."""
    return {"gridsize": int(np.clip((len(values) / EACH) ** 0.5, 10, HEXAGONS)), "mincnt": 1, "linewidths": 0.2}


def _title(ax: Any, titles: list[str], failed: np.ndarray) -> None:
    """Title with held dimensions and the number of failed designs; few ticks, as numbers of small lengths are long."""
    ax.locator_params(axis="x", nbins=6)
    failures = [f"{np.sum(failed)} of {len(failed)} designs failed"] if np.any(failed) else []
    ax.set_title(", ".join([*titles, *failures]), fontsize=9)


def _dimensions_to_draw(sweep_result: Sweep, over: Sequence[str] | str | None) -> list[str]:
    scalars = [name for name, values in sweep_result.designs.items() if np.ndim(values) == 1]
    if over is None:
        dimensions = [name for name in scalars if np.ptp(np.asarray(sweep_result.designs[name])) > 0][:2]
    else:
        dimensions = [over] if isinstance(over, str) else list(over)
    for name in dimensions:
        if name not in scalars:
            raise KeyError(f"no dimension '{name}' of one number; there are {', '.join(scalars)}")
    if len(dimensions) not in (1, 2):
        raise ValueError(f"Draw over one dimension or two, not {len(dimensions)}: name them with `over`.")
    return dimensions


def _name(axis: Any, sweep_result: Sweep, name: str) -> None:
    """Label an axis."""
    label_axis(axis, name, sweep_result.unit_of(name), largest_finite(sweep_result.column(name)))
