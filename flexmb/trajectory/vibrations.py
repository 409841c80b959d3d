"""Perturbation method: vibrations of small amplitude on top of a nominal motion."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float, Int

from ..arguments import check_numbers, check_whole, is_concrete
from ..compilation.compile import jit, jit_beside_options
from ..compilation.record import Record
from ..control.second_order_form import second_order
from ..display import Result, States, Summary, largest, short
from ..linear.linearize import Linearization, Matrices
from ..linear.loose import without_mass
from ..math.linear import factorise
from ..model.model import Labels, Model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven
from ..motion.motion import Motion
from ..motion.moving_matrices import state_at_rates
from ..results import RESULTS, check
from .about_motion import about, check_freedoms, freedoms_of, loads_of_freedoms
from .slow_modes import SlowModes, amplitudes, projected, slow_modes
from .varying_equations import Spline, cubic_spline, integrate_varying, with_halved_steps


class Perturbation(Result, Record):
    """Vibrations on top of a nominal motion, of first order in their amplitude.

    Attributes:
        t: Times, (n_t,) [s].
        q: Deviations of the degrees of freedom from the nominal motion, (n_t, n_q) [m, rad].
        qd: Their rates, (n_t, n_q) [1/s].
        u: Inputs beside the loads of the nominal motion, (n_t, n_u), or (n_t, 0) for none [N, N m].
        held: Released holding force of each degree of freedom: the holding force along the nominal motion, minus the
            force of a servo on the degrees of freedom that stay held, (n_t, n_q) [N, N m].
        nominal: The nominal motion.
        error: Estimated error of the time steps, relative to the largest displacement of the vibrations [-]; NaN if
            ``substeps`` was given.
        substeps: Time steps between two times.
    """

    t: Float[Array, "n_t"]
    q: Float[Array, "n_t n_q"]
    qd: Float[Array, "n_t n_q"]
    u: Float[Array, "n_t n_u"]
    held: Float[Array, "n_t n_q"]
    nominal: Motion
    error: Float[Array, ""]
    substeps: Int[Array, ""]
    one_axis = "t"

    @property
    def model(self) -> Model:
        """The mechanism."""
        return self.nominal.model

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.nominal.labels

    def motion(self) -> Motion:
        """Return the nominal motion plus vibrations, as a Motion.

        The degrees of freedom are the sum of nominal motion and vibrations. The constraints determine all other
        coordinates. If the degrees of freedom are deformations, this includes geometric effects of second order, such
        as the shortening of a bent leaf spring. Accelerations, stresses and forces follow from the equations of motion
        in these states.

        Returns:
            Motion.

        Source:
            THEORY.md 14, eq. (14.23).
        """
        nominal = self.nominal
        model = nominal.model
        q, qd = freedoms_of(nominal)
        rows = nominal.t, nominal.x, nominal.near, self.q, q + self.q, qd + self.qd
        x, xd, last_strain = _placed(model.topology, model.parameters, nominal.driven, rows)
        steps = (nominal.t.shape[0] - 1) * self.substeps
        driven = nominal.driven
        if not is_concrete(self.held) or np.any(np.asarray(self.held)):
            driven = (*driven, *loads_of_freedoms(model.topology, self.t, -self.held))
        return Motion(
            self.t, x, xd, last_strain, self.u, steps, nominal.result, driven, model, "perturbation method", "Radau IIA"
        )

    def states(self) -> States:
        """Return the states over time, as the sum of nominal motion and vibrations."""
        return self.motion().states()

    def summary(self) -> Summary:
        """Return times, extent of the vibrations, and error of the time steps."""
        t, q = np.asarray(self.t), np.asarray(self.q)
        extreme = q[np.argmax(np.abs(q), axis=0), np.arange(q.shape[1])]
        rows = {
            "time": f"{short(t[0])} to {short(t[-1])} s, {len(t)} times",
            "largest vibration": largest(extreme, self.model.q_labels, "[m, rad]"),
            "error of the steps": f"{short(self.error)} with {int(self.substeps)} between two times",
        }
        return Summary(f"Perturbation: vibrations of {q.shape[1]} degrees of freedom on a motion", rows)


@jit_beside_options
def _placed(topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], rows: tuple[Array, ...]):
    """Configurations, velocities and deformations at changed degrees of freedom along a motion."""
    form = coordinates_form(topology, parameters, driven)
    still = jnp.zeros(topology.n_q)

    def at_one_time(at: tuple[Array, ...]):
        t, x, last_strain, change, q, qd = at
        guess = x + state_at_rates(form, t, x, change, still, last_strain, 0.0).v
        x, last_strain = form.placed(form.whole(t), q, guess, last_strain)
        return x, state_at_rates(form, t, x, qd, still, last_strain).v, last_strain

    return jax.lax.map(at_one_time, rows)


@jit
def _equations(
    t: Float[Array, "n_t"],
    m: Matrices,
    force: Float[Array, "n_t n_q"],
    start: tuple[Array, Array],
    kept: Array,
    *,
    modes: int | None,
):
    """Spline of [M, C, K, f] and the start in the kept freedoms or in modes; and the modes."""
    mass, damping, stiffness, force = _free_part(m, force, kept)
    parts, slow = (mass, damping, stiffness), None
    if modes is not None:
        slow = slow_modes(t, mass, stiffness, modes)
        parts = projected(slow, mass, damping, stiffness)
        start = amplitudes(slow, mass, *start)
        force = jnp.einsum("tij,ti->tj", slow.shapes, force)
    return cubic_spline(t, jnp.concatenate([*parts, force[:, :, None]], axis=2)), start, slow


def _free_part(m: Matrices, force: Float[Array, "n_t n_q"], free_indices: Array):
    """Mass, damping, stiffness and force of the degrees of freedom that may vibrate."""
    return *(part[:, free_indices][:, :, free_indices] for part in (m.M0, m.C0 + m.D0, m.K)), force[:, free_indices]


@jit
def _full_motion(
    equations: Spline,
    m: Matrices,
    force: Float[Array, "n_t n_q"],
    kept: Array,
    slow: SlowModes | None,
    p: Float[Array, "n_t k"],
    pd: Float[Array, "n_t k"],
):
    """Deviations of all degrees of freedom and their rates from the integrated ones."""
    still = jnp.zeros((p.shape[0], m.M0.shape[1]))
    if slow is not None:
        mass, damping, _, force = _free_part(m, force, kept)

        def at_one_time(at: tuple[Array, ...]):
            p, pd, mass, damping, force, shapes, rates, second, flexibility, side_by_side = at
            modal_mass, modal_damping, modal_stiffness, modal_force = _coefficients(side_by_side)
            pdd = factorise(modal_mass).solve(modal_force - modal_damping @ pd - modal_stiffness @ p)
            moving = shapes @ pd + rates @ p
            inertia = mass @ (shapes @ pdd + 2 * rates @ pd + second @ p)
            return shapes @ p + flexibility @ (force - damping @ moving - inertia), moving

        follows = jnp.einsum("tij,tj->ti", slow.rest, force)
        p, pd = jax.lax.map(at_one_time, (p, pd, mass, damping, force, *slow, equations.values))
        pd = pd + cubic_spline(equations.t, follows).slopes
    return tuple(still.at[:, kept].set(values) for values in (p, pd))


@jit
def _vibrations(
    equations: Spline, q: Float[Array, "k"], qd: Float[Array, "k"], count: Any = None, *, substeps: int | None = None
):
    steps = count if substeps is None else substeps
    return integrate_varying(lambda t: _coefficients(equations(t)), equations.t, q, qd, steps)


def _coefficients(side_by_side: Float[Array, "n columns"]) -> tuple[Array, ...]:
    """Mass, damping, stiffness and force from [M, C, K, f]."""
    n = side_by_side.shape[0]
    mass, damping, stiffness, force = jnp.split(side_by_side, (n, 2 * n, 3 * n), axis=1)
    return mass, damping, stiffness, force[:, 0]


@jit
def _sway(topology: Topology, parameters: Parameters, dfx: Float[Array, "n_t n_x n_q"], q: Float[Array, "n_t n_q"]):
    """Displacements in extents and radians, (n_t, n_x)."""
    return jnp.einsum("tij,tj->ti", dfx, q) / coordinate_scales(topology, parameters)


def perturbation(
    nominal: Any,
    *,
    q: ArrayLike | None = None,
    qd: ArrayLike | None = None,
    u: ArrayLike | None = None,
    held: Sequence[str] = (),
    modes: int | None = None,
    rtol: float | None = None,
    substeps: int | None = None,
) -> Perturbation:
    """Return vibrations of small amplitude on top of a nominal motion: modes 5 and 6 of SPACAR.

    flexmb releases the forces that held the flexible deformations along the nominal motion. The deviations dq of the
    degrees of freedom follow M0 dqdd + (C0 + D0) dqd + (K0 + N0 + G0) dq = f0 + B0 du, with matrices along the nominal
    motion and f0 opposite to the holding forces. The error is of second order in the vibration. The cost of a step does
    not depend on the number of elements.

    Args:
        nominal: Nominal of inverse dynamics, or Motion of a simulation. A Motion has no holding forces: only the start
            and ``u`` then excite vibrations. The times should resolve the nominal motion, not vibrations; between the
            times matrices and forces are cubic splines.
        q: Deviation of the degrees of freedom at the first time, (n_q,) [m, rad]; None: zero.
        qd: Its rate, (n_q,) [1/s]; None: zero.
        u: Inputs in addition to the inputs of the nominal motion, at its times, (n_t, n_u) [N, N m]; None: none.
        held: Names of degrees of freedom that follow the nominal motion exactly, as with a stiff servo.
        modes: Number of slowly varying modes to integrate; None: all degrees of freedom. Other motions respond
            quasi-statically.
        rtol: Wanted error of the time steps, relative to the largest displacement of the vibrations [-]; None: 1e-4.
            Not beside ``substeps``.
        substeps: Time steps between two times; None: as many as ``rtol`` needs, or 4 under a trace.

    Returns:
        Perturbation. Its ``motion()`` is the sum of nominal motion and vibrations.

    Raises:
        TypeError: The argument is neither a Nominal nor a Motion.
        ValueError: Sizes do not agree; a degree of freedom is unknown, or all of them are held; ``modes`` exceeds the
            number of degrees of freedom; ``rtol`` is given beside ``substeps`` or under a trace.
        AnalysisError: The degrees of freedom do not determine the configuration at a time, or between two times.

    Warns:
        FlexmbWarning: The error does not reach ``rtol``.

    Source:
        THEORY.md 14, eq. (14.22) to (14.26).
    """
    motion, _, holding = about(nominal, "perturbation")
    model, t, names = motion.model, motion.t, motion.model.q_labels
    one_each = f"one number for each of the {len(names)} degrees of freedom ({', '.join(names)})"
    start = [_as_array(name, value, (len(names),), one_each) for name, value in (("q", q), ("qd", qd))]
    free_indices = _free_numbers(names, held)
    check_freedoms(motion)
    lin = motion.linearizations()
    m = lin.matrices
    if is_concrete(m.result):
        worst = int(np.max(np.asarray(m.result)))
        check(worst, True, without_mass(model) if worst == RESULTS.singular_mass else "")
    force, inputs = -holding, jnp.zeros((len(t), 0))
    if u is not None:
        count = len(model.labels.inputs)
        rows = f"a row for each of the {len(t)} times and a column for each of the {count} inputs"
        inputs = _as_array("u", u, (len(t), count), rows)
        force = force + _pushed(lin, inputs)
    if modes is not None:
        check_whole("modes", modes, 1, len(free_indices))
    start = tuple(value[free_indices] for value in start)
    equations, start, slow = _equations(t, m, force, start, free_indices, modes=modes)

    def full_motion(p: Float[Array, "n_t k"], pd: Float[Array, "n_t k"]):
        return _full_motion(equations, m, force, free_indices, slow, p, pd)

    def difference(fine: Any, coarse: Any):
        fine, coarse = full_motion(*fine)[0], full_motion(*coarse)[0]
        change, size = (
            jnp.max(jnp.abs(_sway(model.topology, model.parameters, m.DFx, vibration)), initial=0.0)
            for vibration in (fine - coarse, fine)
        )
        return float(change / jnp.where(size > 0, size, 1.0))

    traced = not is_concrete((m, start, force))
    run = partial(_vibrations, equations, *start)
    (solution, rates), error, count = with_halved_steps(run, difference, substeps, rtol, 1e-4, traced, "The vibration")
    moved, moving = full_motion(solution, rates)
    holding = holding - _servo_forces(m, force, free_indices, moved, moving)
    return Perturbation(t, moved, moving, inputs, holding, motion, jnp.asarray(error), jnp.asarray(count))


def _as_array(name: str, value: Any, shape: tuple[int, ...], contents: str) -> Array:
    """Argument of a given shape, zero by default."""
    if value is None:
        return jnp.zeros(shape)
    check_numbers(f"Argument `{name}`", value)
    array = jnp.asarray(value, float)
    if array.shape != shape:
        raise ValueError(f"Argument `{name}` must have {contents}, but has shape {array.shape}.")
    return array


def _pushed(lin: Linearization, u: Float[Array, "n_t n_u"]) -> Float[Array, "n_t n_q"]:
    """Forces of inputs along the degrees of freedom."""
    form = second_order(lin)
    moving = [s.name for s, moves in zip(lin.labels.inputs, form.moves, strict=True) if moves]
    if moving:
        raise ValueError(
            f"Argument `u`: input '{moving[0]}' moves a FIXED or PRESCRIBED coordinate, so it is no small force. Put it"
            " into the nominal motion."
        )
    return jnp.einsum("tij,tj->ti", form.B0, u)


@jit
def _servo_forces(
    m: Matrices, force: Float[Array, "n_t n_q"], kept: Array, q: Float[Array, "n_t n_q"], qd: Float[Array, "n_t n_q"]
) -> Float[Array, "n_t n_q"]:
    """Forces along the degrees of freedom that are not kept, which make them follow the nominal motion."""
    if len(kept) == force.shape[1]:
        return jnp.zeros_like(force)
    lacking = force - jnp.einsum("tij,tj->ti", m.C0 + m.D0, qd) - jnp.einsum("tij,tj->ti", m.K, q)
    # A motion without mass has no acceleration of its own.
    inverse = jnp.linalg.pinv(m.M0[:, kept][:, :, kept], hermitian=True)
    accelerated = jnp.einsum("tij,tj->ti", inverse, lacking[:, kept])
    needed = jnp.einsum("tij,tj->ti", m.M0[:, :, kept], accelerated) - lacking
    return needed.at[:, kept].set(0.0)


def _free_numbers(names: list[str], constrained: Sequence[str]) -> Array:
    """Places of the degrees of freedom that may vibrate."""
    if isinstance(constrained, str):
        raise TypeError(f"Argument `held` must be a list of degrees of freedom, such as [{constrained!r}].")
    unknown = [name for name in constrained if name not in names]
    if unknown:
        raise ValueError(f"Argument `held`: '{unknown[0]}' is no degree of freedom; there is {', '.join(names)}.")
    free_indices = np.array([i for i, name in enumerate(names) if name not in constrained], int)
    if not len(free_indices):
        raise ValueError("All degrees of freedom are held, so none can vibrate.")
    return jnp.asarray(free_indices)
