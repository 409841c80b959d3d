"""The identity of functions and models, equal from process to process, as far as it can be seen."""

import dataclasses
import functools
import hashlib
import types
from collections.abc import Iterator
from pathlib import PurePath
from typing import Any

import jax
import numpy as np

# The name of a function of these packages identifies it; a user's function is identified by its code.
LIBRARIES = frozenset(("flexmb", "jax", "jaxlib", "numpy", "scipy", "math", "builtins", "functools", "operator"))


def identity(*things: Any) -> str:
    """A text that differs if things differ visibly.

    Numbers, texts, arrays, containers and records count by value. Functions count by code, defaults, captured values,
    and names in their own module. Lists, dictionaries and sets in functions and records count by type: they may be
    notes of calls. Other things count by type, so that different things may have one identity.
    """
    digest = hashlib.sha256()
    _add(digest, things, ())
    return digest.hexdigest()


def _add(digest: Any, thing: Any, within: tuple[int, ...]) -> None:
    """Describe a thing; ``within`` are the things around it, to which it may refer."""
    digest.update(f"{type(thing).__module__}.{type(thing).__qualname__}(".encode())
    if id(thing) in within:
        digest.update(f"^{len(within) - within.index(id(thing))}".encode())
    else:
        for part in _seen(thing):
            if isinstance(part, bytes):
                digest.update(len(part).to_bytes(8, "big") + part)
            else:
                _add(digest, part, (*within, id(thing)))
    digest.update(b")")


def _seen(thing: Any) -> list[Any]:
    """Parts of a thing, as far as they can be read."""
    try:
        return list(_parts(thing))
    except Exception:  # A user's class, a random key of JAX, a deleted array.
        return []


def _parts(thing: Any) -> Iterator[Any]:
    """Bytes, and further things to describe."""
    if thing is None or isinstance(thing, bool | float | complex | str | bytes | type(...)):
        yield repr(thing).encode("utf-8", "surrogatepass")
    elif isinstance(thing, PurePath):
        # The same file may have several paths.
        yield thing.name
    elif isinstance(thing, int):
        # Hexadecimal, since Python prints no integers of thousands of decimals.
        yield f"{thing:x}".encode()
    elif isinstance(thing, np.ndarray | np.generic | jax.Array) and not np.asarray(thing).dtype.hasobject:
        array = np.asarray(thing)
        yield f"{array.dtype} {array.shape}".encode()
        yield np.ascontiguousarray(array).tobytes()
    elif isinstance(thing, tuple | list):
        yield from thing
    elif isinstance(thing, dict):
        for pair in thing.items():
            yield from pair
    elif isinstance(thing, set | frozenset):
        yield from sorted(identity(entry).encode() for entry in thing)
    elif isinstance(thing, functools.partial):
        yield from (thing.func, thing.args, thing.keywords)
    elif isinstance(thing, types.MethodType):
        yield from (thing.__func__, thing.__self__)
    elif isinstance(thing, types.FunctionType):
        yield from _parts_of_function(thing)
    elif isinstance(thing, types.CodeType):
        yield from (thing.co_code, thing.co_consts, thing.co_names, thing.co_varnames, thing.co_freevars)
    elif isinstance(thing, type | types.ModuleType | types.BuiltinFunctionType):
        yield f"{getattr(thing, '__module__', '')}:{getattr(thing, '__qualname__', thing.__name__)}".encode()
    elif dataclasses.is_dataclass(thing):
        for field in dataclasses.fields(thing):
            yield from (field.name, _still(getattr(thing, field.name)))
    else:
        yield getattr(thing, "__wrapped__", None)


def _parts_of_function(function: types.FunctionType) -> Iterator[Any]:
    root = str(function.__module__).partition(".")[0]
    yield from (function.__module__, function.__qualname__)
    yield from (function.__defaults__, function.__kwdefaults__)
    for cell in function.__closure__ or ():
        try:
            yield _still(cell.cell_contents)
        except ValueError:
            # The captured variable is not set yet.
            yield None
    if root in LIBRARIES:
        return
    yield function.__code__
    for name in sorted(_names(function.__code__) & function.__globals__.keys()):
        known = function.__globals__[name]
        if not isinstance(known, types.FunctionType) or str(known.__module__).partition(".")[0] in (root, *LIBRARIES):
            yield from (name, _still(known))


def _still(thing: Any) -> Any:
    """A thing, or the type of a thing that may have changed."""
    return type(thing) if isinstance(thing, list | dict | set) else thing


def _names(code: types.CodeType) -> set[str]:
    """Global names in a function's code, including inner functions."""
    inner = [_names(constant) for constant in code.co_consts if isinstance(constant, types.CodeType)]
    return set(code.co_names).union(*inner)
