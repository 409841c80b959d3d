"""Where a motion starts from: what is driven is where its law puts it, and degrees of freedom are where they were."""

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
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.extent import sizes_of
from ..mechanics.transfer import correction, transfer
from ..model.parameters import Parameters
from ..statics.configuration import STEP
from .coordinates_form import CoordinatesForm
from .drive import Driven
from .motion import Motion
from .moving_matrices import rates_at
from .reduced_form import ReducedForm, reduced_form

# What is driven is brought to where it begins in so many steps at most.
MOST_STEPS = 1000
# In each there are so many corrections: near as a step is, they then end in round-off.
CORRECTIONS = 6
# Held deformations are where they should be within this share of the mechanism's extent, or radians.
SETTLED = 1e-9
# What begins nearer to where it was, as a share of that extent or of the largest rate, is not told of.
TOLD = 1e-6


class Start(NamedTuple):
    """Where a motion starts from.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        xd: Their velocities, (n_x,).
        near: Deformations, (n_e,), from which turns are counted on; None: from the undeformed mechanism.
    """

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    near: Any = None


def driving(parameters: Parameters, driven: tuple[Driven, ...]) -> tuple[Driven, ...]:
    """What of functions of time drives something that is held: coordinates, deformations, or these by heat.

    Args:
        parameters: Of the mechanism.
        driven: What depends on time.
    """
    grows = parameters.increment
    own = grows is not None and any(part is not None for part in (grows.x, grows.e, grows.temperature))
    held = ("x", "e", "temperature", "increment") if own else ("x", "e", "temperature")
    return tuple(one for one in driven if one.quantity in held)


def begins_still(parameters: Parameters, driven: tuple[Driven, ...], t: Any) -> bool:
    """Whether what is held is where it was when a motion begins, and does not move then, by known numbers.

    Args:
        parameters: Of the mechanism.
        driven: What depends on time.
        t: Time at which it starts [s].
    """
    held = driving(parameters, driven)
    if not held:
        return True
    return is_concrete((held, t)) and not any(np.any(np.asarray(own)) for own in _begins(held, as_floats(t)))


def warn_of_found(motion: Motion, given: Start) -> None:
    """Warn where a motion hangs on which degrees of freedom were found: those are kept where something is driven.

    Args:
        motion: Of concrete numbers.
        given: Where it would start if nothing were driven.
    """
    model = motion.model
    size = np.asarray(sizes_of(model.topology, model.parameters))
    rates = np.asarray(motion.xd) / size
    # Times that were not reached have no rates.
    fastest = np.max(np.abs(rates), initial=0.0, where=np.isfinite(rates))
    elsewhere = np.any(np.abs(np.asarray(motion.x)[0] - given.x) > TOLD * size)
    if elsewhere or np.any(np.abs(rates[0] - given.xd / size) > TOLD * fastest):
        warn(
            "What is driven takes the mechanism elsewhere, or gives it a speed, at the first time. Degrees of freedom"
            f" and their rates are kept then, and these were found, not named: {among(model.labels.found)}. Others"
            " would begin another motion: name those that are meant, by dof()."
        )


@jit_beside_options
def _begins(held: tuple[Driven, ...], t: Float[Array, ""]) -> tuple[Array, ...]:
    """Values and rates of what is held."""
    values, rates = jax.jvp(lambda t: [jnp.ravel(one.value(t)) for one in held], (t,), (jnp.ones_like(t),))
    return jnp.concatenate(values), jnp.concatenate(rates)


def is_determined(form: CoordinatesForm) -> bool:
    """Whether there are as many degrees of freedom as determine a mechanism."""
    top = form.topology
    given = (top.e.fixed, top.e.prescribed, top.e.dof)
    return top.x.dependent.shape[0] == sum(own.shape[0] for own in given)


def driven_start(form: CoordinatesForm, t: Float[Array, ""], given: Start) -> tuple[Start, Bool[Array, ""]]:
    """Where a motion starts whose mechanism is driven, and whether there is such a place.

    Degrees of freedom and their rates stay as given; the other coordinates follow.

    Args:
        form: Equations of motion in all coordinates.
        t: Time at which it starts [s].
        given: Where it would start if nothing were driven.

    Source:
        THEORY.md 4, eq. (4.2), in steps of what is driven; derivatives are those of the implicit function.
    """
    reduced = reduced_form(form)
    own = reduced.state_of(*given)
    x, near = form.placed(_aim(form, t), own.u * reduced.sizes, *_walked(*jax.lax.stop_gradient((form, t, own))))
    at = _aim(form, t)
    e, jacobian = deformation_jacobian(form.topology, form.parameters, x, near)
    off = jnp.max(jnp.abs(e[form.held] - at.e), initial=0.0)
    largest = jnp.max(sizes_of(form.topology, form.parameters), initial=1.0)
    v = rates_at(form, at, transfer(form.topology, jacobian), jacobian, own.w * reduced.sizes)
    there = (off <= SETTLED * largest) & jnp.all(jnp.isfinite(x)) & jnp.all(jnp.isfinite(v))
    return Start(x, v, near), there


def _aim(form: CoordinatesForm, t: Float[Array, ""]):
    none = jnp.zeros(form.size)
    return form.whole(t, none, none, none)


def _walked(form: CoordinatesForm, t: Float[Array, ""], own: Any) -> tuple[Array, Array]:
    """Coordinates and deformations near to where the mechanism is driven, in steps from where it was."""
    reduced: ReducedForm = reduced_form(form)
    top, q = form.topology, own.u * reduced.sizes
    x, e = own.memory[: top.n_x], own.memory[top.n_x :]
    aim = _aim(form, t)
    shift = put(jnp.zeros(top.n_x), top.x.prescribed, (aim.x - x)[top.x.prescribed])
    # To first order, how far everything goes.
    _, jacobian = deformation_jacobian(top, form.parameters, x, e)
    change = put(jnp.zeros(top.n_e), form.held, e[form.held] - aim.e) + jacobian @ shift
    way = correction(top, transfer(top, jacobian), change, shift) / sizes_of(top, form.parameters)
    longest = jnp.max(jnp.abs(way), initial=0.0)
    steps = jnp.clip(jnp.ceil(jnp.where(jnp.isfinite(longest), longest, 1.0) / STEP), 0, MOST_STEPS).astype(jnp.int32)

    def further(at: tuple[Array, Array, Array]):
        step, x, near = at
        left = 1 - (step + 1).astype(float) / steps.astype(float)
        partly = aim._replace(x=aim.x - left * shift, e=aim.e - left * (aim.e - e[form.held]))
        return step + 1, *form.placed(partly, q, x, near, CORRECTIONS)

    _, x, near = jax.lax.while_loop(lambda at: at[0] < steps, further, (jnp.zeros((), jnp.int32), x, e))
    return x, near
