"""Poles of traced numbers and their derivatives: closed forms of oscillators, and central differences."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.mechanisms import planar_guide

import flexmb as fm
from flexmb import planar
from flexmb.linear.traced_poles import _vectors, traced_poles
from flexmb.results import collected

K, D, M = 400.0, 3.0, 2.0


def oscillators(stiffness: Any, damping: Any, mass: Any) -> fm.Model:
    """Two masses, each on a spring with a damper of its own."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.fix("wall")
    for i in range(2):
        b.node(f"m{i}", (1.0, 0.0))
        own = fm.Damping(EA=damping[i])
        b.add(planar.truss, "wall", f"m{i}", section=fm.Rigidity(EA=stiffness[i]), damping=own)
        b.fix(f"m{i}", "y")
        b.mass(f"m{i}", mass[i])
        b.dof(f"m{i}", "x")
    return b.build()


def parts(values: Any) -> Any:
    return jnp.stack([values.real, values.imag])


def of_numbers(p: Any, sparse: bool = False) -> Any:
    """Real and imaginary parts of the four poles by (k, d, m) of each, (2, 4)."""
    return parts(fm.poles(oscillators(*p), count=4, sparse=sparse))


def closed_form(k: float, d: float, m: float) -> tuple[complex, np.ndarray]:
    """The pole that turns forwards, and its derivatives: ds = -(dk + s dd + s^2 dm)/(2 m s + d)."""
    s = -d / (2 * m) + 1j * np.sqrt(k / m - (d / (2 * m)) ** 2)
    return s, -np.array([1, s, s**2]) / (2 * m * s + d)


JACOBIANS = {
    "forward": fm.jit(jax.jacfwd(of_numbers)),
    "reverse": fm.jit(jax.jacrev(of_numbers)),
    "sparse, forward": fm.jit(jax.jacfwd(lambda p: of_numbers(p, sparse=True))),
    "sparse, reverse": fm.jit(jax.jacrev(lambda p: of_numbers(p, sparse=True))),
}


@pytest.mark.slow("sparse, forward")
@pytest.mark.parametrize("mode", JACOBIANS)
def test_derivatives_are_those_of_the_closed_form(mode):
    """Round-off of numbers of a few hundred."""
    slow, fast = (K, D, M), (2 * K, D, M)
    found = np.asarray(JACOBIANS[mode](np.array([slow, fast]).T))
    # By |Im|, the one that turns backwards first.
    for pole, own in ((1, slow), (3, fast)):
        _, slopes = closed_form(*own)
        mine, others = (0, 1) if own == slow else (1, 0)
        np.testing.assert_allclose(found[0, pole, :, mine] + 1j * found[1, pole, :, mine], slopes, rtol=1e-11)
        np.testing.assert_allclose(found[:, pole, :, others], 0.0, atol=1e-12)


def test_sums_of_a_repeated_pole_have_derivatives():
    """Two equal oscillators: the sum of their poles changes by the change of each."""
    found = np.asarray(JACOBIANS["reverse"](np.array([(K, D, M)] * 2).T))
    whole, (_, slopes) = found[0] + 1j * found[1], closed_form(K, D, M)
    for own in range(2):
        np.testing.assert_allclose(whole[2:, :, own].sum(axis=0), slopes, rtol=1e-9)


def test_where_poles_meet_there_is_no_derivative():
    """The overdamped one has derivatives, the critically damped one beside it has none."""
    critical, strong = (K, 2 * np.sqrt(K * M), M), (K, 4 * np.sqrt(K * M), M)
    values = np.asarray(fm.jit(of_numbers)(np.array([critical, strong]).T))
    found = np.asarray(JACOBIANS["forward"](np.array([critical, strong]).T))
    meets = np.isclose(values[0], -np.sqrt(K / M), rtol=1e-6)
    assert sum(meets) == 2
    assert np.all(np.isnan(found[:, meets]))
    assert np.all(np.isfinite(found[:, ~meets]))


def test_sparse_poles_that_are_repeated_have_no_derivatives():
    found = np.asarray(JACOBIANS["sparse, forward"](np.array([(K, D, M)] * 2).T))
    assert np.all(np.isnan(found))


def test_a_repeated_pole_of_one_vector_has_no_derivative():
    """(s + 1)^2 (s^2 + s/10 + 4) = 0 of two coupled degrees of freedom, with one vector for the first factor."""
    k, c, m = np.array([[1.0, 1.0], [1.0, 5.0]]), np.array([[2.0, 1.0], [1.0, 0.1]]), np.eye(2)
    poles = np.concatenate([[-1.0, -1.0], np.roots([1.0, 0.1, 4.0])])
    assert np.all(np.isnan(_vectors(k, c, m, poles, 0)))
    assert np.all(np.isfinite(_vectors(k, c, m, poles, 2)))


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_of_a_guide_with_damping_under_load(sparse):
    """Against central differences of poles of known numbers: their error is 1e-10 for the second step, so 1e-7."""

    def guide(thickness: Any) -> fm.Model:
        return planar_guide(thickness, ratio=0.02, force=(0.0, -30.0)).build()

    def answer(thickness: Any) -> Any:
        return parts(fm.poles(guide(thickness), count=2, sparse=sparse))[:, 1]

    at, step = 5e-4, 1e-8
    ahead, behind = (fm.poles(guide(at + h))[1] for h in (step, -step))
    wanted = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(fm.jit(jax.jacrev(answer))(at), [wanted.real, wanted.imag], rtol=1e-6)


def test_those_nearest_to_zero_of_many_designs():
    def build(mass: Any) -> fm.Model:
        return oscillators((K, 20 * K), (D, D), (mass, M))

    masses = np.array([0.5, 1.0])
    found = fm.sweep(build, {"decay": lambda model: -jnp.real(fm.poles(model, count=2)[1])}, {"mass": masses})
    np.testing.assert_allclose(found.answers["decay"], D / (2 * masses), rtol=1e-12)


@pytest.mark.parametrize(
    ("mass", "count", "finite", "code"),
    [
        (np.diag([1.0, 2.0]), 4, 4, fm.RESULTS.successful),
        # A motion without mass has one pole where it is damped.
        (np.diag([1.0, 0.0]), 4, 3, fm.RESULTS.singular_mass),
        (np.diag([1.0, -2.0]), 2, 2, fm.RESULTS.singular_mass),
        (np.diag([1.0, np.nan]), 2, 0, fm.RESULTS.not_finite),
    ],
)
def test_failures_are_codes(mass, count, finite, code):
    values, found = traced_poles(np.diag([4.0, 9.0]), 0.1 * np.eye(2), mass, count)
    assert int(found) == code
    assert np.sum(np.isfinite(values)) == finite


def test_a_failure_is_collected():
    """A motion without mass or damping has no poles: two of the four are missing."""

    def answer(mass: Any) -> Any:
        with collected() as codes:
            values = fm.poles(oscillators((K, K), (D, 0.0), (M, mass)), count=4)
        return jnp.real(values), codes

    _, codes = jax.jit(answer)(0.0)
    assert fm.RESULTS.singular_mass in [int(code) for code in codes]


def test_more_poles_than_there_can_be_are_refused():
    with pytest.raises(ValueError, match="at most 4 poles"):
        jax.eval_shape(lambda k: fm.poles(oscillators((k, K), (D, D), (M, M)), count=5), 1.0)


def test_second_derivatives_are_refused():
    with pytest.raises(NotImplementedError, match="no second ones"):
        jax.eval_shape(jax.hessian(lambda p: of_numbers(p)[0, 0]), jnp.ones((3, 2)))
