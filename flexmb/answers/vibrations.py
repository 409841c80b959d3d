"""Modes 5 and 6: the perturbation method about the motion along a trajectory."""

import functools
from typing import Any

import numpy as np

from ..model.model import Model
from ..trajectory.vibrations import Perturbation, perturbation
from .inverse import linearised, table, told
from .mode import Found, Mode, Question
from .motion import RTOL
from .trajectory import nominal_motion


def _force(found: Any) -> np.ndarray:
    """Force on the degrees of freedom once what held them is let go, (n_t, n_q) [N, N m]."""
    return -np.asarray(found.f0)


def _start(model: Model, led: list[str]) -> np.ndarray:
    """Velocities at the start of what is not led along the trajectory, (n_q,)."""
    names = model.q_labels
    given = np.zeros(len(names)) if model.parameters.start is None else np.asarray(model.parameters.start[1])
    return np.where([name in led for name in names], 0.0, given)


def _run(asked: Question, integrated: bool = False) -> Found:
    """The linearised equations with the force on what is let go; with ``integrated`` also what vibrates then."""
    found, led = nominal_motion(asked, 6 if integrated else 5)
    along = linearised(asked, found)
    for step, force in zip(along["steps"], _force(found), strict=True):
        step["f0"] = force
    if not integrated:
        return Found({**told(found), **along}, found.motion)
    if not found.motion.model.topology.n_q:
        # Nothing is held that could vibrate.
        return Found({**told(found), "dq": np.zeros((len(found.t), 0)), **along}, found.motion)
    rtol = asked.settings.get("ERROR", {}).get("relative", RTOL)
    vibrations = perturbation(found, qd=_start(found.motion.model, led), rtol=rtol)
    return _superposed(found, vibrations, along)


def _superposed(found: Any, vibrations: Perturbation, along: dict[str, Any]) -> Found:
    """Nominal motion and vibrations together."""
    whole = vibrations.motion()
    return Found({**told(found, whole), "dq": np.asarray(vibrations.q), **along}, whole)


def _table(data: dict[str, Any]) -> list[str]:
    lines = table(data)
    for i, d in enumerate(data["dofs"] if "dq" in data else []):
        values = np.asarray(data["dq"])[:, i]
        lines.append(f"  vibration {d['kind']} {d['of']}.{d['component']}: {values.min():.6g} to {values.max():.6g}")
    return lines


MODES = (
    Mode(5, "perturbation", _run, table, needs=("trajectory", "times")),
    Mode(6, "superposition", functools.partial(_run, integrated=True), _table, needs=("trajectory", "times")),
)
