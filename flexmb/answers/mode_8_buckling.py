"""Mode 8: load multipliers at which the loaded mechanism buckles."""

from typing import Any

import numpy as np

from ..linear.buckling import buckling
from ..linear.loose import refuse_negative_mass
from .answer_parts import compliance_answers, equilibrium_answers, numbered_lines, shapes
from .mode import Mode, ModeRequest, ModeResult


def _run(asked: ModeRequest) -> ModeResult:
    lin = asked.linearized()
    refuse_negative_mass(lin)
    buckling_modes = buckling(asked.model)
    if not len(buckling_modes.multipliers) and lin.matrices.symmetric:
        asked.warnings.append("No load acts in any motion: there is no load multiplier.")
    data = {
        **equilibrium_answers(lin),
        "load_multipliers": np.asarray(buckling_modes.multipliers),
        "modes": shapes(buckling_modes.shapes, lin.labels),
        "compliance": compliance_answers(lin),
    }
    return ModeResult(data, buckling_modes)


def _table(data: dict[str, Any]) -> list[str]:
    if "load_multipliers" not in data:
        return []
    return ["load multipliers:", *numbered_lines([f"{v:.7g}" for v in data["load_multipliers"]])]


MODE = Mode(_run, _table, increments=True, needs=("loads",))
