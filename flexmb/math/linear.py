"""Factored linear systems and symmetric matrix pencils, with derivative rules that stay finite."""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..numerical_limits import (
    EIGENVALUES_REPEATED,
    EIGENVECTOR_DIGITS,
    EIGENVECTORS_APART,
    SEMIDEFINITE,
    SMALLEST_PIVOT,
)
from .indices import TRUSTED, put

# Products with at most this number of multiplications are fused sums, which take less time than a call of BLAS.
SMALL = 700


def uneven(n: int, first: int = 0, xp: Any = np) -> Any:
    """Numbers to start iterations with: cos(k^2), to which no mode of a symmetric mechanism is orthogonal."""
    return xp.cos(xp.arange(float(first), first + n) ** 2)


def unit_scale(sizes: Any) -> Any:
    """Scale that makes positive sizes, such as the diagonal of a stiffness, one: 1/sqrt(sizes); 1 elsewhere."""
    xp: Any = np if isinstance(sizes, np.ndarray) else jnp
    return 1 / xp.sqrt(xp.where(sizes > 0, sizes, 1.0))


def multiplied(a: Float[Array, "*#n i j"], b: Float[Array, "*#n j k"]) -> Float[Array, "*#n i k"]:
    """Matrix products; small ones as sums of products, which the compiler fuses with neighbouring operations."""
    if a.shape[-2] * a.shape[-1] * b.shape[-1] > SMALL:
        return a @ b
    return jnp.sum(a[..., :, :, None] * b[..., None, :, :], axis=-2)


class Factors(NamedTuple):
    """LU factors of a square matrix, to solve with it and with its transpose; derivatives are taken of ``matrix``."""

    matrix: Float[Array, "n n"]
    lu: Float[Array, "n n"]
    permutation: Array

    def solve(self, right: Float[Array, "n *k"]) -> Float[Array, "n *k"]:
        """Solution of A X = right."""
        return _solution(self, right, False)

    def solve_transposed(self, right: Float[Array, "n *k"]) -> Float[Array, "n *k"]:
        """Solution of A^T X = right."""
        return _solution(self, right, True)

    def regular(self) -> Bool[Array, ""]:
        """Whether all pivots are finite and none is negligible beside the largest."""
        pivots = jnp.abs(diagonal_of(self.lu))
        if pivots.shape[0] == 0:
            return jnp.array(True)
        return jnp.all(jnp.isfinite(self.lu)) & (jnp.min(pivots) > SMALLEST_PIVOT * jnp.max(pivots))


def factorise(matrix: Float[Array, "n n"]) -> Factors:
    """LU factors of a square matrix."""
    lu, _, permutation = jax.lax.linalg.lu(jax.lax.stop_gradient(matrix))
    return Factors(matrix, lu, permutation)


def _solution(factors: Factors, right: Float[Array, "n *k"], transposed: bool) -> Float[Array, "n *k"]:
    """Solution with a matrix or its transpose; derivatives cost a solve and no new factors.

    ``custom_linear_solve`` keeps the dependence on the matrix. A derivative rule that solves for a tangent can
    therefore be differentiated again.
    """
    matrix = factors.matrix.T if transposed else factors.matrix

    def by_factors(other_way: bool):
        return lambda _, right: _by_factors(factors, right, transposed != other_way)

    return jax.lax.custom_linear_solve(lambda x: matrix @ x, right, by_factors(False), by_factors(True))


def _by_factors(factors: Factors, right: Float[Array, "n *k"], transposed: bool):
    _, lu, permutation = factors
    if transposed:
        y = _triangular(lu, right, lower=False, transpose_a=True)
        y = _triangular(lu, y, lower=True, unit_diagonal=True, transpose_a=True)
        return put(jnp.zeros_like(y), permutation, y)
    y = _triangular(lu, right[permutation], lower=True, unit_diagonal=True)
    return _triangular(lu, y, lower=False)


def _triangular(matrix: Float[Array, "n n"], right: Float[Array, "n *k"], **options: Any):
    columns = right if right.ndim == 2 else right[:, None]
    solved = jax.lax.linalg.triangular_solve(matrix, columns, left_side=True, **options)
    return solved.reshape(right.shape)


def diagonal_of(matrix: Float[Array, "n n"]) -> Float[Array, "n"]:
    """Diagonal of a square matrix by one gather; ``jnp.diagonal`` compiles to more operations."""
    every = np.arange(matrix.shape[0])
    return matrix.at[every, every].get(**TRUSTED)


def cholesky(matrix: Float[Array, "n n"]) -> Float[Array, "n n"]:
    """Lower Cholesky factor of a symmetric matrix; NaN if it is not positive definite."""
    return jax.lax.linalg.cholesky(matrix, symmetrize_input=False)


def solved_by_factor(factor: Float[Array, "n n"], right: Float[Array, "n k"]) -> Float[Array, "n k"]:
    """Solution X of L X = right, L lower triangular."""
    return _triangular(factor, right, lower=True)


def is_positive_definite(matrix: Float[Array, "n n"]) -> Bool[Array, ""]:
    """Whether a symmetric matrix is positive definite: its pivots, scaled to unit diagonal, exceed round-off."""
    n = matrix.shape[0]
    if n == 0:
        return jnp.array(True)
    diagonal = diagonal_of(matrix)
    scale = unit_scale(diagonal)
    pivots = diagonal_of(cholesky(matrix * scale[:, None] * scale)) ** 2
    return jnp.all(diagonal > 0) & jnp.all(pivots > 10 * n * jnp.finfo(matrix.dtype).eps)


def is_positive_semidefinite(matrix: Float[Array, "n n"]) -> Bool[Array, ""]:
    """Whether a symmetric matrix, scaled to unit diagonal, has no negative eigenvalue beyond round-off."""
    diagonal = jnp.abs(diagonal_of(matrix))
    scale = unit_scale(diagonal)
    return is_positive_definite(matrix * scale[:, None] * scale + SEMIDEFINITE * np.eye(matrix.shape[0]))


@jax.custom_jvp
def pencil(a: Float[Array, "n n"], b: Float[Array, "n n"]) -> tuple[Float[Array, "n"], Float[Array, "n n"]]:
    """Eigenvalues mu, ascending, and vectors W of A w = mu B w, with A symmetric and W^T B W = I.

    NaN if B is not positive definite. Derivatives hold for simple eigenvalues and vectors. They omit the coupling of
    close eigenvalues, so that they stay finite. For sums over equal eigenvalues, first derivatives are correct.

    Source:
        Reduction by the Cholesky factor of B; Nelson (1976) for derivatives of simple eigenvalues.
    """
    factor = cholesky(b)
    reduced = _triangular(factor, _triangular(factor, a, lower=True).T, lower=True)
    vectors, values = jax.lax.linalg.eigh((reduced + reduced.T) / 2, symmetrize_input=False)
    return values, _triangular(factor, vectors, lower=True, transpose_a=True)


@pencil.defjvp
def _pencil_jvp(primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    mu, w = pencil(*primals)
    da, db = (w.T @ t @ w for t in tangents)
    change = da - mu[None, :] * db
    gap = mu[None, :] - mu[:, None]
    distinct = jnp.abs(gap) > EIGENVALUES_REPEATED * jnp.maximum(jnp.abs(mu)[None, :], jnp.abs(mu)[:, None])
    # Within a cluster only the norm of the vectors changes.
    coefficients = jnp.where(distinct, change / jnp.where(distinct, gap, 1.0), -db / 2)
    return (mu, w), (diagonal_of(change), w @ coefficients)


def general_eigen(a: Float[Array, "n n"]) -> tuple[Complex[Array, "n"], Complex[Array, "n n"], Float[Array, "n"]]:
    """Eigenvalues, vectors and condition numbers of a matrix that need not be symmetric.

    Derivatives of eigenvalues hold for simple eigenvalues; they are zero if vectors are not separable. Vectors, as
    columns, have no derivatives. The condition of an eigenvalue is the product of the norms of its left and right
    vector over the product of these vectors.
    """
    still = jax.lax.stop_gradient(a)
    values, vectors = jax.lax.stop_gradient(jnp.linalg.eig(still))
    inverse = jnp.linalg.inv(vectors)
    conditions = jnp.linalg.norm(vectors, axis=0) * jnp.linalg.norm(inverse, axis=1)
    distinct = jnp.isfinite(jnp.abs(inverse)) & (jnp.sum(jnp.abs(inverse), axis=1, keepdims=True) < EIGENVECTORS_APART)
    moved = jnp.where(distinct, inverse, 0.0) @ (a - still).astype(complex)
    return values + jnp.sum(moved * vectors.T, axis=1), vectors, conditions


# Least number of additional vectors in the iteration, so that the last wanted vector converges too.
MORE = 6
MOST_ITERATIONS = 40


@functools.partial(jax.custom_jvp, nondiff_argnums=(2,))
def leading(a: Float[Array, "n n"], b: Float[Array, "n n"], count: int):
    """Largest eigenvalues mu, descending, of A w = mu B w, and their vectors W, (n, count), with W^T B W = I.

    A is symmetric; NaN if B is not positive definite. Iterates for few eigenvalues, and computes all of them if the
    iteration does not converge. :func:`pencil` takes tens of times as many operations. First derivatives are as in
    :func:`pencil`; second derivatives cost as much as it.

    Source:
        Subspace iteration with Rayleigh-Ritz projection: Bathe (1996), Finite Element Procedures, section 11.6.
    """
    n = a.shape[0]
    block = count + max(count, MORE)
    if 3 * block > n:
        return _all(a, b, count)
    factor = cholesky(b)

    def applied(x: Float[Array, "n k"]):
        return _triangular(factor, a @ _triangular(factor, x, lower=True, transpose_a=True), lower=True)

    def unfinished(carry: tuple[Any, ...]):
        _, _, residual, tries = carry
        return (residual > 1.0) & (tries < MOST_ITERATIONS)

    def once(carry: tuple[Any, ...]):
        x, _, _, tries = carry
        z = applied(x)
        small = x.T @ z
        vectors, values = jax.lax.linalg.eigh((small + small.T) / 2, symmetrize_input=False)
        order = np.arange(block)[::-1]
        x, z, values = (x @ vectors)[:, order], (z @ vectors)[:, order], values[order]
        off = jnp.sqrt(jnp.sum((z - x * values)[:, :count] ** 2, axis=0))
        # The error of the wanted digits, plus round-off of the largest eigenvalue.
        allowed = EIGENVECTOR_DIGITS * jnp.abs(values[:count]) + 10 * jnp.finfo(a.dtype).eps * jnp.abs(values[0])
        eigenpairs = (values[:count], x[:, :count])
        return jnp.linalg.qr(z)[0], eigenpairs, jnp.max(off / allowed), tries + 1

    first = jnp.linalg.qr(jnp.asarray(np.random.default_rng(0).standard_normal((n, block))))[0]
    start = (first, (jnp.zeros(count), jnp.zeros((n, count))), jnp.inf, 0)
    _, (values, vectors), residual, _ = jax.lax.while_loop(unfinished, once, start)
    iterated = values, _triangular(factor, vectors, lower=True, transpose_a=True)
    return jax.lax.cond(residual <= 1.0, lambda: iterated, lambda: _all(a, b, count))


def _all(a: Float[Array, "n n"], b: Float[Array, "n n"], count: int):
    """As :func:`leading`, from all eigenvalues."""
    values, vectors = pencil(a, b)
    return values[::-1][:count], vectors[:, ::-1][:, :count]


@leading.defjvp
def _leading_jvp(count: int, primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    a, b = primals
    da, db = tangents
    mu, w = leading(a, b, count)
    change = jnp.sum(w * (da @ w - db @ w * mu), axis=0)
    # Compilation drops this part if vectors are not differentiated.
    same, turned = jax.jvp(lambda a, b: _all(a, b, count)[1], (a, b), (da, db))
    return (mu, w), (change, turned * jnp.sign(jnp.sum(w * (b @ same), axis=0)))
