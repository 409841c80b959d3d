"""Compilation of the kernels behind the public functions."""

import functools
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from . import kept
from .host import Run, forget, is_within_run
from .recompiled import noted
from .threads import one_thread

P = ParamSpec("P")
T = TypeVar("T")

# An analysis is many small products around a few calls of LAPACK. Thorough optimisation takes two to six times the
# compile time and halves the time of a run (benchmarks/first_impression.py). It pays off if compiled code is on disk.
QUICK = {
    "xla_backend_optimization_level": 0,
    # Passes of loop-invariant code take a twentieth to an eighth of the compile time and move little out of our loops.
    "xla_disable_hlo_passes": "while-loop-invariant-code-motion",
    "xla_cpu_use_fusion_emitters": False,
    # Its fused products crash on some sizes of small matrices.
    "xla_cpu_experimental_ynn_fusion_type": "",
}
THOROUGH = {
    "xla_backend_optimization_level": 1,
    "xla_cpu_use_fusion_emitters": False,
    "xla_llvm_disable_expensive_passes": True,
    "xla_cpu_experimental_ynn_fusion_type": "",
}
# Removed in jaxlib 0.11, whose compiler refuses unknown names.
if jax.__version_info__ >= (0, 11):
    for options in (QUICK, THOROUGH):
        del options["xla_cpu_use_fusion_emitters"]
# JAX accepts options only at the outermost call: a kernel within another one is compiled with its options.
OPTIONS = {"quick": QUICK, "thorough": THOROUGH, "nested": None}
# Variants of a kernel that are remembered, for different structures and functions: each takes 5 to 40 MB.
MOST_VARIANTS = 32
# Share of a process's memory maps at which compiled code is released. A program takes some 300 maps, the program of a
# motion in space 2000. Beyond the limit, 65 530 on Linux, the compiler aborts the process. Counting takes 10 ms, so it
# happens only if programs since the last count may have reached the share.
FULL = 0.6
MAPS_OF_PROGRAM = 2000


_thorough = False
# Programs that may be compiled before memory maps are counted again.
_programs_left = 0


def compile_thoroughly(thorough: bool, keep: bool = False) -> None:
    """Set whether compiled functions should run quickly rather than compile quickly."""
    global _thorough
    _thorough, kept.is_on = thorough, keep


def jit(function: Callable[..., Any]) -> Callable[..., Any]:
    """As :func:`flexmb.jit`, but a function that is defined again is compiled again."""
    if not callable(function):
        raise TypeError(f"fm.jit takes a function, not a {type(function).__name__}.")

    def flat(structure: Any, options: tuple[tuple[str, Any], ...], *leaves: Any):
        return function(*jax.tree.unflatten(structure, leaves), **dict(options))

    run = compiled(flat, program_name(function))

    @functools.wraps(function)
    def call(*arguments: Any, **options: Any):
        # Flattened once: a model is a tree of some thirty arrays.
        leaves, structure = jax.tree.flatten(arguments)
        return run(structure, tuple(sorted(options.items())), leaves)

    return call


def jit_beside_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """As :func:`jit`, for arguments that may contain leaves other than arrays: functions, solvers, options.

    Such leaves are compared, not traced, so they must be hashable. A function defined again is another leaf.
    """

    def flat(structure: Any, fixed: tuple[Any, ...], *leaves: Any):
        numbers = iter(leaves)
        every = [next(numbers) if leaf is _Number else leaf for leaf in fixed]
        return function(*jax.tree.unflatten(structure, every))

    run = compiled(flat, program_name(function))

    @functools.wraps(function)
    def call(*arguments: Any):
        leaves, structure = jax.tree.flatten(arguments)
        is_number = [isinstance(leaf, jax.Array | np.ndarray) for leaf in leaves]
        fixed = tuple(_Number if number else leaf for leaf, number in zip(leaves, is_number, strict=True))
        return run(structure, fixed, [leaf for leaf, number in zip(leaves, is_number, strict=True) if number])

    return call


def unguarded(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function, exempt from checks that users switch on to find faults in their own code.

    These are ``jax.numpy_rank_promotion("raise")`` and ``jax.transfer_guard("disallow")``.
    """

    @functools.wraps(function)
    def call(*arguments: P.args, **keywords: P.kwargs) -> T:
        with jax.numpy_rank_promotion("allow"), jax.transfer_guard("allow"):
            return function(*arguments, **keywords)

    return call


def is_staged() -> bool:
    """Whether operations now become part of a program, as within ``jax.jit`` but not ``jax.grad`` alone."""
    return isinstance(jax.lax.add(np.zeros(()), np.zeros(())), jax.core.Tracer)


def compiled(function: Callable[..., Any], name: str, counts: bool = True) -> Callable[..., Any]:
    """``run(structure, fixed, leaves)``: ``function(structure, fixed, *leaves)``, compiled by the settings.

    ``counts``: whether compilations are counted by this name.
    """

    def whole(structure: Any, fixed: tuple[Any, ...], *leaves: Any):
        return jax.tree.map(_strong, function(structure, fixed, *leaves))

    @functools.lru_cache(MOST_VARIANTS)
    def variant(structure: Any, fixed: tuple[Any, ...], mode: str, keeps: bool, _: Any):
        def counted(*leaves: Any):
            with noted(name, structure, fixed, leaves, counts):
                return whole(structure, fixed, *leaves)

        key = (whole, structure, fixed) if keeps else None

        def program(*leaves: Any):
            global _programs_left
            _programs_left -= 1
            return kept.call_kept(counted, key, leaves)

        # The list stores whether the program was found to call the host.
        return under_name(counted if mode == "nested" else program, name, OPTIONS[mode]), [False]

    @unguarded
    def run(structure: Any, fixed: tuple[Any, ...], leaves: list[Any]):
        leaves, traced = _call_arguments(leaves)
        if traced:
            # Programs of this package call the host in another way than a user's program does.
            return variant(structure, fixed, "nested", False, (exact(fixed), is_within_run()))[0](*leaves)
        # Within a trace known numbers would be traced too: leave its context.
        with one_thread(), jax.core.eval_context():
            mode = "thorough" if _thorough else "quick"
            program, calls_host = variant(structure, fixed, mode, _is_anywhere(leaves), exact(fixed))
            with Run(calls_host) as running:
                results = running.finished(program(*leaves))
            if _programs_left < 0:
                make_room()
            return results

    return run


def _is_anywhere(leaves: list[Any]) -> bool:
    """Whether arrays may lie on any device: kept programs run on the first one."""
    return jax.default_backend() == "cpu" or not any(getattr(leaf, "committed", False) for leaf in leaves)


def under_name(function: Callable[..., Any], name: str, options: dict[str, Any] | None) -> Any:
    """A function of arrays, to be compiled by JAX under a name."""

    def program(*leaves: Any):
        return function(*leaves)

    program.__name__ = name
    return jax.jit(program, compiler_options=options)


def make_room(share: float = FULL) -> bool:
    """Release compiled code if memory maps may run out above a share of their limit; whether it was released."""
    global _programs_left
    try:
        most = int(Path("/proc/sys/vm/max_map_count").read_text(encoding="ascii"))
        with open("/proc/self/maps", "rb") as maps:
            used = sum(1 for _ in maps)
    except OSError:
        # Only Linux has such a limit.
        return False
    _programs_left = int(FULL * most - used) // MAPS_OF_PROGRAM
    if used > share * most:
        logging.getLogger("flexmb").info("compiled code is given back: it took %d of %d memory maps", used, most)
        jax.clear_caches()
        forget()
        return True
    return False


def exact(thing: Any) -> Any:
    """Representation of an option that distinguishes equal values of different kind, such as 1, 1.0, True and -0.0."""
    if type(thing) is tuple:
        return tuple(map(exact, thing))
    return type(thing), repr(thing) if type(thing) in (float, complex) else thing


def program_name(function: Callable[..., Any]) -> str:
    """Name under which programs are listed."""
    return f"{getattr(function, '__module__', '')}.{getattr(function, '__name__', 'function')}"


def _call_arguments(leaves: list[Any]) -> tuple[list[Any], bool]:
    """Leaves as compiled code takes them, and whether any is traced; one pass at every call.

    Numbers of weak type, such as floats of Python, would be another type and another program.
    """
    known, traced = _known(), False
    for place, leaf in enumerate(leaves):
        kind = type(leaf)
        if kind is np.ndarray or (kind is known and not leaf.weak_type):
            continue
        traced = traced or isinstance(leaf, jax.core.Tracer)
        leaves[place] = _strong(leaf)
    return leaves, traced


@functools.cache
def _known() -> type:
    """The class of JAX's arrays: comparing it is quicker than ``isinstance(.., jax.Array)``."""
    # First asked within a trace, it would be the class of traced arrays.
    with jax.ensure_compile_time_eval():
        return type(jax.device_put(np.zeros(())))


def _strong(number: Any) -> Any:
    """A number or array of strong type."""
    # Random keys have no weak type.
    weak_type = getattr(number, "weak_type", False)
    weak = weak_type if isinstance(number, jax.Array) else isinstance(number, bool | int | float | complex)
    # By NumPy: JAX compiles a program to convert a number.
    library = jnp if isinstance(number, jax.Array) else np
    return library.asarray(number, jnp.result_type(number)) if weak else number


class _Number:
    """Stands for an array among the leaves that are compared."""


def traced_once(function: Callable[..., Any]) -> Callable[..., Any]:
    """Keep the trace of a function of pytrees of arrays, for all kernels that call it with equal shapes.

    Tracing, which no cache on disk saves, then costs its time once a process instead of once a kernel.
    """
    return functools.wraps(function)(jax.jit(function))


def as_primitives(function: Callable[..., Any]) -> Callable[..., Any]:
    """Trace a small function once to primitive operations, before it is differentiated and mapped.

    Functions of ``jax.numpy`` are compiled functions, which ``jax.vmap`` and ``jax.jvp`` would transform one by one,
    in twice the time.
    """

    @functools.wraps(function)
    def call(*arguments: Any, **named: Any):
        leaves, structure = jax.tree.flatten((arguments, named))

        def flat(*leaves: Any):
            arguments, named = jax.tree.unflatten(structure, leaves)
            return function(*arguments, **named)

        program, shape = jax.make_jaxpr(flat, return_shape=True)(*(jax.typeof(leaf) for leaf in leaves))
        return jax.tree.unflatten(
            jax.tree.structure(shape), jax.core.eval_jaxpr(program.jaxpr, program.consts, *leaves)
        )

    return call
