"""An energy-keeping method for long motions without losses, as a diffrax solver of fixed steps.

Its forces of elements over a finite step do exactly the work that the elements store, at any step size. Let f = (e, s)
be the deformations and inertia vectors s(x) of an element. A discrete derivative replaces the derivative of f: its
product with the step of the coordinates is the step of f.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..math.indices import put, scatter_vector, scatter_vectors
from ..math.linear import factorise
from ..mechanics.inertia import mass_matrix
from .coordinates_form import CoordinatesForm
from .protocol import MotionState
from .solver import MotionTerm, SecondOrderSolver, equations_of, solve_step

# Rates of the inertia vectors s(x) of each block of elements; None for a block without mass.
InertiaRates = tuple[Float[Array, "elements k d"] | None, ...]


class EnergyKeeping(SecondOrderSolver):
    """Implicit method of second order that keeps energy: forces do exactly the work that the elements store.

    For constant stiffness and constant forces, the energy is constant to round-off, for any step size. The method damps
    nothing: vibrations that the steps do not resolve persist. Needs ``form="coordinates"`` and no controller.

    Source:
        Gonzalez (1996), J. Nonlinear Science 6, 449; with constraints (1999), Physica D 132, 165. Here the kinetic
        energy is a quadratic form of the rates of the inertia vectors s(x) (THEORY.md 3, eq. (3.1)). Each step passes
        these rates to the next step.
    """

    def init(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any):
        """Return accelerations and multipliers at the start, and the rates of the inertia vectors.

        Args:
            terms: Equations of motion.
            t0: Start [s].
            t1: End of the first step [s].
            y0: State.
            args: Not used.
        """
        form: Any = equations_of(terms)
        return form.acceleration(t0, y0)[0], rates_of_inertia(form, t0, y0)

    @jit_beside_options
    def step(self, terms: MotionTerm, t0: Any, t1: Any, y0: MotionState, args: Any, solver_state: Any, made_jump: Any):
        """Return the result of one step.

        Args:
            terms: Equations of motion.
            t0: Start of the step [s].
            t1: End of the step [s].
            y0: State at the start of the step.
            args: Not used.
            solver_state: From :meth:`init`.
            made_jump: Not used.
        """
        # Every other form is refused before.
        form: Any = equations_of(terms)
        h, n = t1 - t0, y0.u.shape[0]
        z0, rates = solver_state

        def at_end(z: Float[Array, "r"]):
            return MotionState(y0.u + h * y0.w + h**2 / 2 * z[:n], y0.w + h * z[:n], y0.memory)

        def residual(z: Float[Array, "r"]):
            state = at_end(z)
            force, _ = forces_over_step(form, (t0, t1), (y0, state), rates, z[n:])
            return jnp.concatenate([force, form.gap(t1, state) / (h**2 / 2)])

        def matrix(z: Float[Array, "r"]):
            u = y0.u + h / 2 * y0.w + h**2 / 8 * z[:n]
            at = form.tangent((t0 + t1) / 2, MotionState(u, y0.w + h / 2 * z[:n], y0.memory), z)
            return at.by_z.at[:n, :n].add(h / 2 * at.by_w[:n] + h**2 / 4 * at.by_u[:n])

        z1, solved = solve_step(residual, matrix, matrix(z0), z0, n, h**2 / 2)
        state = at_end(z1)
        _, rates = forces_over_step(form, (t0, t1), (y0, state), rates, z1[n:])
        y1 = MotionState(state.u, velocities_of(form, t1, state, rates), state.memory)
        y1 = y1._replace(memory=form.settle(t1, y1).memory)
        dense = dict(y0=y0, y1=y1, a0=z0[:n], a1=z1[:n])
        ok: Any = diffrax.RESULTS
        return y1, None, dense, (z1, rates), ok.where(solved, ok.successful, ok.nonlinear_divergence)


def rates_of_inertia(form: CoordinatesForm, t: Float[Array, ""], state: MotionState) -> InertiaRates:
    """Rates of the inertia vectors s(x), of each block of elements."""
    at, last_strain = form.whole(t, state.u, state.w), form.near(state.memory)

    def rate(f: Callable[..., Any], x: Float[Array, "c"], v: Float[Array, "c"]):
        return jax.jvp(f, (x,), (v,))[1][1]

    return tuple(None if b.mass is None else b.over(rate, last_strain, at.x[b.x], at.v[b.x]) for b in form.elements)


def velocities_of(
    form: CoordinatesForm, t: Float[Array, ""], state: MotionState, rates: InertiaRates
) -> Float[Array, "n"]:
    """Allowed velocities closest to given rates of the inertia vectors, in the norm of the kinetic energy."""
    still, last_strain = state._replace(w=jnp.zeros(form.size)), form.near(state.memory)
    at = form.whole(t, state.u)
    _, jacobian = form.deformed(at.x, last_strain)
    # The rates include driven coordinates, which are known.
    undriven = jax.tree.map(lambda rate, known: rate - known, rates, rates_of_inertia(form, t, still))

    def pulled(f: Callable[..., Any], x: Float[Array, "c"], weight: Float[Array, "k d"]):
        return jax.vjp(lambda x: f(x)[1], x)[1](weight)[0]

    # Momenta of the coordinates, J^T H s_dot [kg m/s ..].
    momenta = [
        (block.x, block.over(pulled, last_strain, at.x[block.x], block.mass @ rate))
        for block, rate in zip(form.elements, undriven, strict=True)
        if block.mass is not None and rate is not None
    ]
    momentum = scatter_vector(at.x.shape[0], momenta)[form.free] * form.sizes
    mass = form.scaled(mass_matrix(form.topology, form.parameters, at.x))
    right = jnp.concatenate([momentum, at.ed - (jacobian @ at.v)[form.held]])
    return factorise(form.system(mass, form.columns(jacobian))).solve(right)[: form.size]


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


def forces_over_step(
    form: CoordinatesForm,
    times: tuple[Any, Any],
    states: tuple[MotionState, MotionState],
    rates: InertiaRates,
    multipliers: Float[Array, "m"],
) -> tuple[Float[Array, "n"], InertiaRates]:
    """Mean forces out of balance over a step, and the rates of the inertia vectors at its end.

    `rates` are the rates at the begin, `multipliers` are means over the step. Velocities of the states are unused. The
    derivative at the middle is corrected along the step (Gonzalez (1996), J. Nonlinear Science 6, 449).
    """
    (t0, t1), last_strain = times, form.near(states[0].memory)
    begin, end = (form.whole(t, at.u).x for t, at in zip(times, states, strict=True))
    h, step, middle, t_middle = t1 - t0, end - begin, (begin + end) / 2, (t0 + t1) / 2
    # They make changes of coordinates pure numbers.
    sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
    ends = [
        (block, block.over(lambda f, a, b: (f(a), f(b)), last_strain, begin[block.x], end[block.x]))
        for block in form.elements
    ]
    deformed = [(block.e, (at[0][0], at[1][0])) for block, at in ends if block.e.shape[1]]
    e0, e1 = scatter_vectors(last_strain.shape[0], deformed, 2)
    sigma = form.stress_of(t_middle, multipliers)((e0 + e1) / 2, (e1 - e0) / h)
    forces, after = [], []
    for (block, ((e_0, s_0), (e_1, s_1))), rate in zip(ends, rates, strict=True):
        change = (None if e_0 is None else e_1 - e_0, None if s_0 is None else s_1 - s_0)
        last = inertia = None
        if rate is not None:
            # Places of inertia move on straight lines, at the mean of their rates at both ends.
            last = 2 * (s_1 - s_0) / h - rate
            inertia = ((last - rate) / h, block.mass)
        stressed = sigma[block.e] if block.e.shape[1] else None
        along = [array if array is None else array[block.x] for array in (middle, step, sizes, form.falling)]
        forces.append((block.x, block.over(_pulled, last_strain, *along, change, (stressed, inertia))))
        after.append(last)
    force = scatter_vector(begin.shape[0], forces) - form.applied(t_middle, middle)
    return force[form.free] * form.sizes, tuple(after)
