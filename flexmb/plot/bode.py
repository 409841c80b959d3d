"""Frequency response: magnitude and phase of each output per unit of each input."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg

from ..control.frequency_response import FrequencyResponse
from ..control.state_space import to_statespace
from ..display import kind_of
from ..linear.linearize import Linearization
from ..model.model import Model
from ..numerical_limits import NEGLIGIBLE, PHASE_OF_MINUS_180
from .canvas import BLUE

# Responses are taken at s = (i + DECAY) omega, so that phases of an undamped mechanism turn at its poles.
DECAY = 1e-6
# A frequency is inserted where a phase turns by more than this between two, in so many rounds.
TURN = np.radians(20.0)
# Models are drawn up to this many times the lowest pole by default: stiff poles may be far away.
FARTHEST = 1e4
ROUNDS = 6
# Ticks of the phase are multiples of one of these [degrees]. There are at most TICKS.
PHASES = (15, 30, 45, 90, 180, 360, 720)
TICKS = 6
WIDTH, HEIGHT = 4.3, 3.5
# Letters of a title in one line.
LONGEST = 44


def bode(
    found: Any,
    outputs: Sequence[str] | str | None = None,
    inputs: Sequence[str] | str | None = None,
    *,
    hertz: Any = None,
) -> Any:
    """Draw a Bode plot of the linearised mechanism, one pair of panels for each input and output.

    Phases begin between -180 and 180 degrees at the lowest frequency and have no jumps of 360 degrees after it. The
    phase of an undamped mechanism is the phase for very small damping. The picture names outputs without a response.

    Args:
        found: Model or Linearization with inputs and outputs, such as ``fm.damped(model, ratio=0.01)``, or a
            control.StateSpace; or the FrequencyResponse of :func:`flexmb.frequency_response`, drawn at its own
            frequencies, without 0 Hz and without frequencies of infinite response.
        outputs: Names of outputs of the state-space model; by default all outputs with a response.
        inputs: Names of inputs of the state-space model; by default all inputs with an effect.
        hertz: Frequencies, (n,) [Hz]. flexmb adds frequencies between them where a phase changes quickly. Default: from
            a tenth of the lowest pole to ten times the highest. Poles far above the lowest pole of a model are outside
            the picture; a note states that they exist.

    Returns:
        matplotlib Figure: magnitude and phase over frequency in hertz.

    Raises:
        TypeError: ``found`` has another type.
        ValueError: An output or input does not exist, no output responds, frequencies are not positive or are given in
            addition to a FrequencyResponse, or the state space is sampled.
        ModelError: The model names no inputs or no outputs.

    Source:
        C (i omega - A)^-1 B + D, by the complex Schur form of the balanced A: G. H. Golub and C. F. Van Loan, Matrix
        Computations, 7.
    """
    if isinstance(found, FrequencyResponse):
        if hertz is not None:
            raise ValueError("A FrequencyResponse has its frequencies: leave `hertz` out.")
        names = [[name.replace(".", " ") for name in known] for known in (found.outputs, found.inputs)]
        rows, columns = _chosen("output", names[0], outputs), _chosen("input", names[1], inputs)
        above = (np.asarray(found.hertz) > 0) & np.all(np.isfinite(np.asarray(found.response)), axis=(1, 2))
        frequencies, beyond = np.asarray(found.hertz)[above], 0
        order = np.argsort(frequencies)
        frequencies, responses = frequencies[order], np.asarray(found.response)[above][order]
        if len(frequencies) < 2:
            raise ValueError("A Bode plot needs finite responses at two frequencies above zero or more.")
        responses = responses[:, rows][:, :, columns]
        largest = np.max(np.abs(responses), axis=0)
        moved = largest > NEGLIGIBLE * np.max(largest, axis=0)
    else:
        system, farthest = _system(found)
        names = [system.output_labels, system.input_labels]
        rows, columns = _chosen("output", names[0], outputs), _chosen("input", names[1], inputs)
        system = system[rows, columns]
        triangular = _triangular(system)
        if hertz is None:
            frequencies, beyond = _around_poles(np.diag(triangular[0]), farthest)
        else:
            frequencies, beyond = np.unique(np.asarray(hertz, float)), 0
        if not len(frequencies) or not np.all(np.isfinite(frequencies) & (frequencies > 0)):
            raise ValueError("Argument `hertz` must be frequencies above zero.")
        frequencies, responses, moved = _responses(*triangular, system.D, frequencies)
    if not np.any(moved):
        raise ValueError("No output responds to the inputs: there is nothing to draw.")
    # Signals that were not asked for by name get no panel if they do not respond or have no effect.
    ys = [i for i in range(len(rows)) if outputs is not None or np.any(moved[i])]
    us = [j for j in range(len(columns)) if inputs is not None or np.any(moved[:, j])]
    names = [[names[0][i] for i in rows], [names[1][j] for j in columns]]
    figure = _drawn(frequencies, responses, moved, (ys, us), names)
    notes = []
    for effect, indices, every in zip(("no response", "without effect"), (ys, us), names, strict=True):
        if left_out := [name for i, name in enumerate(every) if i not in indices]:
            notes.append(f"{effect}: {', '.join(left_out)}")
    if beyond:
        notes.append(f"{beyond} poles are outside the picture: give hertz= to see them")
    if notes:
        figure.supxlabel(textwrap.fill("; ".join(notes), int(13 * figure.get_figwidth())), fontsize=8)
    return figure


def _system(source: Any) -> tuple[Any, float]:
    """The state-space model to draw, and the multiple of its lowest pole up to which it is drawn."""
    import control

    if isinstance(source, Model | Linearization):
        return to_statespace(source), FARTHEST
    if not isinstance(source, control.StateSpace):
        known = "a Model, a Linearization, a FrequencyResponse or a control.StateSpace"
        raise TypeError(f"A Bode plot needs {known}, not {kind_of(source)}.")
    if source.isdtime(strict=True):
        raise ValueError(f"A Bode plot needs a continuous system, not one sampled every {source.dt} s.")
    return source, np.inf


def _triangular(system: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and C of a state-space model in the basis that makes A triangular, with its poles on the diagonal."""
    balanced, (scale, _) = scipy.linalg.matrix_balance(system.A, permute=False, separate=True)
    triangular, basis, *_ = scipy.linalg.schur(balanced, output="complex")
    return triangular, basis.conj().T @ (system.B / scale[:, None]), (system.C * scale) @ basis


def _responses(
    triangular: np.ndarray, right: np.ndarray, left: np.ndarray, through: np.ndarray, frequencies: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies with inserted ones, responses, (n, outputs, inputs), and which responses are not round-off."""

    def at(hertz: np.ndarray) -> np.ndarray:
        """Responses by back substitution, at all frequencies at once."""
        s = (1j + DECAY) * 2 * np.pi * hertz
        moved = np.zeros((len(right), len(s), right.shape[1]), complex)
        for i in reversed(range(len(right))):
            of_others = np.tensordot(triangular[i, i + 1 :], moved[i + 1 :], 1)
            moved[i] = (right[i] + of_others) / (s - triangular[i, i])[:, None]
        return np.tensordot(left, moved, 1).swapaxes(0, 1) + through

    responses = at(frequencies)
    largest = np.max(np.abs(responses), axis=0)
    moved = largest > NEGLIGIBLE * np.max(largest, axis=0)
    for _ in range(ROUNDS):
        turns = np.abs(np.angle(responses[1:] * np.conj(responses[:-1]))) * moved
        gaps = np.flatnonzero(np.max(turns, axis=(1, 2), initial=0.0) > TURN)
        if not len(gaps):
            break
        more = np.sqrt(frequencies[gaps] * frequencies[gaps + 1])
        responses = np.insert(responses, gaps + 1, at(more), axis=0)
        frequencies = np.insert(frequencies, gaps + 1, more)
    return frequencies, responses, moved


def _drawn(frequencies: np.ndarray, responses: np.ndarray, moved: np.ndarray, chosen: Any, names: Any) -> Any:
    """The figure with the chosen outputs and inputs."""
    import matplotlib.pyplot as plt

    (ys, us), (outputs, inputs) = chosen, names
    size = max(WIDTH * len(us), 1.3 * WIDTH), HEIGHT * len(ys)
    figure = plt.figure(figsize=size, layout="constrained")
    places = figure.add_gridspec(len(ys), len(us))
    for row, i in enumerate(ys):
        for column, j in enumerate(us):
            place, title = places[row, column], f"{inputs[j]} → {outputs[i]}"
            if len(title) > LONGEST:
                title = title.replace(" → ", " →\n")
            if not moved[i, j]:
                ax = figure.add_subplot(place)
                ax.axis("off")
                text = textwrap.fill(f"{outputs[i]} does not respond to {inputs[j]}", 30)
                ax.text(0.5, 0.5, text, ha="center", va="center", transform=ax.transAxes)
                continue
            # Labels that neighbouring panels share stand once.
            upper, lower = (figure.add_subplot(part) for part in place.subgridspec(2, 1, height_ratios=(3, 2)))
            _panels(upper, lower, frequencies, responses[:, i, j])
            upper.set_title(title, fontsize=10)
            if not np.any(moved[i, us[:column]]):
                upper.set_ylabel("magnitude")
                lower.set_ylabel("phase [°]")
            if not np.any(moved[ys[row + 1 :], j]):
                lower.set_xlabel("frequency [Hz]")
    return figure


def _panels(upper: Any, lower: Any, frequencies: np.ndarray, response: np.ndarray) -> None:
    from matplotlib.ticker import LogLocator, MultipleLocator, NullFormatter

    phase = np.degrees(np.unwrap(np.angle(response)))
    # Of a mass without support the phase is -180 rather than 180 degrees.
    if phase[0] > 180 - PHASE_OF_MINUS_180:
        phase = phase - 360
    upper.loglog(frequencies, np.abs(response), color=BLUE)
    lower.semilogx(frequencies, phase, color=BLUE)
    upper.sharex(lower)
    upper.tick_params(labelbottom=False)
    for axis in (upper.yaxis, lower.xaxis, upper.xaxis):
        axis.set_major_locator(LogLocator(numticks=TICKS))
        axis.set_minor_formatter(NullFormatter())
    low, high = np.min(phase), np.max(phase)
    step = next((step for step in PHASES if high - low <= step * (TICKS - 2)), PHASES[-1])
    lower.yaxis.set_major_locator(MultipleLocator(step))
    margin = max(0.08 * (high - low), step / 3)
    lower.set_ylim(low - margin, high + margin)
    for ax in (upper, lower):
        ax.grid(visible=True, which="major", alpha=0.3)
        ax.set_xlim(frequencies[0], frequencies[-1])


def _around_poles(poles: np.ndarray, farthest: float) -> tuple[np.ndarray, int]:
    """Frequencies around the poles, dense beside each of them [Hz], and the number of poles too far away.

    python-control needs the zeros too, which it does not find for several outputs.
    """
    poles = np.abs(poles[np.imag(poles) >= 0]) / (2 * np.pi)
    poles = poles[poles > NEGLIGIBLE * np.max(poles, initial=0.0)]
    every = poles if poles.size else np.ones(1)
    poles = every[every <= farthest / 10 * np.min(every)]
    ends = np.log10(np.min(poles)) - 1, np.log10(np.max(poles)) + 1
    beside = 10 ** np.concatenate([-np.logspace(-5, -1, 20), np.logspace(-5, -1, 20)])
    hertz = np.concatenate([np.logspace(*ends, 400), np.outer(poles, beside).ravel()])
    return np.unique(hertz), len(every) - len(poles)


def _chosen(kind: str, known: Sequence[str], requested: Sequence[str] | str | None) -> list[int]:
    if requested is None:
        return list(range(len(known)))
    # python-control has a blank where a name has a dot.
    names = [name.replace(".", " ") for name in ([requested] if isinstance(requested, str) else requested)]
    if wrong := [name for name in names if name not in known]:
        raise ValueError(f"There is no {kind} '{wrong[0]}'. There is: {', '.join(known)}.")
    return [list(known).index(name) for name in names]
