"""Exponentials of screw motions against SciPy's matrix exponential and its derivative."""

import jax
import numpy as np
import pytest
import scipy.linalg

import flexmb as fm
from flexmb.math.rigid import HAT, exponential, product, products


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 1.9])
def test_exponential_and_its_derivatives(angle):
    rng = np.random.default_rng(0)
    turn, w, u = rng.standard_normal((3, 6))
    v = np.concatenate([angle * turn[:3] / np.linalg.norm(turn[:3]), turn[3:]])

    def along(v):
        return exponential(v[None])[0]

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
@pytest.mark.parametrize("count", [1, 2, 4, 8])
def test_products_of_poses(count):
    poses = np.asarray(exponential(np.random.default_rng(1).uniform(-1, 1, (count, 6))))
    expected = [poses[0]]
    for pose in poses[1:]:
        expected.append(expected[-1] @ pose)
    np.testing.assert_allclose(products(poses), expected, atol=1e-14 * count)
    np.testing.assert_allclose(product(poses), expected[-1], atol=1e-14 * count)
