"""The plant for python-control, whose states are metres and radians whatever the mechanism's extent."""

import numpy as np
import pytest
from cases.motions import meshing_wheels, sprung_mass

import flexmb as fm


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
