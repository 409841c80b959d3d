"""Choices: values without derivatives, in every combination."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import printable

# Compiling a combination takes seconds.
MOST = 100
# Longest text of a label.
LONGEST_LABEL = 24

Options = dict[str, dict[str, Any]]


def options_of(choices: Mapping[str, Any], dimensions: Sequence[str]) -> Options:
    """Values by label, by the name of the choice."""
    options: Options = {}
    for name, values in choices.items():
        if name in dimensions:
            raise ValueError(f"'{printable(name)}' is a choice and a dimension. Give it once.")
        if isinstance(values, str) or not isinstance(values, Mapping | Sequence | np.ndarray):
            raise ValueError(
                f"Choice '{printable(name)}' must be a list of values, or a dictionary of values by label, not"
                f" {_label(values)}."
            )
        if not len(values):
            raise ValueError(f"Choice '{printable(name)}' has no values. Give at least one.")
        options[name] = (
            {printable(k): v for k, v in values.items()} if isinstance(values, Mapping) else _labelled(name, values)
        )
    count = math.prod(len(values) for values in options.values())
    if count > MOST:
        listed = ", ".join(f"{printable(name)} {len(values)}" for name, values in options.items())
        raise ValueError(
            f"There are {count} combinations of choices ({listed}), but at most {MOST} are allowed, since each is"
            " compiled separately. Give fewer values, or search one choice after the other."
        )
    return options


def _labelled(name: str, values: Any) -> dict[str, Any]:
    """Values by their printed text if it is short and unique, otherwise by their number."""
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    labels = [_label(value) for value in listed]
    plain = len(set(labels)) == len(labels) and all(len(label) <= LONGEST_LABEL for label in labels)
    return dict(zip(labels if plain else [f"{name}[{i}]" for i in range(len(listed))], listed, strict=True))


def _label(value: Any) -> str:
    return printable(getattr(value, "__name__", None) or (value if isinstance(value, str) else repr(value)))


def combinations(options: Options) -> list[tuple[dict[str, Any], dict[str, str]]]:
    """Every combination of values by name, with its labels by name, the last choice running fastest."""
    pairs = []
    for labels in itertools.product(*options.values()):
        named = dict(zip(options, labels, strict=True))
        pairs.append(({name: options[name][label] for name, label in named.items()}, named))
    return pairs
