"""Quantities of a motion, such as coordinates, forces, stress and energies, over time or over each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..display import unit_of
from ..motion.motion import Motion
from ..questions.energies import ENERGIES
from .canvas import label_axis, largest_finite, plain_axes, prefixed
from .path import index_of, with_unit


def history(
    found: Motion,
    of: Sequence[str] | str | None = None,
    *,
    velocity: bool = False,
    x: str | None = None,
    y: str | None = None,
    ax: Any = None,
) -> Any:
    """Draw coordinates, velocities, energies or other quantities of a motion over time, or one over another.

    Args:
        found: Motion.
        of: Coordinates such as "mass.x", energies ("kinetic", "elastic", "potential", "energy" as their sum), or other
            quantities of :meth:`flexmb.motion.Motion.along` with one unit: "force mass.x", "reaction foot.x",
            "deformation leaf.2", "stress", "stress leaf". By default the coordinate that moves most.
        velocity: Draw the velocities of the coordinates instead.
        x: Quantity of the horizontal axis, such as "displacement mass.x"; by default the time.
        y: One quantity of the vertical axis, instead of ``of``.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes, one line per quantity.

    Raises:
        TypeError: ``found`` is not a Motion.
        KeyError: A coordinate or quantity does not exist.
        ValueError: Quantities have different units, or arguments exclude each other.
    """
    if not isinstance(found, Motion):
        raise TypeError(f"Argument `found` must be a result of fm.simulate(..), but is a {type(found).__name__}.")
    if (x is not None or y is not None) and (of is not None or velocity):
        raise ValueError("Arguments `x` and `y` name the quantities to draw: leave `of` and `velocity` out.")
    most = str(found.labels.x[found.states().most_moving()])
    ax = plain_axes(ax)
    if x is not None or y is not None:
        _draw_over(ax, found, x or "time", [y or most])
    else:
        names = [most] if of is None else [of] if isinstance(of, str) else list(of)
        coordinates = {str(entry) for entry in found.labels.x}
        energies = [name for name in names if name in ENERGIES]
        if energies and len(energies) < len(names):
            raise ValueError("Energies and coordinates have different units: draw two pictures.")
        if velocity and energies:
            raise ValueError(f"Argument `velocity` is for coordinates, and '{energies[0]}' is an energy: leave it out.")
        if velocity or energies or coordinates.issuperset(names):
            _draw_over_time(ax, found, names, velocity)
        else:
            _draw_over(ax, found, "time", names)
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
    return ax


def _draw_over(ax: Any, motion: Motion, over: str, names: Sequence[str]) -> None:
    """Quantities of one unit over another, with prefixes of their units."""
    across, drawn = motion.along(over), [motion.along(name) for name in names]
    if len({quantity.unit for quantity in drawn}) > 1:
        units_text = ", ".join(f"'{quantity.label}' [{quantity.unit}]" for quantity in drawn)
        raise ValueError(f"Quantities have different units; draw two pictures: {units_text}.")
    factor, label = prefixed(across) if over != "time" else (1.0, across.axis)
    joined = drawn[0]._replace(values=np.concatenate([quantity.values for quantity in drawn]))
    size, first = prefixed(joined)
    for quantity in drawn:
        ax.plot(across.values * factor, quantity.values * size, label=quantity.label)
    ax.set_xlabel(label)
    kinds = dict.fromkeys(quantity.of for quantity in drawn)
    ax.set_ylabel(first if len(drawn) == 1 else f"{' and '.join(kinds)} {first[first.rindex('[') :]}")


def _draw_over_time(ax: Any, motion: Motion, names: Sequence[str], velocity: bool) -> None:
    """Energies, coordinates or their velocities over time."""
    t = np.asarray(motion.t)
    if names[0] in ENERGIES:
        seen = motion.observe()
        for name in names:
            ax.plot(t, np.asarray(getattr(seen, name)), label=name)
        ax.set_ylabel("energy [J]")
    else:
        columns = np.asarray(motion.xd if velocity else motion.x)
        indices = [index_of(motion.labels, name) for name in names]
        units = {unit_of(motion.labels.x[index]) for index in indices}
        # One unit stands beside the axis, where its prefix is; several in the legend.
        for index in indices:
            label = str(motion.labels.x[index]) if len(units) == 1 and not velocity else with_unit(motion.labels, index)
            ax.plot(t, columns[:, index], label=f"d/dt {label[:-1]}/s]" if velocity else label)
        ax.set_ylabel("velocity" if velocity else "coordinate")
        if len(units) == 1 and not velocity:
            label_axis(ax.yaxis, "coordinate", min(units), largest_finite(columns[:, indices]))
    ax.set_xlabel("time [s]")
