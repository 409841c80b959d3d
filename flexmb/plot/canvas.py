"""matplotlib in the plane and in space by the same few calls."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..linear.along import Series
from .geometry import Line, extent_of

# Colours that also those who see few colours, and printers, tell apart (Okabe and Ito).
BLUE, GREEN, RED, GREY, BLACK = "#0072B2", "#009E73", "#D55E00", "#BBBBBB", "#222222"
STYLES: dict[str, dict[str, Any]] = {
    "beam": {"color": BLUE, "linewidth": 2.0},
    "bar": {"color": BLUE, "linewidth": 1.2},
    "rigid": {"color": "#555555", "linewidth": 3.5},
    "spring": {"color": GREEN, "linewidth": 1.2},
    "joint": {"color": "#777777", "linewidth": 1.0},
}
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
# Share of the picture that arrows take.
ARROW = 0.15


def new_axes(dimension: int, ax: Any = None) -> Any:
    """Axes to draw a mechanism in.

    Args:
        dimension: 2 or 3.
        ax: Axes to use, or None for those of a new figure.

    Raises:
        ValueError: ``ax`` is not of that dimension.
    """
    if ax is None:
        import matplotlib.pyplot as plt

        return plt.figure(layout="constrained").add_subplot(projection="3d" if dimension == 3 else None)
    if (ax.name == "3d") != (dimension == 3):
        raise ValueError(
            f"Argument `ax` must be axes of {dimension} dimensions for this mechanism"
            + (": make them with projection='3d'." if dimension == 3 else ".")
        )
    return ax


def plain_axes(ax: Any = None) -> Any:
    """Axes for a curve.

    Args:
        ax: Axes to use, or None for those of a new figure.

    Raises:
        ValueError: ``ax`` are axes in space.
    """
    return new_axes(2, ax)


def prefixed(drawn: Series) -> tuple[float, str]:
    """By what to multiply a quantity so that it is read without powers of ten, and the label of its axis then.

    Args:
        drawn: The quantity.
    """
    if drawn.unit == "-" or "," in drawn.unit:
        return 1.0, drawn.axis
    factor, unit = prefix_for(largest_of(drawn.values), drawn.unit)
    return factor, f"{drawn.label} [{unit}]"


def largest_of(values: Any) -> float:
    """Largest size of the finite ones of some values, 0 of none."""
    values = np.abs(np.asarray(values, float))
    return float(np.max(values[np.isfinite(values)], initial=0.0))


def prefix_for(largest: float, unit: str) -> tuple[float, str]:
    """By what to multiply values up to a largest one so that they are read without powers of ten, and their unit then.

    Args:
        largest: The largest of them; the unit stays as it is where it is zero.
        unit: Their unit, SI without a prefix.
    """
    if not largest:
        return 1.0, unit
    power = int(np.clip(3 * np.floor(np.log10(largest * 1.0000001) / 3), -9, 9))
    return 10.0**-power, PREFIXES[power] + unit


def label_axis(axis: Any, name: str, unit: str, largest: float) -> str:
    """Label an axis with its unit; one in metres counts in millimetres or micrometres where that is shorter.

    What is drawn stays in metres, so that more can be drawn over it; the numbers along the axis alone are multiplied.

    Args:
        axis: An axis of matplotlib, or of a colour bar.
        name: What is along it.
        unit: Its unit; none is written where it is empty.
        largest: What the prefix is chosen by, the largest value or the extent.

    Returns:
        The unit that the axis counts in.
    """
    if unit == "m":
        factor, unit = prefix_for(largest, unit)
        # Few numbers, none of which is longer than it must be: round-off of the product is no digit.
        axis.set_major_formatter(lambda value, _: f"{round(value * factor, 6) + 0.0:.10g}")
    axis.set_label_text(f"{name} [{unit}]" if unit else name)
    return unit


def grid(count: int, dimension: int) -> tuple[Any, list[Any]]:
    """Figure with axes for several mechanisms, at most three in a row.

    Args:
        count: Number of axes.
        dimension: 2 or 3.

    Returns:
        Figure and axes.
    """
    import matplotlib.pyplot as plt

    columns = min(3, count)
    rows = -(-count // columns)
    figure = plt.figure(figsize=(4.2 * columns, 3.8 * rows), layout="constrained")
    projection = "3d" if dimension == 3 else None
    return figure, [figure.add_subplot(rows, columns, i + 1, projection=projection) for i in range(count)]


def polylines(ax: Any, lines: Sequence[Float[np.ndarray, "n d"]], label: str, values: Any = None, **style: Any) -> Any:
    """Many lines as one collection.

    Args:
        lines: Points of each, (n, d) [m].
        values: Number by which each line is coloured, or None.
        style: As for matplotlib's LineCollection.
    """
    from matplotlib.collections import LineCollection
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    kind = Line3DCollection if ax.name == "3d" else LineCollection
    style.setdefault("capstyle", "round")
    drawn = kind(lines, array=values, label=label, **style)
    (ax.add_collection3d if ax.name == "3d" else ax.add_collection)(drawn, autolim=False)
    return drawn


def mechanism_lines(ax: Any, lines: Sequence[Line], ghost: bool = False) -> None:
    """Elements in the style of their kind, each kind with its name as label.

    Args:
        ghost: Pale, all of them labelled "undeformed".
    """
    if ghost:
        drawn = [line.points for line in lines if line.kind != "hinge"]
        polylines(ax, drawn, "undeformed", color=GREY, linewidth=1.0, linestyle="--", zorder=1)
        return
    for kind, style in STYLES.items():
        own = [line.points for line in lines if line.kind == kind]
        if own:
            polylines(ax, own, kind, zorder=2, **style)
    if places := [line.points[0] for line in lines if line.kind == "hinge"]:
        marks(ax, np.array(places), "hinge", marker="o", markersize=8, color=BLACK, markerfacecolor="white", zorder=4)


def faces(ax: Any, quads: Sequence[Float[np.ndarray, "quads 4 d"]], label: str, color: str) -> None:
    """Half-transparent faces as one collection.

    Args:
        quads: Corners of the quadrilaterals of each element, (quads, 4, d) [m].
    """
    from matplotlib.collections import PolyCollection
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    if not quads:
        return
    style = {"facecolor": color, "edgecolor": "none", "alpha": 0.35, "label": label, "zorder": 1.5}
    corners: Any = np.concatenate(quads)
    if ax.name == "3d":
        ax.add_collection3d(Poly3DCollection(corners, **style), autolim=False)
    else:
        ax.add_collection(PolyCollection(corners, **style), autolim=False)


def marks(ax: Any, points: Float[np.ndarray, "n d"], label: str, **style: Any) -> None:
    """Markers without a line.

    Args:
        points: Where, (n, d) [m].
        style: As for matplotlib's plot.
    """
    if len(points):
        ax.plot(*np.asarray(points).T, linestyle="none", label=label, **style)


def arrow(ax: Any, start: Float[np.ndarray, "d"], vector: Float[np.ndarray, "d"], label: str, color: str) -> None:
    """Arrow from a point.

    Args:
        start: Where it begins, (d,) [m].
        vector: From its beginning to its end, (d,) [m].
    """
    if ax.name == "3d":
        ax.quiver(*start, *vector, color=color, label=label, arrow_length_ratio=0.25, linewidth=1.5)
    else:
        scaled = {"angles": "xy", "scale_units": "xy", "scale": 1.0}
        ax.quiver(*start, *vector, color=color, label=label, width=0.006, zorder=5, **scaled)


def write(ax: Any, point: Float[np.ndarray, "d"], text: str, **style: Any) -> None:
    """Text at a point.

    Args:
        point: Where, (d,) [m].
        style: As for matplotlib's text.
    """
    ax.text(*point, text, fontsize=8, zorder=6, **style)


def frame(ax: Any, points: Float[np.ndarray, "n d"], margin: float = 0.08) -> None:
    """Limits around points, equal scales and labels with units, of lengths with the prefix that suits the extent.

    Args:
        points: What must be seen, (n, d) [m].
        margin: Space around, as share of the extent.
    """
    around = margin * extent_of(points)
    low, high = np.min(points, axis=0) - around, np.max(points, axis=0) + around
    # A flat direction keeps some thickness, so that its axis can be read.
    size = np.maximum(high - low, 0.25 * np.max(high - low))
    for name, a, b, s in zip("xyz", low, high, size, strict=False):
        getattr(ax, f"set_{name}lim")((a + b - s) / 2, (a + b + s) / 2)
        axis = getattr(ax, f"{name}axis")
        label_axis(axis, name, "m", np.max(size))
        # A short side has room for few numbers.
        axis.set_major_locator(_ticks((4 if ax.name == "3d" else 6) * s / np.max(size)))
    if ax.name == "3d":
        ax.set_box_aspect(size, zoom=0.8)
        # A flat mechanism is seen from the side that shows it.
        thin = np.min(size[:2]) < 0.5 * np.max(size[:2])
        ax.view_init(elev=22, azim=-55 if not thin else 25 if size[0] < size[1] else -65)
    else:
        ax.set_aspect("equal", adjustable="box")


def _ticks(count: float) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(max(1, round(count)), min_n_ticks=1)
