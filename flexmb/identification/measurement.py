"""Measured values of an answer of a mechanism, with their scatter."""

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..design.designs import float_array
from ..errors import printable
from ..numerical_limits import MISTAKEN_UNIT, TEN_DIGITS
from ..questions.question import asked


@dataclasses.dataclass(frozen=True, eq=False)
class Measured:
    """Measured values, and the function that computes them, from :func:`measured`.

    Attributes:
        name: Name in tables and messages.
        answer: ``answer(model, **parameters)`` returns the computed values, (m,).
        values: Measured values, (m,) [unit of the answer].
        scatter: Lower triangular factor of the covariance, (m, m), or standard deviations, (m,) [unit of the answer];
            None if they are not known.
        parameters: Names of the fitted parameters of ``answer``, such as the offset of a sensor.
        over: Place of each value on the axis of a picture, (m,).
        label: Name of this axis, with its unit.
        check: ``check(model)`` raises ValueError if the model has no value, such as for a measured mode without
            partner.
        relative: Whether ``answer`` returns the logarithms of the ratios of computed to measured values: first the real
            parts, then the imaginary parts.
        advice: What may help if a fit ends far from the values; empty if nothing is known.
        sizes: ``sizes(computed)`` returns the size of the answer at each value, (m,), such as the magnitude of a
            complex response.
    """

    name: str
    answer: Callable[..., Any]
    values: Float[np.ndarray, "m"]
    scatter: np.ndarray | None
    parameters: tuple[str, ...] = ()
    over: np.ndarray | None = None
    label: str = ""
    check: Callable[[Any], None] | None = None
    relative: bool = False
    advice: str = ""
    sizes: Callable[[np.ndarray], np.ndarray] = np.abs

    @property
    def deviation(self) -> np.ndarray | None:
        """Standard deviation of each value, (m,); None if it is not known."""
        if self.scatter is None or self.scatter.ndim == 1:
            return self.scatter
        return np.sqrt(np.sum(self.scatter**2, axis=1))


def predicted(item: Measured, model: Any, parameters: Mapping[str, Any]) -> Float[Array, "m"]:
    """Return the computed values."""
    return jnp.ravel(jnp.asarray(item.answer(model, **{name: parameters[name] for name in item.parameters})))


def in_deviations(item: Measured, differences: Any) -> Any:
    """Return differences (m, ...) in standard deviations, decorrelated; unchanged if the scatter is not known.

    The differences may be traced.
    """
    if item.scatter is None:
        return differences
    if item.scatter.ndim == 1:
        return differences / item.scatter.reshape(-1, *[1] * (differences.ndim - 1))
    if isinstance(differences, jax.Array):
        return jax.scipy.linalg.solve_triangular(jnp.asarray(item.scatter), differences, lower=True)
    from scipy.linalg import solve_triangular

    return solve_triangular(item.scatter, differences, lower=True)


def check_unit(item: Measured, computed: np.ndarray) -> None:
    """Raise ValueError if the number of values differs, or their unit cannot be the unit of the answer."""
    if computed.shape != item.values.shape:
        raise ValueError(
            f"Measurement '{item.name}' has {len(item.values)} values, but the model computes {len(computed)}."
            " Give one value for each."
        )
    if item.relative:
        _refuse_ratio(item, float(np.exp(-np.median(computed[: len(computed) // 2]))))
        return
    nonzero = (item.values != 0) & (computed != 0)
    if not np.any(nonzero):
        return
    _refuse_ratio(item, float(np.median(np.abs(item.values[nonzero] / computed[nonzero]))))


def _refuse_ratio(item: Measured, ratio: float) -> None:
    """Raise ValueError for a ratio of measured to computed values that only a wrong unit explains."""
    if not 1 / MISTAKEN_UNIT < ratio < MISTAKEN_UNIT:
        raise ValueError(
            f"Values of measurement '{item.name}' are about {ratio:.2g} times the values that the model computes at the"
            " start. Give them in SI units, or start nearer."
        )


def measured(
    answer: Callable[..., Any] | str | Sequence[str],
    values: Any,
    deviation: Any = None,
    *,
    covariance: Any = None,
    name: str | None = None,
    over: Any = None,
    label: str = "",
) -> Measured:
    """Describe measured values of an answer, with their scatter.

    Args:
        answer: A question such as "frequency 1" (see :meth:`flexmb.paths.Path.along`), a list of questions, or a
            function ``answer(model)`` that returns a number or an array. Further arguments of the function are fitted
            parameters, by name: ``lambda model, offset: reading(model) + offset`` fits the offset of a sensor too.
        values: Measured values, () or (m,) [unit of the answer].
        deviation: Standard deviation of the values, () or (m,) [unit of the answer]. Omit it if it is not known. A fit
            then estimates a common standard deviation of all values from the differences. The data must then be this
            single measurement, so that all values have the same unit.
        covariance: Covariance of correlated values, (m, m), in place of ``deviation``.
        name: Name in tables and messages; by default the text of the question or the name of the function.
        over: Place of each value on the axis of a picture, (m,).
        label: Name of this axis, such as "load [N]".

    Returns:
        Measured.

    Raises:
        ValueError: A value is not finite. A deviation is not positive. A covariance is not symmetric and positive
            definite. Shapes differ. The message names the measurement.
        KeyError: No such question.
        TypeError: The answer is neither a question nor a function.
    """
    function, given_name, parameters = _answer_of(answer)
    name = given_name if name is None else str(name)
    subject = f"Measurement '{printable(name)}'"
    array = np.atleast_1d(float_array(f"{subject}: values", values))
    if array.ndim > 1:
        raise ValueError(
            f"{subject} must have one number or a list of values, but its values have shape {array.shape}."
        )
    wrong = np.flatnonzero(~np.isfinite(array))
    if len(wrong):
        raise ValueError(
            f"{subject} has a value that is not finite, number {wrong[0] + 1} of {len(array)}. Leave it out."
        )
    scatter = _scatter(subject, len(array), deviation, covariance)
    places = None if over is None else np.atleast_1d(float_array(f"{subject}: places", over))
    if places is not None and places.shape != array.shape:
        raise ValueError(f"{subject} has {len(array)} values at {places.size} places: give one place for each value.")
    return Measured(name, function, array, scatter, parameters, places, str(label))


def _answer_of(answer: Any) -> tuple[Callable[..., Any], str, tuple[str, ...]]:
    if isinstance(answer, str):
        return asked(answer), answer, ()
    if callable(answer):
        return answer, str(getattr(answer, "__name__", "answer")), _further_arguments(answer)
    if isinstance(answer, Sequence) and answer and all(isinstance(text, str) for text in answer):
        questions = [asked(text) for text in answer]
        return lambda model: jnp.stack([question(model) for question in questions]), ", ".join(answer), ()
    raise TypeError(f"The answer of a measurement must be a question or a function, but is {printable(repr(answer))}.")


def _further_arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    try:
        parameters = list(inspect.signature(function).parameters.values())[1:]
    except (TypeError, ValueError):
        return ()
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return tuple(p.name for p in parameters if p.kind in named and p.default is p.empty)


def _scatter(subject: str, count: int, deviation: Any, covariance: Any) -> np.ndarray | None:
    if covariance is not None:
        if deviation is not None:
            raise ValueError(f"{subject} has both deviation and covariance: give one.")
        matrix = float_array(f"{subject}: covariance", covariance)
        if matrix.shape != (count, count):
            raise ValueError(
                f"{subject} has {count} values and a covariance of shape {matrix.shape}: give one of {count, count}."
            )
        if not np.allclose(matrix, matrix.T, rtol=0, atol=TEN_DIGITS * np.max(np.abs(matrix))):
            raise ValueError(f"{subject} has a covariance that is not symmetric.")
        try:
            return np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            raise ValueError(f"{subject} has a covariance that is not positive definite.") from None
    if deviation is None:
        return None
    array = float_array(f"{subject}: deviation", deviation)
    if array.shape not in ((), (1,), (count,)):
        raise ValueError(f"{subject} has {count} values and {array.size} deviations: give one, or one for each value.")
    if not np.all(np.isfinite(array) & (array > 0)):
        raise ValueError(f"{subject} has a deviation of {np.min(array):g}: deviations are positive.")
    return np.broadcast_to(array, (count,)).astype(float)


def measurements(data: Any) -> list[Measured]:
    """Return a list of measurements from data of all accepted kinds.

    Args:
        data: A Measured, several, or a dictionary of values and deviations by question.

    Raises:
        TypeError: The data have another type.
        ValueError: There are no measurements, two have the same name, or one of several has no deviation.
    """
    if isinstance(data, Measured):
        items = [data]
    elif isinstance(data, Mapping):
        items = [_of_entry(name, entry) for name, entry in data.items()]
    else:
        items = list(data)
    for item in items:
        if not isinstance(item, Measured):
            raise TypeError(f"Data must be measurements, such as fm.measured(..), but one is {printable(repr(item))}.")
    if not items:
        raise ValueError("Give at least one measurement.")
    twice = [item.name for i, item in enumerate(items) if item.name in [other.name for other in items[:i]]]
    if twice:
        raise ValueError(f"Two measurements have the name '{twice[0]}': give `name` to one of them.")
    unknown = [item.name for item in items if item.scatter is None]
    if unknown and len(items) > 1:
        raise ValueError(
            f"Measurement '{unknown[0]}' has no deviation. With several measurements each needs a deviation, which is"
            " the weight of its values."
        )
    return items


def _of_entry(name: Any, entry: Any) -> Measured:
    if isinstance(entry, Measured):
        return dataclasses.replace(entry, name=str(name))
    try:
        values, deviation = entry
    except (TypeError, ValueError):
        raise TypeError(
            f"Measurement '{printable(name)}' must be a pair of value and standard deviation, but is"
            f" {printable(repr(entry))}."
        ) from None
    return measured(name, values, deviation)
