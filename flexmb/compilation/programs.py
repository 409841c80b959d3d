"""Compiled programs of one function, one for each kind of arguments, from disk where they are kept."""

import contextlib
import weakref
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from .kept import read_program, write_program

_config: Any = None
_passes: Any = None
# Where JAX has them elsewhere, it does all that is done here, in more time.
with contextlib.suppress(ImportError):
    from jax._src import config as _config
    from jaxlib.mlir import passmanager as _passes

_EVERY: Any = weakref.WeakSet()


class Programs:
    """A function of arrays to be compiled, as by ``jax.jit``.

    Its programs do not hold where in Python each operation was written, under which names: to compile them took a
    fifteenth longer with that, and to read them from disk a quarter.

    Args:
        function: Of arrays.
        name: Under which it is listed.
        options: Of the compiler.
        things: What the function follows from if its programs are to be kept on disk.
    """

    def __init__(
        self, function: Callable[..., Any], name: str, options: dict[str, Any] | None, things: tuple | None = None
    ):
        self._by_jax = named(function, name, options)
        # By a name of its own it is never found in JAX's cache: what was read from there cannot be written once more.
        self._apart = named(function, f"{name}.kept", options)
        self._things = None if things is None else (*things, options)
        self.let_go()
        _EVERY.add(self)

    def let_go(self) -> None:
        """Forget the programs."""
        self._last: Any = None
        self._found: dict[Any, Callable[..., Any]] = {}

    def __len__(self) -> int:
        """Number of programs."""
        return len(self._found) + self._by_jax._cache_size()

    def __call__(self, *leaves: Any):
        """Result for arrays."""
        if _config is None or _passes is None or jax.config.jax_disable_jit:
            return self._by_jax(*leaves)
        settings, last = _config.trace_context(), self._last
        if last is not None and last[0] == settings:
            # A program refuses what it was not compiled for before it runs.
            with contextlib.suppress(TypeError, ValueError):
                return last[1](*leaves)
        kind = settings, tuple(map(jax.typeof, leaves))
        program = self._found.get(kind)
        if program is None:
            program = self._found[kind] = self._program(leaves)
        self._last = settings, program
        try:
            return program(*leaves)
        except (TypeError, ValueError):
            # Numbers that lie on another device.
            return self._by_jax(*leaves)

    def _program(self, leaves: tuple[Any, ...]) -> Callable[..., Any]:
        path, program = (None, None) if self._things is None else read_program(self._things, leaves)
        if program is not None:
            return program
        if path is None:
            return _compiled(self._by_jax, leaves)
        with _config.persistent_cache_min_compile_time_secs(np.inf):
            program = _compiled(self._apart, leaves)
        write_program(path, program)
        return program


def _compiled(own: Any, leaves: tuple[Any, ...]) -> jax.stages.Compiled:
    lowered = own.lower(*leaves)
    module: Any = lowered.compiler_ir()
    with module.context:
        _passes.PassManager.parse("builtin.module(strip-debuginfo)").run(module.operation)
    return lowered.compile()


def named(function: Callable[..., Any], name: str, options: dict[str, Any] | None) -> Any:
    """A function of arrays to be compiled by JAX, under a name."""

    def program(*leaves: Any):
        return function(*leaves)

    program.__name__ = name
    return jax.jit(program, compiler_options=options)


def let_go() -> None:
    """Forget all programs that were compiled or read."""
    for programs in list(_EVERY):
        programs.let_go()
