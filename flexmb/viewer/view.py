"""The viewer: a result as a page to rotate and to play."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..display import States, counted
from ..linear.stress import SectionResultants, Stress
from ..model.model import Model
from ..numerical_limits import ROUND_OFF
from ..plot.geometry import PLACES, lines, masses, nodes_of
from ..plot.marks import dofs, loads, supports
from ..plot.modes import AMPLITUDE, drawn_modes, factor_of
from ..plot.state import state_of, states_of
from ..plot.stress import colours_of, values_of
from .page import Colours
from .page import View as View
from .scene import LOOKED_AT, Lines, Nodes, drawn_values, lines_at, lines_of_modes, most_states, nodes_at, thinned

# Default number of modes in a page.
AT_MOST = 12
# Largest displacement in a mode that the page offers, as share of the extent.
LARGEST_AMPLITUDE = 0.5
# Largest factor of the displacements of a state, path or motion that the page offers.
LARGEST_FACTOR = 5.0


def view(
    shown: Any,
    stress: Stress | SectionResultants | Sequence[Stress | SectionResultants] | None = None,
    quantity: str | None = None,
    *,
    at: Any = None,
    which: Sequence[int] | None = None,
) -> View:
    """Show a result as a page to rotate, zoom and play. It opens in any browser without a network, and in notebooks.

    Modes vibrate about the state of their linearisation. A path or a motion plays, with linear interpolation between
    its states. For a single state, the displacement from the undeformed mechanism can be enlarged. Sections with known
    sides or diameter are drawn in this size. A long path or motion is thinned to about a million coordinates.

    Args:
        shown: Model, Linearization, Modes, Buckling, Path, Motion or Mobility.
        stress: Stress or section resultants that colour the elements: of the single state or the state of the modes, or
            of all states of a path or motion.
        quantity: Name of the stress or resultant, as for :func:`flexmb.plot.stress`.
        at: State of a Model: equilibrium, configuration or linearisation; by default the undeformed state.
        which: Numbers of the modes, from 0; by default the first twelve.

    Returns:
        View; ``save("file.html")`` writes the page, a notebook shows it.

    Raises:
        TypeError: ``shown``, ``at`` or ``stress`` cannot be shown.
        ValueError: ``at``, ``which``, ``stress`` or ``quantity`` does not fit.
    """
    result_states = states_of(shown, at)
    if which is not None and result_states.moves is None:
        raise ValueError(f"Argument `which` needs Modes or Buckling; a {type(shown).__name__} has no modes.")
    if result_states.shares is not None and stress is not None:
        raise ValueError(f"A {type(shown).__name__} has its own colours: leave `stress` out.")
    several = result_states.along is not None
    model, x = result_states.model, result_states.x if several else state_of(shown, at)[1]
    colours = _values(model, stress, quantity, len(x) if several else 1)
    if result_states.moves is not None:
        return _modes_view(result_states, colours, which)
    base = np.asarray(model.parameters.reference, float)
    if several:
        few = lines_at(model, base, list(x[thinned(len(x), LOOKED_AT)]), None if colours is None else colours.values)
        chosen = thinned(len(x), most_states(few))
        if colours is not None:
            colours = colours._replace(values=colours.values[chosen])
        states, options = list(x[chosen]), {"along": np.asarray(result_states.along, float)[chosen]}
    elif result_states.shares:
        colours, states, options = _share_colours(result_states), [], {"choices": tuple(result_states.titles)}
    else:
        states, options = [] if np.allclose(x, base, rtol=0, atol=ROUND_OFF) else [x], {}
    drawn = lines_at(model, base, states, None if colours is None else colours.values)
    loaded = x[-1] if several else x
    return _view(model, result_states.kind, drawn, nodes_at(model, base, states), colours, loaded, **options)


def _modes_view(result_states: States, colours: Colours | None, which: Sequence[int] | None) -> View:
    model, base, chosen = result_states.model, result_states.x, drawn_modes(result_states, which, AT_MOST, "show")
    moves = [factor_of(model, base, shape, 1.0) * shape for shape in np.asarray(result_states.moves)[:, chosen].T]
    drawn = lines_of_modes(model, base, moves, None if colours is None else colours.values)
    nodes = nodes_at(model, base, moves)
    options = {"choices": tuple(result_states.titles[mode] for mode in chosen), "amplitude": AMPLITUDE}
    return _view(model, "modes", drawn, nodes, colours, base, largest_amplitude=LARGEST_AMPLITUDE, **options)


def _share_colours(result_states: States) -> Colours:
    """Colours of all elements by their part in each state of self-stress."""
    drawn = lines(result_states.model, result_states.x)
    shares = np.array([[share.get(line.element, np.nan) for line in drawn] for share in result_states.shares or ()])
    values = np.broadcast_to(shares[:, :, None], (*shares.shape, len(PLACES)))
    return Colours("largest stress resultant, relative [-]", "plasma_r", 0.0, 1.0, values)


def _view(
    model: Model, kind: str, drawn: Lines, nodes: Nodes, colours: Colours | None, loaded: np.ndarray, **options: Any
) -> View:
    """The page; ``colours`` have values at all places of all lines, loads are drawn in the state ``loaded``."""
    if colours is not None:
        colours = colours._replace(values=drawn_values(drawn, colours.values))
    settings: dict[str, Any] = {"choices": (), "along": np.zeros(0)}
    settings |= {"amplitude": 1.0, "largest_amplitude": LARGEST_FACTOR}
    labels = {int(index[0]): name for name, index in nodes_of(model).items()}
    return View(
        title=f"{_TITLES[kind]}: {counted(len(drawn.parts), 'element')}, {counted(len(nodes.names), 'node')}",
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
            raise ValueError("Argument `quantity` needs `stress`: give both.")
        return None
    several = list(stress) if isinstance(stress, list | tuple) else [stress]
    if not several:
        raise ValueError("Argument `stress` is an empty list. Give a stress for each state, or leave it out.")
    labelled_values = [values_of(stress_result, quantity, of_states=len(several) == 1) for stress_result in several]
    label = labelled_values[0][1]
    # One stress of a path or motion has all its states.
    every = labelled_values[0][0] if labelled_values[0][0].ndim > 2 else [rows for rows, _ in labelled_values]
    several = several * len(every) if len(several) == 1 else several
    if len(several) != states:
        must = f"have one stress for each of the {states} states" if states > 1 else "be the stress of the shown state"
        raise ValueError(f"Argument `stress` must {must}, but there are {len(several)}.")
    drawn = lines(model, np.asarray(model.parameters.reference, float))
    known = {line.element: i for i, line in enumerate(drawn)}
    if missing := {name for stress_result in several for name in stress_result.names} - set(known):
        raise ValueError(f"The stress belongs to another model; this model has no element '{min(missing)}'.")
    values = np.full((len(several), len(drawn), len(PLACES)), np.nan)
    for k, (stress_result, rows) in enumerate(zip(several, every, strict=True)):
        for name, row in zip(stress_result.names, rows, strict=True):
            values[k, known[name]] = np.interp(PLACES, np.asarray(stress_result.places), row)
    return Colours(label, *colours_of(values[np.isfinite(values)], label), values)


def page(answer: Any) -> bytes:
    """Modes, path, motion or self-stress of an answer; its equilibrium or mechanism where it has no other."""
    return view(answer.shown).html().encode()
