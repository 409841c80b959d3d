"""Forces of elements over a finite step, whose work is exactly the energy that the elements gain.

With f = (e, s) the deformations and places of inertia of an element, the derivative of f is replaced by a discrete one
whose product with the step of the coordinates is the step of f. The stress resultants then do the work that is stored,
and the inertia forces take the kinetic energy, to round-off, whatever the size of the step.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..math.indices import put
from ..math.linear import factorise
from ..mechanics.blocks import scatter_vector, scatter_vectors
from ..mechanics.inertia import mass_matrix
from .coordinates_form import CoordinatesForm
from .element_forces import Moving, deformed
from .protocol import MotionState

Rates = tuple[Float[Array, "elements k d"] | None, ...]


def rates_of_inertia(elements: tuple[Moving, ...], x: Float[Array, "n_x"], v: Float[Array, "n_x"], near) -> Rates:
    """Rates of the places of inertia, of each block.

    Args:
        elements: Elements.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
    """

    def rate(f, x, v):
        return jax.jvp(f, (x,), (v,))[1][1]

    return tuple(None if b.mass is None else b.over(rate, near, x[b.x], v[b.x]) for b in elements)


def momenta_of_inertia(elements: tuple[Moving, ...], x: Float[Array, "n_x"], near, rates: Rates) -> Float[Array, "n_x"]:
    """Momenta of the coordinates, J^T H s_dot, (n_x,) [kg m/s ..].

    Args:
        elements: Elements.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        rates: Rates of the places of inertia.
    """

    def pulled(f, x, weight):
        return jax.vjp(lambda x: f(x)[1], x)[1](weight)[0]

    heavy = [
        (block, block.mass @ rate)
        for block, rate in zip(elements, rates, strict=True)
        if block.mass is not None and rate is not None
    ]
    return scatter_vector(x.shape[0], [(b.x, b.over(pulled, near, x[b.x], weight)) for b, weight in heavy])


def _pulled(f, middle, step, scale, fall, change, forces):
    """Nodal forces of one element over a step: by the discrete derivative of f, of sigma and H s_ddot.

    Args:
        f: Of the coordinates, (e, s).
        middle: Coordinates halfway, (k,).
        step: Their change, (k,).
        scale: What changes are measured in, (k,).
        fall: Accelerations of free fall, (k,), or None.
        change: Change of (e, s).
        forces: sigma, and (s_ddot, H); None where there is none.
    """
    (_, at_middle), pull = jax.jvp(f, (middle,), (step,)), jax.vjp(f, middle)[1]
    sigma, inertia = forces
    weight = None
    if inertia is not None:
        acceleration, mass = inertia
        if fall is not None:
            acceleration = acceleration - jax.jvp(f, (middle,), (fall,))[1][1]
        weight = mass @ acceleration
    # The derivative at the middle misses some of the work, which a force along the step makes up for.
    work = zip(change, at_middle, (sigma, weight), strict=True)
    missing = sum(jnp.sum((whole - found) * force) for whole, found, force in work if force is not None)
    along = step / scale**2
    stretch = along @ step
    return pull((sigma, weight))[0] + missing * along / jnp.where(stretch > 0, stretch, 1.0)


def step_forces(
    elements: tuple[Moving, ...],
    x: tuple[Float[Array, "n_x"], Float[Array, "n_x"]],
    h: Float[Array, ""],
    rates: Rates,
    falling: Float[Array, "n_x"] | None,
    near: Float[Array, "n_e"],
    sizes: Float[Array, "n_x"],
    stress: Callable[..., Any],
) -> tuple[Float[Array, "n_x"], Rates]:
    """Mean nodal forces of stress and inertia over a step, and the rates at its end.

    Args:
        elements: Elements.
        x: Nodal coordinates at its begin and end, (n_x,) each [m, rad, -].
        h: Its length [s].
        rates: Rates of the places of inertia at its begin.
        falling: Accelerations of free fall, (n_x,) [1/s^2], or None.
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        sizes: What steps of coordinates are measured in, (n_x,) [m, -].
        stress: Mean sigma as a function of the mean of e and of its mean rate, (n_e,) [N, N m].

    Returns:
        Forces, (n_x,) [N, N m], and rates.

    Source:
        Gonzalez (1996), J. Nonlinear Science 6, 449: the derivative at the middle, corrected along the step.
    """
    begin, end = x
    step, middle = end - begin, (begin + end) / 2
    found = [
        (block, block.over(lambda f, a, b: (f(a), f(b)), near, begin[block.x], end[block.x])) for block in elements
    ]
    deformed = [(block.e, (at[0][0], at[1][0])) for block, at in found if block.e.shape[1]]
    e0, e1 = scatter_vectors(near.shape[0], deformed, 2)
    sigma = stress((e0 + e1) / 2, (e1 - e0) / h)
    forces, after = [], []
    for (block, ((e_0, s_0), (e_1, s_1))), rate in zip(found, rates, strict=True):
        change = (None if e_0 is None else e_1 - e_0, None if s_0 is None else s_1 - s_0)
        last = inertia = None
        if rate is not None:
            # The places of inertia move on straight lines at the mean of the rates at both ends.
            last = 2 * (s_1 - s_0) / h - rate
            inertia = ((last - rate) / h, block.mass)
        own = sigma[block.e] if block.e.shape[1] else None
        along = [of if of is None else of[block.x] for of in (middle, step, sizes, falling)]
        forces.append((block.x, block.over(_pulled, near, *along, change, (own, inertia))))
        after.append(last)
    return scatter_vector(begin.shape[0], forces), tuple(after)


def forces_over_step(
    form: CoordinatesForm, times, states: tuple[MotionState, MotionState], rates: Rates, multipliers
) -> tuple[Float[Array, "n"], Rates]:
    """Mean forces out of balance over a step, and the rates of the places of inertia at its end.

    Args:
        form: Equations of motion.
        times: Its begin and end [s].
        states: There; velocities are not used.
        rates: Rates of the places of inertia at its begin.
        multipliers: Mean multipliers, (m,) [N, N m].

    Returns:
        (n,) [N, N m], and rates.

    Source:
        See :func:`step_forces`.
    """
    (t0, t1), zero = times, jnp.zeros(form.size)
    begin, end = (form.whole(t, at.u, zero, zero).x for t, at in zip(times, states, strict=True))
    middle, near = (t0 + t1) / 2, form.near(states[0].memory)
    stress = form.stress_of(middle, multipliers)
    sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
    force, after = step_forces(form.elements, (begin, end), t1 - t0, rates, form.falling, near, sizes, stress)
    force = force - form.applied(middle, (begin + end) / 2)
    return force[form.free] * form.sizes, after


def rates_at(form: CoordinatesForm, t, state: MotionState) -> Rates:
    """Rates of the places of inertia, of each block of elements.

    Args:
        form: Equations of motion.
        t: Time [s].
        state: State.
    """
    at = form.whole(t, state.u, state.w, jnp.zeros(form.size))
    return rates_of_inertia(form.elements, at.x, at.v, form.near(state.memory))


def velocities_of(form: CoordinatesForm, t, state: MotionState, rates: Rates) -> Float[Array, "n"]:
    """Velocities that the constraints allow and that come closest to given rates of the places of inertia, (n,).

    Args:
        form: Equations of motion.
        t: Time [s].
        state: State; its velocities are not used.
        rates: Rates.

    Source:
        Least difference in the norm of the kinetic energy.
    """
    n, near = form.size, form.near(state.memory)
    at = form.whole(t, state.u, jnp.zeros(n), jnp.zeros(n))
    _, jacobian = deformed(form.elements, at.x, near)
    # What is driven moves by itself.
    driven = rates_of_inertia(form.elements, at.x, at.v, near)
    own = jax.tree.map(lambda rate, given: rate - given, rates, driven)
    momentum = momenta_of_inertia(form.elements, at.x, near, own)[form.free] * form.sizes
    mass = form.scaled(mass_matrix(form.topology, form.parameters, at.x))
    right = jnp.concatenate([momentum, at.ed - (jacobian @ at.v)[form.held]])
    return factorise(form.system(mass, form.columns(jacobian))).solve(right)[:n]
