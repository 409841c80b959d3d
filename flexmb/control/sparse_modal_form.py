"""Large mechanisms by few modes: second-order form of their amplitudes, with all other motions following at rest."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, by_library, check_number, is_concrete, shown
from ..linear.linearize import Linearization
from ..linear.modes import refuse_unsymmetric
from ..linear.sparse_solve import lowest, solved
from ..linear.spectrum import to_frequency
from ..math.by_deformations import spread
from ..math.element_matrices import between, times
from .second_order_form import SecondOrder
from .sparse_response import solutions
from .sparse_second_order import SparseSecondOrder, sparse_second_order
from .truncation import BESIDE, IDLE, STILL, compared_at, numbered, refuse_left_out, tell_of_error

# So many frequencies, over two decades, at which responses are compared, beside those near each mode.
POINTS = 40
# So many modes are looked for at first where a bandwidth says how many there are.
FIRST = 8


class ByModes(NamedTuple):
    """Second-order form of a few modes of a large mechanism.

    Attributes:
        form: In amplitudes of the modes that are kept; what all other motions add at rest is in D0.
        whole: In all coordinates.
        kept: Numbers of the modes, from 0, ascending.
        hertz: Frequencies of all modes up to the highest that is kept, (n,) [Hz].
    """

    form: SecondOrder
    whole: SparseSecondOrder
    kept: tuple[int, ...]
    hertz: Float[Array, "n"]


def by_modes(lin: Linearization, modes: Any, bandwidth: float | None) -> ByModes:
    """Equations of a few modes of a large mechanism.

    Args:
        lin: Linearization; differentiable in the model's parameters.
        modes: How many of the lowest, or which, from 0; or None.
        bandwidth: Frequency up to which modes are kept [Hz]; or None.

    Raises:
        ValueError: As :func:`flexmb.state_matrices`; neither ``modes`` nor ``bandwidth`` is given.
        ModelError: There are not so many modes, or an input moves nothing.
        AnalysisError: singular_stiffness, where a motion without stiffness is not kept.
        NotImplementedError: The stiffness is unsymmetric, which gives no modes.

    Source:
        THEORY.md 7, eq. (7.14), with R B_u from (7.17).
    """
    refuse_unsymmetric(lin.symmetric)
    return by_library(_by_modes, lin, modes, bandwidth)


def _by_modes(lin: Linearization, modes: Any, bandwidth: float | None, library: Any) -> ByModes:
    """The same by NumPy, of arrays of its own, or by JAX."""
    whole = sparse_second_order(lin)
    kept, found = _chosen(lin, modes, bandwidth)
    elements, (n_x, h) = lin.elements, (lin.x.shape[0], lin.elements.unknowns[1])
    hertz = as_known(to_frequency(found.values))
    if is_concrete(hertz):
        hertz = hertz[np.isfinite(hertz)]
        if max(kept) >= len(hertz):
            raise ValueError(f"Argument `modes` = {shown(modes)}: {len(hertz)} modes of this mechanism have mass.")
        refuse_left_out(kept, np.asarray(hertz))
    own = np.array(kept)
    values, shapes = found.values[own], found.motions[:, own]
    # What all others follow at once: the inputs with those rates that they have, and the damping of what is kept.
    by_p = [of * (whole.orders >= i).astype(float) for i, of in enumerate(whole.B)]
    acting = library.concatenate([*by_p, -times(elements.damping, shapes, size=n_x)], axis=1)[elements.free]
    border = times(elements.mass, shapes, size=n_x)[elements.free]
    right = library.concatenate([acting, library.zeros((h, acting.shape[1]))])
    follows = spread(elements, as_known(solved(elements, right, border))[: acting.shape[0]])
    n_u = len(whole.orders)
    *at_once, by_rates = library.split(whole.C[0] @ follows, [n_u, 2 * n_u, 3 * n_u], axis=1)
    d, (places, rates, second) = whole.D + library.stack(at_once), whole.C @ shapes
    parts: list[Any] = [library.eye(len(own)), between(elements.damping, shapes, shapes), library.diag(values)]
    parts += [*(shapes.T @ of for of in whole.B), places, rates + by_rates, second, *d]
    form = SecondOrder(*parts, orders=whole.orders, moves=whole.moves)
    return ByModes(form, whole, kept, hertz)


def _chosen(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[tuple[int, ...], Any]:
    """Numbers of the modes to keep, and all modes up to the highest of them."""
    if modes is not None and bandwidth is not None:
        raise ValueError("Give `modes` or `bandwidth`, not both: each says which modes are kept.")
    if modes is None and bandwidth is None:
        raise ValueError(
            "A state space of a large mechanism is one of few modes: say how many by `modes`, or by `bandwidth`."
        )
    if bandwidth is None:
        n, h = lin.elements.unknowns
        kept = numbered(modes, n - h)
        return kept, as_known(lowest(lin.elements, max(kept) + 1))
    if not is_concrete((lin.elements, bandwidth)):
        raise ValueError("Which modes are below a `bandwidth` depends on numbers: give `modes` under a trace.")
    check_number("bandwidth", bandwidth, above=0)
    count = FIRST
    while True:
        n, h = lin.elements.unknowns
        found = as_known(lowest(lin.elements, min(count, n - h)))
        below = np.flatnonzero(np.asarray(to_frequency(found.values)) <= bandwidth)
        if not len(below):
            raise ValueError(
                f"Argument `bandwidth` = {shown(bandwidth)} Hz is below the first mode,"
                f" {float(to_frequency(found.values)[0]):.5g} Hz, so that no state would be left."
            )
        if len(below) < found.values.shape[0] or count >= n - h:
            return tuple(below.tolist()), found
        count *= 2


def error_of_large(
    lin: Linearization, found: ByModes, bandwidth: float | None, small: Any
) -> Float[np.ndarray, "n_y n_u"]:
    """As :func:`.truncation.error_of`, measured against solutions in all coordinates at fewer frequencies.

    Args:
        lin: Linearization.
        found: Its few modes.
        bandwidth: End of the band [Hz]; the highest mode that is kept unless given.
        small: A, B, C and D of the state space.

    Returns:
        (n_y, n_u) [-].

    Warns:
        FlexmbWarning: It is above a hundredth.
    """
    hertz, whole = np.asarray(found.hertz), found.whole
    end = float(np.max(hertz[list(found.kept)])) if bandwidth is None else bandwidth
    if end <= 0 or end <= STILL * hertz[-1]:
        end = 1.0
    grid = compared_at(end, hertz, POINTS, BESIDE[[0, -1]])
    n_u, n = whole.B.shape[2], whole.elements.unknowns[0]
    free, moves = np.asarray(whole.elements.free), np.asarray(whole.orders)
    w = 2 * np.pi * grid
    b, c, d = (np.asarray(of) for of in whole[1:4])
    solved_at = np.asarray(solutions(whole.elements, w, *(of.astype(complex) for of in whole[1:3])))
    full, own, least = [], [], np.zeros(d.shape[1:])
    a_, b_, c_, d_ = (np.asarray(of) for of in small)
    eye = np.eye(len(a_))
    for s, z in zip(1j * w, solved_at, strict=True):
        powers = s ** np.arange(3)
        forces, rows, through = (np.tensordot(powers, of, 1) for of in (b[:, free], c[:, :, free], d))
        by_u = s ** -moves.astype(float)
        moved, sensed = z[:n, :n_u], z[:n, n_u:]
        full.append((rows @ moved + through) * by_u)
        own.append(c_ @ np.linalg.solve(s * eye - a_, b_) + d_)
        sizes = np.abs(np.sum(rows.T * sensed, axis=0)), np.abs(np.sum(forces * moved, axis=0)) * np.abs(by_u) ** 2
        least = np.maximum(least, IDLE * np.sqrt(np.outer(*sizes)))
    return tell_of_error(lin, grid, np.array(full), np.array(own), least, end, len(found.kept), None)
