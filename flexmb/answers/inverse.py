"""Modes 2 and 3: what drives a mechanism along a trajectory, and its linearised equations there."""

import functools
from typing import Any

import numpy as np

from ..trajectory.inverse import Nominal
from .mode import Found, Mode, Question
from .motion import frequencies_at_ends, origins, over_time, steps_of
from .parts import SHOWN_VALUES, row
from .trajectory import nominal_motion


def told(found: Nominal, motion: Any = None) -> dict[str, Any]:
    """Times, coordinates, nominal inputs and reference outputs.

    Args:
        found: The nominal motion.
        motion: The motion to be told, where it is another.
    """
    motion = found.motion if motion is None else motion
    labels = motion.labels
    trajectory = over_time(motion.x, labels.x)
    return {
        "x": {node: rows[-1] for node, rows in trajectory.items()},
        "time": np.asarray(motion.t),
        "trajectory": trajectory,
        "velocities": over_time(motion.xd, labels.x),
        "inputs": [signal.name for signal in labels.inputs],
        "outputs": [signal.name for signal in labels.outputs],
        "u0": np.asarray(found.u0),
        "y0": np.asarray(found.y0) + origins(motion.model),
    }


def linearised(asked: Question, found: Nominal) -> dict[str, Any]:
    """The linearised equations at every time.

    Args:
        asked: What is asked, where warnings go.
        found: The nominal motion.
    """
    along, warnings = steps_of(found.motion)
    asked.warnings += warnings
    return along


def _run(asked: Question, matrices: bool = False) -> Found:
    """Inverse dynamics along the trajectory; with ``matrices`` those of the linearised equations at every time."""
    found, _ = nominal_motion(asked, 3 if matrices else 2)
    return Found({**told(found), **(linearised(asked, found) if matrices else {})}, found.motion)


def table(data: dict[str, Any]) -> list[str]:
    """Lines of the terminal of a motion along a trajectory."""
    if "time" not in data:
        return []
    times = np.asarray(data["time"])
    lines = [f"trajectory from 0 to {times[-1]:.6g} s, {len(times)} output times; at the end:"]
    lines += [f"  node {node:<7} {row(rows[-1])}" for node, rows in data["trajectory"].items()][:SHOWN_VALUES]
    for side, key in (("input", "u0"), ("output", "y0")):
        for name, values in zip(data[f"{side}s"][:SHOWN_VALUES], np.asarray(data[key]).T, strict=False):
            lines.append(f"  {side} {name}: {values.min():.6g} to {values.max():.6g}")
    return lines + frequencies_at_ends(data)


MODES = (
    Mode(2, "inverse", _run, table, needs=("trajectory", "times")),
    Mode(3, "trajectory-linearisation", functools.partial(_run, matrices=True), table, needs=("trajectory", "times")),
)
