"""Lyapunov's equation, with derivatives."""

import jax
import jax.numpy as jnp
import jax.scipy.linalg
from jaxtyping import Array, Complex, Float


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
