"""Laws of motion over time: from rest to rest, through points, through samples, and shaped to leave no vibration.

A law is a function f(t) of one number, differentiable by time and by its own numbers. Before its start it has its first
value, after its end its last value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import as_reals, check_number, check_numbers, check_whole, checked_times, is_concrete, short_repr
from ..compilation.program import captured_of_time
from ..compilation.record import Record
from ..display import Result, Summary, short
from ..errors import first_line

# Peaks of velocity, acceleration and jerk for a unit move in one second.
PEAKS = {5: (15 / 8, 10 / math.sqrt(3), 60.0), 7: (35 / 16, 84 / (5 * math.sqrt(5)), 52.5)}
# Coefficients of the polynomials 10 s^3 - 15 s^4 + 6 s^5 and 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7, of ascending power.
RISES = {5: (0, 0, 0, 10, -15, 6), 7: (0, 0, 0, 0, 35, -84, 70, -20)}
# Signs of the jerk in the seven phases of an S-curve.
JERKS = (1, 0, -1, 0, -1, 0, 1)
WORDS = ("value", "velocity", "acceleration", "jerk")


class Law(Result, Record):
    """Function of time in pieces. Each piece is a polynomial of the time since its start.

    Attributes:
        breaks: Start of each piece, and end of the last piece, ascending, (n + 1,) [s].
        coefficients: Coefficients of each piece, by ascending power of time, (n, degree + 1) [m/s^k, rad/s^k].
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
        # Concrete numbers are evaluated by NumPy, without compiling.
        xp: Any = np if is_concrete((self, t)) else jnp
        breaks, coefficients, t = (xp.asarray(array, float) for array in (self.breaks, self.coefficients, t))
        piece = xp.clip(xp.searchsorted(breaks, t, side="right") - 1, 0, coefficients.shape[0] - 1)
        # At the ends, the pieces determine the derivatives. Beyond the ends there is no motion.
        beyond = xp.where(t < breaks[0], breaks[0], breaks[-1])
        inside = (t >= breaks[0]) & (t <= breaks[-1])
        since = xp.where(inside, t, beyond) - breaks[piece]
        return jnp.asarray(xp.polyval(coefficients[piece, ::-1], since))

    @property
    def shape_of_value(self) -> tuple[int, ...]:
        """Shape of a value: the shape of the coefficients of one power."""
        return np.shape(self.coefficients)[2:]

    @property
    def duration(self) -> Float[Array, ""]:
        """Time from start to end, () [s]."""
        return self.breaks[-1] - self.breaks[0]

    def peaks(self) -> tuple[float, float, float]:
        """Return the largest absolute velocity, acceleration and jerk [1/s, 1/s^2, 1/s^3]; needs concrete numbers."""
        return tuple(np.asarray(_peaks(self)).tolist())

    def summary(self) -> Summary:
        """Return first and last value, times and peaks."""
        ends, peaks = [float(self(t)) for t in np.asarray(self.breaks)[[0, -1]]], self.peaks()
        rows = {"time": f"{short(self.breaks[0])} to {short(self.breaks[-1])} s", "pieces": str(len(self.breaks) - 1)}
        rows |= {f"largest {word}": short(peak) for word, peak in zip(WORDS[1:], peaks, strict=True)}
        return Summary(f"Law of time: {short(ends[0])} to {short(ends[1])}", rows)


class Shaped(Record):
    """A law split into parts that follow each other.

    Attributes:
        law: The law.
        shares: Share of each part, (n,) [-].
        delays: Delay of each part, (n,) [s].
    """

    law: Callable[..., Any]
    shares: Float[Array, "n"]
    delays: Float[Array, "n"]

    def __call__(self, t: Float[ArrayLike, ""]) -> Float[Array, ""]:
        """Value at a time."""
        parts = [self.shares[i] * self.law(t - self.delays[i]) for i in range(self.shares.shape[0])]
        return jnp.sum(jnp.stack(parts))


def rates(law: Callable, t: Float[ArrayLike, ""]) -> tuple[Any, Any, Any]:
    """Return value, velocity and acceleration of a law.

    Args:
        law: Function of time in ``jax.numpy``.
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
    """Return a law from rest to rest: a polynomial of degree five, with zero velocity and acceleration at both ends.

    Args:
        start: Value before, () [m, rad].
        end: Value afterwards, () [m, rad].
        duration: Duration, () [s]. Give it, or one or more limits: then the shortest duration within them is taken.
        velocity: Largest velocity, () [1/s].
        acceleration: Largest acceleration, () [1/s^2].
        jerk: Largest rate of the acceleration, () [1/s^3].
        begin: When it begins, () [s].

    Returns:
        Law.

    Raises:
        TypeError, ValueError: A number is missing or not positive, or neither duration nor limit is given.

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
    """Return a law from rest to rest: a polynomial of degree seven. The jerk is also zero at both ends.

    Args:
        start: Value before, () [m, rad].
        end: Value afterwards, () [m, rad].
        duration: Duration, () [s]. Give it, or one or more limits: then the shortest duration within them is taken.
        velocity: Largest velocity, () [1/s].
        acceleration: Largest acceleration, () [1/s^2].
        jerk: Largest rate of the acceleration, () [1/s^3].
        begin: When it begins, () [s].

    Returns:
        Law.

    Raises:
        TypeError, ValueError: A number is missing or not positive, or neither duration nor limit is given.

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
    """Return the shortest law from rest to rest within limits of velocity, acceleration and jerk: an S-curve.

    The law has seven phases. If the way is too short to reach a limit, the phase at this limit has no length.

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
        TypeError, ValueError: An argument is no number, or a limit is not positive.

    Source:
        THEORY.md 14, eq. (14.11).
    """
    for name, value in (("start", start), ("end", end), ("begin", begin)):
        check_number(name, value)
    for name, value in (("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)):
        check_number(name, value, above=0)
    numbers = (start, end, velocity, acceleration, jerk)
    xp: Any = np if is_concrete((numbers, begin)) else jnp
    x, last, v, a, j = (xp.asarray(number, float) for number in numbers)
    way = last - x
    far = _positive(xp, xp.abs(way))
    # The acceleration that velocity limit and way permit, then the velocity that the way permits.
    a = xp.minimum(xp.minimum(a, xp.sqrt(v * j)), xp.cbrt(far * j**2 / 2))
    v = xp.minimum(v, a * (xp.sqrt(a**2 / j**2 / 4 + far / a) - a / j / 2))
    rising, steady = a / j, xp.maximum(v / a - a / j, 0.0)
    cruise = xp.maximum(far / v - (2 * rising + steady), 0.0)
    lengths = xp.stack([rising, steady, rising, cruise, rising, steady, rising])
    at, piece_coefficients = [x, xp.zeros(()), xp.zeros(())], []
    for sign, length in zip(JERKS, lengths, strict=True):
        third = sign * j * xp.sign(way)
        x, xd, xdd = at
        piece_coefficients.append(xp.stack([x, xd, xdd / 2, third / 6]))
        at = [
            x + length * (xd + length * (xdd / 2 + length * third / 6)),
            xd + length * (xdd + length * third / 2),
            xdd + length * third,
        ]
    breaks = xp.asarray(begin, float) + xp.concatenate([xp.zeros(1), xp.cumsum(lengths)])
    return Law(jnp.asarray(breaks), jnp.asarray(xp.stack(piece_coefficients)))


def spline(times: ArrayLike, points: ArrayLike, *, degree: int = 5) -> Law:
    """Return a law through points at given times, from rest to rest: a spline with degree - 1 continuous derivatives.

    Args:
        times: Two or more ascending concrete numbers, (n,) [s].
        points: Values at these times; differentiable, (n,) [m, rad].
        degree: 3: continuous acceleration, zero velocity at the ends. 5: continuous fourth derivative, zero velocity
            and acceleration at the ends.

    Returns:
        Law.

    Raises:
        TypeError, ValueError: Times do not ascend, the number of points differs, or the degree is neither 3 nor 5.

    Source:
        ``scipy.interpolate.make_interp_spline``.
    """
    if degree not in (3, 5):
        raise ValueError(f"Argument `degree` must be 3 or 5, but is {short_repr(degree)}.")
    return _through(times, points, degree, range(1, (degree + 1) // 2))


def sampled(times: ArrayLike, values: ArrayLike, *, degree: int = 5) -> Law:
    """Return a law through samples of a known motion, such as a measured motion.

    Args:
        times: Ascending concrete numbers, at least degree + 1, (n,) [s].
        values: Samples; differentiable, (n,) [m, rad].
        degree: Degree of the spline, 3, 5 or 7, without conditions at its ends.

    Returns:
        Law that is at rest outside its times. The velocity jumps at the ends unless the samples start and end at rest.

    Raises:
        TypeError, ValueError: Times do not ascend, the number of values differs or is too small, or the degree is not
            3, 5 or 7.

    Source:
        ``scipy.interpolate.make_interp_spline``.
    """
    check_whole("degree", degree, 3, 7)
    if degree % 2 == 0:
        raise ValueError(f"Argument `degree` must be 3, 5 or 7, but is {degree}.")
    if np.ndim(times) == 1 and np.shape(times)[0] <= degree:
        raise ValueError(f"Argument `times` must have more than {degree} times for a spline of that degree.")
    return _through(times, values, degree, ())


def stretched(
    law: Law, *, velocity: float | None = None, acceleration: float | None = None, jerk: float | None = None
) -> Law:
    """Return the same law over the shortest duration within limits, such as for a spline with known points.

    Args:
        law: Law with concrete breaks; differentiable in its coefficients.
        velocity: Largest velocity [1/s].
        acceleration: Largest acceleration [1/s^2].
        jerk: Largest rate of the acceleration [1/s^3].

    Returns:
        Law with the same start time.

    Raises:
        TypeError: The argument is no Law of pieces, or ``jax.jit`` traces it.
        ValueError: No limit is given, a limit is not positive, or the law does not move.

    Source:
        A duration c times as long divides the k-th derivative by c^k.
    """
    if not isinstance(law, Law):
        raise TypeError(
            f"fm.trajectory.stretched takes a Law, such as fm.trajectory.spline returns, not {short_repr(law)}."
        )
    limits = velocity, acceleration, jerk
    _check_limits(limits, "Give a limit: `velocity`, `acceleration` or `jerk`.")
    peaks = _peaks(law)
    if is_concrete(law) and not float(np.asarray(peaks[0])) > 0:
        raise ValueError("Argument `law` does not move, so it has no shortest duration.")
    factors = [(peaks[k] / limit) ** (1 / (k + 1)) for k, limit in enumerate(limits) if limit is not None]
    factor = jnp.max(jnp.stack(factors))
    powers = jnp.arange(float(law.coefficients.shape[1]))
    breaks = law.breaks[0] + factor * (law.breaks - law.breaks[0])
    return Law(breaks, law.coefficients / (factor**powers)[None])


def zv(law: Callable, frequency: ArrayLike, damping: ArrayLike = 0.0) -> Shaped:
    """Return a law in two steps, half a period of a vibration apart, so that none of the vibration remains.

    Args:
        law: Law to be shaped, a function of time.
        frequency: Undamped frequency of the vibration, () [Hz].
        damping: Its damping ratio, below 1, () [-].

    Returns:
        Function of time that ends half a damped period later than ``law``; it has no ``duration``.

    Raises:
        TypeError, ValueError: The law is no function, the frequency is not positive, or the ratio is not in [0, 1).

    Source:
        Singer, Seering (1990), as THEORY.md 14, eq. (14.12).
    """
    return _shaped(law, frequency, damping, lambda k: [1 / (1 + k), k / (1 + k)])


def zvd(law: Callable, frequency: ArrayLike, damping: ArrayLike = 0.0) -> Shaped:
    """Like :func:`zv`, in three steps. An error of the frequency leaves a vibration of second order in this error.

    Args:
        law: Law to be shaped, a function of time.
        frequency: Undamped frequency of the vibration, () [Hz].
        damping: Its damping ratio, below 1, () [-].

    Returns:
        Function of time that ends a damped period later than ``law``; it has no ``duration``.

    Raises:
        TypeError, ValueError: The law is no function, the frequency is not positive, or the ratio is not in [0, 1).

    Source:
        Singer, Seering (1990), as THEORY.md 14, eq. (14.12).
    """
    return _shaped(law, frequency, damping, lambda k: [1 / (1 + k) ** 2, 2 * k / (1 + k) ** 2, k**2 / (1 + k) ** 2])


def as_law(what: str, law: Any) -> Callable[..., Any]:
    """A function of time with its present numbers, which returns one number.

    Raises:
        TypeError: ``jax.numpy`` cannot compute it.
        ValueError: It does not return one number.
    """
    if not callable(law):
        raise TypeError(
            f"{what} must be a function of time, such as fm.trajectory.quintic(0.0, 0.01, 0.5), not {short_repr(law)}."
        )
    try:
        captured_law, shape = captured_of_time(law)
    except Exception as fault:
        first = first_line(fault)
        raise TypeError(f"{what} cannot be computed as a function of time, by jax.numpy: {first}") from fault
    if shape != ():
        raise ValueError(f"{what} must return one number, but returns shape {shape}.")
    return captured_law


def _positive(xp: Any, number: Any) -> Any:
    """A non-negative number, kept from zero, where roots have no derivative."""
    return xp.where(number > 0, number, 1e-300)


def _check_limits(limits: Sequence[Any], missing: str) -> None:
    """Check limits of velocity, acceleration and jerk, of which at least one is given."""
    if all(value is None for value in limits):
        raise ValueError(missing)
    for name, value in zip(WORDS[1:], limits, strict=True):
        if value is not None:
            check_number(name, value, above=0)


def _rise(degree: int, start: Any, end: Any, duration: Any, limits: Sequence[Any], begin: Any) -> Law:
    """A move by one polynomial."""
    for name, value in (("start", start), ("end", end), ("begin", begin)):
        check_number(name, value)
    xp: Any = np if is_concrete((start, end, duration, limits, begin)) else jnp
    start, end, begin = (xp.asarray(number, float) for number in (start, end, begin))
    way = end - start
    if duration is not None:
        if any(limit is not None for limit in limits):
            raise ValueError("Give `duration` or limits, not both.")
        check_number("duration", duration, above=0)
        duration = xp.asarray(duration, float)
    else:
        _check_limits(limits, "Give `duration`, or a limit: `velocity`, `acceleration` or `jerk`.")
        # A move by zero may take any time.
        far = xp.where(way == 0, 1.0, xp.abs(way))
        needed = [
            (peak * far / limit) ** (1 / (k + 1))
            for k, (peak, limit) in enumerate(zip(PEAKS[degree], limits, strict=True))
            if limit is not None
        ]
        duration = xp.max(xp.stack(needed))
    coefficients = [start, *(way * rise / duration**k for k, rise in enumerate(RISES[degree]) if k)]
    breaks = begin + xp.stack([xp.zeros(()), duration])
    # jnp.asarray compiles a program for each shape.
    as_array = jax.device_put if xp is np else jnp.asarray
    return Law(as_array(breaks), as_array(xp.stack(coefficients)[None]))


def _through(times: ArrayLike, values: ArrayLike, degree: int, still: Sequence[int]) -> Law:
    """A spline, whose coefficients are linear in the values; at its ends derivatives of some orders are zero."""
    import scipy.interpolate

    if not is_concrete(times):
        raise TypeError("Argument `times` must be concrete numbers; only the values are differentiable.")
    known = checked_times(times)
    check_numbers("The values at the times", values)
    values = jnp.asarray(values, float)
    if values.shape != known.shape:
        raise ValueError(f"There must be one value for each of the {len(known)} times, but they have {values.shape}.")
    # Coefficients are linear in the values: a matrix keeps traced values differentiable.
    concrete = is_concrete(values)
    columns = np.asarray(values)[:, None] if concrete else np.eye(len(known))
    bounds = [(order, np.zeros(columns.shape[1])) for order in still]
    bc_type = (bounds, bounds) if bounds else None
    fitted = scipy.interpolate.make_interp_spline(known, columns, k=degree, bc_type=bc_type)
    breaks = np.unique(np.clip(fitted.t, known[0], known[-1]))
    orders = range(degree + 1)
    matrix = np.stack([fitted(breaks[:-1], nu=order) / math.factorial(order) for order in orders], axis=1)
    return Law(jnp.asarray(breaks), jnp.asarray(matrix[:, :, 0] if concrete else jnp.asarray(matrix) @ values))


def _peaks(law: Law) -> Float[Array, "3"]:
    """Largest velocity, acceleration and jerk, at places found from concrete numbers."""
    if not is_concrete(law.breaks):
        raise TypeError("The peaks of a law are found from concrete times.")
    xp: Any = np if is_concrete(law) else jnp
    # Concrete numbers are evaluated by NumPy, without compiling.
    exact = np.asarray(law.coefficients) if xp is np else law.coefficients
    known = exact if xp is np else jax.lax.stop_gradient(exact)
    if not is_concrete(known):
        raise TypeError("The peaks of a law are found from concrete numbers: jax.jit must not trace its coefficients.")
    coefficients = np.asarray(known)
    lengths, peaks = np.diff(np.asarray(law.breaks)), []
    for order in (1, 2, 3):
        values = [xp.zeros(())]
        for i, length in enumerate(lengths):
            polynomial = np.polynomial.Polynomial(coefficients[i]).deriv(order)
            roots = polynomial.deriv().roots() if polynomial.degree() > 1 else np.zeros(0)
            roots = roots[np.abs(roots.imag) < 1e-9 * length].real
            places = np.concatenate([[0.0, length], roots[(roots > 0) & (roots < length)]])
            powers = np.arange(order, coefficients.shape[1])
            factor = np.array([math.perm(int(p), order) for p in powers], float)
            rows = places[:, None] ** (powers - order) * factor
            values.append(xp.max(xp.abs(rows @ exact[i, order:])))
        peaks.append(xp.max(xp.stack(values)))
    return xp.stack(peaks)


def _shaped(law: Any, frequency: ArrayLike, damping: ArrayLike, shares: Callable[..., Any]) -> Shaped:
    captured_law = as_law("Argument `law`", law)
    check_number("frequency", frequency, above=0)
    check_number("damping", damping, least=0)
    if is_concrete(damping) and not float(np.asarray(damping)) < 1:
        raise ValueError(
            f"Argument `damping` must be below 1, so that the motion vibrates, but is {short_repr(damping)}."
        )
    xp: Any = np if is_concrete((frequency, damping)) else jnp
    ratio = xp.asarray(damping, float)
    root = xp.sqrt(1 - ratio**2)
    parts = xp.stack(shares(xp.exp(-np.pi * ratio / root)))
    half = 1 / (2 * xp.asarray(frequency, float) * root)
    return Shaped(captured_law, jnp.asarray(parts), jnp.asarray(half * xp.arange(float(len(parts)))))
