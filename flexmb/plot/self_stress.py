"""Self-stress of an over-constrained mechanism: the elements that work against each other."""

from typing import Any

import numpy as np

from ..checks.mobility import Mobility
from ..display import kind_of
from .canvas import faces, frame_points, mechanism_lines, new_axes, polylines, spread_texts, write_text
from .geometry import lines, nodes_of
from .mechanism import draw_supports
from .sections import strips
from .state import states_of

# Resultants written beside an element if few elements take part, and if many do.
LABELS, FEW = (3, 1), 4


def self_stress(found: Mobility, state: int = 0, *, ax: Any = None) -> Any:
    """Colour every element by its stress in a state of self-stress, and name the deformation to release.

    The colour of an element is its largest stress resultant, scaled to 1 for the largest of all elements. A text beside
    the element lists its three largest resultants, or one if more than four elements are stressed. ``found.report()``
    lists all of them.

    Args:
        found: Over-constraints of a mechanism.
        state: Number of the state of self-stress, from 0.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes.

    Raises:
        TypeError: ``found`` is not a Mobility.
        ValueError: There is no such state.
    """
    if not isinstance(found, Mobility):
        raise TypeError(f"A picture of self-stress needs fm.mobility(model), not {kind_of(found)}.")
    if not 0 <= state < found.overconstraints:
        raise ValueError(f"There is no state of self-stress {state}: there are {found.overconstraints}, from 0.")
    states = states_of(found)
    model, x, part = states.model, states.x, (states.shares or ())[state]
    ax = new_axes(model.labels.dimension, ax)
    drawn = lines(model, x)
    text: dict[str, list[str]] = {}
    for share in found.stresses(state):
        text.setdefault(share.of, []).append(f"{share.symbol} {share.share:.2g}")
    mechanism_lines(ax, [line for line in drawn if line.element not in part])
    taking = [line for line in drawn if line.element in part]
    values = np.array([part[line.element] for line in taking])
    style: dict[str, Any] = {"cmap": "plasma_r", "clim": (0.0, 1.0), "linewidth": 4.0, "zorder": 3}
    coloured = polylines(ax, [line.points for line in taking], "self-stress", values, **style)
    if model.labels.dimension == 3:
        widths = {name: quads for name, quads in strips(model, x, drawn).items() if name in part}
        shades = np.concatenate([np.full(len(quads), part[name]) for name, quads in widths.items()] or [np.zeros(0)])
        faces(ax, list(widths.values()), array=shades, cmap=style["cmap"], clim=style["clim"])
    ax.figure.colorbar(coloured, ax=ax, label="largest stress resultant, relative [-]", shrink=0.8)
    most = LABELS[len(taking) > FEW]
    for line in taking:
        entries = text[line.element]
        more = ", …" if len(entries) > most else ""
        middle = line.points[len(line.points) // 2]
        write_text(ax, middle, f" {line.element}: {', '.join(entries[:most])}{more}", ha="left")
    draw_supports(ax, model, {name: x[index] for name, index in nodes_of(model).items()})
    ax.set_title(states.titles[state])
    frame_points(ax, np.concatenate([line.points for line in drawn]))
    spread_texts(ax)
    return ax
