"""Derivatives of a motion by its steps taken again, of equations whose solution is known: u = cos(w t), w^2 = k/m."""

import dataclasses
import functools
from typing import NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from jax.tree_util import Partial

import flexmb as fm
from flexmb import planar
from flexmb.math.derivative import with_derivative
from flexmb.motion import Feedback, Integrator, Rodas5P, steps_again
from flexmb.motion.balance import at_start
from flexmb.motion.protocol import MotionState, Tangent, WholeMotion
from flexmb.motion.solve import solve
from flexmb.motion.steps_again import Span, pulled_back

TIGHT = 1e-8
# The second lies within the first step.
ROWS = jnp.array([0.0, 4e-4, 0.3, 0.31, 1.2, 2.0])


class Oscillator(NamedTuple):
    """Mass and spring."""

    mass: jax.Array
    stiffness: jax.Array

    size, states, unknowns, cubic = 1, 0, 1, 0.0

    def residual(self, t, state, z):
        return self.mass * z - self.force(state)

    def force(self, state):
        return -self.stiffness * (state.u + self.cubic * state.u**3)

    def tangent(self, t, state, z):
        one = jnp.ones((1, 1))
        slope = self.stiffness * (1 + 3 * self.cubic * state.u**2)
        return Tangent(slope * one, 0.0 * one, self.mass * one, None)

    def regular(self, by_z):
        return jnp.array(True)

    def acceleration(self, t, state):
        return self.force(state) / self.mass, jnp.array(True)

    def rate_of_memory(self, t, state, z):
        return state.memory

    def settle(self, t, state, mass=None):
        return state

    @property
    def form(self):
        return self

    def whole_motion(self, t, state):
        return WholeMotion(state.u, state.w, state.u, jnp.zeros(0))

    def elastic_stress(self, e):
        return self.stiffness * e


class Stiffening(Oscillator):
    """A spring that stiffens, so that steps depend on the accelerations that they begin with."""

    cubic = 5.0


def solved(equations, span, start, most, **options):
    integrator = Integrator(rtol=TIGHT, atol=0.0, dt0=1e-3, max_steps=most).checked(jumps=False)
    return solve(equations, span, start, integrator, at_start(), 50.0, every=True, **options)


def moved(equations, span, start, most=400):
    """States of which derivatives are those of the steps taken again."""
    ahead = functools.partial(solved, most=most, adjoint=diffrax.ForwardMode())

    def back(parts, ends, changes):
        return pulled_back(parts, ends, changes.states)

    own = lambda *given: ahead(*given)[0]  # noqa: E731
    return with_derivative(own, functools.partial(ahead, recorded=True), back, equations, span, start)


def place(p, rows=ROWS, kind=Oscillator, most=400, stops=None, which=0):
    mass, stiffness, begin, t0, t1 = p
    start = MotionState(begin[None], jnp.zeros(1), jnp.zeros(0))
    span = Span(t0, t1, t0 + (t1 - t0) * rows / 2.0, stops)
    states = moved(kind(mass, stiffness), span, start, most).states
    return jnp.stack([states.u[:, 0], states.w[:, 0]])[which]


def by_hand(p, rows=ROWS):
    mass, stiffness, begin, t0, t1 = p
    return begin * jnp.cos(jnp.sqrt(stiffness / mass) * (t1 - t0) * rows / 2.0)


P = jnp.array([0.7, 90.0, 0.4, 0.25, 2.25])


def test_derivatives_by_numbers_start_and_times_are_those_by_hand():
    slopes = jax.jit(jax.jacrev(place))(P)
    expected = jax.jacobian(by_hand)(P)
    # Of some hundred steps, each with a tolerance of 1e-8.
    np.testing.assert_allclose(slopes[:, :3], expected[:, :3], rtol=0, atol=3e-6)
    # By times within a step the slope of its cubic, a hundred times less exact; the last is at the end of one.
    np.testing.assert_allclose(slopes[:, 3:], expected[:, 3:], rtol=0, atol=1e-4)
    np.testing.assert_allclose(slopes[-1, 3:], expected[-1, 3:], rtol=0, atol=3e-6)
    # A motion that begins later is the same.
    np.testing.assert_allclose(slopes[:, 3] + slopes[:, 4], 0.0, atol=1e-12)


def by_diffrax(p, kind, stops):
    """The same by diffrax's loop, which JAX differentiates by itself."""
    mass, stiffness, begin, t0, t1 = p
    start = MotionState(begin[None], jnp.zeros(1), jnp.zeros(0))
    span = Span(t0, t1, t0 + (t1 - t0) * ROWS / 2.0, stops)
    adjoint = diffrax.RecursiveCheckpointAdjoint()
    states = solved(kind(mass, stiffness), span, start, 2000, adjoint=adjoint)[0].states
    return jnp.stack([states.u[:, 0], states.w[:, 0]])


@pytest.mark.slow
def test_derivatives_are_those_of_the_steps_themselves():
    kind, stops = Stiffening, jnp.array([0.9, 1.7])
    own = jax.jit(jax.jacrev(functools.partial(place, kind=kind, stops=stops, most=2000, which=np.arange(2))))(P)
    other = jax.jit(jax.jacrev(functools.partial(by_diffrax, kind=kind, stops=stops)))(P)
    # By the begin alone diffrax differs: behind a stop it moves none of its steps along.
    np.testing.assert_allclose(own[..., [0, 1, 2, 4]], other[..., [0, 1, 2, 4]], rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_long_motion_stores_few_states_and_computes_the_others_again(monkeypatch):
    slopes = jax.jit(jax.jacrev(place))(P)
    monkeypatch.setattr(steps_again, "FEWEST", 1)
    for stored in (1, 7):
        monkeypatch.setattr(steps_again, "STORED", stored)
        few = jax.jit(jax.jacrev(functools.partial(place, most=401 + stored)))(P)
        np.testing.assert_allclose(few, slopes, rtol=1e-12, atol=1e-14)


@pytest.mark.slow
def test_a_batch_is_each_of_its_motions():
    every = P * jnp.array([[1.0], [1.3], [0.6]])
    together = jax.jit(jax.vmap(jax.jacrev(place)))(every)
    apart = [jax.jit(jax.jacrev(place))(p) for p in every]
    np.testing.assert_allclose(together, apart, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_stops_take_the_steps_behind_them_along():
    """Over the steps from a stop on, the derivative by all times at once is that of a shift, which changes nothing."""

    def shifted(by):
        return place(P.at[3:].add(by), stops=jnp.array([0.9, 1.7]) + by)

    np.testing.assert_allclose(jax.jit(jax.jacrev(shifted))(0.0), 0.0, atol=1e-12)


@pytest.mark.slow
def test_what_is_not_reached_gives_no_derivative():
    slopes = jax.jit(jax.jacrev(functools.partial(place, most=20)))(P)
    reached = np.isfinite(place(P, most=20))
    assert 0 < reached.sum() < len(ROWS)
    np.testing.assert_allclose(slopes[reached][:, :3], jax.jacobian(by_hand)(P)[reached][:, :3], rtol=0, atol=3e-6)
    assert np.all(np.isnan(slopes[~reached]))


@pytest.mark.slow
def test_failures_are_raised_under_grad_too():
    """What has no derivative, as the outcome, is a number there as anywhere."""
    model = mechanisms.planar_guide(5e-4, elongation=False, force=(0.0, -1.0)).build()

    def last(parameters):
        return fm.simulate(dataclasses.replace(model, parameters=parameters), np.array([0.0, 0.1]), max_steps=2).x[
            -1, 0
        ]

    with pytest.raises(fm.AnalysisError, match="max_steps"):
        jax.grad(last, allow_int=True)(model.parameters)


def swinging(mass=2.0):
    """A mass on a soft bar that swings, and a force and a place by which it may be controlled."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "foot", "mass", name="bar", section=fm.Rigidity(EA=800.0), damping=fm.Damping(EA=1.0))
    b.fix("foot")
    b.mass("mass", mass)
    b.force("mass", (0, -9.0))
    b.input("mass", "y")
    b.output("mass", "y")
    return b.build()


MODEL = swinging()
# The first time is the start; others lie within one step and on the end.
TIMES = np.array([0.0, 1e-4, 1.1e-4, 0.3, 1.0])


def both(model=MODEL, times=TIMES, **options):
    return [fm.simulate(model, times, throw=False, solver=solver, **options) for solver in (None, Rodas5P())]


def output(t, z, y, gain):
    return gain * z


def lag(t, z, y):
    return 5.0 * (y - z)


def loop(gain):
    """Feedback with a state of its own, whose error counts by itself; its first step is much too long and refused."""
    control = Feedback(Partial(output, gain=gain), lag, jnp.zeros(1))
    return dict(control=control, rtol=1e-7, dt0=0.5)


@pytest.mark.slow
def test_states_and_steps_are_those_of_the_solver_that_is_asked_for():
    for own, other in (both(), both(**loop(-3.0))):
        assert int(own.steps) == int(other.steps) > 10
        # Round-off of some hundred steps, of accelerations some 1e4 times as large.
        np.testing.assert_allclose(own.x, other.x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(own.xd, other.xd, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(own.x[0], MODEL.parameters.reference)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "code"),
    [
        (dict(max_steps=5), "motion_unfinished"),
        (dict(model=swinging(mass=0.0)), "singular_mass"),
        (loop(1e6), "ran_away"),
    ],
    ids=lambda of: of if isinstance(of, str) else "",
)
def test_failures_are_those_of_the_solver_that_is_asked_for(options, code):
    own, other = both(**options)
    assert {fm.RESULTS(int(found.result)).name for found in (own, other)} == {code}
    np.testing.assert_array_equal(np.isfinite(own.x), np.isfinite(other.x))
    assert int(own.steps) == int(other.steps)


@pytest.mark.slow
def test_motions_of_a_batch_end_each_at_its_own_time():
    ends = jnp.array([0.2, 1.0])
    rows = jax.vmap(lambda end: fm.simulate(MODEL, jnp.stack([jnp.zeros(()), end])).x[-1])(ends)
    for row, end in zip(rows, ends, strict=True):
        alone = fm.simulate(MODEL, np.array([0.0, end]))
        np.testing.assert_allclose(row, alone.x[-1], rtol=0, atol=1e-10)
