"""Damping of beams and gears: what each rigidity takes, in a strain that it alone works against."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanics.inertia import mass_matrix
from flexmb.mechanics.stress_resultants import element_damping, element_stiffness

LENGTH = 0.7
EA, GIT, EIY, EIZ, GAY, GAZ = 2.0, 3.0, 5.0, 7.0, 11.0, 13.0


def beam_between(element, dimension, **properties) -> fm.Model:
    b = fm.Builder()
    b.node("p", np.zeros(dimension))
    b.node("q", LENGTH * np.eye(dimension)[0])
    y = {"y": (0, 1, 0)} if dimension == 3 else {}
    b.add(element, "p", "q", name="beam", **y, **properties)
    b.fix("p")
    return b.build(check=False)


# Curvature kappa along a cubic beam: both of its bendings are kappa l^2/2.
BENT = LENGTH**2 / 2 * np.ones(2)
# Element, dimension, deformations of a strain of one, from which, and the rigidity that works against it. Deformations
# of spectral beams are strains times length, of which the k-th Legendre polynomial has the mean square 1/(2 k + 1).
STRAINS = {
    "planar elongation": (planar.beam, 2, LENGTH * np.ones(1), 1, EA),
    "planar bending": (planar.beam, 2, BENT, 2, EIY),
    "elongation": (spatial.beam, 3, LENGTH * np.ones(1), 1, EA),
    # The torsion of a beam is its length times the twist.
    "torsion": (spatial.beam, 3, LENGTH**2 * np.ones(1), 2, GIT),
    "bending about y": (spatial.beam, 3, BENT, 3, EIY),
    "bending about z": (spatial.beam, 3, BENT, 5, EIZ),
    "planar spectral elongation": (planar.spectral_beam(2), 2, LENGTH * np.ones(1), 4, EA),
    "planar spectral bending": (planar.spectral_beam(2), 2, LENGTH * np.ones(1), 6, EIY),
    "planar spectral bending that varies": (planar.spectral_beam(2), 2, LENGTH * np.ones(1), 7, EIY / 3),
    "spectral elongation": (spatial.spectral_beam(2), 3, LENGTH * np.ones(1), 7, EA),
    "spectral torsion": (spatial.spectral_beam(2), 3, LENGTH * np.ones(1), 9, GIT),
    "spectral bending about y": (spatial.spectral_beam(2), 3, LENGTH * np.ones(1), 11, EIY),
    "spectral bending about z": (spatial.spectral_beam(2), 3, LENGTH * np.ones(1), 13, EIZ),
    "planar spectral shear": (planar.spectral_beam(2, shear=True), 2, LENGTH * np.ones(1), 8, GAZ),
    "spectral shear along y": (spatial.spectral_beam(2, shear=True), 3, LENGTH * np.ones(1), 15, GAY),
    "spectral shear along z": (spatial.spectral_beam(2, shear=True), 3, LENGTH * np.ones(1), 17, GAZ),
}


@pytest.mark.slow
@pytest.mark.parametrize("strain", STRAINS)
def test_each_rigidity_dampens_its_own_strain(strain):
    """A uniform rate of strain takes rigidity times its square per length, in the plane and in space."""
    element, dimension, rates, first, rigidity = STRAINS[strain]
    damping = fm.Damping(EA=EA, GIt=GIT, EIy=EIY, EIz=EIZ, GAy=GAY, GAz=GAZ)
    shear = 0.1 if element.options.get("shear") else 0.0
    section = fm.Rigidity(EA=1.0, GIt=1.0, EIy=1.0, EIz=1.0, shear_y=shear, shear_z=shear)
    model = beam_between(element, dimension, section=section, damping=damping)
    matrix = np.asarray(element_damping(model.topology, model.parameters))
    names = [(entry.of, entry.component) for entry in model.labels.e]
    ed = np.zeros(len(names))
    for i, rate in enumerate(rates):
        ed[names.index(("beam", first + i))] = rate
    assert ed @ matrix @ ed == approx(rigidity * LENGTH, rel=1e-12, abs=0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_mesh_is_damped_and_its_turn_is_not(dimension):
    """The torque on gear p is the damping times the rate of its mismatch; the turn is measured alone."""
    b = fm.Builder()
    if dimension == 3:
        b.node("o", (0, 0, 0))
        for name in ("carrier", "p", "q"):
            b.rotation(name)
        axes = {"axis_p": (0, 0, 1.0), "axis_q": (0, 0, 1.0)}
        b.add(spatial.gear, "carrier", "p", "q", name="mesh", ratio=2.0, stiffness=3.0, damping=0.25, **axes)
    else:
        b.node("p", (0, 0))
        b.node("q", (3, 0))
        b.add(planar.gear, "p", "q", name="mesh", ratio=2.0, stiffness=3.0, damping=0.25)
    model = b.build(check=False)
    names = [(entry.of, entry.component) for entry in model.labels.e]
    own = [names.index(("mesh", 1)), names.index(("mesh", 2))]
    matrix = np.asarray(element_damping(model.topology, model.parameters))[np.ix_(own, own)]
    np.testing.assert_array_equal(matrix, [[0.25, 0], [0, 0]])


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_spectral_beam_that_turns_has_the_energy_of_a_rigid_one(dimension):
    """About its end p: m l^3/3, and the rotary inertia of its sections, m and J per length."""
    m, jx, jy, jz, rate = 1.5, 0.3, 0.02, 0.05, 2.0
    element = planar.spectral_beam(3) if dimension == 2 else spatial.spectral_beam(3)
    section = fm.Rigidity(EA=1.0, GIt=1.0, EIy=1.0, EIz=1.0, mass=m, Jx=jx, Jy=jy, Jz=jz)
    model = beam_between(element, dimension, section=section)
    x = np.asarray(model.parameters.reference)
    mass = np.asarray(mass_matrix(model.topology, model.parameters, x))
    labels = model.labels

    def energy(axis):
        v = np.zeros(len(x))
        turn = rate if dimension == 2 else rate * np.eye(3)[axis]
        for end in ("p.rotation", "q.rotation"):
            # The rate of the vector Euler parameters at the unit orientation is half the angular velocity.
            v[labels.known(end)] = turn if dimension == 2 else np.r_[0, turn / 2]
        arm = LENGTH * np.eye(3)[0]
        velocity = np.cross([0, 0, rate] if dimension == 2 else turn, arm)
        v[labels.known("q")] = velocity[:dimension]
        return 0.5 * v @ mass @ v

    arm = m * LENGTH**3 / 3
    if dimension == 2:
        assert energy(2) == approx(0.5 * rate**2 * (arm + jy * LENGTH), rel=1e-12, abs=0)
    else:
        found = [energy(axis) for axis in range(3)]
        expected = 0.5 * rate**2 * np.array([jx * LENGTH, arm + jy * LENGTH, arm + jz * LENGTH])
        np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize(("element", "dimension"), [(planar.beam, 2), (spatial.beam, 3)])
def test_shear_has_its_share_of_the_damping(element, dimension):
    """Damping rigidities of one time constant damp a beam with shear as its stiffness does, and as the material."""
    material = fm.Material(E=2.0, G=0.8, rho=3.0)
    section = fm.Rectangle(0.3, 0.2, material, shear=True)
    damping = fm.sections.damping_from_ratio(section, LENGTH, 0.5, frequency=1.0)
    model = beam_between(element, dimension, section=section, damping=damping)
    matrices = [np.asarray(one(model.topology, model.parameters)) for one in (element_damping, element_stiffness)]
    np.testing.assert_allclose(matrices[0], 0.5 / np.pi * matrices[1], rtol=1e-12, atol=1e-15)
    # Bending and shear in series, each with its own share of a deflection with opposite moments at its ends.
    bent, flexible = 5.0, 0.25
    numbers = fm.Rigidity(EA=1.0, GIt=1.0, EIy=2.0, EIz=2.0, shear_y=flexible, shear_z=flexible)
    model = beam_between(element, dimension, section=numbers, damping=fm.Damping(EIy=bent, GAz=GAZ))
    matrix = np.asarray(element_damping(model.topology, model.parameters))
    first = [(entry.of, entry.component) for entry in model.labels.e].index(("beam", 2 if dimension == 2 else 3))
    bending, shearing = 6 * 2.0 / LENGTH**3, 2.0 / flexible / (2 * LENGTH)
    share = shearing / (bending + shearing)
    expected = share**2 * bending * bent / 2.0 + (1 - share) ** 2 * shearing * GAZ / (2.0 / flexible)
    way = np.array([1.0, -1.0]) / np.sqrt(2)
    assert way @ matrix[first : first + 2, first : first + 2] @ way == approx(expected, rel=1e-12, abs=0)


def test_damping_of_a_material_reaches_every_strain():
    """Time constant times rigidity, also of shear; sections that are rigid in shear have no such damping."""
    material = fm.Material(E=2.0, G=0.8, damping=0.5)
    section = fm.Rectangle(0.3, 0.2, material, shear=True)
    numbers, damping = section.rigidity(), section.material_damping().rigidities(section)
    for name in ("EA", "EIy", "EIz", "GIt"):
        assert getattr(damping, name) == approx(0.5 * getattr(numbers, name), rel=1e-12, abs=0)
    assert damping.GAy == approx(0.5 * numbers.EIz / numbers.shear_y, rel=1e-12, abs=0)
    assert damping.GAz == approx(0.5 * numbers.EIy / numbers.shear_z, rel=1e-12, abs=0)
    # Frequency at which the ratio times two over the angular frequency is the time constant.
    same = fm.sections.damping_from_ratio(section, 1.0, 0.5 * np.pi, frequency=1.0)
    assert same.GAy == approx(damping.GAy, rel=1e-12, abs=0)
    rigid = fm.Rectangle(0.3, 0.2, material)
    assert rigid.material_damping().rigidities(rigid).GAz == 0.0
