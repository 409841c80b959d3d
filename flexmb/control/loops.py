"""Controllers with limits, delays, schedules and feedforward, for the argument ``control=`` of a simulation."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import as_reals, check_number, check_numbers, check_whole, is_concrete, short_repr
from ..errors import ModelError
from ..motion.controlled_form import Feedback
from ..motion.controllers import Sampled, at_time, controller_of, linear_controller, matrices_of, windup_of
from ..motion.drive import Table
from ..numerical_limits import WHOLE_SAMPLES

if TYPE_CHECKING:
    import control


def saturated(controller: Any, limits: ArrayLike, *, tracking: float | None = None) -> Feedback | Sampled:
    """Return a controller with limited outputs, as of an amplifier, and with integrators that do not wind up.

    Beyond the limits the integrators of a linear controller are corrected, so that their outputs follow the limit with
    the time constant ``tracking``: z' = A z + B y + V (C V)^+ (sat(u) - u)/T, with the eigenvectors V of the
    eigenvalues that do not decay. For a sampled controller, the correction per sample has the factor 1 - exp(-h/T).
    Other states do not change.

    Args:
        controller: Any ``control`` of :func:`flexmb.simulate`. A :class:`flexmb.motion.Feedback` or Sampled of your own
            defines the correction by ``windup``.
        limits: Largest absolute value of all outputs, or smallest and largest value of each, (n_u, 2) [N, N m].
        tracking: Time constant T [s]; ``np.inf`` lets integrators wind up. Required for a controller with integrators;
            otherwise not allowed.

    Returns:
        Feedback, or Sampled for a sampled controller.

    Raises:
        ModelError: The controller or the limits are invalid; ``tracking`` is missing or not needed; integrators form a
            chain, which one time constant cannot correct; A is traced, so that its integrators are unknown.

    Source:
        THEORY.md 14, eq. (14.41).
    """
    feedback = controller_of(controller)
    low, high = _limits(limits)
    if tracking is None and feedback.windup is not None:
        raise ModelError(
            "The controller has integrators, or its A is traced. Integrators wind up while outputs are limited. Give"
            " `tracking`, the time constant [s] with which they follow the limits, or np.inf."
        )
    if tracking is not None and feedback.windup is None:
        raise ModelError("Argument `tracking` is for integrators, but the controller has none. Leave it out.")
    follow = _following(feedback, tracking)

    def within(t: Float[Array, ""], u: ArrayLike):
        u = jnp.atleast_1d(as_reals("The controller's output", u, ModelError))
        if low.shape not in ((), u.shape):
            raise ModelError(f"Argument `limits` is for {low.shape[0]} outputs, but the controller has {u.shape[0]}.")
        return jnp.clip(u, low, high)

    def led_back(t: Float[Array, ""], u: ArrayLike):
        return at_time(follow, t) @ (within(t, u) - jnp.atleast_1d(jnp.asarray(u, float)))

    return _changed(feedback, within, None if follow is None else led_back)


def _changed(feedback: Feedback | Sampled, output: Callable, more: Callable | None = None) -> Feedback | Sampled:
    """A controller with outputs ``output(t, u)``, and ``more(t, u)`` added to the rate, or step, of its states."""
    if isinstance(feedback, Sampled):
        step = feedback.step

        def changed(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
            u, next_states = step(t, z, y)
            return output(t, u), next_states if more is None else next_states + more(t, u)

        return dataclasses.replace(feedback, step=changed)
    unchanged, rate = feedback.output, feedback.rate
    rates = rate if rate is None or more is None else lambda t, z, y: rate(t, z, y) + more(t, unchanged(t, z, y))
    return dataclasses.replace(feedback, output=lambda t, z, y: output(t, unchanged(t, z, y)), rate=rates)


def _limits(limits: Any) -> tuple[Any, Any]:
    """Smallest and largest value of each output, or of all."""
    check_numbers("Argument `limits`", limits, fault=ModelError)
    bounds = jnp.asarray(limits, float)
    if bounds.ndim and (bounds.ndim != 2 or bounds.shape[1] != 2):
        raise ModelError(
            "Argument `limits` must be one number, or the smallest and largest value of each output, (n_u, 2), but has"
            f" shape {bounds.shape}."
        )
    low, high = (bounds[:, 0], bounds[:, 1]) if bounds.ndim else (-bounds, bounds)
    if is_concrete(bounds) and not np.all(np.asarray(low) < np.asarray(high)):
        raise ModelError(f"Argument `limits`: the least must be below the largest, but they are {short_repr(limits)}.")
    return low, high


def _following(feedback: Feedback | Sampled, tracking: Any) -> Any:
    """Rate of the states per excess, (n_z, n_u), or a table of it; None for none."""
    if tracking is None or (is_concrete(tracking) and tracking == np.inf):
        return None
    check_number("tracking", tracking, above=0)
    windup: Any = feedback.windup
    values = windup.values if isinstance(windup, Table) else windup
    if is_concrete(values) and not np.all(np.isfinite(np.asarray(values))):
        raise ModelError(
            "One time constant cannot correct the controller's integrators: they form a chain, are more than its"
            " outputs, or are unknown since A is traced. Give an A of known numbers (NumPy), a Feedback with its own"
            " `windup`, or tracking=np.inf."
        )
    share = 1 - jnp.exp(-feedback.period / tracking) if isinstance(feedback, Sampled) else 1 / jnp.asarray(tracking)
    return Table(windup.times, share * windup.values) if isinstance(windup, Table) else share * jnp.asarray(windup)


def fed_forward(controller: Any, law: Callable) -> Feedback | Sampled:
    """Return a controller with functions of time added to its outputs.

    ``inputs=`` of :func:`flexmb.simulate` adds functions by name. With ``fed_forward``, limits may act on the sum:
    ``saturated(fed_forward(controller, law), limits)``.

    Args:
        controller: Any ``control`` of :func:`flexmb.simulate`.
        law: Function of time that returns the numbers to add to the outputs of the controller, (n_u,) [N, N m], such as
            a :class:`flexmb.motion.Table`. A sampled controller keeps them constant between samples.

    Returns:
        Feedback, or Sampled for a sampled controller.

    Raises:
        ModelError: The controller is invalid; the law is no function or does not return n_u numbers.

    Source:
        Two degrees of freedom: u = law(t) + controller(reference - y), with the nominal inputs of THEORY.md 14 as law.
    """
    feedback = controller_of(controller)
    if not callable(law):
        raise ModelError(f"Argument `law` must be a function of time, such as lambda t: [3.0], not {short_repr(law)}.")

    def added(t: Float[Array, ""], u: ArrayLike):
        parts = ("The controller's output", u), ("Argument `law`", law(t))
        u, extra = (jnp.atleast_1d(as_reals(label, part, ModelError)) for label, part in parts)
        if extra.shape != u.shape:
            raise ModelError(
                f"Argument `law` returns shape {extra.shape}, but the controller has {u.shape[0]} outputs."
            )
        return u + extra

    return _changed(feedback, added)


def scheduled(times: ArrayLike, controllers: Any) -> Feedback | Sampled:
    """Return a controller whose gains or matrices change along a trajectory, linearly between times.

    Args:
        times: Ascending, (n_t,) [s]. Gains are constant before the first and after the last. A simulation does not stop
            at these times unless ``jumps`` lists them.
        controllers: Gains at these times, (n_t,) for one output and one input of the mechanism, or (n_t, n_u, n_y); or
            systems of python-control with the same states.

    Returns:
        Feedback, or Sampled for sampled systems.

    Raises:
        ModelError: Times do not ascend, their number differs from the number of controllers, or systems differ in their
            number of states or signals, names or sampling intervals.

    Source:
        u = K(t) y (as spacntrl of SPACAR), or z' = A(t) z + B(t) y, u = C(t) z + D(t) y.
    """
    check_numbers("Argument `times`", times, fault=ModelError)
    at = jnp.asarray(times, float)
    if at.ndim != 1 or at.shape[0] < 2 or (is_concrete(at) and not np.all(np.diff(np.asarray(at)) > 0)):
        raise ModelError("Argument `times` must be ascending, two times at least.")
    if isinstance(controllers, Sequence) and any(map(_is_system, controllers)):
        return _scheduled_systems(at, controllers)
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


def _is_system(controller: Any) -> bool:
    return hasattr(controller, "D") or hasattr(controller, "num")


def _scheduled_systems(times: Float[Array, "n_t"], systems: Sequence[Any]) -> Feedback | Sampled:
    """One controller from several linear ones, each at its time."""
    if len(systems) != len(times):
        raise ModelError(f"Argument `controllers` has {len(systems)} systems for {len(times)} times.")
    if not all(map(_is_system, systems)):
        raise ModelError("Argument `controllers` mixes systems and other objects. Give only systems of python-control.")
    realisations = [matrices_of(system) for system in systems]
    alike = {(tuple(np.shape(part) for part in matrices), *properties) for matrices, *properties in realisations}
    if len(alike) > 1:
        raise ModelError(
            "The scheduled systems differ in their numbers of states or signals, their names or their intervals. They"
            " must agree."
        )
    parts = [Table(times, jnp.stack([jnp.asarray(matrices[i]) for matrices, *_ in realisations])) for i in range(4)]
    period = realisations[0][1]
    windups = [windup_of(a, c, bool(period)) for (a, _, c, _), *_ in realisations]
    windup = None
    if any(entry is not None for entry in windups):
        shape = (np.shape(realisations[0][0][0])[0], np.shape(realisations[0][0][2])[0])
        windup = Table(times, jnp.stack([jnp.zeros(shape) if w is None else jnp.asarray(w) for w in windups]))
    return linear_controller(parts, period, windup, *realisations[0][2:])


def delayed(controller: Any, delay: float, *, order: int | None = None) -> "control.StateSpace":
    """Return a linear controller with delayed outputs. Computing, buses and amplifiers cause such delays.

    A sampled controller is delayed exactly, by whole samples; each adds one state per output. A continuous one is
    delayed by the Pade approximant of ``control.pade``, numerator and denominator of the same order n: its gain is one
    at all frequencies, and its phase is correct up to some 2 n/T rad/s.

    Args:
        controller: System of python-control.
        delay: Time T [s].
        order: Order of the approximant; required for a continuous controller, otherwise not allowed.

    Returns:
        ``control.StateSpace`` with the names of the controller.

    Raises:
        ModelError: The controller is no linear system, the delay is no whole number of samples, or the order is missing
            or not needed.
        TypeError: Numbers of the controller or the delay are traced.

    Source:
        THEORY.md 14, eq. (14.42).
    """
    import control

    check_number("delay", delay, least=0)
    if not _is_system(controller):
        raise ModelError(
            "Only a linear system of python-control can be delayed. Delay it before it is limited or scheduled. A"
            " function of your own can store its past in the state of a fm.motion.Sampled."
        )
    (a, b, c, d), period, reads, drives = matrices_of(controller)
    if not is_concrete((a, b, c, d, delay)):
        raise TypeError(
            "fm.control.delayed returns a control.StateSpace, which needs concrete numbers. Delay a controller outside"
            " jax.jit and jax.grad, and differentiate by gains in front of it or behind it."
        )
    count = np.shape(d)[0]
    system: Any = control.ss(a, b, c, d, period or 0)
    late: Any
    if period:
        if order is not None:
            raise ModelError(
                "Argument `order` is only for a continuous controller; a sampled controller is delayed exactly."
            )
        samples = round(delay / period)
        if abs(delay / period - samples) > WHOLE_SAMPLES:
            raise ModelError(
                f"A sampled controller needs a delay of whole samples: {delay:g} s are {delay / period:.6g} samples of"
                f" {period:g} s. Sample more often, or round the delay up."
            )
        shift, ends = np.eye(samples, k=-1), np.eye(max(samples, 1))
        delay_line = control.ss(shift, ends[:samples, :1], ends[-1:, :samples], [[float(samples == 0)]], period)
        late = control.append(*[delay_line] * count)
    else:
        if order is None:
            raise ModelError(
                "A delay of a continuous controller is approximated. Give `order`, such as 2 for loops up to some 1/T"
                " rad/s, or a sampled controller."
            )
        order = check_whole("order", order, least=1)
        late = control.append(*[control.ss(control.tf(*control.pade(delay, order)))] * count)
    delayed_system: Any = late * system
    names: Any = {name: list(labels) for name, labels in (("inputs", reads), ("outputs", drives)) if labels is not None}
    return control.StateSpace(
        delayed_system.A, delayed_system.B, delayed_system.C, delayed_system.D, period or 0, **names
    )
