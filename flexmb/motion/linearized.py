"""Linearised equations along a motion, and about a steady motion."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, is_concrete
from ..compilation.compile import jit_beside_options
from ..display import kind_of
from ..errors import ModelError, warn
from ..linear.linearize import Linearization, Matrices
from ..math.linear import factorise
from ..mechanics.deformation import zero_strain
from ..model.model import Model, as_model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import SMALL_DIAGONAL, STEADY_CONVERGED, STEADY_EQUATIONS
from ..results import RESULTS, check, or_nan
from .coordinates_form import coordinates_form
from .drive import Driven
from .drives_by_name import Drives, driven_by, warn_of_left_out
from .motion import Motion
from .moving_matrices import moving_matrices, state_at_rates

# Prescribed speeds are increased in steps, each with this number of Newton iterations.
STEADY_STEPS, STEADY_ITERATIONS = 10, 6
# Equations of a steady motion are compared after prescribed coordinates have moved so far (extents, radians).
ONWARDS = 0.1


def linearize_motion(motion: Motion) -> Linearization:
    """Return the linearised equations at all times of a motion, in the model's degrees of freedom.

    Args:
        motion: Motion.

    Returns:
        Linearization, with times as the first axis: M0, C0, D0, K0, N0, G0 (n_t, n_q, n_q). If the degrees of freedom
        do not determine the configuration, ``result`` is singular_configuration and the matrices are meaningless.

    Raises:
        TypeError: `motion` is no Motion.

    Source:
        THEORY.md 6, eq. (6.1) to (6.5).
    """
    if not isinstance(motion, Motion):
        raise TypeError(
            f"fm.motion.linearize_motion needs a Motion, not {kind_of(motion)}. Give fm.simulate(model, ..)."
        )
    return motion.linearizations()


@jit_beside_options
def _steady(topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], time: Float[Array, ""]) -> Matrices:
    form = coordinates_form(topology, parameters, driven)
    none = jnp.zeros(topology.n_q)
    sizes = coordinate_scales(topology, parameters)
    prescribed = form.whole(time)
    n = topology.x.dof.shape[0]
    scale = jnp.concatenate([sizes[topology.x.dof], jnp.ones(topology.n_q - n)])

    def linear(speed: Float[Array, ""], x: Float[Array, "n_x"], last_strain: Float[Array, "n_e"]):
        return moving_matrices(form, time, state_at_rates(form, time, x, none, none, last_strain, speed))

    def iterate(i: Array, carry: tuple[Any, ...]):
        q, x, last_strain, _, _ = carry
        x, last_strain = form.placed(prescribed, q, x, last_strain)
        speed = jnp.minimum((i // STEADY_ITERATIONS + 1).astype(float) / STEADY_STEPS, 1.0)
        matrices, residual = linear(speed, x, last_strain)
        dq = factorise(matrices.K).solve(-residual)
        return q + dq, x, last_strain, jnp.max(jnp.abs(dq) / scale, initial=0.0), matrices

    nothing = jax.tree.map(
        lambda a: jnp.zeros(a.shape, a.dtype), jax.eval_shape(linear, time, prescribed.x, zero_strain(topology))[0]
    )
    start = (none, prescribed.x, zero_strain(topology), jnp.array(jnp.inf), nothing)
    *_, last, steady = jax.lax.fori_loop(0, STEADY_STEPS * STEADY_ITERATIONS, iterate, start)
    astray = (steady.result == RESULTS.successful) & ~(last < STEADY_CONVERGED)
    return dataclasses.replace(steady, result=jnp.where(astray, RESULTS.not_converged, steady.result).astype(jnp.int32))


def steady_motion(
    model: Model, motion: Mapping[str, Callable], *, time: float = 0.0, throw: bool = True
) -> Linearization:
    """Return the linearised equations of a steady motion under prescribed motion, such as rotation at constant speed.

    The degrees of freedom must be constant in the steady motion, such as deformations. Prescribed velocities are
    increased in steps.

    Args:
        model: Mechanism.
        motion: Values of PRESCRIBED coordinates and deformations as functions of time, by name.
        time: Time of their values and rates [s].
        throw: Raise if no steady motion is found; otherwise the code is in ``result``.

    Returns:
        Linearization with C0 and N0, for ``fm.poles`` and ``fm.to_statespace``.

    Raises:
        ModelError: A name is unknown, or nothing is prescribed.
        AnalysisError: not_converged or singular_configuration.

    Warns:
        FlexmbWarning: The equations change as the motion continues: the degrees of freedom are not constant, and the
            poles at one instant are meaningless. Or the model has incremental loads, which are left out.

    Source:
        THEORY.md 6 and 7, with q_dot = q_ddot = 0.
    """
    as_model(model, "steady_motion")
    check_number("time", time)
    if not motion:
        raise ModelError("A steady motion needs a prescribed motion. Name it in `motion`.")
    driven = driven_by(model, Drives(motion=motion))
    warn_of_left_out(model, driven, "motion.steady_motion")
    numbers = model.topology, model.parameters, driven
    linearization = Linearization(_steady(*numbers, jnp.asarray(time, float)), model)
    check(linearization.matrices.result, throw)
    linearization = Linearization(or_nan(linearization.matrices, linearization.matrices.result, throw), model)
    if throw and is_concrete((model, driven, linearization)):
        _warn_of_change(numbers, linearization.matrices, float(time))
    return linearization


@jit_beside_options
def _speed(
    topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], time: Float[Array, ""]
) -> Float[Array, ""]:
    """Greatest prescribed speed [extents/s, rad/s]."""
    form = coordinates_form(topology, parameters, driven)
    prescribed = form.whole(time)
    speeds = jnp.concatenate([prescribed.v / coordinate_scales(topology, parameters), prescribed.ed])
    return jnp.max(jnp.abs(speeds), initial=0.0)


def _warn_of_change(numbers: tuple[Any, ...], matrices: Matrices, time: float) -> None:
    """Warn if the equations differ a little later."""
    speed = float(_speed(*numbers, jnp.asarray(time, float)))
    if not speed > 0:
        return
    later = _steady(*numbers, jnp.asarray(time + ONWARDS / speed, float))
    mass, rates, stiffness = (
        [np.asarray(sum(getattr(at, name) for name in names)) for at in (matrices, later)]
        for names in (("M0",), ("C0", "D0"), ("K0", "N0", "G0"))
    )
    # Entries have different units: compare each with the diagonal of its row and column.
    heavy, stiff = (
        np.sqrt(np.maximum(diagonal, SMALL_DIAGONAL * np.max(diagonal, initial=0.0)))
        for diagonal in (np.abs(np.diag(pair[0])) for pair in (mass, stiffness))
    )
    sizes = np.outer(heavy, heavy), np.maximum(np.outer(heavy, stiff), np.outer(stiff, heavy)), np.outer(stiff, stiff)
    pairs = zip((mass, rates, stiffness), sizes, strict=True)
    change = max(
        np.max(np.abs(entries - later_entries) / np.where(size > 0, size, 1.0), initial=0.0)
        for (entries, later_entries), size in pairs
    )
    if int(later.result) != RESULTS.successful or change > STEADY_EQUATIONS:
        warn(
            f"The degrees of freedom are not constant in this motion: after {ONWARDS:g} rad, or {ONWARDS:g} times the"
            f" extent, the linearised equations change by {change:.2g} of their largest entries. Poles at one instant"
            " are meaningless. Choose degrees of freedom that turn with anisotropic parts, or use the equations along"
            " the motion: fm.motion.linearize_motion(fm.simulate(..))."
        )
