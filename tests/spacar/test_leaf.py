"""Leaf springs in SPACAR input files: LEAF, PLLEAF, SECTION and CLAMP, by themselves and through the command line."""

import dataclasses
import json
import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.commands import command
from cases.spacar_checks import assert_same, faults
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.answers.mode_1_simulate import over_time
from flexmb.model.topology import Role

fm.enable_x64()

STEEL = fm.Material(210e9, 80e9, 7850.0, alpha=12e-6)
SECTION = fm.Rectangle(0.018, 0.5e-3, STEEL)
NUMBERS = "0.018 0.5e-3 210e9 80e9 7850 12e-6"

# Two leaf springs in line, the second with a free end; a mass hangs at it on a rigid beam, without its rotation.
CHAIN = f"""LEAF 1 1 2 3 4 0 1 0 2
LEAF 2 3 4 5 6 0 1 0 2
X 1 0 0 0
X 3 0.04 0 0
X 5 0.1 0 0
FIX 1
FIX 2
RLSE 1 1 2 3 4 5 6
RLSE 2 1 2 3 4 5 6
END
HALT
SECTION 1 {NUMBERS}
SECTION 2 {NUMBERS}
XM 5 0.05
XF 5 0.2 0.3 0.1
EDAMP 2 1 1e-5 1e-6
TEMP 2 10 20
END
HALT
INPUTF 1 5 3
OUTX 1 5 3
OUTE 2 2 8
END
END
"""


def chain() -> fm.Builder:
    """The same in Python."""
    b = fm.Builder()
    for name, x in {"1": 0.0, "3": 0.04, "5": 0.1}.items():
        b.node(name, (x, 0, 0))
    damping = fm.Damping(EA=1, GIt=1e-5, EIy=1e-6)
    b.add(spatial.leaf_spring, "1", "3", name="first", section=SECTION, order=2, y=(0, 1, 0))
    b.add(spatial.leaf_spring, "3", "5", name="last", section=SECTION, order=2, y=(0, 1, 0), damping=damping)
    b.fix("1")
    b.mass("5", 0.05)
    b.force("5", (0.2, 0.3, 0.1))
    b.temperature("last", [10, 20])
    return b


PLANE = f"""PLLEAF 1 1 2 3 4 3
PLRBEAM 2 3 4 5
X 1 0 0
X 3 0 0.1
X 5 0.05 0.1
FIX 1
FIX 2
RLSE 1 1 2 3
END
HALT
SECTION 1 {NUMBERS}
XM 5 0.2
XF 5 0.1 0
END
END
"""


def plane() -> fm.Builder:
    b = fm.Builder()
    for name, place in {"1": (0, 0), "3": (0, 0.1), "5": (0.05, 0.1)}.items():
        b.node(name, place)
    b.add(planar.leaf_spring, "1", "3", name="leaf", section=SECTION, order=3)
    b.add(planar.rigid_beam, "3", "5")
    b.fix("1")
    b.mass("5", 0.2)
    b.force("5", (0.1, 0))
    return b


@pytest.mark.slow
@pytest.mark.parametrize(("text", "build"), [(CHAIN, chain), (PLANE, plane)])
def test_a_file_is_the_mechanism_of_python_and_survives_round_trips(text, build, tmp_path):
    read = fm.read_spacar(text)
    assert read.warnings == []
    lin, there = (fm.linearize(b.build(dofs="named")) for b in (read.builder, build()))
    fm.write_spacar(read, tmp_path / "again.dat")
    assert_same(fm.read_spacar(tmp_path / "again.dat").builder, read.builder)
    fm.write_spacar(build(), tmp_path / "python.dat")
    written = fm.linearize(fm.read_spacar(tmp_path / "python.dat").builder.build(dofs="named"))
    for matrix in ("M0", "K0", "N0", "G0", "D0"):
        expected = np.asarray(getattr(there, matrix))
        # The sums of forces that an equilibrium leaves, 1e-10 of them.
        close = {"rtol": 1e-9, "atol": 1e-9 * np.max(np.abs(expected), initial=0.0)}
        np.testing.assert_allclose(getattr(lin, matrix), expected, **close)
        np.testing.assert_allclose(getattr(written, matrix), expected, **close)


def run(tmp_path, text, mode, *options):
    path = tmp_path / "leaf.dat"
    path.write_text(text)
    result = command("run", path, "--mode", mode, "--json", "-", *options)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


@pytest.mark.slow
def test_answers_of_the_command_line(tmp_path):
    data, log = run(tmp_path, CHAIN, 8, "--log", tmp_path / "a.log"), (tmp_path / "a.log").read_text()
    assert "closure 1 to 6, warping 7 and 8, elongation 9 to 10, torsion 11 to 12, bending about y 13 to 14" in log
    # Twelve coefficients each; the warping where the two meet, and that of the free end, by themselves.
    assert data["ndof"] == len(data["dofs"]) == 26
    warped = {(d["of"], d["component"]) for d in data["dofs"] if d["component"] in (7, 8)}
    assert (2, 8) in warped
    assert len(warped - {(1, 8), (2, 7)}) == len(warped) - 1
    free = run(tmp_path, CHAIN, 0)
    assert [free[key] for key in ("dofs", "nxo", "underconstraints")] == [data["dofs"], data["nxo"], 0]
    # Nothing is told by node of what has no number; the deformations tell it.
    assert set(data["x"]) == set(data["modes"][0]) == set(data["compliance"]) == set("123456")
    labels = fm.read_spacar(CHAIN).builder.build(check=False).labels.x
    assert set(over_time(np.zeros((1, len(labels))), labels)) == set("123456")
    assert set(data["reactions"]) == {"1", "2"}
    assert len(data["e"]["1"]) == 8 + 6 * 2
    np.testing.assert_allclose(data["reactions"]["1"], [-0.2, -0.3, -0.1], atol=1e-9)
    # Bending at the foot: of the soft axis and of the stiff one, and tension; the tip is drawn down a little.
    soft, stiff = 0.018 * 0.5e-3**2 / 6, 0.5e-3 * 0.018**2 / 6
    expected = 0.1 * 0.1 / soft + 0.3 * 0.1 / stiff + 0.2 / 9e-6
    # At a clamp, which shares the moment unevenly over the width: within 5 % of solid elements.
    assert data["stress"]["maximum"] == approx(expected, rel=0.05)
    assert (data["stress"]["element"], data["stress"]["place"]) == (1, 0.0)
    states = run(tmp_path, CHAIN, 9)
    assert states["outputs"] == ["position 5.3", "deformation 2.8"]
    assert np.shape(states["A"]) == (52, 52)


def roles(text, *nodes):
    """Roles of the warping at nodes, once the mechanism is built."""
    model = fm.read_spacar(text).builder.build(check=False)
    found = dict(zip([entry.of for entry in model.labels.x], model.roles()[0], strict=True))
    return [found[f"{node}.warping"] for node in nodes]


@pytest.mark.slow
def test_what_restrains_warping_in_a_file(tmp_path):
    assert roles(CHAIN, 2, 4, 6) == [Role.FIXED, Role.DEPENDENT, Role.DEPENDENT]
    # Three Euler parameters hold the fourth.
    assert roles(CHAIN.replace("FIX 2", "FIX 2 2 3 4"), 2)[0] is Role.FIXED
    # One that does not twist does not warp, and its neighbour not where they meet.
    stiff = CHAIN.replace("RLSE 1 1 2 3 4 5 6", "RLSE 1 1 3 4 5 6")
    assert roles(stiff, 2, 4, 6) == [Role.FIXED, Role.FIXED, Role.DEPENDENT]
    # A beam by its numbers says nothing of its thickness; CLAMP says what it does.
    beam = CHAIN.replace("LEAF 2 3 4 5 6 0 1 0 2", "BEAM 2 3 4 5 6 0 1 0").replace(
        f"SECTION 2 {NUMBERS}", "ESTIFF 2 1e6"
    )
    beam = beam.replace("TEMP 2", "% ").replace("OUTE 2 2 8", "% ")
    (fault,) = faults(beam)
    assert fault.startswith(
        "text:1: LEAF: element 1: whether '2' clamps its last end cannot be found, since its section"
    )
    assert fault.endswith("in a file by CLAMP.")
    said = beam.replace("X 1 0 0 0", "CLAMP 1 1 0\nX 1 0 0 0")
    assert roles(said, 2, 4) == [Role.FIXED, Role.DEPENDENT]
    (fault,) = faults(CHAIN.replace("X 1 0 0 0", "CLAMP 1 1 0\nCLAMP 2 1 0\nX 1 0 0 0"))
    assert fault.startswith(
        "text:1: LEAF: element 1: Elements '1' and '2' share their warping at '4.warping', but only"
    )
    fm.write_spacar(fm.read_spacar(said), tmp_path / "again.dat")
    assert "CLAMP 1 1 0\n" in (tmp_path / "again.dat").read_text()
    assert_same(fm.read_spacar(tmp_path / "again.dat").builder, fm.read_spacar(said).builder)


@pytest.mark.slow
def test_numbers_of_a_section_may_be_traced():
    text = PLANE.replace("RLSE 1 1 2 3", "DYNE 1 1 2").replace("0.018 0.5e-3", "{w} {t}")

    def rigidity(sizes):
        model = fm.read_spacar(text, numbers={"w": sizes[0], "t": sizes[1]}).builder.build()
        section = next(own["section"] for own in model.parameters.properties if "clamped" in own)
        return section.width[0] * section.thickness[0] ** 3 / 12

    found = jax.grad(rigidity)(jnp.array([0.018, 0.5e-3]))
    np.testing.assert_allclose(found, [0.5e-3**3 / 12, 0.018 * 0.5e-3**2 / 4], rtol=1e-12)


def test_a_rigid_leaf_spring_is_pointed_out():
    (warning,) = fm.read_spacar(CHAIN.replace("RLSE 1 1 2 3 4 5 6\n", "")).warnings
    assert warning == (
        "text:1: LEAF: element 1 is rigid: RLSE 1 1 2 3 4 5 6 makes it a leaf spring that deforms freely"
    )


@pytest.mark.slow
def test_no_deformation_of_a_rigid_leaf_spring_is_proposed_for_release():
    text = (
        CHAIN.replace("LEAF 2 3 4 5 6", "LEAF 2 1 2 3 4")
        .replace("X 5 0.1 0 0\n", "")
        .replace("RLSE 1 1 2 3 4 5 6\n", "")
    )
    text = re.sub("(?m)^(XM|XF|INPUTF|OUTX|OUTE) .*$", "", text.replace("RLSE 2 1 2 3 4 5 6", "RLSE 2 3"))
    found = fm.mobility(fm.read_spacar(text).builder.build(check=False))
    # Both join the same nodes: what node 3 cannot do is said by the first already.
    assert found.overconstraints == len(found.release) == 4
    assert {proposal[0] for proposal in found.release if proposal} == {"2"}


BAD = [
    (f"SECTION 2 {NUMBERS}\n", "", "2: LEAF: element 2: needs its section in the dynamics block: SECTION 2 width"),
    (
        f"SECTION 2 {NUMBERS}",
        f"ESTIFF 2 1\nSECTION 2 {NUMBERS}",
        "13: ESTIFF: element 2: LEAF takes no ESTIFF: SECTION",
    ),
    (f"SECTION 2 {NUMBERS}", f"EM 2 1\nSECTION 2 {NUMBERS}", "13: EM: element 2: LEAF takes no EM: SECTION gives its"),
    ("EDAMP 2", "ALPHA 2 1e-5\nEDAMP 2", "16: ALPHA: element 2: LEAF takes no ALPHA: alpha is the last number of its"),
    ("2 0.018 0.5e-3", "2 0.018 0", "13: SECTION: element 2: has thickness = 0.0, but it must be positive"),
    ("2 0.018 0.5e-3 210e9 80e9", "2 0.018 0.5e-3 210e9 60e9", "13: SECTION: element 2: has nu = 0.75 by E and G, but"),
    (f"SECTION 2 {NUMBERS}", "SECTION 2 1 1 1", "13: SECTION: element 2: too few parameters (4); expected: SECTION"),
    (f"SECTION 2 {NUMBERS}", f"SECTION 2 {NUMBERS} 1", "13: SECTION: element 2: too many parameters (8); expected"),
    (f"SECTION 2 {NUMBERS}", f"SECTIN 2 {NUMBERS}", "13: SECTIN: unknown keyword; did you mean SECTION?"),
    ("RLSE 2 1", "RLSE 2 7 1", "9: RLSE: element 2: deformation 7 of LEAF is the warping of an end: joined parts"),
    ("RLSE 2 1 2 3 4 5 6", "DYNE 2 8", "9: DYNE: element 2: deformation 8 of LEAF is the warping of an end: joined"),
    ("RLSE 2 1 2 3 4 5 6", "INPUTE 2 8", "9: INPUTE: element 2: deformation 8 of LEAF is the warping of an end"),
    ("RLSE 2 1 2 3 4 5 6", "INPUTE 2 2", "9: INPUTE: element 2: LEAF has a strain field there; name one of its coeff"),
    ("INPUTF 1 5 3", "INPUTS 1 2 7", "20: INPUTS: input 1: deformation 7 of LEAF is the warping of an end"),
    (
        "XM 5",
        "ESIG 2 1\nXM 5",
        "14: ESIG: element 2: LEAF accepts only values of single coefficients, from deformation 9",
    ),
    ("X 1 0", "CLAMP 1 1\nX 1 0", "3: CLAMP: element 1: too few parameters (2); expected: CLAMP element first last"),
    (
        "X 1 0",
        "CLAMP 1 2 0\nX 1 0",
        "3: CLAMP: element 1: first must be 1 for a clamped end or 0 for a free one, but is",
    ),
    (
        "0 1 0 2\nLEAF",
        "0 1 0 41\nLEAF",
        "1: LEAF: element 1: p, the coefficients of a strain field, must be at most 40",
    ),
    ("0 1 0 2\nLEAF", "1 0 0 2\nLEAF", "1: LEAF: element 1: has a local y vector that is zero or parallel to its axis"),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD)
def test_one_fault(old, new, expected):
    assert CHAIN.count(old) == 1
    (fault,) = faults(CHAIN.replace(old, new))
    assert fault.startswith("text:" + expected)


@pytest.mark.parametrize(
    ("line", "expected"), [("SECTION 1 1 1 1 1 1", "instead of SECTION"), ("CLAMP 1 1 1", "no CLAMP")]
)
def test_only_leaf_springs_take_it(line, expected):
    text = "PLBEAM 1 1 2 3 4\nX 3 1\nEND\nHALT\nEND\nEND\n"
    at = "END\nHALT\n" if line.startswith("SECTION") else "X 3 1\n"
    (fault,) = faults(text.replace(at, f"{at}{line}\n"))
    assert expected in fault


def other(**changes):
    """The chain with another section of its last leaf spring."""

    def change(b):
        own = b.members["last"].properties
        material = {k: changes.pop(k) for k in ("nu", "strength", "fatigue", "damping") if k in changes}
        section = dataclasses.replace(SECTION, material=dataclasses.replace(STEEL, **material), **changes)
        b.members["last"].properties = {**own, "section": section}

    return change


def _tapered(b):
    b.members["last"].properties["section"] = fm.sections.taper(SECTION, dataclasses.replace(SECTION, width=0.01))


INEXPRESSIBLE = {
    "Element 'last' (leaf_spring) has a section that varies along it": _tapered,
    "Element 'last' (leaf_spring): its section has strength, which": other(strength=1e9),
    "Element 'last' (leaf_spring): its section has fatigue, which": other(fatigue=1e8),
    "Element 'last' (leaf_spring): its section has no rotary inertia, which": other(rotary=False),
    "Element 'last' (leaf_spring): its section has damping, which": other(damping=1e-5),
    "Element 'last' (leaf_spring): its section has nu other than E/(2 G) - 1": other(nu=0.3),
    "Element 'last' (leaf_spring): its section has torsion by an approximation": other(torsion="approximate"),
    "'5.warping' has a role, a load or a signal": lambda b: b.fix("5.warping", 1),
    "'3.warping' has a role, a load or a signal": lambda b: b.dof("3.warping", "w"),
    "Element 'last' (leaf_spring) has a role, a load or an input at its warping, deformations 7 and 8": lambda b: b.dof(
        "last", 8
    ),
}


@pytest.mark.slow("Element 'last' (leaf_spring) has a role, a load or an input at its warping, deformations 7 and 8")
@pytest.mark.parametrize("message", INEXPRESSIBLE)
def test_what_the_format_cannot_express_is_refused(message, tmp_path):
    b = chain()
    INEXPRESSIBLE[message](b)
    with pytest.raises(fm.ModelError) as info:
        fm.write_spacar(b, tmp_path / "chain.dat")
    assert message in str(info.value)
    assert list(tmp_path.iterdir()) == []
