"""Equilibrium paths, stable and unstable parts apart."""

from typing import Any

import numpy as np

from ..display import unit_of
from ..model.model import Labels
from ..paths.path import Path
from .canvas import BLACK, BLUE, RED, plain_axes

MARKERS = {"limit": "o", "bifurcation": "s"}


def path(found: Path, of: str | None = None, *, ax: Any = None) -> Any:
    """Load factor over a coordinate: solid where the equilibrium is stable, dashed where it is not.

    Args:
        found: Path.
        of: Coordinate such as "tip.y"; the one that moves most unless given.
        ax: matplotlib Axes to draw in; new ones unless given.

    Returns:
        matplotlib Axes, with limit and bifurcation points marked.

    Raises:
        TypeError: ``found`` is not a Path.
        KeyError: No such coordinate.
    """
    if not isinstance(found, Path):
        raise TypeError(f"Argument `found` must be of fm.path(model), but is a {type(found).__name__}.")
    ax = plain_axes(ax)
    x, load = np.asarray(found.matrices.x), np.asarray(found.load_factor)
    index = found.states().most_moving() if of is None else index_of(found.labels, of)
    stable = np.asarray(found.stable)
    at, height, kept = _with_critical(x[:, index], load, stable, found, index)
    for label, wanted, style in (("stable", True, "-"), ("unstable", False, "--")):
        pieces = _runs(at, height, kept == wanted)
        if len(pieces):
            ax.plot(*pieces.T, style, color=BLUE if wanted else RED, label=label)
    for kind, marker in MARKERS.items():
        points = [(point.x[index], point.load_factor) for point in found.critical_points if point.kind == kind]
        if points:
            ax.plot(*np.array(points).T, marker, color=BLACK, markerfacecolor="white", label=f"{kind} point")
    ax.set_xlabel(with_unit(found.labels, index))
    ax.set_ylabel("load factor [-]")
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
    return ax


def index_of(labels: Labels, name: str) -> int:
    """Index in x of a coordinate such as "tip.y".

    Raises:
        KeyError: No such coordinate.
    """
    for i, entry in enumerate(labels.x):
        if str(entry) == name:
            return i
    own = [str(entry) for entry in labels.x if entry.of == name.rpartition(".")[0] or entry.of == name]
    hint = f"; there is {', '.join(own)}" if own else "; write node and component, such as tip.y"
    raise KeyError(f"no coordinate '{name}' in this model{hint}")


def with_unit(labels: Labels, index: int) -> str:
    """Name of a coordinate with its unit."""
    return f"{labels.x[index]} [{unit_of(labels.x[index])}]"


def _with_critical(at, load, stable, found: Path, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the path with the critical ones among them, and whether each piece between two points is stable.

    Critical points lie between the steps at which stability changes, in the order of the path; a piece that has an end
    in an unstable state, and no critical point between, is drawn as unstable.
    """
    left = list(found.critical_points)
    points, kept = [(at[0], load[0])], []
    for i in range(1, len(at)):
        between = []
        while left and _between(left[0].x, np.asarray(found.matrices.x)[i - 1 : i + 1]):
            between.append(left.pop(0))
        for point in between:
            points.append((point.x[index], point.load_factor))
        points.append((at[i], load[i]))
        kept += [stable[i - 1] if between else stable[i - 1] and stable[i]]
        kept += [False] * max(len(between) - 1, 0) + ([stable[i]] if between else [])
    return np.array([p[0] for p in points]), np.array([p[1] for p in points]), np.array(kept, bool)


def _between(x: np.ndarray, ends: np.ndarray) -> bool:
    """Whether a state lies between two others: within the ball around both."""
    scale = np.where(np.ptp(ends, axis=0) > 0, np.ptp(ends, axis=0), np.inf)
    a, b, c = ends[0] / scale, ends[1] / scale, x / scale
    return bool((c - a) @ (c - b) <= 1e-9 * ((b - a) @ (b - a)))


def _runs(at: np.ndarray, height: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Pieces that were chosen as one line with gaps, (n, 2)."""
    rows = []
    for i in np.flatnonzero(chosen):
        rows += [(at[i], height[i]), (at[i + 1], height[i + 1]), (np.nan, np.nan)]
    return np.array(rows)
