"""Sets of designs: grid, Latin hypercube, Monte Carlo."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

import numpy as np

from ..arguments import WholeFromZero, check_whole, checked
from ..display import Result, Summary, span
from ..errors import printable

# Memory: 8 bytes for each number. At a thousand designs a second they take three hours.
MOST = 10_000_000
DesignCount = Annotated[int, partial(check_whole, least=1, most=MOST)]


class Designs(Result, dict[str, np.ndarray]):
    """Dimensions of many designs by name; the first axis of each array counts the designs.

    Attributes:
        axes: Values along each axis of a grid by name; the last axis varies fastest. Empty without a grid.
    """

    axes: dict[str, np.ndarray]

    def __init__(self, values: Mapping[str, Any], axes: Mapping[str, Any] | None = None):
        """Keep arrays of equal length.

        Args:
            values: Dimensions by name, (designs, ...).
            axes: Axes of a grid.

        Raises:
            ValueError: There are no designs, their numbers differ, or a value is no number.
        """
        super().__init__({name: float_array(f"Dimension '{name}'", v) for name, v in values.items()})
        self.axes = {name: float_array(f"Axis '{name}'", v) for name, v in (axes or {}).items()}
        for name, v in self.items():
            if v.ndim == 0 or len(v) == 0:
                raise ValueError(f"Dimension '{name}' has no designs. Give one value for each design.")
        lengths = {name: len(v) for name, v in self.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} {n}" for name, n in lengths.items())
            raise ValueError(f"Numbers of designs differ: {listed}. Give one value for each design.")
        if not lengths:
            raise ValueError("Give at least one dimension.")

    def summary(self) -> Summary:
        """Return the range of each dimension."""
        return Summary(f"Designs: {self.count}", {name: span(values) for name, values in self.items()})

    @property
    def count(self) -> int:
        """Number of designs."""
        return len(next(iter(self.values())))


def grid(axes: Mapping[str, Any] | None = None, /, **named: Any) -> Designs:
    """Return every combination of the values of the dimensions.

    Args:
        axes: Values of each dimension by name, (n,) [SI].
        named: The same as keywords.

    Returns:
        Designs; the last axis varies fastest.

    Raises:
        ValueError: An axis is empty or no list of numbers, or there are more than ten million combinations.

    Source:
        Cartesian product.
    """
    values = {
        name: np.atleast_1d(float_array(f"Axis '{name}' of a grid", v)) for name, v in _together(axes, named).items()
    }
    for name, v in values.items():
        if v.ndim != 1 or len(v) == 0:
            raise ValueError(f"Axis '{name}' of a grid must be a list of numbers, but has shape {v.shape}.")
    check_whole("count", math.prod(len(v) for v in values.values()), most=MOST)
    crossed = np.meshgrid(*values.values(), indexing="ij")
    return Designs({name: c.ravel() for name, c in zip(values, crossed, strict=True)}, values)


def checked_bounds(name: str, bounds: Any) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bound of a dimension, finite and in this order."""
    try:
        lower, upper = (float_array(f"Bounds of '{name}'", b) for b in bounds)
    except (TypeError, ValueError):
        text = printable(repr(bounds))
        raise ValueError(f"Bounds of '{name}' must be two numbers, lower and upper, but are {text}.") from None
    if not (np.all(np.isfinite(lower)) and np.all(np.isfinite(upper))):
        raise ValueError(f"Bounds of '{name}' must be finite, but are {lower} and {upper}.")
    if not np.all(lower < upper):
        raise ValueError(f"Bounds of '{name}' are empty: lower {lower} is not below upper {upper}.")
    return lower, upper


@checked
def latin_hypercube(
    count: DesignCount, bounds: Mapping[str, Any] | None = None, /, *, seed: WholeFromZero = 0, **named: Any
) -> Designs:
    """Return designs that cover the bounds evenly: each of ``count`` slices of every dimension contains one design.

    Args:
        count: Number of designs.
        bounds: Lower and upper value of each dimension by name [SI].
        seed: Seed of the random numbers.
        named: Bounds as keywords.

    Returns:
        Designs.

    Raises:
        ValueError: Bounds are empty or not finite, or there are more than ten million designs.

    Source:
        McKay, Beckman, Conover 1979, as ``scipy.stats.qmc.LatinHypercube``.
    """
    from scipy.stats import qmc

    checked_ = {name: checked_bounds(name, b) for name, b in _together(bounds, named).items()}
    for name, (lower, upper) in checked_.items():
        if lower.shape or upper.shape:
            raise ValueError(f"Bounds of '{name}' must be two numbers here. Draw each entry of an array by itself.")
    lower, upper = (np.array([b[i] for b in checked_.values()]) for i in range(2))
    unit = qmc.LatinHypercube(len(checked_), rng=np.random.default_rng(seed)).random(count)
    return Designs(dict(zip(checked_, (lower + unit * (upper - lower)).T, strict=True)))


@checked
def monte_carlo(count: DesignCount, distributions: Any = None, /, *, seed: WholeFromZero = 0, **named: Any) -> Designs:
    """Return random designs: independent dimensions, or the joint distribution of a Scatter.

    Args:
        count: Number of designs.
        distributions: By name: lower and upper value of a uniform distribution [SI], or an object with ``rvs``, such
            as ``scipy.stats.norm(0.5e-3, 5e-6)``. Or a Scatter from :func:`flexmb.scatter`.
        seed: Seed of the random numbers.
        named: Distributions as keywords; with a Scatter the nominal values of the dimensions [SI].

    Returns:
        Designs.

    Raises:
        ValueError: Bounds are empty or not finite. There are more than ten million designs. A parameter of the Scatter
            has no nominal value.

    Source:
        Monte Carlo: independent samples. A Scatter correlates the dimensions by a Gaussian copula.
    """
    if hasattr(distributions, "draw"):
        return distributions.draw(count, named, seed)
    rng, drawn = np.random.default_rng(seed), {}
    for name, distribution in _together(distributions, named).items():
        if hasattr(distribution, "rvs"):
            drawn[name] = distribution.rvs(size=count, random_state=rng)
        else:
            lower, upper = checked_bounds(name, distribution)
            drawn[name] = rng.uniform(lower, upper, (count, *lower.shape))
    return Designs(drawn)


def _together(table: Mapping[str, Any] | None, named: dict[str, Any]) -> dict[str, Any]:
    """Dimensions of a dictionary and of keywords, without repetition."""
    if table is not None and not isinstance(table, Mapping):
        raise TypeError(
            f"Dimensions are {printable(repr(table))}. Give a dictionary by name, or keywords, after the number of"
            " designs."
        )
    if twice := [name for name in named if name in (table or {})]:
        raise TypeError(f"Dimension '{twice[0]}' is in the dictionary and a keyword. Give it once.")
    return {**(table or {}), **named}


def float_array(what: str, value: Any) -> np.ndarray:
    """A number or an array of numbers in double precision."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        # Lists of different lengths.
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{what} must be numbers, but got {printable(repr(value))}.")
    return array.astype(float)
