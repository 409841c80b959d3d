"""Many designs: compiled once, computed in chunks, failures beside the others."""

import contextlib
import os
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from typing import Any

import numpy as np

from .. import __version__
from ..arguments import check_by_name, check_whole
from ..compilation.compile import unguarded
from ..errors import clean, warn
from ..model.model import Model
from ..progress import reporting
from ..results import ANSWERED, RESULTS
from .checkpoint import Checkpoint, refusal
from .chunks import Task, Values, Worker, gathered, part_of
from .designs import Designs
from .evaluate import REFUSED, Answers, Build, check_dimensions, check_names, first_built, named_answers
from .identity import identity
from .swept import Sweep

# What is written beside dimensions and answers, in files and in tables.
RESERVED = ("codes", "about", "result", "design")
# Designs of a checkpoint that are computed again where nothing is compiled, and how near they must come, relative to
# the largest of the answer. Our choice: beyond round-off times the condition of a leaf spring.
REPEATED, SAME = 8, 1e-6


@unguarded
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
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one, several, or a
            dictionary by name.
        designs: Dimensions by name with the designs along the first axis, (designs, ...) [SI]: :func:`grid`,
            :func:`latin_hypercube`, :func:`monte_carlo`, or arrays of your own.
        compiled: False for analyses that cannot be traced, such as ``fm.poles`` or ``fm.path``: design by design.
        chunk: Designs between two checkpoints, and in one task of an executor.
        together: Designs that are computed at once; more than one pays on a GPU (small ones only on a CPU, where many
            LAPACK calls at once may hang).
        executor: Anything with ``submit`` of ``concurrent.futures``, such as a pool or
            ``dask.distributed.Client(..).get_executor()``; chunks are its tasks, and each worker compiles for itself,
            with the folder of ``fm.enable_cache`` where it can be used. Processes must not be forks:
            ``ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))``.
        checkpoint: A file that grows by every chunk; a sweep that was interrupted goes on from it. It must be of this
            sweep: compared are the designs, the names, ``compiled``, the model of the first design that can be built
            with all its numbers, and ``build`` and the answers as far as they can be seen (their code, defaults, what
            they capture and what they name in their module, numbers, texts and arrays by value). Since an object may
            hide what it means, designs of the checkpoint are computed again, as many as a chunk has (eight with
            ``compiled=False``), and must agree with what is stored, to 1e-6 of the largest of an answer.
        progress: True for a bar, or a function called with the number of designs done and of all.
        units: Units by name, for the labels.

    Returns:
        Sweep with answers (designs, ...), and codes (designs,) of RESULTS: one design that fails stops no other. What
        a concrete build refuses has the code impossible_design, what is at an equilibrium that is not stable its
        answers and unstable_state. Designs whose leaf springs are clamped otherwise are compiled for themselves.

    Raises:
        ValueError: A dimension that ``build`` does not take or lacks; numbers of designs that differ; names that meet;
            a pool whose processes are forks; a checkpoint that is damaged, in use, or of another sweep, which is left
            as it is.
        ModelError, SpacarError: Not one design can be built.
        OSError: The checkpoint cannot be read or written.

    Warns:
        FlexmbWarning: Designs are at an equilibrium that is not stable.

    Source:
        The analyses that are asked; ``jax.lax.map`` over the designs.
    """
    functions = named_answers(answers)
    check_by_name("designs", designs)
    designs = designs if isinstance(designs, Designs) else Designs(designs)
    check_dimensions(build, tuple(designs))
    check_names(tuple(designs), tuple(functions), RESERVED)
    for name in units or {}:
        if name not in designs and name not in functions:
            raise ValueError(f"Unit of '{name}': there is no such dimension or answer.")
    chunk = min(check_whole("chunk", chunk, 1), designs.count)
    example, models = None, []
    if compiled or checkpoint is not None:
        try:
            example, models = first_built(build, designs)
        except REFUSED:
            if compiled:
                raise
    task = Task(build, functions, bool(compiled), check_whole("together", together, 1), example)
    parts: list[tuple[np.ndarray, Values]] = []
    with contextlib.ExitStack() as stack:
        worker, kept = Worker(task, executor), None
        if checkpoint is not None:
            meaning = _meaning(task, designs, models)
            kept = stack.enter_context(Checkpoint(checkpoint, meaning, designs, list(functions), dict(units or {})))
            parts = [(rows, (values, codes)) for rows, values, codes in kept.parts]
            _check_stored(kept, worker, designs, parts, chunk if compiled else REPEATED, chunk)
        missing = np.setdiff1d(np.arange(designs.count), np.concatenate([[], *(rows for rows, _ in parts)]))
        todo = [missing[first : first + chunk].astype(int) for first in range(0, len(missing), chunk)]
        report = stack.enter_context(reporting(progress, "designs", designs.count))
        done = designs.count - len(missing)
        for index, (values, codes) in worker.results([part_of(designs, rows, chunk) for rows in todo]):
            parts.append((todo[index], (values, codes)))
            done += len(codes)
            if kept is not None:
                kept.add(todo[index], values, codes)
            if report is not None:
                report(done, designs.count)
    found, codes = gathered(designs.count, list(functions), parts)
    _tell_of_unstable(codes)
    return Sweep(designs, found, codes, dict(units or {}))


def _tell_of_unstable(codes: np.ndarray) -> None:
    unstable = np.flatnonzero(codes == RESULTS.unstable_state)
    if len(unstable):
        warn(
            f"Of {len(codes)} designs {len(unstable)} are at an equilibrium that is not stable (unstable_state in"
            f" `codes`), the first of them number {unstable[0]}: no mechanism stays there by itself."
        )


def _meaning(task: Task, designs: Designs, models: list[Model]) -> dict[str, Any]:
    """What a checkpoint is about, by the words that say where another one differs."""
    return {
        "the version of flexmb": __version__,
        "the version of Python": list(sys.version_info[:2]),
        "the names of dimensions": list(designs),
        "the designs": identity(dict(designs)),
        "the model or a fixed parameter of it": identity(models),
        "the function that builds it": identity(task.build),
        "the argument `compiled`": task.compiled,
        "the names of answers": list(task.functions),
        **{f"the meaning of answer '{clean(name)}'": identity(f) for name, f in task.functions.items()},
    }


def _check_stored(
    kept: Checkpoint, worker: Worker, designs: Designs, parts: list[tuple[np.ndarray, Values]], count: int, chunk: int
) -> None:
    """Refuse a checkpoint some of whose designs have another answer today, whatever the reason."""
    if not parts:
        return
    names = list(kept.answers)
    known, codes = gathered(designs.count, names, parts)
    stored = np.unique(np.concatenate([rows for rows, _ in parts]))
    rows = stored[np.unique(np.linspace(0, len(stored) - 1, min(count, chunk, len(stored))).astype(int))]
    ((_, values),) = worker.results([part_of(designs, rows, chunk)])
    today, again = gathered(designs.count, names, [(rows, values)])
    if not np.array_equal(again[rows], codes[rows]):
        raise refusal(kept.path, "belongs to another sweep: designs that it holds fail otherwise today")
    good = rows[np.isin(codes[rows], ANSWERED)]
    for name in names:
        before, now = known[name], today[name]
        scale = np.max(np.abs(before), initial=0.0, where=np.isfinite(before))
        alike = len(good) == 0 or before.shape == now.shape
        if not alike or not np.allclose(now[good], before[good], rtol=0, atol=SAME * scale, equal_nan=True):
            raise refusal(
                kept.path, f"belongs to another sweep: answer '{clean(name)}' of designs that it holds is another"
            )
