"""Immutable records of arrays that JAX can differentiate, batch and pass through compiled code."""

import dataclasses
from typing import Any, dataclass_transform

import jax

from ..display import Result


def static(**options: Any) -> Any:
    """A field that chooses code rather than being a number: it is compared, not traced."""
    return dataclasses.field(metadata={"static": True}, **options)


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(dataclasses.field, static))
class Record:
    """Base class: a subclass is a frozen dataclass and a pytree, without a decorator.

    ``equinox.Module`` does the same and more; importing it takes a fifth of a second that every fresh process pays,
    and it flattens in Python where JAX flattens a registered dataclass in C++ (benchmarks/first_impression.py).
    """

    def __init_subclass__(cls, **options: Any):
        super().__init_subclass__(**options)
        dataclasses.dataclass(frozen=True, eq=False, repr=not issubclass(cls, Result))(cls)
        jax.tree_util.register_dataclass(cls)
