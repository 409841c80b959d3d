"""Files that appear whole or not at all: JSON, npz and mat."""

import errno
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from .answers import plain


def write_whole(path: str | os.PathLike, content: bytes) -> None:
    """Write a file in one piece: a reader sees the old one or the new one, never half of it.

    What is no file on a disk, such as /dev/stdout or a pipe, is written to as it is; a link stays one.

    Args:
        path: Where.
        content: What.

    Raises:
        OSError: The folder is missing, not writable or full, or the path is that of a folder.
    """
    path = _target(path)
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".flexmb.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        # mkstemp makes the file private; give it what a plain open would.
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def check_writable(path: str | os.PathLike) -> None:
    """Try whether a file can be written, and leave nothing behind.

    Args:
        path: Where.

    Raises:
        OSError: The folder is missing or not writable, the path is that of a folder, or the file is write-protected.
    """
    path = _target(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    if path.is_file() or not path.exists():
        tempfile.TemporaryFile(dir=path.parent).close()


def _target(path: str | os.PathLike) -> Path:
    """The file that a link leads to; /dev/stdout and the like as they are."""
    path = Path(path)
    return path.resolve() if path.is_symlink() and (path.is_file() or not path.exists()) else path


def to_json(data: dict[str, Any]) -> str:
    """One JSON object, numbers that are not finite as null.

    Args:
        data: Keys and values of an answer.
    """
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
            flat.update({f"{key}_{of}".replace(".", "_"): np.asarray(v) for of, v in value.items()})
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
            null.
        path: Where; ends in .npz or .mat.

    Raises:
        ValueError: Another ending.
        OSError: The folder is missing or not writable.
    """
    _write(Path(path), {name[:31]: value for name, value in _flat(data).items()} if _is_mat(path) else _flat(data))


def _is_mat(path: str | os.PathLike) -> bool:
    return Path(path).suffix == ".mat"


def _write(path: Path, arrays: dict[str, Any]) -> None:
    content = io.BytesIO()
    if path.suffix == ".npz":
        np.savez(content, allow_pickle=False, **{k: np.asarray(v) for k, v in arrays.items()})
    elif _is_mat(path):
        import scipy.io

        scipy.io.savemat(content, arrays, oned_as="column", long_field_names=True)
    else:
        raise ValueError(f"Results are saved as .npz or .mat, not '{path.suffix or path}'.")
    write_whole(path, content.getvalue())


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
    everything = {**arrays, "about": np.asarray(json.dumps(about))}
    if _is_mat(path):
        everything = {"".join(c if c.isalnum() else "_" for c in k)[:63]: v for k, v in everything.items()}
    _write(Path(path), everything)
