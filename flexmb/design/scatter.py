"""Scatter of parameters: distributions of made mechanisms about nominal values, with correlation."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..arguments import short_repr
from ..display import Result, Summary, short
from ..errors import printable
from .designs import Designs, float_array
from .evaluate import Layout, layout_of

KINDS = ("normal", "lognormal", "uniform", "triangular")
# Largest probability whose quantile is finite: the largest number below 1.
LARGEST_SHARE = 1 - 2.0**-53
# Share of an object's deviations beyond each end, and distance of the ends from zero over their own.
REMOTE, BESIDE = 1e-9, 1e-3
# Range and number of standard normal scores for the quadrature of moments; number of terms of Mehler's series.
SCORES, POINTS, TERMS = 8.5, 20_001, 40


@dataclasses.dataclass(frozen=True)
class Spread:
    """Distribution of one parameter about its nominal value.

    Attributes:
        kind: One of KINDS, or "own" for an object with ``ppf``.
        sizes: One or two numbers of the distribution; none if ``kind`` is "own".
        own: Distribution of the deviations from the nominal value, an object with ``ppf``; otherwise None.
    """

    kind: str
    sizes: tuple[float, ...] = ()
    own: Any = None

    @property
    def relative(self) -> bool:
        """Whether deviations are relative to the nominal value; otherwise they are absolute."""
        return self.kind == "lognormal"

    def of_scores(self, scores: np.ndarray) -> np.ndarray:
        """Return deviations [SI], or relative deviations [-], at standard normal scores."""
        from scipy.special import ndtr

        if self.kind == "normal":
            return self.sizes[0] * scores
        if self.kind == "lognormal":
            return np.expm1(self.sizes[0] * scores)
        below, share = ndtr(scores), ndtr(-scores)
        if self.kind == "own":
            return np.asarray(self.own.ppf(np.clip(below, 1e-300, LARGEST_SHARE)), float)
        lower, upper = self.sizes
        width = upper - lower
        if self.kind == "uniform":
            return lower + width * below
        # The density of the triangle is largest at the nominal value, deviation 0.
        rising = lower + np.sqrt(below * width * -lower)
        falling = upper - np.sqrt(share * width * upper)
        return np.where(below * width < -lower, rising, falling)


@dataclasses.dataclass(frozen=True, repr=False)
class Scatter(Result):
    """Joint distribution of parameters about their nominal values, from :func:`scatter`.

    Attributes:
        spreads: Distribution by name of the parameter. All entries of an array have the same distribution.
        correlation: Correlation of the normal scores of two parameters, by their names [-].
        nominal: Nominal values of parameters that are no dimensions of the design, by name [SI].
    """

    spreads: dict[str, Spread]
    correlation: dict[tuple[str, str], float]
    nominal: dict[str, np.ndarray]

    def summary(self) -> Summary:
        """Return the distribution of each parameter, and the correlations."""
        rows = {}
        for name, spread in self.spreads.items():
            about = f" about {short(float(self.nominal[name]))}" if np.ndim(self.nominal.get(name, [0])) == 0 else ""
            sizes = (
                " to ".join(short(size) for size in spread.sizes) if spread.own is None else type(spread.own).__name__
            )
            rows[name] = f"{spread.kind} {sizes}{about}"
        rows |= {f"correlation of {a} and {b}": f"{value:g}" for (a, b), value in self.correlation.items()}
        return Summary(f"Scatter of {len(self.spreads)} parameters", rows)

    def draw(self, count: int, dimensions: Mapping[str, Any], seed: int = 0) -> Designs:
        """Return random designs about nominal dimensions.

        Args:
            count: Number of designs.
            dimensions: Nominal values by name [SI]. Parameters in ``nominal`` may be omitted.
            seed: Seed of the random numbers.

        Returns:
            Designs with all dimensions and all parameters that scatter.

        Raises:
            ValueError: A parameter has no nominal value, or the correlations contradict each other.
        """
        values = nominal_values(self, dimensions)
        layout = layout_of(values)
        scores = np.random.default_rng(seed).standard_normal((count, sum(layout.sizes)))
        added, factor = terms_and_factors(self, scores, layout)
        return Designs(layout.stacked(layout.join(values) * factor + added))


def nominal_values(scatter: Scatter, dimensions: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return nominal values of dimensions and of other parameters with scatter; ValueError for a missing value."""
    values = {name: float_array(f"Dimension '{name}'", value) for name, value in dimensions.items()}
    refuse_two_values(scatter, values)
    values |= {name: value for name, value in scatter.nominal.items() if name not in values}
    for name in scatter.spreads:
        if name not in values:
            raise ValueError(f"Scatter of '{printable(name)}' has no nominal value: give it in `nominal`.")
    return values


def refuse_two_values(scatter: Scatter, dimensions: Mapping[str, Any]) -> None:
    """Raise ValueError for a dimension with another nominal value in the scatter."""
    for name, value in scatter.nominal.items():
        if name in dimensions and not np.array_equal(value, dimensions[name]):
            raise ValueError(
                f"'{printable(name)}' has two nominal values: {short_repr(dimensions[name])} as a dimension, and"
                f" {short_repr(value)} in `nominal` of the scatter. Leave it out of `nominal`."
            )


def even_scores(count: int, layout: Layout, seed: int) -> Float[np.ndarray, "count n"]:
    """Return independent standard normal scores, stratified by a Latin hypercube."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    cube = qmc.LatinHypercube(sum(layout.sizes), rng=np.random.default_rng(seed)).random(count)
    return ndtri(np.clip(cube, 1e-16, 1 - 1e-16))


def terms_and_factors(scatter: Scatter, scores: np.ndarray, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return terms [SI] and factors [-], both (count, n): a parameter is its nominal value times factor plus term.

    The scores, (count, n), are independent. The copula correlates them.
    """
    correlated = scores @ correlation_root(scatter, layout).T
    added, factor = np.zeros(scores.shape), np.ones(scores.shape)
    for i, spread in enumerate(by_label(scatter, layout)):
        if spread is not None:
            deviation = spread.of_scores(correlated[:, i])
            (factor if spread.relative else added)[:, i] += deviation
    return added, factor


def by_label(scatter: Scatter, layout: Layout) -> list[Spread | None]:
    """Return the distribution of each entry of the parameters; None for an entry without scatter."""
    spreads: list[Spread | None] = []
    for name, size in zip(layout.names, layout.sizes, strict=True):
        spreads += [scatter.spreads.get(name)] * size
    return spreads


def correlation_root(scatter: Scatter, layout: Layout) -> Float[np.ndarray, "n n"]:
    """Return the lower triangular factor of the correlation matrix of the normal scores."""
    labels, spreads = layout.labels, by_label(scatter, layout)
    matrix = np.eye(len(labels))
    for pair, value in scatter.correlation.items():
        for name in pair:
            if name not in labels:
                entries = " Name an entry, such as 'height[0]'." if name in layout.names else ""
                raise ValueError(f"Correlation of '{printable(name)}': there is no such parameter.{entries}")
            if spreads[labels.index(name)] is None:
                raise ValueError(f"Correlation of '{printable(name)}': it has no scatter.")
        i, j = map(labels.index, pair)
        matrix[i, j] = matrix[j, i] = value
    try:
        return np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise ValueError(
            "The correlations contradict each other: their matrix is not positive definite. Pairs that you do not name"
            " have the correlation 0."
        ) from None


def moments(scatter: Scatter, values: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return mean deviations from the nominal values, (n,), and their covariance, (n, n) [SI].

    Source:
        Mehler's series: E[He_k(x) He_l(y)] = delta_kl k! r^k for normal x, y of correlation r.
    """
    layout = layout_of(values)
    point = layout.join(values)
    scores = np.linspace(-SCORES, SCORES, POINTS)
    weight = np.exp(-(scores**2) / 2)
    weight /= np.sum(weight)
    # Orthonormal Hermite polynomials by their recurrence.
    basis = np.empty((TERMS, POINTS))
    basis[0], basis[1] = 1.0, scores
    for k in range(1, TERMS - 1):
        basis[k + 1] = (scores * basis[k] - np.sqrt(k) * basis[k - 1]) / np.sqrt(k + 1)
    n = len(point)
    series, variances = np.zeros((n, TERMS)), np.zeros(n)
    for i, spread in enumerate(by_label(scatter, layout)):
        if spread is not None:
            deviation = spread.of_scores(scores) * (point[i] if spread.relative else 1.0)
            series[i] = basis @ (weight * deviation)
            variances[i] = weight @ deviation**2 - series[i, 0] ** 2
    root = correlation_root(scatter, layout)
    correlation = root @ root.T
    powers = correlation[:, :, None] ** np.arange(1, TERMS)
    covariance = np.einsum("ik,jk,ijk->ij", series[:, 1:], series[:, 1:], powers)
    np.fill_diagonal(covariance, variances)
    return series[:, 0], covariance


def scatter(
    distributions: Mapping[str, Any],
    *,
    correlation: Mapping[tuple[str, str], float] | None = None,
    nominal: Mapping[str, Any] | None = None,
) -> Scatter:
    """Describe the scatter of the parameters of made mechanisms about their nominal values.

    Args:
        distributions: Distribution by name of a dimension or of another argument of ``build``:

            - a number, the standard deviation of a normal distribution [SI];
            - ``("normal", deviation)``, the same;
            - ``("lognormal", deviation)``: the nominal value is the median, ``deviation`` is the standard deviation of
              the natural logarithm [-];
            - ``("uniform", width)``: deviations between -width and +width [SI];
            - ``("uniform", lower, upper)``: deviations between lower (at most 0) and upper (at least 0) [SI];
            - ``("triangular", width)`` and ``("triangular", lower, upper)``: the same ranges [SI], with the largest
              density at the nominal value;
            - an object with ``ppf``, such as a distribution of ``scipy.stats``: distribution of the deviations.
        correlation: Correlation of the normal scores of two parameters (Gaussian copula), between -1 and 1, by pair of
            names: ``{("left", "right"): 0.9}``. For two normal distributions it equals the correlation of the
            parameters.
        nominal: Nominal values of parameters with scatter that are no dimensions of the design, by name [SI]. An
            example is a modulus.

    Returns:
        Scatter for ``fm.design.monte_carlo``, ``fm.design.tolerances``, ``fm.design.robustness`` and ``fm.tune``. The
        entries of an array are independent. To correlate two entries, name them in ``correlation`` ("height[0]").

    Raises:
        ValueError: A distribution is unknown. A deviation is not positive. Bounds do not enclose zero. A correlation
            is not between -1 and 1, names one parameter twice, or names a parameter without scatter.

    Source:
        Gaussian copula: Nelsen 2006. x = F^-1(Phi(z)), with correlated standard normal scores z.
    """
    if not isinstance(distributions, Mapping) or not distributions:
        raise ValueError("Give a dictionary of distributions by name of the parameter, at least one.")
    spreads = {str(name): _spread(printable(name), distribution) for name, distribution in distributions.items()}
    pairs: dict[tuple[str, str], float] = {}
    for pair, value in (correlation or {}).items():
        subject = f"Correlation of {printable(repr(pair))}"
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1]:
            raise ValueError(f"{subject}: name two different parameters, such as ('left', 'right').")
        for name in pair:
            if str(name).partition("[")[0] not in spreads:
                raise ValueError(f"{subject}: '{printable(name)}' has no scatter.")
        number = float_array(subject, value)
        if number.shape or not -1 < number < 1:
            raise ValueError(f"{subject} is {value}. It must be a number between -1 and 1.")
        if pair in pairs or pair[::-1] in pairs:
            raise ValueError(f"{subject} is given twice.")
        pairs[pair] = float(number)
    values = {
        name: float_array(f"Nominal value of '{printable(name)}'", value) for name, value in (nominal or {}).items()
    }
    for name in values:
        if name not in spreads:
            raise ValueError(f"Nominal value of '{printable(name)}': it has no scatter. Set it inside `build`.")
    return Scatter(spreads, pairs, values)


def _spread(name: str, distribution: Any) -> Spread:
    if hasattr(distribution, "ppf"):
        lower, upper = np.asarray(distribution.ppf(np.array([REMOTE, 1 - REMOTE])), float)
        least = BESIDE * (upper - lower)
        if not -np.inf < lower <= upper < np.inf or lower > least or upper < -least:
            raise ValueError(
                f"Scatter of '{name}': deviations of the object lie from {lower:g} to {upper:g} and must enclose zero."
                " They are added to the nominal value."
            )
        return Spread("own", (), distribution)
    kind, *sizes = (
        ("normal", distribution)
        if not isinstance(distribution, Sequence) or isinstance(distribution, str)
        else distribution
    )
    if kind not in KINDS:
        raise ValueError(
            f"Scatter of '{name}' must be a standard deviation, an object with ppf, or a tuple that begins with"
            f" {', '.join(KINDS[:-1])} or {KINDS[-1]}, not {printable(repr(distribution))}."
        )
    deviations = float_array(f"Scatter of '{name}'", list(sizes)).ravel().tolist()
    two = kind in ("uniform", "triangular")
    if len(deviations) not in ((1, 2) if two else (1,)) or not np.all(np.isfinite(deviations)):
        raise ValueError(f"Scatter of '{name}': {kind} takes {'one or two numbers' if two else 'one number'}.")
    if two and len(deviations) == 2:
        lower, upper = deviations
        if not lower <= 0 <= upper or lower == upper:
            raise ValueError(f"Scatter of '{name}': deviations from {lower:g} to {upper:g} must enclose zero.")
        return Spread(kind, (lower, upper))
    if not deviations[0] > 0:
        raise ValueError(f"Scatter of '{name}' is {deviations[0]:g}. It must be positive.")
    return Spread(kind, (-deviations[0], deviations[0]) if two else (deviations[0],))
