"""Orders of elimination by nested dissection."""

import numpy as np
import pytest
import scipy.sparse

from flexmb.math import sparse
from flexmb.math.dissection import dissected
from flexmb.math.sparse import SparseFactors, SparsePattern


def line(n: int):
    return scipy.sparse.csc_array(2.1 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))


def grid(rows: int, columns: int, unknowns: int = 1, alone: int = 0):
    """Five-point matrix of a grid, so many unknowns a vertex, and vertices that are joined to none."""
    ones = [scipy.sparse.eye_array(n) for n in (rows, columns)]
    plain = scipy.sparse.kron(line(rows), ones[1]) + scipy.sparse.kron(ones[0], line(columns))
    block = np.ones((unknowns, unknowns)) + np.eye(unknowns)
    return scipy.sparse.csc_array(scipy.sparse.block_diag([scipy.sparse.kron(plain, block), np.eye(alone)]))


@pytest.mark.parametrize(
    "matrix", [grid(1, 1), grid(30, 30), grid(9, 40, 3, alone=5), grid(1, 200), scipy.sparse.eye_array(4).tocsc()]
)
def test_every_unknown_is_eliminated_once(matrix):
    np.testing.assert_array_equal(np.sort(dissected(matrix)), np.arange(matrix.shape[0]))


def test_nothing_is_a_matrix_too():
    assert len(dissected(scipy.sparse.csc_array((0, 0)))) == 0


def test_factors_of_a_grid_grow_as_they_must():
    """Of n vertices they have O(n log n) entries, where rows by rows they have O(n^1.5) (George 1973)."""

    def entries(n: int, order: np.ndarray | None = None) -> int:
        matrix = grid(n, n)
        return SparseFactors(matrix, np.arange(n * n) if order is None else order).fill

    sizes = 20, 40, 80
    by_rows, by_halves = zip(*((entries(n), entries(n, dissected(grid(n, n)))) for n in sizes), strict=True)
    grows = [np.log2(of[2] / of[1]) for of in (by_rows, by_halves)]
    # Four times the vertices: 3 for n^1.5, 2 and the logarithm's share, log2(log 6400 / log 1600) = 0.25.
    assert grows[0] > 2.9
    assert grows[1] < 2.4
    assert by_halves[2] < by_rows[2] / 3


def shaken(n: int, seed: int):
    """A pattern of a grid whose own order fills its factors, and element matrices of it."""
    matrix = grid(n, n).tocoo()
    places = np.random.default_rng(seed).permutation(n * n)
    rows, columns = (places[of].reshape(-1, 1) for of in matrix.coords)
    return SparsePattern((n * n, n * n), [(rows, columns)]), matrix.data.reshape(-1, 1, 1)


def test_a_pattern_that_comes_often_has_the_order_that_fills_less(monkeypatch):
    monkeypatch.setattr(sparse, "FULL", 1)
    pattern, pieces = shaken(40, seed=0)
    wanted = np.random.default_rng(1).random(1600)
    fills = []
    for _ in range(sparse.OFTEN + 1):
        factors = pattern.factored(pattern.matrix([pieces]))
        fills.append(factors.fill)
        # Round-off times the condition, about 1e2.
        np.testing.assert_allclose(pattern.matrix([pieces]) @ factors.solve(wanted), wanted, atol=1e-12)
    assert fills[: sparse.OFTEN - 1] == [fills[0]] * (sparse.OFTEN - 1)
    assert fills[-1] == fills[-2] == min(fills)
    monkeypatch.setattr(sparse, "dissected", lambda matrix: np.arange(1600))
    other, _ = shaken(40, seed=0)
    for _ in range(sparse.OFTEN + 1):
        factors = other.factored(other.matrix([pieces]))
    assert factors.fill == fills[0]
