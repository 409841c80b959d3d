"""What drives a mechanism along a trajectory: closed forms, and the motion that comes of it."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.mechanisms import planar_guide
from cases.motions import meshing_wheels
from cases.tolerances import approx
from cases.trajectories import arm

import flexmb as fm
from flexmb import planar
from flexmb.motion.drives_by_name import Drives, driven_by, warn_of_left_out

TIMES = np.linspace(0, 0.05, 201)


def pendulum(length=0.8, mass=1.5, prescribed=False, pull=None):
    """A point mass on a massless arm, driven at its pivot or pulled along x at its tip; gravity along -y."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("tip", (length, 0))
    b.add(planar.beam, "pivot", "tip", name="arm")
    b.fix("pivot", "position")
    b.mass("tip", mass)
    b.gravity((0, -9.81))
    if pull is not None:
        b.force("tip", (pull, 0.0), increment=True)
    if prescribed:
        b.prescribe("pivot", "phi", *(() if pull is None else (1.0,)), increment=pull is not None)
    else:
        b.dof("pivot", "phi")
        b.input("tip", "x", name="pull")
        b.input("pivot", "phi", name="torque")
    for component in ("x", "y"):
        b.output("tip", component)
        b.output("tip", component, quantity="acceleration")
    return b.build()


@pytest.mark.slow
def test_torque_of_a_pendulum():
    """m l² φ'' + m g l cos φ, and the place and acceleration of its tip, to round-off."""
    law = fm.trajectory.quintic(0.0, 2.0, 0.05)
    found = fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, TIMES, inputs=["torque"])
    phi, rate, second = map(np.asarray, jax.jit(jax.vmap(lambda t: _rates(law, t)))(TIMES))
    torque = 1.5 * 0.8**2 * second + 1.5 * 9.81 * 0.8 * np.cos(phi)
    np.testing.assert_allclose(found.u0[:, 1], torque, rtol=0, atol=1e-12 * np.max(np.abs(torque)))
    x = 0.8 * (jnp.cos(phi) - 1)
    a = 0.8 * (-jnp.sin(phi) * second - jnp.cos(phi) * rate**2)
    np.testing.assert_allclose(found.y0[:, 0], x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.y0[:, 1], a, rtol=0, atol=1e-12 * np.max(np.abs(a)))
    # The motion itself has the accelerations of the trajectory.
    np.testing.assert_allclose(found.motion.acceleration("tip", "x"), a, rtol=0, atol=1e-10 * np.max(np.abs(a)))


@pytest.mark.slow
def test_reactions_and_sensors_of_a_pendulum():
    """m (g + y'') at the pivot, and a sum of coordinates, to round-off."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("tip", (0.8, 0))
    b.add(planar.beam, "pivot", "tip", name="arm")
    b.fix("pivot", "position")
    b.mass("tip", 1.5)
    b.gravity((0, -9.81))
    b.dof("pivot", "phi")
    b.input("pivot", "phi")
    b.output("pivot", "y", "reaction", name="support")
    b.sensor("sum", {"tip.x": 1.0, "tip.y": 2.0})
    law = fm.trajectory.septic(0.0, 2.0, 0.05)
    found = fm.trajectory.inverse_dynamics(b.build(), {"pivot.phi": law}, TIMES)
    phi, rate, second = map(np.asarray, jax.jit(jax.vmap(lambda t: _rates(law, t)))(TIMES))
    support = 1.5 * (9.81 + 0.8 * (np.cos(phi) * second - np.sin(phi) * rate**2))
    np.testing.assert_allclose(found.y0[:, 0], support, rtol=0, atol=1e-10 * np.max(np.abs(support)))
    np.testing.assert_allclose(found.y0[:, 1], 0.8 * (np.cos(phi) - 1 + 2 * np.sin(phi)), rtol=0, atol=1e-12)


def _rates(law, t):
    return fm.trajectory.rates(law, t)


@pytest.mark.slow
def test_guide_under_its_nominal_input_follows():
    """5 mm in 50 ms: open loop, ten times the tolerance of the simulation, 1e-10 of 0.1 m, and a part for samples."""
    model = planar_guide(ratio=0.01).build()
    law = fm.trajectory.septic(0.0, 0.005, 0.05)
    found = fm.trajectory.inverse_dynamics(model, {"right1.x": law}, TIMES)
    motion = fm.simulate(model, TIMES, loads={"right1.x": found.inputs["force right1.x"]}, rtol=1e-10)
    np.testing.assert_allclose(motion.position("right1", "x") - 0.1, found.y0[:, 2], rtol=0, atol=1e-8)
    np.testing.assert_allclose(found.y0[:, 2], jax.vmap(law)(jnp.asarray(TIMES)), rtol=0, atol=1e-14)


@pytest.mark.slow
def test_incremental_loads_are_left_out_with_a_warning():
    law, times = fm.trajectory.quintic(0.0, 2.0, 0.05), TIMES[::40]
    with pytest.warns(fm.FlexmbWarning, match=r"inverse_dynamics leaves out the incremental loads.*Build them without"):
        fm.trajectory.inverse_dynamics(pendulum(prescribed=True, pull=3.0), {"pivot.phi": law}, times)
    driven = driven_by(model := pendulum(prescribed=True, pull=3.0), Drives(motion={"pivot.phi": law}))
    alone = dataclasses.replace(model.parameters.increment, force=None)
    model = dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, increment=alone))
    # The trajectory replaces the incremental angle: a warning would be an error here.
    warn_of_left_out(model, driven, "trajectory.inverse_dynamics")
    with pytest.warns(fm.FlexmbWarning, match="leaves out"):
        warn_of_left_out(model, (), "trajectory.inverse_dynamics")


@pytest.mark.slow
def test_torque_of_what_is_prescribed_is_its_reaction():
    """The same pendulum, whose angle is PRESCRIBED: nothing is driven, and the moment is its reaction."""
    law, times = fm.trajectory.quintic(0.0, 2.0, 0.05), TIMES[::40]
    found = fm.trajectory.inverse_dynamics(pendulum(prescribed=True), {"pivot.phi": law}, times)
    phi, _, second = map(np.asarray, jax.jit(jax.vmap(lambda t: _rates(law, t)))(times))
    torque = 1.5 * 0.8**2 * second + 1.5 * 9.81 * 0.8 * np.cos(phi)
    moment = found.motion.reaction("pivot", "phi")
    np.testing.assert_allclose(moment, torque, rtol=0, atol=1e-10 * np.max(np.abs(torque)))


@pytest.mark.slow
def test_second_derivative_of_a_torque():
    """That of a massless slider-crank's, which is mass times acceleration times the slope of the slider's place."""
    law = fm.trajectory.septic(0.1, 1.3, 0.6)

    def torque(length):
        b = fm.Builder()
        for name, x in (("hub", 0.0), ("tip", 0.2), ("slider", 0.2 + length)):
            b.node(name, (x, 0))
        b.add(planar.beam, "hub", "tip", name="crank")
        b.add(planar.truss, "tip", "slider", name="rod")
        b.fix("hub", "x", "y")
        b.fix("slider", "y")
        b.mass("slider", 1.0)
        b.dof("hub", "phi")
        b.input("hub", "phi")
        return fm.trajectory.inverse_dynamics(b.build(), {"hub.phi": law}, np.array([0.0, 0.15, 0.6])).u0[1, 0]

    def exact(length):
        def place(phi):
            return 0.2 * jnp.cos(phi) + jnp.sqrt(length**2 - 0.04 * jnp.sin(phi) ** 2)

        return jax.grad(jax.grad(lambda t: place(law(t))))(0.15) * jax.grad(place)(law(0.15))

    found, expected = (float(fm.jit(jax.jacfwd(jax.jacfwd(of)))(0.4)) for of in (torque, exact))
    assert found == approx(expected, rel=1e-10)


@pytest.mark.slow
def test_flexible_deformations_are_held():
    """The torque of the rigid arm, (J + m L² + rho A L³/3 + rho I L) φ'', and a motion of the whole model."""
    model, law, times = arm(), fm.trajectory.septic(0.0, 0.5, 0.1), np.linspace(0, 0.1, 6)
    found = fm.trajectory.inverse_dynamics(model, {"0.phi": law}, times)
    second = jax.vmap(lambda t: _rates(law, t)[2])(jnp.asarray(times))
    area, turned = 0.03 * 0.003, 0.03 * 0.003**3 / 12
    inertia = 1e-3 + 0.1 * 0.5**2 + 7850 * (area * 0.5**3 / 3 + turned * 0.5)
    size = np.max(np.abs(second))
    np.testing.assert_allclose(found.u0[:, 0], inertia * second, rtol=0, atol=1e-12 * inertia * size)
    np.testing.assert_allclose(found.motion.angular_acceleration("0"), second, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(found.motion.e, 0.0, rtol=0, atol=1e-14)
    assert np.all(found.f0[:, 0] == 0)
    assert np.max(np.abs(found.f0[1, 1:])) > 0.1
    # Free to vibrate about it: the stiffness of the beams is there, and the angle has none.
    stiffness = np.asarray(found.motion.linearizations().matrices.K0)
    assert stiffness.shape == (6, 5, 5)
    assert np.linalg.matrix_rank(stiffness[3]) == 4


@pytest.mark.slow
def test_input_of_a_tip_by_a_dimension():
    """What is driven follows the tip, l sin φ = y; against central differences, whose error is 1e-8 of the whole."""
    law = fm.trajectory.quintic(0.0, 0.3, 0.05)

    def force(length, driven=None):
        about = {"inputs": ["torque"], "driven": driven}
        found = fm.trajectory.inverse_dynamics(pendulum(length), {"tip.y": law}, TIMES[::50], **about)
        return jnp.sum(found.u0[:, 1] * jnp.arange(1.0, 6.0))

    y, rate, second = jax.vmap(lambda t: _rates(law, t))(jnp.asarray(TIMES[::50]))
    phi = jnp.arcsin(y / 0.8)
    turning = (second + 0.8 * jnp.sin(phi) * (rate / (0.8 * jnp.cos(phi))) ** 2) / (0.8 * jnp.cos(phi))
    torque = 1.5 * 0.8**2 * turning + 1.5 * 9.81 * 0.8 * np.cos(phi)
    of_pivot, both = fm.jit(lambda length: force(length, ["pivot.phi"])), fm.jit(jax.value_and_grad(force))
    expected = approx(float(torque @ jnp.arange(1.0, 6.0)), rel=1e-11)
    value, slope = map(float, both(0.8))
    assert value == expected
    assert float(of_pivot(0.8)) == expected
    step = 1e-4
    difference = float(both(0.8 + step)[0] - both(0.8 - step)[0]) / (2 * step)
    assert slope == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_wrong_inputs_are_refused():
    law = fm.trajectory.quintic(0.0, 0.3, 0.05)
    with pytest.raises(fm.ModelError, match=r"1 degrees of freedom.*there are pull, torque"):
        fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, TIMES)
    with pytest.raises(fm.ModelError, match=r"list of inputs, pull, torque; not 'motor'"):
        fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, TIMES, inputs=["motor"])
    with pytest.raises(TypeError, match="of known structure"):
        jax.jit(lambda model: fm.trajectory.inverse_dynamics(model, {"pivot.phi": law}, TIMES).u0)(pendulum())
    with pytest.raises(ValueError, match=r"at least two times, not 0\.1"):
        fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, 0.1)
    # A level arm cannot be turned by a force along it.
    with pytest.raises(
        fm.AnalysisError, match=r"depend on one another, or an input has no effect.*This happens at 0 s"
    ):
        fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law}, TIMES[::50], inputs=["pull"])
    with pytest.raises(fm.ModelError, match=r"of tip\.y: 1 degrees of freedom must be driven.*none that are left"):
        fm.trajectory.inverse_dynamics(pendulum(), {"pivot.phi": law, "tip.y": law}, TIMES)


@pytest.mark.slow
def test_start_values_say_which_way_an_elbow_is_bent():
    """An arm of two links is drawn straight, where it has no inverse, and begins bent."""
    b = fm.Builder()
    for name, place in {"shoulder": (0, 0), "elbow": (0.5, 0), "tip": (0.9, 0)}.items():
        b.node(name, place)
    b.rotation("upper")
    b.rotation("lower")
    b.rotation("ground")
    b.add(planar.rigid_beam, "shoulder", "upper", "elbow", name="first")
    b.add(planar.rigid_beam, "elbow", "lower", "tip", name="second")
    b.add(planar.hinge, "ground", "upper", name="j1")
    b.add(planar.hinge, "upper", "lower", name="j2")
    b.fix("shoulder")
    b.fix("ground")
    for node in ("elbow", "tip"):
        b.mass(node, 0.5)
    for joint, start in {"j1": 0.3, "j2": -0.5}.items():
        b.dof(joint, 1)
        b.input(joint, 1)
        b.start(joint, 1, start)
    x, y = (0.5 * f(0.3) + 0.4 * f(-0.2) for f in (np.cos, np.sin))
    laws = {"tip.x": fm.trajectory.septic(x - 0.9, x - 1.0, 0.05), "tip.y": fm.trajectory.septic(y, y, 0.05)}
    motion = fm.trajectory.inverse_dynamics(b.build(), laws, TIMES[::20]).motion
    # By the law of cosines.
    elbow = -np.arccos(((x - 0.1) ** 2 + y**2 - 0.41) / 0.4)
    found = [motion.deformation(joint, 1)[k] for joint, k in (("j1", 0), ("j2", 0), ("j2", -1))]
    np.testing.assert_allclose(found, [0.3, -0.5, elbow], atol=1e-10)
    laws["tip.y"] = lambda t: jnp.sqrt(t)
    with pytest.raises(fm.ModelError, match=r"'tip\.y': its law.*not finite at 0 s"):
        fm.trajectory.inverse_dynamics(motion.model, laws, TIMES[::20])


@pytest.mark.parametrize("turn", [4.0, 300.0])
def test_turns_are_counted_up_to_start_values(turn):
    """Wheels that mesh with no stress and stand still: no torque."""
    model = meshing_wheels(turn).build()
    plan = fm.trajectory.inverse_dynamics(model, {"p.phi": lambda t: turn + 0.0 * t}, TIMES[:3], inputs=["torque p"])
    # Round-off of 300 rad times 1000 N m/rad.
    np.testing.assert_allclose(plan.u0, 0.0, atol=1e-9)
    np.testing.assert_allclose(plan.f0, 0.0, atol=1e-9)


def test_turns_that_are_too_many_are_told():
    """1e4 rad are followed, up to start values and from a time to the next: here 1.5e4, and 2.5e4."""
    for start, rate, between in (
        (1.5e4, 0.0, "from the undeformed mechanism to t = 0 s"),
        (0.3, 1e8, "t = 0 and 0.00025"),
    ):
        model, law = meshing_wheels(start).build(), lambda t, start=start, rate=rate: start + rate * t
        with pytest.raises(fm.AnalysisError, match=f"'p.phi' goes too far .*{between}.* 1592 turns.*Give more times"):
            fm.trajectory.inverse_dynamics(model, {"p.phi": law}, TIMES[:3], inputs=["torque p"])


def test_a_plan_compiles_no_operation_by_itself(compilations):
    model = meshing_wheels(0.3).build()
    compilations.clear()
    fm.trajectory.inverse_dynamics(model, {"p.phi": lambda t: 0.3 + 0.1 * t}, TIMES[:3], inputs=["torque p"])
    assert {name.rpartition(".")[2] for name in compilations} <= {"_nominal", "_driven_by_inputs"}


@pytest.mark.parametrize("wrong", ["pivot.psi", "pivot.x"])
def test_names_that_cannot_be_driven_are_refused(wrong):
    with pytest.raises(fm.ModelError, match=wrong):
        fm.trajectory.inverse_dynamics(pendulum(), {wrong: lambda t: 0.0 * t}, TIMES, inputs=["torque"])


@pytest.mark.slow
def test_a_tip_beyond_the_arm_is_out_of_the_workspace():
    """0.9 m upwards of an arm of 0.8 m: the law passes 0.8 m between 0.037 and 0.03725 s, one of the times."""
    law = fm.trajectory.quintic(0.0, 0.9, 0.05)
    with pytest.raises(fm.AnalysisError, match=r"workspace.*This happens at 0\.03725 s"):
        fm.trajectory.inverse_dynamics(pendulum(), {"tip.y": law}, TIMES, inputs=["torque"])
