"""Mode 8: load multipliers at which the loaded mechanism buckles."""

from typing import Any

import numpy as np

from ..linear.buckling import buckling
from ..linear.loose import refuse_negative_mass
from .answer_parts import compliances, numbered, shapes, state_of
from .mode import Found, Mode, ModeRequest


def _run(asked: ModeRequest) -> Found:
    lin = asked.linearized()
    refuse_negative_mass(lin)
    found = buckling(asked.model)
    if not len(found.multipliers) and lin.matrices.symmetric:
        asked.warnings.append("No load acts in any motion: there is no load multiplier.")
    data = {
        **state_of(lin),
        "load_multipliers": np.asarray(found.multipliers),
        "modes": shapes(found.shapes, lin.labels),
        "compliance": compliances(lin),
    }
    return Found(data, found)


def _table(data: dict[str, Any]) -> list[str]:
    if "load_multipliers" not in data:
        return []
    return ["load multipliers:", *numbered([f"{v:.7g}" for v in data["load_multipliers"]])]


MODE = Mode(_run, _table, increments=True, needs=("loads",))
