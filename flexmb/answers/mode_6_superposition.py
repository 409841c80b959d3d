"""Mode 6: the motion along a trajectory with the vibrations about it, by the perturbation method."""

import functools
from typing import Any

import numpy as np

from .mode import Mode
from .mode_2_inverse import table
from .mode_5_perturbation import run


def _table(data: dict[str, Any]) -> list[str]:
    lines = table(data)
    for i, d in enumerate(data["dofs"] if "dq" in data else []):
        values = np.asarray(data["dq"])[:, i]
        lines.append(f"  vibration {d['kind']} {d['of']}.{d['component']}: {values.min():.6g} to {values.max():.6g}")
    return lines


MODE = Mode(functools.partial(run, integrated=True), _table, needs=("trajectory", "times"))
