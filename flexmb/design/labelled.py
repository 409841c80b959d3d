"""The modules pandas and xarray, for results in labelled tables and arrays, where they are installed."""

import importlib
from types import ModuleType


def pandas() -> ModuleType:
    """The module pandas.

    Raises:
        ImportError: It is not installed.
    """
    return _optional("pandas")


def xarray() -> ModuleType:
    """The module xarray.

    Raises:
        ImportError: It is not installed.
    """
    return _optional("xarray")


def _optional(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(f"This needs {name}: pip install 'flexmb[io]'.") from None
