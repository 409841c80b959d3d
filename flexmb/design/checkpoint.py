"""The computed part of a sweep, in a file that grows by one record a chunk; saved sweeps, read again.

The file begins with its format, a record about the sweep, and a record with the designs. Every chunk adds a record: a
head with length and checksums, then named arrays (names, types and shapes as JSON, and the numbers). A kill leaves at
worst an incomplete last record, which is dropped.
"""

import errno
import hashlib
import io
import json
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..errors import printable, warn
from ..files import check_unpacked, naming, write_whole
from ..results import RESULTS
from .chunks import gathered
from .designs import Designs

MAGIC = b"flexmb checkpoint 2\n"
# Length of the content and its SHA-256; a CRC of both follows.
HEAD = struct.Struct("<Q32s")
HEAD_SIZE = HEAD.size + 4
TYPES = ("<i8", "<i4", "<f8")

Arrays = dict[str, np.ndarray]


class Stored:
    """The contents of a checkpoint, read only.

    Attributes:
        meaning: Description of the sweep, by words.
        answers: Names of answers.
        designs: All designs of the sweep.
        units: Units by name.
    """

    def __init__(self, path: Path, file: BinaryIO):
        self.path, self.file = path, file
        if file.read(len(MAGIC)) != MAGIC:
            raise checkpoint_error(path, "is no checkpoint of a sweep, or its first record is damaged")
        head, of_designs = _next(file), _next(file)
        if not head or not of_designs:
            raise checkpoint_error(path, "is damaged: it does not name its sweep")
        try:
            header = json.loads(head)
            self.meaning, self.answers, self.units = header["meaning"], list(header["answers"]), dict(header["units"])
            named = _unpacked(of_designs)
            axes = {name.removeprefix("axis "): a for name, a in named.items() if name.startswith("axis ")}
            values = {name.removeprefix("dimension "): a for name, a in named.items() if name.startswith("dim")}
            self.designs = Designs(values, axes)
        except (ValueError, KeyError, TypeError):
            raise checkpoint_error(path, "is damaged: it does not name its sweep") from None

    def parts(self) -> Iterator[tuple[np.ndarray, Arrays, np.ndarray]]:
        """Designs, answers by name and codes of every complete record."""
        number = 0
        while (content := _next(self.file)) is not None:
            number += 1
            if not content:
                raise checkpoint_error(self.path, f"is damaged: its record {number} does not agree with its checksum")
            yield self._part(content, number)

    def _part(self, content: bytes, number: int) -> tuple[np.ndarray, Arrays, np.ndarray]:
        """Designs, answers and codes of a record."""
        try:
            named = _unpacked(content)
            rows, codes = named.pop(""), named.pop("codes")
            values = {name.removeprefix("answer "): array for name, array in named.items()}
        except (ValueError, KeyError, TypeError):
            raise checkpoint_error(self.path, f"is damaged: its record {number} is not as it was written") from None
        wrong = rows.ndim != 1 or codes.shape != rows.shape or rows.dtype != "<i8" or codes.dtype != "<i4"
        wrong = wrong or len(rows) == 0 or rows.min() < 0 or rows.max() >= self.designs.count
        wrong = wrong or not np.all(np.isin(codes, [int(code) for code in RESULTS]))
        if wrong or any(v.shape[:1] != rows.shape or v.dtype != "<f8" for v in values.values()):
            raise checkpoint_error(self.path, f"is damaged: its record {number} has wrong shapes")
        if values and set(values) != set(self.answers):
            raise checkpoint_error(self.path, f"is damaged: its record {number} has other answers")
        return rows, values, codes


def checkpoint_error(path: Path, why: str) -> ValueError:
    """An error about a checkpoint, which is left unchanged."""
    return ValueError(f"Checkpoint '{printable(path)}' {why}. Delete it or name another file.")


class Checkpoint:
    """A file with the answers of some designs of one sweep; ``parts`` are its contents when it was opened."""

    parts: list[tuple[np.ndarray, Arrays, np.ndarray]]

    def __init__(
        self,
        path: str | os.PathLike,
        meaning: dict[str, Any],
        designs: Designs,
        answers: list[str],
        units: dict[str, str],
    ):
        """Open the file, or begin it."""
        self.path, self.answers = Path(path), answers
        self.is_empty = not self.path.exists()
        if not self.is_empty and not self.path.is_file():
            raise OSError(errno.EINVAL, "it is no regular file", str(path))
        if self.is_empty:
            write_whole(self.path, _beginning(meaning, designs, answers, units))
        self.file = open(self.path, "r+b")
        try:
            self._lock()
            self._read(meaning)
        except BaseException:
            self.file.close()
            raise

    def add(self, rows: np.ndarray, values: Arrays, codes: np.ndarray) -> None:
        """Write the answers of some designs."""
        named = {"": np.asarray(rows, "<i8"), "codes": np.asarray(codes, "<i4")}
        named |= {f"answer {name}": np.ascontiguousarray(v, "<f8") for name, v in values.items()}
        with naming(self.path):
            self.file.write(_record(_packed(named)))
            self.file.flush()
        self.is_empty = False

    def close(self) -> None:
        """Close the file, and remove an empty one."""
        with naming(self.path):
            self.file.close()
        if self.is_empty:
            self.path.unlink(missing_ok=True)

    def __enter__(self) -> "Checkpoint":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _lock(self) -> None:
        """Lock out a second sweep until the process ends."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"Checkpoint '{printable(self.path)}' is being written by another sweep.") from None
        except OSError:
            # A file system without locks.
            return

    def _read(self, meaning: dict[str, Any]) -> None:
        stored = Stored(self.path, self.file)
        different = [key for key in {**stored.meaning, **meaning} if stored.meaning.get(key) != meaning.get(key)]
        if different:
            raise checkpoint_error(self.path, f"belongs to another sweep, which differs in: {', '.join(different)}")
        self.parts, good = [], self.file.tell()
        for part in stored.parts():
            self.parts.append(part)
            good = self.file.tell()
        if good < self.path.stat().st_size:
            warn(
                f"The last record of checkpoint '{printable(self.path)}' is incomplete, as after a kill. Its designs"
                " are"
                " computed again."
            )
            self.file.truncate(good)
        self.file.seek(good)


def _beginning(meaning: dict[str, Any], designs: Designs, answers: list[str], units: dict[str, str]) -> bytes:
    header = {"meaning": meaning, "answers": answers, "units": units}
    named = {f"dimension {name}": np.ascontiguousarray(v, "<f8") for name, v in designs.items()}
    named |= {f"axis {name}": np.ascontiguousarray(v, "<f8") for name, v in designs.axes.items()}
    return MAGIC + _record(json.dumps(header).encode()) + _record(_packed(named))


def _record(content: bytes) -> bytes:
    head = HEAD.pack(len(content), hashlib.sha256(content).digest())
    return head + struct.pack("<I", zlib.crc32(head)) + content


def _next(file: BinaryIO) -> bytes | None:
    """Content of the next record; empty if damaged; None at the end or if incomplete."""
    head = file.read(HEAD_SIZE)
    if len(head) < HEAD_SIZE:
        return None
    length, digest = HEAD.unpack(head[: HEAD.size])
    if struct.unpack("<I", head[HEAD.size :])[0] != zlib.crc32(head[: HEAD.size]):
        return b""
    if length > os.fstat(file.fileno()).st_size - file.tell():
        return None
    content = file.read(length)
    return content if hashlib.sha256(content).digest() == digest else b""


def _packed(arrays: Arrays) -> bytes:
    described = json.dumps([[name, array.dtype.str, array.shape] for name, array in arrays.items()]).encode()
    return b"\n".join([described, b"".join(array.tobytes() for array in arrays.values())])


def _unpacked(content: bytes) -> Arrays:
    described, _, numbers = content.partition(b"\n")
    arrays, first = {}, 0
    for name, kind, shape in json.loads(described):
        if kind not in TYPES:
            raise ValueError
        size = int(np.prod(shape, dtype=int))
        arrays[name] = np.frombuffer(numbers, kind, size, first).reshape(shape)
        first += arrays[name].nbytes
    if first != len(numbers):
        raise ValueError
    return arrays


# Designs, answers (designs, ...), codes (designs,), units, and the number of all designs of the sweep.
Contents = tuple[Designs, dict[str, np.ndarray], np.ndarray, dict[str, str], int]


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
    return designs, answers, codes[computed], stored.units, count


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
    return designs, flat, codes, dict(about["units"]), len(codes)
