"""Inertia by sparse factors, and bordered systems, against dense matrices of NumPy."""

import numpy as np
import pytest
import scipy.sparse

from flexmb.math.bordered import Bordered
from flexmb.math.sparse import SparseFactors


def chain(count: int, softer: float) -> np.ndarray:
    """Stiffness of equal springs in a row between two walls, less a multiple of one: eigenvalues 2 - 2 cos - softer."""
    return 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1) - softer * np.eye(count)


@pytest.mark.parametrize(("softer", "negative"), [(0.0, 0), (0.05, 2), (2.1, 21)])
def test_negative_pivots_are_negative_eigenvalues(softer, negative):
    matrix = chain(40, softer)
    factored = SparseFactors(scipy.sparse.csc_array(matrix))
    assert factored.negative == negative == np.sum(np.linalg.eigvalsh(matrix) < 0)
    # In the order that these factors found, too.
    assert SparseFactors(scipy.sparse.csc_array(matrix), factored.ordering).negative == negative


@pytest.mark.parametrize("lowest", [1e-3, 1e-9, 1e-15, 0.0])
def test_a_border_makes_up_for_a_singular_matrix(lowest):
    count = 30
    angles = np.arange(1, count + 1) * np.pi / (count + 1)
    matrix = chain(count, 2 - 2 * np.cos(angles[0]) - lowest)
    column, row, right = np.sin(angles), np.cos(angles) + 2, np.cos(np.arange(count) ** 2)
    stiff = scipy.sparse.csc_array(matrix)
    bordered = Bordered(stiff, SparseFactors(stiff), column, row, 0.5)
    assert bordered.regular
    whole = np.block([[matrix, column[:, None]], [row[None], np.array([[0.5]])]])
    z, w = bordered.solve(right, 0.25)
    # The whole has a condition of a few hundred.
    np.testing.assert_allclose(np.append(z, w), np.linalg.solve(whole, np.append(right, 0.25)), rtol=0, atol=1e-11)
    left = np.linalg.solve(whole.T, np.eye(count + 1)[-1])
    np.testing.assert_allclose(bordered.left(), left[:-1], rtol=0, atol=1e-11)


def test_an_unsymmetric_matrix_in_a_border():
    matrix = chain(12, 0.0) + 0.3 * np.eye(12, k=1)
    column, row, right = np.arange(12.0), np.ones(12), np.cos(np.arange(12.0))
    stiff = scipy.sparse.csc_array(matrix)
    z, w = Bordered(stiff, SparseFactors(stiff), column, row, 0.0).solve(right, 1.0)
    whole = np.block([[matrix, column[:, None]], [row[None], np.zeros((1, 1))]])
    np.testing.assert_allclose(np.append(z, w), np.linalg.solve(whole, np.append(right, 1.0)), rtol=0, atol=1e-12)


def test_a_border_of_what_has_no_factors():
    # A coordinate without any stiffness: all is factored together, row and column brought to its size.
    matrix = chain(6, 0.0)
    matrix[2], matrix[:, 2] = 0.0, 0.0
    column, row, right = 1 + np.arange(6.0), np.full(6, 100.0), np.cos(np.arange(6.0))
    stiff = scipy.sparse.csc_array(matrix)
    factored = SparseFactors(stiff)
    assert not factored.regular
    bordered = Bordered(stiff, factored, column, row, 0.7)
    z, w = bordered.solve(right, 2.0)
    whole = np.block([[matrix, column[:, None]], [row[None], np.array([[0.7]])]])
    left = np.linalg.solve(whole.T, np.eye(7)[-1])
    np.testing.assert_allclose(bordered.left(), left[:-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.append(z, w), np.linalg.solve(whole, np.append(right, 2.0)), rtol=0, atol=1e-12)
