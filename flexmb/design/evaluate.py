"""Answers of a function of named dimensions, with the code of a failure; designs that cannot be built."""

import contextlib
import difflib
import inspect
import sysconfig
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import noting
from ..build.carry import carried_choices, collected_models
from ..build.sound import checks_of
from ..compilation.compile import QUICK
from ..errors import AnalysisError, ModelError, SpacarError, printable
from ..model.model import Model
from ..model.topology import Parameters, Topology
from ..questions.question import asked
from ..results import ANSWERED, RESULTS, collected, worst_of

Build = Callable[..., Any]
Answer = Callable[[Any], Any] | str
Answers = Answer | Sequence[Answer] | Mapping[str, Answer]

# Cost of a reverse pass over the cost of a forward pass (benchmarks/first_impression.py).
REVERSE_COST = 2.0
# Faults of the numbers of a design.
REFUSED = (ModelError, SpacarError)


class UntraceableError(TypeError):
    """A function needs the number of a dimension, which JAX does not know yet."""


@contextlib.contextmanager
def traceable(what: str) -> Iterator[None]:
    """Turn errors of JAX within a user's function into an UntraceableError with its line and a remedy."""
    try:
        yield
    except (jax.errors.JAXTypeError, jax.errors.JAXIndexError) as fault:
        frames = [frame for frame in traceback.extract_tb(fault.__traceback__) if not _is_of_libraries(frame.filename)]
        where = (
            f" in line {frames[-1].lineno} of {Path(frames[-1].filename).name} ({frames[-1].line})" if frames else ""
        )
        raise UntraceableError(
            f"{what} needs the number of a dimension{where}, which is unknown during compilation and differentiation."
            " Use jax.numpy (jnp.cos) instead of numpy and math, jnp.where instead of `if`, and no float() or int() of"
            " a dimension. fm.sweep(.., compiled=False) accepts other functions."
        ) from fault


def subject_of(build: Build) -> str:
    """A function of dimensions, as the subject of a sentence."""
    return f"The function of dimensions '{printable(str(getattr(build, '__name__', build)))}'"


def _is_of_libraries(file: str) -> bool:
    path, python = Path(file), sysconfig.get_paths()
    folders = (Path(__file__).parents[1], python["stdlib"], python["platstdlib"])
    installed = {"site-packages", "dist-packages"} & set(path.parts)
    return file.startswith("<") or bool(installed) or any(path.is_relative_to(folder) for folder in folders)


def named_answers(answers: Answers) -> dict[str, Callable[[Any], Any]]:
    """Functions of answers by name; TypeError, ValueError or KeyError if they are wrong."""
    if isinstance(answers, Mapping):
        functions: dict[str, Any] = dict(answers)
    else:
        several = [answers] if isinstance(answers, str) or not isinstance(answers, Sequence) else list(answers)
        functions = {getattr(answer, "__name__", str(answer)): answer for answer in several}
        if len(functions) < len(several):
            raise ValueError("Two answers have the same name. Give them as a dictionary of names and functions.")
    for name, function in functions.items():
        if isinstance(function, str):
            functions[name] = asked(function)
        elif not callable(function):
            raise TypeError(
                f"Answer '{printable(name)}' must be a function of the model, but is {printable(repr(function))}."
            )
    if not functions:
        raise ValueError("Give at least one answer: a function of the model, such as fm.frequencies.")
    return functions


def check_answer_names(dimensions: Sequence[str], answers: Sequence[str], reserved: Sequence[str]) -> None:
    """Refuse names that would collide in a table or a file."""
    for kind, names in (("Dimension", dimensions), ("Answer", answers)):
        for name in names:
            if not isinstance(name, str) or not name or not name.isprintable() or name.endswith(".npy"):
                raise ValueError(
                    f"{kind} '{printable(name)}' must have a name of printable letters, not ending in .npy."
                )
            if name in reserved:
                raise ValueError(f"{kind} '{name}' must have another name. The result uses this one.")
    for name in answers:
        if name in dimensions:
            raise ValueError(f"Answer '{name}' has the name of a dimension. Choose another name.")


def check_dimensions(build: Build, names: Sequence[str], least: int = 1) -> None:
    """Refuse dimensions that a function does not accept, and report missing ones."""
    if not callable(build):
        text = printable(repr(build))
        raise TypeError(f"Argument `build` must be a function of dimensions that returns a model, but is {text}.")
    try:
        parameters = inspect.signature(build).parameters
    except (TypeError, ValueError):
        return
    accepted = [p for p in parameters.values() if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    known = [p.name for p in accepted]
    if len(names) < least:
        raise ValueError("Give at least one dimension.")
    listed = f"{getattr(build, '__name__', 'the function')}({', '.join(known)})"
    if not any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
        for name in names:
            if name not in known:
                similar = difflib.get_close_matches(name, known, 1)
                hint = f" Did you mean '{similar[0]}'?" if similar else ""
                raise ValueError(f"Dimension '{printable(name)}' is not one of {printable(listed)}.{hint}")
    missing = [p.name for p in accepted if p.default is p.empty and p.name not in names]
    if missing:
        raise ValueError(f"Dimension '{missing[0]}' of {printable(listed)} is not given.")


class Layout(NamedTuple):
    """Named arrays laid end to end: names and shapes, in order."""

    names: tuple[str, ...]
    shapes: tuple[tuple[int, ...], ...]

    @property
    def sizes(self) -> list[int]:
        """Numbers of entries."""
        return [int(np.prod(shape, dtype=int)) for shape in self.shapes]

    @property
    def labels(self) -> list[str]:
        """A name for every entry: "width", or "height[3]" where there are several."""
        labels = []
        for name, shape in zip(self.names, self.shapes, strict=True):
            labels += [name + (f"[{', '.join(map(str, at))}]" if at else "") for at in np.ndindex(*shape)]
        return labels

    def split(self, flat: Any) -> dict[str, Any]:
        """Named arrays from one vector, or from a vector with further axes."""
        ends = np.cumsum(self.sizes)
        parts = [flat[end - size : end] for size, end in zip(self.sizes, ends, strict=True)]
        return {
            name: part.reshape(shape + part.shape[1:])
            for name, shape, part in zip(self.names, self.shapes, parts, strict=True)
        }

    def stacked(self, points: Any) -> dict[str, Any]:
        """Named arrays with the designs first, from one row for each design."""
        return {name: np.moveaxis(np.asarray(part), -1, 0) for name, part in self.split(np.asarray(points).T).items()}

    def join(self, values: Mapping[str, Any]) -> np.ndarray:
        """One vector from named arrays of these shapes or scalars."""
        parts = []
        for name, shape in zip(self.names, self.shapes, strict=True):
            array = np.asarray(values[name], float)
            try:
                parts.append(np.broadcast_to(array, shape).ravel())
            except ValueError:
                raise ValueError(f"'{name}' has shape {shape}, but an array of shape {array.shape} is given.") from None
        return np.concatenate([np.zeros(0), *parts])


def layout_of(values: Mapping[str, Any]) -> Layout:
    """Layout of named numbers or arrays."""
    return Layout(tuple(values), tuple(np.shape(v) for v in values.values()))


def evaluate(
    build: Build, answers: Mapping[str, Callable[[Any], Any]], dimensions: Mapping[str, Any]
) -> tuple[dict[str, Float[Array, "..."]], Int[Array, ""]]:
    """Answers and a code of RESULTS, for use in a trace."""
    values = {}
    with collected() as codes:
        # `possible` finds designs that a concrete build refuses.
        with traceable(subject_of(build)), noting():
            model = build(**dimensions)
        for name, function in answers.items():
            with traceable(f"Answer '{name}'"):
                values[name] = _real(name, function(model))
    code = worst_of(codes)
    undefined = jnp.array(False)
    for value in values.values():
        undefined |= jnp.any(jnp.isnan(value))
    for answered in ANSWERED:
        code = jnp.where((code == int(answered)) & undefined, RESULTS.not_finite, code)
    return values, code.astype(jnp.int32)


def evaluate_concretely(
    build: Build, answers: Mapping[str, Callable[[Any], Any]], dimensions: Mapping[str, Any]
) -> tuple[dict[str, np.ndarray] | None, int]:
    """Answers and a code of RESULTS of one design, for analyses that cannot be traced."""
    try:
        try:
            model = build(**dimensions)
        except REFUSED:
            return None, int(RESULTS.impossible_design)
        with collected() as codes:
            values = {name: np.asarray(_real(name, function(model))) for name, function in answers.items()}
    except AnalysisError as fault:
        if fault.code not in RESULTS.__members__:
            raise
        return None, int(RESULTS[fault.code])
    undefined = any(np.any(np.isnan(v)) for v in values.values())
    return values, int(RESULTS.not_finite if undefined else max(codes, default=RESULTS.successful))


def _real(name: str, value: Any) -> Float[Array, "..."]:
    """A real array of double precision."""
    try:
        array = jnp.asarray(value)
    except (TypeError, ValueError):
        kind = type(value).__name__
        raise TypeError(f"Answer '{name}' must be a number or an array of numbers, but is {kind}.") from None
    if jnp.iscomplexobj(array):
        raise TypeError(f"Answer '{name}' is complex. Take its real part, its modulus or its damping instead.")
    return array.astype(float)


def build_once(build: Build, dimensions: Mapping[str, Any]) -> list[Model]:
    """Build on concrete numbers, which checks everything and finds degrees of freedom."""
    with collected_models() as models:
        build(**dimensions)
    return models


def first_built(build: Build, designs: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[Model]]:
    """The first design that can be built, and its models; the first fault if none can."""
    refused: Exception | None = None
    for i in range(len(next(iter(designs.values())))):
        design = {name: array[i] for name, array in designs.items()}
        try:
            return design, build_once(build, design)
        except REFUSED as fault:
            refused = refused or fault
    raise refused or ModelError("There are no designs.")


def with_slopes(function: Callable[..., Any], dimensions: int, answers: int) -> Callable[..., Any]:
    """A function that returns slopes, and values and code, of a function that returns values and code."""

    def twice(*arguments: Any):
        values, code = function(*arguments)
        return values, (values, code)

    return (jax.jacfwd if dimensions <= REVERSE_COST * answers else jax.jacrev)(twice, has_aux=True)


def flat_function(build: Build, answers: Mapping[str, Callable[[Any], Any]], layout: Layout, models: list[Model]):
    """A function from one vector of dimensions to one vector of answers and their code, and the layout of answers."""

    def named(flat: Float[Array, "n"]):
        with carried_choices(models):
            return evaluate(build, answers, layout.split(flat))

    def function(flat: Float[Array, "n"]):
        values, code = named(flat)
        return jnp.concatenate([jnp.ravel(v) for v in values.values()]), code

    of_answers, _ = jax.eval_shape(named, jax.ShapeDtypeStruct((sum(layout.sizes),), float))
    return function, layout_of({name: of_answers[name] for name in answers})


def refusal_of_designs(
    build: Callable[..., Any], models: list[Model], example: Mapping[str, Any]
) -> Callable[[Mapping[str, Any]], np.ndarray]:
    """Return a function from many designs to whether a concrete build would refuse each design, (designs,).

    A traced build cannot check its numbers: it would compute a frequency for a negative thickness. A program, traced
    from the build, computes the numbers of the models and the conditions on arguments of blocks and sections
    (:func:`flexmb.arguments.noting`). The host then checks that all numbers are finite and runs the checks of sections
    and elements. It ignores each check that finds a fault in the example, which was built.
    """

    def numbers(dimensions: dict[str, Any]):
        with carried_choices(models), collected_models() as built, noting() as conditions, traceable(subject_of(build)):
            build(**dimensions)
        return [model.parameters for model in built], conditions, [model.topology for model in built]

    # All designs have the same elements.
    program = jax.jit(jax.vmap(numbers, out_axes=(0, 0, None)), compiler_options=QUICK)

    def refused(designs: Mapping[str, Any]) -> np.ndarray:
        # The example is the first design.
        every_design = {
            name: np.concatenate([np.asarray(example[name], float)[None], v]) for name, v in designs.items()
        }
        impossible = np.zeros(len(next(iter(every_design.values()))), bool)
        every, conditions, topologies = jax.tree.map(np.asarray, program(every_design))
        for fine in conditions:
            impossible |= ~fine & fine[0]
        for parameters, topology in zip(every, topologies, strict=True):
            for faulty in _faulty(parameters, topology):
                impossible |= np.any(faulty & ~faulty[0], axis=1)
        return impossible[1:]

    return refused


def _faulty(parameters: Parameters, topology: Topology) -> Iterator[np.ndarray]:
    """Yield the result of each check of a model, (designs, places): True for a fault."""
    for leaf in jax.tree.leaves(parameters):
        yield ~np.isfinite(leaf.reshape(len(leaf), -1))
    for ask, numbers, function in checks_of(parameters, topology):
        yield _impossible_elements(ask, numbers, function)


def _impossible_elements(faults: Callable[[Any], list[str]], trees: Any, function: Callable[..., Any]) -> np.ndarray:
    """Return whether each element of each design has a fault, (designs, elements); equal numbers are checked once."""
    leaves, structure = jax.tree.flatten(trees)
    designs, elements = leaves[0].shape[:2]
    if function.__module__.startswith("flexmb.") and not faults(trees):
        # Our checks accept stacked numbers; a user's check may not.
        return np.zeros((designs, elements), bool)
    shapes = [leaf.shape[2:] for leaf in leaves]
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
    rows = np.concatenate([leaf.reshape(designs * elements, -1) for leaf in leaves], axis=1)
    different, places = np.unique(rows, axis=0, return_inverse=True)

    def faulty(row: np.ndarray) -> bool:
        parts = zip(np.split(row, ends[:-1]), shapes, strict=True)
        try:
            return bool(faults(jax.tree.unflatten(structure, [part.reshape(shape) for part, shape in parts])))
        except ModelError:
            return True

    # The first check finds numbers that are not finite. Other checks may raise on them.
    is_faulty = np.array([np.all(np.isfinite(row)) and faulty(row) for row in different], bool)
    return is_faulty[places.ravel()].reshape(designs, elements)
