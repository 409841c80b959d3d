"""Arrays held to the shapes and kinds that annotations of the package say, as it runs: `python -m pytest -p shapes`.

Of each function that returns something, arrays that it took and gives are looked at, sizes of the same name together;
what is no array is left to pyright. What stands within tuples or runs in other threads is not looked at. NumPy's arrays
pass where JAX's are said, as users give them. Functions stay as they are, so that nothing else behaves otherwise:
Python tells of each call and return (``sys.setprofile``).
"""

import collections
import functools
import gc
import inspect
import os
import sys
import tempfile
import types
import typing
from pathlib import Path
from typing import Any

import jax
import jaxtyping
import numpy as np
import pytest

# What is read from a cache is not traced, and its functions are not called.
_cache = tempfile.TemporaryDirectory()
os.environ["FLEXMB_CACHE"] = _cache.name
PACKAGE = str(Path(__file__).parents[1] / "flexmb")
_functions: dict[types.CodeType, types.FunctionType] = {}
_said: dict[types.CodeType, dict[str, list[Any]]] = {}
_running: dict[int, dict[str, Any]] = {}
_seen: set[types.CodeType] = set()
_faults: collections.Counter[str] = collections.Counter()


@functools.cache
def _of_any_library(hint: Any) -> Any:
    return hint.dtype[Any, hint.dim_str]


def _arrays(hint: Any) -> list[Any]:
    """Arrays that an annotation allows."""
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return [own for one in typing.get_args(hint) for own in _arrays(one)]
    if typing.get_origin(hint) is typing.Annotated:
        return _arrays(typing.get_args(hint)[0])
    return [_of_any_library(hint)] if hasattr(hint, "dim_str") else []


def _hints(code: types.CodeType) -> dict[str, list[Any]]:
    """What the annotations of a function say of arrays."""
    if not code.co_filename.startswith(PACKAGE) or code.co_flags & inspect.CO_GENERATOR:
        return {}
    function = _functions.get(code)
    for one in gc.get_referrers(code) if function is None else ():
        function = one if isinstance(one, types.FunctionType) else function
    if hasattr(function, "__wrapped__"):
        # Its annotations are those of what it calls.
        return {}
    try:
        hints = typing.get_type_hints(function, include_extras=True)
    except NameError:
        # Of what is imported for pyright alone, or within a function.
        return {}
    return {name: own for name, hint in hints.items() if (own := _arrays(hint))}


def _look(frame: types.FrameType, event: str, given: Any) -> None:
    code = frame.f_code
    if event == "call":
        if code not in _said:
            _said[code] = _hints(code)
        if _said[code]:
            values = frame.f_locals
            _running[id(frame)] = {name: values[name] for name in _said[code] if name in values}
    elif event == "return":
        taken = _running.pop(id(frame), None)
        # What raises returns None here.
        if taken is None or given is None:
            return
        with jaxtyping.jaxtyped("context"):
            for name, value in (*taken.items(), ("return", given)):
                own = _said[code].get(name)
                if not own or not isinstance(value, jax.Array | np.ndarray):
                    continue
                _seen.add(code)
                try:
                    is_right = any(isinstance(value, one) for one in own)
                except jaxtyping.AnnotationError:
                    # A size that is said by another that is not known.
                    is_right = False
                if not is_right:
                    kinds = " or ".join(f"{one.dtype.__name__}[{one.dim_str!r}]" for one in own)
                    where = f"{Path(code.co_filename).stem}.{code.co_qualname}: {name}"
                    _faults[f"{where} is {value.dtype}{list(value.shape)}, which is no {kinds}"] += 1


@pytest.hookimpl(tryfirst=True)
def pytest_collection_finish():
    """What is there now is frozen by the tests' own hook, which hides it from who looks for it later."""
    for one in gc.get_objects():
        if isinstance(one, types.FunctionType) and one.__code__.co_filename.startswith(PACKAGE):
            _functions[one.__code__] = one


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol():
    sys.setprofile(_look)
    yield
    sys.setprofile(None)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown():
    found = "\n".join(_faults)
    _faults.clear()
    assert not found, f"annotations say otherwise:\n{found}"


def pytest_terminal_summary(terminalreporter):
    # Workers have their own.
    if _seen:
        terminalreporter.write_line(f"Annotations of {len(_seen)} functions were looked at.")
