"""Functions that do the same to other numbers share compiled code."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.mechanisms import planar_guide
from cases.motions import sprung_mass
from cases.tolerances import approx

import flexmb as fm
from flexmb.compilation import compile


def scaled(factor, shift):
    return fm.jit(lambda x: factor * jnp.sin(x) + shift)


def test_a_function_defined_anew_is_compiled_once(compilations):
    x = np.array([0.1, 0.2])
    first = scaled(2.5, 1.5)(x)
    assert compilations  # the counter counts
    compilations.clear()
    second = scaled(3.0, -1.5)(x)
    assert compilations == []
    np.testing.assert_allclose(first, 2.5 * np.sin(x) + 1.5, rtol=1e-15)
    np.testing.assert_allclose(second, 3 * np.sin(x) - 1.5, rtol=1e-15)
    np.testing.assert_allclose(fm.jit(lambda x: 2.0 * jnp.cos(x) + 1.0)(x), 2 * np.cos(x) + 1, rtol=1e-15)


@pytest.mark.slow
def test_derivative_of_a_design_defined_anew(compilations):
    """As where the cell of a notebook runs again: 3/2 of the frequency by one of thickness, the bar being rigid."""

    def slope(mass):
        def hertz(thickness):
            b = planar_guide(thickness)
            b.mass("left1", mass)
            return fm.frequencies(b.build())[0]

        f, of = fm.jit(jax.value_and_grad(hertz))(5e-4)
        return f, of

    first, _ = slope(0.1)
    compilations.clear()
    second, of = slope(0.3)
    assert compilations == []
    assert float(second) < float(first)
    np.testing.assert_allclose(of, 1.5 * second / 5e-4, rtol=2e-2)


def test_options_and_shapes_are_code_of_their_own():
    power = fm.jit(lambda x, *, n: x**n)
    assert float(power(2.0, n=3)) == 8.0
    assert float(power(2.0, n=4)) == 16.0
    np.testing.assert_array_equal(power(np.array([1.0, 2.0]), n=3), [1.0, 8.0])
    assert power(2, n=3).dtype == jnp.int64


def test_within_another_program():
    """What is traced there, captured or an argument, is; what is known stays known."""
    doubled = fm.jit(lambda x: 2 * x)
    assert float(jax.jit(lambda x: doubled(x) + doubled(3.0))(1.0)) == 8.0
    assert float(jax.grad(lambda x: doubled(x) * doubled(3.0))(1.0)) == 12.0
    np.testing.assert_array_equal(jax.vmap(doubled)(np.arange(3.0)), [0.0, 2.0, 4.0])

    def captures(x):
        return fm.jit(lambda y: x * y)(3.0)

    assert float(jax.jit(captures)(2.0)) == 6.0
    assert float(jax.grad(captures)(2.0)) == 3.0


def test_a_function_that_captures_what_is_traced_is_not_remembered():
    outside = []
    product = fm.jit(lambda y: outside[-1] * y)

    def of(x):
        outside.append(x)
        return product(3.0)

    assert float(jax.jit(of)(2.0)) == 6.0
    assert float(jax.jit(lambda x: of(x) + 1)(4.0)) == 13.0


def test_known_numbers_within_another_program():
    """An analysis of a finished model, and of one that is built there, is an answer like any other number."""
    model = planar_guide().build()
    hertz = float(fm.frequencies(model)[0])
    assert float(jax.jit(lambda x: x * fm.frequencies(model)[0])(1.0)) == hertz
    assert float(jax.jit(lambda x: x * fm.frequencies(planar_guide().build())[0])(1.0)) == hertz
    assert float(jax.jit(lambda x: x * np.abs(fm.poles(model)[0]))(1.0)) == approx(2 * np.pi * hertz, rel=1e-12)


def test_results_are_trees_and_random_keys_pass():
    found = fm.jit(lambda x: {"a": x, "b": None, "c": (1.0, 2)})(1.0)
    assert found["b"] is None
    assert [float(of) for of in (found["a"], *found["c"])] == [1.0, 1.0, 2.0]
    assert fm.jit(lambda key: jax.random.normal(key, (2,)))(jax.random.key(0)).shape == (2,)
    with pytest.raises(TypeError, match="takes a function"):
        fm.jit(3)  # type: ignore


def spring(stiffness, mass):
    return sprung_mass(stiffness=stiffness, mass=mass).build()


def hertz(model):
    return fm.frequencies(model)[0]


@pytest.mark.parametrize(
    "ask",
    [
        lambda build: fm.sensitivities(build, {"f": hertz}, {"stiffness": 90.0}).slopes[0, 0],
        lambda build: fm.sweep(build, {"f": hertz}, {"stiffness": [80.0, 90.0]}).answers["f"][1],
        lambda build: fm.tune(
            build, {"f": hertz}, {"stiffness": 50.0}, bounds={"stiffness": (10.0, 500.0)}, targets={"f": 2.0}
        ).dimensions["stiffness"],
    ],
    ids=["sensitivities", "sweep", "tune"],
)
def test_designs_asked_about_again(ask, compilations):
    first = ask(lambda stiffness: spring(stiffness, 0.4))
    compilations.clear()
    second = ask(lambda stiffness: spring(stiffness, 0.5))
    assert not [name for name in compilations if "flexmb." in name]
    assert not np.isclose(first, second)


def staircase(through):
    """Rounded to steps, with a derivative that goes through them or does not."""

    @jax.custom_jvp
    def rounded(t):
        return jnp.round(20 * t) / 20

    rounded.defjvp(lambda primals, tangents: (rounded(*primals), through * tangents[0]))
    return rounded


def test_functions_of_equal_values_and_other_derivatives_are_others():
    # The argument is known, and a number that the function captures is differentiated.
    found = []
    for through in (1.0, 0.0, 3.0):
        plate = staircase(through)
        found.append(jax.grad(lambda t, plate=plate: fm.jit(lambda load: load * plate(t) ** 3)(jnp.array(2.0)))(0.52))
    # 3 F t^2 at t = 0.5, times the slope of the stairs.
    np.testing.assert_allclose(found, [1.5, 0.0, 4.5], rtol=1e-14)


@pytest.mark.parametrize("compiled", [fm.jit, compile.jit])
def test_options_that_are_equal_and_not_the_same_are_others(compiled):
    @compiled
    def size(x, *, norm):
        return jnp.linalg.norm(x) if norm is True else jnp.sum(x * norm)

    x = jnp.array([3.0, 4.0])
    assert [float(size(x, norm=norm)) for norm in (True, 1, 1.0)] == [5.0, 7.0, 7.0]
    kinds = compiled(lambda x, *, p: jnp.asarray(p[0]))
    assert [kinds(3, p=p).dtype.kind for p in ((1,), (1.0,))] == ["i", "f"]
