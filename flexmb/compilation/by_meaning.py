"""Compile functions of equal operations once: functions that differ only in numbers share compiled code."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from . import compile
from .program import Captured, Code, captured
from .recompiled import noted

# Numbers of formulas, not of designs. They stay in the program, so that the compiler can omit operations.
FORMAL = frozenset((0.0, 0.5, 1.0, 2.0))
NUMBERS = (bool, int, float, complex, np.ndarray, np.generic, jax.Array)


def jit(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of pytrees of arrays; calls with concrete numbers compile quickly.

    Two things differ from ``jax.jit``. Compiler options favour a quick compilation, or a quick run if compiled code is
    kept on disk (see :func:`flexmb.enable_cache`). A function that is defined again, such as in a cell of a
    notebook, is compiled again only if its operations differ. Designs and models that differ in numbers share code.

    JAX accepts compiler options only at the outermost call. Under a trace the function is compiled with its caller.

    Args:
        function: Function of pytrees of arrays. Keyword arguments are options; flexmb compiles the function for each
            value of them.

    Returns:
        The compiled function.

    Raises:
        TypeError: The argument is no function.
    """
    plain = compile.jit(function)
    programs: dict[Any, tuple[Captured, Callable[..., Any]]] = {}

    @functools.wraps(function)
    def call(*arguments: Any, **options: Any):
        leaves, structure = jax.tree.flatten(arguments)
        if not all(map(_is_known, leaves)):
            return plain(*arguments, **options)
        kinds = tuple((np.shape(leaf), jnp.result_type(leaf)) for leaf in leaves)
        like = structure, compile.exact(tuple(sorted(options.items()))), kinds
        if like not in programs:
            shapes = jax.tree.unflatten(structure, [jax.ShapeDtypeStruct(*kind) for kind in kinds])
            with noted("", None, (), (), counts=False):
                program = captured(functools.partial(function, **options), *shapes, rules=0, formal=FORMAL)
            if not is_concrete(program.numbers):
                # Numbers of an outer trace may be differentiated and differ next time: shared code must have the same
                # derivatives too.
                program = captured(functools.partial(function, **options), *shapes, formal=FORMAL)
                return _called(program, run_of(program.code), leaves)
            with jax.core.eval_context():
                program = dataclasses.replace(program, numbers=tuple(jax.device_put(list(program.numbers))))
            compiled_before = run_of.cache_info().misses
            programs[like] = program, run_of(program.code)
            if run_of.cache_info().misses > compiled_before:
                name, fixed = compile.program_name(function), tuple(sorted(options.items()))
                with noted(name, structure, fixed, [jax.ShapeDtypeStruct(*kind) for kind in kinds]):
                    pass
        return _called(*programs[like], leaves)

    return call


def _called(program: Captured, run: Callable[..., Any], leaves: list[Any]) -> Any:
    return jax.tree.unflatten(program.code.results, run(None, (), [*program.numbers, *leaves]))


@functools.lru_cache(compile.MOST_VARIANTS)
def run_of(code: Code) -> Callable[..., Any]:
    """Function that runs a program on its numbers and arguments; MOST_VARIANTS of them are remembered."""
    count = len(code.jaxpr.constvars)

    def function(_: Any, __: Any, *leaves: Any):
        return jax.core.eval_jaxpr(code.jaxpr, leaves[:count], *leaves[count:])

    return compile.compiled(function, compile.program_name(jit), counts=False)


def _is_known(leaf: Any) -> bool:
    """Whether it is a number or an array that is not traced, and no random key of JAX."""
    known = isinstance(leaf, NUMBERS) and is_concrete(leaf)
    return known and not (isinstance(leaf, jax.Array) and jnp.issubdtype(leaf.dtype, jax.dtypes.extended))
