"""STEP and DXF: volumes and places by closed form, read back by the libraries that other programs are made of."""

import io
import sys

import numpy as np
import pytest
from cases.mechanisms import DISTANCE, LENGTH, THICKNESS, WIDTH, planar_guide, spatial_guide, steel
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.workbench import cad

# Open CASCADE's own tolerance [mm], for volumes over the thickness.
CLOSE = 1e-6


@pytest.fixture(scope="module")
def step_reader():
    build123d = pytest.importorskip("build123d", reason="pip install 'flexmb[cad]' brings build123d")
    return lambda exported, path: (path.write_bytes(exported[0]), build123d.import_step(path))[1]


@pytest.fixture(scope="module")
def dxf_reader():
    ezdxf = pytest.importorskip("ezdxf", reason="pip install 'flexmb[cad]' brings ezdxf")
    return lambda exported: ezdxf.read(io.StringIO(exported[0].decode()))


def loaded(builder):
    model = builder.build(release="auto")
    return model, np.asarray(fm.equilibrium(model).x)


GUIDES = {"planar": planar_guide(force=(5.0, 0.0)), "spatial": spatial_guide(force=(0.0, 5.0, 0.0))}


@pytest.mark.parametrize("builder", GUIDES.values(), ids=GUIDES)
def test_leaf_springs_are_solids_of_their_sections(builder, step_reader, tmp_path):
    model, _ = loaded(builder)
    found = step_reader(cad.step(model), tmp_path / "guide.step")
    left, right, bar = found.solids()
    for leaf in (left, right):
        assert leaf.is_valid
        assert leaf.volume == approx(1e9 * LENGTH * WIDTH * THICKNESS, rel=CLOSE)
    # A hundredth of the mechanism is the diameter of what has no section.
    assert bar.volume == approx(np.pi / 4 * (0.01 * 100) ** 2 * 1e3 * DISTANCE, rel=CLOSE)
    up = model.labels.dimension - 1
    for i, leaf in enumerate((left, right)):
        middle = np.array([leaf.center().X, leaf.center().Y, leaf.center().Z])
        assert middle[up] == approx(1e3 * LENGTH / 2, abs=CLOSE)
        assert middle[up - 1] == approx(1e3 * DISTANCE * i, abs=CLOSE)
    assert [child.label for child in found.children] == ["left_1", "right_1", "bar"]


@pytest.mark.parametrize("builder", GUIDES.values(), ids=GUIDES)
def test_deformed_as_the_equilibrium_is(builder, step_reader, tmp_path):
    model, x = loaded(builder)
    left, *_ = step_reader(cad.step(model, x), tmp_path / "guide.step").solids()
    assert left.is_valid
    # The centreline is a cubic, longer than the leaf spring by terms of fourth order in its slope, (6/5 v^2/2)^2.
    assert left.volume == approx(1e9 * LENGTH * WIDTH * THICKNESS, rel=1e-4)
    names = [str(entry) for entry in model.labels.x]
    axis = "xy"[model.labels.dimension - 2]
    top = 1e3 * x[names.index(f"left1.{axis}")]
    assert top > 5
    # The end is turned by nothing: its section reaches half a thickness further.
    assert max(getattr(v, axis.upper()) for v in left.vertices()) == approx(top + 1e3 * THICKNESS / 2, abs=1e-3)


SECTIONS = {
    "circle": (fm.Circle(0.002, steel()), np.pi / 4 * 0.002**2),
    "tube": (fm.Tube(0.002, 0.0004, steel()), np.pi / 4 * (0.002**2 - 0.0012**2)),
    "hollow": (fm.HollowRectangle(0.004, 0.002, 0.0005, 0.0002, steel()), 0.004 * 0.002 - 0.003 * 0.0016),
    "outline": (fm.Rigidity(1e6, 1.0, 1.0, 1.0, outline=fm.Rectangle(0.01, 0.001, steel())), 0.01 * 0.001),
}


@pytest.mark.parametrize(("section", "area"), SECTIONS.values(), ids=SECTIONS)
def test_every_section_has_its_volume(section, area, step_reader, tmp_path):
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0.03, 0.04, 0.12))
    b.add(spatial.beam, "A", "B", section=section, released="all")
    b.fix("A")
    (solid,) = step_reader(cad.step(b.build()), tmp_path / "beam.step").solids()
    assert solid.is_valid
    assert solid.volume == approx(1e9 * area * 0.13, rel=1e-5)


def test_a_notched_spring_has_its_shape(step_reader, tmp_path):
    r, depth = 0.0045, 0.004
    section = fm.sections.notch_circular(0.01, 0.01, 0.002, r, steel())
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.009, 0))
    b.add(planar.spectral_beam, "A", "B", section=section)
    b.fix("A")
    (solid,) = step_reader(cad.step(b.build()), tmp_path / "notch.step").solids()
    # A block without two segments of a disc, of which flat pieces between the sections leave little out.
    segment = r**2 * np.arccos((r - depth) / r) - (r - depth) * np.sqrt(2 * r * depth - depth**2)
    assert solid.volume == approx(1e9 * 0.01 * (0.009 * 0.01 - 2 * segment), rel=1e-2)


def area_of(points):
    x, y = np.asarray(points)[:, :2].T
    return abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2


@pytest.mark.slow
def test_a_drawing_in_the_plane(dxf_reader):
    model, x = loaded(GUIDES["planar"])
    drawing = dxf_reader(cad.dxf(model))
    assert drawing.header["$INSUNITS"] == 4
    assert not drawing.audit().errors
    space = drawing.modelspace()
    outlines = space.query("LWPOLYLINE[layer=='outlines']")
    assert [area_of(one.get_points()) for one in outlines] == approx([1e6 * LENGTH * THICKNESS] * 2)
    assert all(one.closed for one in outlines)
    assert len(space.query("LWPOLYLINE[layer=='centrelines']")) == 2
    assert len(space.query("LWPOLYLINE[layer=='rigid']")) == 1
    for state in (None, x):
        space = dxf_reader(cad.dxf(model, state)).modelspace()
        points = [tuple(point.dxf.location) for point in space.query("POINT[layer=='nodes']")]
        own = np.asarray(model.parameters.reference) if state is None else state
        expected = [own[list(model.labels.coordinates(text.dxf.text))] for text in space.query("TEXT")]
        np.testing.assert_allclose(np.array(points)[:, :2], 1e3 * np.array(expected), atol=1e-9)


@pytest.mark.slow
def test_a_drawing_in_space(dxf_reader):
    model, x = loaded(GUIDES["spatial"])
    space = dxf_reader(cad.dxf(model, x)).modelspace()
    (left, _) = space.query("POLYLINE[layer=='outlines']")
    corners = np.array([tuple(v.dxf.location) for v in left.vertices])
    # The two edges of a leaf spring are its width apart.
    half = len(corners) // 2
    np.testing.assert_allclose(np.linalg.norm(corners[:half] - corners[half:][::-1], axis=1), 1e3 * WIDTH)
    (bar,) = space.query("POLYLINE[layer=='rigid']")
    ends = np.array([tuple(v.dxf.location) for v in bar.vertices])
    np.testing.assert_allclose(np.linalg.norm(ends[1] - ends[0]), 1e3 * DISTANCE)


def test_what_is_left_out_is_told(step_reader):
    b = planar_guide()
    b.add(planar.spring_damper, "left0", "right1", law=lambda s, v: 10.0 * s, name="helper")
    _, told = cad.step(b.build(release="auto"))
    assert any("helper" in note for note in told)
    bare = fm.Builder()
    bare.node("A", (0, 0))
    bare.node("B", (1, 0))
    bare.add(planar.spring_damper, "A", "B", law=lambda s, v: 10.0 * s)
    bare.fix("A")
    bare.fix("B", "y")
    with pytest.raises(fm.ModelError, match="No element has a section with a shape"):
        cad.step(bare.build())


def test_names_are_text(step_reader, dxf_reader, tmp_path):
    name = "<script>'ä%%c\\P" + "x" * 100
    b = fm.Builder()
    b.node(name, (0, 0))
    b.node("B", (0.1, 0))
    b.add(planar.beam, name, "B", section=fm.Rectangle(0.01, 0.001, steel()), released="all", name=name)
    b.fix(name)
    model = b.build()
    assert len(step_reader(cad.step(model), tmp_path / "a.step").solids()) == 1
    drawing = dxf_reader(cad.dxf(model))
    assert not drawing.audit().errors
    assert len(drawing.modelspace().query("TEXT")) == 2


@pytest.mark.slow("dxf-ezdxf")
@pytest.mark.parametrize(("function", "library"), [(cad.step, "build123d"), (cad.dxf, "ezdxf")])
def test_a_missing_library_is_named(function, library, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ImportError, match=rf"needs {library}: pip install 'flexmb\[cad\]'"):
        function(planar_guide().build(release="auto"))
