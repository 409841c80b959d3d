"""Leaf springs that are short, broad, thick or bent far beside solid elements; the law of their distortion."""

import decimal
import math
import warnings
from decimal import Decimal

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.integrate import solve_bvp

import flexmb as fm
from flexmb import planar, spatial
from flexmb.elements.bent_strip import curving, relaxing_and_distorting
from flexmb.elements.leaf import Leaf
from flexmb.elements.leaf_stress import leaf_stress

fm.enable_x64()
STEEL = fm.Material(E=210e9, G=210e9 / 2.6, rho=7850.0)


def straight(length: float, width: float, thickness: float) -> fm.Builder:
    """A leaf spring with a clamped foot."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (length, 0, 0))
    b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=fm.Rectangle(width, thickness, STEEL), y=(0, 1, 0))
    b.fix("foot")
    return b


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sizes", "solid", "tolerance"),
    [
        (
            (0.030, 0.030, 0.0003),
            [6.46535e7, 9.11055e6, 1683.84, 1.36289, 0.502897, 4779.40, 1.59526e7, 6827.17],
            [0.001, 0.005, 0.013, 0.007, 0.014, 0.002, 0.005, 0.014],
        ),
        (
            (0.025, 0.050, 0.0005),
            [2.20886e8, 5.43678e7, 22774.3, 26.9727, 4.73463, 44792.6, 6.70919e7, 91679.4],
            [0.003, 0.006, 0.014, 0.010, 0.017, 0.002, 0.007, 0.007],
        ),
        (
            (0.030, 0.012, 0.002),
            [1.70166e8, 6.05006e6, 191916, 93.8412, 57.3714, 2030.44, 1.83573e7, 775924],
            [0.002, 0.002, 0.008, 0.002, 0.006, 0.002, 0.002, 0.012],
        ),
    ],
    ids=["short", "broad", "thick"],
)
def test_tip_beside_solid_elements(sizes, solid, tolerance):
    """C3D20R, a rigid tip; without (2.55) 1 to 5 % too soft along y, without (2.57) the thick one 3.5 % in torsion."""
    b = straight(*sizes)
    b.inertia("tip", (1e-9, 0, 0, 1e-9, 0, 1e-9))
    flexible = np.asarray(fm.compliance(b.build(), "tip"))
    stiff = np.linalg.inv(flexible)
    found = np.array([*1 / np.diag(flexible), stiff[1, 1], stiff[2, 2]])
    assert np.all(np.abs(found / solid - 1) < tolerance)


def test_how_far_and_how_much_a_clamp_makes_a_thick_strip_stiffer():
    """(2.22), (2.55) and (2.58) of a strip 6 times as wide as thick, clamped at its first end."""
    reaches, shares = Leaf(fm.Rectangle(0.012, 0.002, STEEL), jnp.array([1.0, 0.0])).kept(0.03)
    far = np.array([0.14 * 12 + 0.27 * 2, 0.40 * 12, 0.065 * 12 + 0.25 * 2, 0.10 * 12]) / 30
    np.testing.assert_allclose(np.asarray(reaches)[:, 0], far, rtol=1e-12)
    cowper = 10 * 1.3 / (12 + 11 * 0.3)
    np.testing.assert_allclose(np.asarray(shares).T, [[0.09, 0.09, 0.09, 1 - cowper], [0, 0, 0, 0]], rtol=1e-9)


def by_plate(u: float) -> float:
    """Stiffness sideways of a bent plate whose edges stay straight lines of the section, half its width 1.

    The deflection z'''' = -4 (u/2)^4 (z - y), odd in y, with z = z'' = 0 at the edge; fibres are strained by y - z.
    """
    found = solve_bvp(
        lambda y, z: np.stack([z[1], z[2], z[3], -4 * (u / 2) ** 4 * (z[0] - y), 3 * (y - z[0]) * y]),
        lambda a, b: np.array([a[0], a[2], b[0], b[2], a[4]]),
        np.linspace(0, 1, 81),
        np.zeros((5, 81)),
        tol=1e-10,
        max_nodes=20000,
    )
    return found.y[4, -1]


@pytest.mark.parametrize("u", [0.4, 1.5, 4.0, 8.0])
def test_distortion_of_a_bent_strip(u):
    """A plate's equation by collocation, 1e-7."""
    assert float(relaxing_and_distorting(jnp.array(u**4))[1]) == approx(by_plate(u), rel=1e-7)


@pytest.mark.parametrize("v", [0.0, 0.01, 7.0, 29.0, 31.0, 900.0, 1e6])
def test_functions_of_a_bent_strip_and_their_derivatives(v):
    """Power series in decimal numbers of 120 digits, their derivatives by differences: round-off."""

    def functions(v):
        return jnp.stack([curving(v), *relaxing_and_distorting(v)])

    for order, function in enumerate((functions, jax.jacfwd(functions), jax.jacfwd(jax.jacrev(functions)))):
        np.testing.assert_allclose(jax.jit(function)(v), with_many_digits(v, order), rtol=1e-12)


def with_many_digits(v: float, order: int) -> list[float]:
    """Derivatives by v = u^4 of the functions of a bent strip, of order 0, 1 or 2."""
    with decimal.localcontext(prec=120):
        step = Decimal(10) ** -20
        rows = [closed_forms(Decimal(v) + k * step) for k in range(-1, 2)]
        weights = [(0, 1, 0), (-1 / (2 * step), 0, 1 / (2 * step)), (step**-2, -2 * step**-2, step**-2)][order]
        columns = zip(*rows, strict=True)
        return [float(sum(w * value for w, value in zip(weights, column, strict=True))) for column in columns]


def closed_forms(v: Decimal) -> tuple[Decimal, Decimal, Decimal]:
    """Curvature across, kept stress of twist and sideways stiffness, by the power series of sinh, sin, cosh and cos."""
    powers, inverse = (
        [v**k if k else Decimal(1) for k in range(90)],
        [1 / Decimal(math.factorial(n)) for n in range(370)],
    )
    none = Decimal(0)
    s, a, b = (sum((power * inverse[4 * k + n] for k, power in enumerate(powers)), none) for n in (3, 2, 1))
    relaxed = sum((power * (inverse[4 * k + 5] - 2 * inverse[4 * k + 6]) for k, power in enumerate(powers)), none)
    return 2 * a / b, 180 * relaxed / b, 3 * s / a


def test_a_clamp_holds_the_section_of_all_pieces():
    """The share by which a section may distort is one function of the distance from the clamp."""
    section, places = fm.Rectangle(0.03, 0.5e-3, STEEL), np.linspace(0, 1, 9)
    whole = Leaf(section, jnp.array([1.0, 0.0]), jnp.zeros(2))
    last = Leaf(section, jnp.array([1.0, 0.0]), jnp.array([0.006, 0.0]))
    found = jax.jit(lambda own, places, length: own.distorted(places, length))
    np.testing.assert_allclose(found(last, places, 0.014), found(whole, (0.006 + 0.014 * places) / 0.02, 0.02))
    assert float(found(whole, np.zeros(1), 0.02)[0]) == 0
    assert float(found(whole, np.array([0.012 / 0.02]), 0.02)[0]) == 1


@pytest.mark.slow
def test_guided_leaf_springs_at_strokes_beside_solid_elements():
    """C3D20R, 100 x 50 x 0.5 mm: stiffness along y, its rotations held; without (2.56) up to 3.2 % too stiff."""
    for stroke, solid in ((0.005, 3.78049e6), (0.010, 1.57162e6), (0.020, 485570)):
        b = straight(0.1, 0.05, 0.5e-3)
        b.prescribe("tip", "z", stroke)
        b.fix("tip", "rotation")
        assert 1 / float(fm.compliance(b.build(), "tip")[1, 1]) == approx(solid, rel=0.01)


@pytest.mark.slow
def test_wide_fold_at_strokes_beside_solid_elements():
    """C3D20R, legs of 60 x 30 x 0.5 mm at a right angle, the tip moved along x: a tenth and a fifth of a leg.

    Without (2.56) they are 2.8 and 4.1 % too stiff along the fold.
    """
    section = fm.Rectangle(0.03, 0.5e-3, STEEL)
    for stroke, solid, tolerance in (
        (0.006, (10.0693, 614191, 2407.03), 0.011),
        (0.012, (22.393, 248369, 2404.71), 0.014),
    ):
        b = fm.Builder()
        for name, place in {"foot": (0, 0, 0), "corner": (0.06, 0, 0), "tip": (0.06, 0, 0.06)}.items():
            b.node(name, place)
        b.add(spatial.leaf_spring, "foot", "corner", name="first", section=section, y=(0, 1, 0))
        b.add(spatial.leaf_spring, "corner", "tip", name="last", section=section, y=(0, 1, 0))
        b.fix("foot")
        b.prescribe("tip", "x", stroke)
        b.fix("tip", "rotation")
        at = fm.linearize(b.build())
        force = float(at.matrices.reactions[at.labels.known("tip")[0]])
        flexible = np.diag(np.asarray(fm.compliance(at, "tip")))
        np.testing.assert_allclose([force, *1 / flexible[1:3]], solid, rtol=tolerance)


@pytest.mark.slow
def test_stress_of_a_distorted_strip():
    """Fibres at the edges carry more, as those between give way: moment about z over Fa, far from clamps."""
    width, thickness, bend = 0.05, 0.5e-3, 4.0
    section, at = fm.Rectangle(width, thickness, STEEL), jnp.array(0.5)
    leaf, tension, untwisted = Leaf(section, jnp.zeros(2)), 100e6, (jnp.zeros(()), jnp.zeros(()))
    bending = float(section.rigidity().EIy) * bend
    both = jnp.array([0, 0, 0, 0, bending, tension * width**2 * thickness / 6])
    stress = jax.jit(lambda wrench: leaf_stress(leaf, at, 0.1, wrench, untwisted)[0])
    sideways = np.asarray(stress(both) - stress(both.at[5].set(0.0)))
    # What the moment bends, by the closed form of (2.29), found where the moment is its derivative.
    u = (3 * 0.91 * (width**2 / thickness) ** 2 * curvature_of(leaf, bending) ** 2) ** 0.25
    np.testing.assert_allclose(np.abs(sideways[[0, 2, 4, 6]]), tension / by_plate(u), rtol=2e-3)
    np.testing.assert_allclose(sideways[[1, 5]], 0, atol=1e-3)


def test_what_fades_in_the_stress_near_a_clamp():
    """(2.28) and (2.59) by hand: mean of both faces at the edge, difference in the middle, of a strip that is bent."""
    width, thickness, bend = 0.05, 0.5e-3, 4.0
    section = fm.Rectangle(width, thickness, STEEL)
    free, held = Leaf(section, jnp.zeros(2)), Leaf(section, jnp.array([1.0, 0.0]))
    bending = float(section.rigidity().EIy) * bend
    stress = jax.jit(lambda leaf, s: leaf_stress(leaf, s * width / 0.1, 0.1, jnp.eye(6)[4] * bending)[0])
    fourth = 3 * 0.91 * (width**2 / thickness) ** 2 * curvature_of(free, bending) ** 2
    for s in (0.1, 0.3):
        lifted, faded = (np.asarray(stress(leaf, s))[[0, 6]].sum() for leaf in (free, held))
        x = (0.1 + 0.03 * fourth) ** 0.25 * s
        assert faded / lifted == approx(1 - 0.77 * np.exp(-x - x**2 / 2), rel=3e-3)
    upper, lower = np.asarray(stress(held, 0.0))[[1, 5]]
    middle = 1 + 0.65 * 0.3 / (1 + fourth / 500)
    assert (upper - lower) / 2 == approx(6 * bending / (width * thickness**2) * middle, rel=1e-3)


def curvature_of(leaf: Leaf, moment: float) -> float:
    """Curvature at which the energy of a strip far from clamps has a slope, by bisection."""
    names, length = ("EA", "GIt", "EIy", "EIz"), 0.1
    # One coefficient of each strain, then the warping of both ends.
    unit = jnp.zeros(6).at[2].set(length)
    stiff = leaf.matrix(None, 1, length, names)

    @jax.jit
    def slope(bend):
        return jax.grad(lambda b: leaf.energy(1, b * unit, length, names) + 0.5 * b**2 * unit @ stiff @ unit)(bend)

    low, high = 0.0, 2 * moment / float(slope(1.0)) * length
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if float(slope(middle)) < moment * length else (low, middle)
    return low


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ((0.014, 0.03, 0.3e-3), "'leaf' is 0.47 times as long as wide"),
        ((0.1, 0.003, 1e-3), "'leaf' is 3 times as wide as thick"),
    ],
)
def test_sizes_that_are_not_compared_with_solid_elements_warn(sizes, message):
    with pytest.warns(fm.BeamTheoryWarning, match=message):
        straight(*sizes).build()


def test_pieces_of_a_leaf_spring_may_be_short():
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.01 * i, 0))
    for i in range(2):
        b.add(planar.leaf_spring, f"n{i}", f"n{i + 1}", section=fm.Rectangle(0.03, 0.3e-3, STEEL))
    b.fix("n0")
    with warnings.catch_warnings():
        warnings.simplefilter("error", fm.BeamTheoryWarning)
        b.build()


@pytest.mark.parametrize("last", [(0.006, 0.0), (0.004, 0.06), (0.064, 0.0)], ids=["divided", "fold", "thick"])
def test_a_short_leg_or_a_short_leaf_spring_in_pieces_warns(last):
    """0.1 or 0.2 times as long as wide; beside a leg at a fold, or a part that clamps it."""
    b = fm.Builder()
    for name, place in (("foot", (0, 0)), ("middle", (0.004, 0)), ("tip", last)):
        b.node(name, place)
    thickness = 0.3e-3 if last[0] < 0.01 else 1e-3
    b.add(planar.leaf_spring, "foot", "middle", name="short", section=fm.Rectangle(0.03, 0.3e-3, STEEL))
    b.add(planar.leaf_spring, "tip", "middle", section=fm.Rectangle(0.03, thickness, STEEL))
    b.fix("foot")
    with pytest.warns(fm.BeamTheoryWarning, match="'short' is 0.*times as long as wide"):
        b.build()


@pytest.mark.slow
@pytest.mark.parametrize(("curvature", "stroke"), [(None, 0.02), ((0.0, 15.0, 0.0), 1e-3)], ids=["straight", "curved"])
@pytest.mark.parametrize("varies", [False, True])
def test_a_strip_bent_too_far_for_its_width_warns(curvature, stroke, varies):
    """At u = 13 to 16 at its clamp; also by its initial curvature."""
    rectangle = fm.Rectangle(0.05, 0.25e-3, STEEL)
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    section = fm.sections.Profile(lambda place, length: rectangle) if varies else rectangle
    b.add(spatial.leaf_spring(4), "foot", "tip", name="leaf", section=section, y=(0, 1, 0), curvature=curvature)
    b.fix("foot")
    b.prescribe("tip", "z", stroke)
    b.fix("tip", "rotation")
    with pytest.warns(fm.errors.CoarseWarning, match="Element 'leaf'.*Sideways stiffness"):
        fm.equilibrium(b.build())


def test_sizes_are_judged_at_the_length_of_the_leaf_spring():
    """A width of half the length is 0.5 m at a length of 1 m, and 15 mm here."""
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.03, 0, 0))
    section = fm.sections.Profile(lambda place, length: fm.Rectangle(length / 2, 0.5e-3, STEEL))
    b.add(spatial.leaf_spring, "foot", "tip", section=section, y=(0, 1, 0))
    b.fix("foot")
    with warnings.catch_warnings():
        warnings.simplefilter("error", fm.BeamTheoryWarning)
        b.build()
