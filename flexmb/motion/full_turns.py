"""Warn when a measured rotation in space passes a full turn. The measured angle jumps by 2 pi there."""

from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..display import among
from ..errors import warn
from ..math.rigid import compose_turns
from ..math.rotation import CONJUGATE
from ..mechanics.signals import terms_of
from ..model.model import Signal
from .motion import Motion

# A jump is two turns; the rest is left to errors of the trapezoidal rule for the angular velocity [rad].
JUMP = 3 * np.pi
# Smallest component of a jump about the axis of an output that is warned of [rad].
SEEN = 0.1


def warn_of_full_turns(motion: Motion, whence: Any) -> None:
    """Warn of outputs that are rotations about axes in space and jump past a full turn.

    The outputs are components of a rotation vector, which is unique within a full turn to either side. Compared are its
    change between two times and the mean angular velocity. Turns before the start, or between two times at rest, are
    not found. `whence` are the nodal coordinates from which rotations are counted.
    """
    outputs = motion.labels.outputs
    asked = {s.name: [p for p in terms_of((s,)) if p.axis is not None and p.quantity == "position"] for s in outputs}
    if not any(asked.values()) or not is_concrete((motion.t, motion.x, motion.xd, whence)):
        return
    t, x, xd, whence = (np.asarray(array) for array in (motion.t, motion.x, motion.xd, whence))
    # A failed motion ends before its last time.
    finite = np.all(np.isfinite(x), axis=1)
    t, x, xd = t[finite], x[finite], xd[finite]
    jumping = [f"'{name}'" for name, parts in asked.items() if any(_jumps(t, x, xd, whence, part) for part in parts)]
    if jumping:
        warn(
            f"Output {among(jumping)} passes a full turn in this motion. A measured rotation in space jumps there."
            " Measure a hinge instead, whose angle counts past full turns: output('hinge', 1)."
        )


def _jumps(t: np.ndarray, x: np.ndarray, xd: np.ndarray, whence: np.ndarray, part: Signal) -> bool:
    """Whether a rotation, from Euler parameters and their rates at times, passes a full turn."""
    euler = slice(part.index, part.index + 4)
    lam, rate, start = x[:, euler], xd[:, euler], whence[None, euler]

    def between(turn: Any, start: Any) -> Any:
        return compose_turns(CONJUGATE * start, turn) if part.local else compose_turns(turn, CONJUGATE * start)

    since = between(lam, start)
    size = np.linalg.norm(since[:, 1:], axis=1, keepdims=True)
    vector = 2 * np.arctan2(size, since[:, :1]) * since[:, 1:] / np.where(size > 0, size, 1.0)
    speed = 2 * between(rate, lam)[:, 1:]
    missing = np.diff(vector, axis=0) - np.diff(t)[:, None] * (speed[1:] + speed[:-1]) / 2
    return bool(np.any((np.linalg.norm(missing, axis=1) > JUMP) & (np.abs(missing[:, part.axis]) > SEEN)))
