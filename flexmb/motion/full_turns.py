"""A word where a rotation in space that is measured passes a full turn, where it jumps."""

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

# A jump is one of two turns; half of another is left to what the trapezoidal rule makes of the angular velocity.
JUMP = 3 * np.pi
# A jump is seen by an output whose axis it is by more than this [rad].
SEEN = 0.1


def warn_of_full_turns(motion: Motion, whence: Any) -> None:
    """Warn of outputs that are rotations about axes in space where they jump: past a full turn from where they count.

    They are components of a rotation vector, which is told within a full turn to either side. That one was passed
    between two times is seen by the angular velocity at both: the vector does not change by what was turned. Where a
    motion begins beyond a turn, or passes one between two times at which it rests, nothing is seen.

    Args:
        motion: Motion; nothing is looked at where it is traced.
        whence: Nodal coordinates that rotations are counted from, (n_x,) [m, rad, -].
    """
    outputs = motion.labels.outputs
    asked = {s.name: [p for p in terms_of((s,)) if p.axis is not None and p.quantity == "position"] for s in outputs}
    if not any(asked.values()) or not is_concrete((motion.t, motion.x, motion.xd, whence)):
        return
    t, x, xd, whence = (np.asarray(own) for own in (motion.t, motion.x, motion.xd, whence))
    # What failed ends before its last time.
    there = np.all(np.isfinite(x), axis=1)
    t, x, xd = t[there], x[there], xd[there]
    found = [f"'{name}'" for name, parts in asked.items() if any(_jumps(t, x, xd, whence, part) for part in parts)]
    if found:
        warn(
            f"What {among(found)} measures passes a full turn along this motion, and a rotation about an axis in space"
            " is told within one to either side alone: beyond it what is measured jumps. Measure a hinge, whose angle"
            " is counted past full turns: output('hinge', 1)."
        )


def _jumps(t: np.ndarray, x: np.ndarray, xd: np.ndarray, whence: np.ndarray, part: Signal) -> bool:
    """Whether a rotation, by Euler parameters and their rates at times, passes a full turn."""
    own = slice(part.index, part.index + 4)
    lam, rate, start = x[:, own], xd[:, own], whence[None, own]

    def between(of: Any, one: Any) -> Any:
        return compose_turns(CONJUGATE * one, of) if part.local else compose_turns(of, CONJUGATE * one)

    since = between(lam, start)
    size = np.linalg.norm(since[:, 1:], axis=1, keepdims=True)
    vector = 2 * np.arctan2(size, since[:, :1]) * since[:, 1:] / np.where(size > 0, size, 1.0)
    speed = 2 * between(rate, lam)[:, 1:]
    missing = np.diff(vector, axis=0) - np.diff(t)[:, None] * (speed[1:] + speed[:-1]) / 2
    return bool(np.any((np.linalg.norm(missing, axis=1) > JUMP) & (np.abs(missing[:, part.axis]) > SEEN)))
