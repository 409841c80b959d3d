"""The tuning problem: an objective, targets and limits, all linear in the scaled answers; scaling of dimensions."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..errors import printable
from ..numerical_limits import AT_BOUND, TARGET_OF_TUNE_MET
from .designs import checked_bounds, float_array
from .evaluate import Layout

# Number of missed targets or violated constraints in a message.
NAMED = 3


@dataclasses.dataclass(frozen=True)
class Rows:
    """Rows r = A a - b of scaled answers a: matrix A (rows, m), right side b (rows,), and names."""

    matrix: np.ndarray
    right: np.ndarray
    names: tuple[str, ...]

    def __call__(self, answers: Any) -> Any:
        """Values of the rows, (rows,) [-]."""
        return self.matrix @ answers - self.right


@dataclasses.dataclass(frozen=True)
class TuningProblem:
    """Minimise weights . a + |targets(a)|^2/2 with equal(a) = 0 and limits(a) <= 0.

    Targets and constraints are relative to their values. Methods have arguments: answers (m,), multipliers of ``equal``
    and of ``limits``, and the weight of the penalty, () [-].
    """

    weights: np.ndarray
    targets: Rows
    equal: Rows
    limits: Rows

    @property
    def only_targets(self) -> bool:
        """Whether this is a least-squares problem within bounds."""
        return not (np.any(self.weights) or self.equal.names or self.limits.names)

    def objective(self, answers: Any) -> Any:
        """Objective, () [-]."""
        residual = self.targets(answers)
        return self.weights @ answers + 0.5 * residual @ residual

    def violation(self, answers: Any) -> float:
        """Largest violation of a constraint, relative to its value, () [-]."""
        parts = (np.abs(self.equal(answers)), self.limits(answers))
        return float(max(np.max(part, initial=0.0) for part in parts))

    def missed(self, residuals: Any, share: float = TARGET_OF_TUNE_MET) -> list[str]:
        """Missed targets with their relative differences."""
        return _worst("misses by", [(self.targets, np.asarray(residuals))], share)

    def violated(self, answers: Any, tolerance: float) -> list[str]:
        """Violated constraints with their violations."""
        parts = (self.equal, np.abs(self.equal(answers))), (self.limits, np.maximum(self.limits(answers), 0.0))
        return _worst("by", parts, tolerance)

    def lagrangian(self, answers: Any, multipliers: tuple[Any, Any], weight: Any) -> Any:
        """Augmented Lagrangian, () [-].

        Source:
            Rockafellar 1974; Nocedal, Wright 2006, eq. (17.65) with the slacks eliminated.
        """
        of_equal, of_limits = multipliers
        c = self.equal(answers)
        pushed = jnp.maximum(of_limits + weight * self.limits(answers), 0.0)
        penalty = of_equal @ c + 0.5 * weight * c @ c + (pushed @ pushed - of_limits @ of_limits) / (2 * weight)
        return self.objective(answers) + penalty

    def slope(self, answers: np.ndarray, multipliers: tuple[np.ndarray, np.ndarray], weight: float) -> np.ndarray:
        """Derivative of the augmented Lagrangian by the answers, (m,)."""
        updated = self.updated(answers, multipliers, weight)
        slope = self.weights + self.targets.matrix.T @ self.targets(answers)
        return slope + self.equal.matrix.T @ updated[0] + self.limits.matrix.T @ updated[1]

    def updated(
        self, answers: np.ndarray, multipliers: tuple[np.ndarray, np.ndarray], weight: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """First-order estimate of the multipliers."""
        of_equal, of_limits = multipliers
        pushed = np.maximum(of_limits + weight * self.limits(answers), 0.0)
        return of_equal + weight * self.equal(answers), pushed


def _worst(words: str, parts: Sequence[tuple[Rows, np.ndarray]], tolerance: float) -> list[str]:
    """Names of the rows with the largest values beyond a tolerance, with these values in percent."""
    every = [pair for rows, values in parts for pair in zip(rows.names, values, strict=True)]
    beyond = [(name, value) for name, value in every if not abs(value) <= tolerance]
    least = sorted((abs(value) for _, value in beyond), reverse=True)[:NAMED][-1:]
    named = [(name, value) for name, value in beyond if not abs(value) < least[0]][:NAMED]
    more = [f"{len(beyond) - len(named)} more by less"] if len(beyond) > len(named) else []
    return [f"{name} {words} {100 * value:.3g} %" for name, value in named] + more


def asked_names(wanted: Mapping[str, Any]) -> list[Any]:
    """Names of answers in the arguments of :func:`flexmb.tune`."""
    objectives = [wanted[sense] for sense in ("minimize", "maximize") if wanted.get(sense) is not None]
    return objectives + [name for table in ("targets", "limits", "equal") for name in wanted.get(table) or ()]


def make_problem(
    layout: Layout,
    start: np.ndarray,
    *,
    minimize: str | None,
    maximize: str | None,
    targets: Mapping[str, Any],
    equal: Mapping[str, Any],
    limits: Mapping[str, Any],
    margin: float,
) -> TuningProblem:
    """The problem of arguments of :func:`flexmb.tune`."""
    places = dict(zip(layout.names, np.split(np.arange(len(start)), np.cumsum(layout.sizes)[:-1]), strict=True))
    shapes, labels = dict(zip(layout.names, layout.shapes, strict=True)), layout.labels
    objectives = [n for n in (minimize, maximize) if n is not None]
    for name in (*objectives, *targets, *equal, *limits):
        if not isinstance(name, str) or name not in places:
            raise ValueError(f"There is no answer '{printable(name)}'. Answers are: {', '.join(places)}.")
    if len(objectives) > 1:
        raise ValueError(
            "Give either `minimize` or `maximize`. To weigh two answers, define an answer that combines them."
        )
    if not (objectives or targets):
        raise ValueError("Give an objective: `minimize`, `maximize` or `targets`.")
    weights = np.zeros(len(start))
    for name in objectives:
        place = _place(name, places[name], shapes[name], "min" if minimize else "max")
        weights[place] = (1 if minimize else -1) / (abs(start[place]) or 1.0)

    def rows(requirements: list[tuple[str, Any, float, str]], tightened: float) -> Rows:
        matrix, right, names = [], [], []
        for name, value, sign, kind in requirements:
            largest = np.max(np.abs(value.values)) if isinstance(value, Curve) else 0.0
            for place, v in zip(places[name], _entries(name, shapes[name], value, kind), strict=True):
                if np.isinf(v) and kind.endswith("limit") and v * sign > 0:
                    continue
                if not np.isfinite(v):
                    raise ValueError(f"The {kind} of '{name}' must be finite, but is {v}.")
                scale = largest or abs(v) or abs(start[place]) or 1.0
                matrix.append(np.eye(len(start))[place] * sign / scale)
                right.append(sign * v / scale - tightened)
                names.append(labels[place] if kind in ("target", "value") else f"{labels[place]} ({kind} {v:g})")
        return Rows(np.array(matrix).reshape(-1, len(start)), np.array(right), tuple(names))

    pairs = [(name, *limits_of(name, shapes[name], pair)) for name, pair in limits.items()]
    below = [(n, upper, 1.0, "upper limit") for n, _, upper in pairs if upper is not None]
    above = [(n, lower, -1.0, "lower limit") for n, lower, _ in pairs if lower is not None]
    return TuningProblem(
        weights,
        rows([(n, v, 1.0, "target") for n, v in targets.items()], 0.0),
        rows([(n, v, 1.0, "value") for n, v in equal.items()], 0.0),
        rows(below + above, margin),
    )


def _place(name: str, places: np.ndarray, shape: tuple[int, ...], how: str) -> int:
    """Index of the one number to minimise or maximise."""
    if len(places) != 1:
        raise ValueError(
            f"Answer '{name}' has shape {shape}, but only one number can be {how}imized. Use"
            " fm.linear.smooth_maximum, fm.linear.smooth_minimum or one entry of it."
        )
    return places[0]


def _entries(name: str, shape: tuple[int, ...], value: Any, kind: str) -> np.ndarray:
    """Numbers for the entries of an answer, (n,)."""
    if isinstance(value, Curve):
        if kind != "target":
            raise ValueError(f"A curve can only be a target. Give numbers for the {kind} of '{name}'.")
        if shape != value.values.shape:
            count = len(value.values)
            raise ValueError(f"The curve of target '{name}' has {count} places, but the answer has shape {shape}.")
        return value.values
    try:
        return np.broadcast_to(float_array(kind, value), shape).ravel()
    except (TypeError, ValueError):
        expected = f"must be a number or of shape {shape}"
        raise ValueError(f"The {kind} of '{name}' {expected}, but is {printable(repr(value))}.") from None


def limits_of(name: str, shape: tuple[int, ...], pair: Any) -> tuple[Any, Any]:
    """Lower and upper limit of an answer, None for no limit."""
    try:
        if isinstance(pair, str):
            raise ValueError
        lower, upper = pair
    except (TypeError, ValueError):
        expected = "must be two values, lower and upper, None for none"
        raise ValueError(f"Limits of '{name}' {expected}, but are {printable(repr(pair))}.") from None
    if lower is None and upper is None:
        raise ValueError(f"Limits of '{name}' are both None. Leave them out.")
    low, high = (
        value if value is None else _entries(name, shape, value, f"{side} limit")
        for side, value in (("lower", lower), ("upper", upper))
    )
    for side, numbers_of in (("lower", low), ("upper", high)):
        if numbers_of is not None and np.any(np.isnan(numbers_of)):
            raise ValueError(f"The {side} limit of '{name}' is NaN. Give a number, or None for no limit.")
    if low is not None and high is not None and not np.all(low < high):
        raise ValueError(f"Limits of '{name}' are empty: lower {lower} is not below upper {upper}; see `equal`.")
    return lower, upper


@dataclasses.dataclass(frozen=True, eq=False)
class Curve:
    """Target values of an answer along an axis, for ``fm.tune``.

    Differences are relative to the largest value of the curve. In a target that is an array, each difference is
    relative to its own target value. Forces near zero would then have the largest weight.

    Attributes:
        over: Places: strokes, times, load factors, (n,) [their unit].
        values: Target values there, (n,) [unit of the answer].
        label: Label of the places in a picture, such as "stroke [m]".
    """

    over: np.ndarray
    values: np.ndarray
    label: str

    def __init__(self, over: Any, values: Any, label: str = ""):
        """Keep two lists of one length.

        Args:
            over: Places, (n,) [any].
            values: Target values there, (n,), or one number for all [unit of the answer].
            label: Label of the places in a picture, such as "stroke [m]".

        Raises:
            ValueError: Numbers are not finite, or the lengths differ.
        """
        where, curve_values = (
            float_array("The places of a curve", over),
            float_array("The values of a curve", values),
        )
        if where.ndim != 1 or not len(where) or curve_values.shape not in ((), where.shape):
            shapes = f"{where.shape} places and {curve_values.shape} values"
            raise ValueError(f"A curve has {shapes}. Give one value for each place.")
        if not (np.all(np.isfinite(where)) and np.all(np.isfinite(curve_values))):
            raise ValueError("The places and values of a curve must be finite.")
        object.__setattr__(self, "over", where)
        object.__setattr__(self, "values", np.broadcast_to(curve_values, where.shape))
        object.__setattr__(self, "label", str(label))


class Scaling:
    """Dimensions between their bounds as numbers from 0 to 1, logarithmic or linear."""

    def __init__(self, layout: Layout, bounds: Mapping[str, Any], scales: Mapping[str, str]):
        """Check and keep the bounds."""
        for kind, by_name in (("Bounds", bounds), ("Scale", scales)):
            for name in by_name:
                if name not in layout.names:
                    listed = ", ".join(layout.names)
                    raise ValueError(f"{kind} of '{printable(name)}': there is no such dimension ({listed}).")
        for name in layout.names:
            if name not in bounds:
                raise ValueError(f"Dimension '{name}' has no bounds. Give lower and upper, or fix it in `build`.")
        pairs = {name: checked_bounds(name, bounds[name]) for name in layout.names}
        logarithmic = {}
        for name, (lower, _) in pairs.items():
            scale = scales.get(name, "log" if np.all(lower > 0) else "linear")
            if scale not in ("log", "linear"):
                raise ValueError(f"Scale of '{name}' must be 'log' or 'linear', but is {printable(repr(scale))}.")
            if scale == "log" and not np.all(lower > 0):
                raise ValueError(f"Scale of '{name}' cannot be 'log', since its lower bound {lower} is not positive.")
            logarithmic[name] = scale == "log"
        self.layout = layout
        self.lower = layout.join({name: lower for name, (lower, _) in pairs.items()})
        self.upper = layout.join({name: upper for name, (_, upper) in pairs.items()})
        self.log = layout.join(logarithmic) > 0

    def check_inside(self, flat: np.ndarray) -> None:
        """Refuse a start outside the bounds."""
        for name, value, lower, upper in zip(self.layout.labels, flat, self.lower, self.upper, strict=True):
            if not lower <= value <= upper:
                raise ValueError(f"Start {value:g} of '{name}' is outside its bounds, {lower:g} to {upper:g}.")

    def starts(self, first: np.ndarray, count: int, seed: int) -> list[np.ndarray]:
        """Numbers from 0 to 1 of dimensions, (n,), and of further starts spread over the bounds, ``count`` in all."""
        from scipy.stats import qmc

        start = self.to_unit(first)
        others = qmc.LatinHypercube(len(start), rng=np.random.default_rng(seed)) if count > 1 else None
        return [start, *(others.random(count - 1) if others is not None else [])]

    def at_bounds(self, unit: np.ndarray) -> list[str]:
        """Dimensions at a bound, in words."""
        texts = []
        for name, u, lower, upper in zip(self.layout.labels, unit, self.lower, self.upper, strict=True):
            if min(u, 1 - u) < AT_BOUND:
                texts.append(
                    f"{name} is at its {'lower' if u < 0.5 else 'upper'} bound {lower if u < 0.5 else upper:g}"
                )
        return texts

    def to_unit(self, flat: np.ndarray) -> np.ndarray:
        """Numbers from 0 to 1, (n,), of dimensions, (n,)."""
        linear = (flat - self.lower) / (self.upper - self.lower)
        pairs = (flat, 1.0), (self.lower, 1.0), (self.upper, np.e)
        value, lower, upper = (np.where(self.log, number, other) for number, other in pairs)
        return np.clip(np.where(self.log, np.log(value / lower) / np.log(upper / lower), linear), 0.0, 1.0)

    def to_dimensions(self, unit: Any) -> Any:
        """Dimensions, (n,), of numbers from 0 to 1, (n,), which may be traced."""
        ratio = np.where(self.log, self.upper / np.where(self.log, self.lower, 1.0), 1.0)
        linear = self.lower + unit * (self.upper - self.lower)
        if isinstance(unit, np.ndarray):
            dimensions = np.where(self.log, self.lower * np.exp(unit * np.log(ratio)), linear)
            return np.clip(dimensions, self.lower, self.upper)
        return jnp.where(self.log, self.lower * jnp.exp(unit * np.log(ratio)), linear)

    def slopes(self, unit: np.ndarray) -> np.ndarray:
        """Derivatives of the dimensions by their numbers from 0 to 1, (n,) [SI]."""
        ratio = np.log(np.where(self.log, self.upper / np.where(self.log, self.lower, 1.0), 1.0))
        return np.where(self.log, self.to_dimensions(unit) * ratio, self.upper - self.lower)
