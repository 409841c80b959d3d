"""Motions of rigid mechanisms against references written apart from flexmb, and balances of energy and momenta."""

import functools

import diffrax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import motions
from jax.tree_util import Partial
from references import motion_references as reference
from references.balances import Panels, check_balances, momenta

import flexmb as fm


@functools.cache
def pendulum():
    panels = Panels(np.linspace(0, 10, 101))
    return panels, fm.simulate(motions.pendulum().build(), panels.times, rtol=1e-12)


@pytest.mark.slow
def test_pendulum():
    """D5: place and rate over four swings; tension of the rod, which its constraint carries."""
    panels, found = pendulum()
    exact = reference.pendulum(panels.times)
    # Some hundred times the tolerance of one step.
    np.testing.assert_allclose(found.at("mass"), exact["position"], atol=1e-10)
    np.testing.assert_allclose(found.velocity("rod")[:, 0], exact["rate"], atol=3e-10)
    sigma = np.asarray(found.observe().sigma)[:, :2]
    # The rod lies along -x in its own axes; both tensions grow with the rate's error.
    np.testing.assert_allclose(sigma[:, 0], -exact["tension"], atol=3e-9)
    np.testing.assert_allclose(sigma[:, 1], 0, atol=1e-9)


@pytest.mark.slow
def test_balances_of_the_pendulum():
    panels, found = pendulum()
    # Round-off over the step of the differences; the Gauss rule on panels of 0.1 s.
    check_balances(found, panels, step=1e-3, differences=1e-11, integrated=1e-8)


@functools.cache
def double_pendulum():
    panels = Panels(np.linspace(0, 2, 41))
    return panels, fm.simulate(motions.double_pendulum().build(), panels.times, rtol=1e-12)


@pytest.mark.slow
def test_double_pendulum():
    """Before chaos has grown: Runge-Kutta of order eight in the two angles, 1e-11."""
    panels, found = double_pendulum()
    exact = reference.double_pendulum(panels.times)
    # A hundred times the tolerance of one step.
    for i, name in enumerate(("upper", "lower")):
        np.testing.assert_allclose(found.at(name), exact["positions"][:, i], atol=1e-10)
    rates = np.concatenate([found.velocity("first"), found.velocity("second")], axis=1)
    np.testing.assert_allclose(rates, exact["rates"], atol=1e-9)
    seen = found.observe()
    height = np.asarray(seen.energy) - exact["energy"]
    # Potentials are counted from different states.
    np.testing.assert_allclose(height, height[0], atol=1e-9 * np.max(seen.kinetic))


@pytest.mark.slow
def test_balances_of_the_double_pendulum():
    panels, found = double_pendulum()
    check_balances(found, panels, step=1e-3, differences=1e-11, integrated=1e-8)


SPEED = 150.0


@functools.cache
def slider_crank():
    panels = Panels(np.linspace(0, 4 * np.pi / SPEED, 33))
    motion = {"crank.phi": Partial(motions.turned, speed=jnp.array(SPEED))}
    return panels, fm.simulate(motions.slider_crank().build(), panels.times, motion=motion, rtol=1e-8)


@pytest.mark.slow
def test_rigid_slider_crank():
    """Closed form, two turns; no degree of freedom is left, so that nothing is integrated."""
    panels, found = slider_crank()
    exact = reference.slider_crank(panels.times)
    seen, labels = found.observe(), found.labels
    x, y = labels.known("slider")
    drive = labels.known("crank")[0]
    # Round-off of the projection; accelerations and forces with the share of compliance that constraints are given.
    for value, key, error in (
        (found.at("slider")[:, 0], "slider", 1e-14),
        (found.velocity("slider")[:, 0], "slider_velocity", 1e-13),
        (found.at("rod")[:, 0], "rod_angle", 1e-14),
        (found.velocity("rod")[:, 0], "rod_rate", 1e-13),
        (seen.xdd[:, x], "slider_acceleration", 1e-9),
        (seen.reactions[:, drive], "torque", 1e-9),
        (seen.reactions[:, y], "guide", 1e-9),
    ):
        np.testing.assert_allclose(value, exact[key], atol=error * np.abs(exact[key]).max(), err_msg=key)


@pytest.mark.slow
def test_balances_of_the_rigid_slider_crank():
    """The drive's power is the change of energy."""
    panels, found = slider_crank()
    check_balances(found, panels, step=1e-5, differences=1e-10, integrated=1e-7)


@functools.cache
def middle_axis():
    """D5-dzhanibekov, with times at which the middle rate vanishes."""
    period = float(reference.dzhanibekov([0.0])["period"])
    panels = Panels(np.linspace(0, period, 81))
    model = motions.body((1, 2, 3), (1e-3, 1, 0)).build()
    return panels, fm.simulate(model, panels.times, solver=diffrax.Dopri8(), rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_body_about_its_middle_axis():
    """The period to 1e-7 of it, by the time at which the middle rate first crosses zero; energy and momentum stay."""
    panels, found = middle_axis()
    period, quarters = panels.times[-1], panels.wanted[20::20]
    rates, seen = motions.body_rates(found), found.observe()
    slope = np.gradient(rates[:, 1], panels.times)[quarters[0]]
    assert abs(rates[quarters[0], 1] / slope) < 1e-7 * period / 4
    exact = reference.dzhanibekov(panels.times[quarters])
    # Every turn over the unstable axis multiplies the error by 1e3: that of the second crossing is 7e-5.
    for at, expected, error in zip(quarters, exact["rates"], (1e-9, 1e-7, 3e-4, 1e-6), strict=True):
        np.testing.assert_allclose(rates[at], expected, atol=error)
    # Of the interpolation between steps of 0.25 s.
    np.testing.assert_allclose(seen.energy, 1.0000005, rtol=2e-9)
    np.testing.assert_allclose(
        momenta(found).value[:, 3:], np.tile([1e-3, 2.0, 0.0], (len(panels.times), 1)), atol=1e-8
    )


@pytest.mark.slow
def test_balances_about_the_middle_axis():
    panels, found = middle_axis()
    # Differences of an energy of one over 2e-3 s are known to some 1e-12 of power.
    check_balances(found, panels, step=1e-3, differences=5e-11, integrated=1e-8)


@functools.cache
def heavy_top():
    """C5-heavy-top."""
    panels = Panels(np.linspace(0, 1, 101))
    model = motions.body((0.234375, 0.46875, 0.234375), (0, 150, -4.61538), 15.0, (0, 1, 0), (0, 0, -9.81)).build()
    return panels, fm.simulate(model, panels.times, solver=diffrax.Dopri8(), rtol=1e-10, atol=1e-10)


@pytest.mark.slow
def test_heavy_top_along_its_way():
    panels, found = heavy_top()
    exact = reference.heavy_top(panels.times[panels.wanted])
    # As asked for at this tolerance of one step.
    np.testing.assert_allclose(found.at("centre")[panels.wanted], exact["centre"], atol=1e-6)
    np.testing.assert_allclose(motions.body_rates(found)[panels.wanted], exact["rates"], atol=1e-5)


@pytest.mark.slow
def test_balances_of_the_heavy_top():
    """About its fixed point the weight turns it, and nothing else."""
    panels, found = heavy_top()
    check_balances(found, panels, step=1e-5, differences=1e-10, integrated=1e-7)


@pytest.mark.slow
def test_balances_of_four_bars():
    """One loop, through ten singular positions."""
    panels = Panels(np.linspace(0, 10, 401))
    found = fm.simulate(motions.four_bars(1).build(), panels.times, rtol=1e-11, atol=1e-11)
    exact = reference.fourbar(panels.times[panels.wanted[::20]], 1)
    # Round-off grows in each of them.
    np.testing.assert_allclose(found.at("crank0")[panels.wanted[::20], 0] + np.pi / 2, exact["theta"], atol=1e-8)
    np.testing.assert_allclose(found.at("top0")[panels.wanted[::20]], exact["joint"], atol=1e-8)
    check_balances(found, panels, step=1e-3, differences=1e-10, integrated=1e-7)
