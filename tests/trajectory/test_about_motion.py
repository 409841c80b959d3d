"""Inputs along a motion: those that move what is held are what it does there, and outputs beside them are known."""

import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

TIMES = np.linspace(0.0, 1.0, 5)
ROUND_OFF = {"rtol": 1e-12, "atol": 1e-15}


def shaken(quantities=("displacement",), parts=False):
    """A mass between two walls that move along x, on springs; the force on it is an input too."""
    b = fm.Builder()
    for name, x in (("left", 0.0), ("mass", 1.0), ("right", 2.0)):
        b.node(name, (x, 0.0))
        b.fix(name, "y")
    b.add(planar.truss, "left", "mass", name="s", section=fm.Rigidity(EA=100.0))
    b.add(planar.truss, "mass", "right", name="t", section=fm.Rigidity(EA=100.0))
    b.prescribe("left", "x", 0.0)
    b.prescribe("right", "x", 0.0)
    b.mass("mass", 2.0)
    for quantity in quantities:
        b.input("left", "x", quantity, name=f"floor {quantity}")
    if parts:
        b.actuator("both", {"displacement left.x": 1.0, "displacement right.x": 2.0})
    b.input("mass", "x", name="coil")
    b.output("left", "x", "reaction", name="of the wall")
    return b.build()


def law(t):
    return 0.01 * t**3 + 0.002 * t


def test_an_input_that_moves_a_wall_is_what_the_wall_does():
    rates = {"displacement": law, "velocity": lambda t: 0.03 * t**2 + 0.002, "acceleration": lambda t: 0.06 * t}
    motion = fm.simulate(shaken(tuple(rates)), TIMES, motion={"left.x": law}, inputs={"coil": lambda t: 0.3 * t})
    along = fm.trajectory.time_varying(motion)
    wanted = np.stack([*(rate(TIMES) for rate in rates.values()), 0.3 * TIMES], axis=1)
    np.testing.assert_allclose(along.u0, wanted, **ROUND_OFF)
    # The wall has no mass: it holds the spring.
    np.testing.assert_allclose(along.y0[:, 0], -100.0 * motion.observe().e[:, 0], rtol=1e-9, atol=1e-12)


def test_walls_that_one_input_moves_together():
    model = shaken(parts=True)
    both = {"left.x": law, "right.x": lambda t: 2 * law(t)}
    along = fm.trajectory.time_varying(fm.simulate(model, TIMES, motion=both))
    np.testing.assert_allclose(along.u0[:, :2], np.stack([law(TIMES)] * 2, axis=1), **ROUND_OFF)
    alone = fm.simulate(model, TIMES, motion={"left.x": law})
    with pytest.warns(fm.FlexmbWarning, match="Input 'both' moves several held things together"):
        along = fm.trajectory.time_varying(alone)
    # Nearest to one that moves and, of twice the weight, one that stands still.
    np.testing.assert_allclose(along.u0[:, 1], law(TIMES) / 5, **ROUND_OFF)


def test_a_wall_that_stands_still_has_a_reaction():
    motion = fm.simulate(shaken(), TIMES, inputs={"coil": lambda t: jnp.sin(t)})
    along = fm.trajectory.time_varying(motion)
    np.testing.assert_allclose(along.u0[:, 0], 0.0, atol=1e-15)  # round-off
    assert np.all(np.isfinite(along.y0))
