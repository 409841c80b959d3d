"""Combinations of parameters that the data do not determine, and products of powers that the data determine."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from ..numerical_limits import PART_IN_COMBINATION, UNDETERMINED_SHARE, ZERO_SLOPE
from .problem import FitProblem


@dataclasses.dataclass(frozen=True)
class Undetermined:
    """Parameters that may change together and hardly change the computed values.

    Attributes:
        names: Names of the k parameters.
        change: Change of each parameter, with the largest change equal to 1, (k,) [-]. Changes are relative to the
            parameter (logarithmic scale) or to the distance between its bounds (linear scale).
        determined: Determined products of powers of these parameters, in words; may be empty.
        deviation: Standard deviation along the change, as a share of the distance between the bounds [-]; infinite if
            the computed values do not change at all.
    """

    names: tuple[str, ...]
    change: np.ndarray
    determined: tuple[str, ...]
    deviation: float

    def __str__(self) -> str:
        if len(self.names) == 1:
            return f"'{self.names[0]}'"
        changes = ", ".join(f"{name} {100 * part:+.3g} %" for name, part in zip(self.names, self.change, strict=True))
        text = f"{' and '.join(self.names)} (together: {changes})"
        return text + (f", but {' and '.join(self.determined)}" if self.determined else "")


def directions(slopes: np.ndarray, noise: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return principal directions of weighted slopes: deviations, directions as columns, and which are undetermined."""
    n = slopes.shape[1]
    _, singular, rows = np.linalg.svd(slopes, full_matrices=True)
    singular = np.concatenate([singular, np.zeros(n - len(singular))])
    zero = singular <= ZERO_SLOPE * max(singular[0], np.finfo(float).tiny)
    with np.errstate(divide="ignore"):
        deviations = np.where(zero, np.inf, noise / np.where(zero, 1.0, singular))
    return deviations, rows.T, deviations > UNDETERMINED_SHARE


def combinations_of(
    problem: FitProblem, unit: np.ndarray, slopes: np.ndarray, noise: float
) -> tuple[Undetermined, ...]:
    """Return the combinations of parameters that the data do not determine."""
    deviations, columns, wide = directions(slopes, noise)
    scaling = problem.scaling
    relative = np.where(scaling.log, scaling.slopes(unit) / np.where(scaling.log, scaling.to_dimensions(unit), 1), 1.0)
    labels = problem.layout.labels
    return tuple(
        _combination(labels, columns[:, k] * relative, columns[:, k], scaling.log, float(deviations[k]))
        for k in np.flatnonzero(wide)
    )


def _combination(
    labels: Sequence[str], change: np.ndarray, column: np.ndarray, logarithmic: np.ndarray, deviation: float
) -> Undetermined:
    part = np.flatnonzero(np.abs(column) > PART_IN_COMBINATION)
    change = change[part] / change[part][np.argmax(np.abs(change[part]))]
    names = tuple(labels[int(i)] for i in part)
    determined: tuple[str, ...] = ()
    if len(part) > 1 and np.all(logarithmic[part]):
        # p_i p_0^e is constant for e = -change_i/change_0.
        first = int(np.argmax(np.abs(change)))
        determined = tuple(
            f"{names[i]} * {names[first]}^{-change[i] / change[first]:.3g} is determined"
            for i in range(len(names))
            if i != first
        )
    return Undetermined(names, change, determined, deviation)
