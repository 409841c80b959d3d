"""Context variables: set for a while, and values collected while a function is traced."""

import contextlib
import contextvars
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def setting(variable: contextvars.ContextVar[Any], value: Any) -> Iterator[Any]:
    """Set a context variable for a while, and yield its value."""
    token = variable.set(value)
    try:
        yield value
    finally:
        variable.reset(token)


class Collector:
    """Collects values of one trace, but not of transformations within it, whose values do not exist outside."""

    def __init__(self, name: str):
        self._current: contextvars.ContextVar[tuple[Any, list[Any]] | None] = contextvars.ContextVar(name, default=None)

    @contextlib.contextmanager
    def collecting(self) -> Iterator[list[Any]]:
        """Collect values in a list that is yielded."""
        import jax.extend.core

        with setting(self._current, (jax.extend.core.get_opaque_trace_state(), [])) as (_, values):
            yield values

    def here(self) -> list[Any] | None:
        """The values so far; None if nothing is collected."""
        current = self._current.get()
        if current is None:
            return None
        import jax.extend.core

        return current[1] if current[0] == jax.extend.core.get_opaque_trace_state() else None
