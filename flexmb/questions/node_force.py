"""Forces and moments at a node: "force top.x" that holds it there, "moment top.phi", "reaction foot.x"."""

from typing import Any

from .question import Question, at_rest, by_component, split


def _needed(state: Any, rest: str) -> Any:
    return at_rest(state).force_needed(*split(rest))


def _reaction(state: Any, rest: str) -> Any:
    return at_rest(state).reaction(*split(rest))


UNIT = by_component("N", "N m")
QUESTIONS = (
    Question("force", "node", _needed, UNIT, of_many=True),
    Question("moment", "node", _needed, UNIT, of_many=True),
    Question("reaction", "node", _reaction, UNIT, of_many=True),
)
