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
from ..linear.buckling import buckling_loads
from ..linear.modes import frequencies
from ..linear.stress import stress
from ..model.model import Model
from ..spacar.read import read_spacar
from ..statics.equilibrium import equilibrium
from .evaluate import UntraceableError
from .objectives import mass, stiffness

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
        """The model of a design.

        Args:
            free: Values of the parameters with bounds.
        """
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
        """What the function returns.

        Args:
            arguments: What an answer is asked of.
            free: Values of the parameters with bounds, where a model is built.
        """
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

    Args:
        about: File and key of the study, for messages.
        folder: Where the module is looked for first.
        text: What the study has.

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
    """An answer by its name.

    Attributes:
        about: File and key of the study, for messages.
        kind: Name of the answer, one of KINDS.
        value: Number of a frequency or load multiplier, name of a node, or True.
        more: Axis of a stiffness, component of a coordinate, or None.
    """

    about: str
    kind: str
    value: Any
    more: Any = None

    def __call__(self, model: Any) -> Any:
        """The answer of a model."""
        if not isinstance(model, Model):
            kind = type(model).__name__
            raise StudyError(f"{self.about}: {self.kind} is asked of a Model, but `model` returns of type {kind}.")
        try:
            return getattr(self, f"_{self.kind}")(model)
        except (StudyError, AnalysisError, *UNTRACEABLE):
            raise
        except (ValueError, KeyError, TypeError) as fault:
            text = str(fault.args[0] if isinstance(fault, KeyError) and fault.args else fault)
            raise StudyError(f"{self.about}: {self.kind}: {(text.splitlines() or [''])[0]}") from fault

    def _frequency(self, model: Model) -> Any:
        return frequencies(model)[self._place(model, "natural frequency", "natural frequencies")]

    def _load_multiplier(self, model: Model) -> Any:
        return buckling_loads(model)[self._place(model, "load multiplier", "load multipliers")]

    def _place(self, model: Model, one: str, several: str) -> int:
        count = model.topology.n_q
        if self.value > count:
            there = f"{count} {one if count == 1 else several}"
            raise StudyError(
                f"{self.about}: {self.kind} = {self.value}, but the model has {there}, one for each degree of freedom."
            )
        return self.value - 1

    def _mass(self, model: Model) -> Any:
        return mass(model)

    def _stress(self, model: Model) -> Any:
        return stress(model).maximum

    def _utilisation(self, model: Model) -> Any:
        return jnp.max(stress(model).utilisation)

    def _stiffness(self, model: Model) -> Any:
        self._coordinates(model)
        return stiffness(model, str(self.value), self.more)

    def _coordinate(self, model: Model) -> Any:
        size = len(self._coordinates(model))
        if self.more > size:
            raise StudyError(
                f"{self.about}: component = {self.more}, but node '{self.value}' has coordinates 1 to {size}."
            )
        return equilibrium(model).at(str(self.value))[self.more - 1]

    def _coordinates(self, model: Model) -> list[int]:
        found = model.labels.coordinates(str(self.value))
        if not found:
            known = ", ".join(dict.fromkeys(entry.of for entry in model.labels.x if entry.kind != "internal"))
            raise StudyError(
                f"{self.about}: {self.kind}: there is no node '{clean(self.value)}'; there are {clean(known)}."
            )
        return found


# What an answer may be, by the key that says so, and the other keys that it takes.
KINDS: dict[str, tuple[str, ...]] = {
    "frequency": (),
    "load_multiplier": (),
    "mass": (),
    "stiffness": ("axis",),
    "coordinate": ("component",),
    "stress": (),
    "utilisation": (),
}
