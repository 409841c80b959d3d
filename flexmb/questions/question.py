"""A question of a state by its text, such as "frequency 1", and the list of all questions: the files of this folder."""

import dataclasses
import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from ..linear.linearize import ManyStates
from ..linear.state_series import Series
from ..model.by_name import TURNS
from ..model.model import Labels, Model
from ..statics.equilibrium import equilibrium

ANGLES = ("phi", *TURNS)


@dataclasses.dataclass(frozen=True)
class Question:
    """A kind of question. flexmb finds the ``QUESTIONS`` of each file in this folder.

    Attributes:
        name: First words of the text. The question without a name is a coordinate, such as "top.x".
        takes: Kinds of the words after the name, which are joined by points: "number", "element", or "node" and "axis".
            A first word with a question mark, such as "element?", may be omitted.
        value: Function of a state and of the words after the name. A state is a Model at its equilibrium or a
            Linearization; with ``of_many`` also a path or a motion. The first axis of the value is then the axis of the
            states.
        unit: SI unit, or a function of the words after the name and of the mechanism's labels, if they are known.
        label: Label of an axis of a picture; by default the text of the question.
        kind: Common label of several such questions in a picture, such as "energy"; by default the name.
        only: "path" or "motion" if a single state has no answer; otherwise "".
        of_many: Whether ``value`` accepts a path or a motion.
        of_loads: Whether the question needs loads.
        differentiable: Whether ``value`` has derivatives by the numbers of the model.
    """

    name: str
    takes: tuple[str, ...]
    value: Callable[[Any, str], Any]
    unit: str | Callable[[str, Labels | None], str]
    label: str = ""
    kind: str = ""
    only: str = ""
    of_many: bool = False
    of_loads: bool = False
    differentiable: bool = True


@functools.cache
def questions() -> dict[str, Question]:
    """All questions by name. Longer names are first, so that "stress resultant" is not read as "stress"."""
    folder = importlib.import_module(str(__package__))
    modules = [importlib.import_module(f"{__package__}.{file.name}") for file in pkgutil.iter_modules(folder.__path__)]
    every = [question for module in modules for question in getattr(module, "QUESTIONS", ())]
    return {
        question.name: question for question in sorted(every, key=lambda question: (-len(question.name), question.name))
    }


def question_names(kind: str = "state") -> list[str]:
    """Names of the questions that a "state", a "path" or a "motion" answers; first names of this kind only."""
    named = [question for question in questions().values() if question.name]
    of_kind, every = (sorted(q.name for q in named if q.only == only) for only in (kind, ""))
    return [*of_kind, *every]


@dataclasses.dataclass(frozen=True)
class Asked:
    """A question by its text, as a function of a Model or a Linearization.

    Attributes:
        text: Such as "frequency 1", "stiffness top.y", "mass" or "top.x".
    """

    text: str

    @property
    def question(self) -> Question:
        """The question; a KeyError if there is none."""
        return self.parsed()[0]

    @property
    def unit(self) -> str:
        """SI unit of the answer."""
        return _unit(*self.parsed())

    def parsed(self, labels: Labels | None = None, kind: str = "") -> tuple[Question, str]:
        """The question, and the words after its name.

        Raises:
            KeyError: There is no such question.
        """
        text = str(self.text)
        if labels is not None and text in map(str, labels.x):
            return questions()[""], text
        for name, question in questions().items():
            if name and (text == name or text.startswith(f"{name} ")) and question.only in ("", kind or question.only):
                return question, text.removeprefix(name).strip()
        if "." not in text:
            known = ", ".join(question_names(kind or "state"))
            raise KeyError(f"no coordinate '{text}'; write node and component, such as tip.y, or ask for {known}")
        return questions()[""], text

    def __call__(self, state: Any) -> Float[Array, ""]:
        """The answer of one state.

        Raises:
            KeyError: The mechanism has no such node, element, component or number.
        """
        question, argument = self.parsed(state.labels)
        return question.value(state, argument)

    def along(self, result: Any) -> Series:
        """The answers of all states of a path or a motion."""
        kind = result.states().kind
        question, argument = self.parsed(result.labels, kind)
        if question.of_many:
            values = question.value(result, argument)
        else:
            values = [float(question.value(lin, argument)) for lin in each_linearization(result)]
        label = question.label if question.label and not argument else str(self.text)
        return Series(
            np.asarray(values), label, _unit(question, argument, result.labels), question.kind or question.name
        )


def _unit(question: Question, argument: str, labels: Labels | None = None) -> str:
    return question.unit if isinstance(question.unit, str) else question.unit(argument, labels)


def asked(text: str) -> Asked:
    """A question of a state by its text.

    Raises:
        KeyError: There is no such question.
        ValueError: A path or a motion alone answers it.
    """
    parsed = Asked(text)
    if parsed.question.only:
        raise ValueError(f"'{text}' is a question for a {parsed.question.only}, not for one state.")
    return parsed


def unit_of_question(text: str) -> str:
    """SI unit of a question by its text; "-" if it is no question."""
    try:
        return Asked(text).unit
    except KeyError:
        return "-"


def each_linearization(result: Any) -> Iterator[Any]:
    """Linearised equations of each state of a path or a motion, one after the other."""
    return (result.linearization(i) for i in range(len(result.x)))


def at_rest(state: Any) -> Any:
    """A state with coordinates, deformations and forces; the equilibrium of a Model."""
    return equilibrium(state) if isinstance(state, Model) else state


def model_of(state: Any) -> Model:
    """The mechanism of a state."""
    return state if isinstance(state, Model) else state.model


def is_many(state: Any) -> bool:
    """Whether it is a path or a motion."""
    return isinstance(state, ManyStates)


def node_and_component(text: str) -> tuple[str, str]:
    """Node and component of "top.x"; element and number likewise.

    Raises:
        KeyError: There is no point in it.
    """
    name, _, component = text.rpartition(".")
    if not name:
        raise KeyError(f"'{text}' is no component: write node and component, such as tip.y, element and number: leaf.2")
    return name, component


def number_along_axis(values: Any, word: str, text: str) -> Any:
    """One of the numbers along the last axis.

    Raises:
        KeyError: There is no such number.
    """
    count = values.shape[-1]
    if not is_index(text) or int(text) > count:
        raise KeyError(f"no {word} '{text}': they are numbered 1 to {count}")
    return values[..., int(text) - 1]


def is_index(text: str) -> bool:
    """Whether a text is a whole number from 1."""
    return text.isascii() and text.isdecimal() and int(text) > 0


def components_of(labels: Labels, node: str) -> list[str]:
    """Components of a node: "x", "y", "z" of its position, "phi" or "rx", "ry", "rz" of its rotation.

    Raises:
        KeyError: No such node.
    """
    axes: list[str] = []
    for part in labels.parts(node):
        symbols = [labels.x[i].symbol for i in labels.known(part)]
        axes += TURNS if symbols[0] == "l0" else symbols
    return axes


def component_answer(method: str, about: str = "") -> Callable[[Any, str], Any]:
    """Answer by a method of node and component; about axes by another method if there is one."""

    def value(state: Any, argument: str) -> Any:
        node, component = node_and_component(argument)
        return getattr(at_rest(state), about if about and component in ANGLES else method)(node, component)

    return value


def by_component(along: str, about: str) -> Callable[[str, Labels | None], str]:
    """Unit of a component of a node, along or about an axis."""
    return lambda argument, labels: about if argument.rpartition(".")[2] in ANGLES else along


def as_host_values(state: Any, values: Any) -> Any:
    """Values of a path or a motion as numpy arrays, of which JAX compiles no programs; others as they are."""
    return np.asarray(values) if is_many(state) else values


def finite_or_nan(values: np.ndarray) -> np.ndarray:
    """The numbers, NaN where one is not finite."""
    return np.where(np.isfinite(values), values, np.nan)


class Along(ManyStates):
    """Base class of a path and a motion."""

    def along(self: Any, text: str) -> Series:
        """Return one quantity in every state, by its name.

        - Node: "top.x", or "top.phi" for an angle (in space "top.rx"). "displacement top.x" counts from the undeformed
          mechanism; "displacement" is the largest displacement of all nodes. "force top.x" is ``force_needed``,
          "reaction foot.x" the force of a support. "stiffness top.y" has all other motions free.
        - Element: "deformation leaf.2", "stress resultant leaf.2"; "stress leaf", the largest von Mises stress.
        - Whole mechanism: "frequency 1", "mass"; "stress", the largest von Mises stress; "utilisation", the largest
          ratio of this stress to the strength.
        - Path only: "load factor", and "multiplier 1", the first load multiplier of buckling.
        - Motion only: "time", "velocity top.x", "acceleration top.x"; "kinetic", "elastic", "potential", and their sum
          "energy".

        Each file of ``flexmb/questions`` adds its questions.

        Raises:
            KeyError: There is no such quantity, node, element or component.
        """
        return Asked(text).along(self)
