"""The nonlinear mechanism as a system of python-control."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..model.model import Model, as_known
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven
from ..motion.drives_by_name import Drives, driven_by
from ..motion.loop import check_signals, measuring, under_inputs
from ..motion.protocol import MotionState
from ..motion.reduced_form import reduced_form
from ..statics.configuration import configuration
from ..statics.equilibrium import warn_of_increment

if TYPE_CHECKING:
    import control


@jit_beside_options
def plant_rates(
    model: Model,
    driven: tuple[Driven, ...],
    t: Float[Array, ""],
    state: Float[Array, "n"],
    memory: Float[Array, "m"],
    u: Float[Array, "n_u"],
):
    """Rates of the state, outputs, and the memory to go on from."""
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
    return jnp.concatenate([state[n:], form.acceleration(t, at)[0] * form.sizes]), y, at.memory


def to_nonlinear_system(
    model: Model, *, loads: Mapping[str, Callable] | None = None, motion: Mapping[str, Callable] | None = None
) -> "control.NonlinearIOSystem":
    """The mechanism with all its nonlinearity as a plant for ``control.input_output_response`` and its like.

    States are the degrees of freedom, from the undeformed mechanism, and their rates; inputs and outputs those that the
    builder named, rotations in space measured from the undeformed mechanism. Every evaluation places the other
    coordinates from where the last one left them.

    Args:
        model: Mechanism with named inputs and outputs.
        loads: Loads as functions of time, see :class:`flexmb.motion.Drives`.
        motion: Prescribed motion as functions of time, see :class:`flexmb.motion.Drives`.

    Returns:
        control.NonlinearIOSystem with n_q degrees of freedom and their n_q rates as states [m, rad; m/s, rad/s].

    Raises:
        ModelError: The model names no inputs or no outputs, an input that is a motion, or one that can move nothing.
        TypeError: Numbers of the model are traced, as under ``jax.jit``.

    Source:
        THEORY.md 5, eq. (5.2), and 9 (a).
    """
    import control

    warn_of_increment(as_known(model, "to_nonlinear_system"), "to_nonlinear_system")
    inputs, outputs = model.labels.inputs, model.labels.outputs
    check_signals(model, "A plant")
    driven = driven_by(model, Drives(loads=loads, motion=motion))
    start = configuration(model)
    nameless = model.without_names()
    memory = [jnp.concatenate([start.x, jnp.zeros(model.topology.n_e)])]

    def evaluated(t: float, x: np.ndarray, u: np.ndarray):
        rates, y, memory[0] = plant_rates(
            nameless, driven, jnp.asarray(t, float), jnp.asarray(x), memory[0], jnp.asarray(u)
        )
        return np.asarray(rates), np.asarray(y)

    names = [name.replace(".", " ") for name in model.q_labels]
    return control.nlsys(
        lambda t, x, u, params: evaluated(t, x, u)[0],
        lambda t, x, u, params: evaluated(t, x, u)[1],
        inputs=[s.name.replace(".", " ") for s in inputs],
        outputs=[s.name.replace(".", " ") for s in outputs],
        states=names + [f"d {name}" for name in names],
    )
