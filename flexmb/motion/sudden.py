"""Times at which functions of time change suddenly, which long steps would pass over.

A mechanism at rest is integrated by ever longer steps, which do not see a pulse between two of their stages.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete, undifferentiated
from ..compilation.compile import jit
from ..compilation.program import Captured, has_effects, is_wave
from ..display import short
from ..errors import warn
from ..numerical_limits import JUMP_OF_RANGE, SUDDEN_BEND, SUDDEN_OVER_USUAL
from .drive import has_table

# Number of intervals at which functions are evaluated. Users name shorter changes in ``jumps``.
PARTS = 10_000
# Changes within this number of intervals count as one change.
TOGETHER = 64


def sudden_changes(functions: Sequence[Any], span: np.ndarray, named: bool = False) -> np.ndarray | None:
    """Begins and ends of sudden changes of functions of time [s], ascending; None without any.

    Functions of traced numbers are evaluated outside ``jax.jit`` and ``jax.vmap`` only. Tables, whose times are stepped
    onto, and functions that print are skipped. The result is filled up with infinity to a power of two, so that few
    programs are compiled. Warns of a differentiated function that jumps, unless the user has named jumps.
    """
    smooth = [f for f in functions if not has_table(f)]
    smooth = [f for f in smooth if not (isinstance(f, Captured) and (is_wave(f) or has_effects(f)))]
    known_functions = [(f, known) for f in smooth if is_concrete(known := undifferentiated(f))]
    if not known_functions or not span[0] < span[1]:
        return None
    times, edges = np.linspace(span[0], span[1], PARTS + 1), np.zeros(0, int)
    for f, known in known_functions:
        values = np.asarray(_values(known, times))
        at_change = _edges(values)
        edges = np.union1d(edges, at_change[(at_change > 0) & (at_change < PARTS)])
        if len(at_change) and not named and not is_concrete(f) and (at := _jump(values)) is not None:
            warn(
                f"A function of time jumps at t = {short(times[at])} s, and you differentiate by its numbers. The"
                " derivative by the time of the jump is computed as zero. To differentiate by this time, name it:"
                " jumps=[t1]."
            )
    if not len(edges):
        return None
    changes = np.full(max(4, 2 ** int(np.ceil(np.log2(len(edges))))), np.inf)
    changes[: len(edges)] = times[edges]
    return changes


@jit
def _values(function: Any, times: Float[Array, "n"]) -> Float[Array, "n k"]:
    # One after the other: a callback to the host may not accept many times at once.
    return jax.lax.map(lambda t: jnp.ravel(jnp.asarray(function(t), float)), times)


def _jump(values: np.ndarray) -> int | None:
    """Number of the time before the first jump; None without a jump."""
    ranges = np.ptp(values, axis=0)
    moved = ranges > 0
    steps = np.max(np.abs(np.diff(values[:, moved], axis=0)) / ranges[moved], axis=1, initial=0.0)
    at = int(np.argmax(steps))
    return at if steps[at] > max(JUMP_OF_RANGE, SUDDEN_OVER_USUAL * float(np.median(steps))) else None


def _edges(values: np.ndarray) -> np.ndarray:
    """Numbers of the times just before and just after sudden changes."""
    ranges = np.ptp(values, axis=0)
    values = values[:, np.isfinite(ranges) & (ranges > 0)] / ranges[np.isfinite(ranges) & (ranges > 0)]
    bends = np.max(np.abs(np.diff(values, 2, axis=0)), axis=1, initial=0.0)
    sharp = np.flatnonzero(bends > max(SUDDEN_OVER_USUAL * float(np.median(bends)), SUDDEN_BEND)) + 1
    if not len(sharp):
        return sharp
    last = np.append(np.diff(sharp) > TOGETHER, True)
    first = np.append(True, last[:-1])
    return np.concatenate([sharp[first] - 1, sharp[last] + 1])
