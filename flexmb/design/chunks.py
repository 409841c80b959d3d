"""Chunks of designs: compiled once, on all cores or by an executor."""

import functools
import logging
import os
import pickle
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from typing import Any, NamedTuple

import jax
import numpy as np

from ..build.carry import carried_choices
from ..compilation.by_meaning import jit
from ..compilation.threads import cores, in_threads
from ..results import ANSWERED, RESULTS
from .evaluate import REFUSED, Build, build_once, evaluate, evaluate_concretely, refusal_of_designs

# The process that imported this module; a fork has another number.
_IMPORTED_BY = os.getpid()
# Answers by name, (designs, ...), and codes, (designs,).
Values = tuple[dict[str, np.ndarray], np.ndarray]


class Task(NamedTuple):
    """The computation for every design.

    Attributes:
        build: Function of named dimensions.
        functions: Answers by name.
        compiled: Whether to compile.
        together: Number of designs computed at once.
        example: Dimensions of a design that can be built, whose degrees of freedom all designs have; None if each
            design has its own.
    """

    build: Build
    functions: dict[str, Callable[[Any], Any]]
    compiled: bool
    together: int
    example: dict[str, np.ndarray] | None


class Chunk(NamedTuple):
    """Some designs, filled up with the last to a constant size; ``real`` of them count."""

    designs: dict[str, np.ndarray]
    real: int


def chunk_of(designs: Mapping[str, np.ndarray], rows: np.ndarray, size: int) -> Chunk:
    """A chunk of some designs."""
    filled = np.concatenate([rows, np.repeat(rows[-1:], size - len(rows))])
    return Chunk({name: array[filled] for name, array in designs.items()}, len(rows))


class Worker:
    """Computes chunks, on the cores of this machine or by an executor, and compiles once."""

    def __init__(self, task: Task, executor: Executor | None):
        self.executor = executor
        self.work: Any = kernel_of(task, threads=cores()) if executor is None else _packed(task)

    def results(self, parts: list[Chunk]) -> Iterator[tuple[int, Values]]:
        """Number and answers of each chunk, as soon as they are known."""
        if self.executor is None:
            for index, part in enumerate(parts):
                yield index, self.work(part)
            return
        import concurrent.futures

        asked = os.getpid(), jax.config.values["jax_compilation_cache_dir"]
        futures = [self.executor.submit(_work, self.work, part, *asked) for part in parts]
        if all(isinstance(f, concurrent.futures.Future) for f in futures):
            places = {future: index for index, future in enumerate(futures)}
            for future in concurrent.futures.as_completed(futures):
                yield places[future], future.result()
        else:
            for index, future in enumerate(futures):
                yield index, future.result()


def _packed(task: Task) -> Any:
    """The task as bytes, which a worker unpacks and compiles once; unchanged if it cannot be packed."""
    try:
        return pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError):
        try:
            import cloudpickle  # pyright: ignore[reportMissingImports]
        except ImportError:
            return task
        return cloudpickle.dumps(task)


def _work(sent: Any, part: Chunk, asking: int, cache: str | None) -> Values:
    """One chunk in a worker, which may be another process."""
    if os.getpid() not in (asking, _IMPORTED_BY):
        # A fork copies no threads of JAX, and would wait for them for ever.
        raise ValueError(
            "Argument `executor` is a pool of forked processes, in which JAX hangs. Use"
            " ProcessPoolExecutor(mp_context=multiprocessing.get_context('spawn'))."
        )
    from ..setup import enable_cache, enable_x64

    if not jax.config.values["jax_enable_x64"]:
        enable_x64()
    if cache is not None and not jax.config.values["jax_compilation_cache_dir"]:
        try:
            enable_cache(cache)
        except OSError as fault:
            logging.getLogger("flexmb").warning("a worker of a sweep compiles without a cache: %s", fault)
    return (_unpacked(sent) if isinstance(sent, bytes) else kernel_of(sent))(part)


@functools.lru_cache(maxsize=8)
def _unpacked(sent: bytes) -> Callable[[Chunk], Values]:
    return kernel_of(pickle.loads(sent))


def kernel_of(task: Task, *, threads: int = 1) -> Callable[[Chunk], Values]:
    """The function that computes a chunk."""
    if not task.compiled or task.example is None:
        return functools.partial(_concrete_values, task.build, task.functions)
    return _Compiled(task, task.example, threads)


class _Compiled:
    """Designs in one compiled program, with an equal number for each thread.

    Designs with other clamps than the example have another structure, and a program of their own.
    """

    def __init__(self, task: Task, example: dict[str, np.ndarray], threads: int):
        self.task, self.others = task, None
        models = build_once(task.build, example)

        def one(dimensions: dict[str, Any]):
            with carried_choices(models):
                return evaluate(task.build, task.functions, dimensions)

        def every(part: dict[str, Any]):
            return jax.lax.map(one, part, batch_size=task.together if task.together > 1 else None)

        self.program = jit(every)
        self.refused = refusal_of_designs(task.build, models, example)
        self.example, self.threads, self.is_compiled = example, threads, False

    def __call__(self, part: Chunk) -> Values:
        values, codes = self._computed(part)
        rows = np.flatnonzero(codes == RESULTS.other_clamps)
        while len(rows):
            example = {name: array[rows[0]] for name, array in part.designs.items()}
            if all(np.array_equal(array, self.example[name]) for name, array in example.items()):
                # A design has the clamps of itself.
                codes[rows] = RESULTS.successful
                break
            try:
                self.others = _Compiled(self.task, example, self.threads) if self.others is None else self.others
            except REFUSED:
                codes[rows[0]], rows = RESULTS.impossible_design, rows[1:]
                continue
            try:
                other_values, other_codes = self.others(
                    chunk_of(part.designs, rows, len(next(iter(part.designs.values()))))
                )
            except (ValueError, *REFUSED):
                # The other structure lacks an answer.
                break
            if all(array.shape[1:] == values[name].shape[1:] for name, array in other_values.items()):
                values = {name: array.copy() for name, array in values.items()}
                for name, array in other_values.items():
                    values[name][rows] = array
                codes[rows] = other_codes
            break
        return values, codes

    def _computed(self, part: Chunk) -> Values:
        refused = self.refused(part.designs)
        # The example replaces designs that cannot be built: their numbers could take long.
        designs = {
            name: np.where(refused.reshape(-1, *[1] * (array.ndim - 1)), self.example[name], array)
            for name, array in part.designs.items()
        }
        count = len(refused)
        size = -(-count // self.threads)
        rows = [np.arange(first, min(first + size, count)) for first in range(0, count, size)]
        parts = [chunk_of(designs, portion, size).designs for portion in rows]
        results = []
        if not self.is_compiled:
            # Compile before several threads run.
            results, self.is_compiled = [self.program(parts[0])], True
        results += in_threads(self.program, parts[len(results) :], self.threads)
        values = {
            name: np.concatenate([answers[name] for answers, _ in results])[: part.real] for name in results[0][0]
        }
        codes = np.concatenate([codes for _, codes in results])[:count]
        return values, np.where(refused, RESULTS.impossible_design, codes)[: part.real].astype(np.int32)


def _concrete_values(build: Build, functions: dict, part: Chunk) -> Values:
    rows, codes = [], []
    for i in range(part.real):
        values, code = evaluate_concretely(build, functions, {name: a[i] for name, a in part.designs.items()})
        rows.append(values)
        codes.append(code)
    known: dict[str, Any] = next((row for row in rows if row is not None), {})
    shapes = {name: v.shape for name, v in known.items()}
    for row in rows:
        for name, v in (row or {}).items():
            if v.shape != shapes[name]:
                raise ValueError(shape_message(name, v.shape, shapes[name]))
    empty = {name: np.full(shape, np.nan) for name, shape in shapes.items()}
    stacked = {name: np.stack([(row or empty)[name] for row in rows]) for name in shapes}
    return stacked, np.array(codes, np.int32)


def shape_message(name: str, shape: tuple, other: tuple) -> str:
    """Message about an answer with different shapes."""
    return f"Answer '{name}' has shape {shape} in one design and {other} in another. Make the shapes equal."


def gathered(
    count: int, names: list[str], parts: list[tuple[np.ndarray, Values]]
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Answers and codes of all designs, NaN if a design failed or is missing."""
    codes, answers = np.full(count, int(RESULTS.successful), np.int32), {}
    for rows, (_, codes_of_part) in parts:
        codes[rows] = codes_of_part
    failed = ~np.isin(codes, ANSWERED)
    for name in names:
        # A chunk without any answer does not know the shape.
        known = [(rows, values[name]) for rows, (values, _) in parts if name in values]
        shape = known[0][1].shape[1:] if known else ()
        answers[name] = np.full((count, *shape), np.nan)
        for rows, values in known:
            if values.shape[1:] != shape:
                raise ValueError(shape_message(name, values.shape[1:], shape))
            answers[name][rows] = values
        answers[name][failed] = np.nan
    return answers, codes
