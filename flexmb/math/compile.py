"""Compilation of the kernels behind the public functions."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.core

# An analysis is many small products around a few calls of LAPACK. Optimising their code more than doubles the time to
# trace and compile and saves up to half the time of a run (benchmarks/first_impression.py).
QUICK = {"xla_backend_optimization_level": 0, "xla_cpu_use_fusion_emitters": False}


def jit(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of pytrees of arrays, quickly where it is called on concrete numbers.

    The same as ``jax.jit`` but for the compiler's optimisation level. A batch of thousands of designs is better
    compiled by ``jax.jit``. JAX takes compiler options at the outermost call only, so that under a trace the function
    is compiled as part of the caller's.

    Args:
        function: Function of pytrees of arrays; arguments given by keyword are options that choose code.

    Returns:
        The compiled function.
    """

    def flat(structure, options, *leaves):
        return function(*jax.tree.unflatten(structure, leaves), **dict(options))

    outermost = jax.jit(flat, static_argnums=(0, 1), compiler_options=QUICK)
    nested = jax.jit(flat, static_argnums=(0, 1))

    @functools.wraps(function)
    def call(*arguments, **options):
        # Flattened once, here: a model is a tree of some thirty arrays.
        leaves, structure = jax.tree.flatten(arguments)
        traced = any(isinstance(leaf, jax.core.Tracer) for leaf in leaves)
        return (nested if traced else outermost)(structure, tuple(sorted(options.items())), *leaves)

    return call


def traced_once(function: Callable[..., Any]) -> Callable[..., Any]:
    """Keep the trace of a function of pytrees of arrays, for the other kernels that call it with equal shapes.

    Python's part in compiling, which no cache on disk saves, is paid once a process instead of once a kernel.

    Args:
        function: Function of positional arguments.

    Returns:
        The same function.
    """
    return functools.wraps(function)(jax.jit(function))
