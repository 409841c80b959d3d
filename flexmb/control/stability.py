"""A linear controller around the linearised mechanism: poles, stability and margins, by python-control."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import is_concrete
from ..display import Result, Summary, counted, listed, short
from ..errors import ModelError, warn
from ..linear.linearize import Linearization
from ..model.model import Model
from ..motion.controllers import check_finite, check_sizes, matrices_of, placed
from .state_space import to_statespace

if TYPE_CHECKING:
    import control

# Share of a largest that is round-off. A pole is known but for so many times the precision, the norm of the matrix and
# its own condition; those of undamped mechanisms are off the axis by less than once that.
ROUND_OFF, UNSURE = 1e-9, 10
# Frequencies at which the open loop is looked at: so many, or so many a decade, from a hundredth of the slowest pole or
# zero, those of the closed loop included, to ten times the fastest; and beside each of them at so many of its half
# widths, but never on it, where an undamped one has no response.
POINTS, A_DECADE = 1200, 150
BESIDE = np.linspace(-8.0, 8.0, 32)
NARROWEST = 1e-6
# Two poles at the origin are off it by less than this share of the fastest pole, the root of round-off; and what is so
# many times as fast as that is no zero, but round-off of one at infinity.
AT_ORIGIN, FARTHEST = 1e-7, 1e4
# Of two frequencies nearer to each other than this share, as two conjugate poles give them, one is enough.
TWINS = 1e-12
# So many of the smallest dips are looked at, of what changes its sign those as near to zero as this; each so many times
# at these shares of what is left about it.
DIPS, NEARLY = 64, 0.3
NARROWED, SHARES = 12, np.linspace(0.0, 1.0, 11)
# So many halvings leave nothing between two frequencies. Round-off blurs a pole by this share of the highest; what is
# not down to that share so near to a zero jumps over it.
HALVINGS, BLUR, JUMP = 50, 1e-14, 0.1
# A response whose size near rest differs by less than this share from that at twice the rate goes by no power of it.
LEVEL = 0.01
# So many frequencies at a time.
ROW = 4096
# Phases are the same where their sines differ by less: an undamped mechanism answers in phase but for round-off.
SAME_PHASE = 1e-12


@dataclasses.dataclass(frozen=True)
class Margins:
    """How far a loop is from instability, opened at one input of the mechanism with all others closed.

    Attributes:
        input: Where it is opened.
        gain: Factor of the gain that makes it unstable, the nearest to one, above or below [-].
        gain_hertz: Frequency of that; infinite where it is that of what passes at once [Hz].
        phase: Phase that may be lost at the crossover [degrees].
        crossover: Frequency where the gain of the open loop is one [Hz].
        modulus: Smallest distance of the open loop from -1 [-].
        modulus_hertz: Frequency of that [Hz].
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
            sampled where the controller is.
        opened: From the controller's error to the outputs, the loop cut at the mechanism's outputs.
        poles: Of a sampled loop those of the continuous one with the same values at the samples, (n,) [rad/s], the
            slowest to decay first.
        margins: One for each input of the mechanism.
        uncertainty: How far round-off may have moved each of the poles, (n,) [rad/s]; taken to be no more than 1e-9 of
            the fastest, which poles that coincide may exceed.
    """

    system: control.StateSpace
    opened: control.StateSpace
    poles: np.ndarray
    margins: tuple[Margins, ...]
    uncertainty: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether all motions decay, beyond round-off."""
        return bool(np.all(np.real(self.poles) < -self.uncertainty))

    @property
    def growth(self) -> float:
        """Rate of the motion that grows most or decays least, [1/s]."""
        return float(np.max(np.real(self.poles), initial=-np.inf))

    @property
    def _growing(self) -> np.ndarray:
        """Poles of motions that grow, beyond round-off."""
        return self.poles[np.real(self.poles) > self.uncertainty]

    def summary(self) -> Summary:
        """Whether it is stable, its slowest pole, and its margins."""
        rows = {"growth": f"{short(self.growth)} 1/s", "poles": listed([f"{p:.4g}" for p in self.poles], "rad/s")}
        for own in self.margins:
            rows[f"margins at {own.input}"] = (
                f"gain {short(own.gain)} at {short(own.gain_hertz)} Hz, phase {short(own.phase)} degrees at"
                f" {short(own.crossover)} Hz, modulus {short(own.modulus)} at {short(own.modulus_hertz)} Hz"
            )
        word = "stable" if self.stable else "unstable" if len(self._growing) else "neither decays nor grows"
        return Summary(f"ClosedLoop: {word}, {counted(len(self.poles), 'pole')}", rows)


def closed_loop(model: Model | Linearization | control.StateSpace, controller: Any, *, sign: int = -1) -> ClosedLoop:
    """The linear loop of a mechanism and a controller: is it stable, and how far from instability?

    A controller that makes the loop unstable is warned of. :func:`flexmb.simulate` does not ask this, which would take
    a
    fifth of its compile time: there a motion that runs away is refused by name.

    Args:
        model: Mechanism about its equilibrium, its linearisation such as that by :func:`flexmb.damped`, or a state
            space of it such as ``fm.to_statespace(model, bandwidth=300.0)``.
        controller: System of python-control from the outputs to the inputs, continuous or sampled, connected by names
            or in order as ``control`` of :func:`flexmb.simulate`. A sampled one sees the mechanism at its samples, an
            acceleration or force with what it gave before, and is held in between.
        sign: What the controller sees: -1 reference - y, as with ``reference`` of :func:`flexmb.simulate`; 1 the
            outputs y themselves, as without.

    Returns:
        ClosedLoop.

    Raises:
        ModelError: As :func:`flexmb.to_statespace`; the controller is no linear system, or does not fit the model; the
            state space of the mechanism is sampled, or numbers of it or of the controller are not finite.
        TypeError: Numbers of the controller or the model are traced.
        ValueError: ``sign`` is neither.

    Warns:
        FlexmbWarning: The loop is unstable; with its pole and the time in which it doubles.

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
            "fm.control.closed_loop makes a control.StateSpace, which holds concrete numbers: ask it outside jax.jit"
            " and jax.grad. What is to be differentiated by a gain is a motion under the controller."
        )
    if plant.dt:
        raise ModelError(
            f"The mechanism's state space is sampled, with dt = {plant.dt}: give the continuous one, which is sampled"
            " here where the controller is."
        )
    check_finite("mechanism's state space", (plant.A, plant.B, plant.C, plant.D))
    own_in, own_out = placed(reads, outputs, "output"), placed(drives, inputs, "input")
    spread = np.eye(len(outputs)) if own_in is None else np.eye(len(outputs))[own_in]
    gather = np.eye(len(inputs)) if own_out is None else np.eye(len(inputs))[:, own_out]
    whole: Any = control.ss(a, b @ spread, gather @ c, gather @ d @ spread, period or 0)
    if period:
        plant = _sampled(plant, period)
    opened, returned = plant * whole, whole * plant
    try:
        whole_error: Any = control.ss([], [], [], np.eye(len(outputs)))
        loop: Any = control.feedback(opened, whole_error, sign)
    except ValueError as fault:
        raise ModelError(f"The loop passes on what it is given without delay, and has no solution: {fault}") from fault
    values, uncertainty = _poles(loop, period)
    names: Any = {"inputs": [f"reference {name}" for name in outputs], "outputs": outputs}
    system = control.StateSpace(loop.A, loop.B, loop.C, loop.D, period or 0, **names)
    margins = tuple(_margins(returned, i, name, sign, period, values) for i, name in enumerate(inputs))
    found = ClosedLoop(system, opened, values, margins, uncertainty)
    for first in found._growing[:1]:
        warn(
            f"The closed loop is unstable: its pole at {first:.4g} rad/s lets a motion of"
            f" {abs(first.imag) / (2 * np.pi):.4g} Hz double every {np.log(2) / first.real:.3g} s. Lower the gains, add"
            " phase at that frequency, or check the signs and the order of the signals."
        )
    return found


def _poles(loop: Any, period: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Poles of a loop, the slowest to decay first, and how far round-off may have moved each, (n,) and (n,) [rad/s].

    Each by its own condition, since a stiff mode leaves a soft one where it is.
    """
    from scipy.linalg import eig, matrix_balance

    if period or not len(loop.A):
        # What the sampling of a plant has lost does not show in the matrix.
        values, unsure = _continuous(np.asarray(loop.poles(), complex), period), np.inf
    else:
        found: Any = matrix_balance(loop.A)
        balanced = found[0]
        found = eig(balanced, left=True, right=True)
        values, left, right = found
        with np.errstate(divide="ignore"):
            condition = 1 / np.abs(np.sum(np.conj(left) * right, axis=0))
        unsure = UNSURE * np.finfo(float).eps * np.linalg.norm(balanced) * condition
    uncertainty = np.minimum(unsure, np.full(len(values), ROUND_OFF * np.max(np.abs(values), initial=0.0)))
    order = np.lexsort((np.abs(np.imag(values)), -np.real(values)))
    return values[order], uncertainty[order]


def _sampled(plant: Any, period: float) -> Any:
    """A plant at samples whose inputs are held in between: it is sampled before they change, by (14.40)."""
    import control

    whole: Any = control.sample_system(plant, period, "zoh")
    passed = np.flatnonzero(np.any(whole.D, axis=0))
    n, held = len(whole.A), len(passed)
    if not held:
        return whole
    a = np.block([[whole.A, np.zeros((n, held))], [np.zeros((held, n + held))]])
    b, c = np.vstack([whole.B, np.eye(whole.ninputs)[passed]]), np.hstack([whole.C, whole.D[:, passed]])
    return control.ss(a, b, c, np.zeros_like(whole.D), period)


def _margins(returned: Any, place: int, name: str, sign: int, period: float | None, closed: np.ndarray) -> Margins:
    """Margins of the loop opened at one input, the others closed.

    ``returned`` are all loops, opened at the inputs, ``closed`` the poles of the closed loop, of a sampled one those of
    the continuous one, (n,) [rad/s].
    """
    import control

    count = returned.ninputs
    if count > 1:
        others: Any = control.ss([], [], [], np.diag([float(i != place) for i in range(count)]))
        returned = control.feedback(returned, others, sign)
    one: Any = -sign * returned[place, place]
    opened = _Opened(one, period)
    rates = _frequencies(opened, closed)
    response = opened(rates)
    # Where a response is real whatever the system, no phase crosses: at rest, and at the highest frequency.
    ends = opened.ends(rates)
    crossings = _crossings(lambda rate: _sine(opened(rate)), rates, _sine(response))
    reals, places = np.real(opened(crossings)), crossings
    for at, real in ends:
        reals, places = np.append(reals, real), np.append(places, at)
    # What is farther from one is round-off of nothing, or of what is infinite.
    told = (reals < 0) & (np.abs(np.log(np.abs(reals) + 1e-300)) < -np.log(ROUND_OFF))
    gain, gain_at = _least(np.abs(np.log(-reals[told])), -1 / reals[told], places[told])
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
    """Response of an opened loop with one input and one output, at rates of frequencies [rad/s].

    By a Schur form, of which a whole row of frequencies costs less than one by the system itself.
    """

    def __init__(self, system: Any, period: float | None):
        from scipy.linalg import matrix_balance, schur

        self.period, self.system = period, system
        size: Any = len(system.A)
        found: Any = matrix_balance(system.A) if size else (system.A, np.eye(0))
        balanced, turn = found
        found = schur(balanced, output="complex") if size else found
        self._triangle, own = found
        self._b, self._c = own.conj().T @ np.linalg.solve(turn, system.B), system.C @ turn @ own
        self._d = float(np.real(system.D[0, 0]))

    def __call__(self, rates: Any) -> Any:
        """Responses, of the shape of the rates."""
        rates = np.asarray(rates, float)
        s = np.exp(1j * rates.ravel() * self.period) if self.period else 1j * rates.ravel()
        return np.concatenate([self._at(part) for part in np.split(s, range(ROW, len(s), ROW))]).reshape(rates.shape)

    def _at(self, s: np.ndarray) -> np.ndarray:
        n = len(self._triangle)
        x = np.zeros((n, len(s)), complex)
        with np.errstate(divide="ignore", invalid="ignore"):
            for i in reversed(range(n)):
                x[i] = (self._b[i] + self._triangle[i, i + 1 :] @ x[i + 1 :]) / (s - self._triangle[i, i])
            found = (self._c @ x)[0] + self._d
        # On an undamped pole.
        return np.where(np.isfinite(found), found, np.inf)

    def ends(self, rates: np.ndarray) -> list[tuple[float, float]]:
        """Rates at which the response is real whatever the system, and the responses: at the highest, and at rest.

        The least of ``rates`` is far below all poles and zeros but those at the origin [rad/s].
        """
        highest = np.pi / self.period if self.period else np.inf
        found = [(highest, float(np.real(self(highest))) if self.period else self._d)]
        at_origin = self.at_origin()
        if not np.any(at_origin):
            found.append((0.0, float(np.real(self(0.0)))))
        elif rates.size:
            # A rigid motion that the loop does not see is no integrator: towards rest the response does not grow.
            rate = max(rates[0], 10 * np.max(np.abs(self.poles()[at_origin])))
            near, far = self(np.array([rate, 2 * rate]))
            if abs(abs(near) - abs(far)) < LEVEL * abs(far):
                # Its real part is even in the rate.
                found.append((0.0, float(np.real(4 * near - far) / 3)))
        return found

    def at_origin(self) -> np.ndarray:
        """Which poles are those of integrators, but for round-off: two of them split by its root."""
        poles = self.poles()
        return np.abs(poles) <= AT_ORIGIN * max(np.max(np.abs(poles), initial=0.0), np.pi / (self.period or np.inf))

    def poles(self) -> np.ndarray:
        """Poles, of a sampled loop those of the continuous one [rad/s]."""
        return _continuous(np.diag(self._triangle).astype(complex), self.period)


def _sine(response: Any) -> Any:
    """Sine of the phase of a response; zero where it is real but for round-off."""
    with np.errstate(invalid="ignore"):
        found = np.nan_to_num(np.imag(response) / np.abs(response), nan=1.0)
    return np.where(np.abs(found) > SAME_PHASE, found, 0.0)


def _level(response: Any) -> Any:
    """Logarithm of the size of a response, which is not zero."""
    return np.log(np.abs(response) + 1e-300)


def _crossings(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Where a function of the frequency is zero, of which values at ascending ones show all changes of sign."""
    at, values = _with_turns(function, at, values)
    between = np.flatnonzero(values[:-1] * values[1:] < 0)
    low, high, side = at[between], at[between + 1], np.sign(values[between])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        before = side * function(middle) > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    # A phase jumps at an undamped pole or zero, and is that of no crossing there.
    beside = low + BLUR * np.max(at, initial=0.0) * np.array([[-1.0], [1.0]])
    left = np.max(np.abs(function(beside)), axis=0)
    passes = left < JUMP * np.maximum(np.abs(values[between]), np.abs(values[between + 1]))
    return np.concatenate([at[values == 0], low[passes]])


def _with_turns(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and values, with those where a function comes nearest to zero and turns back, or goes beyond it."""
    sizes = np.abs(values)
    inner = (sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] < sizes[2:]) & (sizes[1:-1] < NEARLY)
    alike = (values[1:-1] * values[:-2] > 0) & (values[1:-1] * values[2:] > 0)
    dips = np.flatnonzero(inner & alike) + 1
    dips = dips[np.argsort(sizes[dips])][:DIPS]
    side = np.sign(values[dips])
    least, where = _bottoms(lambda rates: side * function(rates), at[dips - 1], at[dips + 1])
    at, values = np.append(at, where), np.append(values, side * least)
    order = np.argsort(at)
    return at[order], values[order]


def _bottoms(function: Callable[[Any], Any], low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least values of a function, (shares, pairs), between pairs of frequencies with one dip, and where."""
    at = values = np.zeros((1, len(low)))
    columns, best = np.arange(len(low)), np.zeros(len(low), int)
    for _ in range(NARROWED):
        at = low + (high - low) * SHARES[:, None]
        values = function(at)
        best = np.argmin(values, axis=0)
        low, high = at[np.maximum(best - 1, 0), columns], at[np.minimum(best + 1, len(SHARES) - 1), columns]
    return values[best, columns], at[best, columns]


def _least(sizes: np.ndarray, values: np.ndarray, at: np.ndarray) -> tuple[float, float]:
    """Value of the least size, and its frequency; infinite where there is none."""
    if not sizes.size:
        return np.inf, np.nan
    least = np.argmin(sizes)
    return float(values[least]), float(at[least])


def _smallest(function: Callable[[Any], Any], at: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Smallest value of a function of the frequency, of which values at ascending ones show all its dips; and where."""
    around = np.concatenate([[np.inf], values, [np.inf]])
    dips = np.flatnonzero((values <= around[:-2]) & (values <= around[2:]))
    dips = dips[np.argsort(values[dips])][:DIPS]
    least, where = _bottoms(function, at[np.maximum(dips - 1, 0)], at[np.minimum(dips + 1, len(at) - 1)])
    # That at a frequency itself may be less than what is found about it.
    return min((float(values[dips[0]]), float(at[dips[0]])), *zip(least.tolist(), where.tolist(), strict=True))


def _frequencies(opened: _Opened, closed: np.ndarray) -> np.ndarray:
    """Frequencies between which the open and the closed loop have no unseen pole or zero, ascending [rad/s]."""
    poles = opened.poles()[~opened.at_origin()]
    zeros = _continuous(_zeros(opened.system), opened.period)
    seen = np.concatenate([poles, closed])
    largest = np.max(np.abs(seen), initial=0.0)
    seen = np.concatenate([seen, zeros[np.abs(zeros) < FARTHEST * largest]])
    seen = seen[np.abs(seen) > AT_ORIGIN * largest]
    if not seen.size:
        return np.zeros(0)
    most = 10 * np.max(np.abs(seen)) if not opened.period else 0.9999 * np.pi / opened.period
    least = min(np.min(np.abs(seen)), most) / 100
    beside = [abs(p) + max(abs(np.real(p)), NARROWEST * abs(p)) * BESIDE for p in seen]
    count = max(POINTS, int(A_DECADE * np.log10(most / least)))
    found = np.concatenate([np.geomspace(least, most, count), *beside])
    found = np.unique(found[(found >= least) & (found <= most)])
    return found[np.diff(found, prepend=0.0) > TWINS * found]


def _continuous(roots: np.ndarray, period: float | None) -> np.ndarray:
    """Rates of roots of a loop, which are those of samples where it has a period [rad/s]."""
    return np.log(roots[roots != 0]) / period if period else roots


def _zeros(system: Any) -> np.ndarray:
    """Zeros of a system of one input and one output; those at infinity are left out."""
    from scipy.linalg import eigvals

    n = len(system.A)
    whole = np.block([[system.A, system.B], [system.C, system.D]])
    found: Any = eigvals(whole, np.diag([1.0] * n + [0.0]), homogeneous_eigvals=True)
    above, below = found
    finite = np.abs(below) > ROUND_OFF * np.abs(above)
    return above[finite] / below[finite]
