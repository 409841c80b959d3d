"""Deformations and stress resultants of an element: "deformation leaf.2", "stress resultant leaf.bending"."""

from typing import Any

from .question import Question, at_rest, node_and_component


def _deformation(state: Any, argument: str) -> Any:
    element, number = node_and_component(argument)
    return at_rest(state).deformation(element, int(number) if number.isdecimal() else number)


def _resultant(state: Any, argument: str) -> Any:
    element, number = node_and_component(argument)
    return at_rest(state).stress_resultant(element, int(number) if number.isdecimal() else number)


QUESTIONS = (
    Question("deformation", ("element", "number"), _deformation, "m, rad", of_many=True),
    Question("stress resultant", ("element", "number"), _resultant, "N, N m", of_many=True),
)
