"""Noise of an output over frequency by its sources, and the cumulative sum."""

from typing import Any

import numpy as np

from ..control.noise import NoiseBudget
from ..display import kind_of


def noise(found: NoiseBudget, output: str | None = None) -> Any:
    """Draw the noise density of an output, source by source, and its cumulative root mean square.

    Args:
        found: NoiseBudget from :func:`flexmb.control.noise_budget`.
        output: Name of the output; optional if there is only one.

    Returns:
        matplotlib Figure: roots of the power spectral densities, and below them the root mean square up to each
        frequency, both over frequency in hertz.

    Raises:
        TypeError: ``found`` is no NoiseBudget.
        KeyError: The output does not exist, or there are several and none is named.

    Source:
        THEORY.md 14, eq. (14.33).
    """
    import matplotlib.pyplot as plt

    if not isinstance(found, NoiseBudget):
        raise TypeError(f"A picture of noise needs a NoiseBudget, not {kind_of(found)}.")
    total = np.asarray(found.cumulative(output))
    hertz = np.asarray(found.hertz)
    # Zero has no place on a logarithmic axis.
    positive = hertz > 0
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(6.4, 5.6), layout="constrained")
    several = len(found.sources) > 1
    for source in found.sources:
        density = np.sqrt(np.asarray(found.spectrum(output, source)))
        upper.loglog(hertz[positive], density[positive], label=source, lw=1)
        if several:
            lower.semilogx(hertz[positive], np.asarray(found.cumulative(output, source))[positive], lw=1)
    if several:
        every = np.sqrt(np.asarray(found.spectrum(output)))
        upper.loglog(hertz[positive], every[positive], "k", lw=1.5, label="all", zorder=0)
    lower.semilogx(hertz[positive], total[positive], "k", lw=1.5)
    name = found.outputs[0] if output is None else output
    upper.set_title(f"{name}: rms {float(found.rms(output)):.4g}", fontsize=10)
    upper.set_ylabel("density [unit/√Hz]")
    lower.set(ylabel="cumulative rms", xlabel="frequency [Hz]")
    upper.legend(fontsize=8)
    for ax in (upper, lower):
        ax.grid(visible=True, which="major", alpha=0.3)
    return figure
