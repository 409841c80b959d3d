"""Modules without the packages around them, of which a first answer needs nothing and which take long to import."""

import contextlib
import importlib
import importlib.util
import sys
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def empty(package: str) -> Iterator[None]:
    """Within, a package is one whose modules can be imported but that has not run; afterwards it is as if not imported.

    Nothing is done where the package is imported already. Its modules that are imported within are imported once more,
    with the package, by who asks for them later: those compiled by Cython are the same objects then.

    Args:
        package: Its full name.
    """
    if package in sys.modules:
        yield
        return
    parent, _, name = package.rpartition(".")
    around = importlib.import_module(parent)
    spec: Any = importlib.util.find_spec(package)
    sys.modules[package] = importlib.util.module_from_spec(spec)
    try:
        yield
    finally:
        for one in [one for one in sys.modules if one == package or one.startswith(f"{package}.")]:
            del sys.modules[one]
        vars(around).pop(name, None)


def alone(module: str) -> Any:
    """A module that only names what others hold, without its package.

    Args:
        module: Its full name.
    """
    with empty(module.rpartition(".")[0]):
        return importlib.import_module(module)


def find_lapack() -> None:
    """Let JAX take LAPACK from SciPy, before it imports the whole of ``scipy.linalg`` for that: a tenth of a second."""
    import numpy as np

    try:
        with empty("scipy.linalg"):
            from jaxlib.lapack import prepare_lapack_call

            prepare_lapack_call("potrf_ffi", np.float64)
    except Exception:  # Versions that look for it elsewhere.
        importlib.import_module("scipy.linalg")
