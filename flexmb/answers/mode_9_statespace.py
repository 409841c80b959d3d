"""Mode 9: the state space of the linearised mechanism."""

from typing import Any

import numpy as np

from ..control.state_space import state_matrices
from .answer_parts import equilibrium_answers, matrix, pole_answers
from .mode import Mode, ModeRequest, ModeResult


def _run(asked: ModeRequest) -> ModeResult:
    lin = asked.linearized()
    state_space, states = state_matrices(lin)
    data = {
        **equilibrium_answers(lin),
        **{name: np.asarray(value) for name, value in state_space._asdict().items()},
        "inputs": [s.name for s in lin.labels.inputs],
        "outputs": [s.name for s in lin.labels.outputs],
        "states": states,
        **pole_answers(lin, always=True),
    }
    # A Bode plot needs an input that moves some output.
    moved = np.any(data["B"]) and np.any(data["C"])
    return ModeResult(data, None, "bode" if moved else "")


def _table(data: dict[str, Any]) -> list[str]:
    if "A" not in data:
        return []
    lines = [f"{side}: {', '.join(data[side]) or 'none'}" for side in ("inputs", "outputs")]
    for name in "ABCD":
        lines += matrix(name, data[name]) if np.size(data[name]) else [f"{name}: empty"]
    return lines


MODE = Mode(_run, _table, needs=("signals",))
