"""Rotations for users, against those of scipy; derivatives at zero rotation."""

import jax
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexmb import rotations


@pytest.mark.parametrize("size", [0.0, 1e-9, 9.9e-3, 1.01e-2, 1.0, 3.0])
def test_rotations_are_those_of_scipy(size):
    random = np.random.default_rng(1)
    axis, other, arm = random.standard_normal((3, 3))
    vector = size * axis / np.linalg.norm(axis)
    mine, right = rotations.from_vector(vector), Rotation.from_rotvec(vector)
    second, expected = rotations.from_vector(other), Rotation.from_rotvec(other)
    # A few operations of numbers of order one.
    close = {"rtol": 0, "atol": 2e-15}
    np.testing.assert_allclose(mine, right.as_quat(scalar_first=True), **close)
    np.testing.assert_allclose(rotations.to_vector(mine), vector, **close)
    np.testing.assert_allclose(rotations.from_axis_angle(axis, size), mine, **close)
    np.testing.assert_allclose(rotations.to_matrix(mine), right.as_matrix(), **close)
    np.testing.assert_allclose(rotations.rotate(mine, arm), right.apply(arm), **close)
    both = rotations.quaternion_product(second, mine)
    np.testing.assert_allclose(rotations.to_matrix(both), (expected * right).as_matrix(), **close)
    np.testing.assert_allclose(rotations.quaternion_product(both, rotations.inverse(mine)), second, **close)


@pytest.mark.slow
def test_rotations_have_derivatives_at_zero():
    def there_and_back(vector):
        return rotations.to_vector(rotations.from_vector(vector))

    for derivative in (jax.jacfwd, jax.jacrev):
        np.testing.assert_allclose(jax.jit(derivative(there_and_back))(np.zeros(3)), np.eye(3), atol=1e-15)
    second = jax.jit(jax.hessian(rotations.from_vector))(np.zeros(3))
    # cos |v|/2 = 1 - |v|^2/8.
    np.testing.assert_allclose(second[0], -np.eye(3) / 4, atol=1e-15)
    assert np.max(np.abs(second[1:])) == 0
