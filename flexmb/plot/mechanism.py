"""The mechanism itself: elements, supports, degrees of freedom, loads and names."""

from typing import Any

import numpy as np

from ..model.model import Model
from ..numerical_limits import ROUND_OFF
from . import canvas
from . import marks as marked
from .canvas import ARROW, BLACK, BLUE, GREEN, RED, arrow, marks, mechanism_lines, write_text
from .geometry import lines, masses, nodes_of, point_extent, scaled_lines
from .sections import strips
from .state import displaced, state_of


def mechanism(
    shown: Any,
    *,
    at: Any = None,
    step: int | None = None,
    time: float | None = None,
    scale: float = 1.0,
    ghost: bool | None = None,
    supports: bool = True,
    dofs: bool = True,
    loads: bool = True,
    names: bool = False,
    sections: bool = True,
    ax: Any = None,
) -> Any:
    """Draw a mechanism, undeformed or in the state of a result.

    flexmb draws beams as cubic curves between their ends, spectral beams by their strains, and rigid elements thick. It
    draws springs with a law as zigzags, belts and gears with their circles, hinges and lumped masses as markers. It
    draws an element of your own by its function ``shape``, otherwise by its points and rotations.

    Args:
        shown: Model, Linearization, Path or Motion.
        at: State of a Model: equilibrium, configuration or linearisation; by default the undeformed state.
        step: Number of the step of a path or of the output time of a motion; by default the last.
        time: Time of a motion [s]. flexmb draws the nearest output time.
        scale: Factor of the displacements from the undeformed state.
        ghost: Draw the undeformed mechanism too; by default if the state is deformed.
        supports: Mark FIXED nodes (triangle: position, square: rotation too) and PRESCRIBED nodes (diamond).
        dofs: Draw arrows and names of the degrees of freedom that are coordinates.
        loads: Draw arrows of all nodal forces and moments, including incremental ones, each with its size. The longest
            arrow is the largest.
        names: Write the names of nodes and elements.
        sections: Draw beams with the width of their sections in space, and with the thickness in the plane. Sections
            given by rigidities have no outline.
        ax: matplotlib Axes to draw in, in space with ``projection="3d"``; by default new Axes.

    Returns:
        matplotlib Axes.

    Raises:
        TypeError: ``shown`` or ``at`` cannot be drawn.
        ValueError: ``at``, ``step``, ``time``, ``scale`` or ``ax`` does not fit.
    """
    model, state = state_of(shown, at, step, time)
    x = displaced(model, state, scale)
    reference = np.asarray(model.parameters.reference)
    ax = canvas.new_axes(model.labels.dimension, ax)
    seen = []
    moved = not np.allclose(x, reference, rtol=0, atol=ROUND_OFF)
    if moved if ghost is None else ghost:
        still = lines(model, reference)
        mechanism_lines(ax, still, ghost=True)
        seen += [line.points for line in still]
    drawn = scaled_lines(model, reference, state, scale)
    mechanism_lines(ax, drawn)
    quads = list(strips(model, x, drawn).values()) if sections else []
    canvas.faces(ax, quads, facecolor=BLUE)
    points = {name: x[indices] for name, indices in nodes_of(model).items()}
    seen = np.concatenate([*seen, *(line.points for line in drawn), np.array(list(points.values()))])
    marks(ax, np.array([x[i] for i in masses(model)]), "mass", marker="o", markersize=7, color=BLACK, zorder=3)
    if supports:
        draw_supports(ax, model, points)
    size = ARROW * point_extent(seen)
    ends = _dofs(ax, model, points, size) if dofs else []
    ends += _loads(ax, model, x, points, size) if loads else []
    if names:
        for name, point in points.items():
            write_text(ax, point, f" {name}", va="bottom")
        for line in drawn:
            middle = line.points[len(line.points) // 2]
            write_text(ax, middle, line.element, color="#777777", style="italic", ha="center")
    edges = [quad.reshape(-1, quad.shape[-1]) for quad in quads]
    canvas.frame_points(ax, np.concatenate([seen, *edges, *(end[None] for end in ends)]))
    canvas.spread_texts(ax)
    return ax


def draw_supports(ax: Any, model: Model, points: dict[str, np.ndarray]) -> None:
    """Draw markers at FIXED and PRESCRIBED nodes."""
    for (kind, names), marker in zip(marked.supports(model).items(), "s^D", strict=True):
        at = np.array([points[name] for name in names])
        marks(ax, at, kind, marker=marker, markersize=9, color=BLACK, markerfacecolor="none", zorder=4)


def _dofs(ax: Any, model: Model, points: dict[str, np.ndarray], size: float) -> list[np.ndarray]:
    """Arrow for each degree of freedom that is a position, name for each that is a rotation."""
    ends = []
    for dof in marked.dofs(model):
        start, vector = points[dof.node], np.zeros(model.labels.dimension)
        if dof.vector is not None:
            vector = size * dof.vector
            arrow(ax, start, vector, f"dof {dof.name}", GREEN)
        write_text(ax, start + 1.1 * vector, dof.text, color=GREEN, va="top")
        ends.append(start + vector)
    return ends


def _loads(ax: Any, model: Model, x: np.ndarray, points: dict[str, np.ndarray], size: float) -> list[np.ndarray]:
    """Arrows of nodal forces, scaled to the largest, and of moments along their axes; texts of moments in the plane."""
    load_marks = marked.loads(model, x)
    vectors = [load.vector for load in load_marks if load.kind == "force" and load.vector is not None]
    largest = max(map(np.linalg.norm, vectors), default=1.0)
    ends = []
    for load in load_marks:
        start = points[load.node]
        if load.vector is None:
            write_text(ax, start, load.text, color=RED, ha="left", va="bottom")
            continue
        moment = load.kind == "moment"
        along = size * load.vector / (np.linalg.norm(load.vector) if moment else largest)
        for length in (1.0, 0.8) if moment else (1.0,):
            arrow(ax, start, length * along, f"{load.kind} {load.name}", RED)
        write_text(ax, start + 1.1 * along, load.text, color=RED, ha="center")
        ends.append(start + along)
    return ends
