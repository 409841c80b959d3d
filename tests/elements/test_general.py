"""Sections of general stiffness: coupled strains and an offset mass against formulas and independent programs."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from references import coupled_rods

import flexmb as fm
from flexmb import planar, spatial

LENGTH = 1.3
MASS = {"mass": 2.0, "center_y": 0.06, "center_z": -0.04, "Jx": 0.02, "Jy": 0.007, "Jz": 0.014, "Jyz": 0.003}


def coupled(size, seed=3):
    """A positive definite matrix with all couplings, stiff in tension and shear."""
    random = np.random.default_rng(seed).normal(size=(size, size))
    scale = np.sqrt([400.0, 150, 90, 3, 2, 8] if size == 6 else [400.0, 3, 2, 8])
    own = random @ random.T / size + np.eye(size)
    return own * scale[:, None] * scale


def cantilever(section, *, shear=False, order=6, **properties):
    b = fm.Builder()
    b.node("root", (0, 0, 0))
    b.node("tip", (LENGTH, 0, 0))
    b.fix("root")
    b.add(spatial.spectral_beam(order=order, shear=shear), "root", "tip", name="beam", section=section, **properties)
    return b


@pytest.mark.slow
@pytest.mark.parametrize("size", [4, 6])
def test_small_compliance_has_all_couplings(size):
    stiffness = coupled(size)
    model = cantilever(fm.sections.General(stiffness), shear=size == 6, order=2, y=(0, 1, 0)).build()
    full = coupled(6)
    if size == 4:
        # Without shear: what is held has no compliance.
        full = np.diag([1, 1e15, 1e15, 1, 1, 1.0])
        full[np.ix_([0, 3, 4, 5], [0, 3, 4, 5])] = stiffness
    assert fm.compliance(model, "tip") == approx(coupled_rods.small_compliance(full, LENGTH), rel=1e-9, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("size", [4, 6])
def test_large_displacement_under_weight_beside_the_axis(size):
    """A15: displacement, rotation, and force and moment in sections, by shooting."""
    stiffness, force, gravity = coupled(size), np.array([2.5, -2.0, 3.5]), np.array([0.3, -0.6, 1.2])
    section = fm.sections.General(stiffness, **MASS)
    b = cantilever(section, shear=size == 6, order=14, y=(0, 1, 0))
    b.force("tip", force)
    b.gravity(gravity)
    model = b.build()
    state = fm.equilibrium(model)
    center = (MASS["center_y"], MASS["center_z"])
    place, frame, at_root = coupled_rods.equilibrium(stiffness, LENGTH, force, MASS["mass"] * gravity, center)
    assert np.linalg.norm(place - [LENGTH, 0, 0]) > 0.4 * LENGTH
    np.testing.assert_allclose(state.at("tip"), place, atol=1e-7)
    np.testing.assert_allclose(fm.rotations.to_matrix(state.at("tip.rotation")), frame, atol=1e-7)
    resultants = fm.linear.section_resultants(model, points=2, at=state)
    np.testing.assert_allclose(resultants.values[0, 0], at_root, atol=1e-7)
    np.testing.assert_allclose(resultants.values[0, 1], np.r_[frame.T @ force, 0, 0, 0], atol=1e-7)


@pytest.mark.slow
def test_frequencies_with_a_mass_beside_the_axis():
    """A15: a Ritz program of its own."""
    stiffness = coupled(4)
    model = cantilever(fm.sections.General(stiffness, **MASS), order=10, y=(0, 1, 0)).build()
    inertia = (MASS["Jx"], MASS["Jy"], MASS["Jz"], MASS["Jyz"])
    exact = coupled_rods.frequencies(
        stiffness, LENGTH, MASS["mass"], (MASS["center_y"], MASS["center_z"]), inertia, terms=10
    )
    computed = 2 * np.pi * np.asarray(fm.frequencies(model, count=6))
    np.testing.assert_allclose(computed, exact[:6], rtol=1e-6)


@pytest.mark.slow
def test_general_section_of_a_rectangle_is_the_rectangle():
    rectangle = fm.Rectangle(0.02, 0.004, fm.Material(E=70e9, G=26e9, rho=2700.0, damping=1e-5), shear=True)
    s = rectangle.rigidity()
    shears = [s.EIz / s.shear_y, s.EIy / s.shear_z]
    own = {name: getattr(s, name) for name in ("mass", "Jx", "Jy", "Jz")}
    general = fm.sections.General(np.diag([s.EA, *shears, s.GIt, s.EIy, s.EIz]), **own, damping=1e-5)
    found = []
    for section in (rectangle, general):
        b = cantilever(section, shear=True, order=4, curvature=(0, 0.3, 0.2))
        b.force("tip", (1.0, -2.0, 3.0))
        b.gravity((0, 0, -9.81))
        lin = fm.linearize(b.build())
        found.append([lin.M0, lin.D0, lin.K0, lin.N0, lin.G0, lin.x])
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.max(np.abs(one)))


def test_moments_of_mass_are_about_the_axis():
    """Two equal points of the section, by hand; without inertia about its own centre one point."""
    points = np.array([[0.0, 0.05, -0.01], [0.0, 0.01, 0.03]])
    second = points.T @ points / 2
    y, z = points.mean(axis=0)[1:]
    own = second - np.outer([0, y, z], [0, y, z])
    section = fm.sections.General(
        coupled(4), mass=1.0, center_y=y, center_z=z, Jx=np.trace(own), Jy=own[2, 2], Jz=own[1, 1], Jyz=-own[1, 2]
    )
    mass, first, found = section.moments_of_mass()
    assert mass == 1.0
    np.testing.assert_allclose(first, points.mean(axis=0), atol=1e-15)
    np.testing.assert_allclose(found, second, atol=1e-15)


def test_triangle_and_matrix_are_the_same_stiffness():
    matrix = coupled(6)
    section = fm.sections.General(matrix[np.triu_indices(6)].tolist())
    np.testing.assert_array_equal(section.stiffness, (np.triu(matrix) + np.triu(matrix, 1).T))
    np.testing.assert_array_equal(section.triangle(), matrix[np.triu_indices(6)])
    # Coefficients of the strains in the order of a spectral beam, whose shears come last.
    small = section.series_matrix(1, np.asarray(2.0), True)
    places = [0, 3, 4, 5, 1, 2]
    np.testing.assert_allclose(small, np.asarray(section.stiffness)[np.ix_(places, places)] / 2, rtol=1e-14)
    np.testing.assert_allclose(
        np.diag(section.series_matrix(3, np.asarray(1.0), True))[:3], matrix[0, 0] / np.array([1, 3, 5])
    )


@pytest.mark.slow
def test_damping_of_a_general_section_is_its_time_constant():
    model = cantilever(fm.sections.General(coupled(6), **MASS, damping=2e-4), shear=True, order=2).build()
    lin = fm.linearize(model)
    np.testing.assert_allclose(lin.D0, 2e-4 * lin.K0, rtol=1e-12, atol=1e-12 * np.max(np.abs(lin.D0)))


@pytest.mark.slow
def test_derivatives_by_the_entries_of_a_stiffness():
    """Forward and reverse, against central differences, through a build."""
    triangle, size = coupled(4)[np.triu_indices(4)], 4

    def tip(entries):
        b = cantilever(fm.sections.General(entries), order=2, y=(0, 1, 0))
        b.dof("beam", *range(7, 7 + 2 * size))
        return fm.compliance(b.build(), "tip")[1, 3] + fm.compliance(b.build(), "tip")[2, 4]

    forward, reverse = jax.jacfwd(tip)(jnp.asarray(triangle)), jax.grad(tip)(jnp.asarray(triangle))
    exact = []
    for k in range(len(triangle)):
        step = 1e-4 * np.eye(len(triangle))[k]
        two = []
        for sign in (1, -1):
            full = np.zeros((4, 4))
            full[np.triu_indices(4)] = triangle + sign * step
            full = full + np.triu(full, 1).T
            held = np.diag([1, 1e15, 1e15, 1, 1, 1.0])
            held[np.ix_([0, 3, 4, 5], [0, 3, 4, 5])] = full
            c = coupled_rods.small_compliance(held, LENGTH)
            two.append(c[1, 3] + c[2, 4])
        exact.append((two[0] - two[1]) / 2e-4)
    np.testing.assert_allclose(forward, exact, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(reverse, forward, rtol=1e-9, atol=1e-12)


def changed(size, entries):
    found = coupled(size)
    for (i, j), value in entries.items():
        found[i, j] = value
    return found


WRONG = {
    "of shape (5, 5)": np.eye(5),
    "(6, 6), (4, 4), (21,) or (10,)": np.ones(7),
    "not symmetric: its entries between elongation and twist differ": changed(4, {(0, 1): 5.0}),
    "diagonal entry of the shear_z is not positive": changed(6, {(2, 2): 0.0}),
    "combined strains of elongation and twist need no work": np.array(
        [[1.0, 2, 0, 0], [2, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    ),
}


@pytest.mark.parametrize("fault", WRONG)
def test_impossible_stiffness_is_refused(fault):
    with pytest.raises(fm.ModelError) as raised:
        cantilever(fm.sections.General(WRONG[fault]))
    assert fault in str(raised.value)
    assert "'beam'" in str(raised.value)


@pytest.mark.slow
def test_traced_stiffness_that_is_impossible_gives_no_number():
    def tip(coupling):
        matrix = jnp.diag(jnp.array([400.0, 3, 2, 8])).at[[0, 1], [1, 0]].set(coupling)
        b = cantilever(fm.sections.General(matrix), order=2)
        b.dof("beam", *range(7, 15))
        return fm.compliance(b.build(), "tip")[0, 0]

    possible, impossible = jax.vmap(tip)(jnp.array([10.0, 40.0]))
    assert np.isfinite(possible)
    assert np.isnan(impossible)


@pytest.mark.parametrize(
    ("numbers", "fault"),
    [({"mass": -1.0}, "mass = -1.0"), ({"Jy": -1.0}, "Jy = -1.0"), ({"damping": -1.0}, "damping = -1.0")],
)
def test_negative_numbers_are_refused(numbers, fault):
    with pytest.raises(fm.ModelError, match=f"{fault}, but it cannot be negative"):
        cantilever(fm.sections.General(coupled(4), **numbers))


def test_shear_must_fit_the_matrix():
    with pytest.raises(fm.ModelError, match=r"'beam'.*It counts shear, but the stiffness of its section is \(4, 4\)"):
        cantilever(fm.sections.General(coupled(4)), shear=True).build()
    with pytest.raises(fm.ModelError, match=r"'beam'.*It counts no shear, but .* \(6, 6\)"):
        cantilever(fm.sections.General(coupled(6))).build()


IN_SPACE = [spatial.truss, spatial.beam, spatial.warping_beam, spatial.leaf_spring]
IN_THE_PLANE = [planar.truss, planar.beam, planar.spectral_beam, planar.leaf_spring]


@pytest.mark.parametrize("element", [*IN_SPACE, *IN_THE_PLANE], ids=repr)
def test_other_elements_refuse_a_general_section_by_name(element):
    size = 3 if element in IN_SPACE else 2
    b = fm.Builder()
    b.node("root", np.zeros(size))
    b.node("tip", np.eye(size)[0])
    b.fix("root")
    section = fm.sections.General(coupled(4))
    with pytest.raises(fm.ModelError, match=r"'strip'.*(spatial\.spectral_beam|must be a Rectangle)"):
        b.add(element, "root", "tip", name="strip", section=section)


def test_stress_and_temperature_are_refused_by_name():
    section = fm.sections.General(coupled(4), **MASS)
    with pytest.raises(fm.ModelError, match="'beam' is given by its rigidities, without a shape, and has no stress"):
        fm.stress(cantilever(section, order=2).build())
    b = cantilever(section, order=2)
    with pytest.raises(fm.ModelError, match="'beam'"):
        b.temperature("beam", 10.0)


def test_a_file_cannot_express_a_general_section(tmp_path):
    builder = cantilever(fm.sections.General(coupled(4)), order=2)
    with pytest.raises(fm.ModelError, match=r"Element 'beam' \(spectral_beam\) has a section of general stiffness"):
        fm.write_spacar(builder, tmp_path / "wing.dat")


@pytest.mark.slow
def test_a_general_section_beside_others():
    """Beams with sections of both kinds in one mechanism: in a row, their small compliances add up."""
    b = fm.Builder()
    stiffness = np.diag([400.0, 3, 2, 8])
    for name, x in (("root", 0.0), ("middle", LENGTH), ("tip", 2 * LENGTH)):
        b.node(name, (x, 0, 0))
    b.fix("root")
    plain = fm.Rigidity(EA=400.0, GIt=3.0, EIy=2.0, EIz=8.0)
    b.add(
        spatial.spectral_beam(2), "root", "middle", name="general", section=fm.sections.General(stiffness), y=(0, 1, 0)
    )
    b.add(spatial.spectral_beam(2), "middle", "tip", name="plain", section=plain, y=(0, 1, 0))
    found = fm.compliance(b.build(), "tip")
    length = 2 * LENGTH
    assert found[2, 2] == approx(length**3 / (3 * 2.0), rel=1e-9)
    assert found[1, 1] == approx(length**3 / (3 * 8.0), rel=1e-9)
    assert found[3, 3] == approx(length / 3.0, rel=1e-9)
