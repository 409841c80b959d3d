"""What flexmb raises and warns of. Every message names the culprit and says what is right."""

import contextlib
import contextvars
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

# Files of the package, which a warning does not point at, nor at what calls its decorated functions.
_OWN = str(Path(__file__).parent)
# A name longer than this says nothing more to a reader; a file may hold a word of megabytes.
LONGEST = 80


def clean(text: Any) -> str:
    """A user's text as a message may show it: one line, printable, cut in its middle where it is long.

    The end stays, since a path ends with the name of its file. Escapes stand for what a terminal would act on.
    """
    try:
        text = str(text)
    except Exception:  # Whatever a user's own class does, or an integer of thousands of digits.
        text = f"<{type(text).__name__}>"
    cut = text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}...{text[-LONGEST // 2 :]} ({len(text)} characters)"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def first_line(fault: BaseException) -> str:
    """First line of what an exception says, without space around it; the name of its class where it says nothing."""
    return (str(fault).strip().splitlines() or [type(fault).__name__])[0]


class ModelError(ValueError):
    """A model is described wrongly: a node, element, property or number."""


class MechanismError(ModelError):
    """A mechanism is not valid: the counts or the rank of its constraints.

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
        path: Of a path that did not reach its end, the :class:`flexmb.paths.Path` up to there; otherwise None.
    """

    path: Any = None

    def __init__(self, code: str, message: str):
        super().__init__(message)
        self.code = code


class SpacarError(ValueError):
    """An input file is wrong; the message has one line a fault, with file, line and keyword."""


class StudyError(ValueError):
    """A design study is described wrongly; the message names file and key."""


class FlexmbWarning(UserWarning):
    """What is asked for is legal and answered, but likely not what was meant."""


class BeamTheoryWarning(FlexmbWarning):
    """A leaf spring is modelled by plain beams, which leave out what would change a stiffness."""


class CoarseWarning(FlexmbWarning):
    """A beam is bent or twisted further than one beam is right for, or stretched further than cubic beams are."""


class IdleWarning(FlexmbWarning):
    """A stress or a strain is given that does nothing, since its deformation is held or has no stiffness."""


def warn(text: str, category: type[FlexmbWarning] = FlexmbWarning) -> None:
    """Warn at the line outside of the package that led here; a category can be ignored."""
    listening = _HEARD.get()
    if listening is not None:
        said, but = listening
        if not issubclass(category, but):
            said.append(text)
        return
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_code.co_filename.startswith((_OWN, contextlib.__file__)):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)


_Heard = tuple[list[str], tuple[type[FlexmbWarning], ...]]
_HEARD: contextvars.ContextVar[_Heard | None] = contextvars.ContextVar("heard", default=None)


@contextlib.contextmanager
def heard(*but: type[FlexmbWarning]) -> Iterator[list[str]]:
    """Collect what the package warns of in this thread, but for some categories; other warnings pass."""
    said: list[str] = []
    token = _HEARD.set((said, but))
    try:
        yield said
    finally:
        _HEARD.reset(token)
