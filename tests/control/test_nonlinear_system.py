"""The plant for python-control, whose states are metres and radians whatever the mechanism's extent."""

import control
import numpy as np
import pytest
from cases.mechanisms import LENGTH, guide_with_ports, leaf
from cases.motions import meshing_wheels, sprung_mass

import flexmb as fm
from flexmb import planar
from flexmb.control import nonlinear_system


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.02, 3.0])
def test_rates_of_an_oscillator_are_those_of_its_equation(length):
    k, c, m = 90.0, 1.2, 0.4
    b = sprung_mass(length=length, stiffness=k, damping=c, mass=m)
    b.input("mass", "x")
    b.output("mass", "x")
    b.output("mass", "x", "velocity")
    plant = fm.control.to_nonlinear_system(b.build())
    x, v, u = 0.1 * length, -0.7, 5.0
    np.testing.assert_allclose(plant.dynamics(0.0, [x, v], [u]), [v, (u - k * x - c * v) / m], rtol=1e-10)
    np.testing.assert_allclose(plant.output(0.0, [x, v], [u]), [x, v], rtol=1e-10)


@pytest.mark.slow
def test_turns_are_counted_to_wherever_it_is_asked():
    """Wheels that mesh with no stress rest, however often they have turned; torques alone move them."""
    for plant in (fm.control.to_nonlinear_system(meshing_wheels(turned).build()) for turned in (0.0, 50.0)):
        for turn in (1.0, 4.0, -300.0, 0.0):
            still = [turn, -turn / 2, 0.0, 0.0]
            # Round-off of 300 rad times 1000 N m/rad over 0.01 kg m^2.
            np.testing.assert_allclose(plant.dynamics(0.0, still, [0.0, 0.0]), 0.0, atol=1e-7)
            np.testing.assert_allclose(plant.dynamics(0.0, still, [0.01, 0.08]), [0, 0, 1, 2], atol=1e-7)


@pytest.mark.parametrize("turn", [30_000.0, np.nan])
def test_what_is_out_of_reach_is_told(turn):
    plant = fm.control.to_nonlinear_system(meshing_wheels().build())
    with pytest.raises(fm.AnalysisError, match="no configuration with these degrees of freedom"):
        plant.dynamics(0.0, [turn, 0.0, 0.0, 0.0], [0.0, 0.0])


@pytest.mark.slow
def test_a_loop_of_python_control_with_the_plant():
    """python-control compares outputs to the last digit: at one state they must not depend on earlier evaluations."""
    damping = fm.sections.damping_from_ratio(leaf(), LENGTH, 0.005, frequency=10.0)
    model = guide_with_ports(planar.beam, damping=damping)
    plant, pid = fm.control.to_nonlinear_system(model), fm.control.pid(model, 20.0)
    state = np.array([1e-3, 1e-3, -2e-3, 0.1, 0.0, 0.0])
    outputs = [plant.output(0.0, state, [force])[0] for force in (0.0, 1.0, -3.0, 0.0)]
    assert len(set(outputs)) == 1
    controller = control.ss(pid, inputs=["error"], outputs=["force"], name="pid")
    error = control.summing_junction(["wanted", "-position"], "error", name="error")
    loop = control.interconnect([plant, controller, error], inputs=["wanted"], outputs=["position"])
    times, step = np.linspace(0, 0.1, 11), 1e-3
    stepped = control.input_output_response(
        loop, times, step * np.ones(11), solve_ivp_method="Radau", solve_ivp_kwargs={"rtol": 1e-6, "atol": 1e-9}
    )
    motion = fm.simulate(model, times, control=pid, reference=lambda t: step, rtol=1e-6)
    # Ten times the tolerances of both integrations.
    np.testing.assert_allclose(stepped.outputs, np.asarray(motion.at("B"))[:, 0], atol=1e-5 * step)


def test_many_evaluations_are_told_with_a_faster_method(monkeypatch):
    monkeypatch.setattr(nonlinear_system, "MANY", 3)
    plant = fm.control.to_nonlinear_system(meshing_wheels().build())
    state = np.zeros(4)
    for time in (0.0, 0.0, 1.0):
        plant.dynamics(time, state, [0.0, 0.0])
    with pytest.warns(fm.FlexmbWarning, match=r"evaluated 3 times, up to t = 2 s.*solve_ivp_method='Radau'"):
        plant.dynamics(2.0, state, [0.0, 0.0])
