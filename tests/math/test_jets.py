"""Rates of functions along a motion, in one pass, beside JAX's own derivatives taken one after the other."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb.math.jets import jets
from flexmb.math.rigid import exponential


@jax.custom_jvp
def _tripled(x):
    return 3 * x


@_tripled.defjvp
def _tripled_jvp(primals, tangents):
    # Not its derivative, so that one sees whether the rule is asked.
    return _tripled(primals[0]), 5 * tangents[0] * primals[0]


def _products(x):
    a, b, c = jnp.split(x, [2, 4])
    matrix = a[:, None] * b
    both = matrix @ jnp.outer(b, c) - 2.0 * matrix
    return jnp.concatenate([both.ravel() ** 2, (a @ b)[None] * a, np.ones(2)]), jnp.sum(both * matrix[::-1], axis=1)


def _single_operations(x):
    a, b = jnp.split(x, 2)
    angle = jnp.arctan2(a, 2 + b**2)
    return jnp.where(a > 0, jnp.sin(angle) / b, jnp.sqrt(1 + b**4)), jnp.stack([a**3, jnp.exp(-b)])


def _programs(x):
    a, b = jnp.split(x, 2)
    turned = jax.lax.fori_loop(0, 3, lambda _, c: c * jnp.cos(c) + a, b)
    chosen = jax.lax.cond(a[0] > 0, lambda: a * b, lambda: a / b)
    solved = jnp.linalg.solve(jnp.eye(3) + jnp.outer(a, b), turned)
    return solved, chosen + _tripled(b), jax.lax.scan(lambda c, v: (c * v, c + v), jnp.ones(()), a)[1]


def _constant_or_itself(x):
    return jnp.arange(3.0), x, jnp.sign(x), jnp.squeeze(jnp.split(x, [1])[0])


def _poses(x):
    return exponential(x.reshape(1, 6))


@pytest.mark.slow
@pytest.mark.parametrize("function", [_products, _single_operations, _programs, _constant_or_itself, _poses])
def test_rates_are_those_of_derivatives_one_by_one(function):
    rng = np.random.default_rng(3)
    x, v, a, w = (jnp.asarray(rng.uniform(0.2, 1.5, 6) * rng.choice([-1, 1], 6)) for _ in range(4))

    def rate(x, v):
        return jax.jvp(function, (x,), (v,))[1]

    def second(x):
        return jax.jvp(rate, (x, v), (v, a))[1]

    one_by_one = [function, lambda x: rate(x, v), second, lambda x: rate(x, w)]
    taken = fm.jit(lambda x: [[f(x) for f in one_by_one], [jax.jacfwd(f)(x) for f in one_by_one]])
    for orders, aside in ((2, None), (2, w), (3, None), (3, w)):
        parts = [0, 1, 2][:orders] + ([] if aside is None else [3])
        motion = (x, v, a)[:orders]
        for directed in (False, True):
            found = fm.jit(lambda x, m=motion, s=aside, d=directed: jets(function, (x, *m[1:]), s, directed=d))(x)
            values, jacobians = taken(x)
            for part, (value, jacobian) in enumerate((values[k], jacobians[k]) for k in parts):
                for own, one, changed in zip(*map(jax.tree.leaves, (found, value, jacobian)), strict=True):
                    np.testing.assert_allclose(own[part, 0], one, rtol=1e-12, atol=1e-12)
                    if directed:
                        np.testing.assert_allclose(np.moveaxis(own[part, 1:], 0, -1), changed, rtol=1e-11, atol=1e-11)
                    else:
                        assert own.shape[1] == 1


@pytest.mark.slow
def test_rates_may_be_batched_and_differentiated():
    rng = np.random.default_rng(4)
    x, v = (jnp.asarray(rng.uniform(0.5, 1.0, (5, 6))) for _ in range(2))

    def total(x, v):
        return sum(jnp.sum(leaf**2) for leaf in jets(_single_operations, (x, v, v), None, directed=True))

    def one_by_one(x, v):
        def rate(x):
            return jax.jvp(_single_operations, (x,), (v,))[1]

        def second(x):
            return jax.jvp(rate, (x,), (v,))[1]

        def curved(x):
            # Along x + t v + t^2 v / 2.
            pairs = zip(second(x), jax.jvp(_single_operations, (x,), (v,))[1], strict=True)
            return tuple(a + b for a, b in pairs)

        found = [[f(x), jax.jacfwd(f)(x)] for f in (_single_operations, rate, curved)]
        return sum(jnp.sum(leaf**2) for leaf in jax.tree.leaves(found))

    own, expected = (fm.jit(jax.vmap(jax.value_and_grad(f, (0, 1)))) for f in (total, one_by_one))
    for one, other in zip(jax.tree.leaves(own(x, v)), jax.tree.leaves(expected(x, v)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-10)
