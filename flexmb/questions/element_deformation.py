"""Deformations and stress resultants of an element: "deformation leaf.2", "stress resultant leaf.bending"."""

from functools import partial
from typing import Any

from .question import Question, at_rest, node_and_component


def _answer(method: str, state: Any, argument: str) -> Any:
    element, number = node_and_component(argument)
    return getattr(at_rest(state), method)(element, int(number) if number.isdecimal() else number)


QUESTIONS = tuple(
    Question(name, ("element", "number"), partial(_answer, name.replace(" ", "_")), unit, of_many=True)
    for name, unit in {"deformation": "m, rad", "stress resultant": "N, N m"}.items()
)
