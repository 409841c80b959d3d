"""Noise budgets: spectrum, cumulative spectrum and root mean square of outputs, source by source."""

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..arguments import check_numbers, is_concrete, short_repr, undifferentiated
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record, static
from ..display import Column, Labelled, Quantities, Summary, listed, short, span
from ..errors import AnalysisError, ModelError, printable, warn
from ..linear.about import Where, linearized
from ..linear.linearize import Linearization, ManyStates
from ..linear.loose import refuse_without_anything
from ..math.derivative import root_or_zero
from ..math.linear import general_eigen
from ..math.matrix_functions import lyapunov
from ..model.model import Model
from ..numerical_limits import DECAYING_POLE, DRIFTING_NOISE, GROWING_NOISE, UNRESOLVED_SHARE
from ..statics.equilibrium import Equilibrium
from .feedback import Controller, EnergyForm, Places, closed, closed_by_frequency, energy_form, feedback_controller
from .frequency_response import check_hertz, place_of_name, places_of_names, response_of
from .harmonic import plain_arrays
from .noise_frequencies import (
    areas,
    band_frequencies,
    filled,
    frequencies_of_density,
    refined_frequencies,
    responses_at,
    undamped_within,
    unresolved_resonances,
)
from .second_order_form import SecondOrder, second_order
from .state_space import damped_without_mass

Density = float | Sequence[float] | Float[Array, "n_f"] | Callable[[Any], Any]


class NoiseBudget(Labelled, Record):
    """Noise of outputs, source by source; densities are one-sided, per Hz.

    Attributes:
        hertz: Frequencies, (n_f,) [Hz].
        spectra: Power spectral density of each output by each source, (n_f, n_y, n_s) [unit^2/Hz].
        below: Integral of each density from the lowest frequency to each frequency, (n_f, n_y, n_s) [unit^2].
        variances: Mean square of each output by each source, (n_y, n_s) [unit^2].
        outputs: Names of the outputs.
        sources: Names of the sources.
    """

    hertz: Float[Array, "n_f"]
    spectra: Float[Array, "n_f n_y n_s"]
    below: Float[Array, "n_f n_y n_s"]
    variances: Float[Array, "n_y n_s"]
    outputs: tuple[str, ...] = static()
    sources: tuple[str, ...] = static()
    one_axis = "hertz"

    def rms(self, output: str | None = None, source: str | None = None) -> Float[Array, ""]:
        """Return the root mean square of an output, () [unit of the output].

        Args:
            output: Name of the output; optional if there is only one.
            source: Name of a source; by default all sources together.

        Raises:
            KeyError: The output or the source is unknown.
        """
        return root_or_zero(self._part(self.variances, output, source))

    def _part(self, values: Any, output: str | None, source: str | None) -> Any:
        by_source = values[..., place_of_name("output", self.outputs, output), :]
        return (
            jnp.sum(by_source, axis=-1)
            if source is None
            else by_source[..., place_of_name("source", self.sources, source)]
        )

    def spectrum(self, output: str | None = None, source: str | None = None) -> Float[Array, "n_f"]:
        """Return the one-sided power spectral density of an output, (n_f,) [unit^2/Hz].

        Args:
            output, source: As for :meth:`rms`.
        """
        return self._part(self.spectra, output, source)

    def cumulative(self, output: str | None = None, source: str | None = None) -> Float[Array, "n_f"]:
        """Return the root mean square of an output up to each frequency, (n_f,) [unit of the output].

        Args:
            output, source: As for :meth:`rms`.
        """
        return root_or_zero(self._part(self.below, output, source))

    def quantities_by_name(self) -> Quantities:
        """Return spectral densities and their integrals, by frequency, output and source."""
        over = ("frequency", "output", "source")
        along = {"frequency": Column(over[:1], self.hertz, "Hz")}
        along |= {
            name: Column((name,), np.array(names))
            for name, names in zip(over[1:], (self.outputs, self.sources), strict=True)
        }
        return Quantities(over[:1], along, {"density": Column(over, self.spectra), "below": Column(over, self.below)})

    def summary(self) -> Summary:
        """Return the root mean square of each output, and the share of each source in its mean square."""
        rows = {"frequencies": span(self.hertz, "Hz"), "sources": listed(self.sources)}
        for name, variances in zip(self.outputs, np.asarray(self.variances), strict=True):
            total = float(np.sum(variances))
            if not np.isfinite(total) or total == 0:
                rows[f"rms of {name}"] = short(np.sqrt(total))
                continue
            shares = [
                f"{100 * part / total:.1f} % {source}"
                for part, source in zip(variances, self.sources, strict=True)
                if part
            ]
            rows[f"rms of {name}"] = f"{short(np.sqrt(total))}: {', '.join(shares)}"
        title = f"NoiseBudget: {len(self.outputs)} outputs, {len(self.sources)} sources"
        return Summary(title, rows, "noise", {} if len(self.outputs) == 1 else None)


@unguarded
def noise_budget(
    model: Model | Linearization,
    hertz: Float[Array, "n_f"] | Sequence[float] | None = None,
    *,
    sources: Mapping[str, Density],
    band: tuple[float, float] | None = None,
    controller: Any = None,
    measured: Sequence[str] | str | None = None,
    driven: Sequence[str] | str | None = None,
    sign: int = -1,
    outputs: Sequence[str] | str | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> NoiseBudget:
    """Return the noise of outputs due to independent sources, with or without a controller around the mechanism.

    Three ways give the root mean square:

    - ``hertz``: integrate between its first and last frequency by the trapezoidal rule;
    - ``band``: integrate over the band, at frequencies that flexmb chooses;
    - neither, for white sources: integrate over all frequencies, exactly, by Lyapunov's equation.

    Args:
        model: Mechanism, or its linearisation such as ``fm.damped(model, ratio=0.01)``; differentiable in its
            parameters.
        hertz: Ascending frequencies, (n_f,) [Hz], with three or more within the half-power width of each resonance.
            flexmb warns if they do not resolve a resonance, unless numbers are traced by ``jax.jit`` or the controller
            is a function, so that the poles of its loop are unknown.
        sources: One-sided power spectral densities [unit^2/Hz]: a number, an array, (n_f,), for ``hertz``, or a
            function of frequencies, (n_f,) [Hz]. Keys are names of inputs, for noise added to the input, such as the
            motion of a floor. Or "sensor " and the name of an output, for noise added to the controller's reading.
        band: Lowest and highest frequency [Hz]. flexmb chooses frequencies densely near each pole, and where a density
            function bends or jumps. A band from 0 Hz starts at 1e-4 of the slowest pole. flexmb finds a peak of a
            density if the peak extends at least 1e-3 of its frequency to each side. For narrower peaks, and for
            densities that ``jax.jit`` traces, use ``hertz``.
        controller: A continuous system of python-control, a tuple of its A, B, C and D, a matrix of gains (n_driven,
            n_measured), or a function of frequencies, (n_f,) [Hz], that returns (n_f, n_driven, n_measured), or (n_f,)
            for one output and one input. Matrices and results of functions may be traced. If the controller is a
            function, flexmb does not check the stability of the loop.
        measured: Names of the outputs that the controller reads, in its order. Default: names of the controller's
            inputs, or all outputs if the controller has no name of an output.
        driven: Names of the inputs that the controller drives, in its order. Default: names of the controller's
            outputs, or all inputs.
        sign: -1 for u = -K y, as in ``control.feedback`` and :func:`flexmb.simulate` with a reference of zero; or 1.
        outputs: Names of the wanted outputs; all by default.
        at, step, time, increment: State, as for :func:`flexmb.frequencies`.

    Returns:
        NoiseBudget. A root mean square is infinite in three cases: white noise reaches the output directly, such as
        from a force to an acceleration; white noise makes the output drift; or, under a trace, the loop is not stable.

    Raises:
        AnalysisError: unstable: the mechanism or the loop does not come to rest, or has an undamped resonance within
            the frequencies, so that its noise is unbounded. Also failures of the linearisation.
        ModelError: No controller reads a sensor with noise, there are no outputs, or an input moves nothing. Some
            of the controller's names belong to the mechanism, others do not.
        KeyError: A source, output or input is unknown.
        ValueError: There are no sources; a density is negative or has a wrong shape; a density that is no number has
            neither ``hertz`` nor ``band``; the controller does not fit or is not finite at a frequency; under
            ``jax.jit``, a ``band`` is combined with a controller that is a function.

    Warns:
        FlexmbWarning: ``hertz`` do not resolve a resonance; a root mean square is infinite; a spectrum grows towards
            0 Hz, where the band starts; a density function, or a loop with a controller function, has peaks that are
            too sharp to resolve.

    Source:
        THEORY.md 14, eq. (14.33) to (14.37).
    """
    if hertz is not None and band is not None:
        raise ValueError("Give either `hertz` or `band`, not both.")
    if sign not in (-1, 1):
        raise ValueError(f"Argument `sign` must be -1 or 1, but is {short_repr(sign)}.")
    lin = linearized(model, "noise_budget", where=Where(at, step, time, increment))
    ins, outs = ([s.name for s in signals] for signals in (lin.labels.inputs, lin.labels.outputs))
    chosen_outputs = tuple(places_of_names("output", outs, outputs))
    loop = None
    if controller is not None:
        loop = feedback_controller(controller, measured, driven, outs, ins, sign)
    elif measured is not None or driven is not None:
        raise ValueError("Arguments `measured` and `driven` need a controller.")
    entering = _sources(sources, ins, outs, loop)
    if hertz is None and band is None:
        _check_white(entering, lin, loop)
    band = None if band is None else _band(band)
    over = _frequencies(lin, loop, entering, hertz, band)
    pairs = zip(entering.names, entering.densities, strict=True)
    densities = [_density(name, density, over.hertz) for name, density in pairs]
    spectra, below, variances = _budget(
        response_of(lin, over.hertz, None, None, None, None).response,
        None if loop is None else loop.by_frequency(over.hertz),
        densities,
        over,
        places=loop and loop.places,
        entries=entering.entries,
        wanted=chosen_outputs,
    )
    budget = NoiseBudget(over.hertz, spectra, below, variances, tuple(outs[i] for i in chosen_outputs), entering.names)
    if hertz is not None and over.poles is not None:
        known, frequencies, noise = undifferentiated((lin, over, budget))
        _warn_unresolved(known, frequencies, noise, loop, entering, chosen_outputs)
    if is_concrete(budget):
        _warn_infinite(budget)
        if band is not None and band[0] == 0:
            _warn_at_rest(budget)
    return budget


class _Entering(NamedTuple):
    """Where noise enters: numbers of inputs and of outputs with noisy sensors, all names and densities."""

    entries: tuple[tuple[int, ...], tuple[int, ...]]
    names: tuple[str, ...]
    densities: tuple[Any, ...]


def _sources(sources: Any, inputs: list[str], outputs: list[str], loop: Controller | None) -> _Entering:
    """Inputs, then sensors, in any order of the sources."""
    if not isinstance(sources, Mapping) or not sources:
        raise ValueError("Argument `sources` must be densities by name, such as {'floor': 1e-9}, at least one.")
    at_inputs, of_sensors = {}, {}
    for name, density in sources.items():
        known = {*inputs, *(input_name.replace(".", " ") for input_name in inputs)}
        if name in known:
            at_inputs[place_of_name("input", inputs, name)] = density
        elif isinstance(name, str) and name.startswith("sensor "):
            number = place_of_name("output", outputs, name.removeprefix("sensor "))
            if loop is None or number not in loop.measured:
                reads = "there is no controller" if loop is None else "the controller does not read it"
                raise ModelError(f"Source '{printable(name)}': {reads}, so noise of this sensor has no effect.")
            of_sensors[number] = density
        else:
            raise KeyError(
                f"There is no source '{printable(name)}': it is an input, {', '.join(inputs)}, or 'sensor' and an"
                f" output, {', '.join(outputs)}."
            )
    names = [inputs[i] for i in at_inputs] + [f"sensor {outputs[i]}" for i in of_sensors]
    if len(names) < len(sources):
        raise ValueError("Argument `sources` names one source twice.")
    entries = tuple(at_inputs), tuple(of_sensors)
    return _Entering(entries, tuple(names), (*at_inputs.values(), *of_sensors.values()))


def _check_white(entering: _Entering, lin: Linearization, loop: Controller | None) -> None:
    """Refuse sources or controllers without an exact sum over all frequencies; warn of damping that it leaves out."""
    for name, density in zip(entering.names, entering.densities, strict=True):
        if callable(density) or np.ndim(density):
            raise ValueError(f"Source '{name}' is not white. Give `hertz` or `band` to integrate its noise over.")
    if loop is not None and loop.matrices is None:
        raise ValueError(
            "The controller is a function of frequencies, whose poles are not known. Give `hertz` or `band`."
        )
    if is_concrete(lin.matrices) and (name := damped_without_mass(lin)):
        warn(
            f"The motion of {name} carries no mass but is damped. The exact integral neglects this damping. Give"
            " `band`, which includes it, or give the motion a mass."
        )


class _Frequencies(NamedTuple):
    """Frequencies of spectra, and what their sum needs.

    Attributes:
        steps: Width that each frequency of a band represents, and its place in such widths; None for trapezia.
        settles: Whether noise is bounded.
        whole: State space for the exact sum over all frequencies.
        poles: Poles of the mechanism or its loop, (n,) [rad/s]; None if they are unknown.
    """

    hertz: Any
    steps: tuple[Float[Array, "n_f"], Float[Array, "n_f"]] | None
    settles: Bool[Array | np.ndarray, ""]
    whole: EnergyForm | None
    poles: Complex[Array, "n"] | None = None


def _frequencies(
    lin: Linearization, loop: Controller | None, entering: _Entering, hertz: Any, band: tuple[float, float] | None
) -> _Frequencies:
    """The given frequencies, or the frequencies that the poles require."""
    entries, exact = entering.entries, hertz is None and band is None
    # A controller function has no known poles. The poles of the mechanism show its resonances.
    by_states = loop is None or loop.matrices is not None
    refuse_without_anything(lin)
    system, orders = plain_arrays(second_order(lin))
    grid: Any
    noise_system, poles, settles, (grid, steps) = _loop(
        system,
        None if loop is None else loop.matrices,
        None if band is None else _asked_by_densities(entering, band),
        orders=orders,
        places=loop.places if loop is not None and by_states else None,
        entries=entries if by_states else (entries[0], ()),
        band=band,
        exact=exact,
    )
    if by_states and is_concrete(poles):
        _refuse_unstable(np.asarray(poles), bool(settles), loop is not None)
    if hertz is not None:
        grid, steps = check_hertz(hertz), None
        if is_concrete(grid) and (len(grid) < 2 or np.any(np.diff(np.asarray(grid, float)) < 0) or grid[0] == grid[-1]):
            raise ValueError("Argument `hertz` of fm.control.noise_budget must be two frequencies or more that ascend.")
    elif loop is not None and not by_states:
        grid, steps = refined_frequencies(lin, loop, entries, grid), None
    if not by_states:
        return _Frequencies(grid, steps, np.array(True), None)
    if not exact:
        undamped = undamped_within(poles, grid)
        settles = settles & ~jnp.any(undamped)
        if is_concrete((undamped, poles)) and len(resonant := np.asarray(poles)[np.asarray(undamped)]):
            raise AnalysisError(
                "unstable",
                f"A resonance within the band, at {abs(resonant[0]) / (2 * np.pi):.4g} Hz, has no damping. Its noise is"
                " unbounded. Damp it, such as by fm.damped(model, ratio=0.01), or give a band without it.",
            )
    return _Frequencies(grid, steps, settles, noise_system if exact else None, poles)


def _asked_by_densities(entering: _Entering, band: tuple[float, float]) -> np.ndarray | None:
    """Frequencies of a band that density functions require, (n,) [Hz]; None without any."""
    pairs = [pair for pair in zip(entering.names, entering.densities, strict=True) if callable(pair[1])]
    grids = [frequencies_of_density(name, functools.partial(_density, name, density), *band) for name, density in pairs]
    return filled(np.unique(np.concatenate(grids))) if grids else None


def _band(band: Any) -> tuple[float, float]:
    check_numbers("Argument `band`", band, (2,))
    low, high = (float(end) for end in band)
    if not 0 <= low < high:
        raise ValueError(f"Argument `band` must be two ascending frequencies, not negative, but is {short_repr(band)}.")
    return low, high


def _density(name: str, specified: Any, grid: Float[Array | np.ndarray, "n_f"]) -> Float[Array, "*n_f"]:
    """Density of a source at all frequencies, or one for all of them."""
    density: Any = specified(grid) if callable(specified) else specified
    check_numbers(f"Density of source '{name}'", density, grid.shape if np.ndim(density) else ())
    if is_concrete(density) and np.any(np.asarray(density) < 0):
        raise ValueError(f"Density of source '{name}' cannot be negative, but is {short_repr(density)}.")
    if is_concrete(density):
        density = np.asarray(density, float)
    return density


def _refuse_unstable(poles: Any, settles: bool, closed: bool) -> None:
    """Raise unstable for a mechanism or loop that does not come to rest."""
    if settles:
        return
    worst = complex(poles[np.argmax(poles.real)])
    hertz = abs(worst.imag) / (2 * np.pi)
    system = "The loop of mechanism and controller" if closed else "The mechanism"
    how = f"its pole {worst.real:.4g} ± {abs(worst.imag):.4g}i rad/s, at {hertz:.4g} Hz,"
    if worst.real > GROWING_NOISE * np.max(np.abs(poles)):
        remedy = "Change the controller, or its sign (`sign`)." if closed else "Support it, or close a loop around it."
        raise AnalysisError("unstable", f"{system} is unstable: {how} grows. Its noise is unbounded. {remedy}")
    raise AnalysisError(
        "unstable",
        f"{system} does not come to rest: {how} has no damping. Its response to white noise is unbounded. Damp it, such"
        " as by fm.damped(model, ratio=0.01), or give a `band` without it.",
    )


def _warn_unresolved(
    lin: Linearization,
    over: _Frequencies,
    noise: NoiseBudget,
    loop: Controller | None,
    entering: _Entering,
    wanted: tuple[int, ...],
) -> None:
    """Warn of a resonance that the given frequencies do not resolve, by its own share in a mean square."""
    if not is_concrete((lin, over, noise, loop and loop.matrices, entering.densities)):
        return
    grid = np.asarray(over.hertz, float)
    peak_hertz, widths, area, excess = unresolved_resonances(np.asarray(over.poles), grid)
    if not len(peak_hertz):
        return
    densities = []
    for name, specified in zip(entering.names, entering.densities, strict=True):
        density = np.interp(peak_hertz, grid, specified) if np.ndim(specified) else specified
        densities.append(np.broadcast_to(_density(name, density, peak_hertz), peak_hertz.shape))
    responses = responses_at(lin, loop, entering.entries, peak_hertz)[:, list(wanted)]
    peaks = np.abs(responses) ** 2 * np.stack(densities, axis=1)[:, None]
    excess, area = excess[:, None, None], area[:, None, None]
    variances = np.asarray(noise.variances)
    least = np.max(peaks * area, axis=0)
    true = np.maximum(variances - np.sum(peaks * excess, axis=0), least)
    shares = np.abs(peaks * excess) / np.where(true > 0, true, np.inf)
    if not np.max(shares) > UNRESOLVED_SHARE:
        return
    k, i, j = np.unravel_index(np.argmax(shares), shares.shape)
    f, off = peak_hertz[k], abs(np.sqrt(variances[i, j] / true[i, j]) - 1)
    warn(
        f"The frequencies `hertz` do not resolve the resonance at {f:.5g} Hz, whose half-power width is"
        f" {widths[k]:.2g} Hz: the root mean square of '{noise.outputs[i]}' by '{noise.sources[j]}' is off by some"
        f" {100 * off:.2g} %. Use band=({grid[0]:.5g}, {grid[-1]:.5g}), for which flexmb chooses the frequencies, or"
        " give three frequencies or more within this width."
    )


def _warn_infinite(noise: NoiseBudget) -> None:
    infinite = np.argwhere(~np.isfinite(np.asarray(noise.variances)))
    if len(infinite):
        pairs = ", of ".join(f"'{noise.outputs[i]}' by '{noise.sources[j]}'" for i, j in infinite)
        warn(
            f"The root mean square of {pairs} is infinite: white noise reaches the output directly or makes it drift,"
            " or a resonance is undamped. Give a `band` to integrate over, or damp the resonance."
        )


def _warn_at_rest(noise: NoiseBudget) -> None:
    """Warn if unbounded growth towards 0 Hz is most of the sum over a band from there."""
    first = np.asarray(noise.hertz)[0] * np.asarray(noise.spectra)[0]
    drifting = np.argwhere(first > DRIFTING_NOISE * np.asarray(noise.variances))
    if len(drifting):
        i, j = drifting[0]
        warn(
            f"The spectrum of '{noise.outputs[i]}' by '{noise.sources[j]}' grows towards 0 Hz. Its root mean square"
            f" begins at {short(noise.hertz[0])} Hz. Give the band a lowest frequency."
        )


@jit
def _loop(
    system: SecondOrder,
    matrices: Any,
    asked: Float[Array, "n"] | None,
    *,
    orders: tuple[int, ...],
    places: Places | None,
    entries: tuple[tuple[int, ...], tuple[int, ...]],
    band: tuple[float, float] | None,
    exact: bool,
):
    """State space from noise to outputs, its poles, whether it settles, or does not grow, and frequencies.

    Frequencies move with the poles, also in derivatives. On a fixed grid, the error of a derivative would be the
    error of the sum times the sharpness of a resonance.
    """
    noise_system = closed(energy_form(system, orders), matrices, places, *entries)
    poles, _, _ = general_eigen(noise_system.A)
    # Negated, so that NaN does not count as unstable.
    settles = ~(jnp.max(jnp.real(poles)) >= (-DECAYING_POLE if exact else GROWING_NOISE) * jnp.max(jnp.abs(poles)))
    return noise_system, poles, settles, band_frequencies(poles, *(band or (None, None)), asked)


@jit
def _budget(
    plant: Complex[Array, "n_f n_y n_u"],
    gain: Complex[Array, "n_f n_d n_m"] | None,
    densities: Sequence[Array],
    over: _Frequencies,
    *,
    places: Places | None,
    entries: tuple[tuple[int, ...], tuple[int, ...]],
    wanted: tuple[int, ...],
):
    """Spectra, cumulative sums and variances: within the grid, or exact."""
    (grid, steps, settles, noise_system, _), rows = over, np.array(wanted)
    density = jnp.stack([jnp.broadcast_to(part, grid.shape) for part in densities], axis=1)[:, None, :]
    responses = closed_by_frequency(plant, gain, places, *entries)[:, rows]
    size = jnp.real(responses) ** 2 + jnp.imag(responses) ** 2
    spectra = jnp.where(density <= 0, 0.0, size * density)
    if steps is None:
        parts = jnp.diff(grid)[:, None, None] * (spectra[1:] + spectra[:-1]) / 2
        below = jnp.concatenate([jnp.zeros_like(spectra[:1]), jnp.cumsum(parts, axis=0)])
    else:
        below = areas(spectra * steps[0][:, None, None], steps[1])
    variances = below[-1] if noise_system is None else _white(noise_system, density[0, 0])[rows]
    return spectra, below, jnp.where(settles, variances, jnp.inf)


def _white(noise_system: EnergyForm, densities: Float[Array, "n_s"]) -> Float[Array, "n_y n_s"]:
    """Variances under white noise of one-sided densities, by the covariance of the states."""
    b = noise_system.B.T[:, :, None]
    covariance = lyapunov(noise_system.A, b * b.swapaxes(1, 2))
    variances = jnp.einsum("yi,sij,yj->ys", noise_system.C, covariance, noise_system.C)
    # A two-sided density is half the one-sided one.
    bounded = jnp.maximum(variances, 0.0) * densities / 2
    unbounded = (noise_system.rough | (noise_system.D != 0)) & (densities > 0)
    return jnp.where(unbounded, jnp.inf, bounded)
