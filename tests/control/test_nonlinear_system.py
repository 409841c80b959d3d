"""The plant for python-control, whose states are metres and radians whatever the mechanism's extent."""

import numpy as np
import pytest
from cases.motions import sprung_mass

import flexmb as fm


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
