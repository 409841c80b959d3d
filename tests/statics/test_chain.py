"""Chains by sparse matrices, beside tables and balances, and beside dense matrices."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.statics import equilibrium

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0, alpha=11.5e-6)


@pytest.mark.slow
def test_elastica():
    """Mattiasson 1981, Numerical results from large deflection beam and frame problems, table 1: P L^2 = 2 EI."""
    b = fm.Builder()
    for i in range(51):
        b.node(f"n{i}", (i / 50, 0.0))
    for i in range(50):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.fix("n0")
    b.force("n50", (0.0, 2.0))
    found = fm.equilibrium(b.build())
    # Order two of the beams: 6e-5 is measured with 50, 2.4e-4 with 25; five digits are printed.
    np.testing.assert_allclose(found.position("n50"), (1 - 0.16064, 0.49346), atol=2e-4)
    # The load's lever, from forces alone.
    assert float(found.reaction("n0", "phi")) == approx(-2.0 * float(found.position("n50")[0]), rel=1e-7)


def arm(check):
    """An arm in space of eight pieces, one of them rigid and one that does not stretch, its tip held at a place."""
    section = fm.Rectangle(0.01, 1e-3, STEEL)
    b = fm.Builder()
    for i in range(9):
        b.node(f"n{i}", (0.03 * min(i, 5), 0.03 * max(i - 5, 0), 0.0))
    for i in range(8):
        along = {"y": (0, 0, 1)}
        if i == 3:
            b.add(spatial.beam, "n3", "n4", **along)
        elif i == 5:
            b.add(spatial.beam, "n5", "n6", section=section, released=(2, 3, 4, 5, 6), **along)
        else:
            b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=section, name=f"piece {i}", **along)
    b.fix("n0")
    b.mass("n8", 0.02)
    b.gravity((0, 0.5, -9.81))
    b.prescribe("n8", "z", 0.002)
    b.force("n8", (0.3, 0.0, 0.0))
    b.temperature("piece 1", 20.0)
    return b.build(check=check)


@pytest.mark.slow
def test_rigid_pieces_and_what_is_prescribed():
    found = fm.equilibrium(arm(check=False), sparse=True)
    wanted = fm.equilibrium(arm(check=True), sparse=False)
    # Both iterate to 1e-9 of the extent, beyond which the error is its square.
    np.testing.assert_allclose(found.x, wanted.x, atol=1e-10)
    np.testing.assert_allclose(found.sigma, wanted.sigma, atol=1e-8 * float(np.max(np.abs(wanted.sigma))))
    # The supports bear weight and force.
    mass = 0.02 + 7 * 0.03 * 7850.0 * 0.01 * 1e-3
    held = np.asarray(found.reaction("n0"))[:3] + np.array([0, 0, float(found.reaction("n8", "z"))])
    np.testing.assert_allclose(held, (-0.3, -0.5 * mass, 9.81 * mass), atol=1e-8)


@pytest.mark.slow
def test_a_motion_without_stiffness_is_named(monkeypatch):
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.1 * i, 0.0))
        if i:
            b.add(planar.beam, f"n{i - 1}", f"n{i}", section=fm.Rectangle(0.01, 1e-3, STEEL))
    b.fix("n0", "position")
    b.force("n3", (1.0, 0.0))
    # The load turns it nowhere: a solution there is, and no stiffness that says it is the one.
    with pytest.raises(fm.AnalysisError, match=r"a motion has no stiffness.* resists n0\.rotation\.phi \(1\), n1"):
        fm.equilibrium(b.build(check=False), sparse=True)
    # Of many coordinates it is found by sparse factors.
    monkeypatch.setattr(equilibrium, "LARGE", 0)
    with pytest.raises(fm.AnalysisError, match=r"a motion has no stiffness.* resists n0\.rotation\.phi \(1\), n1"):
        fm.equilibrium(b.build(check=False), sparse=True)


@pytest.mark.slow
def test_bars_between_beams_far_apart_along_the_chain():
    """A loop of beams whose two sides a bar joins; dense matrices know of no order."""
    b = fm.Builder()
    places = [(i, 0.0) for i in range(6)] + [(5 - i, 1.0) for i in range(6)]
    for i, place in enumerate(places):
        b.node(f"n{i}", place)
    for i in range(11):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e3, EIy=1.0))
    b.add(planar.truss, "n2", "n9", section=fm.Rigidity(EA=1e3))
    b.fix("n0")
    b.force("n11", (0.0, 1e-3))
    model = b.build()
    found, dense = fm.equilibrium(model, sparse=True), fm.equilibrium(model, sparse=False)
    # Corrections below 1e-9 of the extent end either.
    np.testing.assert_allclose(found.x, dense.x, rtol=0, atol=1e-9)
