"""What is known of a sweep so far, in a file that grows by one record a chunk.

The file begins with a line that says what it is, and a record that says of which sweep. Every chunk adds a record: a
head with its length and checksums, and named arrays, that is their names, types and shapes as JSON, then their numbers.
A kill leaves the last record incomplete, at worst, which is then dropped.
"""

import hashlib
import json
import os
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..errors import clean
from ..files import write_whole
from ..results import RESULTS

MAGIC = b"flexmb checkpoint 1\n"
# Length of the content, its SHA-256, and a CRC of both.
HEAD = struct.Struct("<Q32s")
HEAD_SIZE = HEAD.size + 4
TYPES = ("<i8", "<i4", "<f8")

Arrays = dict[str, np.ndarray]


class Checkpoint:
    """A file with the answers of some designs of one sweep.

    Attributes:
        parts: Which designs it held when it was opened, with answers by name and codes.
    """

    parts: list[tuple[np.ndarray, Arrays, np.ndarray]]

    def __init__(self, path: str | os.PathLike, meaning: dict[str, Any], count: int, answers: list[str]):
        """Open the file, or begin it.

        Args:
            path: Where.
            meaning: What is compared with what the file says of its sweep, by the words for it.
            count: Number of designs.
            answers: Their names.

        Raises:
            ValueError: The file is no checkpoint, is damaged, belongs to another sweep or is in use.
            OSError: It cannot be read or written.
        """
        self.path, self.count, self.answers = Path(path), count, answers
        self.is_empty = not self.path.exists()
        if self.is_empty:
            write_whole(self.path, MAGIC + _record(json.dumps(meaning).encode()))
        self.file = open(self.path, "r+b")
        try:
            self._lock()
            self._read(meaning)
        except BaseException:
            self.file.close()
            raise

    def add(self, rows: np.ndarray, values: Arrays, codes: np.ndarray) -> None:
        """Write the answers of some designs.

        Args:
            rows: Which designs, (k,).
            values: Answers by name, (k, ...).
            codes: Codes of RESULTS, (k,).

        Raises:
            OSError: It cannot be written.
        """
        named = {"": np.asarray(rows, "<i8"), "codes": np.asarray(codes, "<i4")}
        named |= {f"answer {name}": np.ascontiguousarray(v, "<f8") for name, v in values.items()}
        self.file.write(_record(_packed(named)))
        self.file.flush()
        self.is_empty = False

    def close(self) -> None:
        """End writing; what was begun in vain is removed."""
        self.file.close()
        if self.is_empty:
            self.path.unlink(missing_ok=True)

    def __enter__(self) -> "Checkpoint":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def refusal(self, why: str) -> ValueError:
        """What to raise where the file is not what is needed; it is left as it is."""
        return ValueError(f"Checkpoint '{clean(self.path)}' {why}. Delete it or name another file.")

    def _lock(self) -> None:
        """Keep a second sweep from writing in between; the lock ends with the process."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"Checkpoint '{clean(self.path)}' is being written by another sweep.") from None
        except OSError:
            # A file system without locks.
            return

    def _read(self, meaning: dict[str, Any]) -> None:
        if self.file.read(len(MAGIC)) != MAGIC:
            raise self.refusal("is no checkpoint of a sweep, or the beginning of it is damaged")
        head = _next(self.file)
        if not head:
            raise self.refusal("is damaged: it does not say of which sweep it is")
        theirs = json.loads(head)
        different = [what for what in {**theirs, **meaning} if theirs.get(what) != meaning.get(what)]
        if different:
            raise self.refusal(f"belongs to another sweep, which differs in: {', '.join(different)}")
        self.parts, good = [], self.file.tell()
        while (content := _next(self.file)) is not None:
            if not content:
                raise self.refusal(f"is damaged: its record {len(self.parts) + 1} does not agree with its checksum")
            self.parts.append(self._part(content))
            good = self.file.tell()
        if good < self.path.stat().st_size:
            warnings.warn(
                f"The last record of checkpoint '{clean(self.path)}' is incomplete, as after a kill: its designs are"
                " computed again.",
                stacklevel=4,
            )
            self.file.truncate(good)
        self.file.seek(good)

    def _part(self, content: bytes) -> tuple[np.ndarray, Arrays, np.ndarray]:
        """Designs, answers and codes of a record."""
        number = len(self.parts) + 1
        try:
            named = _unpacked(content)
            rows, codes = named.pop(""), named.pop("codes")
            values = {name.removeprefix("answer "): array for name, array in named.items()}
        except (ValueError, KeyError, TypeError):
            raise self.refusal(f"is damaged: its record {number} is not as it was written") from None
        wrong = rows.ndim != 1 or codes.shape != rows.shape or rows.dtype != "<i8" or codes.dtype != "<i4"
        wrong = wrong or len(rows) == 0 or rows.min() < 0 or rows.max() >= self.count
        wrong = wrong or not np.all(np.isin(codes, [int(one) for one in RESULTS]))
        if wrong or any(v.shape[:1] != rows.shape or v.dtype != "<f8" for v in values.values()):
            raise self.refusal(f"is damaged: its record {number} has wrong shapes")
        if values and list(values) != self.answers:
            raise self.refusal(f"is damaged: its record {number} has other answers")
        return rows, values, codes


def _record(content: bytes) -> bytes:
    head = HEAD.pack(len(content), hashlib.sha256(content).digest())
    return head + struct.pack("<I", zlib.crc32(head)) + content


def _next(file: BinaryIO) -> bytes | None:
    """Content of the next record; empty if it is damaged; None at the end and where it is incomplete."""
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
    found, first = {}, 0
    for name, kind, shape in json.loads(described):
        if kind not in TYPES:
            raise ValueError
        size = int(np.prod(shape, dtype=int))
        found[name] = np.frombuffer(numbers, kind, size, first).reshape(shape)
        first += found[name].nbytes
    if first != len(numbers):
        raise ValueError
    return found
