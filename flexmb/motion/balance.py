"""The energy balance of a step: energy that a motion gains or loses without work by any force.

Accurate displacements do not exclude a lost impulse: a method that damps stiff motions stops a body at a stiff spring
within one step. The energy balance detects this.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats
from ..mechanics.stress_resultants import is_nonlinear
from ..numerical_limits import ENERGY_PER_STEP
from .chain_form import ChainForm
from .controlled_form import ControlledForm
from .coordinates_form import CoordinatesForm, all_coordinates
from .protocol import MotionState
from .stages import StepResult, hermite, state_within_step, z_within

# Gauss-Legendre places in a step, and their weights.
PLACES, WEIGHTS = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2, np.polynomial.legendre.leggauss(4)[1] / 2


class Balance(NamedTuple):
    """Energy balance of a motion so far.

    Attributes:
        greatest: Greatest kinetic plus elastic energy [J].
        gained: Energy gained without a cause; negative if lost [J].
        worst: Greatest absolute value of `gained` [J].
    """

    greatest: Float[Array, ""]
    gained: Float[Array, ""]
    worst: Float[Array, ""]

    @property
    def share(self) -> Float[Array, ""]:
        """`worst` over `greatest`; NaN without energy."""
        return self.worst / jnp.where(self.greatest > 0, self.greatest, jnp.nan)

    def with_energy(self, energy: Float[Array, ""]) -> Balance:
        """Balance whose greatest energy is at least `energy`."""
        return self._replace(greatest=jnp.maximum(self.greatest, jnp.where(jnp.isfinite(energy), energy, 0.0)))

    def after(
        self, gained: Float[Array, ""], energy: Float[Array, ""], rtol: Any, noise: Float[Array, ""]
    ) -> tuple[Float[Array, ""], Balance]:
        """Energy gained in a step over the allowed one, and the balance after it; `noise` [J] is allowed by atol."""
        after_step = self.with_energy(energy)
        share = jnp.abs(gained) / jnp.maximum(ENERGY_PER_STEP * rtol * after_step.greatest + noise, 1e-300)
        total = self.gained + jnp.sign(gained) * jnp.maximum(jnp.abs(gained) - noise, 0.0)
        worst = jnp.maximum(self.worst, jnp.abs(total))
        return jnp.where(jnp.isfinite(share), share, jnp.inf), Balance(after_step.greatest, total, worst)


class Before(NamedTuple):
    """What controls the size of the next step: greatest displacement so far (extents, radians), and energy balance."""

    moved: Float[Array, ""]
    balance: Balance


def at_start() -> Before:
    """Values before the first step."""
    zero = as_floats(0.0)
    return Before(zero, Balance(zero, zero, zero))


def is_seen(equations: Any) -> bool:
    """Whether states at the ends of a step give its balance: elements have laws, and no multiplier does work."""
    if isinstance(equations, ChainForm | ControlledForm):
        return False
    form = all_coordinates(equations)
    return (
        form is not None
        and is_nonlinear(form.topology)
        and not any(drive.quantity in ("x", "e", "increment", "temperature") for drive in form.driven)
    )


def elastic_energy(equations: Any, t: Float[Array, ""], state: MotionState) -> Float[Array, ""]:
    """Elastic energy of the elements of constant stiffness [J]."""
    form = equations if isinstance(equations, CoordinatesForm) else equations.form
    if isinstance(equations, ControlledForm):
        # Inputs from the controller do not change the elastic energy.
        equations, state = form, MotionState(state.u[: form.size], state.w[: form.size], state.memory)
    e = equations.whole_motion(t, state).near
    return e @ form.elastic_stress(e) / 2


def kinetic_from_residual(equations: Any, t: Float[Array, ""], state: MotionState) -> Float[Array, ""]:
    """Kinetic energy [J], from the residual, which is linear in the accelerations."""
    n, none = equations.size - equations.states, jnp.zeros(equations.unknowns)
    w = state.w[:n]
    inertia = equations.residual(t, state, none.at[:n].set(w)) - equations.residual(t, state, none)
    return w @ inertia[:n] / 2


class StepError(NamedTuple):
    """Error of the state after a step, and the energies and half trace of the mass matrix for :meth:`Balance.after`."""

    state: MotionState
    gained: Float[Array, ""]
    energy: Float[Array, ""]
    inertia: Float[Array, ""]


def balanced_error(
    equations: Any,
    times: tuple[Any, Any],
    states: tuple[MotionState, MotionState],
    z: Float[Array, "r"],
    taken: StepResult,
) -> StepError:
    """Error of a Rosenbrock step with its energy balance; `z` are accelerations and multipliers at its begin."""
    (t0, t1), n = times, states[0].u.shape[0]
    h, rates, mechanism_rows = t1 - t0, (z[:n], taken.z[:n]), slice(n - equations.states)

    def at(share: Float[Array, ""]):
        t = t0 + share * h
        state, rate = jax.jvp(lambda t: state_within_step(times, states, rates, t), (t,), (jnp.ones_like(t),))
        return t, state, jnp.append(rate.w, z_within((z, taken.z), taken.bows, share)[n:])

    mass, w = jnp.asarray(taken.mass), states[1].w[mechanism_rows]
    energy = w @ mass[mechanism_rows, mechanism_rows] @ w / 2 + elastic_energy(equations, t1, states[1])
    return StepError(taken.error, gained_along(equations, h, at), energy, jnp.trace(mass) / 2)


def gained_along(
    equations: Any, h: Float[Array, ""], at: Callable[[Float[Array, ""]], tuple[Any, MotionState, Array]]
) -> Float[Array, ""]:
    """Work of the residual along a step of length `h` [J].

    The interpolated motion is exact under an additional force, the residual. `at` returns time, state, and
    accelerations with multipliers at a share of the step from 0 to 1.
    """
    n = equations.size - equations.states

    def power(share: Float[Array, ""]):
        t, state, z = at(share)
        return state.w[:n] @ equations.residual(t, state, z)[:n]

    return h * (jax.vmap(power)(jnp.asarray(PLACES)) @ WEIGHTS)


def gained_between(equations: Any, times: tuple[Any, Any], states: tuple[MotionState, MotionState]) -> Float[Array, ""]:
    """Energy that a step gains without a cause [J], from the states at its ends.

    Velocities follow the cubic through positions and velocities, right for smooth motions, or a straight line, right
    for velocities that friction holds. The smaller result counts.
    """
    (t0, t1), (y0, y1), n = times, states, equations.size - equations.states
    h = jnp.where(t1 == t0, 1.0, t1 - t0)

    def along(share: Float[Array, ""], straight: bool):
        def positions(t: Float[Array, ""]):
            return hermite((t - t0) / h, h, y0.u, y1.u, y0.w, y1.w)

        def velocities(t: Float[Array, ""]):
            line = y0.w + (t - t0) / h * (y1.w - y0.w)
            return line if straight else line.at[:n].set(jax.jvp(positions, (t,), (jnp.ones_like(t),))[1][:n])

        t = t0 + share * h
        w, z = jax.jvp(velocities, (t,), (jnp.ones_like(t),))
        u = positions(t).at[n:].set(0.0)
        return t, MotionState(u, w, y0.memory), jnp.append(z, jnp.zeros(equations.unknowns - equations.size))

    gains = jnp.stack([gained_along(equations, t1 - t0, lambda s, c=c: along(s, c)) for c in (False, True)])
    return gains[jnp.argmin(jnp.abs(gains))]
