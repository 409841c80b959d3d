"""A simulation in parts of equal length, whose progress can be watched and which can be stopped."""

import dataclasses
import itertools
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..numerical_limits import WHOLE_STEPS
from ..progress import reporting
from ..results import RESULTS
from .controlled_form import Feedback
from .controllers import Sampled
from .integrate import Integrated, Intervals, Problem, Reached, begin, integrate, integrate_sampled
from .integrator import Integrator
from .protocol import WholeMotion

# Enough for a progress bar, and few, since the integration restarts in each.
PARTS = 50


def sampled_intervals(times: np.ndarray, period: float, start: float, end: float) -> Intervals:
    """Intervals of a sampled controller from `start` to `end`, and the times in each; a sample begins its interval."""
    count = max(int(np.ceil((end - start) / period - WHOLE_STEPS)), 1)
    starts = start + period * np.arange(count)
    ends = np.append(starts[1:], end)
    interval = np.clip(np.searchsorted(starts, times + WHOLE_STEPS * period, side="right") - 1, 0, count - 1)
    place = np.arange(len(times)) - np.searchsorted(interval, interval)
    rows = np.repeat(ends[:, None], np.max(place) + 2, axis=1)
    rows[interval, place] = np.clip(times, starts[interval], ends[interval])
    return Intervals(*jax.device_put((starts, ends, rows, interval, place)))


def _bounds(times: np.ndarray, feedback: Feedback | Sampled | None, dt0: float) -> np.ndarray:
    """Ends of the parts, at whole samples or whole steps."""
    span = times[-1] - times[0]
    unit = feedback.period if isinstance(feedback, Sampled) else dt0 if dt0 > 0 else span / PARTS
    units = max(int(np.ceil(span / unit - WHOLE_STEPS)), 1)
    least = -(-units // PARTS)
    # Parts of one size are compiled once: prefer a size without a shorter part at the end.
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
    """Motion in parts; after a keyboard interruption the motion so far.

    Returns:
        Integrated, with rows of the times reached; rows of a failed part may be not finite.
    """
    all_times, feedback, dt0 = np.asarray(times), problem.feedback, float(np.asarray(integrator.dt0))
    bounds = _bounds(all_times, feedback, dt0)
    part = np.clip(np.searchsorted(bounds, all_times, side="right") - 1, 0, len(bounds) - 2)
    width = int(np.max(np.bincount(part))) + 1
    at = at._replace(state=begin(problem, integrator.form, jnp.asarray(all_times[0]), at.state))
    rows: list[list[np.ndarray]] = []
    steps, result = 0, RESULTS.successful
    with reporting(progress, "simulating", len(bounds) - 1) as report:
        try:
            for i, (start, end) in enumerate(itertools.pairwise(bounds)):
                part_times = all_times[part == i]
                filled = np.append(part_times, np.full(width - len(part_times), end))
                if isinstance(feedback, Sampled):
                    grid = sampled_intervals(filled, feedback.period, start, end)
                    run = integrate_sampled(problem, integrator, grid, jnp.asarray(filled), at)
                else:
                    run = integrate(problem, integrator, jnp.asarray([start, end]), jnp.asarray(filled), at)
                rows.append([np.asarray(column)[: len(part_times)] for column in run.rows])
                steps, result, at = steps + int(run.steps), RESULTS(int(run.result)), run.last
                if report is not None:
                    report(i + 1, len(bounds) - 1)
                if result != RESULTS.successful or not np.all(np.isfinite(np.asarray(at.state[0]))):
                    break
                if not isinstance(feedback, Sampled) and dt0 == 0:
                    # The next part starts with the mean step of this one.
                    mean_step = jnp.asarray((end - start) / max(int(run.steps), 1))
                    integrator = dataclasses.replace(integrator, dt0=mean_step)
        except KeyboardInterrupt:
            result = RESULTS.stopped
    if not rows:
        top, inputs = problem.model.topology, 0 if feedback is None else len(problem.model.labels.inputs)
        rows.append([np.zeros((0, size)) for size in (top.n_x, top.n_x, top.n_e, inputs)])
    whole_motion = WholeMotion(*jax.device_put([np.concatenate(column) for column in zip(*rows, strict=True)]))
    return Integrated(whole_motion, jnp.asarray(steps), jnp.asarray(int(result)), at)
