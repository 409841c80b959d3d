"""Calls that make a Builder's contents: recorded as they are made, and repeated on another Builder."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar, cast

from ..arguments import copied

F = TypeVar("F", bound=Callable[..., Any])


class MadeCall(NamedTuple):
    """A call of a Builder's method, with its own copies of the arguments."""

    method: str
    positional: tuple[Any, ...]
    keywords: dict[str, Any]


def records_call(method: F) -> F:
    """Record each successful call of the method in ``calls`` of its Builder, unless another recorded call makes it."""

    @functools.wraps(method)
    def call(self: Any, *positional: Any, **keywords: Any) -> Any:
        if self._is_recording:
            return method(self, *positional, **keywords)
        # Iterators can be read only once.
        positional = tuple(list(argument) if isinstance(argument, Iterator) else argument for argument in positional)
        keywords = {
            name: list(argument) if isinstance(argument, Iterator) else argument for name, argument in keywords.items()
        }
        self._is_recording = True
        try:
            result = method(self, *positional, **keywords)
        finally:
            self._is_recording = False
        # A default name depends on the present contents.
        named = {"name": result} if method.__name__ == "add" else {}
        self.calls.append(MadeCall(method.__name__, _copy(positional), {**_copy(keywords), **named}))
        return result

    return cast(F, call)


def replay(calls: Iterable[MadeCall], builder: Any) -> Any:
    """Repeat calls on a Builder."""
    for call in calls:
        getattr(builder, call.method)(*call.positional, **call.keywords)
    return builder


def _copy(value: Any) -> Any:
    """A copy that the caller cannot change; records keep their identity, by which shared sections are recognised."""
    if type(value) in (list, tuple):
        return type(value)(map(_copy, value))
    return {key: _copy(entry) for key, entry in value.items()} if isinstance(value, Mapping) else copied(value)
