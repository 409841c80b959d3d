"""Exponentials of screw motions against SciPy's matrix exponential and its derivative."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

import flexmb as fm
from flexmb.math.rigid import chain, screw_line

# matrix(v)[i, j] = HAT[i, j, k] v[k], of a six-vector with the rotation first.
HAT = np.zeros((4, 4, 6))
HAT[:3, :3, :3] = np.cross(np.eye(3)[:, None], np.eye(3)).transpose(2, 1, 0)
HAT[:3, 3, 3:] = np.eye(3)


def poses(motions):
    """Poses after each motion as matrices [[R, r], [0, 1]]."""
    line = chain(motions)
    above = jnp.concatenate([line.axes.mT, line.places[:, :, None]], axis=2)
    return jnp.concatenate([above, jnp.broadcast_to(np.eye(4)[3], (above.shape[0], 1, 4))], axis=1)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 3.9, 4.1])
def test_exponential_and_its_derivatives(angle):
    rng = np.random.default_rng(0)
    turn, w, u = rng.standard_normal((3, 6))
    v = np.concatenate([angle * turn[:3] / np.linalg.norm(turn[:3]), turn[3:]])

    def along(v):
        return poses(v[None])[1]

    def second(v, w, u):
        return jax.jvp(lambda v: jax.jvp(along, (v,), (w,))[1], (v,), (u,))[1]

    found = fm.jit(lambda v, w, u: (along(v), jax.jvp(along, (v,), (w,))[1], second(v, w, u)))(v, w, u)
    value, rate = scipy.linalg.expm_frechet(HAT @ v, HAT @ w)
    np.testing.assert_allclose(found[0], value, atol=1e-15 * 40)
    np.testing.assert_allclose(found[1], rate, atol=1e-15 * 100)
    # Central difference of the first derivative: (1e-16)^(2/3).
    step = 6e-6
    either = [scipy.linalg.expm_frechet(HAT @ (v + side * step * u), HAT @ w)[1] for side in (1, -1)]
    np.testing.assert_allclose(found[2], (either[0] - either[1]) / (2 * step), atol=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_poses_along_a_line(count):
    motions = np.random.default_rng(1).uniform(-1, 1, (count, 6))
    expected = [np.eye(4)]
    for motion in motions:
        expected.append(expected[-1] @ scipy.linalg.expm(HAT @ motion))
    np.testing.assert_allclose(poses(motions), expected, atol=1e-14 * count)


@pytest.mark.slow
def test_one_screw_motion_of_many_turns():
    motion = np.array([7.0, -19.0, 25.0, 1.0, 2.0, 3.0])
    line = screw_line(motion, jnp.array([0.0, 0.3, 1.0]))
    for axes, place, share in zip(line.axes, line.places, (0.0, 0.3, 1.0), strict=True):
        expected = scipy.linalg.expm(HAT @ (share * motion))
        # Rounding, times an angle of 32 rad.
        np.testing.assert_allclose(axes.T, expected[:3, :3], atol=1e-13)
        np.testing.assert_allclose(place, expected[:3, 3], atol=1e-13)


def test_turns_count_beyond_a_full_turn():
    """After one full turn in steps of a quarter, Euler parameters have changed their sign; after two they are back."""
    turns = np.asarray(chain(np.tile([np.pi / 2, 0.0, 0, 0, 0, 0], (8, 1))).turns)
    np.testing.assert_allclose(turns[[4, 8]], [[-1.0, 0, 0, 0], [1, 0, 0, 0]], atol=1e-14)
