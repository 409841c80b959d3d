"""Laws of time against their closed forms, and shapers against the vibration that they are to leave out."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb.trajectory.laws import Law, as_law

law = fm.trajectory


def derivatives(f, t):
    """Value, velocity, acceleration and jerk at many times."""
    return [np.asarray(found) for found in _derivatives(f, jnp.asarray(t))]


@jax.jit
def _derivatives(f, t):
    found = [f]
    for _ in range(3):
        found.append(lambda t, f=found[-1]: jax.jvp(f, (t,), (jnp.ones_like(t),))[1])
    return [jax.vmap(f)(t) for f in found]


@pytest.mark.parametrize(
    ("make", "peaks"), [(law.quintic, (1.875, 5.7735027, 60)), (law.septic, (2.1875, 7.5131884, 52.5))]
)
def test_polynomials_have_their_limits(make, peaks):
    """D = 2 and T = 0.5: peaks times 2/0.5^k, and each limit gives the time back; 1e-7 as the peaks are printed."""
    found = make(-1.0, 1.0, 0.5, begin=0.1)
    expected = [peak * 2 / 0.5 ** (k + 1) for k, peak in enumerate(peaks)]
    np.testing.assert_allclose(found.peaks(), expected, rtol=1e-7)
    value, *rates = derivatives(found, [0.0, 0.1, 0.35, 0.6, 0.7])
    np.testing.assert_allclose(value, [-1, -1, 0, 1, 1], rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.array(rates[:2])[:, [0, 1, 3, 4]], 0.0, rtol=0, atol=1e-12 * 60)
    for name, limit in zip(("velocity", "acceleration", "jerk"), expected, strict=True):
        assert float(make(-1.0, 1.0, **{name: limit}).duration) == approx(0.5, rel=1e-7)


@pytest.mark.slow("10.0-limits0-5.75", "10.0-limits1-5.707106781186548")
@pytest.mark.parametrize(
    ("way", "limits", "duration"),
    [
        # All seven phases: D/V + V/A + A/J.
        (10.0, (2.0, 4.0, 16.0), 5 + 0.5 + 0.25),
        # No acceleration is held: V = 2 < A²/J, and twice 2 sqrt(V/J) with the cruise between them.
        (10.0, (2.0, 8.0, 16.0), 10 / 2 + 2 * np.sqrt(2 / 16)),
        # No cruise: A is reached, V is not; twice a/J and the quadratic of the way.
        (1.0, (9.0, 2.0, 16.0), 2 * (0.125 / 2 + np.sqrt(0.125**2 / 4 + 1 / 2))),
        # Neither: four phases of the cube root.
        (1.0, (9.0, 90.0, 16.0), 4 * np.cbrt(1 / (2 * 16))),
    ],
)
def test_scurve_takes_the_shortest_time(way, limits, duration):
    v, a, j = limits
    for sign in (1.0, -1.0):
        found = law.scurve(0.3, 0.3 + sign * way, velocity=v, acceleration=a, jerk=j, begin=1.0)
        assert float(found.duration) == approx(duration, rel=1e-12)
        t = np.linspace(1.0, 1.0 + duration, 801)[1:-1]
        value, *rates = derivatives(found, t)
        for rate, limit in zip(rates, limits, strict=True):
            assert np.max(np.abs(rate)) <= limit * (1 + 1e-12)
        end = derivatives(found, [1.0 + duration])
        np.testing.assert_allclose([end[0][0], end[1][0]], [0.3 + sign * way, 0.0], rtol=0, atol=1e-12 * way)
        np.testing.assert_allclose(value + value[::-1], 0.6 + sign * way, rtol=0, atol=1e-12 * way)


def test_splines_pass_through_points_and_have_derivatives():
    """A polynomial of degree five is its own spline; from rest to rest it is the quintic."""
    t = np.array([0.0, 0.2, 0.3, 0.7, 0.8, 1.0])
    found = law.sampled(t, t**5 - t)
    np.testing.assert_allclose(derivatives(found, [0.55])[2], 20 * 0.55**3, rtol=1e-11)
    both = law.spline([0.0, 1.0], [2.0, 3.0])
    np.testing.assert_allclose(both(0.3), law.quintic(2.0, 3.0, 1.0)(0.3), rtol=1e-14)
    slow = law.stretched(law.spline([0, 1, 2.5], [0, 1, 0.5]), velocity=0.5, jerk=100.0)
    assert slow.peaks()[0] == approx(0.5, rel=1e-12)
    # Within a trace too, of what is known.
    limited = fm.jit(lambda limit: law.stretched(both, velocity=1.5 * limit)(2.0))
    assert float(limited(1.0)) == approx(3.0, rel=1e-12)
    with pytest.raises(TypeError, match=r"jax\.jit must not trace its coefficients"):
        jax.eval_shape(lambda c: law.stretched(Law(both.breaks, c), velocity=1.0).coefficients, both.coefficients)

    @jax.jit
    def middle(point):
        return law.spline([0.0, 1.0, 2.5], jnp.stack([0.0 * point, point, 0.5 + 0.0 * point]))(1.6)

    step = 1e-3
    difference = (middle(1 + step) - middle(1 - step)) / (2 * step)
    for derivative in (jax.jacfwd, jax.grad):
        # Linear in the point: round-off over the step is left.
        assert float(jax.jit(derivative(middle))(1.0)) == approx(float(difference), rel=1e-11)


@pytest.mark.parametrize(("shaper", "order"), [(law.zv, 1), (law.zvd, 2)])
def test_shapers_leave_no_vibration(shaper, order):
    """q'' + 2 ζ ω q' + ω² q = ω² p after p has ended: integral of exp((ζ + i √(1 - ζ²)) ω t) p' over the law is zero.

    Off its frequency by a share of 1e-3, a thousand times less by one order of the share.
    """
    frequency, ratio = 3.0, 0.05
    p = law.quintic(0.0, 1.0, 0.2)
    shaped = shaper(p, frequency, ratio)
    t = np.linspace(0, 0.7, 7001)
    velocity = derivatives(shaped, t)[1]
    # One of order zero moves all at once.
    left = []
    for off in (0.0, 1e-3):
        root = 2 * np.pi * frequency * (1 + off) * (ratio + 1j * np.sqrt(1 - ratio**2))
        left.append(abs(np.trapezoid(np.exp(root * t) * velocity, t)))
    assert left[0] < 1e-6
    assert 0.5e-3**order < left[1] / 2 < 2 * (1.6e-3) ** order
    assert float(shaped(0.7)) == approx(1.0, rel=1e-14)


def test_a_law_that_goes_nowhere_stays():
    law = fm.trajectory.quintic(0.3, 0.3, velocity=1.0)
    assert [float(of) for of in fm.trajectory.rates(law, 0.5)] == [0.3, 0.0, 0.0]


@pytest.mark.slow
def test_wrong_laws_are_refused():
    with pytest.raises(ValueError, match="not both"):
        law.quintic(0.0, 1.0, 1.0, velocity=1.0)
    with pytest.raises(ValueError, match="Give `duration`"):
        law.septic(0.0, 1.0)
    with pytest.raises(ValueError, match="`jerk` must be positive"):
        law.scurve(0.0, 1.0, velocity=1.0, acceleration=1.0, jerk=0.0)
    with pytest.raises(ValueError, match="without a time twice"):
        law.spline([0.0, 0.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="one value for each of the 3"):
        law.spline([0.0, 1.0, 2.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="`damping` must be below 1"):
        law.zv(lambda t: t, 1.0, 1.0)
    with pytest.raises(TypeError, match=r"function of time, such as fm\.trajectory"):
        law.zvd(3.0, 1.0)


def test_a_law_of_several_numbers_is_refused():
    law = Law(np.array([0.0, 1.0]), np.ones((1, 3, 2)))
    with pytest.raises(ValueError, match=r"'x' must return one number, but returns shape \(2,\)"):
        as_law("Trajectory 'x'", law)
