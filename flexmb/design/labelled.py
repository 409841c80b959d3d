"""Results with names that go to files, pandas and xarray."""

import importlib
import io
import json
import os
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..io.files import write_whole


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


def save_arrays(path: str | os.PathLike, arrays: dict[str, Any], about: dict[str, Any]) -> None:
    """Write named arrays as .npz or .mat, whole or not at all.

    Args:
        path: Where; its ending says how.
        arrays: By name; in a .mat a name is cut to what MATLAB allows and its dots and brackets become underscores.
        about: Texts and units, kept as JSON under "about".

    Raises:
        ValueError: Another ending.
        OSError: The folder is missing or not writable.
    """
    path, content = Path(path), io.BytesIO()
    everything = {**arrays, "about": np.asarray(json.dumps(about))}
    if path.suffix == ".npz":
        np.savez(content, allow_pickle=False, **{k: np.asarray(v) for k, v in everything.items()})
    elif path.suffix == ".mat":
        import scipy.io

        named = {"".join(c if c.isalnum() else "_" for c in k)[:63]: v for k, v in everything.items()}
        scipy.io.savemat(content, named, oned_as="column", long_field_names=True)
    else:
        raise ValueError(f"Results are saved as .npz or .mat, not '{path.suffix or path}'.")
    write_whole(path, content.getvalue())
