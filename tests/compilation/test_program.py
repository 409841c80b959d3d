"""Equations are merged where they mean the same, not where they print alike."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.compilation.program import may_bend, split_constants, split_in_stages, split_together


def weighted(weights):
    """A compiled helper that captures an array; two of them print alike."""
    weights = jnp.asarray(weights)
    return jax.jit(lambda x: jnp.sum(weights * jnp.stack([x, x**2])))


def equations(function, *arguments):
    return str(jax.make_jaxpr(function)(*arguments)).count(" = ")


def test_helpers_that_capture_different_arrays_are_kept_apart():
    first, second = weighted([1.0, 0.0]), weighted([0.0, 1.0])
    early, late = split_constants(lambda x, c: jnp.stack([first(x) * c, second(x) * c]), (1.0,), (2.0,))
    np.testing.assert_array_equal(late(3.0, *early(2.0)), [6.0, 18.0])


def test_constants_that_print_alike_are_kept_apart():
    # The sign of zero, and the last digit of a number.
    def function(x, c):
        return jnp.stack([x / 0.0, x / -0.0, x * 0.1, x * np.nextafter(0.1, 1.0)])

    early, late = split_constants(function, (1.0,), (2.0,))
    np.testing.assert_array_equal(late(1.0, *early(2.0)), [np.inf, -np.inf, 0.1, np.nextafter(0.1, 1.0)])


def test_derivatives_of_ones_own_that_capture_arrays_are_known_by_them():
    def ruled(weights):
        weights = jnp.asarray(weights)

        @jax.custom_jvp
        def function(x):
            return jnp.sum(weights * jnp.stack([x, x**2]))

        function.defjvp(lambda primals, tangents: (function(*primals), 2.0 * tangents[0]))
        return function

    first, again, second = ruled([1.0, 0.0]), ruled([1.0, 0.0]), ruled([0.0, 1.0])
    early, late = split_constants(lambda x, c: jnp.stack([first(x) * c, again(x) * c, second(x) * c]), (1.0,), (2.0,))
    np.testing.assert_array_equal(late(3.0, *early(2.0)), [6.0, 6.0, 18.0])


def test_equal_operations_are_done_once():
    shared = weighted([1.0, 2.0])

    def once(x, c):
        return jnp.sin(x) + shared(x)

    def twice(x, c):
        return jnp.stack([jnp.sin(x) + shared(x), jnp.sin(x) + shared(x)])

    counts = [equations(split_constants(f, (1.0,), (1.0,))[1], 1.0) for f in (once, twice)]
    # Besides the stack of two: broadcasts and a concatenation.
    assert counts[1] <= counts[0] + 4


def test_what_several_functions_make_of_constants_is_done_once():
    weights = [np.array([1.0, 2.0]), np.array([1.0, 2.0])]
    functions = [(lambda x, c, w=w: x * jnp.sum(jnp.sin(w * c)), (1.0,)) for w in weights]
    early, late = split_together([*functions, (lambda c: jnp.cos(c), ())], (2.0,))
    kept = early(2.0)
    # The sum, of equal weights, and the cosine; nothing is left of the last but to hand it over.
    assert len(kept) == 2
    total = np.sum(np.sin(2.0 * weights[0]))
    np.testing.assert_allclose([late[0](3.0, *kept), late[1](4.0, *kept)], [3 * total, 4 * total], rtol=1e-15)
    assert late[2](*kept) == np.cos(2.0)
    assert equations(late[2], *kept) == 0


@pytest.mark.slow
def test_element_of_two_helpers_moves_as_the_same_element_written_out():
    """A mass on an element with two springs, k1 d and k2 (d + d^2), each by a helper of its own."""
    weights = np.array([[1.0, 0.0], [1.0, 1.0]])
    helpers = [weighted(row) for row in weights]

    def by_helpers(p: planar.Point2, q: planar.Point2, *, ref):
        d = q[0] - p[0] - ref.q[0] + ref.p[0]
        return jnp.stack([helper(d) for helper in helpers])

    def written_out(p: planar.Point2, q: planar.Point2, *, ref):
        d = q[0] - p[0] - ref.q[0] + ref.p[0]
        return jnp.stack([d, d + d**2])

    def stiffness(*, ref):
        return jnp.diag(jnp.array([10.0, 30.0]))

    def moved(element):
        b = fm.Builder()
        b.node("wall", (0, 0))
        b.node("mass", (1, 0))
        b.add(fm.Element(element, stiffness=stiffness), "wall", "mass", name="spring")
        b.fix("wall")
        b.fix("mass", "y")
        b.mass("mass", 1.0)
        b.force("mass", (-3.0, 0.0))
        return fm.simulate(b.build(), [0.0, 0.5]).at("mass")[-1, 0] - 1.0

    assert float(moved(by_helpers)) == approx(float(moved(written_out)), rel=1e-9)


def test_what_may_bend():
    """Smooth operations do not, also within compiled parts; choices, comparisons and loops of unknown length may."""

    def newton(x):
        return jax.lax.while_loop(lambda y: y > 1, lambda y: y / 2, x)

    smooth = (lambda x: x**3 + jnp.tanh(x), jax.jit(jnp.sin), lambda x: jnp.exp(-(x**2)) / (1 + x), lambda x: 0 * x)
    bent = (jnp.abs, lambda x: jnp.maximum(x, 0), lambda x: jnp.clip(x, -1, 1), jax.jit(jnp.sign), newton)
    assert not any(may_bend(function, 1.0) for function in smooth)
    assert all(may_bend(function, 1.0) for function in bent)


def test_stages_do_what_follows_from_their_arguments_and_keep_what_later_ones_need():
    def function(first, second, third):
        (a,), (b,), (c,) = first, second, third
        early = jnp.sin(a)
        middle = early * jnp.cos(b)
        return (), (middle, jnp.exp(b)), middle * c + early + jnp.sin(a) + 1.0

    values = [(jnp.array(0.3),), (jnp.array(0.7),), (jnp.array(1.1),)]
    stages = split_in_stages(function, values)
    nothing, early = stages[0](*values[0])
    result, more = stages[1](*values[1], *early)
    last, none = stages[2](*values[2], *early, *more)
    assert (nothing, none) == ((), ())
    # One sine, and one product of it: what is a result alone is not kept.
    assert (len(early), len(more)) == (1, 1)
    assert equations(lambda c: stages[2](c, *early, *more), 1.1) == 4
    expected = function(*values)
    np.testing.assert_allclose(result, expected[1], rtol=1e-15)
    np.testing.assert_allclose(last, expected[2], rtol=1e-15)


def test_a_result_that_follows_from_a_later_group_is_refused():
    with pytest.raises(ValueError, match="a group that comes after its own"):
        split_in_stages(lambda first, second: (first[0] * second[0], second[0]), [(1.0,), (2.0,)])
