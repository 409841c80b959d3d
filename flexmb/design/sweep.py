"""Sweeps over many designs: compiled once, computed in chunks, with failures beside the answers."""

import contextlib
import os
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from typing import Any

import numpy as np

from .. import __version__
from ..arguments import ByName, Count, checked
from ..compilation.compile import unguarded
from ..errors import printable, warn
from ..model.model import Model
from ..numerical_limits import SAME_ANSWER
from ..progress import reporting
from ..results import ANSWERED, RESULTS
from .checkpoint import Checkpoint, checkpoint_error
from .chunks import Task, Values, Worker, chunk_of, gathered
from .designs import Designs
from .evaluate import REFUSED, Answers, Build, check_answer_names, check_dimensions, first_built, named_answers
from .identity import identity
from .swept import Sweep

# Names in files and tables beside dimensions and answers.
RESERVED = ("codes", "about", "result", "design")
# Number of stored designs that are computed again without compilation.
REPEATED = 8


@checked
@unguarded
def sweep(
    build: Build,
    answers: Answers,
    designs: ByName,
    *,
    compiled: bool = True,
    chunk: Count = 256,
    together: Count = 1,
    executor: Executor | None = None,
    checkpoint: str | os.PathLike | None = None,
    progress: Callable[[int, int], None] | bool = False,
    units: Mapping[str, str] | None = None,
) -> Sweep:
    """Return the answers of many designs.

    flexmb compiles the analysis once and runs it on all cores over ``chunk`` designs at a time, which limits the
    memory. After each chunk it writes the checkpoint and reports the progress.

    Args:
        build: Function of the dimensions, by name, that returns a model, or a tuple of models for answers that need
            several mechanisms. If no degrees of freedom are named, flexmb chooses them once, at the first
            design that can be built.
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one answer, several
            answers, or a dictionary by name.
        designs: Dimensions by name with the designs along the first axis, (designs, ...) [SI]: :func:`grid`,
            :func:`latin_hypercube`, :func:`monte_carlo`, or arrays of your own.
        compiled: False for analyses that cannot be traced, such as ``fm.poles`` or ``fm.path``; flexmb then computes
            one design after the other.
        chunk: Number of designs between two checkpoints, and in one task of an executor.
        together: Number of designs computed at once. More than one is faster on a GPU (on a CPU only for small models:
            many LAPACK calls at once may hang). Motions computed at once take as long as the slowest.
        executor: Object with ``submit`` of ``concurrent.futures``, such as a pool or
            ``dask.distributed.Client(..).get_executor()``. Each task computes a chunk. Each worker compiles the
            analysis, and uses the folder of ``fm.enable_cache`` if possible. Processes must not be forks:
            ``ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))``.
        checkpoint: Path of a file to which flexmb adds every chunk. An interrupted sweep continues from this file. The
            file must belong to this sweep. flexmb compares:

            - the designs, the names and ``compiled``;
            - the model of the first design that can be built, with all its numbers;
            - the functions ``build`` and answers: their code, their defaults and their captured values. Numbers, texts
              and arrays of their module are included if a function uses them;
            - the answers of one chunk (eight designs with ``compiled=False``), which it computes again. They must agree
              to 1e-6 of the largest value of an answer.
        progress: True for a bar, or a function called with the number of designs done and of all.
        units: Units by name, for labels.

    Returns:
        Sweep with answers (designs, ...), and codes (designs,) of RESULTS. A failed design does not stop the sweep. A
        design that ``build`` refuses with concrete numbers has the code impossible_design. A design at an unstable
        equilibrium has answers and the code unstable_state. Designs whose leaf springs are clamped differently are
        compiled separately.

    Raises:
        ValueError: ``build`` does not accept a dimension or lacks one; dimensions have different numbers of designs;
            two answers, or a dimension and an answer, have the same name; a pool has forked processes; a checkpoint is
            damaged, in use, or belongs to another sweep (it stays unchanged).
        ModelError, SpacarError: No design can be built.
        OSError: The checkpoint cannot be read or written.

    Warns:
        FlexmbWarning: Designs are at an unstable equilibrium.

    Source:
        The analyses of the answers; ``jax.lax.map`` over the designs.
    """
    functions = named_answers(answers)
    designs = designs if isinstance(designs, Designs) else Designs(designs)
    check_dimensions(build, tuple(designs))
    check_answer_names(tuple(designs), tuple(functions), RESERVED)
    for name in units or {}:
        if name not in designs and name not in functions:
            raise ValueError(f"Unit of '{name}': there is no such dimension or answer.")
    chunk = min(chunk, designs.count)
    example, models = None, []
    if compiled or checkpoint is not None:
        try:
            example, models = first_built(build, designs)
        except REFUSED:
            if compiled:
                raise
    task = Task(build, functions, bool(compiled), together, example)
    parts: list[tuple[np.ndarray, Values]] = []
    with contextlib.ExitStack() as stack:
        worker, store = Worker(task, executor), None
        if checkpoint is not None:
            meaning = _meaning(task, designs, models)
            store = stack.enter_context(Checkpoint(checkpoint, meaning, designs, list(functions), dict(units or {})))
            parts = [(rows, (values, codes)) for rows, values, codes in store.parts]
            _check_stored(store, worker, designs, parts, chunk if compiled else REPEATED, chunk)
        missing = np.setdiff1d(np.arange(designs.count), np.concatenate([[], *(rows for rows, _ in parts)]))
        todo = [missing[first : first + chunk].astype(int) for first in range(0, len(missing), chunk)]
        report = stack.enter_context(reporting(progress, "designs", designs.count))
        computed = designs.count - len(missing)
        for index, (values, codes) in worker.results([chunk_of(designs, rows, chunk) for rows in todo]):
            parts.append((todo[index], (values, codes)))
            computed += len(codes)
            if store is not None:
                store.add(todo[index], values, codes)
            if report is not None:
                report(computed, designs.count)
    results, codes = gathered(designs.count, list(functions), parts)
    unstable = np.flatnonzero(codes == RESULTS.unstable_state)
    if len(unstable):
        warn(
            f"Of {len(codes)} designs {len(unstable)} are at an equilibrium that is not stable (unstable_state in"
            f" `codes`). The first is number {unstable[0]}."
        )
    return Sweep(designs, results, codes, dict(units or {}))


def _meaning(task: Task, designs: Designs, models: list[Model]) -> dict[str, Any]:
    """Description of the sweep of a checkpoint, by words for messages."""
    return {
        "the version of flexmb": __version__,
        "the version of Python": list(sys.version_info[:2]),
        "the names of dimensions": list(designs),
        "the designs": identity(dict(designs)),
        "the model or a fixed parameter of it": identity(models),
        "the function that builds it": identity(task.build),
        "the argument `compiled`": task.compiled,
        "the names of answers": list(task.functions),
        **{f"the meaning of answer '{printable(name)}'": identity(f) for name, f in task.functions.items()},
    }


def _check_stored(
    stored: Checkpoint, worker: Worker, designs: Designs, parts: list[tuple[np.ndarray, Values]], count: int, chunk: int
) -> None:
    """Refuse a checkpoint if some of its designs have other answers today, whatever the reason."""
    if not parts:
        return
    names = list(stored.answers)
    known, codes = gathered(designs.count, names, parts)
    places = np.unique(np.concatenate([rows for rows, _ in parts]))
    rows = places[np.unique(np.linspace(0, len(places) - 1, min(count, chunk, len(places))).astype(int))]
    ((_, values),) = worker.results([chunk_of(designs, rows, chunk)])
    today, again = gathered(designs.count, names, [(rows, values)])
    if not np.array_equal(again[rows], codes[rows]):
        raise checkpoint_error(stored.path, "belongs to another sweep: some of its designs have other codes today")
    good = rows[np.isin(codes[rows], ANSWERED)]
    for name in names:
        before, recomputed = known[name], today[name]
        scale = np.max(np.abs(before), initial=0.0, where=np.isfinite(before))
        alike = len(good) == 0 or before.shape == recomputed.shape
        if not alike or not np.allclose(
            recomputed[good], before[good], rtol=0, atol=SAME_ANSWER * scale, equal_nan=True
        ):
            raise checkpoint_error(
                stored.path, f"belongs to another sweep: answer '{printable(name)}' of some designs is another"
            )
