"""What flexmb raises. Every message names the culprit and says what is right."""

from typing import Any


class ModelError(ValueError):
    """A model is described wrongly: a node, element, property or number."""


class MechanismError(ModelError):
    """A mechanism is not valid: the counts or the rank of its constraints.

    Attributes:
        code: Short name of the fault: "overconstrained", "underconstrained", "both" or "dof".
    """

    def __init__(self, code: str, message: str):
        super().__init__(message)
        self.code = code


class AnalysisError(RuntimeError):
    """An analysis did not succeed.

    Attributes:
        code: Name of the member of RESULTS, such as "not_converged".
        path: Of a path that did not reach its end, the :class:`flexmb.Path` up to there; otherwise None.
    """

    path: Any = None

    def __init__(self, code: str, message: str):
        super().__init__(message)
        self.code = code


class SpacarError(ValueError):
    """An input file is wrong; the message has one line a fault, with file, line and keyword."""
