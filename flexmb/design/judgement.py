"""Assessment of a mechanism over its stroke: curves, limits, and a page of results."""

import dataclasses
from typing import Any

import numpy as np

from ..checks.mobility import Mobility
from ..display import Column, Labelled, Quantities, States, Summary, listed, quantity_text, short
from ..linear.stress import Location
from ..model.model import Model
from ..numerical_limits import NEGLIGIBLE
from .sensitivities import Sensitivities

# Beginnings of the subjects that an assessment needs to be complete.
JUDGED = ("stress", "yield", "fatigue", "buckling", "incremental loads")


@dataclasses.dataclass(frozen=True)
class Limit:
    """A limit of the stroke.

    Attributes:
        name: Name of the limited curve.
        lower: Least value, or None.
        upper: Largest absolute value, or None.
        used: Used share of the limit at each stroke, (states,) [-]; 1 at the limit.
        stroke: Smallest stroke at the limit [m or rad], or None if the limit is not reached.
    """

    name: str
    lower: float | None
    upper: float | None
    used: np.ndarray
    stroke: float | None

    def share(self, value: float) -> float:
        """Return the share of the limit that a value of the curve uses [-]: 1 at the limit."""
        over = 0.0 if self.upper is None else abs(value) / self.upper
        under = 0.0 if self.lower is None else self.lower / value if value > 0 else np.inf
        return float(max(over, under)) if np.isfinite(value) or value > 0 else float(np.nan)


@dataclasses.dataclass(frozen=True, repr=False)
class Verdict(Labelled):
    """Properties of a mechanism over its stroke, and its limits.

    Attributes:
        driven: Name of the driven coordinate.
        unit: Unit of the driven coordinate, "m" or "rad".
        node: Node of support stiffness and parasitic motion.
        stroke: Strokes, ascending, (states,) [m or rad].
        curves: Curves by name, (states,) [unit]:

            - "force" of the drive, "drive stiffness";
            - "stress": largest stress; "yield" and "fatigue": its shares of the strength and of the fatigue limit;
            - "buckling": multiplier of the constant loads;
            - "stiffness y" and so on: support stiffness of the node at a prescribed stroke;
            - "parasitic y" and so on: motion of the node from its place at zero stroke;
            - "frequency 1" and so on, with the drive as a dead force.
        units: Unit of each curve.
        limits: Given and default limits. Limits that are reached come first, in the order of their strokes; the others
            follow, the most used limit first.
        mobility: Over-constraints.
        sensitivities: Sensitivities of all curves to the dimensions, at the stroke where the first limit is reached or
            most used; None without a function of dimensions.
        unanswered: Subjects without an answer, with the reason.
        places: Place of the largest stress at each stroke, with the element's name; empty without stress.
        held_stable: Whether the mechanism is stable at each prescribed stroke, (states,).
        free_stable: Whether the mechanism is stable at each stroke with the drive as a dead force, (states,).
        x: Nodal coordinates at each stroke, (states, n_x) [m, rad, -].
        model: The mechanism.
    """

    driven: str
    unit: str
    node: str | None
    stroke: np.ndarray
    curves: dict[str, np.ndarray]
    units: dict[str, str]
    limits: tuple[Limit, ...]
    mobility: Mobility
    sensitivities: Sensitivities | None
    unanswered: dict[str, str]
    places: tuple[Location, ...]
    held_stable: np.ndarray
    free_stable: np.ndarray
    x: np.ndarray
    model: Model

    @property
    def good(self) -> bool:
        """Whether the mechanism reaches the whole stroke within all limits; :attr:`not_judged` lists open subjects."""
        return "stroke" not in self.unanswered and all(limit.stroke is None for limit in self.limits)

    @property
    def not_judged(self) -> tuple[str, ...]:
        """Subjects without an answer that could limit the stroke, and limits whose curve is unknown at some stroke.

        ``unanswered`` contains the reasons.
        """
        open_subjects = [subject for subject in self.unanswered if subject.startswith(JUDGED)]
        unknown = [limit.name for limit in self.limits if limit.stroke is None and np.any(np.isnan(limit.used))]
        return tuple(dict.fromkeys([*open_subjects, *unknown]))

    def measured(self, name: str, state: Any) -> str:
        """Return a number of a curve with its unit.

        Args:
            name: Name of the curve.
            state: Index of the stroke, from 0.
        """
        return quantity_text(float(self.curves[name][state]), self.units[name])

    def where(self, state: Any) -> str:
        """Return the stroke of a state as a text, such as "at 5 mm".

        Args:
            state: Index of the stroke, from 0.
        """
        return f"at {quantity_text(float(self.stroke[state]), self.unit)}"

    def states(self) -> States:
        """Return the mechanism at each stroke."""
        return States(self.model, self.x, "path", self.stroke, f"stroke {self.driven} [{self.unit}]")

    def quantities_by_name(self) -> Quantities:
        """Return the curves over the stroke, and the stability at each stroke."""
        over = ("stroke",)
        curves = {name: Column(over, values, self.units[name]) for name, values in self.curves.items()}
        stable = {"held_stable": Column(over, self.held_stable), "free_stable": Column(over, self.free_stable)}
        return Quantities(over, {"stroke": Column(over, self.stroke, self.unit)}, {**curves, **stable})

    def summary(self) -> Summary:
        """Return the page, with one row for each subject."""
        rows = {subject: text for subject, text in rows_of(self).items() if text}
        if self.unanswered:
            rows["not answered"] = "; ".join(f"{question}: {why}" for question, why in self.unanswered.items())
        ends = " to ".join(quantity_text(s, self.unit) for s in (self.stroke[0], self.stroke[-1]))
        return Summary(f"Verdict on {self.driven}, {ends}: {self._judgement()}", rows, "verdict")

    def _judgement(self) -> str:
        reached = [limit for limit in self.limits if limit.stroke is not None]
        if reached:
            return f"{reached[0].name} limits it to {quantity_text(reached[0].stroke or 0.0, self.unit)}"
        if "stroke" in self.unanswered:
            return f"no more is known, {self.unanswered['stroke']}"
        text = "good enough" if self.limits else "nothing is known that limits it"
        return f"{text}; not judged: {listed(self.not_judged)}" if self.not_judged else text

    def __str__(self) -> str:
        title, rows, *_ = self.summary()
        width = max(len(name) for name in rows) + 2
        lines = [title, *(f"  {name:<{width}}{text}" for name, text in rows.items()), ""]
        names = {f"stroke [{self.unit}]": self.stroke, **{f"{n} [{self.units[n]}]": c for n, c in self.curves.items()}}
        # Strokes are columns, so that further curves do not widen the page.
        label_width = max(map(len, names)) + 2
        return "\n".join(
            lines + [f"  {n:<{label_width}}" + "".join(f"{v:>10.3g}" for v in c) for n, c in names.items()]
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain keys and values for the JSON of the command line."""
        sensitivities = self.sensitivities
        table = {} if sensitivities is None else dict(zip(sensitivities.answers, sensitivities.table, strict=True))
        return {
            "driven": self.driven,
            "unit": self.unit,
            "node": self.node,
            "good": self.good,
            "stroke": self.stroke,
            "curves": self.curves,
            "units": self.units,
            "limits": [dataclasses.asdict(limit) for limit in self.limits],
            "overconstraints": self.mobility.overconstraints,
            "sensitivities": {
                n: dict(zip(sensitivities.dimensions, row, strict=True)) for n, row in table.items() if sensitivities
            },
            "unanswered": self.unanswered,
            "not_judged": self.not_judged,
            "rows": self.summary().rows,
        }


def rows_of(page: Verdict) -> dict[str, str]:
    """Return the rows of the page by subject."""
    curves, rest_index = page.curves, int(np.flatnonzero(page.stroke == 0)[0])
    force = curves["force"]
    low, high = (page.measured("force", i) for i in (most(-force), most(force)))
    rows = {"drive force": f"{low} to {high}, stiffness {page.measured('drive stiffness', rest_index)} at rest"}
    if "stress" in curves:
        i = most(curves["stress"])
        place = page.places[i]
        rows["stress"] = f"{page.measured('stress', i)} in '{place.element}' at {place.place:g}, {page.where(i)}"
        for name, limit in (("yield", "the strength"), ("fatigue", "the fatigue limit")):
            if name in curves:
                rows["stress"] += f"; {short(np.nanmax(curves[name]))} of {limit}"
    rows["stability"] = _stability(page)
    for subject, start, text_of in (
        ("support stiffness", "stiffness", _stiffness),
        ("parasitic motion", "parasitic", _parasitic),
    ):
        names = [name for name in curves if name.startswith(start)]
        rows[subject] = "; ".join(text for name in names if (text := text_of(page, name, rest_index)))
        rows[subject] = rows[subject] or ("none" if names else "")
    if hertz := [name for name in curves if name.startswith("frequency")]:
        at_rest = listed([page.measured(name, rest_index) for name in hertz])
        i = most(-curves["frequency 1"])
        rows["frequencies"] = f"{at_rest} at rest; least {page.measured('frequency 1', i)} {page.where(i)}"
    rows["over-constraints"] = "; ".join(page.mobility.states().titles) or "none"
    rows["limits first"] = _first(page)
    rows["by dimension"] = _by_dimension(page)
    return rows


def most(values: np.ndarray) -> int:
    """Return the index of the largest of n numbers, the last index of numbers that are equal within round-off."""
    known = np.where(np.isnan(values), -np.inf, values)
    top = np.max(known)
    return int(np.flatnonzero(known >= top * (1 - np.sign(top) * NEGLIGIBLE))[-1])


def _parasitic(page: Verdict, name: str, rest_index: int) -> str:
    """Return the parasitic motion of the node along or about an axis; empty for no motion."""
    i = most(np.abs(page.curves[name]))
    if abs(page.curves[name][i]) <= NEGLIGIBLE * np.max(np.abs(page.stroke)):
        return ""
    return f"{name.split()[-1]} {page.measured(name, i)} {page.where(i)}"


def _stiffness(page: Verdict, name: str, rest_index: int) -> str:
    """Return the stiffness of the node along or about an axis, and its loss over the stroke."""
    values, axis = page.curves[name], name.split()[-1]
    if np.all(np.isinf(values)):
        return f"{axis} rigid in the model"
    i = most(-values)
    if not np.isfinite(values[rest_index]):
        return f"{axis} rigid at rest, {page.measured(name, i)} {page.where(i)}"
    lost = f"{short(100 * (1 - values[i] / values[rest_index]))} % lost {page.where(i)}"
    return (
        f"{axis} {page.measured(name, rest_index)} at rest, {lost if values[i] < values[rest_index] else 'its least'}"
    )


def _stability(page: Verdict) -> str:
    """Return the unstable strokes, and the multiple of the constant loads at buckling."""
    text = "stable"
    if not np.all(page.held_stable):
        falls = np.flatnonzero(~page.held_stable)
        text = f"unstable even with the drive fixed {page.where(falls[np.argmin(np.abs(page.stroke[falls]))])}"
    elif not np.all(page.free_stable):
        first, last = np.flatnonzero(~page.free_stable)[[0, -1]]
        text = f"stable only with the drive fixed, from {page.where(first)[3:]} to {page.where(last)[3:]}"
    if "buckling" not in page.curves:
        return text
    values = page.curves["buckling"]
    if not np.any(np.isfinite(values)):
        return f"{text}; no constant loads that buckle it"
    i = most(-values)
    return f"{text}; buckles at {short(values[i])} times the constant loads, {page.where(i)}"


def _first(page: Verdict) -> str:
    """Return the limits that are reached; otherwise the most used limit."""
    reached = [
        f"{limit.name} at {quantity_text(s, page.unit)}" for limit in page.limits if (s := limit.stroke) is not None
    ]
    if reached:
        return ", then ".join(reached)
    if not page.limits:
        return "no limit is known: give limits={..} (--limit NAME=X), or a material that states its strength"
    first = page.limits[0]
    i = most(first.used)
    return f"none within the stroke; {first.name} comes nearest, {short(first.used[i])} of it {page.where(i)}"


def _by_dimension(page: Verdict) -> str:
    """Return the dimensions that change the first limit, the most effective dimension first."""
    if page.sensitivities is None:
        return "give a function of the dimensions: fm.verdict(build, stroke, dimensions={'t': 0.5e-3, ..})"
    if not page.limits:
        return "no limit is known; .sensitivities has every curve by them"
    sensitivities, first = page.sensitivities, page.limits[0]
    row = sensitivities.table[sensitivities.answers.index(first.name)]
    if not np.any(np.isfinite(row)):
        return f"{first.name} has no derivative by them"
    # For a limit with both ends, the upper end counts.
    sign = 1 if first.upper is None else -1
    advice, sizes = [], np.abs(np.nan_to_num(row))
    for i in np.argsort(-sizes):
        if sizes[i] > NEGLIGIBLE * max(1.0, np.max(sizes)):
            advice.append(
                f"{'larger' if row[i] * sign > 0 else 'smaller'} {sensitivities.dimensions[i]} ({row[i]:+.3g})"
            )
    return (
        f"{listed(advice)}: percent of {first.name} for one percent" if advice else f"none of them moves {first.name}"
    )
