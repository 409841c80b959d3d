"""Stress of leaf springs beside closed forms, a plate's equation and solid finite elements."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.strip_section import energy_of_section, stress_of_section
from cases.tolerances import approx
from scipy.integrate import solve_bvp

import flexmb as fm
from flexmb import planar, spatial
from flexmb.elements.leaf import Leaf
from flexmb.elements.leaf_stress import _across, leaf_stress

L, W, T, E, NU = 0.1, 0.018, 0.5e-3, 210e9, 0.3
STEEL = fm.Material(E=E, G=E / (2 * (1 + NU)), rho=7850.0)
# Points of the section: a corner, the middle of the wide side at +z, the edge at +y.
CORNER, MIDDLE, EDGE = 0, 1, 7


def strip(force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0), sizes=(W, T), length=L, material=STEEL, dofs=()):
    """A leaf spring with a clamped foot and a rigid tip."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (length, 0, 0))
    section = fm.Rectangle(*sizes, material)
    b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=section, y=(0, 1, 0), clamped=True)
    b.fix("foot")
    b.force("tip", force)
    b.moment("tip.rotation", moment)
    for of, number in (name.split(".e") for name in dofs):
        b.dof(of, int(number))
    return b.build()


def along(found, quantity: str, point: int, places) -> np.ndarray:
    """What a stress is at places along the leaf spring, linear between points."""
    values = np.asarray(getattr(found, quantity))[0, :, point]
    return np.interp(places, np.asarray(found.places), values)


@pytest.mark.slow
def test_restrained_warping_beside_its_closed_form():
    """Torque, neither end warps: E y z kappa' with kappa = T/GIt (1 - cosh((x - L/2)/l)/cosh(L/2l)), exact."""
    torque = 1e-5
    found = fm.stress(strip(moment=(torque, 0, 0)), points=21)
    torsion = STEEL.shear_modulus() * W * T**3 * (1 / 3 - 64 / np.pi**5 * T / W * 1.0045237627951384)
    layer = np.sqrt(E / (1 - NU**2) * (W * T) ** 3 / 144 / (1 + 12 * (T / W) ** 2) / torsion)
    away = (np.linspace(0, L, 21) - L / 2) / layer
    slope = -np.sinh(away) / layer / np.cosh(L / 2 / layer) * torque / torsion
    rate = (1 - np.cosh(away) / np.cosh(L / 2 / layer)) * torque / torsion
    # Wagner's effect is of second order in the torque.
    warped = -E * slope * W * T / 4
    sigma = np.asarray(found.sigma_x[0]).T
    scale = np.abs(warped).max()
    for point, sign in ((0, 1), (2, -1), (4, 1), (6, -1), (1, 0), (7, 0)):
        np.testing.assert_allclose(sigma[point], sign * warped, atol=1e-5 * scale)
    # Saint-Venant's shear in the middle; all of the torque is warping's where nothing twists.
    inner = STEEL.shear_modulus() * T * rate
    np.testing.assert_allclose(found.tau[0, :, MIDDLE], inner, atol=1e-8 * np.max(inner))
    assert float(found.tau[0, 0, EDGE]) == approx(9 * torque / (W**2 * T), rel=1e-9)


@pytest.mark.slow
def test_plate_at_a_clamp():
    """The section cannot curve or contract there: stress across is nu times that along, in plane and space alike."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (L, 0))
    b.add(planar.leaf_spring, "foot", "tip", name="leaf", section=fm.Rectangle(W, T, STEEL), clamped=True)
    b.fix("foot")
    b.force("tip", (2.0, 1e-3))
    flat = fm.stress(b.build(), points=11)
    found = fm.stress(strip((2.0, 0, 1e-3), (0, 0, 0)), points=11)
    for point in (1, 5):
        assert float(found.across[0, 0, point]) == approx(NU * float(found.sigma_x[0, 0, point]), rel=1e-6)
    assert np.all(np.asarray(found.across)[0, :, [0, 2, 3, 4, 6, 7]] == 0)
    for name in ("sigma_x", "tau", "across", "von_mises"):
        inner, outer = np.asarray(getattr(flat, name)), np.asarray(getattr(found, name))
        np.testing.assert_allclose(inner, outer, atol=1e-5 * np.abs(outer).max())


def test_tension_of_the_edges_of_a_twisted_strip():
    """Fibres are longer by y^2 kappa^2/2; what they pull at their angle y kappa is a torque. Integrals by numpy."""
    rate, force = 30.0, 40.0
    y, weights = np.polynomial.legendre.leggauss(8)
    y, weights = y * W / 2, weights * W / 2
    lengthened = E * rate**2 / 2 * y**2
    sigma = lengthened - weights @ lengthened / W + force / (W * T)
    torque = float(weights @ (sigma * y**2 * rate) * T)
    rectangle = fm.Rectangle(W, T, STEEL)
    wrench = jnp.array([force, 0, 0, torque + float(rectangle.rigidity().GIt) * rate, 0, 0])
    strip_alone = Leaf(rectangle, jnp.zeros(2))
    told = (jnp.array(0.5), L, wrench, (jnp.array(rate), jnp.zeros(())))
    found, tau, across = jax.jit(functools.partial(leaf_stress, strip_alone))(*told)
    middle = force / (W * T) - weights @ lengthened / W
    edge = middle + E * rate**2 / 2 * (W / 2) ** 2
    np.testing.assert_allclose(found, [edge, middle, edge, edge, edge, middle, edge, edge], rtol=1e-12)
    # Fibres and Saint-Venant's shear take all of the torque.
    assert float(tau[EDGE]) == approx(0.7424538 * float(tau[MIDDLE]), rel=1e-6)
    assert not np.any(np.asarray(across))


def plate(u: float) -> tuple[float, float, float]:
    """Curvature in the middle, and deflection of edge and middle, of a plate whose edges are free, over small ones.

    Half the width is 1, the deflection z'''' = -4 (u/2)^4 z with z'' = 1 and z''' = 0 at the edge.
    """
    found = solve_bvp(
        lambda y, z: np.stack([z[1], z[2], z[3], -4 * (u / 2) ** 4 * z[0]]),
        lambda a, b: np.array([a[1], a[3], b[2] - 1, b[3]]),
        np.linspace(0, 1, 41),
        np.stack([np.linspace(-1 / 6, 1 / 3, 41), np.linspace(0, 1, 41), np.ones(41), np.zeros(41)]),
        tol=1e-9,
    )
    return found.y[2, 0], found.y[0, -1] * 3, -found.y[0, 0] * 6


@pytest.mark.parametrize("u", [0.49, 0.5, 1.5, 4.0, 8.0])
def test_shape_of_a_flattened_strip(u):
    """A plate's equation by collocation, 1e-7; also where series and closed form meet (u^4 = 0.06)."""
    found = [float(one) for one in _across(jnp.array(u**4))]
    np.testing.assert_allclose(found, plate(u), rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("bend", [6.0, -6.0, -30.0])
def test_stress_of_a_curved_strip(bend):
    """(2.45): initial curvature 15/m; its moment by differences of the energy (2.44), its lift by collocation."""
    initial, bending = 15.0, E * W * T**3 / 12

    def fourth(bend):
        return 3 * (1 - NU**2) * W**4 * (initial + bend) ** 2 / T**2

    def energy(bend):
        u = fourth(bend) ** 0.25
        keeps = 2 / u * (np.cosh(u) - np.cos(u)) / (np.sinh(u) + np.sin(u))
        return bending * bend**2 / 2 * (1 - NU**2 * keeps) / (1 - NU**2)

    moment = (energy(bend + 1e-3) - energy(bend - 1e-3)) / 2e-3
    leaf = Leaf(fm.Rectangle(W, T, STEEL), jnp.zeros(2), initial=jnp.array(initial))
    sigma, _, _ = jax.jit(functools.partial(leaf_stress, leaf))(jnp.array(0.5), L, jnp.eye(6)[4] * moment)
    _, edge, _ = plate(fourth(bend) ** 0.25)
    lifted = E * NU * bend * (initial + bend) * W**2 / 12 * edge
    np.testing.assert_allclose(np.asarray(sigma)[[0, 6]], np.array([1, -1]) * E * T / 2 * bend + lifted, rtol=1e-4)


@pytest.mark.parametrize("curvatures", [(0.0, 8.0, 0.0, 12.0), (15.0, -6.0, 4.0, 9.0), (-20.0, 7.0, -5.0, 14.0)])
def test_stress_of_a_twisted_and_bent_strip(curvatures):
    """(2.65) beside Ritz's method over the width: initial curvature, its change, initial twist, its change [1/m].

    Two steps of Newton's method for the curvature leave 8e-5; without (2.69) up to 41 % of the largest stress.
    """
    initial, bend, twisted, twist = curvatures
    section, stretch, step = fm.Rectangle(W, T, STEEL), 1e-4, 1e-3
    longer, bending, stiff = twist * (2 * twisted + twist), E * W * T**3 / 12, E * W * T

    def energy(stretch, bend, twist):
        arguments = section, initial, bend, twist * (2 * twisted + twist), stretch, 0.0
        return energy_of_section(*arguments) + bending * bend**2 / 2

    moment = (energy(stretch, bend + step, twist) - energy(stretch, bend - step, twist)) / (2 * step)
    force = stiff * (stretch + W**2 * longer / 24)
    leaf = Leaf(section, jnp.zeros(2), initial=jnp.array([twisted, initial, 0.0]))
    rates = jnp.array(twist), jnp.zeros(())
    torsion = float(section.rigidity().GIt) * twist
    torque = torsion + (energy(stretch, bend, twist + step) - energy(stretch, bend, twist - step)) / (2 * step)
    resultants = jnp.array([force, 0.0, 0.0, torque, moment, 0.0])
    sigma, tau, across = (
        np.asarray(a) for a in jax.jit(functools.partial(leaf_stress, leaf))(0.5, L, resultants, rates)
    )
    along, over = stress_of_section(section, initial, bend, longer, stretch, 0.0)
    np.testing.assert_allclose(sigma[[0, 6, 1, 5]], along, rtol=1e-4, atol=1e-4 * np.max(np.abs(along)))
    assert across[1] == approx(over, rel=1e-3)
    # Fibres and Saint-Venant's shear carry the whole torque.
    plain = np.asarray(section.stress(jnp.array([0, 0, 0, torsion, 0, 0]))[1])
    np.testing.assert_allclose(tau, plain, atol=1e-3 * np.max(np.abs(plain)))


# Of a strip with a moment of 1 N m about its width at the tip, in the middle along and across; with a torque, along at
# the corner and shear in the middle; 0.1, 0.15 and 0.3 widths from the clamp.
SOLID = {
    "bending": ([1.47873e9, 1.42875e9, 1.34446e9], [4.28703e8, 3.97836e8, 2.97263e8]),
    "torsion": ([-1.19125e9, -9.56762e8, -5.08750e8], [2.11230e8, 2.97656e8, 4.79209e8]),
}


@pytest.mark.slow
def test_stress_beside_solid_elements():
    """REFERENCES.md A14-stress; largest deviations: middle 1.6 % along, 1.7 % of that across; corner 4, shear 7.5 %."""
    load, places = 1e-4, np.array([0.1, 0.15, 0.3]) * W / L
    bent = fm.stress(strip(moment=(0, load, 0)), points=401)
    turned = fm.stress(strip(moment=(load, 0, 0)), points=401)
    along_x, across = (np.array(values) * load for values in SOLID["bending"])
    np.testing.assert_allclose(along(bent, "sigma_x", MIDDLE, places), along_x, rtol=0.02)
    np.testing.assert_allclose(along(bent, "across", MIDDLE, places), across, atol=0.02 * along_x[0])
    corner, shear = (np.array(values) * load for values in SOLID["torsion"])
    np.testing.assert_allclose(along(turned, "sigma_x", CORNER, places), corner, rtol=0.045)
    np.testing.assert_allclose(along(turned, "tau", MIDDLE, places), shear, rtol=0.08)


@pytest.mark.slow
def test_flattening_beside_solid_elements():
    """REFERENCES.md A14-stress: curvature 8/m, in the middle of the length; along at both corners and sides, across."""
    base = E * 8 * T / 2
    found = fm.stress(strip(moment=(0, 8 * E * W * T**3 / 12, 0)), points=5)
    sigma, across = np.asarray(found.sigma_x)[0, 2] / base, np.asarray(found.across)[0, 2] / base / NU
    np.testing.assert_allclose(sigma[[0, 6, 1, 5]], [1.1264, -0.7986, 0.9292, -1.0798], atol=0.004)
    np.testing.assert_allclose(across[[1, 5]], [0.4825, -0.4825], atol=0.005)


@pytest.mark.slow
def test_stress_near_a_clamp_of_a_wide_strip_beside_solid_elements():
    """C3D20R, 100 x 50 x 0.5 mm, its guided tip moved by 10 mm: both faces, edge and middle; without (2.59) 14 %.

    Columns: 0.1, 0.2 and 0.5 widths from the clamp; along at the edge and in the middle, and across there, each at +z
    and at -z.
    """
    solid = {
        ("sigma_x", 0): [-268.95, -237.26, -142.90],
        ("sigma_x", 6): [318.09, 295.59, 189.49],
        ("sigma_x", 1): [-319.49, -283.68, -175.69],
        ("sigma_x", 5): [312.20, 276.67, 168.36],
        ("across", 1): [-96.90, -87.65, -53.57],
        ("across", 5): [94.88, 85.13, 50.18],
    }
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (L, 0, 0))
    b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=fm.Rectangle(0.05, T, STEEL), y=(0, 1, 0))
    b.fix("foot")
    b.prescribe("tip", "z", 0.010)
    b.fix("tip", "rotation")
    found = fm.stress(b.build(), points=401)
    for (quantity, point), expected in solid.items():
        stress = along(found, quantity, point, np.array([0.1, 0.2, 0.5]) * 0.05 / L) / 1e6
        np.testing.assert_allclose(stress, expected, rtol=0.05, atol=2.0)


@pytest.mark.slow
def test_von_mises_at_a_stroke_beside_solid_elements():
    """REFERENCES.md A14-stress: guided tip moved by 10 mm; 4.2 % at corners, 2.5 % in the middle, 2.5 % the largest.

    Rows: 0.2, 0.5 and 1 widths from the clamp; corner and middle at +z, then at -z.
    """
    # What holds the tip there without turning it.
    found = fm.stress(strip((0, 0, 4.993936), (0, 0.2481827, 0)), points=401)
    solid = [[286.8, 287.9, 316.6, 277.0], [253.6, 253.2, 295.0, 238.5], [190.4, 208.6, 230.0, 191.8]]
    places = np.array([0.2, 0.5, 1.0]) * W / L
    stress = np.array([along(found, "von_mises", point, places) for point in (0, 1, 6, 5)]).T / 1e6
    np.testing.assert_allclose(stress[:, [1, 3]], np.array(solid)[:, [1, 3]], rtol=0.026)
    np.testing.assert_allclose(stress, solid, rtol=0.045)
    assert float(found.maximum) == approx(360.4e6, rel=0.03)


@pytest.mark.slow
def test_derivatives_by_the_dimensions():
    """Of all stresses of an element in space by width, thickness, length and modulus, place, deformation and force."""
    element, rng = spatial.leaf_spring(3), np.random.default_rng(1)
    ends = jnp.array([[0.0, 0, 0], [1, 0, 0]])
    frame, still = jnp.array([1.0, 0, 0, 0]), jnp.zeros(1)

    def stresses(numbers):
        w, t, length, modulus, place = numbers[:5] * np.array([W, T, L, E, 0.3])
        section = fm.Rectangle(w, t, fm.Material(E=modulus, G=E / 2.6))
        ref = element.reference((ends[0], frame, still, ends[1] * length, frame, still, jnp.zeros(18)))
        given = {"ref": ref, "place": place, "section": section, "order": 3, "clamped": np.array([1.0, 0.0])}
        wrench = numbers[5:11] * np.array([20, 1, 0.1, 1e-2, 0.2, 0.1])
        return jnp.concatenate(element.surface(0.05 * numbers[11:], resultants=wrench, **given)) / 1e6

    at = jnp.asarray(np.concatenate([np.ones(5), rng.uniform(-1, 1, 6 + 26)]))
    forward, reverse = (np.asarray(jax.jit(jacobian(stresses))(at)) for jacobian in (jax.jacfwd, jax.jacrev))
    scale = np.abs(forward).max()
    np.testing.assert_allclose(forward, reverse, atol=1e-10 * scale)
    steps = 1e-5 * np.eye(len(at))
    central = jax.jit(jax.vmap(lambda step: (stresses(at + step) - stresses(at - step)) / 2e-5))(steps).T
    # Truncation, step^2 times third derivatives.
    np.testing.assert_allclose(forward, central, atol=1e-7 * scale)


@pytest.mark.slow
def test_derivative_of_the_largest_stress_and_utilisation():
    """By the thickness, in the plane, through the equilibrium."""

    def answer(thickness):
        b = fm.Builder()
        b.node("foot", (0, 0))
        b.node("tip", (L, 0))
        material = dataclasses.replace(STEEL, strength=500e6, fatigue=200e6)
        b.add(planar.leaf_spring(5), "foot", "tip", name="leaf", section=fm.Rectangle(W, thickness, material))
        b.fix("foot")
        b.force("tip", (10.0, 1.0))
        for number in range(4, 14):
            b.dof("leaf", number)
        return fm.stress(b.build(), points=9)

    def largest(thickness):
        found = answer(thickness)
        return found.smooth_maximum(8), found

    both = fm.jit(lambda thickness: jax.jvp(largest, (thickness,), (T,), has_aux=True))
    _, slope, found = both(T)
    values = [float(both(T * (1 + step))[0]) for step in (1e-5, -1e-5)]
    assert float(slope) == approx((values[0] - values[1]) / 2e-5, rel=1e-6)
    square = found.sigma_x**2 - found.sigma_x * found.across + found.across**2 + 3 * found.tau**2
    np.testing.assert_allclose(found.von_mises, np.sqrt(np.asarray(square)), rtol=1e-12)
    assert float(found.utilisation[0]) == approx(float(found.maximum) / 500e6)
    assert float(found.fatigue_utilisation[0]) == approx(float(found.maximum) / 200e6)
    assert set(found.quantities()) >= {"von Mises", "sigma_x", "tau", "across", "utilisation"}
