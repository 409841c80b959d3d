"""The page of the viewer as one HTML document."""

import base64
import dataclasses
import html
import json
import os
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..files import write_whole
from ..plot.marks import Mark
from .scene import Lines, Nodes

# Colours between the ends of a scale; the page interpolates.
LEVELS = 64
# Height of the frame in a notebook [px].
FRAME_HEIGHT = 520


class Colours(NamedTuple):
    """What the elements are coloured by.

    Attributes:
        label: Name and unit.
        scale: Name of the colours, as matplotlib knows them.
        low: Value at their lower end.
        high: Value at their upper end.
        values: One row for all states, or one for each, NaN where nothing is to be coloured, (rows, points).
    """

    label: str
    scale: str
    low: float
    high: float
    values: Float[np.ndarray, "rows points"]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class View:
    """A page, and the numbers in it.

    Attributes:
        title: What is shown.
        kind: "state", "modes", "self-stress", "path" or "motion".
        dimension: 2 or 3.
        choices: Name of every mode or state of self-stress.
        along: Load factor [-] or time [s] of every state of a path or motion, (states,).
        lines: Elements: points in the base state, which is the undeformed one, or that of the modes; and in the states.
        nodes: The same of the nodes.
        colours: Stress, a section resultant or self-stress; None without.
        marks: Degrees of freedom and loads, the latter in the last state.
        supports: Names of nodes by kind of support.
        masses: Names of the nodes that carry a lumped mass.
        amplitude: Factor of the displacements at the start: share of the extent for modes, else 1.
        largest_amplitude: Largest that the page offers.
    """

    title: str
    kind: str
    dimension: int
    choices: tuple[str, ...]
    along: Float[np.ndarray, "states"]
    lines: Lines
    nodes: Nodes
    colours: Colours | None
    marks: tuple[Mark, ...]
    supports: dict[str, list[str]]
    masses: tuple[str, ...]
    amplitude: float
    largest_amplitude: float

    def __repr__(self) -> str:
        return f"View({self.title})"

    def html(self) -> str:
        """The page: one HTML document that fetches nothing."""
        folder = files("flexmb.viewer")
        page, script = (folder.joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "viewer.js"))
        # "</" and "<!--" would end or change a script element. JSON may escape "<".
        data = json.dumps(page_data(self), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        # Data may contain any text: each piece is inserted once, and never searched.
        before, rest = page.replace("{{title}}", html.escape(self.title)).split("{{data}}")
        between, after = rest.split("{{script}}")
        return "".join([before, data, between, script, after])

    def save(self, path: str | os.PathLike) -> None:
        """Write the page.

        Args:
            path: Where; ends in .html.

        Raises:
            ValueError: The path has another ending.
            OSError: The folder is missing or not writable.
        """
        if not os.fspath(path).endswith(".html"):
            raise ValueError(f"The viewer writes .html, not '{os.fspath(path)}'; fm.plot draws .png and .svg.")
        write_whole(path, self.html().encode())

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for notebooks."""
        content = html.escape(self.html(), quote=True)
        return (
            f'<iframe srcdoc="{content}" title="{html.escape(self.title)}"'
            f' style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
        )


def page_data(view: View) -> dict[str, Any]:
    """Data of the page, with arrays as base64 of 32-bit floats."""
    lines, nodes = view.lines, view.nodes
    index = {name: i for i, name in enumerate(nodes.names)}
    ribbons = bool(np.any(lines.across))
    vectors = [None if mark.vector is None else [*mark.vector.tolist(), 0.0][:3] for mark in view.marks]
    return {
        "title": view.title,
        "kind": view.kind,
        "dimension": view.dimension,
        "choices": view.choices,
        "along": _floats(view.along),
        "amplitude": [view.amplitude, view.largest_amplitude],
        "parts": [[part.name, part.kind, part.start, part.count, part.shape] for part in lines.parts],
        "base": _floats(lines.base),
        "states": _floats(lines.states),
        "across": _floats(lines.across) if ribbons else None,
        "acrossStates": _floats(lines.across_states) if ribbons else None,
        "nodes": {"names": nodes.names, "base": _floats(nodes.base), "states": _floats(nodes.states)},
        "colours": None if view.colours is None else _colours(view.colours),
        "marks": [
            {"kind": mark.kind, "node": index[mark.node], "vector": vector, "text": mark.text}
            for mark, vector in zip(view.marks, vectors, strict=True)
        ],
        "supports": {kind: [index[name] for name in names] for kind, names in view.supports.items()},
        "masses": [index[name] for name in view.masses],
    }


def _colours(colours: Colours) -> dict[str, Any]:
    from matplotlib import colormaps

    table = colormaps[colours.scale](np.linspace(0, 1, LEVELS))[:, :3]
    return {
        "label": colours.label,
        "low": colours.low,
        "high": colours.high,
        "table": np.round(table, 4).tolist(),
        "values": _floats(colours.values),
    }


def _floats(array: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(array, "<f4").tobytes()).decode()
