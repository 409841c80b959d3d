"""Saved sweeps (.npz, .mat) and checkpoints, read again."""

import errno
import io
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import printable
from ..files import check_unpacked
from ..results import RESULTS
from .checkpoint import MAGIC, Stored
from .chunks import gathered
from .designs import Designs


class Contents(NamedTuple):
    """A sweep in a file: answers are (designs, ...), codes (designs,); ``planned`` counts all designs of the sweep."""

    designs: Designs
    answers: dict[str, np.ndarray]
    codes: np.ndarray
    units: dict[str, str]
    planned: int


def read_sweep(path: str | os.PathLike) -> Contents:
    """Read a sweep."""
    path = Path(path)
    # Reading a pipe would wait for its writer.
    if path.exists() and not path.is_dir() and not path.is_file():
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    with path.open("rb") as file:
        if file.read(len(MAGIC)) == MAGIC:
            file.seek(0)
            return _of_checkpoint(Stored(path, file))
    try:
        return _of_arrays(_arrays(path.read_bytes()))
    except Exception as why:  # Readers of other formats raise anything.
        description = "no sweep that Sweep.save or a checkpoint of fm.sweep wrote, or is damaged"
        raise ValueError(f"'{printable(path)}' is {description} ({printable(why)}).") from None


def _of_checkpoint(stored: Stored) -> Contents:
    parts = [(rows, (values, codes)) for rows, values, codes in stored.parts()]
    if not parts:
        raise ValueError(f"Checkpoint '{printable(stored.path)}' has no designs yet: its sweep has just begun.")
    designs, count = stored.designs, stored.designs.count
    answers, codes = gathered(count, stored.answers, parts)
    computed = np.unique(np.concatenate([rows for rows, _ in parts]))
    if len(computed) < count:
        designs = Designs({name: values[computed] for name, values in designs.items()})
        answers = {name: values[computed] for name, values in answers.items()}
    return Contents(designs, answers, codes[computed], stored.units, count)


def _arrays(content: bytes) -> dict[str, np.ndarray]:
    """Arrays of a file by name."""
    check_unpacked(content)
    if content[:2] == b"PK":
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    import scipy.io

    arrays: dict[str, Any] = scipy.io.loadmat(io.BytesIO(content))
    # MATLAB accepts fewer names.
    changed = next((json.loads(arrays[n].item()) for n in arrays if n.rstrip("_") == "names_of_arrays"), {})
    return {changed.get(name, name): array for name, array in arrays.items()}


def _of_arrays(arrays: dict[str, np.ndarray]) -> Contents:
    about = json.loads(arrays["about"].item())
    along = list(about["axes"])
    # A .mat has at least two axes.
    shaped = {name: np.asarray(arrays[name], float).reshape(shape) for name, shape in about["shapes"].items()}
    axes: dict[str, np.ndarray] = {}
    for i, name in enumerate(along):
        axes[name] = np.moveaxis(shaped[name], i, 0).reshape(shaped[name].shape[i], -1)[:, 0]
    codes = np.asarray(arrays["codes"]).ravel().astype(np.int32)
    if not np.all(np.isin(codes, [int(code) for code in RESULTS])):
        raise ValueError("codes that no result has")
    flat = {name: array.reshape(len(codes), *array.shape[max(len(along), 1) :]) for name, array in shaped.items()}
    designs = Designs({name: flat.pop(name) for name in about["dimensions"]}, axes)
    return Contents(designs, flat, codes, dict(about["units"]), len(codes))
