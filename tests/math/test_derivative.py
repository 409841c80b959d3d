import jax
import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.math.derivative import refusing_derivatives, root_or_zero


def test_derivatives_of_some_numbers_are_refused():
    def guarded(x):
        return jnp.sum(refusing_derivatives({"a": x}, "not again")["a"])

    assert guarded(jnp.ones(2)) == 2.0
    for derivative in (jax.grad, jax.jacfwd):
        with pytest.raises(TypeError, match="not again"):
            derivative(guarded)(jnp.ones(2))


def test_a_root_of_nothing_has_no_slope_and_one_of_no_number_is_none():
    squares = jnp.array([4.0, 0.0, -1e-20, jnp.nan])
    np.testing.assert_array_equal(root_or_zero(squares), [2.0, 0.0, 0.0, np.nan])
    np.testing.assert_array_equal(jax.vmap(jax.grad(root_or_zero))(squares), [0.25, 0.0, 0.0, np.nan])
