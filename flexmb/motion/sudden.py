"""Times at which functions of time change suddenly, which long steps would pass over.

A mechanism at rest is integrated by ever longer steps, and a pulse between two stages of one of them is never seen.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete, undifferentiated
from ..compilation.compile import jit
from ..compilation.program import Captured, has_effects, is_wave
from ..display import short
from ..errors import warn
from .drive import has_table

# Functions are looked at so often: what is over sooner has to be named as a jump.
PARTS = 10_000
# Second differences over the range of a function, from which on it changes suddenly: so many times the usual one, and
# no less than of what takes a seventh of the time, which no step misses.
UNUSUAL, SHARP = 5.0, 1e-6
# From one time to the next values jump by this share of their range.
JUMP = 0.02
# Changes so near to each other are one.
TOGETHER = 64


def sudden_changes(functions: Sequence[Any], span: np.ndarray, named: bool = False) -> np.ndarray | None:
    """Begins and ends of sudden changes within a time, ascending; None where there are none.

    Functions whose numbers are traced are looked at outside ``jax.jit`` and ``jax.vmap`` only; tables not, whose times
    are stepped onto, nor functions that print.

    Args:
        functions: Functions of time.
        span: Start and end, (2,) [s].
        named: Whether the user has named jumps.

    Returns:
        (k,) [s], with k a power of two, so that few structures are compiled; filled up with infinity.

    Warns:
        FlexmbWarning: A function that is differentiated jumps.
    """
    looked_at = [f for f in functions if not has_table(f)]
    looked_at = [f for f in looked_at if not (isinstance(f, Captured) and (is_wave(f) or has_effects(f)))]
    known = [undifferentiated(f) for f in looked_at]
    both = [(f, own) for f, own in zip(looked_at, known, strict=True) if is_concrete(own)]
    if not both or not span[0] < span[1]:
        return None
    times, edges = np.linspace(span[0], span[1], PARTS + 1), np.zeros(0, int)
    for f, own in both:
        values = np.asarray(_values(own, times))
        found = _edges(values)
        edges = np.union1d(edges, found[(found > 0) & (found < PARTS)])
        if len(found) and not named and not is_concrete(f) and (at := _jump(values)) is not None:
            warn(
                f"A function of time jumps at t = {short(times[at])} s, and its numbers are differentiated: the"
                " derivative by the time of the jump, if that is one of them, is zero unless it is named, as in"
                " jumps=[t1]."
            )
    if not len(edges):
        return None
    found = np.full(max(4, 2 ** int(np.ceil(np.log2(len(edges))))), np.inf)
    found[: len(edges)] = times[edges]
    return found


@jit
def _values(function: Any, times: Float[Array, "n"]) -> Float[Array, "n k"]:
    # One by one: a call of the host need not take many times at once.
    return jax.lax.map(lambda t: jnp.ravel(jnp.asarray(function(t), float)), times)


def _jump(values: np.ndarray) -> int | None:
    """Number of the time before the first of the values jump; None where none does."""
    ranges = np.ptp(values, axis=0)
    moved = ranges > 0
    steps = np.max(np.abs(np.diff(values[:, moved], axis=0)) / ranges[moved], axis=1, initial=0.0)
    at = int(np.argmax(steps))
    return at if steps[at] > max(JUMP, UNUSUAL * float(np.median(steps))) else None


def _edges(values: np.ndarray) -> np.ndarray:
    """Numbers of the times just before and just after values change suddenly."""
    ranges = np.ptp(values, axis=0)
    values = values[:, np.isfinite(ranges) & (ranges > 0)] / ranges[np.isfinite(ranges) & (ranges > 0)]
    bends = np.max(np.abs(np.diff(values, 2, axis=0)), axis=1, initial=0.0)
    sharp = np.flatnonzero(bends > max(UNUSUAL * float(np.median(bends)), SHARP)) + 1
    if not len(sharp):
        return sharp
    last = np.append(np.diff(sharp) > TOGETHER, True)
    first = np.append(True, last[:-1])
    return np.concatenate([sharp[first] - 1, sharp[last] + 1])
