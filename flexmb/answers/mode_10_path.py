"""Mode 10: the equilibrium path over the incremental loads."""

from typing import Any

import numpy as np

from ..linear.spectrum import to_frequency
from ..paths.path import Path, path
from ..results import RESULTS
from .answer_parts import by_owner, compliances, configuration, hertz_of, matrices
from .mode import Found, Mode, ModeRequest


def _step(found: Path, i: int) -> dict[str, Any]:
    lin, values, multipliers = (
        found.linearization(i),
        np.asarray(found.eigenvalues)[i],
        np.asarray(found.multipliers)[i],
    )
    finite = np.isfinite(values)
    return {
        "load_factor": float(np.asarray(found.load_factor)[i]),
        **configuration(lin),
        "stable": bool(found.stable[i]),
        "eigenvalues": values[finite],
        "frequencies_hz": hertz_of(values[finite], to_frequency(values[finite])),
        "load_multipliers": multipliers[np.isfinite(multipliers)],
        **matrices(lin),
        "compliance": compliances(lin),
    }


def _path(found: Path) -> dict[str, Any]:
    code = RESULTS(int(found.result))
    critical = [
        {"load_factor": c.load_factor, "kind": c.kind, "mode": by_owner(c.phi, found.labels.x)}
        for c in found.critical_points
    ]
    return {
        "status": "ok" if code == RESULTS.successful else code.name,
        "message": code.message,
        **configuration(found.linearization()),
        "stable": bool(found.stable[-1]),
        "critical_points": critical,
        "path": [_step(found, i) for i in range(len(found.load_factor))],
    }


def _run(asked: ModeRequest) -> Found:
    model = asked.checked()
    # The answer has matrices and all frequencies of each state.
    found = path(model, max_steps=asked.max_steps, progress=asked.reported, sparse=False, throw=False)
    asked.about(found.linearization())
    return Found(_path(found), found)


def _table(data: dict[str, Any]) -> list[str]:
    if "path" not in data:
        return []
    steps, critical = data["path"], data["critical_points"]
    lines = [
        f"path ({len(steps)} states):",
        "        load factor  stable  lowest frequency [Hz]  first load multiplier",
    ]
    for i, s in enumerate(steps):
        hertz, multipliers = s["frequencies_hz"], s["load_multipliers"]
        lowest = "-" if not hertz else "unstable" if hertz[0] is None else f"{hertz[0]:.6g}"
        first = f"{multipliers[0]:.6g}" if len(multipliers) else "-"
        lines.append(
            f"  {i:3d}  {s['load_factor']:12.7g}  {'yes' if s['stable'] else 'NO':6}  {lowest:>21}  {first:>21}"
        )
    lines.append(f"critical points: {'none' if not critical else ''}".rstrip())
    return lines + [f"  {c['kind']:<11} at load factor {c['load_factor']:.10g}" for c in critical]


MODE = Mode(_run, _table, increments=True, needs=("loads", "steps"))
