"""Null spaces, and rows that are chosen as independent of each other, of matrices that show both at a glance."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

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


def in_parts():
    """Rows and columns of parts, one of which has a tenth of the others' size and lacks a rank, among each other."""
    draw = np.random.default_rng(3)
    parts = [
        draw.normal(size=(3, 5)),
        np.outer(draw.normal(size=4), draw.normal(size=3)) / 10,
        draw.normal(size=(4, 4)),
    ]
    # And rows and columns without an entry.
    whole = np.pad(scipy.linalg.block_diag(*parts), ((0, 2), (0, 1)))
    return whole[draw.permutation(len(whole))][:, draw.permutation(whole.shape[1])]


def test_null_spaces_of_parts_are_those_of_the_whole():
    whole = in_parts()
    rank, left, right = null_spaces(scipy.sparse.csr_array(whole))
    expected = null_spaces(whole)
    assert (rank, left.shape, right.shape) == (8, (13, 5), (13, 5)) == (expected[0], *(v.shape for v in expected[1:]))
    for own, other in zip((left, right), expected[1:], strict=True):
        np.testing.assert_allclose((own @ own.T).toarray(), other @ other.T, atol=1e-14)
    # What counts as zero is told by the largest of all parts.
    tiny = np.diag([1.0, 1e-9])
    assert null_spaces(scipy.sparse.csr_array(tiny))[0] == null_spaces(tiny)[0] == 1


@pytest.mark.parametrize("wanted", [0, 3, 20])
@pytest.mark.parametrize("threshold", [1e-9, 1.0])
def test_independent_rows_of_parts_are_those_of_the_whole(wanted, threshold):
    whole = in_parts()
    chosen, rest = independent_rows(scipy.sparse.csr_array(whole), wanted, threshold)
    expected, others = independent_rows(whole, wanted, threshold)
    assert chosen == expected
    np.testing.assert_allclose(rest.toarray(), others, atol=1e-14)
