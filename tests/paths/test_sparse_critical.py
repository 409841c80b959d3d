"""Critical values by sparse factors, against all eigenvalues by NumPy."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from flexmb.errors import AnalysisError
from flexmb.math.sparse import SparseFactors
from flexmb.paths.sparse_critical import TOLD, critical_values_of, value_of_determinant


class Plain:
    """A stiffness of few digits' loss."""

    def __init__(self, matrix):
        self.matrix = matrix

    def between(self, left, right):
        return left.T @ (self.matrix @ right)

    def forces(self, motions):
        return self.matrix @ motions


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
    found = critical_values_of(tangent, SparseFactors(tangent), sizes, np.zeros(n), Plain(stiffness))
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
    found = value_of_determinant(tangent, SparseFactors(tangent), sizes, np.zeros(n), Plain(stiffness))
    free = scipy.linalg.null_space(rows * sizes) if constraints else np.eye(n)
    exact = free.T @ (sizes[:, None] * stiffness * sizes) @ free
    smallest = np.min(np.abs(np.linalg.eigvals(exact)))
    np.testing.assert_allclose(found.values, np.linalg.slogdet(exact)[0] * smallest, rtol=1e-9)
    assert found.below == 0


@pytest.mark.parametrize("find", [critical_values_of, value_of_determinant])
def test_what_factors_do_not_know_well_is_mended_or_refused(find):
    """Factors of a stiffness with some error: values are those of the better one; of a large error nothing is told."""
    n, random = 60, np.random.default_rng(1)
    stiffness = 2.1 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    wrong = random.standard_normal((n, n)) * (np.abs(np.subtract.outer(range(n), range(n))) < 2)
    wrong, sizes = wrong + wrong.T, 1 + np.arange(n) / n
    exact = np.linalg.eigvalsh(sizes[:, None] * stiffness * sizes)

    def found(share):
        tangent = scipy.sparse.csc_array(stiffness + share * wrong)
        return find(tangent, SparseFactors(tangent), sizes, np.zeros(n), Plain(stiffness)).values

    # The square of what a symmetric motion is off, 1e-5; else what is left of 1e-3 on either side, with errors of 3e-6.
    np.testing.assert_allclose(found(1e-5), exact[: len(found(1e-5))], rtol=1e-8)
    assert (
        np.max(np.abs(np.linalg.eigvalsh(sizes[:, None] * (stiffness + 1e-5 * wrong) * sizes)[0] / exact[0] - 1)) > 1e-6
    )
    if find is critical_values_of:
        with pytest.raises(AnalysisError, match="round-off"):
            found(3e-2)


@pytest.mark.parametrize("softest", [0, 3])
@pytest.mark.parametrize("miscounted", [-1, 1])
def test_pivots_that_miss_the_sign_of_a_value_near_zero(softest, miscounted):
    """A value of a few 1e-9 is found with its sign, and no other one is invented or lost beside it."""
    n = 60
    stiffness = 2.1 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness -= (np.linalg.eigvalsh(stiffness)[softest] - 3e-9) * np.eye(n)
    softer = scipy.sparse.csc_array(stiffness - 1e-10 * np.eye(n))
    factors = SparseFactors(softer)
    factors.negative += miscounted
    found = critical_values_of(softer, factors, np.ones(n), np.zeros(n), Plain(stiffness))
    exact = np.linalg.eigvalsh(stiffness)
    nearest = np.sort(exact[np.argsort(np.abs(exact))[:TOLD]])
    # Round-off of one.
    np.testing.assert_allclose(found.values, nearest, atol=1e-14)
    assert found.below == np.count_nonzero(exact < 0) - np.count_nonzero(nearest < 0)


def test_a_sign_of_the_determinant_that_pivots_miss():
    n = 60
    stiffness = 2.1 * np.eye(n) - 1.4 * np.eye(n, k=1) - 0.7 * np.eye(n, k=-1)
    stiffness -= (np.sort(np.linalg.eigvals(stiffness).real)[2] - 3e-9) * np.eye(n)
    softer = scipy.sparse.csc_array(stiffness - 1e-10 * np.eye(n))

    class Missed(SparseFactors):
        @property
        def sign(self):
            return -super().sign

    found = value_of_determinant(softer, Missed(softer), np.ones(n), np.zeros(n), Plain(stiffness))
    # Two are negative; round-off of one.
    np.testing.assert_allclose(found.values, 3e-9, atol=1e-13)
