"""The nonlinear mechanism as a system of python-control."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..errors import AnalysisError
from ..mechanics.extent import sizes_of
from ..model.model import Model, as_known
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven
from ..motion.drives_by_name import Drives, driven_by
from ..motion.loop import check_signals, measuring, under_inputs
from ..motion.protocol import MotionState
from ..motion.reduced_form import reduced_form
from ..results import RESULTS
from ..statics.configuration import configuration
from ..statics.equilibrium import warn_of_increment

if TYPE_CHECKING:
    import control

# Newton's method has found the dependent coordinates where as many steps again change them by less than this share of
# the extent, or radians: the error is then the square of that, or less.
FOUND = 1e-6
# From where the last evaluation was, degrees of freedom go in steps of this many extents, metres (of deformations) or
# radians at most, so that turns are counted, and in so many at most; where nothing is found, in four times as many, so
# often.
STEP, FARTHEST, FINER = 1.0, 20_000, 4


class Evaluated(NamedTuple):
    """Rates of the state and outputs; the memory to go on from; and whether it was found, below ``FOUND``."""

    rates: Float[Array, "n"]
    y: Float[Array, "n_y"]
    memory: Float[Array, "m"]
    gap: Float[Array, ""]


@jit_beside_options
def plant_rates(
    model: Model,
    driven: tuple[Driven, ...],
    t: Float[Array, ""],
    state: Float[Array, "n"],
    memory: Float[Array, "m"],
    u: Float[Array, "n_u"],
) -> Evaluated:
    """Rates and outputs at a state, with the other coordinates from a memory of all of them and of deformations."""
    undriven = coordinates_form(model.topology, model.parameters, driven)
    form = reduced_form(under_inputs(model, undriven, u))
    n = form.size
    q, qd = state[:n] / form.sizes, state[n:] / form.sizes
    at = form.settle(t, MotionState(q, qd, memory))
    whole = form.whole_motion(t, at)
    own = undriven.state_of(whole.x, whole.xd, whole.near)
    sensors = measuring(model, undriven, None)
    z = under_inputs(model, undriven, u).acceleration(t, own)[0] if sensors.places.late else None
    y = sensors.measured(t, own, z, u)
    # The rates are those after this second search.
    again = form.settle(t, at).memory
    moved = jnp.abs(again - at.memory)[: model.topology.n_x] / sizes_of(model.topology, model.parameters)
    rates = jnp.concatenate([state[n:], form.acceleration(t, at)[0] * form.sizes])
    return Evaluated(rates, y, at.memory, jnp.max(moved, initial=0.0))


class Freedoms(NamedTuple):
    """Where in the memory degrees of freedom are, what they are there undeformed, and their sizes, each (n_q,)."""

    places: np.ndarray
    origins: np.ndarray
    sizes: np.ndarray


def freedoms_in_memory(model: Model) -> Freedoms:
    """Degrees of freedom of a model of known numbers."""
    top, parameters = model.topology, model.parameters
    x, e = np.asarray(top.x.dof), np.asarray(top.e.dof)
    sizes = reduced_form(coordinates_form(top, parameters)).sizes
    origins = np.concatenate([np.asarray(parameters.reference)[x], np.zeros(len(e))])
    return Freedoms(np.concatenate([x, top.n_x + e]), origins, np.asarray(sizes))


def memory_at_start(model: Model) -> np.ndarray:
    """Coordinates and deformations where the builder lets a motion begin, (n_x + n_e,) [m, rad, -]."""
    start = configuration(model)
    return np.concatenate([start.x, start.e])


def to_nonlinear_system(
    model: Model, *, loads: Mapping[str, Callable] | None = None, motion: Mapping[str, Callable] | None = None
) -> "control.NonlinearIOSystem":
    """The mechanism with all its nonlinearity as a plant for ``control.input_output_response`` and its like.

    States are the degrees of freedom, from the undeformed mechanism, and their rates; inputs and outputs those that the
    builder named, rotations in space measured from the undeformed mechanism. Every evaluation places the other
    coordinates from where the last one left them, in steps of the degrees of freedom where that is far away.

    Args:
        model: Mechanism with named inputs and outputs.
        loads: Loads as functions of time, see :class:`flexmb.motion.Drives`.
        motion: Prescribed motion as functions of time, see :class:`flexmb.motion.Drives`.

    Returns:
        control.NonlinearIOSystem with n_q degrees of freedom and their n_q rates as states [m, rad; m/s, rad/s].

    Raises:
        ModelError: The model names no inputs or no outputs, an input that is a motion, or one that can move nothing.
        TypeError: Numbers of the model are traced, as under ``jax.jit``.
        AnalysisError: out_of_reach, raised where the system is evaluated: the mechanism cannot be assembled there.

    Source:
        THEORY.md 5, eq. (5.2), and 9 (a).
    """
    import control

    warn_of_increment(as_known(model, "to_nonlinear_system"), "to_nonlinear_system")
    inputs, outputs = model.labels.inputs, model.labels.outputs
    check_signals(model, "A plant")
    driven = driven_by(model, Drives(loads=loads, motion=motion))
    nameless, freedoms = model.without_names(), freedoms_in_memory(model)
    n, memory = model.topology.n_q, memory_at_start(model)

    def evaluated(t: float, x: np.ndarray, u: np.ndarray):
        nonlocal memory
        before = memory[freedoms.places] - freedoms.origins
        way = np.asarray(x, float)[:n] - before
        least = np.ceil(np.max(np.abs(way) / freedoms.sizes, initial=0.0) / STEP)
        for finer in 4 ** np.arange(FINER + 1):
            if not max(least, 1) * finer <= FARTHEST:
                break
            steps, at = int(max(least, 1) * finer), memory
            found: Any = None
            for k in range(1, steps + 1):
                state = np.concatenate([before + way * k / steps, np.zeros(n)]) if k < steps else np.asarray(x, float)
                numbers = (np.asarray(own, float) for own in (t, state, at, u))
                found = jax.device_get(plant_rates(nameless, driven, *numbers))
                at = found.memory
                if not found.gap < FOUND:
                    break
            else:
                memory = at
                return found.rates, found.y
        raise AnalysisError("out_of_reach", RESULTS.out_of_reach.message)

    names = [name.replace(".", " ") for name in model.q_labels]
    return control.nlsys(
        lambda t, x, u, params: evaluated(t, x, u)[0],
        lambda t, x, u, params: evaluated(t, x, u)[1],
        inputs=[s.name.replace(".", " ") for s in inputs],
        outputs=[s.name.replace(".", " ") for s in outputs],
        states=names + [f"d {name}" for name in names],
    )
