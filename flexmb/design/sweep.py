"""Many designs: compiled once, computed in chunks, failures beside the others."""

import dataclasses
import functools
import hashlib
import io
import json
import os
import pickle
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import jax
import numpy as np

from ..errors import ModelError
from ..io.files import save_arrays, write_whole
from ..math.compile import jit
from ..math.threads import cores, each
from ..progress import reporting
from ..results import RESULTS
from .designs import Designs
from .evaluate import Answers, Build, build_once, check_dimensions, evaluate, evaluate_concretely, named_answers
from .labelled import pandas, xarray

# A state without derivative is an answer all the same.
ANSWERED = (RESULTS.successful, RESULTS.critical_state)


@dataclasses.dataclass(frozen=True)
class Sweep:
    """Answers of many designs.

    Attributes:
        designs: Dimensions by name, each (designs, ...) [SI]; ``designs.axes`` of a grid.
        answers: Answers by name, each (designs, ...), NaN where a design failed [their units].
        codes: Code of RESULTS of every design, (designs,).
        units: Units by name, as given.
    """

    designs: Designs
    answers: dict[str, np.ndarray]
    codes: np.ndarray
    units: dict[str, str]

    def __getitem__(self, name: str) -> np.ndarray:
        """An answer or a dimension by name; of a grid, with its axes first."""
        found = self.answers[name] if name in self.answers else self.designs[name]
        return (
            found.reshape(tuple(len(a) for a in self.designs.axes.values()) + found.shape[1:]) if self.axes else found
        )

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values along each axis of a grid, by name; otherwise empty."""
        return self.designs.axes

    def failures(self) -> dict[str, int]:
        """How many designs failed, by the name of the code."""
        return {RESULTS(c).name: int(np.sum(self.codes == c)) for c in np.unique(self.codes) if c not in ANSWERED}

    def to_pandas(self):
        """A ``pandas.DataFrame`` with one row a design; units in ``attrs``.

        Raises:
            ImportError: pandas is not installed.
        """
        columns: dict[str, Any] = {}
        for name, array in {**self.designs, **self.answers}.items():
            for at in np.ndindex(array.shape[1:]):
                columns[name + (f"[{', '.join(map(str, at))}]" if at else "")] = array[(slice(None), *at)]
        columns["result"] = [RESULTS(int(c)).name for c in self.codes]
        frame = pandas().DataFrame(columns)
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_xarray(self):
        """An ``xarray.Dataset``: of a grid with its axes, otherwise with the axis "design".

        Raises:
            ImportError: xarray is not installed.
        """
        xr = xarray()
        along = tuple(self.axes) or ("design",)
        variables = {}
        for name in (*self.answers, *(() if self.axes else self.designs)):
            values = self[name]
            own = tuple(f"{name}_{i}" for i in range(values.ndim - len(along)))
            variables[name] = ((*along, *own), values, {"units": self.units.get(name, "")})
        shape = tuple(len(a) for a in self.axes.values()) or (-1,)
        variables["result"] = (along, self.codes.reshape(shape), {"meaning": "code of flexmb.RESULTS"})
        coords = {name: ((name,), a, {"units": self.units.get(name, "")}) for name, a in self.axes.items()}
        return xr.Dataset(variables, coords)

    def save(self, path: str | os.PathLike) -> None:
        """Write as .npz or .mat: every dimension and answer by its name, "codes", and "about" (units) as JSON.

        Args:
            path: Where; its ending says how.

        Raises:
            ValueError: Another ending.
            OSError: The folder is missing or not writable.
        """
        arrays = {name: self[name] for name in (*self.designs, *self.answers)}
        shape = tuple(len(a) for a in self.axes.values()) or (-1,)
        about = {"units": self.units, "axes": list(self.axes), "failures": self.failures()}
        save_arrays(path, {**arrays, "codes": self.codes.reshape(shape)}, about)

    def _repr_html_(self) -> str | None:
        """Table and picture in a notebook."""
        from ..viewer.notebook import card

        return card(self)


def sweep(
    build: Build,
    answers: Answers,
    designs: Mapping[str, Any],
    *,
    compiled: bool = True,
    chunk: int = 256,
    together: int = 1,
    executor: Executor | None = None,
    checkpoint: str | os.PathLike | None = None,
    progress: Callable[[int, int], None] | bool = False,
    units: Mapping[str, str] | None = None,
) -> Sweep:
    """Answers of many designs.

    The kernel is compiled once and runs on all cores over ``chunk`` designs at a time, which bounds the memory, with
    checkpoints and progress in between.

    Args:
        build: Function of the dimensions, by name, that returns a model. Degrees of freedom that it does not name are
            found once, at the first design that can be built.
        answers: Functions of the model that return numbers: one, several, or a dictionary by name.
        designs: Dimensions by name with the designs along the first axis, (designs, ...) [SI]: :func:`grid`,
            :func:`latin_hypercube`, :func:`monte_carlo`, or arrays of your own.
        compiled: False for analyses that cannot be traced, such as ``fm.poles`` or ``fm.path``: design by design.
        chunk: Designs between two checkpoints, and in one task of an executor.
        together: Designs that are computed at once; more than one pays on a GPU (small ones only on a CPU, where many
            LAPACK calls at once may hang).
        executor: Anything with ``submit`` of ``concurrent.futures``, such as a pool or
            ``dask.distributed.Client(..).get_executor()``; chunks are its tasks, and each worker compiles for itself.
        checkpoint: A .npz file that is written after every chunk; an unfinished sweep of the same designs goes on from
            it.
        progress: True for a bar, or a function called with the number of designs done and of all.
        units: Units by name, for the labels.

    Returns:
        Sweep with answers (designs, ...), and codes (designs,) of RESULTS: one design that fails stops no other.

    Raises:
        ValueError: A dimension that ``build`` does not take or lacks; numbers of designs that differ; a checkpoint of
            another sweep.
        ModelError: Not one design can be built.

    Source:
        The analyses that are asked; ``jax.lax.map`` over the designs.
    """
    functions = named_answers(answers)
    designs = designs if isinstance(designs, Designs) else Designs(designs)
    check_dimensions(build, tuple(designs))
    for name, value in (("chunk", chunk), ("together", together)):
        if value < 1:
            raise ValueError(f"Argument `{name}` must be at least 1, but is {value}.")
    chunk, count = min(int(chunk), designs.count), designs.count
    starts = list(range(0, count, chunk))
    key = _fingerprint(designs, functions, chunk)
    done = _resume(checkpoint, key)
    todo = [start for start in starts if start not in done]
    task = (build, functions, compiled, int(together))
    parts = [_part(designs, start, chunk) for start in todo]
    with reporting(progress, "designs", count) as report:
        for index, (values, codes) in _run(task, parts, executor):
            done[todo[index]] = (values, codes)
            if checkpoint is not None:
                _write(checkpoint, key, done)
            if report is not None:
                report(min(sum(len(codes) for _, codes in done.values()), count), count)
    return _joined(designs, functions, [done[start] for start in starts], dict(units or {}))


Part = tuple[dict[str, np.ndarray], int]
Values = tuple[dict[str, np.ndarray], np.ndarray]


def _part(designs: Mapping[str, np.ndarray], start: int, chunk: int) -> Part:
    """One chunk, filled up with its last design so that all have one size, and how many of it count."""
    part = {name: array[start : start + chunk] for name, array in designs.items()}
    real = len(next(iter(part.values())))
    return {name: np.concatenate([a, np.repeat(a[-1:], chunk - real, axis=0)]) for name, a in part.items()}, real


def _run(task: tuple, parts: list[Part], executor: Executor | None) -> Iterable[tuple[int, Values]]:
    if executor is None:
        kernel = _kernel(*task, threads=cores())
        for index, part in enumerate(parts):
            yield index, kernel(*part)
        return
    import concurrent.futures

    from ..setup import cache_folder

    sent = _packed(task)
    cache = str(cache_folder()) if jax.config.values["jax_compilation_cache_dir"] else None
    futures = [executor.submit(_work, sent, part, cache) for part in parts]
    if all(isinstance(f, concurrent.futures.Future) for f in futures):
        places = {future: index for index, future in enumerate(futures)}
        for future in concurrent.futures.as_completed(futures):
            yield places[future], future.result()
    else:
        for index, future in enumerate(futures):
            yield index, future.result()


def _packed(task: tuple) -> Any:
    """The task as bytes, so that a worker unpacks and compiles it once; as it is where it cannot be packed."""
    try:
        return pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError):
        try:
            import cloudpickle  # pyright: ignore[reportMissingImports]
        except ImportError:
            return task
        return cloudpickle.dumps(task)


def _work(sent: Any, part: Part, cache: str | None) -> Values:
    """One chunk in a worker, which may be another process."""
    from ..setup import enable_cache, enable_x64

    if not jax.config.values["jax_enable_x64"]:
        enable_x64()
    if cache is not None and not jax.config.values["jax_compilation_cache_dir"]:
        enable_cache(cache)
    return (_unpacked(sent) if isinstance(sent, bytes) else _kernel(*sent))(*part)


@functools.lru_cache(maxsize=8)
def _unpacked(sent: bytes) -> Callable[..., Values]:
    return _kernel(*pickle.loads(sent))


def _kernel(build: Build, functions: dict, compiled: bool, together: int, *, threads: int = 1) -> Callable[..., Values]:
    """What computes one chunk, in so many threads."""
    if not compiled:
        return functools.partial(_one_by_one, build, functions)
    program: list[Any] = []

    def call(part: dict[str, np.ndarray], real: int) -> Values:
        count = len(next(iter(part.values())))
        size = -(-count // threads)
        pieces, done = [_part(part, start, size)[0] for start in range(0, count, size)], []
        if not program:
            program.append(jit(_mapped(build, functions, _first_models(build, part), together)))
            # Compiled here, before several threads ask for it.
            done = [program[0](pieces[0])]
        done += each(program[0], pieces[len(done) :], threads)
        values = {name: np.concatenate([own[name] for own, _ in done])[:real] for name in done[0][0]}
        return values, np.concatenate([codes for _, codes in done])[:real]

    return call


def _mapped(build: Build, functions: dict, models: list, together: int):
    from ..build.carry import carried

    def one(dimensions):
        with carried(models):
            return evaluate(build, functions, dimensions)

    def every(part):
        return jax.lax.map(one, part, batch_size=together if together > 1 else None)

    return every


def _first_models(build: Build, part: dict[str, np.ndarray]) -> list:
    """Models of the first design of a chunk that can be built, whose degrees of freedom the others take over."""
    first: ModelError | None = None
    for i in range(len(next(iter(part.values())))):
        try:
            return build_once(build, {name: a[i] for name, a in part.items()})
        except ModelError as fault:
            first = first or fault
    raise first or ModelError("There are no designs.")


def _one_by_one(build: Build, functions: dict, part: dict[str, np.ndarray], real: int) -> Values:
    rows, codes = [], []
    for i in range(real):
        values, code = evaluate_concretely(build, functions, {name: a[i] for name, a in part.items()})
        rows.append(values)
        codes.append(code)
    known: dict[str, Any] = next((row for row in rows if row is not None), {})
    shapes = {name: v.shape for name, v in known.items()}
    for row in rows:
        for name, v in (row or {}).items():
            if v.shape != shapes[name]:
                raise ValueError(
                    f"Answer '{name}' has shape {v.shape} in one design and {shapes[name]} in another: make it of one."
                )
    empty = {name: np.full(shape, np.nan) for name, shape in shapes.items()}
    stacked = {name: np.stack([(row or empty)[name] for row in rows]) for name in shapes}
    return stacked, np.array(codes, np.int32)


def _joined(designs: Designs, functions: dict, parts: list[Values], units: dict[str, str]) -> Sweep:
    codes = np.concatenate([codes for _, codes in parts])
    failed = ~np.isin(codes, [int(c) for c in ANSWERED])
    answers = {}
    for name in functions:
        shape = next((values[name].shape[1:] for values, _ in parts if name in values), ())
        # A chunk of which no design was answered does not know the shape.
        pieces = [values.get(name, np.full((len(own), *shape), np.nan)) for values, own in parts]
        answers[name] = np.concatenate(pieces)
        answers[name][failed] = np.nan
    return Sweep(designs, answers, codes, units)


def _fingerprint(designs: Designs, functions: dict, chunk: int) -> str:
    digest = hashlib.sha256(json.dumps([list(designs), list(functions), chunk]).encode())
    for array in designs.values():
        digest.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _write(path: str | os.PathLike, key: str, done: dict[int, Values]) -> None:
    arrays = {"key": np.asarray(key)}
    for start, (values, codes) in done.items():
        arrays[f"{start}:codes"] = codes
        arrays |= {f"{start}:answer:{name}": v for name, v in values.items()}
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)  # pyright: ignore[reportArgumentType]
    write_whole(path, content.getvalue())


def _resume(path: str | os.PathLike | None, key: str) -> dict[int, Values]:
    """What a checkpoint holds already, by the first design of each chunk."""
    if path is None:
        return {}
    if Path(path).suffix != ".npz":
        raise ValueError(f"Argument `checkpoint` must be a path that ends in .npz, but is '{path}'.")
    if not Path(path).exists():
        return {}
    with np.load(path) as file:
        if "key" not in file or str(file["key"]) != key:
            raise ValueError(
                f"Checkpoint '{path}' belongs to another sweep: its designs, names of answers or chunk differ. Delete"
                " it or name another file."
            )
        done: dict[int, Values] = {}
        for name in file.files:
            start, _, kind = name.partition(":")
            if kind == "codes":
                done[int(start)] = ({}, file[name])
        for name in file.files:
            start, _, kind = name.partition(":")
            if kind.startswith("answer:"):
                done[int(start)][0][kind.removeprefix("answer:")] = file[name]
    return done
