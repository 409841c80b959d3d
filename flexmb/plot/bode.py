"""Frequency response, by python-control."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..control.state_space import to_statespace
from ..linear.linearize import Linearization
from ..model.model import Model


def bode(
    found: Any,
    outputs: Sequence[str] | str | None = None,
    inputs: Sequence[str] | str | None = None,
    *,
    hertz: Any = None,
) -> Any:
    """Bode plot of the linearised mechanism.

    Args:
        found: Model or Linearization with inputs and outputs, or a control.StateSpace.
        outputs: Names of outputs as the state-space model has them; those that respond unless given.
        inputs: Names of inputs likewise; all unless given.
        hertz: Frequencies, (n,) [Hz]; from a tenth of the lowest pole to ten times the highest unless given.

    Returns:
        matplotlib Figure: magnitude and phase over frequency in hertz.

    Raises:
        TypeError: ``found`` is none of these.
        ValueError: No such output or input, or no output responds.
        ModelError: The model names no inputs or no outputs.

    Source:
        C (i omega - A)^-1 B + D, by control.bode_plot.
    """
    import control

    if isinstance(found, Model | Linearization):
        found = to_statespace(found)
    if not isinstance(found, control.StateSpace):
        raise TypeError(
            f"A Bode plot is drawn of a Model, a Linearization or a control.StateSpace, not of a"
            f" {type(found).__name__}."
        )
    rows = _chosen("output", found.output_labels, outputs)
    columns = _chosen("input", found.input_labels, inputs)
    if outputs is None:
        rows = [row for row in rows if _responds(found, row, columns)]
    if not rows:
        raise ValueError("No output responds to the inputs: there is nothing to draw.")
    import matplotlib.pyplot as plt

    omega = _around_poles(found) if hertz is None else 2 * np.pi * np.asarray(hertz, float)
    # python-control draws in the current figure where that is empty.
    plt.figure(figsize=(4.8 * len(columns), 3.0 * len(rows) + 1.5))
    return control.bode_plot(found[rows, columns], omega, Hz=True, title="Frequency response").figure


def _around_poles(system: Any) -> np.ndarray:
    """Frequencies around the poles, closer beside each of them, [rad/s].

    python-control asks for the zeros too, which it does not know of several outputs.
    """
    poles = np.abs(np.linalg.eigvals(system.A))
    poles = poles[poles > 1e-9 * np.max(poles, initial=0.0)] if poles.size else np.ones(1)
    ends = np.log10(np.min(poles)) - 1, np.log10(np.max(poles)) + 1
    beside = 10 ** np.concatenate([-np.logspace(-5, -1, 40), np.logspace(-5, -1, 40)])
    return np.unique(np.concatenate([np.logspace(*ends, 400), np.outer(poles, beside).ravel()]))


def _chosen(kind: str, known: Sequence[str], wanted: Sequence[str] | str | None) -> list[int]:
    if wanted is None:
        return list(range(len(known)))
    # python-control has a blank where a name has a dot.
    names = [name.replace(".", " ") for name in ([wanted] if isinstance(wanted, str) else wanted)]
    if wrong := [name for name in names if name not in known]:
        raise ValueError(f"There is no {kind} '{wrong[0]}'. There is: {', '.join(known)}.")
    return [list(known).index(name) for name in names]


def _responds(system: Any, row: int, columns: list[int]) -> bool:
    """Whether an output is moved by an input, beyond round-off."""
    probe = 1.7j * max(1.0, float(np.max(np.abs(np.linalg.eigvals(system.A)), initial=1.0)))
    size = np.abs(np.atleast_2d(system(probe)))[:, columns]
    return bool(np.max(size[row]) > 1e-9 * np.max(size))
