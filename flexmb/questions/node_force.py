"""External force or moment that holds a node: "force top.x", "moment top.phi". Of a support: "reaction foot.x"."""

from .question import Question, by_component, component_answer

UNIT = by_component("N", "N m")
METHODS = {"force": "force_needed", "moment": "force_needed", "reaction": "reaction"}
QUESTIONS = tuple(
    Question(name, ("node", "axis"), component_answer(method), UNIT, of_many=True) for name, method in METHODS.items()
)
