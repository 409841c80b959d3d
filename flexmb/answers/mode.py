"""A mode of the command line: the ``MODE`` of a file ``mode_NUMBER_NAME`` of this room, found by its name."""

import dataclasses
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from ..build.builder import Builder
from ..linear.linearize import Linearization, linearize
from ..model.model import Model
from .answer_parts import loose_warnings


@dataclasses.dataclass
class ModeRequest:
    """Input of a mode.

    Attributes:
        builder: Description of the mechanism.
        model: The mechanism, unchecked until :meth:`checked` is called.
        name: Name of its file.
        release, dofs: See ``Builder.build``.
        max_steps: Steps of a path at most.
        settings: Statements of the file beside the mechanism.
        lin: Linearisation so far, reported and drawn even if the mode then fails.
        warnings: Warnings so far, likewise.
        progress: See ``simulate`` and ``path``; None: a bar where there is a terminal.
    """

    builder: Builder
    model: Model
    name: str
    release: str
    dofs: str
    max_steps: int
    settings: dict[str, Any]
    lin: Linearization | None = None
    warnings: list[str] = dataclasses.field(default_factory=list)
    progress: Callable[..., None] | bool | None = None

    @property
    def reported(self) -> Callable[..., None] | bool:
        """Argument ``progress`` of a long analysis."""
        return sys.stderr.isatty() if self.progress is None else self.progress

    def checked(self) -> Model:
        """The mechanism with its degrees of freedom, checked."""
        self.model = self.builder.build(dofs=self.dofs, release=self.release)
        return self.model

    def about(self, lin: Linearization) -> Linearization:
        """Note the linearisation of the answer, and warn of degrees of freedom that nothing holds."""
        self.lin = lin
        self.warnings += loose_warnings(lin)
        return lin

    def linearized(self) -> Linearization:
        """The linearisation about the equilibrium under the constant loads."""
        return self.about(linearize(self.checked(), increment=0.0))


class ModeResult(NamedTuple):
    """Outcome of a mode.

    Attributes:
        data: Keys and values of this mode; "status" and "message" if the status is not "ok".
        result: Result of the analysis, which pictures show.
        picture: Function of :mod:`flexmb.plot` that draws the linearisation instead of the result.
    """

    data: dict[str, Any]
    result: Any = None
    picture: str = ""


class Mode(NamedTuple):
    """One mode.

    Attributes:
        run: The analysis. Errors, and a status other than "ok", are failures.
        table: Lines of the terminal from the answer's keys and values, of which a failed answer has few.
        increments: Whether incremental loads act.
        structural: Whether only the structure is asked about: no loads act, and a status is a finding, not a failure.
        needs: Statements that the mode needs beside the mechanism: "times", "trajectory" and "steps" (of a path);
            "loads", "cause" (of a motion: loads, start values or prescribed motion) and "signals".
        number: Number as in SPACAR, from the name of the file.
        name: Name, from the name of the file.
        about: A sentence, from the docstring of the file.
    """

    run: Callable[[ModeRequest], ModeResult]
    table: Callable[[dict[str, Any]], list[str]]
    increments: bool = False
    structural: bool = False
    needs: tuple[str, ...] = ()
    number: int = -1
    name: str = ""
    about: str = ""
