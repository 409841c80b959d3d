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


def test_a_pattern_that_comes_often_has_the_order_that_fills_less(monkeypatch):
    monkeypatch.setattr(sparse, "FULL", 1)
    entries = grid(20, 20).tocoo()
    rows, columns = (of.reshape(-1, 1) for of in entries.coords)
    wanted = np.random.default_rng(1).random(400)

    def fills(begin: np.ndarray) -> list[int]:
        pattern, found = SparsePattern((400, 400), [(rows, columns)]), []
        pattern.ordering = begin
        for _ in range(sparse.OFTEN + 1):
            matrix = pattern.matrix([entries.data.reshape(-1, 1, 1)])
            factors = pattern.factored(matrix)
            found.append(factors.fill)
            # Round-off times the condition, about 1e2.
            np.testing.assert_allclose(matrix @ factors.solve(wanted), wanted, atol=1e-12)
        return found

    by_rows, by_halves = (SparseFactors(grid(20, 20), of).fill for of in (np.arange(400), dissected(grid(20, 20))))
    assert by_halves < by_rows
    assert fills(np.arange(400)) == [by_rows] * (sparse.OFTEN - 1) + [by_halves] * 2
    monkeypatch.setattr(sparse, "dissected", lambda matrix: np.random.default_rng(2).permutation(400))
    assert fills(np.arange(400)) == [by_rows] * (sparse.OFTEN + 1)

    def too_large(_):
        raise MemoryError

    monkeypatch.setattr(sparse, "dissected", too_large)
    assert fills(np.arange(400)) == [by_rows] * (sparse.OFTEN + 1)
