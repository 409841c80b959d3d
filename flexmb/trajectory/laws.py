"""Laws of time: from rest to rest in any coordinate, through points, through samples, and shaped to leave no vibration.

A law is a function f(t) of one number, with derivatives by the time and by its own numbers. It is at rest at its first
value before it begins, and at its last value afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import as_reals, check_number, check_numbers, check_whole, checked_times, is_concrete, shown
from ..compilation.program import of_time
from ..compilation.record import Record
from ..display import Result, Summary, short
from ..errors import first_line

# Peaks of velocity, acceleration and jerk of a move by one in one second.
PEAKS = {5: (15 / 8, 10 / math.sqrt(3), 60.0), 7: (35 / 16, 84 / (5 * math.sqrt(5)), 52.5)}
# Coefficients of the polynomials 10 s^3 - 15 s^4 + 6 s^5 and 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7, of ascending power.
RISES = {5: (0, 0, 0, 10, -15, 6), 7: (0, 0, 0, 0, 35, -84, 70, -20)}
# Signs of the jerk in the seven phases of an S-curve, and which of them last as long as the jerk, the rest and the
# cruise.
JERKS = (1, 0, -1, 0, -1, 0, 1)
WORDS = ("value", "velocity", "acceleration", "jerk")


class Law(Result, Record):
    """Function of time in pieces, each a polynomial of the time since it began.

    Attributes:
        breaks: Where pieces begin, and where the last ends, ascending, (n + 1,) [s].
        coefficients: Of each piece, of ascending power of the time, (n, degree + 1) [m/s^k, rad/s^k].
    """

    breaks: Float[Array, "n_breaks"]
    coefficients: Float[Array, "n powers"]
    one_axis = "breaks"

    def __call__(self, t: Float[ArrayLike, ""]) -> Float[Array, ""]:
        """Value at a time.

        Args:
            t: Time, () [s].

        Returns:
            () [m, rad].
        """
        # Of concrete numbers by NumPy, for which nothing is compiled.
        xp: Any = np if is_concrete((self, t)) else jnp
        breaks, coefficients, t = (xp.asarray(own, float) for own in (self.breaks, self.coefficients, t))
        piece = xp.clip(xp.searchsorted(breaks, t, side="right") - 1, 0, coefficients.shape[0] - 1)
        # At the ends themselves the derivatives are those of the pieces; beyond there is no motion.
        beyond = xp.where(t < breaks[0], breaks[0], breaks[-1])
        inside = (t >= breaks[0]) & (t <= breaks[-1])
        since = xp.where(inside, t, beyond) - breaks[piece]
        return jnp.asarray(xp.polyval(coefficients[piece, ::-1], since))

    @property
    def shape_of_value(self) -> tuple[int, ...]:
        """That of one number, where coefficients are those of polynomials; whatever the time."""
        return np.shape(self.coefficients)[2:]

    @property
    def duration(self) -> Float[Array, ""]:
        """Time from its beginning to its end, () [s]."""
        return self.breaks[-1] - self.breaks[0]

    def peaks(self) -> tuple[float, float, float]:
        """Largest velocity, acceleration and jerk, without sign [1/s, 1/s^2, 1/s^3]; of concrete numbers."""
        return tuple(np.asarray(_peaks(self)).tolist())

    def summary(self) -> Summary:
        """From where to where, when, and its peaks."""
        ends, peaks = [float(self(t)) for t in np.asarray(self.breaks)[[0, -1]]], self.peaks()
        rows = {"time": f"{short(self.breaks[0])} to {short(self.breaks[-1])} s", "pieces": str(len(self.breaks) - 1)}
        rows |= {f"largest {word}": short(peak) for word, peak in zip(WORDS[1:], peaks, strict=True)}
        return Summary(f"Law of time: {short(ends[0])} to {short(ends[1])}", rows)


class Shaped(Record):
    """A law that is given in several parts, one after the other.

    Attributes:
        law: The law.
        shares: Part of each, (n,) [-].
        delays: By how much each comes later, (n,) [s].
    """

    law: Callable[..., Any]
    shares: Float[Array, "n"]
    delays: Float[Array, "n"]

    def __call__(self, t: Float[ArrayLike, ""]) -> Float[Array, ""]:
        """Value at a time."""
        parts = [self.shares[i] * self.law(t - self.delays[i]) for i in range(self.shares.shape[0])]
        return jnp.sum(jnp.stack(parts))


def rates(law: Callable, t: Float[ArrayLike, ""]) -> tuple[Any, Any, Any]:
    """Value, velocity and acceleration of a law.

    Args:
        law: Function of time by ``jax.numpy``.
        t: Time, () [s].

    Returns:
        Three numbers, () each [m, m/s, m/s^2 or rad].

    Source:
        Derivatives by ``jax.jvp``.
    """
    t = jnp.asarray(t, float)

    def first(t: Float[Array, ""]):
        return jax.jvp(lambda t: as_reals("Argument `law`", law(t)), (t,), (jnp.ones_like(t),))

    (value, rate), (_, second) = jax.jvp(first, (t,), (jnp.ones_like(t),))
    return value, rate, second


def quintic(
    start: ArrayLike,
    end: ArrayLike,
    duration: ArrayLike | None = None,
    *,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    jerk: ArrayLike | None = None,
    begin: ArrayLike = 0.0,
) -> Law:
    """Law from rest to rest by a polynomial of degree five: velocity and acceleration are zero at both ends.

    Args:
        start: Value before, () [m, rad].
        end: Value afterwards, () [m, rad].
        duration: How long it takes, () [s]. Give this, or one or more of the limits: then it is the shortest
            that keeps them.
        velocity: Largest velocity, () [1/s].
        acceleration: Largest acceleration, () [1/s^2].
        jerk: Largest rate of the acceleration, () [1/s^3].
        begin: When it begins, () [s].

    Returns:
        Law.

    Raises:
        TypeError, ValueError: What is no number, is not positive, or neither a duration nor a limit.

    Source:
        THEORY.md 14, eq. (14.10).
    """
    return _rise(5, start, end, duration, (velocity, acceleration, jerk), begin)


def septic(
    start: ArrayLike,
    end: ArrayLike,
    duration: ArrayLike | None = None,
    *,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    jerk: ArrayLike | None = None,
    begin: ArrayLike = 0.0,
) -> Law:
    """Law from rest to rest by a polynomial of degree seven: the jerk too is zero at both ends.

    Args:
        start: Value before, () [m, rad].
        end: Value afterwards, () [m, rad].
        duration: How long it takes, () [s]. Give this, or one or more of the limits: then it is the shortest
            that keeps them.
        velocity: Largest velocity, () [1/s].
        acceleration: Largest acceleration, () [1/s^2].
        jerk: Largest rate of the acceleration, () [1/s^3].
        begin: When it begins, () [s].

    Returns:
        Law.

    Raises:
        TypeError, ValueError: What is no number, is not positive, or neither a duration nor a limit.

    Source:
        THEORY.md 14, eq. (14.10).
    """
    return _rise(7, start, end, duration, (velocity, acceleration, jerk), begin)


def scurve(
    start: ArrayLike,
    end: ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    jerk: ArrayLike,
    begin: ArrayLike = 0.0,
) -> Law:
    """Shortest law from rest to rest within limits of velocity, acceleration and jerk: the S-curve of seven phases.

    Where the way is too short to reach a limit, the phases that would hold it have no length.

    Args:
        start: Value before, () [m, rad].
        end: Value afterwards, () [m, rad].
        velocity: Largest velocity, () [1/s].
        acceleration: Largest acceleration, () [1/s^2].
        jerk: Largest rate of the acceleration, () [1/s^3].
        begin: When it begins, () [s].

    Returns:
        Law.

    Raises:
        TypeError, ValueError: What is no number, or a limit that is not positive.

    Source:
        THEORY.md 14, eq. (14.11).
    """
    for name, value in (("start", start), ("end", end), ("begin", begin)):
        check_number(name, value)
    for name, value in (("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)):
        check_number(name, value, above=0)
    xp: Any = np if is_concrete((start, end, velocity, acceleration, jerk, begin)) else jnp
    own: Any = [xp.asarray(one, float) for one in (start, end, velocity, acceleration, jerk)]
    x, last, v, a, j = own
    way = last - x
    far = _positive(xp, xp.abs(way))
    # The acceleration that the velocity and the way allow to reach, and then the velocity that the way does.
    a = xp.minimum(xp.minimum(a, xp.sqrt(v * j)), xp.cbrt(far * j**2 / 2))
    v = xp.minimum(v, a * (xp.sqrt(a**2 / j**2 / 4 + far / a) - a / j / 2))
    rising, steady = a / j, xp.maximum(v / a - a / j, 0.0)
    cruise = xp.maximum(far / v - (2 * rising + steady), 0.0)
    lengths = xp.stack([rising, steady, rising, cruise, rising, steady, rising])
    at, pieces = [x, xp.zeros(()), xp.zeros(())], []
    for sign, length in zip(JERKS, lengths, strict=True):
        third = sign * j * xp.sign(way)
        x, xd, xdd = at
        pieces.append(xp.stack([x, xd, xdd / 2, third / 6]))
        at = [
            x + length * (xd + length * (xdd / 2 + length * third / 6)),
            xd + length * (xdd + length * third / 2),
            xdd + length * third,
        ]
    breaks = xp.asarray(begin, float) + xp.concatenate([xp.zeros(1), xp.cumsum(lengths)])
    return Law(jnp.asarray(breaks), jnp.asarray(xp.stack(pieces)))


def spline(times: ArrayLike, points: ArrayLike, *, degree: int = 5) -> Law:
    """Law through points at given times, from rest to rest, with as many continuous derivatives as its degree allows.

    Args:
        times: When, ascending, two or more concrete numbers, (n,) [s].
        points: Where; differentiable, (n,) [m, rad].
        degree: 3, continuous to the acceleration, with no velocity at the ends, or 5, continuous to the fourth
            derivative, with no acceleration there either.

    Returns:
        Law.

    Raises:
        TypeError, ValueError: Times that do not ascend, another number of points, another degree.

    Source:
        ``scipy.interpolate.make_interp_spline``.
    """
    if degree not in (3, 5):
        raise ValueError(f"Argument `degree` must be 3 or 5, but is {shown(degree)}.")
    rest = range(1, (degree + 1) // 2)
    return _through(times, points, degree, lambda count: [(order, np.zeros(count)) for order in rest])


def sampled(times: ArrayLike, values: ArrayLike, *, degree: int = 5) -> Law:
    """Law through samples of a motion that is known, such as one that was measured.

    Args:
        times: When, ascending, concrete numbers, more than the degree, (n,) [s].
        values: The samples; differentiable, (n,) [m, rad].
        degree: Of the spline through them, 3 to 7; nothing is said of its ends. A motion needs 3 at least.

    Returns:
        Law, at rest beyond its ends, where its velocity jumps unless the samples end at rest.

    Raises:
        TypeError, ValueError: Times that do not ascend, another number of values, too few, another degree.

    Source:
        ``scipy.interpolate.make_interp_spline``.
    """
    check_whole("degree", degree, 3, 7)
    if degree % 2 == 0:
        raise ValueError(f"Argument `degree` must be 3, 5 or 7, but is {degree}.")
    if np.ndim(times) == 1 and np.shape(times)[0] <= degree:
        raise ValueError(f"Argument `times` must have more than {degree} times for a spline of that degree.")
    return _through(times, values, degree, lambda count: None)


def stretched(
    law: Law,
    *,
    velocity: float | None = None,
    acceleration: float | None = None,
    jerk: float | None = None,
) -> Law:
    """The same law over the shortest time that keeps limits, such as a spline whose way is known and not its time.

    Args:
        law: Law, of concrete breaks; of its coefficients derivatives are taken.
        velocity: Largest velocity [1/s].
        acceleration: Largest acceleration [1/s^2].
        jerk: Largest rate of the acceleration [1/s^3].

    Returns:
        Law that begins at the same time.

    Raises:
        TypeError: It is no Law of pieces, or ``jax.jit`` traces it.
        ValueError: No limit is given, or one that is not positive; or the law does not move.

    Source:
        A time longer by c divides the k-th derivative by c^k.
    """
    if not isinstance(law, Law):
        raise TypeError(f"fm.trajectory.stretched takes a Law as fm.trajectory.spline gives it, not {shown(law)}.")
    limits = _limits((velocity, acceleration, jerk))
    peaks = _peaks(law)
    if is_concrete(law) and not float(np.asarray(peaks[0])) > 0:
        raise ValueError("Argument `law` does not move: no time is the shortest.")
    factors = [(peaks[k] / limit) ** (1 / (k + 1)) for k, limit in enumerate(limits) if limit is not None]
    factor = jnp.max(jnp.stack(factors))
    powers = jnp.arange(float(law.coefficients.shape[1]))
    breaks = law.breaks[0] + factor * (law.breaks - law.breaks[0])
    return Law(breaks, law.coefficients / (factor**powers)[None])


def zv(law: Callable, frequency: ArrayLike, damping: ArrayLike = 0.0) -> Shaped:
    """Law in two steps, half a period of a vibration apart, which leaves none of it behind.

    Args:
        law: Law to be shaped, a function of time.
        frequency: Undamped frequency of the vibration, () [Hz].
        damping: Its damping ratio, below 1, () [-].

    Returns:
        Function of time, which ends half a damped period later than ``law``; unlike :class:`Law` it knows no duration.

    Raises:
        TypeError, ValueError: No function; a frequency that is not positive, a ratio that is negative or not below 1.

    Source:
        Singer, Seering (1990), as THEORY.md 14, eq. (14.12).
    """
    return _shaped(law, frequency, damping, lambda k: [1 / (1 + k), k / (1 + k)])


def zvd(law: Callable, frequency: ArrayLike, damping: ArrayLike = 0.0) -> Shaped:
    """As :func:`zv`, in three steps: what an error of the frequency leaves is of second order in the error.

    Args:
        law: Law to be shaped, a function of time.
        frequency: Undamped frequency of the vibration, () [Hz].
        damping: Its damping ratio, below 1, () [-].

    Returns:
        Function of time, which ends a damped period later than ``law``; unlike :class:`Law` it knows no duration.

    Raises:
        TypeError, ValueError: No function; a frequency that is not positive, a ratio that is negative or not below 1.

    Source:
        Singer, Seering (1990), as THEORY.md 14, eq. (14.12).
    """
    return _shaped(law, frequency, damping, lambda k: [1 / (1 + k) ** 2, 2 * k / (1 + k) ** 2, k**2 / (1 + k) ** 2])


def as_law(what: str, law: Any) -> Callable[..., Any]:
    """A function of time as it is now, which gives one number.

    Raises:
        TypeError: It is no function that ``jax.numpy`` can compute.
        ValueError: It does not give one number.
    """
    if not callable(law):
        raise TypeError(
            f"{what} must be a function of time, such as fm.trajectory.quintic(0.0, 0.01, 0.5), not {shown(law)}."
        )
    try:
        taken, shape = of_time(law)
    except Exception as fault:
        first = first_line(fault)
        raise TypeError(f"{what} cannot be computed as a function of time, by jax.numpy: {first}") from fault
    if shape != ():
        raise ValueError(f"{what} must give one number, but gives shape {shape}.")
    return taken


def _positive(xp: Any, number: Any) -> Any:
    """A number that is not negative, kept from zero, where roots have no derivative."""
    return xp.where(number > 0, number, 1e-300)


def _limits(given: Sequence[Any]) -> list[Any]:
    """Limits of velocity, acceleration and jerk, of which there is one at least."""
    for name, value in zip(WORDS[1:], given, strict=True):
        if value is not None:
            check_number(name, value, above=0)
    if all(value is None for value in given):
        raise ValueError("Give a limit: `velocity`, `acceleration` or `jerk`.")
    return list(given)


def _rise(degree: int, start: Any, end: Any, duration: Any, limits: Sequence[Any], begin: Any) -> Law:
    """A move by one polynomial."""
    for name, value in (("start", start), ("end", end), ("begin", begin)):
        check_number(name, value)
    xp: Any = np if is_concrete((start, end, duration, limits, begin)) else jnp
    start, end, begin = (xp.asarray(one, float) for one in (start, end, begin))
    way = end - start
    if duration is not None:
        if any(limit is not None for limit in limits):
            raise ValueError("Give `duration`, or the limits that it shall be found from, not both.")
        check_number("duration", duration, above=0)
        duration = xp.asarray(duration, float)
    else:
        if all(limit is None for limit in limits):
            raise ValueError("Give `duration`, or a limit to find it from: `velocity`, `acceleration` or `jerk`.")
        # Where it goes nowhere, any time serves: it stays.
        far = xp.where(way == 0, 1.0, xp.abs(way))
        needed = [
            (peak * far / limit) ** (1 / (k + 1))
            for k, (peak, limit) in enumerate(zip(PEAKS[degree], _limits(limits), strict=True))
            if limit is not None
        ]
        duration = xp.max(xp.stack(needed))
    coefficients = [start, *(way * rise / duration**k for k, rise in enumerate(RISES[degree]) if k)]
    breaks = begin + xp.stack([xp.zeros(()), duration])
    # jnp.asarray compiles a program for each shape.
    as_array = jax.device_put if xp is np else jnp.asarray
    return Law(as_array(breaks), as_array(xp.stack(coefficients)[None]))


def _through(times: ArrayLike, values: ArrayLike, degree: int, ends: Callable[[int], Any]) -> Law:
    """A spline, whose coefficients are linear in the values."""
    import scipy.interpolate

    if not is_concrete(times):
        raise TypeError("Argument `times` must be concrete numbers: derivatives are taken by the values.")
    known = checked_times(times)
    check_numbers("The values at the times", values)
    values = jnp.asarray(values, float)
    if values.shape != known.shape:
        raise ValueError(f"There must be one value for each of the {len(known)} times, but they have {values.shape}.")
    # The coefficients are linear in the values, of which derivatives are taken where they are traced.
    concrete = is_concrete(values)
    columns = np.asarray(values)[:, None] if concrete else np.eye(len(known))
    bounds = ends(columns.shape[1])
    fitted = scipy.interpolate.make_interp_spline(
        known, columns, k=degree, bc_type=None if bounds is None else (bounds, bounds)
    )
    breaks = np.unique(np.clip(fitted.t, known[0], known[-1]))
    orders = range(degree + 1)
    matrix = np.stack([fitted(breaks[:-1], nu=order) / math.factorial(order) for order in orders], axis=1)
    return Law(jnp.asarray(breaks), jnp.asarray(matrix[:, :, 0] if concrete else jnp.asarray(matrix) @ values))


def _peaks(law: Law) -> Float[Array, "3"]:
    """Largest velocity, acceleration and jerk; where they are is found by concrete numbers."""
    if not is_concrete(law.breaks):
        raise TypeError("The peaks of a law are found from concrete times.")
    xp: Any = np if is_concrete(law) else jnp
    # Of concrete numbers by NumPy, for which nothing is compiled.
    exact = np.asarray(law.coefficients) if xp is np else law.coefficients
    known = exact if xp is np else jax.lax.stop_gradient(exact)
    if not is_concrete(known):
        raise TypeError("The peaks of a law are found from concrete numbers: jax.jit must not trace its coefficients.")
    coefficients = np.asarray(known)
    lengths, found = np.diff(np.asarray(law.breaks)), []
    for order in (1, 2, 3):
        values = [xp.zeros(())]
        for i, length in enumerate(lengths):
            own = np.polynomial.Polynomial(coefficients[i]).deriv(order)
            roots = own.deriv().roots() if own.degree() > 1 else np.zeros(0)
            roots = roots[np.abs(roots.imag) < 1e-9 * length].real
            places = np.concatenate([[0.0, length], roots[(roots > 0) & (roots < length)]])
            powers = np.arange(order, coefficients.shape[1])
            factor = np.array([math.perm(int(p), order) for p in powers], float)
            rows = places[:, None] ** (powers - order) * factor
            values.append(xp.max(xp.abs(rows @ exact[i, order:])))
        found.append(xp.max(xp.stack(values)))
    return xp.stack(found)


def _shaped(law: Any, frequency: ArrayLike, damping: ArrayLike, shares: Callable[..., Any]) -> Shaped:
    taken = as_law("Argument `law`", law)
    check_number("frequency", frequency, above=0)
    check_number("damping", damping, least=0)
    if is_concrete(damping) and not float(np.asarray(damping)) < 1:
        raise ValueError(f"Argument `damping` must be below 1, where something vibrates, but is {shown(damping)}.")
    xp: Any = np if is_concrete((frequency, damping)) else jnp
    ratio = xp.asarray(damping, float)
    root = xp.sqrt(1 - ratio**2)
    parts = xp.stack(shares(xp.exp(-np.pi * ratio / root)))
    half = 1 / (2 * xp.asarray(frequency, float) * root)
    return Shaped(taken, jnp.asarray(parts), jnp.asarray(half * xp.arange(float(len(parts)))))
