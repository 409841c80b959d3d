"""Steps across a kink of a law or a controller: found, so that they can be shortened.

A step of a Runge-Kutta method across a kink has an error within its tolerance, but one that depends steeply on where in
the step the kink lies; as derivatives are those of the steps, they would be wrong by the root of the tolerance. And
what acts within a step alone, such as a stop that is met and left again, is not seen by its error at all: of a free
flight any step is exact.
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
from .controlled_form import ControlledForm
from .coordinates_form import CoordinatesForm
from .element_forces import PreparedBlock, deformed, prepared_block
from .protocol import MotionState

# A step is looked at in so many parts for kinks, and for what acts within it alone.
PARTS, FINE_PARTS = 8, 16
# A kink is where a function bends so many times as much as it does in the middle of a step's places, by more than that
# share of its slope.
UNUSUAL, CURVED = 8.0, 1e-3
# What changes by less than this share of it is round-off.
CHANGED = 1e-9
# A step across a kink is at last this share of the one that was refused. What changes in it by that share of its change
# in the one that was refused jumps.
SHARE, JUMP = 1e-6, 0.3
# Steps are no shorter than so many times the round-off of the time, nor so many times the shortest.
ROUND_OFF, LEAST = 1e-14, 20.0


class Kinks(Record):
    """Finds kinks of laws, energies, dissipations and controllers.

    Attributes:
        equations: Equations of motion, with ``form`` in all coordinates or such themselves.
        elements: Those with laws, energies or dissipations.
        every: Whether every kink counts, as for a derivative; otherwise that of what acts within a step alone.
    """

    equations: Any
    elements: tuple[PreparedBlock, ...]
    every: bool = static(default=True)

    def none(self, t: Float[Array, ""], state: MotionState) -> Float[Array, "k"]:
        """Zero for each function."""
        like: Any = jax.eval_shape(_forces, self, t, state)
        return jnp.zeros(like.shape)

    def within(
        self,
        times: tuple[Float[Array, ""], Float[Array, ""]],
        states: tuple[MotionState, MotionState],
        slopes: Float[Array, "k"],
    ) -> tuple[Float[Array, "k"], Float[Array, "k"]]:
        """By how much each function that has a kink within a step changes in it, zero where it has none, and its slope.

        Args:
            times: Its begin and end [s].
            states: There.
            slopes: Of each function where a kink was found at first, (k,) [1/s]: what bends less beside it is no kink.
        """
        times, states, own = jax.lax.stop_gradient((times, states, self))
        h = times[1] - times[0]
        controls = getattr(self.equations, "states", 0)

        def looked_at(parts: int, bow: float):
            at = along_step(times, states, controls, parts, bow)
            values = jax.vmap(lambda t, state: _forces(own, t, state))(*at)
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
    """Times at equal distances within a step, its ends among them, and states along the cubic through both ends.

    Rates are those of the cubic. A controller's states go straight, and what counts turns stays as at the begin.

    Args:
        times: Its begin and end [s].
        states: There.
        controls: Number of states of a controller, the last of the velocities.
        parts: Of the step; there is a place more.
        bow: Share of what the cubic leaves the straight line by: zero is that line.
    """
    (t0, t1), (begin, end) = times, states
    n, h, moved = begin.u.shape[0], t1 - t0, end.u - begin.u
    # By what a cubic with the rates at both ends leaves the straight line; a controller's states have none.
    mechanism = np.arange(n) < n - controls
    ahead, behind = (jnp.where(mechanism, more, 0.0) for more in (h * begin.w - moved, moved - h * end.w))
    faster = 3 * (behind - ahead) / jnp.where(h == 0, 1.0, h)

    def between(share: Float[Array, ""]):
        # The memory counts turns, by deformations near by.
        state = jax.tree.map(lambda a, b: a + share * (b - a), begin, end)._replace(memory=begin.memory)
        arch = bow * share * (1 - share)
        u, w = state.u + arch * ((1 - share) * ahead + share * behind), state.w + arch * faster
        return t0 + share * h, state._replace(u=u, w=w)

    return jax.vmap(between)(jnp.linspace(0.0, 1.0, parts + 1))


class KinkSearch(NamedTuple):
    """Search for a kink.

    Attributes:
        by: Time by which it has passed; none is sought where that is over [s].
        length: Of the step that was refused first [s].
        changes: Of each function in that step, zero of those without a kink, (k,).
        slopes: Of each in that step, (k,) [1/s].
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
        """Whether a step is refused for a kink, the end of the next one, and the search as it goes on.

        Args:
            kinks: What finds them.
            times: Begin and end of the step [s].
            states: There.
            kept: Whether its error would be small enough.
            next_t1: End of the next step by its error.
            smallest: Smallest step [s].
        """
        known = jnp.where(self.by > times[0], self.slopes, 0.0)
        changes, slopes = kinks.within(times, states, known)
        found = _halved(self, times, kept, (jnp.where(kept, changes, 0.0), slopes), next_t1, LEAST * smallest)
        # Where a jump matters is asked for derivatives alone.
        return found if kinks.every else (*found[:2], found[2]._replace(jumped=self.jumped))


def search_of(kinks: Kinks | None, t: Float[Array, ""], state: MotionState) -> KinkSearch:
    """A search that has found nothing, at the start of a motion; without kinks none ever does."""
    sizes = jnp.zeros(0) if kinks is None else kinks.none(t, state)
    return KinkSearch(jnp.asarray(-jnp.inf), jnp.asarray(jnp.inf), sizes, sizes, jnp.asarray(False))


def _halved(
    search: KinkSearch,
    times: tuple[Any, Any],
    kept: Any,
    functions: tuple[Float[Array, "k"], Float[Array, "k"]],
    next_t1: Any,
    least: Any,
) -> tuple[Bool[Array, ""], Float[Array, ""], KinkSearch]:
    """Whether a step is refused for a kink, the end of the next one, and the search as it goes on."""
    (t0, t1), (changes, slopes) = times, functions
    seeking, h = search.by > t0, t1 - t0
    length = jnp.where(seeking, search.length, h)
    short = jnp.maximum(SHARE * length, ROUND_OFF * jnp.maximum(jnp.abs(t0), jnp.abs(t1)))
    short = jnp.maximum(short, least)
    refused = jnp.any(changes > 0) & (h > short)
    begins = refused & ~seeking
    first = jnp.where(begins, changes, search.changes)
    jumped = search.jumped | (seeking & ~refused & jnp.any((changes > JUMP * first) & (first > 0)))
    by = jnp.where(refused, t1, search.by)
    begin = jnp.where(refused, t0, t1)
    rest = by - begin
    onwards = begin + jnp.where(rest > short, rest / 2, rest)
    # Behind the kink steps are as long as before.
    after = jnp.where(rest > 0, onwards, jnp.where(seeking, jnp.maximum(next_t1, t1 + length), next_t1))
    return (
        refused,
        jnp.where(kept, after, next_t1),
        KinkSearch(by, length, first, jnp.where(begins, slopes, search.slopes), jumped),
    )


def kinks_of(equations: Any, every: bool = True) -> Kinks | None:
    """What finds kinks of some equations, None where all laws and the controller are made of smooth operations."""
    form = _all_coordinates(equations)
    if form is None or not (_law_may_bend(form) or _controller_may_bend(equations)):
        return None
    top, own = form.topology, form.parameters
    blocks = zip(top.blocks, own.properties, strict=True)
    laws = [(block, given) for block, given in blocks if not set(NONLINEAR).isdisjoint(block.companions)]
    found = [prepared_block(block, given, own.reference) for block, given in laws]
    return Kinks(equations, tuple(one for one in found if one is not None), every)


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


def _all_coordinates(equations: Any) -> CoordinatesForm | None:
    form = equations if isinstance(equations, CoordinatesForm) else getattr(equations, "form", None)
    return form if isinstance(form, CoordinatesForm) else None


def _forces(of: Kinks, t: Float[Array, ""], state: MotionState) -> Float[Array, "k"]:
    """Inputs by a controller, and stress resultants of laws, energies and dissipations."""
    form: Any = _all_coordinates(of.equations)
    at = of.equations.whole_motion(t, state)
    if not is_nonlinear(form.topology):
        return at.u
    e, jacobian = deformed(of.elements, at.x, at.near)
    strain = strain_of(form.topology, form.parameters, form.drive(t).loads, e)
    return jnp.concatenate([at.u, nonlinear_stress(form.topology, form.parameters, strain, jacobian @ at.xd)])


def _is_kinked(values: Float[Array, "places k"], steep: Float[Array, "k"]) -> Bool[Array, "k"]:
    """Which functions have a kink, by their values at equal distances."""
    second = jnp.abs(jnp.diff(values, 2, axis=0))
    # Wherever between two places a kink lies, it shows at these two.
    bend, usual = jnp.max(second[1:] + second[:-1], axis=0), jnp.median(second, axis=0)
    changes = steep > CHANGED * jnp.max(jnp.abs(values), axis=0)
    return changes & (bend > CURVED * steep) & (bend > UNUSUAL * usual)
