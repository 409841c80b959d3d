"""Mode 5: force on released degrees of freedom along a trajectory, by the perturbation method."""

import numpy as np

from ..model.model import Model
from ..trajectory.vibrations import perturbation
from .mode import Mode, ModeRequest, ModeResult
from .mode_1_simulate import RTOL
from .mode_2_inverse import linearised, nominal_data, nominal_motion, table


def _start(model: Model, led: list[str]) -> np.ndarray:
    """Start velocities of degrees of freedom that the trajectory does not lead, (n_q,)."""
    names = model.q_labels
    start_velocities = np.zeros(len(names)) if model.parameters.start is None else np.asarray(model.parameters.start[1])
    return np.where([name in led for name in names], 0.0, start_velocities)


def run(asked: ModeRequest, integrated: bool = False) -> ModeResult:
    """The linearised equations with the force; with ``integrated`` also the vibrations."""
    nominal, led = nominal_motion(asked, 6 if integrated else 5)
    along = linearised(asked, nominal)
    for step, f0 in zip(along["steps"], np.asarray(nominal.f0), strict=True):
        step["f0"] = -f0
    if not integrated:
        return ModeResult({**nominal_data(nominal), **along}, nominal.motion)
    if not nominal.motion.model.topology.n_q:
        # No released degree of freedom can vibrate.
        return ModeResult({**nominal_data(nominal), "dq": np.zeros((len(nominal.t), 0)), **along}, nominal.motion)
    rtol = asked.settings.get("ERROR", {}).get("relative", RTOL)
    vibrations = perturbation(nominal, qd=_start(nominal.motion.model, led), rtol=rtol)
    total_motion = vibrations.motion()
    return ModeResult({**nominal_data(nominal, total_motion), "dq": np.asarray(vibrations.q), **along}, total_motion)


MODE = Mode(run, table, needs=("trajectory", "times"))
