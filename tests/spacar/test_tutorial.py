"""Every number that the tutorial prints for its mechanisms, by the Python interface (reference problems T1 to T5).

Tolerance "printed": half a unit of the last printed digit. Tolerance 1e-6: the closed forms beside the prints.
"""

import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm


@pytest.mark.parametrize("dof", ["x", "e"])
def test_truss_guide(dof):
    model = mechanisms.truss_guide(dof).build()
    lin = fm.linearize(model)
    np.testing.assert_allclose(lin.K0, [[945]], rtol=1e-12)
    np.testing.assert_allclose(lin.M0, [[0.206 + 2 * 0.007065 - 2 / 3 * 0.007065]], rtol=1e-12)


@pytest.mark.slow
def test_truss_guide_printed_numbers():
    b = fm.Builder()
    b.node("1", (0, 0))
    b.node("2", (0.1, 0))
    # T1: distributed mass of both leaf springs, 2 ml; a third of it counts at the end.
    section = fm.Rigidity(EA=94.5, mass=2 * 0.07065)
    b.add(fm.planar.truss, "1", "2", name="1", section=section, damping=fm.Damping(EA=0.00365))
    b.fix("1")
    b.fix("2", "y")
    b.mass("2", 0.206)
    b.dof("2", "x")
    b.input("2", "x")
    b.output("2", "x")
    lin = fm.linearize(b.build())
    assert lin.M0[0, 0] == approx(0.2107, abs=5e-5)
    assert lin.K0[0, 0] == approx(945, rel=1e-12)
    assert fm.frequencies(lin.model)[0] == approx(10.658436, rel=1e-6)
    ss = fm.to_statespace(lin)
    assert np.asarray(ss.A)[1, 0] == approx(-4484.84, abs=5e-3)
    # From the printed damping 0.00365: 3 digits.
    assert np.asarray(ss.A)[1, 1] == approx(-0.1732, abs=5e-5)
    assert np.asarray(ss.B)[1, 0] == approx(4.745859, abs=5e-7)
    np.testing.assert_allclose(ss.C, [[1, 0]], atol=1e-15)
    np.testing.assert_allclose(ss.D, [[0]], atol=1e-15)
    b.force("2", (1.0, 0.0))
    static = fm.equilibrium(b.build())
    assert static.at("2")[0] == approx(0.1 + 1 / 945, abs=1e-12)
    assert static.sigma[0] == approx(1.0, rel=1e-12)


def test_planar_guide_frequency_and_state_space():
    lin = fm.linearize(mechanisms.planar_guide(ratio=0.005).build())
    assert fm.frequencies(lin.model)[0] == approx(10.6448474, abs=5e-8)
    assert lin.K0[0, 0] == approx(945, rel=1e-12)
    ss = fm.to_statespace(lin)
    assert np.asarray(ss.A)[1, 0] == approx(-4473.409, abs=5e-4)
    # The tutorial enters EdI = 5.3e-6, two digits of 5.274e-6.
    assert np.asarray(ss.A)[1, 1] == approx(-0.602135 * 5.274e-6 / 5.3e-6, rel=1e-4)
    assert np.asarray(ss.B)[1, 0] == approx(4.733766, abs=5e-7)
    # Outputs x3 y3 x5 y5 phi4 phi6: rows 1 and 3 [1 0], the others zero in the straight state.
    expected = np.zeros((6, 2))
    expected[[0, 2], 0] = 1
    np.testing.assert_allclose(ss.C, expected, atol=1e-12)


def test_planar_guide_buckling_sign_and_mode():
    model = mechanisms.planar_guide(force=(0, -1.0)).build()
    found = fm.buckling(model)
    assert found.multipliers[0] == approx(78.75, abs=5e-5)
    assert fm.buckling_loads(mechanisms.planar_guide(force=(0, 1.0)).build())[0] == approx(-78.75, abs=5e-5)
    # The bar sways: both its ends by the same, nothing else moves.
    ends = [i for node in ("left1", "right1") for i in model.labels.coordinates(node)]
    np.testing.assert_allclose(np.asarray(found.shapes)[ends, 0], [1, 0, 1, 0], atol=1e-12)


@pytest.mark.slow
def test_planar_guide_without_the_elongation_term_buckles_too_late():
    model = mechanisms.planar_guide(force=(0, -1.0), second_order=False).build()
    assert fm.buckling_loads(model)[0] == approx(94.5, rel=1e-9)


@pytest.mark.slow
def test_planar_guide_with_three_degrees_of_freedom():
    inertia = -0.206 * 0.1**2 / 12
    lin = fm.linearize(mechanisms.planar_guide(elongation=True, inertia=inertia).build())
    ea, ei, length, b = 1.89e6, 0.039375, 0.1, 0.1
    axial, bending = ea / length, ei / length
    k = np.array(
        [
            [24 * bending / length**2, 0, 2 * 6 * bending / length],
            [0, 2 * axial, axial * b],
            [2 * 6 * bending / length, axial * b, axial * b**2 + 2 * 4 * bending],
        ]
    )
    np.testing.assert_allclose(lin.K0, k, rtol=1e-9, atol=1e-6)
    m = np.array([[0.2112483, 0, 7.401e-5], [0, 0.2112483, 0.0105624], [7.401e-5, 0.0105624, 0]])
    np.testing.assert_allclose(np.asarray(lin.M0)[:, :2], m[:, :2], atol=5e-8)
    found = fm.frequencies(lin.model)
    np.testing.assert_allclose(found[:2], [10.644716, 2128.9695], rtol=1e-6)
    # The third mode is ill-conditioned in J; with m = 0.206 the closed form gives 3586.424 (T4, trap 4).
    assert found[2] == approx(3586.424, rel=1e-6)
    printed = mechanisms.planar_guide(elongation=True, inertia=-0.0001716).build()
    assert fm.frequencies(printed)[2] == approx(3583.3, rel=1e-3)


@pytest.mark.slow
def test_spatial_guide():
    # One bending of the right leaf spring released in its stiff plane, as if cut partly (T5).
    model = mechanisms.spatial_guide(extra=(5,), ratio=0.005).build()
    assert fm.frequencies(model)[0] == approx(10.646359, rel=1e-6)
    ss = fm.to_statespace(model)
    assert np.asarray(ss.A)[1, 0] == approx(-4474.680, rel=1e-6)
    assert np.asarray(ss.A)[1, 1] == approx(-0.602306 * 5.274e-6 / 5.3e-6, rel=1e-4)
    assert np.asarray(ss.B)[1, 0] == approx(4.735111, abs=5e-7)
    expected = np.zeros((6, 2))
    expected[[1, 4], 0] = 1
    np.testing.assert_allclose(ss.C, expected, atol=1e-12)


def test_mobility_of_the_spatial_guide():
    # T5 and trap 3: two normal leaf springs give one self-stress and one motion, though the counts agree.
    both_normal = mechanisms.spatial_guide(dofs=False).build(check=False)
    found = fm.mobility(both_normal)
    assert (found.overconstraints, found.underconstraints) == (1, 1)
    assert both_normal.counts()["ndof"] == 0
    named = fm.mobility(mechanisms.spatial_guide().build(check=False))
    assert (named.overconstraints, named.underconstraints) == (1, 0)
    # Both leaf springs bend in their stiff plane (figure 4.5): e5 and e6 of both take part, their soft bending not.
    shares = {(s.of, s.symbol): abs(s.share) for s in named.stresses()}
    assert {("left 1", "e5"), ("left 1", "e6"), ("right 1", "e5"), ("right 1", "e6")} <= set(shares)
    assert not {("left 1", "e3"), ("right 1", "e4")} & set(shares)
    cut = fm.mobility(mechanisms.spatial_guide(extra=(5,)).build(check=False))
    assert (cut.overconstraints, cut.underconstraints) == (0, 0)
    assert mechanisms.spatial_guide(extra=(5,), dofs=False).build().counts()["ndof"] == 1


def test_degrees_of_freedom_counted_as_in_the_tutorial():
    # T5: -6 with rigid leaf springs, 0 with torsion and soft bending released, 1 with one stiff bending more.
    counts = [
        mechanisms.spatial_guide(released=r, extra=x, dofs=False).build(check=False).counts()["ndof"]
        for r, x in (((), ()), ((2, 3, 4), ()), ((2, 3, 4), (5,)))
    ]
    assert counts == [-6, 0, 1]


def test_release_on_request_removes_the_overconstraint():
    b = mechanisms.spatial_guide()
    with pytest.raises(fm.MechanismError, match=r"over-constrained(.|\n)*release deformation [56] of element"):
        b.build()
    model = b.build(release="auto")
    assert model.counts()["ndof"] == 1
    assert fm.frequencies(model)[0] == approx(10.646359, rel=1e-6)


@pytest.mark.slow
def test_refined_guide_approaches_the_continuum():
    # 10.644743 Hz: continuum with inextensible leaf springs, no rotary inertia, bar in translation (T, independent).
    found = [float(fm.frequencies(mechanisms.planar_guide(beams=n, dofs=False).build())[0]) for n in (1, 2, 4)]
    errors = np.abs(np.array(found) / 10.644743 - 1)
    # Half a unit of the last digit is 5e-8; one beam is 1e-5 too high.
    assert errors[0] == approx(1e-5, rel=0.1)
    assert errors[1] < 1e-6
    assert errors[2] < 1e-7


@pytest.mark.slow
def test_compliance_of_the_planar_guide():
    model = mechanisms.planar_guide().build()
    matrix = fm.compliance(model, "left1")
    np.testing.assert_allclose(matrix, [[1 / 945, 0, 0], [0, 0, 0], [0, 0, 0]], atol=1e-12)
    assert jnp.all(jnp.isfinite(matrix))


@pytest.mark.slow
def test_the_lowest_frequencies_alone():
    """As among all of them, of some forty degrees of freedom."""
    model = mechanisms.spatial_guide(beams=4, released=(1, 2, 3, 4, 5, 6), dofs=False).build()
    found = fm.frequencies(model)
    assert len(found) > 30
    np.testing.assert_allclose(fm.frequencies(model, count=3), found[:3], rtol=1e-9)
    with pytest.raises(ValueError, match="count"):
        fm.frequencies(model, count=0)
