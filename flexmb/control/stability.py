"""Closed loop of the linearised mechanism and a linear controller: poles, stability and margins, by python-control."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import is_concrete
from ..display import Result, Summary, counted, listed, short
from ..errors import ModelError, warn
from ..linear.linearize import Linearization
from ..model.model import Model
from ..motion.controllers import check_finite, check_sizes, matrices_of, signal_places
from ..numerical_limits import (
    BLUR_OF_POLE,
    FARTHEST_ZERO,
    JUMP_OF_PHASE,
    LEVEL_AT_REST,
    NARROWEST_RESONANCE,
    NEARLY_CROSSING,
    NEGLIGIBLE,
    POLE_AT_ORIGIN,
    ROUND_OFF,
    TWIN_FREQUENCIES,
)
from .state_space import to_statespace

if TYPE_CHECKING:
    import control

# Uncertainty of a pole over precision, norm of the matrix and its own condition; undamped poles are off the axis by
# less than once this.
UNSURE = 10
# Number of frequencies of the open loop in all, or per decade. They range from a hundredth of the slowest pole or zero,
# also of the closed loop, to ten times the fastest. More frequencies lie beside each pole and zero at these half
# widths, but none at an undamped pole or zero, which has no response.
POINTS, A_DECADE = 1200, 150
BESIDE = np.linspace(-8.0, 8.0, 32)
# Number of smallest dips that are searched, number of searches, and shares of the interval in each.
DIPS = 64
NARROWED, SHARES = 12, np.linspace(0.0, 1.0, 11)
# Bisections after which nothing is left between two frequencies.
HALVINGS = 50
# Frequencies computed together.
ROW = 4096


@dataclasses.dataclass(frozen=True)
class Margins:
    """Distance of a loop from instability; the loop is opened at one input of the mechanism, all others stay closed.

    Attributes:
        input: Input at which the loop is opened.
        gain: Factor on the gain that makes the loop unstable; of several, the one nearest to 1, above or below [-].
        gain_hertz: Frequency of this instability [Hz]; infinite for a direct feedthrough.
        phase: Phase that the loop may lose at the crossover, negative if it may gain this phase [degrees].
        crossover: Frequency at which the gain of the open loop is one [Hz].
        modulus: Smallest distance of the open loop from -1 [-].
        modulus_hertz: Frequency of this smallest distance [Hz].
    """

    input: str
    gain: float
    gain_hertz: float
    phase: float
    crossover: float
    modulus: float
    modulus_hertz: float


@dataclasses.dataclass(frozen=True, repr=False)
class ClosedLoop(Result):
    """A closed loop of linear systems.

    Attributes:
        system: From the reference of every output to the outputs, ``control.StateSpace`` with the names of the model;
            sampled if the controller is.
        opened: Open loop, from the controller's error to the mechanism's outputs.
        poles: Poles, the slowest to decay first, (n,) [rad/s]. For a sampled loop: poles of a continuous loop with the
            same values at the samples. Stability and margins follow from these poles. They leave out states "moved by"
            an input that the controller does not drive, such as the place and speed of a floor: ``system`` has their
            poles at zero too.
        margins: Margins for each input that the controller drives.
        uncertainty: Round-off of each pole, (n,) [rad/s], at most 1e-9 of the fastest pole. The round-off of coinciding
            poles may be larger.
    """

    system: control.StateSpace
    opened: control.StateSpace
    poles: np.ndarray
    margins: tuple[Margins, ...]
    uncertainty: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether all motions decay, beyond round-off; the given motion of a floor is none of them."""
        return bool(np.all(np.real(self.poles) < -self.uncertainty))

    @property
    def growth(self) -> float:
        """Rate of the motion that grows most or decays least [1/s]."""
        return float(np.max(np.real(self.poles), initial=-np.inf))

    @property
    def _growing(self) -> np.ndarray:
        """Poles of motions that grow, beyond round-off."""
        return self.poles[np.real(self.poles) > self.uncertainty]

    def summary(self) -> Summary:
        """Return whether the loop is stable, its slowest pole, and its margins."""
        rows = {"growth": f"{short(self.growth)} 1/s", "poles": listed([f"{p:.4g}" for p in self.poles], "rad/s")}
        for margins in self.margins:
            rows[f"margins at {margins.input}"] = (
                f"gain {short(margins.gain)} at {short(margins.gain_hertz)} Hz, phase {short(margins.phase)} degrees at"
                f" {short(margins.crossover)} Hz, modulus {short(margins.modulus)} at {short(margins.modulus_hertz)} Hz"
            )
        word = "stable" if self.stable else "unstable" if len(self._growing) else "neither decays nor grows"
        return Summary(f"ClosedLoop: {word}, {counted(len(self.poles), 'pole')}", rows)


def closed_loop(model: Model | Linearization | control.StateSpace, controller: Any, *, sign: int = -1) -> ClosedLoop:
    """Return the linear loop of a mechanism and a controller, with its poles and margins.

    flexmb warns if the loop is unstable. :func:`flexmb.simulate` does not check the stability, which would take a fifth
    of its compile time; it raises an error if the motion runs away.

    Args:
        model: Mechanism, linearised about its equilibrium; or a linearisation, such as from :func:`flexmb.damped`; or a
            state space, such as ``fm.to_statespace(model, bandwidth=300.0)``.
        controller: System of python-control from the outputs to the inputs, continuous or sampled. It is connected by
            names or in order, like ``control`` of :func:`flexmb.simulate`. A sampled controller reads the mechanism at
            its samples and keeps its output constant in between. If it reads an acceleration or a force, this value
            still results from its previous output.
        sign: -1 for a controller that reads reference - y, as with ``reference`` of :func:`flexmb.simulate`; 1 for a
            controller that reads y.

    Returns:
        ClosedLoop.

    Raises:
        ModelError: As :func:`flexmb.to_statespace`; the controller is no linear system or does not fit the model; the
            state space of the mechanism is sampled; numbers of the mechanism or the controller are not finite.
        TypeError: Numbers of the controller or the model are traced.
        ValueError: ``sign`` is neither -1 nor 1.

    Warns:
        FlexmbWarning: The loop is unstable. The message states the pole and the time in which the motion doubles.

    Source:
        THEORY.md 14, eq. (14.40); ``control.feedback``, ``control.sample_system``.
    """
    import control

    if sign not in (1, -1):
        raise ValueError(f"Argument `sign` must be -1, for reference - y, or 1, for y, not {sign!r}.")
    plant: Any = model if isinstance(model, control.StateSpace) else to_statespace(model)
    inputs, outputs = list(plant.input_labels), list(plant.output_labels)
    (a, b, c, d), period, reads, drives = matrices_of(controller)
    check_sizes(controller, inputs, outputs)
    if not is_concrete((a, b, c, d)):
        raise TypeError(
            "fm.control.closed_loop returns a control.StateSpace, which needs concrete numbers. Use it outside jax.jit"
            " and jax.grad. To differentiate by a gain, use a motion under the controller."
        )
    if plant.dt:
        raise ModelError(
            f"The mechanism's state space is sampled, with dt = {plant.dt}. Give the continuous state space; flexmb"
            " samples it like the controller."
        )
    check_finite("mechanism's state space", (plant.A, plant.B, plant.C, plant.D))
    own_in, own_out = signal_places(reads, outputs, "output"), signal_places(drives, inputs, "input")
    spread = np.eye(len(outputs)) if own_in is None else np.eye(len(outputs))[own_in]
    gather = np.eye(len(inputs)) if own_out is None else np.eye(len(inputs))[:, own_out]
    full_controller: Any = control.ss(a, b @ spread, gather @ c, gather @ d @ spread, period or 0)
    whole_error: Any = control.ss([], [], [], np.eye(len(outputs)))

    def looped(plant: Any) -> tuple[Any, Any, Any]:
        plant = _sampled(plant, period) if period else plant
        opened = plant * full_controller
        try:
            return opened, full_controller * plant, control.feedback(opened, whole_error, sign)
        except ValueError as fault:
            raise ModelError(f"The loop has an algebraic loop without solution: {fault}") from fault

    driven = range(len(inputs)) if own_out is None else sorted(set(own_out))
    opened, returned, loop = looped(plant)
    inner, inner_loop = _without_given_motion(plant, driven), loop
    if inner is not plant:
        _, returned, inner_loop = looped(inner)
    values, uncertainty = _poles(inner_loop, period)
    names: Any = {"inputs": [f"reference {name}" for name in outputs], "outputs": outputs}
    system = control.StateSpace(loop.A, loop.B, loop.C, loop.D, period or 0, **names)
    margins = tuple(_margins(returned, i, inputs[i], sign, period, values) for i in driven)
    answer = ClosedLoop(system, opened, values, margins, uncertainty)
    for first in answer._growing[:1]:
        warn(
            f"The closed loop is unstable: its pole at {first:.4g} rad/s lets a motion of"
            f" {abs(first.imag) / (2 * np.pi):.4g} Hz double every {np.log(2) / first.real:.3g} s. Lower the gains, add"
            " phase at that frequency, or check the signs and the order of the signals."
        )
    return answer


def _without_given_motion(plant: Any, driven: Sequence[int]) -> Any:
    """The plant without the states "moved by" an input that the controller does not drive, which no loop reaches."""
    import control

    undriven = [name for i, name in enumerate(plant.input_labels) if i not in driven]
    given = {f"{rate}moved by {name}" for name in undriven for rate in ("", "d ")}
    keep = np.flatnonzero([label not in given for label in plant.state_labels])
    if len(keep) == plant.nstates:
        return plant
    return control.StateSpace(plant.A[keep][:, keep], plant.B[keep], plant.C[:, keep], plant.D)


def _poles(loop: Any, period: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Poles of a loop, the slowest to decay first, and the round-off of each by its own condition."""
    from scipy.linalg import eig, matrix_balance

    if period or not len(loop.A):
        # The matrix does not show what sampling of the plant has lost.
        values, unsure = _continuous(np.asarray(loop.poles(), complex), period), np.inf
    else:
        balanced: Any = matrix_balance(loop.A)[0]
        solution: Any = eig(balanced, left=True, right=True)
        values, left, right = solution
        with np.errstate(divide="ignore"):
            condition = 1 / np.abs(np.sum(np.conj(left) * right, axis=0))
        unsure = UNSURE * np.finfo(float).eps * np.linalg.norm(balanced) * condition
    uncertainty = np.minimum(unsure, np.full(len(values), NEGLIGIBLE * np.max(np.abs(values), initial=0.0)))
    order = np.lexsort((np.abs(np.imag(values)), -np.real(values)))
    return values[order], uncertainty[order]


def _sampled(plant: Any, period: float) -> Any:
    """A plant with held inputs, sampled before they change, by (14.40)."""
    import control

    sampled: Any = control.sample_system(plant, period, "zoh")
    passed = np.flatnonzero(np.any(sampled.D, axis=0))
    n, n_passed = len(sampled.A), len(passed)
    if not n_passed:
        return sampled
    a = np.block([[sampled.A, np.zeros((n, n_passed))], [np.zeros((n_passed, n + n_passed))]])
    b, c = np.vstack([sampled.B, np.eye(sampled.ninputs)[passed]]), np.hstack([sampled.C, sampled.D[:, passed]])
    return control.ss(a, b, c, np.zeros_like(sampled.D), period)


def _margins(returned: Any, place: int, name: str, sign: int, period: float | None, closed: np.ndarray) -> Margins:
    """Margins of the loop opened at one input, the others closed.

    ``returned`` are all loops, opened at the inputs; ``closed`` the (continuous) poles of the closed loop [rad/s].
    """
    import control

    count = returned.ninputs
    if count > 1:
        others: Any = control.ss([], [], [], np.diag([float(i != place) for i in range(count)]))
        returned = control.feedback(returned, others, sign)
    loop: Any = -sign * returned[place, place]
    opened = _Opened(loop, period)
    rates = _frequencies(opened, closed)
    response = opened(rates)
    # At rest and at the highest frequency a response is always real, which is no crossing of phase.
    ends = opened.ends(rates)
    crossings = _crossings(lambda rate: _sine(opened(rate)), rates, _sine(response))
    reals, places = np.real(opened(crossings)), crossings
    for at, real in ends:
        reals, places = np.append(reals, real), np.append(places, at)
    # Values farther from one are round-off of zero or infinity.
    meaningful = (reals < 0) & (np.abs(np.log(np.abs(reals) + 1e-300)) < -np.log(NEGLIGIBLE))
    gain, gain_at = _least(np.abs(np.log(-reals[meaningful])), -1 / reals[meaningful], places[meaningful])
    crossovers = _crossings(lambda rate: _level(opened(rate)), rates, _level(response))
    phases = np.degrees(np.angle(-opened(crossovers)))
    phase, phase_at = _least(np.abs(phases), phases, crossovers)
    distances = [(abs(1 + real), at) for at, real in ends]
    if rates.size:
        distances.append(_smallest(lambda rate: np.abs(1 + opened(rate)), rates, np.abs(1 + response)))
    modulus, modulus_at = min(distances, default=(np.inf, np.nan))
    turn = 2 * np.pi
    return Margins(name, gain, gain_at / turn, phase, phase_at / turn, modulus, modulus_at / turn)


class _Opened:
    """Response of an opened loop with one input and one output, at rates [rad/s].

    By a Schur form: a whole row of frequencies costs less than one by the system itself.
    """

    def __init__(self, system: Any, period: float | None):
        from scipy.linalg import matrix_balance, schur

        self.period, self.system = period, system
        size: Any = len(system.A)
        pair: Any = matrix_balance(system.A) if size else (system.A, np.eye(0))
        balanced, turn = pair
        pair = schur(balanced, output="complex") if size else pair
        self._triangle, schur_vectors = pair
        self._b, self._c = schur_vectors.conj().T @ np.linalg.solve(turn, system.B), system.C @ turn @ schur_vectors
        self._d = float(np.real(system.D[0, 0]))

    def __call__(self, rates: Any) -> Any:
        """Responses, in the shape of the rates."""
        rates = np.asarray(rates, float)
        s = np.exp(1j * rates.ravel() * self.period) if self.period else 1j * rates.ravel()
        return np.concatenate([self._at(part) for part in np.split(s, range(ROW, len(s), ROW))]).reshape(rates.shape)

    def _at(self, s: np.ndarray) -> np.ndarray:
        n = len(self._triangle)
        x = np.zeros((n, len(s)), complex)
        with np.errstate(divide="ignore", invalid="ignore"):
            for i in reversed(range(n)):
                x[i] = (self._b[i] + self._triangle[i, i + 1 :] @ x[i + 1 :]) / (s - self._triangle[i, i])
            response = (self._c @ x)[0] + self._d
        # On an undamped pole.
        return np.where(np.isfinite(response), response, np.inf)

    def ends(self, rates: np.ndarray) -> list[tuple[float, float]]:
        """Highest rate and rest, at which every response is real, and the responses."""
        highest = np.pi / self.period if self.period else np.inf
        pairs = [(highest, float(np.real(self(highest))) if self.period else self._d)]
        at_origin = self.at_origin()
        if not np.any(at_origin):
            pairs.append((0.0, float(np.real(self(0.0)))))
        elif rates.size:
            # An unobserved rigid motion is no integrator: the response does not grow towards rest.
            rate = max(rates[0], 10 * np.max(np.abs(self.poles()[at_origin])))
            near, far = self(np.array([rate, 2 * rate]))
            if abs(abs(near) - abs(far)) < LEVEL_AT_REST * abs(far):
                # The real part is even in the rate.
                pairs.append((0.0, float(np.real(4 * near - far) / 3)))
        return pairs

    def at_origin(self) -> np.ndarray:
        """Whether each pole belongs to an integrator. Round-off splits a double pole by its square root."""
        poles = self.poles()
        return np.abs(poles) <= POLE_AT_ORIGIN * max(
            np.max(np.abs(poles), initial=0.0), np.pi / (self.period or np.inf)
        )

    def poles(self) -> np.ndarray:
        """Poles [rad/s]; of a sampled loop, poles of a continuous loop with the same values at the samples."""
        return _continuous(np.diag(self._triangle).astype(complex), self.period)


def _sine(response: Any) -> Any:
    """Sine of the phase of a response; zero if it is real but for round-off."""
    with np.errstate(invalid="ignore"):
        sine = np.nan_to_num(np.imag(response) / np.abs(response), nan=1.0)
    return np.where(np.abs(sine) > ROUND_OFF, sine, 0.0)


def _level(response: Any) -> Any:
    """Logarithm of the size of a response, which is not zero."""
    return np.log(np.abs(response) + 1e-300)


def _crossings(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Zeros of a function of frequency, from values at ascending frequencies that show all changes of sign."""
    at, values = _with_turns(function, at, values)
    between = np.flatnonzero(values[:-1] * values[1:] < 0)
    low, high, side = at[between], at[between + 1], np.sign(values[between])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        before = side * function(middle) > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    # A jump of phase at an undamped pole or zero is no crossing.
    beside = low + BLUR_OF_POLE * np.max(at, initial=0.0) * np.array([[-1.0], [1.0]])
    residual = np.max(np.abs(function(beside)), axis=0)
    passes = residual < JUMP_OF_PHASE * np.maximum(np.abs(values[between]), np.abs(values[between + 1]))
    return np.concatenate([at[values == 0], low[passes]])


def _with_turns(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and values, with those where a function turns back next to zero, or beyond it."""
    sizes = np.abs(values)
    inner = (sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] < sizes[2:]) & (sizes[1:-1] < NEARLY_CROSSING)
    alike = (values[1:-1] * values[:-2] > 0) & (values[1:-1] * values[2:] > 0)
    dips = np.flatnonzero(inner & alike) + 1
    dips = dips[np.argsort(sizes[dips])][:DIPS]
    side = np.sign(values[dips])
    least, where = _bottoms(lambda rates: side * function(rates), at[dips - 1], at[dips + 1])
    at, values = np.append(at, where), np.append(values, side * least)
    order = np.argsort(at)
    return at[order], values[order]


def _bottoms(function: Callable[[Any], Any], low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minima of a function between pairs of frequencies with one dip, and their frequencies."""
    at = values = np.zeros((1, len(low)))
    columns, best = np.arange(len(low)), np.zeros(len(low), int)
    for _ in range(NARROWED):
        at = low + (high - low) * SHARES[:, None]
        values = function(at)
        best = np.argmin(values, axis=0)
        low, high = at[np.maximum(best - 1, 0), columns], at[np.minimum(best + 1, len(SHARES) - 1), columns]
    return values[best, columns], at[best, columns]


def _least(sizes: np.ndarray, values: np.ndarray, at: np.ndarray) -> tuple[float, float]:
    """Value of the smallest size, and its frequency; infinite without any."""
    if not sizes.size:
        return np.inf, np.nan
    least = np.argmin(sizes)
    return float(values[least]), float(at[least])


def _smallest(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Minimum of a function of frequency and its place, from values at ascending frequencies that show all its dips."""
    around = np.concatenate([[np.inf], values, [np.inf]])
    dips = np.flatnonzero((values <= around[:-2]) & (values <= around[2:]))
    dips = dips[np.argsort(values[dips])][:DIPS]
    least, where = _bottoms(function, at[np.maximum(dips - 1, 0)], at[np.minimum(dips + 1, len(at) - 1)])
    # The value at a frequency itself may be smaller than those found around it.
    return min((float(values[dips[0]]), float(at[dips[0]])), *zip(least.tolist(), where.tolist(), strict=True))


def _frequencies(opened: _Opened, closed: np.ndarray) -> np.ndarray:
    """Ascending frequencies that miss no pole or zero of the open and the closed loop [rad/s]."""
    poles = opened.poles()[~opened.at_origin()]
    zeros = _continuous(_zeros(opened.system), opened.period)
    seen = np.concatenate([poles, closed])
    largest = np.max(np.abs(seen), initial=0.0)
    seen = np.concatenate([seen, zeros[np.abs(zeros) < FARTHEST_ZERO * largest]])
    seen = seen[np.abs(seen) > POLE_AT_ORIGIN * largest]
    if not seen.size:
        return np.zeros(0)
    most = 10 * np.max(np.abs(seen)) if not opened.period else 0.9999 * np.pi / opened.period
    least = min(np.min(np.abs(seen)), most) / 100
    beside = [abs(p) + max(abs(np.real(p)), NARROWEST_RESONANCE * abs(p)) * BESIDE for p in seen]
    count = max(POINTS, int(A_DECADE * np.log10(most / least)))
    grid = np.concatenate([np.geomspace(least, most, count), *beside])
    grid = np.unique(grid[(grid >= least) & (grid <= most)])
    return grid[np.diff(grid, prepend=0.0) > TWIN_FREQUENCIES * grid]


def _continuous(roots: np.ndarray, period: float | None) -> np.ndarray:
    """Poles of a loop [rad/s], from the roots of the sampled loop if it has a period."""
    return np.log(roots[roots != 0]) / period if period else roots


def _zeros(system: Any) -> np.ndarray:
    """Finite zeros of a system of one input and one output."""
    from scipy.linalg import eigvals

    n = len(system.A)
    system_pencil = np.block([[system.A, system.B], [system.C, system.D]])
    quotients: Any = eigvals(system_pencil, np.diag([1.0] * n + [0.0]), homogeneous_eigvals=True)
    above, below = quotients
    finite = np.abs(below) > NEGLIGIBLE * np.abs(above)
    return above[finite] / below[finite]
