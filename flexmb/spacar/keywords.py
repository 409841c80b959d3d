"""The keywords of SPACAR input files, and the action of each in its block.

ROWS lists actions, DRAWN lists keywords with a warning, and REFUSED lists refused keywords with the reason. Keywords of
ROWS without effect warn by themselves (OUTLEVEL, ITERSTEP and the like). Some lines have an effect in some modes only:
STARTDX, STARTDE, velocities of INPUTX and INPUTE, and ERROR in 1 and 4 (the relative tolerance of ERROR in 6 too),
TIMESTEP in these and in 2, 3, 5 and 6, where trajectories act (TRAJX, NOMF, REFX and the like); inputs and outputs in 4
and 9, increments (DELXF and the like) in 8 and 10.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

from . import actions as act
from . import trajectories
from .kinds import FORMS
from .lines import DYNAMICS, KINEMATICS, SIGNALS, Statement
from .reading import Reading
from .trajectories import QUANTITIES

# Stages: nodes follow from elements, and properties and positions are needed before elements are built.
DECLARE, DESCRIBE, APPLY = range(3)


@dataclasses.dataclass(frozen=True)
class Row:
    """One keyword in one block, with its form (see lines.parse), its action and its stage."""

    keyword: str
    block: str
    form: str
    action: Callable[[Reading, Statement, dict[str, Any]], None]
    stage: int


_WAY = "start end value [law]"
_NUMBERED = {"node": "number node component", "element": "number element deformation"}
ROWS = tuple(
    Row(keyword, block, form, action, stage)
    for keywords, block, form, action, stage in (
        *((keyword, KINEMATICS, form, act.declare, DECLARE) for keyword, form in FORMS.items()),
        ("X", KINEMATICS, "node x [y] [z]", act.position, DESCRIBE),
        ("FIX", KINEMATICS, "node [coordinate ...]", act.fix, APPLY),
        ("RLSE", KINEMATICS, "element deformation ...", act.release, APPLY),
        ("DYNX", KINEMATICS, "node coordinate ...", act.degree_of_freedom, APPLY),
        ("DYNE", KINEMATICS, "element deformation ...", act.degree_of_freedom, APPLY),
        ("INPUTX", KINEMATICS, "node coordinate ...", act.prescribed, APPLY),
        ("INPUTE", KINEMATICS, "element deformation ...", act.prescribed, APPLY),
        ("CLAMP", KINEMATICS, "element first last", act.clamp, DESCRIBE),
        ("OUTLEVEL LEVELLOG", KINEMATICS, "log store", act.log_level, APPLY),
        ("OUTLEVEL LEVELLOG", DYNAMICS, "log store", act.log_level, APPLY),
        ("ESTIFF EM EDAMP", DYNAMICS, "element value ...", act.section_numbers, DESCRIBE),
        ("SECTION", DYNAMICS, "element width thickness E G rho [alpha]", act.section, DESCRIBE),
        ("XM", DYNAMICS, "node value ...", act.lumped, APPLY),
        ("XF DELXF", DYNAMICS, "node value ...", act.force, APPLY),
        ("ESIG DELESIG", DYNAMICS, "element value ...", act.prestress, APPLY),
        ("EINIT", DYNAMICS, "element value ...", act.strain, APPLY),
        ("ALPHA", DYNAMICS, "element value", act.expansion, DESCRIBE),
        ("TEMP DELTEMP", DYNAMICS, "element value ...", act.temperature, APPLY),
        ("INPUTX", DYNAMICS, "node coordinate value [velocity] [acceleration]", act.motion, APPLY),
        ("INPUTE", DYNAMICS, "element deformation value [velocity] [acceleration]", act.motion, APPLY),
        ("DELINPX", DYNAMICS, "node coordinate increment", act.motion_increment, APPLY),
        ("DELINPE", DYNAMICS, "element deformation increment", act.motion_increment, APPLY),
        ("GRAVITY", DYNAMICS, "gx gy [gz]", act.gravity, APPLY),
        ("ITERSTEP", DYNAMICS, "iterations steps tolerance [fourth] [path] [initial]", act.setting, APPLY),
        ("TIMESTEP", DYNAMICS, "end steps", act.setting, APPLY),
        ("ERROR", DYNAMICS, "absolute relative", act.setting, APPLY),
        ("STARTDX", DYNAMICS, "node coordinate value [velocity]", act.start_value, APPLY),
        ("STARTDE", DYNAMICS, "element deformation value [velocity]", act.start_value, APPLY),
        *(("TRAJX", block, f"node coordinate {_WAY}", trajectories.leg, APPLY) for block in (DYNAMICS, SIGNALS)),
        *(("TRAJE", block, f"element deformation {_WAY}", trajectories.leg, APPLY) for block in (DYNAMICS, SIGNALS)),
        ("USERSIG USERINP", DYNAMICS, "name", act.routine, APPLY),
        *(
            (" ".join(keywords), SIGNALS, _NUMBERED[kind], trajectories.signal, APPLY)
            for (_, kind), keywords in QUANTITIES.items()
        ),
        ("NOMF REFX REFXP REFXDP", SIGNALS, _NUMBERED["node"], trajectories.channel, APPLY),
        ("NOMS REFE REFEP REFEDP", SIGNALS, _NUMBERED["element"], trajectories.channel, APPLY),
    )
    for keyword in keywords.split()
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
