"""Null spaces, and rows that are chosen as independent of each other, of matrices that show both at a glance."""

import numpy as np
import pytest

from flexmb.math.subspace import independent_rows, null_spaces


def test_null_spaces_of_a_product_of_vectors():
    rank, left, right = null_spaces(np.outer([3.0, 4.0], [2.0, 1.0, -2.0]))
    assert (rank, left.shape, right.shape) == (1, (2, 1), (3, 2))
    np.testing.assert_allclose(np.abs(left[:, 0]), [0.8, 0.6], atol=1e-15)
    np.testing.assert_allclose(right.T @ np.column_stack([[2.0, 1.0, -2.0]]), 0, atol=1e-15)
    np.testing.assert_allclose(right.T @ right, np.eye(2), atol=1e-15)


@pytest.mark.parametrize("shape", [(0, 3), (2, 0), (2, 3)])
def test_null_spaces_of_nothing(shape):
    rank, left, right = null_spaces(np.zeros(shape))
    assert (rank, left.shape, right.shape) == (0, (shape[0],) * 2, (shape[1],) * 2)


def test_the_largest_rows_that_are_independent():
    rows = np.array([[1.0, 0, 0], [2.0, 0, 0], [0, 3.0, 0], [1.0, 1.0, 0]])
    chosen, rest = independent_rows(rows, 3, 1e-9)
    # Nothing is left of the others, however many are wanted.
    assert chosen == [2, 1]
    np.testing.assert_allclose(rest, np.diag([0, 0, 1.0]), atol=1e-15)
    assert independent_rows(rows, 1, 1e-9)[0] == [2]
    assert independent_rows(rows, 3, 2.5)[0] == [2]
    # Among equals the first.
    assert independent_rows(np.eye(3)[[1, 0, 2]], 2, 0.5)[0] == [0, 1]
