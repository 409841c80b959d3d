"""Large mechanisms in second-order form: what inputs do and outputs measure, in all coordinates."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, by_library, is_concrete
from ..errors import AnalysisError, ModelError
from ..linear.linearize import Linearization
from ..linear.sparse_solve import solved
from ..math.by_deformations import spread
from ..math.element_matrices import ElementMatrices, between, by_coordinates, times, times_transposed, transposed
from ..math.indices import accumulate, put
from ..mechanics.signals import DEFORMATION_ORDERS, ORDERS, along_coordinates, terms_of
from ..model.model import Signal
from .held import Held, about_axes, held_by, held_of, moved_by, seeds
from .second_order_form import adding_to, mixed, orders_of, stacked

# Share of a force below which what is left beside those of constraints is round-off.
IDLE = 1e-9


class SparseSecondOrder(NamedTuple):
    """M v'' + C v' + K v + D^T m = B0 p + B1 p' + B2 p'', D v = 0, and outputs, as :class:`SecondOrder` has them.

    The coordinates are those beside what follows what is held at rest: x = v + Z p.

    Attributes:
        elements: K, C, M and D, element by element.
        B: What acts on the coordinates by p and its two rates, (3, n_x, n_u).
        C: Outputs by the coordinates and their rates, (3, n_y, n_x).
        D: Outputs by p and its rates, (3, n_y, n_u).
        orders: Of which derivative of p each input is, 0, 1 or 2, (n_u,); plain numbers.
        moves: Which inputs move what is held, rather than being forces, (n_u,); plain booleans.
    """

    elements: ElementMatrices
    B: Float[Array, "3 n_x n_u"]
    C: Float[Array, "3 n_y n_x"]
    D: Float[Array, "3 n_y n_u"]
    orders: np.ndarray
    moves: np.ndarray


def lossy_elements(lin: Linearization, losses: Float[Array, "n_e"]) -> ElementMatrices:
    """Element matrices of which stiffness and elastic are those times the loss factors of the deformations.

    Args:
        lin: Linearization.
        losses: (n_e,) [-].
    """
    elements, losses = as_known((lin.elements, losses))
    elastic = [
        (rows, columns, (losses[rows][:, :, None] + losses[columns][:, None, :]) / 2 * own)
        for rows, columns, own in elements.elastic
    ]
    structural = by_coordinates(elements.constraints, elastic)
    return elements._replace(structural=structural, curved=[], damping=[], mass=[], elastic=elastic, viscous=[])


def sparse_second_order(lin: Linearization, lossy: ElementMatrices | None = None) -> SparseSecondOrder:
    """Second-order form of a large mechanism, for the model's named inputs and outputs.

    Args:
        lin: Linearization; differentiable in the model's parameters.
        lossy: As of :func:`lossy_elements`: what is lossy in B, C and D is found in place of what is elastic.

    Returns:
        SparseSecondOrder.

    Raises:
        ModelError: An input moves nothing.

    Source:
        THEORY.md 7, eq. (7.18), in place of 14, eq. (14.2) and (14.3).
    """
    return by_library(_sparse_second_order, lin, lossy)


def _sparse_second_order(lin: Linearization, lossy: ElementMatrices | None, library: Any) -> SparseSecondOrder:
    """The same by NumPy, of arrays of its own, or by JAX."""
    model, elements = lin.model, lin.elements
    inputs, outputs = (tuple(s.without_name() for s in some) for some in model.signals())
    causes, sensed = terms_of(inputs), terms_of(outputs)
    held = held_by((*causes, *sensed))
    carried = _carried(lin, elements, held, library)
    # What holds it is measured along the motions that meet no force of the transposed stiffness.
    along = carried if lin.symmetric else _carried(lin, transposed(elements), held, library)
    own = elements if lossy is None else lossy
    n_x = lin.x.shape[0]
    forces = stacked(
        [_force(s, lin, library) if s.order is None and lossy is None else None for s in causes], n_x, library
    ).T
    motions = moved_by(causes, held)
    still = library.zeros((n_x, len(held)))
    parts = [still if lossy is None else times(own.stiffness, carried, size=n_x)]
    parts += [times(pieces, carried, size=n_x) for pieces in (own.damping, own.mass)]
    by_p = [-part @ motions for part in parts]
    by_p[0] = by_p[0] + forces
    holding = [still if lossy is None else times_transposed(own.stiffness, along, size=n_x)]
    holding += [times_transposed(pieces, along, size=n_x) for pieces in (own.damping, own.mass)]
    between_held = [between(pieces, along, carried) for pieces in (own.stiffness, own.damping, own.mass)]
    if lossy is None:
        between_held[0] = between_held[0] + about_axes(lin, held, 0)
    rows: list[list[Any]] = [[], [], []]
    through: list[list[Any]] = [[], [], []]
    for s in sensed:
        if s.held and s.quantity in ("reaction", "stress"):
            # What is put on a deformation from outside is less its stress resultant.
            i, sign = held.index(held_of(s)), -1.0 if s.of_element else 1.0
            by_x = [sign * part[:, i] for part in holding]
            at_once = [sign * part[i] @ motions for part in between_held]
            at_once[0] = at_once[0] - sign * (along[:, i] @ forces)
        else:
            by_x = _measured(s, lin, own, lossy is not None, library)
            at_once = [row @ carried @ motions for row in by_x]
            if s.quantity == "stress" and lossy is None:
                at_once[0] = at_once[0] + adding_to(s, causes)
        for rate in range(3):
            rows[rate].append(by_x[rate])
            through[rate].append(at_once[rate])
    by_x = [stacked(of, n_x, library) for of in rows]
    by_u = [stacked(of, len(causes), library) for of in through]
    b, c, d = map(library.stack, mixed(inputs, outputs, model.parameters.weights, by_p, by_x, by_u))
    found = SparseSecondOrder(own, b, c, d, *orders_of(inputs))
    if lossy is None:
        _refuse_idle(lin, found)
    return found


def some_of(found: SparseSecondOrder, us: list[int], ys: list[int]) -> SparseSecondOrder:
    """The same of some inputs and outputs, by their numbers."""
    u, y = np.array(us), np.array(ys)
    d = found.D[:, y][:, :, u]
    return SparseSecondOrder(found.elements, found.B[:, :, u], found.C[:, y], d, found.orders[u], found.moves[u])


def _force(s: Signal, lin: Linearization, library: Any) -> Float[Array, "n_x"]:
    """Forces on the coordinates of a unit input."""
    if s.quantity == "stress":
        return -_of_deformation(lin, _unit(s, lin, library))
    own, row = along_coordinates(s, lin.x)
    return accumulate(library.zeros(lin.x.shape[0]), own, row)


def _unit(s: Signal, lin: Linearization, library: Any) -> Float[Array, "n_e"]:
    """One for the deformation of a signal, zero for all others."""
    return put(library.zeros(lin.e.shape[0]), s.index, 1.0)


def _of_deformation(lin: Linearization, weights: Float[Array, "n_e"]) -> Float[Array, "n_x"]:
    """Derivative of a sum of deformations by the coordinates."""
    return times_transposed(lin.elements.constraints, weights[:, None], size=lin.x.shape[0])[:, 0]


def _measured(s: Signal, lin: Linearization, own: ElementMatrices, only_stress: bool, library: Any) -> list[Any]:
    """Derivatives of an output by the coordinates and their two rates, each (n_x,)."""
    none = library.zeros(lin.x.shape[0])
    found: list[Any] = [none, none, none]
    if s.quantity == "stress":
        unit = _unit(s, lin, library)[:, None]
        for rate, pieces in enumerate((own.elastic, own.viscous)):
            found[rate] = _of_deformation(lin, times_transposed(pieces, unit, size=lin.e.shape[0])[:, 0])
    elif only_stress:
        return found
    elif s.quantity.startswith("deformation"):
        found[DEFORMATION_ORDERS[s.quantity]] = _of_deformation(lin, _unit(s, lin, library))
    else:
        at, row = along_coordinates(s, lin.x)
        found[ORDERS[s.quantity]] = accumulate(none, at, row)
    return found


def _carried(
    lin: Linearization, elements: ElementMatrices, held: tuple[Held, ...], library: Any
) -> Float[Array, "n_x k"]:
    """Motions at rest of all coordinates by a unit of each of what is held."""
    if not held:
        return library.zeros((lin.x.shape[0], 0))
    n_x, n_e = lin.x.shape[0], lin.e.shape[0]
    by_x, by_e = seeds(lin.model.topology, lin.x, held)
    forces = times(elements.stiffness, by_x, size=n_x)[elements.free]
    excess = (times(elements.constraints, by_x, size=n_e) - by_e)[elements.held]
    moved = as_known(solved(elements, -library.concatenate([forces, excess])))
    return by_x + spread(elements, moved[: elements.unknowns[0]])


def _carries(lin: Linearization, forces: np.ndarray) -> np.ndarray:
    """Whether forces on what moves, (n, k), meet more than constraints, (k,)."""
    elements, n_x = lin.elements, lin.x.shape[0]
    n, h = elements.unknowns
    largest = np.max(np.abs(forces), axis=0, initial=0.0)
    if not h or not np.any(largest):
        return largest > 0
    try:
        moved = as_known(solved(elements, np.concatenate([forces, np.zeros((h, forces.shape[1]))])))
    except AnalysisError:
        # Of a motion without stiffness that is not known.
        return largest > 0
    elastic = times(elements.stiffness, spread(elements, moved[:n]), size=n_x)[elements.free]
    return np.max(np.abs(np.asarray(elastic)), axis=0) > IDLE * largest


def _refuse_idle(lin: Linearization, found: SparseSecondOrder) -> None:
    """Refuse inputs that move nothing; of concrete numbers."""
    if not is_concrete(found[:4]):
        return
    own = np.asarray(found.B)[:, np.asarray(lin.elements.free)]
    forces = np.any(np.array([_carries(lin, of) for of in own]), axis=0)
    idle = np.flatnonzero(~forces & ~np.any(np.asarray(found.D), axis=(0, 1)))
    if len(idle):
        s = lin.labels.inputs[idle[0]]
        raise ModelError(
            f"Input '{s.name}' (a {s.quantity}) moves nothing about this state. Let it act on what can move, or"
            " leave it out."
        )
