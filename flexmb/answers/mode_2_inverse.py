"""Mode 2: inverse dynamics along a trajectory; and functions that modes 3, 5 and 6 share with it."""

from typing import Any

import numpy as np

from ..trajectory.inverse import Nominal
from .answer_parts import SHOWN_VALUES, row
from .mode import Found, Mode, ModeRequest
from .mode_1_simulate import frequencies_at_ends, origins, over_time, steps_of
from .nominal_motion import nominal_motion


def told(found: Nominal, motion: Any = None) -> dict[str, Any]:
    """Times, coordinates, nominal inputs and reference outputs."""
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


def linearised(asked: ModeRequest, found: Nominal) -> dict[str, Any]:
    """The linearised equations at every time."""
    along, warnings = steps_of(found.motion)
    asked.warnings += warnings
    return along


def run(asked: ModeRequest, matrices: bool = False) -> Found:
    """Inverse dynamics along the trajectory; with ``matrices`` also the linearised equations at every time."""
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


MODE = Mode(run, table, needs=("trajectory", "times"))
