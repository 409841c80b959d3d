"""Mode 0: over- and under-constraints."""

from typing import Any

from ..checks.mobility import Mobility, Share, mobility
from .answer_parts import number
from .mode import Found, Mode, ModeRequest


def _mobility_modes(found: Mobility) -> list[dict[str, Any]]:
    def listed(shares: list[Share], key: str):
        return [{key: number(s.of), "component": s.component, "share": s.share} for s in shares]

    over = [
        {
            "kind": "overconstraint",
            "deformations": listed(found.stresses(i), "element"),
            "release": {own[0].kind: number(own[0].of), "component": own[0].number} if own else None,
        }
        for i, own in enumerate(found.candidates)
    ]
    under = [
        {"kind": "underconstraint", "coordinates": listed(found.motions(i), "node")}
        for i in range(found.underconstraints)
    ]
    return over + under


def _run(asked: ModeRequest) -> Found:
    found = mobility(asked.model)
    data = {
        "status": found.status,
        "message": found.report(),
        "overconstraints": found.overconstraints,
        "underconstraints": found.underconstraints,
        "mobility": _mobility_modes(found),
    }
    return Found(data, found)


MODE = Mode(_run, lambda data: [], structural=True)
