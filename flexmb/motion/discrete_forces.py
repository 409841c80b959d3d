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

from ..mechanics.blocks import scatter_vector, scatter_vectors
from .element_forces import PreparedBlock
from .protocol import InertiaRates


def rates_of_inertia(
    elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], v: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> InertiaRates:
    """Rates of the places of inertia, of each block.

    Args:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        v: Their velocities, (n_x,) [1/s].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
    """

    def rate(f: Callable[..., Any], x: Float[Array, "c"], v: Float[Array, "c"]):
        return jax.jvp(f, (x,), (v,))[1][1]

    return tuple(None if b.mass is None else b.over(rate, near, x[b.x], v[b.x]) for b in elements)


def momenta_of_inertia(
    elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"], rates: InertiaRates
) -> Float[Array, "n_x"]:
    """Momenta of the coordinates, J^T H s_dot, (n_x,) [kg m/s ..].

    Args:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        rates: Rates of the places of inertia.
    """

    def pulled(f: Callable[..., Any], x: Float[Array, "c"], weight: Float[Array, "k d"]):
        return jax.vjp(lambda x: f(x)[1], x)[1](weight)[0]

    heavy = [
        (block, block.mass @ rate)
        for block, rate in zip(elements, rates, strict=True)
        if block.mass is not None and rate is not None
    ]
    return scatter_vector(x.shape[0], [(b.x, b.over(pulled, near, x[b.x], weight)) for b, weight in heavy])


def _pulled(
    f: Callable[..., Any],
    middle: Float[Array, "k"],
    step: Float[Array, "k"],
    scale: Float[Array, "k"],
    fall: Float[Array, "k"] | None,
    change: tuple[Any, Any],
    forces: tuple[Any, Any],
):
    """Nodal forces of one element over a step, to which the discrete derivative of f carries sigma and H s_ddot."""
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
    elements: tuple[PreparedBlock, ...],
    x: tuple[Float[Array, "n_x"], Float[Array, "n_x"]],
    h: Float[Array, ""],
    rates: InertiaRates,
    falling: Float[Array, "n_x"] | None,
    near: Float[Array, "n_e"],
    sizes: Float[Array, "n_x"],
    stress: Callable[..., Any],
) -> tuple[Float[Array, "n_x"], InertiaRates]:
    """Mean nodal forces of stress and inertia over a step, and the rates at its end.

    Args:
        x: Nodal coordinates at its begin and end, (n_x,) each [m, rad, -].
        h: Its length [s].
        rates: Rates of the places of inertia at its begin.
        falling: Accelerations of free fall, (n_x,) [1/s^2], or None.
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        sizes: Sizes that make changes of coordinates pure numbers, (n_x,) [m, -].
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
