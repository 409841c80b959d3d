"""Expressions and statements of C, the workspace that they share, and how they become the text of a file."""

import contextlib
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np


class Place:
    """The place of a number: a buffer or table, factors of loop counters by C expression, and a constant."""

    __slots__ = ("buffer", "constant", "terms")

    def __init__(self, constant: int = 0, terms: dict[str, int] | None = None, buffer: int | str | None = None):
        self.constant, self.buffer = int(constant), buffer
        self.terms = {key: int(factor) for key, factor in (terms or {}).items() if factor}

    def __add__(self, other: "Place | int") -> "Place":
        if not isinstance(other, Place):
            return Place(self.constant + other, self.terms, self.buffer)
        terms = dict(self.terms)
        for key, factor in other.terms.items():
            terms[key] = terms.get(key, 0) + factor
        return Place(self.constant + other.constant, terms, other.buffer if self.buffer is None else self.buffer)

    def __mul__(self, factor: int) -> "Place":
        return Place(self.constant * factor, {key: value * factor for key, value in self.terms.items()})

    def __str__(self) -> str:
        text = ""
        for key, factor in self.terms.items():
            text += ("-" if factor < 0 else "+") + (key if abs(factor) == 1 else f"{abs(factor)}*{key}")
        if self.buffer is not None:
            return f"{{@{self.buffer}{self.constant:+d}}}{text}"
        if self.constant or not text:
            text += f"{self.constant:+d}"
        return text.removeprefix("+")


def variable(name: str) -> Place:
    """A loop counter or another integer of C."""
    return Place(0, {name: 1})


class ArrayView(NamedTuple):
    """Numbers in memory: array of C, place of the first one, strides, shape and type."""

    pool: str
    start: Place
    strides: tuple[int, ...]
    shape: tuple[int, ...]
    dtype: np.dtype

    def place(self, index: list[Place]) -> Place:
        """Place of an entry."""
        place = self.start
        for position, stride in zip(index, self.strides, strict=True):
            place = place + position * stride
        return place

    def at(self, index: list[Place]) -> str:
        """An entry as a C expression."""
        return f"{self.pool}[{self.place(index)}]"

    def by_axes(self, axes: Sequence[int | None], shape: tuple[int, ...]) -> "ArrayView":
        """An array of another shape: the place of each axis in it, None for the first entry."""
        strides = [0] * len(shape)
        for axis, stride in zip(axes, self.strides, strict=True):
            if axis is not None:
                strides[axis] = stride
        return self._replace(strides=tuple(strides), shape=shape)

    def part(self, starts: Sequence[Place], shape: tuple[int, ...], steps: Sequence[int] | None = None) -> "ArrayView":
        """A part from a place on, in steps along each axis, which may be negative."""
        strides = [stride * step for stride, step in zip(self.strides, steps or [1] * len(shape), strict=True)]
        return self._replace(start=self.place(list(starts)), strides=tuple(strides), shape=shape)

    @property
    def cost(self) -> int:
        """No operations."""
        return 0


class Lazy(NamedTuple):
    """Numbers that are computed where they are read.

    Attributes:
        at: Expression of an entry.
        cost: Number of operations in it; 0 if it may be read repeatedly.
    """

    at: Callable[[list[Place]], str]
    cost: int
    shape: tuple[int, ...]
    dtype: np.dtype

    def by_axes(self, axes: Sequence[int | None], shape: tuple[int, ...]) -> "Lazy":
        """As :meth:`ArrayView.by_axes`."""
        return self._replace(
            at=lambda index: self.at([Place() if axis is None else index[axis] for axis in axes]), shape=shape
        )

    def part(self, starts: Sequence[Place], shape: tuple[int, ...], steps: Sequence[int] | None = None) -> "Lazy":
        """As :meth:`ArrayView.part`."""
        places = list(zip(starts, steps or [1] * len(shape), strict=True))
        return self._replace(
            at=lambda index: self.at([start + i * step for (start, step), i in zip(places, index, strict=True)]),
            shape=shape,
        )


Value = ArrayView | Lazy


def compact(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Strides of an array in row order."""
    strides, size = [], 1
    for length in reversed(shape):
        strides.append(size)
        size *= length
    return tuple(reversed(strides))


def even_strides(numbers: np.ndarray) -> tuple[int, tuple[int, ...]] | None:
    """Start and strides of integers that grow evenly along each axis; None for others."""
    if not numbers.size:
        return 0, (0,) * numbers.ndim
    first = int(numbers.flat[0])
    seconds = [int(np.take(numbers, min(length, 2) - 1, axis).flat[0]) for axis, length in enumerate(numbers.shape)]
    strides = tuple(second - first for second in seconds)
    grown = first + np.tensordot(np.array(strides, int), np.indices(numbers.shape), 1)
    return (first, strides) if np.array_equal(grown, numbers) else None


def transposed(value: Value, order: Sequence[int]) -> Value:
    """The same numbers with axes in another order."""
    axes = [order.index(axis) for axis in range(len(order))]
    return value.by_axes(axes, tuple(value.shape[axis] for axis in order))


def reshaped(view: ArrayView, shape: tuple[int, ...]) -> ArrayView | None:
    """The same numbers in another shape; None if that needs more than one stride an axis."""
    if 0 in shape:
        return view._replace(shape=shape, strides=(0,) * len(shape))
    old = [(length, stride) for length, stride in zip(view.shape, view.strides, strict=True) if length != 1]
    # Merge axes that one longer axis could replace.
    merged: list[list[int]] = []
    for length, stride in old:
        if merged and merged[-1][1] == stride * length:
            merged[-1] = [merged[-1][0] * length, stride]
        else:
            merged.append([length, stride])
    strides = []
    for length in reversed(shape):
        if length == 1:
            strides.append(0)
            continue
        if not merged or merged[-1][0] % length:
            return None
        strides.append(merged[-1][1])
        merged[-1] = [merged[-1][0] // length, merged[-1][1] * length]
        if merged[-1][0] == 1:
            merged.pop()
    return view._replace(shape=shape, strides=tuple(reversed(strides)))


def c_type(dtype: np.dtype) -> str:
    """Type of a number in C."""
    return "double" if dtype.kind == "f" else "int64_t"


def c_array(kind: str, name: str, words: Sequence[str], count: int | None = None) -> str:
    """Definition of a constant array in C. It may have more entries (``count``) than words; the rest is zero."""
    lines = [""]
    for word in words:
        if len(lines[-1]) + len(word) > 110:
            lines.append("")
        lines[-1] += f"{word}, "
    return f"static const {kind} {name}[{count or len(words)}] = {{\n" + "\n".join(lines).rstrip(", ") + "\n};"


def c_numbers(name: str, values: Any) -> str:
    """Definition of a constant array of numbers in C."""
    return c_array("double", name, [repr(float(value)) for value in values])


def literal(value: Any, dtype: np.dtype) -> str:
    """A constant in C."""
    if dtype.kind != "f":
        value = int(value)
        if value == -(2**63):  # C has no literal for it.
            return "INT64_MIN"
        text = str(value) if abs(value) < 2**31 else f"INT64_C({value})"
    else:
        value = float(value)
        text = repr(value)
        if not np.isfinite(value):
            text = "NAN" if np.isnan(value) else "INFINITY" if value > 0 else "-INFINITY"
    return f"({text})" if text.startswith("-") else text


# Number of statements in a C function: compile time grows faster than the length.
STATEMENTS = 50
# Number of zeros in a table from which on they are skipped.
ZEROS = 4
MARK = re.compile(r"\{@(\d+)([+-]\d+)\}")
TABLE = re.compile(r"\{@([KI]\d+)([+-]\d+)\}")


class Compound(NamedTuple):
    """A loop or branch: texts, each with the statements after it, and text at the end."""

    sections: list[tuple[str, list["Statement"]]]
    end: str


Statement = str | Compound


class Tables:
    """Constants of a file, each once."""

    def __init__(self):
        self._arrays: list[np.ndarray] = []
        self._known: dict[tuple, str] = {}

    def value(self, array: np.ndarray) -> Value:
        """An array of constants: a number, evenly growing integers, or a place in a table."""
        array = np.asarray(array)
        shape, dtype = array.shape, array.dtype
        if not array.size or all(_same(array, axis) for axis in range(array.ndim)):
            text = literal(array.flat[0], dtype) if array.size else "0"
            return Lazy(lambda index: text, 0, shape, dtype)
        if dtype.kind in "iu" and even_strides(array) is not None:
            return Lazy(lambda index: f"({self.integer(array, index)})", 0, shape, dtype)
        # Axes along which nothing changes are not written out.
        moving = [axis for axis, n in enumerate(shape) if n > 1 and not _same(array, axis)]
        short = array[tuple(slice(None) if axis in moving else slice(0, 1) for axis in range(array.ndim))]
        pool = "K" if dtype.kind == "f" else "I"
        short_strides = compact(short.shape)
        strides = tuple(short_strides[axis] if axis in moving else 0 for axis in range(array.ndim))
        return ArrayView(pool, self.start(pool, short), strides, shape, dtype)

    def integer(self, array: np.ndarray, index: list[Place]) -> Place:
        """An entry of an array of integers as a place."""
        if even := even_strides(array):
            return ArrayView("", Place(even[0]), even[1], array.shape, array.dtype).place(index)
        return variable(self.value(array).at(index))

    def start(self, pool: str, array: np.ndarray) -> Place:
        """Place of an array in a table, "K" of numbers or "I" of integers."""
        array = np.ascontiguousarray(array, float if pool == "K" else np.int64)
        key = (pool, array.tobytes())
        if key not in self._known:
            self._known[key] = f"{pool}{len(self._arrays)}"
            self._arrays.append(array)
        return Place(buffer=self._known[key])

    def completed(self, code: str) -> str:
        """Definitions of the tables in a text, and the text with their places filled in."""
        starts: dict[str, int] = {}
        numbers: dict[str, list[str]] = {"K": [], "I": []}

        def put(match: re.Match) -> str:
            name = match[1]
            if name not in starts:
                array, table = self._arrays[int(name[1:])], numbers[name[0]]
                starts[name] = len(table)
                table.extend(literal(number, array.dtype) for number in array.ravel())
            return str(starts[name] + int(match[2]))

        code = TABLE.sub(put, code)
        for pool, kind in (("I", "int64_t"), ("K", "double")):
            if words := list(_words(numbers[pool])):
                code = c_array(kind, pool, words, len(numbers[pool])) + "\n" + code
        return code


def _words(numbers: list[str]) -> Iterator[str]:
    """Entries of a table in C; a place in brackets skips zeros."""
    skipped = 0
    for place, number in enumerate(numbers):
        if number in ("0.0", "0"):
            skipped += 1
            continue
        zeros = 0 if skipped > ZEROS else skipped
        yield from ["0"] * zeros
        yield number if skipped == zeros else f"[{place}] = {number}"
        skipped = 0


def _same(array: np.ndarray, axis: int) -> bool:
    first = np.take(array, [0], axis)
    return np.broadcast_to(first, array.shape).tobytes() == np.ascontiguousarray(array).tobytes()


class Writer:
    """Statements in order, and their buffers; ``helpers`` are called functions of ``runtime.c``.

    ``constants`` are the numbers of operands that are known.
    """

    def __init__(self, tables: Tables, constants: Mapping[Any, np.ndarray]):
        self.tables, self.constants = tables, constants
        self.helpers: dict[str, None] = {}
        self.statements: list[Statement] = []
        self._buffers: list[tuple[str, int]] = []
        self._parts: list[str] = []

    def add(self, statement: Statement) -> None:
        """Append a statement."""
        self.statements.append(statement)

    @contextlib.contextmanager
    def writing(self, statements: list[Statement]) -> Iterator[list[Statement]]:
        """Append to another list of statements."""
        outside, self.statements = self.statements, statements
        yield statements
        self.statements = outside

    def helper(self, name: str) -> str:
        """Name of a function of ``runtime.c``, which becomes part of the file."""
        self.helpers[name] = None
        return name

    def new(self, shape: tuple[int, ...], dtype: np.dtype) -> ArrayView:
        """A buffer for an array."""
        pool = "w" if dtype.kind == "f" else "n"
        self._buffers.append((pool, int(np.prod(shape, dtype=int))))
        return ArrayView(pool, Place(buffer=len(self._buffers) - 1), compact(shape), shape, dtype)

    def store(self, value: Value, to: ArrayView) -> None:
        """Write an array into memory."""
        loops, index = counters("i", to.shape)
        if 0 not in to.shape:
            self.add(f"{loops}{to.at(index)} = {value.at(index)};")

    def copied(self, value: Value) -> ArrayView:
        """An array in a new buffer."""
        copy = self.new(value.shape, value.dtype)
        self.store(value, copy)
        return copy

    def stored(self, value: Value) -> ArrayView:
        """An array in memory, where it is or in a new buffer."""
        return value if isinstance(value, ArrayView) else self.copied(value)

    def in_shape(self, value: Value, shape: tuple[int, ...]) -> Value:
        """The same numbers in another shape."""
        longer = [axis for axis, n in enumerate(shape) if n != 1]
        if [shape[axis] for axis in longer] == [n for n in value.shape if n != 1]:
            remaining = iter(longer)
            return value.by_axes([next(remaining) if n != 1 else None for n in value.shape], shape)
        view = self.stored(value)
        return reshaped(view, shape) or self.copied(view)._replace(strides=compact(shape), shape=shape)

    def cheap(self, value: Value) -> Value:
        """An array that may be read repeatedly without cost."""
        return self.copied(value) if value.cost else value

    def sizes(self) -> tuple[int, int]:
        """Lengths of the workspace, of numbers and of integers."""
        return max(1, self._sizes["w"]), max(1, self._sizes["n"])

    def text(self, name: str) -> tuple[list[str], list[str]]:
        """Functions for all statements, with names that begin with ``name``, and lines that call them."""
        starts = self._placed()

        def put(match: re.Match) -> str:
            return str(starts[int(match[1])] + int(match[2]))

        functions: list[str] = []

        def lines(statements: list[Statement]) -> list[str]:
            texts = []
            for statement in statements:
                if isinstance(statement, str):
                    texts.append(MARK.sub(put, statement))
                    continue
                for text, body in statement.sections:
                    texts.append("\n".join([MARK.sub(put, text), *divided(body)]))
                texts.append(MARK.sub(put, statement.end))
            return texts

        def divided(statements: list[Statement]) -> list[str]:
            if len(statements) <= STATEMENTS:
                return lines(statements)
            calls = []
            for i in range(0, len(statements), STATEMENTS):
                body = lines(statements[i : i + STATEMENTS])
                part = f"{name}_{len(functions)}"
                head = f"static PART void {part}(double *w, int64_t *n)\n{{\n(void)w;\n(void)n;\n"
                functions.append(head + "\n".join(body) + "\n}\n")
                calls.append(f"{part}(w, n);")
            return calls

        # Only the outermost list knows the arguments.
        return functions, lines(self.statements)

    def _placed(self) -> list[int]:
        """Starts of the buffers, which share memory if they are not needed at the same time."""
        lives: dict[int, list[int]] = {}
        loops: list[tuple[int, int]] = []
        count = 0

        def visit(statements: list[Statement]) -> None:
            nonlocal count
            for statement in statements:
                if isinstance(statement, str):
                    seen(statement)
                    continue
                first = count
                for text, body in statement.sections:
                    seen(text)
                    visit(body)
                seen(statement.end)
                loops.append((first, count))

        def seen(text: str) -> None:
            nonlocal count
            for match in MARK.finditer(text):
                lives.setdefault(int(match[1]), [count, count])[1] = count
            count += 1

        visit(self.statements)
        # A buffer that is needed in a loop and outside is needed in all rounds. Inner loops come first.
        for first, end in loops:
            for life in lives.values():
                if life[0] < first <= life[1] < end or first <= life[0] < end <= life[1]:
                    life[0], life[1] = min(life[0], first), max(life[1], end - 1)
        starts = [0] * len(self._buffers)
        self._sizes = {"w": 0, "n": 0}
        busy: dict[str, list[tuple[int, int, int]]] = {"w": [], "n": []}
        for buffer, (begin, end) in sorted(lives.items(), key=lambda item: item[1][0]):
            pool, size = self._buffers[buffer]
            busy[pool] = [used for used in busy[pool] if used[2] >= begin]
            start = 0
            for other, length, _ in sorted(busy[pool]):
                if other - start >= size:
                    break
                start = max(start, other + length)
            busy[pool].append((start, size, end))
            starts[buffer] = start
            self._sizes[pool] = max(self._sizes[pool], start + size)
        return starts


def counters(letter: str, shape: tuple[int, ...]) -> tuple[str, list[Place]]:
    """Loops over an array, and the index within them; axes with one entry have no counter."""
    names = [f"{letter}{axis}" if length > 1 else "" for axis, length in enumerate(shape)]
    loops = "".join(f"F({name}, {length}) " for name, length in zip(names, shape, strict=True) if name)
    return loops, [variable(name) if name else Place() for name in names]
