"""Lazy loading of a package's names on first use (PEP 562), from the stub beside its ``__init__.py``."""

import ast
import functools
import importlib
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# When this package began to be imported [ns].
begun = time.time_ns()


@functools.cache
def offered(package: str) -> dict[str, str]:
    """Names in the stub of a package, such as ``from .modes import modes as modes``, and their modules."""
    stub = Path(str(importlib.import_module(package).__file__)).with_suffix(".pyi").read_text(encoding="utf-8")
    lines = [line for line in ast.parse(stub).body if isinstance(line, ast.ImportFrom)]
    return {name.name: f"{package}.{line.module or ''}".rstrip(".") for line in lines for name in line.names}


def names(package: str, *rooms: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package; names of ``rooms`` are found too, but not listed."""

    def load(name: str) -> Any:
        if name == "__all__":
            return listed()
        where = None
        for room in () if name.startswith("__") else ("", *rooms):
            where = where or offered(f"{package}.{room}".rstrip(".")).get(name)
        if where is None:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        # Without such a name, the package has a module of that name.
        value = None if where == package else getattr(importlib.import_module(where), name, None)
        value = value or importlib.import_module(f"{where}.{name}")
        setattr(sys.modules[package], name, value)
        return value

    def listed() -> list[str]:
        return sorted(offered(package))

    return load, listed


def only(module: dict[str, Any], is_meant: Callable[[Any], bool]) -> tuple[list[str], Callable[[], list[str]]]:
    """``__all__`` and ``__dir__`` of a module by its ``globals()``: public names of values for users."""
    public_names = sorted(name for name, value in module.items() if not name.startswith("_") and is_meant(value))
    return public_names, lambda: public_names
