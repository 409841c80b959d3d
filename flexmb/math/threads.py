"""Independent work on all cores."""

import functools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax


def cores() -> int:
    """How many threads independent compiled calls are worth: the cores, where arrays live on them."""
    # Settings that hold in one thread only, such as x64 within a context, do not reach others.
    alone = jax.default_backend() != "cpu" or not jax.config.values["jax_enable_x64"]
    return 1 if alone else len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@functools.cache
def _libraries() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def each(function: Callable[[Any], Any], arguments: Sequence[Any], threads: int) -> list[Any]:
    """Compiled calls side by side, each with a LAPACK of one thread.

    Matrices of some hundred rows are too small for more: a LAPACK of two threads takes twice as long
    (``benchmarks/designs.py``), and threads that share one gain nothing.

    Args:
        function: Compiled, and called before.
        arguments: One for each call.
        threads: How many at a time.

    Returns:
        Results in the order of the arguments.
    """

    def finished(argument):
        return jax.block_until_ready(function(argument))

    with _libraries().limit(limits=1, user_api="blas"):
        if threads == 1:
            return [finished(argument) for argument in arguments]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(finished, arguments))
