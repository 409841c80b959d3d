"""Spectral beams in SPACAR input files: PLSBEAM and SBEAM, by themselves and through the command line."""

import json

import numpy as np
import pytest
import scipy.optimize
from cases.commands import command
from cases.spacar_checks import assert_same, faults
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanisms import mechanism_path

fm.enable_x64()


def run(path, mode, *options):
    result = command("run", path, "--mode", mode, "--json", "-", *options)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def guide(tmp_path, order, name="pf2d"):
    """The tutorial's planar guide with one spectral beam a leaf spring; nothing else is changed."""
    text = mechanism_path(name).read_text()
    for ends in ("1 1 2 3 4", "3 5 6 7 8"):
        text = text.replace(f"PLBEAM {ends}", f"PLSBEAM {ends} {order}".rstrip())
    path = tmp_path / "guide.dat"
    path.write_text(text)
    return path


def exact_frequency():
    """Lowest frequency of the guide [Hz]: leaf springs as Euler-Bernoulli beams with clamped and guided ends."""
    bend, mass, length, top = 0.039375, 0.07065, 0.1, 0.103

    def unbalanced(beta):
        # w = a (cos - cosh) + b (sin - sinh) with w' = 0 at the top, where shear carries half the bar's inertia.
        b = beta * length
        a, c = np.cos(b) - np.cosh(b), np.sin(b) + np.sinh(b)
        w = a * (np.cos(b) - np.cosh(b)) + c * (np.sin(b) - np.sinh(b))
        third = beta**3 * (a * (np.sin(b) - np.sinh(b)) - c * (np.cos(b) + np.cosh(b)))
        omega2 = bend / mass * beta**4
        return bend * third + top * omega2 * w

    beta = float(scipy.optimize.brentq(unbalanced, 2.0, 14.0, xtol=1e-13))
    return np.sqrt(bend / mass) * beta**2 / (2 * np.pi)


@pytest.mark.slow
def test_guide_with_one_spectral_beam_a_leaf_spring(tmp_path):
    # A curvature that is linear along the leaf spring is a cubic beam: closed form of the tutorial's model.
    cubic = run(guide(tmp_path, 2), 7)
    np.testing.assert_allclose(cubic["frequencies_hz"], [10.6448473823], rtol=1e-10)
    assert (cubic["nx"], cubic["ne"], cubic["nxo"], cubic["neo"], cubic["ndof"]) == (20, 17, 6, 13, 1)
    # Order 4 unless said otherwise: 8 numbers a leaf spring in nx and ne besides the beam's 4 nodes and 3 deformations.
    usual = run(guide(tmp_path, ""), 7)
    assert (usual["nx"], usual["ne"], usual["nxo"], usual["neo"], usual["ndof"]) == (28, 25, 6, 17, 5)
    # The leaf spring's own mass changes its shape and lowers the frequency by 1e-5; order four knows that to 1e-4.
    assert usual["frequencies_hz"][0] == approx(exact_frequency(), rel=1e-9)
    assert usual["frequencies_hz"][0] < cubic["frequencies_hz"][0] * (1 - 5e-6)
    assert usual["dofs"][0] == {"kind": "x", "of": 3, "component": 1}
    # What the loop leaves open is made up by single coefficients of the bendings.
    assert all(d["kind"] == "e" and d["component"] >= 3 + 4 + 1 for d in usual["dofs"][1:])
    assert [len(usual[key]["1"]) for key in ("e", "sig")] == [3 + 2 * 4] * 2
    assert set(usual["x"]) == set(usual["modes"][0]) == set("12345678")
    check = run(guide(tmp_path, ""), 0)
    assert (check["status"], check["underconstraints"], check["dofs"]) == ("ok", 0, usual["dofs"])


@pytest.mark.slow
def test_buckling_load_of_the_guide(tmp_path):
    data = run(guide(tmp_path, 6, "pf2db"), 8)
    bend, length = 0.039375, 0.1

    def sway(load):
        """Stiffness of a column whose ends stay parallel, closed form; the other leaf spring bears no load."""
        k = np.sqrt(load / bend)
        return load * k / (2 * np.tan(k * length / 2) - k * length) + 12 * bend / length**3

    # The tutorial's 78.75 N is that of cubic beams.
    expected = scipy.optimize.brentq(sway, 60, 79)
    assert data["load_multipliers"][0] == approx(expected, rel=1e-6)
    assert set(data["compliance"]) == set("12345678")


COLUMN = """PLSBEAM 1 1 2 3 4 6
X 1 0 0
X 3 1 0
FIX 1
FIX 2
DYNE 1 1 2
END
HALT
ESTIFF 1 1e8 1
EM 1 1
XF 3 -3 0
END
END
"""


@pytest.mark.slow
def test_path_of_a_cantilever_through_its_buckling_load(tmp_path):
    path = tmp_path / "column.dat"
    path.write_text(COLUMN)
    data = run(path, 10)
    # Closed form; P/EA = 2.5e-8.
    (critical,) = data["critical_points"]
    assert critical["kind"] == "bifurcation"
    assert 3 * critical["load_factor"] == approx(np.pi**2 / 4, rel=1e-7)
    assert [s["load_factor"] < critical["load_factor"] for s in data["path"]] == [s["stable"] for s in data["path"]]
    assert data["path"][-1]["load_factor"] == 1.0
    assert len(data["dofs"]) == 12
    # The closure's stress is the force on node 3, the first coefficient of the elongation that of all of the beam.
    np.testing.assert_allclose(np.array(data["sig"]["1"])[[0, 1, 2, 3]], [-3, 0, 0, -3], atol=1e-9)


LATERAL = """SBEAM 1 1 2 3 4 0 1 0
X 3 1 0 0
FIX 1
FIX 2
DYNE 1 1 2 3 5
END
HALT
ESTIFF 1 1e9 1 1e6 1
EM 1 1 0.1 0.05 0.05
XF 3 0 0 1
END
END
"""


@pytest.mark.slow
def test_lateral_buckling_by_one_beam_of_the_usual_order(tmp_path):
    path, log = tmp_path / "lateral.dat", tmp_path / "lateral.log"
    path.write_text(LATERAL)
    data = run(path, 8, "--log", log)
    # THEORY.md 2: 4.0164 with four coefficients (exact 4.0126), to a unit of the last digit printed there.
    np.testing.assert_allclose(np.abs(data["load_multipliers"][:2]), 4.0164, rtol=0, atol=1e-4)
    # DYNE names a field by any number of the beam for it and makes all coefficients degrees of freedom.
    assert [d["component"] for d in data["dofs"]] == list(range(7, 7 + 4 * 4))
    assert (data["nx"], data["ne"], data["nxo"], data["neo"], data["ndof"]) == (28, 22, 6, 6, 16)
    text = log.read_text()
    assert "closure 1 to 6, elongation 7 to 10, torsion 11 to 14, bending about y 15 to 18, bending about z" in text


def member(text):
    return fm.read_spacar(text).builder.members["1"]


def roles(text):
    """Numbers of the deformations that are not FIXED."""
    return [n for n, role in enumerate(member(text).roles, 1) if role.value != "fixed"]


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ("1", range(7, 11)),
        ("2", range(11, 15)),
        ("3", range(15, 19)),
        ("4", range(15, 19)),
        ("3 4", range(15, 19)),
        ("5", range(19, 23)),
        ("5 6", range(19, 23)),
        ("1 2 3 4 5 6", range(7, 23)),
        ("3 19 20", range(15, 21)),
    ],
)
@pytest.mark.parametrize("keyword", ["RLSE", "DYNE"])
def test_numbers_of_the_beam_stand_for_whole_fields(keyword, numbers, expected):
    assert roles(LATERAL.replace("DYNE 1 1 2 3 5", f"{keyword} 1 {numbers}")) == list(expected)


@pytest.mark.slow
def test_shear_is_counted_where_it_is_given(tmp_path):
    text = LATERAL.replace("1e9 1 1e6 1", "1e9 1 1e6 1 0.02 0.01").replace("1 0\n", "1 0 3\n", 1)
    assert member(text).element is spatial.spectral_beam(3, shear=True)
    assert member(LATERAL).element is spatial.spectral_beam(4)
    section = member(text).properties["section"]
    assert (section.shear_z, section.shear_y) == (0.02, 0.01)
    # A beam that bends along z shears along z; along y, both are fixed without number 5 or 6.
    assert roles(text.replace("DYNE 1 1 2 3 5", "RLSE 1 3")) == [*range(13, 16), *range(22, 25)]
    assert roles(text.replace("DYNE 1 1 2 3 5", "RLSE 1 6")) == [*range(16, 19), *range(19, 22)]
    # Written as they were read: the two fields of a number lie apart in e.
    fm.write_spacar(fm.read_spacar(text.replace("DYNE 1 1 2 3 5", "RLSE 1 6 3")), tmp_path / "shear.dat")
    assert "RLSE 1 3 5\n" in (tmp_path / "shear.dat").read_text()
    # Timoshenko: tip compliance l^3/3EI + l/GAk, both with EI = 1e6 and EI/GAk = 0.02.
    unloaded = text.replace("XF", "% XF")
    found = fm.linear.directional_compliance(fm.read_spacar(unloaded).builder.build(dofs="named"))["3"]
    np.testing.assert_allclose(found[1:], [1 / 3 + 0.01, (1 / 3 + 0.02) / 1e6], rtol=1e-6)


def stressed_and_strained(count, keyword, which):
    """Lines of which one says a millionth; every file has both, so that all are one structure."""
    values = {one: [1e-6 * (one == keyword and i == which) for i in range(count)] for one in ("ESIG", "EINIT")}
    return "\n".join(" ".join([one, "1", *map(str, numbers)]) for one, numbers in values.items())


@pytest.mark.slow
@pytest.mark.parametrize("keyword", ["ESIG", "EINIT"])
@pytest.mark.parametrize("which", range(6))
def test_prestress_and_strain_mean_what_they_mean_for_a_beam(keyword, which):
    text = LATERAL.replace("XF 3 0 0 1", stressed_and_strained(6, keyword, which)).replace("1e9 1 1e6 1", "2 3 5 7")
    # Two coefficients know what a beam knows: a bending that is linear along it.
    text = text.replace("X 3 1", "X 3 2").replace("4 0 1 0\n", "4 0 1 0 2\n")
    beam = (
        text.replace("SBEAM", "BEAM")
        .replace("0 1 0 2", "0 1 0")
        .replace("DYNE 1 1 2 3 5", "RLSE 1 1 2 3 4 5 6\nDYNX 3 1 2 3\nDYNX 4 2 3 4")
    )
    found, expected = (fm.equilibrium(fm.read_spacar(t).builder.build(dofs="named")) for t in (text, beam))
    for node in ("3", "4"):
        # Small deformations: what is left is their square, 1e-12.
        np.testing.assert_allclose(found.at(node), expected.at(node), rtol=0, atol=1e-11)
    assert np.max(np.abs(np.asarray(found.at("3")) - [2, 0, 0])) + np.max(np.abs(found.at("4")[1:])) > 1e-8


@pytest.mark.slow("0-ESIG", "0-EINIT", "1-ESIG", "1-EINIT", "2-EINIT")
@pytest.mark.parametrize("keyword", ["ESIG", "EINIT"])
@pytest.mark.parametrize("which", range(3))
def test_prestress_and_strain_in_the_plane(keyword, which):
    text = COLUMN.replace("XF 3 -3 0", stressed_and_strained(3, keyword, which)).replace("1e8 1", "2 3")
    text = text.replace("X 3 1", "X 3 2").replace("4 6\n", "4 2\n")
    beam = text.replace("PLSBEAM 1 1 2 3 4 2", "PLBEAM 1 1 2 3 4").replace("DYNE 1 1 2", "DYNE 1 1 2 3")
    found, expected = (fm.equilibrium(fm.read_spacar(t).builder.build(dofs="named")) for t in (text, beam))
    for node in ("3", "4"):
        np.testing.assert_allclose(found.at(node), expected.at(node), rtol=0, atol=1e-11)
    assert np.max(np.abs(np.asarray(found.at("3")) - [2, 0])) + np.max(np.abs(found.at("4"))) > 1e-8


EVERYTHING = """SBEAM 1 1 2 3 4 0 1 0 3
SBEAM 2 3 4 5 6 0 1 0
X 3 1 0 0
X 5 2 0 0
FIX 1
FIX 2
DYNE 1 1 2
DYNE 1 3
RLSE 1 16 17 20
INPUTE 1 18
DYNE 2 8 7
RLSE 2 2 3 20
END
HALT
ESTIFF 1 1e6 1 2 3 0.02 0.01
ESTIFF 2 1e6 1 2 3
EM 1 1 0.1 0.05 0.05 0.01
EDAMP 2 1 2 3 4
XF 5 0 0 1
INPUTE 1 18 0.1
DELINPE 1 18 0.2
ESIG 1 2 3 4 5 6 7 0.25
DELESIG 2 0 0 0 0 0 0 1 2 3
EINIT 2 1e-3 0 1e-3
STARTDE 2 8 1e-3
END
HALT
INPUTS 1 2 8
OUTE 1 2 20
OUTS 2 1 7
END
END
"""


def test_everything_survives_a_round_trip(tmp_path):
    model = fm.read_spacar(EVERYTHING)
    assert [m.element for m in model.builder.members.values()] == [
        spatial.spectral_beam(3, shear=True),
        spatial.spectral_beam(4),
    ]
    fm.write_spacar(model, tmp_path / "again.dat")
    again = fm.read_spacar(tmp_path / "again.dat")
    assert_same(again.builder, model.builder)
    assert again.settings == model.settings
    text = (tmp_path / "again.dat").read_text()
    for line in ("SBEAM 1 1 2 3 4 0.0 1.0 0.0 3", "DYNE 1 3", "RLSE 1 16 17 20", "INPUTE 1 18", "RLSE 2 2 3 20"):
        assert line + "\n" in text


def named(**extra):
    leaf = fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850))
    b = fm.Builder()
    for name, place in {"foot": (0, 0), "top": (0, 0.1), "far": (0.1, 0.1), "base": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.spectral_beam(), "foot", "top", name="left", section=leaf, **extra)
    b.add(planar.spectral_beam(3), "base", "far", name="right", section=leaf, damping=fm.Damping(EA=1.0, EIy=1e-6))
    b.add(planar.rigid_beam, "top", "far", section=fm.Rigidity(mass=2.0))
    b.rotation("crank")
    b.add(planar.hinge, "far", "crank", stiffness=0.3)
    b.fix("foot")
    b.fix("base", "position")
    b.fix("base", "rotation")
    b.mass("far", 0.2)
    b.inertia("crank", 1e-3)
    b.dof("crank", 1)
    return b


@pytest.mark.slow
def test_named_mechanism_of_python(tmp_path):
    fm.write_spacar(named(), tmp_path / "guide.dat")
    text = (tmp_path / "guide.dat").read_text()
    assert "PLSBEAM 1 1 5 2 6 5\n" in text
    assert "RLSE 1 1 2\n" in text
    again, there = (b.build() for b in (fm.read_spacar(tmp_path / "guide.dat").builder, named()))
    # Other coefficients may be taken to make up the number of degrees of freedom; the motions are the same.
    np.testing.assert_allclose(fm.frequencies(again), fm.frequencies(there), rtol=1e-9)


@pytest.mark.parametrize("element", [spatial.spectral_beam(2), spatial.leaf_spring(order=2)])
def test_a_local_y_that_is_not_given_is_written_as_it_is_taken(element, tmp_path):
    b = fm.Builder()
    for name, place in {"foot": (0, 0, 0), "top": (0.1, 0.02, 0.03)}.items():
        b.node(name, place)
    b.add(element, "foot", "top", section=fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850)))
    b.fix("foot")
    fm.write_spacar(b, tmp_path / "leaf.dat")
    # The axis that the beam is least along.
    np.testing.assert_array_equal(member(tmp_path / "leaf.dat").properties["y"], [0, 1, 0])


INEXPRESSIBLE = {
    "Element 'left' (spectral_beam) has an initial curvature": named(curvature=2.0),
    "Element 'left' (spectral_beam) has a role, a load or a signal at deformations 1 to 3 (closure)": named(),
    "'left.internal' contains coordinates of an element": named(),
}
_CLOSED, _INTERNAL = list(INEXPRESSIBLE.values())[1:]
_CLOSED.release("left", "closure_y")
_INTERNAL.force("left.internal", (1.0,))


@pytest.mark.parametrize("message", INEXPRESSIBLE)
def test_what_the_format_cannot_express_is_refused(message, tmp_path):
    with pytest.raises(fm.ModelError) as info:
        fm.write_spacar(INEXPRESSIBLE[message], tmp_path / "guide.dat")
    assert message in str(info.value)
    assert list(tmp_path.iterdir()) == []


BAD = [
    (
        "SBEAM 1 1 2 3 4 0 1 0",
        "SBEAM 1 1 2 3 4",
        "1: SBEAM: element 1: too few parameters (5); expected: SBEAM element",
    ),
    ("0 1 0\n", "0 1 0 0\n", "1: SBEAM: element 1: p must be a whole number from 1, but is '0'"),
    ("0 1 0\n", "0 1 0 2.5\n", "1: SBEAM: element 1: p must be a whole number from 1, but is '2.5'"),
    ("0 1 0\n", "0 1 0 999\n", "1: SBEAM: element 1: p, the coefficients of a strain field, must be at most 40"),
    ("0 1 0\n", "0 1 0 4 4\n", "1: SBEAM: element 1: too many parameters (10)"),
    ("0 1 0\n", "1 0 0\n", "1: SBEAM: element 1: has a local y vector that is zero or parallel"),
    ("X 3 1 0 0", "X 3 0 0 0", "1: SBEAM: element 1: has zero length"),
    ("DYNE 1 1 2 3 5", "DYNE 1 1 1", "5: DYNE: element 1: deformation 1 is named twice"),
    ("DYNE 1 1 2 3 5", "DYNE 1 3\nRLSE 1 4", "6: RLSE: element 1: deformation 4 has a role already by DYNE on line 5"),
    (
        "DYNE 1 1 2 3 5",
        "DYNE 1 23",
        "5: DYNE: element 1: deformation 23 is out of range: element 1 has deformations 1 to",
    ),
    (
        "DYNE 1 1 2 3 5",
        "INPUTE 1 3",
        "5: INPUTE: element 1: SBEAM has a strain field there; name one of its coefficients by its number in e, from 7",
    ),
    ("DYNE 1 1 2 3 5", "INPUTE 2 1", "5: INPUTE: element 2: there is no element 2 (there are: 1)"),
    ("1e9 1 1e6 1\n", "1e9 1 1e6 1 0.1\n", "8: ESTIFF: element 1: SBEAM counts shear in both directions or in none"),
    ("1e9 1 1e6 1\n", "1e9 1 1e6 1 1 1 1\n", "8: ESTIFF: element 1: SBEAM takes at most 6 numbers (EA, GIt, EIy, EIz"),
    ("1e9 1 1e6 1\n", "1e9 -1\n", "8: ESTIFF: element 1: GIt must not be negative, but is -1.0"),
    ("XF 3 0 0 1\n", "STARTDE 1 3 1\n", "10: STARTDE: element 1: SBEAM has a strain field there"),
    ("END\nEND", "END\nHALT\nOUTS 1 1 3\nEND\nEND", "13: OUTS: output 1: SBEAM has a strain field there"),
]


@pytest.mark.parametrize(("old", "new", "expected"), BAD)
def test_one_fault(old, new, expected):
    (fault,) = faults(LATERAL.replace(old, new, 1))
    assert fault.startswith("text:" + expected)


PLANAR = [
    (
        "1e8 1\n",
        "1e8 1 0.5\n",
        "9: ESTIFF: element 1: PLSBEAM has no shear deformation: this number must be 0, but is 0.5",
    ),
    ("4 6\n", "4 1\n", "11: ESIG: element 1: values 2 and 3 differ: bending that varies needs p of at least 2"),
]


@pytest.mark.parametrize(("old", "new", "expected"), PLANAR)
def test_one_fault_in_the_plane(old, new, expected):
    text = COLUMN.replace("XF 3 -3 0", "ESIG 1 0 1 2").replace(old, new, 1)
    (fault,) = faults(text)
    assert fault.startswith("text:" + expected)


@pytest.mark.slow
def test_a_leaf_spring_too_many_is_released_by_a_coefficient(tmp_path):
    text = mechanism_path("pf3dover").read_text()
    for ends in ("1 1 2 3 4", "3 5 6 7 8"):
        text = text.replace(f"BEAM {ends} 0 1 0", f"SBEAM {ends} 0 1 0 2")
    path = tmp_path / "over.dat"
    path.write_text(text)
    data = run(path, 0)
    assert (data["status"], data["overconstraints"], data["underconstraints"]) == ("overconstrained", 1, 0)
    # Not the closure: to release that would cut the leaf spring.
    release = data["mobility"][0]["release"]
    assert release["element"] in (1, 3)
    assert release["component"] > 6
    # As one cubic beam a leaf spring (printed 10.6464, half a unit), and as the release written into the file.
    released = run(path, 7, "--release", "auto")
    assert released["frequencies_hz"][0] == approx(10.6464, abs=5e-5)
    path.write_text(text.replace("DYNX 3 2", f"DYNX 3 2\nRLSE {release['element']} {release['component']}"))
    np.testing.assert_allclose(run(path, 7)["frequencies_hz"], released["frequencies_hz"], rtol=1e-9)
