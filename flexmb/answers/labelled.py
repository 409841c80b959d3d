"""Results as arrays of xarray and tables of pandas, with the names of their axes and with units."""

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..display import Column, Labelled, Quantities, among, unit_of
from ..errors import printable
from ..files import for_files
from ..linear.linearize import ManyStates
from ..model.by_name import FRAME_OF, TURNS
from ..questions.question import Asked
from ..results import RESULTS
from .answer_parts import is_shown

# What the states of a result follow one another by. A path may turn back, so that no two load factors need differ.
ROWS = {"path": "step", "motion": "time"}


def to_xarray(result: Labelled, names: Sequence[str]) -> Any:
    """A result as an ``xarray.Dataset``."""
    xr = for_files("xarray")
    contents = _quantities(result, names)
    shared: dict[str, Any] = {
        name: _variable(quantity, quantity.over) for name, quantity in contents.coordinates.items()
    }
    variables, used_names = {}, {*contents.coordinates, *contents.quantities, *contents.rows}
    for name, quantity in contents.quantities.items():
        inner = tuple(_free(f"{name}_{i}", used_names) for i in range(np.ndim(quantity.values) - len(quantity.over)))
        variables[name] = _variable(quantity, (*quantity.over, *inner))
        if not isinstance(quantity.unit, str) and len({*np.ravel(quantity.unit)}) > 1:
            shared[_free(f"{name}_units", used_names)] = (quantity.over[-np.ndim(quantity.unit) :], quantity.unit)
    attributes = {"title": type(result).__name__}
    code = getattr(result, "result", None)
    if code is not None and np.ndim(code) == 0:
        attributes["result"] = RESULTS(int(code)).name
    return xr.Dataset(variables, shared, attributes)


def to_pandas(result: Labelled, names: Sequence[str]) -> Any:
    """A result as a ``pandas.DataFrame``."""
    contents = _quantities(result, names)
    columns: dict[str, Any] = {}
    units = {}
    shape = _rows(contents)
    for name, quantity in {**contents.coordinates, **contents.quantities}.items():
        if name in contents.coordinates and not set(quantity.over) <= set(contents.rows):
            continue
        values = _along_rows(quantity, contents.rows, shape)
        inner = values.shape[len(shape) :]
        flat = values.reshape(-1, *inner)
        for at in np.ndindex(inner):
            entry = ", ".join(_entries(contents, quantity, at))
            column = _free(f"{name}[{entry}]" if at else name, columns)
            columns[column] = flat[(slice(None), *at)]
            if unit := quantity.unit if isinstance(quantity.unit, str) else str(np.asarray(quantity.unit)[at]):
                units[column] = unit
    if "result" in contents.quantities:
        columns["result"] = [RESULTS(int(code)).name for code in columns["result"]]
    frame = for_files("pandas").DataFrame(columns)
    frame.attrs["units"] = units
    return frame


def _quantities(result: Labelled, names: Sequence[str]) -> Quantities:
    """Quantities of a result: those that are named, or all that it holds."""
    contents = result.quantities_by_name()
    if contents is None:
        return _state_quantities(result, names)
    if missing := [name for name in names if name not in contents.quantities]:
        known = among(contents.quantities, missing[0])
        raise KeyError(f"This {type(result).__name__} has no quantity '{printable(missing[0])}'; it has {known}")
    return contents._replace(quantities={name: contents.quantities[name] for name in names}) if names else contents


def _state_quantities(result: Any, names: Sequence[str]) -> Quantities:
    """What a result with states answers in each of them: the coordinates unless questions are asked."""
    states = result.states()
    row = ROWS[states.kind]
    label, _, unit = states.label.removesuffix("]").rpartition(" [")
    along = {label.replace(" ", "_"): Column((row,), np.asarray(states.along), unit)}
    if not names:
        return Quantities((row,), along, {name: column._replace(over=(row,)) for name, column in _coordinates(result)})
    answers = {text: _series(result, text) for text in names}
    return Quantities((row,), along, {text: Column((row,), s.values, s.unit) for text, s in answers.items()})


def _series(result: Any, text: str) -> Any:
    """Answers of all states to a question."""
    try:
        return Asked(text).along(result)
    except (AttributeError, TypeError):
        # Equilibria have neither matrices nor loads.
        if isinstance(result, ManyStates):
            raise
        name = type(result).__name__
        raise KeyError(
            f"'{printable(text)}' is no question for {name} as a whole: ask for each state, such as at=found[0]"
        ) from None


def _coordinates(result: Any) -> Iterator[tuple[str, Column]]:
    """Positions and rotations of the nodes in every state, by name; rotations in space about the global axes."""
    x = np.asarray(result.x)
    for i, entry in enumerate(result.labels.x):
        node = entry.of.removesuffix(".rotation")
        if not is_shown(entry) or node.startswith(FRAME_OF):
            continue
        if entry.symbol != "l0" and unit_of(entry) != "-":
            yield f"{node}.{entry.symbol}", Column((), x[:, i], unit_of(entry))
        elif entry.symbol == "l0":
            turned = np.asarray(result.rotation(node))
            for j, axis in enumerate(TURNS):
                yield f"{node}.{axis}", Column((), turned[:, j], "rad")


def _variable(quantity: Column, over: tuple[str, ...]) -> tuple[Any, ...]:
    """A variable of xarray. Programs that compute with units know no "-" and no superscripts."""
    units = {quantity.unit} if isinstance(quantity.unit, str) else {*np.ravel(quantity.unit).tolist()}
    attributes = {"units": "1" if (unit := units.pop()) == "-" else unit.replace("²", "^2")} if len(units) == 1 else {}
    if quantity.meaning:
        attributes["meaning"] = quantity.meaning
    return over, np.asarray(quantity.values), attributes


def _rows(contents: Quantities) -> tuple[int, ...]:
    """Lengths of the axes that all quantities share."""
    every = [*contents.coordinates.values(), *contents.quantities.values()]
    return tuple(
        next(np.shape(quantity.values)[quantity.over.index(row)] for quantity in every if row in quantity.over)
        for row in contents.rows
    )


def _along_rows(quantity: Column, rows: tuple[str, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Values with all rows in front; a coordinate along one of them is repeated along the others."""
    values = np.asarray(quantity.values)
    known_rows = [row for row in rows if row in quantity.over]
    values = values.reshape(
        tuple(n if row in known_rows else 1 for row, n in zip(rows, shape, strict=True))
        + values.shape[len(known_rows) :]
    )
    return np.broadcast_to(values, (*shape, *values.shape[len(shape) :]))


def _entries(contents: Quantities, quantity: Column, at: tuple[int, ...]) -> Iterator[str]:
    """Names of an entry of a quantity along its other axes, where they have names, or its numbers from 0."""
    axes = (*quantity.over[len(contents.rows) :], *(None,) * len(at))
    for axis, i in zip(axes, at, strict=False):
        named: Mapping[Any, Any] = contents.coordinates
        yield str(np.asarray(named[axis].values)[i] if axis in named else i)


def _free(name: str, used_names: Container[str]) -> str:
    """A name that is not taken."""
    while name in used_names:
        name += "_"
    return name
