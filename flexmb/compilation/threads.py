"""Threads: one for LAPACK, all cores for independent work."""

import contextlib
import functools
import importlib
import os
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax

_lock = threading.Lock()
_inside = 0
_before: list[tuple[Any, int]] = []


@functools.cache
def _libraries() -> tuple[Any, ...]:
    """The BLAS libraries that are loaded, found once: looking for them takes longer than most kernels run."""
    from threadpoolctl import ThreadpoolController

    # What it finds are the libraries that are loaded; SciPy's LAPACK is that of jax.
    importlib.import_module("scipy.linalg")

    return tuple(ThreadpoolController().select(user_api="blas").lib_controllers)


class one_thread(contextlib.ContextDecorator):
    """Within, LAPACK works in the thread that calls it, in the whole process; after the last one, as before.

    Matrices of a mechanism are too small for more (``benchmarks/threads.py``): two threads gain nothing, and as soon as
    anything else runs on the machine they wait for each other ten to fifty times as long as they work.
    """

    def __enter__(self) -> None:
        global _inside
        with _lock:
            _inside += 1
            if _inside == 1:
                _before[:] = [(one, one.get_num_threads()) for one in _libraries()]
                _set((one, 1) for one, _ in _before)

    def __exit__(self, *fault: object) -> None:
        global _inside
        with _lock:
            _inside -= 1
            if _inside == 0:
                _set(_before)


def _set(numbers: Iterable[tuple[Any, int]]) -> None:
    """Give libraries so many threads each."""
    for library, number in numbers:
        library.set_num_threads(number)


def cores() -> int:
    """How many threads independent compiled calls are worth: the cores, where arrays live on them."""
    if jax.default_backend() != "cpu":
        return 1
    with ThreadPoolExecutor(1) as pool:
        # What is set within a context holds in its own thread only.
        if pool.submit(jax.dtypes.canonicalize_dtype, float).result() != jax.dtypes.canonicalize_dtype(float):
            return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(function: Callable[[Any], Any], arguments: Sequence[Any], threads: int) -> list[Any]:
    """Compiled calls side by side, each with a LAPACK of one thread.

    Returns the results in the order of the arguments.
    """

    def finished(argument: Any):
        return jax.block_until_ready(function(argument))

    with one_thread():
        if threads == 1:
            return [finished(argument) for argument in arguments]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(finished, arguments))
