"""Linear time-varying systems: the elevator against equations written by hand, reductions, and files."""

import contextlib
import dataclasses

import control
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.interpolate
import scipy.io
import scipy.linalg
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar
from flexmb.mechanisms import mechanism_path
from flexmb.trajectory.linear_along import TimeVarying
from flexmb.trajectory.varying_equations import cubic_spline, integrate_varying

# The shipped elevator: radius, free length, mass of a weight, inertia of the pulley, EA and EdA of the belts, motor.
RADIUS, FREE, WEIGHT, INERTIA, EA, EDA, MOTOR, DAMPER = 0.1, 0.2, 10.0, 0.3, 1000.0, 2.5, 12.5, 3.0
SIGN = np.array([1.0, -1.0])
DEPTH = np.array([[RADIUS, 1, 0], [-RADIUS, 0, 1]])
MASSES = WEIGHT * DEPTH.T @ DEPTH + np.diag([INERTIA, 0, 0])
TIMES = np.linspace(0, 1, 101)


@pytest.fixture(scope="module")
def elevator():
    model = fm.read_spacar(mechanism_path("elevator")).builder.build(dofs="named")
    motion = fm.simulate(model, TIMES, rtol=1e-8)
    return fm.trajectory.time_varying(motion)


def forces(state):
    """Generalised forces on the turn of the pulley and the elongations of the belts, by Lagrange's equations."""
    phi, e, phid, ed = state[0], state[1:3], state[3], state[4:]
    lengths = FREE + SIGN * RADIUS * phi
    moment = -MOTOR * phi - DAMPER * phid + jnp.sum(SIGN * RADIUS * EA * e**2 / (2 * lengths**2))
    return jnp.concatenate([moment[None], -(EA * e + EDA * ed) / lengths])


@pytest.mark.slow("3", "9")
@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_spline_is_that_of_scipy(count):
    # One test would do for all counts but that the ends of short ones are special.
    rng = np.random.default_rng(count)
    t, y = np.sort(rng.random(count)), rng.random((count, 2, 3))
    own, scipys = cubic_spline(jnp.asarray(t), jnp.asarray(y)), scipy.interpolate.CubicSpline(t, y)
    at = np.linspace(-0.1, 1.1, 7)
    found = np.array([own(s) for s in at])
    # Round-off, times what extrapolation makes of it.
    np.testing.assert_allclose(found, scipys(at), atol=1e-13 * np.max(np.abs(scipys(at))))


def test_steps_are_of_order_five_against_a_closed_form():
    # q = sin(t)/t solves q'' + 2 q'/t + q = 0; without mass, 2 q'/t + q = 0 has q = exp(-t^2/4).
    def equation(t):
        return jnp.diag(jnp.array([1.0, 0.0])), 2 / t * jnp.eye(2), jnp.eye(2), jnp.zeros(2)

    times = jnp.linspace(1.0, 6.0, 6)
    slow, fall = np.exp(-0.25), -0.5 * np.exp(-0.25)
    start = jnp.array([np.sin(1.0), slow]), jnp.array([np.cos(1.0) - np.sin(1.0), fall])
    exact = np.array([np.sin(6.0) / 6, np.exp(-9.0)])
    run = fm.jit(lambda count: integrate_varying(equation, times, *start, count)[0][-1])
    errors = np.array([np.abs(run(jnp.asarray(k)) - exact) for k in (2, 4, 8)])
    assert np.all(errors[:-1] / errors[1:] > 2**4.5)
    assert np.all(errors[-1] < 1e-8)


@pytest.mark.slow
def test_elevator_at_the_begin(elevator):
    # By hand: the belts are slack, so that nothing but their own stiffness holds the weights.
    stiffness = np.diag([MOTOR, EA / (FREE + RADIUS), EA / (FREE - RADIUS)])
    by_hand = np.sqrt(scipy.linalg.eigh(stiffness, MASSES, eigvals_only=True)) / (2 * np.pi)
    found = elevator.frequencies()[0]
    np.testing.assert_allclose(found, by_hand, rtol=1e-9)
    # Printed digits.
    np.testing.assert_allclose(found, [0.7876, 3.2199, 5.9244], atol=0.5e-4)
    np.testing.assert_allclose(elevator.z0, [1, 0, 0, 0, 0, 0], atol=1e-12)


@pytest.mark.slow
def test_response_of_the_elevator_against_an_integration_by_scipy(elevator):
    """Motion and what is linear about it, both by hand, driven by a moment that is linear between the times."""
    moment = np.sin(7 * TIMES)
    start = np.array([0.0, 1e-3, 0, 0, 0, -0.02])
    slope = jax.jit(jax.jacfwd(forces))
    inverse = np.linalg.inv(MASSES)

    def rates(t, both):
        nominal, small = both[:6], both[6:]
        forced = np.array([-np.interp(t, TIMES, moment), 0, 0])
        own = inverse @ np.asarray(forces(nominal))
        return np.concatenate([nominal[3:], own, small[3:], inverse @ (np.asarray(slope(nominal)) @ small + forced)])

    begin = np.concatenate([[1.0, 0, 0, 0, 0, 0], start])
    exact = solve_ivp(rates, (0, 1), begin, rtol=1e-8, atol=1e-11, t_eval=TIMES, max_step=0.01).y[6:]
    found = elevator.response(TIMES, {"stress 1.1": moment}, start, rtol=1e-8)
    assert found.output_labels == ["deformation 1 1", "deformation 2 1", "deformation 3 1"]
    # The motion is good to 1e-7 of its largest deflection, and so are the matrices; splines 10 ms apart leave less.
    np.testing.assert_allclose(found.states, exact, atol=1e-6 * np.max(np.abs(exact)))
    np.testing.assert_allclose(found.outputs, exact[:3], atol=1e-6 * np.max(np.abs(exact[:3])))


def test_tolerance_beside_a_number_of_steps_is_refused():
    times, one = np.arange(3.0), np.ones((3, 1, 1))
    a, b, c, mass = np.zeros((3, 2, 2)), np.ones((3, 2, 1)), np.ones((3, 1, 2)), one
    along = np.zeros((3, 1)), np.zeros((3, 1)), np.zeros(2), np.zeros((3, 0))
    system = TimeVarying(times, a, b, c, 0 * one, mass, *along, None, None, None, ("q", "d q"), ("u",), ("y",))
    with pytest.raises(ValueError, match="either `rtol` or `substeps`"):
        system.solution(times, np.zeros(3), rtol=1e-9, substeps=1)
    with pytest.raises(ValueError, match="Under a trace the number of steps is fixed"):
        jax.jit(lambda u: system.solution(times, u, rtol=1e-9))(np.zeros(3))


@pytest.mark.slow
def test_response_of_a_system_that_stays_is_that_of_control(elevator):
    times, u = np.linspace(0.0, 0.5, 26), np.cos(9 * np.linspace(0.0, 0.5, 26))
    # All of it as it is in one moment.
    whole = {name: getattr(elevator, name) for name in "ABCDM"}
    frozen = {name: jnp.broadcast_to(of[40], of.shape) for name, of in whole.items()}
    still = dataclasses.replace(elevator, **frozen)
    found = still.response(times, u, rtol=1e-9)
    known = control.forced_response(elevator.statespace(TIMES[40]), times, u)
    exact = known.outputs.reshape(found.outputs.shape)
    np.testing.assert_allclose(found.outputs, exact, atol=1e-8 * np.max(np.abs(exact)))


@pytest.mark.slow
def test_reduction(elevator):
    whole = elevator.reduced(3)
    np.testing.assert_allclose(whole.frequencies(), elevator.frequencies(), rtol=1e-9)
    few = elevator.reduced(2)
    assert few.state_labels == ("mode 1", "mode 2", "d mode 1", "d mode 2")
    np.testing.assert_allclose(few.left_out, elevator.frequencies()[:, 2])
    # By Rayleigh's principle frequencies of a part of the motions are not below those of all, where all is at rest.
    assert np.all(few.frequencies()[0] > elevator.frequencies()[0, :2] * (1 - 1e-9))
    assert few.error[0] < 2e-3
    assert few.error[1] < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_file_has_the_names_of_spacar(elevator, tmp_path, ending):
    path = tmp_path / f"elevator.{ending}"
    elevator.save(path)
    with np.load(path) if ending == "npz" else contextlib.nullcontext(scipy.io.loadmat(path, squeeze_me=True)) as file:
        numbers = {name: int(file[name]) for name in ("NNOM", "NX", "NU", "NY", "DFT")}
        assert numbers == {"NNOM": 1, "NX": 6, "NU": 1, "NY": 3, "DFT": 0}
        assert "G" not in file
        # A row a time, column by column, as MATLAB's reshape(A(k, :), NX, NX) takes it.
        np.testing.assert_array_equal(file["A"][7].reshape(6, 6, order="F"), elevator.A[7])
        np.testing.assert_array_equal(file["C"][7].reshape(3, 6, order="F"), elevator.C[7])
        np.testing.assert_allclose(file["M0"][7].reshape(3, 3, order="F"), MASSES, rtol=1e-9)
        damping = np.diag([DAMPER, *EDA / (FREE + SIGN * RADIUS)])
        np.testing.assert_allclose(file["C0B"][0].reshape(3, 3, order="F"), damping, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(file["Y0"][0], [1, 0, 0], atol=1e-12)
        assert file["U0"].size == len(TIMES)
        assert str(file["inputs"] if ending == "mat" else file["inputs"][0]) == "stress 1.1"


@pytest.mark.slow
def test_an_input_that_moves_a_support():
    """A mass on a spring whose foot is accelerated: its states and those of the foot, by hand."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1, 0))
    b.add(planar.truss, "foot", "mass", section=fm.Rigidity(EA=100.0))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", 4.0)
    b.dof("mass", "x")
    b.input("foot", "x", "acceleration", name="floor")
    b.output("mass", "x")
    system = fm.trajectory.time_varying(fm.simulate(b.build(), np.linspace(0, 1, 5)))
    # 4 x'' = 100 (foot - x) and foot'' = u: from u to x a gain of 25/((s^2 + 25) s^2).
    states = zip(*(np.asarray(of) for of in (system.A, system.B, system.C)), strict=True)
    gains = [(c @ np.linalg.solve(2j * np.eye(4) - a, b)).item() for a, b, c in states]
    np.testing.assert_allclose(gains, 25 / ((25 - 4) * -4), rtol=1e-12)
    np.testing.assert_allclose(system.y0, 0.0, atol=1e-12)


def test_what_cannot_be_asked_says_so(elevator):
    with pytest.raises(ValueError, match="within the times of the system, 0 to 1 s"):
        elevator(1.1)
    with pytest.raises(ValueError, match=r"no input 'moment'; there is stress 1\.1"):
        elevator.response(TIMES, {"moment": TIMES})
    with pytest.raises(ValueError, match="a column for each time"):
        elevator.response(TIMES, TIMES[1:])
    with pytest.raises(ValueError, match="each of the 6 states"):
        elevator.response(TIMES, initial=[1.0])
    with pytest.raises(ValueError, match="`initial` has a value that is not a finite number"):
        elevator.solution(TIMES, initial=np.full(6, np.nan))
    with pytest.raises(ValueError, match="`u` has a value that is not a finite number"):
        elevator.solution(TIMES, np.full(len(TIMES), np.inf))
    with pytest.raises(ValueError, match="without a time twice"):
        elevator.solution([0.0, 0.0])
    with pytest.raises(ValueError, match="`modes`"):
        elevator.reduced(4)
    with pytest.raises(TypeError, match="takes a Motion"):
        fm.trajectory.time_varying(3)


def test_frequencies_of_what_is_traced_are_refused(elevator):
    with pytest.raises(TypeError, match=r"outside jax\.jit, jax\.grad"):
        jax.jit(lambda a: dataclasses.replace(elevator, A=a).frequencies())(elevator.A)


@pytest.mark.slow
@pytest.mark.parametrize("what", [fm.trajectory.time_varying, fm.trajectory.perturbation])
def test_a_motion_past_a_dead_point_of_its_freedoms_is_refused(what):
    """A pendulum by its x, which is stationary where it lies level; to a quarter turn it may be told by that."""
    b = fm.Builder()
    b.node("o", (0, 0))
    b.node("t", (0, -0.5))
    b.add(planar.rigid_beam, "o", "t")
    b.fix("o", "x", "y")
    b.mass("t", 2.0)
    b.dof("t", "x")
    b.start("t", "x", 0.0, velocity=6.0)
    b.input("t", "x")
    b.output("t", "x")
    motion = fm.simulate(b.build(), np.linspace(0, 0.2, 21), rtol=1e-9)
    # 12 rad/s: a quarter turn after 0.1309 s.
    with pytest.raises(fm.AnalysisError, match=r"Between t = 0\.13 and 0\.14 s .* \(t\.x\) do not determine") as told:
        what(motion)
    assert told.value.code == "singular_configuration"
    what(motion.until(13))
