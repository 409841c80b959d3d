"""Sizes of cross-sections in files: stress against beam theory, what does not go together, and the way back."""

import json

import numpy as np
import pytest
from cases.commands import command
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.mechanisms import mechanism_path

E, L, FORCE = 210e9, 0.1, 1e-3
# Two sides; outer and inner sides; diameter; outer and inner diameter: area, Iy, Iz, half the side along z and along y.
W, T, WI, TI, D, DI = 0.02, 0.004, 0.016, 0.002, 0.006, 0.004
SHAPES = {
    "rect": ((W, T), W * T, W * T**3 / 12, T * W**3 / 12, T / 2, W / 2),
    "recthol": (
        (W, T, WI, TI),
        W * T - WI * TI,
        (W * T**3 - WI * TI**3) / 12,
        (T * W**3 - TI * WI**3) / 12,
        T / 2,
        W / 2,
    ),
    "circ": ((D,), np.pi * D**2 / 4, np.pi * D**4 / 64, np.pi * D**4 / 64, D / 2, D / 2),
    "circhol": (
        (D, DI),
        *(np.pi * (D**2 - DI**2) / 4, np.pi * (D**4 - DI**4) / 64, np.pi * (D**4 - DI**4) / 64, D / 2, D / 2),
    ),
}


def cantilevers(along: str) -> str:
    """A beam of each shape along x, clamped at its first end, with a force along an axis at its last."""
    first, then, sizes = [], [], []
    for k, (name, (numbers, area, iy, iz, *_)) in enumerate(SHAPES.items()):
        p, r, q, s = (4 * k + i for i in range(1, 5))
        first += [f"BEAM {k + 1} {p} {r} {q} {s} 0 1 0", f"X {p} 0 {k} 0", f"X {q} {L} {k} 0", f"FIX {p}", f"FIX {r}"]
        first.append(f"RLSE {k + 1} 1 2 3 4 5 6")
        then.append(f"ESTIFF {k + 1} {E * area!r} 1 {E * iy!r} {E * iz!r}")
        then.append(f"XF {q} {' '.join(str(FORCE * (axis == along)) for axis in 'xyz')}")
        sizes += [f"BEAMPROPS {k + 1}", f"CROSSTYPE {name}", f"CROSSDIM {' '.join(map(str, numbers))}"]
    return "\n".join([*first, "END", "HALT", *then, "END", "END", "VISUALIZATION", *sizes]) + "\n"


@pytest.mark.slow
def test_stress_of_sizes_is_that_of_beam_theory(tmp_path):
    """M c/I at the foot, M = F l, for bending along z and along y: sizes lie along local y first."""
    read = {along: fm.read_spacar(cantilevers(along)) for along in "yz"}
    for along, one in read.items():
        assert (one.warnings, one.settings) == ([], {})
        found = fm.stress(one.builder.build())
        for name, row, (_, _, iy, iz, z, y) in zip(SHAPES, np.asarray(found.sigma_x), SHAPES.values(), strict=True):
            expected = FORCE * L * (z / iy if along == "z" else y / iz)
            # The tip goes aside by 1e-5 of the length.
            assert np.max(row[0]) == approx(expected, rel=1e-6), (along, name)
    # What is written has the same stress.
    fm.write_spacar(read["z"], tmp_path / "again.dat")
    again = fm.read_spacar(tmp_path / "again.dat")
    assert (again.warnings, again.settings) == ([], {})
    for name in read["z"].builder.members:
        own, other = (b.builder.members[name].properties["section"].outline for b in (read["z"], again))
        assert repr(own) == repr(other)


def test_sections_of_python_are_written_with_their_sizes(tmp_path):
    steel = fm.Material(E=E, G=80e9, rho=7850.0)
    for section, line in (
        (fm.Tube(0.01, 0.001, steel), "circhol\nCROSSDIM 0.01 0.008"),
        (fm.Circle(0.01, steel), "circ"),
    ):
        b = fm.Builder()
        b.node("foot", (0, 0))
        b.node("top", (0, L))
        b.add(planar.beam, "foot", "top", section=section)
        b.fix("foot")
        fm.write_spacar(b, tmp_path / "one.dat")
        assert f"BEAMPROPS 1\nCROSSTYPE {line}" in (tmp_path / "one.dat").read_text()
    # Without sizes nothing is drawn.
    b = fm.read_spacar(mechanism_path("pf2d"))
    fm.write_spacar(b, tmp_path / "two.dat")
    assert "VISUALIZATION" not in (tmp_path / "two.dat").read_text()


GUIDE = mechanism_path("pf3d").read_text().replace("EM 2 ", "XF 5 0 1 0\nEM 2 ")


def drawn(lines: str) -> str:
    return f"{GUIDE}VISUALIZATION\n{lines}\n"


def test_sizes_that_do_not_go_with_the_stiffness_are_told():
    flat, line = (
        "CROSSTYPE rect\nCROSSDIM 0.0005 0.018",
        "text:5: BEAM: element 1: sizes do not agree with the stiffness: ",
    )
    assert fm.read_spacar(drawn(f"BEAMPROPS 1 3\n{flat}")).warnings == []
    (told, other) = fm.read_spacar(drawn("BEAMPROPS 1 3\nCROSSTYPE rect\nCROSSDIM 0.018 0.0005")).warnings
    assert told.startswith(f"{line}EIy/EA is 2.7e-05 m^2 by ESTIFF and 2.083e-08 by CROSSDIM, EIz/EA is ")
    assert "exchanged they agree" in told
    assert "element 3" in other
    (told,) = fm.read_spacar(drawn("BEAMPROPS 1\nCROSSTYPE circ\nCROSSDIM 0.0005")).warnings
    assert told.startswith(line)
    assert "exchanged" not in told
    # Of a rigid bar they are drawn alone, and kept.
    mixed = fm.read_spacar(drawn(f"BEAMPROPS 1 2 3\n{flat}\nCOLOR 1 0 0"))
    assert len(mixed.settings["VISUALIZATION"]) == 5
    assert mixed.warnings[0].endswith("have no effect on results: VISUALIZATION (line 50), COLOR (line 54)")
    assert mixed.builder.members["3"].properties["section"].has_shape


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("BEAMPROPS 1\nCROSSTYPE oval\nCROSSDIM 1", "CROSSTYPE must be one of rect, recthol, circ, circhol, line"),
        ("BEAMPROPS 1\nCROSSTYPE rect\nCROSSDIM 1", "CROSSDIM of rect takes 2 sizes, but has 1"),
        ("BEAMPROPS 1\nCROSSTYPE rect\nCROSSDIM 1 thick", "value must be a number, but is 'thick'"),
        ("BEAMPROPS 1\nCROSSTYPE circhol\nCROSSDIM 1 0", "CROSSDIM: wall = 0.5, which leaves no hole"),
        ("BEAMPROPS 9\nCROSSTYPE circ\nCROSSDIM 1", "there is no element 9"),
        (
            "BEAMPROPS 1\nCROSSTYPE circ\nCROSSDIM 1\nBEAMPROPS 1\nCROSSTYPE circ\nCROSSDIM 1",
            "is given already on line 51; give it once",
        ),
    ],
)
def test_sizes_that_are_none_are_refused(lines, told):
    with pytest.raises(fm.SpacarError, match=r"text:5[14]: BEAMPROPS: element [19]: ") as info:
        fm.read_spacar(drawn(lines))
    assert told in str(info.value)


@pytest.mark.slow
def test_the_command_line_answers_and_draws_it(tmp_path):
    (tmp_path / "a.dat").write_text(drawn("BEAMPROPS 1 3\nCROSSTYPE rect\nCROSSDIM 0.0005 0.018"))
    result = command("run", tmp_path / "a.dat", "--mode", 7, "--json", "-", "--plot", tmp_path / "a.svg")
    found = json.loads(result.stdout)["stress"]
    # Half of the force on each leaf spring, and half of its moment at either end: 6 M/(w t^2). The axial force of 0.5 N
    # adds 0.2 %, and moves 0.2 % of the force from the pressed to the pulled leaf spring.
    assert found["maximum"] == approx(6 * 0.5 * 0.05 / (0.018 * 0.0005**2), rel=5e-3)
    assert (found["element"], found["place"]) == (1, 0.0)
    # Beside the mode, as the tutorial's figure 4.11.
    text = (tmp_path / "a.svg").read_text()
    assert "von Mises stress [MPa]" in text
    assert "mode 1: " in text
