"""Motions of what is held, reactions, constraint forces and axes of rotations as inputs and outputs of a file."""

import numpy as np
import pytest
from cases.spacar_checks import assert_same

import flexmb as fm

fm.enable_x64()

# A spring with a damper between a base and two masses that a rigid bar joins.
K, D, M2, M3 = 1000.0, 2.0, 0.5, 0.3
MASSES = """PLTRUSS 1 1 2
PLTRUSS 2 2 3
X 1 0 0
X 2 0.1 0
X 3 0.2 0
FIX 1
FIX 2 2
FIX 3 2
RLSE 1 1
DYNX 2 1
END
HALT
XM 2 0.5
XM 3 0.3
ESTIFF 1 100
EDAMP 1 0.2
END
HALT
INXP 1 1 1
INPUTF 2 3 1
OUTX 1 2 1
OUTS 2 2 1
OUTF 3 1 1
END
END
"""


@pytest.mark.slow
def test_a_base_that_moves_and_forces_that_are_transmitted(tmp_path):
    """Newton's equations of the masses, of the second one and of the base, without any state space."""
    read = fm.read_spacar(MASSES)
    assert read.warnings == []
    fm.write_spacar(read, tmp_path / "again.dat")
    assert_same(fm.read_spacar(tmp_path / "again.dat").builder, read.builder)
    found, _ = fm.control.state_matrices(read.builder.build())
    a, b, c, d = (np.asarray(part) for part in found)
    for s in (3j, 1.0 + 40j):
        gain = c @ np.linalg.solve(s * np.eye(len(a)) - a, b) + d
        spring, inertia = K + D * s, (M2 + M3) * s**2
        # Of the velocity of the base, and of the force on the second mass.
        x = np.array([spring / s, 1.0]) / (inertia + spring)
        bar = np.array([0.0, 1.0]) - M3 * s**2 * x
        support = -spring * (x - np.array([1 / s, 0.0]))
        np.testing.assert_allclose(gain, [x, bar, support], rtol=1e-9)


@pytest.mark.slow
def test_axes_of_a_rotation_in_space(tmp_path):
    """A unit moment twists a shaft of G It/L = 4 N m/rad by a quarter; a file says axes by rx, ry and rz."""
    text = """BEAM 1 1 2 3 4 0 0 1
X 1 0 0 0
X 3 0.5 0 0
FIX 1
FIX 2
DYNE 1 1 2 3 4 5 6
END
HALT
XM 3 1
XM 4 1 0 0 1 0 1
ESTIFF 1 1 2 1 1
END
HALT
INPUTF 1 4 RX
OUTX 1 4 rx
OUTF 2 2 rx
REFX 1 4 rz
END
END
"""
    read = fm.read_spacar(text)
    assert read.warnings == []
    fm.write_spacar(read, tmp_path / "again.dat")
    again = fm.read_spacar(tmp_path / "again.dat")
    assert_same(again.builder, read.builder)
    assert again.settings["REFX"][0][:3] == (1, 4, "rz")
    found, _ = fm.control.state_matrices(read.builder.build())
    static = found.D - np.asarray(found.C) @ np.linalg.solve(found.A, found.B)
    np.testing.assert_allclose(static[:, 0], [0.25, -1.0], rtol=1e-9)
    assert [s.name for s in read.builder.signals["input"]] == ["moment 4.rx"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("INX 3 2 1", "coordinate 1 is free to move"),
        ("INE 3 1 1", "deformation 1 is free to move"),
        ("OUTF 4 3 1", "coordinate 1 is free, so no support acts there"),
        (
            "INPUTF 3 1 1",
            "coordinate 1 is fixed or prescribed, so a force on it has no effect; let it act on one that moves, or mo",
        ),
        ("OUTX 4 2 ry", "ry is an axis of a rotation in space, but node 2 is none; its coordinate is 1 to 2"),
    ],
)
def test_signals_that_cannot_be(line, words):
    with pytest.raises(fm.SpacarError, match=words):
        fm.read_spacar(MASSES.replace("OUTF 3 1 1", f"OUTF 3 1 1\n{line}"))
