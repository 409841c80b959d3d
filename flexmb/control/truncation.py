"""A state space of few modes: which modes, the static response of the others, and the error that is left."""

from collections.abc import Callable, Iterator
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, as_whole, by_library, check_number, check_whole, is_concrete, short_repr
from ..errors import warn
from ..linear.linearize import Linearization
from ..linear.modes import check_spectrum, modal_frequencies, refuse_unsymmetric
from ..linear.sparse_solve import lowest, sparse_solution
from ..linear.spectrum import shift_to_definite, spectrum, to_frequency
from ..math.by_deformations import motions_from_free
from ..math.element_matrices import matrix_times, quadratic_form
from ..math.linear import factorise
from ..numerical_limits import FREE_POLE, NEGLIGIBLE, REPORTED_ERROR
from .harmonic import solutions
from .second_order_form import LargeSecondOrder, SecondOrder, large_second_order

# Frequencies at which responses are compared, over two decades, and beside each mode; fewer for a large mechanism,
# where each needs factors.
POINTS, FEW_POINTS = 120, 40
BESIDE = 1 + np.array([-1e-2, -1e-3, 1e-3, 1e-2])
# Modes of a large mechanism computed first for a bandwidth.
FIRST = 8


def retained_modes(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[int, ...]:
    """Ascending numbers of the modes to keep in degrees of freedom, from 0; raise for wrong `modes` or `bandwidth`."""

    def every(_: int):
        hertz, result = map(np.asarray, modal_frequencies(lin))
        check_spectrum(result, True, lin)
        return hertz[np.isfinite(hertz)], None

    _refuse_both_given(lin, modes, bandwidth)
    if lin.matrices.M0.ndim > 2:
        raise ValueError("Modes need one state, but this linearisation is along a motion. Give lin.at_time(0).")
    if not is_concrete((lin.matrices, bandwidth)):
        return ascending_modes(modes, lin.matrices.M0.shape[0])
    hertz, _ = every(0)
    kept_modes = ascending_modes(modes, len(hertz)) if bandwidth is None else _below(bandwidth, len(hertz), every)[0]
    _refuse_left_out(kept_modes, hertz)
    return kept_modes


def _refuse_both_given(lin: Linearization, modes: Any, bandwidth: Any) -> None:
    if modes is not None and bandwidth is not None:
        raise ValueError("Give `modes` or `bandwidth`, not both: each chooses the modes to keep.")
    refuse_unsymmetric(lin.symmetric)
    if bandwidth is not None and not is_concrete((lin.matrices, bandwidth)):
        raise ValueError("The modes below a `bandwidth` depend on traced numbers. Give `modes` under a trace.")


def _below(bandwidth: Any, most: int, lowest_of: Callable[[int], tuple[Any, Any]]) -> tuple[tuple[int, ...], Any]:
    """Modes up to a frequency, and the result of ``lowest_of``, which computes a number of the lowest."""
    check_number("bandwidth", bandwidth, above=0)
    count = FIRST
    while True:
        hertz, answer = lowest_of(min(count, most))
        below = np.flatnonzero(hertz <= bandwidth)
        if not len(below):
            raise ValueError(
                f"Argument `bandwidth` = {short_repr(bandwidth)} Hz is below the first mode, {hertz[0]:.5g} Hz. No"
                " state would be left. Up to there the response is static: fm.frequency_response(model, 0.0)."
            )
        if len(below) < len(hertz) or count >= most:
            return tuple(below.tolist()), answer
        count *= 2


def _refuse_left_out(kept_modes: tuple[int, ...], hertz: Float[np.ndarray, "modes"]) -> None:
    """Refuse to leave out a mode that does not vibrate, by ascending frequencies."""
    out = [i for i in range(len(hertz)) if i not in kept_modes and hertz[i] <= FREE_POLE * hertz[-1]]
    if out:
        raise ValueError(
            f"Mode {out[0] + 1} does not vibrate ({hertz[out[0]]:.3g} Hz) and cannot follow statically. Keep it, as"
            f" number {out[0]} of `modes`."
        )


def ascending_modes(modes: Any, count: int) -> tuple[int, ...]:
    """Ascending numbers of modes from the argument `modes`, for a count of modes."""
    if (n_modes := as_whole(modes)) is not None:
        if not 1 <= n_modes <= count:
            raise ValueError(f"Argument `modes` must be from 1 to {count}, the number of modes, but is {n_modes}.")
        return tuple(range(n_modes))
    if not isinstance(modes, list | tuple | range | np.ndarray) or np.ndim(modes) != 1 or not len(modes):
        raise TypeError(
            f"Argument `modes` must be a whole number, or numbers of modes from 0, not {short_repr(modes)}."
        )
    numbers = [check_whole("modes", number) for number in modes]
    if len(set(numbers)) < len(numbers) or min(numbers) < 0 or max(numbers) >= count:
        raise ValueError(
            f"Argument `modes` must be numbers of modes from 0 to {count - 1}, each once, but is {short_repr(modes)}."
        )
    return tuple(sorted(numbers))


def truncated(
    k: Float[Array, "n_q n_q"], m: Float[Array, "n_q n_q"], kept: tuple[int, ...]
) -> tuple[Float[Array, "n_q k"], Callable[[Float[Array, "n_q f"]], Float[Array, "n_q f"]]]:
    """Mass-normalised kept shapes, and the function that returns the static response of all other motions to forces.

    THEORY.md 7, eq. (7.14): (K + s M0)^-1 of forces that do not move kept modes, plus what s takes from the others.
    """
    shift, *_ = shift_to_definite(k, m)
    values, shapes, _, _ = spectrum(k, m)
    others = np.array([i for i in range(len(values)) if i not in kept], int)
    keep, other_shapes = shapes[:, np.array(kept)], shapes[:, others]
    inertia = m @ keep
    # Motions without mass have infinite values and no shape: the first term includes them.
    massive = jnp.isfinite(values[others])
    other_values = jnp.where(massive, values[others], 1.0)
    factors = factorise(k + shift * m)
    share = jnp.where(massive, shift / (other_values * (other_values + shift)), 0.0)

    def follows(forces: Float[Array, "n_q f"]):
        direct = factors.solve(forces - inertia @ (keep.T @ forces))
        # Round-off of soft kept modes would exceed the rest.
        direct = direct - keep @ (inertia.T @ direct)
        return direct + other_shapes @ ((other_shapes.T @ forces) * share[:, None])

    return keep, follows


def by_modes(
    lin: Linearization, modes: Any, bandwidth: float | None
) -> tuple[SecondOrder, LargeSecondOrder, tuple[int, ...], Float[Array, "n"]]:
    """Equations of a few modes of a large mechanism (THEORY.md 7, eq. (7.14), with R B_u from (7.17)).

    Returns the second-order form in amplitudes of the kept modes, where D0 includes all other motions at rest; the form
    in all coordinates; numbers of the kept modes, from 0, ascending; and frequencies of all modes up to the highest one
    kept [Hz].

    Raises as :func:`retained_modes`, ModelError for an input that moves nothing, and singular_stiffness for a motion
    without stiffness that is not kept.
    """
    _refuse_both_given(lin, modes, bandwidth)
    if modes is None and bandwidth is None:
        raise ValueError("A state space of a large mechanism needs a choice of few modes. Give `modes` or `bandwidth`.")
    return by_library(_by_modes, lin, modes, bandwidth)


def _by_modes(lin: Linearization, modes: Any, bandwidth: float | None, library: Any):
    """:func:`by_modes` by NumPy, from NumPy arrays, or by JAX."""
    large_form = large_second_order(lin)
    elements, n_x, (n, h) = lin.elements, lin.x.shape[0], lin.elements.unknowns

    def lowest_of(count: int):
        answer: Any = as_known(lowest(elements, count, lin.solver))
        return as_known(to_frequency(answer.values)), answer

    if bandwidth is None:
        kept_modes = ascending_modes(modes, n - h)
        modal = lowest_of(max(kept_modes) + 1)[1]
    else:
        kept_modes, modal = _below(bandwidth, n - h, lowest_of)
    hertz = as_known(to_frequency(modal.values))
    if is_concrete(hertz):
        hertz = hertz[np.isfinite(hertz)]
        if max(kept_modes) >= len(hertz):
            raise ValueError(f"Argument `modes` = {short_repr(modes)}: {len(hertz)} modes of this mechanism have mass.")
        _refuse_left_out(kept_modes, np.asarray(hertz))
    values, shapes = modal.values[np.array(kept_modes)], modal.motions[:, np.array(kept_modes)]
    # All others follow at once the inputs with their rates, and the damping of kept modes.
    by_p = [b * (large_form.orders >= i).astype(float) for i, b in enumerate(large_form.B)]
    acting = library.concatenate([*by_p, -matrix_times(elements.damping, shapes, size=n_x)], axis=1)[elements.free]
    border = matrix_times(elements.mass, shapes, size=n_x)[elements.free]
    right = library.concatenate([acting, library.zeros((h, acting.shape[1]))])
    follows = motions_from_free(elements, as_known(sparse_solution(elements, right, border))[: acting.shape[0]])
    n_u = len(large_form.orders)
    *at_once, by_rates = library.split(large_form.C[0] @ follows, [n_u, 2 * n_u, 3 * n_u], axis=1)
    d, (places, rates, second) = large_form.D + library.stack(at_once), large_form.C @ shapes
    parts: list[Any] = [
        library.eye(len(kept_modes)),
        quadratic_form(elements.damping, shapes, shapes),
        library.diag(values),
    ]
    parts += [*(shapes.T @ b for b in large_form.B), places, rates + by_rates, second, *d]
    form = SecondOrder(*parts, orders=large_form.orders, moves=large_form.moves)
    return form, large_form, kept_modes, hertz


def _solved(whole: SecondOrder, grid: np.ndarray) -> Iterator[tuple[Any, ...]]:
    """At each frequency: B, C, D, and the motions by inputs and by outputs as forces."""
    for s in 2j * np.pi * grid:
        stiffness, forces, rows, through = whole.at(s)
        solved_both = np.linalg.solve(stiffness, np.column_stack([forces, rows.T]))
        yield forces, rows, through, *np.split(solved_both, [forces.shape[1]], 1)


def _solved_by_elements(large_form: LargeSecondOrder, grid: np.ndarray) -> Iterator[tuple[Any, ...]]:
    """:func:`_solved` in all coordinates."""
    n_u, n = large_form.B.shape[2], large_form.elements.unknowns[0]
    free, w = np.asarray(large_form.elements.free), 2 * np.pi * grid
    b, c, d = map(np.asarray, large_form[1:4])
    solved_at = np.asarray(
        solutions(large_form.elements, w, large_form.B.astype(complex), large_form.C.astype(complex))
    )
    for s, z in zip(1j * w, solved_at, strict=True):
        by_u, powers = s ** -large_form.orders.astype(float), s ** np.arange(3)
        forces, rows, through = (np.tensordot(powers, m, 1) for m in (b[:, free], c[:, :, free], d))
        yield forces * by_u, rows, through * by_u, z[:n, :n_u] * by_u, z[:n, n_u:]


def _band(
    kept_modes: tuple[int, ...], bandwidth: float | None, hertz: np.ndarray, points: int, beside: np.ndarray
) -> tuple[float, np.ndarray]:
    """End of a band [Hz], and frequencies over two decades below it and beside each mode, none at a resonance."""
    end = float(np.max(hertz[list(kept_modes)])) if bandwidth is None else bandwidth
    if end <= 0 or end <= FREE_POLE * hertz[-1]:
        # All kept modes have no stiffness: the band ends well below vibrations.
        vibrates = hertz[(hertz > 0) & (hertz > FREE_POLE * hertz[-1])]
        end = float(np.min(vibrates)) / 10 if len(vibrates) else 1.0
    beside_modes = np.outer(hertz, beside).ravel()
    grid = np.unique(
        np.concatenate(
            [end * np.logspace(-2, 0, points), beside_modes[(beside_modes > 1e-2 * end) & (beside_modes <= end)]]
        )
    )
    off_resonance = np.abs(grid[:, None] - hertz) > np.min(np.abs(BESIDE - 1)) / 2 * grid[:, None]
    return end, grid[np.all(off_resonance, axis=1)]


def error_of(
    lin: Linearization,
    whole: SecondOrder | LargeSecondOrder,
    small: Any,
    kept: tuple[int, ...],
    hertz: np.ndarray,
    bandwidth: float | None,
) -> Float[np.ndarray, "n_y n_u"]:
    """Largest error of a truncated state space in its band, (n_y, n_u) [-]; warns above a hundredth.

    It is the difference of responses over the larger of the full one and its median within half an octave to both
    sides, so that an antiresonance does not count. ``whole`` is the form of all modes, ``small`` the truncated state
    space, ``hertz`` the known frequencies of all modes. A large form is compared at fewer frequencies.
    """
    if isinstance(whole, LargeSecondOrder):
        end, grid = _band(kept, bandwidth, hertz, FEW_POINTS, BESIDE[[0, -1]])
        full, some = _solved_by_elements(whole, grid), str(len(kept))
    else:
        end, grid = _band(kept, bandwidth, hertz, POINTS, BESIDE)
        full, some = _solved(whole, grid), f"{len(kept)} of {len(hertz)}"
    removed = np.delete(hertz, [i for i in kept if i < len(hertz)])
    a, b, c, d = map(np.asarray, small)
    right, truncated_responses, least = [], [], np.zeros(d.shape)
    for s, (forces, rows, through, moved, sensed) in zip(2j * np.pi * grid, full, strict=True):
        right.append(rows @ moved + through)
        truncated_responses.append(c @ np.linalg.solve(s * np.eye(len(a)) - a, b) + d)
        sizes = np.abs(np.sum(rows.T * sensed, axis=0)), np.abs(np.sum(forces * moved, axis=0))
        least = np.maximum(least, NEGLIGIBLE * np.sqrt(np.outer(*sizes)))
    right = np.array(right)
    difference = np.abs(np.array(truncated_responses) - right)
    size, same_octave = np.abs(right), np.abs(np.log2(grid[:, None] / grid)) <= 0.5
    usual = np.maximum(size, np.array([np.median(size[row], axis=0) for row in same_octave]))
    errors = np.where(np.max(size, axis=0) <= least, 0.0, difference / np.where(usual > 0, usual, 1.0))
    error = np.max(errors, axis=0, initial=0.0)
    if np.max(error, initial=0.0) > REPORTED_ERROR:
        # The first of several values that are equal but for round-off, such as of velocity and acceleration.
        at, y, u = np.unravel_index(np.argmax(errors >= (1 - 1e-9) * np.max(errors)), errors.shape)
        output, source = lin.labels.outputs[y].name, lin.labels.inputs[u].name
        nearest = removed[np.argsort(np.abs(removed - grid[at]))[:1]]
        beside = "".join(f" The nearest mode that is left out is at {hertz:.5g} Hz." for hertz in nearest)
        warn(
            f"The state space of {some} modes is off by {100 * error[y, u]:.2g} % for '{output}' of"
            f" '{source}' at {grid[at]:.4g} Hz, in its band up to {end:.4g} Hz.{beside} Keep more modes, by `modes` or"
            " a larger `bandwidth`."
        )
    return error
