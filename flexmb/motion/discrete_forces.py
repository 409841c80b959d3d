"""Forces of elements over a finite step, whose work is exactly the energy that the elements gain.

Let f = (e, s) be the deformations and inertia vectors s(x) of an element. A discrete derivative replaces the derivative
of f: its product with the step of the coordinates is the step of f. Stress resultants and inertia forces then do
exactly the work that is stored, at any step size.
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
    """Rates of the inertia vectors, of each block."""

    def rate(f: Callable[..., Any], x: Float[Array, "c"], v: Float[Array, "c"]):
        return jax.jvp(f, (x,), (v,))[1][1]

    return tuple(None if b.mass is None else b.over(rate, near, x[b.x], v[b.x]) for b in elements)


def momenta_of_inertia(
    elements: tuple[PreparedBlock, ...], x: Float[Array, "n_x"], near: Float[Array, "n_e"], rates: InertiaRates
) -> Float[Array, "n_x"]:
    """Momenta of the coordinates, J^T H s_dot [kg m/s ..]."""

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
    """Nodal forces of one element over a step: the discrete derivative of f, transposed, times sigma and H s_ddot."""
    (_, at_middle), pull = jax.jvp(f, (middle,), (step,)), jax.vjp(f, middle)[1]
    sigma, inertia = forces
    weight = None
    if inertia is not None:
        acceleration, mass = inertia
        if fall is not None:
            acceleration = acceleration - jax.jvp(f, (middle,), (fall,))[1][1]
        weight = mass @ acceleration
    # The derivative at the middle misses some of the work. A force along the step adds the rest.
    work = zip(change, at_middle, (sigma, weight), strict=True)
    missing = sum(jnp.sum((step - at_middle) * force) for step, at_middle, force in work if force is not None)
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
    """Mean nodal forces of stress and inertia over a step, and the rates of the inertia vectors at its end.

    The derivative at the middle, corrected along the step (Gonzalez (1996), J. Nonlinear Science 6, 449). `sizes` make
    changes of coordinates pure numbers. `stress` returns mean sigma from the means of e and of its rate.
    """
    begin, end = x
    step, middle = end - begin, (begin + end) / 2
    ends = [(block, block.over(lambda f, a, b: (f(a), f(b)), near, begin[block.x], end[block.x])) for block in elements]
    deformed = [(block.e, (at[0][0], at[1][0])) for block, at in ends if block.e.shape[1]]
    e0, e1 = scatter_vectors(near.shape[0], deformed, 2)
    sigma = stress((e0 + e1) / 2, (e1 - e0) / h)
    forces, after = [], []
    for (block, ((e_0, s_0), (e_1, s_1))), rate in zip(ends, rates, strict=True):
        change = (None if e_0 is None else e_1 - e_0, None if s_0 is None else s_1 - s_0)
        last = inertia = None
        if rate is not None:
            # Places of inertia move on straight lines, at the mean of their rates at both ends.
            last = 2 * (s_1 - s_0) / h - rate
            inertia = ((last - rate) / h, block.mass)
        stressed = sigma[block.e] if block.e.shape[1] else None
        along = [array if array is None else array[block.x] for array in (middle, step, sizes, falling)]
        forces.append((block.x, block.over(_pulled, near, *along, change, (stressed, inertia))))
        after.append(last)
    return scatter_vector(begin.shape[0], forces), tuple(after)
