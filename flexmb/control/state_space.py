"""The linearised mechanism as a state-space model of python-control."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete, undifferentiated
from ..compilation.compile import jit, unguarded
from ..errors import AnalysisError, ModelError, warn
from ..linear.about import Where, asked_about
from ..linear.linearize import Linearization, ManyStates, Matrices
from ..linear.loose import refuse_negative_mass, refuse_without_anything
from ..linear.modes import modal_frequencies
from ..linear.spectrum import massless_freedoms, response_without_mass
from ..math.linear import factorise
from ..math.linear_solver import LinearSolver
from ..mechanics.signals import combined, terms_of
from ..model.model import MOTIONS, Model
from ..model.topology import coordinate_scales
from ..numerical_limits import NEGLIGIBLE, REPORTED_ERROR, ROUND_OFF
from ..results import RESULTS
from ..statics.equilibrium import Equilibrium
from ..statics.solver_choice import asked_solver
from .second_order_form import SecondOrder, second_order
from .truncation import by_modes, error_of, retained_modes, truncated

if TYPE_CHECKING:
    import control

# Largest number of frequencies at which responses are compared.
MOST_COMPARED = 60


class StateMatrices(NamedTuple):
    """z_dot = A z + B u, y = C z + D u with z = (q, q_dot) of the degrees of freedom that carry mass.

    An input that is the velocity of a constrained coordinate adds its displacement to z, after q. An acceleration also
    adds its velocity, after q_dot.

    Attributes:
        A: (n_z, n_z); n_z = 2 n without such inputs.
        B: (n_z, n_u).
        C: (n_y, n_z).
        D: (n_y, n_u).
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]

    def __repr__(self) -> str:
        return "StateMatrices: " + ", ".join(f"{name} {np.shape(matrix)}" for name, matrix in self._asdict().items())


class _Realised(NamedTuple):
    """State-space matrices, and values for their names and checks.

    Attributes:
        late: Rate of an input that an output needs and no state space has; 0 for none.
        shifted: Whether states of degrees of freedom, and of their rates, exclude immediate motions by the inputs.
    """

    matrices: StateMatrices
    late: Float[Array, "n_y n_u"]
    shifted: tuple[Any, Any]


@jit
def _realised(
    parts: tuple[Array, ...],
    *,
    orders: tuple[int, ...],
    moves: tuple[bool, ...],
    condensed: tuple[int, ...],
    modes: tuple[int, ...] = (),
) -> _Realised:
    """First-order form of a second-order one, with massless motions condensed, or some modes only; at each time."""

    def in_state(parts: tuple[Array, ...]):
        return _realised_at(parts, np.array(orders, int), np.array(moves, float), condensed, modes)

    return in_state(parts) if parts[0].ndim == 2 else jax.vmap(in_state)(parts)


def _realised_at(
    parts: tuple[Array, ...], orders: np.ndarray, moves: np.ndarray, condensed: tuple[int, ...], modes: tuple[int, ...]
) -> _Realised:
    m, c, k, *by_p = parts[:6]
    c_q, through = list(parts[6:9]), list(parts[9:12])
    n_q, n_u = by_p[0].shape
    kept_indices = np.array([i for i in range(n_q) if i not in condensed], int)
    keep, direct = jnp.eye(n_q)[:, kept_indices], jnp.zeros((n_q, n_u))
    left_out: Any = None
    if modes:
        keep, left_out = truncated(k, m, modes)
        direct = left_out(by_p[0])
    elif condensed:
        moved = response_without_mass(m, k, condensed, jnp.concatenate([by_p[0], k @ keep], axis=1))
        direct, keep = moved[:, :n_u], keep - moved[:, n_u:]
    mass, damping, stiffness = (keep.T @ matrix @ keep for matrix in (m, c, k))
    by_p[0], through[0] = by_p[0] - k @ direct, through[0] + c_q[0] @ direct
    by_rates = 0.0 if left_out is None else c_q[0] @ left_out(c @ keep)
    if np.any(moves):
        # Massless motions also follow the rates of a motion; rates of forces are not known.
        for i, matrix in ((1, c), (2, m)):
            by_p[i], through[i] = by_p[i] - matrix @ (direct * moves), through[i] + c_q[i] @ (direct * moves)
            if left_out is not None:
                # Damping and inertia add to the effect of an input with such a rate.
                through[i] = through[i] + c_q[0] @ left_out(by_p[i] * (orders >= i).astype(float))
        by_p, c_q = [keep.T @ b for b in by_p], [c @ keep for c in c_q]
        c_q[1] = c_q[1] - by_rates
        return _first_order(mass, damping, stiffness, by_p, c_q, through, orders)
    n = keep.shape[1]
    lower = factorise(mass).solve(jnp.concatenate([-stiffness, -damping, keep.T @ by_p[0]], axis=1))
    v_dot, pull = lower[:, : 2 * n], lower[:, 2 * n :]
    z_dot = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n)], axis=1)
    row = jnp.concatenate([c_q[0] @ keep, c_q[1] @ keep - by_rates], axis=1) + c_q[2] @ keep @ v_dot
    matrices = StateMatrices(
        jnp.concatenate([z_dot, v_dot]),
        jnp.concatenate([jnp.zeros((n, n_u)), pull]),
        row,
        through[0] + c_q[2] @ keep @ pull,
    )
    return _Realised(matrices, jnp.zeros(matrices.D.shape, jnp.int32), (jnp.zeros(n, bool), jnp.zeros(n, bool)))


def _first_order(
    mass: Float[Array, "n n"],
    damping: Float[Array, "n n"],
    stiffness: Float[Array, "n n"],
    by_p: list[Array],
    c_q: list[Array],
    through: list[Array],
    orders: np.ndarray,
) -> _Realised:
    """States z, displacements that inputs are rates of, v, and velocities that inputs are rates of (14.5)."""
    n, n_u = by_p[0].shape
    inverse = factorise(mass)
    once, twice = np.flatnonzero(orders > 0), np.flatnonzero(orders == 2)

    def level(powers: list[Array], rate: int):
        """Effect of a rate (negative: an integral) of the inputs, from the effects of their displacements."""
        nothing = jnp.zeros(powers[0].shape[0])
        return jnp.stack(
            [powers[k + rate][:, j] if 0 <= k + rate < 3 else nothing for j, k in enumerate(orders)], axis=1
        )

    b0, b1, b2 = (level(by_p, rate) for rate in range(3))
    d0, d1, d2 = (level(through, rate) for rate in range(3))
    at_once = inverse.solve(b2)
    rates = inverse.solve(b1 - damping @ at_once)
    integrals, sensed = ([level(effects, -1)[:, once], level(effects, -2)[:, twice]] for effects in (by_p, through))
    # Columns: z, v, first integrals of inputs, second integrals.
    by_state = jnp.concatenate([-stiffness, -damping, *integrals], axis=1)
    lower = inverse.solve(jnp.concatenate([by_state, b0 - stiffness @ at_once - damping @ rates], axis=1))
    v_dot, pull = jnp.split(lower, [by_state.shape[1]], axis=1)
    (c0, c1, c2), more = c_q, len(once) + len(twice)
    row = jnp.concatenate([c0, c1, *sensed], axis=1) + c2 @ v_dot
    d = c0 @ at_once + c1 @ rates + c2 @ pull + d0
    z_dot, eye = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n), np.zeros((n, more))], axis=1), np.eye(n_u)
    # The rate of a second integral is the first one of the same input.
    first = np.hstack([np.zeros((len(twice), 2 * n)), eye[twice][:, once], np.zeros((len(twice),) * 2)])
    a = jnp.concatenate([z_dot, v_dot, np.zeros((len(once), 2 * n + more)), first])
    b = jnp.concatenate([rates, pull, eye[once], np.zeros((len(twice), n_u))])
    # Into the order of names: displacements after z, velocities after v.
    places = {j: 2 * n + i for i, j in enumerate(once)} | {j: 2 * n + len(once) + i for i, j in enumerate(twice)}
    speeds = [2 * n + i for i, j in enumerate(once) if orders[j] == 2]
    order = np.array([*range(n), *(places[j] for j in once), *range(n, 2 * n), *speeds], int)
    # Rate of an input that is left in an output, apart from round-off of its parts.
    size = jnp.abs(inverse.solve(jnp.eye(n)))
    most = size @ jnp.abs(b2)
    most_rate = size @ (jnp.abs(b1) + jnp.abs(damping) @ most)
    largest = jnp.abs(c1) @ most + jnp.abs(c2) @ most_rate + jnp.abs(d1)
    needs_rate = jnp.abs(c1 @ at_once + c2 @ rates + d1) > NEGLIGIBLE * largest
    needs_second = jnp.abs(c2 @ at_once + d2) > NEGLIGIBLE * (jnp.abs(c2) @ most + jnp.abs(d2))
    late = jnp.where(needs_second, 2, jnp.where(needs_rate, 1, 0))
    shifted = jnp.any(at_once != 0, axis=1), jnp.any((rates != 0) | (at_once != 0), axis=1)
    return _Realised(StateMatrices(a[order][:, order], b[order], row[:, order], d), late, shifted)


def state_matrices(
    model: Model | Linearization,
    *,
    modes: int | Sequence[int] | None = None,
    bandwidth: float | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
) -> tuple[StateMatrices, list[str]]:
    """Return state-space matrices about the static equilibrium, for the model's named inputs and outputs.

    States are the degrees of freedom that carry mass, and their rates. Motions without mass are condensed statically,
    without their damping. If all coordinates are constrained there are no states, and D relates outputs to inputs.

    Inputs that move a constrained coordinate change the states:

    - A displacement adds no states. A part of the motion may follow it at once. The states exclude this part, and their
      names end in "shifted".
    - A velocity adds the displacement to the states. An acceleration adds displacement and velocity. These states have
      the name "moved by" the input.

    An output that needs a rate of an input raises an error that names the quantity to use. Example: the input is the
    displacement of one end of a damper, and the output is the acceleration of a mass at the other end.

    Args:
        model: Mechanism, or its linearisation, also along a motion: times are then the first axis of the matrices.
            Differentiable in its parameters for named inputs and outputs. flexmb finds the motions without mass from
            concrete numbers. Under a trace it assumes that all motions carry mass, and D is NaN where an output needs a
            rate of an input.
        modes: Number of the lowest modes to keep, or their numbers, from 0; states are their amplitudes [m sqrt(kg)]
            and rates. The other modes follow the inputs statically; they also follow an acceleration of a constrained
            coordinate by their inertia. Responses of positions, deformations, stresses and reactions are exact at rest
            and almost exact in the band. Velocities and accelerations of the other modes would need rates of the inputs
            and are left out. Velocity and acceleration outputs are therefore wrong by the share of the other modes in
            the static flexibility. Damping of the other modes does not act on kept modes. Differentiable if the
            frequencies of kept modes differ from all others.
        bandwidth: Keep all modes up to this frequency [Hz]; not under a trace.
        sparse: Compute modes with sparse matrices in all coordinates, for a model that needs no degrees of freedom; see
            :func:`flexmb.equilibrium`. By default chosen by size, if ``modes`` or ``bandwidth`` is given.
        solver: "sparse", "dense", or a LinearSolver in place of sparse factors, as for :func:`flexmb.frequencies`.

    Returns:
        A, B, C, D (shapes in StateMatrices) [SI], and the names of the states.

    Raises:
        ModelError: An input moves nothing, or an output needs a rate of an input.
        AnalysisError: singular_mass: no degree of freedom carries mass, or a motion has negative mass. Also failures of
            the linearisation.
        ValueError: ``modes`` and ``bandwidth`` are both given, modes are unknown, no mode is below the bandwidth, or a
            mode that does not vibrate would be left out.
        NotImplementedError: ``modes`` or ``bandwidth`` for an unsymmetric stiffness.

    Warns:
        FlexmbWarning: The neglected damping of motions without mass changes responses at the frequencies of poles by
            more than 1 %; or kept modes have an error above 1 % in their band, see :func:`to_statespace`.

    Source:
        THEORY.md 7, eq. (7.7), with modes (7.14); tutorial WA 1239 (2012), eq. (2.3) and (A.4): A = [[0, I], [-M0^-1 K,
        -M0^-1 (C0 + D0)]], a stress input adds to sigma: B = -M0^-1 DFe^T. For constraint forces and motions of
        constrained coordinates see 14, eq. (14.1) to (14.5).
    """
    few = modes is not None or bandwidth is not None
    lin = (
        model
        if _is_along_motion(model)
        else asked_about(model, "state_matrices", None, asked_solver(sparse, solver), few=few)
    )
    return _matrices_of(lin, modes, bandwidth)[:2]


def _matrices_of(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[StateMatrices, list[str], Any]:
    """State-space matrices, names of the states, and the error of kept modes in their band, None under a trace."""
    known = lin if lin.large else undifferentiated(lin)
    traced, condensed = not is_concrete(known), ()
    whole: Any = None
    hertz: Any = None
    if lin.large:
        form, whole, kept, hertz = by_modes(lin, modes, bandwidth)
    else:
        if not traced:
            _refuse_undetermined(known)
            refuse_negative_mass(known)
            condensed = _all_massless(known)
        form = second_order(lin)
        if not traced:
            whole = jax.tree.map(np.asarray, undifferentiated(form))
            refuse_idle_inputs(known, whole)
        kept = () if modes is None and bandwidth is None else retained_modes(lin, modes, bandwidth)
    names = [f"mode {i + 1}" for i in kept]
    if not traced and not kept:
        names = [name for i, name in enumerate(lin.model.q_labels) if i not in condensed]
        if condensed and not names:
            raise AnalysisError("singular_mass", RESULTS.singular_mass.message + " Here no motion carries mass.")
    orders, moves = tuple(form.orders.tolist()), tuple(form.moves.tolist())
    kept_here = () if lin.large else kept
    realised = _realised(tuple(form[:12]), orders=orders, moves=moves, condensed=condensed, modes=kept_here)
    if traced:
        # NaN in place of a rate of an input.
        d = jnp.where(realised.late > 0, jnp.nan, realised.matrices.D)
        return realised.matrices._replace(D=d), _names(names, lin, orders, (names, names)) if names else [], None
    late, moved, numbers = undifferentiated((realised.late, realised.shifted, realised.matrices))
    _refuse_rates(lin, np.asarray(late), orders)
    shifted = [np.any(flags, axis=tuple(range(np.ndim(flags) - 1))).tolist() for flags in map(np.asarray, moved)]
    error = None
    if kept:
        if hertz is None:
            hertz = np.asarray(modal_frequencies(known)[0])
            hertz = hertz[np.isfinite(hertz)]
        error = error_of(known, whole, numbers, kept, np.asarray(hertz), bandwidth)
    elif condensed and lin.matrices.M0.ndim == 2:
        _warn_of_lost_damping(known, whole, numbers)
    return realised.matrices, _names(names, lin, orders, shifted), error


def damped_without_mass(lin: Linearization) -> str:
    """Name of a damped motion without mass, or empty; of concrete numbers."""
    condensed = _all_massless(lin)
    damping = np.asarray(lin.matrices.C0 + lin.matrices.D0)
    return lin.model.q_labels[condensed[0]] if np.any(damping[..., list(condensed), :]) else ""


def _warn_of_lost_damping(lin: Linearization, form: SecondOrder, matrices: StateMatrices) -> None:
    """Warn if damping of massless motions, which states do not include, changes responses at frequencies of poles."""
    name = damped_without_mass(lin)
    if not name or not matrices.B.size or not matrices.C.size:
        return
    a, b, c, d = (np.asarray(part) for part in matrices)
    rates = np.unique(np.abs(np.linalg.eigvals(a)).round(9))
    right, by_states = [], []
    for w in rates[rates > 0][:MOST_COMPARED]:
        k, forces, rows, through = form.at(1j * w)
        right.append(rows @ np.linalg.solve(k, forces) + through)
        by_states.append(c @ np.linalg.solve(1j * w * np.eye(len(a)) - a, b) + d)
    if not right:
        return
    sizes = np.maximum(np.abs(right), 1e-9 * np.max(np.abs(right), axis=0))
    off = np.max(np.abs(np.subtract(by_states, right)) / np.where(sizes > 0, sizes, 1.0))
    if not off < REPORTED_ERROR:
        warn(
            f"The motion of {name} carries no mass but is damped. A state space neglects this damping: responses and"
            f" poles are wrong by up to {100 * off:.2g} %. fm.poles, fm.frequency_response and a noise budget in a band"
            " include the damping. Give the motion a mass, or remove the damper."
        )


def _names(names: list[str], lin: Any, orders: tuple[int, ...], shifted: Any) -> list[str]:
    """Names of the states: degrees of freedom or modes, displacements that inputs are rates of, and rates."""
    labels = lin.labels.inputs
    moved = [(f"moved by {s.name}", order) for s, order in zip(labels, orders, strict=True) if order]
    z, v = ([f"{name} shifted" if by else name for name, by in zip(names, flags, strict=True)] for flags in shifted)
    speeds = [name for name, order in moved if order == 2]
    return [*z, *(name for name, _ in moved), *(f"d {name}" for name in (*v, *speeds))]


def _refuse_rates(lin: Any, late: np.ndarray, orders: tuple[int, ...]) -> None:
    """Refuse an output that needs a rate of an input, with the quantity to use instead."""
    late = np.max(late, axis=tuple(range(late.ndim - 2)), initial=0)
    if not np.any(late):
        return
    y, u = np.argwhere(late)[0]
    output, source = lin.labels.outputs[y].name, lin.labels.inputs[u].name
    has, takes, needs = (MOTIONS[orders[u] + int(rate)] for rate in (0, late[y, u], np.max(late[:, u])))
    raise ModelError(
        f"Output '{output}' needs the {takes} of the coordinate that the input '{source}' moves, but a state space"
        f' contains only its {has}. Give the input quantity="{needs}", which adds this motion to the states; or leave'
        " the output out."
    )


def _is_along_motion(model: Model | Linearization) -> TypeGuard[Linearization]:
    return isinstance(model, Linearization) and not model.large and model.matrices.M0.ndim > 2


def _refuse_undetermined(lin: Linearization) -> None:
    """Refuse a motion with times at which the degrees of freedom do not determine the configuration."""
    wrong = np.flatnonzero(np.asarray(lin.matrices.result) != RESULTS.successful)
    if len(wrong) and lin.matrices.M0.ndim > 2:
        code = RESULTS(int(np.asarray(lin.matrices.result)[wrong[0]]))
        raise AnalysisError(code.name, f"At {len(wrong)} of the times, {wrong[0]} the first: {code.message}")


def _at_each_time(lin: Linearization) -> list[Matrices]:
    """Matrices at the times of a motion, or of one state."""
    m = jax.tree.map(np.asarray, lin.matrices)
    return [m] if m.M0.ndim == 2 else [jax.tree.map(lambda a, i=i: a[i], m) for i in range(len(m.M0))]


def _all_massless(lin: Linearization) -> tuple[int, ...]:
    """Degrees of freedom to condense at all times."""
    condensed = {tuple(massless_freedoms(np.asarray(m.M0))) for m in _at_each_time(lin)}
    if len(condensed) > 1:
        raise AnalysisError(
            "singular_mass",
            RESULTS.singular_mass.message + " The motions without mass change with time. Choose one time.",
        )
    return condensed.pop()


def refuse_idle_inputs(lin: Linearization, whole: SecondOrder) -> None:
    """Raise ModelError for inputs whose columns of B and D are zero but for round-off, at all times; known numbers."""
    whole, condensed = jax.tree.map(np.asarray, whole), _all_massless(lin)
    if not len(whole.orders):
        return
    if condensed:
        refuse_without_anything(lin)
    inputs, weights = lin.model.labels.inputs, lin.model.parameters.weights
    factors = np.abs(np.asarray(combined(inputs, None if weights is None else weights[0])))
    sizes = coordinate_scales(lin.model.topology, lin.model.parameters)
    largest = np.max(sizes)
    size = factors @ np.array([max(1.0, largest) if s.of_element else sizes[s.index] for s in terms_of(inputs)])
    idle = np.ones(len(inputs), bool)
    numbers = whole[:12] if whole.M.ndim > 2 else [matrix[None] for matrix in whole[:12]]
    for m, *parts in zip(_at_each_time(lin), *numbers, strict=True):
        fields: Any = (*parts, whole.orders, whole.moves)
        state_form = SecondOrder(*fields)
        # Largest motion of each degree of freedom in extents and radians.
        reach = np.max(np.abs(m.DFx) / sizes[:, None], axis=0, initial=0.0)
        by_p, through = np.stack(state_form[3:6]), np.abs(state_form[9:12])
        pushes = np.any(np.abs(by_p[0]) > ROUND_OFF * size * reach[:, None], axis=0)
        acts = np.where(whole.moves, np.any(by_p, axis=(0, 1)), pushes)
        idle &= ~np.any(through > ROUND_OFF * np.maximum(1.0, size), axis=(0, 1))
        for i in np.flatnonzero(idle & acts):
            idle[i] = not whole.moves[i] and _drives_only_unseen(m, state_form, int(i), condensed)
    if np.any(idle):
        s = inputs[np.argmax(idle)]
        raise ModelError(
            f"Input '{s.name}' (a {s.quantity}) moves nothing in this state: its columns of B and D are zero. Let it"
            " act on a coordinate that can move, or leave it out."
        )


def _drives_only_unseen(m: Matrices, form: SecondOrder, i: int, condensed: tuple[int, ...]) -> bool:
    """Whether an input acts only on massless motions that no output measures."""
    if not condensed:
        return False
    force = form.B0[:, i]
    kept_indices = np.array([j for j in range(len(force)) if j not in condensed], int)
    direct = response_without_mass(m.M0, m.K, condensed, force, np.linalg.solve)
    unbalanced = (
        np.abs(force - m.K @ direct)[kept_indices]
        > ROUND_OFF * (np.abs(force) + np.abs(m.K) @ np.abs(direct))[kept_indices]
    )
    if np.any(unbalanced):
        return False
    return not np.any(np.abs(form.C0 @ direct) > ROUND_OFF * (np.abs(form.C0) @ np.abs(direct)))


@unguarded
def to_statespace(
    model: Model | Linearization,
    *,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
    modes: int | Sequence[int] | None = None,
    bandwidth: float | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
) -> "control.StateSpace":
    """Return the linearised mechanism as a ``control.StateSpace`` with names of states, inputs and outputs.

    Args:
        model: Mechanism, or its linearisation. From a linearisation along a motion, choose one time:
            ``lin.at_time(0)``. The damping comes from the elements, or from :func:`flexmb.damped`.
        at, step, time, increment: State, as for :func:`flexmb.frequencies`.
        modes: Number of the lowest modes to keep, or their numbers, from 0; see :func:`state_matrices`. Use few states
            for controller design: python-control cannot compute margins with many stiff states.
        bandwidth: Keep all modes up to this frequency [Hz].
        sparse, solver: As for :func:`state_matrices`.

    Returns:
        control.StateSpace with the matrices of :func:`state_matrices`. With kept modes it has an attribute
        ``truncation_error``, (n_y, n_u) [-]: largest error of the response of each output to each input, up to
        ``bandwidth`` or the highest mode kept. The reference has all modes. flexmb computes the error at 120
        frequencies over two decades, and at four frequencies beside each mode. With sparse matrices these are 40
        frequencies, and two beside each mode. The difference of the responses is divided by the response with all
        modes. If the median of this response within half an octave to both sides is larger, the median is the divisor.
        An antiresonance therefore does not count.

    Raises:
        ModelError: The model names no inputs or no outputs, an output needs a rate of an input, or an input moves
            nothing; the linearisation has many times.
        AnalysisError: singular_mass.
        ValueError: As :func:`state_matrices`.
        TypeError: Numbers are traced, as under ``jax.grad``.

    Warns:
        FlexmbWarning: ``truncation_error`` has an entry above 0.01.

    Source:
        See :func:`state_matrices`.
    """
    import control

    if _is_along_motion(model):
        raise ModelError(
            f"This linearisation is along a motion, at {len(model.matrices.M0)} times, but a control.StateSpace has"
            " one. Give lin.at_time(0), or use A, B, C and D at all times from state_matrices(lin)."
        )
    few = modes is not None or bandwidth is not None
    lin = asked_about(model, "to_statespace", Where(at, step, time, increment), asked_solver(sparse, solver), few=few)
    inputs, outputs = ([s.name for s in signals] for signals in (lin.labels.inputs, lin.labels.outputs))
    if not inputs or not outputs:
        raise ModelError("A state-space model needs an input and an output. Name them with input() and output().")
    if not is_concrete(lin):
        raise TypeError(
            "A control.StateSpace needs concrete numbers. Make it outside jax.jit and jax.grad, or use"
            " fm.control.state_matrices, which has derivatives."
        )
    matrices, states, error = _matrices_of(lin, modes, bandwidth)
    # python-control refuses dots in names.
    labels = [[name.replace(".", " ") for name in names] for names in (states, inputs, outputs)]
    parts = [np.asarray(m) for m in matrices]
    system: Any = control.StateSpace(*parts, states=labels[0], inputs=labels[1], outputs=labels[2])
    if error is not None:
        system.truncation_error = error
    return system
