"""Large deflection of SPACAR-type beams: order two, few iterations, derivatives by positions (A1, A4)."""

import jax
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.statics.newton_search import LoadStep


def cantilever(beams, force=(0.0, 0.0), moment=0.0, foot=0.0, tip=1.0, dofs=()):
    """EI = L = 1 along x, stretching a billion times stiffer than bending."""
    section = fm.Rigidity(EA=1e9, EIy=1.0, mass=1.0)
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (foot + (tip - foot) * i / beams, 0))
    for i in range(beams):
        b.add(planar.beam, str(i), str(i + 1), name=f"beam {i}", section=section)
    b.fix("0")
    b.force(str(beams), force)
    b.moment(str(beams), moment)
    for i in dofs:
        b.dof(f"beam {i}", 1, 2, 3)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load", "deflection", "shortening", "most"),
    [(1.0, 0.3017207738, 0.0564332363, 60), (5.0, 0.7137915236, 0.3876283607, 160)],
)
def test_elastica(load, deflection, shortening, most):
    # A1, closed form; the axial strain is below 1e-8. Order two: the error falls four times a halving.
    found = [fm.equilibrium(cantilever(n, force=(0.0, load))) for n in (4, 8, 16)]
    tips = np.array([np.asarray(f.at(str(n))) for f, n in zip(found, (4, 8, 16), strict=True)])
    for errors in (np.abs(tips[:, 1] / deflection - 1), np.abs((1 - tips[:, 0]) / shortening - 1)):
        np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.15)
    assert np.all(np.abs(tips[-1] / [1 - shortening, deflection] - 1) < 5e-3)
    # Newton converges in a few iterations a load step; it needed up to 280 where DOF stress came from D(x).
    assert sum(int(f.iterations) for f in found) <= most


def test_turns_on_the_way_end_where_little_is_left():
    """A correction a tenth of the one before leaves a hundredth of itself: Newton's method is of order two."""

    def ends(size, load, before=0.5, tries=1):
        of = (load - 0.1, 0.1, 0.5, before)
        return bool(LoadStep(*map(np.float64, of), np.int32(tries)).near_enough(np.float64(size)))

    assert ends(0.05, 0.3)
    assert not ends(0.15, 0.3)
    # The first correction tells nothing; at the whole load nothing is to be left.
    assert not ends(0.05, 0.3, before=np.inf, tries=0)
    assert not ends(0.05, 1.0)
    assert ends(1e-10, 1.0)


@pytest.mark.slow
def test_roll_up_converges_with_order_two_and_is_refused_where_it_cannot_be():
    # A4: M = 2 pi EI/L closes the circle; 8 SPACAR beams cannot carry that moment.
    gaps = [float(np.hypot(*fm.equilibrium(cantilever(n, moment=2 * np.pi)).at(str(n)))) for n in (16, 32)]
    assert gaps[0] / gaps[1] == approx(4, rel=0.15)
    assert gaps[1] < 1.5e-2
    with pytest.raises(fm.AnalysisError, match="equilibrium was not found"):
        fm.equilibrium(cantilever(8, moment=2 * np.pi))


@pytest.mark.slow
def test_derivative_by_positions_under_load():
    def tip(foot, end):
        model = cantilever(2, force=(0.2, 1.0), foot=foot, tip=end, dofs=(0, 1))
        return fm.equilibrium(model).at("2")

    value, step = fm.jit(tip), 1e-5
    for k, differentiate in ((0, jax.jacfwd), (1, jax.jacfwd), (0, jax.jacrev)):
        found = fm.jit(differentiate(tip, argnums=k))(0.0, 1.0)
        moved = [0.0, 1.0], [0.0, 1.0]
        moved[0][k] += step
        moved[1][k] -= step
        difference = (np.asarray(value(*moved[0])) - np.asarray(value(*moved[1]))) / (2 * step)
        # Truncation 1e-10; round-off of x, 1e-16 times the ratio 1e9 of the stiffnesses, over the step: 1e-6 at most.
        np.testing.assert_allclose(found, difference, rtol=2e-6, atol=2e-6)


@pytest.mark.slow
def test_zero_and_small_loads_converge():
    guide = [mechanisms.planar_guide(force=(f, 0.0)).build() for f in (0.0, 1e-3, 9.5)]
    moved = [float(fm.equilibrium(g).at("left1")[0]) for g in guide]
    assert moved[0] == 0.0
    # Small loads: force over 945 N/m.
    assert moved[1] == approx(1e-3 / 945, rel=1e-6)
    assert 0.009 < moved[2] < 0.0101


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "count", "squared"), [(planar.beam, 16, 1.01**2), (planar.spectral_beam, 1, 1.0)])
def test_a_stretched_strip_bends_as_theory_says(kind, count, squared):
    """THEORY.md 2: cubic beams project onto the stretched axis, so that EI counts by (1 + strain)^2."""
    stretched, across = 0.01, 0.01
    b = fm.Builder()
    for i in range(count + 1):
        b.node(f"n{i}", (i / count, 0.0))
    for i in range(count):
        b.add(kind, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e3, EIy=1.0, mass=1.0))
    b.fix("n0")
    b.force(f"n{count}", (1e3 * stretched, across))
    found = fm.equilibrium(b.build(check=False), sparse=True).position(f"n{count}")[1]
    k = np.sqrt(1e3 * stretched * (1 + stretched) / squared)
    wanted = across / (1e3 * stretched) * (1 + stretched) * (1 - np.tanh(k) / k)
    # The strain itself is taken to be the same along the strip; the two formulas differ by 4e-3.
    assert found == approx(wanted, rel=1e-4)
