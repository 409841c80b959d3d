"""Load multipliers of linear buckling by their number: "multiplier 1"."""

from typing import Any

import numpy as np

from ..linear.buckling import buckling_loads
from ..model.model import Model
from .question import Question, finite_or_nan, is_many, number_along_axis


def _multiplier(state: Any, argument: str) -> Any:
    if not is_many(state):
        # Buckling scales incremental loads, which do not act in the state.
        raised = not isinstance(state, Model) and state.model.parameters.increment is not None
        model = state if isinstance(state, Model) else state.model
        return number_along_axis(buckling_loads(model, increment=0.0 if raised else None), "multiplier", argument)
    if state.states().kind != "path":
        raise KeyError("a motion has no load multipliers, only a path")
    if state.by_sparse:
        raise KeyError(
            "a path by sparse matrices has no load multipliers of all states: ask for one state, such as"
            " fm.buckling_loads(model, count=1, at=path, step=-1)"
        )
    return finite_or_nan(number_along_axis(np.asarray(state.multipliers), "multiplier", argument))


QUESTIONS = (Question("multiplier", ("number",), _multiplier, "-", of_many=True, of_loads=True),)
