"""Natural frequencies along a path or a motion."""

from typing import Any

import numpy as np

from ..arguments import check_whole
from ..display import unit_of
from ..linear.modes import frequencies as frequencies_of
from ..motion.motion import Motion
from ..paths.path import Path
from ..paths.sparse_path import SparsePath
from ..questions.frequency import frequencies_along
from ..statics.solver_choice import up_to
from .canvas import label_axis, largest_finite, plain_axes
from .modes import AT_MOST
from .path import index_of
from .state import states_of


def frequencies(
    found: Path | SparsePath | Motion, of: str | None = None, *, count: int = AT_MOST, ax: Any = None
) -> Any:
    """Draw natural frequencies along a path or a motion; they are negative if the motion grows.

    Along a motion, the frequencies belong to K0 + N0 + G0 and M0 at every time, without C0 and D0. Complex frequencies
    are left out.

    Args:
        found: Path or Motion.
        of: Coordinate of the horizontal axis, such as "tip.x"; by default the load factor or the time.
        count: Largest number of frequencies, from the lowest on.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes, one line per frequency.

    Raises:
        TypeError: ``found`` is neither a Path nor a Motion.
        KeyError: The coordinate does not exist.

    Source:
        THEORY.md 7.
    """
    if not isinstance(found, Path | SparsePath | Motion):
        raise TypeError(f"Argument `found` must be a Path or a Motion, but is a {type(found).__name__}.")
    count, states = check_whole("count", count, 1), states_of(found)
    if isinstance(found, SparsePath):
        most = up_to(count, found.model)
        hertz = np.asarray([frequencies_of(found.linearization(i), count=most) for i in range(len(found.x))])
    elif isinstance(found, Motion):
        hertz = frequencies_along(found.linearizations().matrices)
    else:
        hertz = np.asarray(found.frequencies)
    index = None if of is None else index_of(found.labels, of)
    along = states.along if index is None else states.x[:, index]
    ax = plain_axes(ax)
    drawn = hertz.T[:count]
    for i, row in enumerate(drawn):
        ax.plot(along, np.where(np.isfinite(row), row, np.nan), label=f"f{i + 1}")
    ax.set_xlabel(states.label)
    if index is not None:
        entry = found.labels.x[index]
        label_axis(ax.xaxis, str(entry), unit_of(entry), largest_finite(along))
    ax.set_ylabel("frequency [Hz]")
    ax.grid(visible=True, alpha=0.3)
    left_out = hertz.shape[1] - len(drawn)
    ax.legend(title=f"and {left_out} higher" if left_out > 0 else None)
    return ax
