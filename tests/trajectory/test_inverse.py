"""What drives a mechanism along a trajectory: closed forms, and the motion that comes of it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.mechanisms import planar_guide

import flexmb as fm
from flexmb import planar

TIMES = np.linspace(0, 0.05, 201)


def pendulum(length=0.8, mass=1.5):
    """A point mass on a massless arm, driven at its pivot; gravity along -y."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("tip", (length, 0))
    b.add(planar.beam, "pivot", "tip", name="arm")
    b.fix("pivot", "position")
    b.mass("tip", mass)
    b.gravity((0, -9.81))
    b.dof("pivot", "phi")
    b.input("pivot", "phi", name="torque")
    for component in ("x", "y"):
        b.output("tip", component)
        b.output("tip", component, quantity="acceleration")
    return b.build()


def test_torque_of_a_pendulum():
    """m l² φ'' + m g l cos φ, and the place and acceleration of its tip, to round-off."""
    law = fm.trajectory.quintic(0.0, 2.0, 0.05)
    found = fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, TIMES)
    phi, rate, second = jax.vmap(lambda t: _rates(law, t))(jnp.asarray(TIMES))
    torque = 1.5 * 0.8**2 * second + 1.5 * 9.81 * 0.8 * jnp.cos(phi)
    np.testing.assert_allclose(found.u0[:, 0], torque, rtol=0, atol=1e-12 * np.max(np.abs(torque)))
    x = 0.8 * (jnp.cos(phi) - 1)
    a = 0.8 * (-jnp.sin(phi) * second - jnp.cos(phi) * rate**2)
    np.testing.assert_allclose(found.y0[:, 0], x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.y0[:, 1], a, rtol=0, atol=1e-12 * np.max(np.abs(a)))
    # The motion itself has the accelerations of the trajectory.
    np.testing.assert_allclose(found.motion.acceleration("tip", "x"), a, rtol=0, atol=1e-10 * np.max(np.abs(a)))


def _rates(law, t):
    return fm.trajectory.rates(law, t)


def test_guide_under_its_nominal_input_follows():
    """5 mm in 50 ms: open loop, ten times the tolerance of the simulation, 1e-10 of 0.1 m, and a part for samples."""
    model = planar_guide(ratio=0.01).build()
    law = fm.trajectory.septic(0.0, 0.005, 0.05)
    found = fm.trajectory.inverse_dynamics(model, {"right1.x": law}, TIMES)
    motion = fm.simulate(model, TIMES, loads={"right1.x": found.inputs["force right1.x"]}, rtol=1e-10)
    np.testing.assert_allclose(motion.position("right1", "x") - 0.1, found.y0[:, 2], rtol=0, atol=1e-8)
    np.testing.assert_allclose(found.y0[:, 2], jax.vmap(law)(jnp.asarray(TIMES)), rtol=0, atol=1e-14)


@pytest.mark.parametrize("wrong", ["pivot.psi", "pivot.x"])
def test_names_that_cannot_be_driven_are_refused(wrong):
    with pytest.raises(fm.ModelError, match=wrong):
        fm.trajectory.inverse_dynamics(pendulum(), {wrong: lambda t: 0.0 * t}, TIMES)


def test_a_tip_beyond_the_arm_is_out_of_the_workspace():
    """0.9 m upwards of an arm of 0.8 m: the law passes 0.8 m between 0.037 and 0.03725 s, one of the times."""
    law = fm.trajectory.quintic(0.0, 0.9, 0.05)
    with pytest.raises(fm.AnalysisError, match=r"workspace.*It is so at 0\.03725 s"):
        fm.trajectory.inverse_dynamics(pendulum(), {"tip.y": law}, TIMES)
