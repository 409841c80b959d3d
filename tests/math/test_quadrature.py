"""Legendre polynomials at traced places against those on the host, which numpy and quadrature hold."""

import jax
import numpy as np
import pytest
from numpy.polynomial import legendre

from flexmb.math.quadrature import gauss, legendre_integrals, legendre_values


@pytest.mark.slow("2", "3", "9")
@pytest.mark.parametrize("order", [1, 2, 3, 9])
def test_values_and_integrals_at_traced_places(order):
    s = np.array([0.0, 0.2, 0.5, 1.0])
    values = np.asarray(jax.jit(lambda s: legendre_values(order, s))(s))
    expected = np.stack([legendre.Legendre.basis(k, domain=[0, 1])(s) for k in range(order)], axis=1)
    np.testing.assert_allclose(values, expected, atol=1e-14)
    # Gauss quadrature from 0 to s, exact for the degree.
    nodes, weights = gauss(order)
    values_at = jax.jit(lambda s: legendre_values(order, s))
    by_quadrature = [end * weights @ np.asarray(values_at(end * nodes)) for end in s]
    np.testing.assert_allclose(jax.jit(lambda s: legendre_integrals(order, s))(s), by_quadrature, atol=1e-14)
    np.testing.assert_allclose(legendre_integrals(order, s), by_quadrature, atol=1e-14)
    # One place, and the derivative of the integral there.
    slope = jax.jit(jax.jacfwd(lambda s: legendre_integrals(order, s)))(0.3)
    np.testing.assert_allclose(slope, values_at(0.3), atol=1e-13)
