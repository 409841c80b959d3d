"""Targets from texts with units, checked, and numbers written like the text before."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import shown
from ..display import listed, measured, short
from ..errors import clean
from ..questions.question import unit_of_question
from ..spacar.arithmetic import value_of
from .building import free_names
from .document import Document
from .traced import question_of

KINDS = {"equal": "=", "least": "≥", "most": "≤"}
PREFIXES = {"f": 1e-15, "p": 1e-12, "n": 1e-9, "µ": 1e-6, "u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}


@dataclasses.dataclass(frozen=True)
class Want:
    """A target: an answer by its key, "equal", "least" or "most", and a value in its SI unit without prefix."""

    key: str
    kind: str
    value: float
    unit: str

    def __str__(self) -> str:
        return f"{self.key} {KINDS[self.kind]} {text_of(self.value, self.unit)}"

    def missed(self, value: float) -> float:
        """Relative miss of a value [-]; zero or negative if it meets the target."""
        off = (value - self.value) / (abs(self.value) or 1.0)
        return {"equal": abs(off), "least": -off, "most": off}[self.kind]


def wants_of(given: Sequence[Mapping[str, Any]], names: Mapping[str, float]) -> list[Want]:
    """Checked targets."""
    found = []
    for target in given:
        key, kind = str(target.get("answer", "")), target.get("kind", "equal")
        if kind not in KINDS:
            raise ValueError(f"Target '{clean(key)}' is of kind {shown(kind)}. It must be equal, least or most.")
        unit = unit_of(key)
        found.append(Want(key, kind, value_in(key, str(target.get("value", "")), unit, names), unit))
    if not found:
        raise ValueError("There is no target. Give one, such as frequency 1 = 20 Hz.")
    for key in {want.key for want in found}:
        own = {want.kind: want.value for want in found if want.key == key}
        if len(own) < sum(want.key == key for want in found) or ("equal" in own and len(own) > 1):
            raise ValueError(f"'{clean(key)}' has two targets. Give one value, or a lower and an upper one.")
        if own.get("least", -np.inf) > own.get("most", np.inf):
            raise ValueError(f"'{clean(key)}' cannot be at least {own['least']:g} and at most {own['most']:g}.")
    return found


def label_of(given: Sequence[Mapping[str, Any]]) -> str:
    """Label of the edit that meets targets."""
    parts = [f"{t.get('answer')} {KINDS.get(str(t.get('kind', 'equal')), '?')} {t.get('value')}" for t in given]
    return clean(f"target {', '.join(parts)}")


def unit_of(key: str) -> str:
    """SI unit of an answer without prefix; empty if it has none, or if there is no such answer."""
    return unit_of_question(question_of(key, "")).removesuffix("-")


def value_in(key: str, text: str, unit: str, names: Mapping[str, float]) -> float:
    """A number from text such as "20", "20 Hz", "300 MPa", "2*f"."""
    rest, factor = text.strip(), 1.0
    if unit and rest.endswith(unit):
        rest = rest.removesuffix(unit)
        if rest and rest[-1] in PREFIXES and (len(rest) < 2 or not rest[-2].isalpha()):
            rest, factor = rest[:-1], PREFIXES[rest[-1]]
    try:
        value = float(value_of(rest.strip(), names)) * factor
    except ValueError as fault:
        form = f"a number [{unit or '-'}]" + (f", such as 20 {unit} or 20 k{unit}" if unit else "")
        raise ValueError(f"Target '{clean(key)}': '{clean(text)}' {fault}. Give {form}.") from None
    if not np.isfinite(value):
        raise ValueError(f"Target '{clean(key)}' is '{clean(text)}'. It must be finite.")
    return value


def text_of(value: float, unit: str) -> str:
    """An answer with its unit."""
    return f"{short(value)} {unit}".strip() if unit in ("", "kg") else measured(value, unit)


def number_like(text: str, value: float, digits: int) -> str:
    """A number with the exponent of another text: 0.76e-3 after 0.5e-3."""
    exponent = re.search(r"[eE]([-+]?\d+)\s*$", text)
    plain = f"{value:.{digits}g}"
    if exponent is None:
        return plain
    mantissa = f"{value / 10.0 ** int(exponent[1]):.{digits}g}"
    return f"{mantissa}{exponent[0].strip()}" if "e" not in mantissa else plain


def checked_free(document: Document, free: Sequence[str]) -> list[str]:
    """Names that may change."""
    known = free_names(document)
    for name in free:
        if name not in document.names:
            raise ValueError(f"There is no name '{clean(name)}' to change.")
        if name not in known:
            text = clean(document.names[name]["value"])
            raise ValueError(f"'{clean(name)}' is '{text}': it follows from other names. Choose from {listed(known)}.")
    if not known:
        raise ValueError("No dimension may change. Write a name, such as t, instead of a number, and give it a value.")
    return list(dict.fromkeys(free)) or known
