"""Complex responses to harmonic inputs, by frequency, output and input, with derivatives."""

import csv
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from ..arguments import check_choice, check_numbers, is_concrete, short_repr, undifferentiated
from ..compilation.compile import unguarded
from ..compilation.record import Record, static
from ..display import Column, Labelled, Quantities, Summary, listed, short, span
from ..errors import ModelError, printable, warn
from ..linear.about import Where, asked_about
from ..linear.damping import Losses, loss_factors
from ..linear.linearize import Linearization, ManyStates
from ..linear.loose import refuse_negative_mass
from ..linear.modes import check_spectrum, refuse_unsymmetric
from ..math.linear_solver import LinearSolver
from ..model.model import Model, Port
from ..results import RESULTS, collect, or_nan
from ..statics.equilibrium import Equilibrium
from ..statics.solver_choice import asked_solver
from ..statics.stable import is_unstable, unstable_motions
from .harmonic import forms_with_losses, plain_arrays, response_by_elements, response_by_freedoms
from .second_order_form import orders_of, second_order
from .state_space import refuse_idle_inputs
from .universal_file import read_responses, write_responses


class FrequencyResponse(Labelled, Record):
    """Complex response of outputs to harmonic inputs: y = H(i 2 pi f) u.

    Attributes:
        hertz: Frequencies, (n_f,) [Hz].
        response: H, (n_f, n_y, n_u) [unit of the output / unit of the input].
        outputs: Names of the outputs.
        inputs: Names of the inputs.
        output_ports, input_ports: Node, axis, quantity and unit of each output and input; empty if unknown.
    """

    hertz: Float[Array, "n_f"]
    response: Complex[Array, "n_f n_y n_u"]
    outputs: tuple[str, ...] = static()
    inputs: tuple[str, ...] = static()
    output_ports: tuple[Port, ...] = static(default=())
    input_ports: tuple[Port, ...] = static(default=())
    one_axis = "hertz"

    def of(self, output: str | None = None, input: str | None = None) -> Complex[Array, "n_f"]:
        """Return the response of one output to one input, (n_f,) [unit of the output / unit of the input].

        Args:
            output: Name of the output; optional if there is only one.
            input: Name of the input; optional if there is only one.

        Raises:
            KeyError: The output or the input is unknown, or there are several and none is named.
        """
        i, j = place_of_name("output", self.outputs, output), place_of_name("input", self.inputs, input)
        return self.response[..., i, j]

    def magnitude(self, output: str | None = None, input: str | None = None) -> Float[Array, "n_f"]:
        """Return the amplitude of one output per unit of one input, (n_f,) [unit of the output / unit of the input].

        Args:
            output, input: As for :meth:`of`.
        """
        return jnp.abs(self.of(output, input))

    def phase(self, output: str | None = None, input: str | None = None) -> Float[Array, "n_f"]:
        """Return the phase lead of one output over one input, (n_f,) [rad]; continuous from the first frequency on.

        Args:
            output, input: As for :meth:`of`.
        """
        return jnp.unwrap(jnp.angle(self.of(output, input)))

    def quantities_by_name(self) -> Quantities:
        """Return the complex response by frequency, output and input."""
        over = ("frequency", "output", "input")
        names = {"output": self.outputs, "input": self.inputs}
        along = {"frequency": Column(("frequency",), self.hertz, "Hz")}
        along |= {name: Column((name,), np.array(signal_names)) for name, signal_names in names.items()}
        return Quantities(over[:1], along, {"response": Column(over, self.response, self._units())})

    def _units(self) -> Any:
        """Unit of each response, (n_y, n_u); empty where one of its signals has no known unit."""
        if not (self.output_ports and self.input_ports):
            return ""
        pairs = [[(y.unit, u.unit) for u in self.input_ports] for y in self.output_ports]
        return np.array([[ratio(*pair) if all(pair) else "" for pair in row] for row in pairs])

    def save(self, path: str | os.PathLike) -> None:
        """Write the responses to a file, in SI units.

        A universal file has a data set 58 for each response. A CSV file has the columns "hertz", "real" and
        "imaginary", as ``flexmb fit`` reads them; with several responses "real OUTPUT by INPUT" and so on.

        Args:
            path: Path of the file; it ends in .uff, .unv or .csv.

        Raises:
            ImportError: pyuff is not installed, which universal files need.
            ValueError: The path has another ending, there are fewer than two frequencies, or a response is not finite.
            OSError: The folder is missing or not writable.

        Warns:
            FlexmbWarning: The format rounds the frequencies, to six digits.
        """
        if Path(path).suffix == ".csv":
            return self._write_columns(path)
        write_responses(self, path)

    def _write_columns(self, path: str | os.PathLike) -> None:
        names, columns = ["hertz"], [np.asarray(self.hertz)]
        values: Any = np.asarray(self.response)
        if not np.all(np.isfinite(values)):
            raise ValueError("A file contains only finite numbers, but a response is not finite: damp the resonance.")
        for i, output in enumerate(self.outputs):
            for j, source in enumerate(self.inputs):
                pair = f" {output} by {source}" if values[0].size > 1 else ""
                names += [f"real{pair}", f"imaginary{pair}"]
                columns += [values[:, i, j].real, values[:, i, j].imag]
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([names, *np.column_stack(columns).tolist()])

    @staticmethod
    def load(path: str | os.PathLike) -> "FrequencyResponse":
        """Read frequency responses from a universal file (data sets 58), in SI units; they may be measured.

        A file without a system of units (data set 164) is in SI units.

        Args:
            path: Path of the file.

        Raises:
            ImportError: pyuff is not installed.
            ValueError: The file has no frequency response, its responses differ in frequencies, or a pair of output and
                input is missing.
            OSError: The file cannot be read.
        """
        hertz, response, *names_and_ports = read_responses(path)
        return FrequencyResponse(jnp.asarray(hertz), jnp.asarray(response), *names_and_ports)

    def summary(self) -> Summary:
        """Return frequencies and names, and the frequency at which each response is largest."""
        hertz, sizes = np.asarray(self.hertz), np.abs(np.asarray(self.response))
        rows = {"frequencies": f"{len(hertz)}, {span(hertz, 'Hz')}"}
        rows |= {"outputs": listed(self.outputs), "inputs": listed(self.inputs)}
        for j, source in enumerate(self.inputs):
            for i, output in enumerate(self.outputs):
                most = int(np.argmax(sizes[:, i, j]))
                if sizes[most, i, j] > 0:
                    text = f"at most {short(sizes[most, i, j])}, at {short(hertz[most])} Hz"
                    rows[f"{output} by {source}"] = text
        title = f"FrequencyResponse: {len(self.outputs)} x {len(self.inputs)} at {len(hertz)} frequencies"
        return Summary(title, rows, "bode", {} if len(self.outputs) * len(self.inputs) == 1 else None)


def ratio(unit: str, of: str) -> str:
    """Unit of a quotient."""
    per = f"({of})" if set(" /") & set(of) else of
    return "1" if unit == of else f"{unit}/{per}"


def place_of_name(kind: str, known: Sequence[str], name: str | None) -> int:
    """Place of a name, None if there is only one; a blank matches a dot, as in python-control."""
    if name is None and len(known) == 1:
        return 0
    if isinstance(name, str):
        for i, existing in enumerate(known):
            if name in (existing, existing.replace(".", " ")):
                return i
    asked = "Choose one" if name is None else f"There is no {kind} '{printable(name)}'"
    raise KeyError(f"{asked}: the {kind}s are {', '.join(known)}.")


def places_of_names(kind: str, known: Sequence[str], wanted: Sequence[str] | str | None) -> list[int]:
    """Places of the wanted names, in their order; by default all."""
    if not known:
        raise ModelError(f"A response needs an {kind}. Name it with {kind}() of the builder.")
    if wanted is None:
        return list(range(len(known)))
    if not isinstance(wanted, Iterable):
        raise TypeError(f"Argument `{kind}s` must be a name or a list of names, not {short_repr(wanted)}.")
    places = [place_of_name(kind, known, name) for name in ([wanted] if isinstance(wanted, str) else wanted)]
    if not places or len(set(places)) < len(places):
        raise ValueError(f"Argument `{kind}s` must name {kind}s, each once. There are: {', '.join(known)}.")
    return places


def check_hertz(hertz: Any) -> Float[Array, "n_f"]:
    """Frequencies as an array; ValueError if they are not finite, negative, or have more than one axis."""
    check_numbers("Argument `hertz`", hertz)
    if np.ndim(hertz) > 1:
        raise ValueError(f"Argument `hertz` must be frequencies, (n_f,), but has shape {np.shape(hertz)}.")
    if is_concrete(hertz) and np.any(np.asarray(hertz) < 0):
        raise ValueError(f"Argument `hertz` cannot be negative, but is at least {np.min(np.asarray(hertz)):g}.")
    return np.atleast_1d(np.asarray(hertz, float)) if is_concrete(hertz) else jnp.atleast_1d(hertz)  # type: ignore


@unguarded
def frequency_response(
    model: Model | Linearization,
    hertz: Float[Array, "n_f"] | Sequence[float] | float,
    *,
    inputs: Sequence[str] | str | None = None,
    outputs: Sequence[str] | str | None = None,
    loss_factor: Losses | None = None,
    method: str | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> FrequencyResponse:
    """Return the response of the outputs to harmonic inputs; thousands of frequencies take one call.

    The response includes the damping of the elements or of :func:`flexmb.damped`, and structural damping. Only a
    response by frequency can include structural damping exactly. Motions without mass follow the inputs directly, with
    their damping. About a state of motion, flexmb keeps the matrices of this state constant.

    Args:
        model: Mechanism, or its linearisation; differentiable in its parameters, also for repeated frequencies.
        hertz: Frequencies, (n_f,) [Hz]; differentiable.
        inputs, outputs: Names of the wanted inputs and outputs; all by default.
        loss_factor: Structural damping K0 (1 + i eta), at all frequencies including 0 Hz: one loss factor eta [-] for
            all elements, or by name or Material, as in :func:`flexmb.damped`.
        method: "modes" sums over all undamped modes. More frequencies then cost almost nothing, unless damping couples
            the modes and their amplitudes must be solved for. "direct" solves for the degrees of freedom at each
            frequency. Both are exact but for round-off. "direct" keeps more digits if the contributions of many modes
            cancel, such as in the internal stress due to an internal actuator far below the resonances. The default is
            "direct" without real modes (unsymmetric stiffness, state of motion, sparse matrices), otherwise "modes".
        sparse: Solve with sparse matrices at each frequency, in all coordinates of a model that needs no degrees of
            freedom; see :func:`flexmb.equilibrium`. By default chosen by size.
        solver: "sparse" or "dense" matrices, in place of ``sparse``. Or a LinearSolver: it computes the static
            solution, and sparse factors compute the complex solutions.
        at, step, time, increment: State, as for :func:`flexmb.frequencies`.

    Returns:
        FrequencyResponse with the complex response (n_f, n_y, n_u) [SI]. It is infinite at an undamped resonance, such
            as the resonance of a free body at 0 Hz.

    Raises:
        KeyError: An input or output is unknown.
        ModelError: The model names no inputs or no outputs, or an input moves nothing.
        ValueError: A frequency is negative or not finite; an element with a loss factor has no stiffness.
        NotImplementedError: ``method="modes"`` for an unsymmetric stiffness or a motion.
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness or has a negative mass.

    Warns:
        FlexmbWarning: A response is infinite, or the equilibrium is not stable.

    Source:
        THEORY.md 14, eq. (14.30) and (14.31); derivative (14.32); sparse matrices 7, eq. (7.15) and (7.18).
    """
    check_choice("method", method, (None, "modes", "direct"))
    frequencies = check_hertz(hertz)
    where = Where(at, step, time, increment)
    lin = asked_about(model, "frequency_response", where, asked_solver(sparse, solver), few=method != "modes")
    answer = response_of(lin, frequencies, inputs, outputs, loss_factor, method)
    if is_concrete((lin, answer)):
        _warn_infinite(answer)
        m = lin.matrices
        if lin.large:
            unstable = is_unstable(jax.tree.map(np.asarray, lin.elements), m.symmetric)
        else:
            unstable = m.moving is None and unstable_motions(m.K0 + m.G0, m.K0, m.symmetric).shape[1] > 0
        if unstable:
            collect(RESULTS.unstable_state)
            warn(
                "The equilibrium is not stable: it has a negative frequency. The response is the transfer function of"
                " this state. It can be measured only while a controller stabilises the mechanism. Lower the load, or"
                " use a stable state of fm.path."
            )
    return answer


def response_of(
    lin: Linearization, hertz: Float[Array, "n_f"], inputs: Any, outputs: Any, losses: Any, method: str | None
) -> FrequencyResponse:
    """:func:`frequency_response` of a linearisation, without warnings."""
    m, labels = lin.matrices, lin.labels
    us = tuple(places_of_names("input", [s.name for s in labels.inputs], inputs))
    ys = tuple(places_of_names("output", [s.name for s in labels.outputs], outputs))
    rests = m.symmetric and m.moving is None
    if method == "modes":
        if lin.large:
            raise NotImplementedError('Sparse matrices give no sum over all modes. Leave out method="modes".')
        refuse_unsymmetric(m.symmetric)
        if not rests:
            raise NotImplementedError('About a state of motion there are no real modes. Leave out method="modes".')
    form = None
    if not lin.large:
        form = second_order(lin)
        refuse_negative_mass(lin)
        known = undifferentiated((lin, form))
        if is_concrete(known):
            refuse_idle_inputs(*known)
    orders, _ = orders_of(lin.model.signals()[0])
    rates = [labels.inputs[j].name for j in us if orders[j]]
    if rates and is_concrete(hertz) and np.any(np.asarray(hertz) == 0):
        raise ValueError(
            f"Argument `hertz`: at 0 Hz there is no response to '{rates[0]}', a constant velocity or acceleration."
            " Leave that frequency out."
        )
    losses = None if losses is None else loss_factors(lin, losses)
    if form is None:
        responses = jax.device_put(response_by_elements(lin, hertz, us, ys, losses))
    else:
        form, orders = plain_arrays(form)
        lossy = None if losses is None else forms_with_losses(lin, losses)
        by_modes = method != "direct" and rests
        responses, result = response_by_freedoms(form, lossy, hertz, us=us, ys=ys, orders=orders, by_modes=by_modes)
        check_spectrum(result, True, lin)
        responses = or_nan(responses, result)
    outputs, inputs = [labels.outputs[i] for i in ys], [labels.inputs[j] for j in us]
    return FrequencyResponse(
        hertz,
        responses,
        tuple(signal.name for signal in outputs),
        tuple(signal.name for signal in inputs),
        tuple(signal.port(labels) for signal in outputs),
        tuple(signal.port(labels) for signal in inputs),
    )


def _warn_infinite(result: FrequencyResponse) -> None:
    """Warn of infinite responses, by the first."""
    infinite = np.argwhere(~np.isfinite(np.asarray(result.response)))
    if len(infinite):
        f, i, j = infinite[0]
        hertz = float(result.hertz[f])
        remedy = "Damp it (fm.damped, or `loss_factor`) or leave that frequency out."
        if hertz == 0:
            remedy = "A motion has no stiffness. Support it, or leave 0 Hz out."
        warn(
            f"The response of '{result.outputs[i]}' to '{result.inputs[j]}' is infinite at {hertz:.6g} Hz, an undamped"
            f" resonance. {remedy}"
        )
