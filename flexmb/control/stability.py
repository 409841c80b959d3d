"""A linear controller around the linearised mechanism: poles, stability and margins, by python-control."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display import Result, Summary, counted, listed, short
from ..errors import ModelError, warn
from ..linear.linearize import Linearization
from ..model.model import Model
from ..motion.controllers import check_sizes, matrices_of, placed
from .state_space import to_statespace

if TYPE_CHECKING:
    import control

# A pole this share of the largest to the right of the imaginary axis is there by round-off.
ROUND_OFF = 1e-9
# Frequencies at which the open loop is looked at: so many, from a hundredth of the slowest pole to ten times the
# fastest, and beside every pole at so many of its half widths, but never on it, where an undamped one has no response.
POINTS = 1200
BESIDE = np.linspace(-8.0, 8.0, 32)
NARROWEST = 1e-6


@dataclasses.dataclass(frozen=True)
class Margins:
    """How far a loop is from instability, opened at one input of the mechanism with all others closed.

    Attributes:
        input: Where it is opened.
        gain: Factor of the gain that makes it unstable, the nearest to one, above or below [-].
        gain_hertz: Frequency of that [Hz].
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
    """

    system: control.StateSpace
    opened: control.StateSpace
    poles: np.ndarray
    margins: tuple[Margins, ...]

    @property
    def stable(self) -> bool:
        """Whether all motions decay."""
        return bool(np.all(np.real(self.poles) < -ROUND_OFF * np.max(np.abs(self.poles), initial=0.0)))

    @property
    def growth(self) -> float:
        """Rate of the motion that grows most or decays least, [1/s]."""
        return float(np.max(np.real(self.poles), initial=-np.inf))

    def summary(self) -> Summary:
        """Whether it is stable, its slowest pole, and its margins."""
        rows = {"growth": f"{short(self.growth)} 1/s", "poles": listed([f"{p:.4g}" for p in self.poles], "rad/s")}
        for own in self.margins:
            rows[f"margins at {own.input}"] = (
                f"gain {short(own.gain)} at {short(own.gain_hertz)} Hz, phase {short(own.phase)} degrees at"
                f" {short(own.crossover)} Hz, modulus {short(own.modulus)} at {short(own.modulus_hertz)} Hz"
            )
        word = "stable" if self.stable else "unstable" if _grows(self.poles) else "neither decays nor grows"
        return Summary(f"ClosedLoop: {word}, {counted(len(self.poles), 'pole')}", rows)


def _grows(poles: np.ndarray) -> bool:
    return bool(np.max(np.real(poles), initial=-np.inf) > ROUND_OFF * np.max(np.abs(poles), initial=0.0))


def closed_loop(model: Model | Linearization | control.StateSpace, controller: Any, *, sign: int = -1) -> ClosedLoop:
    """The linear loop of a mechanism and a controller: is it stable, and how far from instability?

    A controller that makes the loop unstable is warned of. :func:`flexmb.simulate` does not ask: the linearised
    equations would take a fifth of its compile time; its motion runs away, and is refused by name where it does.

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
        ModelError: As :func:`flexmb.to_statespace`; the controller is no linear system, or does not fit the model.
        ValueError: ``sign`` is neither.

    Warns:
        FlexmbWarning: The loop is unstable; with its pole and the time in which it doubles.

    Source:
        THEORY.md 14, eq. (14.40); ``control.feedback``, ``control.sample_system``, ``control.stability_margins``.
    """
    import control

    if sign not in (1, -1):
        raise ValueError(f"Argument `sign` must be -1, for reference - y, or 1, for y, not {sign!r}.")
    plant: Any = model if isinstance(model, control.StateSpace) else to_statespace(model)
    inputs, outputs = list(plant.input_labels), list(plant.output_labels)
    (a, b, c, d), period, reads, drives = matrices_of(controller)
    check_sizes(controller, inputs, outputs)
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
    values = np.asarray(loop.poles(), complex)
    if period:
        values = np.log(values[values != 0]) / period
    values = values[np.lexsort((np.abs(np.imag(values)), -np.real(values)))]
    names: Any = {"inputs": [f"reference {name}" for name in outputs], "outputs": outputs}
    system = control.StateSpace(loop.A, loop.B, loop.C, loop.D, period or 0, **names)
    margins = tuple(_margins(returned, i, name, sign, period) for i, name in enumerate(inputs))
    found = ClosedLoop(system, opened, values, margins)
    if _grows(values):
        first = values[0]
        warn(
            f"The closed loop is unstable: its pole at {first:.4g} rad/s lets a motion of"
            f" {abs(first.imag) / (2 * np.pi):.4g} Hz double every {np.log(2) / first.real:.3g} s. Lower the gains, add"
            " phase at that frequency, or check the signs and the order of the signals."
        )
    return found


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


def _margins(returned: Any, place: int, name: str, sign: int, period: float | None) -> Margins:
    """Margins of the loop opened at one input, the others closed."""
    import control

    count = returned.ninputs
    if count > 1:
        others: Any = control.ss([], [], [], np.diag([float(i != place) for i in range(count)]))
        returned = control.feedback(returned, others, sign)
    one: Any = -sign * returned[place, place]
    hertz = _frequencies(one, period) / (2 * np.pi)
    if not hertz.size or not np.any(one.B) or not np.any(one.C):
        return Margins(name, *([np.inf, np.nan] * 3))
    response = one(_laplace(2j * np.pi * hertz, period))
    data = control.frd(response, 2 * np.pi * hertz, smooth=True)
    gain, phase, modulus, gain_at, phase_at, modulus_at = (float(value) for value in control.stability_margins(data))
    if period:
        # At the highest frequency, where a response is real, there is no crossing of a phase.
        last = float(np.real(one(-1.0)))
        ends = -1 / last if last < 0 else np.inf
        if not abs(np.log(ends)) >= abs(np.log(gain)):
            gain, gain_at = ends, np.pi / period
    distance = np.abs(1 + response)
    if not modulus <= np.min(distance):
        # At an end of the frequencies, where python-control looks for no smallest one.
        modulus, modulus_at = float(np.min(distance)), 2 * np.pi * float(hertz[np.argmin(distance)])
    turn = 2 * np.pi
    return Margins(name, gain, gain_at / turn, phase, phase_at / turn, modulus, modulus_at / turn)


def _laplace(s: np.ndarray, period: float | None):
    return np.exp(s * period) if period else s


def _frequencies(system: Any, period: float | None) -> np.ndarray:
    """Frequencies that show all poles and zeros of a loop, ascending [rad/s]."""
    poles = np.asarray(system.poles(), complex)
    if period:
        poles = np.log(poles[np.abs(poles) > 0]) / period
    sizes = np.abs(poles)
    sizes = sizes[sizes > ROUND_OFF * np.max(sizes, initial=0.0)]
    if not sizes.size:
        # Integrators alone, whose crossover the gain at one rad/s tells.
        sizes = np.array([1e-3, 1e3])
    most = 10 * np.max(sizes) if not period else 0.9999 * np.pi / period
    least = min(np.min(sizes), most) / 100
    beside = [abs(p) + max(abs(np.real(p)), NARROWEST * abs(p)) * BESIDE for p in poles]
    found = np.concatenate([np.geomspace(least, most, POINTS), *beside])
    return np.unique(found[(found >= least) & (found <= most)])
