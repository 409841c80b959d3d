"""Linearised equations along a motion, and about a steady one."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, is_concrete
from ..compilation.compile import jit_beside_options
from ..errors import ModelError, warn
from ..linear.linearize import Linearization, Matrices
from ..math.linear import factorise
from ..mechanics.deformation import zero_near
from ..mechanics.extent import sizes_of
from ..model.model import Model, as_model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check, or_nan
from .coordinates_form import coordinates_form
from .drive import Driven
from .drives_by_name import Drives, driven_by
from .motion import Motion
from .moving_matrices import carried, moving_matrices

# The speed of what is prescribed is brought up in so many steps, each of so many iterations of Newton's method.
STEADY_STEPS, STEADY_ITERATIONS = 10, 6
# Largest last change of a degree of freedom over its size.
STEADY_TOLERANCE = 1e-9
# A motion is steady whose equations are the same when what is prescribed has gone on so far (extents, radians), but for
# such a share.
ONWARDS, SAME = 0.1, 1e-6
# Of entries less than this share of the largest, round-off of the others would be seen.
BESIDE = 1e-8


def linearize_motion(motion: Motion) -> Linearization:
    """Linearised equations at every time of a motion, in the model's degrees of freedom.

    Args:
        motion: Motion.

    Returns:
        Linearization whose arrays have the times in front: M0, C0, D0, K0, N0, G0 (n_t, n_q, n_q). Where the degrees of
        freedom do not determine the configuration, ``result`` is singular_configuration and the matrices mean nothing.

    Raises:
        TypeError: It is no Motion.

    Source:
        THEORY.md 6, eq. (6.1) to (6.5).
    """
    if not isinstance(motion, Motion):
        raise TypeError(
            f"fm.motion.linearize_motion takes a Motion, not a {type(motion).__name__}: give fm.simulate(model, ..)."
        )
    return motion.linearizations()


@jit_beside_options
def _steady(topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], time: Float[Array, ""]) -> Matrices:
    form = coordinates_form(topology, parameters, driven)
    none = jnp.zeros(topology.n_q)
    sizes = sizes_of(topology, parameters)
    given = form.whole(time, *(jnp.zeros(form.size),) * 3)
    n = topology.x.dof.shape[0]
    scale = jnp.concatenate([sizes[topology.x.dof], jnp.ones(topology.n_q - n)])

    def linear(speed: Float[Array, ""], x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
        return moving_matrices(form, time, carried(form, time, x, none, none, near, speed))

    def iterate(i: Array, walk: tuple[Any, ...]):
        q, x, near, _, _ = walk
        x, near = form.placed(given, q, x, near)
        speed = jnp.minimum((i // STEADY_ITERATIONS + 1).astype(float) / STEADY_STEPS, 1.0)
        found, residual = linear(speed, x, near)
        dq = factorise(found.K).solve(-residual)
        return q + dq, x, near, jnp.max(jnp.abs(dq) / scale, initial=0.0), found

    nothing = jax.tree.map(
        lambda a: jnp.zeros(a.shape, a.dtype), jax.eval_shape(linear, time, given.x, zero_near(topology))[0]
    )
    start = (none, given.x, zero_near(topology), jnp.array(jnp.inf), nothing)
    *_, last, found = jax.lax.fori_loop(0, STEADY_STEPS * STEADY_ITERATIONS, iterate, start)
    astray = (found.result == RESULTS.successful) & ~(last < STEADY_TOLERANCE)
    return dataclasses.replace(found, result=jnp.where(astray, RESULTS.not_converged, found.result).astype(jnp.int32))


def steady_motion(
    model: Model,
    motion: Mapping[str, Callable],
    *,
    time: float = 0.0,
    throw: bool = True,
) -> Linearization:
    """Steady motion under prescribed motion, such as a rotation at constant speed, and its linearised equations.

    The degrees of freedom are at rest; they should be deformations or other coordinates that are constant in the steady
    motion. The prescribed velocities are brought up in steps.

    Args:
        model: Mechanism.
        motion: Values of PRESCRIBED coordinates and deformations as functions of time, by name.
        time: Time at which to take their values and rates [s].
        throw: Raise where none is found; otherwise the code is in ``result``.

    Returns:
        Linearization with C0 and N0; ``fm.poles`` and ``fm.to_statespace`` take it.

    Raises:
        ModelError: Unknown name, or nothing is prescribed.
        AnalysisError: not_converged or singular_configuration.

    Warns:
        FlexmbWarning: The equations change as the motion goes on, so that it is none in which these degrees of freedom
            rest, and poles of one instant tell nothing.

    Source:
        THEORY.md 6 and 7, with q_dot = q_ddot = 0.
    """
    as_model(model, "steady_motion")
    check_number("time", time)
    if not motion:
        raise ModelError("A steady motion needs something that moves: name it in `motion`.")
    driven = driven_by(model, Drives(motion=motion))
    numbers = model.topology, model.parameters, driven
    found = Linearization(_steady(*numbers, jnp.asarray(time, float)), model)
    check(found.matrices.result, throw)
    found = Linearization(or_nan(found.matrices, found.matrices.result, throw), model)
    if throw and is_concrete((model, driven, found)):
        _warn_of_change(numbers, found.matrices, float(time))
    return found


@jit_beside_options
def _speed(
    topology: Topology, parameters: Parameters, driven: tuple[Driven, ...], time: Float[Array, ""]
) -> Float[Array, ""]:
    """The greatest speed of what is prescribed, () [extents/s, rad/s]."""
    form = coordinates_form(topology, parameters, driven)
    given = form.whole(time, *(jnp.zeros(form.size),) * 3)
    speeds = jnp.concatenate([given.v / sizes_of(topology, parameters), given.ed])
    return jnp.max(jnp.abs(speeds), initial=0.0)


def _diagonal(pair: list[np.ndarray]) -> np.ndarray:
    return np.abs(np.diag(pair[0]))


def _warn_of_change(numbers: tuple[Any, ...], found: Matrices, time: float) -> None:
    """Warn where the equations are others a little later."""
    speed = float(_speed(*numbers, jnp.asarray(time, float)))
    if not speed > 0:
        return
    later = _steady(*numbers, jnp.asarray(time + ONWARDS / speed, float))
    mass, rates, stiffness = (
        [np.asarray(sum(getattr(of, name) for name in names)) for of in (found, later)]
        for names in (("M0",), ("C0", "D0"), ("K0", "N0", "G0"))
    )
    # Each entry beside those of its row and column on the diagonal: they are of different units.
    heavy, stiff = (
        np.sqrt(np.maximum(own, BESIDE * np.max(own, initial=0.0))) for own in map(_diagonal, (mass, stiffness))
    )
    sizes = np.outer(heavy, heavy), np.maximum(np.outer(heavy, stiff), np.outer(stiff, heavy)), np.outer(stiff, stiff)
    pairs = zip((mass, rates, stiffness), sizes, strict=True)
    change = max(
        np.max(np.abs(one - other) / np.where(size > 0, size, 1.0), initial=0.0) for (one, other), size in pairs
    )
    if int(later.result) != RESULTS.successful or change > SAME:
        warn(
            "These degrees of freedom do not rest in this motion: as it goes on, the linearised equations change"
            f" ({change:.2g} of their largest entries after {ONWARDS:g} rad or extents), and poles of one instant tell"
            " nothing of it. Name degrees of freedom that turn along with what is anisotropic, or ask for the equations"
            " along the motion: fm.motion.linearize_motion(fm.simulate(..))."
        )
