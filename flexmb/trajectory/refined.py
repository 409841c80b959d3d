"""Time steps halved until the answer no longer changes."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import check_number, check_whole
from ..errors import warn

# Of the method of order five the finer of two runs is off by this share of how far they are apart.
SHARE = 1 / 31
# Steps from one time to the next: at most, and under a trace, where no error can be looked at.
MOST, TRACED = 2**12, 4


def refined(
    run: Callable[..., Any], apart: Callable[[Any, Any], float], substeps: Any, rtol: Any, traced: bool, what: str
) -> tuple[Any, float, int]:
    """What a run of a method of order five gives, with twice as many steps until that hardly differs.

    Warns:
        FlexmbWarning: The error is not reached.

    Returns the run, its estimated error (NaN where steps are given or under a trace), and its number of steps.

    Args:
        run: Function of the number of steps from one time to the next; a whole number of Python's where it is given or
            under a trace, else an array, so that one program serves all.
    """
    check_number("rtol", rtol, above=0)
    if substeps is not None or traced:
        count = TRACED if substeps is None else check_whole("substeps", substeps, 1)
        return run(count), np.nan, count
    count, coarse = 1, run(jnp.asarray(1))
    while True:
        count *= 2
        fine = run(jnp.asarray(count))
        error = SHARE * apart(fine, coarse)
        if error <= rtol or count >= MOST:
            break
        coarse = fine
    if not error <= rtol:
        warn(
            f"{what} is off by {error:.1e}, more than rtol = {rtol:g}, with {MOST} steps from each time to the next."
            " Give more times."
        )
    return fine, error, count
