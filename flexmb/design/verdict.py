"""Is it good enough: what a mechanism does over its stroke, and what limits that first, on one page."""

import contextlib
import dataclasses
import itertools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..arguments import check_number, check_numbers, check_whole, shown
from ..arguments import numbers as as_numbers
from ..build.restrict import with_turn
from ..checks.mobility import mobility
from ..compilation.compile import unguarded
from ..errors import heard
from ..model.model import Model, as_determined, as_known
from ..progress import reporting
from .designs import numbers
from .evaluate import Build, check_dimensions
from .judgement import Limit, Verdict, most
from .over_stroke import StrokeQuestions, unit_of_curve
from .sensitivities import Sensitivities, sensitivities
from .stroke import driven

# What is a limit without being asked for: strength and fatigue limit of the material, the constant loads.
USUAL = {"yield": 1.0, "fatigue": 1.0, "buckling": 1.0}
# What must not be too small; of all else it is too much that limits.
LEAST = ("buckling", "frequency", "stiffness")
# A limit is located to this share of the way between two strokes.
CLOSE = 1e-6
# An extreme between strokes is found to this share of the way from one to the next but one.
CLOSE_EXTREME = 1e-4
# So is the end of what is reached, to this share of the stroke that is asked.
CLOSE_END = 0.01


@unguarded
def verdict(
    model: Model | Build,
    stroke: float | tuple[float, float] | Mapping[str, Any],
    *,
    dimensions: Mapping[str, Any] | None = None,
    limits: Mapping[str, Any] | None = None,
    node: str | None = None,
    steps: int = 4,
    count: int = 3,
    progress: Callable[[int, int], None] | bool = False,
) -> Verdict:
    """Whether a mechanism is good enough over its stroke, what limits it first, and which dimension moves that.

    A drive holds the coordinate at each stroke, under the constant loads. Frequencies and buckling are those of the
    mechanism that is let go there, the force of the drive remaining.

    Args:
        model: Mechanism; or a function of ``dimensions`` that returns one.
        stroke: To both sides, or its two ends about zero, [m or rad]; by the name of what is driven where the model
            does not say it: {"top.x": 5e-3}, in space {"top.rx": 0.1} of the angle about a global axis. What is
            prescribed with an increment, the one input, or the one degree of freedom need no name.
        dimensions: Numbers by name, as ``flexmb.sensitivities`` takes them [SI].
        limits: By the name of a curve, in its unit: the least of "frequency 1", "stiffness y" and "buckling", the
            largest size of any other; or both, as (lower, upper) with None for none. They stand beside the usual ones,
            1 for "yield", "fatigue" and "buckling". Any other question of a state, such as "stress leaf", is a curve
            too where a limit names it.
        node: Whose support stiffness and parasitic motion are asked; the driven one unless given.
        steps: Strokes to each side. Where one of them has no equilibrium, the last that has is looked for before it,
            to a hundredth of the stroke, and that side ends there.
        count: How many frequencies.
        progress: True for a bar, or a function called with the number of strokes looked at and of all.

    Returns:
        Verdict with stroke (states,) [m or rad] and curves by name, (states,) [their units].

    Raises:
        ModelError: What is to be driven is not there, is not said, or cannot move.
        ValueError: A stroke or a limit that is none, or a limit of no curve.
        AnalysisError: There is no equilibrium at zero stroke.

    Source:
        Composition of linearize, stress, compliance, frequencies and sensitivities; buckling of THEORY.md 7, eq. (7.4)
        with the constant loads as increment. A limit is looked for at the strokes, half-way between them and at
        extremes, and located by Brent's method. Fatigue is that of a motion which reverses fully between a stroke and
        its opposite.
    """
    steps, count = check_whole("steps", steps, 1), check_whole("count", count, 1)
    build = None
    if callable(model) and not isinstance(model, Model):
        if not dimensions:
            raise TypeError("fm.verdict of a function takes dimensions={'t': 0.5e-3, ..}, as fm.sensitivities does.")
        dimensions = {name: numbers(f"Dimension '{name}'", v) for name, v in dimensions.items()}
        check_dimensions(model, tuple(dimensions))
        build, model = model, model(**dimensions)
    elif dimensions is not None:
        raise TypeError("Argument `dimensions` goes with a function of them: give it in place of the model.")
    model = as_determined(as_known(model, "verdict"), "verdict")
    name, (low, high) = _ends(stroke)
    model = with_turn(model, str(name))
    asked = StrokeQuestions(model, driven(model, name), node, count)
    sides = [np.linspace(0, end, steps + 1)[1:].tolist() for end in (low, high) if end]
    with reporting(progress, "strokes", 1 + sum(map(len, sides))) as report:
        asked.look(0.0, throw=True)
        for extra in limits or {}:
            if extra not in asked.values[0.0]:
                with contextlib.suppress(KeyError, ValueError):
                    asked.ask_too(extra)
        for side in sides:
            for last, s in itertools.pairwise([0.0, *side]):
                if report is not None:
                    report(len(asked.values), 1 + sum(map(len, sides)))
                if not asked.look(s):
                    asked.approach(last, s, CLOSE_END * abs(side[-1]))
                    break
    asked.say_what_is_missing()
    curves, strokes = asked.curves(), np.array(sorted(asked.values))
    states = (
        asked.places(),
        asked.stable("held"),
        asked.stable("free"),
        np.array([asked.at[s].held.x for s in strokes.tolist()]),
    )
    found = _limits(asked, strokes, curves, limits or {})
    table = None if build is None else _sensitivities(asked, build, dimensions or {}, found, strokes)
    with heard():
        redundant = mobility(model)
    units = {name: unit_of_curve(name, asked.unit) for name in curves}
    of = asked.driven.name, asked.unit, asked.node
    return Verdict(*of, strokes, curves, units, found, redundant, table, asked.unanswered, *states, model)


def _ends(stroke: Any) -> tuple[str | None, tuple[float, float]]:
    """Name of what is driven, or None, and the two ends of its stroke."""
    name = None
    if isinstance(stroke, Mapping):
        if len(stroke) != 1:
            raise ValueError(f"Argument `stroke` takes one coordinate, not {len(stroke)}: {shown(dict(stroke))}.")
        ((name, stroke),) = stroke.items()
    if np.ndim(stroke) == 1 and len(stroke) == 2:
        low, high = stroke
        check_numbers("Argument `stroke`", (low, high))
        if not low <= 0 <= high or low == high:
            raise ValueError(f"Argument `stroke` has ends about zero, where it begins; they are {shown(stroke)}.")
        return name, (float(low), float(high))
    check_number("stroke", stroke, above=0)
    return name, (-float(stroke), float(stroke))


def _limits(
    asked: StrokeQuestions, strokes: np.ndarray, curves: dict[str, np.ndarray], given: Mapping[str, Any]
) -> tuple[Limit, ...]:
    """Limits with where they are reached, the first of them first."""
    wanted = {name: value for name, value in USUAL.items() if np.any(np.isfinite(curves.get(name, np.nan)))}
    for name, value in given.items():
        name = "frequency 1" if name == "frequency" else name
        if name not in curves:
            why = "".join(f" Not answered is {what}: {why}." for what, why in asked.unanswered.items())
            raise ValueError(f"Limit of {shown(name)}: there is no such curve. There are: {', '.join(curves)}.{why}")
        wanted[name] = value
    found = []
    for name, value in wanted.items():
        limit = _limit(name, value)
        used = np.array([limit.share(v) for v in curves[name].tolist()])
        found.append(dataclasses.replace(limit, used=used, stroke=_reached(asked, limit, strokes)))
    return tuple(sorted(found, key=_order))


def _order(limit: Limit) -> tuple[float, float]:
    """Reached at a small stroke before reached at a large one, before much used and little used."""
    return np.inf if limit.stroke is None else abs(limit.stroke), -float(np.nanmax(limit.used))


def _reached(asked: StrokeQuestions, limit: Limit, strokes: np.ndarray) -> float | None:
    """The stroke nearest to zero at which a limit is reached."""

    def excess(stroke: float) -> float:
        known = asked.look(stroke) and limit.name in asked.values[stroke]
        share = limit.share(asked.values[stroke][limit.name]) if known else np.nan
        return -1.0 if np.isnan(share) else float(np.clip(share - 1, -1.0, 1.0))

    if excess(0.0) >= 0:
        return 0.0
    sides = strokes[strokes >= 0], strokes[strokes <= 0][::-1]
    found = [place for side in sides if (place := _first_reached(excess, side.tolist())) is not None]
    # Of two that are equal but for how well they are known, the one along the stroke.
    return min(found, key=lambda s: abs(s) * (1 + 10 * CLOSE * (s < 0)), default=None)


def _first_reached(excess: Callable[[float], float], side: list[float]) -> float | None:
    """The first stroke along one side at which a limit is reached, or None; half-way between strokes is looked too.

    Where more than half of it is used, and more than on either side, the extreme between is looked for.
    """
    every = side[:1]
    for a, b in itertools.pairwise(side):
        every += [(a + b) / 2, b]
    for i in range(1, len(every)):
        a, b = every[i - 1 : i + 1]
        c = every[i + 1] if i + 1 < len(every) else b
        beside = excess(a), excess(c)
        if c != b and -0.5 < excess(b) < 0 and min(beside) < excess(b) >= max(beside):
            near = {"xatol": CLOSE_EXTREME * abs(c - a)}
            found: Any = minimize_scalar(lambda s: -excess(s), bounds=sorted((a, c)), method="bounded", options=near)
            b = float(found.x)
        if excess(b) >= 0:
            reached: Any = brentq(excess, a, b, xtol=CLOSE * abs(b - a))
            return float(reached)
    return None


def _sensitivities(
    asked: StrokeQuestions, build: Build, dimensions: Mapping[str, Any], limits: tuple[Limit, ...], strokes: np.ndarray
) -> Sensitivities:
    """Of all curves by the dimensions, at the stroke where the first limit is reached, or most used, or at the end."""
    stroke = float(max(strokes, key=abs))
    if limits:
        first = limits[0]
        stroke = float(strokes[most(first.used)]) if first.stroke is None else first.stroke
    names = list(asked.values[0.0])
    found = sensitivities(build, {"curves": lambda m: asked.numbers_at(m, stroke, names)}, dimensions, throw=False)
    return dataclasses.replace(found, answers=tuple(names))


def _limit(name: str, value: Any) -> Limit:
    """A limit from a number, which the curve is to stay above or below by its nature, or from both ends."""
    pair: tuple[Any, ...] = (value, None) if name.startswith(LEAST) else (None, value)
    if np.ndim(value) == 1 and len(value) == 2:
        pair = tuple(value)
    for one in pair:
        if one is not None and not (as_numbers(one) is not None and np.ndim(one) == 0 and 0 < one < np.inf):
            raise ValueError(f"Limit of '{name}' must be positive, or (lower, upper) of such, but is {shown(value)}.")
    lower, upper = (None if one is None else float(one) for one in pair)
    if lower is None and upper is None:
        raise ValueError(f"Limit of '{name}' is none at all: leave it out.")
    if lower is not None and upper is not None and not lower < upper:
        raise ValueError(f"Limits of '{name}' are empty: lower {lower:g} is not below upper {upper:g}.")
    return Limit(name, lower, upper, np.zeros(0), None)
