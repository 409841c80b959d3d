"""BEAMW in SPACAR input files: a strip that is twisted beside its closed form, round trips, faults."""

import json
import re

import numpy as np
import pytest
from cases.commands import command
from cases.spacar_checks import assert_same, faults
from cases.tolerances import approx

import flexmb as fm
from flexmb import spatial

GIT, EIW, LENGTH = 0.0589, 1.2e-5, 0.1
# A strip of two beams: node 6 is the warping that they share, 9 that of the tip.
STRIP = """
BEAMW 1 1 2 3 4 5 6 0 1 0
BEAMW 2 4 5 6 7 8 9 0 1 0
X 1 0 0 0
X 4 0.05 0 0
X 7 0.1 0 0
FIX 1
FIX 2
FIX 3{fixed}
DYNE 1 1 2 3 4 5 6
DYNE 2 1 2 3 4 5 6
DYNX {free}
END
HALT
ESTIFF 1 1.89e6 0.0589 0.04 51 0 0 1.2e-5
ESTIFF 2 1.89e6 0.0589 0.04 51 0 0 1.2e-5
EM 1 0.07 2e-6 0 0 0 3e-12
EM 2 0.07 2e-6 0 0 0 3e-12
XM 7 0.1
XM 8 1e-6 0 0 1e-6 0 1e-6
{more}END
HALT
OUTX 1 6 1
END
END
"""
FREE = STRIP.format(fixed="", free="6 1\nDYNX 9 1", more="")
CLAMPED = STRIP.format(fixed="\nFIX 9", free="6 1", more="")
LOADED = STRIP.format(fixed="\nFIX 9", free="6 1", more="XF 6 0.01\n")


# At a support that says nothing of its warping, it is free, and deformation 7 goes with it.
LOOSE = FREE.replace("FIX 3\n", "DYNE 1 7\n")


@pytest.mark.slow("one", "both")
@pytest.mark.parametrize(("text", "ends"), [(LOOSE, 0), (FREE, 1), (CLAMPED, 2)], ids=["none", "one", "both"])
def test_twist_by_the_closed_form(text, ends):
    """REFERENCES.md T7-torsion, (2.10)."""
    al = LENGTH * np.sqrt(GIT / EIW)
    expected = LENGTH / GIT * (1 - (ends and ends * np.tanh(al / ends) / al))
    found = fm.compliance(fm.read_spacar(text).builder.build(dofs="named"), "8")
    assert found.shape == (3, 3)
    assert float(found[0, 0]) == approx(expected, rel=1e-12)


def by_hand():
    b = fm.Builder()
    for name, x in (("1", 0.0), ("4", 0.05), ("7", 0.1)):
        b.node(name, (x, 0, 0))
    for name in ("2", "5", "8"):
        b.rotation(name)
    for name in ("3", "6", "9"):
        b.warping(name)
    section = fm.Rigidity(1.89e6, 0.04, 51.0, GIT, EIw=EIW, mass=0.07, Jx=2e-6, Jw=3e-12)
    for name, ends in (("1", "123456"), ("2", "456789")):
        b.add(spatial.warping_beam, *ends, name=name, section=section, y=(0, 1, 0), clamped=False)
    for node in "123":
        b.fix(node)
    b.mass("7", 0.1)
    b.inertia("8", (1e-6, 0, 0, 1e-6, 0, 1e-6))
    return b


@pytest.mark.slow
def test_the_same_by_hand_and_after_a_round_trip(tmp_path):
    read = fm.read_spacar(LOADED)
    fm.write_spacar(read, tmp_path / "again.dat")
    again = fm.read_spacar(tmp_path / "again.dat")
    assert_same(again.builder, read.builder)
    assert read.warnings == again.warnings == []
    models = [b.build() for b in (by_hand(), fm.read_spacar(FREE).builder)]
    # Other degrees of freedom: round-off times the square of the largest frequency over the smallest, 7e3.
    np.testing.assert_allclose(*map(fm.frequencies, models), rtol=1e-8)
    assert [model.topology.n_q for model in models] == [14, 14]


@pytest.mark.slow
def test_what_a_build_finds_is_written(tmp_path):
    """Of a leaf spring between a support and a body, whose names are words, in beams of a rectangle."""
    b = fm.Builder()
    for i, name in enumerate(("foot", "middle", "top")):
        b.node(name, (0.05 * i, 0, 0))
    section = fm.Rectangle(0.018, 0.5e-3, fm.Material(210e9, 80e9, 7800.0), shear=True)
    b.add(spatial.warping_beam, "foot", "middle", name="lower", section=section, y=(0, 1, 0))
    b.add(spatial.warping_beam, "middle", "top", name="upper", section=section, y=(0, 1, 0))
    b.fix("foot")
    b.mass("top", 0.1, inertia=(1e-5, 0, 0, 1e-5, 0, 1e-5))
    fm.write_spacar(b, tmp_path / "guide.dat")
    read = fm.read_spacar(tmp_path / "guide.dat")
    lines = (tmp_path / "guide.dat").read_text().splitlines()
    assert [line for line in lines if line.startswith("FIX")] == ["FIX 1", "FIX 4", "FIX 5", "FIX 9"]
    np.testing.assert_allclose(*(fm.frequencies(c.build()) for c in (read.builder, b)), rtol=1e-8)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("BEAMW 1 1 2 3 4 5 6 0 1 0", "BEAMW 1 1 2 3 4 5", "BEAMW: element 1: too few parameters (6); expected: BEAMW"),
        ("3 4 5 6 0 1 0", "3 4 5 3 0 1 0", "BEAMW: element 1: joins node 3 to itself; BEAMW needs two nodes warpp and"),
        (
            "BEAMW 2 4 5 6",
            "BEAMW 2 4 5 2",
            "BEAMW: element 2: takes node 2 for a warping node, but it is a rotational node on line 2 (BEAMW)",
        ),
        ("FIX 1\n", "FIX 1\nX 3 0 0 0\n", "X: node 3: is a warping node (BEAMW on line 2): only a translational node"),
        ("FIX 1\n", "FIX 1\nFIX 6 2\n", "FIX: node 6: coordinate 2 is out of range: node 6 has coordinates 1 to 1"),
        ("51 0 0 1.2e-5\nESTIFF 2", "51\nESTIFF 2", "BEAMW: element 1: has a section without warping rigidity EIw"),
        ("0.04 51 0 0 1.2e-5\nEM", "0.04 51 0 0 -1\nEM", "ESTIFF: element 2: EIw must not be negative, but is -1.0"),
        (
            "51 0 0 1.2e-5\nEM",
            "51 0 0 1.2e-5 0\nEM",
            "ESTIFF: element 2: BEAMW takes at most 7 numbers (EA, GIt, EIy, EIz, shear_z, shear_y, EIw), but 8",
        ),
        ("3e-12\nEM 2", "3e-12 1\nEM 2", "EM: element 1: BEAMW takes at most 6 numbers (mass, Jx, Jy, Jz, Jyz, Jw)"),
        (
            "XM 7 0.1\n",
            "XM 7 0.1\nXM 6 1\n",
            "XM: node 6: is a warping node and has no lumped mass: the sixth number of EM of",
        ),
        ("XM 7 0.1\n", "XM 7 0.1\nXF 6 1 2\n", "XF: node 6: warping node takes at most 1 components, but 2 are given"),
    ],
)
def test_wrong_lines_are_named(old, new, expected):
    assert old in FREE
    found = faults(FREE.replace(old, new, 1))
    assert len(found) == 1
    assert found[0].partition(":")[2].partition(": ")[2].startswith(expected)


@pytest.mark.slow("7", "8", "10")
@pytest.mark.parametrize("mode", [0, 7, 8, 10])
def test_the_command_line_answers(mode, tmp_path):
    (tmp_path / "strip.dat").write_text(LOADED)
    run = command("run", tmp_path / "strip.dat", "--mode", mode, "--json", "-")
    assert run.exit_code == 0, run.output
    found = json.loads(run.stdout)
    assert found["ndof"] == 13
    if mode == 7:
        # A bimoment on the middle warps it. Nothing else is loaded: the tip turns, and no torque is in the strip, where
        # the twist rate fades as sinh(alpha x).
        alpha = np.sqrt(GIT / EIW)
        warped = 0.01 * np.tanh(0.05 * alpha) / (2 * EIW * alpha)
        assert found["x"]["6"][0] == approx(warped, rel=1e-9)
        assert found["x"]["9"] == [0.0]
        held = EIW * alpha / np.sinh(0.05 * alpha) * warped
        np.testing.assert_allclose([found["reactions"][n][0] for n in ("3", "9")], [-held, -held], rtol=1e-9)


@pytest.mark.slow
def test_a_leaf_spring_shares_the_warping_of_a_beam(tmp_path):
    """The second half of the strip as LEAF: it takes node 6 from BEAMW, and keeps it when it is written."""
    sized = "SECTION 2 0.018 0.5e-3 210e9 80e9 7800\n"
    text = re.sub("(?m)^(DYNE 2|DYNX 9|ESTIFF 2|EM 2).*\n", "", FREE).replace("DYNX 6 1\n", "RLSE 2 1 2 3 4 5 6\n")
    text = text.replace("BEAMW 2 4 5 6 7 8 9 0 1 0", "LEAF 2 4 5 7 8 0 1 0 2\nCLAMP 2 0 0").replace(
        "XM 7", sized + "XM 7"
    )
    read = fm.read_spacar(text)
    assert read.builder.members["2"].nodes[:6] == ("4", "5", "6", "7", "8", "8.warping")
    fm.write_spacar(read, tmp_path / "again.dat")
    assert_same(fm.read_spacar(tmp_path / "again.dat").builder, read.builder)
    (fault,) = faults(text.replace("LEAF", "BEAMW 3 4 5 10 1 2 3\nLEAF"))
    assert "shares the warping of node 5, where BEAMW names several: 6, 10" in fault
