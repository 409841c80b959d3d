"""Targets: reads their texts with units, checks them, and writes tuned numbers in the notation of the old text."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import short_repr
from ..display import listed, quantity_text, short
from ..errors import printable
from ..questions.question import unit_of_question
from ..spacar.arithmetic import arithmetic_result
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
        return f"{self.key} {KINDS[self.kind]} {answer_text(self.value, self.unit)}"

    def missed(self, value: float) -> float:
        """Relative miss of a value [-]; zero or negative if it meets the target."""
        off = (value - self.value) / (abs(self.value) or 1.0)
        return {"equal": abs(off), "least": -off, "most": off}[self.kind]


def wants_of(given: Sequence[Mapping[str, Any]], names: Mapping[str, float]) -> list[Want]:
    """Checked targets."""
    wants = []
    for target in given:
        key, kind = str(target.get("answer", "")), target.get("kind", "equal")
        if kind not in KINDS:
            known = "It must be equal, least or most."
            raise ValueError(f"Target '{printable(key)}' is of kind {short_repr(kind)}. {known}")
        unit = answer_unit(key)
        wants.append(Want(key, kind, wanted_value(key, str(target.get("value", "")), unit, names), unit))
    if not wants:
        raise ValueError("There is no target. Give one, such as frequency 1 = 20 Hz.")
    for key in {want.key for want in wants}:
        by_kind = {want.kind: want.value for want in wants if want.key == key}
        if len(by_kind) < sum(want.key == key for want in wants) or ("equal" in by_kind and len(by_kind) > 1):
            raise ValueError(f"'{printable(key)}' has two targets. Give one value, or a lower and an upper one.")
        if (least := by_kind.get("least", -np.inf)) > (most := by_kind.get("most", np.inf)):
            raise ValueError(f"'{printable(key)}' cannot be at least {least:g} and at most {most:g}.")
    return wants


def label_of(given: Sequence[Mapping[str, Any]]) -> str:
    """Label of the edit that meets targets."""
    parts = [f"{t.get('answer')} {KINDS.get(str(t.get('kind', 'equal')), '?')} {t.get('value')}" for t in given]
    return printable(f"target {', '.join(parts)}")


def answer_unit(key: str) -> str:
    """SI unit of an answer without prefix; empty if it has none, or if there is no such answer."""
    return unit_of_question(question_of(key, "")).removesuffix("-")


def wanted_value(key: str, text: str, unit: str, names: Mapping[str, float]) -> float:
    """A number from text such as "20", "20 Hz", "300 MPa", "2*f"."""
    number_text, factor = text.strip(), 1.0
    if unit and number_text.endswith(unit):
        number_text = number_text.removesuffix(unit)
        if number_text and number_text[-1] in PREFIXES and (len(number_text) < 2 or not number_text[-2].isalpha()):
            number_text, factor = number_text[:-1], PREFIXES[number_text[-1]]
    try:
        value = float(arithmetic_result(number_text.strip(), names)) * factor
    except ValueError as fault:
        form = f"a number [{unit or '-'}]" + (f", such as 20 {unit} or 20 k{unit}" if unit else "")
        raise ValueError(f"Target '{printable(key)}': '{printable(text)}' {fault}. Give {form}.") from None
    if not np.isfinite(value):
        raise ValueError(f"Target '{printable(key)}' is '{printable(text)}'. It must be finite.")
    return value


def answer_text(value: float, unit: str) -> str:
    """An answer with its unit."""
    return f"{short(value)} {unit}".strip() if unit in ("", "kg") else quantity_text(value, unit)


def number_like(text: str, value: float, digits: int) -> str:
    """A number with the exponent of another text: 0.76e-3 after 0.5e-3."""
    exponent = re.search(r"[eE]([-+]?\d+)\s*$", text)
    plain = f"{value:.{digits}g}"
    if exponent is None:
        return plain
    mantissa = f"{value / 10.0 ** int(exponent[1]):.{digits}g}"
    return f"{mantissa}{exponent[0].strip()}" if "e" not in mantissa else plain


def name_ops(document: Document, values: Mapping[str, float], digits: int) -> list[dict[str, Any]]:
    """The edit that sets names, in the notation of their present values."""
    texts = {name: number_like(document.names[name]["value"], value, digits) for name, value in values.items()}
    return [{"op": "name", "name": n, "to": {**document.names[n], "value": text}} for n, text in texts.items()]


def checked_free(document: Document, free: Sequence[str]) -> list[str]:
    """Names that may change."""
    known = free_names(document)
    for name in free:
        if name not in document.names:
            raise ValueError(f"There is no name '{printable(name)}' to change.")
        if name not in known:
            text = f"'{printable(name)}' is '{printable(document.names[name]['value'])}'"
            raise ValueError(f"{text}: it follows from other names. Choose from {listed(known)}.")
    if not known:
        raise ValueError("No dimension may change. Write a name, such as t, instead of a number, and give it a value.")
    return list(dict.fromkeys(free)) or known
