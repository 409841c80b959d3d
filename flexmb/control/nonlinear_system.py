"""The nonlinear mechanism as a system of python-control."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..errors import AnalysisError, warn
from ..mechanics.loads import warn_of_increment
from ..model.model import Model, as_known_model
from ..model.topology import coordinate_scales
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven
from ..motion.drives_by_name import Drives, driven_by
from ..motion.loop import check_signals, controlled_form, under_inputs
from ..motion.protocol import MotionState
from ..motion.reduced_form import reduced_form
from ..numerical_limits import DEPENDENT_FOUND
from ..results import RESULTS
from ..statics.configuration import start_of

if TYPE_CHECKING:
    import control

# Degrees of freedom move from the last evaluation in at most FARTHEST steps of at most STEP extents, metres (of
# deformations) or radians, so that turns are counted. After a failure, four times as many steps are tried, FINER times.
STEP, FARTHEST, FINER = 1.0, 20_000, 4
# Number of evaluations after which a warning names faster methods.
MANY = 10_000


@jit_beside_options
def plant_rates(
    model: Model,
    driven: tuple[Driven, ...],
    t: Float[Array, ""],
    state: Float[Array, "n"],
    memory: Float[Array, "m"],
    u: Float[Array, "n_u"],
) -> tuple[Float[Array, "n"], Float[Array, "n_y"], Float[Array, "m"], Float[Array, ""]]:
    """Rates of a state, outputs, the memory to continue from, and the last change of Newton's method.

    The memory of all coordinates and deformations is Newton's first guess.
    """
    undriven = coordinates_form(model.topology, model.parameters, driven)
    form = reduced_form(under_inputs(model, undriven, u))
    n = form.size
    q, qd = state[:n] / form.sizes, state[n:] / form.sizes
    at = form.settle(t, MotionState(q, qd, memory))
    full_motion = form.whole_motion(t, at)
    in_coordinates = undriven.state_of(full_motion.x, full_motion.xd, full_motion.near)
    sensors = controlled_form(model, undriven, None)
    z = under_inputs(model, undriven, u).acceleration(t, in_coordinates)[0] if sensors.places.late else None
    y = sensors.measured(t, in_coordinates, z, u)
    # The second search measures the error of the first.
    again = form.settle(t, at).memory
    moved = jnp.abs(again - at.memory)[: model.topology.n_x] / coordinate_scales(model.topology, model.parameters)
    rates = jnp.concatenate([state[n:], form.acceleration(t, at)[0] * form.sizes])
    return rates, y, at.memory, jnp.max(moved, initial=0.0)


class Freedoms(NamedTuple):
    """Places of degrees of freedom in the memory, their undeformed values, and their sizes."""

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
    """Coordinates and deformations at the builder's start, (n_x + n_e,)."""
    start = start_of(model)
    return np.concatenate([start.x, start.e])


class _Plant:
    """Rates and outputs of a mechanism; it remembers the coordinates that Newton's method begins from.

    python-control evaluates a state several times. Each time, Newton's method must start from the same memory.
    Otherwise the last digits of outputs change, and python-control reports an algebraic loop.
    """

    def __init__(self, model: Model, driven: tuple[Driven, ...]):
        self.model, self.driven = model.without_names(), driven
        self.freedoms, self.memory = freedoms_in_memory(model), memory_at_start(model)
        # The last question (time, state, inputs) and its answer, and the memory before it.
        self.question: tuple[bytes, ...] = ()
        self.answer: Any = None
        self.memory_before = self.memory
        self.count, self.begin = 0, np.inf

    def evaluate(self, t: float, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rates and outputs."""
        question = tuple(np.asarray(number, float).tobytes() for number in (t, x, u))
        if question == self.question:
            return self.answer
        if question[:2] == self.question[:2]:
            self.memory = self.memory_before
        self.question, self.answer, self.memory_before = question, None, self.memory
        # Another simulation begins at the same time or before.
        self.count, self.begin = (1, float(t)) if t <= self.begin else (self.count + 1, self.begin)
        if self.count == MANY:
            warn(
                f"The plant was evaluated {MANY} times, up to t = {float(t):.4g} s. Explicit methods, such as RK45 by"
                " default, need steps as short as the fastest vibration of the mechanism. Pass"
                " solve_ivp_method='Radau' to control.input_output_response, or use fm.simulate with control=."
            )
        self.answer = self._computed(t, np.asarray(x, float), u)
        return self.answer

    def _computed(self, t: float, x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        n = self.model.topology.n_q
        before = self.memory[self.freedoms.places] - self.freedoms.origins
        change = x[:n] - before
        least = max(np.ceil(np.max(np.abs(change) / self.freedoms.sizes, initial=0.0) / STEP), 1)
        for finer in 4 ** np.arange(FINER + 1):
            if not least * finer <= FARTHEST:
                break
            steps, memory = int(least * finer), self.memory
            rates: Any = None
            y: Any = None
            for k in range(1, steps + 1):
                state = np.concatenate([before + change * k / steps, np.zeros(n)]) if k < steps else x
                numbers = (np.asarray(number, float) for number in (t, state, memory, u))
                rates, y, memory, gap = jax.device_get(plant_rates(self.model, self.driven, *numbers))
                if not gap < DEPENDENT_FOUND:
                    break
            else:
                self.memory = memory
                return rates, y
        # The next question is answered anew.
        self.question = ()
        raise AnalysisError("out_of_reach", RESULTS.out_of_reach.message)


def to_nonlinear_system(
    model: Model, *, loads: Mapping[str, Callable] | None = None, motion: Mapping[str, Callable] | None = None
) -> "control.NonlinearIOSystem":
    """Return the nonlinear mechanism as a plant for ``control.input_output_response`` and similar functions.

    States are the degrees of freedom, counted from the undeformed mechanism, and their rates. Inputs and outputs are
    the ones named in the builder. Rotations in space count from the undeformed mechanism. Each evaluation solves for
    the other coordinates, starting from the last evaluation. If the change is large, it solves in several steps.

    Most mechanisms are stiff: their fastest vibration is much faster than the motion. The default method of
    ``control.input_output_response``, RK45, takes steps as short as this vibration. Pass ``solve_ivp_method="Radau"``,
    or use ``fm.simulate`` with ``control=``.

    Args:
        model: Mechanism with named inputs and outputs.
        loads: Loads as functions of time, see :class:`flexmb.motion.Drives`.
        motion: Prescribed motion as functions of time, see :class:`flexmb.motion.Drives`.

    Returns:
        control.NonlinearIOSystem with n_q degrees of freedom and their n_q rates as states [m, rad; m/s, rad/s].

    Raises:
        ModelError: The model names no inputs or no outputs, or an input is a motion or can move nothing.
        TypeError: Numbers of the model are traced, as under ``jax.jit``.
        AnalysisError: out_of_reach, raised when the system is evaluated: the mechanism cannot be assembled there.

    Warns:
        FlexmbWarning: The plant was evaluated 10 000 times.

    Source:
        THEORY.md 5, eq. (5.2), and 9 (a).
    """
    import control

    warn_of_increment(as_known_model(model, "to_nonlinear_system"), "to_nonlinear_system")
    inputs, outputs = model.labels.inputs, model.labels.outputs
    check_signals(model, "A plant")
    driven = driven_by(model, Drives(loads=loads, motion=motion))
    plant = _Plant(model, driven)
    names = [name.replace(".", " ") for name in model.q_labels]
    return control.nlsys(
        lambda t, x, u, params: plant.evaluate(t, x, u)[0],
        lambda t, x, u, params: plant.evaluate(t, x, u)[1],
        inputs=[s.name.replace(".", " ") for s in inputs],
        outputs=[s.name.replace(".", " ") for s in outputs],
        states=names + [f"d {name}" for name in names],
    )
