"""Modal data from measured frequency responses: poles by the AAA algorithm of SciPy, refined by least squares."""

import dataclasses
import warnings
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Complex, Float

from ..arguments import check_choice, check_whole
from ..compilation.threads import one_thread
from ..display import Result, Summary
from ..errors import AnalysisError, warn
from ..numerical_limits import LARGEST_RATIO_OF_MODE, SAME_POLE
from ..results import RESULTS
from .measurement import Measured
from .mode_pairing import measured_modes

QUANTITIES = ("position", "velocity", "acceleration")
# Numbers of terms of the rational functions that give candidates for poles; default largest number of modes.
TERMS = (6, 10, 16, 24, 34)
MOST_MODES = 12
# For each further mode: number of refined candidates, number of peaks of the differences, damping ratios at the peaks.
TRIED, PEAKS = 3, 4
RATIOS = np.array([0.002, 0.01, 0.05])
# Least damping ratio of the search.
LEAST_RATIO = 1e-8


@dataclasses.dataclass(frozen=True, repr=False)
class ModalData(Result):
    """Modes of a mechanism from its measured frequency responses.

    Attributes:
        hertz: Natural frequencies, modulus of the poles over 2 pi, ascending, (modes,) [Hz].
        hertz_deviation: Standard deviations of the frequencies, (modes,) [Hz].
        damping: Damping ratios, (modes,) [-].
        damping_deviation: Standard deviations of the damping ratios, (modes,) [-].
        residues: Residues of the poles with positive frequency, (outputs, modes) [unit of the response times rad/s].
        shapes: Real mode shapes at the outputs, with largest entry 1, (outputs, modes) [-].
        poles: Poles with positive frequency, (modes,) [rad/s].
        fitted: Response of these modes plus two terms for modes outside the band, (n_f, outputs) [unit of the
            response].
        noise: Root mean square of the differences in standard deviations, or relative to the response without
            ``deviation`` [-].
    """

    hertz: Float[np.ndarray, "modes"]
    hertz_deviation: Float[np.ndarray, "modes"]
    damping: Float[np.ndarray, "modes"]
    damping_deviation: Float[np.ndarray, "modes"]
    residues: Complex[np.ndarray, "outputs modes"]
    shapes: Float[np.ndarray, "outputs modes"]
    poles: Complex[np.ndarray, "modes"]
    fitted: Complex[np.ndarray, "n_f outputs"]
    noise: float

    def measured(self, *, at: Sequence[str] = (), name: str = "frequencies", **options: Any) -> Measured:
        """Return the frequencies as a measurement for :func:`flexmb.fit`.

        Args:
            at: Coordinates of the outputs, such as "tip.y", (outputs,). A fit then pairs the modes by their shapes.
            name: Name in tables and messages.
            options: Other arguments of :func:`flexmb.measured_modes`.
        """
        if len(at):
            options = {"shapes": self.shapes, "at": at, **options}
        return measured_modes(self.hertz, self.hertz_deviation, name=name, **options)

    def summary(self) -> Summary:
        """Return frequency and damping ratio of each mode, with their standard deviations."""
        rows = {
            f"mode {i + 1}": f"{f:.6g} ± {df:.2g} Hz, damping {z:.4g} ± {dz:.2g}"
            for i, (f, df, z, dz) in enumerate(
                zip(self.hertz, self.hertz_deviation, self.damping, self.damping_deviation, strict=True)
            )
        }
        return Summary(f"Modal data: {len(self.hertz)} modes from {self.residues.shape[0]} responses", rows)


@one_thread()
def modes_of_response(
    hertz: Any,
    responses: Any,
    deviation: Any = None,
    *,
    modes: int | None = None,
    quantity: Literal["position", "velocity", "acceleration"] = "position",
) -> ModalData:
    """Find poles and residues of measured frequency responses to a common input.

    Args:
        hertz: Frequencies, positive and ascending, (n_f,) [Hz].
        responses: Complex responses of one or several outputs, (n_f,) or (n_f, outputs).
        deviation: Standard deviation of real part and of imaginary part: a number, (n_f,), or the shape of
            ``responses`` [unit of the response]. Without it, all values have the same standard deviation relative to
            their magnitude. flexmb estimates it from the differences.
        modes: Number of modes. By default flexmb chooses it by the Bayesian information criterion, up to twelve.
        quantity: Quantity that the outputs measure.

    Returns:
        ModalData. Its method ``measured`` returns a measurement for :func:`flexmb.fit`.

    Raises:
        ValueError: Numbers of frequencies and responses differ. A value is zero or not finite. A response is real
            and positive at all frequencies. Frequencies are not positive and ascending. A deviation is not positive.
            There are too few values for the modes.
        AnalysisError: flexmb finds fewer modes than wanted (not_converged).

    Warns:
        FlexmbWarning: The root mean square of the differences exceeds 1.5 times the given deviations. The search for a
            mode ended at a bound, such as the largest damping ratio of 0.5.

    Source:
        Candidates: AAA, Nakatsukasa, Sete, Trefethen 2018 (SciPy). Number of modes by the Bayesian information
        criterion: Schwarz 1978. Refinement by variable projection: Golub, Pereyra 1973. H(s) is the sum of
        R/(s - p) + conj(R)/(s - conj(p)) over the modes, plus L/s^2 + U for modes below and above the band.
    """
    check_choice("quantity", quantity, QUANTITIES)
    places, values, spread = _checked(hertz, responses, deviation)
    if modes is not None:
        check_whole("modes", modes, 1)
    s = 2j * np.pi * places
    # Responses of positions have the form of H(s), without terms that grow with frequency.
    order = QUANTITIES.index(quantity)
    rows = _Rows(s, values / s[:, None] ** order, spread / np.abs(s[:, None]) ** order)
    most = (values.size * 2 - 1) // (2 * values.shape[1] + 2) - 1
    if (modes or 1) > most:
        raise ValueError(f"{values.size} values do not determine {modes or 1} modes: measure more frequencies.")
    chosen, bounded = _chosen(rows, _candidates(rows), modes, min(most, modes or MOST_MODES))
    if modes is None and len(chosen) == MOST_MODES < most:
        warn(f"The search ended at {MOST_MODES} modes. If there are more in the band, state their number by `modes`.")
    order_of_modes = np.argsort(np.abs(chosen))
    poles: Any = chosen[order_of_modes]
    jacobian = rows.slopes(poles)
    residual, coefficients = rows.solved(poles)
    freedom = max(len(residual) - 2 * len(poles) - coefficients.size, 1)
    noise = float(np.sqrt(np.sum(residual**2) / freedom))
    scale = 1.0 if deviation is not None else noise
    if deviation is not None and noise > TOO_FAR:
        warn(
            f"The modes do not explain the responses: differences are {noise:.3g} times the given deviations. Allow"
            " more modes, or cut the band."
        )
    covariance = np.linalg.inv(jacobian.T @ jacobian) * scale**2
    relative = np.sqrt(np.diag(covariance)).reshape(2, -1)
    frequencies, damping = np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles)
    for i in np.flatnonzero(bounded[order_of_modes]):
        if damping[i] < 2 * LEAST_RATIO:
            warn(f"The responses do not determine the damping of mode {i + 1}, at {frequencies[i]:.4g} Hz: it is tiny.")
            continue
        warn(
            f"The search for mode {i + 1} ended at a bound, at {frequencies[i]:.4g} Hz with a damping ratio of"
            f" {damping[i]:.4g}. Both and their deviations may be wrong. Ask for fewer `modes`, or cut the band."
        )
    residues = rows.residues(poles, coefficients) * poles**order
    return ModalData(
        frequencies,
        relative[0] * frequencies,
        damping,
        relative[1] * damping,
        residues,
        _real_shapes(residues),
        poles,
        rows.response(poles, coefficients) * s[:, None] ** order,
        noise,
    )


# Largest root mean square of differences, in deviations, of modes that explain the responses.
TOO_FAR = 1.5


def _checked(hertz: Any, responses: Any, deviation: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequencies, (n_f,), responses and their deviations, (n_f, outputs)."""
    places = np.atleast_1d(np.asarray(hertz, float))
    values: Any = np.asarray(responses, complex)
    values = values[:, None] if values.ndim == 1 else values
    if places.ndim != 1 or values.ndim != 2 or len(values) != len(places):
        raise ValueError(
            f"There are {places.size} frequencies, but responses of {np.shape(responses)}: one row for each."
        )
    bad = np.flatnonzero(~np.isfinite(places) | ~np.all(np.isfinite(values), axis=1) | np.any(values == 0, axis=1))
    if len(bad):
        raise ValueError(f"Row {bad[0] + 1} of {len(places)} has a value that is not finite or zero. Leave it out.")
    if not (np.all(np.diff(places) > 0) and places[0] > 0):
        raise ValueError("Frequencies must be positive and ascending.")
    if real := np.flatnonzero(~np.any(values.imag, axis=0) & np.all(values.real > 0, axis=0)).tolist():
        raise ValueError(
            f"Response {real[0] + 1} of {values.shape[1]} is real and positive at all frequencies, like a magnitude."
            " Give complex responses."
        )
    if deviation is None:
        return places, values, np.abs(values)
    spread = np.asarray(deviation, float)
    spread = spread[:, None] if spread.shape == (len(places),) else spread
    try:
        spread = np.broadcast_to(spread, values.shape)
    except ValueError:
        raise ValueError(f"Deviations have shape {spread.shape}, but responses {values.shape}.") from None
    if not np.all(np.isfinite(spread) & (spread > 0)):
        raise ValueError(f"A deviation is {np.min(spread):g}: deviations are finite and positive.")
    return places, values, spread


def _real(rows: Any) -> np.ndarray:
    """Return real parts, then imaginary parts, as one array."""
    return np.concatenate([rows.real, rows.imag])


class _Rows:
    """Weighted responses as real rows, linear in residues and in the two terms for modes outside the band."""

    def __init__(self, s: np.ndarray, values: np.ndarray, spread: np.ndarray):
        self.s, self.values, self.spread = s, values, spread
        self.low, self.high = np.abs(s[0]), np.abs(s[-1])

    def basis(self, poles: Any) -> np.ndarray:
        """Return the columns of the linear coefficients: real and imaginary parts of residues, then the two terms."""
        down, up = 1 / (self.s[:, None] - poles), 1 / (self.s[:, None] - poles.conj())
        size = np.abs(poles)
        beside = np.stack([(self.low / self.s) ** 2, np.ones(len(self.s))], axis=1)
        return np.concatenate([size * (down + up), 1j * size * (down - up), beside], axis=1)

    def solved(self, poles: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return differences in standard deviations, (rows,), and linear coefficients, (coefficients, outputs)."""
        rows, coefficients, _ = self._projected(poles, ())
        return rows, coefficients

    def slopes(self, poles: Any) -> np.ndarray:
        """Return derivatives of differences by logarithms of modulus and damping ratio of the poles, (rows, 2 modes).

        The linear coefficients depend on the poles (variable projection, approximation of Kaufman 1975).
        """
        size, ratio = np.abs(poles), -poles.real / np.abs(poles)
        by_ratio = ratio * size * (-1 - 1j * ratio / np.sqrt(1 - ratio**2))
        down, up = 1 / (self.s[:, None] - poles) ** 2, 1 / (self.s[:, None] - poles.conj()) ** 2
        changes = []
        for step in (poles, by_ratio):
            first, second = size * step * down, size * step.conj() * up
            changes.append((first + second, 1j * (first - second)))
        return self._projected(poles, changes)[2]

    def _projected(self, poles: Any, changes: Sequence[Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return differences, linear coefficients, and changes of the response orthogonal to the basis."""
        basis, count = self.basis(poles), len(poles)
        rows, coefficients, slopes = [], [], []
        for values, spread in zip(self.values.T, self.spread.T, strict=True):
            matrix, right = _real(basis / spread[:, None]), _real(values / spread)
            orthogonal, triangle = np.linalg.qr(matrix)
            solution = np.linalg.solve(triangle, orthogonal.T @ right)
            rows.append(matrix @ solution - right)
            coefficients.append(solution)
            parts = [
                _real((of_real * solution[:count] + of_imaginary * solution[count : 2 * count]) / spread[:, None])
                for of_real, of_imaginary in changes
            ]
            if parts:
                moved = np.concatenate(parts, axis=1)
                slopes.append(moved - orthogonal @ (orthogonal.T @ moved))
        return (
            np.concatenate(rows),
            np.stack(coefficients, axis=1),
            np.concatenate(slopes) if slopes else np.zeros((0, 0)),
        )

    def residues(self, poles: Any, coefficients: np.ndarray) -> np.ndarray:
        """Return residues of the poles with positive frequency, (outputs, modes)."""
        count = len(poles)
        return np.abs(poles) * (coefficients[:count] + 1j * coefficients[count : 2 * count]).T

    def response(self, poles: Any, coefficients: np.ndarray) -> np.ndarray:
        """Return the response, (n_f, outputs)."""
        return self.basis(poles) @ coefficients


def _candidates(rows: _Rows) -> np.ndarray:
    """Return different stable poles in the band, from rational functions of each response."""
    from scipy.interpolate import AAA

    stable: list[complex] = []
    points = np.concatenate([rows.s, -rows.s])
    for values in rows.values.T:
        for terms in TERMS:
            if terms > len(rows.s):
                break
            with warnings.catch_warnings():
                # AAA warns if the terms do not meet the tolerance, which is zero here.
                warnings.simplefilter("ignore", RuntimeWarning)
                poles = AAA(
                    points, np.concatenate([values, values.conj()]), max_terms=terms, rtol=0.0, clean_up=False
                ).poles()
            ratio = -poles.real / np.abs(poles)
            inside = (poles.imag > 0.9 * rows.low) & (poles.imag < 1.1 * rows.high)
            stable += poles[inside & (ratio > 0) & (ratio < LARGEST_RATIO_OF_MODE)].tolist()
    different: list[complex] = []
    for pole in sorted(stable, key=abs):
        if not any(abs(pole - other) < SAME_POLE * abs(pole) for other in different):
            different.append(pole)
    return np.array(different)


def _chosen(
    rows: _Rows, candidates: np.ndarray, count: int | None, most: int
) -> tuple[np.ndarray, Bool[np.ndarray, "modes"]]:
    """Add poles one after the other: each time the pole that reduces the differences most; as :func:`_refined`."""
    chosen, bounded, score = np.zeros(0, complex), np.zeros(0, bool), np.inf
    values = 2 * rows.values.size
    while len(chosen) < most:
        trials = np.concatenate([candidates, _at_differences(rows, chosen)])
        distinct = [p for p in trials if not np.any(np.abs(chosen - p) < SAME_POLE * abs(p))]
        costs = [float(np.sum(rows.solved(np.append(chosen, pole))[0] ** 2)) for pole in distinct]
        refined = []
        for i in np.argsort(costs)[:TRIED]:
            more, at_bound = _refined(rows, np.append(chosen, distinct[int(i)]))
            refined.append((float(np.sum(rows.solved(more)[0] ** 2)), more, at_bound))
        if not refined:
            break
        cost, more, at_bound = min(refined, key=lambda candidate: candidate[0])
        numbers = len(more) * (2 + 2 * rows.values.shape[1])
        new = values * np.log(max(cost, np.finfo(float).tiny)) + numbers * np.log(values)
        if count is None and (new >= score or not _are_modes(rows, more, cost)):
            break
        chosen, bounded, score = more, at_bound, new
    if len(chosen) < (count or 1):
        raise AnalysisError(
            RESULTS.not_converged.name,
            f"Of {count or 1} modes {len(chosen)} were found in the responses. Ask for fewer, or measure more points.",
        )
    return chosen, bounded


def _are_modes(rows: _Rows, poles: Any, cost: float) -> bool:
    """Return whether every damping ratio is below the limit and above its standard deviation."""
    jacobian = rows.slopes(poles)
    freedom = max(len(jacobian) - jacobian.shape[1], 1)
    try:
        variances = np.diag(np.linalg.inv(jacobian.T @ jacobian)) * cost / freedom
    except np.linalg.LinAlgError:
        return False
    ratio = -poles.real / np.abs(poles)
    return bool(np.all(ratio < 0.99 * LARGEST_RATIO_OF_MODE) and np.all(variances[len(poles) :] < 1))


def _at_differences(rows: _Rows, poles: Any) -> np.ndarray:
    """Return poles at the largest differences, with several damping ratios."""
    count = len(rows.s)
    differences = rows.solved(poles)[0].reshape(rows.values.shape[1], 2, count)
    power = np.sum(differences**2, axis=(0, 1))
    inner = (power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])
    peaks = 1 + np.flatnonzero(inner)
    largest = peaks[np.argsort(-power[peaks])[:PEAKS]]
    size = np.abs(rows.s[largest])[:, None]
    return (size * (-RATIOS + 1j * np.sqrt(1 - RATIOS**2))).ravel()


def _refined(rows: _Rows, poles: Any) -> tuple[np.ndarray, Bool[np.ndarray, "modes"]]:
    """Return the poles with the least squares of differences near given poles, and whether each is at a bound."""
    from scipy.optimize import least_squares

    def poles_of(numbers: np.ndarray) -> np.ndarray:
        size, ratio = np.exp(numbers.reshape(2, -1))
        return size * (-ratio + 1j * np.sqrt(1 - ratio**2))

    first = np.log(
        np.concatenate([np.abs(poles), np.clip(-poles.real / np.abs(poles), 1e-6, 0.9 * LARGEST_RATIO_OF_MODE)])
    )
    count = len(poles)
    lower = np.concatenate([first[:count] - 0.3, np.full(count, np.log(LEAST_RATIO))])
    upper = np.concatenate([first[:count] + 0.3, np.full(count, np.log(LARGEST_RATIO_OF_MODE))])
    solution = least_squares(
        lambda numbers: rows.solved(poles_of(numbers))[0],
        first,
        jac=lambda numbers: rows.slopes(poles_of(numbers)),  # pyright: ignore[reportArgumentType]
        bounds=(lower, upper),
        x_scale="jac",
    )
    # Within 1 % of a bound: the search approaches it from inside.
    at_bound = np.minimum(solution.x - lower, upper - solution.x) < 0.01
    return poles_of(solution.x), np.any(at_bound.reshape(2, -1), axis=0)


def _real_shapes(residues: np.ndarray) -> np.ndarray:
    """Return real shapes with largest entry 1, after the rotation with the least imaginary parts."""
    turned = residues * np.exp(-0.5j * np.angle(np.sum(residues**2, axis=0)))
    real = turned.real
    largest = real[np.argmax(np.abs(real), axis=0), np.arange(real.shape[1])]
    return real / largest
