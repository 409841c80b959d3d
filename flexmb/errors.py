"""Exceptions and warnings of flexmb. Each message names the culprit and states what is right."""

import contextlib
import contextvars
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .collecting import setting

# Files of the package and of its context managers, which warnings do not point at.
_OWN = str(Path(__file__).parent)
# Longest name in a message; a file may contain a word of megabytes.
LONGEST = 80


def printable(text: Any) -> str:
    """A user's text for a message: one line, printable, long texts cut in the middle.

    The end stays, as paths end with the file name. Escapes replace control characters.
    """
    try:
        text = str(text)
    except Exception:  # A user's class may raise anything; so may an integer of thousands of digits.
        text = f"<{type(text).__name__}>"
    cut = text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}...{text[-LONGEST // 2 :]} ({len(text)} characters)"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def first_line(fault: BaseException) -> str:
    """First line of an exception's text; the name of its class if it has none."""
    return (str(fault).strip().splitlines() or [type(fault).__name__])[0]


class ModelError(ValueError):
    """A model is described wrongly: a node, element, property or number."""


class MechanismError(ModelError):
    """A mechanism is not valid: numbers or rank of its constraints are wrong.

    Attributes:
        code: Short name of the fault: "overconstrained", "underconstrained", "both", "dof" or "too_large".
    """

    def __init__(self, code: str, message: str):
        super().__init__(message)
        self.code = code


class AnalysisError(RuntimeError):
    """An analysis did not succeed.

    Attributes:
        code: Name of the member of RESULTS, such as "not_converged".
        path: The :class:`flexmb.paths.Path` so far, if a path did not reach its end; otherwise None.
    """

    path: Any = None

    def __init__(self, code: str, message: str):
        super().__init__(message)
        self.code = code


class SpacarError(ValueError):
    """An input file is wrong; the message has one line per fault, with file, line and keyword."""


class StudyError(ValueError):
    """A design study is described wrongly; the message names file and key."""


class FlexmbWarning(UserWarning):
    """A call is valid and returns an answer, but is probably not what you meant."""


class BeamTheoryWarning(FlexmbWarning):
    """A leaf spring is modelled by plain beams, which neglect effects on its stiffness."""


class CoarseWarning(FlexmbWarning):
    """A beam is bent or twisted too far for one beam, stretched too far for cubic beams, or wide and bent too far."""


class IdleWarning(FlexmbWarning):
    """A given stress or strain has no effect: its deformation is FIXED, PRESCRIBED or without stiffness."""


def warn(text: str, category: type[FlexmbWarning] = FlexmbWarning) -> None:
    """Warn, and report the line of the user's code that called the package."""
    listening = _HEARD.get()
    if listening is not None:
        messages, but = listening
        if not issubclass(category, but):
            messages.append(text)
        return
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_code.co_filename.startswith((_OWN, contextlib.__file__)):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)


_Heard = tuple[list[str], tuple[type[FlexmbWarning], ...]]
_HEARD: contextvars.ContextVar[_Heard | None] = contextvars.ContextVar("heard", default=None)


@contextlib.contextmanager
def heard(*but: type[FlexmbWarning]) -> Iterator[list[str]]:
    """Collect warnings of the package in this thread, except some categories; other warnings pass."""
    with setting(_HEARD, ([], but)) as (messages, _):
        yield messages
