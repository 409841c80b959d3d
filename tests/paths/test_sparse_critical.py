"""Critical values by sparse factors, against all eigenvalues by NumPy."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from flexmb.math.sparse import SparseFactors
from flexmb.paths.sparse_critical import TOLD, critical_values_of, value_of_determinant


@pytest.mark.parametrize("constraints", [0, 10])
@pytest.mark.parametrize("softer", [0.0, 0.4, 1.9])
def test_values_nearest_to_zero_and_number_below(constraints, softer):
    n = 60
    stiffness = (2.1 - softer) * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    rows = np.zeros((constraints, n))
    for i in range(constraints):
        # One coordinate alone in each, without a stiffness of its own, as the length of Euler parameters.
        stiffness[6 * i] = stiffness[:, 6 * i] = 0.0
        rows[i, [6 * i, 6 * i + 3]] = 2.0, 0.5 * (i % 2)
    tangent = scipy.sparse.csc_array(np.block([[stiffness, rows.T], [rows, np.zeros((constraints, constraints))]]))
    sizes = 1 + np.arange(n) / n
    found = critical_values_of(tangent, SparseFactors(tangent), sizes, np.zeros(n), lambda w, v: w.T @ (stiffness @ v))
    free = scipy.linalg.null_space(rows * sizes) if constraints else np.eye(n)
    exact = np.linalg.eigvalsh(free.T @ (sizes[:, None] * stiffness * sizes) @ free)
    nearest = np.sort(exact[np.argsort(np.abs(exact))[:TOLD]])
    np.testing.assert_allclose(found.values, nearest, rtol=1e-10)
    assert found.below == np.count_nonzero(exact < 0) - np.count_nonzero(nearest < 0)


@pytest.mark.parametrize(("n", "constraints"), [(60, 0), (60, 10), (12, 3)])
@pytest.mark.parametrize("softer", [0.0, 0.4, 2.3])
def test_smallest_modulus_and_sign_of_the_determinant(n, constraints, softer):
    random = np.random.default_rng(n + constraints)
    stiffness = (2.1 - softer) * np.eye(n) - 1.4 * np.eye(n, k=1) - 0.7 * np.eye(n, k=-1)
    rows = random.standard_normal((constraints, n)) * (random.random((constraints, n)) < 0.1) + np.eye(constraints, n)
    tangent = scipy.sparse.csc_array(np.block([[stiffness, rows.T], [rows, np.zeros((constraints, constraints))]]))
    sizes = 1 + np.arange(n) / n
    found = value_of_determinant(
        tangent, SparseFactors(tangent), sizes, np.zeros(n), lambda w, v: w.T @ (stiffness @ v)
    )
    free = scipy.linalg.null_space(rows * sizes) if constraints else np.eye(n)
    exact = free.T @ (sizes[:, None] * stiffness * sizes) @ free
    smallest = np.min(np.abs(np.linalg.eigvals(exact)))
    np.testing.assert_allclose(found.values, np.linalg.slogdet(exact)[0] * smallest, rtol=1e-9)
    assert found.below == 0
