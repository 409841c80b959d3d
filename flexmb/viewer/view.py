"""The viewer: a result as a page to turn and to play."""

import dataclasses
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..checks.mobility import Mobility
from ..files import write_whole
from ..linear.buckling import Buckling
from ..linear.modes import Modes
from ..linear.stress import SectionResultants, Stress
from ..model.model import Model
from ..motion.motion import Motion
from ..paths.path import Path
from ..plot.geometry import PLACES, lines, masses, nodes_of
from ..plot.marks import Mark, dofs, loads, supports
from ..plot.modes import AMPLITUDE, factor_of, title_of
from ..plot.self_stress import title_of as title_of_self_stress
from ..plot.state import state_of
from ..plot.stress import colours_of, values_of
from .scene import LOOKED_AT, Lines, Nodes, kept_values, lines_at, lines_of_modes, most_states, nodes_at, thinned

# Modes in one page, unless it is said which.
AT_MOST = 12
# Largest displacement in a mode that the page offers, as share of the extent.
LARGEST_AMPLITUDE = 0.5
# Largest factor of the displacements of a state, path or motion that the page offers.
LARGEST_FACTOR = 5.0


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
        from .page import document

        return document(self)

    def save(self, path: str | os.PathLike) -> None:
        """Write the page.

        Args:
            path: Where; ends in .html.

        Raises:
            ValueError: Another ending.
            OSError: The folder is missing or not writable.
        """
        if not os.fspath(path).endswith(".html"):
            raise ValueError(f"The viewer writes .html, not '{os.fspath(path)}'; fm.plot draws .png and .svg.")
        write_whole(path, self.html().encode())

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for notebooks."""
        from .page import framed

        return framed(self)


def view(
    shown: Any,
    stress: Stress | SectionResultants | Sequence[Stress | SectionResultants] | None = None,
    quantity: str | None = None,
    *,
    at: Any = None,
    which: Sequence[int] | None = None,
) -> View:
    """A result as a page to turn, zoom and play, which opens in any browser without a network, and in notebooks.

    Modes swing about the state that they are about; a path or a motion plays, with straight lines between its states;
    of a single state the displacement from the undeformed mechanism can be enlarged. Sections that the model gives by
    their sides or diameter are drawn by them. A long path or motion is thinned to some million coordinates.

    Args:
        shown: Model, Linearization, Modes, Buckling, Path, Motion or Mobility.
        stress: What colours the elements: stress or section resultants of a single state or of the state that modes
            are about; of a path or motion one for each state.
        quantity: Which of it, as for :func:`flexmb.plot.stress`.
        at: With a Model: equilibrium, configuration or linearisation of it; the undeformed state unless given.
        which: Numbers of the modes, from 0; the first twelve unless given.

    Returns:
        View; ``save("file.html")`` writes it, a notebook shows it.

    Raises:
        TypeError: ``shown``, ``at`` or ``stress`` cannot be shown.
        ValueError: ``at``, ``which``, ``stress`` or ``quantity`` does not fit.
    """
    if which is not None and not isinstance(shown, Modes | Buckling):
        raise ValueError(f"Argument `which` goes with Modes or Buckling; a {type(shown).__name__} has no modes.")
    if isinstance(shown, Mobility):
        return _of_self_stress(shown, stress)
    if isinstance(shown, Modes | Buckling):
        return _of_modes(shown, stress, quantity, which, at)
    if isinstance(shown, Path | Motion):
        return _of_states(shown, stress, quantity, at)
    return _of_state(shown, stress, quantity, at)


def _of_state(shown: Any, stress: Any, quantity: str | None, at: Any) -> View:
    model, x = state_of(shown, at)
    base = np.asarray(model.parameters.reference, float)
    states = [] if np.allclose(x, base, rtol=0, atol=1e-12) else [x]
    return _with_lines(model, base, states, "state", _values(model, stress, quantity, 1), loaded=x)


def _of_states(shown: Path | Motion, stress: Any, quantity: str | None, at: Any) -> View:
    model, last = state_of(shown, at)
    is_path = isinstance(shown, Path)
    x = np.asarray(shown.matrices.x if is_path else shown.x, float)
    along = np.asarray(shown.load_factor if is_path else shown.t, float)
    colours = _values(model, stress, quantity, len(x))
    base = np.asarray(model.parameters.reference, float)
    few = lines_at(model, base, list(x[thinned(len(x), LOOKED_AT)]), None if colours is None else colours.values)
    chosen = thinned(len(x), most_states(few))
    if colours is not None:
        colours = colours._replace(values=colours.values[chosen])
    kind = "path" if is_path else "motion"
    return _with_lines(model, base, list(x[chosen]), kind, colours, loaded=last, along=along[chosen])


def _of_modes(found: Modes | Buckling, stress: Any, quantity: str | None, which: Sequence[int] | None, at: Any) -> View:
    model, base = state_of(found.lin, at)
    shapes = np.asarray(found.shapes)
    count = shapes.shape[1]
    chosen = list(range(min(count, AT_MOST))) if which is None else list(which)
    if not chosen:
        raise ValueError("There is no mode to show: no motion has mass, or no load acts in any.")
    if wrong := [mode for mode in chosen if not 0 <= mode < count]:
        raise ValueError(f"There is no mode {wrong[0]}: there are {count}, numbered from 0.")
    colours = _values(model, stress, quantity, 1)
    moves = [factor_of(model, base, shape, 1.0) * shape for shape in shapes[:, chosen].T]
    drawn = lines_of_modes(model, base, moves, None if colours is None else colours.values)
    nodes = nodes_at(model, base, moves)
    options = {"choices": tuple(title_of(found, mode) for mode in chosen), "amplitude": AMPLITUDE}
    return _view(model, "modes", drawn, nodes, colours, base, largest_amplitude=LARGEST_AMPLITUDE, **options)


def _of_self_stress(found: Mobility, stress: Any) -> View:
    if stress is not None:
        raise ValueError("A Mobility has its own colours: leave `stress` out.")
    model = found.model
    base = np.asarray(model.parameters.reference, float)
    if not found.overconstraints:
        return _of_state(model, None, None, None)
    drawn = lines(model, base)
    values = np.full((found.overconstraints, len(drawn), len(PLACES)), np.nan)
    for state in range(found.overconstraints):
        part: dict[str, float] = {}
        for share in found.stresses(state):
            part[share.of] = max(part.get(share.of, 0.0), abs(share.share))
        for i, line in enumerate(drawn):
            values[state, i] = part.get(line.element, np.nan)
    colours = Colours("largest stress resultant, relative [-]", "plasma_r", 0.0, 1.0, values)
    choices = tuple(title_of_self_stress(found, state) for state in range(found.overconstraints))
    return _with_lines(model, base, [], "self-stress", colours, loaded=base, choices=choices)


def _with_lines(
    model: Model, base, states: list, kind: str, colours: Colours | None, *, loaded, **options: Any
) -> View:
    drawn = lines_at(model, base, states, None if colours is None else colours.values)
    return _view(model, kind, drawn, nodes_at(model, base, states), colours, loaded, **options)


def _view(model: Model, kind: str, drawn: Lines, nodes: Nodes, colours: Colours | None, loaded, **options: Any) -> View:
    """``colours`` has values at all places of all lines, ``loaded`` is the state in which the loads are told."""
    if colours is not None:
        colours = colours._replace(values=kept_values(drawn, colours.values))
    settings: dict[str, Any] = {
        "choices": (),
        "along": np.zeros(0),
        "amplitude": 1.0,
        "largest_amplitude": LARGEST_FACTOR,
    }
    labels = {int(index[0]): name for name, index in nodes_of(model).items()}
    return View(
        title=f"{_TITLES[kind]}: {_counted(len(drawn.parts), 'element')}, {_counted(len(nodes.names), 'node')}",
        kind=kind,
        dimension=model.labels.dimension,
        lines=drawn,
        nodes=nodes,
        colours=colours,
        marks=(*dofs(model), *loads(model, loaded)),
        supports=supports(model),
        masses=tuple(labels[int(index[0])] for index in masses(model)),
        **{**settings, **options},
    )


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


_TITLES = {
    "state": "Mechanism",
    "modes": "Modes",
    "self-stress": "Self-stress",
    "path": "Equilibrium path",
    "motion": "Motion",
}


def _values(model: Model, stress: Any, quantity: str | None, states: int) -> Colours | None:
    """Colours of all lines at all places, (rows, lines, places)."""
    if stress is None:
        if quantity is not None:
            raise ValueError("Argument `quantity` says which of the `stress` colours the elements: give that too.")
        return None
    several = list(stress) if isinstance(stress, list | tuple) else [stress]
    if len(several) != states:
        raise ValueError(
            f"Argument `stress` must be one for each of the {states} states, but there are {len(several)}."
            if states > 1
            else f"Argument `stress` must be one, that of the state which is shown, but there are {len(several)}."
        )
    found = [values_of(own, quantity) for own in several]
    label = found[0][1]
    drawn = lines(model, np.asarray(model.parameters.reference, float))
    known = {line.element: i for i, line in enumerate(drawn)}
    if missing := {name for own in several for name in own.names} - set(known):
        raise ValueError(f"The stress is not of this model, which has no element '{min(missing)}'.")
    values = np.full((len(several), len(drawn), len(PLACES)), np.nan)
    for k, (own, (rows, _)) in enumerate(zip(several, found, strict=True)):
        for name, row in zip(own.names, rows, strict=True):
            values[k, known[name]] = np.interp(PLACES, np.asarray(own.places), row)
    return Colours(label, *colours_of(values[np.isfinite(values)], label), values)
