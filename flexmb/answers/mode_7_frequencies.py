"""Mode 7: natural frequencies and modes about the equilibrium; poles where there are no frequencies."""

from typing import Any

import numpy as np

from ..linear.modes import modes
from .answer_parts import hertz_of, numbered, poles_of, shapes, state_of
from .mode import Found, Mode, ModeRequest


def _run(asked: ModeRequest) -> Found:
    lin = asked.linearized()
    if not lin.matrices.symmetric:
        silent = "The stiffness is unsymmetric (moments about fixed axes, follower loads): `poles` answers alone."
        asked.warnings.append(silent)
        # The answer keeps its keys. Numbers that are not finite are null.
        none = dict.fromkeys(("eigenvalues", "frequencies_hz", "massless", "modes"))
        return Found({**state_of(lin), **none, **poles_of(lin, always=True)})
    found = modes(lin)
    values, hertz = np.asarray(found.eigenvalues), np.asarray(found.frequencies)
    data = {
        **state_of(lin),
        "stable": found.stable,
        "eigenvalues": values,
        "frequencies_hz": hertz_of(values, hertz),
        "massless": found.massless,
        "modes": shapes(found.shapes, lin.labels),
        **poles_of(lin, always=False),
    }
    return Found(data, found)


def _table(data: dict[str, Any]) -> list[str]:
    lines = []
    if data.get("frequencies_hz") is not None:
        pairs = list(zip(data["eigenvalues"], data["frequencies_hz"], strict=True))
        lines.append(f"natural frequencies [Hz] ({len(pairs)}, {data['massless']} motions without mass left out):")
        texts = [f"unstable, omega^2 = {v:.6g}" if f is None else f"{f:.7g}" for v, f in pairs]
        lines += numbered(texts)
    elif "poles" in data:
        lines += ["poles [1/s]:", *numbered([f"{re:.7g} {im:+.7g}j" for re, im in data["poles"]])]
    return lines


MODE = Mode(_run, _table)
