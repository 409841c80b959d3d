import jax
import jax.numpy as jnp
import pytest

from flexmb.math.derivative import refusing_derivatives


def test_derivatives_of_some_numbers_are_refused():
    def guarded(x):
        return jnp.sum(refusing_derivatives({"a": x}, "not again")["a"])

    assert guarded(jnp.ones(2)) == 2.0
    for derivative in (jax.grad, jax.jacfwd):
        with pytest.raises(TypeError, match="not again"):
            derivative(guarded)(jnp.ones(2))
