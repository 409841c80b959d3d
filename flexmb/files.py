"""Files: read up to a largest size, never wait for a pipe, write completely or not at all; files of named arrays."""

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

# Largest ratio of unpacked to packed size: similar numbers compress well. Files written here are not packed.
LARGEST_RATIO = 100
# Kind of a compressed variable in a .mat file of level 5, and bytes that are unpacked at once.
COMPRESSED, PIECE = 15, 1 << 20
# Most bytes of an input file; one of 100 000 beams has 12 MiB.
LARGEST_FILE = 64 * 2**20
# Streams from a shell, which are read as they are.
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
        OSError: The file cannot be read, is not regular, or is larger (errno EFBIG).
    """
    # Opened without blocking, so that a pipe does not wait for a writer.
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
    """Write a file in one piece: a reader sees the old content or the new one, never half of it.

    Anything that is not a file on a disk, such as /dev/stdout or a pipe, is written directly. Links stay links.

    Raises:
        OSError: The folder is missing, not writable or full, or the path is a folder.
    """
    path = _target(path)
    if path.exists() and not path.is_file():
        with naming(path):
            path.write_bytes(content)
        return
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "There is no such folder", str(path.parent))
    with naming(path):
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


@contextlib.contextmanager
def naming(path: str | os.PathLike) -> Iterator[None]:
    """Name this file in every OSError within: on a full disk the name is missing, for temporary files it is another."""
    try:
        yield
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror or str(fault), os.fspath(path)) from None


def check_writable(path: str | os.PathLike) -> None:
    """Test whether a file can be written, leaving nothing behind.

    Raises:
        OSError: The folder is missing or not writable, the path is a folder, or the file is write-protected.
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
    """Target of a link to a file; other paths unchanged."""
    path = Path(path)
    return path.resolve() if path.is_symlink() and (path.is_file() or not path.exists()) else path


def write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    """Write arrays by name as .npz or .mat; raise ValueError for another ending."""
    content = io.BytesIO()
    if path.suffix == ".npz":
        # Unlike numpy.savez, whose argument names no array may have.
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
    """Write arrays by name as .npz or .mat, with texts as JSON under the reserved name "about"."""
    if "about" in arrays:
        raise ValueError("An array is named 'about', which is reserved for the description of all arrays: rename it.")
    write_arrays(Path(path), {**arrays, "about": np.asarray(json.dumps(about))})


def check_unpacked(content: bytes) -> None:
    """Raise ValueError for an .npz or .mat file that is damaged or would unpack to more than LARGEST_RATIO its size."""
    most = LARGEST_RATIO * len(content)
    if content[:2] == b"PK":
        # Members unpack to no more than their entries in the directory state.
        size = sum(member.file_size for member in zipfile.ZipFile(io.BytesIO(content)).infolist())
    else:
        size = _size_of_compressed(content, most)
    if size > most:
        raise ValueError(f"it unpacks to more than {LARGEST_RATIO} times its size")


def _size_of_compressed(content: bytes, most: int) -> int:
    """Unpacked size of the compressed variables of a .mat file, counted piece by piece up to a limit."""
    order, at, size = ">" if content[126:128] == b"MI" else "<", 128, 0
    while at + 8 <= len(content) and size <= most:
        kind, count = struct.unpack_from(f"{order}II", content, at)
        at += 8 + count
        if kind == COMPRESSED:
            unpacker, remaining = zlib.decompressobj(), content[at - count : at]
            while remaining and size <= most:
                size += len(unpacker.decompress(remaining, PIECE))
                remaining = unpacker.unconsumed_tail
    return size


def _as_variables(arrays: dict[str, Any]) -> dict[str, Any]:
    """Arrays under names that MATLAB permits; "names_of_arrays" lists changed names as JSON."""
    of_names = "names_of_arrays"
    while of_names in arrays:
        of_names += "_"
    names = _matlab_names([of_names, *arrays])
    changed = {names[name]: name for name in arrays if names[name] != name}
    variables = {names[name]: value for name, value in arrays.items()}
    return {**variables, of_names: np.asarray(json.dumps(changed))} if changed else variables


def _matlab_names(names: list[str]) -> dict[str, str]:
    """Distinct MATLAB names: a letter, then letters, digits and underscores, at most 63; valid names stay."""
    new_names = {name: name for name in names if re.fullmatch(r"[A-Za-z]\w{0,62}", name, re.ASCII)}
    used = set(new_names)
    for name in names:
        if name not in new_names:
            plain_name = re.sub(r"^(?![A-Za-z])", "x", re.sub(r"\W", "_", name, flags=re.ASCII))
            endings = (f"_{i}" if i > 1 else "" for i in itertools.count(1))
            new_names[name] = next(
                candidate for ending in endings if (candidate := plain_name[: 63 - len(ending)] + ending) not in used
            )
            used.add(new_names[name])
    return new_names
