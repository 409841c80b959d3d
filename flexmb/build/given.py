"""Checks of arguments of the Builder: names, sequences of numbers, numbers of components."""

from typing import Any

from ..arguments import as_whole, check_numbers, copied, short_repr
from ..elements.element import ALL, Element
from ..elements.element_text import deformations_of
from ..errors import ModelError


def name_text(what: str, name: Any) -> str:
    """A name as text; a whole number is a name too."""
    if not isinstance(name, str) and as_whole(name) is None:
        raise ModelError(f"{what} is named by a string, such as 'foot', not by {short_repr(name)}.")
    if not str(name).strip() or not str(name).isprintable():
        raise ModelError(f"{what} needs a name of printable characters, not {short_repr(name)}.")
    return str(name)


def number_list(what: str, values: Any) -> list:
    """Several numbers as a list."""
    if isinstance(values, str | dict | set):
        raise ModelError(f"{what} must be a sequence of numbers, not {short_repr(values)}.")
    try:
        numbers = copied(list(values))
    except TypeError:
        raise ModelError(f"{what} must be a sequence of numbers, not {short_repr(values)}.") from None
    for value in numbers:
        check_numbers(what, value, (), ModelError)
    return numbers


def number_in(component: Any) -> int | None:
    """Number of a coordinate; None for anything else."""
    if isinstance(component, str):
        return int(component) if component.isascii() and component.isdecimal() else None
    return as_whole(component)


def nonempty_arguments(what: str, of: Any, given: tuple) -> tuple:
    """Arguments of which there must be at least one."""
    if not given:
        raise ModelError(f"{what.capitalize()} of '{of}' is empty. Name components or deformations.")
    return given


def number_in_element(name: str, element: Element, count: int, deformation: Any) -> int:
    """Number of a deformation. Raises ModelError: The element has no such deformation."""
    number = element.number_of(deformation)
    if number is None or not 1 <= number <= count:
        description = f"has deformations 1 to {count}" if count else "has no deformations"
        named = f": {names}" if (names := deformations_of(element)) else ""
        raise ModelError(f"Element '{name}' {description}, not {short_repr(deformation)}{named}.")
    return number


def check_closure(name: str, element: Element, number: int, deformation: Any) -> None:
    """Raise ModelError for a deformation of the closure that is given by its number."""
    if element.names and number in element.closure and deformation not in element.numbered:
        own = element.deformation_names[number]
        raise ModelError(
            f"Element '{name}' ({element.name}): deformation {number} ({own}) is part of its closure, which joins it to"
            f" its node. Its strains are {deformations_of(element, *element.closure)}. To free the closure itself, give"
            f' its name "{own}".'
        )


def numbers_freed(name: str, element: Element, count: int, deformation: Any) -> tuple[int, ...]:
    """Numbers of deformations that a number or a name frees; the name of a strain field frees all its coefficients.

    Raises ModelError: No such deformation, or a number that is part of the closure.
    """
    if isinstance(deformation, str) and deformation in element.numbered:
        return element.numbered[deformation]
    number = number_in_element(name, element, count, deformation)
    check_closure(name, element, number, deformation)
    return (number,)


def released_in(name: str, wanted: Any, element: Element, count: int) -> list[int]:
    """Numbers of the deformations that may change, checked. Raises ModelError."""
    if isinstance(wanted, str) and wanted == ALL:
        return [n for n in range(1, count + 1) if n not in element.closure]
    entries = [wanted] if isinstance(wanted, str) and wanted in element.numbered else wanted
    entries = None if isinstance(entries, str | bytes | dict) or not hasattr(entries, "__iter__") else list(entries)
    if entries is None or any(as_whole(entry) is None and not isinstance(entry, str) for entry in entries):
        usual = next((name for name, n in element.numbered.items() if n[0] not in element.closure), "")
        names = f', or names, such as "{usual}"' if usual else ""
        raise ModelError(
            f"Argument `released` of element '{name}' must be \"all\" or numbers from 1, such as (2, 3){names}; () for"
            f" none. It is {short_repr(wanted)}."
        )
    return [n for entry in entries for n in numbers_freed(name, element, count, entry)]
