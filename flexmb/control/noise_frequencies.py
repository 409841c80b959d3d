"""Frequencies at which noise is summed: chosen by the poles and the densities, or by the responses of a loop."""

from collections.abc import Callable
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
# A density that is a function is looked at so often between two of SPREAD frequencies in equal ratios, and as often in
# equal steps: a line that is 1e-3 of its frequency wide at each side is met, also in a band that begins at STILL.
LOOKS = 64
# It is drawn where it leaves the straight line between two frequencies by this share of what it is there. FAINT of what
# it is at most within so many of the SPREAD to each side is added to that: beside a line its tails are nothing.
CURVED, ASIDE = 0.002, 16


def undamped_within(poles: Complex[Array, "n"], grid: Float[Array, "n_f"]) -> Bool[Array, "n"]:
    """Which poles are resonances without damping within frequencies."""
    sizes = jnp.abs(poles)
    hertz, largest = jnp.imag(poles) / (2 * np.pi), jnp.max(sizes)
    vibrates = (jnp.abs(jnp.real(poles)) <= DECAYS * largest) & (sizes > FREE * largest)
    return vibrates & (hertz >= grid[0]) & (hertz <= grid[-1])


def refined(lin: Any, loop: Controller, entries: tuple[tuple[int, ...], ...], grid: Any) -> np.ndarray:
    """Frequencies that draw the responses of a loop whose poles are not known: halved until these change by little.

    Warns where it takes too many; ValueError where numbers are traced by ``jax.jit``.
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

    def responses(hertz: Any):
        plant = response_of(lin, hertz, None, None, None, None).response
        of = closed_by_frequency(plant, known_gain(hertz), (loop.measured, loop.driven), *entries)
        return np.asarray(of).reshape(len(hertz), -1)

    known = _in_pieces(responses, grid)
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
        known = np.insert(known, coarse + 1, _in_pieces(responses, more), axis=0)
        grid = np.insert(grid, coarse + 1, more)
    if np.any(sharp):
        warn(
            f"The loop around a controller that is a function of frequencies is not drawn to the end by {len(grid)}"
            " frequencies: it has a resonance without damping, or a long delay. The root mean square may be off; give"
            " `hertz`, or damping."
        )
    return grid


def _in_pieces(of: Callable[[Any], Any], hertz: np.ndarray) -> np.ndarray:
    """What a function gives at frequencies, by calls of one size, each compiled once."""
    many = np.concatenate([hertz, np.full(-len(hertz) % PIECE, hertz[-1])])
    return np.concatenate([np.asarray(of(piece)) for piece in many.reshape(-1, PIECE)])[: len(hertz)]


def drawn(name: str, density: Callable[[Any], Any], low: float, high: float) -> np.ndarray:
    """Frequencies that draw a density beside those in equal ratios: halved until it is straight between two of them.

    Args:
        name: Name of the source.
        density: Density at frequencies, (PIECE,) [Hz], or one for all of them.
        low, high: Begin of the band, from 0 Hz a share of its end, and its end.

    Returns:
        (n,) [Hz], none where the density is smooth, or is traced. Warns where it takes too many.
    """
    low = low or STILL * high
    # Within jax.jit too, what is computed from known frequencies and known numbers is known.
    with jax.ensure_compile_time_eval():
        if not is_concrete(jax.lax.stop_gradient(density(np.full(PIECE, high)))):
            return np.zeros(0)

        def values(hertz: np.ndarray):
            return _in_pieces(lambda f: np.broadcast_to(np.asarray(jax.lax.stop_gradient(density(f))), f.shape), hertz)

        many = SPREAD * LOOKS
        grid = np.sort(np.concatenate([np.geomspace(low, high, many + 1), np.linspace(low, high, many + 2)[1:-1]]))
        known = values(grid)
        largest = np.max(known[:-1].reshape(-1, LOOKS), axis=1)
        around = np.lib.stride_tricks.sliding_window_view(np.pad(largest, ASIDE), 2 * ASIDE + 1)
        faint = FAINT * np.repeat(np.max(around, axis=1), LOOKS)
        # From wide to narrow, each with all that was looked at within.
        wanted, stride = np.zeros(len(grid), bool), LOOKS
        begins = np.zeros(0, int)
        while stride > 1:
            off = np.abs(known - np.interp(grid, grid[::stride], known[::stride]))[:-1].reshape(-1, stride)
            size = np.maximum(np.max(known[:-1].reshape(-1, stride), axis=1), known[stride::stride]) + faint[::stride]
            begins = np.flatnonzero(np.max(off, axis=1) > CURVED * size) * stride
            wanted[begins[:, None] + np.array([0, stride // 2, stride])] = True
            stride //= 2
        found, left = grid[wanted], np.concatenate([begins, begins + 1])
        # Then halved: frequencies and densities at both ends, and what is faint there.
        gaps = np.stack([grid[left], grid[left + 1], known[left], known[left + 1], faint[left]])
        whole = np.trapezoid(known, grid)
        while gaps.size and len(found) < MOST:
            a, b, at_a, at_b, least = gaps
            middle = (a + b) / 2
            at = values(middle)
            sharp = np.abs(at - (at_a + at_b) / 2) > CURVED * (np.maximum(np.maximum(at_a, at_b), at) + least)
            found = np.concatenate([found, middle[sharp]])
            halves = [a, middle, at_a, at, least], [middle, b, at, at_b, least]
            gaps = np.concatenate([np.stack(half)[:, sharp] for half in halves], axis=1)
            widths = gaps[1] - gaps[0]
            narrow = widths <= NARROWEST * gaps[1]
            endless = narrow & (widths * np.maximum(gaps[2], gaps[3]) > CURVED * whole)
            if np.any(endless):
                gaps = gaps[:, endless]
                break
            gaps = gaps[:, ~narrow]
    if gaps.size:
        warn(
            f"The density of source '{name}' is not drawn to the end by {len(found)} frequencies, such as at"
            f" {gaps[0, 0]:.6g} Hz: it is too rough there. The root mean square may be off; give `hertz`."
        )
    return np.unique(found)


def filled(hertz: np.ndarray) -> np.ndarray | None:
    """Frequencies, and some between them so that their number is one of few, each compiled once; None of none."""
    while len(hertz) > 1 and (short := -len(hertz) % PIECE):
        hertz = np.union1d(hertz, ((hertz[1:] + hertz[:-1]) / 2)[:short])
    return hertz if len(hertz) else None


def frequencies(
    poles: Complex[Array, "n"], low: float | None, high: float | None, more: Any = None
) -> tuple[Any, tuple[Any, Any]]:
    """Frequencies of a band, or where none is given of all poles, and the width in hertz that each stands for.

    They are at equal steps of N(f), the logarithm of f plus the phase of each pole: SPREAD steps by the former, BESIDE
    by each of the latter. So a density over dN/df is smooth; THEORY.md tells how right its sum is. Frequencies that a
    density asks for stand still between them.

    Args:
        poles: Poles, (n,) [rad/s].
        low, high: Begin and end of the band [Hz].
        more: Further frequencies, (k,) [Hz].

    Returns:
        Frequencies, (n_f,) [Hz]; their widths, (n_f,) [Hz], and places, in steps of N from the first, (n_f,).

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
    step, places = ends[1] - ends[0], jnp.arange(len(near), dtype=float)
    if more is not None:
        more = jnp.clip(more, first, end)
        found, places = jnp.concatenate([found, more]), jnp.concatenate([places, counted(more) / step])
        order = jnp.argsort(found)
        found, places = found[order], places[order]
    return found, (step / rate(found), places)


def areas(values: Float[Array, "n y s"], places: Float[Array, "n"]) -> Float[Array, "n y s"]:
    """What values at places add up to from the first to each.

    By a parabola through each three of them at steps of one, else by the trapezoidal rule, as between frequencies that
    densities ask for: what is halved until it is straight may jump.
    """
    steps = jnp.diff(places)
    whole = jnp.pad(steps == 1.0, 1, constant_values=True)
    even = (whole[:-2] & whole[1:-1] & whole[2:])[:, None, None]
    slopes = jnp.concatenate([values[1:2] - values[:1], (values[2:] - values[:-2]) / 2, values[-1:] - values[-2:-1]])
    bent = jnp.where(even, (slopes[1:] - slopes[:-1]) / 12, 0.0)
    between = steps[:, None, None] * (values[1:] + values[:-1]) / 2 - bent
    return jnp.concatenate([jnp.zeros_like(values[:1]), jnp.cumsum(between, axis=0)])
