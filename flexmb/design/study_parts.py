"""The parts of a study: models from files and functions, and answers."""

import contextlib
import dataclasses
import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import jax.errors
import jax.numpy as jnp

from ..errors import AnalysisError, ModelError, SpacarError, StudyError, first_line, printable
from ..model.model import Model
from ..questions.question import Asked
from ..spacar.read import read_spacar
from .evaluate import UntraceableError

# Errors of JAX where a function needs a number while it is traced.
UNTRACEABLE = (UntraceableError, jax.errors.JAXTypeError, jax.errors.JAXIndexError)


class RaisedError(StudyError):
    """A user's function raised."""


def message_of(fault: BaseException) -> str:
    """Return the first line of an error's message, without the quotes of a KeyError."""
    if isinstance(fault, KeyError) and fault.args:
        fault = ValueError(fault.args[0])
    return first_line(fault)


@contextlib.contextmanager
def naming_study(start: str, untraced: str = "") -> Iterator[None]:
    """Put a study's file before messages on its arguments; ``untraced`` explains errors of tracing."""
    try:
        yield
    except (StudyError, SpacarError, ModelError, AnalysisError):
        raise
    except UNTRACEABLE as fault:
        if not untraced:
            raise
        raise StudyError(f"{start}{untraced}: {first_line(fault)}") from fault
    except (ValueError, KeyError) as fault:
        raise StudyError(f"{start}{message_of(fault)}") from fault


class _Noted(dict):
    """Numbers by name, with the names that were asked for."""

    def __init__(self, numbers: dict[str, Any]):
        super().__init__(numbers)
        self.asked: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.asked.add(name)
        return super().__getitem__(name)


@dataclasses.dataclass(frozen=True)
class FromFile:
    """Builds the model of a SPACAR input file.

    Attributes:
        about: File and key of the study, for messages.
        source: Path of the input file.
        content: SHA-256 of the input file when the study was read.
        release: Argument of :meth:`flexmb.Builder.build`.
        fixed: Names and values of parameters without bounds.
        free: Names of the other parameters.
        warnings: Warnings of the last reading.
    """

    about: str
    source: Path
    content: str
    release: str
    fixed: tuple[tuple[str, float], ...]
    free: tuple[str, ...]
    warnings: list[str] = dataclasses.field(default_factory=list)

    def __call__(self, **free: Any) -> Model:
        """The model of a design."""
        numbers = _Noted({**dict(self.fixed), **free})
        read = read_spacar(self.source, numbers=numbers)
        for name in self.free:
            if name not in numbers.asked:
                raise StudyError(f"{self.about}: [parameters] {name}: '{read.name}' has no {{{name}}}.")
        self.warnings[:] = read.warnings
        return read.builder.build(release=self.release)


@dataclasses.dataclass(frozen=True)
class Called:
    """A user's function, whose faults are named.

    Attributes:
        about: File and key of the study, for messages.
        name: Text of the study, module:function.
        function: The function.
        fixed: Names and values of constant arguments.
        is_answer: Whether it must return numbers.
    """

    about: str
    name: str
    function: Callable[..., Any]
    fixed: tuple[tuple[str, float], ...] = ()
    is_answer: bool = False

    def __call__(self, *arguments: Any, **free: Any) -> Any:
        """Result of the function."""
        try:
            result = self.function(*arguments, **dict(self.fixed), **free)
        except (StudyError, SpacarError, AnalysisError, ModelError, *UNTRACEABLE):
            raise
        except (Exception, SystemExit) as fault:
            raise RaisedError(f"{self.about}: '{self.name}' raised {described_fault(fault)}.") from fault
        if not self.is_answer:
            return result
        try:
            array = jnp.asarray(result)
        except (TypeError, ValueError):
            array = None
        if array is None or jnp.iscomplexobj(array):
            kind = "complex" if array is not None else f"of type {type(result).__name__}"
            raise StudyError(f"{self.about}: '{self.name}' returned something {kind}. It must return numbers.")
        return result


def described_fault(fault: BaseException) -> str:
    """An exception in one line."""
    name, text = type(fault).__name__, first_line(fault)
    return name if text == name else f"{name}: {printable(text)}"


def function_of(about: str, folder: Path, text: str) -> Callable[..., Any]:
    """The function of a text module:function, with the module in a folder or installed."""
    module, _, name = text.partition(":")
    if not all(part.isidentifier() for part in (*module.split("."), *name.split("."))):
        raise StudyError(
            f"{about} must be module:function, such as 'own:stage' beside the study, not '{printable(text)}'."
        )
    try:
        function: Any = _module(folder, module)
        for part in name.split("."):
            function = getattr(function, part)
    except (Exception, SystemExit) as fault:
        raise StudyError(f"{about}: '{printable(text)}' cannot be imported: {described_fault(fault)}.") from fault
    if not callable(function):
        raise StudyError(f"{about}: '{printable(text)}' is of type {type(function).__name__}. It must be a function.")
    return function


def _module(folder: Path, name: str) -> ModuleType:
    beside = [folder.joinpath(*name.split("."))]
    beside = [path for path in (beside[0].with_suffix(".py"), beside[0] / "__init__.py") if path.is_file()]
    known = sys.modules.get(name)
    if beside and known is not None and Path(getattr(known, "__file__", None) or "").resolve() != beside[0].resolve():
        # Another module of this name is already loaded, and stays.
        spec: Any = importlib.util.spec_from_file_location(name, beside[0])
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    place = str(folder.resolve())
    sys.path.insert(0, place)
    try:
        importlib.invalidate_caches()
        return importlib.import_module(name)
    finally:
        sys.path.remove(place)


@dataclasses.dataclass(frozen=True)
class NamedAnswer:
    """A question about the model of a study; ``about`` is its file and key."""

    about: str
    asked: Asked

    def __call__(self, model: Any) -> Any:
        """The answer of a model."""
        name = self.asked.question.name or "coordinate"
        if not isinstance(model, Model):
            kind = type(model).__name__
            raise StudyError(f"{self.about}: {name} needs a Model, but `model` returns {kind}.")
        try:
            return self.asked(model)
        except (StudyError, AnalysisError, *UNTRACEABLE):
            raise
        except (ValueError, KeyError, TypeError) as fault:
            raise StudyError(f"{self.about}: {name}: {printable(message_of(fault))}") from fault
