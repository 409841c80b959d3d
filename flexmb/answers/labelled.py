"""Results as arrays of xarray and tables of pandas, with the names of their axes and with units."""

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..display import Column, Labelled, Quantities, among, unit_of
from ..errors import clean
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
    held = _held(result, names)
    shared: dict[str, Any] = {name: _variable(own, own.over) for name, own in held.coordinates.items()}
    variables, taken = {}, {*held.coordinates, *held.quantities, *held.rows}
    for name, own in held.quantities.items():
        inner = tuple(_free(f"{name}_{i}", taken) for i in range(np.ndim(own.values) - len(own.over)))
        variables[name] = _variable(own, (*own.over, *inner))
        if not isinstance(own.unit, str) and len({*np.ravel(own.unit)}) > 1:
            shared[_free(f"{name}_units", taken)] = (own.over[-np.ndim(own.unit) :], own.unit)
    attributes = {"title": type(result).__name__}
    code = getattr(result, "result", None)
    if code is not None and np.ndim(code) == 0:
        attributes["result"] = RESULTS(int(code)).name
    return xr.Dataset(variables, shared, attributes)


def to_pandas(result: Labelled, names: Sequence[str]) -> Any:
    """A result as a ``pandas.DataFrame``."""
    held = _held(result, names)
    columns: dict[str, Any] = {}
    units = {}
    shape = _rows(held)
    for name, own in {**held.coordinates, **held.quantities}.items():
        if name in held.coordinates and not set(own.over) <= set(held.rows):
            continue
        values = _along_rows(own, held.rows, shape)
        inner = values.shape[len(shape) :]
        flat = values.reshape(-1, *inner)
        for at in np.ndindex(inner):
            entry = ", ".join(_entries(held, own, at))
            column = _free(f"{name}[{entry}]" if at else name, columns)
            columns[column] = flat[(slice(None), *at)]
            if unit := own.unit if isinstance(own.unit, str) else str(np.asarray(own.unit)[at]):
                units[column] = unit
    if "result" in held.quantities:
        columns["result"] = [RESULTS(int(code)).name for code in columns["result"]]
    frame = for_files("pandas").DataFrame(columns)
    frame.attrs["units"] = units
    return frame


def _held(result: Labelled, names: Sequence[str]) -> Quantities:
    """Quantities of a result: those that are named, or all that it holds."""
    held = result.quantities_by_name()
    if held is None:
        return _of_states(result, names)
    if missing := [name for name in names if name not in held.quantities]:
        known = among(held.quantities, missing[0])
        raise KeyError(f"This {type(result).__name__} has no quantity '{clean(missing[0])}'; it has {known}")
    return held._replace(quantities={name: held.quantities[name] for name in names}) if names else held


def _of_states(result: Any, names: Sequence[str]) -> Quantities:
    """What a result with states answers in each of them: the coordinates unless questions are asked."""
    states = result.states()
    row = ROWS[states.kind]
    label, _, unit = states.label.removesuffix("]").rpartition(" [")
    along = {label.replace(" ", "_"): Column((row,), np.asarray(states.along), unit)}
    if not names:
        return Quantities((row,), along, {name: own._replace(over=(row,)) for name, own in _coordinates(result)})
    found = {}
    for text in names:
        series = _series(result, text)
        found[text] = Column((row,), series.values, series.unit)
    return Quantities((row,), along, found)


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
            f"'{clean(text)}' is no question for {name} as a whole: ask for each state, such as at=found[0]"
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


def _variable(own: Column, over: tuple[str, ...]) -> tuple[Any, ...]:
    """A variable of xarray. Programs that compute with units know no "-" and no superscripts."""
    units = {own.unit} if isinstance(own.unit, str) else {*np.ravel(own.unit).tolist()}
    attributes = {"units": "1" if (unit := units.pop()) == "-" else unit.replace("²", "^2")} if len(units) == 1 else {}
    if own.meaning:
        attributes["meaning"] = own.meaning
    return over, np.asarray(own.values), attributes


def _rows(held: Quantities) -> tuple[int, ...]:
    """Lengths of the axes that all quantities share."""
    every = [*held.coordinates.values(), *held.quantities.values()]
    return tuple(
        next(np.shape(own.values)[own.over.index(row)] for own in every if row in own.over) for row in held.rows
    )


def _along_rows(own: Column, rows: tuple[str, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Values with all rows in front; a coordinate along one of them is repeated along the others."""
    values = np.asarray(own.values)
    there = [row for row in rows if row in own.over]
    values = values.reshape(
        tuple(n if row in there else 1 for row, n in zip(rows, shape, strict=True)) + values.shape[len(there) :]
    )
    return np.broadcast_to(values, (*shape, *values.shape[len(shape) :]))


def _entries(held: Quantities, own: Column, at: tuple[int, ...]) -> Iterator[str]:
    """Names of an entry of a quantity along its other axes, where they have names, or its numbers from 0."""
    axes = (*own.over[len(held.rows) :], *(None,) * len(at))
    for axis, i in zip(axes, at, strict=False):
        named: Mapping[Any, Any] = held.coordinates
        yield str(np.asarray(named[axis].values)[i] if axis in named else i)


def _free(name: str, taken: Container[str]) -> str:
    """A name that is not taken."""
    while name in taken:
        name += "_"
    return name
