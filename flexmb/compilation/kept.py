"""Compiled programs on disk, of what is made of plain values and this package's own functions.

JAX keeps compiled code too, by a number of the program that it was compiled from: to find it, a process has to trace
and to write down that program again, which takes as long as to read the code. Here it is found by what would be traced:
by the text of this package, what a function was made with, and the types of its arguments. Nothing of a user's is kept.
"""

import ast
import contextlib
import functools
import hashlib
import importlib.metadata
import importlib.util
import itertools
import json
import logging
import operator
import os
import re
import sys
import types
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from ..lazy import begun
from .host import program_on_disk

PURE = ("flexmb", "equinox", "lineax", "optimistix", "diffrax", "jaxtyping")
LIBRARIES = ("jax", "jaxlib", "numpy", "scipy", *PURE[1:])
KNOWN = {"flexmb", *LIBRARIES, *sys.stdlib_module_names}
PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis))
WITHOUT_ARRAYS = {*PLAIN, types.FunctionType, property, classmethod, staticmethod}
# Names that libraries give to a function beside its own.
ALIASES = {"ds", "swish", "hard_swish", "permute_dims", "random_gamma_grad", "checking_leaks"}
# What these hold chooses how code is compiled or written, not what is traced.
UNTRACED = (
    "flexmb.compilation.compile",
    "flexmb.compilation.executables",
    "flexmb.compilation.kept",
    "flexmb.compilation.slim",
    "flexmb.cli",
    "flexmb.fmu.primitives",
)
_RIGHT: set[str] = set()


class _Seen(NamedTuple):
    """What a module held when it was looked at: values, its classes, what these hold; its arrays and their numbers."""

    values: list[Any]
    kinds: list[type]
    methods: list[Any]
    arrays: list[np.ndarray]
    numbers: list[Any]


_SEEN: dict[str, _Seen] = {}
_NOTHING = _Seen([], [], [], [], [])
# Of a module that was taken as written.
_UNSEARCHED = _Seen([], [], [], [], [])
_runs_alone = False
WATCHED = ("jax", "jax.lax", "jax.numpy", "jax.numpy.linalg", "jax.nn", "jax.scipy.linalg", "numpy")


def read_program(things: tuple, leaves: tuple[Any, ...]) -> tuple[Path | None, Any]:
    """Where the program of a function is kept, and the program itself if it is there.

    Args:
        things: What the function follows from, options of the compiler among them.
        leaves: Its arguments.

    Returns:
        Path, or None where the function cannot be known in another process; program, or None.
    """
    log = logging.getLogger("flexmb")
    try:
        path = _path(*things, [str(jax.typeof(leaf)) for leaf in leaves])
    except Exception as reason:
        log.debug("%s is kept by JAX alone: %s", things[0], reason)
        return None, None
    try:
        names, program = _read(path)
        return path, _loaded(names, program, len(leaves))
    except Exception as reason:
        log.debug("%s is compiled: %s", things[0], reason)
        return path, None


def _loaded(names: bytes, program: bytes, count: int) -> Callable[..., Any]:
    """A program that was kept."""
    from jax.experimental.serialize_executable import deserialize_and_load

    program = zlib.decompress(program)
    program_on_disk(program)
    taken = jax.tree.structure(((0,) * count, {}))
    return deserialize_and_load(program, taken, jax.tree.structure(_built(json.loads(names))))


def kept_number(function: Callable[..., int], things: tuple) -> int:
    """A whole number that follows from plain things, kept beside the programs.

    Args:
        function: Of this package; what it raises is not kept.
        things: Its arguments.
    """
    try:
        path = _path(function, things)
    except Exception as reason:
        logging.getLogger("flexmb").debug("%s is computed: %s", function, reason)
        return function(*things)
    with contextlib.suppress(Exception):
        return int(_read(path)[0])
    found = function(*things)
    with contextlib.suppress(OSError):
        _write(path, str(found).encode(), b"")
    return found


def take_as_written(yes: bool) -> None:
    """Whether functions and numbers are taken to be those of the text, where a process runs this package alone.

    To look at each of them takes a fifteenth of a command.

    Args:
        yes: Nothing else has run that could have replaced them.
    """
    global _runs_alone
    _runs_alone = yes


def _path(*things: Any) -> Path:
    """Where what follows from things is kept; an error where they, or what they are used in, cannot be known."""
    name = _check(repr((_surroundings(), described(things))).encode()).decode()
    folder = jax.config.values["jax_compilation_cache_dir"]
    if folder is None or not jax.config.values["jax_enable_compilation_cache"]:
        raise ValueError("compiled code is not kept on disk")
    return Path(folder, f"programs/{name}")


def _read(path: Path) -> list[bytes]:
    check, *parts = path.read_bytes().split(b"\n", 2)
    if check != _check(path.name.encode(), *parts):
        path.unlink()
        raise ValueError(f"{path} was damaged")
    return parts


def _write(path: Path, *parts: bytes) -> None:
    path.parent.mkdir(mode=0o700, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}-{id(parts)}")
    try:
        part.write_bytes(b"\n".join([_check(path.name.encode(), *parts), *parts]))
        part.replace(path)
    finally:
        # It is still there where the disk is full.
        part.unlink(missing_ok=True)


def write_program(path: Path, program: jax.stages.Compiled) -> None:
    """Keep a program; nothing is written where it cannot be.

    Args:
        path: Of :func:`read_program`.
        program: As it was compiled in this process: what was read from a disk cannot be written.
    """
    from jax.experimental.serialize_executable import serialize

    try:
        code, _, results = serialize(program)
        names = json.dumps(_named(jax.tree.unflatten(results, range(results.num_leaves)))).encode()
        if jax.tree.structure(_built(json.loads(names))) != results:
            raise TypeError("its result holds what cannot be written down")
        _write(path, names, zlib.compress(_as_kept(code), 1))
    except Exception as reason:
        logging.getLogger("flexmb").debug("%s is not kept: %s", program, reason)


def _as_kept(code: bytes) -> bytes:
    """A program without what only takes time to load, or whole where it is written as is not known."""
    try:
        from .slim import slim

        return slim(code)
    except Exception as reason:
        logging.getLogger("flexmb").debug("a program is kept whole: %s", reason)
        return code


def _check(*parts: bytes) -> bytes:
    return hashlib.sha256(b"\n".join(parts)).hexdigest().encode()


def _named(tree: Any) -> Any:
    """A result as what JSON can hold; numbers stand for arrays."""
    if type(tree) in (int, bool, str, type(None)):
        return tree
    fields = tree if type(tree) is dict else getattr(tree, "_asdict", lambda: getattr(tree, "__dict__", None))()
    return [*described(type(tree)), [_named(part) for part in (tree if fields is None else fields.items())]]


def _built(names: Any) -> Any:
    if not isinstance(names, list):
        return names
    kind, parts = getattr(sys.modules[names[0]], names[1]), map(_built, names[2])
    return kind(parts) if names[0] == "builtins" else kind(**dict(parts))


@functools.cache
def _text() -> str:
    """Versions of what is traced with and text of this package, as one number."""
    found = hashlib.sha256(repr([sys.version, *map(_version, LIBRARIES)]).encode())
    for folder, folders, files in os.walk(Path(__file__).parents[1]):
        folders.sort()
        for name in sorted(files):
            if name.endswith(".py"):
                # Some hundred files: a Path for each would take as long as to read them.
                with open(os.path.join(folder, name), "rb") as file:
                    text = file.read()
                found.update(f"{os.path.basename(folder)}/{name} {len(text)}\n".encode())
                found.update(text)
    return found.hexdigest()


def _version(library: str) -> str:
    """Version of an installed library: by the name of what says it, which takes a tenth of the time to read that."""
    names = [one for folder in dict.fromkeys(sys.path) for one in _saying(folder).get(library, [])]
    return names[0] if len(names) == 1 else importlib.metadata.version(library)


@functools.cache
def _saying(folder: str) -> dict[str, list[str]]:
    """Names of what says the versions of libraries in a folder; each twice where these may say something else."""
    found: dict[str, list[str]] = {}
    if os.path.isfile(folder):
        return {library: ["zipped"] * 2 for library in LIBRARIES}
    with contextlib.suppress(OSError):
        for name in os.listdir(folder or "."):
            library, kind = re.split("[-.]", name, maxsplit=1)[0], os.path.splitext(name)[1]
            if kind in (".dist-info", ".egg-info"):
                found.setdefault(library, []).extend([name] if kind == ".dist-info" else [name] * 2)
    return found


def _surroundings() -> Any:
    """What a traced program depends on beside its arguments; an error where someone replaced functions or numbers."""
    own = [name for name in sys.modules if name.startswith("flexmb.") and name not in UNTRACED]
    for module in [sys.modules[name] for name in sorted([*own, *WATCHED]) if name in sys.modules]:
        before = _SEEN.get(module.__name__, _NOTHING)
        # A folder without code of its own has no file.
        if before is _NOTHING and module.__file__ and os.stat(module.__file__).st_mtime_ns > begun:
            raise TypeError(f"the text of {module.__name__} changed, maybe after it was read")
        if _runs_alone:
            _SEEN[module.__name__] = _UNSEARCHED
            continue
        values = list(vars(module).values())
        kinds, seen = before.kinds, _are_same(values, before.values)
        if not seen:
            kinds = [one for one in values if isinstance(one, type) and one.__module__ == module.__name__]
        methods = list(itertools.chain.from_iterable(vars(kind).values() for kind in kinds)) if kinds else []
        # An array may be written into.
        if seen and _are_same(methods, before.methods) and _numbers_of(before.arrays) == before.numbers:
            continue
        for name, value in list(vars(module).items()):
            _refuse_replaced(module, name, value)
        for one in methods:
            one = one if isinstance(one, types.FunctionType) else getattr(one, "__wrapped__", None)
            if isinstance(one, types.FunctionType) and not one.__name__.startswith("__"):
                _place(one)
        constants = [] if module.__name__ in WATCHED else _refuse_replaced_numbers(module)
        arrays = list(_arrays_in([constants, methods]))
        _SEEN[module.__name__] = _Seen(values, kinds, methods, arrays, _numbers_of(arrays))
    settings = [(k, getattr(jax.config, k, None)) for k in sorted(jax.config.values) if "cache" not in k]
    around = [os.environ.get(name) for name in ("EQX_ON_ERROR", "XLA_FLAGS")]
    return _text(), settings, around, jax.default_backend(), _machine(jax.config.values["jax_default_device"])


@functools.cache
def _machine(chosen: Any) -> tuple[int, str]:
    """What compiled code runs on, instructions of the processor included; an error where that is chosen."""
    if chosen is not None:
        raise TypeError("a device was chosen")
    from jaxlib.xla_client import get_topology_for_devices

    (device,) = jax.devices()
    return get_topology_for_devices([device]).fingerprint(), device.client.platform_version


def _arrays_in(thing: Any) -> Iterator[np.ndarray]:
    """Arrays within what can be described."""
    parts: Any = ()
    if isinstance(thing, np.ndarray):
        yield thing
    elif isinstance(thing, list | tuple):
        parts = thing
    elif isinstance(thing, dict):
        parts = thing.values()
    elif type(thing).__module__.partition(".")[0] in PURE and hasattr(thing, "__dict__"):
        parts = vars(thing).values()
    for part in parts:
        # Most of what a module holds has none, which is soon said.
        if type(part) not in WITHOUT_ARRAYS:
            yield from _arrays_in(part)


def _numbers_of(arrays: list[np.ndarray]) -> list[Any]:
    return [(array.dtype, array.shape, array.tobytes()) for array in arrays]


def _are_same(things: list[Any], others: list[Any]) -> bool:
    return len(things) == len(others) and all(map(operator.is_, things, others))


def _refuse_replaced(module: Any, name: str, value: Any) -> None:
    """Refuse a function that stands under a name where the text of the module has another."""
    function = value if isinstance(value, types.FunctionType) else getattr(value, "__wrapped__", None)
    if isinstance(function, types.FunctionType):
        if not function.__name__.startswith("__"):
            _place(function)
        alike = function.__name__.strip("_") == name.strip("_") or "<locals>" in function.__qualname__
        if not alike and name not in ALIASES and not _says(module.__file__, name, function.__name__):
            raise TypeError(f"{module.__name__}.{name} was replaced")
    elif callable(value) and not isinstance(value, type) and name not in ALIASES:
        root = type(value).__module__.partition(".")[0]
        if root not in KNOWN or root == "unittest" or isinstance(value, functools.partial):
            raise TypeError(f"{module.__name__}.{name} was replaced")


@functools.cache
def _says(file: str, name: str, function: str) -> bool:
    """Whether a module of this package gives a function another name itself."""
    text = Path(file).read_text(encoding="utf-8") if Path(file).is_relative_to(Path(__file__).parents[1]) else ""
    given = rf"\n{re.escape(name)} = [^\n]*\b{re.escape(function)}\b|\b{re.escape(function)} as {re.escape(name)}\b"
    return re.search(given, text) is not None


def _refuse_replaced_numbers(module: Any) -> list[Any]:
    """Refuse constants of a module that are not what its text says; what it says is kept, since that takes long."""
    found = []
    for name, value in sorted(vars(module).items()):
        if name.isupper() and not isinstance(value, list):
            with contextlib.suppress(Exception):
                found.append((name, described(_as_array(value))))
    constants = [vars(module)[name] for name, _ in found]
    own = _check(repr((_text(), module.__name__, found)).encode()).decode()
    if not found or own in _RIGHT:
        return constants
    path = Path(str(jax.config.values["jax_compilation_cache_dir"]), "constants", own)
    if not path.exists():
        said = _constants_of(module)
        if any(name in said and described(said[name]) != value for name, value in found):
            raise TypeError(f"a number of {module.__name__} was replaced")
        with contextlib.suppress(OSError):
            path.parent.mkdir(exist_ok=True)
            path.touch()
    _RIGHT.add(own)
    return constants


def _as_array(value: Any) -> Any:
    return np.asarray(value) if isinstance(value, np.generic) else value


def _constants_of(module: Any) -> dict[str, Any]:
    """Names and values that the text of a module gives to them."""
    found: dict[str, Any] = {}
    for line in ast.parse(Path(module.__file__).read_text(encoding="utf-8")).body:
        if isinstance(line, ast.ImportFrom):
            source = vars(
                sys.modules[importlib.util.resolve_name("." * line.level + (line.module or ""), module.__package__)]
            )
            found |= {one.asname or one.name: source[one.name] for one in line.names if one.name in source}
        elif isinstance(line, ast.Assign | ast.AnnAssign | ast.AugAssign | ast.For):
            parts = [one.value if isinstance(one, ast.Subscript) else one for one in ast.walk(line)]
            if any(isinstance(one, ast.Name) and one.id.isupper() for one in parts):
                exec(compile(ast.Module([line], []), module.__file__, "exec"), vars(module), found)
    return {name: _as_array(value) for name, value in found.items()}


def described(thing: Any) -> Any:
    """A thing as text in tuples and lists, equal for equal things everywhere; a TypeError where parts are hidden."""
    kind: Any = type(thing)
    if kind in PLAIN or thing is type(None):
        return kind.__name__, repr(thing)
    if kind in (tuple, list, dict):
        return kind.__name__, [described(one) for one in (thing.items() if kind is dict else thing)]
    if kind is jax.tree_util.PyTreeDef:
        return thing.num_leaves, described(thing.node_data()), [described(one) for one in thing.children()]
    if kind is types.FunctionType:
        cells = [cell.cell_contents for cell in thing.__closure__ or ()]
        return _place(thing), described([cells, thing.__defaults__, thing.__kwdefaults__, vars(thing)])
    if kind is np.ndarray and not thing.dtype.hasobject:
        return str(thing.dtype), thing.shape, thing.tobytes()
    if isinstance(thing, type) and thing.__module__.partition(".")[0] in KNOWN:
        if functools.reduce(getattr, thing.__qualname__.split("."), sys.modules[thing.__module__]) is thing:
            return thing.__module__, thing.__qualname__
    elif kind.__module__.partition(".")[0] in PURE:
        return described(kind), described(dict(getattr(thing, "_asdict", lambda: vars(thing))()))
    raise TypeError(f"{kind.__module__}.{kind.__qualname__} cannot be known in another process")


def _place(function: types.FunctionType) -> tuple:
    """Where the text of a function stands, in the package, a library, or Python's own."""
    name, code = function.__globals__.get("__name__", ""), function.__code__
    module: Any = sys.modules.get(name) if name.partition(".")[0] in KNOWN else None
    if module is None or vars(module) is not function.__globals__ or code.co_filename != module.__file__:
        raise TypeError(f"{name}.{function.__qualname__} cannot be known in another process")
    return name, code.co_qualname, code.co_firstlineno
