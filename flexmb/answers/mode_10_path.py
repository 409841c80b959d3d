"""Mode 10: the equilibrium path over the incremental loads."""

from typing import Any

import numpy as np

from ..linear.spectrum import to_frequency
from ..paths.path import Path, path
from ..results import RESULTS
from .answer_parts import by_owner, compliance_answers, configuration_answers, hertz_of, matrix_answers
from .mode import Mode, ModeRequest, ModeResult


def _step(path_result: Path, i: int) -> dict[str, Any]:
    lin = path_result.linearization(i)
    values, multipliers = np.asarray(path_result.eigenvalues)[i], np.asarray(path_result.multipliers)[i]
    finite = np.isfinite(values)
    return {
        "load_factor": float(np.asarray(path_result.load_factor)[i]),
        **configuration_answers(lin),
        "stable": bool(path_result.stable[i]),
        "eigenvalues": values[finite],
        "frequencies_hz": hertz_of(values[finite], to_frequency(values[finite])),
        "load_multipliers": multipliers[np.isfinite(multipliers)],
        **matrix_answers(lin),
        "compliance": compliance_answers(lin),
    }


def _path(path_result: Path) -> dict[str, Any]:
    code = RESULTS(int(path_result.result))
    critical = [
        {"load_factor": c.load_factor, "kind": c.kind, "mode": by_owner(c.phi, path_result.labels.x)}
        for c in path_result.critical_points
    ]
    return {
        "status": "ok" if code == RESULTS.successful else code.name,
        "message": code.message,
        **configuration_answers(path_result.linearization()),
        "stable": bool(path_result.stable[-1]),
        "critical_points": critical,
        "path": [_step(path_result, i) for i in range(len(path_result.load_factor))],
    }


def _run(asked: ModeRequest) -> ModeResult:
    model = asked.checked()
    # The answer has matrices and all frequencies of each state.
    path_result = path(model, max_steps=asked.max_steps, progress=asked.reported, sparse=False, throw=False)
    asked.about(path_result.linearization())
    return ModeResult(_path(path_result), path_result)


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
