"""Events that end a motion: those that pass within one step, and how they fail, by closed forms of free flight."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.compilation.program import captured
from flexmb.motion.events import EventCondition, Passing, as_it_is, check_at_start
from flexmb.motion.protocol import MotionState
from flexmb.results import RESULTS

SPEED, GRAVITY, PASSED = 3.0, 9.81, 0.001
APEX = SPEED**2 / (2 * GRAVITY)
# Of the way up and of the way down, which the time of a crossing 1 mm below the apex lies between.
UP, DOWN = (SPEED / GRAVITY + sign * np.sqrt(2 * PASSED / GRAVITY) for sign in (-1, 1))
AT_REST = MotionState(np.zeros(1), np.zeros(1), np.zeros(0))
BISECTION = optx.Bisection(rtol=1e-10, atol=1e-10)


def builder_of_mass():
    """A mass of 1 kg thrown up at 3 m/s towards a stop that it does not reach; the extent is 1 m."""
    b = fm.Builder()
    b.node("ceiling", (0.0, 1.0))
    b.node("mass", (0.0, 0.0))
    b.fix("ceiling")
    b.fix("mass", "x")
    b.add(planar.spring_damper(lambda e, ed: 1e4 * jnp.minimum(e + 0.9, 0.0)), "mass", "ceiling")
    b.mass("mass", 1.0)
    b.gravity((0.0, -GRAVITY))
    b.dof("mass", "y")
    b.start("mass", "y", 0.0, velocity=SPEED)
    return b


@pytest.fixture(scope="module")
def mass():
    return builder_of_mass().build()


def height(t, y, args, **_):
    return y.u[0] - (APEX - PASSED)


def last(mass, event, **how):
    """Time of the last state that the motion has reached, looked at in 2000 places of 1 s."""
    found = fm.simulate(mass, np.linspace(0, 1, 2001), event=event, **how)
    return found.t[np.isfinite(np.asarray(found.x)).all(axis=1)][-1]


@pytest.mark.slow
@pytest.mark.parametrize(("direction", "instant"), [(None, UP), (True, UP), (False, DOWN)])
def test_a_crossing_and_its_return_within_one_step_are_seen(mass, direction, instant):
    # Of a free flight any step is exact, so that it spans both crossings.
    event = diffrax.Event(height, BISECTION, direction)
    assert last(mass, event) == approx(instant, abs=6e-4)


@pytest.mark.slow
def test_a_condition_that_holds_within_one_step_alone_ends_the_motion_while_it_holds(mass):
    event = diffrax.Event(lambda t, y, args, **_: height(t, y, args) > 0)
    assert UP < last(mass, event) < DOWN


@pytest.mark.slow
def test_of_two_conditions_within_one_step_the_first_in_time_ends_the_motion(mass):
    both = {"way down": height, "past": lambda t, y, args, **_: t > 0.9}
    event = diffrax.Event(both, optx.Newton(rtol=1e-8, atol=1e-8), {"way down": False, "past": None})
    assert last(mass, event) == approx(DOWN, abs=6e-4)


@pytest.mark.slow
def test_steps_are_shortened_where_their_ends_do_not_tell_which_event_comes_first():
    def wave(t, y):
        return (t - 0.3) * (t - 0.7)

    def later(t, y):
        return t - 0.8

    # Conditions with the way each counts, and whether the step from 0 to 1 s is to be shorter.
    cases = [
        ([(later, None)], False),
        ([(later, True)], False),
        ([(later, False)], False),
        ([(wave, None)], True),
        ([(wave, True)], True),
        ([(wave, False)], True),
        ([(lambda t, y: (t > 0.3) & (t < 0.7), None)], True),
        ([(lambda t, y: t > 0.3, None)], False),
        ([(lambda t, y: t > 0.3, None), (later, True)], True),
        ([(lambda t, y: t < 0.3, None), (later, False)], False),
        ([(lambda t, y: -later(t, y), False), (later, False)], False),
    ]

    def passing(given):
        own = [(EventCondition(captured(one, 0.0, AT_REST)), way) for one, way in given]
        return Passing(tuple(one for one, _ in own), tuple(way for _, way in own))

    found = jax.jit(lambda: [passing(given).within((0.0, 1.0), (AT_REST, AT_REST), 1e-9) for given, _ in cases])()
    assert [bool(one) for one in found] == [expected for _, expected in cases]
    assert not passing(cases[3][0]).within((0.0, 1.0), (AT_REST, AT_REST), 0.1)


@pytest.mark.slow
def test_a_root_finder_that_fails_is_named(mass):
    event = diffrax.Event(height, optx.Newton(rtol=1e-14, atol=1e-300))
    with pytest.raises(fm.AnalysisError, match="root finder of `event` did not find its time"):
        fm.simulate(mass, np.linspace(0, 1, 5), event=event)
    found = fm.simulate(mass, np.linspace(0, 1, 5), event=event, throw=False)
    assert found.result == RESULTS.event_not_found


@pytest.mark.slow
def test_a_condition_that_leaves_zero_from_rest_is_told():
    b = fm.Builder()
    b.node("mass", (0.0, 0.0))
    b.fix("mass", "x")
    b.mass("mass", 1.0)
    b.gravity((0.0, -GRAVITY))
    for condition in (lambda t, y, args, **_: y.u[0], lambda t, y, args, **_: y.w[0]):
        with pytest.warns(fm.FlexmbWarning, match="condition of `event` is zero at the start"):
            fm.simulate(b.build(), np.linspace(0, 1, 3), event=diffrax.Event(condition))


def test_a_condition_that_is_zero_at_the_start_is_told():
    with pytest.warns(fm.FlexmbWarning, match="condition of `event` is zero at the start"):
        check_at_start(as_it_is(diffrax.Event(height), 0.0, AT_REST), [0.0], [1e-6], 0.0)
    # It falls through zero where it comes back; what stays zero, as beyond a limit, ends nothing yet, nor what falls.
    check_at_start(as_it_is(diffrax.Event(height, direction=False), 0.0, AT_REST), [0.0], [1e-6], 0.0)
    check_at_start(as_it_is(diffrax.Event(height), 0.0, AT_REST), [0.0], [0.0], 0.0)
    check_at_start(as_it_is(diffrax.Event(height, direction=True), 0.0, AT_REST), [0.0], [-1e-6], 0.0)


@pytest.mark.slow
def test_a_motion_that_an_event_ends_has_derivatives_until_then():
    """A mass on a spring let go at 0.2 m, stopped where it passes its place of rest; by how heavy it is."""

    def early(mass):
        b = fm.Builder()
        b.node("wall", (0.0, 0.0))
        b.node("mass", (1.0, 0.0))
        b.fix("wall")
        b.fix("mass", "y")
        b.add(planar.truss, "wall", "mass", section=fm.Rigidity(EA=40.0))
        b.mass("mass", mass)
        b.start("mass", "x", 0.2)
        event = diffrax.Event(lambda t, y, args, **more: y.u[0])
        motion = fm.simulate(b.build(), np.linspace(0.0, 0.3, 4), event=event, rtol=1e-8)
        return motion.at("mass")[1, 0]

    angle = 0.1 * np.sqrt(40.0)
    expected = 0.2 * np.sin(angle) * angle / 2
    # A hundred times the tolerance.
    np.testing.assert_allclose(jax.jit(jax.grad(early))(1.0), expected, rtol=1e-6)
    np.testing.assert_allclose(jax.grad(early)(1.0), expected, rtol=1e-6)


@pytest.mark.slow
def test_a_sampled_controller_is_compiled_for_times_that_are_known():
    held = fm.motion.Sampled(lambda t, z, y: (jnp.array([5.0]) - 2.0 * y, z), 0.05)
    b = builder_of_mass()
    b.input("mass", "y", name="push")
    b.output("mass", "y", name="height")
    pushed = b.build()

    def height(share):
        found = fm.simulate(pushed, [0.0, 0.1, 0.2], control=held, inputs={"push": lambda t: share})
        return found.at("mass")[-1, 1]

    np.testing.assert_allclose(jax.jit(height)(1.0), height(1.0), rtol=1e-12)
    with pytest.raises(TypeError, match="concrete times"):
        jax.jit(lambda times: fm.simulate(pushed, times, control=held).x)(np.array([0.0, 0.1]))
