"""Rules of Newton's method for all static solutions: which corrections are accepted, and how load steps adapt.

The size of a correction is its largest change of a coordinate, in extents of the mechanism or radians. Rules across a
path apply to host and traced numbers. Loops are not shared: each solves other equations, and one compiled loop contains
Newton's iterations and the load steps around them, so that its equations are compiled once.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..numerical_limits import LOOSE_TOLERANCE, SMALLEST_LOAD_STEP, STEP_TOLERANCE

# Goals for the next load step: size of its first correction, as share of `largest`, and contraction of corrections.
FIRST_CORRECTION = 0.8
WANTED_CONTRACTION = 0.2

# A number on the host, or a traced one.
Number = float | Float[Array | np.ndarray, ""]


class Newton(NamedTuple):
    """Limits of corrections. Beyond them, the iteration has left the path and may find another branch.

    Attributes:
        largest: A larger correction is refused: angles could be counted into another turn.
        contraction: A correction above this share of the previous correction is refused too.
        round_off: Smaller corrections may shrink slowly, because of round-off of a nearly singular tangent.
        most: Largest number of corrections.

    Source:
        Deuflhard 2011, Newton Methods for Nonlinear Problems, section 5.1.
    """

    largest: float
    contraction: float
    round_off: float
    most: int

    def slow(self, size: Number, before: Number) -> Any:
        """Whether a correction is hardly smaller than the previous one, which is infinite for the first."""
        return size > self.contraction * before

    def astray(self, size: Number, before: Number, tries: Any) -> Any:
        """Whether a correction is refused, also if it is NaN."""
        slow = self.slow(size, before) & (size > self.round_off)
        return ~(size < self.largest) | slow | (tries >= self.most)


# At a given load.
AT_LOAD = Newton(largest=0.75, contraction=0.35, round_off=STEP_TOLERANCE**0.5, most=12)
# In a plane across an equilibrium path, where the load changes too.
ACROSS_PATH = Newton(largest=0.3, contraction=0.5, round_off=1e-7, most=10)


class LoadStep(NamedTuple):
    """Progress of load steps, and of Newton's method at the next one.

    Attributes:
        reached: Share of the load of the last equilibrium.
        step: Next increase of it.
        first: Size of the first correction.
        before: Size of the last; infinite without one.
        tries: Number of corrections so far.
    """

    reached: Float[Array, ""]
    step: Float[Array, ""]
    first: Float[Array, ""]
    before: Float[Array, ""]
    tries: Int[Array, ""]

    @property
    def load(self) -> Float[Array, ""]:
        """Share of the load that is tried."""
        return jnp.minimum(self.reached + self.step, 1.0)

    def astray(self, size: Number) -> Any:
        """Whether the next correction, of this size, is refused."""
        return AT_LOAD.astray(size, self.before, self.tries)

    def near_enough(self, size: Number) -> Any:
        """Whether the next correction, of this size, ends the iteration: at the whole load it must be small.

        The rest is estimated: after a contraction by theta, the next one is by theta^2 (Deuflhard 2011, section 2.1).
        """
        left = size * (size / self.before) ** 2
        return (size < STEP_TOLERANCE) | ((self.load < 1.0) & (left < LOOSE_TOLERANCE) & (self.tries > 0))

    def after(self, size: Number, done: Any, bad: Any) -> tuple["LoadStep", Any]:
        """State after a correction that is ``done`` or ``bad`` (refused), and whether load steps are too short."""
        first = jnp.where(self.tries == 0, size, self.first)
        # Factor of the step for a first correction of the wanted size.
        fitting = FIRST_CORRECTION * AT_LOAD.largest / first
        shorter = self.step * jnp.where((self.tries == 0) & (fitting > 0), jnp.clip(fitting, 0.02, 0.5), 0.25)
        contraction = size / self.before
        longer = self.step * jnp.clip(jnp.minimum(fitting, jnp.sqrt(WANTED_CONTRACTION / contraction)), 0.5, 4.0)
        following = LoadStep(
            reached=jnp.where(done, self.load, self.reached),
            step=jnp.where(bad, shorter, jnp.where(done, longer, self.step)),
            first=first,
            before=jnp.where(bad | done, jnp.inf, size),
            tries=jnp.where(bad | done, 0, self.tries + 1),
        )
        return following, bad & (shorter < SMALLEST_LOAD_STEP)


def first_load_step() -> LoadStep:
    """The whole load in one step."""
    return LoadStep(
        reached=jnp.array(0.0),
        step=jnp.array(1.0),
        first=jnp.array(1.0),
        before=jnp.array(jnp.inf),
        tries=jnp.zeros((), jnp.int32),
    )
