"""The picture of an answer of the command line."""

import io
from collections.abc import Callable
from typing import Any

import numpy as np

from ..checks.mobility import Mobility
from ..design.sweep import Sweep
from ..design.tune import Tuned
from ..motion.motion import Motion
from ..paths.path import Path
from .bode import bode
from .canvas import grid
from .history import history
from .mechanism import mechanism
from .modes import modes
from .path import path
from .self_stress import self_stress
from .sweep import sweep
from .tuning import tuning

STATE_SPACE = 9
# The same file for the same answer: no date in it, no random names.
CONSTANT: Any = {"backend": "agg", "svg.hashsalt": "flexmb"}


def image(answer: Any, mode: int, format: str) -> bytes:
    """Draw an answer: modes, path, history, self-stress or Bode plot; the mechanism where the analysis has no other.

    Args:
        answer: Answer of :func:`flexmb.answers.answers.answer`.
        mode: Number of the analysis mode.
        format: "png" or "svg".

    Returns:
        Content of the file.
    """
    return _content(lambda: _figure(answer, mode), format)


def study_image(found: Sweep | Tuned, format: str) -> bytes:
    """Draw a design study: every answer of a sweep that is one number, or the run of a search.

    Args:
        found: Of ``fm.sweep`` or ``fm.tune``.
        format: "png" or "svg".

    Returns:
        Content of the file.
    """
    return _content(lambda: tuning(found) if isinstance(found, Tuned) else _sweeps(found), format)


def _sweeps(found: Sweep) -> Any:
    figure, axes = grid(max(sum(v.ndim == 1 for v in found.answers.values()), 1), 2)
    for name, ax in zip([n for n, v in found.answers.items() if v.ndim == 1], axes, strict=False):
        sweep(found, name, ax=ax)
    return figure


def _content(draw: Callable[[], Any], format: str) -> bytes:
    """Content of a file with the figure that a function draws."""
    import matplotlib

    with matplotlib.rc_context(CONSTANT):
        import matplotlib.pyplot as plt

        figure = draw()
        buffer = io.BytesIO()
        figure.savefig(buffer, format=format, dpi=150, metadata={"Date": None} if format == "svg" else None)
        plt.close(figure)
    return buffer.getvalue()


def _figure(answer: Any, mode: int) -> Any:
    found = answer.found
    if mode == STATE_SPACE and answer.lin is not None and _has_signals(answer):
        return bode(answer.lin)
    if isinstance(found, Path):
        return _pair(lambda ax: path(found, ax=ax), lambda ax: mechanism(found, ax=ax), found.labels.dimension)
    if isinstance(found, Motion):
        return _pair(lambda ax: history(found, ax=ax), lambda ax: mechanism(found, ax=ax), found.labels.dimension)
    if isinstance(found, Mobility):
        return (self_stress(found) if found.overconstraints else mechanism(found.model, names=True)).figure
    if found is not None and found.shapes.shape[1]:
        return modes(found)
    return mechanism(answer.model if answer.lin is None else answer.lin, names=True).figure


def _has_signals(answer: Any) -> bool:
    """Whether some input moves some output."""
    data = answer.data
    return bool(np.any(data.get("B", 0)) and np.any(data.get("C", 0)))


def _pair(left: Any, right: Any, dimension: int) -> Any:
    """A curve, and beside it where the mechanism ends."""
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(10, 4.5), layout="constrained")
    left(figure.add_subplot(1, 2, 1))
    right(figure.add_subplot(1, 2, 2, projection="3d" if dimension == 3 else None))
    return figure
