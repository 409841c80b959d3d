"""Configurations at given degrees of freedom, against closed forms."""

import jax
import jax.numpy as jnp
import pytest

import flexmb as fm
from flexmb import planar


def rod(length):
    """A rigid rod about the origin, whose end is at x = 0.6 and therefore at y = sqrt(length^2 - 0.6^2)."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("end", (0.6, jnp.sqrt(length**2 - 0.36)))
    b.add(planar.truss, "pivot", "end", name="rod")
    b.fix("pivot")
    b.dof("end", "x")
    b.mass("end", 1.0)
    return b.build()


@pytest.mark.parametrize("outer", [jax.jacfwd, jax.jacrev])
def test_second_derivatives_of_a_configuration(outer):
    def height(length, moved):
        return fm.configuration(rod(length), moved[None]).at("end")[1]

    # Of y = sqrt(L^2 - (0.6 + q)^2) with L = 1 and q = 0.2: -(x/y)^2/y by L twice, L x/y^3 by both, -(L/y)^2/y by q.
    (by_length, both), (_, by_moved) = fm.jit(outer(jax.grad(height, (0, 1)), (0, 1)))(1.0, jnp.asarray(0.2))
    found = [float(one) for one in (by_length, both, by_moved)]
    assert found == pytest.approx([-0.64 / 0.216, 0.8 / 0.216, -1 / 0.216], rel=1e-12)
