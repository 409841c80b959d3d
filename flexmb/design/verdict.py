"""The verdict on a mechanism over its stroke: its properties and its first limit, on one page."""

import contextlib
import dataclasses
import itertools
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..arguments import Count, check_number, check_numbers, checked, short_repr
from ..arguments import numbers as as_numbers
from ..build.restrict import with_turn
from ..checks.mobility import mobility
from ..compilation.compile import unguarded
from ..errors import heard
from ..model.model import Model, as_determined, as_known_model
from ..numerical_limits import LIMIT_ENDS, LIMIT_EXTREME, LIMIT_PLACE
from ..progress import reporting
from .designs import float_array
from .evaluate import Build, check_dimensions
from .judgement import Limit, Verdict, most
from .over_stroke import StrokeQuestions, unit_of_curve
from .sensitivities import Sensitivities, sensitivities
from .stroke import driven

# Default limits: strength and fatigue limit of the material, and the constant loads.
USUAL = {"yield": 1.0, "fatigue": 1.0, "buckling": 1.0}
# Curves with a lower limit; all others have an upper one.
LEAST = ("buckling", "frequency", "stiffness")


@checked
@unguarded
def verdict(
    model: Model | Build,
    stroke: float | tuple[float, float] | Mapping[str, Any],
    *,
    dimensions: Mapping[str, Any] | None = None,
    limits: Mapping[str, Any] | None = None,
    node: str | None = None,
    steps: Count = 4,
    count: Count = 3,
    progress: Callable[[int, int], None] | bool | None = None,
) -> Verdict:
    """Assess a mechanism over its stroke: its properties, its first limit, and the dimensions that move this limit.

    A drive prescribes the coordinate at each stroke, under the constant loads. For frequencies and buckling, the drive
    is replaced by its force, so that the coordinate is free.

    Args:
        model: Mechanism; or a function of ``dimensions`` that returns a mechanism.
        stroke: Largest stroke to both sides, or its two ends, which enclose zero, [m or rad]. Give it with the name of
            the driven coordinate if the model does not determine this coordinate: {"top.x": 5e-3}, or in space
            {"top.rx": 0.1} for the angle about a global axis. No name is needed for a coordinate that is prescribed
            with an increment, or if the model has only one input or only one degree of freedom. A stroke counts from
            the constant value of a prescribed coordinate, otherwise from the undeformed mechanism.
        dimensions: Numbers by name, as for ``flexmb.sensitivities`` [SI].
        limits: Limits by the name of a curve, in its unit. A number is the least value of "frequency 1", "stiffness y"
            and "buckling", and the largest size of any other curve. Or (lower, upper), with None for no limit. Default
            limits of 1 for "yield", "fatigue" and "buckling" apply too. A limit may also name another quantity of a
            state, such as "stress leaf".
        node: Node of support stiffness and parasitic motion; by default the driven node.
        steps: Number of strokes to each side. If a stroke has no equilibrium, this side ends at the largest stroke with
            an equilibrium, found to a hundredth of the stroke.
        count: Largest number of frequencies.
        progress: True for a bar, or a function called with the number of strokes done and of all. None: a bar in a
            terminal.

    Returns:
        Verdict with stroke (states,) [m or rad] and curves by name, (states,) [their units].

    Warns:
        BeamTheoryWarning: The stress leaves out normal stress of restrained warping, as for :func:`flexmb.stress`.

    Raises:
        ModelError: The driven coordinate does not exist, is not named, or cannot move.
        ValueError: A stroke or a limit is wrong, or a limit has no curve.
        AnalysisError: There is no equilibrium at zero stroke.

    Source:
        Composition of linearize, stress, compliance, frequencies and sensitivities; buckling of THEORY.md 7, eq. (7.4)
        with the constant loads as increment. Limits are checked at the strokes, half-way between them and at extremes,
        and located by Brent's method. Fatigue assumes a motion that reverses fully between a stroke and its opposite.
    """
    build = None
    if callable(model) and not isinstance(model, Model):
        if not dimensions:
            raise TypeError("fm.verdict of a function needs dimensions={'t': 0.5e-3, ..}, as fm.sensitivities does.")
        dimensions = {name: float_array(f"Dimension '{name}'", v) for name, v in dimensions.items()}
        check_dimensions(model, tuple(dimensions))
        build, model = model, model(**dimensions)
    elif dimensions is not None:
        raise TypeError(
            "Argument `dimensions` needs a function of the dimensions. Give the function instead of the model."
        )
    if {"frequency", "frequency 1"}.issubset(limits or {}):
        raise ValueError("Limits of 'frequency' and 'frequency 1' are the same. Give one of them.")
    model = as_determined(as_known_model(model, "verdict"), "verdict")
    name, (low, high) = _ends(stroke)
    model = with_turn(model, str(name))
    asked = StrokeQuestions(model, driven(model, name), node, count)
    sides = [np.linspace(0, end, steps + 1)[1:].tolist() for end in (low, high) if end]
    total = 1 + sum(map(len, sides))
    with reporting(sys.stderr.isatty() if progress is None else progress, "strokes", total) as report:
        if report is not None:
            report(0, total)
        asked.look(0.0, throw=True)
        for extra in limits or {}:
            if extra not in (*asked.values[0.0], "frequency"):
                with contextlib.suppress(KeyError, ValueError):
                    asked.ask_too(extra)
        for side in sides:
            for last, s in itertools.pairwise([0.0, *side]):
                if report is not None:
                    report(len(asked.values), total)
                if not asked.look(s):
                    asked.approach(last, s, LIMIT_ENDS * abs(side[-1]))
                    break
        if report is not None:
            report(total, total)
        asked.say_what_is_missing()
        curves, strokes = asked.curves(), np.array(sorted(asked.values))
        states = asked.places(), asked.stable("held"), asked.stable("free")
        x = np.array([asked.at[s].held.x for s in strokes.tolist()])
        ordered_limits = _limits(asked, strokes, curves, limits or {})
        table = None if build is None else _sensitivities(asked, build, dimensions or {}, ordered_limits, strokes)
        with heard():
            redundant = mobility(model)
    units = {name: unit_of_curve(name, asked.unit) for name in curves}
    head = asked.driven.name, asked.unit, asked.node
    return Verdict(*head, strokes, curves, units, ordered_limits, redundant, table, asked.unanswered, *states, x, model)


def _ends(stroke: Any) -> tuple[str | None, tuple[float, float]]:
    """Name of the driven coordinate, or None, and the two ends of its stroke."""
    name = None
    if isinstance(stroke, Mapping):
        if len(stroke) != 1:
            raise ValueError(
                f"Argument `stroke` must name one coordinate, not {len(stroke)}: {short_repr(dict(stroke))}."
            )
        ((name, stroke),) = stroke.items()
    if np.ndim(stroke) == 1 and len(stroke) == 2:
        low, high = stroke
        check_numbers("Argument `stroke`", (low, high))
        if not low <= 0 <= high or low == high:
            raise ValueError(f"Argument `stroke` must have ends about zero, but has {short_repr(stroke)}.")
        return name, (float(low), float(high))
    check_number("stroke", stroke, above=0)
    return name, (-float(stroke), float(stroke))


def _limits(
    asked: StrokeQuestions, strokes: np.ndarray, curves: dict[str, np.ndarray], user_limits: Mapping[str, Any]
) -> tuple[Limit, ...]:
    """Limits and where they are reached, the first one first."""
    values = {name: value for name, value in USUAL.items() if np.any(np.isfinite(curves.get(name, np.nan)))}
    for name, value in user_limits.items():
        name = "frequency 1" if name == "frequency" else name
        if name not in curves:
            why = "".join(f" {question} has no answer: {why}." for question, why in asked.unanswered.items())
            raise ValueError(
                f"Limit of {short_repr(name)}: there is no such curve. There are: {', '.join(curves)}.{why}"
            )
        values[name] = value
    limits = []
    for name, value in values.items():
        limit = _limit(name, value)
        used = np.array([limit.share(v) for v in curves[name].tolist()])
        limits.append(dataclasses.replace(limit, used=used, stroke=_stroke_of_limit(asked, limit, strokes)))
    return tuple(sorted(limits, key=_order))


def _order(limit: Limit) -> tuple[float, float]:
    """Order of limits: by the stroke at which they are reached, then by their largest use."""
    return np.inf if limit.stroke is None else abs(limit.stroke), -float(np.nanmax(limit.used))


def _stroke_of_limit(asked: StrokeQuestions, limit: Limit, strokes: np.ndarray) -> float | None:
    """The stroke nearest to zero at which a limit is reached."""

    def excess(stroke: float) -> float:
        known = asked.look(stroke) and limit.name in asked.values[stroke]
        share = limit.share(asked.values[stroke][limit.name]) if known else np.nan
        return -1.0 if np.isnan(share) else float(np.clip(share - 1, -1.0, 1.0))

    if excess(0.0) >= 0:
        return 0.0
    sides = strokes[strokes >= 0], strokes[strokes <= 0][::-1]
    reached = [place for side in sides if (place := _first_reached(excess, side.tolist())) is not None]
    # Of two equal strokes take the positive one.
    return min(reached, key=lambda s: abs(s) * (1 + 10 * LIMIT_PLACE * (s < 0)), default=None)


def _first_reached(excess: Callable[[float], float], side: list[float]) -> float | None:
    """The first stroke along one side at which a limit is reached, or None.

    Half-way points between strokes count too. The extreme near a stroke is found if more than half of the limit is used
    there, and more than beside it.
    """
    every = side[:1]
    for a, b in itertools.pairwise(side):
        every += [(a + b) / 2, b]
    for i in range(1, len(every)):
        a, b = every[i - 1 : i + 1]
        c = every[i + 1] if i + 1 < len(every) else b
        beside = excess(a), excess(c)
        if c != b and -0.5 < excess(b) < 0 and min(beside) < excess(b) >= max(beside):
            options = {"xatol": LIMIT_EXTREME * abs(c - a)}
            extreme: Any = minimize_scalar(
                lambda s: -excess(s), bounds=sorted((a, c)), method="bounded", options=options
            )
            b = float(extreme.x)
        if excess(b) >= 0:
            reached: Any = brentq(excess, a, b, xtol=LIMIT_PLACE * abs(b - a))
            return float(reached)
    return None


def _sensitivities(
    asked: StrokeQuestions, build: Build, dimensions: Mapping[str, Any], limits: tuple[Limit, ...], strokes: np.ndarray
) -> Sensitivities:
    """Sensitivities of all curves where the first limit is reached or most used, or else at the largest stroke."""
    stroke = float(max(strokes, key=abs))
    if limits:
        first = limits[0]
        stroke = float(strokes[most(first.used)]) if first.stroke is None else first.stroke
    names = list(asked.values[0.0])
    table = sensitivities(build, {"curves": lambda m: asked.numbers_at(m, stroke, names)}, dimensions, throw=False)
    return dataclasses.replace(table, answers=tuple(names))


def _limit(name: str, value: Any) -> Limit:
    """A limit from one number, lower or upper by the nature of the curve, or from both ends."""
    pair: tuple[Any, ...] = (value, None) if name.startswith(LEAST) else (None, value)
    if np.ndim(value) == 1 and len(value) == 2:
        pair = tuple(value)
    for end in pair:
        if end is not None and not (as_numbers(end) is not None and np.ndim(end) == 0 and 0 < end < np.inf):
            raise ValueError(
                f"Limit of '{name}' must be a positive number or a pair (lower, upper), but is {short_repr(value)}."
            )
    lower, upper = (None if end is None else float(end) for end in pair)
    if lower is None and upper is None:
        raise ValueError(f"Limit of '{name}' is (None, None). Leave it out.")
    if lower is not None and upper is not None and not lower < upper:
        raise ValueError(f"Limits of '{name}' are empty: lower {lower:g} is not below upper {upper:g}.")
    return Limit(name, lower, upper, np.zeros(0), None)
