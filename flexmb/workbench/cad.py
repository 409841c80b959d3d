"""The mechanism for CAD programs in millimetres: solids as STEP by build123d, lines as DXF by ezdxf."""

import importlib
import io
import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..display import listed
from ..elements.section import Rigidity
from ..elements.sections import HollowRectangle, Tube
from ..errors import ModelError, printable
from ..math.rotation import initial_frame
from ..model.model import Model
from ..numerical_limits import NEGLIGIBLE
from ..plot.geometry import PLACES, Line, lines, nodes_of, point_extent
from ..plot.sections import across_of, sections_of, shape_of, shapes_of, unit_vectors
from ..viewer.scene import in_space

MILLIMETRES = 1e3
# A smooth surface passes every so many sections of a bent line.
STRIDE = 6
# Diameter of the bar for a rigid element, as a share of the mechanism.
BAR = 0.01


class _Outline(NamedTuple):
    """Section at a place: outer and inner sides along local y and z, or diameters; zero inside without a hole [m]."""

    outer: tuple[float, float]
    inner: tuple[float, float]
    round: bool


class _Part(NamedTuple):
    """An element with a section: frames and outlines at places along it, joined by one smooth or by flat surfaces."""

    name: str
    points: Float[np.ndarray, "places 3"]
    width: Float[np.ndarray, "places 3"]
    height: Float[np.ndarray, "places 3"]
    outlines: list[_Outline]
    smooth: bool


def step(model: Model, x: Float[np.ndarray, "n_x"] | None = None, title: str = "mechanism") -> tuple[bytes, list[str]]:
    """A STEP file and notes: the mechanism at x as solids of sections, and round bars for rigid elements."""
    cad = _library("build123d", "A STEP file")
    x = np.asarray(model.parameters.reference if x is None else x, float)
    drawn = lines(model, x, straight=True)
    parts, extent = list(_parts(model, x, drawn)), _extent(model)
    solids, known = [_solid(cad, part) for part in parts], {part.name for part in parts}
    bars, without_shape = [], []
    for line in drawn:
        if line.element in known:
            continue
        if line.kind in ("rigid", "beam", "bar") and _length(line.points) > NEGLIGIBLE * extent:
            bars.append(line.element)
            solids += _bars(cad, line, BAR * extent)
        else:
            without_shape.append(line.element)
    if not solids:
        raise ModelError("No element has a section with a shape. A STEP file would be empty.")
    notes = ["Lengths are in millimetres."]
    if bars:
        size = f"{1e3 * BAR * extent:.3g}"
        notes.append(f"Elements without a section are round bars of {size} mm: {listed(bars)}.")
    if without_shape:
        notes.append(f"Elements without a shape are left out: {listed(without_shape)}.")
    compound, buffer = cad.Compound(label=printable(title), children=solids), io.BytesIO()
    cad.export_step(compound, buffer)
    return buffer.getvalue(), notes


def dxf(model: Model, x: Float[np.ndarray, "n_x"] | None = None) -> tuple[bytes, list[str]]:
    """A DXF drawing and notes: layers with outlines in the plane, edges in space, centrelines, and nodes."""
    ezdxf = _library("ezdxf", "A DXF file")
    x = np.asarray(model.parameters.reference if x is None else x, float)
    drawing = ezdxf.new("R2010", setup=True)
    drawing.header["$INSUNITS"], drawing.header["$MEASUREMENT"] = 4, 1
    for name, (color, linetype) in LAYERS.items():
        drawing.layers.add(name, color=color, linetype=linetype)
    space, flat, drawn = drawing.modelspace(), model.labels.dimension == 2, lines(model, x, straight=True)
    extent = _extent(model)

    def draw(points: np.ndarray, layer: str, closed: bool = False) -> None:
        points = MILLIMETRES * np.asarray(points)
        if flat:
            space.add_lwpolyline(points[:, :2].tolist(), close=closed, dxfattribs={"layer": layer})
        else:
            space.add_polyline3d(points.tolist(), close=closed, dxfattribs={"layer": layer})

    for part in _parts(model, x, drawn):
        along = part.height if flat else part.width
        half = np.array([outline.outer[1 if flat else 0] for outline in part.outlines])[:, None] / 2
        draw(np.concatenate([part.points + half * along, (part.points - half * along)[::-1]]), "outlines", closed=True)
    for line in drawn:
        if len(line.points) > 1:
            draw(in_space(_few(line.points, extent)), LAYER_OF[line.kind])
    for name, index in nodes_of(model).items():
        at = MILLIMETRES * in_space(x[index])
        space.add_point(at.tolist(), dxfattribs={"layer": "nodes"})
        text = space.add_text(printable(name), height=MILLIMETRES * 0.015 * extent, dxfattribs={"layer": "names"})
        text.set_placement(at.tolist())
    stream = io.StringIO()
    drawing.write(stream)
    return stream.getvalue().encode("utf-8"), ["Lengths are in millimetres."]


# Colour by its number in AutoCAD, and line type.
LAYERS = {
    "outlines": (5, "CONTINUOUS"),
    "centrelines": (1, "CENTER"),
    "rigid": (8, "CONTINUOUS"),
    "springs": (3, "CONTINUOUS"),
    "joints": (9, "CONTINUOUS"),
    "nodes": (7, "CONTINUOUS"),
    "names": (7, "CONTINUOUS"),
}
LAYER_OF = {"beam": "centrelines", "bar": "centrelines", "rigid": "rigid", "spring": "springs"}
LAYER_OF |= {"joint": "joints", "hinge": "joints"}


def _library(name: str, feature: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(f"{feature} needs {name}: pip install 'flexmb[cad]'.") from None


def _extent(model: Model) -> float:
    x = np.asarray(model.parameters.reference)
    return point_extent(np.array([x[index] for index in nodes_of(model).values()]))


def _length(points: np.ndarray) -> float:
    return float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def _few(points: np.ndarray, extent: float) -> np.ndarray:
    """The ends of a straight line, or all points of another one."""
    s = np.linspace(0, 1, len(points))[:, None]
    off = np.max(np.abs(points - (1 - s) * points[0] - s * points[-1]))
    return points[[0, -1]] if off <= NEGLIGIBLE * extent else points


def _outline(section: Any) -> _Outline | None:
    """Outline of a section; None if it has no shape."""
    shape = shape_of(section)
    if shape is None:
        return None
    solid: Any = section.outline if isinstance(section, Rigidity) else section
    inner = 0.0, 0.0
    if isinstance(solid, HollowRectangle):
        inner = max(shape.width - 2 * float(solid.wall_y), 0.0), max(shape.thickness - 2 * float(solid.wall_z), 0.0)
    elif isinstance(solid, Tube):
        inner = shape.width - 2 * float(solid.wall), shape.width - 2 * float(solid.wall)
    return _Outline((shape.width, shape.thickness), inner, shape.round)


def _parts(model: Model, x: np.ndarray, drawn: list[Line]) -> Iterator[_Part]:
    """Elements with a known orientation whose sections have a shape."""
    sections, extent = sections_of(model), _extent(model)
    across = across_of(model, x, drawn, shapes_of(model))
    undeformed = {line.element: line for line in lines(model, np.asarray(model.parameters.reference), straight=True)}
    for line in drawn:
        section = sections.get(line.element)
        if section is None or len(line.points) != len(PLACES) or _length(line.points) <= NEGLIGIBLE * extent:
            continue
        length = _length(undeformed[line.element].points)
        places = PLACES.tolist() if section.varies else [0.0]
        known = [shape for place in places if (shape := _outline(section.at(place, length))) is not None]
        if len(known) < len(places):
            continue
        outlines = known if section.varies else known * len(PLACES)
        points = in_space(line.points)
        tangents = unit_vectors(np.gradient(points, axis=0, edge_order=2))
        if model.labels.dimension == 2:
            width = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        elif line.element in across:
            width = across[line.element]
        elif outlines[0].round:
            width = _untwisted(tangents)
        else:
            continue
        straight = len(_few(points, extent)) == 2 and np.ptp(width, axis=0).max() < NEGLIGIBLE
        ends = [0, -1] if straight else None
        chosen = list(range(len(PLACES)) if section.varies else ends or range(0, len(PLACES), STRIDE))
        rows = points[chosen], width[chosen], np.cross(tangents, width)[chosen], [outlines[i] for i in chosen]
        yield _Part(line.element, *rows, not section.varies and len(chosen) > 2)


def _untwisted(tangents: np.ndarray) -> np.ndarray:
    """Directions across a line that do not turn about it, (places, 3)."""
    start, end = np.zeros(3), tangents[0]
    y = np.asarray(initial_frame(jnp.asarray(start), jnp.asarray(end), None))[:, 1]
    directions = []
    for t in tangents:
        y = unit_vectors(y - (y @ t) * t)
        directions.append(y)
    return np.array(directions)


def _solid(cad: Any, part: _Part) -> Any:
    """The solid through the sections of a part."""

    def lofted(sizes: list[tuple[float, float]]) -> Any:
        wires = []
        for p, y, z, (a, b), outline in zip(part.points, part.width, part.height, sizes, part.outlines, strict=True):
            if outline.round:
                plane = cad.Plane(tuple(MILLIMETRES * p), x_dir=tuple(y), z_dir=tuple(np.cross(y, z)))
                wires.append(cad.Wire.make_circle(MILLIMETRES * a / 2, plane))
            else:
                corners = [p + i * a / 2 * y + j * b / 2 * z for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
                wires.append(cad.Wire.make_polygon([tuple(MILLIMETRES * c) for c in corners]))
        return cad.Solid.make_loft(wires, ruled=not part.smooth)

    solid = lofted([outline.outer for outline in part.outlines])
    if all(min(outline.inner) > 0 for outline in part.outlines):
        solid = solid.cut(lofted([outline.inner for outline in part.outlines]))
    solid.label = printable(part.name)
    return solid


def _bars(cad: Any, line: Line, diameter: float) -> Iterator[Any]:
    """Round bars along the segments of a line."""
    points = MILLIMETRES * in_space(_few(line.points, point_extent(line.points)))
    for p, q in itertools.pairwise(points):
        plane = cad.Plane(tuple(p), z_dir=tuple(q - p))
        bar = cad.Solid.make_cylinder(MILLIMETRES * diameter / 2, float(np.linalg.norm(q - p)), plane)
        bar.label = printable(line.element)
        yield bar
