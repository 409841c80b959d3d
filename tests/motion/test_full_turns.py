"""Rotations in space that are measured past a full turn are told, since what measures them jumps there."""

import dataclasses
import warnings

import control
import numpy as np
import pytest

import flexmb as fm
from flexmb import spatial
from flexmb.motion.full_turns import warn_of_full_turns

TIMES = np.linspace(0.0, 1.0, 11)


def rotor(speed, measured) -> fm.Builder:
    """A wheel on a hinge about an axis askew, that turns steadily."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.rotation("ground")
    b.fix("o", "x", "y", "z")
    b.fix("ground")
    b.add(spatial.hinge, "ground", "o", name="hinge", axis=tuple(axis))
    b.inertia("o", (1e-2, 0, 0, 1e-2, 0, 1e-2))
    b.start("hinge", 1, 0.0, speed)
    b.input("hinge", 1, name="torque")
    b.output(*measured, name="angle")
    return b


@pytest.mark.parametrize(("speed", "told"), [(6.2, False), (6.4, True), (40 * np.pi, True)])
def test_what_a_controller_measures_past_a_full_turn_is_told(speed, told):
    """The fastest comes round from one time to the next, where it is as it was."""
    model = rotor(speed, ("o", "rx")).build()
    idle = control.ss([], [], [], [[0.0]])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        fm.simulate(model, TIMES, control=idle)
    assert any("more than a full turn" in str(one.message) for one in said) is told


def test_what_is_counted_is_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fm.simulate(rotor(200.0, ("hinge", 1)).build(), TIMES, control=control.ss([], [], [], [[0.0]]))


def test_what_comes_after_a_failure_is_no_motion():
    """As where it was watched and failed: infinite."""
    found = fm.simulate(rotor(6.0, ("o", "rx")).build(), TIMES)
    left = np.arange(len(TIMES))[:, None] > 6
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_full_turns(dataclasses.replace(found, x=np.where(left, np.inf, found.x)))


def test_so_are_outputs_along_a_plan():
    with pytest.warns(fm.FlexmbWarning, match="What 'angle' measures turns by more than a full turn"):
        fm.trajectory.inverse_dynamics(rotor(0.0, ("o", "rx")).build(), {"hinge.e1": lambda t: 7.0 * t**2}, TIMES)
