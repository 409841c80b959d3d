"""Factored systems and symmetric pencils against numpy and scipy, and their derivative rules."""

import functools

import hypothesis.extra.numpy as npst
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from cases.tolerances import approx
from hypothesis import assume, given
from hypothesis import strategies as st

import flexmb as fm
from flexmb.math.linear import cholesky, factorise, is_positive_definite, leading, pencil

EPS = np.finfo(float).eps
N = 5
NUMBER = st.floats(-1, 1).map(lambda x: round(x, 3))
matrices = npst.arrays(float, (N, N), elements=NUMBER)
symmetric = matrices.map(lambda a: a + a.T)
# Well conditioned: eigenvalues between 1 and 1 + N^2.
definite = matrices.map(lambda a: np.eye(N) + a @ a.T)


# -- linear systems -------------------------------------------------------------------------------------------------


@fm.jit
def solved(matrix, right):
    factors = factorise(matrix)
    columns = factors.solve(right), factors.solve_transposed(right)
    return columns, (factors.solve(right[:, 0]), factors.solve_transposed(right[:, 0])), factors.regular()


@given(matrices, npst.arrays(float, (N, 3), elements=NUMBER))
def test_factors_solve_as_numpy(matrix, right):
    assume(np.linalg.cond(matrix) < 1e4)
    columns, single, regular = solved(matrix, right)
    assert regular
    for a, found, one in zip((matrix, matrix.T), columns, single, strict=True):
        expected = np.linalg.solve(a, right)
        # Backward stable: eps times the condition number times the size, for numpy's answer too.
        atol = 100 * EPS * 1e4 * np.max(np.abs(expected), initial=1e-3)
        np.testing.assert_allclose(found, expected, rtol=0, atol=atol)
        np.testing.assert_allclose(one, expected[:, 0], rtol=0, atol=atol)


def test_factors_of_rows_out_of_order():
    # A cyclic permutation, which is not its own inverse: row order and its transpose differ.
    matrix = np.roll(np.diag([1.0, 2, 3, 4, 5]), 1, axis=0) + 0.1 * np.eye(N)
    right = np.arange(1.0, 3 * N + 1).reshape(N, 3)
    (found, transposed), _, _ = solved(matrix, right)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), rtol=1e-14)
    np.testing.assert_allclose(transposed, np.linalg.solve(matrix.T, right), rtol=1e-14)


def test_singular_and_empty_factors():
    for matrix in ([[1.0, 2], [2, 4]], [[1.0, jnp.nan], [2, 4]], [[0.0, 0.0], [0.0, 0.0]]):
        assert not factorise(jnp.array(matrix)).regular()
    assert factorise(jnp.zeros((0, 0))).regular()


def _derivatives(method):
    right, weights = jnp.arange(1.0, N + 1), np.linspace(1, 2, N)

    def solution(matrix):
        return getattr(factorise(matrix), method)(right)

    def both(matrix, change):
        def along(matrix):
            return jax.jvp(solution, (matrix,), (change,))[1]

        gradient, second = (jax.grad(lambda m, f=f: weights @ f(m))(matrix) for f in (solution, along))
        found, again = jax.jvp(along, (matrix,), (change,))
        of = [weights @ found, jnp.sum(gradient * change), weights @ again, jnp.sum(second * change)]
        return found, again, jnp.stack(of)

    return fm.jit(both)


derivatives = {method: _derivatives(method) for method in ("solve", "solve_transposed")}


@given(matrices, matrices)
def test_derivative_of_a_solution(matrix, change):
    assume(np.linalg.cond(matrix) < 100)
    inverse = np.linalg.inv(matrix)
    for method, a, da in (("solve", inverse, change), ("solve_transposed", inverse.T, change.T)):
        found, again, of = derivatives[method](matrix, change)
        expected = -a @ da @ a @ np.arange(1.0, N + 1)
        curved = -2 * a @ da @ expected
        # eps times the square of the condition number.
        for answer, value, (forward, reverse) in ((found, expected, of[:2]), (again, curved, of[2:])):
            atol = 100 * EPS * 1e4 * max(np.max(np.abs(each), initial=1) for each in (expected, curved))
            np.testing.assert_allclose(answer, value, rtol=0, atol=atol)
            assert float(reverse) == approx(float(forward), rel=0, abs=10 * atol)


@pytest.mark.slow
@pytest.mark.parametrize("transposed", [False, True])
def test_second_derivatives_in_every_order(transposed):
    """That of the inverse of a matrix that is linear in a number: x'' = 2 A^-1 A' A^-1 A' x."""
    a, slope, right = np.array([[3.15, 0.56], [0.29, 1.88]]), np.array([[0.5, 0.2], [0.3, -0.4]]), np.array([1.0, 2.0])
    if transposed:
        a, slope = a.T, slope.T

    def first(s):
        matrix = jnp.asarray(a) + s * slope
        factors = factorise(matrix.T if transposed else matrix)
        return (factors.solve_transposed if transposed else factors.solve)(jnp.asarray(right))[0]

    back = np.linalg.solve(a, slope)
    expected = (2 * back @ back @ np.linalg.solve(a, right))[0]
    for outer in (jax.jacfwd, jax.jacrev):
        for inner in (jax.jacfwd, jax.jacrev):
            assert outer(inner(first))(0.0) == approx(expected, rel=1e-12)


@given(definite)
def test_cholesky(matrix):
    np.testing.assert_allclose(cholesky(jnp.asarray(matrix)), np.linalg.cholesky(matrix), atol=100 * EPS * N**2)


# -- definiteness ---------------------------------------------------------------------------------------------------

# Leaf springs: stiffnesses from 1e-5 to 1e10 in one matrix.
scales = npst.arrays(float, N, elements=st.floats(-5, 10)).map(lambda exponents: 10 ** (exponents / 2))
is_definite = fm.jit(is_positive_definite)


def scaled(matrix, scale):
    return matrix * scale[:, None] * scale[None, :]


@given(definite, scales)
def test_definite_of_any_scale(matrix, scale):
    assert is_definite(scaled(matrix, scale))


@given(definite, st.integers(0, N - 1), scales, st.floats(0.01, 1))
def test_indefinite_of_any_scale(matrix, i, scale, below):
    # A - (1 + below) v v^T/(v^T A^-1 v) has v^T A^-1 (..) A^-1 v = -below v^T A^-1 v; v a unit vector.
    taken = np.eye(N)[i]
    indefinite = matrix - (1 + below) * np.outer(taken, taken) / np.linalg.inv(matrix)[i, i]
    assert not is_definite(scaled(indefinite, scale))


@given(npst.arrays(float, (N, N - 1), elements=NUMBER), st.permutations(range(N)), scales)
def test_semidefinite_of_any_scale(entries, order, scale):
    # Rank N - 1. All rows but the last are those of a well-conditioned triangle, so that the last pivot is round-off
    # and not round-off times a condition number.
    half = 0.3 * np.tril(entries, -1) + np.eye(N, N - 1)
    half[-1] = 1 + entries[-1]
    semidefinite = (half @ half.T)[np.ix_(order, order)] if order[-1] == N - 1 else half @ half.T
    assert not is_definite(scaled(semidefinite, scale))


def test_definiteness_of_special_matrices():
    assert is_definite(jnp.zeros((0, 0)))
    assert is_definite(jnp.diag(jnp.array([1e-5, 1.0, 1.0, 1.0, 1e10])))
    special = [
        np.zeros((N, N)),
        np.diag([1.0, 1, 1, 1, -1e-8]),
        np.diag([1.0, 1, 1, 1, 0]),
        np.eye(N) + 2 * np.eye(N)[::-1],
        np.diag([1.0, 1, 1, 1, np.nan]),
        np.diag([1.0, 1, 1, 1, np.inf]),
    ]
    for matrix in special:
        assert not is_definite(matrix)


# -- pencils --------------------------------------------------------------------------------------------------------


@given(symmetric, definite)
def test_pencil_is_scipys(a, b):
    mu, w = map(np.asarray, pencil(jnp.asarray(a), jnp.asarray(b)))
    expected = scipy.linalg.eigh(a, b, eigvals_only=True)
    # Symmetric matrices of norm below 2 N: round-off of the eigenvalues, the condition of B, below 26, included.
    np.testing.assert_allclose(mu, expected, rtol=0, atol=1e3 * EPS * 2 * N)
    np.testing.assert_allclose(w.T @ b @ w, np.eye(N), atol=1e3 * EPS)
    np.testing.assert_allclose(a @ w, b @ w * mu, rtol=0, atol=1e4 * EPS * 2 * N)


compiled_pencil = fm.jit(pencil)
forward = fm.jit(lambda primals, tangents: jax.jvp(pencil, primals, tangents))


@given(symmetric, definite, symmetric, symmetric)
def test_derivatives_of_simple_eigenvalues_and_vectors(a, b, da, db):
    mu, w = map(np.asarray, compiled_pencil(a, b))
    assume(np.min(np.diff(mu)) > 0.05)
    _, (dmu, dw) = forward((a, b), (da, db))
    step = EPS ** (1 / 3) * 0.05

    def beside(t):
        values, vectors = map(np.asarray, compiled_pencil(a + t * da, b + t * db))
        return values, vectors * np.sign(np.sum(w * (b @ vectors), axis=0))  # LAPACK chooses the sign

    (mu_p, w_p), (mu_m, w_m) = beside(step), beside(-step)
    # Vectors change over |da|/gap <= 200: truncation (200 step)^2/6, round-off 100 eps/(gap step).
    np.testing.assert_allclose(dmu, (mu_p - mu_m) / (2 * step), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(dw, (w_p - w_m) / (2 * step), rtol=1e-4, atol=1e-4)


def repeated_pair(seed_vectors, b):
    """A with eigenvalues 1, 2, 2, 4, 7 in the metric of B."""
    values = np.array([1.0, 2, 2, 4, 7])
    _, w = scipy.linalg.eigh(seed_vectors, b)
    back = b @ w
    return back * values @ back.T


def sum_of_pair(a, b):
    return jnp.sum(pencil(a, b)[0][1:3])


def projector_on_pair(a, b):
    w = pencil(a, b)[1][:, 1:3]
    return w @ w.T


@functools.cache
def derivatives_at_pair():
    def along(function):
        return fm.jit(lambda p, t: jax.jvp(function, p, t)[1])

    def twice(p, t):
        return jax.jvp(lambda *q: jax.jvp(sum_of_pair, q, t)[1], p, t)[1]

    return along(sum_of_pair), fm.jit(jax.grad(sum_of_pair, (0, 1))), fm.jit(twice), along(projector_on_pair)


@given(symmetric, definite, symmetric, symmetric)
def test_repeated_eigenvalue_has_finite_derivatives_and_the_right_sum(seed, b, da, db):
    a = repeated_pair(seed, b)
    first, gradient, twice, _ = derivatives_at_pair()
    _, (dmu, dw) = forward((a, b), (da, db))
    assert np.all(np.isfinite(dmu))
    assert np.all(np.isfinite(dw))
    slope = float(first((a, b), (da, db)))
    by_a, by_b = map(np.asarray, gradient(a, b))
    assert np.all(np.isfinite(by_a))
    assert np.all(np.isfinite(by_b))
    # The same numbers in another order.
    assert np.sum(by_a * da) + np.sum(by_b * db) == approx(slope, rel=1e-9, abs=1e-9)
    step = 1e-5

    def beside(t):
        return np.sum(scipy.linalg.eigh(a + t * da, b + t * db, eigvals_only=True)[1:3])

    # The gap to the rest is 1, the sum smooth: truncation (40 step)^2, round-off 100 eps/step.
    assert slope == approx((beside(step) - beside(-step)) / (2 * step), rel=1e-6, abs=1e-6)
    assert np.isfinite(twice((a, b), (da, db)))


@given(symmetric, definite, symmetric)
def test_second_derivative_of_the_sum_of_a_repeated_pair_at_constant_b(seed, b, da):
    a, db = repeated_pair(seed, b), np.zeros((N, N))
    _, _, twice, _ = derivatives_at_pair()
    step = 1e-4

    def at(t):
        return np.sum(scipy.linalg.eigh(a + t * da, b, eigvals_only=True)[1:3])

    # Truncation step^2 times the fourth derivative, |da|^4 up to 1e4; round-off 100 eps/step^2.
    expected = (at(step) - 2 * at(0) + at(-step)) / step**2
    assert twice((a, b), (da, db)) == approx(expected, rel=1e-3, abs=1e-3)


@pytest.mark.slow
@given(symmetric, definite, symmetric, symmetric)
def test_vectors_of_a_repeated_pair_keep_their_norm_and_their_plane(seed, b, da, db):
    """W^T B W = I holds along the derivative, and the plane of the pair, W W^T over it, turns as it should."""
    a = repeated_pair(seed, b)
    _, w = map(np.asarray, compiled_pencil(a, b))
    _, (_, dw) = forward((a, b), (da, db))
    change = np.asarray(dw).T @ b @ w
    # Round-off of da and db over the gap 1.
    np.testing.assert_allclose(change + change.T + w.T @ db @ w, 0, atol=1e-9)
    projector = derivatives_at_pair()[3]
    step = 1e-5

    def beside(t):
        pair = scipy.linalg.eigh(a + t * da, b + t * db)[1][:, 1:3]
        return pair @ pair.T

    difference = (beside(step) - beside(-step)) / (2 * step)
    # Truncation (40 step)^2, round-off 100 eps/step.
    np.testing.assert_allclose(projector((a, b), (da, db)), difference, rtol=1e-5, atol=1e-5)


def separated(n=40, seed=5):
    """Symmetric A and positive definite B whose eigenvalues fall off as those of a mechanism do."""
    rng = np.random.default_rng(seed)
    mix = rng.standard_normal((n, n))
    a, b = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    return mix @ np.diag(1.0 / np.arange(1, n + 1) ** 4) @ mix.T, mix @ mix.T + 0.1 * np.eye(n), a + a.T, b + b.T


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
def test_leading_pairs_and_their_derivatives(count):
    """Against LAPACK by scipy, and against central differences, first and second."""
    a, b, da, db = separated()
    mu, w = fm.jit(lambda a, b: leading(a, b, count))(a, b)
    values, vectors = scipy.linalg.eigh(a, b)
    np.testing.assert_allclose(mu, values[::-1][:count], rtol=1e-12)
    signs = np.sign(np.sum(np.asarray(w) * (b @ vectors[:, ::-1][:, :count]), axis=0))
    # Eleven digits are asked for of the vectors' residual; the gap to the next is at least a tenth here.
    np.testing.assert_allclose(w * signs, vectors[:, ::-1][:, :count], atol=1e-9)

    def value(s):
        return leading(a + s * da * 1e-3, b + s * db * 1e-3, count)[0]

    def exact(s):
        return scipy.linalg.eigvalsh(a + s * da * 1e-3, b + s * db * 1e-3)[::-1][:count]

    # Differences: of second order, and round-off 1e-15/step.
    first = (exact(1e-3) - exact(-1e-3)) / 2e-3
    second = (exact(1e-2) - 2 * exact(0.0) + exact(-1e-2)) / 1e-4
    np.testing.assert_allclose(fm.jit(jax.jacrev(value))(0.0), first, rtol=1e-5)
    forward = fm.jit(lambda s: jax.jvp(jax.jacfwd(value), (s,), (1.0,)))(0.0)
    np.testing.assert_allclose(forward[0], first, rtol=1e-5)
    np.testing.assert_allclose(forward[1], second, rtol=1e-3)


@pytest.mark.slow
def test_leading_pairs_that_do_not_separate():
    """More equal eigenvalues than are iterated together: all are computed."""
    b = np.diag(np.linspace(1.0, 2.0, 60))
    mu, w = fm.jit(lambda a, b: leading(a, b, 2))(b + 1e-3 * np.diag(np.arange(60.0) / 60), b)
    expected = scipy.linalg.eigvalsh(b + 1e-3 * np.diag(np.arange(60.0) / 60), b)[::-1][:2]
    np.testing.assert_allclose(mu, expected, rtol=1e-14)
    np.testing.assert_allclose(w.T @ b @ w, np.eye(2), atol=1e-12)
