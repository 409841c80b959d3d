"""Sections: closed forms, the tutorial's numbers, limits, and derivatives against central differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.special
from cases.tolerances import approx
from hypothesis import given
from hypothesis import strategies as st
from jax.flatten_util import ravel_pytree

import flexmb as fm
from flexmb.elements.surface import von_mises

EPS = np.finfo(float).eps
STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
WIDTH, THICKNESS, LENGTH = 0.018, 0.0005, 0.1
POSITIVE = st.floats(0.1, 10).map(lambda x: round(x, 3))


def torsion_of_rectangle(w, t, terms=400):
    """Saint-Venant's series summed term by term, Timoshenko and Goodier's form, on the longer side."""
    w, t = max(w, t), min(w, t)
    n = np.arange(1, 2 * terms, 2)
    return w * t**3 * (1 / 3 - 64 / np.pi**5 * (t / w) * np.sum(np.tanh(n * np.pi * w / (2 * t)) / n**5))


# -- T7, and the sections of REFERENCES.md S1 ------------------------------------------------------------------------


def test_torsion_constants_of_the_leaf_spring():
    # T7, printed to 7 and 6 digits.
    assert fm.sections.torsion_series(WIDTH, THICKNESS) == approx(7.368698e-13, abs=5e-20)
    assert fm.sections.torsion_approximate(WIDTH, THICKNESS) == approx(7.36875e-13, abs=5e-19)


@pytest.mark.parametrize(("ratio", "one_end"), [(2, 1.138936), (1, 1.322473), (0.5, 1.894016), (0.3, 3.176028)])
def test_warping_factor_table(ratio, one_end):
    # T7, nu = 0.3, printed to 7 digits.
    assert fm.sections.warping_factor(ratio, 1.0, 0.3, 1) == approx(one_end, abs=5e-7)


@pytest.mark.parametrize(("ends", "stiffness"), [(0, 0.589500), (1, 0.616577), (2, 0.646262)])
def test_twist_stiffness_of_one_leaf(ends, stiffness):
    # T7: GIt = 0.05895, l = 0.1, nu = 0.3; printed to 6 digits.
    factor = fm.sections.warping_factor(LENGTH, WIDTH, 0.3, ends)
    assert 0.05895 / LENGTH * factor == approx(stiffness, abs=5e-7)


def test_warping_factor_with_the_modulus_of_a_beam():
    # Spring of the predecessor's cross flexure: E = 210e9, G = 70e9, so that nu = 0.5 and 24/(1 + nu) = 16.
    factor = fm.sections.warping_factor(0.05 * 2 * np.sqrt(2), 0.05, 0.5, modulus="beam")
    al = 8 * np.sqrt(2)
    assert factor == approx(al / (al - 2 * np.tanh(al / 2)), rel=10 * EPS)
    assert factor == approx(1.21473, abs=5e-6)
    with pytest.raises(ValueError, match="modulus must be 'plate' or 'beam', but is 'shell'"):
        fm.sections.warping_factor(0.1, 0.05, 0.3, modulus="shell")  # pyright: ignore


def test_warping_factor_refuses_another_number_of_ends():
    with pytest.raises(ValueError, match="clamped_ends must be 0, 1 or 2"):
        fm.sections.warping_factor(LENGTH, WIDTH, 0.3, 3)


def test_two_clamped_ends_are_two_halves_with_one():
    # By symmetry the middle of a leaf clamped at both ends warps freely: its halves have one clamped end each.
    assert fm.sections.warping_factor(LENGTH, WIDTH, 0.3, 2) == approx(
        float(fm.sections.warping_factor(LENGTH / 2, WIDTH, 0.3, 1)), rel=10 * EPS
    )


def test_leaf_spring_oracles():
    # REFERENCES.md S1, to half a unit of the last digit written there.
    s = fm.Rectangle(WIDTH, THICKNESS, STEEL, shear=True).rigidity()
    assert s.EA == approx(1.89e6, rel=1e-12)
    assert s.EIy == approx(0.039375, rel=1e-12)
    assert s.EIz == approx(51.03, rel=1e-12)
    assert s.GIt == approx(0.0589496, abs=5e-8)
    assert STEEL.poisson() == approx(0.3125, rel=1e-12)
    assert s.EIy / s.shear_z / (80e9 * WIDTH * THICKNESS) == approx(0.85020, abs=5e-6)
    assert 12 * s.shear_z / LENGTH**2 == approx(7.719e-5, abs=5e-9)
    assert 12 * s.shear_y / LENGTH**2 == approx(0.1000, abs=5e-5)
    assert s.mass == approx(0.07065, rel=1e-12)


def test_cross_flexure_spring_oracles():
    material = fm.Material(E=210e9, G=70e9)
    assert material.poisson() == approx(0.5, rel=1e-12)
    section = fm.Rectangle(0.05, 0.0002, material)
    assert section.rigidity().GIt / 70e9 == approx(1.329972e-13, abs=5e-20)


@pytest.mark.parametrize(
    ("name", "power", "printed", "digit"),
    [("EA", 1, 0.3654, 1e-4), ("GIt", 3, 6.5e-6, 1e-7), ("EIz", 3, 1.9e-4, 1e-5), ("EIy", 3, 5.3e-6, 1e-7)],
)
def test_damping_of_the_leaf_spring(name, power, printed, digit):
    section = fm.Rectangle(WIDTH, THICKNESS, STEEL)
    found = getattr(fm.sections.damping_from_ratio(section, LENGTH, 0.005), name)
    # T2 and T5, printed to this digit.
    assert found == approx(printed, abs=digit / 2)
    stiffness = getattr(section.rigidity(), name) / LENGTH**power
    assert found / LENGTH**power == approx(0.01 * np.sqrt(stiffness * 0.007065), rel=1e-12)


def test_damping_of_what_a_section_lacks_is_zero_with_a_finite_derivative():
    def axial(mass):
        return fm.sections.damping_from_ratio(fm.Rigidity(EIy=2.0, mass=mass), 1.5, 0.01).EA

    assert axial(1.0) == 0
    assert jax.grad(axial)(1.0) == 0
    # No mass, no damping: the root of zero has no derivative, the answer has one.
    assert np.isfinite(
        jax.grad(lambda m: fm.sections.damping_from_ratio(fm.Rigidity(EIy=2.0, mass=m), 1.5, 0.01).EIy)(0.0)
    )


def test_given_poisson_ratio_is_taken():
    assert fm.Material(E=210e9, G=80e9, nu=0.3).poisson() == 0.3


# -- torsion of a rectangle -----------------------------------------------------------------------------------------


@pytest.mark.slow
@given(POSITIVE, POSITIVE)
def test_torsion_series_is_the_sum_of_its_terms(w, t):
    # The docstring's 1e-9; either side may be the longer.
    assert fm.sections.torsion_series(w, t) == approx(torsion_of_rectangle(w, t), rel=1e-9)


def test_torsion_of_a_square():
    # Timoshenko and Goodier give 0.1406 a^4; A5 uses 0.140577 for the unit square, 0.1405770 is the sum to 7 digits.
    assert fm.sections.torsion_series(1.0, 1.0) == approx(0.1405770, abs=5e-8)


def test_derivative_of_the_torsion_of_a_square():
    # Homogeneous of degree 4 and symmetric in the sides: 2 It/a by each, though the sides change places there.
    found = jax.grad(fm.sections.torsion_series, (0, 1))(1.0, 1.0)
    # The terms left out are 1e-9 of the value at w = t and change faster than it: 1e-7 of the derivative.
    np.testing.assert_allclose(found, 2 * 0.14057701, rtol=1e-6)


def test_torsion_of_a_thin_strip():
    # w t^3/3 (1 - 0.63 t/w): every tanh is 1, and the odd powers sum to 31/32 zeta(5).
    slope = 192 / np.pi**5 * 31 / 32 * scipy.special.zeta(5)
    for t in (1e-2, 1e-4):
        assert fm.sections.torsion_series(1.0, t) / (t**3 / 3) == approx(1 - slope * t, rel=10 * EPS)


# -- closed forms ---------------------------------------------------------------------------------------------------


def polygon_moments(outer, inner):
    """Area and second moments of a rectangle with a rectangular hole, (width, thickness) each, by sampling squares."""
    (w, t), (wi, ti) = outer, inner
    # Integrals of 1, z^2 and y^2 over a rectangle, by Gauss quadrature that is exact for them.
    points, weights = np.polynomial.legendre.leggauss(3)

    def over(w, t):
        y, z = points * w / 2, points * t / 2
        area = np.outer(weights, weights) * w * t / 4
        return np.array([area.sum(), (area * z[None, :] ** 2).sum(), (area * y[:, None] ** 2).sum()])

    return over(w, t) - over(wi, ti)


@pytest.mark.slow
@given(POSITIVE, POSITIVE, POSITIVE, POSITIVE, st.booleans())
def test_rectangle(w, t, e, rho, rotary):
    s = fm.Rectangle(w, t, fm.Material(E=e, G=0.4 * e, rho=rho), rotary=rotary).rigidity()
    area, iy, iz = polygon_moments((w, t), (0, 0))
    np.testing.assert_allclose([s.EA, s.EIy, s.EIz, s.mass], [e * area, e * iy, e * iz, rho * area], rtol=1e-13)
    np.testing.assert_allclose(
        [s.Jx, s.Jy, s.Jz], [rho * (iy + iz), rho * iy, rho * iz] if rotary else [0, 0, 0], rtol=1e-13
    )
    assert s.shear_z == s.shear_y == 0
    assert s.GIt == approx(0.4 * e * torsion_of_rectangle(w, t), rel=1e-9)


@given(POSITIVE, POSITIVE, POSITIVE, POSITIVE)
def test_circle_and_tube(d, share, e, rho):
    material = fm.Material(E=e, G=0.4 * e, rho=rho)
    wall = d / 2 * share / 10
    radii = np.array([d / 2, d / 2 - wall])
    # Integrals of 1 and of r^2 over the ring: 2 pi r dr.
    ring, polar = np.pi * -np.diff(radii**2)[0], np.pi / 2 * -np.diff(radii**4)[0]
    s = fm.Tube(d, wall, material).rigidity()
    # A thin ring is a difference of the whole circle's: eps over its share.
    rtol = 1e-12 / (share / 10)
    np.testing.assert_allclose([s.EA, s.EIy, s.EIz], [e * ring, e * polar / 2, e * polar / 2], rtol=rtol)
    np.testing.assert_allclose([s.GIt, s.mass, s.Jx], [0.4 * e * polar, rho * ring, rho * polar], rtol=rtol)
    c = fm.Circle(d, material, shear=True).rigidity()
    whole = fm.Tube(d, d / 2, material).rigidity()
    for name in ("EA", "EIy", "EIz", "GIt", "mass", "Jx", "Jy", "Jz"):
        assert getattr(c, name) == approx(float(getattr(whole, name)), rel=1e-13)
    # Cowper 1966: k = 6 (1 + nu)/(7 + 6 nu), nu = 1/0.8 - 1.
    assert c.EIy / c.shear_z == approx(0.4 * e * np.pi * d**2 / 4 * 6 * 1.25 / 8.5, rel=1e-12)


@given(POSITIVE, POSITIVE, st.floats(0.01, 0.4), st.floats(0.01, 0.4))
def test_hollow_rectangle_bends_as_the_difference_of_two(w, t, share_y, share_z):
    wall_y, wall_z = share_y * w, share_z * t
    s = fm.HollowRectangle(w, t, wall_y, wall_z, fm.Material(E=2.0, G=0.8, rho=3.0)).rigidity()
    area, iy, iz = polygon_moments((w, t), (w - 2 * wall_y, t - 2 * wall_z))
    # A difference of the whole rectangle's, of which a wall of 1 % leaves 4 %.
    np.testing.assert_allclose([s.EA, s.EIy, s.EIz, s.mass], [2 * area, 2 * iy, 2 * iz, 3 * area], rtol=1e-12)
    np.testing.assert_allclose([s.Jx, s.Jy, s.Jz], [3 * (iy + iz), 3 * iy, 3 * iz], rtol=1e-12)


@pytest.mark.parametrize("power", [1, 2, 3])
def test_thin_walls_of_a_hollow_rectangle(power):
    """Thin walls a = 1e-power: It to 2 a w^2 t^2/(w + t), A to 2 a (w + t), Iy to a (t^3/6 + w t^2/2)."""
    w, t, a = 3.0, 2.0, 10.0**-power
    s = fm.HollowRectangle(w, t, a, a, fm.Material(E=1.0, G=1.0)).rigidity()
    found = np.array([s.GIt, s.EA, s.EIy, s.EIz]) / a
    thin = [2 * w**2 * t**2 / (w + t), 2 * (w + t), t**3 / 6 + w * t**2 / 2, w**3 / 6 + t * w**2 / 2]
    # First order in the wall over the shorter side; the coefficient is below 4.
    np.testing.assert_allclose(found, thin, rtol=4 * a / t)


def test_unequal_walls_of_a_hollow_rectangle_by_bredt():
    # Walls at the ends of the width are as long as the thickness: 4 A^2/(2 w/wall_z + 2 t/wall_y).
    s = fm.HollowRectangle(3.0, 2.0, 2e-6, 1e-6, fm.Material(E=1.0, G=1.0)).rigidity()
    assert s.GIt == approx(4 * 36 / (6 / 1e-6 + 4 / 2e-6), rel=1e-5)


def test_warping_and_approximate_torsion_enter_the_rigidity():
    plain = fm.Rectangle(WIDTH, THICKNESS, STEEL, torsion="approximate").rigidity().GIt
    assert plain == approx(0.05895, abs=5e-9)
    for ends in (0, 1, 2):
        section = fm.Rectangle(WIDTH, THICKNESS, STEEL, torsion="approximate", warping_length=LENGTH, clamped_ends=ends)
        factor = fm.sections.warping_factor(LENGTH, WIDTH, 0.3125, ends)
        assert section.rigidity().GIt == approx(float(plain * factor), rel=1e-13)


# -- stress on the surface ------------------------------------------------------------------------------------------


def unit(i, size=1.0):
    return size * jnp.eye(6)[i]


@pytest.mark.slow
@given(POSITIVE, POSITIVE)
def test_torsion_stress_of_a_rectangle(w, t):
    """Saint-Venant's series in the other direction: hyperbolic functions along the sides where ours has cosines.

    With the sides taken for each other the sum on the longer side becomes the slow alternating one and the other way
    round: both are the same stress function, expanded differently, and neither shares a term with the other.
    """
    _, tau = fm.Rectangle(w, t, STEEL).stress(unit(3))
    constant = torsion_of_rectangle(w, t)
    n = np.arange(1, 200001, 2)
    half = np.pi / 2 * min(w, t) / max(w, t)
    longest, shortest = max(w, t), min(w, t)
    alternating = np.sum((-1.0) ** (n // 2) * np.tanh(np.minimum(n * half, 50)) / n**2)
    on_long_side = longest / constant * 8 / np.pi**2 * alternating
    on_short_side = longest / constant * (1 - 8 / np.pi**2 * np.sum(1 / (n**2 * np.cosh(np.minimum(n * half, 300)))))
    at_y, at_z = (on_short_side, on_long_side) if w >= t else (on_long_side, on_short_side)
    # The alternating sum stops at 1/n^2 = 2.5e-11, against a stress that is the difference of both near a thin strip.
    tolerance = 1e-9 * longest / shortest
    np.testing.assert_allclose(tau, [0, at_z, 0, at_y] * 2, rtol=tolerance, atol=1e-12 * on_long_side)


@pytest.mark.slow
def test_torsion_stress_of_thin_strip_and_square():
    # Thin strip: T t/It with It = w t^3/3; square: both sides alike, Saint-Venant's 4.8 T/a^3.
    _, tau = fm.Rectangle(1.0, 1e-4, STEEL).stress(unit(3))
    assert tau[1] * 1e-8 / 3 == approx(1, rel=1e-4)
    _, tau = fm.Rectangle(1.0, 1.0, STEEL).stress(unit(3))
    np.testing.assert_allclose(tau[1::2], 4.8, atol=0.01)
    # The largest value is at the middle of the longer side, whichever that is.
    tall = fm.Rectangle(0.5, 1.0, STEEL).stress(unit(3))[1]
    assert int(jnp.argmax(jnp.abs(tall))) in (3, 7)


def test_derivative_of_the_torsion_stress_of_a_square():
    """The sides change places there, but the stress is one analytic function of both."""

    @fm.jit
    def middles(w):
        return fm.Rectangle(w, 1.0, STEEL).stress(unit(3))[1][1:4:2]

    step = 1e-4
    difference = (middles(1 + step) - middles(1 - step)) / (2 * step)
    # Truncation step^2 and torsion_series: 1e-9 of the value, 1e-7 of the derivative, over the step there.
    np.testing.assert_allclose(fm.jit(jax.jacfwd(middles))(1.0), difference, rtol=1e-5)


@given(POSITIVE, POSITIVE)
def test_rectangle_stress_balances_its_resultants(w, t):
    """Linear stress and parabolas through the points given, integrated over the section."""
    section = fm.Rectangle(w, t, STEEL)
    points, weights = np.polynomial.legendre.leggauss(3)
    y, z = np.meshgrid(points * w / 2, points * t / 2, indexing="ij")
    area = np.outer(weights, weights) * w * t / 4
    for resultants in (np.array([1.2, 0, 0, 0, 0.7, -0.4]), np.array([0.3, 0.8, -0.5, 0, 0.2, 0.1])):
        sigma, tau = (np.asarray(a) for a in section.stress(jnp.asarray(resultants)))
        # A plane through the corners.
        middle = np.mean(sigma[::2])
        by_y = (sigma[0] - sigma[2]) / w
        by_z = (sigma[2] - sigma[4]) / t
        spread = middle + by_y * y + by_z * z
        found = [np.sum(area * spread), np.sum(area * spread * z), -np.sum(area * spread * y)]
        np.testing.assert_allclose(found, resultants[[0, 4, 5]], rtol=1e-12, atol=1e-12)
        along_y, along_z = (tau[5] - tau[1]) / 2, (tau[7] - tau[3]) / 2
        forces = [np.sum(area * along_y * (1 - (2 * y / w) ** 2)), np.sum(area * along_z * (1 - (2 * z / t) ** 2))]
        np.testing.assert_allclose(forces, resultants[[1, 2]], rtol=1e-12, atol=1e-12)


@given(POSITIVE, POSITIVE, POSITIVE, POSITIVE)
def test_round_sections(my, mz, vy, vz):
    d, wall = 0.8, 0.1
    for section, inner in ((fm.Circle(d, STEEL), 0.0), (fm.Tube(d, wall, STEEL), d - 2 * wall)):
        i, area = np.pi * (d**4 - inner**4) / 64, np.pi * (d**2 - inner**2) / 4
        sigma, tau = section.stress(jnp.array([3.0, vy, vz, 2.0, my, mz]))
        bending = np.hypot(my, mz) * d / 2 / i
        # The extremes of bending in any direction, on both sides; a quarter turn from them the middle.
        np.testing.assert_allclose(np.sort(sigma)[[0, -1]], 3 / area + bending * np.array([-1, 1]), rtol=1e-12)
        np.testing.assert_allclose(np.asarray(sigma)[1:4:2], 3 / area, atol=1e-12 * bending)
        # V Q/(I b), at its largest in the middle, and torsion T r/It.
        r = np.array([d / 2, inner / 2])
        first_moment, width = 2 / 3 * -np.diff(r**3)[0], 2 * -np.diff(r)[0]
        shear = np.hypot(vy, vz) * first_moment / (i * width)
        twist = 2.0 * d / 2 / (2 * i)
        np.testing.assert_allclose([np.max(tau), np.min(tau)], twist + shear * np.array([1, -1]), rtol=1e-12)
        # The force of a thin tube, and that of the solid one by its parabola 1 - (z/R)^2, is the resultant.
    thin = fm.Tube(1.0, 1e-6, STEEL).stress(jnp.array([0, 0, 1.0, 0, 0, 0]))[1]
    assert np.max(thin) * np.pi * 0.5 * 1e-6 == approx(1, rel=1e-5)


def test_round_section_is_the_same_in_every_direction():
    section = fm.Circle(0.01, STEEL)
    angles = np.linspace(0, 2 * np.pi, 7)
    largest = []
    for a in angles:
        turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        sigma, tau = section.stress(jnp.r_[5.0, turn @ [0.2, 0.1], 0.3, turn @ [0.04, 0.7]])
        largest.append(np.max(np.sqrt(sigma**2 + 3 * tau**2)))
    np.testing.assert_allclose(largest, largest[0], rtol=1e-12)


@pytest.mark.parametrize("i", range(6))
def test_round_section_without_a_direction_has_derivatives(i):
    """No bending, or bending that is round-off: derivatives stay of the size of the stress they are of."""
    slopes = fm.jit(lambda section, at: jax.jacfwd(section.stress)(at))
    section = fm.Circle(0.01, STEEL)
    for noise in (0.0, 1e-17):
        at = np.eye(6)[i] + noise * np.array([0, 0.3, 0.7, 0, 0.5, 0.2])
        jacobian = np.concatenate(slopes(section, at))
        # 32/(pi d^3) is the largest section factor, 1e7.
        assert np.max(np.abs(jacobian)) < 1.1e7
    assert np.all(np.isfinite(np.concatenate(slopes(section, np.zeros(6)))))


@pytest.mark.parametrize("name", ["rectangle", "hollow rectangle", "circle", "tube"])
def test_equivalent_stress_of_nothing_has_a_derivative(name):
    @fm.jit
    @jax.value_and_grad
    def total(resultants):
        return jnp.sum(von_mises(*SECTIONS[name].stress(resultants)))

    value, slope = total(np.zeros(6))
    assert value == 0
    assert not np.any(slope)
    # A twisted rectangle has no stress at its corners.
    assert np.all(np.isfinite(total(np.eye(6)[3])[1]))


def flow(w, t, wall_y, wall_z, vz):
    """Shear flow of Vz in thin walls, by summing V z dA/I from the middle of the upper wall, at corner and web."""
    n = 20000
    inertia = 2 * wall_z * w * (t / 2) ** 2 + 2 * wall_y * t**3 / 12
    corner = vz / inertia * wall_z * (t / 2) * w / 2
    z = (np.arange(n) + 0.5) / n * t / 2
    return corner, corner + vz / inertia * wall_y * np.sum(z) * t / 2 / n


@pytest.mark.parametrize("walls", [(1e-6, 1e-6), (1e-6, 3e-6), (3e-6, 1e-6)])
def test_shear_of_a_thin_box(walls):
    w, t = 3.0, 2.0
    section = fm.HollowRectangle(w, t, *walls, STEEL)
    corner, web = flow(w, t, *walls, 1.0)
    _, tau = section.stress(unit(2))
    thinner = min(walls)
    # Up in both webs: counter-clockwise at +y, clockwise at -y. Walls of 1e-6 of the sides.
    expected = [
        corner / thinner,
        0,
        -corner / thinner,
        -web / walls[0],
        -corner / thinner,
        0,
        corner / thinner,
        web / walls[0],
    ]
    np.testing.assert_allclose(tau, expected, rtol=1e-5, atol=1e-3)
    corner, web = flow(t, w, walls[1], walls[0], 1.0)
    _, tau = section.stress(unit(1))
    expected = [
        -corner / thinner,
        -web / walls[1],
        -corner / thinner,
        0,
        corner / thinner,
        web / walls[1],
        corner / thinner,
        0,
    ]
    np.testing.assert_allclose(tau, expected, rtol=1e-5, atol=1e-3)
    # Bredt: T/(2 A t).
    _, tau = section.stress(unit(3))
    wall = np.array([thinner, walls[1], thinner, walls[0]] * 2)
    np.testing.assert_allclose(tau, 1 / (2 * w * t * wall), rtol=1e-5)


@pytest.mark.slow
def test_box_without_a_hole_is_a_rectangle():
    # Walls that meet in the middle of the width: N, bending and the parabola of Vz in the middle of the web.
    box = fm.HollowRectangle(1.2, 0.7, 0.6, 0.35, STEEL)
    solid = fm.Rectangle(1.2, 0.7, STEEL)
    for i in (0, 4, 5):
        np.testing.assert_allclose(box.stress(unit(i))[0], solid.stress(unit(i))[0], rtol=1e-12, atol=1e-12)
    for i, points in ((1, (1, 5)), (2, (3, 7))):
        found, expected = box.stress(unit(i))[1], solid.stress(unit(i))[1]
        np.testing.assert_allclose(found[np.array(points)], expected[np.array(points)], rtol=1e-12)


# -- derivatives ----------------------------------------------------------------------------------------------------

MATERIAL = fm.Material(E=2.1, G=0.8, rho=1.3)
SECTIONS = {
    "rectangle": fm.Rectangle(1.7, 0.4, MATERIAL, shear=True),
    "rectangle, high": fm.Rectangle(0.4, 1.7, MATERIAL, shear=True),
    "rectangle, approximate": fm.Rectangle(1.7, 0.4, MATERIAL, torsion="approximate"),
    "rectangle, one end": fm.Rectangle(1.7, 0.4, MATERIAL, warping_length=2.0, clamped_ends=1),
    "rectangle, two ends": fm.Rectangle(1.7, 0.4, MATERIAL, warping_length=2.0, clamped_ends=2),
    "hollow rectangle": fm.HollowRectangle(1.7, 0.9, 0.1, 0.2, MATERIAL),
    "circle": fm.Circle(0.9, MATERIAL, shear=True),
    "tube": fm.Tube(0.9, 0.1, MATERIAL),
}


@pytest.mark.slow
@pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS)
def test_derivatives_of_rigidity_and_damping(section):
    point, unravel = ravel_pytree(jax.tree.map(jnp.asarray, section))

    def numbers(point):
        own = unravel(point)
        stress = own.stress(jnp.array([0.3, 0.02, -0.03, 0.05, 0.04, -0.06]))
        return ravel_pytree((own.rigidity(), fm.sections.damping_from_ratio(own, 1.5, 0.01), stress))[0]

    batch = fm.jit(jax.vmap(numbers))
    jacobian = np.asarray(fm.jit(jax.jacfwd(numbers))(point))
    reverse = np.asarray(fm.jit(jax.jacrev(numbers))(point))
    step = EPS ** (1 / 3)
    eye = np.eye(point.size)
    difference = (np.asarray(batch(point + step * eye)) - np.asarray(batch(point - step * eye))).T / (2 * step)
    assert np.all(np.isfinite(jacobian))
    np.testing.assert_allclose(reverse, jacobian, rtol=1e-12, atol=1e-13)
    # Truncation step^2/6 times a third derivative of at most 100, round-off eps/step; numbers of order one.
    np.testing.assert_allclose(difference, jacobian, rtol=1e-8, atol=1e-8)
