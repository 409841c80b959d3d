"""Sets of designs: grid, Latin hypercube, Monte Carlo."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arguments import check_whole
from ..display import Result, Summary, span
from ..errors import clean

# Designs are held in memory, 8 bytes for each number of each; a thousand a second take three hours.
MOST = 10_000_000


class Designs(Result, dict[str, np.ndarray]):
    """Dimensions by name, each with the designs along its first axis.

    Attributes:
        axes: Of a grid, the values along each axis by name, the last running fastest; otherwise empty.
    """

    axes: dict[str, np.ndarray]

    def __init__(self, values: Mapping[str, Any], axes: Mapping[str, Any] | None = None):
        """Keep arrays of equal length.

        Args:
            values: Dimensions by name, (designs, ...).
            axes: Of a grid.

        Raises:
            ValueError: There are no designs, their numbers differ, or something else than numbers is given.
        """
        super().__init__({name: numbers(f"Dimension '{name}'", v) for name, v in values.items()})
        self.axes = {name: numbers(f"Axis '{name}'", v) for name, v in (axes or {}).items()}
        for name, v in self.items():
            if v.ndim == 0 or len(v) == 0:
                raise ValueError(f"Dimension '{name}' has no designs: give one value for each.")
        lengths = {name: len(v) for name, v in self.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} {n}" for name, n in lengths.items())
            raise ValueError(f"All dimensions need one value for each design, but their numbers differ: {listed}.")
        if not lengths:
            raise ValueError("Give at least one dimension.")

    def summary(self) -> Summary:
        """Between which values each dimension varies."""
        return Summary(f"Designs: {self.count}", {name: span(values) for name, values in self.items()})

    @property
    def count(self) -> int:
        """Number of designs."""
        return len(next(iter(self.values())))


def grid(axes: Mapping[str, Any] | None = None, /, **named: Any) -> Designs:
    """Every combination of values of the dimensions.

    Args:
        axes: Values of each dimension by name, (n,) [SI].
        named: The same as keywords, for names that Python takes.

    Returns:
        Designs, the last axis running fastest.

    Raises:
        ValueError: An axis is empty or no list of numbers, or there are more than ten million combinations.

    Source:
        Cartesian product.
    """
    values = {name: np.atleast_1d(numbers(f"Axis '{name}' of a grid", v)) for name, v in _together(axes, named).items()}
    for name, v in values.items():
        if v.ndim != 1 or len(v) == 0:
            raise ValueError(f"Axis '{name}' of a grid must be a list of numbers, but has shape {v.shape}.")
    check_whole("count", math.prod(len(v) for v in values.values()), most=MOST)
    crossed = np.meshgrid(*values.values(), indexing="ij")
    return Designs({name: c.ravel() for name, c in zip(values, crossed, strict=True)}, values)


def checked_bounds(name: str, bounds: Any) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bound of a dimension.

    Raises:
        ValueError: Not two, not finite, or the lower one is not below the upper one.
    """
    try:
        lower, upper = (numbers(f"Bounds of '{name}'", b) for b in bounds)
    except (TypeError, ValueError):
        raise ValueError(
            f"Bounds of '{name}' must be two numbers, lower and upper, but are {clean(repr(bounds))}."
        ) from None
    if not (np.all(np.isfinite(lower)) and np.all(np.isfinite(upper))):
        raise ValueError(f"Bounds of '{name}' must be finite, but are {lower} and {upper}.")
    if not np.all(lower < upper):
        raise ValueError(f"Bounds of '{name}' are empty: lower {lower} is not below upper {upper}.")
    return lower, upper


def latin_hypercube(count: int, bounds: Mapping[str, Any] | None = None, /, *, seed: int = 0, **named: Any) -> Designs:
    """Designs that cover the bounds evenly: each of ``count`` slices of every dimension holds one.

    Args:
        count: Number of designs.
        bounds: Lower and upper value of each dimension by name [SI].
        seed: Of the random numbers.
        named: Bounds as keywords, for names that Python takes.

    Returns:
        Designs.

    Raises:
        ValueError: Bounds are empty or not finite, or there are more than ten million designs.

    Source:
        McKay, Beckman, Conover 1979, as ``scipy.stats.qmc.LatinHypercube``.
    """
    from scipy.stats import qmc

    checked = {name: checked_bounds(name, b) for name, b in _together(bounds, named).items()}
    for name, (lower, upper) in checked.items():
        if lower.shape or upper.shape:
            raise ValueError(f"Bounds of '{name}' must be two numbers here: an array is drawn entry by entry.")
    lower, upper = (np.array([b[i] for b in checked.values()]) for i in range(2))
    rng, count = np.random.default_rng(check_whole("seed", seed, 0)), check_whole("count", count, 1, MOST)
    unit = qmc.LatinHypercube(len(checked), rng=rng).random(count)
    return Designs(dict(zip(checked, (lower + unit * (upper - lower)).T, strict=True)))


def monte_carlo(
    count: int, distributions: Mapping[str, Any] | None = None, /, *, seed: int = 0, **named: Any
) -> Designs:
    """Random designs, every dimension by itself.

    Args:
        count: Number of designs.
        distributions: By name: lower and upper value for a uniform one [SI], or anything with ``rvs``, such as
            ``scipy.stats.norm(0.5e-3, 5e-6)``.
        seed: Of the random numbers.
        named: Distributions as keywords, for names that Python takes.

    Returns:
        Designs.

    Raises:
        ValueError: Bounds are empty or not finite, or there are more than ten million designs.

    Source:
        Independent samples.
    """
    rng, drawn = np.random.default_rng(check_whole("seed", seed, 0)), {}
    for name, given in _together(distributions, named).items():
        if hasattr(given, "rvs"):
            drawn[name] = given.rvs(size=check_whole("count", count, 1, MOST), random_state=rng)
        else:
            lower, upper = checked_bounds(name, given)
            drawn[name] = rng.uniform(lower, upper, (check_whole("count", count, 1, MOST), *lower.shape))
    return Designs(drawn)


def _together(given: Mapping[str, Any] | None, named: dict[str, Any]) -> dict[str, Any]:
    """Dimensions of a dictionary and of keywords, none twice."""
    if given is not None and not isinstance(given, Mapping):
        # How many designs of chance there are comes first.
        raise TypeError(
            f"Dimensions are given as a dictionary by name, or as keywords, not as {clean(repr(given))}; where a number"
            " of designs is, it goes before them."
        )
    twice = [name for name in named if name in (given or {})]
    if twice:
        raise TypeError(f"Dimension '{twice[0]}' is given twice: in the dictionary and as a keyword.")
    return {**(given or {}), **named}


def numbers(what: str, value: Any) -> np.ndarray:
    """A number or an array of numbers, double precision.

    Raises:
        ValueError: It is something else.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        # Lists of several lengths.
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{what} must be numbers, but got {clean(repr(value))}.")
    return array.astype(float)
