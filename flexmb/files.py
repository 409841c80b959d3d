"""Files that are read without waiting and within a limit, that appear whole or not at all; named arrays in them."""

import contextlib
import errno
import importlib
import io
import itertools
import json
import os
import re
import stat
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

# A file may unpack to so many times its size: numbers that are alike compress well. What is written here is not packed.
LARGEST_RATIO = 100
# Kind of a compressed variable in a .mat, as MATLAB's format of level 5 has it, and bytes that are unpacked at once.
COMPRESSED, PIECE = 15, 1 << 20
# A file of 100 000 beams has 12 MiB.
LARGEST_FILE = 64 * 2**20
# What a shell hands over: read as it is, whatever stands behind it.
STREAMS = ("/dev/stdin", "/dev/fd/")


def for_files(name: str) -> ModuleType:
    """A module of the extra ``io``, such as pandas.

    Raises:
        ImportError: It is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(f"This needs {name}: pip install 'flexmb[io]'.") from None


def read_whole(path: str | os.PathLike, largest: int = LARGEST_FILE) -> bytes:
    """Return the content of a regular file, or of /dev/stdin and /dev/fd/N, up to a number of bytes.

    A pipe would wait for its writer, and a device such as /dev/zero has no end.

    Raises:
        OSError: It cannot be read, is no regular file, or is larger (errno EFBIG).
    """
    # Opened so, a pipe waits for nobody.
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(handle, "rb") as file:
        state = os.fstat(handle)
        if stat.S_ISDIR(state.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
        if os.fspath(path).startswith(STREAMS):
            os.set_blocking(handle, True)
        elif not stat.S_ISREG(state.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file", os.fspath(path))
        content = file.read(largest + 1) if state.st_size <= largest else b""
    if max(len(content), state.st_size) > largest:
        raise OSError(errno.EFBIG, f"it has more than {largest} bytes", os.fspath(path))
    return content


def write_whole(path: str | os.PathLike, content: bytes) -> None:
    """Write a file in one piece: a reader sees the old one or the new one, never half of it.

    What is no file on a disk, such as /dev/stdout or a pipe, is written to as it is; a link stays one.

    Raises:
        OSError: The folder is missing, not writable or full, or the path is that of a folder.
    """
    path = _target(path)
    if path.exists() and not path.is_file():
        with naming(path):
            path.write_bytes(content)
        return
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "There is no such folder", str(path.parent))
    with naming(path):
        _replace(path, content)


@contextlib.contextmanager
def naming(path: str | os.PathLike) -> Iterator[None]:
    """Name this file in every OSError within: that of a full disk has no name, that of a temporary file another."""
    try:
        yield
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror or str(fault), os.fspath(path)) from None


def _replace(path: Path, content: bytes) -> None:
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

    Raises:
        OSError: The folder is missing or not writable, the path is that of a folder, or the file is write-protected.
    """
    path = _target(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "There is no such folder", str(path.parent))
    if path.is_file() or not path.exists():
        tempfile.TemporaryFile(dir=path.parent).close()


def _target(path: str | os.PathLike) -> Path:
    """The file that a link leads to; /dev/stdout and the like as they are."""
    path = Path(path)
    return path.resolve() if path.is_symlink() and (path.is_file() or not path.exists()) else path


def write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    """Write arrays by name as .npz or .mat, as the ending of the path says; raise ValueError for another ending."""
    content = io.BytesIO()
    if path.suffix == ".npz":
        # As numpy.savez, which has arguments whose names no array can bear.
        with zipfile.ZipFile(content, "w") as archive:
            for name, value in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, np.asarray(value), allow_pickle=False)
    elif path.suffix == ".mat":
        import scipy.io

        scipy.io.savemat(content, _as_variables(arrays), oned_as="column", long_field_names=True)
    else:
        raise ValueError(f"Results are saved as .npz or .mat, not '{path.suffix or path}'.")
    write_whole(path, content.getvalue())


def save_arrays(path: str | os.PathLike, arrays: dict[str, Any], about: dict[str, Any]) -> None:
    """Write arrays by name as .npz or .mat, and texts as JSON under "about", which no array may be called."""
    if "about" in arrays:
        raise ValueError("An array named 'about' cannot be saved beside what is said about all of them: rename it.")
    write_arrays(Path(path), {**arrays, "about": np.asarray(json.dumps(about))})


def check_unpacked(content: bytes) -> None:
    """Refuse an .npz or a .mat that unpacks to more than so many times its size, before it does.

    Raises:
        ValueError: It does; or it is damaged.
    """
    most = LARGEST_RATIO * len(content)
    if content[:2] == b"PK":
        # No member gives more than its entry in the directory says.
        size = sum(member.file_size for member in zipfile.ZipFile(io.BytesIO(content)).infolist())
    else:
        size = _size_of_compressed(content, most)
    if size > most:
        raise ValueError(f"it unpacks to more than {LARGEST_RATIO} times its size")


def _size_of_compressed(content: bytes, most: int) -> int:
    """Bytes that the compressed variables of a .mat unpack to, counted piece by piece up to a limit."""
    order, at, size = ">" if content[126:128] == b"MI" else "<", 128, 0
    while at + 8 <= len(content) and size <= most:
        kind, count = struct.unpack_from(f"{order}II", content, at)
        at += 8 + count
        if kind == COMPRESSED:
            unpacker, rest = zlib.decompressobj(), content[at - count : at]
            while rest and size <= most:
                size += len(unpacker.decompress(rest, PIECE))
                rest = unpacker.unconsumed_tail
    return size


def _as_variables(arrays: dict[str, Any]) -> dict[str, Any]:
    """The same under names that MATLAB takes, no two alike; where some differ, "names_of_arrays" says so as JSON."""
    of_names = "names_of_arrays"
    while of_names in arrays:
        of_names += "_"
    names = _matlab_names([of_names, *arrays])
    changed = {names[name]: name for name in arrays if names[name] != name}
    found = {names[name]: value for name, value in arrays.items()}
    return {**found, of_names: np.asarray(json.dumps(changed))} if changed else found


def _matlab_names(names: list[str]) -> dict[str, str]:
    """Letters, digits and underscores, a letter first, at most 63: a name that is so already stays."""
    found = {name: name for name in names if re.fullmatch(r"[A-Za-z]\w{0,62}", name, re.ASCII)}
    taken = set(found)
    for name in names:
        if name not in found:
            plain_name = re.sub(r"^(?![A-Za-z])", "x", re.sub(r"\W", "_", name, flags=re.ASCII))
            endings = (f"_{i}" if i > 1 else "" for i in itertools.count(1))
            found[name] = next(
                one for ending in endings if (one := plain_name[: 63 - len(ending)] + ending) not in taken
            )
            taken.add(found[name])
    return found
