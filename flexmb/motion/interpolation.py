"""Motion between two steps."""

from typing import Any

import diffrax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .protocol import MotionState


class MotionInterpolation(diffrax.AbstractLocalInterpolation):
    """Positions and velocities between two steps, Hermite polynomials of order three in each.

    Attributes:
        t0: Begin [s].
        t1: End [s].
        y0: State at the begin.
        y1: State at the end.
        a0: Accelerations at the begin, (n,) [1/s^2].
        a1: Accelerations at the end, (n,) [1/s^2].
    """

    t0: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    t1: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    y0: MotionState
    y1: MotionState
    a0: Float[Array, "n"]
    a1: Float[Array, "n"]

    def evaluate(self, t0, t1=None, left: bool = True) -> MotionState:
        """State at a time, or its change over an interval."""
        del left
        if t1 is not None:
            first, last = self.evaluate(t0), self.evaluate(t1)
            return MotionState(*(b - a for a, b in zip(first, last, strict=True)))
        h = self.t1 - self.t0
        s = (t0 - self.t0) / jnp.where(h == 0, 1.0, h)
        y0, y1 = self.y0, self.y1
        u = _hermite(s, h, y0.u, y1.u, y0.w, y1.w)
        w = _hermite(s, h, y0.w, y1.w, self.a0, self.a1)
        return MotionState(u, w, y0.memory + s * (y1.memory - y0.memory))


def _hermite(s, h, p0, p1, v0, v1):
    change = p1 - p0
    return p0 + s * (h * v0 + s * (3 * change - h * (2 * v0 + v1) + s * (h * (v0 + v1) - 2 * change)))
