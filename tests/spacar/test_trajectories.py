"""Trajectories, nominal inputs and reference outputs in SPACAR input files: what is read, written and refused."""

import pytest
from cases.spacar_checks import faults

import flexmb as fm

fm.enable_x64()

ARM = """PLBEAM 1 1 2 3 4
PLTOR 2 5 2
X 1 0 0
X 3 1 0
FIX 1
FIX 5
INPUTE 2 1
DYNE 1 2
RLSE 1 1
{kinematics}
END
HALT
EM 1 1
ESTIFF 1 1e6 100
{dynamics}
END
HALT
{signals}
END
END
"""
K, D, S = 10, 15, 18


def text_of(**lines):
    return ARM.format(**{"kinematics": "", "dynamics": "", "signals": "", **lines})


WHOLE = text_of(
    dynamics="INPUTE 2 1 0.5\nTIMESTEP 2 20\nTRAJE 2 1 1 1.5 0.25 SCURVE",
    signals="TRAJE 2 1 0 1 1.5\nREFX 2 3 2\nREFE 1 2 1\nNOMS 1 2 1\nREFEDP 3 2 1\n"
    "TRAJE 1 2 1 2 1D-3 septic\nTRAJE 2 1 1.5 2 0",
)


def test_what_is_read_survives_a_round_trip(tmp_path):
    read = fm.read_spacar(WHOLE)
    assert read.warnings == []
    assert [leg[:-1] for leg in read.settings["TRAJE"]] == [
        (2, 1, 1.0, 1.5, 0.25, "scurve"),
        (2, 1, 0.0, 1.0, 1.5, "quintic"),
        (1, 2, 1.0, 2.0, 1e-3, "septic"),
        (2, 1, 1.5, 2.0, 0.0, "quintic"),
    ]
    assert [read.settings[k][0][:-1] for k in ("REFE", "REFX", "REFEDP", "NOMS")] == [
        (1, 2, 1),
        (2, 3, 2),
        (3, 2, 1),
        (1, 2, 1),
    ]
    assert read.builder.signals == {"input": [], "output": []}
    fm.write_spacar(read, tmp_path / "again.dat")
    again = fm.read_spacar(tmp_path / "again.dat").settings
    for keyword, entries in read.settings.items():
        if isinstance(entries, list):
            assert [tuple(e)[:-1] for e in again[keyword]] == [tuple(e)[:-1] for e in entries]
    assert again["TIMESTEP"] == read.settings["TIMESTEP"]


BAD = [
    ("dynamics", "TRAJE 9 1 0 1 2", "{D}: TRAJE: element 9: there is no element 9 (there are: 1, 2)"),
    ("dynamics", "TRAJX 9 1 0 1 2", "{D}: TRAJX: node 9: is in no element; a node exists if an element names it"),
    ("signals", "TRAJX 3 3 0 1 2", "{S}: TRAJX: node 3: coordinate 3 is out of range: node 3 has coordinates 1 to 2"),
    (
        "dynamics",
        "TRAJX 3 1 0 1 2",
        "{D}: TRAJX: node 3: coordinate 1 is calculable, so it cannot follow a trajectory: name",
    ),
    (
        "dynamics",
        "TRAJX 1 1 0 1 2",
        "{D}: TRAJX: node 1: coordinate 1 is held, so it cannot follow a trajectory: name it with",
    ),
    (
        "dynamics",
        "TRAJE 1 1 0 1 2",
        "{D}: TRAJE: element 1: deformation 1 is calculable, so it cannot follow a trajectory",
    ),
    ("dynamics", "TRAJE 2 1 1 0.5 2", "{D}: TRAJE: element 2: end must be later than start, which is 1.0 s, but"),
    ("dynamics", "TRAJE 2 1 1 1 2", "{D}: TRAJE: element 2: end must be later than start, which is 1.0 s, but is 1.0"),
    ("dynamics", "TRAJE 2 1 -1 1 2", "{D}: TRAJE: element 2: start is a time [s] from 0, but is -1.0"),
    ("dynamics", "TRAJE 2 1 0 1 2 cubic", "{D}: TRAJE: element 2: the law must be quintic, septic or scurve, but is"),
    (
        "dynamics",
        "TRAJE 2 1 0 1",
        "{D}: TRAJE: element 2: too few parameters (4); expected: TRAJE element deformation start end value [law]",
    ),
    (
        "dynamics",
        "TRAJE 2 1 0 1 2\nTRAJE 2 1 0.9 2 3",
        "{D1}: TRAJE: element 2: deformation 1 moves from 0.0 s to 1.0 s already by line {D}; lines must follow",
    ),
    (
        "dynamics",
        "INPUTE 2 1 0 3\nTRAJE 2 1 0 1 2",
        "{D1}: TRAJE: element 2: moves by the velocity or acceleration of INPUTE on line {D} already",
    ),
    ("kinematics", "TRAJE 2 1 0 1 2", "{K}: TRAJE: element 2: belongs in the dynamics block, but is in the"),
    ("signals", "NOMF 1 3 1", "{S}: NOMF: input 1: there is no output that follows the trajectory: name one with REFX"),
    ("signals", "NOMF 2 3 1\nREFX 1 3 1", "{S}: NOMF: input 2: nominal input 1 is missing; nominal inputs are"),
    ("signals", "REFX 1 3 1\nREFE 3 2 1", "{S1}: REFE: output 3: reference output 2 is missing; reference outputs are"),
    (
        "signals",
        "NOMF 1 3 1\nNOMS 1 2 1\nREFX 1 3 1",
        "{S1}: NOMS: input 1: nominal input 1 is defined already on line {S}; nominal inputs share one numbering",
    ),
    (
        "signals",
        "NOMF 1 1 1\nREFX 1 3 1",
        "{S}: NOMF: input 1: coordinate 1 is fixed, so nothing can drive it; let the input act on one that moves",
    ),
    (
        "signals",
        "NOMS 1 2 1\nREFX 1 3 1",
        "{S}: NOMS: input 1: is prescribed without a motion, so nothing is driven: give its motion by TRAJE",
    ),
    ("signals", "REFX 1 5 2", "{S}: REFX: output 1: coordinate 2 is out of range: node 5 has coordinates 1 to 1"),
    *(
        ("dynamics", f"{keyword} 1 2 3", f"{{D}}: {keyword}: element 1: is refused, since its parameters are not known")
        for keyword in ("TROT", "TREPMAX", "TRM", "TRFRONT", "TIMENORM", "INTEGRAL")
    ),
]


@pytest.mark.parametrize(("block", "lines", "expected"), BAD)
def test_one_fault(block, lines, expected):
    (fault,) = faults(text_of(**{block: lines}))
    assert fault.startswith("text:" + expected.format(K=K, D=D, D1=D + 1, S=S, S1=S + 1))


@pytest.mark.slow("INTEGRAL-ERROR absolute")
@pytest.mark.parametrize(
    ("keyword", "way"),
    [("TROT", "TRAJX node coordinate start end value"), ("TIMENORM", "times [s]"), ("INTEGRAL", "ERROR absolute")],
)
def test_a_refusal_says_how_it_is_said_here(keyword, way):
    assert way in faults(text_of(dynamics=f"{keyword} 1"))[0]
