"""Statistics of the answers of a design with scatter, and their derivatives by the nominal dimensions.

All designs of a search use the same random numbers. The statistics therefore depend on the dimensions alone.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..errors import printable
from ..model.model import Model
from ..results import worst_of
from .evaluate import Build, Layout, flat_function, layout_of
from .problem import limits_of
from .scatter import Scatter, even_scores, terms_and_factors

YIELD = "yield"
# Made mechanisms of each design of a search, by default.
SAMPLES = 128
HOW_TO_ASK = "Ask for a statistic, such as 'mean mass', 'percentile 95 mass' or 'yield'"
WORDS = r"(mean|deviation|percentile (\d+(?:\.\d+)?)) (.+)"


class Statistic(NamedTuple):
    """A statistic of an answer.

    Attributes:
        kind: "mean", "deviation" or "percentile".
        percent: Percentage of a percentile; otherwise 0.
        answer: Name of the answer.
    """

    kind: str
    percent: float
    answer: str


def statistic_of(text: str, answers: Mapping[str, Any]) -> Statistic | None:
    """Return the statistic with a name such as "percentile 95 stress"; None for any other text."""
    match = re.fullmatch(WORDS, text)
    if not match or match[3] not in answers:
        return None
    percent = float(match[2] or 0)
    if match[2] and not 0 < percent < 100:
        raise ValueError(f"'{printable(text)}': a percentile is between 0 and 100.")
    return Statistic(match[1].split()[0], percent, match[3])


def samples_for(percent: float) -> int:
    """Return the least number of samples of which one is expected beyond a percentile."""
    return math.ceil((1 - 1e-9) / min(percent / 100, 1 - percent / 100))


@dataclasses.dataclass(frozen=True)
class SampledDesign:
    """The scatter of a search and the wanted statistics.

    Attributes:
        scatter: Joint distribution of the parameters.
        count: Number of made mechanisms of each design.
        seed: Seed of the random numbers.
        statistics: Statistics by name, such as "mean mass".
        acceptable: Lower and upper limit by name of an answer, for the yield.
    """

    scatter: Scatter
    count: int
    seed: int
    statistics: dict[str, Statistic]
    acceptable: dict[str, Any]

    def further(self, layout: Layout) -> dict[str, np.ndarray]:
        """Return the nominal values of parameters beside the dimensions."""
        return {name: value for name, value in self.scatter.nominal.items() if name not in layout.names}

    def made(self, layout: Layout) -> tuple[Layout, Callable[[Any], Any]]:
        """Return the layout of all parameters, and a function from dimensions (n,) to made mechanisms as rows.

        The first row is the nominal design.
        """
        further = self.further(layout)
        full_layout = Layout(
            (*layout.names, *further), (*layout.shapes, *(np.shape(value) for value in further.values()))
        )
        further_values = layout_of(further).join(further)
        added, factor = terms_and_factors(self.scatter, even_scores(self.count, full_layout, self.seed), full_layout)
        added = np.concatenate([np.zeros((1, added.shape[1])), added])
        factor = np.concatenate([np.ones((1, factor.shape[1])), factor])

        def rows(flat: Any) -> Any:
            join: Any = np.concatenate if isinstance(flat, np.ndarray) else jnp.concatenate
            return join([flat, further_values]) * factor + added

        return full_layout, rows

    def function(
        self,
        build: Build,
        functions: Mapping[str, Callable[[Any], Any]],
        layout: Layout,
        models: list[Model],
    ) -> tuple[Callable[[Any], Any], Layout]:
        """Return the function from dimensions to nominal answers and statistics, and the layout of its values."""
        full_layout, to_rows = self.made(layout)
        inner, of_answers = flat_function(build, functions, full_layout, models)
        shapes = dict(zip(of_answers.names, of_answers.shapes, strict=True))
        acceptable = {name: limits_of(name, shapes[name], pair) for name, pair in self.acceptable.items()}

        def function(flat: Float[Array, "n"]):
            rows, codes = jax.lax.map(inner, to_rows(flat))
            values = of_answers.split(rows[1:].T)
            parts = [rows[0]]
            parts += [
                jnp.ravel(statistic_value(statistic, values[statistic.answer]))
                for statistic in self.statistics.values()
            ]
            if acceptable:
                parts.append(smooth_yield(values, acceptable)[None])
            return jnp.concatenate(parts), worst_of([codes])

        names = (*of_answers.names, *self.statistics, *([YIELD] if acceptable else []))
        sizes = (*of_answers.shapes, *(shapes[statistic.answer] for statistic in self.statistics.values()))
        return function, Layout(names, (*sizes, *([()] if acceptable else [])))


def wanted_statistics(asked: Sequence[Any], answers: Mapping[str, Any]) -> tuple[dict[str, Statistic], bool]:
    """Return the statistics among the ``asked`` names, and whether the yield is asked for."""
    statistics = {
        text: statistic
        for text in asked
        if isinstance(text, str) and text not in answers and (statistic := statistic_of(text, answers))
    }
    return statistics, YIELD in asked and YIELD not in answers


def sampled_of(
    scatter: Scatter | None,
    samples: int,
    seed: int,
    asked: Sequence[str],
    answers: Mapping[str, Any],
    dimensions: Sequence[str],
    acceptable: Mapping[str, Any] | None,
) -> SampledDesign | None:
    """Return the scatter of a search with the statistics among the ``asked`` names; None without scatter."""
    statistics, wants_yield = wanted_statistics(asked, answers)
    if scatter is None:
        if statistics or wants_yield or acceptable:
            subject = next(iter(statistics), YIELD if wants_yield else "acceptable")
            raise ValueError(
                f"'{printable(subject)}' is a statistic of made mechanisms. Give `scatter` from fm.scatter(..)."
            )
        if samples != SAMPLES:
            raise ValueError(
                "Argument `samples` is the number of made mechanisms of each design, but nothing is asked about made"
                f" mechanisms. {HOW_TO_ASK}, with `scatter`; or leave `samples` out."
            )
        return None
    if not isinstance(scatter, Scatter):
        raise TypeError(f"Argument `scatter` must be a result of fm.scatter(..), but is {printable(repr(scatter))}.")
    if wants_yield and not acceptable:
        raise ValueError("The yield needs `acceptable`: limits of answers by name.")
    if acceptable and YIELD in answers:
        raise ValueError(f"Answer '{YIELD}' must have another name. The yield uses this one.")
    for name in acceptable or {}:
        if name not in answers:
            raise ValueError(f"Acceptable '{printable(name)}': there is no such answer ({', '.join(answers)}).")
    for text, statistic in statistics.items():
        if statistic.kind == "percentile" and samples < (least := samples_for(statistic.percent)):
            raise ValueError(f"'{printable(text)}' lies beyond {samples} samples. Give `samples`, {least} or more.")
    for name in scatter.spreads:
        if name not in dimensions and name not in scatter.nominal:
            raise ValueError(f"Scatter of '{printable(name)}' has no nominal value: give it in `nominal`.")
    nominal = all(isinstance(name, str) and name in answers for name in asked)
    if nominal and not (statistics or wants_yield or acceptable):
        raise ValueError(
            "Argument `scatter` has no effect: the names of answers are nominal values, and nothing is asked about made"
            f" mechanisms. {HOW_TO_ASK}, or leave `scatter` out."
        )
    return SampledDesign(scatter, samples, seed, statistics, dict(acceptable or {}))


def statistic_value(asked: Statistic, values: Float[Array, "... samples"]) -> Float[Array, "..."]:
    """Return a statistic over the last axis.

    Source:
        Percentiles: weighted means of order statistics, Harrell, Davis 1982. They stay continuous when two samples
        change their order.
    """
    if asked.kind == "mean":
        return jnp.mean(values, axis=-1)
    if asked.kind == "deviation":
        return _deviation(values)
    from scipy.stats import beta

    count, share = values.shape[-1], asked.percent / 100
    places = beta.cdf(np.arange(count + 1) / count, (count + 1) * share, (count + 1) * (1 - share))
    return jnp.sort(values, axis=-1) @ np.diff(places)


def _deviation(values: Array) -> Array:
    variance = jnp.var(values, axis=-1, ddof=1)
    positive = variance > 0
    return jnp.where(positive, jnp.sqrt(jnp.where(positive, variance, 1.0)), 0.0)


def smooth_yield(values: Mapping[str, Array], acceptable: Mapping[str, tuple[Any, Any]]) -> Float[Array, ""]:
    """Return the share of samples within all limits, with each limit blurred by a normal distribution.

    Source:
        Kernel estimate of a distribution function: Azzalini 1981. The width of the kernel is the standard deviation of
        the answer over the cube root of the number of samples.
    """
    within_limits: Any = 1.0
    for name, (lower, upper) in acceptable.items():
        samples = values[name]
        count = samples.shape[-1]
        spread = _deviation(samples)[..., None]
        scatters = spread > 0
        width = jnp.where(scatters, spread * count ** (-1 / 3), 1.0)
        for limit, sign in ((lower, 1.0), (upper, -1.0)):
            if limit is not None:
                edge = np.broadcast_to(np.asarray(limit, float), samples.shape[:-1])[..., None]
                # A limit at infinity has no slope.
                finite = np.isfinite(edge)
                margin = sign * (samples - np.where(finite, edge, 0.0))
                step = jnp.where(finite, margin >= 0, sign * edge < 0).astype(float)
                # An answer without scatter is inside or outside.
                inside = jnp.where(scatters & finite, jax.scipy.special.ndtr(margin / width), step)
                within_limits = within_limits * jnp.prod(inside.reshape(-1, count), axis=0)
    return jnp.mean(within_limits)
