"""Names of what a compiled function depends on, equal from process to process."""

import dis
import enum
import functools
import hashlib
import importlib.metadata
import os
import sys
import types
from pathlib import Path
from typing import Any

import jax
import jax.core
import numpy as np

# What these packages define is known by its name: their versions are part of every fingerprint.
PACKAGES = ("jax", "jaxlib", "numpy", "scipy", "diffrax", "equinox", "lineax", "optimistix", "optax", "jaxtyping")
PURE = ("builtins", "math", "cmath", "functools", "operator", "itertools", "collections", "typing", "types", "enum")
TRUSTED = frozenset(("flexmb", *PACKAGES, *PURE, "numbers", "dataclasses", "abc"))
# Names by which a function may reach what is not to be seen in it.
REACHING = {"random", "open", "input", "eval", "exec", "globals", "locals", "vars", "getattr", "load", "memmap"}
REACHING |= {"loadtxt", "genfromtxt", "fromfile", "__import__"}
SETTINGS = ("jax_enable_x64", "jax_default_matmul_precision", "jax_numpy_dtype_promotion", "jax_debug_nans")
NUMBERS = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis))


class UnknownError(TypeError):
    """Something that cannot be told from its like in another process."""


def of_package() -> str:
    """Fingerprint of the code of this package, of those it is traced with, and of the settings that count."""
    settings = [(name, getattr(jax.config, name)) for name in SETTINGS] + [os.environ.get("EQX_ON_ERROR")]
    return repr((_code(), settings, jax.default_backend()))


@functools.cache
def _code() -> str:
    own = hashlib.sha256(repr((sys.version, [_version(name) for name in PACKAGES])).encode())
    root = Path(__file__).parents[1]
    for path in sorted(root.rglob("*.py")):
        own.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return own.hexdigest()


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def fingerprint(*things: Any) -> str:
    """Name of things by value, functions by their code and what they refer to.

    Args:
        things: Numbers, strings, arrays, containers, records, functions, types, structures of pytrees.

    Raises:
        UnknownError: Something whose code or state cannot be known, such as an object of a user's class.
    """
    digest = hashlib.sha256()
    _add(digest, things, ())
    return digest.hexdigest()


def _add(digest, thing: Any, within: tuple[int, ...]) -> None:
    """Describe a thing; ``within`` are the functions and containers that are being described."""
    digest.update(f"{type(thing).__module__}.{type(thing).__qualname__}(".encode())
    if id(thing) in within:
        # A function that refers to itself.
        digest.update(f"^{len(within) - within.index(id(thing))}".encode())
    else:
        for part in _parts(thing):
            if isinstance(part, bytes):
                digest.update(len(part).to_bytes(8, "big") + part)
            else:
                _add(digest, part, (*within, id(thing)))
    digest.update(b")")


def _parts(thing: Any) -> list[Any]:
    """What a thing consists of: bytes as they are, and further things."""
    if isinstance(thing, NUMBERS):
        return [repr(thing).encode()]
    if isinstance(thing, np.ndarray | np.generic | jax.Array) and not isinstance(thing, jax.core.Tracer):
        array = np.asarray(thing)
        if array.dtype.hasobject:
            raise UnknownError("an array of objects")
        return [f"{array.dtype} {array.shape}".encode(), np.ascontiguousarray(array).tobytes()]
    if isinstance(thing, tuple | list):
        return list(thing)
    if isinstance(thing, dict):
        return [part for pair in thing.items() for part in pair]
    if isinstance(thing, set | frozenset):
        return sorted(fingerprint(one).encode() for one in thing)
    if isinstance(thing, type | types.ModuleType | types.BuiltinFunctionType | np.ufunc | np.dtype):
        return [_trusted_name(thing)]
    if isinstance(thing, jax.tree_util.PyTreeDef):
        tree: Any = thing
        return [tree.node_data(), tree.num_leaves, *tree.children()]
    if isinstance(thing, enum.Enum):
        return [_trusted_name(type(thing)), thing.name]
    if isinstance(thing, functools.partial):
        return [thing.func, thing.args, thing.keywords]
    if isinstance(thing, types.MethodType):
        return [thing.__func__, thing.__self__]
    if isinstance(thing, types.FunctionType):
        return _parts_of_function(thing)
    if isinstance(thing, types.CodeType):
        return _parts_of_code(thing)
    if callable(thing) and hasattr(thing, "__wrapped__") and _root(type(thing)) in TRUSTED:
        return _parts_of_wrapper(thing)
    state = getattr(thing, "__dict__", None)
    if state is not None:
        return [_trusted_name(type(thing)), state]
    raise UnknownError(f"{type(thing).__module__}.{type(thing).__qualname__}")


def _root(thing: Any) -> str:
    return str(getattr(thing, "__module__", None) or "").partition(".")[0]


def _trusted_name(thing: Any) -> bytes:
    """Name of a module, class or function of a package whose version is known."""
    if isinstance(thing, np.dtype):
        return str(thing).encode()
    module = thing.__name__ if isinstance(thing, types.ModuleType) else getattr(thing, "__module__", None) or "numpy"
    if module.partition(".")[0] not in TRUSTED:
        raise UnknownError(f"{module} is no package whose version is known")
    return f"{module}:{getattr(thing, '__qualname__', thing.__name__)}".encode()


def _parts_of_wrapper(thing: Any) -> list[Any]:
    """Of a function that a package has wrapped: compiled, remembered."""
    if isinstance(thing, jax.custom_jvp | jax.custom_vjp) and _root(thing) not in TRUSTED:
        raise UnknownError("a function with derivatives of its own")
    return [_trusted_name(thing)] if _root(thing) in TRUSTED else [thing.__wrapped__]


def _parts_of_function(function: types.FunctionType) -> list[Any]:
    try:
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
    except ValueError:
        raise UnknownError("a function that refers to what is not there yet") from None
    bound = [cells, function.__defaults__, function.__kwdefaults__]
    if _root(function) in TRUSTED:
        return [f"{function.__module__}:{function.__qualname__}".encode(), *bound]
    known = function.__globals__
    named = [(name, known[name]) for name in sorted(_names(function.__code__)) if name in known]
    return [function.__code__, *bound, named]


def _parts_of_code(code: types.CodeType) -> list[Any]:
    if any(instruction.opname in ("IMPORT_NAME", "STORE_GLOBAL") for instruction in dis.get_instructions(code)):
        raise UnknownError("a function that imports, or changes what is global")
    if reaching := REACHING.intersection(code.co_names):
        raise UnknownError(f"a function that uses {', '.join(sorted(reaching))}")
    counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return [code.co_code, code.co_exceptiontable, code.co_consts, names, counts]


def _names(code: types.CodeType) -> set[str]:
    """Names that a function may look up globally, those within it included."""
    inner = [_names(one) for one in code.co_consts if isinstance(one, types.CodeType)]
    return set(code.co_names).union(*inner)
