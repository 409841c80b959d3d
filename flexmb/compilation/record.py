"""Immutable records of arrays that JAX can differentiate, batch and pass through compiled code."""

import dataclasses
from typing import Any, dataclass_transform

import jax

from ..display import Result


def static(**options: Any) -> Any:
    """A field that selects code instead of holding numbers: it is compared, not traced."""
    return dataclasses.field(metadata={"static": True}, **options)


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field, static))
class Record:
    """Base class whose subclasses are frozen dataclasses and pytrees without a decorator.

    ``equinox.Module`` does more, but its import takes a fifth of a second of each new process, and it flattens in
    Python, while JAX flattens registered dataclasses in C++ (benchmarks/first_impression.py).
    """

    def __init_subclass__(cls, **options: Any):
        super().__init_subclass__(**options)
        dataclasses.dataclass(frozen=True, eq=False, repr=not issubclass(cls, Result))(cls)
        jax.tree_util.register_dataclass(cls)
