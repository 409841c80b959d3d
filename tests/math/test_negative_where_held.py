"""Eigenvalues are counted by pivots whatever the units, beside those of dense matrices without units."""

import numpy as np
import pytest
import scipy.sparse

from flexmb.math.sparse import SparseFactors, equilibrating, negative_under_constraints


@pytest.mark.parametrize("negative", [0, 1, 3])
def test_signs_where_constraints_hold(negative):
    """A chain of springs, some of them pushing, coordinates in units up to 10^12 apart, some only held."""
    n, held, draw = 24, 6, np.random.default_rng(5)
    ends = np.eye(n, n) - np.eye(n, n, -1)
    springs = np.ones(n)
    springs[5 : 5 + 6 * negative : 6] = -0.7
    stiffness = ends.T @ (springs[:, None] * ends)
    # What only a constraint holds has no stiffness of its own.
    stiffness[:, :3] = stiffness[:3] = 0.0
    rows = np.zeros((held, n))
    rows[np.arange(held), np.arange(held)] = 1.0
    rows[:, 6:] = 0.1 * draw.standard_normal((held, n - 6)) * (draw.uniform(size=(held, n - 6)) < 0.2)
    allowed = np.linalg.svd(rows)[2][held:].T
    wanted = int(np.sum(np.linalg.eigvalsh(allowed.T @ stiffness @ allowed) < 0))
    assert wanted > 0 or negative < 3
    units = 10.0 ** draw.uniform(-6, 6, n)
    whole = np.block([[stiffness * np.outer(units, units), (rows * units).T], [rows * units, np.zeros((held, held))]])
    tangent = scipy.sparse.csc_array(whole)
    assert negative_under_constraints(tangent, SparseFactors(tangent), n) == wanted
    scale = equilibrating(tangent)
    largest = np.max(np.abs(scale[:, None] * whole * scale), axis=1)
    # Ruiz: the largest entries differ from one by a factor that halves in each round, in its logarithm.
    np.testing.assert_allclose(largest, 1.0, rtol=0.1)
