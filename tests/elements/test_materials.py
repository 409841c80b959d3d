"""Materials: the catalogue agrees with itself, and what a material states reaches the mechanism."""

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanics.stress_resultants import element_damping, element_stiffness

CATALOGUE = {name: own for name, own in vars(fm.materials).items() if isinstance(own, fm.Material)}
TIME = 2e-4
DAMPED = dataclasses.replace(mechanisms.steel(), damping=TIME)
WIDTH, THICKNESS, LENGTH, MASS = 0.018, 5e-4, 0.1, 0.5


@pytest.mark.parametrize("name", CATALOGUE)
def test_catalogue_agrees_with_itself(name):
    own: Any = CATALOGUE[name]
    # Isotropic: G = E/(2 (1 + nu)); measured moduli of rolled metal differ from it by some percent.
    assert own.G == approx(own.E / (2 * (1 + own.nu)), rel=0.03)
    assert not fm.Circle(1e-3, own).faults()
    # Units: from Invar to aluminium, from glass to the steels.
    assert 0 < own.alpha < 30e-6
    assert 2000 < own.rho < 9000
    assert 50e9 < own.E < 250e9
    for limit in (own.strength, own.fatigue):
        assert limit is None or 1e-4 * own.E < limit < 1e-2 * own.E


def cantilever(element, dimension, section, **properties):
    b = fm.Builder()
    b.node("foot", np.zeros(dimension))
    b.node("tip", LENGTH * np.eye(dimension)[0])
    y = {"y": (0, 1, 0)} if dimension == 3 else {}
    b.add(element, "foot", "tip", name="leaf", section=section, **y, **properties)
    b.fix("foot")
    b.mass("tip", MASS)
    return b


LEAF = fm.Rectangle(WIDTH, THICKNESS, DAMPED, rotary=False)
SHEARED = dataclasses.replace(LEAF, shear=True)
TAPERED = fm.sections.taper(LEAF, dataclasses.replace(LEAF, thickness=2 * THICKNESS))


def measure(p: fm.Point2, q: fm.Point2, *, ref) -> object:
    return (q - p) - (ref.q - ref.p)


def springs(*, ref, section) -> object:
    return np.diag([1.0, 2.0]) * section.rigidity().EA


# An element type of one's own has no damping of its own, and is damped all the same.
OWN = fm.Element(measure, stiffness=springs)


@pytest.mark.slow("tapered")
@pytest.mark.parametrize(
    ("element", "dimension", "section"),
    [
        (planar.truss, 2, LEAF),
        (planar.beam, 2, SHEARED),
        (spatial.beam, 3, SHEARED),
        (spatial.spectral_beam(3, shear=True), 3, SHEARED),
        (planar.spectral_beam(3), 2, TAPERED),
        (OWN, 2, LEAF),
    ],
    ids=["truss", "planar", "spatial", "spectral", "tapered", "own"],
)
def test_damping_is_the_time_constant_times_stiffness(element, dimension, section):
    # Kelvin and Voigt: the stress of every strain has its rate beside it, shear and taper included.
    model = cantilever(element, dimension, section).build(check=False)
    damping = np.asarray(element_damping(model.topology, model.parameters))
    stiffness = np.asarray(element_stiffness(model.topology, model.parameters))
    assert np.any(stiffness)
    np.testing.assert_allclose(damping, TIME * stiffness, rtol=1e-14)


def truss_with(material, **properties):
    """A mass on a truss: one degree of freedom, k = EA/L."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (LENGTH, 0))
    b.add(planar.truss, "foot", "tip", name="rod", section=fm.Rectangle(WIDTH, THICKNESS, material), **properties)
    b.fix("foot")
    b.fix("tip", "y")
    b.mass("tip", MASS)
    return b


def test_a_vibration_decays_as_kelvin_and_voigt_say():
    # m x'' + k (x + time x') = 0.
    massless = dataclasses.replace(DAMPED, rho=0.0)
    k = massless.E * WIDTH * THICKNESS / LENGTH
    square, half = k / MASS, TIME * k / MASS / 2
    found = np.sort_complex(np.ravel(fm.poles(truss_with(massless).build())))
    root = np.sqrt(complex(half**2 - square))
    np.testing.assert_allclose(found, np.sort_complex([-half - root, -half + root]), rtol=1e-9)


def test_damping_of_its_own_counts_alone_and_a_rigid_element_says_nothing():
    own = truss_with(DAMPED, damping=fm.Damping(EA=3.0)).build()
    assert np.asarray(element_damping(own.topology, own.parameters)) == approx(3.0 / LENGTH, rel=1e-14)
    # Held deformations have no damping, and no one is warned of a material that has some.
    held = truss_with(DAMPED, released=())
    assert not np.any(np.asarray(element_damping(*_parts(held.build(check=False)))))


def _parts(model):
    return model.topology, model.parameters


@pytest.mark.slow
def test_damping_that_varies_along_a_beam_is_refused():
    other = dataclasses.replace(LEAF, material=dataclasses.replace(DAMPED, damping=2 * TIME))
    with pytest.raises(fm.ModelError, match="damping of the material varies along the section"):
        cantilever(planar.spectral_beam(3), 2, fm.sections.stepped([LEAF, other], [0.5]))


# -- strength ---------------------------------------------------------------------------------------------------------

STRONG = dataclasses.replace(mechanisms.steel(), strength=400e6, fatigue=100e6)
AREA = WIDTH * THICKNESS


def two_rods(first, second, force):
    """Two rods in line, pulled at the end by a force: the same stress in both."""
    b = fm.Builder()
    for i in range(3):
        b.node(str(i), (i * LENGTH, 0))
        b.fix(str(i), *(() if i == 0 else ("y",)))
    for i, material in enumerate((first, second)):
        b.add(planar.truss, str(i), str(i + 1), name=f"rod {i}", section=fm.Rectangle(WIDTH, THICKNESS, material))
    b.force("2", (force, 0))
    return b


def test_stress_over_strength_by_name():
    weak = dataclasses.replace(STRONG, strength=200e6)
    found = fm.stress(two_rods(STRONG, weak, 150e6 * AREA).build())
    np.testing.assert_allclose(found.utilisation, [150 / 400, 150 / 200], rtol=1e-8)
    np.testing.assert_allclose(found.fatigue_utilisation, [1.5, 1.5], rtol=1e-8)
    assert "utilisation: 0.375 to 0.75, largest in 'rod 1'" in repr(found)
    # Between the largest and n^(1/p) of it, of 80 values.
    assert 0.75 <= float(found.smooth_utilisation(200.0)) <= 0.75 * 80 ** (1 / 200)


@pytest.mark.slow
def test_stress_above_strength_is_told_by_name():
    model = two_rods(mechanisms.steel(), STRONG, 500e6 * AREA).build()
    with pytest.warns(fm.FlexmbWarning, match="above the strength of the material in 'rod 1': by a factor of 1.25"):
        found = fm.stress(model)
    # What states no strength uses none, and the summary names it.
    np.testing.assert_allclose(found.utilisation, [0.0, 1.25], rtol=1e-8)
    assert "without strength: rod 0" in repr(found)


@pytest.mark.slow
def test_strength_along_a_beam_that_varies():
    """A cantilever that is twice as thick at its foot: stress and strength of the section at each place."""
    strong = fm.Rectangle(WIDTH, 2 * THICKNESS, dataclasses.replace(STRONG, strength=800e6))
    thin = dataclasses.replace(strong, thickness=THICKNESS, material=STRONG)
    b = cantilever(planar.spectral_beam(2), 2, fm.sections.taper(strong, thin))
    b.force("tip", (0.0, 1e-3))
    found = fm.stress(b.build(), points=3)
    places = np.asarray(found.places)
    thickness, strength = THICKNESS * (2 - places), 400e6 * (2 - places)
    expected = 6 * 1e-3 * LENGTH * (1 - places) / (WIDTH * thickness**2) / strength
    # But for the tip, where the shear force alone is left.
    used = found.quantities()["utilisation"][0][0]
    np.testing.assert_allclose(used[:2], expected[:2], rtol=1e-6)
    assert found.utilisation[0] == approx(expected[1], rel=1e-6)


@pytest.mark.slow
def test_a_spacar_file_has_the_damping_of_the_material(tmp_path):
    b = cantilever(planar.beam, 2, LEAF)
    fm.write_spacar(b, tmp_path / "leaf.dat")
    read = fm.read_spacar(tmp_path / "leaf.dat").builder.build()
    model = b.build()
    found, expected = (np.asarray(element_damping(*_parts(one))) for one in (read, model))
    np.testing.assert_allclose(found, expected, rtol=1e-14)


@pytest.mark.parametrize(("element", "dimension"), [(planar.beam, 2), (spatial.spectral_beam(2, shear=True), 3)])
def test_a_spacar_file_cannot_have_the_damping_of_shear(element, dimension, tmp_path):
    b = cantilever(element, dimension, dataclasses.replace(LEAF, shear=True))
    with pytest.raises(
        fm.ModelError, match=r"damped by its material and its shear too, which a SPACAR .* give `damping`"
    ):
        fm.write_spacar(b, tmp_path / "leaf.dat")
    assert not (tmp_path / "leaf.dat").exists()


@pytest.mark.slow
def test_without_a_strength_there_is_no_utilisation():
    found = fm.stress(two_rods(mechanisms.steel(), mechanisms.steel(), 1.0).build())
    with pytest.raises(fm.ModelError, match="No material of the elements states its strength"):
        _ = found.utilisation
    assert "utilisation" not in found.quantities()


@pytest.mark.slow
def test_derivatives_of_the_utilisation():
    def used(strength, thickness):
        b = two_rods(STRONG, dataclasses.replace(STRONG, strength=strength), 100e6 * AREA)
        for i in range(2):
            section = b.members[f"rod {i}"].properties["section"]
            b.members[f"rod {i}"].properties["section"] = dataclasses.replace(section, thickness=thickness)
        b.dof("rod 0", 1)
        b.dof("rod 1", 1)
        return fm.stress(b.build(dofs="named")).utilisation[1]

    # F/(w t strength), up to the strain of 5e-4 that is not counted in the section.
    value = 100e6 / 200e6
    by_strength, by_thickness = jax.grad(used, (0, 1))(200e6, THICKNESS)
    assert by_strength == approx(-value / 200e6, rel=1e-8)
    assert by_thickness == approx(-value / THICKNESS, rel=1e-8)


@pytest.mark.slow
def test_designs_with_materials_and_bodies_that_cannot_be_are_refused():
    """Of many designs at once, as of one: a fatigue limit above the strength, an inertia below zero."""

    def build(fatigue, inertia):
        b = two_rods(STRONG, dataclasses.replace(STRONG, fatigue=fatigue), 1.0)
        b.body("2", MASS, center=(0.01, 0.0), inertia=inertia)
        b.fix("2.rotation", "phi")
        return b.build()

    designs = {"fatigue": np.array([100e6, 500e6, 100e6]), "inertia": np.array([1e-3, 1e-3, -1e-3])}
    swept = fm.sweep(build, {"mass": fm.mass}, designs)
    assert [bool(np.isfinite(mass)) for mass in swept["mass"]] == [True, False, False]
