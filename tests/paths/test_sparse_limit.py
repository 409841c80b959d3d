"""Limit loads by sparse factors: closed form, and those of dense matrices."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.snapping import limit_of, toggle, truss
from cases.tolerances import approx

import flexmb as fm


@pytest.mark.slow
def test_limit_load_of_a_truss_and_its_derivatives():
    """A7, closed form: proportional to EA; its slope by the height by central differences of that."""

    def limit(p):
        return 5 * fm.limit_load(truss(*p), sparse=True)

    at = np.array([1e4, 1.0])
    assert limit(at) == approx(limit_of(*at), rel=1e-12)
    by_height = (limit_of(1e4, 1.0 + 1e-5) - limit_of(1e4, 1.0 - 1e-5)) / 2e-5
    for differentiate in (jax.jacfwd, jax.jacrev):
        found = differentiate(limit)(jnp.asarray(at))
        assert float(found[0]) == approx(limit_of(*at) / 1e4, rel=1e-11)
        assert float(found[1]) == approx(by_height, rel=1e-9)


@pytest.mark.slow
def test_limit_load_of_beams_is_that_of_dense_matrices():
    """Without degrees of freedom; the load follows the apex, which turns as the moved foot breaks the symmetry."""

    def limit(p, sparse):
        return fm.limit_load(toggle(*p, follower=True, check=not sparse), sparse=sparse)

    at = jnp.array([1.0, 1.0, 0.05])
    (load, found), (dense, wanted) = (jax.value_and_grad(limit)(at, sparse) for sparse in (True, False))
    assert float(load) == approx(float(dense), rel=1e-12)
    np.testing.assert_allclose(found, wanted, rtol=1e-10)


@pytest.mark.slow
def test_what_has_no_limit_point_says_so():
    with pytest.raises(fm.AnalysisError, match="max_steps"):
        fm.limit_load(truss(load=-5.0), max_steps=20, sparse=True)
    assert np.isnan(fm.limit_load(truss(load=-5.0), max_steps=20, sparse=True, throw=False))


@pytest.mark.slow
def test_within_another_program():
    def limit(height):
        return fm.limit_load(truss(1e4, height), solver="sparse")

    assert 5 * float(jax.jit(limit)(1.0)) == approx(limit_of(1e4, 1.0), rel=1e-12)
    assert float(jax.jit(jax.grad(limit))(1.0)) == approx(float(jax.grad(limit)(1.0)), rel=1e-11)
    with pytest.raises(NotImplementedError, match="no second one"):
        jax.grad(jax.grad(limit))(1.0)
