"""Rotations in space that are measured past a full turn are told, since what measures them jumps there."""

import dataclasses
import warnings

import control
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import spatial
from flexmb.motion.full_turns import warn_of_full_turns

TIMES = np.linspace(0.0, 1.0, 11)


AXIS = (2 / 3, -1 / 3, 2 / 3)


def rotor(speed, measured, axis=AXIS) -> fm.Builder:
    """A wheel on a hinge, about an axis askew unless given, that turns steadily."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.rotation("ground")
    b.fix("o", "x", "y", "z")
    b.fix("ground")
    b.add(spatial.hinge, "ground", "o", name="hinge", axis=axis)
    b.inertia("o", (1e-2, 0, 0, 1e-2, 0, 1e-2))
    b.start("hinge", 1, 0.0, speed)
    b.input("hinge", 1, name="torque")
    b.output(*measured, name="angle")
    return b


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "told"), [(6.2, False), (6.4, True), (40 * np.pi, True)])
def test_what_a_controller_measures_past_a_full_turn_is_told(speed, told):
    """The fastest comes round from one time to the next, where it is as it was."""
    model = rotor(speed, ("o", "rx")).build()
    idle = control.ss([], [], [], [[0.0]])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        fm.simulate(model, TIMES, control=idle)
    assert any("passes a full turn" in str(one.message) for one in said) is told


@pytest.mark.slow
def test_what_is_counted_is_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fm.simulate(rotor(200.0, ("hinge", 1)).build(), TIMES, control=control.ss([], [], [], [[0.0]]))


@pytest.mark.slow
def test_what_comes_after_a_failure_is_no_motion():
    """As where it was watched and failed: infinite."""
    found = fm.simulate(rotor(6.0, ("o", "rx")).build(), TIMES)
    left = np.arange(len(TIMES))[:, None] > 6
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        broken = dataclasses.replace(found, x=np.where(left, np.inf, found.x))
        warn_of_full_turns(broken, found.model.parameters.reference)


@pytest.mark.slow(
    "<lambda>-measured0-True",
    "<lambda>-measured2-False",
    "<lambda>-measured3-False",
    "<lambda>-measured4-False",
    "<lambda>-measured1-False",
)
@pytest.mark.parametrize(
    ("law", "measured", "told"),
    [
        # It is the undeformed mechanism that a plan counts from, not where it begins.
        (lambda t: 5.0 + 3.0 * t, ("o", "rx"), True),
        (lambda t: -4.0 + 8.0 * t, ("o", "rx"), False),
        (lambda t: 5.0 + 3.0 * t, ("o", "rx", "velocity"), False),
        # Times in step with a motion to and fro.
        (lambda t: 0.2 * jnp.sin(20 * jnp.pi * t), ("o", "rx"), False),
        # About an axis that it does not turn about.
        (lambda t: 9.0 * t, ("o", "rx", "across"), False),
    ],
)
def test_what_jumps_along_a_plan_is_told_and_nothing_else(law, measured, told):
    across = measured[-1] == "across"
    model = rotor(0.0, measured[:2] if across else measured, (0.0, 0.0, 1.0) if across else AXIS).build()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = fm.trajectory.inverse_dynamics(model, {"hinge.e1": law}, TIMES)
    assert any("passes a full turn" in str(one.message) for one in said) is told
    if measured == ("o", "rx"):
        # What is measured is the law's share of the axis, but for a jump by two turns.
        expected = AXIS[0] * law(TIMES)
        assert np.allclose(found.y0[:, 0], expected, atol=1e-9) is not told


@pytest.mark.slow
def test_two_times_are_enough():
    model = rotor(0.0, ("o", "rx")).build()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fm.trajectory.inverse_dynamics(model, {"hinge.e1": lambda t: 12.0 * t - 6.0}, [0.0, 1.0])
    np.testing.assert_allclose(found.y0[:, 0], [-6 * AXIS[0], 6 * AXIS[0]], rtol=1e-12)


@pytest.mark.slow
def test_so_are_outputs_along_a_plan():
    with pytest.warns(fm.FlexmbWarning, match="Output 'angle' passes a full turn"):
        fm.trajectory.inverse_dynamics(rotor(0.0, ("o", "rx")).build(), {"hinge.e1": lambda t: 7.0 * t**2}, TIMES)
