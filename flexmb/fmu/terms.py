"""The parts of C expressions: places in memory, linear in loop counters, and values that are not written yet.

A number of the program is in one of four arrays of C: ``w`` (double) and ``n`` (int64_t) are the workspace, ``K`` and
``I`` the constants. Until the workspace is divided a place has a mark: ``{@3+5}`` is the sixth number of buffer 3,
``{@K3+5}`` the sixth number of table 3.
"""

from collections.abc import Callable
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
        found = self.start
        for position, stride in zip(index, self.strides, strict=True):
            found = found + position * stride
        return found

    def at(self, index: list[Place]) -> str:
        """An entry as a C expression."""
        return f"{self.pool}[{self.place(index)}]"

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


Value = ArrayView | Lazy


def compact(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Strides of an array in row order."""
    strides, size = [], 1
    for length in reversed(shape):
        strides.append(size)
        size *= length
    return tuple(reversed(strides))


def linear(numbers: np.ndarray) -> tuple[int, tuple[int, ...]] | None:
    """Start and strides of integers that grow evenly along each axis; None for others."""
    if not numbers.size:
        return 0, (0,) * numbers.ndim
    first = int(numbers.flat[0])
    strides = []
    for axis, length in enumerate(numbers.shape):
        place = [0] * numbers.ndim
        place[axis] = 1
        strides.append(int(numbers[tuple(place)]) - first if length > 1 else 0)
    grown = first + sum(
        (np.arange(length) * stride).reshape([-1 if i == axis else 1 for i in range(numbers.ndim)])
        for axis, (length, stride) in enumerate(zip(numbers.shape, strides, strict=True))
    )
    return (first, tuple(strides)) if np.array_equal(np.broadcast_to(grown, numbers.shape), numbers) else None


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
