"""Coordinates and energies over time."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..motion.motion import Motion
from .canvas import plain_axes
from .path import index_of, with_unit

ENERGIES = ("kinetic", "elastic", "potential", "energy")


def history(found: Motion, of: Sequence[str] | str | None = None, *, velocity: bool = False, ax: Any = None) -> Any:
    """Coordinates, velocities or energies of a motion over time.

    Args:
        found: Motion.
        of: Coordinates such as "mass.x", or energies: "kinetic", "elastic", "potential", "energy" (their sum). The
            coordinate that moves most unless given.
        velocity: Velocities of the coordinates in their place.
        ax: matplotlib Axes to draw in; new ones unless given.

    Returns:
        matplotlib Axes, one line for each.

    Raises:
        TypeError: ``found`` is not a Motion.
        KeyError: No such coordinate.
        ValueError: Energies and coordinates are asked for together.
    """
    if not isinstance(found, Motion):
        raise TypeError(f"Argument `found` must be of fm.simulate(model, times), but is a {type(found).__name__}.")
    ax = plain_axes(ax)
    x = np.asarray(found.x)
    wanted = [str(found.labels.x[found.states().most_moving()])] if of is None else [of] if isinstance(of, str) else of
    energies = [name for name in wanted if name in ENERGIES]
    if energies and len(energies) < len(wanted):
        raise ValueError("Energies and coordinates have different units: draw them in two pictures.")
    t = np.asarray(found.t)
    if energies:
        seen = found.observe()
        for name in energies:
            ax.plot(t, np.asarray(getattr(seen, name)), label=name)
        ax.set_ylabel("energy [J]")
    else:
        columns = np.asarray(found.xd if velocity else x)
        for name in wanted:
            index = index_of(found.labels, name)
            label = with_unit(found.labels, index)
            ax.plot(t, columns[:, index], label=f"d/dt {label[:-1]}/s]" if velocity else label)
        ax.set_ylabel("velocity" if velocity else "coordinate")
    ax.set_xlabel("time [s]")
    ax.grid(visible=True, alpha=0.3)
    ax.legend()
    return ax
