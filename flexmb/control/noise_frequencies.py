"""Frequencies at which noise is summed: chosen by poles and densities, or by the responses of a loop."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..arguments import is_concrete
from ..errors import warn
from ..numerical_limits import (
    CHANGE_OF_RESPONSE,
    CURVED_DENSITY,
    DECAYING_POLE,
    FAINT_RESPONSE,
    FIRST_OF_BAND,
    FREE_POLE,
    NEAREST_FREQUENCIES,
    POLE_AT_REST,
    UNRESOLVED_SHARE,
)
from .feedback import Controller, closed_by_frequency
from .frequency_response import response_of

# Frequencies of a band in equal ratios, and for each pole, at equal shares of a resonance's curve 1/(1 + x^2); first
# guessed up to x = WIDEST.
SPREAD, BESIDE, WIDEST = 200, 80, 100.0
# Frequencies computed together, and the largest number of frequencies.
PIECE, MOST = 256, 20000
# Evaluations of a density function between two of SPREAD frequencies in equal ratios, and as many in equal steps. They
# find a line that extends 1e-3 of its frequency to each side, also in a band from 0 Hz.
LOOKS = 64
# Number of SPREAD frequencies to each side whose maximum counts for what is faint: tails beside a line do not matter.
ASIDE = 16


def undamped_within(poles: Complex[Array, "n"], grid: Float[Array, "n_f"]) -> Bool[Array, "n"]:
    """Whether each pole is an undamped resonance within frequencies."""
    sizes = jnp.abs(poles)
    hertz, largest = jnp.imag(poles) / (2 * np.pi), jnp.max(sizes)
    vibrates = (jnp.abs(jnp.real(poles)) <= DECAYING_POLE * largest) & (sizes > FREE_POLE * largest)
    return vibrates & (hertz >= grid[0]) & (hertz <= grid[-1])


def unresolved_resonances(poles: np.ndarray, grid: np.ndarray) -> Float[np.ndarray, "4 n"]:
    """Resonances that the trapezoidal rule sums wrongly: peaks 1/(1 + x^2), x = (f - f_peak) / (half the width).

    The sum over a uniform grid is wrong by 2 exp(-pi n) for n frequencies within the width (Poisson's formula).

    Returns frequencies of the peaks, distances between their frequencies of half power, areas below peaks of height one
    between the first and the last frequency, and areas by the trapezoidal rule minus these, (n,) [Hz] each.
    """
    place, half = np.imag(poles) / (2 * np.pi), np.abs(np.real(poles)) / (2 * np.pi)
    rows = []
    for f, h in zip(place, half, strict=True):
        if f < 0 or h == 0:
            continue
        x = (grid - f) / h
        area = h * (np.arctan(x[-1]) - np.arctan(x[0]))
        excess = np.trapezoid(1 / (1 + x**2), grid) - area
        if abs(excess) > UNRESOLVED_SHARE / 2 * np.pi * h:
            rows.append((f, 2 * h, area, excess))
    return np.array(rows).reshape(-1, 4).T


def responses_at(lin: Any, loop: Controller | None, entries: tuple[tuple[int, ...], ...], hertz: np.ndarray) -> Any:
    """Responses of outputs to sources at concrete frequencies, with or without a controller of known matrices."""

    def responses(hertz: Any):
        plant = response_of(lin, hertz, None, None, None, None).response
        gain, places = (None, None) if loop is None else (loop.by_frequency(hertz), loop.places)
        return np.asarray(closed_by_frequency(plant, gain, places, *entries))

    return _in_blocks(responses, hertz)


def refined_frequencies(lin: Any, loop: Controller, entries: tuple[tuple[int, ...], ...], grid: Any) -> np.ndarray:
    """Frequencies that resolve the responses of a loop with unknown poles: halved until the responses change little.

    Warns if too many are needed; ValueError for numbers traced by ``jax.jit``.
    """
    # Numbers traced by ``jax.grad`` alone are concrete without their derivatives, which frequencies do not need.
    lin, grid = jax.lax.stop_gradient((lin, grid))

    def known_gain(hertz: Any) -> Any:
        gain = jax.lax.stop_gradient(loop.by_frequency(hertz))
        if not is_concrete((gain, lin, grid)):
            raise ValueError(
                "For a controller function, flexmb chooses the frequencies of a `band` from concrete numbers. Give"
                " `hertz` under jax.jit."
            )
        return gain

    known_gain(np.ones(1))
    grid = np.asarray(grid)

    def responses(hertz: np.ndarray):
        known_loop = loop._replace(by_frequency=known_gain)
        return responses_at(lin, known_loop, entries, hertz).reshape(len(hertz), -1)

    known = responses(grid)
    while True:
        # Across a resonance halfway between two frequencies sizes are equal, but phases are not.
        size = np.abs(known)
        size = np.maximum(size[1:], size[:-1]) + FAINT_RESPONSE * np.max(size, axis=0)
        steps = np.max(np.abs(np.diff(known, axis=0)) / np.where(size > 0, size, 1.0), axis=1, initial=0.0)
        sharp = steps > CHANGE_OF_RESPONSE
        coarse = np.flatnonzero(sharp & (np.diff(grid) > NEAREST_FREQUENCIES * grid[1:]))
        if not len(coarse) or len(grid) >= MOST:
            break
        more = np.sqrt(grid[coarse] * grid[coarse + 1])
        known = np.insert(known, coarse + 1, responses(more), axis=0)
        grid = np.insert(grid, coarse + 1, more)
    if np.any(sharp):
        warn(
            f"{len(grid)} frequencies do not resolve the loop around a controller function: it has an undamped"
            " resonance, or a long delay. The root mean square may be wrong. Give `hertz`, or damping."
        )
    return grid


def _in_blocks(function: Callable[[Any], Any], hertz: np.ndarray) -> np.ndarray:
    """Values of a function at frequencies, by calls of one size, which compile once."""
    many = np.concatenate([hertz, np.full(-len(hertz) % PIECE, hertz[-1])])
    return np.concatenate([np.asarray(function(piece)) for piece in many.reshape(-1, PIECE)])[: len(hertz)]


def frequencies_of_density(name: str, density: Callable[[Any], Any], low: float, high: float) -> np.ndarray:
    """Frequencies that resolve a density function between those in equal ratios, (n,) [Hz], with a warning if too many.

    Intervals are halved until the density is linear within each. None for a smooth or traced density.
    """
    low = low or POLE_AT_REST * high
    # Known frequencies and numbers stay known within jax.jit.
    with jax.ensure_compile_time_eval():
        if not is_concrete(jax.lax.stop_gradient(density(np.full(PIECE, high)))):
            return np.zeros(0)

        def values(hertz: np.ndarray):
            return _in_blocks(lambda f: np.broadcast_to(np.asarray(jax.lax.stop_gradient(density(f))), f.shape), hertz)

        many = SPREAD * LOOKS
        grid = np.sort(np.concatenate([np.geomspace(low, high, many + 1), np.linspace(low, high, many + 2)[1:-1]]))
        known = values(grid)
        largest = np.max(known[:-1].reshape(-1, LOOKS), axis=1)
        around = np.lib.stride_tricks.sliding_window_view(np.pad(largest, ASIDE), 2 * ASIDE + 1)
        faint = FAINT_RESPONSE * np.repeat(np.max(around, axis=1), LOOKS)
        # From wide to narrow intervals, each with all values within.
        selected, stride = np.zeros(len(grid), bool), LOOKS
        begins = np.zeros(0, int)
        while stride > 1:
            off = np.abs(known - np.interp(grid, grid[::stride], known[::stride]))[:-1].reshape(-1, stride)
            size = np.maximum(np.max(known[:-1].reshape(-1, stride), axis=1), known[stride::stride]) + faint[::stride]
            begins = np.flatnonzero(np.max(off, axis=1) > CURVED_DENSITY * size) * stride
            selected[begins[:, None] + np.array([0, stride // 2, stride])] = True
            stride //= 2
        chosen, left_ends = grid[selected], np.concatenate([begins, begins + 1])
        # Then halved: frequencies and densities at both ends, and the faint level.
        gaps = np.stack(
            [grid[left_ends], grid[left_ends + 1], known[left_ends], known[left_ends + 1], faint[left_ends]]
        )
        integral = np.trapezoid(known, grid)
        while gaps.size and len(chosen) < MOST:
            a, b, at_a, at_b, least = gaps
            middle = (a + b) / 2
            at = values(middle)
            sharp = np.abs(at - (at_a + at_b) / 2) > CURVED_DENSITY * (np.maximum(np.maximum(at_a, at_b), at) + least)
            chosen = np.concatenate([chosen, middle[sharp]])
            halves = [a, middle, at_a, at, least], [middle, b, at, at_b, least]
            gaps = np.concatenate([np.stack(half)[:, sharp] for half in halves], axis=1)
            widths = gaps[1] - gaps[0]
            narrow = widths <= NEAREST_FREQUENCIES * gaps[1]
            endless = narrow & (widths * np.maximum(gaps[2], gaps[3]) > CURVED_DENSITY * integral)
            if np.any(endless):
                gaps = gaps[:, endless]
                break
            gaps = gaps[:, ~narrow]
    if gaps.size:
        warn(
            f"The density of source '{name}' is too rough: {len(chosen)} frequencies do not resolve it, such as at"
            f" {gaps[0, 0]:.6g} Hz. The root mean square may be wrong. Give `hertz`."
        )
    return np.unique(chosen)


def filled(hertz: np.ndarray) -> np.ndarray | None:
    """Frequencies with some added between, so that their number is one of few, each compiled once; None for none."""
    while len(hertz) > 1 and (short := -len(hertz) % PIECE):
        hertz = np.union1d(hertz, ((hertz[1:] + hertz[:-1]) / 2)[:short])
    return hertz if len(hertz) else None


def band_frequencies(
    poles: Complex[Array, "n"], low: float | None, high: float | None, more: Any = None
) -> tuple[Any, tuple[Any, Any]]:
    """Frequencies of a band, or of all poles, and the widths and places that they represent.

    They are at equal steps of N(f), the logarithm of f plus the phase of each pole: SPREAD steps by the former, BESIDE
    by each of the latter. A density over dN/df is then smooth. Frequencies ``more`` that a density requires stay fixed
    between.

    Returns frequencies, widths [Hz], and places in steps of N from the first, (n_f,) each (THEORY.md 14, eq. (14.37)).
    """
    sizes = jnp.abs(poles) / (2 * np.pi)
    end = 3 * jnp.max(sizes) if high is None else jnp.asarray(high)
    slowest = jnp.min(jnp.where(sizes > POLE_AT_REST * end, sizes, end))
    first = slowest / 30 if low is None else jnp.asarray(low) if low else jnp.minimum(slowest, end) * FIRST_OF_BAND
    # One of each pair.
    upper = poles[jnp.argsort(-jnp.imag(poles))][: (len(poles) + 1) // 2]
    place, width = jnp.imag(upper) / (2 * np.pi), jnp.abs(jnp.real(upper)) / (2 * np.pi)
    width = jnp.maximum(width, POLE_AT_REST * end)
    octaves = jnp.log(end / first)

    def counted(f: Float[Array, "k"]):
        phases = jnp.arctan((f[:, None] - place) / width) - jnp.arctan((first - place) / width)
        return SPREAD * jnp.log(f / first) / octaves + BESIDE / np.pi * jnp.sum(phases, axis=1)

    def rate(f: Float[Array, "k"]):
        beside = width / (width**2 + (f[:, None] - place) ** 2)
        return SPREAD / octaves / f + BESIDE / np.pi * jnp.sum(beside, axis=1)

    beside = place[:, None] + width[:, None] * np.tan(np.linspace(-1, 1, BESIDE) * np.arctan(WIDEST))
    even = first * (end / first) ** np.linspace(0, 1, SPREAD)
    knots = jnp.sort(jnp.concatenate([jnp.clip(beside.ravel(), first, end), even]))
    ends = counted(end[None])[0] * np.linspace(0, 1, len(knots))
    grid = jax.lax.stop_gradient(jnp.interp(ends, counted(knots), knots))
    for _ in range(3):
        # From constant frequencies, so that the last step has the whole derivative.
        grid = jax.lax.stop_gradient(grid)
        grid = jnp.clip(grid - (counted(grid) - ends) / rate(grid), first, end)
    step, places = ends[1] - ends[0], jnp.arange(len(knots), dtype=float)
    if more is not None:
        more = jnp.clip(more, first, end)
        grid, places = jnp.concatenate([grid, more]), jnp.concatenate([places, counted(more) / step])
        order = jnp.argsort(grid)
        grid, places = grid[order], places[order]
    return grid, (step / rate(grid), places)


def areas(values: Float[Array, "n y s"], places: Float[Array, "n"]) -> Float[Array, "n y s"]:
    """Cumulative integrals of values at places.

    By a parabola through three places at steps of one, else by the trapezoidal rule: values at frequencies that
    densities require may jump.
    """
    steps = jnp.diff(places)
    is_whole_step = jnp.pad(steps == 1.0, 1, constant_values=True)
    even = (is_whole_step[:-2] & is_whole_step[1:-1] & is_whole_step[2:])[:, None, None]
    slopes = jnp.concatenate([values[1:2] - values[:1], (values[2:] - values[:-2]) / 2, values[-1:] - values[-2:-1]])
    bent = jnp.where(even, (slopes[1:] - slopes[:-1]) / 12, 0.0)
    between = steps[:, None, None] * (values[1:] + values[:-1]) / 2 - bent
    return jnp.concatenate([jnp.zeros_like(values[:1]), jnp.cumsum(between, axis=0)])
