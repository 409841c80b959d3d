"""Controllers with limits, delays, schedules and feedforward: functions that return what ``control=`` takes."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import as_reals, check_number, check_numbers, check_whole, is_concrete, shown
from ..errors import ModelError
from ..motion.controlled_form import Feedback
from ..motion.controllers import Sampled, at_time, controller_of, linear_controller, matrices_of, windup_of
from ..motion.drive import Table

if TYPE_CHECKING:
    import control

# A delay is a whole number of samples where it differs from it by at most this share of one.
SAME = 1e-6


def saturated(controller: Any, limits: ArrayLike, *, tracking: float | None = None) -> Feedback | Sampled:
    """A controller whose outputs stay within limits, as an amplifier's do, and whose integrators do not wind up.

    Beyond the limits the integrators of a linear controller are led back, so that what they ask for follows the limit
    with the time constant ``tracking``: z' = A z + B y + V (C V)^+ (sat(u) - u)/T, with the eigenvectors V of the
    eigenvalues that do not decay. A sampled one takes the share 1 - exp(-h/T) of it a sample. Other states are left
    alone.

    Args:
        controller: What :func:`flexmb.simulate` takes as ``control``. Of a :class:`flexmb.motion.Feedback` or Sampled
            that one writes oneself, ``windup`` says what is led back.
        limits: Largest size of every output, or least and largest of each, (n_u, 2) [N, N m].
        tracking: Time constant T [s]; ``np.inf`` lets integrators wind up. Needed where the controller integrates, and
            only there.

    Returns:
        Feedback, or Sampled for a sampled controller.

    Raises:
        ModelError: The controller is none, limits that are none, ``tracking`` is missing or for nothing, a chain of
            integrators, which one time constant does not lead back, or an A that is traced, whose are not known.

    Source:
        THEORY.md 14, eq. (14.41).
    """
    given = controller_of(controller)
    low, high = _limits(limits)
    if tracking is None and given.windup is not None:
        raise ModelError(
            "The controller integrates, or may where its A is traced, and would wind up while its outputs are limited:"
            " give `tracking`, the time constant [s] by which it follows them, or np.inf."
        )
    if tracking is not None and given.windup is None:
        raise ModelError("Argument `tracking` is for integrators, which the controller has not: leave it out.")
    follow = _following(given, tracking)

    def within(t: Float[Array, ""], u: ArrayLike):
        u = jnp.atleast_1d(as_reals("What the controller gives", u, ModelError))
        if low.shape not in ((), u.shape):
            raise ModelError(f"Argument `limits` is for {low.shape[0]} outputs, but the controller has {u.shape[0]}.")
        return jnp.clip(u, low, high)

    def led_back(t: Float[Array, ""], u: ArrayLike):
        return at_time(follow, t) @ (within(t, u) - jnp.atleast_1d(jnp.asarray(u, float)))

    return _changed(given, within, None if follow is None else led_back)


def _changed(given: Feedback | Sampled, output: Callable, more: Callable | None = None) -> Feedback | Sampled:
    """A controller whose outputs u are ``output(t, u)``, ``more(t, u)`` added to the rate, or step, of its state."""
    if isinstance(given, Sampled):
        step = given.step

        def changed(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
            u, then = step(t, z, y)
            return output(t, u), then if more is None else then + more(t, u)

        return dataclasses.replace(given, step=changed)
    own, rate = given.output, given.rate
    rates = rate if rate is None or more is None else lambda t, z, y: rate(t, z, y) + more(t, own(t, z, y))
    return dataclasses.replace(given, output=lambda t, z, y: output(t, own(t, z, y)), rate=rates)


def _limits(limits: Any) -> tuple[Any, Any]:
    """Least and largest of each output, or of all."""
    check_numbers("Argument `limits`", limits, fault=ModelError)
    found = jnp.asarray(limits, float)
    if found.ndim and (found.ndim != 2 or found.shape[1] != 2):
        raise ModelError(
            "Argument `limits` must be one number, or a least and a largest of each output, (n_u, 2), but has shape"
            f" {found.shape}."
        )
    low, high = (found[:, 0], found[:, 1]) if found.ndim else (-found, found)
    if is_concrete(found) and not np.all(np.asarray(low) < np.asarray(high)):
        raise ModelError(f"Argument `limits`: the least must be below the largest, but they are {shown(limits)}.")
    return low, high


def _following(given: Feedback | Sampled, tracking: Any) -> Any:
    """What an excess does to the state, (n_z, n_u), or a table of it; None for nothing."""
    if tracking is None or (is_concrete(tracking) and tracking == np.inf):
        return None
    check_number("tracking", tracking, above=0)
    windup: Any = given.windup
    values = windup.values if isinstance(windup, Table) else windup
    if is_concrete(values) and not np.all(np.isfinite(np.asarray(values))):
        raise ModelError(
            "The controller's integrators stand in a chain, are more than its outputs, or are not known since its A is"
            " traced: one time constant does not lead them back. Give an A of known numbers (NumPy), write a Feedback"
            " with a `windup` of its own, or give tracking=np.inf."
        )
    share = 1 - jnp.exp(-given.period / tracking) if isinstance(given, Sampled) else 1 / jnp.asarray(tracking)
    return Table(windup.times, share * windup.values) if isinstance(windup, Table) else share * jnp.asarray(windup)


def fed_forward(controller: Any, law: Callable) -> Feedback | Sampled:
    """A controller with inputs of the mechanism as functions of time added to what it gives.

    ``inputs=`` of :func:`flexmb.simulate` does the same for inputs by name; here limits may act on the sum:
    ``saturated(fed_forward(controller, law), limits)``.

    Args:
        controller: What :func:`flexmb.simulate` takes as ``control``.
        law: Function of time that gives what is added to each output of the controller, (n_u,) [N, N m]; a
            :class:`flexmb.motion.Table` is one. A sampled controller holds it from sample to sample.

    Returns:
        Feedback, or Sampled for a sampled controller.

    Raises:
        ModelError: The controller is none, or the law is no function or gives another number of numbers.

    Source:
        Two degrees of freedom: u = law(t) + controller(reference - y), with the nominal inputs of THEORY.md 14 as law.
    """
    given = controller_of(controller)
    if not callable(law):
        raise ModelError(f"Argument `law` must be a function of time, such as lambda t: [3.0], not {shown(law)}.")

    def added(t: Float[Array, ""], u: ArrayLike):
        both = ("What the controller gives", u), ("Argument `law`", law(t))
        u, extra = (jnp.atleast_1d(as_reals(what, part, ModelError)) for what, part in both)
        if extra.shape != u.shape:
            raise ModelError(f"Argument `law` gives shape {extra.shape}, but the controller has {u.shape[0]} outputs.")
        return u + extra

    return _changed(given, added)


def scheduled(times: ArrayLike, controllers: Any) -> Feedback | Sampled:
    """A controller whose gains, or whose matrices, change along a trajectory; in between on straight lines.

    Args:
        times: Ascending, (n_t,) [s]. Before the first and after the last the gains are constant. Where they bend, the
            simulation need not stop: its steps follow. Named as ``jumps`` it stops there.
        controllers: Gains at these times, (n_t,) for one output and one input of the mechanism, or (n_t, n_u, n_y); or
            as many systems of python-control, with the same states.

    Returns:
        Feedback, or Sampled of sampled systems.

    Raises:
        ModelError: Times that do not ascend, or not as many controllers, or systems that differ in their numbers of
            states or signals, their names or their intervals.

    Source:
        u = K(t) y, or z' = A(t) z + B(t) y, u = C(t) z + D(t) y; SPACAR's spacntrl has the first.
    """
    check_numbers("Argument `times`", times, fault=ModelError)
    at = jnp.asarray(times, float)
    if at.ndim != 1 or at.shape[0] < 2 or (is_concrete(at) and not np.all(np.diff(np.asarray(at)) > 0)):
        raise ModelError("Argument `times` must be ascending, two times at least.")
    if isinstance(controllers, Sequence) and any(_is_system(one) for one in controllers):
        return _of_systems(at, controllers)
    check_numbers("Argument `controllers`", controllers, fault=ModelError)
    gains = jnp.asarray(controllers, float)
    gains = gains[:, None, None] if gains.ndim == 1 else gains
    if gains.ndim != 3 or gains.shape[0] != at.shape[0]:
        raise ModelError(
            f"Argument `controllers` must be gains at {at.shape[0]} times, (n_t,) or (n_t, n_u, n_y), not of shape"
            f" {gains.shape}."
        )
    gain = Table(at, gains)
    return Feedback(lambda t, z, y: gain(t) @ y)


def _is_system(given: Any) -> bool:
    return hasattr(given, "D") or hasattr(given, "num")


def _of_systems(times: Float[Array, "n_t"], systems: Sequence[Any]) -> Feedback | Sampled:
    """One controller of several linear ones, each at its time."""
    if len(systems) != len(times):
        raise ModelError(f"Argument `controllers` has {len(systems)} systems for {len(times)} times.")
    if not all(_is_system(one) for one in systems):
        raise ModelError("Argument `controllers` has systems and others: give systems of python-control alone.")
    found = [matrices_of(one) for one in systems]
    alike = {(tuple(np.shape(part) for part in of[0]), *of[1:]) for of in found}
    if len(alike) > 1:
        raise ModelError(
            "The scheduled systems differ in their numbers of states or signals, their names or their intervals:"
            " there is nothing in between."
        )
    parts = [Table(times, jnp.stack([jnp.asarray(of[0][i]) for of in found])) for i in range(4)]
    period = found[0][1]
    winding = [windup_of(of[0][0], of[0][2], bool(period)) for of in found]
    windup = None
    if any(one is not None for one in winding):
        shape = (np.shape(found[0][0][0])[0], np.shape(found[0][0][2])[0])
        windup = Table(times, jnp.stack([jnp.zeros(shape) if one is None else jnp.asarray(one) for one in winding]))
    return linear_controller(parts, period, windup, *found[0][2:])


def delayed(controller: Any, delay: float, *, order: int | None = None) -> "control.StateSpace":
    """A linear controller whose outputs arrive late, by computing, buses and amplifiers.

    A sampled controller is delayed by whole samples, exactly: each is one more state an output. A continuous one is
    delayed by the Pade approximant of ``control.pade``, numerator and denominator of the same order n: its gain is
    one at every frequency, and its phase is that of the delay up to some 2 n/T rad/s.

    Args:
        controller: System of python-control.
        delay: Time T [s].
        order: Order of the approximant; for a continuous controller, and only there.

    Returns:
        ``control.StateSpace`` with the names of the controller.

    Raises:
        ModelError: It is no linear system, or a sampled one whose delay is not a whole number of samples; an order is
            missing or for nothing.
        TypeError: Numbers of the controller or the delay are traced.

    Source:
        THEORY.md 14, eq. (14.42).
    """
    import control

    check_number("delay", delay, least=0)
    if not _is_system(controller):
        raise ModelError(
            "Only a linear system of python-control is delayed: delay it before it is limited or scheduled. A function"
            " of your own keeps what is to come in the state of a fm.motion.Sampled."
        )
    (a, b, c, d), period, reads, drives = matrices_of(controller)
    if not is_concrete((a, b, c, d, delay)):
        raise TypeError(
            "fm.control.delayed makes a control.StateSpace, which holds concrete numbers: delay a controller outside"
            " jax.jit and jax.grad, and differentiate by gains in front of it or behind it."
        )
    count = np.shape(d)[0]
    system: Any = control.ss(a, b, c, d, period or 0)
    late: Any
    if period:
        if order is not None:
            raise ModelError("Argument `order` is for a continuous controller: samples are delayed exactly.")
        samples = round(delay / period)
        if abs(delay / period - samples) > SAME:
            raise ModelError(
                f"A sampled controller is delayed by whole samples of {period:g} s, and {delay:g} s are"
                f" {delay / period:.6g} of them. Sample more often, or round the delay up."
            )
        shift, ends = np.eye(samples, k=-1), np.eye(max(samples, 1))
        one = control.ss(shift, ends[:samples, :1], ends[-1:, :samples], [[float(samples == 0)]], period)
        late = control.append(*[one] * count)
    else:
        if order is None:
            raise ModelError(
                "A delay of a continuous controller is approximated: give `order`, such as 2 for loops up to some 1/T"
                " rad/s, or a sampled controller."
            )
        order = check_whole("order", order, least=1)
        late = control.append(*[control.ss(control.tf(*control.pade(delay, order)))] * count)
    whole: Any = late * system
    names: Any = {name: list(own) for name, own in (("inputs", reads), ("outputs", drives)) if own is not None}
    return control.StateSpace(whole.A, whole.B, whole.C, whole.D, period or 0, **names)
