"""A simulation in parts of equal length, one after the other, so that it can be watched and stopped."""

import dataclasses
import itertools
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..progress import reporting
from ..results import RESULTS
from .controlled_form import Feedback
from .controllers import Sampled
from .integrate import Integrated, Intervals, Problem, Reached, begin, integrate, integrate_sampled
from .integrator import Integrator
from .protocol import WholeMotion

# Most parts: enough for a bar to move by, and few, since the integration starts anew in each.
PARTS = 50


def sampled_intervals(times: np.ndarray, period: float, start: float, end: float) -> Intervals:
    """Intervals of a sampled controller, and the times asked for in each; a sample belongs to what follows.

    Args:
        times: Times, ascending, (n_t,) [s].
        period: Interval [s].
        start: First sample [s].
        end: End of the last interval, which may be a shorter one [s].
    """
    count = max(int(np.ceil((end - start) / period - 1e-9)), 1)
    starts = start + period * np.arange(count)
    ends = np.append(starts[1:], end)
    interval = np.clip(np.searchsorted(starts, times + 1e-9 * period, side="right") - 1, 0, count - 1)
    place = np.arange(len(times)) - np.searchsorted(interval, interval)
    rows = np.repeat(ends[:, None], np.max(place) + 2, axis=1)
    rows[interval, place] = np.clip(times, starts[interval], ends[interval])
    return Intervals(*jax.device_put((starts, ends, rows, interval, place)))


def _bounds(times: np.ndarray, feedback: Feedback | Sampled | None, dt0: float) -> np.ndarray:
    """Ends of the parts: whole samples or whole steps, where either is given."""
    span = times[-1] - times[0]
    unit = feedback.period if isinstance(feedback, Sampled) else dt0 if dt0 > 0 else span / PARTS
    units = max(int(np.ceil(span / unit - 1e-9)), 1)
    least = -(-units // PARTS)
    # Parts of one size are compiled once: a size that leaves no shorter part at the end, if there is one.
    size = next((n for n in range(least, 2 * least + 1) if units % n == 0), least)
    ends = times[0] + unit * np.arange(0, units, size)
    return np.append(ends, times[-1])


def integrate_in_parts(
    problem: Problem,
    integrator: Integrator,
    times: Float[Array, "n_t"],
    at: Reached,
    progress: Callable[[int, int], None] | bool,
) -> Integrated:
    """Motion as by the other two, in parts; after an interruption from the keyboard what there is up to then.

    Args:
        integrator: How, as checked.
        times: Times, the first is the start, (n_t,) [s].
        at: Where it starts from.
        progress: See :func:`flexmb.simulate`.

    Returns:
        Integrated, with rows for the times that were reached; those of the part that failed may be not finite.
    """
    wanted, feedback, dt0 = np.asarray(times), problem.feedback, float(np.asarray(integrator.dt0))
    bounds = _bounds(wanted, feedback, dt0)
    part = np.clip(np.searchsorted(bounds, wanted, side="right") - 1, 0, len(bounds) - 2)
    width = int(np.max(np.bincount(part))) + 1
    at = at._replace(state=begin(problem, integrator.form, jnp.asarray(wanted[0]), at.state))
    rows: list[list[np.ndarray]] = []
    steps, result = 0, RESULTS.successful
    with reporting(progress, "simulating", len(bounds) - 1) as report:
        try:
            for i, (start, end) in enumerate(itertools.pairwise(bounds)):
                own = wanted[part == i]
                filled = np.append(own, np.full(width - len(own), end))
                if isinstance(feedback, Sampled):
                    grid = sampled_intervals(filled, feedback.period, start, end)
                    run = integrate_sampled(problem, integrator, grid, jnp.asarray(filled), at)
                else:
                    run = integrate(problem, integrator, jnp.asarray([start, end]), jnp.asarray(filled), at)
                rows.append([np.asarray(column)[: len(own)] for column in run.rows])
                steps, result, at = steps + int(run.steps), RESULTS(int(run.result)), run.last
                if report is not None:
                    report(i + 1, len(bounds) - 1)
                if result != RESULTS.successful or not np.all(np.isfinite(np.asarray(at.state[0]))):
                    break
                if not isinstance(feedback, Sampled) and dt0 == 0:
                    # The next part goes on with steps as long as these were.
                    own_step = jnp.asarray((end - start) / max(int(run.steps), 1))
                    integrator = dataclasses.replace(integrator, dt0=own_step)
        except KeyboardInterrupt:
            result = RESULTS.stopped
    if not rows:
        top, inputs = problem.model.topology, 0 if feedback is None else len(problem.model.labels.inputs)
        rows.append([np.zeros((0, size)) for size in (top.n_x, top.n_x, top.n_e, inputs)])
    whole = WholeMotion(*jax.device_put([np.concatenate(column) for column in zip(*rows, strict=True)]))
    return Integrated(whole, jnp.asarray(steps), jnp.asarray(int(result)), at)
