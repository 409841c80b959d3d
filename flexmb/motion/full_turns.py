"""A word where a rotation in space that is measured passes a full turn, where it jumps."""

from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..display import listed
from ..errors import warn
from ..math.rigid import compose_turns
from ..math.rotation import CONJUGATE
from ..mechanics.signals import terms_of
from .motion import Motion

FULL = 2 * np.pi


def warn_of_full_turns(motion: Motion) -> None:
    """Warn of outputs that are rotations about axes in space where what they measure turns by more than a full turn.

    They are components of a rotation vector, which is told within a full turn to either side.

    Args:
        motion: Motion; nothing is looked at where it is traced.
    """
    outputs = motion.labels.outputs
    asked = [s for s in outputs if any(p.axis is not None and p.quantity == "position" for p in terms_of((s,)))]
    if not asked or not is_concrete((motion.t, motion.x, motion.xd)):
        return
    t, x, xd = (np.asarray(own) for own in (motion.t, motion.x, motion.xd))
    # What failed ends before its last time.
    there = np.all(np.isfinite(x), axis=1)
    t, x, xd = t[there], x[there], xd[there]
    found = []
    for signal in asked:
        at = {part.index for part in terms_of((signal,)) if part.axis is not None and part.quantity == "position"}
        if any(_turns_over(t, x[:, i : i + 4], xd[:, i : i + 4]) for i in at):
            found.append(f"'{signal.name}'")
    if found:
        warn(
            f"What {listed(found)} measures turns by more than a full turn along this motion, and a rotation about an"
            " axis in space is told within one to either side alone: beyond it what is measured jumps. Measure a hinge,"
            " whose angle is counted past full turns: output('hinge', 1)."
        )


def _turns_over(t: np.ndarray, lam: Any, rate: Any) -> bool:
    """Whether a rotation passes a full turn, by Euler parameters and their rates at times, each (n_t, 4)."""
    since = compose_turns(lam, CONJUGATE * lam[:1])
    size = np.linalg.norm(since[:, 1:], axis=1, keepdims=True)
    vector = 2 * np.arctan2(size, since[:, :1]) * since[:, 1:] / np.where(size > 0, size, 1.0)
    # Between times that are far apart it may have come round; then the rates tell.
    speed = 2 * compose_turns(rate, CONJUGATE * lam)[:, 1:]
    turned = np.cumsum(np.diff(t)[:, None] * (speed[1:] + speed[:-1]) / 2, axis=0)
    jumps = np.linalg.norm(np.diff(vector, axis=0), axis=1)
    return bool(np.any(jumps > FULL) or np.any(np.linalg.norm(turned, axis=1) > FULL))
