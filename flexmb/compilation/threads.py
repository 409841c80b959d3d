"""Threads: one for LAPACK, all cores for independent calls."""

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
    """Loaded BLAS libraries, found once, since the search takes longer than most kernels."""
    from threadpoolctl import ThreadpoolController

    # SciPy's LAPACK, which JAX uses, must be loaded to be found.
    importlib.import_module("scipy.linalg")

    return tuple(ThreadpoolController().select(user_api="blas").lib_controllers)


class one_thread(contextlib.ContextDecorator):
    """Context in which LAPACK uses only the calling thread, in the whole process, until the last such context ends.

    Matrices of a mechanism are too small for more (``benchmarks/threads.py``): two threads gain nothing. If anything
    else runs on the machine, they wait for each other ten to fifty times as long as they work.
    """

    def __enter__(self) -> None:
        global _inside
        with _lock:
            _inside += 1
            if _inside == 1:
                _before[:] = [(library, library.get_num_threads()) for library in _libraries()]
                _set((library, 1) for library, _ in _before)

    def __exit__(self, *fault: object) -> None:
        global _inside
        with _lock:
            _inside -= 1
            if _inside == 0:
                _set(_before)


def _set(numbers: Iterable[tuple[Any, int]]) -> None:
    """Set numbers of threads of libraries."""
    for library, number in numbers:
        library.set_num_threads(number)


def cores() -> int:
    """Number of threads for independent compiled calls: the cores if arrays live on the CPU, else one."""
    if jax.default_backend() != "cpu":
        return 1
    with ThreadPoolExecutor(1) as pool:
        # Settings within a context hold only in its thread: use this thread alone then.
        if pool.submit(jax.dtypes.canonicalize_dtype, float).result() != jax.dtypes.canonicalize_dtype(float):
            return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(function: Callable[[Any], Any], arguments: Sequence[Any], threads: int) -> list[Any]:
    """Results of compiled calls in parallel, in order, each with a LAPACK of one thread."""

    def finished(argument: Any):
        return jax.block_until_ready(function(argument))

    with one_thread():
        if threads == 1:
            return [finished(argument) for argument in arguments]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(finished, arguments))
