"""Lines of a SPACAR input file: comments, blocks, and parameters checked against the form of their keyword."""

import codecs
import dataclasses
import errno
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import jax.core
import numpy as np

from ..errors import SpacarError, printable
from ..files import LARGEST_FILE, read_whole
from .arithmetic import arithmetic_result

KINEMATICS, DYNAMICS, SIGNALS, DRAWING = "kinematics", "dynamics", "inputs and outputs", "visualization"
BLOCKS = (KINEMATICS, DYNAMICS, SIGNALS)

# Whole numbers among the parameters, and their least values. All others are real numbers.
WHOLE: dict[str, int] = dict.fromkeys(
    ("element", "node", "xp", "rotp", "warpp", "xq", "rotq", "warpq", "p", "coordinate", "deformation", "number"), 1
)
WHOLE |= {"component": 1, "iterations": 1, "steps": 1, "log": 0, "store": 0, "first": 0, "last": 0}
TEXT = ("name", "law")
# Axes of a rotation in space.
AXES = ("rx", "ry", "rz")
# Nonzero numbers lie between these: squares and cubes of others leave double precision.
SMALLEST, LARGEST = 1e-100, 1e50

_WHOLE = re.compile(r"[+-]?\d{1,9}", re.ASCII)
# The largest whole number, of nine digits.
MOST = 999_999_999
# Fortran programs write 1.0D-3.
_REAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d+)?", re.ASCII)
_NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")
_DIGIT = re.compile("[1-9]")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf(inity)?)", re.ASCII | re.IGNORECASE)


class Fault(Exception):
    """A fault of one line."""


def within(value: Any) -> Any:
    """Whether numbers are zero or in the range of the format."""
    size = np.abs(value)
    return (size == 0) | ((size >= SMALLEST) & (size <= LARGEST))


_LINE = re.compile(r"([^\r\n]*)(?:\r\n|\r|\n|\Z)")
_WORD = re.compile(r"(?:\{[^{}]*\}|[^\s{}]|[{}])+")


class Placeholder(str):
    """A word "{t}" or "{E*w*t**3/12}" for a number, with numbers by name."""

    numbers: Mapping[str, Any]

    def value(self) -> Any:
        """The number, which may be traced."""
        try:
            return arithmetic_result(self[1:-1], self.numbers)
        except ValueError as fault:
            raise Fault(f"'{printable(self)}' {fault}") from None


def known(value: Any) -> bool:
    """Whether a number is not traced."""
    return not isinstance(value, jax.core.Tracer)


def is_zero(value: Any) -> bool:
    """Whether a number is known to be zero."""
    return known(value) and value == 0


@dataclasses.dataclass(frozen=True, slots=True)
class Statement:
    """One line of a file.

    Attributes:
        line: Number of the line, from 1.
        keyword: Keyword in capitals.
        raw: Text of the line, without comment.
        named: Values of placeholders; None if braces are letters.
    """

    line: int
    keyword: str
    raw: str
    named: Mapping[str, Any] | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """Parameters; keeping them would take ten times the memory of the line."""
        if self.named is None or "{" not in self.raw:
            return tuple(self.raw.split()[1:])
        return tuple(_words(self.raw, self.named))[1:]

    @property
    def numbers(self) -> set[int]:
        """Whole numbers among the parameters."""
        return {int(w) for w in self.words if _WHOLE.fullmatch(w)}


def placeholders(found: Iterable[Statement]) -> tuple[str, ...]:
    """Names in placeholders, each once, without pi."""
    words = [w for s in found for w in s.words if isinstance(w, Placeholder)]
    return tuple(dict.fromkeys(name for w in words for name in _NAME.findall(w) if name != "pi"))


def read_text(path: str | os.PathLike) -> str:
    """Text of a file in UTF-8 or Latin-1; SpacarError for another encoding or too large a file."""
    name = printable(Path(path).name)
    try:
        content = read_whole(path)
    except OSError as fault:
        if fault.errno != errno.EFBIG:
            raise
        raise SpacarError(f"{name}:1: the file is too large. An input file has at most {LARGEST_FILE} bytes") from None
    # The mark of UTF-32 begins with that of UTF-16.
    for mark, encoding in ((codecs.BOM_UTF32_LE, "32"), (codecs.BOM_UTF16_LE, "16"), (codecs.BOM_UTF16_BE, "16")):
        if content.startswith(mark):
            raise SpacarError(f"{name}:1: the file is in UTF-{encoding}; save it as UTF-8")
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise SpacarError(f"{name}:{line}: the file contains a zero byte, so it is no text in UTF-8 or Latin-1")
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        return content.decode()
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _words(line: str, numbers: Mapping[str, Any]) -> list[str]:
    """Words of a line, with words in braces as placeholders."""
    words: list[str] = []
    for word in _WORD.findall(line):
        if word[0] == "{" and word.find("}") == len(word) - 1:
            word = Placeholder(word)
            word.numbers = numbers
        words.append(word)
    return words


def statements(text: str, numbers: Mapping[str, Any] | None = None) -> Iterator[Statement]:
    """Lines with content, one by one; without ``numbers`` for placeholders braces are letters."""
    for number, line in enumerate(_LINE.finditer(text), 1):
        raw = re.split("[%#;]", line[0], maxsplit=1)[0].strip()
        if raw:
            keyword = (raw.split(maxsplit=1) if numbers is None or "{" not in raw else _words(raw, numbers))[0]
            # Other letters may have the same capitals: the ligature of f and i becomes FI.
            keyword = sys.intern(keyword.upper()) if keyword.isascii() else keyword
            yield Statement(number, keyword, raw, numbers)


class _Group(NamedTuple):
    names: list[str]
    required: bool
    repeats: bool


def _groups(form: str) -> list[_Group]:
    """Parts of a form: "node x [y] [z]", "element value ...", "node [coordinate ...]"; only the last may repeat."""
    parts = re.findall(r"\[[^\]]*\]|\S+", form.replace(" ...", ""))
    groups = [_Group(part.strip("[]").split(), part[0] != "[", False) for part in parts]
    return [*groups[:-1], groups[-1]._replace(repeats=True)] if "..." in form else groups


def parse(keyword: str, form: str, words: tuple[str, ...]) -> dict[str, Any]:
    """Parameters by name; a repeated one is a list, and a missing optional one is left out.

    In a form "[y1 y2 y3]" may be left out as a whole, "value ..." means one or more, "[value ...]" any number.
    Alternatives of different length stand between bars.
    """
    expected = f"expected: {keyword} {form}".rstrip()
    alternatives = form.split(" | ")
    groups = _groups(next((a for a in alternatives if len(a.split()) == len(words)), alternatives[-1]))
    remaining, by_name = list(words), {}
    for group in groups:
        size = len(group.names)
        if len(remaining) < size or not remaining:
            if group.required:
                raise Fault(f"too few parameters ({len(words)}); {expected}")
            continue
        if group.repeats:
            by_name[group.names[0]], remaining = remaining, []
            continue
        by_name |= zip(group.names, remaining, strict=False)
        remaining = remaining[size:]
    if remaining:
        most = sum(len(group.names) for group in groups)
        problem = "too many parameters" if len(words) > most else "not all parameters of a group"
        raise Fault(f"{problem} ({len(words)}); {expected}")
    return {name: _value(name, text, expected) for name, text in by_name.items()}


def _value(name: str, text: Any, expected: str) -> Any:
    if isinstance(text, list):
        return [_value(name, word, expected) for word in text]
    if name in TEXT:
        return text
    if name == "component" and text.lower() in AXES:
        return text.lower()
    if name in WHOLE:
        if not _WHOLE.fullmatch(text) or int(text) < WHOLE[name]:
            to = f" to {MOST}" if _WHOLE.match(text) and len(text) > 9 else ""
            raise Fault(f"{name} must be a whole number from {WHOLE[name]}{to}, but is '{printable(text)}'; {expected}")
        return int(text)
    if isinstance(text, Placeholder):
        value = text.value()
        if not known(value):
            return value
    elif _NOT_FINITE.fullmatch(text):
        raise Fault(f"{name} must be a finite number, but is '{text}'; {expected}")
    elif not _REAL.fullmatch(text):
        raise Fault(f"{name} must be a number, but is '{printable(text)}'; {expected}")
    else:
        value = float(text.lower().replace("d", "e"))
    if abs(value) > LARGEST:
        too = f"too large: at most {LARGEST:g} is taken"
        raise Fault(f"{name} must be a finite number, but '{printable(text)}' is {too}; {expected}")
    # Numbers too small for a double have become zero too.
    means_zero = value == 0 and (isinstance(text, Placeholder) or not _DIGIT.search(re.split("[eEdD]", text)[0]))
    if abs(value) < SMALLEST and not means_zero:
        raise Fault(f"{name} must be 0 or at least {SMALLEST:g}, but is '{printable(text)}'; {expected}")
    return value
