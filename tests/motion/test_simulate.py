"""Nonlinear motion against closed forms, printed solutions of independent integrations, and conservation laws."""

import dataclasses
import json
from typing import Any

import control
import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import motions
from cases.files import arrays_of
from cases.mechanisms import planar_guide
from cases.motions import meshing_wheels
from jax.tree_util import Partial
from references import motion_references as reference
from references.balances import energy_rate
from scipy.integrate import solve_ivp
from scipy.io import loadmat

import flexmb as fm
from flexmb import planar
from flexmb.motion.simulate import Keywords


@pytest.fixture(scope="module")
def pendulum():
    return motions.pendulum().build()


# As many as in test_motion_problems.py, with which it shares compiled code.
TIMES = np.linspace(0, 10, 601)
PENDULUM = (-0.2750874626, -0.9614192051)  # REFERENCES D5, closed form, t = 10


@pytest.fixture(scope="module")
def swing(pendulum):
    return fm.simulate(pendulum, TIMES, rtol=1e-9)


@pytest.mark.slow
def test_pendulum_in_all_coordinates(swing):
    # Global error over four swings: some hundred times the tolerance of one step.
    np.testing.assert_allclose(swing.at("mass")[-1], PENDULUM, atol=2e-7)
    seen = swing.observe()
    assert np.ptp(seen.energy) < 1e-7 * np.max(seen.kinetic)
    # Round-off of the projection.
    assert np.max(np.abs(seen.e)) < 1e-14
    assert np.max(np.abs(seen.ed)) < 1e-13


@pytest.mark.slow
def test_a_motion_begins_with_the_velocity_of_its_configuration(pendulum, swing):
    """On from the middle of another motion, told by degrees of freedom: it ends where that one does."""
    middle = 300
    phi, rate = swing.at("rod")[middle], swing.velocity("rod")[middle]
    start = fm.configuration(pendulum, q=phi, qd=rate)
    found = fm.simulate(pendulum, TIMES[: len(TIMES) - middle], initial=start, rtol=1e-9)
    np.testing.assert_allclose(found.velocity("mass")[0], swing.velocity("mass")[middle], atol=1e-12)
    np.testing.assert_allclose(found.at("mass")[-1], PENDULUM, atol=2e-7)
    # Within a trace one state of a motion that is known is traced, and what is asked of it.
    on = jax.eval_shape(lambda share: fm.simulate(pendulum, share * TIMES[:3], initial=swing).x, 1.0)
    assert on.shape == (3, swing.x.shape[1])


@pytest.mark.slow
def test_pendulum_by_an_explicit_solver(pendulum):
    found = fm.simulate(pendulum, TIMES, rtol=1e-9, atol=1e-9, solver=diffrax.Dopri8())
    np.testing.assert_allclose(found.at("mass")[-1], PENDULUM, atol=2e-7)
    assert found.solver == "Dopri8"


@pytest.mark.slow
def test_pendulum_by_an_implicit_solver_of_diffrax(pendulum):
    """Its root finder takes the tolerances of the steps."""
    found = fm.simulate(pendulum, np.array([0.0, 1.0]), rtol=1e-8, atol=1e-8, solver=diffrax.Kvaerno5())
    np.testing.assert_allclose(found.at("mass"), reference.pendulum([0.0, 1.0])["position"], atol=1e-7)


@pytest.mark.slow
def test_order_of_the_default_solver(pendulum):
    """Fixed steps: the error falls with the fifth power of the step."""
    errors = []
    for steps in (100, 200):
        found = fm.simulate(
            pendulum,
            np.array([0.0, 2.0]),
            controller=diffrax.ConstantStepSize(),
            dt0=2.0 / steps,
            solver=fm.motion.Rodas5P(),
        )
        exact = solve_ivp(lambda t, y: [y[1], -9.81 * np.cos(y[0] + np.pi)], (0, 2), [0, 0], rtol=1e-13, atol=1e-13)
        angle = exact.y[0, -1]
        errors.append(abs(float(found.at("rod")[-1, 0]) - angle))
    assert np.log2(errors[0] / errors[1]) > 4.5, errors


# REFERENCES D5: theta, its rate and the energy (zero potential at theta = 0) at t = 10; round-off becomes 3e-8 in ten
# passages of the position where both loops lose rank.
FOUR_BARS, ENERGY = (-30.179800860189, -1.506642181), 35.835


@pytest.mark.slow
def test_four_bars_pass_their_singular_position():
    """At theta = 0 and pi the constraints lose rank: both loops must stay on the branch of the parallelogram."""
    found = fm.simulate(motions.four_bars(2).build(), np.linspace(0, 10, 21), rtol=1e-11)
    assert abs(float(found.at("crank0")[-1, 0]) + np.pi / 2 - FOUR_BARS[0]) < 1e-7
    assert abs(float(found.velocity("crank0")[-1, 0]) - FOUR_BARS[1]) < 5e-7
    np.testing.assert_allclose(found.at("crank1"), found.at("crank0"), atol=1e-7)
    seen = found.observe()
    np.testing.assert_allclose(seen.energy, seen.energy[0], atol=1e-7 * ENERGY)
    assert np.max(np.abs(seen.e)) < 1e-9


@pytest.mark.slow
def test_loads_as_functions_of_time():
    """A mass on a spring under a force that ramps up and stays: closed form, with the bend stepped onto."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="spring", section=fm.Rigidity(EA=400.0))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    b.dof("mass", "x")
    model = b.build()
    times = np.array([0, 0.5, 1.0, 2.0])
    table = fm.motion.Table(jnp.array([0.0, 0.7, 3.0]), jnp.array([0.0, 7.0, 7.0]))
    found = fm.simulate(model, times, loads={"mass.x": table}, rtol=1e-9)
    omega = 20.0

    def ramp(t):
        return 10.0 * np.where(t > 0, t - np.sin(omega * t) / omega, 0.0) / omega**2

    np.testing.assert_allclose(found.at("mass")[:, 0] - 1.0, ramp(times) - ramp(times - 0.7), atol=1e-9)
    # The same in records, of which a keyword changes what it names; None stands for what is not given.
    drives, integrator = fm.motion.Drives(loads={"mass.x": table}), fm.motion.Integrator(rtol=1e-3)
    again = fm.simulate(model, times, drives=drives, integrator=integrator, rtol=1e-9, atol=None)
    np.testing.assert_array_equal(again.x, found.x)
    assert again.steps != fm.simulate(model, times, drives=drives, integrator=integrator).steps


def oscillator():
    """A mass on a damped spring with a force and its place as input and output."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="s", section=fm.Rigidity(EA=100.0), damping=fm.Damping(EA=0.5))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    b.dof("mass", "x")
    b.input("mass", "x")
    b.output("mass", "x")
    return b.build()


@pytest.mark.slow
def test_plant_for_python_control():
    """Python-control's integration of the plant, against the equation of a driven pendulum."""
    b = motions.pendulum()
    b.input("rod", "phi", name="torque")
    b.output("rod", "phi", name="angle")
    times = np.linspace(0, 1, 6)
    plant = fm.control.to_nonlinear_system(b.build())
    assert (plant.ninputs, plant.noutputs, plant.nstates) == (1, 1, 2)
    torque = 4 * np.sin(times)
    driven = control.input_output_response(plant, times, torque, solve_ivp_kwargs={"rtol": 1e-9, "atol": 1e-10})

    def rate(t, y):
        # python-control draws straight lines between the inputs.
        return [y[1], 9.81 * np.cos(y[0]) + np.interp(t, times, torque)]

    exact = solve_ivp(rate, (0, 1), [0, 0], t_eval=times, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(np.ravel(driven.outputs), exact.y[0], atol=1e-6)


@pytest.mark.slow
def test_a_motion_is_saved_whole(swing, tmp_path):
    for ending in ("npz", "mat"):
        fm.save_motion(swing, tmp_path / f"run.{ending}")
        kept: Any = arrays_of(tmp_path / "run.npz") if ending == "npz" else loadmat(tmp_path / "run.mat")
        np.testing.assert_array_equal(kept["x"], swing.x)
        np.testing.assert_allclose(np.ravel(kept["kinetic"]), swing.observe().kinetic, rtol=1e-12)
        assert [str(name).strip() for name in kept["x_names"]] == [str(entry) for entry in swing.labels.x]
        about = json.loads(str(np.ravel(kept["about"])[0]))
        assert about["result"] == "successful"
        assert about["units"]["kinetic"] == "J"
    with pytest.raises(ValueError, match=r"saved as \.npz or \.mat"):
        fm.save_motion(swing, tmp_path / "run.csv")


def test_sampled_loop_of_a_linear_mechanism_is_that_of_control():
    """Zero-order hold is exact in discrete time; the controller sees the output at the sample."""
    model = oscillator()
    lead: Any = control.ss(control.tf([200, 3000], [1, 100]))
    lead = lead.sample(0.05)
    times = np.arange(0, 1.01, 0.025)
    found = fm.simulate(model, times, control=lead, reference=lambda t: jnp.array([0.01]), rtol=1e-8, atol=1e-9)
    plant: Any = fm.to_statespace(model)
    loop = control.feedback(plant.sample(0.05) * lead, 1)
    _, expected = control.step_response(loop, np.arange(0, 1.01, 0.05))
    np.testing.assert_allclose(found.at("mass")[::2, 0] - 1.0, 0.01 * np.asarray(expected), atol=1e-7)
    # Held in between.
    np.testing.assert_array_equal(found.u[:-1:2], found.u[1::2])
    with pytest.raises(fm.ModelError, match="sampled, but has no interval"):
        fm.simulate(model, times, control=control.ss([], [], [], [[1.0]], True))


@pytest.mark.slow
def test_closed_loop_of_a_linear_mechanism_is_that_of_control():
    model = oscillator()
    lead = control.ss(control.tf([200, 3000], [1, 100]))
    times = np.linspace(0, 2, 21)
    found = fm.simulate(model, times, control=lead, reference=lambda t: jnp.array([0.01]), rtol=1e-8, atol=1e-9)
    loop = control.feedback(fm.to_statespace(model) * lead, 1)
    _, expected = control.step_response(loop, times)
    np.testing.assert_allclose(found.at("mass")[:, 0] - 1.0, 0.01 * np.asarray(expected), atol=1e-7)
    seen = found.observe()
    loop = fm.motion.Loop(control=lead, reference=lambda t: jnp.array([0.01]))
    np.testing.assert_array_equal(fm.simulate(model, times, loop=loop, rtol=1e-8, atol=1e-9).u, found.u)
    assert found.u.shape == (21, 1)
    # What the controller puts in less what the damper takes is the change of energy, at every time: round-off over the
    # step of the differences, which have no other error where all is linear.
    power = np.asarray(seen.power)
    np.testing.assert_allclose(energy_rate(found, 1e-3), power, atol=1e-9 * np.max(np.abs(power)))
    velocity = np.asarray(found.velocity("mass"))[:, 0]
    np.testing.assert_allclose(power, np.asarray(found.u)[:, 0] * velocity - 0.5 * velocity**2, atol=1e-12)


@pytest.fixture(scope="module")
def guide():
    model = motions.released_guide().build()
    return model, fm.equilibrium(motions.pushed(model, "left2", 0, 0.945))


@pytest.mark.slow
def test_released_guide_against_an_explicit_integration(guide):
    """The bar of a guide with axial modes of 14 kHz, against diffrax's Dopri8 at small steps."""
    model, bent = guide
    times = np.linspace(0, 0.02, 5)
    found = fm.simulate(model, times, initial=bent, rtol=1e-6)
    tight = fm.simulate(model, times, initial=bent, rtol=1e-9, atol=1e-11, solver=diffrax.Dopri8())
    np.testing.assert_allclose(found.at("left2"), tight.at("left2"), atol=1e-8)
    assert int(found.steps) < int(tight.steps)


@pytest.mark.slow
def test_damped_beams_beside_a_rigid_one_swing_as_one_mass_on_a_damped_spring():
    """The rigid bar has no damping, so that damping and deformations of the beams are not of the same block."""
    b = planar_guide(ratio=0.05)
    b.start("left1", "x", 1e-4)
    model = b.build()
    lin = fm.linearize(model)
    m, d, k = (float(a[0, 0]) for a in (lin.M0, lin.D0, lin.K))
    times = np.linspace(0, 0.2, 21)
    found = fm.simulate(model, times, rtol=1e-8)
    decay, omega = d / (2 * m), np.sqrt(k / m - (d / (2 * m)) ** 2)
    swing = np.exp(-decay * times) * (np.cos(omega * times) + decay / omega * np.sin(omega * times))
    # A swing of 1e-3 of the length changes the frequency by some times the square of that, over 13 radians.
    np.testing.assert_allclose(found.at("left1")[:, 0] / 1e-4, swing, rtol=0, atol=2e-5)


def place(stiffness, **options):
    """Mass on a spring after 0.7 s, and the code of the result."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="spring", section=fm.Rigidity(EA=stiffness))
    b.fix("foot")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    b.dof("mass", "x")
    b.start("mass", "x", 0.1)
    found = fm.simulate(b.build(), np.array([0.0, 0.7]), rtol=1e-8, max_steps=2000, **options)
    return found.at("mass")[-1, 0], found.result


def exact_place(stiffness):
    """x = 1 + a cos(omega t) with omega^2 = EA / m, and its derivative by EA."""
    omega, t = np.sqrt(stiffness), 0.7
    return 1 + 0.1 * np.cos(omega * t), -0.1 * t * np.sin(omega * t) / (2 * omega)


@pytest.mark.slow
def test_derivative_of_a_motion():
    """Forward mode; reverse in the batch below."""
    (found, _), (forward, _) = jax.jvp(lambda s: place(s, adjoint=diffrax.ForwardMode()), (9.0,), (1.0,))
    # Ten times the tolerance of the integration.
    np.testing.assert_allclose([found, forward], exact_place(9.0), rtol=1e-6)


@pytest.mark.slow
def test_derivatives_of_a_batch_whose_motions_take_different_numbers_of_steps():
    """A batch is its members, one by one, each with steps of its own."""
    many = np.array([9.0, 900.0])
    (places, results), slopes = jax.vmap(jax.value_and_grad(place, has_aux=True))(many)
    assert not np.any(results)
    expected = exact_place(many)
    np.testing.assert_allclose(places, expected[0], rtol=1e-6)
    # The tolerance of a step, over some tens of steps, and times t w for the phase.
    np.testing.assert_allclose(slopes, expected[1], rtol=1e-5)


@pytest.mark.slow
def test_turns_are_counted_past_full_ones_and_on_from_another_motion():
    """Steady turning of a wheel on a hinge in space, with a mass on its arm."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.node("end", (0.1, 0, 0))
    b.rotation("ground")
    b.rotation("arm")
    b.fix("o", "x", "y", "z")
    b.fix("ground")
    b.add(fm.spatial.hinge, "ground", "arm", name="hinge", axis=(0, 0, 1.0))
    b.add(fm.spatial.rigid_beam, "o", "arm", "end", name="bar")
    b.mass("end", 1.0)
    b.start("hinge", 1, 0.0, 10.0)
    model = b.build()
    first = fm.simulate(model, [0.0, 0.5, 1.0], rtol=1e-8, solver=diffrax.Dopri8())
    second = fm.simulate(model, [0.5, 1.5, 2.0], initial=first.until(2), rtol=1e-8, solver=diffrax.Dopri8())
    for found in (first, second):
        # Some hundred steps of 1e-8 each.
        np.testing.assert_allclose(found.near[:, 0], 10.0 * found.t, rtol=1e-6)
    np.testing.assert_allclose(second.observe().e[:, 0], 10.0 * second.t, rtol=1e-6)


def sprung_wheel(start=None, stop="") -> fm.Model:
    """A wheel on a hinge with a spring, and a spring beside it that does nothing, before it, behind it or nowhere."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.rotation("ground")
    b.node("beside", (1.0, 0, 0))
    b.fix("o", "x", "y", "z")
    b.fix("ground")
    b.fix("beside", "y", "z")
    for part in ("before", "hinge", "behind"):
        if part == "hinge":
            b.add(fm.spatial.hinge, "ground", "o", name="hinge", axis=(0, 0, 1.0), stiffness=3.0)
        elif part == stop:
            b.add(fm.spatial.truss, "o", "beside", name="stop", section=fm.Rigidity(EA=1.0))
    b.inertia("o", (1e-2, 0, 0, 1e-2, 0, 1e-2))
    b.mass("beside", 1.0)
    b.dof("beside", "x")
    b.dof("hinge", 1)
    if start is not None:
        b.start("hinge", 1, start)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("form", ["coordinates", "reduced"])
@pytest.mark.parametrize("stops", [("", ""), ("before", ""), ("", "before"), ("before", "behind")])
def test_turns_are_counted_on_from_where_a_motion_begins(form, stops):
    """Let go more than a full turn from where it is free of stress: k/I of the angle itself.

    The state may be of a model with other elements.
    """
    first, second = stops
    initial = fm.configuration(sprung_wheel(8.0, first))
    t = np.linspace(0, 0.05, 3)
    found = fm.simulate(sprung_wheel(None, second), t, rtol=1e-9, form=form, initial=initial)
    # The tolerance, over some tens of steps.
    np.testing.assert_allclose(found.deformation("hinge", 1), 8.0 * np.cos(np.sqrt(300.0) * t), rtol=1e-6)
    further = fm.simulate(sprung_wheel(None, first), t, rtol=1e-9, form=form, initial=found.until(2))
    np.testing.assert_allclose(
        further.deformation("hinge", 1), 8.0 * np.cos(np.sqrt(300.0) * (t + t[1])), rtol=1e-6, atol=1e-5
    )


@pytest.mark.slow
def test_a_motion_begins_with_the_turns_of_an_equilibrium():
    """Wheels that mesh, of which a torque has turned one by four radians and a spring the other back by eight."""
    b = meshing_wheels()
    b.rotation("ground")
    b.fix("ground")
    b.add(planar.hinge, "ground", "q", stiffness=3.0)
    b.moment("p", 12.0)
    model = b.build()
    still = fm.simulate(model, [0, 0.1], initial=fm.equilibrium(model))
    # By hand: q = -2 M/k; round-off of a stiffness of 1000.
    np.testing.assert_allclose(still.rotation("q"), -8.0, rtol=1e-10)


# -- what is refused ----------------------------------------------------------------------------------------------


def test_a_start_of_a_mechanism_of_another_length_is_refused():
    def hanging(length):
        b = fm.Builder()
        b.node("hook", (0.0, 0.0))
        b.node("load", (0.0, -length))
        b.add(planar.truss, "hook", "load", name="spring", section=fm.Rigidity(EA=1e3))
        b.fix("hook")
        b.fix("load", "x")
        b.mass("load", 1.0)
        b.dof("load", "y")
        return b.build()

    start = fm.equilibrium(hanging(0.1))
    with pytest.raises(fm.ModelError, match=r"`initial` is a state of .*other undeformed positions: .*load\.y"):
        fm.simulate(hanging(0.11), [0.0, 0.1], initial=start)
    with pytest.raises(fm.ModelError, match=r"other undeformed positions: .*load\.y"):
        jax.grad(lambda length: fm.simulate(hanging(length), [0.0, 0.1], initial=start).x[-1, -1])(0.11)


def test_names_and_times_are_checked(pendulum):
    with pytest.raises(fm.ModelError, match="'mess' names no coordinate, deformation or node"):
        fm.simulate(pendulum, [0, 1.0], loads={"mess": abs})
    with pytest.raises(fm.ModelError, match=r"'mass\.x' is not PRESCRIBED"):
        fm.simulate(pendulum, [0, 1.0], motion={"mass.x": abs})
    with pytest.raises(ValueError, match="ascending"):
        fm.simulate(pendulum, [0, 1.0, 0.5])
    with pytest.raises(fm.ModelError, match="needs an input and an output"):
        fm.simulate(pendulum, [0, 1.0], control=lambda t, y: y)
    with pytest.raises(fm.ModelError, match="no incremental loads"):
        fm.simulate(pendulum, [0, 1.0], increment=jnp.sin)


def test_keywords_and_records_are_checked(pendulum):
    groups = [fm.motion.Drives, fm.motion.Loop, fm.motion.Integrator]
    assert list(Keywords.__annotations__) == [field.name for kind in groups for field in dataclasses.fields(kind)]
    with pytest.raises(TypeError, match=r"no keyword `rtoll`.* form, rtol, atol,"):
        fm.simulate(pendulum, [0, 1.0], rtoll=1e-3)
    for name in ("drives", "loop", "integrator"):
        with pytest.raises(TypeError, match=rf"`{name}` must be fm\.{name.title()}\(\.\.\), not 1e-05"):
            fm.simulate(pendulum, [0, 1.0], **{name: 1e-5})
    with pytest.raises(ValueError, match="`rtol` must be positive"):
        fm.simulate(pendulum, [0, 1.0], integrator=fm.motion.Integrator(rtol=-1.0))
    with pytest.raises(ValueError, match='controller needs form="coordinates"'):
        fm.simulate(pendulum, [0, 1.0], control=abs, form="reduced")
    with pytest.raises(ValueError, match='form="reduced" does not take explicit solvers'):
        fm.simulate(pendulum, [0, 1.0], solver=diffrax.Dopri8(), form="reduced")


def indefinite():
    """As the tutorial's (3.9) puts a lumped inertia on a leaf spring: mass of all coordinates is indefinite."""
    b = motions.double_pendulum(masses=(11.0, 1.0))
    b.inertia("first", -10.0)
    b.dof("first", "phi")
    b.dof("second", "phi")
    return b.build()


@pytest.mark.slow
def test_a_negative_lumped_inertia_is_refused_by_name():
    with pytest.raises(fm.AnalysisError, match="reduced") as fault:
        fm.simulate(indefinite(), np.linspace(0, 2, 5), solver=diffrax.Dopri8())
    assert fault.value.code == "singular_mass"


@pytest.mark.slow
def test_a_negative_lumped_inertia_is_right_where_the_mass_of_all_motions_is_positive():
    """The inertia takes away what the upper mass has too much, and a driven load its weight: M1 is left."""
    model = indefinite()
    times, loads = np.linspace(0, 2, 5), {"upper.y": Partial(jnp.full_like, fill_value=10 * 9.81)}
    found = fm.simulate(model, times, loads=loads, form="reduced", rtol=1e-9)
    assert found.form == "reduced"
    exact = reference.double_pendulum(times)["positions"]
    # Some hundred times the tolerance of one step.
    for i, name in enumerate(("upper", "lower")):
        np.testing.assert_allclose(found.at(name), exact[:, i], atol=1e-7)


@pytest.mark.slow
def test_in_parts(pendulum):
    """What is watched is what is computed at once."""
    calls = []
    found = fm.simulate(pendulum, TIMES, rtol=1e-9, progress=lambda *counts: calls.append(counts))
    # As for the whole: some hundred times the tolerance of one step.
    np.testing.assert_allclose(found.at("mass")[-1], PENDULUM, atol=2e-7)
    assert calls == [(i + 1, 50) for i in range(50)]


@pytest.mark.slow
def test_stopped_from_the_keyboard(pendulum):
    def interrupt(done, of):
        if done == of // 2:
            raise KeyboardInterrupt

    found = fm.simulate(pendulum, TIMES, rtol=1e-9, progress=interrupt)
    assert int(found.result) == fm.RESULTS.stopped
    assert found.t.shape == (300,)
    assert found.x.shape[0] == found.xd.shape[0] == 300
    assert np.all(np.isfinite(found.observe().energy))
