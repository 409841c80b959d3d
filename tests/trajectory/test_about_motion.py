"""Inputs along a motion: those that move what is held are what it does there, and outputs beside them are known."""

import warnings

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.trajectory.about_motion import about, outputs_of

TIMES = np.linspace(0.0, 1.0, 5)
ROUND_OFF = {"rtol": 1e-12, "atol": 1e-15}
RATES = {
    "displacement": lambda t: 0.01 * t**3 + 0.002 * t,
    "velocity": lambda t: 0.03 * t**2 + 0.002,
    "acceleration": lambda t: 0.06 * t,
}


def law(t):
    return RATES["displacement"](t)


def twice(t):
    return 2 * law(t)


def away(t):
    return 0.05 + 2 * law(t)


def push(t):
    return 0.3 * t


@pytest.fixture(scope="module")
def shaken():
    """A mass between two walls that move along x, on springs; the force on it is an input."""
    b = fm.Builder()
    for name, x in (("left", 0.0), ("mass", 1.0), ("right", 2.0)):
        b.node(name, (x, 0.0))
        b.fix(name, "y")
    b.add(planar.truss, "left", "mass", name="s", section=fm.Rigidity(EA=100.0))
    b.add(planar.truss, "mass", "right", name="t", section=fm.Rigidity(EA=100.0))
    b.prescribe("left", "x", 0.0)
    b.prescribe("right", "x", 0.0)
    b.dof("s", 1)
    b.mass("mass", 2.0)
    for quantity in RATES:
        b.input("left", "x", quantity, name=quantity)
    b.actuator("both", {"displacement left.x": 1.0, "displacement right.x": 2.0})
    b.actuator("held", {"acceleration left.y": 1.0, "acceleration right.y": 1.0})
    b.input("mass", "x", name="coil")
    b.output("left", "x", "reaction", name="of the wall")
    return b.build()


def along(model, right):
    motion = fm.simulate(model, TIMES, motion={"left.x": law, "right.x": right}, inputs={"coil": push})
    return motion, np.asarray(about(motion, "time_varying").u0)


@pytest.mark.slow
def test_an_input_that_moves_a_wall_is_what_the_wall_does(shaken):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion, u0 = along(shaken, twice)
    wanted = [*(rate(TIMES) for rate in RATES.values()), law(TIMES), 0 * TIMES, push(TIMES)]
    np.testing.assert_allclose(u0, np.stack(wanted, axis=1), **ROUND_OFF)
    # The wall has no mass: it holds the spring.
    np.testing.assert_allclose(outputs_of(motion)[:, 0], -100.0 * motion.observe().e[:, 0], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("right", "told"), [(away, False), (law, True)])
def test_walls_that_one_input_moves_do_so_together_but_for_a_constant_distance(shaken, right, told):
    expected = pytest.warns(fm.FlexmbWarning, match="Input 'both' moves several coordinates together")
    with expected if told else warnings.catch_warnings():
        if not told:
            warnings.simplefilter("error")
        u0 = along(shaken, right)[1]
    # What is nearest to one wall that moves as it says, and one that moves so twice as far.
    np.testing.assert_allclose(u0[:, 3], (law(TIMES) + 2 * right(TIMES)) / 5, **ROUND_OFF)
