"""Mode 7: natural frequencies and modes about the equilibrium; poles where there are no frequencies."""

from typing import Any

import numpy as np

from ..linear.modes import modes
from .answer_parts import equilibrium_answers, hertz_of, numbered_lines, pole_answers, shapes
from .mode import Mode, ModeRequest, ModeResult


def _run(asked: ModeRequest) -> ModeResult:
    lin = asked.linearized()
    if not lin.matrices.symmetric:
        silent = "The stiffness is unsymmetric (moments about fixed axes, follower loads): `poles` answers alone."
        asked.warnings.append(silent)
        # The answer keeps its keys. Numbers that are not finite are null.
        none = dict.fromkeys(("eigenvalues", "frequencies_hz", "massless", "modes"))
        return ModeResult({**equilibrium_answers(lin), **none, **pole_answers(lin, always=True)})
    mode_set = modes(lin)
    values, hertz = np.asarray(mode_set.eigenvalues), np.asarray(mode_set.frequencies)
    data = {
        **equilibrium_answers(lin),
        "stable": mode_set.stable,
        "eigenvalues": values,
        "frequencies_hz": hertz_of(values, hertz),
        "massless": mode_set.massless,
        "modes": shapes(mode_set.shapes, lin.labels),
        **pole_answers(lin, always=False),
    }
    return ModeResult(data, mode_set)


def _table(data: dict[str, Any]) -> list[str]:
    lines = []
    if data.get("frequencies_hz") is not None:
        pairs = list(zip(data["eigenvalues"], data["frequencies_hz"], strict=True))
        lines.append(f"natural frequencies [Hz] ({len(pairs)}, {data['massless']} motions without mass left out):")
        texts = [f"unstable, omega^2 = {v:.6g}" if f is None else f"{f:.7g}" for v, f in pairs]
        lines += numbered_lines(texts)
    elif "poles" in data:
        lines += ["poles [1/s]:", *numbered_lines([f"{re:.7g} {im:+.7g}j" for re, im in data["poles"]])]
    return lines


MODE = Mode(_run, _table)
