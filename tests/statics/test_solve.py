"""The search for an equilibrium, where there is no stiffness before there is stress."""

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

EA, TENSION = 1e5, 50.0


@pytest.mark.parametrize("how", ["strain", "temperature", "prescribed", "force"])
def test_a_string_is_tightened(how):
    """A mass on a string of length one vibrates across it by sqrt(4 T/(m l)), however the tension comes about."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (i / 2, 0))
    for i in range(2):
        b.add(planar.truss, f"n{i}", f"n{i + 1}", name=f"s{i}", section=fm.Rigidity(EA=EA, alpha=1e-5))
    b.fix("n0")
    b.fix("n2", "y")
    b.mass("n1", 1.0)
    if how in ("strain", "temperature"):
        b.fix("n2", "x")
        for i in range(2):
            b.strain(f"s{i}", -TENSION * 0.5 / EA) if how == "strain" else b.temperature(f"s{i}", -TENSION / EA / 1e-5)
    elif how == "prescribed":
        b.prescribe("n2", "x", TENSION / EA)
    else:
        b.mass("n2", 1e-3)
        b.force("n2", (TENSION, 0))
    length = 1.0 if how in ("strain", "temperature") else 1 + TENSION / EA
    expected = np.sqrt(4 * TENSION / length) / (2 * np.pi)
    assert fm.frequencies(b.build(), count=1)[0] == pytest.approx(expected, rel=1e-9)
