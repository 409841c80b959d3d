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
from ..linear.spectrum import massless_freedoms, response_without_mass
from ..math.linear import Factors, factorise
from ..math.linear_solver import LinearSolver, asked_solver
from ..mechanics.extent import sizes_of
from ..mechanics.signals import combined, terms_of
from ..model.model import MOTIONS, Model
from ..results import RESULTS
from ..statics.equilibrium import Equilibrium
from .second_order_form import SecondOrder, second_order
from .truncation import by_modes, chosen_modes, error_of, error_of_large, truncated

if TYPE_CHECKING:
    import control

# A state space may be off by so much without a word, looked at at so many frequencies.
LOST_DAMPING, MOST_COMPARED = 0.01, 60
# What an input does below this share of what it could, as round-off leaves it, is nothing.
IDLE = 1e-12
# A rate of an input below this share of what it consists of is round-off.
LEFT = 1e-9


class StateMatrices(NamedTuple):
    """z_dot = A z + B u, y = C z + D u with z = (q, q_dot) of the degrees of freedom that carry mass.

    Where inputs are velocities or accelerations of what is held, its displacements stand after q and, of accelerations,
    its velocities after q_dot.

    Attributes:
        A: (n_z, n_z); n_z is 2 n without such inputs.
        B: (n_z, n_u).
        C: (n_y, n_z).
        D: (n_y, n_u).
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]

    def __repr__(self) -> str:
        return "StateMatrices: " + ", ".join(f"{name} {np.shape(own)}" for name, own in self._asdict().items())


class _Realised(NamedTuple):
    """State-space matrices, and what their names and their checks need.

    Attributes:
        matrices: A, B, C and D.
        late: Which rate of an input an output takes that no state space has, 0 where it takes none, (n_y, n_u).
        shifted: Whether the states that stand for the degrees of freedom, and those for their rates, are less what the
            inputs move at once, (n,) and (n,).
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
    """First-order form of a second-order one, motions without mass condensed, or all modes but some; at each time."""

    def one(parts: tuple[Array, ...]):
        return _realised_at(parts, np.array(orders, int), np.array(moves, float), condensed, modes)

    return one(parts) if parts[0].ndim == 2 else jax.vmap(one)(parts)


def _realised_at(
    parts: tuple[Array, ...], orders: np.ndarray, moves: np.ndarray, condensed: tuple[int, ...], modes: tuple[int, ...]
) -> _Realised:
    m, c, k, *by_p = parts[:6]
    c_q, through = list(parts[6:9]), list(parts[9:12])
    n_q, n_u = by_p[0].shape
    kept = np.array([i for i in range(n_q) if i not in condensed], int)
    keep, direct = jnp.eye(n_q)[:, kept], jnp.zeros((n_q, n_u))
    left_out: Any = None
    if modes:
        keep, left_out = truncated(k, m, modes)
        direct = left_out(by_p[0])
    elif condensed:
        moved = response_without_mass(m, k, condensed, jnp.concatenate([by_p[0], k @ keep], axis=1))
        direct, keep = moved[:, :n_u], keep - moved[:, n_u:]
    mass, damping, stiffness = (keep.T @ of @ keep for of in (m, c, k))
    by_p[0], through[0] = by_p[0] - k @ direct, through[0] + c_q[0] @ direct
    by_rates = 0.0 if left_out is None else c_q[0] @ left_out(c @ keep)
    if np.any(moves):
        # What follows at once follows a motion with its rates, too; rates of forces are not known.
        for i, of in ((1, c), (2, m)):
            by_p[i], through[i] = by_p[i] - of @ (direct * moves), through[i] + c_q[i] @ (direct * moves)
            if left_out is not None:
                # And what it meets then by damping and inertia, where the input has such a rate.
                through[i] = through[i] + c_q[0] @ left_out(by_p[i] * (orders >= i).astype(float))
        by_p, c_q = [keep.T @ of for of in by_p], [of @ keep for of in c_q]
        c_q[1] = c_q[1] - by_rates
        return _first_order(mass, damping, stiffness, by_p, c_q, through, orders)
    n = keep.shape[1]
    lower = factorise(mass).solve(jnp.concatenate([-stiffness, -damping, keep.T @ by_p[0]], axis=1))
    v_dot, pull = lower[:, : 2 * n], lower[:, 2 * n :]
    z_dot = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n)], axis=1)
    row = jnp.concatenate([c_q[0] @ keep, c_q[1] @ keep - by_rates], axis=1) + c_q[2] @ keep @ v_dot
    found = StateMatrices(
        jnp.concatenate([z_dot, v_dot]),
        jnp.concatenate([jnp.zeros((n, n_u)), pull]),
        row,
        through[0] + c_q[2] @ keep @ pull,
    )
    return _Realised(found, jnp.zeros(found.D.shape, jnp.int32), (jnp.zeros(n, bool), jnp.zeros(n, bool)))


def _first_order(
    mass: Float[Array, "n n"],
    damping: Float[Array, "n n"],
    stiffness: Float[Array, "n n"],
    by_p: list[Array],
    c_q: list[Array],
    through: list[Array],
    orders: np.ndarray,
) -> _Realised:
    """States z, displacements that inputs are rates of, v, and velocities that inputs are rates of; (14.5)."""
    n, n_u = by_p[0].shape
    inverse = factorise(mass)
    once, twice = np.flatnonzero(orders > 0), np.flatnonzero(orders == 2)

    def level(of: list[Array], rate: int):
        """What a rate of the inputs does, or where negative an integral of them, of what their displacements do."""
        nothing = jnp.zeros(of[0].shape[0])
        return jnp.stack([of[k + rate][:, j] if 0 <= k + rate < 3 else nothing for j, k in enumerate(orders)], axis=1)

    b0, b1, b2 = (level(by_p, rate) for rate in range(3))
    d0, d1, d2 = (level(through, rate) for rate in range(3))
    at_once = inverse.solve(b2)
    rates = inverse.solve(b1 - damping @ at_once)
    integrals, sensed = ([level(of, -1)[:, once], level(of, -2)[:, twice]] for of in (by_p, through))
    # Columns: z, v, the first integrals of inputs and the second ones.
    by_state = jnp.concatenate([-stiffness, -damping, *integrals], axis=1)
    lower = inverse.solve(jnp.concatenate([by_state, b0 - stiffness @ at_once - damping @ rates], axis=1))
    v_dot, pull = jnp.split(lower, [by_state.shape[1]], axis=1)
    (c0, c1, c2), more = c_q, len(once) + len(twice)
    row = jnp.concatenate([c0, c1, *sensed], axis=1) + c2 @ v_dot
    d = c0 @ at_once + c1 @ rates + c2 @ pull + d0
    z_dot, eye = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n), np.zeros((n, more))], axis=1), np.eye(n_u)
    # The rate of a second integral is the first one of the same input.
    first = np.concatenate(
        [
            np.zeros((len(twice), 2 * n)),
            eye[np.asarray(twice, int)][:, np.asarray(once, int)],
            np.zeros((len(twice),) * 2),
        ],
        1,
    )
    a = jnp.concatenate([z_dot, v_dot, np.zeros((len(once), 2 * n + more)), first])
    b = jnp.concatenate([rates, pull, eye[once], np.zeros((len(twice), n_u))])
    # Into the order of names: displacements after z, velocities after v.
    places = {j: 2 * n + i for i, j in enumerate(once)} | {j: 2 * n + len(once) + i for i, j in enumerate(twice)}
    speeds = [2 * n + i for i, j in enumerate(once) if orders[j] == 2]
    order = np.array([*range(n), *(places[j] for j in once), *range(n, 2 * n), *speeds], int)
    late = _left(inverse, damping, (b1, b2), (at_once, rates), (c1, c2), (d1, d2))
    shifted = jnp.any(at_once != 0, axis=1), jnp.any((rates != 0) | (at_once != 0), axis=1)
    return _Realised(StateMatrices(a[order][:, order], b[order], row[:, order], d), late, shifted)


def _left(
    inverse: Factors,
    damping: Float[Array, "n n"],
    by_rates: tuple[Array, Array],
    moved: tuple[Array, Array],
    c: tuple[Array, Array],
    through: tuple[Array, Array],
):
    """Which rate of an input is left in an output, 1 or 2, or 0; what is below round-off of its parts is nothing."""
    (b1, b2), (at_once, rates), (c1, c2), (d1, d2) = by_rates, moved, c, through
    size = jnp.abs(inverse.solve(jnp.eye(len(damping))))
    most = size @ jnp.abs(b2)
    most_rate = size @ (jnp.abs(b1) + jnp.abs(damping) @ most)
    first, second = c1 @ at_once + c2 @ rates + d1, c2 @ at_once + d2
    largest = jnp.abs(c1) @ most + jnp.abs(c2) @ most_rate + jnp.abs(d1), jnp.abs(c2) @ most + jnp.abs(d2)
    there = [jnp.abs(of) > LEFT * size for of, size in zip((first, second), largest, strict=True)]
    return jnp.where(there[1], 2, jnp.where(there[0], 1, 0))


def state_matrices(
    model: Model | Linearization,
    *,
    modes: int | Sequence[int] | None = None,
    bandwidth: float | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
) -> tuple[StateMatrices, list[str]]:
    """State-space matrices about the static equilibrium, for the model's named inputs and outputs.

    Motions without mass are condensed statically, without their damping: states are the degrees of freedom that carry
    mass. Where everything is held there are none, and D says how the outputs follow.

    An input that is the displacement of what is held adds no states: they are the degrees of freedom less what the
    input moves at once by its inertia, and are then named "shifted". A velocity adds its integral to the states, an
    acceleration both of its integrals, named "moved by" the input. An output that takes a rate of an input, such as the
    acceleration of a mass where the displacement of a damper's end is the input, is refused by the quantity to take.

    Args:
        model: Mechanism, or its linearisation, also that along a motion: then the matrices have the times in front.
            Differentiable in its parameters for named inputs and outputs. Which motions carry no mass is decided on
            concrete numbers; under a trace all are taken to carry mass, and D is NaN where an output takes a rate of an
            input.
        modes: How many of the lowest modes to keep, or which, numbered from 0; the states are their amplitudes [m
            sqrt(kg)] and rates. All others follow inputs at once, as they do at rest, to an acceleration of what is
            held with the inertia that it moves: the response at rest of positions, deformations, stresses and reactions
            is right, and that in the band nearly so. Velocities and accelerations of what follows would take rates of
            the inputs and are left out, so that these outputs are off by the share of the flexibility at rest that is
            not that of the modes kept. By damping what follows does not act back on the modes that are kept.
            Differentiable where the frequencies of modes that are kept differ from all others.
        bandwidth: Keep all modes up to this frequency [Hz]; not under a trace.
        sparse: Modes by sparse matrices in all coordinates, of a model that needs no degrees of freedom; see
            :func:`flexmb.equilibrium` for what these take. Chosen by size unless given, where modes are to be kept.
        solver: "sparse", "dense", or a LinearSolver in place of sparse factors, as for :func:`flexmb.frequencies`.

    Returns:
        A, B, C, D (shapes in StateMatrices) [SI], and the names of the states.

    Raises:
        ModelError: An input moves nothing, or an output takes a rate of an input.
        AnalysisError: singular_mass where no degree of freedom carries mass, or some motion a negative one; what the
            linearisation failed by.
        ValueError: Both ``modes`` and ``bandwidth`` are given, there are no such modes, no mode is below the bandwidth,
            or a motion would be left out that does not vibrate.
        NotImplementedError: Modes are to be kept, and an unsymmetric stiffness gives none.

    Warns:
        FlexmbWarning: Damping of motions without mass is left out, and responses at the frequencies of poles are off by
            more than 1 % for that; what is kept is off by more than 1 % in its band, as :func:`to_statespace` says.

    Source:
        THEORY.md 7, eq. (7.7), with modes (7.14); tutorial WA 1239 (2012), eq. (2.3) and (A.4): A = [[0, I], [-M0^-1 K,
        -M0^-1 (C0 + D0)]], a stress input adds to sigma: B = -M0^-1 DFe^T; motions of what is held and constraint
        forces 14, eq. (14.1) to (14.5).
    """
    few = modes is not None or bandwidth is not None
    lin = (
        model
        if _is_along_motion(model)
        else asked_about(model, "state_matrices", None, asked_solver(sparse, solver), few=few)
    )
    found, names, _ = _matrices_of(lin, modes, bandwidth)
    return found, names


def _matrices_of(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[StateMatrices, list[str], Any]:
    """State-space matrices, names of the states, and of some modes the error in their band, unless under a trace."""
    known = lin if lin.large else undifferentiated(lin)
    traced, condensed, kept = not is_concrete(known), (), ()
    plain: Any = None
    if lin.large:
        some = by_modes(lin, modes, bandwidth)
        form, names = some.form, [f"mode {i + 1}" for i in some.kept]
    else:
        some = None
        if not traced:
            _refuse_undetermined(known)
            refuse_negative_mass(known)
            condensed = _all_massless(known)
        form = second_order(lin)
        if not traced:
            plain = jax.tree.map(np.asarray, undifferentiated(form))
            refuse_idle_inputs(known, plain)
        kept = chosen_modes(lin, modes, bandwidth) if modes is not None or bandwidth is not None else ()
        names = [f"mode {i + 1}" for i in kept]
        if not traced and not kept:
            names = [name for i, name in enumerate(lin.model.q_labels) if i not in condensed]
            if condensed and not names:
                raise AnalysisError("singular_mass", RESULTS.singular_mass.message + " Here no motion carries mass.")
    orders, moves = tuple(form.orders.tolist()), tuple(form.moves.tolist())
    found = _realised(tuple(form[:12]), orders=orders, moves=moves, condensed=condensed, modes=kept)
    if traced:
        # No number stands where a rate of an input would have to.
        d = jnp.where(found.late > 0, jnp.nan, found.matrices.D)
        return found.matrices._replace(D=d), _names(names, lin, orders, (names, names)) if names else [], None
    late, moved, numbers = undifferentiated((found.late, found.shifted, found.matrices))
    _refuse_rates(lin, np.asarray(late), orders)
    shifted = [np.any(of, axis=tuple(range(np.ndim(of) - 1))).tolist() for of in map(np.asarray, moved)]
    error = None
    if some is not None:
        error = error_of_large(lin, some, bandwidth, numbers)
    elif kept:
        error = error_of(known, kept, bandwidth, plain, numbers)
    elif condensed and lin.matrices.M0.ndim == 2:
        _warn_of_lost_damping(known, plain, numbers)
    return found.matrices, _names(names, lin, orders, shifted), error


def damped_without_mass(lin: Linearization) -> str:
    """Name of a motion without mass that is damped, empty where there is none; of concrete numbers."""
    condensed = _all_massless(lin)
    damping = np.asarray(lin.matrices.C0 + lin.matrices.D0)
    return lin.model.q_labels[condensed[0]] if np.any(damping[..., list(condensed), :]) else ""


def _warn_of_lost_damping(lin: Linearization, whole: SecondOrder, found: StateMatrices) -> None:
    """Warn where damping of motions without mass matters, for which positions and rates of the others are no states.

    Responses to all inputs are compared, at the frequencies of the poles, with those of the second-order form.
    """
    name = damped_without_mass(lin)
    if not name or not found.B.size or not found.C.size:
        return
    a, b, c, d = (np.asarray(part) for part in found)
    rates = np.unique(np.abs(np.linalg.eigvals(a)).round(9))
    right, own = [], []
    for w in rates[rates > 0][:MOST_COMPARED]:
        k, forces, rows, through = whole.at(1j * w)
        right.append(rows @ np.linalg.solve(k, forces) + through)
        own.append(c @ np.linalg.solve(1j * w * np.eye(len(a)) - a, b) + d)
    if not right:
        return
    sizes = np.maximum(np.abs(right), 1e-9 * np.max(np.abs(right), axis=0))
    off = np.max(np.abs(np.subtract(own, right)) / np.where(sizes > 0, sizes, 1.0))
    if not off < LOST_DAMPING:
        warn(
            f"The motion of {name} carries no mass but is damped. A state space has it follow at once, without that"
            f" damping: responses are off by up to {100 * off:.2g} %, and poles with them. fm.poles,"
            " fm.frequency_response and a noise budget in a band have the damping. Give it a mass, or no damper."
        )


def _names(names: list[str], lin: Any, orders: tuple[int, ...], shifted: Any) -> list[str]:
    """Names of the states: of degrees of freedom or modes, of displacements that inputs are rates of, and of rates."""
    labels = lin.labels.inputs
    moved = [(f"moved by {s.name}", order) for s, order in zip(labels, orders, strict=True) if order]
    z, v = ([f"{name} shifted" if by else name for name, by in zip(names, of, strict=True)] for of in shifted)
    speeds = [name for name, order in moved if order == 2]
    return [*z, *(name for name, _ in moved), *(f"d {name}" for name in (*v, *speeds))]


def _refuse_rates(lin: Any, late: np.ndarray, orders: tuple[int, ...]) -> None:
    """Refuse an output that takes a rate of an input, by the quantity to take in its place."""
    late = np.max(late, axis=tuple(range(late.ndim - 2)), initial=0)
    if not np.any(late):
        return
    y, u = np.argwhere(late)[0]
    output, source = lin.labels.outputs[y].name, lin.labels.inputs[u].name
    has, takes, needs = (MOTIONS[orders[u] + int(rate)] for rate in (0, late[y, u], np.max(late[:, u])))
    raise ModelError(
        f"Output '{output}' takes the {takes} of what the input '{source}' moves, which a state space cannot tell from"
        f' its {has}: let the input be the {needs}, quantity="{needs}", which adds the motion itself to the states; or'
        " leave the output out."
    )


def _is_along_motion(model: Model | Linearization) -> TypeGuard[Linearization]:
    return isinstance(model, Linearization) and not model.large and model.matrices.M0.ndim > 2


def _refuse_undetermined(lin: Linearization) -> None:
    """Refuse a motion at some time of which the degrees of freedom do not determine the configuration."""
    wrong = np.flatnonzero(np.asarray(lin.matrices.result) != RESULTS.successful)
    if len(wrong) and lin.matrices.M0.ndim > 2:
        code = RESULTS(int(np.asarray(lin.matrices.result)[wrong[0]]))
        raise AnalysisError(code.name, f"At {len(wrong)} of the times, {wrong[0]} the first: {code.message}")


def _at_each_time(lin: Linearization) -> list[Matrices]:
    """Matrices at the times of a motion, or the only ones."""
    m = jax.tree.map(np.asarray, lin.matrices)
    return [m] if m.M0.ndim == 2 else [jax.tree.map(lambda a, i=i: a[i], m) for i in range(len(m.M0))]


def _all_massless(lin: Linearization) -> tuple[int, ...]:
    """Degrees of freedom to condense at all times."""
    found = {tuple(massless_freedoms(np.asarray(m.M0))) for m in _at_each_time(lin)}
    if len(found) > 1:
        raise AnalysisError(
            "singular_mass",
            RESULTS.singular_mass.message + " Which motion carries none changes along the motion: choose a time.",
        )
    return found.pop()


def refuse_idle_inputs(lin: Linearization, whole: SecondOrder) -> None:
    """Raise ModelError of inputs whose columns of B and D are zero but for round-off, at all times; known numbers."""
    whole, condensed = jax.tree.map(np.asarray, whole), _all_massless(lin)
    if not len(whole.orders):
        return
    if condensed:
        refuse_without_anything(lin)
    inputs, weights = lin.model.labels.inputs, lin.model.parameters.weights
    factors = np.abs(np.asarray(combined(inputs, None if weights is None else weights[0])))
    sizes = sizes_of(lin.model.topology, lin.model.parameters)
    largest = np.max(sizes)
    own = np.array([max(1.0, largest) if s.of_element else sizes[s.index] for s in terms_of(inputs)])
    size = factors @ own
    idle = set(range(len(inputs)))
    numbers = whole[:12] if whole.M.ndim > 2 else [of[None] for of in whole[:12]]
    for m, *parts in zip(_at_each_time(lin), *numbers, strict=True):
        own_parts: Any = (*parts, whole.orders, whole.moves)
        now = SecondOrder(*own_parts)
        # How far, in extents and radians, each degree of freedom moves what it moves most.
        reach = np.max(np.abs(m.DFx) / sizes[:, None], axis=0, initial=0.0)
        for i in sorted(idle):
            if whole.moves[i]:
                acts = any(np.any(of[:, i]) for of in (now.B0, now.B1, now.B2))
            else:
                acts = np.any(np.abs(now.B0[:, i]) > IDLE * size[i] * reach)
                acts = acts and not _drives_only_unseen(m, now, i, condensed)
            seen = any(np.any(np.abs(of[:, i]) > IDLE * max(1.0, size[i])) for of in (now.D0, now.D1, now.D2))
            if acts or seen:
                idle.discard(i)
    if idle:
        s = inputs[min(idle)]
        raise ModelError(
            f"Input '{s.name}' (a {s.quantity}) moves nothing about this state: its columns of B and D are zero. Let it"
            " act on what can move, or leave it out."
        )


def _drives_only_unseen(m: Matrices, whole: SecondOrder, i: int, condensed: tuple[int, ...]) -> bool:
    """Whether an input acts on massless motions alone, of which no output tells."""
    if not condensed:
        return False
    force = whole.B0[:, i]
    kept = np.array([j for j in range(len(force)) if j not in condensed], int)
    direct = response_without_mass(m.M0, m.K, condensed, force, np.linalg.solve)
    left = np.abs(force - m.K @ direct)[kept] > IDLE * (np.abs(force) + np.abs(m.K) @ np.abs(direct))[kept]
    if np.any(left):
        return False
    return not np.any(np.abs(whole.C0 @ direct) > IDLE * (np.abs(whole.C0) @ np.abs(direct)))


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
    """The linearised mechanism as a ``control.StateSpace`` with names for states, inputs and outputs.

    Args:
        model: Mechanism, or its linearisation; of a motion that at one time, ``lin.at_time(0)``. Damping is that of its
            elements, unless it is a linearisation by :func:`flexmb.damped`.
        at, step, time, increment: About which state it is asked, as for :func:`flexmb.frequencies`.
        modes: How many of the lowest modes to keep, or which, numbered from 0; see :func:`state_matrices`. A controller
            is designed on few states, and margins of many stiff ones are beyond python-control.
        bandwidth: Keep all modes up to this frequency [Hz].
        sparse, solver: As for :func:`state_matrices`.

    Returns:
        control.StateSpace; matrices as :func:`state_matrices`. Where modes are kept it has an attribute
        ``truncation_error``, (n_y, n_u) [-]: by how much the response of each output to each input is off at most, up
        to ``bandwidth`` or else the highest mode that is kept. It is measured against all modes at 120 frequencies over
        two decades and beside each mode; by sparse matrices at 40 frequencies and at two beside each mode. It is the
        difference over the larger of the full response there and its median within half an octave to both sides, which
        keeps an antiresonance from counting.

    Raises:
        ModelError: The model names no inputs or no outputs, an output takes a rate of an input, or an input moves
            nothing; the linearisation is that at many times.
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
            f"This linearisation is along a motion, at {len(model.matrices.M0)} times, and a control.StateSpace is that"
            " at one: give lin.at_time(0), or take A, B, C and D at all of them from state_matrices(lin)."
        )
    few = modes is not None or bandwidth is not None
    lin = asked_about(model, "to_statespace", Where(at, step, time, increment), asked_solver(sparse, solver), few=few)
    inputs, outputs = ([s.name for s in found] for found in (lin.labels.inputs, lin.labels.outputs))
    if not inputs or not outputs:
        raise ModelError("A state-space model needs an input and an output: name them with input() and output().")
    if not is_concrete(lin):
        raise TypeError(
            "A control.StateSpace holds concrete numbers: make it outside jax.jit and jax.grad, or take"
            " fm.control.state_matrices, which has derivatives."
        )
    found, states, error = _matrices_of(lin, modes, bandwidth)
    # control refuses a dot in a name.
    clean = [[name.replace(".", " ") for name in names] for names in (states, inputs, outputs)]
    parts = [np.asarray(m) for m in found]
    system: Any = control.StateSpace(*parts, states=clean[0], inputs=clean[1], outputs=clean[2])
    if error is not None:
        system.truncation_error = error
    return system
