"""When Newton's method is trusted, and how load steps adapt to it: the rules of all static solutions.

The size of a correction is its largest change of a coordinate, positions in extents of the mechanism, rotations in
radians. All functions take numbers on the host as well as traced ones. The loops themselves are not shared: each
solves other equations for its correction, and one loop in compiled code holds every turn of Newton's method and of
the load steps around it, so that its equations are compiled once.
"""

from typing import Any, NamedTuple

import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# A correction smaller than this is made and ends the iteration: the error left is of the order of its square.
STEP_TOLERANCE = 1e-9
# At loads that are only passed on the way this suffices, after the first correction.
LOOSE_TOLERANCE = 0.02
# Load steps are not shortened below this share of the load.
SMALLEST_LOAD_STEP = 1e-5
# The next load step is to begin with a correction of this share of the largest, and to bring it down by this.
FIRST_CORRECTION = 0.8
WANTED_CONTRACTION = 0.2

# A number on the host, or a traced one.
Number = float | Float[Array | np.ndarray, ""]


class Newton(NamedTuple):
    """When corrections show that the iteration has left the neighbourhood of the path and may find another branch.

    Attributes:
        largest: A larger correction is refused: angles could be counted into another turn.
        contraction: So is one that is more than this share of the one before it.
        round_off: Smaller ones may shrink as slowly as they do: that is round-off of a nearly singular tangent.
        most: Number of corrections.

    Source:
        Deuflhard 2011, Newton Methods for Nonlinear Problems, section 5.1.
    """

    largest: float
    contraction: float
    round_off: float
    most: int

    def slow(self, size: Number, before: Number) -> Any:
        """Whether a correction is hardly smaller than the one before it, which is infinite for the first."""
        return size > self.contraction * before

    def astray(self, size: Number, before: Number, tries: Any) -> Any:
        """Whether a correction after so many others is refused, one that is no number among them."""
        slow = self.slow(size, before) & (size > self.round_off)
        return ~(size < self.largest) | slow | (tries >= self.most)


# At a given load.
AT_LOAD = Newton(largest=0.75, contraction=0.35, round_off=STEP_TOLERANCE**0.5, most=12)
# In a plane across an equilibrium path, where the load changes too.
ACROSS_PATH = Newton(largest=0.3, contraction=0.5, round_off=1e-7, most=10)


def near_enough(size: Number, load: Number, tries: Any) -> Any:
    """Whether a correction after so many others ends the iteration at a share of the load: at 1 it must be small."""
    return (size < STEP_TOLERANCE) | ((load < 1.0) & (size < LOOSE_TOLERANCE) & (tries > 0))


def shorter_load_step(step: Number, first: Number, tries: Any) -> Any:
    """Load step in place of one whose correction was refused after so many others, the first of size ``first``."""
    fitting, xp = _fitting(first), library_of(step)
    return step * xp.where((tries == 0) & (fitting > 0), xp.clip(fitting, 0.02, 0.5), 0.25)


def next_load_step(step: Number, first: Number, contraction: Number) -> Any:
    """Load step after one whose iteration converged: ``contraction`` is its last correction over the one before."""
    xp = library_of(step)
    return step * xp.clip(xp.minimum(_fitting(first), xp.sqrt(WANTED_CONTRACTION / contraction)), 0.5, 4.0)


def _fitting(first: Number) -> Any:
    """By how much a load step would have to be longer for a first correction of the wanted size."""
    return FIRST_CORRECTION * AT_LOAD.largest / first


def library_of(number: Any) -> Any:
    """What computes with a number: NumPy on the host, where nothing is compiled."""
    return jnp if isinstance(number, jax.core.Tracer) else np
