"""Answers that designs are asked for, against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm


def swing(omega, damping):
    return jnp.array([[0.0, 1.0], [-(omega**2), -2 * damping * omega]])


@jax.jit
def settled(omega, damping):
    return fm.design.settling_time(
        swing(omega, damping), jnp.array([1.0, 0.0]), jnp.array([1.0, 0.0]), 0.02, horizon=10.0
    )


@pytest.mark.slow
def test_settling_of_a_decay():
    """exp(-a t) = 0.02 at t = ln(50)/a."""

    def of(a):
        return fm.design.settling_time(-a[None, None], jnp.ones(1), jnp.ones(1), 0.02, horizon=10.0)

    at = jnp.asarray(1.7)
    exact = np.log(50) / 1.7
    assert float(jax.jit(of)(at)) == approx(exact, rel=1e-12)
    for derivative in (jax.jacfwd(of), jax.jacrev(of)):
        assert float(jax.jit(derivative)(at)) == approx(-exact / 1.7, rel=1e-10)
    assert float(jax.jit(jax.hessian(of))(at)) == approx(2 * exact / 1.7**2, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("hertz", [300.0, 1e5])
def test_settling_beside_a_stiff_vibration(hertz):
    """One that is neither moved nor seen changes nothing, however fast it is."""
    own, stiff, none = swing(12.0, 0.13), swing(2 * np.pi * hertz, 0.02), np.zeros((2, 2))
    start = np.array([1.0, 0.0, 0.0, 0.0])
    whole = np.block([[own, none], [none, stiff]])
    found = jax.jit(lambda a: fm.design.settling_time(a, start, start, 0.02, horizon=10.0))(whole)
    assert found == approx(float(settled(12.0, 0.13)), rel=1e-9)


@pytest.mark.slow
def test_settling_of_a_swing():
    """Release of a damped oscillator, closed form on a grid of a microsecond."""
    omega, damping = 12.0, 0.13
    t = np.linspace(0, 10, 10_000_001)
    free = omega * np.sqrt(1 - damping**2)
    y = np.exp(-damping * omega * t) * (np.cos(free * t) + damping * omega / free * np.sin(free * t))
    exact = t[np.flatnonzero(np.abs(y) > 0.02)[-1]]
    assert float(settled(omega, damping)) == approx(exact, abs=2e-6)
    h = 1e-5
    difference = (float(settled(omega, damping + h)) - float(settled(omega, damping - h))) / (2 * h)
    for derivative in (jax.jacfwd(settled, argnums=1), jax.jacrev(settled, argnums=1)):
        assert float(jax.jit(derivative)(omega, damping)) == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_what_does_not_settle():
    assert float(settled(12.0, 0.0)) == np.inf
    assert float(settled(12.0, -0.1)) == np.inf
    # Grows past all numbers within the horizon.
    assert float(settled(1e4, -0.5)) == np.inf
    assert float(fm.design.settling_time(-jnp.eye(1), jnp.ones(1), jnp.ones(1), 2.0, horizon=1.0)) == 0.0
    with pytest.raises(ValueError, match="must be positive"):
        fm.design.settling_time(-jnp.eye(1), jnp.ones(1), jnp.ones(1), 2.0, horizon=0.0)
