"""Mode 5: force on released degrees of freedom along a trajectory, by the perturbation method; shared with mode 6."""

from typing import Any

import numpy as np

from ..model.model import Model
from ..trajectory.vibrations import Perturbation, perturbation
from .mode import Found, Mode, ModeRequest
from .mode_1_simulate import RTOL
from .mode_2_inverse import linearised, nominal_motion, table, told


def _force(found: Any) -> np.ndarray:
    """Force on the released degrees of freedom, (n_t, n_q) [N, N m]."""
    return -np.asarray(found.f0)


def _start(model: Model, led: list[str]) -> np.ndarray:
    """Start velocities of degrees of freedom that the trajectory does not lead, (n_q,)."""
    names = model.q_labels
    given = np.zeros(len(names)) if model.parameters.start is None else np.asarray(model.parameters.start[1])
    return np.where([name in led for name in names], 0.0, given)


def run(asked: ModeRequest, integrated: bool = False) -> Found:
    """The linearised equations with the force; with ``integrated`` also the vibrations."""
    found, led = nominal_motion(asked, 6 if integrated else 5)
    along = linearised(asked, found)
    for step, force in zip(along["steps"], _force(found), strict=True):
        step["f0"] = force
    if not integrated:
        return Found({**told(found), **along}, found.motion)
    if not found.motion.model.topology.n_q:
        # No released degree of freedom can vibrate.
        return Found({**told(found), "dq": np.zeros((len(found.t), 0)), **along}, found.motion)
    rtol = asked.settings.get("ERROR", {}).get("relative", RTOL)
    vibrations = perturbation(found, qd=_start(found.motion.model, led), rtol=rtol)
    return _superposed(found, vibrations, along)


def _superposed(found: Any, vibrations: Perturbation, along: dict[str, Any]) -> Found:
    """Nominal motion and vibrations together."""
    whole = vibrations.motion()
    return Found({**told(found, whole), "dq": np.asarray(vibrations.q), **along}, whole)


MODE = Mode(run, table, needs=("trajectory", "times"))
