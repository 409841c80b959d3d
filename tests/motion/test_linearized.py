"""Linearised equations about a steady rotation, against a spectral solution of the rotating beam."""

import jax.numpy as jnp
import numpy as np
import pytest
from cases import motions
from cases.tolerances import approx
from jax.tree_util import Partial

import flexmb as fm
from flexmb import planar


@pytest.mark.slow
def test_rotating_cantilever_stiffens():
    """REFERENCES C3: first lead-lag frequency; a linear beam on the hub would soften and diverge beyond 3.516."""
    model = motions.rotor().build()
    for speed, expected in ((0.0, 3.5160153), (2.0, 3.6217970), (6.0, 4.2632254)):
        angle = Partial(motions.turned, speed=jnp.array(speed))
        lin = fm.motion.steady_motion(model, {"hub.rotation.phi": angle})
        found = np.sort(np.abs(np.imag(fm.poles(lin))))
        # Printed digits; the strain by the rotation is 2e-8 at EA = 1e9.
        np.testing.assert_allclose(found[0], expected, rtol=1e-6)


@pytest.mark.slow
def test_a_steady_motion_leaves_incremental_loads_out_with_a_warning():
    b = motions.rotor(order=3)
    b.force("tip", (0.0, 1e-3), increment=True)
    angle = Partial(motions.turned, speed=jnp.array(0.0))
    with pytest.warns(fm.FlexmbWarning, match="fm.motion.steady_motion leaves out the incremental loads"):
        fm.motion.steady_motion(b.build(), {"hub.rotation.phi": angle})


@pytest.mark.slow
def test_pendulum_in_a_coordinate_that_is_not_its_angle():
    # A point of mass m on a rod of length 1, its place x the degree of freedom: m xdd/(1 - x^2) + m x xd^2/(1 - x^2)^2
    # + m g x/sqrt(1 - x^2) = 0 from Lagrange's equations; by hand, its derivatives by xd and by x.
    b = fm.Builder()
    b.node("hook", (0, 0))
    b.node("bob", (0, -1))
    b.fix("hook")
    b.add(planar.truss, "hook", "bob")
    b.add(planar.mass, "bob", mass=2.0)
    b.dof("bob", "x")
    b.start("bob", "x", 0.3, velocity=0.7)
    b.gravity((0, -9.81))
    motion = fm.simulate(b.build(), [0.0, 0.01])
    lin = fm.motion.linearize_motion(motion).at_time(0)
    x, v, left = 0.3, 0.7, 1 - 0.3**2
    a = -x * v**2 / left - 9.81 * x * np.sqrt(left)
    assert lin.M0[0, 0] == approx(2 / left, rel=1e-9)
    assert lin.C0[0, 0] == approx(4 * x * v / left**2, rel=1e-9)
    stiffness = 2 * (2 * x * a / left**2 + v**2 * (1 + 3 * x**2) / left**3 + 9.81 / left**1.5)
    assert (lin.K0 + lin.N0 + lin.G0)[0, 0] == approx(stiffness, rel=1e-9)


@pytest.mark.slow
def test_a_force_that_follows_a_bar_takes_no_stiffness_from_it():
    """J phi'' = 0: along its bar the force has no moment about the hinge, wherever the bar is."""
    b = fm.Builder()
    b.node("hinge", (0, 0))
    b.node("tip", (0.5, 0))
    b.add(planar.beam, "hinge", "tip")
    b.fix("hinge", "x", "y")
    b.mass("tip", 2.0)
    b.force("tip", (-4.0, 0.0), follower=True)
    b.dof("hinge", "phi")
    b.start("hinge", "phi", 0.3)
    lin = fm.motion.linearize_motion(fm.simulate(b.build(), [0.0, 0.01])).at_time(0)
    assert lin.M0[0, 0] == approx(0.5, rel=1e-12)
    assert (lin.K0 + lin.N0 + lin.G0)[0, 0] == approx(0.0, abs=1e-12)
