"""Profile likelihood of a fitted parameter, with its confidence interval."""

from typing import Any

import numpy as np

from ..display import kind_of
from ..identification.fitted import ProfileLikelihood
from .canvas import BLACK, BLUE, GREY, plain_axes


def profile(found: ProfileLikelihood, *, ax: Any = None) -> Any:
    """Draw the growth of chi-squared over the values of a parameter, and its confidence interval.

    A dashed line shows the growth by the linearised model, whose interval is symmetric. If both curves differ, use the
    interval of the profile.

    Args:
        found: Result of ``fitted.profile("name")``.
        ax: matplotlib Axes to draw in; by default new Axes.

    Returns:
        matplotlib Axes.

    Raises:
        TypeError: ``found`` is no profile likelihood.
    """
    if not isinstance(found, ProfileLikelihood):
        raise TypeError(f"A picture of a profile needs the result of fitted.profile(..), not {kind_of(found)}.")
    ax = plain_axes(ax)
    order = np.argsort(found.values)
    values, growth, linear = (np.asarray(one)[order] for one in (found.values, found.growth, found.linear))
    # An end at a bound is infinite.
    ends = np.clip(found.interval, values[0], values[-1])
    ax.axvspan(*ends, color=BLUE, alpha=0.15, label=f"{found.level:.0%} interval")
    ax.axhline(found.threshold, color=GREY, linewidth=1)
    ax.plot(values, growth, color=BLUE, marker=".", label="profile")
    ax.plot(values, linear, "--", color=BLACK, linewidth=1, label="linearised")
    ax.set(xlabel=f"{found.name} [SI]", ylabel="growth of chi-squared [-]")
    ax.set_ylim(bottom=0.0)
    ax.grid(visible=True, alpha=0.3)
    ax.legend(fontsize=8)
    return ax
