"""Stress and section resultants as colours."""

from typing import Any

import numpy as np

from ..display import kind_of
from ..linear.stress import SectionResultants, Stress
from ..model.model import Model
from ..numerical_limits import ROUND_OFF, SAME_PLACE_ON_LINE
from .canvas import BLACK, faces, frame_points, marks, mechanism_lines, new_axes, polylines, spread_texts, write_text
from .geometry import PLACES, Line, lines, nodes_of, point_extent, scaled_lines
from .sections import STRIDE, strips
from .state import checked_factor, displaced, state_of

SURFACE = {
    "von Mises": "von Mises stress [MPa]",
    "sigma_x": "normal stress σx [MPa]",
    "tau": "shear stress τ [MPa]",
    "across": "stress across [MPa]",
}


def stress(
    found: Stress | SectionResultants,
    shown: Any,
    quantity: str | None = None,
    *,
    step: int | None = None,
    scale: float = 1.0,
    ax: Any = None,
) -> Any:
    """Colour every flexible element by its stress, or by a force or moment in its sections, with a scale.

    A mark shows the largest value, with its element and node, or its place from 0 to 1 along the element. In space,
    flexmb draws rectangular sections with their width. It draws the undeformed mechanism pale if the state is deformed.
    The colour is the largest stress of the points of the section, with sign. flexmb interpolates between the places of
    the stress.

    Args:
        found: Stress or section resultants.
        shown: State of the stress: Equilibrium, Linearization, Model (drawn undeformed), or Path with ``step``.
        quantity: For a Stress: "von Mises", "sigma_x" or "tau"; with leaf springs "across"; with materials of known
            strength "utilisation". For stress and section resultants: "normal force", "shear force y", "shear force z",
            "torque", "bending moment y" or "bending moment z". Default: von Mises, or bending moment y.
        step: Number of the step of a path; by default the last.
        scale: Factor of the displacements.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes; the scale is beside them.

    Raises:
        TypeError: ``found`` is not a stress.
        ValueError: The quantity does not exist, or the elements are not elements of the model.
    """
    values, label = values_of(found, quantity)
    model, x = state_of(shown, step=step)
    reference = np.asarray(model.parameters.reference)
    drawn, still = scaled_lines(model, reference, x, checked_factor(scale)), lines(model, reference)
    if missing := set(found.names) - {line.element for line in drawn}:
        raise ValueError(f"The stress belongs to another model; this model has no element '{min(missing)}'.")
    ax = new_axes(model.labels.dimension, ax)
    if not np.allclose(x, reference, rtol=0, atol=ROUND_OFF):
        mechanism_lines(ax, still, ghost=True)
    mechanism_lines(ax, [line for line in drawn if line.element not in found.names])
    rows = {name: row for row, name in enumerate(found.names)}
    segments, colours, quads, shades = [], [], [], []
    widths = strips(model, displaced(model, x, scale), drawn) if model.labels.dimension == 3 else {}
    for line in drawn:
        if line.element in rows:
            along = np.interp(PLACES, np.asarray(found.places), values[rows[line.element]])
            segments += list(np.stack([line.points[:-1], line.points[1:]], axis=1))
            colours.append((along[:-1] + along[1:]) / 2)
            if line.element in widths:
                quads.append(widths[line.element])
                ends = along[::STRIDE]
                shades.append((ends[:-1] + ends[1:]) / 2)
    colours_name, low, high = colours_of(values, label)
    style: dict[str, Any] = {"cmap": colours_name, "clim": (low, high)}
    coloured = polylines(ax, segments, label, np.concatenate(colours), linewidth=3.0, zorder=3, **style)
    if quads:
        faces(ax, quads, alpha=0.6, array=np.concatenate(shades), **style)
    ax.figure.colorbar(coloured, ax=ax, label=label, shrink=0.8)
    edges = [quad.reshape(-1, 3) for quad in quads]
    frame_points(ax, np.concatenate([*(line.points for line in (*drawn, *still)), *edges]))
    _mark_largest(ax, model, found, values, label, drawn)
    spread_texts(ax)
    return ax


def _mark_largest(ax: Any, model: Model, result: Any, values: np.ndarray, label: str, drawn: list[Line]) -> None:
    """Ring around the largest value, with its size and place."""
    if not np.any(values):
        return
    row, column = np.unravel_index(np.argmax(np.abs(values)), values.shape)
    name, place = result.names[row], float(result.places[column])
    points = next(line.points for line in drawn if line.element == name)
    at = np.array([np.interp(place, PLACES, along) for along in points.T])
    marks(ax, at[None], "largest", marker="o", markersize=9, color=BLACK, markerfacecolor="none", zorder=5)
    # An end of an element is named by its node.
    reference = np.asarray(model.parameters.reference)
    line = next(line for line in lines(model, reference) if line.element == name).points
    end = {0.0: line[0], 1.0: line[-1]}.get(place)
    tolerance = SAME_PLACE_ON_LINE * point_extent(line)
    nodes = nodes_of(model).items() if end is not None else ()
    node = next((node_name for node_name, index in nodes if np.linalg.norm(reference[index] - end) <= tolerance), None)
    unit = label[label.rindex("[") + 1 : -1].strip("-")
    value_text = f"{values[row, column]:.4g} {unit}".strip()
    write_text(ax, at, f"  {value_text}, '{name}' at {node or format(place, '.3g')}", va="bottom")


def values_of(found: Any, quantity: str | None, *, of_states: bool = False) -> tuple[np.ndarray, str]:
    """Value at each place of each element, (elements, places), and the label with unit; in several states if allowed.

    For a stress: the largest value of the eight points of the surface, with its sign.
    """
    if not hasattr(found, "quantities"):
        known = "fm.stress(model) or fm.linear.section_resultants(model)"
        raise TypeError(f"Colours of stress need {known}, not {kind_of(found)}.")
    known = found.quantities()
    if quantity is None:
        quantity = "von Mises" if "von Mises" in known else "bending moment y"
    if quantity not in known:
        raise ValueError(f"Argument `quantity` must be one of {', '.join(known)}, but is '{quantity}'.")
    values, unit = known[quantity]
    if values.ndim > 2 and not of_states:
        advice = "draw one state, such as fm.stress(model, at=.., step=-1)"
        raise ValueError(f"This stress has {len(values)} states: {advice}.")
    return (values / 1e6, SURFACE[quantity]) if quantity in SURFACE else (values, f"{quantity} [{unit}]")


def colours_of(values: np.ndarray, label: str) -> tuple[str, float, float]:
    """Name of the colours for values, and the values at their ends: from zero, or symmetric about it."""
    largest = float(np.max(np.abs(values))) or 1.0
    positive = label.startswith(("von Mises", "utilisation"))
    return ("viridis", 0.0, largest) if positive else ("coolwarm", -largest, largest)
