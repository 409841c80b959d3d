"""Log message when a function is compiled for the third time in a process: the difference from the second time.

A notice is a line of the log "flexmb" at level INFO, since several models in one process are usual:
``logging.basicConfig(level="INFO")`` shows it.
"""

import contextlib
import contextvars
import logging
from collections.abc import Iterator
from typing import Any, NamedTuple

import jax
import numpy as np

from ..errors import printable

# A second compilation is usual, such as for a gradient or another model.
THIRD = 3
# Differences that a notice names.
MOST_NAMED = 4


class _Compilation(NamedTuple):
    number: int
    structure: Any
    options: dict[Any, Any]
    kinds: list[str]


_last: dict[str, _Compilation] = {}
# Functions within another one are compiled with it.
_within = contextvars.ContextVar("within", default=False)


@contextlib.contextmanager
def noted(name: str, structure: Any, fixed: tuple[Any, ...], leaves: Any, counts: bool = True) -> Iterator[None]:
    """Count a compilation of a function by its name; at the third, log what differs from the second."""
    if counts and not _within.get():
        before, pairs = _last.get(name), all(type(pair) is tuple and len(pair) == 2 for pair in fixed)
        kinds = [f"{leaf.dtype}{list(np.shape(leaf))}" for leaf in leaves]
        options = dict(fixed) if pairs else dict(enumerate(fixed))
        current = _last[name] = _Compilation(1 if before is None else before.number + 1, structure, options, kinds)
        if before is not None and current.number == THIRD:
            differences = _differences(before, current)
            more = f"; and {len(differences) - MOST_NAMED} more" if differences[MOST_NAMED:] else ""
            text = "%s is compiled for the third time in this process. New since the last time: %s"
            logging.getLogger("flexmb").info(text, name, "; ".join(differences[:MOST_NAMED]) + more)
    token = _within.set(True)
    try:
        yield
    finally:
        _within.reset(token)


def _differences(before: _Compilation, current: _Compilation) -> list[str]:
    """Shapes of arguments by name, options, and structure."""
    old, new = (_named(asked.structure, asked.kinds) for asked in (before, current))
    differences = [f"{at} {old[at]} -> {new[at]}" for at in new if at in old and old[at] != new[at]]
    differences += [f"{at} is gone" for at in old if at not in new] + [f"{at} {new[at]}" for at in new if at not in old]
    for name in dict.fromkeys((*before.options, *current.options)):
        texts = [printable(repr(options.get(name))) for options in (before.options, current.options)]
        differences += [f"option {name} {' -> '.join(texts)}"] if texts[0] != texts[1] else []
    if not differences and before.structure != current.structure:
        differences = ["the structure: element types, their options, or other values that choose code"]
    return differences or ["operations of the function, a use in jax.grad or jax.vmap, or a setting"]


def _named(structure: Any, kinds: list[str]) -> dict[str, str]:
    """Kinds of arrays by the names of the arguments, properties and fields that contain them."""
    if structure is None or structure.num_leaves != len(kinds):
        return {f"number {i + 1}": kind for i, kind in enumerate(kinds)}
    leaves, _ = jax.tree_util.tree_flatten_with_path(jax.tree.unflatten(structure, kinds))
    return {f"argument{jax.tree_util.keystr(path)}": kind for path, kind in leaves}
