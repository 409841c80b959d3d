"""The energy balance of a step: energy that a motion gains or loses although no force does that work.

A step whose displacements are accurate may still lose an impulse. A stiff spring that a body meets within the step
moves it by little, and a method that damps stiff motions brings the body to rest. The lost energy shows it.
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
from .chain_form import ChainForm
from .controlled_form import ControlledForm
from .coordinates_form import CoordinatesForm
from .protocol import MotionState
from .stages import Taken, between, hermite, z_within

# A step may gain or lose at most so many times the relative tolerance of the greatest energy. At ten times, twenty
# impacts between walls added up to more than is warned of; at three they do not (tests/motion/test_balance.py).
ALLOWED = 3.0
# Places in a step where forces are looked at, and their weights, by Gauss and Legendre.
PLACES, WEIGHTS = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2, np.polynomial.legendre.leggauss(4)[1] / 2


class Balance(NamedTuple):
    """Energy balance of a motion so far.

    Attributes:
        greatest: Greatest kinetic plus elastic energy [J].
        gained: Energy gained without a cause, negative where it was lost [J].
        worst: Greatest of its absolute values [J].
    """

    greatest: Float[Array, ""]
    gained: Float[Array, ""]
    worst: Float[Array, ""]

    @property
    def share(self) -> Float[Array, ""]:
        """Energy gained or lost without a cause, over the greatest energy; NaN where there was no energy."""
        return self.worst / jnp.where(self.greatest > 0, self.greatest, jnp.nan)

    def with_energy(self, energy: Float[Array, ""]) -> Balance:
        """The same where the energy has been so great [J]."""
        return self._replace(greatest=jnp.maximum(self.greatest, jnp.where(jnp.isfinite(energy), energy, 0.0)))

    def after(
        self, gained: Float[Array, ""], energy: Float[Array, ""], rtol: Any, noise: Float[Array, ""]
    ) -> tuple[Float[Array, ""], Balance]:
        """What a step gains over what it may gain, and the balance behind it.

        Args:
            gained: By the step [J].
            energy: At its end [J].
            rtol: Relative tolerance.
            noise: Energy of the motion that the absolute tolerance allows in the step [J].
        """
        behind = self.with_energy(energy)
        share = jnp.abs(gained) / jnp.maximum(ALLOWED * rtol * behind.greatest + noise, 1e-300)
        total = self.gained + jnp.sign(gained) * jnp.maximum(jnp.abs(gained) - noise, 0.0)
        worst = jnp.maximum(self.worst, jnp.abs(total))
        return jnp.where(jnp.isfinite(share), share, jnp.inf), Balance(behind.greatest, total, worst)


class Before(NamedTuple):
    """What is known of a motion before a step, by which step sizes are controlled.

    Attributes:
        moved: Greatest displacement so far (extents, radians).
        balance: Energy balance so far.
    """

    moved: Float[Array, ""]
    balance: Balance


def at_start() -> Before:
    """What is known before the first step."""
    zero = as_floats(0.0)
    return Before(zero, Balance(zero, zero, zero))


def is_seen(equations: Any) -> bool:
    """Whether the balance of a step is looked at by the states at its ends: elements have laws, and nothing is driven.

    Multipliers then do no work. What has no law has nothing that a step misses, and that balance is the coarser one.
    """
    if isinstance(equations, ChainForm | ControlledForm):
        return False
    form = _all_coordinates(equations)
    if not isinstance(form, CoordinatesForm):
        return False
    return is_nonlinear(form.topology) and not any(
        one.quantity in ("x", "e", "increment", "temperature") for one in form.driven
    )


def elastic_energy(equations: Any, t: Float[Array, ""], state: MotionState) -> Float[Array, ""]:
    """Elastic energy of the elements of constant stiffness [J]."""
    form, whole = _all_coordinates(equations), equations
    if isinstance(equations, ControlledForm):
        # The inputs that a controller gives do not matter here.
        whole, state = form, MotionState(state.u[: form.size], state.w[: form.size], state.memory)
    e = whole.whole_motion(t, state).near
    return e @ form.elastic_stress(e) / 2


def kinetic_energy(equations: Any, t: Float[Array, ""], state: MotionState) -> Float[Array, ""]:
    """Kinetic energy of what moves [J], by the residual, which is linear in the accelerations."""
    n, none = equations.size - equations.states, jnp.zeros(equations.unknowns)
    w = state.w[:n]
    inertia = equations.residual(t, state, none.at[:n].set(w)) - equations.residual(t, state, none)
    return w @ inertia[:n] / 2


class StepError(NamedTuple):
    """Error estimate of a step with its energy balance, as a solver hands both to its step size controller.

    Attributes:
        state: Error of the state.
        gained: Energy that the step gains without a cause [J].
        energy: Kinetic plus elastic energy at its end [J].
        inertia: Half the trace of the mass matrix, for :meth:`Balance.after`'s noise.
    """

    state: MotionState
    gained: Float[Array, ""]
    energy: Float[Array, ""]
    inertia: Float[Array, ""]


def balanced_error(
    equations: Any,
    times: tuple[Any, Any],
    states: tuple[MotionState, MotionState],
    z: Float[Array, "r"],
    taken: Taken,
) -> StepError:
    """Error of a Rosenbrock step with its energy balance.

    Args:
        equations: Equations of motion.
        times: Begin and end of the step [s].
        states: There, on the constraints.
        z: Accelerations and multipliers at its begin, (n + m,).
        taken: What the step led to.
    """
    (t0, t1), n = times, states[0].u.shape[0]
    h, rates, own = t1 - t0, (z[:n], taken.z[:n]), slice(n - equations.states)

    def at(share: Float[Array, ""]):
        t = t0 + share * h
        state, rate = jax.jvp(lambda t: between(times, states, rates, t), (t,), (jnp.ones_like(t),))
        return t, state, jnp.append(rate.w, z_within((z, taken.z), taken.bows, share)[n:])

    mass, w = jnp.asarray(taken.mass), states[1].w[own]
    energy = w @ mass[own, own] @ w / 2 + elastic_energy(equations, t1, states[1])
    return StepError(taken.error, gained_along(equations, h, at), energy, jnp.trace(mass) / 2)


def gained_along(
    equations: Any, h: Float[Array, ""], at: Callable[[Float[Array, ""]], tuple[Any, MotionState, Array]]
) -> Float[Array, ""]:
    """Work of what the equations leave out of balance along a step [J].

    The motion between the ends of a step is exact under an additional force, the residual there. Its work is energy
    that no load, damper, controller or prescribed motion accounts for.

    Args:
        equations: Equations of motion.
        h: Length of the step [s].
        at: Time, state, accelerations and multipliers (n + m,) at a share of the step, from 0 to 1.
    """
    n = equations.size - equations.states

    def power(share: Float[Array, ""]):
        t, state, z = at(share)
        return state.w[:n] @ equations.residual(t, state, z)[:n]

    return h * (jax.vmap(power)(jnp.asarray(PLACES)) @ WEIGHTS)


def gained_between(equations: Any, times: tuple[Any, Any], states: tuple[MotionState, MotionState]) -> Float[Array, ""]:
    """The energy that a step gains without a cause [J], by the states at its ends alone.

    Velocities between them are rates of the cubic through positions and velocities, or straight: what is less. The
    cubic is right for smooth motions, the straight line for velocities that friction holds.

    Args:
        equations: Equations of motion that no function of time moves: multipliers then do no work.
        times: Begin and end of the step [s].
        states: There.
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


def _all_coordinates(equations: Any) -> Any:
    return equations if isinstance(equations, CoordinatesForm) else equations.form
