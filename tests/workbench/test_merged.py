"""Rotations of a file beside their positions."""

import flexmb as fm
from flexmb import planar
from flexmb.workbench.merged import merged


def test_a_rotation_beside_two_positions_stays_by_itself():
    b = fm.Builder()
    for name, place in {"1": (0, 0), "3": (1, 0), "5": (0, 1), "6": (1, 1)}.items():
        b.node(name, place)
    for name in ("2", "4", "7"):
        b.rotation(name)
    b.add(planar.beam, "1", "2", "3", "4", name="1")
    b.add(planar.beam, "5", "2", "6", "7", name="2")
    found = merged(b)
    assert found.members["1"].nodes == ("1", "2", "3", "3.rotation")
    assert found.members["2"].nodes == ("5", "2", "6", "6.rotation")
