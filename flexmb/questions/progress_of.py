"""Progress along a path or a motion: "load factor" and "time"."""

from .question import Question

QUESTIONS = tuple(
    Question(name, (), lambda result, _: result.states().along, unit, only=only, of_many=True, differentiable=False)
    for name, unit, only in (("load factor", "-", "path"), ("time", "s", "motion"))
)
