"""Differences that scatter more where the answer is large: a common standard deviation does not describe them."""

from typing import Any

import numpy as np

from ..errors import warn
from ..numerical_limits import EXACT_FIT, FEWEST_OF_SCATTER, IMPLAUSIBLE, UNEVEN_SCATTER, UNTESTED
from .fitted import Fit
from .measurement import Measured
from .problem import weighted_slopes


def warn_of_uneven_scatter(fitted: Fit) -> None:
    """Warn of each measurement whose differences depend on the size of the answer."""
    rows, slopes, _ = fitted.problem.residuals(fitted.unit)
    basis, _ = np.linalg.qr(weighted_slopes(rows, slopes, fitted.problem.loss))
    # A value with a large effect on the fit differs less from the fitted model.
    remaining = 1 - np.sum(basis**2, axis=1)
    for item, part in zip(fitted.data, fitted.problem.parts, strict=True):
        if item.scatter is not None and item.scatter.ndim > 1:
            continue
        sizes = item.sizes(fitted.computed[item.name])
        ratio = ratio_of_scatter(rows[part], remaining[part], sizes)
        known = item.scatter is not None
        exact = not known and fitted.noise <= EXACT_FIT * (1.0 if item.relative else np.max(sizes))
        if ratio is not None and not exact:
            warn(_description(item, ratio, known))


def _description(item: Measured, ratio: float, known: bool) -> str:
    grows = ratio > 1
    subject = f"The differences of measurement '{item.name}' scatter {max(ratio, 1 / ratio):.2g} times as much where"
    subject += f" the answer is {'large as where it is small' if grows else 'small as where it is large'}"
    unit = "deviations" if known else "one common deviation"
    cause = f"{subject}, but the fit weighs them by {unit}. The intervals are {'too narrow' if grows else 'wrong'}."
    if item.relative:
        return f"{cause} Give deviations that describe the scatter, or omit logarithmic=True."
    by_logarithms = ", or logarithmic=True" if item.advice and not known else ""
    return (
        f"{cause} Give deviations that {'grow' if grows else 'fall'} with the answer"
        f"{f' (a relative deviation){by_logarithms}' if grows else ''}. Or the model is wrong there."
    )


def ratio_of_scatter(differences: np.ndarray, remaining: np.ndarray, sizes: np.ndarray) -> float | None:
    """Return the scatter at the largest quarter of the sizes over the scatter at the smallest quarter.

    Args:
        differences: Weighted differences, (m,).
        remaining: Share of the variance of each value that remains in its difference from a fitted model, (m,).
        sizes: Sizes of the answers, (m,).

    Returns:
        The ratio, or None if scatter of equal deviations explains it.

    Source:
        Rank correlation of absolute differences and sizes, which outliers hardly change: Spearman 1904.
    """
    from scipy.stats import spearmanr

    tested = remaining > UNTESTED
    differences, remaining, sizes = differences[tested], remaining[tested], sizes[tested]
    if len(sizes) < FEWEST_OF_SCATTER or np.ptp(sizes) == 0 or np.ptp(np.abs(differences)) == 0:
        return None
    test: Any = spearmanr(np.abs(differences) / np.sqrt(remaining), sizes)
    order, quarter = np.argsort(sizes, kind="stable"), len(sizes) // 4
    small, large = order[:quarter], order[-quarter:]
    scatter = [np.sqrt(np.sum(differences[at] ** 2) / np.sum(remaining[at])) for at in (large, small)]
    ratio = float(scatter[0] / max(scatter[1], np.finfo(float).tiny))
    if test.pvalue >= IMPLAUSIBLE or max(ratio, 1 / max(ratio, np.finfo(float).tiny)) <= UNEVEN_SCATTER:
        return None
    return ratio if (ratio > 1) == (test.statistic > 0) else None
