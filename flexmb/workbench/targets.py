"""Targets for answers beside the drawing, met by the dimensions nearest to the present ones."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..design.evaluate import layout_of
from ..design.problem import Scaling, make_problem
from ..design.search import search_from
from ..display import listed
from ..errors import ModelError, heard, printable
from ..mechanics.loads import has_loads
from ..numerical_limits import AT_BOUND, TARGET_AGAINST, TARGET_MET, TARGET_NEARLY, TARGET_TO_ROUND_OFF
from ..plot.geometry import point_extent
from ..progress import Stopped
from ..questions.question import Asked
from ..results import RESULTS
from .building import built_whole, numeric_values, positions
from .document import Document
from .traced import Traced, question_of, traced
from .wants import answer_text, answer_unit, checked_free, name_ops, wants_of

# Default bounds of a name: its value divided and multiplied by this.
WIDE = 5.0
# Evaluations of the search, evaluations of each search after it for the targets alone, and number of those.
BUDGET, BUDGET_NEAREST, ROUNDS = 400, 200, 2
# Shortest time between two designs that the page shows [s], and total time to wait for that [s].
PACE, LONGEST_PAUSE = 0.05, 1.2


def meet(
    document: Document, wants: Sequence[Mapping[str, Any]], free: Sequence[str], job: Any, node: str | None = None
) -> dict[str, Any]:
    """Find the dimensions nearest to the present ones that meet the targets; "ops" of the result would write them.

    ``job.tell(..)`` receives the progress, and ``job.stopped`` ends the search.
    """
    # The page shows warnings beside the drawing.
    with heard():
        tuning, stopped = _Tuning(document, wants, free, job, node), False
        try:
            tuning.run()
        except Stopped:
            stopped = True
        return tuning.told(stopped)


class _Tuning:
    """One search, and the best design so far."""

    def __init__(self, document: Document, wants: Any, free: Sequence[str], job: Any, node: str | None):
        numbers = numeric_values(document)
        names = {name: float(numbers[a]) for name in document.names if (a := f"names/{name}/value") in numbers}
        self.document, self.job = document, job
        self.wants = wants_of(wants, names)
        self.free = checked_free(document, free)
        known = {name: bounds_of(document, name, numbers) for name in self.free}
        bounds = {name: pair for name, (pair, _) in known.items()}
        self.assumed = {name: pair for name, (pair, is_assumed) in known.items() if is_assumed}
        self.start = np.array([names[name] for name in self.free])
        self.scaling = Scaling(layout_of({name: names[name] for name in self.free}), bounds, {})
        # Size of a change through the whole range, relative if the dimension keeps its sign.
        log, lower, upper = self.scaling.log, self.scaling.lower, self.scaling.upper
        self.size = np.where(log, np.log(np.where(log, upper, 1.0) / np.where(log, lower, 1.0)), 1.0)
        self.keys = list(dict.fromkeys(want.key for want in self.wants))
        model = built_whole(document).builder.build()
        idle = [key for key in self.keys if _depends_on_loads(key)]
        if idle and not has_loads(model.topology, model.parameters):
            raise ValueError(f"No load acts, so there is no {idle[0]}. Add a force, a moment or gravity.")
        self.traced: Traced = traced(document, model, self.keys, node)
        self.answers = self.traced.at(document)
        self.everything = np.array([names[name] for name in self.traced.names])
        self.places = [self.traced.names.index(name) for name in self.free]
        self.best: tuple[float, np.ndarray, np.ndarray] | None = None
        self.count, self.told_at, self.paused, self.failed = 0, 0.0, 0.0, RESULTS.successful

    def _by_key(self, values: np.ndarray) -> dict[str, float]:
        return dict(zip(self.keys, values.tolist(), strict=True))

    def kernel(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """Answers and relative changes of the dimensions, (m + n,), their derivatives by ``unit``, and the code."""
        unit = np.clip(unit, 0.0, 1.0)
        x = np.asarray(self.scaling.to_dimensions(unit))
        values, slopes, code = self.evaluate(x)
        # A dimension that may change its sign changes relative to its range.
        rate = np.where(self.scaling.log, x * self.size, self.scaling.upper - self.scaling.lower)
        change = self.size * (unit - self.scaling.to_unit(self.start))
        return np.concatenate([values, change]), np.concatenate([slopes * rate, np.diag(self.size)]), code

    def evaluate(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """Answers of a design, which is noted and shown."""
        if self.job.stopped:
            raise Stopped
        everything = self.everything.copy()
        everything[self.places] = x
        values, slopes, code = self.answers(everything)
        slopes = slopes[:, self.places]
        self.count += 1
        if code == RESULTS.successful and np.all(np.isfinite(values)):
            missed = self.missed(values)
            far = float(np.linalg.norm(self.scaling.to_unit(x) - self.scaling.to_unit(self.start)))
            # Among designs that meet all targets the nearest is best.
            rank = missed if missed > TARGET_TO_ROUND_OFF else far * TARGET_TO_ROUND_OFF
            if self.best is None or rank < self.best[0]:
                self.best = rank, x.copy(), values
                # Designs of steps that go too far are not shown.
                self._tell(x, values, missed)
        else:
            self.failed = RESULTS.not_finite if code == RESULTS.successful else RESULTS(code)
        return values, slopes, code

    def missed(self, values: np.ndarray) -> float:
        """Relative miss of the worst target [-]."""
        by_key = self._by_key(values)
        return max(0.0, *(want.missed(by_key[want.key]) for want in self.wants))

    def _tell(self, x: np.ndarray, values: np.ndarray, missed: float) -> None:
        now = time.monotonic()
        if (wait := self.told_at + PACE - now) > 0:
            if self.paused > LONGEST_PAUSE:
                return
            time.sleep(wait)
            self.paused += wait
        self.told_at = time.monotonic()
        by_key = self._by_key(values)
        text = ", ".join(f"{key} {answer_text(value, answer_unit(key))}" for key, value in by_key.items())
        fraction = min(0.95, self.count / 40) if missed > TARGET_MET else 0.98
        self.job.tell(fraction=fraction, text=text, design=dict(zip(self.free, x.tolist(), strict=True)), values=by_key)

    def run(self) -> None:
        """Search like ``fm.tune`` for the least change, then for the targets alone, or for the nearest design."""
        self.job.tell(fraction=0.0, text="compiling")
        values, slopes, code = self.evaluate(self.start)
        if code != RESULTS.successful or not np.all(np.isfinite(values)):
            why = RESULTS(code) if code != RESULTS.successful else RESULTS.not_finite
            names = ", ".join(key for key, v in zip(self.keys, values, strict=True) if not np.isfinite(v))
            raise ModelError(f"{names or 'A target'} has no value now, so the search cannot begin: {why.message}")
        if self.missed(values) <= 0:
            return
        self._refuse_without_effect(values, slopes)
        equal = {want.key: want.value for want in self.wants if want.kind == "equal"}
        limits: dict[str, tuple[float | None, float | None]] = {}
        for want in self.wants:
            lower, upper = limits.get(want.key, (None, None))
            if want.kind != "equal":
                limits[want.key] = (want.value, upper) if want.kind == "least" else (lower, want.value)
        nowhere = np.zeros(len(self.free))
        self._search(values, {"change": nowhere}, equal, limits, self.start, BUDGET)
        for _ in range(ROUNDS):
            assert self.best is not None
            missed, x, values = self.best
            if missed <= TARGET_TO_ROUND_OFF:
                return
            by_key = self._by_key(values)
            # A limit that is reached stays reached, from inside.
            inside = {"equal": 0.0, "least": TARGET_MET, "most": -TARGET_MET}
            active_targets = {
                want.key: want.value + inside[want.kind] * abs(want.value)
                for want in self.wants
                if want.kind == "equal" or want.missed(by_key[want.key]) > -10 * TARGET_NEARLY
            }
            self._search(values, active_targets, {}, {}, x, BUDGET_NEAREST)
            if self.best[0] >= missed:
                return

    def _search(
        self, values: np.ndarray, targets: Any, equal: Any, limits: Any, begin: np.ndarray, budget: int
    ) -> None:
        """Search like ``fm.tune``; :meth:`evaluate` keeps the best design."""
        layout = layout_of({**dict.fromkeys(self.keys, 0.0), "change": np.zeros(len(self.free))})
        start = np.concatenate([values, np.zeros(len(self.free))])
        conditions: dict[str, Any] = {"targets": targets, "equal": equal, "limits": limits}
        problem = make_problem(layout, start, minimize=None, maximize=None, **conditions, margin=TARGET_NEARLY)
        unit = self.scaling.to_unit(begin)
        # Only optimisers of optax and optimistix trace or refuse designs.
        search_from(problem, self.kernel, _untraced, _untraced, unit, None, TARGET_NEARLY, budget)

    def _refuse_without_effect(self, values: np.ndarray, slopes: np.ndarray) -> None:
        for want in self.wants:
            i = self.keys.index(want.key)
            if want.missed(float(values[i])) > 0 and not np.any(slopes[i]):
                present, free = answer_text(float(values[i]), want.unit), listed(self.free)
                advice = "Let another dimension vary: write a name instead of a number."
                raise ValueError(f"{want} cannot be met. It is {present}, and {free} has no effect on it. {advice}")

    def told(self, stopped: bool = False) -> dict[str, Any]:
        """The result of :func:`meet`."""
        if self.best is None:
            nothing: dict[str, Any] = {"design": {}, "values": {}, "ops": [], "label": "", "met": False}
            return {**nothing, "text": "Stopped before the first design.", "stopped": stopped, "assumed": {}}
        rank, x, values = self.best
        ops, design = self._written(x)
        met = rank <= TARGET_MET
        targets_text = ", ".join(map(str, self.wants))
        before = self.document.names
        changes = [f"{op['name']} = {op['to']['value']} (was {before[op['name']]['value']})" for op in ops]
        if met and not ops:
            text = f"{targets_text}: already met."
        elif met:
            text = f"{targets_text}: met with {', '.join(changes)}."
        elif stopped:
            text = f"Stopped on the way to {targets_text}. Nearest so far: {', '.join(changes) or 'as it is'}."
        else:
            text = self._why(x, values)
        changed = {op["name"] for op in ops}
        for name, (low, high) in [pair for pair in self.assumed.items() if pair[0] in changed]:
            text += f" '{printable(name)}' has no bounds. The search used {low:.4g} to {high:.4g}."
        return {
            "status": "done" if met else "stopped" if stopped else "failed",
            "text": text,
            "design": design,
            "values": self._by_key(values),
            "ops": ops,
            "label": f"target {targets_text}",
            "met": met,
            "stopped": stopped,
            "assumed": {name: list(pair) for name, pair in self.assumed.items()},
        }

    def _why(self, x: np.ndarray, values: np.ndarray) -> str:
        """Which targets are not met, the nearest values, and what limits them."""
        by_key, unit = self._by_key(values), self.scaling.to_unit(x)
        bad = [w for w in self.wants if w.missed(by_key[w.key]) > TARGET_MET]
        not_reached = [f"{want} is not reached: it comes to {answer_text(by_key[want.key], want.unit)}" for want in bad]
        limits = []
        for name, u, low, high in zip(self.free, unit, self.scaling.lower, self.scaling.upper, strict=True):
            if min(u, 1 - u) < AT_BOUND:
                side, bound = ("lower", low) if u < 0.5 else ("upper", high)
                limits.append(f"{printable(name)} is at its {side} bound {bound:g}")
        for want in self.wants:
            if want not in bad and want.missed(by_key[want.key]) > -TARGET_AGAINST:
                limits.append(f"{want} stands against it")
        if len(bad) > 1:
            limits.append("they contradict each other")
        if self.failed is not RESULTS.successful and not limits:
            limits.append(f"further designs have no answer: {self.failed.message}")
        why = "; ".join(limits) or "no small change of a dimension brings it nearer"
        advice = "Widen the bounds" if limits else "Begin with other values"
        return f"{', '.join(not_reached)}; {why}. {advice}, or let more dimensions vary."

    def _written(self, x: np.ndarray) -> tuple[list[dict[str, Any]], dict[str, float]]:
        """The edit that writes a design with the fewest digits that meet the targets, and the design as written."""
        for digits in (12, 17):
            pairs = zip(self.free, x.tolist(), self.start.tolist(), strict=True)
            ops = name_ops(self.document, {name: v for name, v, before in pairs if v != before}, digits)
            design = dict(zip(self.free, self.start.tolist(), strict=True))
            design |= {op["name"]: float(op["to"]["value"]) for op in ops}
            everything = self.everything.copy()
            everything[self.places] = list(design.values())
            after = self.answers(everything)[0] if ops else None
            if after is None or self.best is None or self.best[0] > TARGET_MET or self.missed(after) <= TARGET_MET:
                break
        return ops, design


def bounds_of(document: Document, name: str, numbers: Mapping[str, Any]) -> tuple[tuple[float, float], bool]:
    """Bounds of a name, and whether one is a default."""
    value = float(numbers[f"names/{name}/value"])
    known = [numbers.get(f"names/{name}/{end}") for end in ("low", "high")]
    size = abs(value) * WIDE if value else 0.5 * point_extent(np.array(list(positions(document).values())))
    wide = sorted((value / WIDE, value * WIDE)) if value else [-size, size]
    low, high = (float(w if bound is None else bound) for bound, w in zip(known, wide, strict=True))
    if not low < high:
        raise ValueError(f"The bounds of '{printable(name)}' are {low:g} and {high:g}. The upper must be larger.")
    if not low <= value <= high:
        raise ValueError(f"'{printable(name)}' is {value:g}, outside its bounds {low:g} to {high:g}. Widen them.")
    return (low, high), None in known


def _depends_on_loads(key: str) -> bool:
    with contextlib.suppress(KeyError):
        return Asked(question_of(key, "")).question.of_loads
    return False


def _untraced(unit: Any) -> Any:
    raise AssertionError("Only optimisers of optax and optimistix trace.")
