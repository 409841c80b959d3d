"""The linearised mechanism as a state-space model of python-control."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import jit
from ..errors import AnalysisError, ModelError
from ..linear.linearize import Linearization, ManyStates, Matrices, Where, linearized
from ..linear.loose import refuse_negative_mass
from ..linear.spectrum import massless_freedoms, response_without_mass
from ..math.linear import factorise
from ..mechanics.extent import sizes_of
from ..mechanics.signals import along_coordinates, input_row, rotation_row
from ..model.model import Model, Signal
from ..model.roles import Role
from ..results import RESULTS
from .truncation import chosen_modes, error_of, truncated

if TYPE_CHECKING:
    import control

# What an input does below this share of what it could, as round-off leaves it, is nothing.
IDLE = 1e-12


class StateMatrices(NamedTuple):
    """z_dot = A z + B u, y = C z + D u with z = (q, q_dot) of the degrees of freedom that carry mass.

    Attributes:
        A: (2 n, 2 n).
        B: (2 n, n_u).
        C: (n_y, 2 n).
        D: (n_y, n_u).
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]

    def __repr__(self) -> str:
        return "StateMatrices: " + ", ".join(f"{name} {np.shape(own)}" for name, own in self._asdict().items())


@jit
def _state_matrices(
    m: Matrices,
    inputs: tuple[Signal, ...],
    outputs: tuple[Signal, ...],
    condensed: tuple[int, ...],
    modes: tuple[int, ...] = (),
) -> StateMatrices:
    """Second-order system with massless motions condensed statically, then in first-order form; along a motion each.

    Where modes are given, all others are condensed.
    """

    def one(m: Matrices) -> StateMatrices:
        return _state_matrices_at(m, inputs, outputs, condensed, modes)

    return one(m) if m.M0.ndim == 2 else jax.vmap(one)(m)


def _forces(m: Matrices, inputs) -> Float[Array, "n_q n_u"]:
    """What inputs do to the degrees of freedom, one a column."""
    forces = [input_row(s, m.x, m.DFx, m.DFe) for s in inputs]
    return jnp.stack(forces, axis=1) if forces else jnp.zeros((m.M0.shape[0], 0))


def _passed(s: Signal, inputs) -> Float[Array, "n_u"]:
    """What an output takes of the inputs themselves: a stress input adds to the stress."""
    return jnp.array([float(s.quantity == u.quantity == "stress" and u.index == s.index) for u in inputs])


def _state_matrices_at(m: Matrices, inputs, outputs, condensed, modes) -> StateMatrices:
    n_q = m.M0.shape[0]
    kept = np.array([i for i in range(n_q) if i not in condensed], int)
    b = _forces(m, inputs)
    damping = m.C0 + m.D0
    keep, direct = jnp.eye(n_q)[:, kept], jnp.zeros((n_q, b.shape[1]))
    if modes:
        keep, direct = truncated(m, b, modes)
    elif condensed:
        moved = response_without_mass(m.M0, m.K, condensed, jnp.concatenate([b, m.K @ keep], axis=1))
        direct, keep = moved[:, : b.shape[1]], keep - moved[:, b.shape[1] :]
    mass, stiffness = keep.T @ m.M0 @ keep, keep.T @ m.K @ keep
    inverse = factorise(mass)
    n = keep.shape[1]
    lower = jnp.concatenate([-inverse.solve(stiffness), -inverse.solve(keep.T @ damping @ keep)], axis=1)
    upper = jnp.concatenate([jnp.zeros((n, n)), jnp.eye(n)], axis=1)
    drive = inverse.solve(keep.T @ (b - m.K @ direct))
    # Of the degrees of freedom, their rates and their second rates by the state.
    none = jnp.zeros((n_q, n))
    by_state = [jnp.concatenate([keep, none], axis=1), jnp.concatenate([none, keep], axis=1), keep @ lower]
    by_input = [direct, jnp.zeros_like(direct), keep @ drive]
    rows, feedthrough = [], []
    for s in outputs:
        parts = _output_rows(s, m)
        row, through = (
            sum(part @ matrix for part, matrix in zip(parts, of, strict=True) if part is not None)
            for of in (by_state, by_input)
        )
        rows.append(row)
        feedthrough.append(through + _passed(s, inputs))
    c = jnp.stack(rows) if rows else jnp.zeros((0, 2 * n))
    d = jnp.stack(feedthrough) if feedthrough else jnp.zeros((0, b.shape[1]))
    drive = jnp.concatenate([jnp.zeros((n, b.shape[1])), drive])
    return StateMatrices(jnp.concatenate([upper, lower]), drive, c, d)


def _output_rows(s: Signal, m: Matrices) -> tuple[Any, ...]:
    """Derivatives of an output by the degrees of freedom, their rates and their second rates; None where there is none.

    Along a motion the rate of DFx q is DFx qd + DFx_d q, and a rotation's axes turn: of omega = 2 Lbar(lambda)
    d(lambda)/dt the change is 2 Lbar(lambda) of the rate's less 2 Lbar(d(lambda)/dt) of the parameters'.
    """
    moving = m.moving
    if s.quantity == "stress":
        rates = m.S_d[s.index]
        by_q = m.S[s.index] @ m.DFe
        return by_q if moving is None else by_q + rates @ moving.DFe_d, rates @ m.DFe, None
    of_e = s.quantity.startswith("deformation")
    order = ("position", "velocity", "acceleration")
    if of_e:
        order = ("deformation", "deformation rate", "deformation acceleration")
    place = order.index(s.quantity)
    own, row = (jnp.array([s.index]), jnp.ones(1)) if of_e else along_coordinates(s, m.x)
    along = row @ (m.DFe if of_e else m.DFx)[own]
    if place == 0 or moving is None:
        return tuple(along if i == place else None for i in range(3))
    first, second = (moving.DFe_d, moving.DFe_dd) if of_e else (moving.DFx_d, moving.DFx_dd)
    turning = jnp.zeros_like(along)
    if s.axis is not None:
        rates = moving.xd if place == 1 else moving.xdd
        turning = rotation_row(rates[own], s.axis, s.local) @ m.DFx[own]
    if place == 1:
        return row @ first[own] - turning, along, None
    return row @ second[own] - turning, 2 * row @ first[own], along


def state_matrices(
    model: Model | Linearization, *, modes: int | Sequence[int] | None = None, bandwidth: float | None = None
) -> tuple[StateMatrices, list[str]]:
    """State-space matrices about the static equilibrium, for the model's named inputs and outputs.

    Motions without mass are condensed statically (their damping is left out), so that the states are those of the
    degrees of freedom that carry mass.

    Args:
        model: Mechanism, or its linearisation, also that along a motion: then the matrices have the times in front.
            Differentiable in its parameters for named inputs and outputs. Which motions carry no mass is decided on
            concrete numbers; under a trace all are taken to carry mass.
        modes: How many of the lowest modes to keep, or which, numbered from 0; the states are their amplitudes
            [m sqrt(kg)] and rates. All others follow inputs at once, as they do at rest: the response at rest of
            positions, deformations and stresses is right, and that in the band nearly so. Velocities and accelerations
            of what follows would take rates of the inputs and are left out, so that these outputs are off by the share
            of the flexibility at rest that is not that of the modes kept. Left out, too, is damping between modes
            that are kept and others. Differentiable where the frequencies of modes that are kept differ from all
            others.
        bandwidth: Keep all modes up to this frequency [Hz]; not under a trace.

    Returns:
        A, B, C, D (shapes in StateMatrices) [SI], and the names of the states.

    Raises:
        ModelError: An output is the stress of a FIXED deformation, or an input moves nothing.
        AnalysisError: singular_mass where nothing carries mass, or some motion a negative one; what the linearisation
            failed by.
        ValueError: Both ``modes`` and ``bandwidth`` are given, there are no such modes, no mode is below the bandwidth,
            or a motion would be left out that does not vibrate.
        NotImplementedError: Modes are to be kept, and an unsymmetric stiffness gives none.

    Warns:
        FlexmbWarning: What is kept is off by more than 1 % in its band, up to ``bandwidth`` or else the highest mode
            that is kept, measured as :func:`to_statespace` says.

    Source:
        THEORY.md 7, eq. (7.7), with modes (7.14); tutorial WA 1239 (2012), eq. (2.3) and (A.4): A = [[0, I],
        [-M0^-1 K, -M0^-1 (C0 + D0)]], a stress input adds to sigma: B = -M0^-1 DFe^T.
    """
    lin = model if _is_along_motion(model) else linearized(model, "state_matrices")
    found, names, _ = _matrices_of(lin, modes, bandwidth)
    return found, names


def _matrices_of(lin: Linearization, modes: Any, bandwidth: Any) -> tuple[StateMatrices, list[str], Any]:
    """State-space matrices, names of the states, and of some modes the error in their band, unless under a trace."""
    labels, m = lin.labels, lin.matrices
    traced = not is_concrete(m)
    condensed: tuple[int, ...] = ()
    if not traced:
        _check_times(lin)
        _check_outputs(lin)
        refuse_negative_mass(lin)
        condensed = _all_massless(lin)
        _refuse_idle_inputs(lin, condensed)
    if modes is not None or bandwidth is not None:
        return _truncated(lin, condensed, modes, bandwidth)
    names = [name for i, name in enumerate(lin.model.q_labels) if i not in condensed] if not traced else []
    if not traced and not names:
        raise AnalysisError("singular_mass", RESULTS.singular_mass.message + " Here no motion carries mass.")
    found = _state_matrices(m, inputs=labels.inputs, outputs=labels.outputs, condensed=condensed)
    return found, names + [f"d {name}" for name in names], None


def _truncated(lin: Linearization, condensed: tuple[int, ...], modes: Any, bandwidth: Any):
    """As :func:`_matrices_of`, of some modes."""
    labels, m = lin.labels, lin.matrices
    kept = chosen_modes(lin, modes, bandwidth)
    found = _state_matrices(m, inputs=labels.inputs, outputs=labels.outputs, condensed=condensed, modes=kept)
    names, error = [f"mode {i + 1}" for i in kept], None
    if is_concrete(m):
        rows = [jax.tree.map(np.asarray, (*_output_rows(s, m), _passed(s, labels.inputs))) for s in labels.outputs]
        forces = np.asarray(_forces(m, labels.inputs))
        error = error_of(lin, kept, bandwidth, forces, rows, found)
    return found, names + [f"d {name}" for name in names], error


def _is_along_motion(model: Model | Linearization) -> TypeGuard[Linearization]:
    return isinstance(model, Linearization) and model.matrices.M0.ndim > 2


def _check_times(lin: Linearization) -> None:
    """Refuse a motion at some time of which the degrees of freedom do not determine the configuration."""
    wrong = np.flatnonzero(np.asarray(lin.matrices.result) != RESULTS.successful)
    if len(wrong) and lin.matrices.M0.ndim > 2:
        code = RESULTS(int(np.asarray(lin.matrices.result)[wrong[0]]))
        raise AnalysisError(code.name, f"At {len(wrong)} of the times, {wrong[0]} the first: {code.message}")


def _check_outputs(lin: Linearization) -> None:
    """Refuse outputs that are constraint forces."""
    roles = lin.model.roles()[1]
    for s in lin.labels.outputs:
        if s.quantity == "stress" and roles[s.index] in (Role.FIXED, Role.PRESCRIBED):
            raise ModelError(
                f"Output '{s.name}' is the stress of a {roles[s.index].value} deformation, a constraint force,"
                " which the state-space model does not give. Release the deformation and give it a stiffness."
            )


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


def _refuse_idle_inputs(lin: Linearization, condensed: tuple[int, ...]) -> None:
    """Refuse inputs whose columns of B and D are zero but for round-off, at all times.

    Args:
        condensed: Degrees of freedom that are condensed.

    Raises:
        ModelError: An input moves nothing.
    """
    sizes = sizes_of(lin.model.topology, lin.model.parameters)
    idle = set(range(len(lin.labels.inputs)))
    for m in _at_each_time(lin):
        # How far, in extents and radians, each degree of freedom moves what it moves most.
        reach = np.max(np.abs(m.DFx) / sizes[:, None], axis=0, initial=0.0)
        for i in sorted(idle):
            s = lin.labels.inputs[i]
            row = np.asarray(input_row(s, m.x, m.DFx, m.DFe))
            size = max(1.0, np.max(sizes)) if s.quantity == "stress" else sizes[s.index]
            if np.any(np.abs(row) > IDLE * size * reach) and not _drives_only_unseen(m, row, lin, condensed):
                idle.discard(i)
    if idle:
        s = lin.labels.inputs[min(idle)]
        raise ModelError(
            f"Input '{s.name}' (a {s.quantity}) moves nothing about this state: its columns of B and D are zero. Let it"
            " act on what can move, or leave it out."
        )


def _drives_only_unseen(m: Matrices, force: np.ndarray, lin: Linearization, condensed: tuple[int, ...]) -> bool:
    """Whether an input acts on massless motions alone, of which no output tells."""
    if not condensed:
        return False
    kept = np.array([i for i in range(len(force)) if i not in condensed], int)
    direct = response_without_mass(m.M0, m.K, condensed, force, np.linalg.solve)
    left = np.abs(force - m.K @ direct)[kept] > IDLE * (np.abs(force) + np.abs(m.K) @ np.abs(direct))[kept]
    if np.any(left):
        return False
    rows = [part for s in lin.labels.outputs for part in _output_rows(s, m)[:1] if part is not None]
    return not any(abs(np.asarray(r) @ direct) > IDLE * (np.abs(r) @ np.abs(direct)) for r in rows)


def to_statespace(
    model: Model | Linearization,
    *,
    at: Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
    modes: int | Sequence[int] | None = None,
    bandwidth: float | None = None,
) -> "control.StateSpace":
    """The linearised mechanism as a ``control.StateSpace`` with names for states, inputs and outputs.

    Args:
        model: Mechanism, or its linearisation; of a motion that at one time, ``lin.at_time(0)``. Damping is that of its
            elements, unless it is a linearisation by :func:`flexmb.damped`.
        at: Path, Motion or Linearization of the model, about a state of which it is asked in place of an equilibrium.
        step: Number of the state of a path or a motion, from 0; -1 for the last.
        time: Time of the state of a motion, one of its output times [s].
        increment: Factor of the incremental loads of the equilibrium, () [-]; zero unless given.
        modes: How many of the lowest modes to keep, or which, numbered from 0; see :func:`state_matrices`. A controller
            is designed on few states, and margins of many stiff ones are beyond python-control.
        bandwidth: Keep all modes up to this frequency [Hz].

    Returns:
        control.StateSpace; matrices as :func:`state_matrices`. Where modes are kept it has an attribute
        ``truncation_error``, (n_y, n_u) [-]: by how much the response of each output to each input is off at most, up
        to ``bandwidth`` or else the highest mode that is kept, measured against all modes at 120 frequencies over two
        decades and beside each mode. It is the difference over the larger of the full response there and its median
        within half an octave to both sides, which keeps an antiresonance from counting.

    Raises:
        ModelError: The model names no inputs or no outputs, or an output that cannot be given, or an input that moves
            nothing; the linearisation is that at many times.
        AnalysisError: singular_mass.
        ValueError: As :func:`state_matrices`.

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
    lin = linearized(model, "to_statespace", where=Where(at, step, time, increment))
    inputs, outputs = ([s.name for s in found] for found in (lin.labels.inputs, lin.labels.outputs))
    if not inputs or not outputs:
        raise ModelError("A state-space model needs an input and an output: name them with input() and output().")
    found, states, error = _matrices_of(lin, modes, bandwidth)
    # control refuses a dot in a name.
    clean = [[name.replace(".", " ") for name in names] for names in (states, inputs, outputs)]
    parts = [np.asarray(m) for m in found]
    system: Any = control.StateSpace(*parts, states=clean[0], inputs=clean[1], outputs=clean[2])
    if error is not None:
        system.truncation_error = error
    return system
