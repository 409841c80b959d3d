"""Derivatives of a motion by the times at which its loads bend or jump: those of the convolution in closed form."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.integrate import quad

import flexmb as fm
from flexmb import planar
from flexmb.motion.drive import Table
from flexmb.motion.drives_by_name import Drives, driven_by, jump_times

MASS, STIFFNESS, DAMPING = 2.0, 500.0, 3.0
# Between steps, whose places are not to count.
LAST = 0.34
TIMES = np.array([0.0, LAST, 0.4])
BEND = 0.2


def built(mass):
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("cart", (0.1, 0.0))
    # A bar of EA has the stiffness EA/l.
    section, damping = fm.Rigidity(EA=0.1 * STIFFNESS), fm.Damping(EA=0.1 * DAMPING)
    b.add(planar.truss, "foot", "cart", section=section, damping=damping)
    b.fix("foot")
    b.fix("cart", "y")
    b.mass("cart", mass)
    return b.build()


@functools.cache
def oscillator():
    return built(MASS)


def answer_to(force, begin, end):
    """Displacement in the end under a force that acts from begin to end."""
    decay = DAMPING / (2 * MASS)
    rate = np.sqrt(STIFFNESS / MASS - decay**2)

    def own(t):
        return force(t) * np.exp(-decay * (LAST - t)) * np.sin(rate * (LAST - t)) / (MASS * rate)

    return quad(own, begin, end, epsabs=1e-14)[0]


def moved(load, **options):
    return fm.simulate(oscillator(), TIMES, loads={"cart.x": load}, **options).at("cart")[1, 0]


@pytest.mark.slow
def test_a_step_onto_a_jump_does_not_look_beyond_it():
    def steps(p):
        load = {"cart.x": lambda t: jnp.where(t >= p, 500.0, 0.0)}
        return fm.simulate(oscillator(), TIMES, loads=load, jumps=[p]).steps

    # Where round-off leads the last stage of that step beyond the jump, it is refused again and again: 44 steps.
    assert fm.jit(steps)(BEND) < 25


@pytest.mark.slow
def test_derivative_by_the_mass_across_two_jumps():
    """Steps end before a jump and begin behind it, with other accelerations, forward and in reverse."""

    def end(mass):
        pulse = {"cart.x": lambda t: jnp.where((t > 0.1) & (t < BEND), 500.0, 0.0)}
        return fm.simulate(built(mass), TIMES, loads=pulse, jumps=[0.1, BEND], rtol=1e-7).at("cart")[1, 0]

    def exact(mass):
        decay = DAMPING / (2 * mass)
        rate = np.sqrt(STIFFNESS / mass - decay**2)

        def added(t):
            return 500.0 * np.exp(-decay * (LAST - t)) * np.sin(rate * (LAST - t)) / (mass * rate)

        return quad(added, 0.1, BEND, epsabs=1e-14)[0]

    value, slope = jax.value_and_grad(end)(MASS)
    assert value == approx(exact(MASS) + 0.1, rel=1e-6)
    # Errors of steps and of central differences.
    assert slope == approx((exact(MASS + 1e-4) - exact(MASS - 1e-4)) / 2e-4, rel=1e-5)


@pytest.mark.slow
def test_derivative_by_a_bend_that_stands_in_jumps():
    slope = fm.jit(jax.grad(lambda p: moved(lambda t: 5 * jnp.maximum(t - p, 0.0), jumps=[p])))
    for bend in BEND + 0.001 * np.arange(12):
        # The tolerance of a step, 1e-4.
        assert slope(bend) == approx(answer_to(lambda t: -5.0, bend, LAST), rel=1e-4)


@pytest.mark.slow
def test_derivative_by_the_time_of_a_jump_of_what_moves():
    slope = fm.jit(jax.grad(lambda p: moved(lambda t: 20 + jnp.where(t > p, 5.0, 0.0), jumps=[p])))
    decay = DAMPING / (2 * MASS)
    rate = np.sqrt(STIFFNESS / MASS - decay**2)
    left = LAST - BEND
    # Less of what the jump adds. Steps to 1e-5 leave 6e-5; when they moved along, they left 32 %.
    wanted = -5 * np.exp(-decay * left) * np.sin(rate * left) / (MASS * rate)
    assert slope(BEND) == approx(wanted, rel=2e-4)


@pytest.mark.slow
def test_derivative_by_the_times_of_a_table():
    begin, end = times = np.array([0.05, BEND])
    slopes = jax.grad(lambda times: moved(Table(times, jnp.array([0.0, 5.0])), rtol=1e-6))(times)
    wanted = [
        answer_to(lambda t: -5 * (end - t) / (end - begin) ** 2, begin, end),
        answer_to(lambda t: -5 * (t - begin) / (end - begin) ** 2, begin, end),
    ]
    # Steps that moved along with its times left 5e-3, a bend taken for half of either side 1e-2.
    np.testing.assert_allclose(slopes, wanted, rtol=5e-5)


def test_where_a_table_bends_it_is_that_of_one_piece_and_moves_no_steps():
    times = np.array([0.05, BEND])

    def both(times):
        table = Table(times, jnp.array([0.0, 5.0]))
        return table(BEND), jump_times(Drives(), driven_by(oscillator(), Drives(loads={"cart.x": table})))

    value, kinks = jax.jacfwd(both)(times)
    np.testing.assert_allclose(value, [0.0, -5 / np.diff(times)[0]], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(kinks, np.zeros((2, 2)))


def test_times_of_jumps_may_be_traced_one_by_one():
    shape = jax.eval_shape(lambda p: jump_times(Drives(jumps=[p, 2 * p]), ()), BEND)
    assert shape.shape == (2,)
    with pytest.raises(ValueError, match="must be a list of times"):
        jump_times(Drives(jumps=[[0.1], [0.2]]), ())


@pytest.mark.slow
def test_derivatives_forward_name_what_they_ask_for():
    with pytest.raises(TypeError, match=r"adjoint=diffrax\.ForwardMode"):
        jax.jacfwd(lambda f: moved(lambda t: f * t))(1.0)


@pytest.mark.slow
def test_second_derivatives_in_reverse_name_what_they_ask_for():
    with pytest.raises(TypeError, match="differentiated once in reverse"):
        jax.eval_shape(jax.grad(jax.grad(lambda f: moved(lambda t: f * t))), 1.0)


def test_a_law_made_of_a_table_is_no_prescribed_motion():
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("cart", (0.1, 0.0))
    b.add(planar.truss, "foot", "cart", section=fm.Rigidity(EA=50.0))
    b.fix("foot", "y")
    b.fix("cart", "y")
    b.prescribe("foot", "x")
    b.mass("cart", 1.0)
    model, table = b.build(), Table(np.array([0.0, 0.2, 0.4]), np.array([0.0, 0.01, 0.0]))
    for value in (table, fm.trajectory.zv(table, 2.0)):
        with pytest.raises(fm.ModelError, match="Its velocity jumps"):
            fm.simulate(model, TIMES, motion={"foot.x": value})
