"""What callers of the Builder give, checked and as it is kept: names, sequences of numbers, numbers of components."""

from typing import Any

from ..arguments import as_whole, check_numbers, copied, shown
from ..elements.element import ALL
from ..errors import ModelError


def named(what: str, name: Any) -> str:
    """A name as it is kept; a number is a name too."""
    if not isinstance(name, str) and as_whole(name) is None:
        raise ModelError(f"{what} is named by a string, such as 'foot', not by {shown(name)}.")
    if not str(name).strip() or not str(name).isprintable():
        raise ModelError(f"{what} needs a name of printable characters, not {shown(name)}.")
    return str(name)


def listed(what: str, values: Any) -> list:
    """Several numbers as a list of one each."""
    if isinstance(values, str | dict | set):
        raise ModelError(f"{what} must be a sequence of numbers, not {shown(values)}.")
    try:
        found = copied(list(values))
    except TypeError:
        raise ModelError(f"{what} must be a sequence of numbers, not {shown(values)}.") from None
    for value in found:
        check_numbers(what, value, (), ModelError)
    return found


def number_in(component: Any) -> int | None:
    """Number of a coordinate or deformation, None where it is none."""
    if isinstance(component, str):
        return int(component) if component.isascii() and component.isdecimal() else None
    return as_whole(component)


def some_of(what: str, of: Any, given: tuple) -> tuple:
    """What is given, which must be something."""
    if not given:
        raise ModelError(f"{what.capitalize()} of '{of}': say of what; nothing is named.")
    return given


def released_in(name: str, wanted: Any, count: int) -> list[int]:
    """Numbers of the deformations that may change.

    Args:
        wanted: As given: "all" or numbers from 1.
    """
    if isinstance(wanted, str) and wanted == ALL:
        return list(range(1, count + 1))
    found = None if isinstance(wanted, str | bytes | dict) or not hasattr(wanted, "__iter__") else list(wanted)
    if found is None or any(as_whole(i) is None for i in found):
        raise ModelError(
            f"Argument `released` of element '{name}' must be \"all\" or numbers from 1, such as (2, 3); () for none."
            f" It is {shown(wanted)}."
        )
    for i in found:
        if not 1 <= i <= count:
            raise ModelError(f"Element '{name}' has deformations 1 to {count}, not {i}.")
    return [int(i) for i in found]
