"""Where statics has no answer, or a tempting wrong one: a right answer or a named result."""

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar


def truss(load, base=10.0, height=1.0):
    """A7: two bars of EA = 1e4, feet held, apex free to move up and down."""
    b = fm.Builder()
    section = fm.Rigidity(EA=1e4, mass=1.0)
    b.node("left", (-base, 0))
    b.node("right", (base, 0))
    b.node("apex", (0, height))
    b.add(planar.truss, "left", "apex", name="1", section=section)
    b.add(planar.truss, "right", "apex", name="2", section=section)
    b.fix("left")
    b.fix("right")
    b.fix("apex", "x")
    b.force("apex", (0, -load))
    return b.build()


LIMIT = 3.8108719042


@pytest.mark.parametrize("share", [1.0001, 1.01, 1.5, 4.0, 100.0])
def test_beyond_a_limit_load_there_is_a_refusal_and_no_jump(share):
    # The snapped side carries any of these loads: an iteration that leaves the path would find it.
    with pytest.raises(fm.AnalysisError, match="limit load"):
        fm.equilibrium(truss(share * LIMIT))


@pytest.mark.parametrize("share", [0.0, 1e-6, 0.5, 0.99, 0.9999])
def test_below_it_the_branch_is_the_one_that_starts_unloaded(share):
    drop = 1 - float(fm.equilibrium(truss(share * LIMIT)).at("apex")[1])
    # Closed form of the bars' engineering strain, A7.
    bar = np.hypot(10, 1 - drop)
    assert 2e4 * (1 / bar - 1 / np.hypot(10, 1)) * (1 - drop) == pytest.approx(share * LIMIT, rel=1e-8, abs=1e-9)
    assert drop < 0.4236074652


def column(load, aside=0.0, **options):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.spectral_beam(6), "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0))
    b.fix("foot")
    b.force("tip", (-load, aside), **options)
    return b.build()


def test_a_straight_column_beyond_its_buckling_load_is_called_unstable():
    model = column(3.0)
    assert fm.equilibrium(model).at("tip")[1] == pytest.approx(0, abs=1e-12)
    assert fm.frequencies(model)[0] < 0
    # All loads scale: the multiplier counts from none.
    assert fm.buckling_loads(model)[0] == pytest.approx(2.4674011003 / 3, rel=1e-5)


def test_a_force_that_follows_its_column_has_no_static_buckling_load():
    # Beck's column flutters: statics finds no load, from the straight state or below any load.
    model = column(1.0, follower=True)
    found = np.asarray(fm.buckling_loads(model))
    assert not np.any(np.isfinite(found) & (np.abs(found) < 100))
    assert np.all(np.abs(np.real(fm.poles(model))) < 1e-6)
    # Flutter at 20.05 EI/L^2 (closed form, Beck 1952): pairs of poles leave the axis.
    assert np.max(np.real(fm.poles(column(19.9, follower=True)))) < 1e-3
    assert np.max(np.real(fm.poles(column(20.2, follower=True)))) > 0.1


def test_a_load_on_a_support_moves_nothing():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.spectral_beam(3), "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e3, EIy=1.0))
    b.fix("foot")
    b.force("foot", (5.0, -7.0))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.e, 0, atol=1e-12)
    np.testing.assert_allclose(found.reactions[:2], [-5.0, 7.0], rtol=1e-12)


@pytest.mark.parametrize("load", [1e3, 1e5])
def test_a_huge_first_step_ends_on_the_branch(load):
    # The tip hangs ever more along the force; elongation P/EA.
    found = fm.equilibrium(column(0.0, aside=load), throw=False)
    if int(found.result) == fm.RESULTS.successful:
        x, y = np.asarray(found.at("tip"))
        assert 0 < x < 0.1
        assert 0.9 < y - load / 1e6 < 1.0
    else:
        assert fm.RESULTS(int(found.result)) is fm.RESULTS.not_converged


def test_a_foil_of_one_ten_thousandth_of_its_length():
    # A1 at P L^2/EI = 1: EA L^2/EI = 12e8.
    material = fm.Material(E=210e9, G=80e9)
    foil = fm.Rectangle(0.01, 1e-5, material)
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.1, 0))
    b.add(planar.spectral_beam(6), "foot", "tip", name="foil", section=foil)
    b.fix("foot")
    b.force("tip", (0, float(foil.rigidity().EIy) / 0.01))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("tip"), [0.1 * (1 - 0.0564332363), 0.1 * 0.3017207738], rtol=2e-8)
