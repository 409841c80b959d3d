"""Progress along a path or a motion: "load factor" and "time"."""

from typing import Any

from .question import Question


def _along(result: Any, argument: str) -> Any:
    return result.states().along


QUESTIONS = (
    Question("load factor", (), _along, "-", only="path", of_many=True, differentiable=False),
    Question("time", (), _along, "s", only="motion", of_many=True, differentiable=False),
)
