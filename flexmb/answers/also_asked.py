"""Questions that a command asks beside its mode, of each state of the answer."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import clean, heard
from ..questions.question import Asked, is_many
from ..questions.question import asked as of_state
from .answers import Answer


class QuestionError(ValueError):
    """There is no such question, or the mechanism has no answer to it."""


def also_asked(found: Answer, texts: Sequence[str]) -> dict[str, Any]:
    """Answers of questions by their texts, beside the keys and values of an answer.

    Raises:
        QuestionError: There is no such question, node, element or number; or the mode has no state.
    """
    if not texts or found.exit_status:
        return {}
    answers: dict[str, Any] = {}
    for text in texts:
        try:
            with heard():
                if is_many(found.found):
                    series = Asked(text).along(found.found)
                    answers[text] = {"values": series.values, "unit": series.unit}
                elif found.lin is None:
                    raise ValueError("this mode has no state to ask")
                else:
                    question = of_state(text)
                    answers[text] = {"values": float(np.asarray(question(found.lin))), "unit": question.unit}
        except (KeyError, ValueError, AttributeError) as fault:
            raise QuestionError(f"'{clean(text)}': {clean(fault.args[0] if fault.args else fault)}") from None
    return {"asked": answers}
