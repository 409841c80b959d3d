"""Holes in leaf springs: solid finite elements, derivatives, and what is refused or warned of."""

import dataclasses
import json
import warnings
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.elements.holes import Holed
from flexmb.linear.stress import left_out_of_stress
from flexmb.math.quadrature import gauss

STEEL = fm.Material(E=210e9, nu=0.3, rho=7850)
STRIP = fm.Rectangle(0.03, 0.5e-3, STEEL)
SOLIDS = Path(__file__).parents[2] / "benchmarks/results/solid.json"
SHAPES = {
    "slot": ((0.1, 0.03), (0.04, 0.01), False),
    "slot with round ends": ((0.08, 0.02), (0.03, 0.008), True),
    "round hole": ((0.06, 0.024), (0.013, 0.013), True),
}


def holed(strip=STRIP, width=0.01, places=(0.0, 0.03, 0.07, 0.1), rounded=True, plane=False, **beside) -> fm.Builder:
    """A strip with a hole between the two inner places."""
    b, rooms = fm.Builder(), planar if plane else spatial
    across = {} if plane else {"y": (0, 1, 0)}
    nodes = ("foot", "start", "end", "tip")
    for name, x in zip(nodes, places, strict=True):
        b.node(name, (x, 0) if plane else (x, 0, 0))
    leaf = planar.leaf_spring(shear=True) if plane else spatial.leaf_spring
    section = fm.sections.with_hole(strip, width, rounded=rounded)
    b.add(leaf, "foot", "start", name="first", section=strip, **across)
    b.add(rooms.spectral_beam(shear=True), "start", "end", name="hole", section=section, **across, **beside)
    b.add(leaf, "end", "tip", name="last", section=strip, **across)
    b.fix("foot")
    return b


@jax.jit
def compliances(section, length) -> jax.Array:
    """Compliances of a beam at its middle: N, T, My, Mz, Vy, Vz."""
    places, weights = gauss(6)

    def at(place):
        r = section.at(place, length).rigidity()
        bending, away = jnp.stack([1 / r.EIy, 1 / r.EIz]), (length * (place - 0.5)) ** 2
        shears = jnp.stack([(r.shear_y + away) / r.EIz, (r.shear_z + away) / r.EIy])
        return jnp.concatenate([jnp.stack([1 / r.EA, 1 / r.GIt]), bending, shears])

    return length * weights @ jax.vmap(at)(places)


def added(strip: fm.Rectangle, width, length, rounded: bool) -> np.ndarray:
    """What a hole adds to the compliances of a strip at its centre, in units of the strip: N, T, My, Mz, Vy, Vz."""
    plain, w = dataclasses.replace(strip, shear=True), strip.width
    r = plain.rigidity()
    units = np.array([w / r.EA, w / r.GIt, w / r.EIy, w / r.EIz, w**3 / r.EIz, w**3 / r.EIy])
    hole = fm.sections.with_hole(strip, width, rounded=rounded)
    return np.asarray(compliances(hole, length) - compliances(plain, length)) / units


@pytest.mark.parametrize(
    ("length", "rounded", "solid"),
    [
        (4 / 3, False, [0.91690, 0.72933, 0.75713, 0.06125, 4.91528, 0.14500]),
        (1 / 3, True, [0.29948, 0.11845, 0.17601, 0.01479, 0.16790, 0.00224]),
    ],
)
def test_compliance_of_a_hole_beside_solid_elements(length, rounded, solid):
    """C3D20R, hole of a third of the width: benchmarks/solid_holes.py with finer meshes than those of the fit."""
    strip = fm.Rectangle(0.02, 0.3e-3, STEEL)
    found = added(strip, 0.02 / 3, 0.02 * length, rounded)
    # Of the compliance of the hole and half a width of the strip on both sides: residual of the fit.
    beside = [length + 1] * 4 + [length**3 / 12 + length / 3.9, (length + 1) ** 3 / 12]
    np.testing.assert_allclose((found - solid) / (np.array(solid) + beside), 0, atol=0.013)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_holes_beside_solid_elements(name):
    """A slot, and two holes that the fit did not use; residual of the fit 1.3 %."""
    (length, width), (long, wide), rounded = SHAPES[name]
    places = (0.0, (length - long) / 2, (length + long) / 2, length)
    b = holed(fm.Rectangle(width, 0.5e-3, STEEL), wide, places, rounded)
    b.node("beyond", (length + 0.01, 0, 0))
    b.add(spatial.beam, "tip", "beyond")
    found = 1 / np.diag(fm.compliance(b.build(), "tip"))
    quantities = json.loads(SOLIDS.read_text())["solid"][name]["quantities"]
    solid = [quantities[f"stiffness {axis}"]["fine"] for axis in ("x", "y", "z", "rx", "ry", "rz")]
    np.testing.assert_allclose(found, solid, rtol=0.013)


def test_a_hole_has_derivatives():
    """Forward, reverse and central differences of the compliances by all sizes."""

    def numbers(sizes):
        width, thickness, hole, length, nu = sizes
        section = Holed(fm.Rectangle(width, thickness, fm.Material(E=1.0, nu=nu)), hole, length, 0.2)
        r = section.rigidity()
        return jnp.log(jnp.stack([r.EA, r.GIt, r.EIy, r.EIz, r.shear_y, r.shear_z]))

    sizes = jnp.array([0.03, 0.5e-3, 0.01, 0.04, 0.3])
    steps = 1e-5 * np.diag(sizes)

    @jax.jit
    def all_ways(sizes):
        change = jax.vmap(numbers)(sizes + steps) - jax.vmap(numbers)(sizes - steps)
        return jax.jacfwd(numbers)(sizes), jax.jacrev(numbers)(sizes), change.T / (2e-5 * sizes)

    forward, reverse, differences = all_ways(sizes)
    np.testing.assert_allclose(forward * sizes, reverse * sizes, rtol=1e-10, atol=1e-10)
    # The square of the step, and round-off over the step.
    np.testing.assert_allclose(forward * sizes, differences * sizes, rtol=1e-8, atol=1e-8)


def test_stacked_sections_have_stacked_rigidities():
    def section(width, length):
        return Holed(STRIP, width, length, 0.2).rigidity()

    sizes = jnp.array([0.01, 0.015]), jnp.array([0.04, 0.03])
    for found, wanted in zip(*(jax.tree.leaves(f(*sizes)) for f in (section, jax.vmap(section))), strict=True):
        np.testing.assert_allclose(found * jnp.ones(2), wanted, rtol=1e-14)


@pytest.mark.slow
def test_a_mechanism_with_a_hole_has_derivatives():
    def soft(sizes, **options):
        hole, start, thickness = sizes
        places = (0.0, start, 0.1 - start, 0.1)
        model = holed(fm.Rectangle(0.03, thickness, STEEL), hole, places, plane=True).build(**options)
        return fm.compliance(model, "tip")[1, 1]

    sizes = jnp.array([0.01, 0.03, 0.5e-3])
    options = {"dofs": holed(plane=True).build().q_labels}
    found = jax.grad(soft)(sizes, **options) * sizes
    steps = 1e-4 * jnp.diag(sizes)
    change = jnp.stack([soft(sizes + step, **options) - soft(sizes - step, **options) for step in steps]) / 2e-4
    # The square of the step, and round-off over the step.
    np.testing.assert_allclose(found, change, rtol=1e-6, atol=1e-6 * soft(sizes))


@pytest.mark.slow
def test_a_mechanism_has_derivatives_by_what_stands_beside_a_hole():
    """By a place and by a modulus of one outer strip: neither is a reason to miss the strip."""

    def sag(foot, modulus):
        b = fm.Builder()
        for name, place in (("foot", foot), ("start", 0.03), ("end", 0.07), ("tip", 0.1)):
            b.node(name, (place, 0))
        beside = dataclasses.replace(STRIP, material=dataclasses.replace(STEEL, E=modulus))
        leaf, section = planar.leaf_spring(shear=True), fm.sections.with_hole(STRIP, 0.01)
        b.add(leaf, "foot", "start", name="first", section=STRIP)
        b.add(planar.spectral_beam(shear=True), "start", "end", name="hole", section=section)
        b.add(leaf, "end", "tip", name="last", section=beside)
        b.fix("foot")
        return fm.compliance(b.build(dofs=dofs), "tip")[1, 1]

    dofs = holed(plane=True).build().q_labels
    slopes = jax.grad(sag, (0, 1))(0.0, 210e9)
    for i, step in enumerate((1e-6, 1e5)):
        ahead, back = (sag(*(np.array([0.0, 210e9]) + sign * step * np.eye(2)[i])) for sign in (1, -1))
        # Round-off of differences.
        assert float(slopes[i]) == pytest.approx(float(ahead - back) / (2 * step), rel=1e-4)


def test_mass_beside_a_hole_is_the_mass_of_the_rest():
    for rounded, area in ((True, 0.04 * 0.01 - (4 - np.pi) / 4 * 0.01**2), (False, 0.04 * 0.01)):
        mass = fm.sections.with_hole(STRIP, 0.01, rounded=rounded).at(0.5, 0.04).rigidity().mass * 0.04
        assert mass == pytest.approx(7850 * 0.5e-3 * (0.03 * 0.04 - area), rel=1e-12)


@pytest.mark.parametrize("rounded", [True, False])
def test_shear_rigidities_are_positive_in_the_whole_range(rounded):
    @jax.jit
    @jax.vmap
    def shears(share, ratio, nu):
        strip = fm.Rectangle(1.0, 0.01, fm.Material(E=1.0, nu=nu))
        found = Holed(strip, share, share * ratio, 0.5, rounded).rigidity()
        return jnp.minimum(found.shear_y, found.shear_z)

    ranges = np.meshgrid(np.linspace(0.1, 0.7, 13), np.linspace(1, 8, 15), [0.2, 0.3, 0.4])
    assert np.all(shears(*(numbers.ravel() for numbers in ranges)) > 0)


@pytest.mark.slow
def test_a_hole_in_the_plane_bends():
    soft = float(fm.compliance(holed(plane=True).build(), "tip")[1, 1])
    plain = fm.Builder()
    for name, x in (("foot", 0.0), ("tip", 0.1)):
        plain.node(name, (x, 0))
    plain.add(planar.leaf_spring(shear=True), "foot", "tip", section=STRIP)
    plain.fix("foot")
    rest = added(STRIP, 0.01, 0.04, True)[2] * 0.03 / STRIP.rigidity().EIy
    # The curvature of the hole turns the tip at an arm of half of the strip.
    assert soft == pytest.approx(float(fm.compliance(plain.build(), "tip")[1, 1]) + rest * 0.05**2, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"width": 0.022}, "0.73 times as wide as the strip"),
        ({"width": 0.004, "places": (0, 0.03, 0.07, 0.1)}, "10 times as long as wide"),
        ({"places": (0, 0.01, 0.05, 0.1)}, "'hole' .* ends 0.33 widths of the strip from a clamp"),
        ({"strip": fm.Rectangle(0.03, 4e-3, STEEL)}, "2.5 times as wide as thick"),
        ({"strip": fm.Rectangle(0.03, 0.5e-3, fm.Material(E=1e9, nu=0.45))}, "ratio is 0.45"),
        ({"curvature": 0.1}, "a curved strip"),
    ],
)
def test_a_hole_out_of_range_warns(changes, message):
    with pytest.warns(fm.BeamTheoryWarning, match=message):
        holed(plane=True, **changes).build()


def test_a_hole_beside_the_axis_or_without_a_strip_is_an_error():
    b = fm.Builder()
    for name, place in {"foot": (0, 0, 0), "start": (0, 0.005, 0), "end": (0.04, 0.005, 0)}.items():
        b.node(name, place)
    b.add(spatial.rigid_body, "foot", "start")
    section = fm.sections.with_hole(STRIP, 0.01)
    b.add(spatial.spectral_beam(shear=True), "start", "end", name="hole", section=section, y=(0, 1, 0))
    b.fix("foot")
    with pytest.raises(fm.ModelError, match=r"'hole' has a section with a hole, .* at node 'start.rotation'"):
        b.build()


@pytest.mark.parametrize(
    ("width", "length", "message"),
    [
        (0.03, 0.04, "needs a wider"),
        (0.01, 0.005, "as long as wide"),
        (0.0285, 0.04, "0.95 times as wide as the strip, whose fitted compliance to shear is not positive"),
    ],
)
def test_impossible_holes_are_errors(width, length, message):
    with pytest.raises(fm.ModelError, match=message):
        holed(width=width, places=(0, 0.03, 0.03 + length, 0.1), plane=True).build()
    with pytest.raises(TypeError, match="must be a Rectangle"):
        fm.sections.with_hole(fm.HollowRectangle(0.03, 0.01, 1e-3, 1e-3, STEEL), width)


def test_a_leaf_spring_has_no_section_with_a_hole():
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.1, 0, 0))
    section = fm.sections.with_hole(STRIP, 0.01)
    with pytest.raises(fm.ModelError, match=r"not a section of kind Holed: a piece beside a hole is a spectral_beam"):
        b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=section, y=(0, 1, 0))


def test_a_hole_has_no_stress():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = holed().build()
    with pytest.warns(fm.FlexmbWarning, match="'hole' .* no stress.* beside a hole, use solid elements"):
        assert left_out_of_stress(model) == ["hole"]
