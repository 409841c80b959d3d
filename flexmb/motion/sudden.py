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

from ..arguments import is_concrete
from ..compilation.compile import jit
from ..compilation.program import Captured, has_effects, is_wave
from .drive import has_table

# Functions are looked at so often: what is over sooner has to be named as a jump.
PARTS = 10_000
# Second differences over the range of a function, from which on it changes suddenly: so many times the usual one, and
# no less than of what takes a seventh of the time, which no step misses.
UNUSUAL, SHARP = 5.0, 1e-6
# Changes so near to each other are one.
TOGETHER = 64


def sudden_changes(functions: Sequence[Any], span: np.ndarray) -> np.ndarray | None:
    """Begins and ends of sudden changes within a time, ascending; None where there are none.

    Functions whose numbers are traced are looked at outside ``jax.jit`` and ``jax.vmap`` only; tables not, whose times
    are stepped onto, nor functions that print.

    Args:
        functions: Functions of time.
        span: Start and end, (2,) [s].

    Returns:
        (k,) [s], with k a power of two, so that few structures are compiled; filled up with infinity.
    """
    looked_at = [f for f in functions if not has_table(f)]
    looked_at = [f for f in looked_at if not (isinstance(f, Captured) and (is_wave(f) or has_effects(f)))]
    looked_at = [f for f in map(_undifferentiated, looked_at) if is_concrete(f)]
    if not looked_at or not span[0] < span[1]:
        return None
    times = np.linspace(span[0], span[1], PARTS + 1)
    edges = np.unique([edge for f in looked_at for edge in _edges(np.asarray(_values(f, times)))]).astype(int)
    edges = edges[(edges > 0) & (edges < PARTS)]
    if not len(edges):
        return None
    found = np.full(max(4, 2 ** int(np.ceil(np.log2(len(edges))))), np.inf)
    found[: len(edges)] = times[edges]
    return found


def _undifferentiated(function: Any) -> Any:
    """A function whose numbers have no derivatives; those of ``jax.grad`` alone are concrete then."""

    def known(number: Any) -> Any:
        return jax.lax.stop_gradient(number) if isinstance(number, jax.core.Tracer) else number

    return jax.tree.map(known, function)


@jit
def _values(function: Any, times: Float[Array, "n"]) -> Float[Array, "n k"]:
    # One by one: a call of the host need not take many times at once.
    return jax.lax.map(lambda t: jnp.ravel(jnp.asarray(function(t), float)), times)


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
