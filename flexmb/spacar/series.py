"""Deformation numbers of spectral beams in SPACAR input files.

A file numbers a spectral beam like a beam: numbers up to 3 in the plane and 6 in space mean whole strain fields (1
elongation, 2 torsion, 3 or 4 and 5 or 6 the two bendings; in the plane 1, and 2 or 3). The closure, which has these
numbers in ``e``, is always FIXED. Further numbers mean single coefficients. In a leaf spring in space 7 and 8 are the
warping of its ends, which a file does not mention.
"""

import math

from ..elements.element import Element
from .lines import is_zero, known

FIELDS = {
    2: ("elongation", "bending"),
    3: ("elongation", "torsion", "bending about y", "bending about z", "shear along y", "shear along z"),
}
# Fields of each number of the beam: a beam that bends along z also shears along z.
_PARTS: dict[int, tuple[tuple[int, ...], ...]] = {
    2: ((0,), (1,), (1,)),
    3: ((0,), (1,), (2, 5), (2, 5), (3, 4), (3, 4)),
}
# Fields of the bendings, number of the beam's bending at end p, and sign of its bending relative to the curvature.
_BENDINGS = {2: ((1, 2, -1.0),), 3: ((2, 3, 1.0), (3, 5, 1.0))}


def closure(element: Element) -> int:
    """Number of deformations that close a spectral beam; zero for other elements."""
    return len(element.closure)


def warping(element: Element) -> tuple[int, ...]:
    """Deformations for the warping of the ends of a leaf spring in space; none for other elements."""
    return element.measured if element.fields else ()


def _dimension(element: Element) -> int:
    return next(iter(element.nodes.values())).dimension


def deformations_meant(element: Element, number: int) -> tuple[int, ...]:
    """Deformations of a number in a file."""
    if number > closure(element):
        return (number,)
    parts = _PARTS[_dimension(element)][number - 1]
    return tuple(n for k in parts if k < len(element.fields) for n in element.fields[k])


def shortened(element: Element, numbers: list[int]) -> list[int]:
    """Numbers in a file for some deformations in their order, with whole fields under the beam's numbers."""
    short, remaining = [], list(numbers)
    fields = {n: deformations_meant(element, n) for n in range(1, closure(element) + 1)}
    while remaining:
        number = next((n for n, meant in fields.items() if tuple(remaining[: len(meant)]) == meant), remaining[0])
        short.append(number)
        del remaining[: len(deformations_meant(element, number))]
    return short


def in_whole_fields(element: Element, numbers: list[int]) -> list[int]:
    """Deformations in an order in which :func:`shortened` finds the whole fields."""
    order = [n for k in range(1, closure(element) + 1) for n in deformations_meant(element, k)]
    return sorted(numbers, key=lambda n: order.index(n) if n in order else 0)


def resultants(element: Element, length: float, values: list[float]) -> dict[int, float]:
    """Stress resultants of the coefficients that do the same work as values of ESIG, by number.

    To first order the beam's deformations are integrals of the strains: e1 of the elongation, e2 of the twist times the
    length, bendings of the curvature times the length times the distance from the other end.
    """
    return _spread(element, values, (length, length / 2, length / 6))


def strain_coefficients(element: Element, length: float, values: list[float]) -> dict[int, float]:
    """Coefficients of the strains of a beam with deformations of EINIT, by number.

    Inverse of the integrals of :func:`resultants` for a curvature that is linear along the beam.
    """
    return _spread(element, values, (1 / length, 1 / length, 3 / length))


def _spread(element: Element, values: list[float], factors: tuple[float, float, float]) -> dict[int, float]:
    twist, mean, slope = factors
    by_number = dict(enumerate(values, 1))
    spread_values = {n: v for n, v in by_number.items() if n > closure(element)}

    def add(number: int, value: float):
        spread_values[number] = spread_values.get(number, 0.0) + value

    fields, dimension = element.fields, _dimension(element)
    add(fields[0][0], by_number.get(1, 0.0))
    if dimension == 3:
        add(fields[1][0], twist * by_number.get(2, 0.0))
    for k, at_p, sign in _BENDINGS[dimension]:
        p, q = by_number.get(at_p, 0.0), by_number.get(at_p + 1, 0.0)
        add(fields[k][0], sign * mean * (p + q))
        if len(fields[k]) > 1:
            add(fields[k][1], sign * slope * (q - p))
        elif known(p - q) and not math.isclose(p, q):
            raise ValueError(f"values {at_p} and {at_p + 1} differ: bending that varies needs p of at least 2")
    return {n: v for n, v in spread_values.items() if not is_zero(v)}


def meaning_of_deformations(element: Element) -> str:
    """Meaning of the deformations, for the log."""
    names = FIELDS[_dimension(element)]
    parts = [f"{name} {indices[0]} to {indices[-1]}" for name, indices in zip(names, element.fields, strict=False)]
    ends = [f"warping {' and '.join(map(str, indices))}"] if (indices := warping(element)) else []
    return ", ".join([f"closure 1 to {closure(element)}", *ends, *parts])
