"""Input files of a guide of two leaf springs, with parameters in braces."""

_FRAME = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
PLBEAM 3 5 6 7 8
X 1 0 0
X 3 0 {l}
X 5 0.1 {l}
X 7 {+l/2+0.05-(l-0.1)/2} 0
FIX 1
FIX 2
FIX 7
FIX 8
RLSE 1 2 3
RLSE 3 2 3
DYNX 3 1
END
HALT
"""
_STIFFNESS = """ESTIFF 1 {210e9*w*t} {210e9*w*t**3/12}
ESTIFF 3 {210e9*w*t} {210e9*w*t**3/12}
"""
_MASS = """XM 3 0.103
XM 5 0.103
EM 1 {7850*w*t}
EM 3 {7850*w*t}
"""
_PORTS = """HALT
INPUTF 1 3 1
OUTX 1 3 1
END
"""
# Parameters t, l, w. Node 7 stays at 0.1 m.
GUIDE = f"{_FRAME}{_MASS}{_STIFFNESS}END\nEND\n"
# Parameters t, m, w. The frequency goes with t^1.5, the drive stiffness with t^3.
GUIDE_WITH_PORTS = (
    _FRAME.replace("{l}", "0.1").replace("{+l/2+0.05-(l-0.1)/2}", "0.1")
    + "XM 3 {m}\nXM 5 {m}\n"
    + f"{_STIFFNESS}END\n{_PORTS}END\n"
)
