"""Derivatives of motions across kinks of laws and controllers, by closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.motions import height_behind_the_stop, thrown_at_a_stop
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.motion.kinks import PARTS, _is_kinked

END = 0.8


def stop(e, ed, *, gap, k):
    return -k * jnp.maximum(-e - gap, 0.0)


def stuck(e, ed, *, force):
    return jnp.where(e < -0.1, -force, 0.0)


def cart(speed, mass):
    b = fm.Builder()
    b.node("wall", (0.0, 0.0))
    b.node("cart", (1.0, 0.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", mass)
    b.dof("cart", "x")
    b.start("cart", "x", 0.0, velocity=-speed)
    return b


@pytest.mark.slow
def test_derivatives_across_a_stop():
    """Flight, half a period on the spring of the stop, flight back; kinks are found to a millionth of a step."""

    def place(p):
        speed, gap, k, mass = p
        b = cart(speed, mass)
        b.add(planar.spring_damper(stop), "wall", "cart", name="stop", gap=gap, k=k)
        return fm.simulate(b.build(), np.array([0.0, 0.5])).at("cart")[-1, 0]

    def by_hand(p):
        speed, gap, k, mass = p
        return 1 - gap + speed * (0.5 - gap / speed - jnp.pi * jnp.sqrt(mass / k))

    for gap in (0.1, 0.103):
        p = jnp.array([1.0, gap, 1e4, 2.0])
        value, slopes = jax.value_and_grad(place)(p)
        # The tolerance of the steps is 1e-5 of the greatest displacement.
        assert value == approx(float(by_hand(p)), abs=1e-5)
        np.testing.assert_allclose(slopes, jax.grad(by_hand)(p), rtol=2e-5)


def thrown(gap, **how):
    """Height at 2 s of a mass that would pass the stop by 10 mm."""
    return fm.simulate(thrown_at_a_stop(gap).build(), np.array([0.0, 2.0]), rtol=1e-7, **how).at("mass")[-1, 1]


@pytest.mark.slow("reduced", "coordinates")
@pytest.mark.parametrize("form", ["coordinates", "reduced"])
def test_a_stop_that_is_met_and_left_within_a_step_throws_back(form):
    """Of a free flight any step is exact, so that its error tells nothing of a stop within it."""
    # Without the stop it would be at -14 m; what the steps leave, of a contact of 10 ms.
    assert float(thrown(0.44, form=form)) == approx(float(height_behind_the_stop(0.44)), abs=1e-3)


@pytest.mark.slow
def test_derivatives_across_a_stop_that_is_met_within_a_step():
    value, slope = jax.value_and_grad(thrown)(jnp.asarray(0.44))
    assert float(value) == approx(float(height_behind_the_stop(0.44)), abs=1e-3)
    assert float(slope) == approx(float(jax.grad(height_behind_the_stop)(0.44)), rel=1e-3)


@pytest.mark.slow
def test_a_barrier_turns_back_what_cannot_pass_it():
    """2 J high and 40 mm wide, before a cart of 0.5 J: energy, whatever the tolerance."""

    def barrier(e, ed):
        s = (e - 0.5) / 0.02
        return jnp.where(jnp.abs(s) < 1, -8.0 * s * (1 - s**2) / 0.02, 0.0)

    b = cart(-1.0, 1.0)
    b.add(planar.spring_damper(barrier), "wall", "cart")
    for rtol in (1e-3, 1e-5, 1e-8):
        x = fm.simulate(b.build(), np.linspace(0.0, 1.0, 101), rtol=rtol).at("cart")[:, 0]
        assert 0.45 < np.max(x) - 1 < 0.5


@pytest.mark.slow
def test_a_force_that_jumps_has_no_derivative_and_says_so():
    def place(force):
        b = cart(1.0, 2.0)
        b.add(planar.spring_damper(stuck), "wall", "cart", name="stuck", force=force)
        return fm.simulate(b.build(), np.array([0.0, 0.13])).at("cart")[-1, 0]

    with pytest.warns(fm.FlexmbWarning, match="force of a law or of a controller jumps as the mechanism moves"):
        jax.grad(place)(5.0)
    # A motion without derivatives is what it is: 0.1 s of flight, then F/m.
    assert place(5.0) == approx(1 - 0.13 + 5.0 / 2 * 0.03**2 / 2, abs=1e-5)


@pytest.mark.slow
def test_derivatives_across_the_limit_of_a_controller():
    """A spring by an actuator of bounded force: that is constant until 0.72 s, and on the other side from 0.83 s."""
    limit, k, mass, start = 2.0, 50.0, 2.0, 0.3

    def place(p):
        limit, k = p
        b = cart(0.0, mass)
        b.start("cart", "x", start)
        b.input("cart", "x", name="drive")
        b.output("cart", "x", name="where")

        def control(t, y):
            return jnp.clip(-k * y, -limit, limit)

        return fm.simulate(b.build(), np.array([0.0, END]), control=control).at("cart")[-1, 0]

    def by_hand(p):
        limit, k = p
        there, rate = limit / k, jnp.sqrt(k / mass)
        after = jnp.sqrt(2 * mass * (start - there) / limit)
        phase = rate * (END - after)
        return 1 + there * jnp.cos(phase) - limit * after / mass / rate * jnp.sin(phase)

    p = jnp.array([limit, k])
    value, slopes = fm.jit(jax.value_and_grad(place))(p)
    assert value == approx(float(by_hand(p)), abs=1e-5)
    np.testing.assert_allclose(slopes, jax.grad(by_hand)(p), rtol=1e-4)


@pytest.mark.parametrize("place", [0.01, 0.3, 0.5, 0.74, 0.95])
def test_what_bends_smoothly_has_no_kink(place):
    at = np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    spike = np.array([i == 3 for i in range(PARTS + 1)], float)[:, None]
    mixed = (at - place) * np.abs(at - place)
    inflected = [np.sin(0.8 * (at - place)), (at - place) ** 3, np.exp(at)]
    # Of a step that resolves it; and round-off of what is constant, or grows as the step does.
    for smooth in (*inflected, at**2, 1e3 + 1e-8 * spike, 0 * at, at + 1e-5 * spike):
        assert not kinked(smooth)
    for bent in (np.maximum(at - place, 0.0), np.abs(at - place), at + 0.1 * np.maximum(at - place, 0) + 7):
        assert kinked(bent)
    # A square that changes its sign has a curvature that jumps, of no slope.
    assert place in (0.01, 0.95) or not kinked(mixed)


def kinked(values):
    steep = np.max(np.abs(np.diff(values, axis=0)), axis=0)
    return bool(_is_kinked(jnp.asarray(values), jnp.asarray(steep))[0])
