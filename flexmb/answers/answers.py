"""Answers of a mode and of additional questions as plain numbers, for the terminal and files of the command line."""

import dataclasses
import functools
import importlib
import math
import pkgutil
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .. import __version__
from ..build.builder import Builder
from ..build.dofs import complete_series
from ..errors import AnalysisError, IdleWarning, MechanismError, ModelError, heard, printable
from ..linear.linearize import Linearization
from ..mechanics.loads import LEAVES_OUT
from ..model.model import Entry, Model
from ..model.topology import RoleIndices
from ..questions.question import Asked, is_many
from ..questions.question import asked as of_state
from ..results import RESULTS
from ..spacar.actions import RATES_IDLE
from .answer_parts import number
from .mode import Mode, ModeRequest, ModeResult

# Default for the most steps of a path.
STEPS = 200


@functools.cache
def _files() -> dict[int, str]:
    """Names of the files of all modes, such as "mode_7_frequencies", by their numbers, without loading them."""
    files = [file.name for file in pkgutil.iter_modules(importlib.import_module(str(__package__)).__path__)]
    numbered = {int(name.split("_")[1]): name for name in files if name.startswith("mode_")}
    return dict(sorted(numbered.items()))


def modes() -> dict[int, Mode]:
    """All modes by their numbers."""
    return {number: mode_of(number) for number in _files()}


@functools.cache
def mode_of(number: int) -> Mode:
    """A mode by its number. Only its file is loaded."""
    file = _files()[number]
    module = importlib.import_module(f"{__package__}.{file}")
    about = (module.__doc__ or "").partition(":")[2].strip()
    return module.MODE._replace(number=number, name=file.split("_", 2)[2].replace("_", "-"), about=about)


@dataclasses.dataclass(frozen=True)
class Answer:
    """What an analysis found.

    Attributes:
        data: Keys and values, all numbers plain or numpy arrays.
        exit_status: 0 answered, 1 not valid or not converged.
        model: The mechanism, if it could be built.
        lin: Its linearisation, if there is one.
        found: Result of the analysis, such as Modes; None for a state space.
        picture: Function of :mod:`flexmb.plot` that draws the linearisation instead of the result.
    """

    data: dict[str, Any]
    exit_status: int
    model: Model | None = None
    lin: Linearization | None = None
    found: Any = None
    picture: str = ""

    @property
    def shown(self) -> Any:
        """Content of the picture: the result; if it has no picture, the linearisation or the mechanism."""
        if self.found is not None and self.found.summary().picture != "mechanism":
            return self.found
        return self.model if self.lin is None else self.lin


def _dofs(model: Model) -> list[dict[str, Any]]:
    def named(kind: str, indices: RoleIndices, entries: Sequence[Entry]):
        for i in np.asarray(indices.dof).tolist():
            yield {"kind": kind, "of": number(entries[i].of), "component": entries[i].component}

    return [*named("x", model.topology.x, model.labels.x), *named("e", model.topology.e, model.labels.e)]


def answer(
    builder: Builder,
    name: str,
    mode: int,
    warnings: list[str] | None = None,
    release: str = "none",
    dofs: str = "named",
    max_steps: int | None = None,
    settings: dict[str, Any] | None = None,
    progress: Callable[..., None] | bool | None = None,
) -> Answer:
    """Run one analysis mode."""
    data: dict[str, Any] = {"model": name, "mode": mode, "flexmb": __version__, "status": "ok", "message": ""}
    data["warnings"] = reader_warnings(mode, warnings or [])
    # The reader of the file has warned of idle statements with their lines. Overflow that matters ends as a number that
    # is not finite, which has a status.
    with heard(IdleWarning) as heard_warnings, np.errstate(all="ignore"):
        model = complete_series(builder, builder.build(check=False))
        data["warnings"] += _increment_warnings(builder, mode_of(mode))
        if max_steps is not None and "steps" not in mode_of(mode).needs:
            data["warnings"].append(
                f"The largest number of steps ({max_steps}) applies to a path, mode 10: it has no effect here."
            )
        most = STEPS if max_steps is None else max_steps
        question = ModeRequest(builder, model, name, release, dofs, most, settings or {}, progress=progress)
        mode_answer = _answered(question, mode_of(mode), data)
    # Idle incremental loads are reported by the keywords of the file.
    data["warnings"] += dict.fromkeys(text for text in heard_warnings if LEAVES_OUT not in text)
    return mode_answer


def _answered(question: ModeRequest, mode: Mode, data: dict[str, Any]) -> Answer:
    """Fill in the keys and values of an answer."""
    failed = 0
    try:
        mode_result = mode.run(question)
        failed = int(not mode.structural and mode_result.data.get("status", "ok") != "ok")
    except (MechanismError, AnalysisError) as fault:
        mode_result, failed = ModeResult({"status": fault.code, "message": str(fault)}), 1
    except ModelError as fault:
        # For example an output that does not exist in this mode.
        mode_result, failed = ModeResult({"status": "not_valid", "message": str(fault)}), 1
    data.update(question.model.counts())
    data["dofs"] = _dofs(question.model)
    data["warnings"] += question.warnings
    values = mode_result.data
    bad = [key for key, value in values.items() if not _finite({key: value})]
    if failed:
        values = {key: value for key, value in values.items() if key not in bad}
    elif bad:
        values = {"status": RESULTS.not_finite.name, "message": f"{RESULTS.not_finite.message} ({', '.join(bad)})"}
        failed = 1
    data.update(values)
    return Answer(data, failed, question.model, question.lin, mode_result.result, mode_result.picture)


def _finite(value: Any) -> bool:
    """Whether all numbers in a value are finite."""
    if isinstance(value, dict):
        # A free motion is infinitely compliant: null in JSON.
        return all(_finite(v) for key, v in value.items() if key != "compliance")
    if isinstance(value, list | tuple):
        return all(map(_finite, value))
    if type(value) is float:
        return math.isfinite(value)
    numeric = isinstance(value, float | complex | np.generic) or (
        isinstance(value, np.ndarray) and value.dtype.kind in "fc"
    )
    return not numeric or bool(np.all(np.isfinite(value)))


def _increment_warnings(builder: Builder, mode: Mode) -> list[str]:
    """Warning of incremental loads that do not act in a mode."""
    hidden = (m for m in builder.members.values() if m.hidden)
    has_increments = any(builder.loads["increment"].values()) or any(m.properties.get("incremental") for m in hidden)
    if not has_increments or mode.increments or mode.structural:
        return []
    return [
        "Incremental loads (DELXF, DELESIG, DELINPX, DELINPE) act in modes"
        f" {' and '.join(str(item.number) for item in modes().values() if item.increments)}: mode {mode.number} answers"
        " without them."
    ]


def reader_warnings(mode: int, warnings: Sequence[str]) -> list[str]:
    """Warnings of the reader of the file that apply to a mode."""
    moves = "times" in mode_of(mode).needs
    return [text for text in warnings if not (moves and text.endswith(RATES_IDLE))]


def plain(value: Any) -> Any:
    """Value with numpy arrays as lists and numbers that are not finite as None, for JSON."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


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
            raise QuestionError(f"'{printable(text)}': {printable(fault.args[0] if fault.args else fault)}") from None
    return {"asked": answers}
