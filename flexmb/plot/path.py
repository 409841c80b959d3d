"""Equilibrium paths: any two of their quantities, with stable and unstable parts."""

from typing import Any

import numpy as np

from ..display import unit_of
from ..model.model import Labels
from ..numerical_limits import BETWEEN_ENDS
from ..paths.path import Path
from ..paths.sparse_path import SparsePath
from .canvas import BLACK, BLUE, GREY, RED, label_axis, largest_finite, plain_axes, prefixed

MARKERS = {"limit": "o", "bifurcation": "s"}
# Curves over a coordinate get their slope at the start, which shows how nonlinear the mechanism is.
FORCES = ("force", "moment", "reaction")
# States at the start from which the slope is taken.
FIRST = 4


def path(
    found: Path | SparsePath, of: str | None = None, *, x: str | None = None, y: str | None = None, ax: Any = None
) -> Any:
    """Draw the load factor over a coordinate, or any quantity over any other: solid if stable, dashed if unstable.

    ``fm.plot.path(found, x="displacement top.x", y="force top.x")`` is force against stroke, with the slope at the
    start as a thin line.

    Args:
        found: Path.
        of: Coordinate of the horizontal axis, such as "tip.y"; by default the coordinate that moves most.
        x: Quantity of the horizontal axis instead of ``of``, as for :meth:`flexmb.paths.Path.along`: "top.x",
            "displacement top.x", "force top.x", "reaction foot.x", "deformation leaf.2", "stress", "frequency 1",
            "stiffness top.y", "multiplier 1", "load factor".
        y: Quantity of the vertical axis, as for ``x``; by default the load factor.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes, with limit and bifurcation points marked.

    Raises:
        TypeError: ``found`` is not a Path.
        KeyError: A coordinate or quantity does not exist.
        ValueError: Both ``of`` and ``x`` are given.
    """
    if not isinstance(found, Path | SparsePath):
        raise TypeError(f"Argument `found` must be a result of fm.path(model), but is a {type(found).__name__}.")
    if of is not None and x is not None:
        raise ValueError("Arguments `of` and `x` both name the horizontal axis: give only `x`.")
    index = found.states().most_moving() if of is None else index_of(found.labels, of)
    plain = x is None and y is None
    asked = str(found.labels.x[index]) if x is None else x, "load factor" if y is None else y
    ax = plain_axes(ax)
    drawn = [found.along(text) for text in asked]
    points = found.at_critical_points() if found.critical_points else None
    critical = [np.zeros(0) if points is None else points.along(text).values for text in asked]
    if plain:
        units = [(1.0, with_unit(found.labels, index)), (1.0, drawn[1].axis)]
    else:
        units = [prefixed(quantity) for quantity in drawn]
    a, b = (quantity.values * factor for quantity, (factor, _) in zip(drawn, units, strict=True))
    ca, cb = (values * factor for values, (factor, _) in zip(critical, units, strict=True))
    if not plain and drawn[0].of == "coordinate" and drawn[1].of in FORCES:
        _draw_slope(ax, a, b)
    at, height, segment_stable = _with_critical((a, b), (ca, cb), found)
    for label, is_stable, style in (("stable", True, "-"), ("unstable", False, "--")):
        segments = _runs(at, height, segment_stable == is_stable)
        if len(segments):
            ax.plot(*segments.T, style, color=BLUE if is_stable else RED, label=label)
    for kind, marker in MARKERS.items():
        indices = [i for i, point in enumerate(found.critical_points) if point.kind == kind]
        if indices:
            ax.plot(ca[indices], cb[indices], marker, color=BLACK, markerfacecolor="white", label=f"{kind} point")
    ax.set(xlabel=units[0][1], ylabel=units[1][1])
    if plain:
        label_axis(ax.xaxis, str(found.labels.x[index]), drawn[0].unit, largest_finite(a))
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
    return ax


def _draw_slope(ax: Any, at: np.ndarray, height: np.ndarray) -> None:
    """Thin line with the slope of a curve at its start, from a polynomial through the first states."""
    a, b = at[:FIRST] - at[0], height[:FIRST] - height[0]
    if len(a) < 2 or np.any(np.diff(a) * np.sign(a[-1]) <= 0):
        return
    scale = a[-1]
    slope = np.polynomial.Polynomial.fit(a / scale, b, len(a) - 1, domain=[-1, 1]).deriv()(0.0) / scale
    ends = np.array([np.min(at), np.max(at)]) - at[0]
    reach = 1.05 * np.max(np.abs(height - height[0]))
    if slope:
        ends = np.clip(ends, -reach / abs(slope), reach / abs(slope))
    ax.plot(at[0] + ends, height[0] + slope * ends, "-", color=GREY, linewidth=0.9, label="slope at the start")


def index_of(labels: Labels, name: str) -> int:
    """Index in x of a coordinate such as "tip.y". Raises KeyError: No such coordinate."""
    for i, entry in enumerate(labels.x):
        if str(entry) == name:
            return i
    candidates = [str(entry) for entry in labels.x if entry.of == name.rpartition(".")[0] or entry.of == name]
    hint = f"; there is {', '.join(candidates)}" if candidates else "; write node and component, such as tip.y"
    raise KeyError(f"no coordinate '{name}' in this model{hint}")


def with_unit(labels: Labels, index: int) -> str:
    """Name of a coordinate with its unit."""
    return f"{labels.x[index]} [{unit_of(labels.x[index])}]"


def _with_critical(steps: Any, critical: Any, path_result: Path | SparsePath) -> tuple[np.ndarray, ...]:
    """Points of the path with the critical ones among them, and whether each piece between two points is stable.

    A piece is drawn as unstable if one of its ends is, and no critical point lies between.
    """
    (at, height), x, stable = steps, np.asarray(path_result.x), np.asarray(path_result.stable)
    remaining = list(zip(path_result.critical_points, *critical, strict=True))
    points, segment_stable = [(at[0], height[0])], []
    for i in range(1, len(at)):
        between = []
        while remaining and _between(remaining[0][0].x, x[i - 1 : i + 1]):
            between.append(remaining.pop(0))
        points += [(a, b) for _, a, b in between]
        points.append((at[i], height[i]))
        segment_stable += [stable[i - 1] if between else stable[i - 1] and stable[i]]
        segment_stable += [False] * max(len(between) - 1, 0) + ([stable[i]] if between else [])
    return np.array([p[0] for p in points]), np.array([p[1] for p in points]), np.array(segment_stable, bool)


def _between(x: np.ndarray, ends: np.ndarray) -> bool:
    """Whether a state lies within the ball on two others."""
    scale = np.where(np.ptp(ends, axis=0) > 0, np.ptp(ends, axis=0), np.inf)
    a, b, c = ends[0] / scale, ends[1] / scale, x / scale
    return bool((c - a) @ (c - b) <= BETWEEN_ENDS * ((b - a) @ (b - a)))


def _runs(at: np.ndarray, height: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Chosen pieces as one line with gaps, (n, 2)."""
    rows = []
    for i in np.flatnonzero(chosen):
        rows += [(at[i], height[i]), (at[i + 1], height[i + 1]), (np.nan, np.nan)]
    return np.array(rows)
