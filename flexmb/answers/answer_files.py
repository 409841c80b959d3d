"""Answers as JSON, npz and mat."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..files import write_arrays
from .answers import plain


def to_json(data: dict[str, Any]) -> str:
    """One JSON object, with null for numbers that are not finite."""
    return json.dumps(plain(data), allow_nan=False, indent=1)


def _stacked(key: str, steps: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Steps as arrays "path_x_3", steps first; NaN where a step has fewer numbers or none."""
    rows = [_flat(step) for step in steps]
    names = dict.fromkeys(name for row in rows for name in row)
    return {f"{key}_{name}": _padded([row.get(name) for row in rows]) for name in names}


def _padded(column: list[Any]) -> np.ndarray:
    there = [np.asarray(value) for value in column if value is not None]
    like = max(there, key=len) if there and there[0].ndim else np.zeros(())
    filled = [np.full(like.shape, np.nan) if value is None else np.asarray(value) for value in column]
    if len({value.shape for value in filled}) == 1:
        return np.stack(filled)
    return np.stack([np.pad(v.astype(float), (0, len(like) - len(v)), constant_values=np.nan) for v in filled])


def _flat(data: dict[str, Any]) -> dict[str, Any]:
    """Inner dictionaries as arrays "x_3"; lists of dictionaries as JSON text."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat.update({f"{key}_{of}": np.asarray(v) for of, v in value.items()})
        elif key in ("path", "steps"):
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

    Raises:
        ValueError: Another ending.
        OSError: The folder is missing or not writable.
    """
    write_arrays(Path(path), _flat(data))
