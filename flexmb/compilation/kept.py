"""Traced programs on disk, for functions that contain only plain values and functions of this package.

JAX keeps compiled code on disk, and finds it by the traced program. Tracing takes most of the time of a command whose
code is compiled already. A file of this module therefore stores a traced program. Its name is a digest of everything
that determines the trace: the text of this package, versions, settings of JAX, the function, its closure, and the types
of its arguments. Programs that involve a user's function or object are not stored. Replaced functions of this package
or of a library are not detected: choose another cache folder, or none, after replacing one.
"""

import contextlib
import functools
import hashlib
import importlib.metadata
import logging
import os
import pickle
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np

from ..lazy import begun
from . import host

PURE = ("flexmb", "equinox", "lineax", "optimistix", "diffrax", "jaxtyping")
LIBRARIES = ("jax", "jaxlib", "numpy", "scipy", *PURE[1:])
KNOWN = {"flexmb", *LIBRARIES, *sys.stdlib_module_names}
PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis))
# Settings of JAX that make it call functions operation by operation.
BY_OPERATIONS = ("jax_disable_jit", "jax_debug_nans", "jax_debug_infs")
# Ending of files that are being written.
PART = ".part"
log = logging.getLogger("flexmb")
# Whether programs are kept in JAX's cache folder.
is_on = False


def call_kept(function: Callable[..., Any], things: tuple | None, leaves: tuple[Any, ...]) -> Any:
    """Result of a function in a trace, by its program on disk; otherwise traced, and written if possible."""
    if any(getattr(jax.config, name) for name in BY_OPERATIONS):
        return function(*leaves)
    path = None if things is None else _path(things, leaves)
    stored = None if path is None else _read(path)
    if stored is None:
        stored = _traced(function, path, [jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for leaf in leaves])
    structure, run = stored
    return jax.tree.unflatten(structure, run(*leaves))


def remembered(function: Callable[..., int]) -> Callable[..., int]:
    """Remember a whole number that a function of this package finds by tracing, also on disk."""

    @functools.lru_cache(1000)
    def recalled(*things: Any):
        path = _path((function, *things), ())
        content = None if path is None else _content(path)
        if content is not None:
            return int(content)
        number = function(*things)
        if path is not None:
            with contextlib.suppress(OSError):
                _write(path, str(number).encode())
        return number

    return functools.wraps(function)(recalled)


def _traced(function: Callable[..., Any], path: Path | None, shapes: list[Any]) -> tuple[Any, Callable[..., Any]]:
    """Structure of a function's result, and a function that computes its leaves."""
    structure: Any = None

    def flat(*leaves: Any):
        nonlocal structure
        results, structure = jax.tree.flatten(function(*leaves))
        return results

    run = jax.jit(flat)
    host.hold_for(run.trace(*shapes).jaxpr)
    if path is not None:
        from jax import export

        try:
            calls = [export.DisabledSafetyCheck.custom_call(host.TARGET)]
            program = export.export(run, disabled_checks=calls)(*shapes)
            # A structure cannot be pickled, but a tree of that structure can.
            results = jax.tree.unflatten(structure, range(structure.num_leaves))
            _write(path, pickle.dumps((results, bytes(program.serialize()))))
            return structure, program.call
        except Exception as reason:
            log.debug("%s is not kept: %s", path.name, reason)
    return structure, run


def _read(path: Path) -> tuple[Any, Callable[..., Any]] | None:
    """What :func:`_traced` wrote; None if it is missing or unusable."""
    from jax import export

    content = _content(path)
    if content is None:
        return None
    try:
        results, program = pickle.loads(content)
        host.program_on_disk(program)
        return jax.tree.structure(results), export.deserialize(bytearray(program)).call
    except Exception as reason:
        log.debug("%s cannot be used: %s", path.name, reason)
        return None


def _content(path: Path) -> bytes | None:
    """Content of a file; None if it is missing or damaged."""
    try:
        check, content = path.read_bytes().split(b"\n", 1)
    except (OSError, ValueError) as reason:
        log.debug("%s is traced: %s", path.name, reason)
        return None
    return content if check == _check(path, content) else None


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(mode=0o700, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}-{id(content)}{PART}")
    try:
        part.write_bytes(_check(path, content) + b"\n" + content)
        part.replace(path)
    finally:
        # The part remains if the disk is full.
        part.unlink(missing_ok=True)


def _check(path: Path, content: bytes) -> bytes:
    return hashlib.sha256(path.name.encode() + content).hexdigest().encode()


def _path(key_parts: tuple, leaves: tuple[Any, ...]) -> Path | None:
    """File for a program by the things and argument types that determine it; None if they are unknown elsewhere."""
    folder = jax.config.values["jax_compilation_cache_dir"]
    try:
        if not is_on or folder is None or not jax.config.values["jax_enable_compilation_cache"]:
            raise ValueError("programs are not kept on disk")
        if getattr(jax.config, "jax_default_device", None) is not None:
            raise ValueError("a device was chosen")
        key = _surroundings(), as_nested_text(key_parts), [str(jax.typeof(leaf)) for leaf in leaves]
    except Exception as reason:
        log.debug("%s is traced in each process: %s", key_parts[0], reason)
        return None
    return Path(folder, "programs", hashlib.sha256(repr(key).encode()).hexdigest())


def _surroundings() -> Any:
    """Everything that a trace depends on besides the function and its arguments."""
    for module in [module for name, module in sys.modules.items() if name.startswith("flexmb.")]:
        _refuse_changed(module)
    settings = [(name, getattr(jax.config, name, None)) for name in sorted(jax.config.values) if "cache" not in name]
    return _text(), settings, os.environ.get("EQX_ON_ERROR"), jax.default_backend()


@functools.cache
def _refuse_changed(module: types.ModuleType) -> None:
    """Raise TypeError if the text of a module may differ from the running code, as it changed after the import."""
    # Namespace packages have no file.
    if module.__file__ and os.stat(module.__file__).st_mtime_ns > begun:
        raise TypeError(f"the text of {module.__name__} changed, maybe after it was read")


@functools.cache
def _text() -> str:
    """Digest of versions and of the text of this package."""
    versions = [sys.version, *map(importlib.metadata.version, LIBRARIES)]
    digest = hashlib.sha256(repr(versions).encode())
    package = Path(__file__).parents[1]
    for file in sorted(package.rglob("*.py")):
        text = file.read_bytes()
        digest.update(f"{file.relative_to(package)} {len(text)}\n".encode() + text)
    return digest.hexdigest()


def as_nested_text(thing: Any) -> Any:
    """Return an object as nested text. Equal objects have equal text in all processes; TypeError for unknown parts."""
    kind: Any = type(thing)
    if kind in PLAIN or thing is type(None):
        return kind.__name__, repr(thing)
    if kind in (tuple, list, dict):
        return kind.__name__, [as_nested_text(part) for part in (thing.items() if kind is dict else thing)]
    if kind is jax.tree_util.PyTreeDef:
        return thing.num_leaves, as_nested_text(thing.node_data()), [as_nested_text(part) for part in thing.children()]
    if kind is types.FunctionType:
        cells = [cell.cell_contents for cell in thing.__closure__ or ()]
        return _place(thing), as_nested_text([cells, thing.__defaults__, thing.__kwdefaults__, vars(thing)])
    if kind is np.ndarray and not thing.dtype.hasobject:
        return str(thing.dtype), thing.shape, thing.tobytes()
    if isinstance(thing, type) and thing.__module__.partition(".")[0] in KNOWN:
        if functools.reduce(getattr, thing.__qualname__.split("."), sys.modules[thing.__module__]) is thing:
            return thing.__module__, thing.__qualname__
    elif kind.__module__.partition(".")[0] in PURE:
        return as_nested_text(kind), as_nested_text(dict(getattr(thing, "_asdict", lambda: vars(thing))()))
    raise TypeError(f"{kind.__module__}.{kind.__qualname__} cannot be known in another process")


def _place(function: types.FunctionType) -> tuple:
    """Place of a function's text in the package, a library, or Python."""
    name, code = function.__globals__.get("__name__", ""), function.__code__
    module: Any = sys.modules.get(name) if name.partition(".")[0] in KNOWN else None
    if module is None or vars(module) is not function.__globals__ or code.co_filename != module.__file__:
        raise TypeError(f"{name}.{function.__qualname__} cannot be known in another process")
    return name, code.co_qualname, code.co_firstlineno
