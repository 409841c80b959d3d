"""matplotlib in the plane and in space by the same few calls."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..display import prefix_of
from ..linear.state_series import Series
from .geometry import Line, point_extent

# Colours that the colour-blind and printers tell apart (Okabe and Ito).
BLUE, GREEN, RED, GREY, BLACK = "#0072B2", "#009E73", "#D55E00", "#BBBBBB", "#222222"
STYLES: dict[str, dict[str, Any]] = {
    "beam": {"color": BLUE, "linewidth": 2.0},
    "bar": {"color": BLUE, "linewidth": 1.2},
    "rigid": {"color": "#555555", "linewidth": 3.5},
    "spring": {"color": GREEN, "linewidth": 1.2},
    "joint": {"color": "#777777", "linewidth": 1.0},
}
# Length of arrows over the extent of the picture.
ARROW = 0.15

# Letters of a title per inch.
LETTERS = 11.5


def new_axes(dimension: int, ax: Any = None) -> Any:
    """Axes to draw a mechanism in. Raises ValueError: ``ax`` is not of that dimension."""
    if ax is None:
        import matplotlib.pyplot as plt

        return plt.figure(layout="constrained").add_subplot(projection="3d" if dimension == 3 else None)
    if (ax.name == "3d") != (dimension == 3):
        advice = ": make them with projection='3d'" if dimension == 3 else ""
        raise ValueError(f"Argument `ax` must be axes of {dimension} dimensions for this mechanism{advice}.")
    return ax


def plain_axes(ax: Any = None) -> Any:
    """Axes for a curve. Raises ValueError: ``ax`` are axes in space."""
    return new_axes(2, ax)


def prefixed(drawn: Series) -> tuple[float, str]:
    """Factor by which a quantity is read without powers of ten, and the label of its axis then."""
    if drawn.unit == "-" or "," in drawn.unit:
        return 1.0, drawn.axis
    factor, unit = prefix_for(largest_finite(drawn.values), drawn.unit)
    return factor, f"{drawn.label} [{unit}]"


def largest_finite(values: Any) -> float:
    """Largest size of the finite values, 0 if there are none."""
    values = np.abs(np.asarray(values, float))
    return float(np.max(values[np.isfinite(values)], initial=0.0))


def prefix_for(largest: float, unit: str) -> tuple[float, str]:
    """Factor by which values up to a largest one are read without powers of ten, and their unit then."""
    by, prefix = prefix_of(largest)
    return 1 / by, prefix + unit


def label_axis(axis: Any, name: str, unit: str, largest: float) -> str:
    """Label an axis; return the unit of its numbers, a shorter one than metres although all is drawn in metres."""
    if unit == "m":
        from matplotlib.ticker import Formatter

        factor, unit = prefix_for(largest, unit)
        # Few and short numbers, without digits of the round-off.
        axis.set_major_formatter(lambda value, _: Formatter.fix_minus(f"{round(value * factor, 6) + 0.0:.10g}"))
    axis.set_label_text(f"{name} [{unit}]" if unit else name)
    return unit


def figure_grid(
    count: int, dimension: int = 2, *, size: tuple[float, float] = (4.2, 3.8), most: int = 3
) -> tuple[Any, list[Any]]:
    """Figure with several axes of a size, at most so many in a row; and the axes."""
    import matplotlib.pyplot as plt

    columns = min(most, count)
    rows = -(-count // columns)
    figure = plt.figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    projection = "3d" if dimension == 3 else None
    return figure, [figure.add_subplot(rows, columns, i + 1, projection=projection) for i in range(count)]


def draw_band(ax: Any, x: np.ndarray, values: np.ndarray, deviations: np.ndarray, label: str | None) -> None:
    """Draw a curve with a band of two standard deviations, left out where they are infinite."""
    width = np.where(np.isfinite(deviations), 2 * deviations, 0.0)
    ax.fill_between(x, values - width, values + width, color=BLUE, alpha=0.2, linewidth=0)
    ax.plot(x, values, color=BLUE, marker=".", linewidth=1, label=label)


def entitle(figure: Any, text: str) -> None:
    """Write a title above all panels, in lines as wide as the figure."""
    figure.suptitle(textwrap.fill(text, int(LETTERS * figure.get_figwidth())), fontsize=10)


def polylines(ax: Any, lines: Sequence[Float[np.ndarray, "n d"]], label: str, values: Any = None, **style: Any) -> Any:
    """Many lines as one collection."""
    from matplotlib.collections import LineCollection
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    kind = Line3DCollection if ax.name == "3d" else LineCollection
    style.setdefault("capstyle", "round")
    drawn = kind(lines, array=values, label=label, **style)
    (ax.add_collection3d if ax.name == "3d" else ax.add_collection)(drawn, autolim=False)
    return drawn


def mechanism_lines(ax: Any, lines: Sequence[Line], ghost: bool = False) -> None:
    """Elements in the style of their kind, labelled by the kind."""
    if ghost:
        drawn = [line.points for line in lines if line.kind != "hinge"]
        polylines(ax, drawn, "undeformed", color=GREY, linewidth=1.0, linestyle="--", zorder=1)
        return
    for kind, style in STYLES.items():
        polyline_points = [line.points for line in lines if line.kind == kind]
        if polyline_points:
            polylines(ax, polyline_points, kind, zorder=2, **style)
    if places := [line.points[0] for line in lines if line.kind == "hinge"]:
        marks(ax, np.array(places), "hinge", marker="o", markersize=8, color=BLACK, markerfacecolor="white", zorder=4)


def faces(ax: Any, quads: Sequence[Float[np.ndarray, "quads 4 d"]], **style: Any) -> None:
    """Half-transparent faces of sections as one collection: ``facecolor``, or ``array`` with a number for each."""
    from matplotlib.collections import PolyCollection
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    if not quads:
        return
    style = {"edgecolor": "none", "alpha": 0.35, "label": "section", "zorder": 1.5, **style}
    corners: Any = np.concatenate(quads)
    if ax.name == "3d":
        ax.add_collection3d(Poly3DCollection(corners, **style), autolim=False)
    else:
        ax.add_collection(PolyCollection(corners, **style), autolim=False)


def marks(ax: Any, points: Float[np.ndarray, "n d"], label: str, **style: Any) -> None:
    """Markers without a line."""
    if len(points):
        ax.plot(*np.asarray(points).T, linestyle="none", label=label, **style)


def arrow(ax: Any, start: Float[np.ndarray, "d"], vector: Float[np.ndarray, "d"], label: str, color: str) -> None:
    """Arrow from a point."""
    if ax.name == "3d":
        ax.quiver(*start, *vector, color=color, label=label, arrow_length_ratio=0.25, linewidth=1.5)
    else:
        scaled = {"angles": "xy", "scale_units": "xy", "scale": 1.0}
        ax.quiver(*start, *vector, color=color, label=label, width=0.006, zorder=5, **scaled)


def write_text(ax: Any, point: Float[np.ndarray, "d"], text: str, **style: Any) -> None:
    """Text at a point."""
    # Legible over lines.
    paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.6, "pad": 0.5}
    ax.text(*point, text, fontsize=8, zorder=6, bbox=paper, **style)


def frame_points(ax: Any, points: Float[np.ndarray, "n d"]) -> None:
    """Limits around points, equal scales, and labels with the unit that suits the extent."""
    from matplotlib.ticker import MaxNLocator

    around = 0.08 * point_extent(points)
    low, high = np.min(points, axis=0) - around, np.max(points, axis=0) + around
    # A flat direction keeps some thickness, to make its axis readable.
    size = np.maximum(high - low, 0.25 * np.max(high - low))
    for name, a, b, s in zip("xyz", low, high, size, strict=False):
        getattr(ax, f"set_{name}lim")((a + b - s) / 2, (a + b + s) / 2)
        axis = getattr(ax, f"{name}axis")
        label_axis(axis, name, "m", np.max(size))
        # A short side has room for few numbers.
        count = round((4 if ax.name == "3d" else 6) * s / np.max(size))
        axis.set_major_locator(MaxNLocator(max(1, count), min_n_ticks=1))
    if ax.name == "3d":
        ax.set_box_aspect(size, zoom=0.76)
        # A flat mechanism is viewed from its broad side.
        thin = np.min(size[:2]) < 0.5 * np.max(size[:2])
        ax.view_init(elev=22, azim=-55 if not thin else 25 if size[0] < size[1] else -65)
    else:
        ax.set_aspect("equal", adjustable="box")


def spread_texts(ax: Any) -> None:
    """Move the texts of a complete picture as little as it takes to lie over no other text, axis or colour bar."""
    from matplotlib.transforms import ScaledTranslation

    texts = [text for text in ax.texts if text.get_text().strip()]
    if not texts:
        return
    root = ax.figure.canvas.figure
    root.draw_without_rendering()
    # The area that the layout gave to these axes. Axes of equal scales fill part of it.
    bounds = ax.get_position(original=True).transformed(root.transSubfigure)
    occupied = [box for other in root.axes if other is not ax and (box := other.get_tightbbox()) is not None]
    occupied += _numbers_along(ax)
    boxes = [_box_of(text, ax).padded(1.0) for text in texts]
    for i in sorted(range(len(texts)), key=lambda i: -boxes[i].y0):
        moved = _free(boxes[i], bounds, occupied)
        occupied.append(moved)
        dx, dy = moved.x0 - boxes[i].x0, moved.y0 - boxes[i].y0
        shift = ScaledTranslation(dx / root.dpi, dy / root.dpi, root.dpi_scale_trans)
        texts[i].set_transform(texts[i].get_transform() + shift)


def _box_of(text: Any, ax: Any) -> Any:
    """Box of a text, on paper."""
    box = text.get_window_extent()
    if ax.name != "3d":
        return box
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    # A text in space has a place on paper only while it is drawn.
    x, y, z = text.get_position_3d()
    place = proj_transform(x, y, z, ax.M)[:2]
    return box.translated(*(ax.transData.transform(place) - ax.transData.transform(text.get_position())))


def _numbers_along(ax: Any) -> list[Any]:
    """Boxes of the numbers along the axes and of their labels, on paper."""
    boxes = []
    for name in "xyz"[: 3 if ax.name == "3d" else 2]:
        axis, (low, high) = getattr(ax, f"{name}axis"), sorted(getattr(ax, f"get_{name}lim")())
        # The ticks as drawn: functions that return the ticks of axes in space move them.
        boxes += [tick.label1.get_window_extent() for tick in axis.majorTicks if low <= tick.get_loc() <= high]
        boxes.append(axis.label.get_window_extent())
    return boxes


def _free(box: Any, bounds: Any, occupied: list[Any]) -> Any:
    """The nearest box within bounds that covers no other box; the box itself if there is none."""
    left, right = min(bounds.x0 - box.x0, 0.0), min(bounds.x1 - box.x1, 0.0)
    aside = right or (left if box.x0 < bounds.x0 else 0.0)
    across = aside + np.array([0.0, -0.25, 0.25, -0.5, 0.5, -1.0, 1.0]) * box.width
    steps = box.height / 2 * np.arange(-40, 41)
    shifts = sorted(((dx, dy) for dx in across for dy in steps), key=lambda shift: np.hypot(shift[0] - aside, shift[1]))
    for dx, dy in shifts:
        moved = box.translated(dx, dy)
        inside = moved.x0 >= bounds.x0 - 1 and moved.x1 <= bounds.x1 + 1
        inside = inside and moved.y0 >= bounds.y0 and moved.y1 <= bounds.y1
        if inside and not any(moved.overlaps(other) for other in occupied):
            return moved
    return box
