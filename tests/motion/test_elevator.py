"""The elevator of the tutorial's appendix A.3, figure A.2, whose parameters are our own, as the shipped file has it."""

import functools

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import simpson, solve_ivp

import flexmb as fm
from flexmb.mechanisms import mechanism_path

RADIUS, LENGTH, MASS, INERTIA, EA, EDA, SPRING, DAMPER = 0.1, 0.2, 10.0, 0.3, 1000.0, 2.5, 12.5, 3.0
SIGNS = np.array([1.0, -1.0])  # a positive turn pays out the left belt and winds up the right one
# Of turn and two elongations: the masses are at depths LENGTH + sign RADIUS turn + elongation.
DEPTHS = np.array([[RADIUS, 1, 0], [-RADIUS, 0, 1]])
MASSES = MASS * DEPTHS.T @ DEPTHS + np.diag([INERTIA, 0, 0])


@functools.cache
def motion():
    read = fm.read_spacar(mechanism_path("elevator"))
    step = read.settings["TIMESTEP"]
    times = np.linspace(0, step["end"], step["steps"] + 1)
    found = fm.simulate(read.builder.build(dofs="named"), times, rtol=read.settings["ERROR"]["relative"])
    return found, found.observe()


def alone(times):
    """Turn and elongations by Lagrange's equations, written out."""

    def rates(t, z):
        q, v = z[:3], z[3:]
        free, e, ed = LENGTH + SIGNS * RADIUS * q[0], q[1:], v[1:]
        tension = (EA * e + EDA * ed) / free
        # The energy EA e^2/(2 L) falls as L grows.
        moment = -SPRING * q[0] - DAMPER * v[0] + np.sum(SIGNS * RADIUS * EA * e**2 / (2 * free**2))
        return np.r_[v, np.linalg.solve(MASSES, np.r_[moment, -tension])]

    options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
    return solve_ivp(rates, (0, times[-1]), [1.0, 0, 0, 0, 0, 0], t_eval=times, **options).y[:3]


@pytest.mark.slow
def test_motion_is_that_of_its_own_equations():
    found, seen = motion()
    # Elements 1, 2 and 3 in the order of the file; a belt has its measured turn beside its elongation.
    expected = alone(np.asarray(found.t))
    # A hundred times rtol, of the turn of 1 rad and of the pulley's travel.
    np.testing.assert_allclose(seen.e[:, 0], expected[0], rtol=0, atol=1e-5)
    np.testing.assert_allclose(seen.e[:, [1, 3]], expected[1:].T, rtol=0, atol=1e-6)
    np.testing.assert_allclose(seen.e[:, [2, 4]], np.stack([expected[0]] * 2, axis=1), rtol=0, atol=1e-5)


@pytest.mark.slow
def test_motion_looks_like_the_figure():
    _, seen = motion()
    turn, elongation = np.asarray(seen.e[:, 0]), 1e3 * np.asarray(seen.e[:, [1, 3]])
    # (a): from 1 rad to rest in 2.5 s, swinging through by less than 0.2 rad.
    assert turn[0] == 1.0
    assert -0.2 < turn.min() < -0.01
    assert np.all(np.abs(turn[200:]) < 0.02)
    # (c): between -6 and 8 mm, with a vibration that outlasts the turn.
    assert -6 < elongation.min() < -4
    assert 6 < elongation.max() < 8
    assert 0.5 < np.max(np.abs(elongation[-50:])) < 2


@pytest.mark.slow
def test_energy_changes_by_what_the_dampers_take():
    found, seen = motion()
    first = SPRING / 2
    np.testing.assert_allclose(seen.energy[0], first, rtol=1e-12)
    assert np.all(np.asarray(seen.power) <= 0)
    # Simpson's rule with 20 points a period of the fastest exchange: some 1e-4 of it.
    for end in (101, 251):
        lost = simpson(np.asarray(seen.power)[:end], x=np.asarray(found.t)[:end])
        np.testing.assert_allclose(seen.energy[end - 1], first + lost, rtol=0, atol=1e-4 * first)


@pytest.mark.slow
def test_frequencies_without_control_vary_with_the_belts():
    found, seen = motion()
    lin = fm.motion.linearize_motion(found)
    np.testing.assert_allclose(lin.M0, np.broadcast_to(MASSES, lin.M0.shape), rtol=1e-9, atol=1e-12)
    turn, elongation = np.asarray(seen.e[:, 0]), np.asarray(seen.e[:, [1, 3]])
    free = LENGTH + SIGNS * RADIUS * turn[:, None]
    # Second derivatives of EA e^2/(2 L), the turn's with the control's spring.
    np.testing.assert_allclose(lin.K[:, [1, 2], [1, 2]], EA / free, rtol=1e-8)
    coupling = -SIGNS * RADIUS * EA * elongation / free**2
    np.testing.assert_allclose(lin.K[:, 0, 1:], coupling, rtol=0, atol=1e-6)
    control = lin.K[:, 0, 0] - np.sum((RADIUS * elongation) ** 2 * EA / free**3, axis=1)
    np.testing.assert_allclose(control, SPRING, rtol=1e-7)
    np.testing.assert_allclose(lin.D0[:, [1, 2], [1, 2]], EDA / free, rtol=1e-8)
    # Figure (b), open loop: one free motion, two that vary while the lengths do.
    hertz = []
    for k, m in zip(np.asarray(lin.K), np.asarray(lin.M0), strict=True):
        opened = (k + k.T) / 2 - np.diag([SPRING, 0, 0])
        hertz.append(np.sqrt(np.abs(scipy.linalg.eigh(opened, m, eigvals_only=True))) / (2 * np.pi))
    hertz = np.array(hertz)
    assert np.all(hertz < 6)
    assert np.all(hertz[:, 0] < 0.5)
    assert np.all(hertz[:, 1:] > 3)
    assert hertz[0, 2] / hertz[-1, 2] > 1.2
