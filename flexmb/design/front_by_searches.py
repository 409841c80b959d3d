"""Pareto front of two criteria by searches with derivatives, such as a nominal value against a percentile."""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

import numpy as np

from ..arguments import ByName, check_whole, checked
from ..errors import AnalysisError, printable, warn
from ..results import RESULTS
from .designs import Designs
from .evaluate import Answers, Build
from .swept import Front, Sweep
from .tune import tune
from .tuned import Tuned


@checked
def robust_front(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    bounds: ByName,
    *,
    minimize: str,
    against: str,
    points: Annotated[int, partial(check_whole, least=2)] = 8,
    limits: Mapping[str, Any] | None = None,
    **options: Any,
) -> Front:
    """Compute the Pareto front of two criteria by searches with derivatives.

    Each end of the front minimises one criterion. Each point between the ends minimises the first criterion with an
    upper limit on the second criterion. These limits are evenly spaced.

    Args:
        build: See :func:`flexmb.tune`.
        answers: See :func:`flexmb.tune`.
        dimensions: Dimensions at the start, by name [SI].
        bounds: Lower and upper value by name [SI].
        minimize: First criterion: name of an answer, or a statistic such as "percentile 95 mass".
        against: Second criterion, minimised too. To maximise an answer, add an answer that returns its negative.
        points: Number of points, including both ends.
        limits: Limits of other answers and statistics.
        options: Other arguments of :func:`flexmb.tune`, such as ``scatter``, ``samples`` and ``starts``.

    Returns:
        Front. Its sweep has all answers and statistics of the successful searches.

    Raises:
        ValueError: The criteria are equal, a criterion has a limit, or ``choices`` are given. Also the errors of
            :func:`flexmb.tune`.
        AnalysisError: The search for an end of the front fails.

    Warns:
        FlexmbWarning: Searches for points between the ends fail. The front leaves these points out.

    Source:
        Epsilon-constraint method: Haimes, Lasdon, Wismer 1971.
    """
    if options.get("choices"):
        raise ValueError("A front has no `choices`: make one for each combination.")
    if minimize == against:
        raise ValueError(f"The front needs two different criteria, not '{printable(minimize)}' twice.")
    for name in (minimize, against):
        if name in (limits or {}):
            raise ValueError(f"'{printable(name)}' is a criterion of the front and has a limit. Leave one of them out.")
    all_limits: dict[str, Any] = {minimize: (None, np.inf), against: (None, np.inf), **(limits or {})}

    def searched(criterion: str, start: Mapping[str, Any], **more: Any) -> Tuned:
        search_limits = {**all_limits, **more}
        return tune(build, answers, start, bounds, minimize=criterion, limits=search_limits, throw=False, **options)

    ends = [searched(criterion, dimensions) for criterion in (minimize, against)]
    for criterion, end in zip((minimize, against), ends, strict=True):
        if end.result is not RESULTS.successful:
            raise AnalysisError(end.result.name, f"The least '{criterion}' was not found. {end.reason}")
    optima, missed = [ends[0]], 0
    for level in np.linspace(ends[0].answers[against], ends[1].answers[against], points)[1:-1]:
        optimum = searched(minimize, optima[-1].dimensions, **{against: (None, float(level))})
        if optimum.result is RESULTS.successful:
            optima.append(optimum)
        else:
            missed += 1
    if missed:
        warn(f"Of {points} points of the front {missed} were not found and are left out. Give more `starts`.")
    optima.append(ends[1])
    designs = Designs(
        {name: np.stack([np.asarray(optimum.dimensions[name]) for optimum in optima]) for name in dimensions}
    )
    values = {name: np.stack([np.asarray(optimum.answers[name]) for optimum in optima]) for name in optima[0].answers}
    results = Sweep(designs, values, np.zeros(len(optima), np.int32), {})
    return results.pareto(minimize=[minimize, against])
