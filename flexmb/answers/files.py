"""Answers as JSON, npz and mat."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..files import write_arrays
from .answers import plain


def to_json(data: dict[str, Any]) -> str:
    """One JSON object, numbers that are not finite as null."""
    return json.dumps(plain(data), allow_nan=False, indent=1)


def _stacked(key: str, steps: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Steps as arrays "path_x_3", steps first; what one step has fewer of is NaN there."""
    columns: dict[str, list[np.ndarray]] = {}
    for flat in map(_flat, steps):
        for name, value in flat.items():
            columns.setdefault(f"{key}_{name}", []).append(np.asarray(value))

    def padded(column: list[np.ndarray]) -> np.ndarray:
        if len({v.shape for v in column}) == 1:
            return np.stack(column)
        longest = max(len(v) for v in column)
        return np.stack([np.pad(v.astype(float), (0, longest - len(v)), constant_values=np.nan) for v in column])

    return {name: padded(column) for name, column in columns.items()}


def _flat(data: dict[str, Any]) -> dict[str, Any]:
    """Dictionaries inside dictionaries as "x_3": array; lists of them as JSON text."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat.update({f"{key}_{of}": np.asarray(v) for of, v in value.items()})
        elif key == "path":
            flat.update(_stacked(key, value))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            flat[key] = json.dumps(plain(value))
        elif isinstance(value, list):
            numbers = [np.nan if v is None else v for v in value]
            flat[key] = np.asarray(numbers)
        else:
            flat[key] = value
    return flat


def save(data: dict[str, Any], path: str | os.PathLike) -> None:
    """Save an answer as .npz or .mat, by the ending of the path.

    Args:
        data: Keys and values of an answer. Objects by node or element number become arrays "x_3", "sig_1", those of a
            path "path_x_3" with the steps first; what a JSON file has as null is NaN here, since these formats have no
            null. A .mat file says in "names_of_arrays" which names MATLAB does not take and what they became.
        path: Where; ends in .npz or .mat.

    Raises:
        ValueError: Another ending.
        OSError: The folder is missing or not writable.
    """
    write_arrays(Path(path), _flat(data))
