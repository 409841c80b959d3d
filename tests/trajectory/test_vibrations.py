"""The perturbation method: against a closed form, and against the nonlinear motion."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from jax.tree_util import Partial
from scipy.special import jv, yv

import flexmb as fm
from flexmb import planar
from flexmb.mechanisms import mechanism_path

TIMES = np.linspace(0, 0.6, 61)


def longer(t, speed):
    return speed * t


def hanging(gravity=9.81) -> fm.Builder:
    """Point mass on a rod whose length is prescribed."""
    b = fm.Builder()
    b.node("hook", (0, 0))
    b.node("bob", (0, -1))
    b.fix("hook")
    b.add(planar.truss, "hook", "bob", name="rope", released=())
    b.prescribe("rope", 1, 0.0)
    b.mass("bob", 0.7)
    b.dof("bob", "x")
    b.gravity((0, -gravity))
    return b


SPEED, DROP = 0.8, np.linspace(0, 4, 81)


@pytest.fixture(scope="module")
def let_down():
    return fm.simulate(hanging().build(), DROP, motion={"rope.e1": Partial(longer, speed=SPEED)}, rtol=1e-10)


def of_bessel(gravity):
    """L phi'' + 2 v phi' + g phi = 0 at small angles, L = 1 + v t: phi u is a Bessel function of u = 2 sqrt(g L)/v."""
    length = 1 + SPEED * DROP
    u = 2 * np.sqrt(gravity * length) / SPEED
    # phi = (a J1(u) + b Y1(u))/u, whose derivative by u is -(a J2(u) + b Y2(u))/u; x = L phi starts at 1 mm, at rest.
    start = np.array([[jv(1, u[0]), yv(1, u[0])], [-jv(2, u[0]), -yv(2, u[0])]]) / u[0]
    # phi' = -v x/L^2, and du/dt = v u/(2 L).
    a, b = np.linalg.solve(start, [1e-3, -1e-3 / (u[0] / 2)])
    return length * (a * jv(1, u) + b * yv(1, u)) / u


@pytest.mark.slow
def test_pendulum_that_is_let_down_against_bessel_functions(let_down):
    found = fm.trajectory.perturbation(let_down, q=[1e-3], rtol=1e-9)
    # Splines through matrices 50 ms apart: h^4/384 of their fourth derivatives.
    np.testing.assert_allclose(found.q[:, 0], of_bessel(9.81), atol=1e-6 * 1e-3)


@pytest.mark.slow
def test_linearised_under_what_a_controller_gave(let_down):
    # An input that pulls the bob down tightens the rope: its stiffness to the side is the tension over the length.
    b = hanging()
    b.input("bob", "y")
    motion = dataclasses.replace(let_down, model=b.build(), u=jnp.full((len(DROP), 1), -3.0))
    found = motion.linearizations().K[:, 0, 0]
    np.testing.assert_allclose(found, (0.7 * 9.81 + 3) / (1 + SPEED * DROP), rtol=1e-7)


@pytest.mark.slow
def test_gradient_by_gravity(let_down):
    def deviation(gravity):
        # It hangs straight at any gravity.
        motion = dataclasses.replace(let_down, model=hanging(gravity).build())
        return fm.trajectory.perturbation(motion, q=[1e-3], substeps=2).q[-1, 0]

    step = 1e-4
    difference = (deviation(9.81 + step) - deviation(9.81 - step)) / (2 * step)
    forward = jax.jvp(deviation, (9.81,), (1.0,))[1]
    reverse = jax.grad(deviation)(9.81)
    # Truncation 1e-9, round-off 1e-16 of 1e-3 over the step.
    np.testing.assert_allclose([forward, reverse], difference, rtol=1e-6)
    known = (of_bessel(9.81 + step) - of_bessel(9.81 - step))[-1] / (2 * step)
    np.testing.assert_allclose(forward, known, rtol=1e-4)


def arm(stiffness=40.0, mass=0.5):
    """Flexible arm with a load on a hub that a motor turns."""
    b = fm.Builder()
    names = ["hub", "middle", "tip"]
    for i, name in enumerate(names):
        b.node(name, (0.5 * i, 0))
    section = fm.Rigidity(EA=1e6, EIy=stiffness, mass=mass)
    for i in range(2):
        b.add(planar.beam, names[i], names[i + 1], name=f"part{i}", section=section, released=(2, 3))
        b.dof(f"part{i}", 2, 3)
    b.fix("hub", "x", "y")
    b.mass("tip", 0.3)
    b.inertia("hub", 0.05)
    b.dof("hub", "phi")
    b.input("hub", "phi")
    b.output("tip", "y")
    return b.build()


def turned(model, travel):
    return fm.trajectory.inverse_dynamics(model, {"hub.phi": fm.trajectory.septic(0.0, travel, 0.5)}, TIMES)


@pytest.fixture(scope="module")
def swung():
    return turned(arm(), 0.5)


@pytest.mark.slow
def test_vibrations_on_a_trajectory_against_the_nonlinear_motion(swung):
    """What held the arm straight is let go; the error falls with the square of the amplitude at least."""
    errors, sizes = [], []
    for nominal in (swung, turned(arm(), 0.25)):
        (moment,) = nominal.inputs.values()
        full = fm.simulate(arm(), TIMES, loads={"hub.rotation.phi": moment}, rtol=1e-9).position("tip")
        found = fm.trajectory.perturbation(nominal).motion()
        straight = nominal.motion.position("tip")
        errors.append(float(jnp.max(jnp.abs(found.position("tip") - full))))
        sizes.append(float(jnp.max(jnp.abs(full - straight))))
        assert found.form == "perturbation method"
    assert sizes[0] > 0.01
    assert errors[0] < 0.02 * sizes[0]
    assert sizes[0] / sizes[1] == approx(2, rel=0.01)
    assert errors[0] / errors[1] > 4
    # Accelerations are those of the machine, nothing held any longer: by differences of the velocities.
    seen = found.observe()
    rate = np.gradient(np.asarray(found.velocity("tip", "y")), TIMES)
    np.testing.assert_allclose(seen.acceleration("tip", "y")[5:-5], rate[5:-5], atol=0.05 * np.max(np.abs(rate)))


@pytest.mark.slow
@pytest.mark.parametrize("controlled", [False, True])
def test_inputs_of_a_motion_are_those_of_functions_and_of_a_controller(controlled):
    """Which of them drives a motion does not matter to what its inputs are."""
    more = {"control": lambda t, y: jnp.array([0.2 * t])} if controlled else {}
    found = fm.simulate(arm(), TIMES, inputs={"force hub.phi": lambda t: 3.0 * jnp.sin(10 * t)}, **more)
    wanted = 3.0 * np.sin(10 * TIMES) + (0.2 * TIMES if controlled else 0.0)
    np.testing.assert_allclose(fm.trajectory.time_varying(found).u0[:, 0], wanted, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_few_modes_and_what_is_left_out_at_rest(swung):
    whole, few = fm.trajectory.perturbation(swung, rtol=1e-8), fm.trajectory.perturbation(swung, modes=3, rtol=1e-8)
    size = jnp.max(jnp.abs(whole.q), axis=0)
    # The frequencies left out are above 86 Hz, the trajectory's content below 6 Hz.
    assert jnp.all(jnp.abs(few.q - whole.q) < 5e-4 * size)
    system = fm.trajectory.time_varying(swung)
    np.testing.assert_allclose(system.u0, swung.u0)
    moment = np.sin(20 * TIMES) ** 3
    small = system.reduced(3)
    assert small.error is not None
    assert small.left_out is not None
    assert np.shape(small.basis) == (len(TIMES), 5, 3)
    # Round-off is what is known of the frequency of the rigid motion.
    assert jnp.all(small.error < 1e-4)
    assert jnp.all(small.left_out > 80)
    exact, found = (s.response(TIMES, moment).outputs for s in (system, small))
    np.testing.assert_allclose(found, exact, atol=1e-3 * np.max(np.abs(exact)))
    # The same moment beside that of the nominal motion, whose vibrations do not change.
    pushed = fm.trajectory.perturbation(swung, u=moment[:, None])
    tip = system.C[:, 0, :5] @ jnp.swapaxes(pushed.q - whole.q, 0, 1)
    # Inputs are linear between times there, and splines here.
    np.testing.assert_allclose(np.diagonal(tip), exact, atol=1e-2 * np.max(np.abs(exact)))


@pytest.mark.slow
def test_a_stiff_servo_holds_what_it_drives(swung):
    found = fm.trajectory.perturbation(swung, held=["hub.rotation.phi"])
    assert jnp.all(found.q[:, 0] == 0)
    assert float(jnp.max(jnp.abs(found.q[:, 1]))) > 1e-3
    np.testing.assert_allclose(found.motion().rotation("hub"), swung.motion.rotation("hub"), rtol=0, atol=1e-12)
    # What it takes is among the forces, so that the hub is accelerated as it is led. What is left falls with the third
    # power of the travel: 4 of 15, 0.51 of 7.5, 0.064 of 3.8, 0.0080 of 1.9 rad/s^2.
    small = turned(arm(), 0.0625)
    led = np.asarray(small.motion.acceleration("hub.rotation"))
    both = fm.trajectory.perturbation(small, held=["hub.rotation.phi"]).motion()
    np.testing.assert_allclose(both.acceleration("hub.rotation"), led, rtol=0, atol=5e-3 * np.max(np.abs(led)))


@pytest.mark.slow
def test_error_falls_with_the_square_of_the_amplitude():
    """The elevator released beside where it was, against what the nonlinear motion changes by."""
    model = fm.read_spacar(mechanism_path("elevator")).builder.build(dofs="named")
    times = np.linspace(0, 1, 101)

    def released(turn):
        motion = fm.simulate(model, times, rtol=1e-8, initial=fm.configuration(model, jnp.array([turn, 0.0, 0.0])))
        return motion, jnp.stack([motion.deformation(element, 1) for element in "123"], axis=1)

    motion, nominal = released(1.0)
    errors = []
    for amplitude in (0.1, 0.01):
        found = fm.trajectory.perturbation(motion, q=[amplitude, 0, 0], rtol=1e-9)
        errors.append(float(jnp.max(jnp.abs(found.q - (released(1.0 + amplitude)[1] - nominal)))))
    assert errors[0] < 1e-3
    # 2 but for the next term, a tenth of it at most.
    assert np.log10(errors[0] / errors[1]) == approx(2, abs=0.05)


@pytest.mark.slow
def test_what_cannot_be_asked_says_so(swung):
    for keywords, fault, said in (
        ({"q": [0.0]}, ValueError, "each of the 5 degrees of freedom"),
        ({"held": "hub"}, TypeError, "must be a list"),
        ({"held": ["hub.y"]}, ValueError, "'hub.y' is no degree of freedom"),
        ({"held": swung.motion.model.q_labels}, ValueError, "none can vibrate"),
        ({"modes": 6}, ValueError, "modes"),
        ({"u": np.zeros(61)}, ValueError, "a row for each of the 61 times"),
        ({"rtol": 0.0}, ValueError, "rtol"),
    ):
        with pytest.raises(fault, match=said):
            fm.trajectory.perturbation(swung, **keywords)
    with pytest.raises(ValueError, match=r"Argument `q` must be numbers, not \{'elbow': "):
        jax.eval_shape(lambda bent: fm.trajectory.perturbation(swung, q={"elbow": bent}).q, 0.0)
    with pytest.raises(TypeError, match="takes a Motion"):
        fm.trajectory.perturbation(arm())


@pytest.mark.slow
def test_a_motion_without_mass_is_named():
    """A point mass on an arm without mass: the turn of the tip has none, which is no fault of the constraints."""
    with pytest.raises(fm.AnalysisError, match=r"Motions without mass: .*tip\.rotation\.phi") as info:
        fm.trajectory.perturbation(turned(arm(mass=0.0), 0.5))
    assert info.value.code == "singular_mass"
