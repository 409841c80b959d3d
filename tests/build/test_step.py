"""Bodies from STEP files: build123d makes solids whose mass, centre and inertia are closed forms."""

import sys
from types import SimpleNamespace

import jax
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb.build.step import body_of_step

# Of a box, in metres, and where its centre is.
SIZES, PLACE, RHO = np.array([0.04, 0.02, 0.01]), np.array([0.01, 0.02, 0.03]), 7800.0
MASS = RHO * np.prod(SIZES)
OWN = MASS / 12 * (np.sum(SIZES**2) * np.eye(3) - np.diag(SIZES**2))


@pytest.fixture(scope="module")
def cad():
    return pytest.importorskip("build123d", reason="pip install 'flexmb[cad]' brings build123d")


def box(cad, sizes=SIZES, place=PLACE, unit=1e-3):
    return cad.Pos(*(place / unit).tolist()) * cad.Box(*(sizes / unit).tolist())


def test_box(cad, tmp_path):
    path = tmp_path / "box.step"
    cad.export_step(box(cad), path)
    mass, center, inertia = body_of_step("It", path, fm.Material(210e9, 80e9, RHO))
    # Open CASCADE's own tolerance of 1e-7 mm, over 10 mm.
    assert mass == approx(MASS, rel=1e-7)
    np.testing.assert_allclose(center, PLACE, rtol=1e-7)
    np.testing.assert_allclose(inertia, OWN, rtol=1e-7, atol=1e-7 * OWN[0, 0])


def test_units_of_the_file_are_metres_here(cad, tmp_path):
    for name, unit in (("M", 1.0), ("IN", 25.4e-3)):
        path = tmp_path / f"{name}.step"
        cad.export_step(cad.Box(1.0, 2.0, 3.0), path, unit=getattr(cad.Unit, name))
        assert body_of_step("It", path, 1.0)[0] == approx(6 * unit**3, rel=1e-7)


def test_several_solids_make_one_body(cad, tmp_path):
    """Two halves of the box have its mass, centre and inertia together."""
    half = SIZES * [0.5, 1, 1]
    apart = np.array([SIZES[0] / 4, 0, 0])
    path = tmp_path / "halves.step"
    cad.export_step(cad.Compound([box(cad, half, PLACE + side * apart) for side in (-1, 1)]), path)
    mass, center, inertia = body_of_step("It", str(path), RHO)
    assert mass == approx(MASS, rel=1e-7)
    np.testing.assert_allclose(center, PLACE, rtol=1e-7)
    np.testing.assert_allclose(inertia, OWN, rtol=1e-7, atol=1e-7 * OWN[0, 0])


def test_solids_add_up_by_parallel_axes(monkeypatch, tmp_path):
    """The same halves as another program would report them, in millimetres: without build123d this is tested too."""
    sizes, arm = 1e3 * SIZES * [0.5, 1, 1], np.array([1e3 * SIZES[0] / 4, 0, 0])
    volume = np.prod(sizes)
    own = volume / 12 * (np.sum(sizes**2) * np.eye(3) - np.diag(sizes**2))

    def half(side):
        center = 1e3 * PLACE + side * arm
        return SimpleNamespace(volume=volume, matrix_of_inertia=own.tolist(), center=lambda of: tuple(center))

    shape = SimpleNamespace(solids=lambda: [half(-1), half(1)])
    fake = SimpleNamespace(import_step=lambda path: shape, CenterOf=SimpleNamespace(MASS=None))
    monkeypatch.setitem(sys.modules, "build123d", fake)
    (tmp_path / "part.step").touch()
    mass, center, inertia = body_of_step("It", tmp_path / "part.step", RHO)
    assert mass == approx(MASS, rel=1e-14)
    np.testing.assert_allclose(center, PLACE, rtol=1e-14)
    np.testing.assert_allclose(inertia, OWN, rtol=1e-12, atol=1e-14 * OWN[0, 0])


def test_in_the_plane_and_in_space_a_box_swings_as_one_of_numbers(cad, tmp_path):
    path, at = tmp_path / "box.step", np.array([0.0, -0.1, 0.0])
    cad.export_step(box(cad), path)

    def properties(dimension, **given):
        b = fm.Builder()
        b.node("A", (0.0,) * dimension)
        b.body("A", **given)
        (member,) = b.members.values()
        return member.properties

    found = properties(2, step=path, material=RHO, at=at[:2])
    right = properties(2, mass=MASS, center=PLACE[:2] + at[:2], inertia=OWN[2, 2])
    for name, value in right.items():
        np.testing.assert_allclose(found[name], value, rtol=1e-7)
    found = properties(3, step=path, material=RHO, at=at)
    right = properties(3, mass=MASS, center=PLACE + at, inertia=OWN)
    for name, value in right.items():
        np.testing.assert_allclose(found[name], value, rtol=1e-7, atol=1e-7 * np.max(np.abs(value)))


def test_surfaces_and_other_files_have_no_solids(cad, tmp_path):
    surface, text = tmp_path / "face.step", tmp_path / "text.step"
    cad.export_step(cad.Face.make_rect(10, 10), surface)
    text.write_text("not a step file")
    for path in (surface, text):
        with pytest.raises(fm.ModelError, match=rf"It: the STEP file '.*{path.name}' has no solids"):
            body_of_step("It", path, RHO)


def test_without_build123d_the_extra_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "build123d", None)
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    with pytest.raises(
        ImportError, match=r"body on node 'A': a STEP file needs build123d: pip install 'flexmb\[cad\]'"
    ):
        b.body("A", step=tmp_path / "part.step", material=fm.materials.aluminium_7075)


def test_a_density_may_be_traced(cad, tmp_path):
    path = tmp_path / "box.step"
    cad.export_step(box(cad), path)

    def mass(density):
        b = fm.Builder()
        b.node("A", (0, 0, 0))
        b.body("A", step=path, material=density)
        return fm.mass(b.build(check=False))

    assert jax.grad(mass)(RHO) == approx(np.prod(SIZES), rel=1e-7)
