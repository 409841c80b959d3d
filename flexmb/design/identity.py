"""Digest of functions and models, equal in every process. Parts that Python cannot read are not included."""

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


def _add(digest: Any, value: Any, within: tuple[int, ...]) -> None:
    """Describe a thing; ``within`` are the things around it, to which it may refer."""
    digest.update(f"{type(value).__module__}.{type(value).__qualname__}(".encode())
    if id(value) in within:
        digest.update(f"^{len(within) - within.index(id(value))}".encode())
    else:
        for part in _readable_parts(value):
            if isinstance(part, bytes):
                digest.update(len(part).to_bytes(8, "big") + part)
            else:
                _add(digest, part, (*within, id(value)))
    digest.update(b")")


def _readable_parts(value: Any) -> list[Any]:
    """Parts of a thing, as far as they can be read."""
    try:
        return list(_parts(value))
    except Exception:  # A user's class, a random key of JAX, a deleted array.
        return []


def _parts(value: Any) -> Iterator[Any]:
    """Bytes, and further things to describe."""
    if value is None or isinstance(value, bool | float | complex | str | bytes | type(...)):
        yield repr(value).encode("utf-8", "surrogatepass")
    elif isinstance(value, PurePath):
        # The same file may have several paths.
        yield value.name
    elif isinstance(value, int):
        # Hexadecimal, since Python prints no integers of thousands of decimals.
        yield f"{value:x}".encode()
    elif isinstance(value, np.ndarray | np.generic | jax.Array) and not np.asarray(value).dtype.hasobject:
        array = np.asarray(value)
        yield f"{array.dtype} {array.shape}".encode()
        yield np.ascontiguousarray(array).tobytes()
    elif isinstance(value, tuple | list):
        yield from value
    elif isinstance(value, dict):
        for pair in value.items():
            yield from pair
    elif isinstance(value, set | frozenset):
        yield from sorted(identity(entry).encode() for entry in value)
    elif isinstance(value, functools.partial):
        yield from (value.func, value.args, value.keywords)
    elif isinstance(value, types.MethodType):
        yield from (value.__func__, value.__self__)
    elif isinstance(value, types.FunctionType):
        yield from _parts_of_function(value)
    elif isinstance(value, types.CodeType):
        yield from (value.co_code, value.co_consts, value.co_names, value.co_varnames, value.co_freevars)
    elif isinstance(value, type | types.ModuleType | types.BuiltinFunctionType):
        yield f"{getattr(value, '__module__', '')}:{getattr(value, '__qualname__', value.__name__)}".encode()
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from (field.name, _unchanging(getattr(value, field.name)))
    else:
        yield getattr(value, "__wrapped__", None)


def _parts_of_function(function: types.FunctionType) -> Iterator[Any]:
    root = str(function.__module__).partition(".")[0]
    yield from (function.__module__, function.__qualname__)
    yield from (function.__defaults__, function.__kwdefaults__)
    for cell in function.__closure__ or ():
        try:
            yield _unchanging(cell.cell_contents)
        except ValueError:
            # The captured variable is not set yet.
            yield None
    if root in LIBRARIES:
        return
    yield function.__code__
    for name in sorted(_names(function.__code__) & function.__globals__.keys()):
        known = function.__globals__[name]
        if not isinstance(known, types.FunctionType) or str(known.__module__).partition(".")[0] in (root, *LIBRARIES):
            yield from (name, _unchanging(known))


def _unchanging(value: Any) -> Any:
    """A thing, or the type of a thing that may have changed."""
    return type(value) if isinstance(value, list | dict | set) else value


def _names(code: types.CodeType) -> set[str]:
    """Global names in a function's code, including inner functions."""
    inner = [_names(constant) for constant in code.co_consts if isinstance(constant, types.CodeType)]
    return set(code.co_names).union(*inner)
