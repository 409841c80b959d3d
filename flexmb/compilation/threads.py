"""Threads: one for LAPACK, all cores for independent work."""

import contextlib
import functools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax

from ..lazy import no_garbage_looked_for
from .alone import find_lapack

_lock = threading.Lock()
_inside = 0
_limit: Any = None


@functools.cache
def _controller() -> Any:
    from threadpoolctl import ThreadpoolController

    # What it finds are the libraries that are loaded; SciPy's LAPACK is that of jax.
    with no_garbage_looked_for():
        find_lapack()

    return ThreadpoolController()


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """Within, LAPACK works in the thread that calls it, in the whole process; after the last one, as before.

    Matrices of a mechanism are too small for more (``benchmarks/threads.py``): two threads gain nothing, and as soon as
    anything else runs on the machine they wait for each other ten to fifty times as long as they work.
    """
    global _inside, _limit
    with _lock:
        _inside += 1
        if _inside == 1:
            _limit = _controller().limit(limits=1, user_api="blas")
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if _inside == 0:
                _limit.restore_original_limits()


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

    Args:
        function: Compiled, and called before.
        arguments: One for each call.
        threads: How many at a time.

    Returns:
        Results in the order of the arguments.
    """

    def finished(argument: Any):
        return jax.block_until_ready(function(argument))

    with one_thread():
        if threads == 1:
            return [finished(argument) for argument in arguments]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(finished, arguments))
