"""Inputs of a flexible arm whose tip follows a law: an independent solution, the linear and the nonlinear motion."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from cases.tolerances import approx
from cases.trajectories import arm

import flexmb as fm

# The arm moves at 0.1 s, and some 0.1 s of what the input does before and after are kept.
STEP = 0.5 / 2000
TIMES = STEP * np.arange(2001)
LAW = fm.trajectory.septic(0.0, 0.01, 0.3, begin=0.1)


@pytest.fixture(scope="module")
def model():
    return arm()


@pytest.fixture(scope="module")
def matrices(model):
    return [np.asarray(part) for part in fm.control.state_matrices(model)[0]]


@pytest.fixture(scope="module")
def found(model):
    return fm.trajectory.stable_inversion(model, {"tip": LAW}, TIMES)


def test_input_is_that_of_fouriers_integral(model, matrices):
    """U = Y''/(s² G(s)) over 8 s, of a law whose spectrum ends far below the sampling. Left is round-off,
    of a matrix whose largest eigenvalue is 1e4 times the lowest, in its square."""

    def law(t):
        return 0.005 * (1 + jax.scipy.special.erf((t - 0.25) / 0.02))

    found = fm.trajectory.stable_inversion(model, {"tip": law}, TIMES)
    a, b, c, _ = matrices
    count = 32000
    t = STEP * np.arange(count) - 4.0
    s = 2j * np.pi * np.fft.fftfreq(count, STEP)
    s[0] = 2j * np.pi * 1e-6
    response = c[0] @ np.linalg.solve(s[:, None, None] * np.eye(len(a)) - a, np.tile(b, (count, 1, 1)))[:, :, 0].T
    second = np.asarray(jax.vmap(lambda t: fm.trajectory.rates(law, t)[2])(jnp.asarray(t)))
    u = np.fft.ifft(np.fft.fft(second) / (s**2 * response)).real
    start = np.searchsorted(t, -STEP / 2)
    np.testing.assert_allclose(found.u[:, 0], u[start : start + len(TIMES)], rtol=0, atol=1e-8 * np.max(np.abs(u)))


@pytest.mark.slow
def test_linear_arm_follows_to_1e_8(matrices, found):
    """From rest under the input as a function of time, by the exponential of the matrix and a cubic between times."""
    a, b, c, _ = matrices
    n, torque = len(a), found.inputs["torque"]
    assert np.sum(found.zeros.real > 0) == 4
    assert found.error < 1e-12
    nodes = np.array([0.0, 1.0, 2.0, 3.0]) / 3
    values = np.asarray(jax.vmap(torque)(jnp.asarray((TIMES[:-1, None] + STEP * nodes).ravel()))).reshape(-1, 4)
    powers = values @ np.linalg.inv(np.vander(nodes, increasing=True)).T * [1, 1, 2, 6]
    whole = np.zeros((n + 4, n + 4))
    whole[:n, :n], whole[:n, n : n + 1] = a * STEP, b * STEP
    whole[n:-1, n + 1 :] = np.eye(3)
    step, z, tip = scipy.linalg.expm(whole)[:n], np.zeros(n), [0.0]
    for row in powers:
        z = step @ np.concatenate([z, row])
        tip.append(c[0] @ z)
    np.testing.assert_allclose(tip, jax.vmap(LAW)(jnp.asarray(TIMES)), rtol=0, atol=1e-8)


def test_collocated_output_needs_nothing_beforehand(model):
    found = fm.trajectory.stable_inversion(model, {"hub": LAW}, TIMES)
    assert np.all(found.zeros.real < 0)
    np.testing.assert_array_equal(found.u[TIMES < 0.1 - STEP / 2], 0.0)


@pytest.mark.slow
def test_nonlinear_arm_follows_nearly(model, found):
    """10 mm at 0.5 m turn by 0.02 rad, whose sine is 0.02²/6 less: 0.67 µm, and what bending adds or takes, 0.1 µm."""
    motion = fm.simulate(model, TIMES[::20], loads={"0.rotation.phi": found.inputs["torque"]}, rtol=1e-8)
    off = np.abs(np.asarray(motion.position("2", "y")) - found.y[::20, 0])
    assert np.max(off) == approx(0.02**2 / 6 * 0.01, abs=1e-7)


def test_what_cannot_be_inverted_is_refused(model, found):
    with pytest.raises(fm.ModelError, match=r"zeros on the imaginary axis.*Hz"):
        fm.trajectory.stable_inversion(arm(ratio=None), {"hub": LAW}, TIMES)
    ramp = fm.trajectory.sampled(np.linspace(0.1, 0.4, 7), np.linspace(0.0, 0.01, 7))
    with pytest.raises(fm.ModelError, match=r"'tip' is not smooth enough.*order 1"):
        fm.trajectory.stable_inversion(model, {"tip": ramp}, TIMES)
    with pytest.raises(fm.ModelError, match="not at rest at the last"):
        fm.trajectory.stable_inversion(model, {"tip": LAW}, TIMES[:1000])
    with pytest.raises(fm.ModelError, match=r"no output.*tip, hub"):
        fm.trajectory.stable_inversion(model, {"top": LAW}, TIMES)
    with pytest.raises(ValueError, match="without a time twice"):
        fm.trajectory.stable_inversion(model, {"tip": LAW}, TIMES[::-1])
    with pytest.raises(fm.ModelError, match="as many laws as inputs"):
        fm.trajectory.stable_inversion(model, {"tip": LAW, "hub": LAW}, TIMES)
    with pytest.warns(fm.FlexmbWarning, match="begin earlier"):
        late = fm.trajectory.stable_inversion(model, {"tip": LAW}, TIMES[399:])
    assert 1e-5 < late.error < 1e-2
