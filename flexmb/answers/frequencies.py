"""Mode 7: natural frequencies and modes about the equilibrium; poles where there are no frequencies."""

from typing import Any

import numpy as np

from ..linear.modes import modes
from .mode import Found, Mode, Question
from .parts import SHOWN_VALUES, hertz_of, poles_of, shapes, state_of


def _run(asked: Question) -> Found:
    lin = asked.linearized()
    if not lin.matrices.symmetric:
        silent = "The stiffness is unsymmetric (moments about fixed axes, follower loads): `poles` answers alone."
        asked.warnings.append(silent)
        return Found({**state_of(lin), **poles_of(lin, always=True)})
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
    if "frequencies_hz" in data:
        pairs = list(zip(data["eigenvalues"], data["frequencies_hz"], strict=True))
        lines.append(f"natural frequencies [Hz] ({len(pairs)}, {data['massless']} motions without mass left out):")
        texts = [f"unstable, omega^2 = {v:.6g}" if f is None else f"{f:.7g}" for v, f in pairs]
        lines += [f"  {i + 1:3d}  {text}" for i, text in enumerate(texts[:SHOWN_VALUES])]
        lines += [f"  ... {len(texts) - SHOWN_VALUES} more"] if len(texts) > SHOWN_VALUES else []
    elif "poles" in data:
        lines.append("poles [1/s]:")
        lines += [f"  {i + 1:3d}  {re:.7g} {im:+.7g}j" for i, (re, im) in enumerate(data["poles"][:SHOWN_VALUES])]
        lines += [f"  ... {len(data['poles']) - SHOWN_VALUES} more"] * (len(data["poles"]) > SHOWN_VALUES)
    return lines


MODES = (Mode(7, "frequencies", _run, _table),)
