"""Legendre polynomials on [0, 1], their integrals, quadrature nodes: by NumPy, at places of JAX by JAX."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.polynomial import legendre


def legendre_values(order: int, s: Any) -> Any:
    """Values of the Legendre polynomials P_k(2 s - 1), k < order, (*n, order); P_k^2 integrates to 1/(2 k + 1).

    By (k + 1) P_{k+1} = (2 k + 1) x P_k - k P_{k-1} at places of JAX.
    """
    if not isinstance(s, jax.Array):
        return legendre.legvander(2 * np.asarray(s) - 1, order - 1)
    x = 2 * s - 1
    values = [jnp.ones_like(x), x]
    for k in range(1, order - 1):
        values.append(((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1))
    return jnp.stack(values[:order], axis=-1)


def legendre_slopes(order: int, s: np.ndarray) -> np.ndarray:
    """Derivatives by s of the Legendre polynomials P_k(2 s - 1), k < order, (n, order)."""
    slopes = legendre.legder(np.eye(order), axis=0)
    return 2 * legendre.legval(2 * np.asarray(s) - 1, slopes).T if order > 1 else np.zeros((len(s), 1))


def legendre_integrals(order: int, s: Any) -> Any:
    """Integrals of P_k(2 s - 1) from 0 to s, (*n, order), by (2 k + 1) P_k = d(P_{k+1} - P_{k-1})/dx."""
    values = legendre_values(order + 1, s)
    library: Any = jnp if isinstance(values, jax.Array) else np
    below = library.concatenate([-library.ones_like(values[..., :1]), values[..., :-2]], axis=-1)
    return (values[..., 1:] - below) / (4.0 * np.arange(order) + 2)


def legendre_coefficients(nodes: np.ndarray) -> np.ndarray:
    """Matrix (n, n) from values at n nodes to coefficients of the Legendre series through them."""
    return np.linalg.inv(legendre_values(len(nodes), nodes))


@functools.cache
def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1], exact to degree 2 n - 1; read-only arrays."""
    nodes, weights = legendre.leggauss(n)
    nodes, weights = (nodes + 1) / 2, weights / 2
    for array in (nodes, weights):
        array.flags.writeable = False
    return nodes, weights


def lobatto(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Lobatto nodes and weights on [0, 1], both ends included, exact to degree 2 n - 3.

    Source: inner nodes are the roots of P_{n-1}'; the weights are 2/(n (n-1) P_{n-1}(x)^2) on [-1, 1].
    """
    last = np.zeros(n)
    last[-1] = 1
    x = np.concatenate([[-1.0], np.sort(legendre.legroots(legendre.legder(last)).real), [1.0]])
    return (x + 1) / 2, 1 / (n * (n - 1) * legendre.legval(x, last) ** 2)


def integration_matrix(nodes: np.ndarray) -> np.ndarray:
    """Matrix (n, n) from values at n nodes to integrals from 0 to each node, exact to degree n - 1."""
    return legendre_integrals(len(nodes), nodes) @ legendre_coefficients(nodes)
