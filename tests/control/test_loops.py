"""Controllers around one mass: limits, delays, samples, schedules, poles, margins; against SciPy and closed forms."""

import contextlib
import warnings
from typing import Any

import control
import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from cases.motions import oscillation, sprung_mass
from cases.tolerances import approx
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar
from flexmb.motion.controllers import windup_of

MASS, DAMPING, STIFFNESS = 0.4, 0.5, 90.0
STEP = 0.01


def sprung(stiffness=STIFFNESS) -> fm.Model:
    b = sprung_mass(stiffness=stiffness, damping=DAMPING, mass=MASS)
    b.input("mass", "x", name="force")
    b.output("mass", "x", "velocity", name="rate")
    b.output("mass", "x", name="place")
    return b.build()


MODEL = sprung()
TIMES = np.linspace(0, 0.4, 9)


def pid() -> control.StateSpace:
    return fm.control.pid(MODEL, 5.0, output="place")


def held(t):
    return jnp.array([0.0, STEP])


def place(motion):
    return np.asarray(motion.at("mass"))[:, 0] - 0.4


def plant(x, u):
    return [x[1], (u - DAMPING * x[1] - STIFFNESS * x[0]) / MASS]


# -- PID by placing poles -----------------------------------------------------------------------------------------


def test_pid_puts_its_poles_where_they_are_wanted_and_knows_the_names():
    w = 2 * np.pi * 5.0
    pair = -0.7 * w + 1j * w * np.sqrt(1 - 0.49)
    found = fm.control.closed_loop(MODEL, pid())
    np.testing.assert_allclose(found.poles, [-0.5 * w, pair, np.conj(pair), -4 * w], rtol=1e-9)
    assert found.stable
    assert found.growth == approx(-0.5 * w)
    assert pid().input_labels == ["place"]
    assert found.system.input_labels == ["reference rate", "reference place"]
    # Without integrator, and of a mass that nothing holds: given as a state space.
    mass = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0], [-1 / MASS]], [[1.0, 0.0]], [[0.0]])
    found = fm.control.closed_loop(mass, fm.control.pid(mass, 5.0, slow=0.0, fast=2.0))
    np.testing.assert_allclose(found.poles, [pair, np.conj(pair), -2 * w], rtol=1e-9)


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({}, fm.ModelError, "several outputs. Name one as `output`, of rate, place"),
        ({"output": "speed"}, fm.ModelError, "`output` names 'speed'"),
        ({"output": "rate"}, fm.ModelError, "Output 'rate' measures a quantity 'velocity'"),
        ({"output": "place", "bandwidth": 0.01, "damping": 0.1, "fast": 0.1}, ValueError, r"more damping \(1.25 1/s\)"),
        ({"output": "place", "slow": -1.0}, ValueError, "`slow`"),
    ],
)
def test_bad_pid(given, kind, words):
    with pytest.raises(kind, match=words):
        fm.control.pid(MODEL, **{"bandwidth": 5.0, **given})


def test_plant_of_two_motions_has_no_pid():
    two = control.append(*[control.ss(control.tf([1], [1, 0, 0]))] * 2)
    with pytest.raises(fm.ModelError, match=r"4 states.*modes=1"):
        fm.control.pid(control.ss(two.A, two.B @ np.ones((2, 1)), two.C[:1], 0), 5.0)
    with pytest.raises(fm.ModelError, match="is no position"):
        fm.control.pid(control.ss([[0.0, 1.0], [-3.0, -1.0]], [[0], [1.0]], [[0, 1.0]], 0), 5.0)


def test_pid_warns_of_a_lowest_mode_that_hardly_moves_with_its_force():
    """A stage on two crossed springs, 90 and 900 N/m, 0.01 rad from the axes: the force mainly moves the stiff mode."""
    share = np.sin(0.01) ** 2
    a = [[0.0, 1.0], [-90.0 / MASS, 0.0]]
    askew = control.ss(a, [[0.0], [1 / MASS]], [[share, 0.0]], [[(1 - share) / 900.0]])
    for bandwidth in (20.0, np.sqrt(90.0 / MASS) / (2 * np.pi)):
        with pytest.warns(fm.FlexmbWarning, match=r"neglects move 'y\[0\]' more .* a mass of 4000 .*"):
            fm.control.pid(askew, bandwidth)
    # Along the other axis, to which 0.01 rad hardly matters, no warning is due.
    fm.control.pid(control.ss(a, [[0.0], [1 / MASS]], [[1 - share, 0.0]], [[share / 900.0]]), 20.0)


def test_pid_beside_a_floor_that_moves():
    """What another input moves is no motion of the plant, whose lowest mode is damped across those left out."""
    b = sprung_mass(stiffness=STIFFNESS, damping=DAMPING, mass=MASS)
    b.node("end", (0.5, 0.0))
    b.add(planar.truss, "mass", "end", section=fm.Rigidity(EA=900.0))
    b.fix("end", "y")
    b.mass("end", 0.1 * MASS)
    b.dof("end", "x")
    b.input("foot", "x", "acceleration", name="floor")
    b.input("mass", "x", name="force")
    b.output("mass", "x", name="place")
    model = b.build()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        small = fm.to_statespace(model, modes=1)
    found = fm.control.pid(small, 5.0, input="force", output="place")
    same = fm.control.pid(model, 5.0, input="force", output="place")
    np.testing.assert_allclose(found(1j), same(1j), rtol=1e-12)
    # One mass of 1.1 MASS, to its flexibility beside the spring.
    w, m = 2 * np.pi * 5.0, 1.1 * MASS
    a3, a2 = np.real(np.polymul([1, 1.4 * w, w**2], np.polymul([1, 0.5 * w], [1, 4 * w])))[1:3]
    filtered = m / (a3 * m - DAMPING)
    derivative = m * filtered * a2 - DAMPING - STIFFNESS * filtered
    np.testing.assert_allclose(same.D[0, 0], derivative / filtered, rtol=1e-2)


def on_a_floor(quantity: Any, sensor: Any = None) -> fm.Model:
    b = sprung_mass(stiffness=STIFFNESS, damping=DAMPING, mass=MASS)
    b.input("mass", "x", name="force")
    b.input("foot", "x", quantity, name="floor.x")
    b.output("mass", "x", name="place")
    b.sensor("slide", sensor or {"mass.x": 1.0, "foot.x": -1.0})
    return b.build()


@pytest.mark.slow
def test_pid_of_a_sensor_of_positions():
    """The stretch of the spring is the place, for the force; a sensor with a rate is no position."""
    found = fm.control.pid(on_a_floor("acceleration"), 5.0, input="force", output="slide")
    same = pid()
    for part in "ABCD":
        np.testing.assert_allclose(getattr(found, part), getattr(same, part), rtol=1e-9)
    assert found.input_labels == ["slide"]
    mixed = on_a_floor("acceleration", {"mass.x": 1.0, "velocity mass.x": 0.1})
    with pytest.raises(fm.ModelError, match=r"'slide' measures a quantity 'velocity'\. .*only positions and deform"):
        fm.control.pid(mixed, 5.0, input="force", output="slide")


@pytest.mark.parametrize(("quantity", "count"), [("acceleration", 2), ("velocity", 1), ("displacement", 0)])
@pytest.mark.parametrize("period", [None, 1e-3])
def test_a_loop_on_a_floor_leaves_out_the_given_motion_of_the_floor(quantity, count, period):
    """python-control has the same poles, and one at rest for each integral of the floor's motion."""
    controller = fm.control.pid(MODEL, 5.0, output="place")
    controller = control.ss(controller, inputs=["slide"], outputs=["force"])
    controller = control.ss(control.sample_system(controller, period, "tustin")) if period else controller
    controller = control.ss(controller, inputs=["slide"], outputs=["force"])
    found = fm.control.closed_loop(on_a_floor(quantity), controller)
    assert found.stable
    assert "stable," in repr(found)
    assert "neither" not in repr(found)
    assert found.growth < -10.0
    assert [margins.input for margins in found.margins] == ["force"]
    poles = np.asarray(found.system.poles(), complex)
    poles = np.log(poles[poles != 0]) / period if period else poles
    # Two coinciding poles are off by the root of round-off.
    assert np.sum(np.abs(poles) < 1e-4) == count
    np.testing.assert_allclose(np.sort(poles[np.abs(poles) > 1e-4]), np.sort(found.poles), rtol=1e-6)
    # Without a floor.
    own = control.ss(controller, inputs=["place"], outputs=["force"])
    np.testing.assert_allclose(np.sort(fm.control.closed_loop(MODEL, own).poles), np.sort(found.poles), rtol=1e-6)


def test_a_floor_that_the_controller_drives_is_part_of_the_loop():
    """An acceleration of the floor that follows nothing leaves the floor where it drifts."""
    found = fm.control.closed_loop(on_a_floor("acceleration"), control.ss([], [], [], np.zeros((2, 2))))
    assert np.sum(np.abs(found.poles) < 1e-4) == 2
    assert not found.stable


def test_a_controller_without_names_learns_how_to_name_them():
    such_as = r"control\.ss\(controller, inputs=\['place'\], outputs=\['force'\]\)"
    with pytest.raises(fm.ModelError, match=such_as):
        fm.control.closed_loop(on_a_floor("acceleration"), control.tf([1.0], [1.0, 3.0]))


def test_notch():
    w = 2 * np.pi * 50.0
    found = fm.control.notch(50.0, depth=0.01, width=0.4)
    np.testing.assert_allclose(np.abs(found(1j * w * np.array([1e-4, 1.0, 1e4]))), [1, 0.01, 1], rtol=1e-6)
    # Half the power at w (sqrt(1 + b^2/4) -+ b/2), but for the depth.
    edges = w * (np.sqrt(1 + 0.2**2) + np.array([-0.2, 0.2]))
    np.testing.assert_allclose(np.abs(found(1j * edges)) ** 2, (1 + 0.01**2) / 2, rtol=1e-9)


# -- limits, delays, schedules ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_limits_and_back_calculation_against_scipy():
    """A step that takes the force to its limit; the integrator is led back with a time constant."""
    limit, tracking = 1.5, 0.02
    c, own = pid(), {}
    integral, lag = np.asarray(c.C)[0]
    filtered, gain = -1 / np.asarray(c.A)[1, 1], float(c.D[0, 0])

    def rates(t, s):
        error = STEP - s[0]
        wanted = integral * s[2] + lag * s[3] + gain * error
        u = np.clip(wanted, -limit, limit)
        return [*plant(s, u), error + (u - wanted) / (integral * own["T"]), error - s[3] / filtered]

    over = {}
    for own["T"] in (tracking, np.inf):
        by_scipy = solve_ivp(rates, (0, TIMES[-1]), np.zeros(4), rtol=1e-9, atol=1e-12, t_eval=TIMES, max_step=1e-3)
        controller = fm.control.saturated(pid(), limit, tracking=own["T"])
        found = fm.simulate(MODEL, TIMES, control=controller, reference=held, rtol=1e-8, atol=1e-9)
        # The corners where the limit is met and left: some tolerances of steps.
        np.testing.assert_allclose(place(found), by_scipy.y[0], atol=2e-7)
        assert np.max(np.abs(np.asarray(found.u))) <= limit
        assert np.abs(np.asarray(found.u)[0, 0]) == limit
        over[own["T"]] = np.max(place(found))
    assert over[tracking] < over[np.inf] - 0.1 * STEP


@pytest.mark.slow
def test_samples_delay_and_limits_against_a_recursion():
    """Exact from sample to sample: the held force drives the mass by the exponential of its matrix."""
    h, delay, limits = 0.02, 2, [[0.05, 0.25]]
    sampled = control.ss([[1.0]], [[h]], [[40.0]], [[30.0]], h, inputs=["place"], outputs=["force"])
    whole = fm.control.delayed(sampled, delay * h)
    assert whole.nstates == 1 + delay
    controller = fm.control.fed_forward(
        fm.control.saturated(whole, limits, tracking=3 * h), lambda t: 0.2 * jnp.cos(9 * t)
    )
    found = fm.simulate(MODEL, TIMES, control=controller, reference=held, rtol=1e-9, atol=1e-10)
    a = np.array([[0, 1.0, 0], [-STIFFNESS / MASS, -DAMPING / MASS, 1 / MASS], [0, 0, 0]])
    once = scipy.linalg.expm(a * h)
    # What is in the pipe is led back with the integrator that it came from.
    x, z, pipe, places, forces = np.zeros(2), 0.0, [0.0] * delay, [], []
    for i in range(21):
        error = STEP - x[0]
        pipe.append(40.0 * z + 30.0 * error)
        wanted = pipe.pop(0)
        u = float(np.clip(wanted, *limits[0]))
        excess, led = u - wanted, 1 - np.exp(-1 / 3)
        z, pipe = z + h * error + led * excess / 40.0, [one + led * excess for one in pipe]
        u += 0.2 * np.cos(9 * i * h)
        places.append(x[0])
        forces.append(u)
        x = once[:2, :2] @ x + once[:2, 2] * u
    # Every other time that is asked for is a sample, one in five; the last is the end of what the one before held.
    np.testing.assert_allclose(place(found)[::2], places[::5], atol=1e-8)
    np.testing.assert_allclose(np.asarray(found.u)[:-1:2, 0], forces[:-1:5], atol=1e-6)
    within = np.array(forces) - 0.2 * np.cos(9 * h * np.arange(21))
    assert (np.min(within), np.max(within)) == approx(limits[0])


@pytest.mark.slow
def test_gains_along_a_schedule():
    """Gains on straight lines over time, and systems whose matrices do so."""
    at, gains = np.array([0.0, 0.1, 0.3]), np.array([0.0, 60.0, 20.0])
    by_scipy = solve_ivp(
        lambda t, s: plant(s, np.interp(t, at, gains) * (STEP - s[0])),
        (0, TIMES[-1]), [0.0, 0.0], rtol=1e-9, atol=1e-12, t_eval=TIMES, max_step=5e-3,
    )  # fmt: skip
    table = np.stack([np.zeros(3), gains], axis=1)[:, None]
    found = fm.simulate(MODEL, TIMES, control=fm.control.scheduled(at, table), reference=held, rtol=1e-8)
    np.testing.assert_allclose(place(found), by_scipy.y[0], atol=1e-7)
    lags = [control.ss([[-30.0]], [[1.0]], [[k]], [[0.0]], inputs=["place"], outputs=["force"]) for k in gains]
    scheduled: Any = fm.control.scheduled(at, lags)
    np.testing.assert_allclose(scheduled.output(0.05, jnp.ones(1), jnp.ones(1)), [30.0])
    np.testing.assert_allclose(scheduled.rate(0.05, 2 * jnp.ones(1), jnp.ones(1)), [-59.0])


def test_a_continuous_delay_is_all_pass():
    """Of order one (1 - s T/2)/(1 + s T/2), behind the controller."""
    found = fm.control.delayed(control.tf([2.0], [1, 3]), 0.1, order=1)
    s = 1j * np.array([0.1, 1.0, 30.0])
    np.testing.assert_allclose(found(s), 2 / (s + 3) * (1 - 0.05 * s) / (1 + 0.05 * s), rtol=1e-12)
    with pytest.raises(fm.ModelError, match="Give `order`"):
        fm.control.delayed(control.tf([2.0], [1, 3]), 0.1)


INTEGRATOR: Any = control.tf([1.0], [1.0, 0.0])
LAG: Any = control.StateSpace([[-1.0]], [[1.0]], [[1.0]], [[0.0]])


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: fm.control.saturated(INTEGRATOR, 1.0), "Give `tracking`"),
        (lambda: fm.control.saturated(LAG, 1.0, tracking=0.1), "`tracking` is for integrators"),
        (lambda: fm.control.saturated(LAG, [[1.0, -1.0]]), "least must be below"),
        (lambda: fm.control.saturated(LAG, [-1.0, 1.0]), r"has shape \(2,\)"),
        (lambda: fm.control.saturated(INTEGRATOR * INTEGRATOR, 1.0, tracking=0.1), "form a chain"),
        (lambda: fm.control.saturated(control.tf([1, 0, 0], [1, 1]), 1.0), "It must be proper"),
        (lambda: fm.control.saturated(control.nlsys(None, lambda t, x, u, p: u, inputs=1, outputs=1), 1.0), "must be"),
        (lambda: fm.control.delayed(LAG.sample(0.1), 0.25), "whole samples: 0.25 s are 2.5 samples of 0.1 s"),
        (lambda: fm.control.delayed(LAG.sample(0.1), 0.2, order=2), "`order` is only for a continuous"),
        (lambda: fm.control.delayed(lambda t, y: y, 0.1), "Only a linear system"),
        (lambda: fm.control.scheduled([0.0, 0.0], [1.0, 2.0]), "must be ascending"),
        (lambda: fm.control.scheduled([0.0, 1.0], [1.0, 2.0, 3.0]), "at 2 times"),
        (lambda: fm.control.scheduled([0.0, 1.0], [LAG, LAG * LAG]), "differ in their numbers of states"),
        (lambda: fm.control.scheduled([0.0, 1.0], [LAG, 1.0]), "mixes systems and other objects"),
        (lambda: fm.control.fed_forward(LAG, 1.0), "`law` must be a function of time"),
        (lambda: fm.control.closed_loop(MODEL, lambda t, y: y), "function is no linear system"),
        (lambda: fm.control.closed_loop(MODEL, LAG), "1 inputs and 1 outputs, but the mechanism has 2 outputs"),
        (lambda: fm.control.closed_loop(LAG, np.nan * UNIT), "controller are not finite. They are in its D"),
        (lambda: fm.control.closed_loop(LAG, lag(1.0, np.nan)), "controller are not finite. They are in its A"),
        (
            lambda: fm.control.closed_loop(lag(1.0, np.inf), LAG),
            "mechanism's state space are not finite. They are in its A",
        ),
        (lambda: fm.control.closed_loop(LAG.sample(0.1), LAG.sample(0.1)), "is sampled, with dt = 0.1. Give the"),
        (lambda: fm.control.closed_loop(-1.0 * UNIT, UNIT), "an algebraic loop without solution"),
        (lambda: fm.simulate(MODEL, TIMES, control=lag(1.0, np.nan)), "controller are not finite. They are in its A"),
        (
            lambda: fm.simulate(MODEL, TIMES, control=control.ss([], [], [], [[1, 1]], inputs=["place", "pace"])),
            "'pace' is no output of the mechanism. It has: rate, place",
        ),
        (
            lambda: fm.simulate(MODEL, TIMES, control=fm.control.saturated(lambda t, y: y[:1], [[-1, 1]] * 2)),
            "for 2 outputs, but the controller has 1",
        ),
        (
            lambda: fm.simulate(MODEL, TIMES, control=fm.control.fed_forward(lambda t, y: y[:1], lambda t: [1, 2])),
            r"`law` returns shape \(2,\)",
        ),
    ],
)
def test_bad_controllers(ask, words):
    with pytest.raises(fm.ModelError, match=words):
        ask()


def test_systems_of_traced_gains_are_refused_by_name():
    def gains(own):
        return fm.control.StateMatrices(np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), own * np.ones((1, 2)))

    for ask in (
        lambda own: fm.control.closed_loop(MODEL, gains(own)).growth,
        lambda own: fm.control.delayed(gains(own), 0.1, order=1).D[0, 0],
        lambda own: fm.control.delayed(LAG, own, order=1).D[0, 0],
    ):
        with pytest.raises(TypeError, match=r"returns a control\.StateSpace, which needs concrete numbers"):
            jax.grad(ask)(1.0)


def test_integrators_are_led_back_alike_where_gains_are_traced():
    """As with known numbers; an undamped pair of states and an integrator, seen by two outputs and by three."""
    a = np.array([[0.0, 3.0, 0.0, 1.0], [-3.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0], [0.0, 0.0, 0.0, -5.0]])
    c = np.random.default_rng(0).standard_normal((3, 4))
    np.testing.assert_allclose(jax.jit(lambda c: windup_of(a, c, False))(c), windup_of(a, c, False), atol=1e-13)
    assert jax.jit(lambda c: windup_of(np.array([[-1.0]]), c, False) is None)(np.ones((1, 1)))
    assert np.all(np.isnan(windup_of(a, c[:2], False)))

    def limited(a, **tracking):
        gains = fm.control.StateMatrices(a, np.ones((1, 1)), np.ones((1, 1)), np.ones((1, 1)))
        fm.control.saturated(gains, 1.0, **tracking)
        return a

    with pytest.raises(fm.ModelError, match="or its A is traced"):
        jax.jit(limited)(np.zeros((1, 1)))
    with pytest.raises(fm.ModelError, match="unknown since A is traced"):
        jax.jit(lambda a: limited(a, tracking=0.1))(np.zeros((1, 1)))
    jax.jit(lambda a: limited(a, tracking=np.inf))(np.zeros((1, 1)))


# -- the closed loop ----------------------------------------------------------------------------------------------


def test_margins_of_a_mass_under_pd_by_hand():
    """L = (kd s + kp)/(m s^2): |L| = 1 gives the crossover, the phase margin is atan(kd w/kp)."""
    kp, kd = 300.0, 12.0
    mass = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1 / MASS]], [[1.0, 0.0], [0.0, 1.0]], 0)
    found = fm.control.closed_loop(mass, control.ss([], [], [], [[kp, kd]]))
    w2 = (kd**2 + np.sqrt(kd**4 + 4 * MASS**2 * kp**2)) / (2 * MASS**2)
    (own,) = found.margins
    assert own.crossover == approx(np.sqrt(w2) / (2 * np.pi), rel=1e-6)
    assert own.phase == approx(np.degrees(np.arctan(kd * np.sqrt(w2) / kp)), rel=1e-6)
    assert own.gain == np.inf
    # The controller that sees y itself needs the other sign.
    other = fm.control.closed_loop(mass, control.ss([], [], [], [[-kp, -kd]]), sign=1)
    np.testing.assert_allclose(other.poles, found.poles)
    assert other.margins[0].phase == approx(own.phase)


def test_margins_of_two_loops_are_each_with_the_other_closed():
    """Two masses on a spring, each held by its own gains: of one the other is part of the plant."""
    k, kp, kd = 50.0, np.array([200.0, 90.0]), np.array([4.0, 7.0])
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [k * np.array([[-1, 1], [1, -1]]), np.zeros((2, 2))]])
    two = control.ss(a, np.eye(4)[:, 2:], np.eye(4), 0)
    found = fm.control.closed_loop(two, control.ss([], [], [], np.hstack([np.diag(kp), np.diag(kd)])))
    s = 2j * np.pi * found.margins[0].crossover
    there = k + s**2 + kp[1] + kd[1] * s
    opened = (kp[0] + kd[0] * s) / (k + s**2 - k**2 / there)
    assert abs(opened) == approx(1, abs=1e-10)
    assert found.margins[0].phase == approx(180 + np.degrees(np.angle(opened)), abs=1e-8)


@pytest.mark.parametrize("gain", [3.0, 10.0, 100.0])
@pytest.mark.parametrize("damping", [0.0, 0.01, 1.0])
def test_margins_of_lightly_damped_loops_are_those_of_their_polynomials(damping, gain):
    """Crossovers lie beside the closed loop's poles, whose damping ratios are from 1e-7 on, far from the open loop's.

    A carriage of 2 kg that pushes half a kilogram by a spring; of four states, polynomials are right.
    """
    m, k, d = np.array([2.0, 0.5]), np.array([500.0, 2e4]), np.array([damping, 1.0])
    inner, outer = np.array([[1.0, -1], [-1, 1]]), np.array([[1.0, 0], [0, 0]])
    own = [-(one[0] * outer + one[1] * inner) / m[:, None] for one in (k, d)]
    a = np.block([[np.zeros((2, 2)), np.eye(2)], own])
    stage = control.ss(a, [[0.0], [0], [1 / m[0]], [0]], [[0.0, 1, 0, 0]], 0)
    found = fm.control.closed_loop(stage, control.ss([], [], [], [[gain]]))
    assert found.stable
    (own,) = found.margins
    gains, phases, moduli, _, crossovers, _ = control.stability_margins(control.tf(found.opened), returnall=True)
    assert own.gain == approx(min(gains, key=lambda one: abs(np.log(one))), rel=1e-6)
    # Roots of polynomials of the eighth degree, which are nearly double.
    assert own.modulus == approx(min(moduli), rel=1e-4, abs=1e-9)
    if len(phases):
        at = np.argmin(np.abs(phases))
        assert own.phase == approx(phases[at], rel=1e-4, abs=1e-9)
        assert own.crossover == approx(crossovers[at] / (2 * np.pi), rel=1e-6)
    else:
        assert own.phase == np.inf


def lag(gain, rate=1.0) -> Any:
    return control.ss([[-rate]], [[1.0]], [[gain]], [[0.0]])


UNIT: Any = control.ss([], [], [], [[1.0]])


@pytest.mark.parametrize("gain", [20.0, 1e3, 1e6])
def test_a_crossover_far_beyond_the_poles_is_found(gain):
    """gain/(s + 1): |L| = 1 at the root of gain^2 - 1, with the phase of that left to -180 degrees."""
    (own,) = fm.control.closed_loop(lag(gain), UNIT).margins
    rate = np.sqrt(gain**2 - 1)
    assert own.crossover == approx(rate / (2 * np.pi), rel=1e-9)
    assert own.phase == approx(180 - np.degrees(np.arctan(rate)), rel=1e-9)
    assert own.gain == np.inf


@pytest.mark.parametrize(("d", "gain"), [(-0.9, 1 / 0.9), (-0.5, 2.0), (0.5, np.inf)])
def test_a_gain_that_passes_at_once_has_its_margin_at_the_highest_frequency(d, gain):
    """What is passed on without delay loses its solution where it is -1: s^2 d/(s^2 + s + 4), and d alone."""
    for plant in (control.tf([d, 0, 0], [1, 1, 4]), control.ss([], [], [], [[d]])):
        (own,) = fm.control.closed_loop(control.ss(plant), UNIT).margins
        assert own.gain == approx(gain, rel=1e-12)
        assert own.modulus <= 1 + d + 1e-12


def test_a_free_mass_has_no_margin_at_rest_whatever_its_coordinates():
    """Two poles at the origin, which round-off parts by its root."""
    s: Any = control.tf("s")
    phase = control.stability_margins((1 / s**2 + 0.1 / (s**2 + s + 900)) * (s + 4))[1]
    for seed in range(20):
        turn = np.random.default_rng(seed).standard_normal((4, 4))
        a = np.zeros((4, 4))
        a[0, 2], a[1, 3], a[3, 1], a[3, 3] = 1.0, 1.0, -900.0, -1.0
        b, c = np.array([[0.0], [0], [1], [1]]), np.array([[1.0, 0.1, 0, 0], [0, 0, 1, 0.1]])
        free = control.ss(turn @ a @ np.linalg.inv(turn), turn @ b, c @ np.linalg.inv(turn), 0)
        (own,) = fm.control.closed_loop(free, control.ss([], [], [], [[4.0, 1.0]])).margins
        assert own.gain == np.inf
        assert own.phase == approx(phase, rel=1e-6)


@pytest.mark.filterwarnings("ignore:The closed loop is unstable")
@pytest.mark.parametrize("period", [0, 1e-3])
def test_a_rigid_motion_that_the_loop_does_not_see_hides_no_margin_at_rest(period):
    """Positive feedback of the stretch of a spring by a force in it: it falls over at its stiffness."""
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [100 * np.array([[-1.0, 1], [1, -1]]), np.zeros((2, 2))]])
    free = control.ss(a, [[0.0], [0], [-1], [1]], [[-1.0, 1.0, 0, 0]], 0)
    lag: Any = control.ss(control.tf([-80.0 * 144], [1, 12, 144]))
    (own,) = fm.control.closed_loop(free, lag.sample(period) if period else lag).margins
    assert own.gain == approx(100 / 80, rel=1e-6)
    assert own.gain_hertz == 0
    assert own.modulus == approx(0.2, rel=1e-6)


@pytest.mark.parametrize(("light", "fastest"), [(1e-3, 1e4), (1e-3, 1e7), (2e-5, 1e4), (1e-5, 500.0)])
def test_undamped_motions_of_weak_coupling_have_no_margins_of_their_own(light, fastest):
    """PD on a carriage, whatever it carries: a phase jumps at every undamped pole and zero, and crosses nothing.

    What it carries swings at 200 rad/s; a stiff part leaves the round-off that blurs the others.
    """
    carried = light * np.array([1.0, 1e-2])
    stiff = carried * np.array([200.0, fastest]) ** 2
    sums = np.array([[-np.sum(stiff), *stiff], [stiff[0], -stiff[0], 0], [stiff[1], 0, -stiff[1]]])
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [sums / np.array([[2.0], *carried[:, None]]), np.zeros((3, 3))]])
    stage = control.ss(a, np.eye(6)[:, [3]] / 2, np.eye(6)[[0, 3]], 0)
    (own,) = fm.control.closed_loop(stage, control.ss([], [], [], [[2400.0, 120.0]])).margins
    assert own.gain == np.inf
    # Of the carriage alone: m w^2 = |kp + i kd w|.
    w = np.sqrt((120.0**2 + np.sqrt(120.0**4 + 16 * 2400.0**2)) / 8)
    assert own.phase == approx(np.degrees(np.arctan(120 * w / 2400)), abs=0.05)


@pytest.mark.filterwarnings("ignore:The closed loop is unstable")
@pytest.mark.parametrize(
    "sections",
    [
        [([1, 1.61e-5, 76591.8], [1, 1.61e-5, 76591.75]), ([-0.329114, 23.0841], [1, 70.101]), ([1, 0], [1, 3])],
        [
            ([-40.83, -38260], [1, 937.1]),
            ([1, -42.38], [1, -55.64]),
            ([1, 0.5776, 8752], [1, 0.194, 986.9]),
            ([1, 0], [1, 3]),
        ],
    ],
)
def test_the_least_distance_is_found_in_a_dip_as_narrow_as_its_poles(sections):
    """Beside poles of the closed loop with damping ratios of 3e-8 and 4e-3, against rows of frequencies."""
    loop = UNIT
    for numerator, denominator in sections:
        loop = control.ss(control.tf(numerator, denominator)) * loop
    found = fm.control.closed_loop(loop, UNIT)
    w = np.abs(found.poles) + np.abs(np.real(found.poles)) * np.linspace(-2, 2, 200_001)[:, None]
    response = np.prod([np.polyval(above, 1j * w) / np.polyval(below, 1j * w) for above, below in sections], axis=0)
    assert found.margins[0].modulus == approx(np.min(np.abs(1 + response)), rel=1e-6)


@pytest.mark.filterwarnings("ignore:The closed loop is unstable")
def test_two_crossings_close_to_each_other_are_found():
    """Beside a resonance a phase goes a little beyond -180 degrees and back, with no pole or zero between."""
    poles = np.poly([-4.71493307e-03 + 267.15741282j, -4.71493307e-03 - 267.15741282j, 18.0931465])
    loop = control.tf(-1.0 * np.poly([-42.78801335, -1130.36046738]), poles)
    (own,) = fm.control.closed_loop(control.ss(loop), UNIT).margins
    gains = control.stability_margins(loop, returnall=True)[0]
    assert own.gain == approx(min(gains, key=lambda one: abs(np.log(one))), rel=1e-6)


@pytest.mark.filterwarnings("ignore:The closed loop is unstable")
@pytest.mark.parametrize(("sign", "gain"), [(1, 4.0), (-1, np.inf)])
def test_a_phase_that_jumps_at_an_undamped_pole_crosses_nothing(sign, gain):
    """A lag before an undamped oscillator: the phase falls by 180 degrees at once, where the gain is infinite.

    Fed back with the other sign it falls over at rest, where four times its static gain is one.
    """
    oscillator = control.ss([[0.0, 1.0], [-4.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0)
    found = fm.control.closed_loop(oscillator, control.ss([[-3.0]], [[3.0]], [[1.0]], [[0.0]]), sign=sign)
    assert found.margins[0].gain == approx(gain, rel=1e-12)
    # Of its rate there is nothing at rest.
    found = fm.control.closed_loop(oscillator, control.ss([[-3.0]], [[3.0]], [[-3.0]], [[3.0]]), sign=sign)
    assert found.margins[0].gain == np.inf


@pytest.mark.slow
def test_an_unstable_loop_is_reported_and_its_motion_is_refused():
    wrong = -1.0 * pid()
    wrong = control.ss(wrong, inputs=["place"], outputs=["force"])
    with pytest.warns(fm.FlexmbWarning, match=r"unstable: its pole at .* double every") as said:
        found = fm.control.closed_loop(MODEL, wrong)
    assert not found.stable
    assert f"{np.log(2) / found.growth:.3g} s" in str(next(w for w in said if w.category is fm.FlexmbWarning).message)
    with pytest.raises(fm.AnalysisError, match="closed_loop") as fault:
        fm.simulate(MODEL, [0.0, 10.0], control=wrong, reference=held)
    assert fault.value.code == "ran_away"


@pytest.mark.parametrize(("rate", "stable"), [(-5e-3, True), (0.0, False), (5e-3, False)])
def test_a_slow_motion_beside_a_stiff_one_is_told_from_one_that_stays(rate, stable):
    """The speed of a mass of 30 rad/s is fed back, with one of 1e7 rad/s beside it, which leaves its pole as it is."""
    own = [control.tf([1, 0], [1, 2 * d, w**2]) for w, d in ((30.0, 0.0), (1e7, 5e4))]
    plant: Any = control.append(*[control.ss(one) for one in own])
    with (
        pytest.warns(fm.FlexmbWarning, match=r"pole at 0\.005.30j .* of 4\.775 Hz")
        if rate > 0
        else contextlib.nullcontext()
    ):
        found = fm.control.closed_loop(plant, control.ss([], [], [], np.diag([-2 * rate, 0.0])))
    assert found.stable is stable
    assert found.growth == approx(rate, rel=1e-6, abs=1e-8)
    word = "stable" if stable else "unstable" if rate else "neither decays nor grows"
    assert found.summary().title == f"ClosedLoop: {word}, 4 poles"


def test_a_sampled_loop_is_stable_as_long_as_its_poles_are_within_the_circle():
    """A gain on the velocity of one free mass, held over h: z = 1 - K h/m, stable up to K = 2 m/h."""
    h = 0.1
    free = control.ss([[0.0]], [[1 / MASS]], [[1.0]], [[0.0]])
    for gain, stable in ((1.9 * MASS / h, True), (0.5 * MASS / h, True)):
        found = fm.control.closed_loop(free, control.ss([], [], [], [[gain]], h))
        np.testing.assert_allclose(np.exp(found.poles * h), [1 - gain * h / MASS])
        assert found.stable is stable
        # Opened, K h/m (1/(z - 1)): its gain margin at z = -1 is 2 m/(K h).
    with pytest.warns(fm.FlexmbWarning, match=r"of 5 Hz double every"):
        assert not fm.control.closed_loop(free, control.ss([], [], [], [[2.1 * MASS / h]], h)).stable


@pytest.mark.slow("0.8")
@pytest.mark.parametrize("gain", [0.8, 3.0])
def test_a_sampled_loop_feels_at_its_samples_what_it_gave_before(gain):
    """A gain on an acceleration, held over h: it goes on by -K/m from sample to sample, as the motion shows."""
    b = sprung_mass(stiffness=STIFFNESS, damping=DAMPING, mass=1.0)
    b.input("mass", "x", name="force")
    b.output("mass", "x", "acceleration", name="a")
    model, h = b.build(), 1e-4
    sampled: Any = control.ss([], [], [], [[gain]], h)
    with pytest.warns(fm.FlexmbWarning, match="unstable") if gain > 1 else contextlib.nullcontext():
        found = fm.control.closed_loop(model, sampled)
    assert found.stable is (gain < 1)
    fastest = found.poles[np.argmax(np.abs(found.poles))]
    # The spring adds h^2 k/m, the damper h d/m.
    np.testing.assert_allclose(np.exp(fastest * h), -gain, rtol=2e-4)
    # At the highest frequency, pi/h, it is unstable where the gain times 1/m is one.
    np.testing.assert_allclose([found.margins[0].gain, found.margins[0].gain_hertz], [1 / gain, 0.5 / h], rtol=2e-4)
    u = fm.simulate(model, h * np.arange(9), control=sampled, reference=lambda t: 1e-3).u[:, 0]
    steps = np.diff(u[:-1])
    np.testing.assert_allclose(steps[1:] / steps[:-1], -gain, rtol=2e-3)


def hanging() -> fm.Model:
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("mass", (0, -0.5))
    b.rotation("rod")
    b.add(planar.rigid_beam, "pivot", "rod", "mass", name="arm")
    b.fix("pivot", "x", "y")
    b.mass("mass", 0.8)
    b.gravity((0, -9.81))
    b.dof("rod", "phi")
    b.input("rod", "phi", name="motor")
    b.output("rod", "phi", name="angle")
    return b.build()


@pytest.mark.slow
def test_a_closed_loop_of_small_amplitude_is_the_linear_one():
    """A pendulum, whose sine differs from its angle by the third power: half of it leaves a quarter of the error."""
    model, times, errors = hanging(), np.linspace(0, 1.0, 11), []
    controller = control.tf([20.0, 30.0], [0.01, 1])
    loop = fm.control.closed_loop(model, controller).system
    linear = control.forced_response(loop, times, np.ones(11)).outputs
    for amplitude in (0.1, 0.05):
        found = fm.simulate(model, times, control=controller, reference=lambda t, a=amplitude: a, rtol=1e-9)
        errors.append(np.max(np.abs(np.asarray(found.at("rod"))[:, 0] / amplitude - linear)))
    assert errors[0] < 2e-3
    assert errors[1] == approx(errors[0] / 4, rel=0.02)


@pytest.mark.slow
def test_a_loop_differentiates_by_a_dimension_and_by_a_gain():
    """Traced numbers in the mechanism and in the controller, forward and reverse, within limits: closed form."""
    none = jnp.zeros

    def answer(model, gain, **options):
        gains = jnp.stack([none(()), gain])[None]
        controller = fm.control.StateMatrices(none((0, 0)), none((0, 2)), none((1, 0)), gains)
        limited = fm.control.saturated(controller, 5.0)
        found = fm.simulate(model, [0, 0.1], control=limited, reference=held, rtol=1e-9, atol=1e-11, **options)
        return found.at("mass")[-1, 0]

    def exact(stiffness, gain):
        return oscillation(0.1, stiffness + gain, DAMPING, MASS, gain * STEP)[0]

    at, step = np.array([STIFFNESS, 60.0]), 1e-2
    differences = [(exact(*(at + step * way)) - exact(*(at - step * way))) / (2 * step) for way in np.eye(2)]
    forward = fm.jit(
        lambda k, g: jax.jvp(lambda k: answer(sprung(k), g, adjoint=diffrax.ForwardMode()), (k,), (1.0,))[1]
    )
    reverse = fm.jit(jax.grad(lambda g: answer(MODEL, g)))
    # Ten times the tolerance of the integration.
    np.testing.assert_allclose(forward(*at), differences[0], rtol=1e-6)
    np.testing.assert_allclose(reverse(at[1]), differences[1], rtol=1e-6)


@pytest.mark.slow
def test_an_event_between_samples_ends_the_motion_without_a_failure():
    """A mass on a spring passes its middle after a quarter of a period; what observes it does nothing."""
    b = sprung_mass(stiffness=STIFFNESS, damping=0.0, mass=MASS)
    b.input("mass", "x")
    b.output("mass", "x")
    b.start("mass", "x", 0.1)
    quarter = np.pi / 2 / np.sqrt(STIFFNESS / MASS)
    event = diffrax.Event(lambda t, y, args, **_: y.u[0])
    idle = control.ss([], [], [], [[0.0]], 0.03)
    model = b.build()
    found = fm.simulate(model, np.linspace(0, 1.9 * quarter, 9), control=idle, event=event)
    assert found.result == fm.RESULTS.successful
    reached = np.isfinite(np.asarray(found.x)).all(axis=1)
    np.testing.assert_array_equal(reached, np.arange(9) < 5)
    np.testing.assert_allclose(place(found)[:5], 0.1 * np.cos(np.arange(5) * 1.9 / 16 * np.pi), atol=1e-6)
    # No answer about what was not reached.
    for ask in (
        lambda: fm.frequencies(model, at=found, step=-1),
        lambda: fm.motion.linearize_motion(found),
        lambda: fm.linear.section_resultants(model, at=found),
    ):
        with pytest.raises(fm.ModelError, match=r"has 5 of 9 states.*give motion.until\(5\)"):
            ask()
