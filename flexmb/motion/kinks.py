"""Search for kinks of laws and controllers within steps, so that steps can be shortened there.

The error of a step across a kink is within the tolerance, but depends steeply on the place of the kink. Derivatives
are derivatives of the steps, and would be wrong by the root of the tolerance. A force that acts only within a step,
such as a stop that is met and left again, does not appear in its error at all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..compilation.program import may_bend
from ..compilation.record import Record, static
from ..elements.element import NONLINEAR
from ..mechanics.stress_resultants import is_nonlinear, nonlinear_stress, strain_of
from ..numerical_limits import (
    JUMP_AT_KINK,
    KINK_OVER_SLOPE,
    KINK_OVER_USUAL,
    NEGLIGIBLE,
    SHORTEST_STEP,
    STEP_AT_KINK,
    TIME_ROUND_OFF,
)
from .controlled_form import ControlledForm
from .coordinates_form import CoordinatesForm, all_coordinates
from .element_forces import PreparedBlock, deformations_and_slopes, prepared_block
from .protocol import MotionState

# Parts of a step in which kinks, and forces that act only within it, are sought.
PARTS, FINE_PARTS = 8, 16


class Kinks(Record):
    """Finds kinks of laws, energies, dissipations and controllers.

    Attributes:
        equations: Equations of motion in all coordinates, or with such a ``form``.
        elements: Elements with laws, energies or dissipations.
        every: Whether every kink counts, as for a derivative; otherwise only forces that act within a step alone.
    """

    equations: Any
    elements: tuple[PreparedBlock, ...]
    every: bool = static(default=True)

    def within(
        self,
        times: tuple[Float[Array, ""], Float[Array, ""]],
        states: tuple[MotionState, MotionState],
        slopes: Float[Array, "k"],
    ) -> tuple[Float[Array, "k"], Float[Array, "k"]]:
        """Change of each function with a kink in a step (zero without), and its slope.

        `slopes` are the slopes of the functions at the first sight of the kink. A smaller bend is no kink.
        """
        times, states, kinks = jax.lax.stop_gradient((times, states, self))
        h = times[1] - times[0]
        controls = getattr(self.equations, "states", 0)

        def looked_at(parts: int, bow: float):
            at = along_step(times, states, controls, parts, bow)
            values = jax.vmap(lambda t, state: _forces(kinks, t, state))(*at)
            steep = jnp.max(jnp.abs(jnp.diff(values, axis=0)), axis=0)
            return values, steep, _is_kinked(values, jnp.maximum(steep, slopes * h / parts))

        values, steep, kinked = looked_at(FINE_PARTS, 1.0)
        shares = np.linspace(0.0, 1.0, FINE_PARTS + 1)[:, None]
        change = values[-1] - values[0]
        alone = kinked & (jnp.max(jnp.abs(values - values[0] - shares * change), axis=0) > jnp.abs(change))
        changes, part = jnp.where(alone, jnp.ptp(values, axis=0), 0.0), h / FINE_PARTS
        if self.every:
            straight, steep, kinked = looked_at(PARTS, 0.0)
            changes, part = jnp.where(kinked, jnp.ptp(straight, axis=0), changes), h / PARTS
        return changes, steep / part


def along_step(
    times: tuple[Any, Any], states: tuple[MotionState, MotionState], controls: int, parts: int, bow: float = 1.0
) -> tuple[Float[Array, "places"], MotionState]:
    """Times at equal distances in a step, both ends included, and states along the cubic through both ends.

    States of a controller are interpolated linearly; counted turns stay as at the begin. `bow` is the share of the
    cubic's deviation from the straight line.
    """
    (t0, t1), (begin, end) = times, states
    n, h, moved = begin.u.shape[0], t1 - t0, end.u - begin.u
    # Deviation of the cubic from the straight line; none for a controller's states.
    mechanism = np.arange(n) < n - controls
    ahead, behind = (jnp.where(mechanism, more, 0.0) for more in (h * begin.w - moved, moved - h * end.w))
    faster = 3 * (behind - ahead) / jnp.where(h == 0, 1.0, h)

    def between(share: Float[Array, ""]):
        # The memory counts turns, by nearby deformations.
        state = jax.tree.map(lambda a, b: a + share * (b - a), begin, end)._replace(memory=begin.memory)
        arch = bow * share * (1 - share)
        u, w = state.u + arch * ((1 - share) * ahead + share * behind), state.w + arch * faster
        return t0 + share * h, state._replace(u=u, w=w)

    return jax.vmap(between)(jnp.linspace(0.0, 1.0, parts + 1))


class KinkSearch(NamedTuple):
    """State of a search for a kink.

    Attributes:
        by: Time by which the kink has passed; no search if this is over [s].
        length: Length of the step that was refused first [s].
        changes: Change of each function in that step; zero without a kink.
        slopes: Slope of each in that step [1/s].
        jumped: Whether a function has jumped at a kink so far.
    """

    by: Float[Array, ""]
    length: Float[Array, ""]
    changes: Float[Array, "k"]
    slopes: Float[Array, "k"]
    jumped: Bool[Array, ""]

    def after(
        self,
        kinks: Kinks,
        times: tuple[Any, Any],
        states: tuple[MotionState, MotionState],
        kept: Any,
        next_t1: Any,
        smallest: Any,
    ) -> tuple[Bool[Array, ""], Float[Array, ""], KinkSearch]:
        """Whether a step is refused for a kink, the end of the next step, and the new search.

        `kept`: whether the step's error is small enough; `next_t1`: end of the next step by its error.
        """
        (t0, t1), seeking = times, self.by > times[0]
        changes, slopes = kinks.within(times, states, jnp.where(seeking, self.slopes, 0.0))
        changes = jnp.where(kept, changes, 0.0)
        length = jnp.where(seeking, self.length, t1 - t0)
        short = jnp.maximum(STEP_AT_KINK * length, TIME_ROUND_OFF * jnp.maximum(jnp.abs(t0), jnp.abs(t1)))
        short = jnp.maximum(short, SHORTEST_STEP * smallest)
        refused = jnp.any(changes > 0) & (t1 - t0 > short)
        begins = refused & ~seeking
        first = jnp.where(begins, changes, self.changes)
        jumped = self.jumped
        if kinks.every:
            # Only derivatives need to know of jumps.
            jumped = jumped | (seeking & ~refused & jnp.any((changes > JUMP_AT_KINK * first) & (first > 0)))
        by = jnp.where(refused, t1, self.by)
        begin = jnp.where(refused, t0, t1)
        remaining = by - begin
        onwards = begin + jnp.where(remaining > short, remaining / 2, remaining)
        # Beyond the kink steps are as long as before.
        after = jnp.where(remaining > 0, onwards, jnp.where(seeking, jnp.maximum(next_t1, t1 + length), next_t1))
        search = KinkSearch(by, length, first, jnp.where(begins, slopes, self.slopes), jumped)
        return refused, jnp.where(kept, after, next_t1), search


def search_of(kinks: Kinks | None, t: Float[Array, ""], state: MotionState) -> KinkSearch:
    """Search at the start of a motion."""
    sizes = jnp.zeros(0 if kinks is None else jax.eval_shape(_forces, kinks, t, state).shape)
    return KinkSearch(jnp.asarray(-jnp.inf), jnp.asarray(jnp.inf), sizes, sizes, jnp.asarray(False))


def kinks_of(equations: Any, every: bool = True) -> Kinks | None:
    """Search for kinks of equations; None if all laws and the controller are smooth operations."""
    form = all_coordinates(equations)
    if form is None or not (_law_may_bend(form) or _controller_may_bend(equations)):
        return None
    blocks = zip(form.topology.blocks, form.parameters.properties, strict=True)
    laws = [(block, properties) for block, properties in blocks if not set(NONLINEAR).isdisjoint(block.companions)]
    prepared = [prepared_block(block, properties, form.parameters.reference) for block, properties in laws]
    return Kinks(equations, tuple(block for block in prepared if block is not None), every)


def _law_may_bend(form: CoordinatesForm) -> bool:
    top = form.topology
    if not is_nonlinear(top):
        return False
    none = jax.ShapeDtypeStruct((top.n_e,), float)
    return may_bend(lambda e, ed: nonlinear_stress(top, form.parameters, e, ed), none, none)


def _controller_may_bend(equations: Any) -> bool:
    if not isinstance(equations, ControlledForm):
        return False
    places, output = equations.places, equations.feedback.output
    count = (places.outputs if places.read is None else places.read).shape[0]
    like = [jax.ShapeDtypeStruct(shape, float) for shape in ((), (equations.states,), (count,))]
    return may_bend(output, *like)


def _forces(kinks: Kinks, t: Float[Array, ""], state: MotionState) -> Float[Array, "k"]:
    """A controller's inputs, and stress resultants of laws, energies and dissipations."""
    form: Any = all_coordinates(kinks.equations)
    at = kinks.equations.whole_motion(t, state)
    if not is_nonlinear(form.topology):
        return at.u
    e, jacobian = deformations_and_slopes(kinks.elements, at.x, at.near)
    strain = strain_of(form.topology, form.parameters, form.drive(t).loads, e)
    return jnp.concatenate([at.u, nonlinear_stress(form.topology, form.parameters, strain, jacobian @ at.xd)])


def _is_kinked(values: Float[Array, "places k"], steep: Float[Array, "k"]) -> Bool[Array, "k"]:
    """Whether each function has a kink, from values at equal distances."""
    second = jnp.abs(jnp.diff(values, 2, axis=0))
    # A kink between two places changes the second differences at both.
    bend, usual = jnp.max(second[1:] + second[:-1], axis=0), jnp.median(second, axis=0)
    changes = steep > NEGLIGIBLE * jnp.max(jnp.abs(values), axis=0)
    return changes & (bend > KINK_OVER_SLOPE * steep) & (bend > KINK_OVER_USUAL * usual)
