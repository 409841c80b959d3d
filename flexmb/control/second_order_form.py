"""The linearised mechanism in second-order form, with input and output matrices."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_known, by_library, is_concrete, library_of
from ..compilation.compile import jit
from ..errors import AnalysisError, ModelError
from ..linear.linearize import Linearization, Matrices
from ..linear.sparse_solve import sparse_solution
from ..math.by_deformations import motions_from_free
from ..math.element_matrices import (
    ElementMatrices,
    by_coordinates,
    matrix_times,
    quadratic_form,
    times_transposed,
    transposed,
)
from ..math.indices import accumulate, put
from ..mechanics.prepared import kernel
from ..mechanics.signals import (
    DEFORMATION_ORDERS,
    ORDERS,
    along_coordinates,
    combined,
    input_row,
    rotation_row,
    terms_of,
)
from ..model.model import Signal
from ..model.topology import Parameters, Topology
from ..numerical_limits import NEGLIGIBLE, ROUND_OFF
from .held import ConstrainedCoordinate, about_axes, constrained_by, constrained_of, moved_by, seeds, with_constrained


class SecondOrder(NamedTuple):
    """M q'' + C q' + K q = B0 p + B1 p' + B2 p'',  y = C0 q + C1 q' + C2 q'' + D0 p + D1 p' + D2 p''.

    p equals the input u, with one exception. If u is the velocity or acceleration of a constrained coordinate, p is its
    displacement, and u is the derivative of p of order ``orders``. In the frequency domain, with s = i w, for input j:
    q = (s^2 M + s C + K)^-1 (B0 + s B1 + s^2 B2)[:, j] u_j / s^orders[j].

    Attributes:
        M, C, K: Mass, damping and stiffness of the degrees of freedom, (n_q, n_q) [SI].
        B0, B1, B2: Effects of p and its rates on the degrees of freedom, (n_q, n_u).
        C0, C1, C2: Outputs by the degrees of freedom and their rates, (n_y, n_q).
        D0, D1, D2: Outputs by p and its rates, (n_y, n_u).
        orders: Order of the derivative of p that equals each input: 0, 1 or 2, (n_u,); plain numbers.
        moves: Whether each input moves a constrained coordinate, instead of being a force, (n_u,); plain booleans.
    """

    M: Float[Array, "*t n_q n_q"]
    C: Float[Array, "*t n_q n_q"]
    K: Float[Array, "*t n_q n_q"]
    B0: Float[Array, "*t n_q n_u"]
    B1: Float[Array, "*t n_q n_u"]
    B2: Float[Array, "*t n_q n_u"]
    C0: Float[Array, "*t n_y n_q"]
    C1: Float[Array, "*t n_y n_q"]
    C2: Float[Array, "*t n_y n_q"]
    D0: Float[Array, "*t n_y n_u"]
    D1: Float[Array, "*t n_y n_u"]
    D2: Float[Array, "*t n_y n_u"]
    orders: np.ndarray
    moves: np.ndarray

    def at(self, s: complex) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return K, B, C and D of one state at s = i w; the response of y to u is C K^-1 B + D.

        Args:
            s: i w [rad/s]; not zero if an input is a velocity or an acceleration.

        Returns:
            (n_q, n_q), (n_q, n_u), (n_y, n_q) and (n_y, n_u), complex.
        """
        m, c, k, b0, b1, b2, c0, c1, c2, d0, d1, d2 = map(np.asarray, self[:12])
        by_u = s ** -self.orders.astype(float)
        forces, through = (b0 + s * b1 + s**2 * b2) * by_u, (d0 + s * d1 + s**2 * d2) * by_u
        return k + s * c + s**2 * m, forces, c0 + s * c1 + s**2 * c2, through

    def __repr__(self) -> str:
        return "SecondOrder: " + ", ".join(f"{name} {np.shape(matrix)}" for name, matrix in self._asdict().items())


class LargeSecondOrder(NamedTuple):
    """M v'' + C v' + K v + D^T m = B0 p + B1 p' + B2 p'', D v = 0, and outputs as in :class:`SecondOrder`.

    The coordinates are relative to the motion at rest that held coordinates cause: x = v + Z p.

    Attributes:
        elements: K, C, M and D, element by element.
        B: Effects of p and its two rates on the coordinates.
        C: Outputs by the coordinates and their rates.
        D: Outputs by p and its rates.
        orders, moves: As in :class:`SecondOrder`.
    """

    elements: ElementMatrices
    B: Float[Array, "3 n_x n_u"]
    C: Float[Array, "3 n_y n_x"]
    D: Float[Array, "3 n_y n_u"]
    orders: np.ndarray
    moves: np.ndarray

    def of(self, us: Sequence[int], ys: Sequence[int]) -> "LargeSecondOrder":
        """The form of some inputs and outputs, by their numbers."""
        u, y = np.array(us), np.array(ys)
        d = self.D[:, y][:, :, u]
        return LargeSecondOrder(self.elements, self.B[:, :, u], self.C[:, y], d, self.orders[u], self.moves[u])


class _Signals(NamedTuple):
    """Inputs and outputs without names, and the held coordinates that they move or measure."""

    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    held: tuple[ConstrainedCoordinate, ...]

    @classmethod
    def of(cls, lin: Linearization) -> "_Signals":
        """The signals of a linearised mechanism."""
        inputs, outputs = (tuple(s.without_name() for s in some) for some in lin.model.signals())
        return cls(inputs, outputs, constrained_by((*terms_of(inputs), *terms_of(outputs))))


class _Around(NamedTuple):
    """Stiffness, damping and mass around held coordinates, and effects of inputs that are forces.

    Attributes:
        by_held: Forces on the freedoms by held coordinates and their rates, each (n, k).
        of_held: Holding forces by the freedoms and their rates, each (k, n).
        between: Holding forces by held coordinates, each (k, k).
        forces: Of the inputs on the freedoms, (n, terms).
        on_held: Of the inputs on held coordinates, (k, terms).
    """

    by_held: Sequence[Any]
    of_held: Sequence[Any]
    between: Sequence[Any]
    forces: Any
    on_held: Any


def second_order(lin: Linearization) -> SecondOrder:
    """Return the second-order form of a linearised mechanism, for the model's named inputs and outputs.

    Args:
        lin: Linearization, differentiable in the model's parameters. Along a motion, times are the first axis.

    Returns:
        SecondOrder.

    Source:
        THEORY.md 14, eq. (14.1) to (14.4). The equations about the state are set up with constrained coordinates
            free, and their stiffness includes constraint forces. Columns of moved coordinates go to the right-hand
            side.
    """
    model, m, signals = lin.model, lin.matrices, _Signals.of(lin)
    extended = _with_constrained(model.topology, model.parameters, m, held=signals.held) if signals.held else m
    weights = model.parameters.weights
    if is_concrete((m, weights)) and m.M0.ndim == 2:
        # On the host: compilation of sizes that occur once takes longer than computing.
        m, extended, weights = jax.tree.map(np.asarray, (m, extended, weights))
        parts = _about_state(m, extended, weights, signals, np)
    else:
        parts = _second_order(m, extended, weights, signals=signals)
    orders, moves = orders_of(signals.inputs)
    return SecondOrder(*parts, orders=orders, moves=moves)


def orders_of(inputs: tuple[Signal, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Order of the derivative of a displacement that each input is, and whether it moves held coordinates."""
    orders = [s.terms[0].order for s in inputs]
    return np.array([order or 0 for order in orders], int), np.array([order is not None for order in orders], bool)


@kernel
def _with_constrained(
    topology: Topology, parameters: Parameters, m: Matrices, *, held: tuple[ConstrainedCoordinate, ...]
):
    def in_state(m: Matrices):
        return with_constrained(topology, parameters, m, held)

    return jax.vmap(in_state)(m) if m.M0.ndim > 2 else in_state(m)


@jit
def _second_order(m: Matrices, whole: Matrices, weights: Any, *, signals: _Signals) -> Any:
    def in_state(m: Matrices, whole: Matrices):
        return _about_state(m, whole, weights, signals, jnp)

    return jax.vmap(in_state)(m, whole) if m.M0.ndim > 2 else in_state(m, whole)


def _about_state(m: Matrices, extended: Matrices, weights: Any, signals: _Signals, xp: Any) -> tuple[Any, ...]:
    """The twelve matrices of one state, by NumPy or by jax.numpy; in ``extended`` held coordinates are last."""
    n, causes = m.M0.shape[0], terms_of(signals.inputs)
    parts = (extended.K, extended.C0 + extended.D0, extended.M0)
    columns = [input_row(s, extended.x, extended.DFx, extended.DFe) if s.order is None else None for s in causes]
    forces = _stacked(columns, n + len(signals.held), xp).T
    around = _Around(
        [part[:n, n:] for part in parts],
        [part[n:, :n] for part in parts],
        [part[n:, n:] for part in parts],
        forces[:n],
        forces[n:],
    )

    def measured(s: Signal):
        rows = _output_rows(s, extended)
        return [[None if row is None else row[part] for row in rows] for part in (slice(n), slice(n, None))]

    by_p, by_q, through = _assembled(signals, weights, around, measured, xp)
    return m.M0, m.C0 + m.D0, m.K, *by_p, *by_q, *through


def _assembled(
    signals: _Signals, weights: Any, around: _Around, measured: Callable[[Signal], Any], xp: Any, passes: bool = True
) -> tuple[list[Any], list[Any], list[Any]]:
    """Effects of inputs, outputs by the freedoms, and outputs by inputs, each by powers of the rate.

    Args:
        weights: Of the terms of inputs and outputs; None if each has one term.
        measured: Rows of an output by the freedoms and by held coordinates, each with its rates, None for zero.
        passes: Whether a stress input adds to the measured stress.
    """
    inputs, outputs, held = signals
    causes, (n, k) = terms_of(inputs), (around.forces.shape[0], len(held))
    motions = moved_by(causes, held)
    by_p = [-part @ motions for part in around.by_held]
    by_p[0] = by_p[0] + around.forces
    by_q, by_held, passed = [], [], []
    for s in terms_of(outputs):
        if s.held and s.quantity in ("reaction", "stress"):
            # The external force on a deformation is minus its stress resultant.
            i, sign = held.index(constrained_of(s)), -1.0 if s.of_element else 1.0
            by_q.append([sign * part[i] for part in around.of_held])
            by_held.append([sign * part[i] for part in around.between])
            passed.append(-sign * around.on_held[i])
        else:
            for rows, measured_rows in zip((by_q, by_held), measured(s), strict=True):
                rows.append(measured_rows)
            # Stress inputs add to the measured stress.
            same = [float(u.quantity == "stress" and u.index == s.index and u.order is None) for u in causes]
            passed.append(np.array(same) if passes and s.quantity == "stress" else None)
    by_q, by_held = (
        [_stacked([row[rate] for row in rows], size, xp) for rate in range(3)]
        for rows, size in ((by_q, n), (by_held, k))
    )
    through = [rows @ motions for rows in by_held]
    through[0] = through[0] + _stacked(passed, len(causes), xp)
    if weights is None:
        return by_p, by_q, through
    mix, read = combined(inputs, weights[0]).T, combined(outputs, weights[1])
    totals = [b @ mix for b in by_p], [read @ c for c in by_q], [read @ d @ mix for d in through]
    by, read_size = abs(mix), abs(read)
    sizes = [abs(b) @ by for b in by_p], [read_size @ abs(c) for c in by_q], [read_size @ abs(d) @ by for d in through]
    # A floor that moves as a whole deforms nothing: effects of its points cancel but for round-off.
    return jax.tree.map(_exact, totals, sizes)


def _exact(total: Any, size: Any) -> Any:
    """Zero where terms of a size cancel but for round-off; derivatives stay."""
    known = jax.lax.stop_gradient(total)
    small = abs(known) <= ROUND_OFF * jax.lax.stop_gradient(size)
    return library_of(small).where(small, total - known, total)


def _stacked(rows: list[Any], size: int, xp: Any) -> Any:
    """Rows below each other, zero for None."""
    none = xp.zeros(size)
    return xp.stack([none if row is None else row for row in rows]) if rows else xp.zeros((0, size))


def _output_rows(s: Signal, m: Matrices) -> tuple[Any, ...]:
    """Derivatives of an output by the freedoms, their rates and second rates; None for zero.

    Along a motion the rate of DFx q is DFx qd + DFx_d q, and a rotation's axes turn: the change of omega = 2
    Lbar(lambda) d(lambda)/dt is 2 Lbar(lambda) of the rate's minus 2 Lbar(d(lambda)/dt) of the parameters' change.
    """
    moving = m.moving
    if s.quantity == "stress":
        rates, by_q = m.S_d[s.index], m.S[s.index] @ m.DFe
        return by_q if moving is None else by_q + rates @ moving.DFe_d, rates @ m.DFe, None
    of_e = s.quantity.startswith("deformation")
    place = {**ORDERS, **DEFORMATION_ORDERS}[s.quantity]
    indices, row = (np.array([s.index]), np.ones(1)) if of_e else along_coordinates(s, m.x)
    along = row @ (m.DFe if of_e else m.DFx)[indices]
    if place == 0 or moving is None:
        return tuple(along if i == place else None for i in range(3))
    first, second = (moving.DFe_d, moving.DFe_dd) if of_e else (moving.DFx_d, moving.DFx_dd)
    turning = jnp.zeros_like(along)
    if s.axis is not None:
        rates = moving.xd if place == 1 else moving.xdd
        turning = rotation_row(rates[indices], s.axis, s.local) @ m.DFx[indices]
    if place == 1:
        return row @ first[indices] - turning, along, None
    return row @ second[indices] - turning, 2 * row @ first[indices], along


def lossy_elements(lin: Linearization, losses: Float[Array, "n_e"]) -> ElementMatrices:
    """Element matrices whose stiffness is multiplied by the loss factors of the deformations."""
    elements, losses = as_known((lin.elements, losses))
    elastic = [
        (rows, columns, (losses[rows][:, :, None] + losses[columns][:, None, :]) / 2 * stiffness)
        for rows, columns, stiffness in elements.elastic
    ]
    structural = by_coordinates(elements.constraints, elastic)
    return elements._replace(structural=structural, curved=[], damping=[], mass=[], elastic=elastic, viscous=[])


def large_second_order(lin: Linearization, lossy: ElementMatrices | None = None) -> LargeSecondOrder:
    """Second-order form of a large mechanism; ModelError for an input that moves nothing.

    With ``lossy``, from :func:`lossy_elements`, B, C and D belong to the losses. THEORY.md 7, eq. (7.18), in place
    of 14, eq. (14.2) and (14.3).
    """
    return by_library(_large_second_order, lin, lossy)


def _large_second_order(lin: Linearization, lossy: ElementMatrices | None, library: Any) -> LargeSecondOrder:
    """:func:`large_second_order` by NumPy, from NumPy arrays, or by JAX."""
    elements, n_x, signals = lin.elements, lin.x.shape[0], _Signals.of(lin)
    causes, held = terms_of(signals.inputs), signals.held
    carried = _carried(lin, elements, held, library)
    # Holding forces are measured along motions that meet no force of the transposed stiffness.
    along = carried if lin.symmetric else _carried(lin, transposed(elements), held, library)
    matrices, elastic = (elements, True) if lossy is None else (lossy, False)
    columns = [_force(s, lin, library) if s.order is None and elastic else None for s in causes]
    forces = _stacked(columns, n_x, library).T
    # Motions at rest meet no elastic force.
    parts = [] if elastic else matrices.stiffness, matrices.damping, matrices.mass
    beyond = [quadratic_form(part, along, carried) for part in (matrices.stiffness, matrices.damping, matrices.mass)]
    if elastic:
        beyond[0] = beyond[0] + about_axes(lin, held, 0)
    by_held = [matrix_times(part, carried, size=n_x) for part in parts]
    of_held = [times_transposed(part, along, size=n_x).T for part in parts]
    around = _Around(by_held, of_held, beyond, forces, along.T @ forces)

    def measured(s: Signal):
        rows = _measured(s, lin, matrices, elastic, library)
        return rows, [row @ carried for row in rows]

    powers = _assembled(signals, lin.model.parameters.weights, around, measured, library, elastic)
    b, c, d = map(library.stack, powers)
    form = LargeSecondOrder(matrices, b, c, d, *orders_of(signals.inputs))
    if elastic:
        _refuse_idle(lin, form)
    return form


def _force(s: Signal, lin: Linearization, library: Any) -> Float[Array, "n_x"]:
    """Forces on the coordinates of a unit input."""
    if s.quantity == "stress":
        return -_deformation_row(lin, _unit(s, lin, library))
    indices, row = along_coordinates(s, lin.x)
    return accumulate(library.zeros(lin.x.shape[0]), indices, row)


def _unit(s: Signal, lin: Linearization, library: Any) -> Float[Array, "n_e"]:
    """One for the deformation of a signal, zero for all others."""
    return put(library.zeros(lin.e.shape[0]), s.index, 1.0)


def _deformation_row(lin: Linearization, weights: Float[Array, "n_e"]) -> Float[Array, "n_x"]:
    """Derivative of a weighted sum of deformations by the coordinates."""
    return times_transposed(lin.elements.constraints, weights[:, None], size=lin.x.shape[0])[:, 0]


def _measured(s: Signal, lin: Linearization, matrices: ElementMatrices, elastic: bool, library: Any) -> list[Any]:
    """Derivatives of an output by the coordinates and their two rates; of a stress alone unless ``elastic``."""
    none = library.zeros(lin.x.shape[0])
    rows: list[Any] = [none, none, none]
    if s.quantity == "stress":
        unit = _unit(s, lin, library)[:, None]
        for rate, element_matrices in enumerate((matrices.elastic, matrices.viscous)):
            rows[rate] = _deformation_row(lin, times_transposed(element_matrices, unit, size=lin.e.shape[0])[:, 0])
    elif not elastic:
        return rows
    elif s.quantity.startswith("deformation"):
        rows[DEFORMATION_ORDERS[s.quantity]] = _deformation_row(lin, _unit(s, lin, library))
    else:
        at, row = along_coordinates(s, lin.x)
        rows[ORDERS[s.quantity]] = accumulate(none, at, row)
    return rows


def _carried(
    lin: Linearization, elements: ElementMatrices, held: tuple[ConstrainedCoordinate, ...], library: Any
) -> Float[Array, "n_x k"]:
    """Motions at rest of all coordinates by a unit of each held coordinate."""
    if not held:
        return library.zeros((lin.x.shape[0], 0))
    n_x, n_e = lin.x.shape[0], lin.e.shape[0]
    by_x, by_e = seeds(lin.model.topology, lin.x, held)
    forces = matrix_times(elements.stiffness, by_x, size=n_x)[elements.free]
    excess = (matrix_times(elements.constraints, by_x, size=n_e) - by_e)[elements.held]
    moved = as_known(sparse_solution(elements, -library.concatenate([forces, excess]), solver=lin.solver))
    return by_x + motions_from_free(elements, moved[: elements.unknowns[0]])


def _carries(lin: Linearization, forces: np.ndarray) -> np.ndarray:
    """Whether forces on the free coordinates, (n, k), do more than load constraints."""
    elements, n_x = lin.elements, lin.x.shape[0]
    n, h = elements.unknowns
    largest = np.max(np.abs(forces), axis=0, initial=0.0)
    if not h or not np.any(largest):
        return largest > 0
    try:
        moved = as_known(
            sparse_solution(elements, np.concatenate([forces, np.zeros((h, forces.shape[1]))]), solver=lin.solver)
        )
    except AnalysisError:
        # With a motion without stiffness this is not known.
        return largest > 0
    elastic = matrix_times(elements.stiffness, motions_from_free(elements, moved[:n]), size=n_x)[elements.free]
    return np.max(np.abs(np.asarray(elastic)), axis=0) > NEGLIGIBLE * largest


def _refuse_idle(lin: Linearization, form: LargeSecondOrder) -> None:
    """Refuse inputs that move nothing; of concrete numbers."""
    if not is_concrete(form[:4]):
        return
    on_free = np.asarray(form.B)[:, np.asarray(lin.elements.free)]
    forces = np.any(np.array([_carries(lin, columns) for columns in on_free]), axis=0)
    idle = np.flatnonzero(~forces & ~np.any(np.asarray(form.D), axis=(0, 1)))
    if len(idle):
        s = lin.labels.inputs[idle[0]]
        raise ModelError(
            f"Input '{s.name}' (a {s.quantity}) moves nothing in this state. Let it act on a coordinate that can move,"
            " or leave it out."
        )
