"""What is made of known numbers alone, as lookups by name are, compiles nothing."""

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar
from flexmb.arguments import computed
from flexmb.compilation.compile import jit


@pytest.mark.slow
def test_lookups_by_name_compile_nothing(compilations):
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("tip", (0.3, 0.0))
    b.add(planar.beam, "foot", "tip", name="leaf", section=fm.Rigidity(EA=1e6, EIy=1.0, mass=0.1))
    b.fix("foot")
    b.force("tip", (0.0, 0.1))
    model = b.build()
    lin = fm.linearize(model)
    equilibrium, modes = fm.equilibrium(model), fm.modes(lin)
    compilations.clear()
    found = [
        equilibrium.at("tip.rotation"),
        equilibrium.position("tip", "y"),
        equilibrium.reaction("foot"),
        equilibrium.stress_resultant("leaf", 1),
        modes.shape("tip"),
        modes.shape("tip", "phi"),
        lin.K,
    ]
    assert compilations == []
    assert all(isinstance(array, jax.Array) and array.dtype == float for array in found)
    # By hand: the force on a clamped foot, and its moment.
    np.testing.assert_allclose(equilibrium.reaction("foot"), [0.0, -0.1, -0.1 * 0.3], atol=1e-6)


def test_what_is_traced_stays_traced_and_what_numpy_has_stays_there():
    def last(xp, values):
        return xp.sum(values[..., -1])

    assert isinstance(computed(last, np.ones((2, 3))), np.float64)
    assert isinstance(computed(last, jnp.ones((2, 3))), jax.Array)
    np.testing.assert_array_equal(jax.grad(lambda v: computed(last, v))(jnp.ones((2, 3))), [[0, 0, 1], [0, 0, 1]])


def test_a_kernel_that_known_numbers_go_into_is_one_program(compilations):
    """Also where what is computed beside it is to be known, as the section of an element is when it is added."""
    function = jit(lambda x: jax.vmap(lambda one: one + jnp.sum(jnp.stack([jnp.ones(3), jnp.zeros(3)])))(x))
    compilations.clear()

    @jax.jit
    def around(y):
        with jax.core.eval_context():
            np.testing.assert_array_equal(function(np.arange(2.0)), [3.0, 4.0])
        return 2 * y

    around(np.ones(2))
    assert len(compilations) == 2
