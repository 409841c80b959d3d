"""Frequencies at which noise is summed: chosen by the poles, or where these are not known by the responses."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..arguments import is_concrete
from ..errors import warn
from .feedback import Controller, closed_by_frequency
from .frequency_response import response_of

# A motion decays whose pole has a real part beyond this share of the largest pole: round-off leaves less.
DECAYS = 1e-13
# Frequencies of a band: so many in equal ratios, and so many for each pole, spread as a resonance is, of a curve
# 1/(1 + x^2) to each an equal share; first tried out to x = WIDEST.
SPREAD, BESIDE, WIDEST = 200, 80, 100.0
# What moves freely has a pole of this share of the largest, by round-off.
FREE = 1e-7
# A band from 0 Hz begins at this share of the slowest pole or of its end, since what is an acceleration has moved
# without bounds at rest. A pole below that other share of its end is none.
FIRST, STILL = 1e-4, 1e-9
# Without poles responses change by this share from one frequency to the next at most, but for what is fainter than that
# share of the largest; so many are computed together, and so many there are at most.
LITTLE, FAINT, PIECE, MOST = 0.02, 1e-6, 256, 20000
# Nor are they nearer to each other than this share.
NARROWEST = 1e-9


def undamped_within(poles: Complex[Array, "n"], grid: Float[Array, "n_f"]) -> Bool[Array, "n"]:
    """Which poles are resonances without damping within frequencies."""
    sizes = jnp.abs(poles)
    hertz, largest = jnp.imag(poles) / (2 * np.pi), jnp.max(sizes)
    vibrates = (jnp.abs(jnp.real(poles)) <= DECAYS * largest) & (sizes > FREE * largest)
    return vibrates & (hertz >= grid[0]) & (hertz <= grid[-1])


def refined(lin: Any, loop: Controller, entries: tuple[tuple[int, ...], ...], grid: Any) -> np.ndarray:
    """Frequencies that draw the responses of a loop whose poles are not known: halved until these change by little.

    Raises:
        ValueError: Numbers are traced by ``jax.jit``.

    Warns:
        FlexmbWarning: It takes too many.
    """
    # Those of ``jax.grad`` alone are concrete without their derivatives, which a frequency need not have.
    lin, grid = jax.lax.stop_gradient((lin, grid))

    def known_gain(hertz: Any) -> Any:
        found = jax.lax.stop_gradient(loop.by_frequency(hertz))
        if not is_concrete((found, lin, grid)):
            raise ValueError(
                "Beside a controller that is a function of frequencies those of a `band` are chosen by concrete"
                " numbers: give `hertz` under jax.jit."
            )
        return found

    known_gain(np.ones(1))
    grid = np.asarray(grid)

    def responses(hertz: np.ndarray):
        # In pieces of one size, each compiled once.
        many: Any = np.concatenate([hertz, np.full(-len(hertz) % PIECE, hertz[-1])])
        found = []
        for piece in many.reshape(-1, PIECE):
            plant = response_of(lin, piece, None, None, None, None).response
            of = closed_by_frequency(plant, known_gain(piece), (loop.measured, loop.driven), *entries)
            found.append(np.asarray(of).reshape(PIECE, -1))
        return np.concatenate(found)[: len(hertz)]

    known = responses(grid)
    while True:
        # Across a resonance halfway between two frequencies their sizes are equal, but not their phases.
        size = np.abs(known)
        size = np.maximum(size[1:], size[:-1]) + FAINT * np.max(size, axis=0)
        steps = np.max(np.abs(np.diff(known, axis=0)) / np.where(size > 0, size, 1.0), axis=1, initial=0.0)
        sharp = steps > LITTLE
        coarse = np.flatnonzero(sharp & (np.diff(grid) > NARROWEST * grid[1:]))
        if not len(coarse) or len(grid) >= MOST:
            break
        more = np.sqrt(grid[coarse] * grid[coarse + 1])
        grid, known = np.insert(grid, coarse + 1, more), np.insert(known, coarse + 1, responses(more), axis=0)
    if np.any(sharp):
        warn(
            f"The loop around a controller that is a function of frequencies is not drawn to the end by {len(grid)}"
            " frequencies: it has a resonance without damping, or a long delay. The root mean square may be off; give"
            " `hertz`, or damping."
        )
    return grid


def frequencies(poles: Complex[Array, "n"], low: float | None, high: float | None) -> tuple[Any, Any]:
    """Frequencies of a band, or where none is given of all poles, and the width in hertz that each stands for.

    They are at equal steps of N(f), the logarithm of f plus the phase of each pole: SPREAD steps by the former, BESIDE
    by each of the latter. So a density over dN/df is smooth, however sharp the resonances are.

    Source:
        THEORY.md 14, eq. (14.37).
    """
    sizes = jnp.abs(poles) / (2 * np.pi)
    end = 3 * jnp.max(sizes) if high is None else jnp.asarray(high)
    slowest = jnp.min(jnp.where(sizes > STILL * end, sizes, end))
    first = slowest / 30 if low is None else jnp.asarray(low) if low else jnp.minimum(slowest, end) * FIRST
    # Of each pair one.
    upper = poles[jnp.argsort(-jnp.imag(poles))][: (len(poles) + 1) // 2]
    place, width = jnp.imag(upper) / (2 * np.pi), jnp.abs(jnp.real(upper)) / (2 * np.pi)
    width = jnp.maximum(width, STILL * end)
    octaves = jnp.log(end / first)

    def counted(f: Float[Array, "k"]):
        phases = jnp.arctan((f[:, None] - place) / width) - jnp.arctan((first - place) / width)
        return SPREAD * jnp.log(f / first) / octaves + BESIDE / np.pi * jnp.sum(phases, axis=1)

    def rate(f: Float[Array, "k"]):
        beside = width / (width**2 + (f[:, None] - place) ** 2)
        return SPREAD / octaves / f + BESIDE / np.pi * jnp.sum(beside, axis=1)

    beside = place[:, None] + width[:, None] * np.tan(np.linspace(-1, 1, BESIDE) * np.arctan(WIDEST))
    even = first * (end / first) ** np.linspace(0, 1, SPREAD)
    near = jnp.sort(jnp.concatenate([jnp.clip(beside.ravel(), first, end), even]))
    ends = counted(end[None])[0] * np.linspace(0, 1, len(near))
    found = jax.lax.stop_gradient(jnp.interp(ends, counted(near), near))
    for _ in range(3):
        # From fixed frequencies, so that the last step carries the whole derivative.
        found = jax.lax.stop_gradient(found)
        found = jnp.clip(found - (counted(found) - ends) / rate(found), first, end)
    return found, (ends[1] - ends[0]) / rate(found)


def areas(values: Float[Array, "n y s"]) -> Float[Array, "n y s"]:
    """What values at equal steps add up to from the first to each, by a parabola through each three of them."""
    slopes = jnp.concatenate([values[1:2] - values[:1], (values[2:] - values[:-2]) / 2, values[-1:] - values[-2:-1]])
    between = (values[1:] + values[:-1]) / 2 - (slopes[1:] - slopes[:-1]) / 12
    return jnp.concatenate([jnp.zeros_like(values[:1]), jnp.cumsum(between, axis=0)])
