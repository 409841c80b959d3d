"""A state space of the modes that matter: which they are, what follows them statically, and the error that is left."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_whole, check_number, check_whole, is_concrete, shown
from ..errors import warn
from ..linear.linearize import Linearization
from ..linear.modes import check_spectrum, modal_frequencies, refuse_unsymmetric
from ..linear.spectrum import shift_to_definite, spectrum
from ..math.linear import factorise
from .second_order_form import SecondOrder

# Above this error a truncated state space is warned of.
TOLERANCE = 0.01
# A mode below this share of the highest frequency does not vibrate: its frequency is that of round-off.
STILL = 1e-7
# Frequencies at which responses are compared: so many over two decades, and these beside each mode.
POINTS = 120
BESIDE = 1 + np.array([-1e-2, -1e-3, 1e-3, 1e-2])
# What responds by less than this share of what a force along it and the input along itself do, does so by round-off.
IDLE = 1e-9


def chosen_modes(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[int, ...]:
    """Numbers of the modes to keep, from 0, ascending.

    Args:
        lin: Linearization of one state.
        modes: How many of the lowest, or which, from 0; or None.
        bandwidth: Frequency up to which modes are kept [Hz]; or None.

    Raises:
        ValueError: Both are given, the numbers are no modes, no mode is below the bandwidth, one that does not vibrate
            is left out, or a bandwidth is given under a trace.
        NotImplementedError: The stiffness is unsymmetric.
        AnalysisError: As :func:`flexmb.modes`.
    """
    if modes is not None and bandwidth is not None:
        raise ValueError("Give `modes` or `bandwidth`, not both: each says which modes are kept.")
    refuse_unsymmetric(lin.matrices.symmetric)
    if lin.matrices.M0.ndim > 2:
        raise ValueError("Modes are those of one state, and this linearisation is along a motion: give lin.at_time(0).")
    traced = not is_concrete((lin.matrices, bandwidth))
    if traced:
        if bandwidth is not None:
            raise ValueError("Which modes are below a `bandwidth` depends on numbers: give `modes` under a trace.")
        return numbered(modes, lin.matrices.M0.shape[0])
    hertz, result = (np.asarray(of) for of in modal_frequencies(lin))
    check_spectrum(result, True, lin)
    hertz = hertz[np.isfinite(hertz)]
    if bandwidth is not None:
        check_number("bandwidth", bandwidth, above=0)
        found = tuple(np.flatnonzero(hertz <= bandwidth).tolist())
        if not found:
            raise ValueError(
                f"Argument `bandwidth` = {shown(bandwidth)} Hz is below the first mode, {hertz[0]:.5g} Hz, so that no"
                " state would be left: up to there the response is that at rest, dcgain() of the full state space."
            )
    else:
        found = numbered(modes, len(hertz))
    refuse_left_out(found, hertz)
    return found


def refuse_left_out(kept: tuple[int, ...], hertz: Float[np.ndarray, "modes"]) -> None:
    """Refuse to leave out a mode that does not vibrate.

    Args:
        kept: Numbers of the modes that are kept, from 0.
        hertz: Frequencies of the modes, ascending, (modes,) [Hz].

    Raises:
        ValueError: One is left out.
    """
    out = [i for i in range(len(hertz)) if i not in kept and hertz[i] <= STILL * hertz[-1]]
    if out:
        raise ValueError(
            f"Mode {out[0] + 1} does not vibrate ({hertz[out[0]]:.3g} Hz), so that it cannot follow at once: keep it,"
            f" as number {out[0]} of `modes`."
        )


def numbered(modes: Any, count: int) -> tuple[int, ...]:
    """Numbers of the modes that the argument `modes` says, from 0, ascending.

    Args:
        modes: How many of the lowest, or which, from 0.
        count: How many there are.

    Raises:
        TypeError: It is neither.
        ValueError: There are not so many, or a number stands twice.
    """
    if (whole := as_whole(modes)) is not None:
        if not 1 <= whole <= count:
            raise ValueError(f"Argument `modes` must be from 1 to {count}, the number of modes, but is {whole}.")
        return tuple(range(whole))
    if not isinstance(modes, list | tuple | range | np.ndarray) or np.ndim(modes) != 1 or not len(modes):
        raise TypeError(f"Argument `modes` must be a whole number, or numbers of modes from 0, not {shown(modes)}.")
    found = [check_whole("modes", number) for number in modes]
    if len(set(found)) < len(found) or min(found) < 0 or max(found) >= count:
        raise ValueError(
            f"Argument `modes` must be numbers of modes from 0 to {count - 1}, each once, but is {shown(modes)}."
        )
    return tuple(sorted(found))


def truncated(
    k: Float[Array, "n_q n_q"], m: Float[Array, "n_q n_q"], kept: tuple[int, ...]
) -> tuple[Float[Array, "n_q k"], Callable[[Float[Array, "n_q f"]], Float[Array, "n_q f"]]]:
    """Mode shapes that are kept, and the displacements by which all other motions follow forces at once.

    Args:
        k: Stiffness, (n_q, n_q).
        m: Mass, (n_q, n_q).
        kept: Numbers of the modes.

    Returns:
        Mass-normalised shapes, (n_q, k), and what makes of forces along the degrees of freedom, one a column,
        (n_q, f), the displacements, (n_q, f).

    Source:
        THEORY.md 7, eq. (7.14): (K + s M0)^-1 of forces that do not move the modes that are kept, and plus what s takes
        from the others.
    """
    shift, _, _ = shift_to_definite(k, m)
    values, shapes, _, _ = spectrum(k, m)
    own, others = np.array(kept), np.array([i for i in range(len(values)) if i not in kept], int)
    keep, left = shapes[:, own], shapes[:, others]
    inertia = m @ keep
    # Motions without mass have infinite values and no shape: they are in the first term.
    massive = jnp.isfinite(values[others])
    rest = jnp.where(massive, values[others], 1.0)
    factors = factorise(k + shift * m)
    share = jnp.where(massive, shift / (rest * (rest + shift)), 0.0)

    def follows(forces: Float[Array, "n_q f"]):
        direct = factors.solve(forces - inertia @ (keep.T @ forces))
        # What is kept would swamp the rest by its round-off, where it has little stiffness.
        direct = direct - keep @ (inertia.T @ direct)
        return direct + left @ ((left.T @ forces) * share[:, None])

    return keep, follows


def error_of(
    lin: Linearization, kept: tuple[int, ...], bandwidth: float | None, whole: SecondOrder, small: Any
) -> Float[np.ndarray, "n_y n_u"]:
    """Largest error of a truncated state space in its band, measured against the full one, and told where it is large.

    Args:
        lin: Linearization.
        kept: Numbers of the modes that are kept.
        bandwidth: End of the band [Hz]; the highest mode that is kept unless given.
        whole: Second-order form of all modes, in plain numbers.
        small: A, B, C and D of the truncated state space.

    Returns:
        (n_y, n_u) [-]: difference of the responses over the larger of the full one there and its median within half an
        octave to both sides; the median keeps an antiresonance from counting.

    Warns:
        FlexmbWarning: It is above a hundredth.
    """
    hertz = np.asarray(modal_frequencies(lin)[0])
    hertz = hertz[np.isfinite(hertz)]
    end = float(np.max(hertz[list(kept)])) if bandwidth is None else bandwidth
    if end <= STILL * hertz[-1]:
        # All that is kept moves without stiffness: the band ends well below what vibrates.
        end = float(np.min(hertz[hertz > STILL * hertz[-1]], initial=hertz[-1])) / 10 or 1.0
    grid = compared_at(end, hertz, POINTS, BESIDE)
    shape = len(lin.labels.outputs), len(lin.labels.inputs)
    full, least = [], np.zeros(shape)
    for f in grid:
        s = 2j * np.pi * f
        stiffness, forces, by_q, through = whole.at(s)
        moved, sensed = np.split(np.linalg.solve(stiffness, np.column_stack([forces, by_q.T])), [shape[1]], 1)
        full.append(by_q @ moved + through)
        sizes = np.abs(np.sum(by_q.T * sensed, axis=0)), np.abs(np.sum(forces * moved, axis=0))
        least = np.maximum(least, IDLE * np.sqrt(np.outer(*sizes)))
    a, b, c, d = (np.asarray(of) for of in small)
    eye = np.eye(len(a))
    own = np.array([c @ np.linalg.solve(2j * np.pi * f * eye - a, b) + d for f in grid])
    return tell_of_error(lin, grid, np.array(full), own, least, end, len(kept), len(hertz))


def compared_at(end: float, hertz: np.ndarray, points: int, beside: np.ndarray) -> np.ndarray:
    """Frequencies of a band at which responses are compared; none is a resonance, where undamped ones have no end.

    Args:
        end: Of the band [Hz].
        hertz: Of modes, (modes,) [Hz].
        points: So many over the two decades below the end.
        beside: And these beside each mode, as shares of its frequency, (k,) [-].

    Returns:
        Ascending, (n,) [Hz].
    """
    near = np.outer(hertz, beside).ravel()
    grid = np.unique(np.concatenate([end * np.logspace(-2, 0, points), near[(near > 1e-2 * end) & (near <= end)]]))
    return grid[np.all(np.abs(grid[:, None] - hertz) > np.min(np.abs(BESIDE - 1)) / 2 * grid[:, None], axis=1)]


def tell_of_error(
    lin: Any,
    grid: np.ndarray,
    full: np.ndarray,
    own: np.ndarray,
    least: np.ndarray,
    end: float,
    kept: int,
    of: int | None,
) -> Float[np.ndarray, "n_y n_u"]:
    """Largest error of responses, told where it is large.

    Args:
        lin: Linearization, for the names.
        grid: Frequencies, (n_f,) [Hz].
        full: Right responses, (n_f, n_y, n_u).
        own: Those of the truncated state space.
        least: What is nothing beside it, (n_y, n_u).
        end: End of the band [Hz].
        kept: How many modes are kept.
        of: Of how many; None where no one knows.

    Returns:
        (n_y, n_u) [-], as of :func:`error_of`.

    Warns:
        FlexmbWarning: It is above a hundredth.
    """
    size = np.abs(full)
    near = np.abs(np.log2(grid[:, None] / grid)) <= 0.5
    usual = np.maximum(size, np.array([np.median(size[row], axis=0) for row in near]))
    idle = np.max(size, axis=0) <= least
    errors = np.where(idle, 0.0, np.abs(own - full) / np.where(usual > 0, usual, 1.0))
    error = np.max(errors, axis=0, initial=0.0)
    if np.max(error, initial=0.0) > TOLERANCE:
        # The first of those that are equal but for round-off, as velocity and acceleration are.
        at, y, u = np.unravel_index(np.argmax(errors >= (1 - 1e-9) * np.max(errors)), errors.shape)
        output, source = lin.labels.outputs[y].name, lin.labels.inputs[u].name
        some = f"{kept}" if of is None else f"{kept} of {of}"
        warn(
            f"The state space of {some} modes is off by {100 * error[y, u]:.2g} % for '{output}' of"
            f" '{source}' at {grid[at]:.4g} Hz, in its band up to {end:.4g} Hz. Keep more modes, by `modes` or a"
            " larger `bandwidth`."
        )
    return error
