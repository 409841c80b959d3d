"""Independent work on all cores."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax


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

    Matrices of some hundred rows are too small for more: with ninety rows on two cores, a LAPACK of two threads took
    1.7 times as long, and calls side by side that shared it gained nothing.

    Args:
        function: Compiled, and called before.
        arguments: One for each call.
        threads: How many at a time.

    Returns:
        Results in the order of the arguments.
    """
    from threadpoolctl import threadpool_limits

    def finished(argument):
        return jax.block_until_ready(function(argument))

    with threadpool_limits(1, user_api="blas"):
        if threads == 1:
            return [finished(argument) for argument in arguments]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(finished, arguments))
