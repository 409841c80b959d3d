"""Start of a motion: driven coordinates move to their first values, degrees of freedom keep theirs."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..arguments import as_floats, is_concrete
from ..compilation.compile import jit_beside_options
from ..display import among
from ..errors import warn
from ..math.indices import put
from ..mechanics.deformation import correction, deformation_jacobian, transfer
from ..model.topology import Parameters, coordinate_scales
from ..numerical_limits import CONFIGURATION_STEP, CONSTRAINTS_MET, MOVED_START
from .coordinates_form import CoordinatesForm
from .drive import Driven
from .motion import Motion
from .moving_matrices import rates_at
from .reduced_form import ReducedForm, reduced_form

# Driven coordinates move to their first values in at most this number of steps.
MOST_STEPS = 1000
# Newton corrections per step, enough for round-off at this step size.
CORRECTIONS = 6


class Start(NamedTuple):
    """Nodal coordinates, velocities and deformations at the start; turns count from these, None for zero."""

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    near: Any = None


def driving(parameters: Parameters, driven: tuple[Driven, ...]) -> tuple[Driven, ...]:
    """Functions of time that drive held coordinates or deformations, also by temperature."""
    grows = parameters.increment
    scaled = grows is not None and any(part is not None for part in (grows.x, grows.e, grows.temperature))
    quantities = ("x", "e", "temperature", "increment") if scaled else ("x", "e", "temperature")
    return tuple(drive for drive in driven if drive.quantity in quantities)


def begins_still(parameters: Parameters, driven: tuple[Driven, ...], t: Any) -> bool:
    """Whether everything held is known to start at its place and at rest."""
    excitations = driving(parameters, driven)
    if not excitations:
        return True
    return is_concrete((excitations, t)) and not any(
        np.any(np.asarray(part)) for part in _begins(excitations, as_floats(t))
    )


def warn_of_start(motion: Motion, given: Start) -> None:
    """Warn if a driven motion depends on degrees of freedom that were found; `given` is the start without drives."""
    model = motion.model
    size = np.asarray(coordinate_scales(model.topology, model.parameters))
    rates = np.asarray(motion.xd) / size
    # Times that were not reached have no rates.
    fastest = np.max(np.abs(rates), initial=0.0, where=np.isfinite(rates))
    elsewhere = np.any(np.abs(np.asarray(motion.x)[0] - given.x) > MOVED_START * size)
    if elsewhere or np.any(np.abs(rates[0] - given.xd / size) > MOVED_START * fastest):
        warn(
            "Driven coordinates move the mechanism, or give it a velocity, at the first time. The degrees of freedom"
            f" and their rates keep their values. flexmb chose these degrees of freedom: {among(model.labels.found)}."
            " Others would start another motion. Name the intended degrees of freedom by dof()."
        )


@jit_beside_options
def _begins(held: tuple[Driven, ...], t: Float[Array, ""]) -> tuple[Array, ...]:
    """Values and rates of held coordinates and deformations."""
    values, rates = jax.jvp(lambda t: [jnp.ravel(drive.value(t)) for drive in held], (t,), (jnp.ones_like(t),))
    return jnp.concatenate(values), jnp.concatenate(rates)


def is_determined(form: CoordinatesForm) -> bool:
    """Whether the number of degrees of freedom determines the mechanism."""
    top = form.topology
    independent = (top.e.fixed, top.e.prescribed, top.e.dof)
    return top.x.dependent.shape[0] == sum(indices.shape[0] for indices in independent)


def driven_start(form: CoordinatesForm, t: Float[Array, ""], given: Start) -> tuple[Start, Bool[Array, ""]]:
    """Start of a driven mechanism, and whether it can be assembled there (THEORY.md 4, eq. (4.2)).

    Degrees of freedom and their rates stay as given; the other coordinates follow in steps. The implicit function
    theorem yields the derivatives.
    """
    reduced = reduced_form(form)
    state = reduced.state_of(*given)
    x, last_strain = form.placed(
        form.whole(t), state.u * reduced.sizes, *_driven_in_steps(*jax.lax.stop_gradient((form, t, state)))
    )
    at = form.whole(t)
    e, jacobian = deformation_jacobian(form.topology, form.parameters, x, last_strain)
    off = jnp.max(jnp.abs(e[form.held] - at.e), initial=0.0)
    largest = jnp.max(coordinate_scales(form.topology, form.parameters), initial=1.0)
    v = rates_at(form, at, transfer(form.topology, jacobian), jacobian, state.w * reduced.sizes)
    met = (off <= CONSTRAINTS_MET * largest) & jnp.all(jnp.isfinite(x)) & jnp.all(jnp.isfinite(v))
    return Start(x, v, last_strain), met


def _driven_in_steps(form: CoordinatesForm, t: Float[Array, ""], state: Any) -> tuple[Array, Array]:
    """Coordinates and deformations near the driven place, in steps from the given state."""
    reduced: ReducedForm = reduced_form(form)
    top, q = form.topology, state.u * reduced.sizes
    x, e = state.memory[: top.n_x], state.memory[top.n_x :]
    aim = form.whole(t)
    shift = put(jnp.zeros(top.n_x), top.x.prescribed, (aim.x - x)[top.x.prescribed])
    # How far everything moves, to first order.
    _, jacobian = deformation_jacobian(top, form.parameters, x, e)
    change = put(jnp.zeros(top.n_e), form.held, e[form.held] - aim.e) + jacobian @ shift
    way = correction(top, transfer(top, jacobian), change, shift) / coordinate_scales(top, form.parameters)
    longest = jnp.max(jnp.abs(way), initial=0.0)
    steps = jnp.clip(
        jnp.ceil(jnp.where(jnp.isfinite(longest), longest, 1.0) / CONFIGURATION_STEP), 0, MOST_STEPS
    ).astype(jnp.int32)

    def further(at: tuple[Array, Array, Array]):
        step, x, last_strain = at
        remaining = 1 - (step + 1).astype(float) / steps.astype(float)
        partly = aim._replace(x=aim.x - remaining * shift, e=aim.e - remaining * (aim.e - e[form.held]))
        return step + 1, *form.placed(partly, q, x, last_strain, CORRECTIONS)

    _, x, last_strain = jax.lax.while_loop(lambda at: at[0] < steps, further, (jnp.zeros((), jnp.int32), x, e))
    return x, last_strain
