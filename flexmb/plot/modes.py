"""Vibration and buckling modes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arguments import check_number
from ..display import Result, States, kind_of
from ..linear.buckling import Buckling
from ..linear.modes import Modes
from ..model.model import Model
from ..numerical_limits import SMALLEST_SHAPE
from .canvas import BLUE, faces, figure_grid, frame_points, mechanism_lines
from .geometry import lines, nodes_of, point_extent, scaled_lines
from .mechanism import draw_supports
from .sections import across_of, shapes_of, strips
from .state import displaced

# Amplitude of modes over the extent of the mechanism.
AMPLITUDE = 0.15
# Step of the difference that finds the displacement of lines, which is linear in it within 1e-6.
STEP = 1e-6
# Largest turn of a section at that amplitude [rad].
LARGEST_TURN = 1.0
AT_MOST = 6


def modes(found: Modes | Buckling, which: Sequence[int] | int | None = None, *, amplitude: float = AMPLITUDE) -> Any:
    """Draw mode shapes over the state of the linearisation, with frequency or load multiplier in the title.

    Args:
        found: Vibration or buckling modes.
        which: Numbers of the modes, from 0; by default the first six.
        amplitude: Largest displacement in the picture, as a share of the mechanism's extent.

    Returns:
        matplotlib Figure, one Axes per mode.

    Raises:
        TypeError: ``found`` is neither Modes nor Buckling.
        ValueError: There is no such mode, or none at all.
    """
    states = found.states() if isinstance(found, Result) else None
    if states is None or states.moves is None:
        raise TypeError(f"A picture of modes needs fm.modes(model) or fm.buckling(model), not {kind_of(found)}.")
    check_number("amplitude", amplitude)
    chosen = drawn_modes(states, [which] if isinstance(which, int) else which, AT_MOST, "draw")
    figure, axes = figure_grid(len(chosen), states.model.labels.dimension)
    for ax, mode in zip(axes, chosen, strict=True):
        _draw(ax, states.model, np.asarray(states.x), np.asarray(states.moves[:, mode]), amplitude)
        ax.set_title(states.titles[mode])
    return figure


def drawn_modes(found: States, which: Sequence[int] | None, most: int, verb: str) -> list[int]:
    """Numbers of the modes that are wanted. Raises ValueError: There is no such mode, or none at all."""
    count = len(found.titles)
    chosen = list(range(min(count, most))) if which is None else list(which)
    if not chosen:
        raise ValueError(f"There is no mode to {verb}: no motion has mass, or no load acts in any.")
    if wrong := [mode for mode in chosen if not 0 <= mode < count]:
        raise ValueError(f"There is no mode {wrong[0]}: there are {count}, numbered from 0.")
    return chosen


def _draw(ax: Any, model: Model, x: np.ndarray, shape: np.ndarray, amplitude: float) -> None:
    still = lines(model, x)
    mechanism_lines(ax, still, ghost=True)
    factor = factor_of(model, x, shape, amplitude)
    step = STEP / (np.max(np.abs(shape), initial=0.0) or 1.0)
    after, scale = x + step * shape, factor / step
    drawn = scaled_lines(model, x, after, scale)
    mechanism_lines(ax, drawn)
    moved = displaced(model, after, scale, base=x)
    if model.labels.dimension == 3:
        faces(ax, list(strips(model, moved, drawn).values()), facecolor=BLUE)
    draw_supports(ax, model, {name: moved[indices] for name, indices in nodes_of(model).items()})
    frame_points(ax, np.concatenate([line.points for line in (*still, *drawn)]))


def factor_of(model: Model, x: np.ndarray, shape: np.ndarray, amplitude: float = AMPLITUDE) -> float:
    """Factor of a mode shape with which the largest displacement of a drawn point is ``amplitude`` times the extent.

    The factor is smaller if sections would turn by more than a radian, as in torsion.
    """
    size = np.max(np.abs(shape), initial=0.0) or 1.0
    states = (x, x + STEP / size * shape)
    before, after = (lines(model, at, straight=True) for at in states)
    points = np.concatenate([line.points for line in before])
    moved = np.concatenate([line.points for line in after]) - points
    shapes = shapes_of(model)
    sides = [across_of(model, at, state_lines, shapes) for at, state_lines in zip(states, (before, after), strict=True)]
    turned = [np.linalg.norm(sides[1][name] - start, axis=1) for name, start in sides[0].items()]
    rate = size / STEP
    extent = point_extent(points)
    largest = rate * np.max(np.linalg.norm(moved, axis=1)) / extent
    twist = rate * AMPLITUDE / LARGEST_TURN * np.max(turned, initial=0.0)
    # A mode that only turns points is drawn with a tenth of a radian.
    return amplitude / max(largest, twist) if max(largest, twist) > SMALLEST_SHAPE * size else 0.1 / size
