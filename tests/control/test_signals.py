"""Inputs and outputs: moments and rotations about axes in space, inputs that do nothing, names."""

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.motions import body, turned
from cases.tolerances import approx
from jax.tree_util import Partial
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math.rotation import rotation_vector
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.loop import controlled_form

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
AXES = ("rx", "ry", "rz")


def torsion_bar(thickness=0.5e-3, signals=True, loads=True, dofs=True):
    """A leaf spring along x with a body at its end c; inertia and loads of all directions, so that nothing is plane."""
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("c", (0.1, 0, 0))
    b.add(spatial.beam, "a", "c", name="leaf", section=fm.Rectangle(0.018, thickness, STEEL), y=(0, 1, 0))
    b.fix("a")
    b.mass("c", 0.1, inertia=(2e-5, 1e-6, 0, 3e-5, 0, 4e-5))
    if dofs:
        b.dof("leaf", 1, 2, 3, 4, 5, 6)
    if loads:
        b.force("c", (0.0, 3.0, 0.5))
        b.moment("c", (0.2, 0.05, 0.0))
    if signals:
        for axis in AXES:
            b.input("c", axis)
            for quantity in ("position", "velocity", "acceleration"):
                b.output("c", axis, quantity)
    return b


def gain(system) -> np.ndarray:
    """Static gain -C A^-1 B + D."""
    a, b, c, d = (np.asarray(part) for part in (system.A, system.B, system.C, system.D))
    return d - c @ np.linalg.solve(a, b)


def test_static_gain_of_a_torsion_bar():
    b = torsion_bar(signals=False, loads=False)
    b.input("c", "rx")
    b.output("c", "rx")
    system = fm.to_statespace(b.build())
    assert system.input_labels == ["moment c rx"]
    assert system.output_labels == ["position c rx"]
    # L/(G It) with Saint-Venant's series for a rectangle of 18 by 0.5 mm: 0.1/(80e9 * 7.36869e-13), printed digits.
    assert gain(system)[0, 0] == approx(1.69636, abs=0.5e-5)


@pytest.fixture(scope="module")
def loaded():
    model = torsion_bar().build()
    lin = fm.linearize(model)
    # Turned well away from where it was: this is what the derivative is to be right about.
    assert np.linalg.norm(since([1, 0, 0, 0], lin.x[model.labels.known("c.rotation")], False)) > 0.2
    return model, lin


@pytest.mark.slow
def test_moments_and_rotations_about_global_axes_of_a_turned_node(loaded):
    """Static gain against a difference of nonlinear equilibria, turned from one into the other."""
    _, lin = loaded
    found = gain(fm.to_statespace(lin))[::3]
    step = 1e-5
    for i in range(3):
        turned = []
        for sign in (1, -1):
            b = torsion_bar()
            b.moment("c", sign * step * np.eye(3)[i])
            q = np.asarray(fm.equilibrium(b.build()).at("c.rotation"))
            turned.append(Rotation.from_quat(q, scalar_first=True))
        between = (turned[0] * turned[1].inv()).as_rotvec() / (2 * step)
        # Truncation of the difference, the square of 1e-5 of a turn's moment; round-off 1e-13 over it.
        np.testing.assert_allclose(found[:, i], between, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(found, fm.compliance(lin, "c")[3:, 3:], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_axes_that_turn_with_the_node(loaded):
    _, lin = loaded
    b = torsion_bar(signals=False)
    for axis in AXES:
        b.input("c", axis, local=True)
        b.output("c", axis, local=True)
    own = gain(fm.to_statespace(b.build()))
    np.testing.assert_allclose(own, fm.compliance(lin, "c", local=True)[3:, 3:], rtol=1e-9, atol=1e-12)
    turn = Rotation.from_quat(np.asarray(lin.x[lin.labels.known("c.rotation")]), scalar_first=True).as_matrix()
    np.testing.assert_allclose(own, turn.T @ gain(fm.to_statespace(lin))[::3] @ turn, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_angular_velocity_and_acceleration_are_rates_of_the_rotation(loaded):
    _, lin = loaded
    a, b, c, d = fm.control.state_matrices(lin)[0]
    position, velocity, acceleration = (c[i::3] for i in range(3))
    # y_dot = C (A z + B u): from position to velocity nothing passes directly.
    np.testing.assert_allclose(velocity, position @ a, atol=1e-9 * np.max(np.abs(velocity)))
    np.testing.assert_allclose(position @ b, 0, atol=1e-12 * np.max(np.abs(b)))
    np.testing.assert_allclose(acceleration, velocity @ a, atol=1e-9 * np.max(np.abs(acceleration)))
    np.testing.assert_allclose(d[2::3], velocity @ b, rtol=1e-9, atol=1e-9 * np.max(np.abs(d)))


@pytest.mark.slow
def test_derivative_by_a_dimension():
    def rotations(thickness):
        a, b, c, d = fm.control.state_matrices(torsion_bar(thickness).build())[0]
        return jnp.concatenate([jnp.ravel(part) for part in (a, b, c, d)])

    t, step = 0.5e-3, 1e-8
    found = fm.jit(lambda t: jax.jvp(rotations, (t,), (1.0,))[1])(t)
    difference = (rotations(t + step) - rotations(t - step)) / (2 * step)
    # Truncation (1e-8/5e-4)^2, round-off 1e-12 over 2e-5 of a change.
    np.testing.assert_allclose(found, difference, rtol=1e-5, atol=1e-6 * np.max(np.abs(difference)))


# -- measured and driven in a simulation --------------------------------------------------------------------------


def sensed(stiffness=(1.0, 2.0, 3.0), moment=(0.3, 0.4, -0.5)):
    """A body held by three springs about axes, turned by a moment; x is one of its principal axes."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.node("rim", (0.1, 0.2, 0.3))
    b.rotation("ground")
    b.rotation("c")
    b.fix("o")
    b.fix("ground")
    b.add(spatial.hinge, "ground", "c", name="springs", axis=(1, 2, 2), stiffness=stiffness, released="all")
    b.add(spatial.rigid_beam, "o", "c", "rim", name="arm")
    b.inertia("c", (2e-3, 0, 0, 3e-3, 1e-4, 4e-3))
    b.moment("c", moment)
    b.dof("springs", 1, 2, 3)
    for axis in AXES:
        b.input("c", axis)
    b.input("c", "rx", local=True, name="own")
    for local in (False, True):
        b.output("c", "rx", local=local, name=f"angle {local}")
        b.output("c", "rx", "velocity", local=local, name=f"rate {local}")
    return b.build()


FREE = dict(stiffness=np.zeros(3), moment=(0, 0, 0))  # that nothing holds


def _torque(t, y, constant, swing, gains, offset):
    return constant + swing * jnp.sin(10 * t) - gains @ (y - offset)


def driven(model, times, initial, constant=(0, 0, 0, 0), swing=(0, 0, 0, 0), gains=None, offset=(0, 0, 0, 0)):
    """Motion under moments about global axes and one about the body's own; compiled once for all tests."""
    gains = np.zeros((4, 4)) if gains is None else gains
    given = dict(constant=constant, swing=swing, gains=gains, offset=offset)
    torque = Partial(_torque, **{name: jnp.asarray(value, float) for name, value in given.items()})
    return fm.simulate(model, times, initial=initial, control=torque, rtol=1e-9)


def since(rest, parameters, local):
    """Rotation vector from one orientation to others, about global axes or those of the body."""
    rest, now = (Rotation.from_quat(np.asarray(q), scalar_first=True) for q in (rest, parameters))
    return (rest.inv() * now if local else now * rest.inv()).as_rotvec()


@pytest.mark.slow
def test_a_closed_loop_about_a_turned_state_agrees_with_the_linear_one_to_first_order():
    model = sensed()
    # As a configuration, as the other motions here start from one.
    turned = [entry.of == "springs" for entry in model.labels.e]
    rest = fm.configuration(model, q=fm.equilibrium(model).e[np.array(turned)])
    times = np.linspace(0, 0.2, 5)
    gains = np.zeros((4, 4))
    gains[0, :2] = 2.0, 0.05
    # The rotation that is measured at the start is that from the undeformed mechanism.
    offset = np.array([since([1, 0, 0, 0], rest.at("c"), False)[0], 0.0, 0.0, 0.0])
    loop = control.feedback(fm.to_statespace(model), control.ss([], [], [], gains))
    errors = []
    for amplitude in (2e-2, 1e-2):
        found = driven(model, times, rest, (amplitude, 0, 0, 0), gains=gains, offset=offset)
        held = np.array([amplitude, 0, 0, 0])[:, None] * np.ones(len(times))
        _, linear = control.forced_response(loop, times, held)
        moved = since(rest.at("c"), found.at("c"), False)
        errors.append(np.max(np.abs(moved[:, 0] - linear[0])) / np.max(np.abs(linear[0])))
    # Turned by some hundredths of a radian: what is left is of second order, so that half of it leaves half.
    assert errors[0] < 1e-2
    assert errors[1] == approx(errors[0] / 2, rel=0.1)


def test_what_sensors_of_a_rotation_give():
    """Rotation and angular velocity against SciPy, and their derivatives by the coordinates that move."""
    model = sensed()
    rng = np.random.default_rng(5)
    start, now, rate = rng.standard_normal((3, 4))
    start, now = (q / np.linalg.norm(q) for q in (start * np.sign(start[0]), now * np.sign(start[0] * (start @ now))))
    own = model.labels.known("c")
    x = [np.array(model.parameters.reference) for _ in range(2)]
    x[0][own], x[1][own] = start, now
    v = np.zeros(len(x[0]))
    v[own] = rate - now * (now @ rate)

    @fm.jit
    def sensors(model, whence, x, v):
        form = coordinates_form(model.topology, model.parameters)
        sensors = controlled_form(model, form, whence)
        state = form.state_of(x, v, None)

        def measured(u, w):
            return sensors.measured(0.0, state._replace(u=u, w=w))

        found = measured(state.u, state.w)
        by_state, n = sensors._measured_derivatives(0.0, state)[0], state.u.shape[0]
        return found, (by_state[:, :n], by_state[:, n:]), jax.jacfwd(measured, (0, 1))(state.u, state.w)

    found, derivatives, jacobians = sensors(model, *x, v)
    # A step along the geodesic turns by the angular velocity times the time.
    step = 1e-6
    ahead, behind = (now + sign * step * v[own] for sign in (1, -1))
    for i, local in enumerate((False, True)):
        expected = since([1, 0, 0, 0], start, local)[0] + since(start, now, local)[0]
        np.testing.assert_allclose(found[2 * i], expected, rtol=1e-12)
        omega = since(behind, ahead, local) / (2 * step)
        assert found[2 * i + 1] == approx(omega[0], rel=1e-8)
    for one, other in zip(derivatives, jacobians, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def torque(t, constant):
    return constant * jnp.cos(t)


@pytest.fixture(scope="module")
def steered():
    """A body with moments about global axes, and one about its own."""
    b = body((1.0, 2.0, 3.0), (0.0, 0.0, 0.0))
    for axis in AXES:
        b.input("body", axis, name=axis)
    b.input("body", "rx", local=True, name="own")
    b.output("body", "rx")
    return b.build()


def moved(model, about, own, **start):
    inputs = {name: Partial(torque, constant=value) for name, value in zip((*AXES, "own"), (*about, own), strict=True)}
    return fm.simulate(model, np.linspace(0, 2, 5), inputs=inputs, rtol=1e-9, **start)


@pytest.mark.slow
def test_a_moment_that_is_an_input_acts_as_one_that_is_a_load(steered):
    about = np.array([1.0, 0.3, -0.5])
    load = fm.simulate(steered, np.linspace(0, 2, 5), loads={"body": Partial(torque, constant=about)}, rtol=1e-9)
    # The body turns by more than a radian; the moments keep their axes.
    assert np.linalg.norm(np.asarray(load.at("body"))[-1, 1:]) > 0.5
    np.testing.assert_allclose(moved(steered, about, 0.0).at("body"), load.at("body"), atol=1e-8)


@pytest.mark.slow
def test_a_moment_about_axes_of_the_body(steered):
    """About its own principal axis a body only spins: Euler's equations."""
    found = moved(steered, np.zeros(3), 0.3, initial=fm.configuration(steered, q=[0.3, -0.2, 0.1]))
    rest, end = (Rotation.from_quat(np.asarray(found.at("body"))[i], scalar_first=True) for i in (0, -1))
    # Angle M (1 - cos t)/J about the body's own x axis, which stays where it is.
    np.testing.assert_allclose((rest.inv() * end).as_rotvec(), [0.3 * (1 - np.cos(2)), 0, 0], atol=1e-7)


@pytest.mark.slow
def test_moments_by_a_controller():
    """About an axis of the body, beside Euler's equations, and in a plant of python-control."""
    model = sensed(**FREE)
    start = fm.configuration(model, q=[0.3, -0.2, 0.1])
    found = driven(model, np.linspace(0, 0.2, 5), start, (0, 0, 0, 0.03))
    rest, end = (Rotation.from_quat(np.asarray(found.at("c"))[i], scalar_first=True) for i in (0, -1))
    # Angle M t^2/(2 J).
    np.testing.assert_allclose((rest.inv() * end).as_rotvec(), [0.3, 0, 0], atol=1e-7)
    b = body((1.0, 2.0, 3.0), (0.0, 0.0, 0.0))
    for axis in AXES:
        b.input("body", axis)
    b.output("body", "rx")
    model = b.build()
    driving = fm.simulate(
        model, np.linspace(0, 2, 5), control=lambda t, y: jnp.array([1.0, jnp.sin(t), -0.5]), rtol=1e-9
    )
    states = control.input_output_response(
        fm.control.to_nonlinear_system(model),
        np.linspace(0, 2, 201),
        np.stack([np.ones(201), np.sin(np.linspace(0, 2, 201)), -0.5 * np.ones(201)]),
        solve_ivp_kwargs={"rtol": 1e-9, "atol": 1e-10},
    )
    whole = Rotation.from_quat(np.asarray(driving.at("body"))[-1], scalar_first=True).as_rotvec()
    # Straight lines between the inputs: 1e-4 squared over 8.
    assert states.outputs[..., -1].item() == approx(whole[0], abs=1e-4)


@pytest.mark.slow
def test_rotation_vector_is_that_of_scipy_and_has_a_derivative_at_zero():
    rng = np.random.default_rng(3)
    for size in (0.0, 1e-9, 1e-3, 1.0, 3.0, 6.0):
        axis = rng.standard_normal(3)
        turn = size * axis / np.linalg.norm(axis)
        half = np.r_[np.cos(size / 2), np.sin(size / 2) * axis / np.linalg.norm(axis)]
        np.testing.assert_allclose(rotation_vector(jnp.asarray(half)), turn, atol=4e-16 * (1 + 10 * size))
    slope = jax.jacfwd(rotation_vector)(jnp.array([1.0, 0, 0, 0]))
    np.testing.assert_array_equal(slope, np.c_[np.zeros(3), 2 * np.eye(3)])


# -- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("side", ["input", "output"])
@pytest.mark.parametrize("component", ["l1", "l0", 2])
def test_euler_parameters_are_no_signals(side, component):
    b = torsion_bar(signals=False)
    with pytest.raises(fm.ModelError, match=r"'c\.rotation\.l\d' is an Euler parameter.* rx, ry or rz"):
        getattr(b, side)("c.rotation", component)


def test_axes_are_those_of_a_rotation_in_space():
    b = torsion_bar(signals=False)
    with pytest.raises(fm.ModelError, match=r"Input 'c\.x': only a rotation in space .* `local`"):
        b.input("c", "x", local=True)
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    b.add(planar.beam, "A", "B")
    with pytest.raises(fm.ModelError, match=r"Node 'B' has no coordinate 'rz'. It has: x, y, phi"):
        b.input("B", "rz")


def test_names_of_signals_are_told_apart():
    b = torsion_bar(signals=False)
    b.input("c", "x")
    with pytest.raises(fm.ModelError, match=r"Input 'force c\.x' is named twice"):
        b.input("c", "x")
    # In a control system a point is a blank.
    with pytest.raises(fm.ModelError, match=r"Input 'force c x' is named twice"):
        b.input("c", "y", name="force c x")
    b.output("c", "x", name="force c.x")
    with pytest.raises(fm.ModelError, match="needs a name"):
        b.output("c", "y", name=" ")


def held(component, **options):
    b = torsion_bar(signals=False)
    b.input("a" if component in ("x", "rx") else "leaf", component, **options)
    b.output("c", "x")
    return b


@pytest.mark.slow
def test_an_input_on_what_is_held_is_refused():
    with pytest.raises(fm.ModelError, match=r"Input 'force a\.x' acts on a coordinate that is fixed"):
        held("x").build()
    with pytest.raises(fm.ModelError, match=r"Input 'moment a\.rx' acts on a rotation that is fixed"):
        held("rx").build()
    b = torsion_bar(signals=False, dofs=False)
    b.prescribe("c", "x", 1e-3)
    b.input("c", "x", name="drive")
    with pytest.raises(fm.ModelError, match=r"Input 'drive' acts on a coordinate that is prescribed"):
        b.build()
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    b.add(planar.beam, "A", "B", name="leaf", section=fm.Rigidity(EA=1.0, EIy=1.0), released=(2, 3))
    b.fix("A")
    b.input("leaf", 1)
    with pytest.raises(fm.ModelError, match=r"Input 'stress leaf\.1' acts on a deformation that is fixed"):
        b.build()
    # Released on the way, it acts.
    b.release("leaf", 1)
    b.mass("B", 1.0, inertia=1.0)
    b.output("B", "x")
    assert gain(fm.to_statespace(b.build())) == approx(-0.1)


def stiff_arm():
    """An arm that cannot stretch: a force along it does nothing."""
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.3, 0.4))
    b.rotation("arm")
    b.rotation("ground")
    b.add(planar.rigid_beam, "A", "arm", "B", name="bar")
    b.add(planar.hinge, "ground", "arm", name="spring", stiffness=1.0)
    b.fix("A", "position")
    b.fix("ground")
    b.node("C", (0.3, 0.0))
    b.add(planar.truss, "A", "C", name="strut")
    b.fix("C", "y")
    b.mass("B", 1.0)
    b.dof("arm", "phi")
    b.input("C", "x", name="push")
    b.output("B", "y")
    return b


@pytest.mark.slow
def test_an_input_that_moves_nothing_is_refused_by_name():
    model = stiff_arm().build()
    for ask in (fm.to_statespace, fm.control.state_matrices):
        with pytest.raises(fm.ModelError, match=r"Input 'push' .*moves nothing"):
            ask(model)
    with pytest.raises(fm.ModelError, match=r"Input 'push' .*moves nothing"):
        fm.simulate(model, [0, 0.1], control=lambda t, y: y)
    with pytest.raises(fm.ModelError, match=r"Input 'push' .*moves nothing"):
        fm.simulate(model, [0, 0.1], inputs={"push": lambda t: 1.0})
    with pytest.raises(fm.ModelError, match=r"Input 'push' .*moves nothing"):
        fm.control.to_nonlinear_system(model)


@pytest.mark.slow
def test_an_input_at_a_dead_point_of_a_motion_is_none_that_does_nothing():
    """A crank at its dead point: a force along it moves it as soon as it has turned."""
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (1.0, 0))
    b.rotation("crank")
    b.add(planar.rigid_beam, "A", "crank", "B", name="arm")
    b.fix("A", "position")
    b.mass("B", 1.0)
    b.start("crank", "phi", 0.0, 1.0)
    b.input("B", "x")
    b.output("B", "x")
    model = b.build()
    found = fm.simulate(model, [0, 1.0], control=lambda t, y: jnp.array([-1.0]), rtol=1e-6)
    # Energy: the force takes u = -(1 - cos) along.
    angle = float(found.at("crank")[-1, 0])
    assert float(found.velocity("crank")[-1, 0]) ** 2 == approx(1 + 2 * (1 - np.cos(angle)), rel=1e-4)
    with pytest.raises(fm.ModelError, match=r"Input 'force B\.x' .*moves nothing"):
        fm.control.state_matrices(model)


# -- about a motion -----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_velocities_about_a_steady_motion_are_rates_of_positions():
    """Of a body on springs on a shaft that spins: rates of what is measured, the coordinates turning along."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.node("rim", (0.1, 0.2, 0.3))
    b.rotation("shaft")
    b.rotation("c")
    b.fix("o", "position")
    b.prescribe("shaft", "rotation", 0.0, axis=(1, 0, 0), tilt="fixed")
    b.add(spatial.hinge, "shaft", "c", name="springs", axis=(1, 2, 2), stiffness=(10.0, 20.0, 30.0), released="all")
    b.add(spatial.rigid_beam, "o", "c", "rim", name="arm")
    b.inertia("c", (2e-3, 1e-4, 2e-4, 3e-3, 0, 4e-3))
    for quantity in ("position", "velocity", "acceleration"):
        b.output("rim", "x", quantity)
        b.output("c", "ry", quantity)
        b.output("c", "rz", quantity)
    b.input("c", "rx")
    model, spin, step = b.build(), 30.0, 1e-6
    drive = {"shaft": Partial(turned, speed=spin)}
    here, ahead, behind = (fm.motion.steady_motion(model, drive, time=t) for t in (0.0, step, -step))
    a, _, c, _ = fm.control.state_matrices(here)[0]
    position, velocity, acceleration = (np.asarray(c[3 * i : 3 * i + 3]) for i in range(3))
    # Along the motion C turns: a difference of C at two instants.
    rate = np.asarray(fm.control.state_matrices(ahead)[0].C - fm.control.state_matrices(behind)[0].C) / (2 * step)
    # The angular velocity is no rate of the infinitesimal rotation, but that less omega x rotation.
    carried = spin * np.stack([np.zeros(len(a)), position[2], -position[1]])
    # Truncation (30 * 1e-6)^2, and what is left of the iterations of a steady motion, 1e-12 over the step.
    for found, expected in ((velocity, position @ a + rate[:3] + carried), (acceleration, velocity @ a + rate[3:6])):
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.max(np.abs(found)))


@pytest.mark.slow
def test_matrices_along_a_motion():
    b = body((1.0, 2.0, 3.0), (0.1, 0.2, 3.0))
    b.input("body", "rx")
    b.output("body", "rx")
    b.output("body", "ry", "velocity")
    found = fm.motion.linearize_motion(fm.simulate(b.build(), np.linspace(0, 1, 4)))
    every, names = fm.control.state_matrices(found)
    assert [part.shape for part in every] == [(4, 6, 6), (4, 6, 1), (4, 2, 6), (4, 2, 1)]
    assert len(names) == 6
    for i in (2, -1):
        alone = fm.to_statespace(found.at_time(i))
        for part, name in zip(every, "ABCD", strict=True):
            np.testing.assert_allclose(part[i], getattr(alone, name), rtol=1e-12, atol=1e-12)
    with pytest.raises(fm.ModelError, match=r"along a motion, at 4 times.*lin\.at_time\(0\).*state_matrices"):
        fm.to_statespace(found)
    with pytest.raises(IndexError, match="There are 4 times"):
        found.at_time(4)
    with pytest.raises(ValueError, match="no times"):
        found.at_time(0).at_time(0)


@pytest.mark.slow
def test_a_traced_build_knows_what_its_inputs_act_on():
    def frequency(load, component):
        b = torsion_bar(signals=False)
        b.input("c", component)
        if component == "rx":
            b.input("a", "y")
        b.output("c", "rx")
        b.force("c", (load, 0, 0))
        return b.build().parameters.loads.force[0]

    assert fm.jit(lambda load: frequency(load, "x"))(jnp.array(1.0)) == 0.0
    with pytest.raises(fm.ModelError, match=r"Input 'force a\.y' acts on a coordinate that is fixed"):
        fm.jit(lambda load: frequency(load, "rx"))(jnp.array(1.0))
