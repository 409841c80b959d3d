"""What a study is made of: models from files and functions, and answers."""

import dataclasses
import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import jax.errors
import jax.numpy as jnp

from ..errors import AnalysisError, ModelError, SpacarError, StudyError, clean, first_line
from ..files import read_whole
from ..model.model import Model
from ..questions.question import Asked
from ..spacar.read import read_spacar
from .evaluate import UntraceableError

# What JAX raises where a function asks for a number while it is traced.
UNTRACEABLE = (UntraceableError, jax.errors.JAXTypeError, jax.errors.JAXIndexError)


class RaisedError(StudyError):
    """A user's function raised."""


class _Noted(dict):
    """Numbers by name, which notes the names that were asked for."""

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
        source: The input file.
        content: Of it, as a SHA-256: that of the file when the study was read.
        release: As of :meth:`flexmb.Builder.build`.
        fixed: Parameters without bounds, name and value.
        free: Names of the others.
        warnings: Of the last time that the file was read.
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
                raise StudyError(f"{self.about}: [parameters] {name}: '{read.name}' has no {{{name}}} to put it in.")
        self.warnings[:] = read.warnings
        return read.builder.build(release=self.release)


def content_of(source: Path) -> str:
    """Content of a file, as a SHA-256."""
    return hashlib.sha256(read_whole(source)).hexdigest()


@dataclasses.dataclass(frozen=True)
class Called:
    """A user's function, whose faults are named.

    Attributes:
        about: File and key of the study, for messages.
        name: As the study has it, module:function.
        function: The function.
        fixed: Named arguments that stay, name and value.
        is_answer: Whether it must return numbers.
    """

    about: str
    name: str
    function: Callable[..., Any]
    fixed: tuple[tuple[str, float], ...] = ()
    is_answer: bool = False

    def __call__(self, *arguments: Any, **free: Any) -> Any:
        """What the function returns."""
        try:
            found = self.function(*arguments, **dict(self.fixed), **free)
        except (StudyError, SpacarError, AnalysisError, ModelError, *UNTRACEABLE):
            raise
        except (Exception, SystemExit) as fault:
            raise RaisedError(f"{self.about}: '{self.name}' raised {said(fault)}.") from fault
        if not self.is_answer:
            return found
        try:
            array = jnp.asarray(found)
        except (TypeError, ValueError):
            array = None
        if array is None or jnp.iscomplexobj(array):
            what = "complex" if array is not None else f"of type {type(found).__name__}"
            raise StudyError(f"{self.about}: '{self.name}' must return a number or an array of them, but it is {what}.")
        return found


def said(fault: BaseException) -> str:
    """What an exception says, in one line."""
    name, text = type(fault).__name__, first_line(fault)
    return name if text == name else f"{name}: {clean(text)}"


def function_of(about: str, folder: Path, text: str) -> Callable[..., Any]:
    """A function named as module:function, the module in a folder or installed.

    Raises:
        StudyError: There is none.
    """
    module, _, name = text.partition(":")
    if not all(part.isidentifier() for part in (*module.split("."), *name.split("."))):
        raise StudyError(f"{about} must be module:function, such as 'own:stage' beside the study, not '{clean(text)}'.")
    try:
        found: Any = _module(folder, module)
        for part in name.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as fault:
        raise StudyError(f"{about}: cannot take '{clean(text)}': {said(fault)}.") from fault
    if not callable(found):
        raise StudyError(f"{about}: '{clean(text)}' is no function, but of type {type(found).__name__}.")
    return found


def _module(folder: Path, name: str) -> ModuleType:
    beside = [folder.joinpath(*name.split("."))]
    beside = [path for path in (beside[0].with_suffix(".py"), beside[0] / "__init__.py") if path.is_file()]
    known = sys.modules.get(name)
    if beside and known is not None and Path(getattr(known, "__file__", None) or "").resolve() != beside[0].resolve():
        # A module of this name is loaded from elsewhere, and stays what it is to others.
        spec: Any = importlib.util.spec_from_file_location(name, beside[0])
        found = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(found)
        return found
    place = str(folder.resolve())
    sys.path.insert(0, place)
    try:
        importlib.invalidate_caches()
        return importlib.import_module(name)
    finally:
        sys.path.remove(place)


@dataclasses.dataclass(frozen=True)
class NamedAnswer:
    """A question that a study asks of its model.

    Attributes:
        about: File and key of the study, for messages.
        asked: The question.
    """

    about: str
    asked: Asked

    def __call__(self, model: Any) -> Any:
        """The answer of a model."""
        name = self.asked.question.name or "coordinate"
        if not isinstance(model, Model):
            kind = type(model).__name__
            raise StudyError(f"{self.about}: {name} is asked of a Model, but `model` returns of type {kind}.")
        try:
            return self.asked(model)
        except (StudyError, AnalysisError, *UNTRACEABLE):
            raise
        except (ValueError, KeyError, TypeError) as fault:
            text = str(fault.args[0] if isinstance(fault, KeyError) and fault.args else fault)
            raise StudyError(f"{self.about}: {name}: {clean((text.splitlines() or [''])[0])}") from fault
