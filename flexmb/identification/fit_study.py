"""A fit from a TOML file: model, parameters with bounds and priors, and measurements."""

import contextlib
import dataclasses
import inspect
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..design.study import answer_head, fields_of
from ..design.study_file import StudyReader, is_function
from ..design.study_parts import function_of, naming_study
from ..errors import StudyError, printable
from ..spacar.read import read_spacar
from .fit import fit
from .fitted import Fit
from .measurement import Measured
from .study_data import measurements_of

UNTRACED = "a fit needs derivatives, and the model or an answer cannot be traced by JAX"


@dataclasses.dataclass(frozen=True)
class FitStudy:
    """The contents of a file for a fit.

    Attributes:
        name: Name of the file.
        build: Function of the parameters that returns a model.
        builder: Function that ``build`` calls; it keeps the warnings of the reader of the input file.
        data: Measurements.
        values: Start values of the parameters with bounds, by name.
        bounds: Lower and upper value of these parameters, by name.
        scales: "log" or "linear" by name, if given.
        priors: Mean and standard deviation by name, if given.
        options: Other arguments of :func:`flexmb.fit`.
        level: Level of the confidence intervals [-].
    """

    name: str
    build: Callable[..., Any]
    builder: Callable[..., Any]
    data: list[Measured]
    values: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    scales: dict[str, Any]
    priors: dict[str, tuple[float, float]]
    options: dict[str, Any]
    level: float

    @property
    def warnings(self) -> list[str]:
        """Warnings that the reader of the input file has given."""
        return list(getattr(self.builder, "warnings", ()))

    def fit(self, *, throw: bool = False) -> Fit:
        """Run :func:`flexmb.fit`; a StudyError names the file."""
        with naming_study(f"{self.name}: ", UNTRACED):
            options = {"scales": self.scales, "priors": self.priors, **self.options}
            return fit(self.build, self.data, self.values, self.bounds, throw=throw, **options)


def read_fit_study(path: str | os.PathLike) -> FitStudy:
    """Read a study for a fit; a StudyError names file and key."""
    reader = StudyReader(Path(path))
    with reader.named():
        reader.check_tables("model", "data")
        if reader.data.get("choices"):
            raise StudyError("[choices]: a fit has no choices. Give one value of each as a parameter.")
        parameters = reader.parameters()
        start, bounds, scales, priors, fixed = reader.searched(parameters)
        if not start:
            raise StudyError("[parameters]: give at least one lower and upper.")
        items = measurements_of(reader.name, reader.path.parent, reader.data["data"])
        of_data = {name for item in items for name in item.parameters}
        for item in items:
            if unknown := [name for name in item.parameters if name not in parameters]:
                known = ", ".join(parameters)
                raise StudyError(f"[data] {item.name}: there is no parameter '{printable(unknown[0])}' ({known}).")
        accepted = _accepted(reader, {name: entry["value"] for name, entry in parameters.items()})
        arguments = [name for name in parameters if name not in of_data or name in accepted]
        own_fixed = tuple((name, value) for name, value in fixed.items() if name in arguments)
        own_free = tuple(name for name in start if name in arguments)
        builder = reader.builder(own_fixed, own_free)
        options = dict(reader.data.get("fit", {}))
        level = options.pop("level", 0.95)
        if not level < 1:
            raise StudyError(f"[fit] level must be below 1, but is {level:g}.")
        return FitStudy(
            reader.name,
            _with_signature(builder, own_free),
            builder,
            [_with_fixed(item, fixed) for item in items],
            start,
            bounds,
            scales,
            priors,
            options,
            level,
        )


def _accepted(reader: StudyReader, values: Mapping[str, float]) -> set[str]:
    """Return the names of the parameters of the model of a study."""
    text, folder = reader.data["model"], reader.path.parent
    if is_function(text):
        with contextlib.suppress(TypeError, ValueError):
            return set(inspect.signature(function_of("model", folder, text)).parameters)
        return set()
    # For a missing file, `reader.builder` raises.
    return set(read_spacar(folder / text, numbers=values).parameters) if (folder / text).is_file() else set()


def _with_signature(builder: Callable[..., Any], names: tuple[str, ...]) -> Callable[..., Any]:
    """Return the builder with these names in its signature, which ``fit`` reads."""

    def build(**parameters: Any) -> Any:
        return builder(**parameters)

    keywords = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in names]
    vars(build)["__signature__"] = inspect.Signature(keywords)
    return build


def _with_fixed(item: Measured, fixed: Mapping[str, float]) -> Measured:
    """Return a measurement with the values of its fixed parameters."""
    known = {name: fixed[name] for name in item.parameters if name in fixed}
    if not known:
        return item

    def answer(model: Any, **parameters: Any) -> Any:
        return item.answer(model, **known, **parameters)

    remaining = tuple(name for name in item.parameters if name not in known)
    return dataclasses.replace(item, answer=answer, parameters=remaining)


def fit_answer(study: FitStudy, found: Fit, version: str) -> dict[str, Any]:
    """Return a fit as data for JSON."""
    return {
        **answer_head(study, version, found.result),
        **fields_of(found, "reason parameters start deviation"),
        "level": study.level,
        "intervals": {name: list(found.interval(name, study.level)) for name in found.labels},
        "labels": list(found.labels),
        **fields_of(found, "covariance correlation chi_squared freedom probability noise"),
        "undetermined": [
            {
                "parameters": list(combination.names),
                "change": combination.change,
                "determined": list(combination.determined),
                "deviation": combination.deviation,
            }
            for combination in found.undetermined
        ],
        "active": list(found.active),
        "minima": [{"parameters": values, "chi_squared": cost} for values, cost in found.minima],
        "evaluations": found.evaluations,
        "data": {
            item.name: {
                "measured": item.values,
                "deviation": item.deviation,
                "computed": found.computed[item.name],
                "residuals": found.residuals[item.name],
            }
            for item in found.data
        },
    }


def fit_arrays(found: Fit) -> dict[str, np.ndarray]:
    """Return the arrays of a fit by name; StudyError if two arrays have the same name."""
    named = [*found.parameters.items(), ("covariance", found.covariance)]
    named += [(f"deviation_{name}", value) for name, value in found.deviation.items()]
    for item in found.data:
        named += [(f"measured_{item.name}", item.values), (f"computed_{item.name}", found.computed[item.name])]
    arrays = {}
    for name, value in named:
        if name in arrays or name == "about":
            raise StudyError(f"'{printable(name)}' is a name that --save uses for another array: choose another name.")
        arrays[name] = np.asarray(value)
    return arrays
