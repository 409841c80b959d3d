"""Sensitivities of answers to dimensions: first and second derivatives."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, Literal

import jax
import numpy as np
from jaxtyping import Array, Float

from ..arguments import ByName, check_choice, checked
from ..compilation.by_meaning import jit
from ..compilation.compile import unguarded
from ..display import Result, Summary, counted, largest, short
from ..errors import AnalysisError, warn
from ..files import for_files
from ..results import NO_DERIVATIVE, RESULTS, check
from .designs import float_array
from .evaluate import (
    REVERSE_COST,
    Answers,
    Build,
    build_once,
    check_dimensions,
    flat_function,
    layout_of,
    named_answers,
)


@dataclasses.dataclass(frozen=True, repr=False)
class Sensitivities(Result):
    """First derivatives of answers by dimensions, and second derivatives if wanted.

    Attributes:
        answers: Name of each of the m answers, such as "stiffness[1]".
        dimensions: Name of each of the n dimensions.
        values: Answers, (m,) [their units].
        point: Dimensions, (n,) [SI].
        slopes: d answer/d dimension, (m, n) [their units].
        table: d ln(answer)/d ln(dimension), (m, n) [-]: percent of the answer for one percent of the dimension; not
            finite if the answer is zero.
        curvatures: d2 answer/d dimension d dimension, (m, n, n) [their units], or None.
        mode: "forward" or "reverse".
        result: Code of RESULTS.
    """

    answers: tuple[str, ...]
    dimensions: tuple[str, ...]
    values: np.ndarray
    point: np.ndarray
    slopes: np.ndarray
    table: np.ndarray
    curvatures: np.ndarray | None
    mode: str
    result: RESULTS

    def to_pandas(self):
        """Return the table as a ``pandas.DataFrame`` with a row for each answer and a column for each dimension.

        Raises:
            ImportError: pandas is not installed.
        """
        return for_files("pandas").DataFrame(self.table, index=list(self.answers), columns=list(self.dimensions))

    def summary(self) -> Summary:
        """Return each answer with its change for one percent of the most effective dimension."""
        rows = {}
        for name, value, row in zip(self.answers, self.values, self.table, strict=True):
            rows[name] = f"{short(value)}, {largest(row, self.dimensions, '%', 'per % of')}"
        count, many = np.shape(self.table)
        title = f"Sensitivities of {counted(count, 'answer')} to {counted(many, 'dimension')}: {self.result.name}"
        return Summary(title, rows, "sensitivities")

    def __str__(self) -> str:
        width = max(12, *(len(name) + 2 for name in self.dimensions))
        first = max(len(name) for name in (*self.answers, "d ln/d ln"))
        lines = [f"{'d ln/d ln':<{first}}{'value':>14}" + "".join(f"{name:>{width}}" for name in self.dimensions)]
        for name, value, row in zip(self.answers, self.values, self.table, strict=True):
            lines.append(f"{name:<{first}}{value:>14.6g}" + "".join(f"{entry:>{width}.4f}" for entry in row))
        return "\n".join(lines)


@checked
@unguarded
def sensitivities(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    *,
    second_order: bool = False,
    mode: Literal["forward", "reverse"] | None = None,
    throw: bool = True,
) -> Sensitivities:
    """Compute derivatives of answers by the dimensions of a mechanism.

    Args:
        build: Function of the dimensions, by name, that returns a model, or a tuple of models for answers that need
            several mechanisms. If no degrees of freedom are named, flexmb chooses them once, at these dimensions.
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one answer, several
            answers, or a dictionary by name.
        dimensions: Numbers or arrays by name, n numbers in all [SI].
        second_order: Whether to compute second derivatives.
        mode: Mode of differentiation; by default the cheaper one.
        throw: Raise if an analysis fails; otherwise ``result`` contains the code.

    Returns:
        Sensitivities with ``table`` (m, n) [-] and ``slopes`` (m, n).

    Raises:
        ValueError: ``build`` does not accept a dimension, or needs an argument that is no dimension.
        AnalysisError: An analysis fails, or the state is critical and has no derivative.

    Warns:
        FlexmbWarning: The equilibrium is unstable.

    Source:
        Implicit differentiation of the equilibrium and of the eigenvalues (:func:`flexmb.equilibrium`,
        :func:`flexmb.frequencies`); d ln a/d ln p = (p/a) da/dp.
    """
    return derived(build, answers, dimensions, second_order, mode, throw)[0]


def derived(
    build: Build, answers: Answers, dimensions: Mapping[str, Any], second_order: bool, mode: str | None, throw: bool
) -> tuple[Sensitivities, Callable[[np.ndarray], Any]]:
    """Return sensitivities, and the compiled function from (n,) to values, slopes, curvatures and code."""
    dimensions = {name: float_array(f"Dimension '{name}'", v) for name, v in dimensions.items()}
    functions, layout = named_answers(answers), layout_of(dimensions)
    check_dimensions(build, layout.names)
    function, rows = flat_function(build, functions, layout, build_once(build, dimensions))
    point, m = layout.join(dimensions), sum(rows.sizes)
    if mode is None:
        mode = "forward" if len(point) <= REVERSE_COST * m else "reverse"
    check_choice("mode", mode, ("forward", "reverse"))
    derivatives = jit(_derivatives(function, mode, second_order))
    values, slopes, curvatures, code = derivatives(point)
    result = RESULTS(int(code))
    subject = f"This affects the sensitivities of {', '.join(functions)}."
    derivatives_of = [np.reshape(part, (m, -1)) for part in (slopes, curvatures) if part is not None]
    finite = np.all(np.isfinite(np.concatenate(derivatives_of, axis=1)), axis=1)
    if result in (RESULTS.successful, RESULTS.unstable_state) and not np.all(finite):
        result = RESULTS.not_finite
        subject += f" '{rows.labels[int(np.argmin(finite))]}' has no finite derivative at these dimensions."
    if throw and result in NO_DERIVATIVE:
        # `check` below accepts this code, which has values but no derivatives.
        raise AnalysisError(result.name, result.message)
    check(int(result), throw, subject)
    if result is RESULTS.unstable_state:
        warn(f"{result.message} {subject}")
    values, slopes = np.asarray(values), np.asarray(slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        table = slopes * point / values[:, None]
    second = np.asarray(curvatures) if second_order else None
    labels = tuple(rows.labels), tuple(layout.labels)
    return Sensitivities(*labels, values, point, slopes, table, second, mode, result), derivatives


def _derivatives(function: Callable[..., Any], mode: str, second_order: bool):
    differentiate: Any = jax.jacfwd if mode == "forward" else jax.jacrev

    def twice(flat: Float[Array, "n"]):
        value, code = function(flat)
        return value, (value, code)

    def once(flat: Float[Array, "n"]):
        slopes, (value, code) = differentiate(twice, has_aux=True)(flat)
        return slopes, (value, slopes, code)

    def everything(flat: Float[Array, "n"]):
        if not second_order:
            _, (value, slopes, code) = once(flat)
            return value, slopes, None, code
        curvatures, (value, slopes, code) = jax.jacfwd(once, has_aux=True)(flat)
        return value, slopes, curvatures, code

    return everything
