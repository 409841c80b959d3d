"""Interpolation between two steps of a motion."""

from collections.abc import Callable
from typing import Any, ClassVar

import diffrax
from jaxtyping import Array, Float

from .protocol import MotionState
from .stages import state_within_step


class MotionInterpolation(diffrax.AbstractLocalInterpolation):
    """Positions and velocities between two steps: Hermite polynomials of order three in each."""

    t0: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    t1: Any  # pyright: ignore[reportIncompatibleVariableOverride]
    y0: MotionState
    y1: MotionState
    a0: Float[Array, "n"]
    a1: Float[Array, "n"]
    within: ClassVar[Callable[..., MotionState]] = staticmethod(state_within_step)

    def evaluate(self, t0: Any, t1: Any = None, left: bool = True) -> MotionState:
        """State at a time, or its change over an interval."""
        del left
        if t1 is not None:
            first, last = self.evaluate(t0), self.evaluate(t1)
            return MotionState(*(b - a for a, b in zip(first, last, strict=True)))
        return self.within((self.t0, self.t1), (self.y0, self.y1), (self.a0, self.a1), t0)
