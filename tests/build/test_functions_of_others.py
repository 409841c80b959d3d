"""Functions of a user's own element that refer to numbers outside: no answer mixes numbers of before and after."""

import copy
import pickle

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar

STIFFNESS, MASS, FORCE = 100.0, 2.0, 5.0


def elongation(p: fm.Point2, q: fm.Point2, *, ref):
    return planar.truss.deformation(p, q, ref=ref)


def law(e, e_dot, *, ref):
    return jnp.asarray(STIFFNESS) * e


SPRING = fm.Element(elongation, law=law)


def built(spring=SPRING):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.add(spring, "wall", "mass", name="spring")
    b.fix("wall")
    b.fix("mass", "y")
    b.mass("mass", MASS)
    b.force("mass", (FORCE, 0))
    b.dof("mass", "x")
    return b.build()


def displacement(model):
    return float(displacement_of(model))


def frequency(model):
    """In rad/s."""
    return float(fm.frequencies(model)[0]) * 2 * np.pi


def stretched(model):
    """After a tenth of a second from rest."""
    return float(fm.simulate(model, [0.0, 0.1]).at("mass")[-1, 0]) - 1


@pytest.mark.slow
def test_a_model_answers_for_what_its_elements_meant_when_it_was_built(monkeypatch):
    before = built()
    assert displacement(before) == approx(FORCE / STIFFNESS)
    monkeypatch.setitem(globals(), "STIFFNESS", 400.0)
    after = built()
    assert displacement(after) == approx(FORCE / 400.0)
    assert frequency(after) == approx((400.0 / MASS) ** 0.5)
    # What is compiled keeps its number; what has to be derived anew would have the other one.
    assert displacement(before) == approx(FORCE / 100.0)
    with pytest.raises(
        fm.ModelError, match=r"'elongation'.* its law uses a number that has changed since the model was built"
    ):
        stretched(before)
    monkeypatch.setitem(globals(), "STIFFNESS", 100.0)
    assert stretched(before) == approx(FORCE / 100.0 * (1 - np.cos((100.0 / MASS) ** 0.5 * 0.1)), rel=1e-4)


def braked(e, e_dot, *, ref):
    """An inner compiled function and a product of matrices, whose precision is a setting of JAX."""
    return (jnp.array([[STIFFNESS]]) @ jnp.atleast_1d(jax.nn.relu(e + 1.0) - 1.0)).reshape(e.shape)


@pytest.mark.slow
def test_settings_are_no_numbers():
    spring = fm.Element(elongation, law=braked)
    model = built(spring)
    with jax.default_matmul_precision("highest"):
        assert displacement(model) == approx(FORCE / STIFFNESS)
    with jax.disable_jit(), jax.numpy_dtype_promotion("standard"):
        assert displacement(model) == approx(FORCE / STIFFNESS)
        assert displacement(built(spring)) == approx(FORCE / STIFFNESS)


@pytest.mark.slow
def test_a_model_with_functions_of_others_can_be_copied():
    model = built()
    for again in (copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert displacement(again) == approx(FORCE / STIFFNESS)


def by_stiffness(k):
    return displacement_of(built(fm.Element(elongation, law=lambda e, e_dot, *, ref: k * e)))


def displacement_of(model):
    return fm.equilibrium(model).at("mass")[0] - 1


def frequency_by_stiffness(k):
    return fm.frequencies(built(fm.Element(elongation, law=lambda e, e_dot, *, ref: k * e)))[0]


def grad_of_two(function):
    return jax.grad(lambda k: jnp.sum(jax.vmap(function)(k * jnp.ones(2))) / 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "transformed",
    [jax.grad, jax.jacfwd, lambda f: jax.jit(jax.grad(f)), lambda f: jax.jit(jax.grad(jax.jit(f))), grad_of_two],
    ids=["grad", "jacfwd", "jit grad", "jit grad jit", "grad vmap"],
)
def test_derivatives_by_numbers_outside(transformed):
    """u = F/k, f = (k/m)^(1/2)/(2 pi)."""
    k = 100.0
    assert transformed(by_stiffness)(k) == approx(-FORCE / k**2, rel=1e-9)
    expected = (k / MASS) ** 0.5 / (2 * np.pi) / (2 * k)
    assert transformed(frequency_by_stiffness)(k) == approx(expected, rel=1e-9)


@pytest.mark.slow
def test_numbers_of_a_batch_are_taken_as_they_are():
    found = jax.vmap(by_stiffness)(jnp.array([100.0, 200.0]))
    np.testing.assert_allclose(found, FORCE / np.array([100.0, 200.0]), rtol=1e-10)
    assert jax.jit(by_stiffness)(100.0) == approx(FORCE / 100.0)
