"""The way back over the steps of a motion, of equations whose solution is known: u = cos(w t), w^2 = k/m."""

import dataclasses
import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms

import flexmb as fm
from flexmb.math.derivative import with_derivative
from flexmb.motion import Integrator, integrate, tape
from flexmb.motion.balance import at_start
from flexmb.motion.march import march
from flexmb.motion.march_back import march_back
from flexmb.motion.protocol import MotionState, Tangent, WholeMotion
from flexmb.motion.tape import Span

TIGHT = 1e-8
# The second lies within the first step.
ROWS = jnp.array([0.0, 4e-4, 0.3, 0.31, 1.2, 2.0])


class Oscillator(NamedTuple):
    """Mass and spring."""

    mass: jax.Array
    stiffness: jax.Array

    size, states, unknowns, cubic = 1, 0, 1, 0.0

    @property
    def linear(self) -> bool:
        return True

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


class Unsettled(Oscillator):
    """The same, whose first accelerations are asked for."""

    @property
    def linear(self) -> bool:
        return False


class Stiffening(Unsettled):
    """A spring that stiffens, so that steps depend on the accelerations that they begin with."""

    cubic = 5.0


def moved(equations, span, start, most=400):
    """Marched states of which derivatives are those of the way back."""
    one = jnp.asarray(1.0)

    def ahead(*own, **more):
        return march(*own, at_start(), (TIGHT * one, 0.0 * one), lambda fast: 1e-3 * one, most, **more)

    def back(parts, kept, changes):
        return march_back(*parts, kept, changes)

    own = lambda *given: ahead(*given)[0]  # noqa: E731
    return with_derivative(own, functools.partial(ahead, taped=True), back, equations, span, start)


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


@pytest.mark.slow("Oscillator")
@pytest.mark.parametrize("kind", [Oscillator, Unsettled])
def test_derivatives_by_numbers_start_and_times_are_those_by_hand(kind):
    slopes = jax.jit(jax.jacrev(functools.partial(place, kind=kind)))(P)
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
    integrator = Integrator(rtol=TIGHT, atol=0.0, dt0=1e-3).checked(controlled=False, jumps=False)
    given = kind(mass, stiffness), integrator, (None, stops), t0, t1, t0 + (t1 - t0) * ROWS / 2.0, start
    states = integrate._by_diffrax(50.0, *given, at_start()).states
    return jnp.stack([states.u[:, 0], states.w[:, 0]])


def test_derivatives_are_those_of_the_steps_themselves(monkeypatch):
    # The loop of diffrax looks at no energy balance here, which would make other steps.
    monkeypatch.setattr("flexmb.motion.march.gained_along", lambda *given: jnp.zeros(()))
    kind, stops = Stiffening, jnp.array([0.9, 1.7])
    own = jax.jit(jax.jacrev(functools.partial(place, kind=kind, stops=stops, most=2000, which=np.arange(2))))(P)
    other = jax.jit(jax.jacrev(functools.partial(by_diffrax, kind=kind, stops=stops)))(P)
    # By the begin alone diffrax differs: behind a stop it moves none of its steps along.
    np.testing.assert_allclose(own[..., [0, 1, 2, 4]], other[..., [0, 1, 2, 4]], rtol=1e-9, atol=1e-9)


def test_a_long_motion_keeps_few_steps_and_takes_the_others_anew(monkeypatch):
    slopes = jax.jit(jax.jacrev(place))(P)
    for kept in (1, 7):
        monkeypatch.setattr(tape, "KEPT", kept)
        few = jax.jit(jax.jacrev(functools.partial(place, most=401 + kept)))(P)
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


def test_what_is_not_reached_gives_no_derivative():
    slopes = jax.jit(jax.jacrev(functools.partial(place, most=20)))(P)
    reached = np.isfinite(place(P, most=20))
    assert 0 < reached.sum() < len(ROWS)
    np.testing.assert_allclose(slopes[reached][:, :3], jax.jacobian(by_hand)(P)[reached][:, :3], rtol=0, atol=3e-6)
    assert np.all(np.isnan(slopes[~reached]))


@pytest.mark.parametrize("bounds", [{"KEPT": 4}, {"NUMBERS": 16, "FEWEST": 1}, {"NUMBERS": 1, "FEWEST": 4}])
def test_a_tape_finds_its_places(monkeypatch, bounds):
    """Of four steps that are kept: so many, or the 16 numbers of these, or so many at least."""
    for name, value in bounds.items():
        monkeypatch.setattr(tape, name, value)
    most, like = 20, MotionState(jnp.zeros(1), jnp.zeros(1), jnp.zeros(0))
    own = tape.blank_tape(most, like, jnp.zeros(2))
    for step in range(most + 1):
        state = MotionState(jnp.full(1, float(step)), jnp.zeros(1), jnp.zeros(0))
        own = own.with_step(step + 0.5, state, jnp.zeros(2), jnp.array(True))
    assert int(own.steps) == most + 1
    np.testing.assert_array_equal(own.ends[: most + 1], np.arange(most + 1) + 0.5)
    kept = [step for step in range(most + 1) if step < 4 or (step - 4) % own.apart == 0]
    assert own.apart == 5
    assert len(own.carried) == 4 + len(kept[4:]) + 1 + own.apart
    for step in kept:
        assert own.at(own.place(step))[0].u[0] == step
    rest = [int(own.place(step)) for step in range(most + 1) if step not in kept]
    assert min(rest) > own.room
    assert max(rest) < len(own.carried)


def test_failures_are_raised_under_grad_too():
    """What has no derivative, as the outcome, is a number there as anywhere."""
    model = mechanisms.planar_guide(5e-4, elongation=False, force=(0.0, -1.0)).build()

    def last(parameters):
        return fm.simulate(dataclasses.replace(model, parameters=parameters), np.array([0.0, 0.1]), max_steps=2).x[
            -1, 0
        ]

    with pytest.raises(fm.AnalysisError, match="max_steps"):
        jax.grad(last, allow_int=True)(model.parameters)
