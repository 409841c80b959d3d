"""Functions of a symmetric matrix, with derivatives that hold where eigenvalues repeat, and Lyapunov's equation."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import jax.scipy.linalg
import numpy as np
from jaxtyping import Array, Complex, Float

from ..numerical_limits import EIGENVALUES_ALIKE
from .linear import pencil


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def spectral(function: Callable[..., Any], matrix: Float[Array, "n n"], *arguments: Any) -> Float[Array, "n n"]:
    """The matrix U diag(f(mu)) U^T of a symmetric matrix U diag(mu) U^T; f acts on each eigenvalue, ascending.

    Source: Daleckii and Krein for the derivative, THEORY.md 10, eq. (10.3).
    """
    mu, u = pencil(matrix, jnp.eye(matrix.shape[0]))
    return (u * function(mu, *arguments)) @ u.T


@spectral.defjvp
def _spectral_jvp(function: Callable[..., Any], primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    matrix, *arguments = primals
    change, *others = tangents
    mu, u = pencil(matrix, jnp.eye(matrix.shape[0]))
    values, by_arguments = jax.jvp(lambda *values: function(mu, *values), tuple(arguments), tuple(others))
    moved = divided(function, mu, *arguments) * (u.T @ change @ u)
    return (u * values) @ u.T, u @ (moved + by_arguments * np.eye(len(mu))) @ u.T


def divided(function: Callable[..., Any], mu: Float[Array, "n"], *arguments: Any) -> Float[Array, "n n"]:
    """Divided differences (f_i - f_j)/(mu_i - mu_j); the mean slope for eigenvalues close together."""
    values, slopes = jax.jvp(lambda eigenvalues: function(eigenvalues, *arguments), (mu,), (jnp.ones_like(mu),))
    gap = mu[:, None] - mu[None, :]
    distinct = jnp.abs(gap) > EIGENVALUES_ALIKE * jnp.maximum(jnp.abs(mu)[:, None], jnp.abs(mu)[None, :])
    quotient = (values[:, None] - values[None, :]) / jnp.where(distinct, gap, 1.0)
    return jnp.where(distinct, quotient, (slopes[:, None] + slopes[None, :]) / 2)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def harmonic(
    function: Callable[..., Any], matrix: Float[Array, "n n"], middle: Float[Array, "n n"], *arguments: Any
) -> Float[Array, "n n"]:
    """Solution X of P X + X P = 2 P N P, where P is a non-negative function of a symmetric matrix.

    In its eigenvectors X_ij is N_ij times the harmonic mean of p_i and p_j. Source: THEORY.md 7, eq. (7.13).
    """
    mu, u = pencil(matrix, jnp.eye(matrix.shape[0]))
    p = function(mu, *arguments)
    return u @ (_mean(p) * (u.T @ middle @ u)) @ u.T


def _mean(p: Float[Array, "n"]):
    total = p[:, None] + p[None, :]
    return 2 * p[:, None] * p[None, :] / jnp.where(total > 0, total, 1.0)


@harmonic.defjvp
def _harmonic_jvp(function: Callable[..., Any], primals: tuple[Array, ...], tangents: tuple[Array, ...]):
    matrix, middle, *arguments = primals
    change, moved, *others = tangents
    mu, u = pencil(matrix, jnp.eye(matrix.shape[0]))
    p, by_arguments = jax.jvp(lambda *values: function(mu, *values), tuple(arguments), tuple(others))
    n, dn = (u.T @ matrix @ u for matrix in (middle, moved))
    dp = divided(function, mu, *arguments) * (u.T @ change @ u) + by_arguments * np.eye(len(mu))
    total = p[:, None] + p[None, :]
    total = jnp.where(total > 0, total, 1.0)
    # P dX + dX P = 2 P dN P + dP (2 N P - X) + (2 P N - X) dP.
    side = dp @ (n * 2 * p[None, :] ** 2 / total)
    return u @ (_mean(p) * n) @ u.T, u @ (_mean(p) * dn + (side + side.T) / total) @ u.T


def lyapunov(a: Float[Array, "n n"], w: Float[Array, "s n n"]) -> Float[Array, "s n n"]:
    """Solutions P of A P + P A^T + W = 0: covariances of the states under white noise.

    Derivatives solve the same equation, in reverse the adjoint one, with the same factors. Source: Bartels, Stewart
    (1972), Communications of the ACM 15, 820, with a complex Schur form.
    """
    t, u = jax.scipy.linalg.schur(jax.lax.stop_gradient(a).astype(complex), output="complex")
    n = a.shape[0]
    eye = jnp.eye(n, dtype=complex)

    def solved(matrix: Float[Array, "s n n"], adjoint: bool):
        # With A = U T U^H: T Y + Y T^H = F, last column first; adjoint: T^H Y + Y T = F, first column first.
        triangle, around = (t.conj().T, t) if adjoint else (t, t.conj().T)
        right = u.conj().T @ matrix.astype(complex) @ u

        def column(i: Array, y: Complex[Array, "s n n"]):
            j = i if adjoint else n - 1 - i
            known = right[:, :, j] - y @ around[:, j]
            y_j = jax.lax.linalg.triangular_solve(triangle + around[j, j] * eye, known.T, left_side=True, lower=adjoint)
            return y.at[:, :, j].set(y_j.T)

        y = jax.lax.fori_loop(0, n, column, jnp.zeros_like(right))
        return jnp.real(u @ y @ u.conj().T)

    return jax.lax.custom_linear_solve(
        lambda p: a @ p + p @ a.T,
        -w,
        solve=lambda _, right: solved(right, False),
        transpose_solve=lambda _, right: solved(right, True),
    )
