"""Controllers around an oscillator: signs, what they measure, and what is seen of them, against the closed form."""

import re
import warnings

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.motions import oscillation, sprung_mass
from cases.tolerances import approx

import flexmb as fm
from flexmb.motion.controlled_form import Feedback
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.loop import controlled_form

STIFFNESS, MASS = 90.0, 0.4
TIMES = np.linspace(0, 0.5, 6)


def controlled(**options) -> fm.Model:
    """A force on the mass and a stress in its spring, from place, rate of the place, stretch and its rate."""
    b = sprung_mass(stiffness=STIFFNESS, mass=MASS, **options)
    b.input("mass", "x")
    b.input("s", 1)
    b.output("mass", "x")
    b.output("mass", "x", "velocity")
    b.output("s", 1)
    b.output("s", 1, "deformation rate")
    return b.build()


def feedback(t, y):
    return jnp.array([5.0 - 4.0 * y[0] - 0.5 * y[1], 2.0 + 6.0 * y[2] + 0.7 * y[3]])


@pytest.mark.slow
def test_force_and_stress_by_feedback_of_places_and_rates():
    """m x'' = -k x + u_force - u_stress: the gains add to stiffness and damping."""
    found = fm.simulate(controlled(), TIMES, control=feedback, rtol=1e-9)
    x, v = oscillation(TIMES, STIFFNESS + 10.0, 1.2, MASS, 3.0)
    # Ten times the tolerance of a step, over some tens of steps.
    np.testing.assert_allclose(found.at("mass")[:, 0] - 0.4, x, atol=1e-7)
    np.testing.assert_allclose(found.velocity("mass")[:, 0], v, atol=1e-6)
    u = np.stack([5.0 - 4.0 * x - 0.5 * v, 2.0 + 6.0 * x + 0.7 * v], axis=1)
    np.testing.assert_allclose(found.u, u, atol=1e-6)
    seen = found.observe()
    np.testing.assert_allclose(seen.xdd[:, 2], (u[:, 0] - u[:, 1] - STIFFNESS * x) / MASS, atol=1e-5)
    np.testing.assert_allclose(seen.sigma[:, 0], STIFFNESS * x + u[:, 1], atol=1e-5)
    np.testing.assert_allclose(seen.reactions[:, 0], -STIFFNESS * x - u[:, 1], atol=1e-5)
    # What the controller puts in, by either input.
    np.testing.assert_allclose(seen.power, (u[:, 0] - u[:, 1]) * v, atol=1e-5)
    np.testing.assert_allclose(seen.energy, STIFFNESS * x**2 / 2 + MASS * v**2 / 2, atol=1e-6)


@pytest.mark.slow
def test_inputs_as_functions_of_time_beside_a_controller():
    """Feedforward: the same constants from outside the controller, one as a table that jumps nowhere."""

    def gains(t, y):
        return jnp.array([-4.0 * y[0] - 0.5 * y[1], 6.0 * y[2] + 0.7 * y[3]])

    held = fm.motion.Table(np.array([0.0, 1.0]), np.array([2.0, 2.0]))
    inputs = {"stress s.1": held, "force mass.x": lambda t: 5.0}
    found = fm.simulate(controlled(), TIMES, control=gains, inputs=inputs, rtol=1e-9)
    x, v = oscillation(TIMES, STIFFNESS + 10.0, 1.2, MASS, 3.0)
    np.testing.assert_allclose(found.at("mass")[:, 0] - 0.4, x, atol=1e-7)
    # What the controller gives alone.
    np.testing.assert_allclose(found.u, np.stack([-4.0 * x - 0.5 * v, 6.0 * x + 0.7 * v], axis=1), atol=1e-6)
    seen = found.observe()
    np.testing.assert_allclose(seen.sigma[:, 0], STIFFNESS * x + found.u[:, 1] + 2.0, atol=1e-5)


def test_an_actuator_as_a_function_of_time():
    b = sprung_mass(stiffness=STIFFNESS, mass=MASS)
    b.actuator("both", {"mass.x": 2.0, "s.1": -0.5})
    b.output("mass", "x")
    found = fm.simulate(b.build(), TIMES, inputs={"both": lambda t: 2.0}, rtol=1e-9)
    x, _ = oscillation(TIMES, STIFFNESS, 0.0, MASS, 5.0)
    np.testing.assert_allclose(found.at("mass")[:, 0] - 0.4, x, atol=1e-7)


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ({"force": lambda t: 1.0}, "names 'force', which is no input.*force mass.x, stress s.1"),
        ({"force mass.x": 1.0}, "Input 'force mass.x' must be a function of time"),
        ({"force mass.x": lambda t: jnp.ones(2)}, "must return one number"),
        ([1.0], "`inputs` must be a dictionary"),
    ],
)
def test_inputs_are_asked_by_name(inputs, words):
    with pytest.raises(fm.ModelError, match=words):
        fm.simulate(controlled(), TIMES, inputs=inputs)


def test_derivatives_of_what_is_measured():
    """Of a mass that swings across its spring too; against JAX's own derivatives of the measurements."""
    model = controlled(guided=False)
    x, v = np.array(model.parameters.reference), np.zeros(4)
    x[2:], v[2:] = [0.35, 0.3], [0.4, -0.9]

    @jax.jit
    def asked(x, v):
        form = coordinates_form(model.topology, model.parameters)
        state = form.state_of(x, v, None)
        sensors = controlled_form(model, form, None)

        def by_rates(u, w):
            return sensors.measured(0.0, state._replace(u=u, w=w))

        jacobian = jax.jacfwd(by_rates, (0, 1))(state.u, state.w)
        return sensors.measured(0.0, state), sensors._measured_derivatives(0.0, state), jacobian

    y, (by_state, _), jacobian = asked(x, v)
    length = np.hypot(0.35, 0.3)
    np.testing.assert_allclose(y, [-0.05, 0.4, length - 0.4, (0.35 * 0.4 - 0.3 * 0.9) / length], rtol=1e-12)
    np.testing.assert_allclose(by_state, np.concatenate(jacobian, axis=1), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("at", [0.0, 0.2, 0.4])
def test_the_failure_of_any_interval_is_that_of_the_motion(at):
    """A load that no step is short enough for, in one of the intervals of a sampled controller."""

    def shaken(t):
        return jnp.where((t >= at) & (t < at + 0.1), 50 * jnp.sin(2e4 * t), 0.0)

    held = fm.motion.Sampled(lambda t, z, y: (jnp.zeros(2), z), 0.1)
    found = fm.simulate(
        controlled(), TIMES, control=held, loads={"mass.x": shaken}, rtol=1e-9, max_steps=60, throw=False
    )
    assert fm.RESULTS(int(found.result)) == fm.RESULTS.motion_unfinished


def lost(y):
    """A number until the mass passes the middle, and none behind it."""
    return jnp.where(y[:1] > 0, 0.0, jnp.nan)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("controller", "what"),
    [
        (lambda t, y: jnp.append(jnp.zeros(1), lost(y)), "for the input 'stress s.1'"),
        (Feedback(lambda t, z, y: jnp.zeros(2), lambda t, z, y: lost(y), jnp.zeros(1)), "for its own state"),
        (fm.motion.Sampled(lambda t, z, y: (jnp.append(lost(y), 0.0), z), 0.02), "for the input 'force mass.x'"),
    ],
    ids=["function", "state", "sampled"],
)
def test_a_controller_that_gives_no_number_is_named_with_the_time(controller, what):
    """A free oscillation from 0.1 m passes its middle after a quarter of a period; samples are taken every 20 ms."""
    b = sprung_mass(stiffness=STIFFNESS, mass=MASS)
    b.start("mass", "x", 0.1)
    b.input("mass", "x")
    b.input("s", 1)
    b.output("mass", "x")
    with pytest.raises(fm.AnalysisError, match=rf"The controller .*{what} at t = [\d.]+ s") as fault:
        fm.simulate(b.build(), TIMES, control=controller)
    assert fault.value.code == "not_finite"
    quarter = np.pi / 2 * np.sqrt(MASS / STIFFNESS)
    expected = 0.02 * np.ceil(quarter / 0.02) if isinstance(controller, fm.motion.Sampled) else quarter
    # The tolerance of the motion, 1e-5 of 0.1 m and ten steps, over its speed of 1.5 m/s; six digits are printed.
    found = float(re.findall(r"at t = ([\d.]+) s", str(fault.value))[0])
    assert found == approx(expected, abs=1e-5)


@pytest.mark.slow
def test_a_reference_that_gives_no_number_is_named():
    with pytest.raises(fm.AnalysisError, match=r"Argument `reference` is not finite at t = 0\.2"):
        fm.simulate(
            controlled(), TIMES, control=feedback, reference=lambda t: jnp.where(t > 0.2, jnp.nan, 0.0) * jnp.ones(4)
        )


def test_a_reference_that_is_no_function_is_refused():
    with pytest.raises(TypeError, match=r"Argument `reference` must be a number, .* a function of time .* not a dict"):
        fm.simulate(controlled(), TIMES, control=feedback, reference={"x": 1e-3})  # type: ignore[arg-type]


def named(gain):
    """A proportional controller of the force on the mass, connected by name."""
    b = sprung_mass(stiffness=STIFFNESS, damping=0.0, mass=MASS)
    b.start("mass", "x", 0.1)
    b.input("mass", "x", name="push")
    b.output("mass", "x", "velocity", name="pace")
    b.output("mass", "x", name="place")
    return b.build(), control.ss([], [], [], [[gain]], inputs=["place"], outputs=["push"])


@pytest.mark.slow
def test_a_linear_system_without_a_reference_is_positive_feedback():
    """It reads y: the gain is taken from the stiffness, where a reference of zero adds it."""
    model, gain = named(30.0)
    stiff, soft = (0.1 * np.cos(np.sqrt((STIFFNESS + k) / MASS) * TIMES) for k in (30.0, -30.0))

    def place(**options):
        return fm.simulate(model, TIMES, rtol=1e-8, **{"control": gain, **options}).at("mass")[:, 0] - 0.4

    positive = r"reads y, so the feedback is positive.*closed_loop\(.*sign=1\).*reference=0.*give sign=1"
    for wrong in (gain, fm.control.saturated(gain, 100.0), control.ss([], [], [], [[0.0, 30.0]])):
        with pytest.warns(fm.FlexmbWarning, match=positive):
            np.testing.assert_allclose(place(control=wrong), soft, atol=1e-6)
    # Warnings are errors.
    np.testing.assert_allclose(place(sign=1), soft, atol=1e-6)
    for options in ({"sign": -1}, {"reference": 0}, {"reference": 0.0, "sign": -1}):
        np.testing.assert_allclose(place(**options), stiff, atol=1e-6)
    np.testing.assert_allclose(place(control=lambda t, y: -30.0 * y[1]), stiff, atol=1e-6)
    np.testing.assert_allclose(place(control=lambda t, y: 30.0 * y[1], sign=-1), stiff, atol=1e-6)


@pytest.mark.slow
def test_a_reference_of_what_a_controller_reads_by_name():
    """A force of 30 (r - x) on the mass: it swings about 30 r/(k + 30)."""
    model, gain = named(30.0)
    middle = 30.0 * 0.02 / (STIFFNESS + 30.0)
    expected = middle + (0.1 - middle) * np.cos(np.sqrt((STIFFNESS + 30.0) / MASS) * TIMES)
    for wanted in (0.02, [0.02], [7.0, 0.02], lambda t: 0.02, lambda t: jnp.array([7.0, 0.02])):
        found = fm.simulate(model, TIMES, control=gain, reference=wanted, rtol=1e-8)
        np.testing.assert_allclose(found.at("mass")[:, 0] - 0.4, expected, atol=1e-6)
    words = (
        r"returns shape \(3,\), but .* 2 outputs.* order of the builder, or for each of the 1 outputs that the contr"
    )
    with pytest.raises(fm.ModelError, match=words):
        fm.simulate(model, TIMES, control=gain, reference=np.zeros(3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "reads"),
    [({"sign": 1}, r"reads y: .*sign=1\)"), ({"reference": 1e-3}, r"reads reference - y: .*sign=-1\)")],
)
def test_a_motion_that_runs_away_names_the_sign_of_its_loop(options, reads):
    gain = 200.0 * options.get("sign", -1)
    model, controller = named(gain)
    with pytest.raises(fm.AnalysisError, match=reads) as fault:
        fm.simulate(model, [0.0, 10.0], control=controller, **options)
    assert fault.value.code == "ran_away"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"control": feedback, "sign": 0}, "`sign` must be -1 or 1"),
        ({"sign": 1}, "`sign` needs a controller"),
        ({"control": feedback, "sign": 1, "reference": lambda t: 0.0}, "which is sign=-1. Leave out `sign`"),
        ({"control": feedback, "reference": np.nan}, "`reference` has a value that is not a finite number"),
    ],
)
def test_signs_that_contradict_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        fm.simulate(controlled(), TIMES, **options)


def shaken():
    """A mass of 0.4 kg on a damped spring to a wall, pushed by an actuator of two forces; all that is felt there."""
    b = sprung_mass(stiffness=STIFFNESS, damping=1.2, mass=MASS)
    b.actuator("push", {"mass.x": 2.0, "s.1": 0.5})
    b.output("mass", "x", "acceleration")
    b.sensor("felt", {"reaction foot.x": 0.5, "stress s.1": -0.2, "mass.x": 3.0})
    return b.build()


@pytest.mark.slow
def test_tangent_of_accelerations_and_reactions_fed_back_at_once():
    """Derivatives of the residual, in which the input solves an equation with itself in it."""
    model = shaken()

    @jax.jit
    def both(x):
        form = coordinates_form(model.topology, model.parameters)
        closed = controlled_form(model, form, None, Feedback(lambda t, z, y: 0.3 * y[:1] - 0.7 * y[1:]))
        state = closed.state_of(x, 0.5 * x, None)
        z = jnp.linspace(0.2, 0.9, closed.unknowns)

        def left(u, w, z):
            return closed.residual(0.0, state._replace(u=u, w=w), z)

        return closed.tangent(0.0, state, z)[:3], jax.jacfwd(left, (0, 1, 2))(state.u, state.w, z)

    for found, expected in zip(*both(model.parameters.reference.at[2].add(0.1)), strict=True):
        # Round-off of a stiffness of 90.
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.slow
def test_accelerations_and_reactions_fed_back_at_once():
    """Through a controller with a state, against python-control's loop of the linear system, D of both in it."""
    model = shaken()
    own = control.ss([[-8.0]], [[1.0, 2.0]], [[3.0]], [[0.05, -0.2]])
    found = fm.simulate(model, TIMES, control=own, reference=lambda t: jnp.array([2.0, 0.0]), rtol=1e-9)
    loop = control.feedback(own, fm.to_statespace(model))
    _, u = control.forced_response(loop, TIMES, np.array([[2.0], [0.0]]) * np.ones(len(TIMES)), return_x=False)
    # Ten times the tolerance of a step, over some tens of steps; python-control's is exact for a step.
    np.testing.assert_allclose(found.u[:, 0], np.squeeze(u), atol=1e-6)


@pytest.mark.parametrize("given", ["text", None, ["1.0", "a"], {"u": 1.0}], ids=repr)
@pytest.mark.parametrize("of", ["The controller", "The controller's rate", "Argument `reference`"])
def test_what_returns_no_numbers_is_named(of, given):
    options = {
        "The controller": {"control": lambda t, y: given},
        "The controller's rate": {"control": Feedback(lambda t, z, y: y, lambda t, z, y: given, jnp.zeros(1))},
        "Argument `reference`": {"control": lambda t, y: y, "reference": lambda t: given},
    }
    with pytest.raises(fm.ModelError, match=f"{of} must return a number or an array of numbers, not"):
        fm.simulate(controlled(), TIMES, **options[of])


@pytest.mark.slow
def test_a_controller_that_begins_anew_in_a_later_part_is_warned_of():
    def integral(start):
        return Feedback(lambda t, z, y: jnp.append(-z, 0.0), lambda t, z, y: y[:1], jnp.array([start]))

    model = controlled()
    first = fm.simulate(model, [0.0, 0.01], control=integral(0.0))
    with pytest.warns(fm.FlexmbWarning, match="states of the controller, such as its integrals, begin at zero"):
        fm.simulate(model, [0.01, 0.02], initial=first, control=integral(0.0))
    # States that are given are meant; without states there are none to lose. A warning would be an error here.
    fm.simulate(model, [0.01, 0.02], initial=first, control=integral(1e-3))
    fm.simulate(model, [0.01, 0.02], initial=first)


@pytest.mark.slow
def test_a_controller_around_many_coordinates_is_warned_of():
    def stage(beams):
        b = fm.Builder()
        section = fm.Rectangle(0.02, 1e-3, fm.Material(E=2e11, G=8e10, rho=8e3))
        for i in range(beams + 1):
            b.node(f"n{i}", (0.1 * i / beams, 0))
        for i in range(beams):
            b.add(fm.planar.beam, f"n{i}", f"n{i + 1}", section=section)
        b.fix("n0")
        b.input(f"n{beams}", "y")
        b.output(f"n{beams}", "y")
        return b.build()

    def held(model):
        return fm.simulate(model, [0.0, 1e-7], control=lambda t, y: -y)

    with warnings.catch_warnings(action="error"):
        held(stage(19))
    with pytest.warns(fm.FlexmbWarning, match=r"60 coordinates.*fm\.lean.*fm\.to_statespace"):
        held(stage(20))
