"""The keywords of SPACAR input files, and the action of each in its block.

ROWS lists actions, DRAWN lists keywords with a warning, and REFUSED lists refused keywords with the reason. Keywords of
ROWS without effect warn by themselves (OUTLEVEL, ITERSTEP and the like). Some lines have an effect in some modes only:
STARTDX, STARTDE, velocities of INPUTX and INPUTE, and ERROR in 1 and 4 (the relative tolerance of ERROR in 6 too),
TIMESTEP in these and in 2, 3, 5 and 6, where trajectories act (TRAJX, NOMF, REFX and the like); inputs and outputs in 4
and 9, increments (DELXF and the like) in 8 and 10.
"""

import dataclasses
from collections.abc import Callable
from functools import partial
from typing import Any

from . import actions as act
from . import trajectories
from .kinds import FORMS, KINDS
from .lines import DYNAMICS, KINEMATICS, SIGNALS, Statement
from .reading import Reading
from .trajectories import QUANTITIES, signal

# Stages: nodes follow from elements, and properties and positions are needed before elements are built.
DECLARE, DESCRIBE, APPLY = range(3)


@dataclasses.dataclass(frozen=True)
class Row:
    """One keyword in one block, with its form (see lines.parse), its action and its stage."""

    keyword: str
    block: str
    form: str
    action: Callable[[Reading, Statement, dict[str, Any]], None]
    stage: int = APPLY


WAY = "start end value [law]"
ROWS = (
    *(
        Row(
            keyword,
            KINEMATICS,
            form,
            partial(act.declare, kinds=tuple(k for k in KINDS if k.keyword == keyword)),
            DECLARE,
        )
        for keyword, form in FORMS.items()
    ),
    Row("X", KINEMATICS, "node x [y] [z]", act.position, DESCRIBE),
    Row("FIX", KINEMATICS, "node [coordinate ...]", act.fix),
    Row("RLSE", KINEMATICS, "element deformation ...", act.release),
    Row("DYNX", KINEMATICS, "node coordinate ...", act.degree_of_freedom),
    Row("DYNE", KINEMATICS, "element deformation ...", act.degree_of_freedom),
    Row("INPUTX", KINEMATICS, "node coordinate ...", act.prescribed),
    Row("INPUTE", KINEMATICS, "element deformation ...", act.prescribed),
    Row("CLAMP", KINEMATICS, "element first last", act.clamp, DESCRIBE),
    *(
        Row(keyword, block, "log store", act.log_level)
        for keyword in ("OUTLEVEL", "LEVELLOG")
        for block in (KINEMATICS, DYNAMICS)
    ),
    Row("ESTIFF", DYNAMICS, "element value ...", act.section_numbers, DESCRIBE),
    Row("EM", DYNAMICS, "element value ...", act.section_numbers, DESCRIBE),
    Row("EDAMP", DYNAMICS, "element value ...", act.section_numbers, DESCRIBE),
    Row("SECTION", DYNAMICS, "element width thickness E G rho [alpha]", act.section, DESCRIBE),
    Row("XM", DYNAMICS, "node value ...", act.lumped),
    Row("XF", DYNAMICS, "node value ...", act.force),
    Row("DELXF", DYNAMICS, "node value ...", act.force),
    Row("ESIG", DYNAMICS, "element value ...", act.prestress),
    Row("DELESIG", DYNAMICS, "element value ...", act.prestress),
    Row("EINIT", DYNAMICS, "element value ...", act.strain),
    Row("ALPHA", DYNAMICS, "element value", act.expansion, DESCRIBE),
    Row("TEMP", DYNAMICS, "element value ...", act.temperature),
    Row("DELTEMP", DYNAMICS, "element value ...", act.temperature),
    Row("INPUTX", DYNAMICS, "node coordinate value [velocity] [acceleration]", act.motion),
    Row("INPUTE", DYNAMICS, "element deformation value [velocity] [acceleration]", act.motion),
    Row("DELINPX", DYNAMICS, "node coordinate increment", act.motion_increment),
    Row("DELINPE", DYNAMICS, "element deformation increment", act.motion_increment),
    Row("GRAVITY", DYNAMICS, "gx gy [gz]", act.gravity),
    Row("ITERSTEP", DYNAMICS, "iterations steps tolerance [fourth] [path] [initial]", act.setting),
    Row("TIMESTEP", DYNAMICS, "end steps", act.setting),
    Row("ERROR", DYNAMICS, "absolute relative", act.setting),
    Row("STARTDX", DYNAMICS, "node coordinate value [velocity]", act.start_value),
    Row("STARTDE", DYNAMICS, "element deformation value [velocity]", act.start_value),
    *(Row("TRAJX", block, f"node coordinate {WAY}", trajectories.leg) for block in (DYNAMICS, SIGNALS)),
    *(Row("TRAJE", block, f"element deformation {WAY}", trajectories.leg) for block in (DYNAMICS, SIGNALS)),
    Row("USERSIG", DYNAMICS, "name", act.routine),
    Row("USERINP", DYNAMICS, "name", act.routine),
    *(
        Row(keyword, SIGNALS, "number node component" if kind == "node" else "number element deformation", signal)
        for (_, kind), keywords in QUANTITIES.items()
        for keyword in keywords
    ),
    *(
        Row(keyword, SIGNALS, "number node component", trajectories.channel)
        for keyword in ("NOMF", "REFX", "REFXP", "REFXDP")
    ),
    *(
        Row(keyword, SIGNALS, "number element deformation", trajectories.channel)
        for keyword in ("NOMS", "REFE", "REFEP", "REFEDP")
    ),
)
TABLE = {(row.keyword, row.block): row for row in ROWS}

DRAWN = (
    *("VISUALIZATION", "INITIAL", "COLOR", "BEAMPROPS", "CROSSTYPE", "CROSSDIM", "GRAPHICS", "FACECOLOR", "OPACITY"),
    *("DONOTDRAW", "VIBRATIONMODE", "VIBREND", "ENLARGEFACTOR", "TRANSPARENCY", "BEAMVIS", "TRUSSVIS"),
)

_LATER = "is not available yet"
_UNCLEAR = "is refused, since its form is not known; use an element of flexmb through the Python Builder"
_KINEMATIC = "is refused: no analysis excludes a degree of freedom from the dynamic set; use DYNX/DYNE or INPUTX/INPUTE"
UNKNOWN_MOTION = (
    "is refused, since its parameters are not known; give the motion of a coordinate by TRAJX node coordinate start end"
    " value [quintic|septic|scurve], a deformation by TRAJE element deformation start end value [quintic|septic|scurve]"
)
_UNKNOWN_TIME = "is refused, since its parameters are not known; "
REFUSED = {
    **dict.fromkeys(("TUBE", "PLTUBE"), f"element type {_LATER}"),
    **dict.fromkeys(("GEAR", "PLGEAR", "WHEEL", "BELT", "CYLBEAR", "PLBEAR", "SLIDER", "GIMBAL"), _UNCLEAR),
    **dict.fromkeys(("KINX", "KINE"), _KINEMATIC),
    **dict.fromkeys(("TROT", "TREPMAX", "TRM", "TRFRONT"), UNKNOWN_MOTION),
    "ENHC": "is refused, since its meaning is not known",
    "TIMENORM": f"{_UNKNOWN_TIME}start and end of TRAJX and TRAJE are times [s]; TIMESTEP gives output times",
    "INTEGRAL": f"{_UNKNOWN_TIME}steps are chosen by the tolerances of ERROR absolute relative",
}

KEYWORDS = tuple(dict.fromkeys([row.keyword for row in ROWS] + [*REFUSED, *DRAWN, "END", "HALT"]))
"""All keywords that are known."""
