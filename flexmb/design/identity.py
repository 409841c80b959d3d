"""Whether two functions or models are alike, as far as that can be seen, equal from process to process."""

import dataclasses
import functools
import hashlib
import types
from collections.abc import Iterator
from pathlib import PurePath
from typing import Any

import jax
import numpy as np

# Of these packages a function's name says what it is; of a user's, its code does.
LIBRARIES = frozenset(("flexmb", "jax", "jaxlib", "numpy", "scipy", "math", "builtins", "functools", "operator"))


def identity(*things: Any) -> str:
    """A text that differs where things are seen to differ.

    Numbers, texts, arrays, containers and records are seen by value, functions by their code, defaults, what they
    capture and what they name in their own module, but for lists, dictionaries and sets in functions and records, which
    may be notes that change as a function is called. Of anything else the type is seen alone, so that two things of one
    identity may still differ.
    """
    digest = hashlib.sha256()
    _add(digest, things, ())
    return digest.hexdigest()


def _add(digest: Any, thing: Any, within: tuple[int, ...]) -> None:
    """Describe a thing; ``within`` are those that are being described, one of which may refer to itself."""
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
    """What a thing consists of, as far as it lets itself be looked at."""
    try:
        return list(_parts(thing))
    except Exception:  # A user's class, a random key of JAX, an array that was given away.
        return []


def _parts(thing: Any) -> Iterator[Any]:
    """Bytes, and further things to be described."""
    if thing is None or isinstance(thing, bool | float | complex | str | bytes | type(...)):
        yield repr(thing).encode("utf-8", "surrogatepass")
    elif isinstance(thing, PurePath):
        # The same file may be named from here or from there.
        yield thing.name
    elif isinstance(thing, int):
        # Hexadecimal, since Python does not print some thousand decimals.
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
        yield from sorted(identity(one).encode() for one in thing)
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
            # A function that refers to what is not there yet.
            yield None
    if root in LIBRARIES:
        return
    yield function.__code__
    for name in sorted(_names(function.__code__) & function.__globals__.keys()):
        known = function.__globals__[name]
        if not isinstance(known, types.FunctionType) or str(known.__module__).partition(".")[0] in (root, *LIBRARIES):
            yield from (name, _still(known))


def _still(thing: Any) -> Any:
    """A thing, or its type where it may have changed since."""
    return type(thing) if isinstance(thing, list | dict | set) else thing


def _names(code: types.CodeType) -> set[str]:
    """Names that a function may look up globally, those within it included."""
    inner = [_names(one) for one in code.co_consts if isinstance(one, types.CodeType)]
    return set(code.co_names).union(*inner)
