"""Mode 9: the state space of the linearised mechanism."""

from typing import Any

import numpy as np

from ..control.state_space import state_matrices
from .answer_parts import matrix, poles_of, state_of
from .mode import Found, Mode, ModeRequest


def _run(asked: ModeRequest) -> Found:
    lin = asked.linearized()
    found, states = state_matrices(lin)
    data = {
        **state_of(lin),
        **{name: np.asarray(value) for name, value in found._asdict().items()},
        "inputs": [s.name for s in lin.labels.inputs],
        "outputs": [s.name for s in lin.labels.outputs],
        "states": states,
        **poles_of(lin, always=True),
    }
    # A Bode plot needs an input that moves some output.
    moved = np.any(data["B"]) and np.any(data["C"])
    return Found(data, None, "bode" if moved else "")


def _table(data: dict[str, Any]) -> list[str]:
    if "A" not in data:
        return []
    lines = [f"{side}: {', '.join(data[side]) or 'none'}" for side in ("inputs", "outputs")]
    for name in "ABCD":
        lines += matrix(name, data[name]) if np.size(data[name]) else [f"{name}: empty"]
    return lines


MODE = Mode(_run, _table, needs=("signals",))
