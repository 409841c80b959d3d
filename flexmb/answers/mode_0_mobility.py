"""Mode 0: over- and under-constraints."""

from typing import Any

from ..checks.mobility import Mobility, Share, mobility
from .answer_parts import number
from .mode import Mode, ModeRequest, ModeResult


def _mobility_modes(model_mobility: Mobility) -> list[dict[str, Any]]:
    def listed(shares: list[Share], key: str):
        return [{key: number(s.of), "component": s.component, "share": s.share} for s in shares]

    over = [
        {
            "kind": "overconstraint",
            "deformations": listed(model_mobility.stresses(i), "element"),
            "release": {candidates[0].kind: number(candidates[0].of), "component": candidates[0].number}
            if candidates
            else None,
        }
        for i, candidates in enumerate(model_mobility.candidates)
    ]
    under = [
        {"kind": "underconstraint", "coordinates": listed(model_mobility.motions(i), "node")}
        for i in range(model_mobility.underconstraints)
    ]
    return over + under


def _run(asked: ModeRequest) -> ModeResult:
    model_mobility = mobility(asked.model)
    data = {
        "status": model_mobility.status,
        "message": model_mobility.report(),
        "overconstraints": model_mobility.overconstraints,
        "underconstraints": model_mobility.underconstraints,
        "mobility": _mobility_modes(model_mobility),
    }
    return ModeResult(data, model_mobility)


MODE = Mode(_run, lambda data: [], structural=True)
