"""Compiled programs of one function, one for each kind of arguments, from disk where they are kept."""

import contextlib
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from .kept import read_program, write_program

_config: Any = None
_caches: Any = None
_passes: Any = None
with contextlib.suppress(ImportError):
    from jax._src import config as _config
    from jax._src import util as _caches
    from jaxlib.mlir import passmanager as _passes
SETTINGS = ("debug_nans", "debug_infs", "optimization_level", "memory_fitting_level")
_USED = ("trace_context", "disable_jit", "persistent_cache_min_compile_time_secs", *SETTINGS)
# A JAX that has one of them elsewhere does all that is done here by itself, in more time.
_is_known = hasattr(_caches, "register_cache") and _passes is not None and all(hasattr(_config, of) for of in _USED)


class Executables:
    """A function of arrays to be compiled, as by ``jax.jit``; ``jax.clear_caches`` lets its programs go.

    Its programs do not hold where in Python each operation was written, nor under which names: with that they take a
    quarter longer to be read from disk, and a twentieth to be compiled.

    Args:
        function: Of arrays.
        name: Under which it is listed; what is kept on disk has ".kept" behind it.
        options: Of the compiler.
        things: What the function follows from if its programs are to be kept on disk.
    """

    def __init__(
        self, function: Callable[..., Any], name: str, options: dict[str, Any] | None, things: tuple | None = None
    ):
        self._by_jax = named(function, name, options)
        # Never found in JAX's cache, for its name: XLA writes what it has read without the code of its loops.
        self._apart = named(function, f"{name}.kept", options)
        self._things = None if things is None else (*things, options)
        self.cache_clear()
        if _is_known:
            _caches.register_cache(self, name)

    def cache_clear(self) -> None:
        """Let the programs go."""
        self._found: dict[Any, Callable[..., Any]] = {}
        self._only: Any = None

    def __len__(self) -> int:
        """Number of programs, those included that JAX compiled by itself."""
        return len(self._found) + self._by_jax._cache_size()

    def __call__(self, *leaves: Any):
        """Result for arrays."""
        if not _is_known:
            return self._by_jax(*leaves)
        settings, only = _settings(), self._only
        if only is not None and only[0] == settings:
            # A program refuses what it was not compiled for before it runs, but takes long to say why.
            try:
                return only[1](*leaves)
            except (TypeError, ValueError):
                pass
        kind = settings, tuple([(leaf.shape, leaf.dtype) for leaf in leaves])
        program = self._found.get(kind)
        if program is None:
            program = self._found[kind] = self._program(leaves)
            self._only = (settings, program) if len(self._found) == 1 and program is not self._by_jax else None
        try:
            return program(*leaves)
        except (TypeError, ValueError):
            if program is self._by_jax:
                raise
            # It refuses them too where they lie on another device.
            return self._by_jax(*leaves)

    def _program(self, leaves: tuple[Any, ...]) -> Callable[..., Any]:
        # What looks for NaN in results runs a function anew, operation by operation.
        by_operations = any(one.value for one in (_config.disable_jit, _config.debug_nans, _config.debug_infs))
        # A device that was chosen is not to be that of other numbers.
        if by_operations or any(getattr(leaf, "committed", False) for leaf in leaves):
            return self._by_jax
        path, program = (None, None) if self._things is None else read_program(self._things, leaves)
        if program is not None:
            return program
        if path is None:
            return _compiled(self._by_jax, leaves)
        with _config.persistent_cache_min_compile_time_secs(np.inf):
            program = _compiled(self._apart, leaves)
        write_program(path, program)
        return program


def _settings() -> tuple[Any, ...]:
    """Settings of JAX that its programs depend on."""
    return (_config.trace_context(), *[getattr(_config, name).value for name in SETTINGS])


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
