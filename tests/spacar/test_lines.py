"""Lines of SPACAR input files: no keyword is read without a word, no number beyond reach, every encoding."""

import codecs
import re
import tracemalloc

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.spacar_checks import faults
from cases.tolerances import approx

import flexmb as fm
from flexmb.answers.answers import modes
from flexmb.answers.mode import ModeRequest
from flexmb.errors import printable
from flexmb.spacar.keywords import DRAWN, KEYWORDS, REFUSED, ROWS
from flexmb.spacar.lines import BLOCKS, LARGEST, LARGEST_FILE, SMALLEST
from flexmb.spacar.read import MOST_FAULTS
from flexmb.spacar.trajectories import NOMINAL, REFERENCES, WAYS

fm.enable_x64()

# -- every keyword ------------------------------------------------------------------------------------------------

PLANE = """PLBEAM 1 1 2 3 4
PLBEAM 2 3 4 5 6
X 3 1 0
X 5 2 0
X 7 3 1
X 9 4 1
FIX 1
FIX 2
RLSE 1 1 2 3
RLSE 2 1
INPUTE 2 3
INPUTX 5 1
DYNE 2 2
DYNX 9 1
{kinematics}
END
HALT
ESTIFF 1 1e5 1
ESTIFF 2 1e5 1
{dynamics}
END
HALT
{signals}
END
END
"""
# The base names nodes 7 to 9 in an element, but for those cases that do so themselves.
TIED = "PLRBEAM 9 5 6 7\nPLTRUSS 8 7 9\nRLSE 8 1"
SPACE = PLANE.replace("PLBEAM", "BEAM").replace("X 7 3 1\nX 9 4 1\n", "").replace("DYNX 9 1\n", "")

# Block and two lines that differ in their numbers alone, for what has a form of its own.
IN_PLANE = {
    "PLTRUSS": ("kinematics", "PLTRUSS 3 5 7", "PLTRUSS 3 7 5"),
    "PLBEAM": ("kinematics", "PLBEAM 3 5 6 7 8", "PLBEAM 3 7 8 5 6"),
    "PLSBEAM": ("kinematics", "PLSBEAM 3 5 6 7 8 2", "PLSBEAM 3 5 6 7 8 3"),
    "PLRBEAM": ("kinematics", "PLRBEAM 3 5 6 7", "PLRBEAM 3 3 4 7"),
    "PLPINBODY": ("kinematics", "PLPINBODY 3 5 6 7", "PLPINBODY 3 3 4 7"),
    "PLTOR": ("kinematics", "PLTOR 3 4 8", "PLTOR 3 6 8"),
    "PLBELT": ("kinematics", "PLBELT 3 5 6 7 0.1", "PLBELT 3 5 6 7 -0.1"),
    "X": ("kinematics", "PLTRUSS 3 5 11\nX 11 1 2", "PLTRUSS 3 5 11\nX 11 1 3"),
    "FIX": ("kinematics", "FIX 7 1", "FIX 7 2"),
    "RLSE": ("kinematics", "RLSE 9 1", "RLSE 9 2"),
    "DYNX": ("kinematics", "DYNX 7 1", "DYNX 7 2"),
    "DYNE": ("kinematics", "DYNE 9 1", "DYNE 9 2"),
    "INPUTX": ("kinematics", "INPUTX 7 1", "INPUTX 7 2"),
    "INPUTE": ("kinematics", "INPUTE 9 1", "INPUTE 9 2"),
    "ESTIFF": ("dynamics", "ESTIFF 8 100", "ESTIFF 8 200"),
    "EM": ("dynamics", "EM 1 1", "EM 1 2"),
    "EDAMP": ("dynamics", "EDAMP 1 1", "EDAMP 1 2"),
    "XM": ("dynamics", "XM 4 1", "XM 4 -2"),
    "XF": ("dynamics", "XF 3 1", "XF 3 0 1"),
    "DELXF": ("dynamics", "DELXF 3 1", "DELXF 3 2"),
    "ESIG": ("dynamics", "ESIG 1 1", "ESIG 1 2"),
    "DELESIG": ("dynamics", "DELESIG 1 1", "DELESIG 1 2"),
    "EINIT": ("dynamics", "EINIT 1 1", "EINIT 1 2"),
    "ALPHA": ("dynamics", "ALPHA 1 1e-5", "ALPHA 1 2e-5"),
    "TEMP": ("dynamics", "ALPHA 1 1e-5\nTEMP 1 10", "ALPHA 1 1e-5\nTEMP 1 10 20 5"),
    "DELTEMP": ("dynamics", "ALPHA 1 1e-5\nDELTEMP 1 10", "ALPHA 1 1e-5\nDELTEMP 1 20"),
    "INPUTX again": ("dynamics", "INPUTX 5 1 0.1", "INPUTX 5 1 0.2"),
    "INPUTX velocity": ("dynamics", "INPUTX 5 1 0.1 1", "INPUTX 5 1 0.1 2"),
    "INPUTE again": ("dynamics", "INPUTE 2 3 0.1", "INPUTE 2 3 0.2"),
    "INPUTE acceleration": ("dynamics", "INPUTE 2 3 0.1 0 1", "INPUTE 2 3 0.1 0 2"),
    "DELINPX": ("dynamics", "DELINPX 5 1 0.1", "DELINPX 5 1 0.2"),
    "DELINPE": ("dynamics", "DELINPE 2 3 0.1", "DELINPE 2 3 0.2"),
    "GRAVITY": ("dynamics", "GRAVITY 0 1", "GRAVITY 1 0"),
    "STARTDX": ("dynamics", "STARTDX 9 1 4.1", "STARTDX 9 1 4 1"),
    "STARTDE": ("dynamics", "STARTDE 2 2 0.1", "STARTDE 2 2 0.2"),
    "TIMESTEP": ("dynamics", "TIMESTEP 1 10", "TIMESTEP 1 20"),
    "ERROR": ("dynamics", "ERROR 1e-3 1e-4", "ERROR 1e-3 1e-5"),
    "ITERSTEP": ("dynamics", "ITERSTEP 10 9 5e-7 1 3 0", "ITERSTEP 10 5 5e-7"),
    "USERSIG": ("dynamics", "USERSIG wall", "USERSIG floor"),
    "USERINP": ("dynamics", "USERINP wall", "USERINP floor"),
    "OUTLEVEL": ("kinematics", "OUTLEVEL 0 1", "OUTLEVEL 1 1"),
    "LEVELLOG": ("dynamics", "LEVELLOG 0 1", "LEVELLOG 1 1"),
    "INPUTF": ("signals", "INPUTF 1 3 1", "INPUTF 1 3 2"),
    "INPUTS": ("signals", "INPUTS 1 1 1", "INPUTS 1 1 2"),
    **{k: ("signals", f"{k} 1 3 1", f"{k} 1 3 2") for k in ("OUTX", "OUTXP", "OUTXDP")},
    **{k: ("signals", f"{k} 1 1 1", f"{k} 1 1 2") for k in ("INX", "INXP", "INXDP", "OUTF")},
    **{k: ("signals", f"{k} 1 9 1", f"{k} 1 9 2") for k in ("INE", "INEP", "INEDP")},
    **{k: ("signals", f"{k} 1 1 1", f"{k} 1 1 2") for k in ("OUTE", "OUTEP", "OUTEDP", "OUTS")},
    "TRAJX": ("dynamics", "TRAJX 9 1 0 1 2", "TRAJX 9 1 0 1 2 scurve"),
    "TRAJX signals": ("signals", "TRAJX 9 1 0 1 2", "TRAJX 9 1 0 1 3"),
    "TRAJE": ("dynamics", "TRAJE 2 3 0 1 2", "TRAJE 2 3 0 2 2"),
    "TRAJE signals": ("signals", "TRAJE 2 3 0 1 2", "TRAJE 2 3 0.5 1 2"),
    "NOMF": ("signals", "NOMF 1 3 1\nREFX 1 3 1", "NOMF 1 3 2\nREFX 1 3 1"),
    "NOMS": ("signals", "NOMS 1 1 1\nREFX 1 3 1", "NOMS 1 1 2\nREFX 1 3 1"),
    **{k: ("signals", f"{k} 1 3 1", f"{k} 1 3 2") for k in ("REFX", "REFXP", "REFXDP")},
    **{k: ("signals", f"{k} 1 1 1", f"{k} 1 1 2") for k in ("REFE", "REFEP", "REFEDP")},
    **{k: ("signals", f"{k} 1 2", f"{k} 2 3") for k in DRAWN},
    **{k: ("kinematics", f"{k} 1 2", f"{k} 2 3") for k in REFUSED},
    "HALT": ("signals", "HALT 1", "HALT 2"),
    "END": ("signals", "END 1", "END 2"),
}
IN_SPACE = {
    "BEAM": ("kinematics", "BEAM 3 5 6 7 8 1 0 0", "BEAM 3 5 6 7 8 0 0 1"),
    "BEAMW": ("kinematics", "BEAMW 3 5 6 11 7 8 12 1 0 0", "BEAMW 3 5 6 11 7 8 12 0 0 1"),
    "SBEAM": ("kinematics", "SBEAM 3 5 6 7 8 1 0 0 2", "SBEAM 3 5 6 7 8 1 0 0 3"),
    "RBEAM": ("kinematics", "RBEAM 3 5 6 7 1 0 0", "RBEAM 3 3 4 7 1 0 0"),
    "PINBODY": ("kinematics", "PINBODY 3 5 6 7", "PINBODY 3 3 4 7"),
    "TRUSS": ("kinematics", "TRUSS 3 5 7", "TRUSS 3 7 5"),
    "HINGE": ("kinematics", "HINGE 3 6 8 0 1 0\nTRUSS 8 5 7", "HINGE 3 6 8 0 0 1\nTRUSS 8 5 7"),
    "SCREW": ("kinematics", "SCREW 3 5 6 7 8 1 0 0 0.1", "SCREW 3 5 6 7 8 1 0 0 0.2"),
}
# A leaf spring and its section stand in two blocks; each case has one of them, or both.
SIZES = "SECTION 1 0.02 1e-3 2e11 8e10 7800"
LEAF = "{kinematics}\nX 3 1\nFIX 1\nFIX 2\nEND\nHALT\n{dynamics}\nEND\nHALT\n{signals}\nEND\nEND\n"
SIZED = LEAF.replace("{dynamics}", SIZES + "\n{dynamics}")
SHAPED = SIZED.replace("{kinematics}", "LEAF 1 1 2 3 4 0 0 1\n{kinematics}")
OF_LEAVES = {
    "LEAF": (SIZED, "kinematics", "LEAF 1 1 2 3 4 0 0 1 2", "LEAF 1 1 2 3 4 0 0 1 3"),
    "PLLEAF": (SIZED, "kinematics", "PLLEAF 1 1 2 3 4", "PLLEAF 1 3 4 1 2"),
    "CLAMP": (SHAPED, "kinematics", "CLAMP 1 1 0", "CLAMP 1 0 0"),
    "SECTION": (
        LEAF.replace("{kinematics}", "LEAF 1 1 2 3 4 0 0 1"),
        "dynamics",
        SIZES,
        SIZES + " 1e-5",
    ),
}
CASES = {**{k: (PLANE, *v) for k, v in IN_PLANE.items()}, **{k: (SPACE, *v) for k, v in IN_SPACE.items()}, **OF_LEAVES}
# What analyses take from the settings; a test below sees them arrive.
TAKEN = ("TIMESTEP", "ERROR", "INPUTX", "INPUTE", *WAYS, *NOMINAL, *REFERENCES)


def filled(base, block, line):
    lines = {"kinematics": "", "dynamics": "", "signals": "", block: line}
    if base is PLANE and not (block == "kinematics" and re.match("PL|X ", line)):
        lines["kinematics"] = TIED + "\n" + lines["kinematics"]
    elif base is PLANE:
        lines["kinematics"] += "\nPLTRUSS 8 7 9" if " 7" in line else "\nPLRBEAM 9 5 6 7\nPLTRUSS 8 7 9"
    elif base is SPACE:
        lines["kinematics"] += "\nX 7 2 3 0"
    return base.format(**lines)


def understood(text):
    """Everything that analyses take from a file, or the faults; and the warnings."""
    try:
        read = fm.read_spacar(text, callables={"wall": max, "floor": min})
    except fm.SpacarError as fault:
        return None, str(fault).splitlines()
    b = read.builder
    nodes = {name: (node.start, node.roles) for name, node in b.nodes.items()}
    members = {name: (m.element.name, m.nodes, m.roles, str(m.properties)) for name, m in b.members.items()}
    # Spectral beams of several orders bear one name.
    counts = {name: len(m.roles) for name, m in b.members.items()}
    settings = {k: v for k, v in read.settings.items() if k in TAKEN}
    return repr((nodes, members, counts, b.dofs, b.loads, b.signals, b.starts, settings)), read.warnings


def test_every_keyword_has_a_case():
    assert {k.split()[0] for k in CASES} == set(KEYWORDS)


@pytest.mark.parametrize("case", CASES)
def test_no_keyword_is_read_without_a_word(case):
    keyword, (base, block, *lines) = case.split()[0], CASES[case]
    (one, first), (other, second) = (understood(filled(base, block, line)) for line in lines)
    if None not in (one, other) and one != other:
        return
    for words, line in zip((first, second), lines, strict=True):
        number = filled(base, block, line).splitlines().index(line.splitlines()[-1]) + 1
        assert any(re.match(rf"text:{number}: .*\b{keyword}\b", w) for w in words), words


def test_what_a_simulation_takes_from_a_file(monkeypatch):
    taken = {}

    def simulate(model, times, **options):
        taken.update(options, times=times)
        raise fm.AnalysisError("seen", "")

    monkeypatch.setattr("flexmb.answers.mode_1_simulate.simulate", simulate)
    extra = "TIMESTEP 2 4\nERROR 1e-3 1e-6\nINPUTX 5 1 2.5 3\nINPUTE 2 3 0.5 0 7"
    text = filled(PLANE, "dynamics", extra).replace("DYNX 9 1", "FIX 9\nRLSE 9 2")
    read = fm.read_spacar(text)
    model = read.builder.build(check=False)
    asked = ModeRequest(read.builder, model, "text", "none", "named", 200, read.settings)
    monkeypatch.setattr(ModeRequest, "checked", lambda self: self.model)
    with pytest.raises(fm.AnalysisError, match=r"^$"):
        modes()[1].run(asked)
    np.testing.assert_array_equal(taken["times"], [0, 0.5, 1, 1.5, 2])
    assert taken["rtol"] == 1e-6
    # The absolute tolerance of a file is in metres, that of a simulation in extents of the mechanism, here 4 m by 1 m.
    assert 1e-3 / taken["atol"] == approx(4, rel=0.05)
    arguments = {name: [float(v) for v in motion.keywords.values()] for name, motion in taken["motion"].items()}
    assert arguments == {"5.x": [0.5, 3, 0], "2.e3": [0.5, 0, 7]}


# -- numbers ------------------------------------------------------------------------------------------------------

TRUSS = """PLTRUSS 1 1 2
X 1 0 0
X 2 0.1 0
FIX 1
FIX 2 2
RLSE 1 1
DYNX 2 1
END
HALT
XM 2 1
ESTIFF 1 10
END
END
"""
NUMBERS = {
    "X 2 nan 0": "X: node 2: x must be a finite number, but is 'nan'",
    "X 2 -inf 0": "X: node 2: x must be a finite number, but is '-inf'",
    "X 2 1e999 0": "X: node 2: x must be a finite number, but '1e999' is too large",
    "X 2 1e300 0": "X: node 2: x must be a finite number, but '1e300' is too large: at most 1e+50 is taken",
    "X 2 5e-324 0": "X: node 2: x must be 0 or at least 1e-100, but is '5e-324'",
    # Zero in double precision, though not as it is written.
    "X 2 0.01e-400 0": "X: node 2: x must be 0 or at least 1e-100, but is '0.01e-400'",
    "X 2 1_0 0": "X: node 2: x must be a number, but is '1_0'",
    "X 2 0x10 0": "X: node 2: x must be a number, but is '0x10'",
    "X 2 +-1 0": "X: node 2: x must be a number, but is '+-1'",
    "X 2 1,5 0": "X: node 2: x must be a number, but is '1,5'",
    "X 2 \u0663 0": "X: node 2: x must be a number, but is '\u0663'",
    "X 2 1e 0": "X: node 2: x must be a number, but is '1e'",
    "X \u0663 1 0": "X: node \u0663: node must be a whole number from 1, but is '\u0663'",
    "X -2 1 0": "X: node must be a whole number from 1, but is '-2'",
    "X 0 1 0": "X: node 0: node must be a whole number from 1, but is '0'",
    "X 2.0 1 0": "X: node must be a whole number from 1, but is '2.0'",
    "X 1234567890 1 0": "X: node 1234567890: node must be a whole number from 1 to 999999999, but is '1234567890'",
    "X 2 1 0 0": "X: node 2: has 2 coordinates in a planar mechanism, but 3 are given",
    "X 2 1 0 0 0": "X: node 2: too many parameters (5); expected: X node x [y] [z]",
    "X 99 1 0": "X: node 99: is in no element",
    "EINIT 1 1e308": "EINIT: element 1: value must be a finite number, but '1e308' is too large",
    "TIMESTEP 1 9999999999": "TIMESTEP: steps must be a whole number from 1 to 999999999, but is '9999999999'",
    "\ufb01x 2": "\ufb01x: unknown keyword",
    "TUBE " + "9" * 5000 + " 1 1": f"TUBE: element {printable('9' * 5000)}: element type is",
    "USERSIG \x1b[31m": r"USERSIG: needs the user routine '\x1b[31m'",
    "TIMENORM 1": "TIMENORM: element 1: is refused, since its parameters are not known; start and end of TRAJX and",
    "TUBE 3 1 2 3 4": "TUBE: element 3: element type is not available yet",
    "TROT 2 1 0 1 1": "TROT: element 2: is refused, since its parameters are not known; give the motion of a",
}


@pytest.mark.parametrize("line", NUMBERS, ids=lambda line: line[:20])
def test_numbers_that_are_none(line):
    block = re.match(r"[A-Z]+", line)
    rows = [row.block for row in ROWS if block and row.keyword == block[0]]
    if rows == [BLOCKS[1]]:
        text = TRUSS.replace("XM 2 1", "XM 2 1\n" + line)
    else:
        text = TRUSS.replace("X 2 0.1 0", line if line.startswith("X 2 ") else "X 2 0.1 0\n" + line)
    number = text.split("\n").index(line) + 1
    assert [f for f in faults(text) if f.startswith(f"text:{number}: {NUMBERS[line]}")], faults(text)
    assert all(f.isprintable() and len(f) < 400 for f in faults(text))


@pytest.mark.parametrize("value", [LARGEST, -LARGEST, SMALLEST, 0.0, -0.0])
def test_the_largest_and_the_smallest_number(value, tmp_path):
    read = fm.read_spacar(TRUSS.replace("XM 2 1", f"ESIG 1 {value!r}"))
    assert read.builder.loads["initial"]["prestress"]["element", "1", 1] == value
    fm.write_spacar(read, tmp_path / "again.dat")
    fm.read_spacar(tmp_path / "again.dat")


@pytest.mark.parametrize("value", [1e51, -1e60, 1e-101])
def test_a_number_that_is_not_read_is_not_written(value, tmp_path):
    read = fm.read_spacar(TRUSS)
    read.builder.prestress("1", value)
    with pytest.raises(fm.ModelError, match=re.escape(f"'ESIG 1 {value!r}' cannot be written to a SPACAR input file")):
        fm.write_spacar(read, tmp_path / "again.dat")
    assert list(tmp_path.iterdir()) == []


def test_nodes_are_numbered_within_what_is_read(tmp_path):
    b = fm.Builder()
    b.node("999999999", (0, 0))
    b.node("tip", (1, 0))
    b.add(fm.planar.truss, "999999999", "tip", name="999999999", section=fm.Rigidity(EA=1.0))
    fm.write_spacar(b, tmp_path / "again.dat")
    assert "PLTRUSS 999999999 999999999 1\n" in (tmp_path / "again.dat").read_text()


def test_a_value_that_has_no_effect_is_named_beside_one_that_has():
    text = TRUSS.replace("PLTRUSS 1 1 2", "PLBEAM 1 1 3 2 4").replace("ESTIFF 1 10", "ESTIFF 1 10\nESIG 1 1 0 2")
    (warning,) = fm.read_spacar(text).warnings
    assert "ESIG: deformation 3 of element 1 is fixed, so the value has no effect" in warning


PARAMETERS = TRUSS.replace("ESTIFF 1 10", "ESTIFF 1 {2*k_1 + 1e1}")


def test_parameters_of_a_file():
    read = fm.read_spacar(PARAMETERS, numbers={"k_1": 5, "e1": 2.0})
    assert read.parameters == ("k_1",)
    assert read.warnings == ["text: parameter 'e1' does not occur in the file"]
    assert fm.read_spacar(TRUSS, callables={"wall": max}).warnings == [
        "text: user routine 'wall' does not occur in the file"
    ]


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        ("0.5", TypeError, "'k_1' must be a real number, but is 0.5"),
        (True, TypeError, "'k_1' must be a real number"),
        (None, TypeError, "'k_1' must be a real number"),
        ([1.0], TypeError, "'k_1' must be a real number"),
        (np.ones(1), TypeError, "'k_1' must be a real number"),
        (1j, TypeError, "'k_1' must be a real number"),
        (10**400, TypeError, "'k_1' must be a real number"),
        (np.nan, ValueError, "'k_1' must be a finite number, but is nan"),
        (1e50, fm.SpacarError, "ESTIFF: element 1: value must be a finite number, but '{2*k_1 + 1e1}' is too large"),
    ],
)
def test_numbers_for_parameters_that_are_none(value, error, words):
    with pytest.raises(error, match=re.escape(words)):
        fm.read_spacar(PARAMETERS, numbers={"k_1": value})


def test_a_user_routine_is_a_function():
    with pytest.raises(TypeError, match="'wall' must be a function, but is 3"):
        fm.read_spacar(TRUSS, callables={"wall": 3})


# Lines with a number that may be traced, among those of PLANE, and of a mechanism in space.
TRACED = [
    *("TIMESTEP {t} 10", "ERROR {t} 1e-3", "ITERSTEP 10 9 {t}", "INPUTX 5 1 {t} {t} {t}", "INPUTE 2 3 {t} {t}"),
    *(
        "GRAVITY 0 {t}",
        "ESIG 1 {t} 1",
        "EINIT 1 {t}",
        "XF 5 {t} 1",
        "DELXF 5 {t}",
        "XM 4 {t}",
        "XM 3 {t}",
        "EM 2 {t} 1",
    ),
    *("EDAMP 2 {t}", "STARTDE 2 2 {t} {t}", "DELINPX 5 1 {t}", "DELESIG 1 {t}", "DELINPE 2 3 {t}"),
    *("ALPHA 1 {t}", "ALPHA 1 1e-5\nTEMP 1 {t} {t} {t}", "ALPHA 1 1e-5\nDELTEMP 1 {t}"),
]
TRACED_IN_SPACE = [
    *("ESIG 1 {t} {t} {t} {t} {t} {t}", "EINIT 1 {t} {t} {t} {t} {t} {t}", "XF 4 {t} 0 1", "XF 4 0 {t} 0 1"),
    *("XM 4 {t} 0 0 1 0 1", "ESTIFF 3 {t}", "ESTIFF 1 1 1 1 1 {t} {t}", "EM 1 {t} {t} {t} {t} {t}"),
]
TURNING = """SBEAM 1 1 2 3 4 0 1 {t}
SCREW 2 1 2 5 6 1 {t} 0 {t}
HINGE 3 4 7 0 {t} 1
X 3 1 0 {t}
X 5 2 0 0
DYNE 1 1 2 3 5
END
HALT
{stiff}"""


@pytest.mark.parametrize("line", [*TRACED, *TRACED_IN_SPACE])
def test_every_number_may_be_traced(line):
    stiff = "" if line.startswith("ESTIFF 1") else "ESTIFF 1 1 1 1 1\n"
    in_space = f"{TURNING.replace('{stiff}', stiff)}{line}\nEND\nEND\n"
    text = filled(PLANE, "dynamics", line) if line in TRACED else in_space

    def numbers(t):
        read = fm.read_spacar(text, numbers={"t": t})
        b = read.builder
        everything = [
            b.loads,
            b.starts,
            [m.properties for m in b.members.values()],
            [n.start for n in b.nodes.values()],
        ]
        settings = [v for k, v in read.settings.items() if k in (*TAKEN, "ITERSTEP")]
        leaves = jax.tree.leaves([list(_values(everything)), list(_values(settings))])
        return [jnp.asarray(leaf, float) for leaf in leaves if not isinstance(leaf, str | bool)]

    # What is traced is not known to be zero, and so is not left out.
    found = [[leaf for leaf in leaves if np.any(leaf)] for leaves in (jax.jit(numbers)(0.25), numbers(0.25))]
    for traced, plain in zip(*found, strict=True):
        np.testing.assert_allclose(traced, plain, rtol=1e-14)


def _values(of):
    """Contents of dictionaries whose keys have no order."""
    if isinstance(of, dict | list | tuple):
        for value in of.values() if isinstance(of, dict) else of:
            yield from _values(value)
    else:
        yield of


# -- files --------------------------------------------------------------------------------------------------------

COMMENT = "% Führung aus Stahl: 5 µm\n"
ENCODED = {
    "UTF-8": COMMENT.encode() + TRUSS.encode(),
    "UTF-8 with its mark": codecs.BOM_UTF8 + COMMENT.encode() + TRUSS.encode(),
    "Latin-1": (COMMENT + TRUSS).encode("latin-1"),
    "Windows": (COMMENT + TRUSS).replace("\n", "\r\n").encode("cp1252"),
    "old Macintosh": (COMMENT + TRUSS).replace("\n", "\r").encode("mac-roman"),
    # Copied from a web page.
    "spaces that do not break": (COMMENT + TRUSS.replace("X 1 0 0", "X\u00a01 0\u00a00")).encode(),
}


@pytest.mark.parametrize("encoding", ENCODED)
def test_encodings(encoding, tmp_path):
    path = tmp_path / "bar.dat"
    path.write_bytes(ENCODED[encoding])
    read = fm.read_spacar(path)
    assert (read.warnings, len(read.builder.nodes), read.builder.nodes["2"].start) == ([], 2, [0.1, 0.0])
    assert "hrung aus Stahl" in read.text
    assert "\ufeff" not in read.text


def test_a_text_may_begin_with_the_mark():
    assert fm.read_spacar("\ufeff" + TRUSS).warnings == []


NO_TEXT = {
    "UTF-16": (TRUSS.encode("utf-16"), "bar.dat:1: the file is in UTF-16; save it as UTF-8"),
    "UTF-16 of big end": (codecs.BOM_UTF16_BE + TRUSS.encode("utf-16-be"), "bar.dat:1: the file is in UTF-16"),
    "UTF-32": (TRUSS.encode("utf-32"), "bar.dat:1: the file is in UTF-32"),
    "no mark": (TRUSS.encode("utf-16-le"), "bar.dat:1: the file contains a zero byte"),
    "binary": (TRUSS.encode() + b"\n\0\1", "bar.dat:15: the file contains a zero byte"),
    "empty": (b"", "bar.dat:1: file is empty"),
    "comments": (b"% nothing\n", "bar.dat:1: file is empty"),
}


@pytest.mark.parametrize("case", NO_TEXT)
def test_what_is_no_text(case, tmp_path):
    content, words = NO_TEXT[case]
    path = tmp_path / "bar.dat"
    path.write_bytes(content)
    with pytest.raises(fm.SpacarError) as info:
        fm.read_spacar(path)
    assert str(info.value).startswith(words)


def test_a_file_without_end_is_not_read_whole(tmp_path):
    with pytest.raises(OSError, match="it is no regular file: '/dev/zero'"):
        fm.read_spacar("/dev/zero")
    with (tmp_path / "large.dat").open("wb") as file:
        file.truncate(LARGEST_FILE + 1)
    with pytest.raises(fm.SpacarError, match=f"large.dat:1: the file is too large. .* at most {LARGEST_FILE} bytes"):
        fm.read_spacar(tmp_path / "large.dat")


@pytest.mark.slow
@pytest.mark.parametrize("line", ["TURBINE {0} 2 3 4", "X {0} 1.0 y", "PLBEAM a b c d e f g h"])
def test_many_faults_take_little_memory(line):
    """Ten times the text at most, of which a copy is made: the lines are kept, their words are not."""
    text = "\n".join(line.format(i + 1) for i in range(20_000))
    tracemalloc.start()
    try:
        assert len(faults(text)) == 101
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # Text, line, its number and place: 300 bytes. As tuples of words the shortest line took 700.
    assert most < 20_000 * 350 + 2**20


@pytest.mark.slow
def test_a_file_of_another_kind_is_answered_shortly():
    found = faults("\n".join(f"word{i} \x07{'y' * 10**4} z" for i in range(10 * MOST_FAULTS)))
    assert len(found) == MOST_FAULTS + 1
    assert found[-1] == f"text: more than {MOST_FAULTS} faults; the others are not listed"
    assert all(line.isprintable() and len(line) < 300 for line in found)


def test_a_name_of_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "a\nb\udcff.dat"
    path.write_text("QQQ\n")
    with pytest.raises(fm.SpacarError) as info:
        fm.read_spacar(path)
    assert str(info.value).startswith(r"a\nb\udcff.dat:1: QQQ: unknown keyword")


@pytest.mark.slow
def test_many_lines_that_draw_are_one_short_warning():
    (warning,) = fm.read_spacar(TRUSS + "VISUALIZATION\n" + "COLOR 1 0 0\n" * 20000).warnings
    assert warning.endswith("COLOR (line 33), 19981 more")
