"""Compilation of the kernels behind the public functions."""

import functools
from collections.abc import Callable
from typing import Any

import jax

# The kernels are many small products around a few calls of LAPACK: the compiler's optimisation passes halve no run
# time here and double the time to compile (benchmarks/first_impression.py).
QUICK = {"xla_backend_optimization_level": 0}


def kernel(function: Callable[..., Any] | None = None, *, static: tuple[str, ...] = ()) -> Callable[..., Any]:
    """Compile a function of pytrees of arrays, quickly where it is called on concrete numbers.

    JAX takes compiler options at the outermost call only, so under a trace the function is compiled as part of the
    user's.

    Args:
        function: Function to compile.
        static: Names of arguments that are not arrays.
    """
    if function is None:
        return functools.partial(kernel, static=static)
    outermost = jax.jit(function, static_argnames=static, compiler_options=QUICK)
    nested = jax.jit(function, static_argnames=static)

    @functools.wraps(function)
    def call(*arguments, **named):
        traced = any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves((arguments, named)))
        return (nested if traced else outermost)(*arguments, **named)

    return call
