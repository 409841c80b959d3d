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
    """What a mode is asked.

    Attributes:
        builder: Description of the mechanism.
        model: The mechanism, unchecked until :meth:`checked` is called.
        name: Name of its file.
        release, dofs: See ``Builder.build``.
        max_steps: Steps of a path at most.
        settings: What the file says beside the mechanism.
        lin: Linearisation that the mode has come to, which is told and drawn also where the mode then fails.
        warnings: What to say beside the answer, likewise.
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
        """What a long analysis is given as ``progress``."""
        return sys.stderr.isatty() if self.progress is None else self.progress

    def checked(self) -> Model:
        """The mechanism with its degrees of freedom, checked.

        Raises:
            MechanismError: It is over- or under-constrained.
        """
        self.model = self.builder.build(dofs=self.dofs, release=self.release)
        return self.model

    def about(self, lin: Linearization) -> Linearization:
        """Note the linearisation that is answered about, and warn of what nothing holds there."""
        self.lin = lin
        self.warnings += loose_warnings(lin)
        return lin

    def linearized(self) -> Linearization:
        """The linearisation about the equilibrium under the constant loads.

        Raises:
            MechanismError: As for :meth:`checked`.
            AnalysisError: There is no equilibrium.
        """
        return self.about(linearize(self.checked(), increment=0.0))


class Found(NamedTuple):
    """What a mode answers.

    Attributes:
        data: Keys and values beside those that all answers have; "status" and "message" where it is not "ok".
        result: What the analysis returned, which pictures show.
        picture: Function of :mod:`flexmb.plot` that draws the linearisation, in place of the result's own.
    """

    data: dict[str, Any]
    result: Any = None
    picture: str = ""


class Mode(NamedTuple):
    """One mode.

    Attributes:
        run: The analysis. What it raises, and a status other than "ok", are failures.
        table: Lines of the terminal, of the answer's keys and values, which are few where it failed.
        increments: Whether incremental loads act.
        structural: Whether the structure alone is asked about: no loads act, and a status is a finding, not a failure.
        needs: What it is told beside the mechanism, or cannot do without: "times", "trajectory" and "steps" (of a
            path); "loads", "cause" (of a motion: loads, start values or what is prescribed) and "signals".
        number: By which it is asked for, as in SPACAR; both this and the name are read from the name of the file.
        name: The same as a word.
    """

    run: Callable[[ModeRequest], Found]
    table: Callable[[dict[str, Any]], list[str]]
    increments: bool = False
    structural: bool = False
    needs: tuple[str, ...] = ()
    number: int = -1
    name: str = ""
