"""A beam far shorter than the mechanism is as good as none: answers are those without it, or are refused by name."""

import itertools
from typing import Any

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

LEAF = fm.Rectangle(width=0.018, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850))


def cantilever(gap, positions=False):
    """Three beams of 50 mm, one of the length `gap` if there is any, and a mass on its end."""
    b = fm.Builder()
    nodes = "ABCDE" if gap else "ABCD"
    for name, x in zip(nodes, (0, 0.05, 0.1, 0.15, 0.15 + gap), strict=False):
        b.node(name, (x, 0))
    for p, q in itertools.pairwise(nodes):
        b.add(planar.beam, p, q, name=p + q, section=LEAF)
    b.fix("A")
    b.mass(nodes[-1], 0.1)
    for node in "BCDE" if positions else "":
        for component in ("x", "y", "phi"):
            b.dof(node, component)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-6, 1e-9])
def test_a_short_beam_is_as_good_as_none(gap):
    """But for its share gap/0.15 of what bends, and round-off eps 0.15/gap of its length: 7e-6 and 3e-8."""
    model = cantilever(gap)
    expected = np.asarray(fm.frequencies(cantilever(0), count=3))
    tolerance = dict(rtol=max(1e-6, 3 * gap / 0.15))
    np.testing.assert_allclose(fm.frequencies(model, count=3), expected, **tolerance)
    modes = fm.modes(model)
    np.testing.assert_allclose(modes.frequencies[:3], expected, **tolerance)
    assert modes.stable
    poles: Any = fm.poles(model)[:6:2]
    np.testing.assert_allclose(np.abs(poles.imag) / (2 * np.pi), expected, **tolerance)
    assert np.all(np.abs(poles.real) < 1e-9 * np.abs(poles))


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-5, 1e-6, 1e-8, 1e-10])
def test_what_round_off_hides_is_refused_by_name(gap):
    """Of positions, the stiffness of the short beam leaves no digits: eps EI/gap^3 beside that of the leaf spring."""
    with pytest.raises(fm.AnalysisError, match=r"round-off .* 'DE'") as fault:
        fm.frequencies(cantilever(gap, positions=True))
    assert fault.value.code == "lost_in_round_off"
    with pytest.raises(fm.AnalysisError, match=r"round-off .* 'DE'|singular"):
        fm.frequencies(cantilever(gap), sparse=True, count=3)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-6, 1e-8, 1e-10])
def test_a_compliance_that_round_off_hides_is_refused_by_name(gap):
    with pytest.raises(fm.AnalysisError, match=r"round-off .* 'DE'|singular"):
        fm.compliance(cantilever(gap), "E", sparse=True)


@pytest.mark.slow
def test_a_compliance_is_exact_beside_a_short_beam():
    length = 0.15 + 3e-6
    expected = length**3 / (3 * LEAF.material.E * LEAF.width * LEAF.thickness**3 / 12)
    # Round-off, which deformations do not multiply; stiffnesses differ by 1e13.
    found = fm.compliance(cantilever(3e-6), "E", sparse=True)
    np.testing.assert_allclose(found[1, 1], expected, rtol=1e-13)
