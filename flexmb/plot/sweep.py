"""Answers over the dimensions of many designs."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..design.swept import Sweep
from .canvas import BLUE, GREY, grid, plain_axes


def sweep(found: Sweep, answer: str | None = None, over: Sequence[str] | str | None = None, *, ax: Any = None) -> Any:
    """An answer over one dimension as a curve, over two as a map; designs that failed are grey crosses.

    Of a grid with more axes than are shown, the others are held at their middle value, which the title says. Other
    designs are points, coloured by the answer where two dimensions are shown.

    Args:
        found: Of ``fm.sweep``.
        answer: Name of the answer, of one number a design; each of them in Axes of its own unless given.
        over: One dimension or two; the first that vary unless given, at most two.
        ax: matplotlib Axes to draw in; new ones unless given.

    Returns:
        matplotlib Axes; a Figure of several without ``answer``.

    Raises:
        TypeError: ``found`` is not of ``fm.sweep``.
        KeyError: No such answer or dimension.
        ValueError: The answer has several numbers, or another number of dimensions than one or two is asked for.
    """
    if not isinstance(found, Sweep):
        raise TypeError(f"Argument `found` must be of fm.sweep(..), but is a {type(found).__name__}.")
    if answer is None:
        names = [name for name, values in found.answers.items() if values.ndim == 1]
        figure, axes = grid(max(len(names), 1), 2)
        for name, own in zip(names, axes, strict=False):
            sweep(found, name, over, ax=own)
        return figure
    if answer not in found.answers:
        raise KeyError(f"no answer '{answer}'; there are {', '.join(found.answers)}")
    if found.answers[answer].ndim != 1:
        raise ValueError(f"Answer '{answer}' has several numbers a design: sweep one of them.")
    shown = _shown(found, over)
    ax = plain_axes(ax)
    z = found.answers[answer]
    failed = ~np.isfinite(z)
    titles = []
    kept = np.ones(len(z), bool)
    for name, values in found.axes.items():
        if name not in shown:
            middle = values[len(values) // 2]
            kept &= np.asarray(found.designs[name]) == middle
            titles.append(f"{name} = {middle:.4g}")
    places = [np.asarray(found.designs[name])[kept] for name in shown]
    z, failed = z[kept], failed[kept]
    label = _label(found, answer)
    if len(shown) == 1:
        order = np.argsort(places[0])
        style = {"marker": "."} if found.axes else {"marker": ".", "linestyle": "none"}
        ax.plot(places[0][order], z[order], color=BLUE, label=label, **style)
        low = np.nanmin(z) if np.any(~failed) else 0.0
        ax.plot(places[0][failed], np.full(failed.sum(), low), "x", color=GREY, label="failed")
        ax.set_ylabel(label)
    else:
        _map(ax, found, shown, places, z, failed, label)
        ax.set_ylabel(_label(found, shown[1]))
    ax.set_xlabel(_label(found, shown[0]))
    ax.set_title(", ".join(titles), fontsize=9)
    return ax


def _shown(found: Sweep, over: Sequence[str] | str | None) -> list[str]:
    scalars = [name for name, values in found.designs.items() if np.ndim(values) == 1]
    if over is None:
        shown = [name for name in scalars if np.ptp(np.asarray(found.designs[name])) > 0][:2]
    else:
        shown = [over] if isinstance(over, str) else list(over)
    for name in shown:
        if name not in scalars:
            raise KeyError(f"no dimension '{name}' of one number; there are {', '.join(scalars)}")
    if len(shown) not in (1, 2):
        raise ValueError(f"Show one dimension or two, not {len(shown)}: name them with `over`.")
    return shown


def _map(ax: Any, found: Sweep, shown: list[str], places: list[np.ndarray], z, failed, label: str) -> None:
    """Colours over two dimensions: fields with contours of a grid, points otherwise."""
    x, y = places
    if found.axes:
        columns, rows = (np.asarray(found.axes[name]) for name in shown)
        field = np.full((len(rows), len(columns)), np.nan)
        field[np.searchsorted(rows, y), np.searchsorted(columns, x)] = z
        drawn = ax.pcolormesh(columns, rows, field, shading="nearest", cmap="viridis")
        if min(field.shape) > 2 and np.nanmin(field) < np.nanmax(field):
            lines = ax.contour(columns, rows, field, colors="white", linewidths=0.8)
            ax.clabel(lines, fontsize=7)
    else:
        drawn = ax.scatter(x[~failed], y[~failed], c=z[~failed], s=12, cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=label)
    ax.plot(x[failed], y[failed], "x", color=GREY, label="failed")


def _label(found: Sweep, name: str) -> str:
    unit = found.units.get(name)
    return f"{name} [{unit}]" if unit else name
