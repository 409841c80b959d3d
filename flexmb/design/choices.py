"""Choices: values without derivatives, in every combination."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import clean

# Compiling a combination takes seconds.
MOST = 100
# Longest text of a label.
LONGEST_LABEL = 24

Options = dict[str, dict[str, Any]]


def options_of(choices: Mapping[str, Any], dimensions: Sequence[str]) -> Options:
    """Values by label, by the name of the choice."""
    found: Options = {}
    for name, given in choices.items():
        if name in dimensions:
            raise ValueError(f"'{clean(name)}' is a choice and a dimension. Give it once.")
        if isinstance(given, str) or not isinstance(given, Mapping | Sequence | np.ndarray):
            raise ValueError(
                f"Choice '{clean(name)}' must be a list of values, or a dictionary of values by label, not"
                f" {_of(given)}."
            )
        if not len(given):
            raise ValueError(f"Choice '{clean(name)}' has no values. Give at least one.")
        found[name] = {clean(k): v for k, v in given.items()} if isinstance(given, Mapping) else _labelled(name, given)
    count = math.prod(len(given) for given in found.values())
    if count > MOST:
        listed = ", ".join(f"{clean(name)} {len(given)}" for name, given in found.items())
        raise ValueError(
            f"There are {count} combinations of choices ({listed}), but at most {MOST} are allowed, since each is"
            " compiled separately. Give fewer values, or search one choice after the other."
        )
    return found


def _labelled(name: str, values: Any) -> dict[str, Any]:
    """Values by their printed text if it is short and unique, otherwise by their number."""
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    labels = [_of(value) for value in listed]
    plain = len(set(labels)) == len(labels) and all(len(label) <= LONGEST_LABEL for label in labels)
    return dict(zip(labels if plain else [f"{name}[{i}]" for i in range(len(listed))], listed, strict=True))


def _of(value: Any) -> str:
    return clean(getattr(value, "__name__", None) or (value if isinstance(value, str) else repr(value)))


def combinations(options: Options) -> list[tuple[dict[str, Any], dict[str, str]]]:
    """Every combination of values by name, with its labels by name, the last choice running fastest."""
    found = []
    for labels in itertools.product(*options.values()):
        named = dict(zip(options, labels, strict=True))
        found.append(({name: options[name][label] for name, label in named.items()}, named))
    return found
