"""Derivatives of motions of chains and nets, in reverse mode, against central differences and the dense form."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb.arguments import is_concrete
from flexmb.mechanics.sparse_order import order_of, solution

from .test_chain import arm, pendulum
from .test_net import bob, net

TIMES = np.linspace(0.0, 0.03, 3)
# Stiffness, mass, weight, end and the motion of the foot, as multiples of what they are.
AS_THEY_ARE = jnp.ones(5)


def multiplied(model, factors):
    """A model with another stiffness in bending, mass and weight."""
    own = model.parameters
    section = own.properties[0]["section"]
    section = dataclasses.replace(section, EIy=factors[0] * section.EIy, mass=factors[1] * section.mass)
    properties = ({**own.properties[0], "section": section}, *own.properties[1:])
    loads = dataclasses.replace(own.loads, gravity=factors[2] * own.loads.gravity)
    return dataclasses.replace(model, parameters=dataclasses.replace(own, properties=properties, loads=loads))


def places(factors, **options):
    """Places and velocities of a pendulum on a driven foot, as one number."""

    def foot(t):
        return 0.05 * factors[4] * (1 - jnp.cos(20 * t))

    model, motion = multiplied(pendulum(2), factors), {"n0.y": foot}
    found = fm.simulate(model, TIMES * factors[3], motion=motion, rtol=1e-7, form="chain", **options)
    weights = jnp.sin(1.0 + jnp.arange(found.x.size, dtype=float).reshape(found.x.shape))
    return jnp.sum(weights * (found.x + 0.01 * found.xd))


@pytest.mark.slow
def test_a_pendulum_depends_on_gravity_times_the_square_of_time():
    """Not on its mass; so a change of gravity moves it along its velocity, for half the time that has gone."""
    model, end = bob(mass=0.7), 0.5

    def place(gravity, mass, end):
        own = model.parameters
        loads = dataclasses.replace(own.loads, gravity=gravity * own.loads.gravity)
        properties = tuple({**one, "mass": mass * one["mass"]} if "mass" in one else one for one in own.properties)
        parameters = dataclasses.replace(own, loads=loads, properties=properties)
        times = jnp.stack([jnp.zeros(()), end])
        moving = dataclasses.replace(model, parameters=parameters)
        # The first step is too long, and refused.
        found = fm.simulate(moving, times, rtol=1e-8, form="chain", dt0=0.2)
        # Coordinates of the bob come after those of the other end.
        return found.x[-1, 2], found.xd[-1, 2]

    with_velocity = jax.value_and_grad(place, argnums=(0, 1, 2), has_aux=True)
    (_, velocity), (by_gravity, by_mass, by_end) = with_velocity(*jnp.ones(2), jnp.asarray(end))
    # Some hundred steps with a tolerance of 1e-8.
    np.testing.assert_allclose(by_gravity, end / 2 * velocity, rtol=1e-6)
    np.testing.assert_allclose(by_end, velocity, rtol=1e-6)
    np.testing.assert_allclose(by_mass, 0.0, atol=1e-6)


@pytest.fixture(scope="module")
def slopes():
    return jax.grad(places)(AS_THEY_ARE)


@pytest.mark.slow
def test_derivatives_are_those_of_central_differences(slopes):
    step = 1e-3
    for i, slope in enumerate(slopes):
        beside = [float(places(AS_THEY_ARE.at[i].add(way * step))) for way in (1, -1)]
        # Of steps whose lengths change, with a tolerance of 1e-7, over twice the step; velocities are some hundred
        # times as large.
        np.testing.assert_allclose(slope, (beside[0] - beside[1]) / (2 * step), rtol=2e-4, atol=1e-4)


@pytest.mark.slow
def test_a_users_program_and_a_batch_have_the_same(slopes):
    together = jax.jit(jax.vmap(jax.grad(places)))(jnp.stack([AS_THEY_ARE, 1.01 * AS_THEY_ARE]))
    np.testing.assert_allclose(together[0], slopes, rtol=1e-5)
    np.testing.assert_allclose(together[1], jax.grad(places)(1.01 * AS_THEY_ARE), rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [arm, net])
def test_derivatives_are_those_of_the_dense_form(kind):
    model = kind(2)
    weights = jnp.sin(1.0 + jnp.arange(model.topology.n_x, dtype=float))

    def place(parameters, form):
        own = dataclasses.replace(model, parameters=parameters)
        return jnp.sum(weights * fm.simulate(own, TIMES, rtol=1e-8, form=form).x[-1])

    chain, dense = (
        jax.grad(place, allow_int=True)(model.parameters, form).properties for form in ("chain", "coordinates")
    )
    for one, other in zip(chain, dense, strict=True):
        for name in ("EA", "EIy", "mass", "Jy") if "section" in other else ():
            wanted = getattr(other["section"], name)
            tolerance = 1e-4 * float(jnp.max(jnp.abs(wanted)))
            # Stiff beams ring along, which no tolerance of displacements resolves.
            tolerance *= 100 if name == "EA" else 1
            np.testing.assert_allclose(getattr(one["section"], name), wanted, rtol=0, atol=tolerance, err_msg=name)


def test_jumps_are_refused_by_name():
    def last(by):
        return fm.simulate(pendulum(2), TIMES, loads={"n2.x": lambda t: by * t}, form="chain", jumps=[0.01]).x[-1, 0]

    with pytest.raises(fm.ModelError, match="a motion with jumps or an event"):
        jax.grad(last)(1.0)


@pytest.mark.slow
def test_a_second_derivative_in_reverse_is_refused_by_name():
    with pytest.raises(TypeError, match="differentiated once in reverse"):
        jax.grad(lambda factors: jnp.sum(jax.grad(places)(factors)))(AS_THEY_ARE)


def test_what_is_found_of_a_chain_within_a_trace_serves_others():
    """The first program of a structure does not keep what belongs to it alone; traced connections are refused."""
    model = arm(1)

    @jax.jit
    def within(number):
        order_of(model.topology)
        return number

    within(1.0)
    assert not any(not is_concrete(one) for one in jax.tree.leaves(order_of(model.topology)))
    with pytest.raises(fm.ModelError, match="its connections are traced"):
        jax.jit(lambda model: fm.simulate(model, TIMES, form="chain").x)(model)


@pytest.mark.slow("pendulum")
@pytest.mark.parametrize("kind", [arm, pendulum])
def test_solutions_and_their_derivatives_are_those_of_the_dense_matrix(kind):
    """Of an elastic chain, and of a chain with constraints."""
    topology = kind(2).topology
    order = order_of(topology)
    count = topology.x.free.shape[0] + topology.e.held.shape[0]
    random = np.random.default_rng(1)
    pieces = tuple(jnp.asarray(random.normal(size=(*own.shape, own.shape[1]))) for own in order.unknowns)
    diagonal, right = jnp.full(count, 9.0), jnp.asarray(random.normal(size=count))

    def dense(pieces, diagonal):
        return jax.vmap(lambda one: order.product(pieces, one), 1, 1)(jnp.eye(count)) + jnp.diag(diagonal)

    def solved(pieces, diagonal, right):
        return solution(order, pieces, diagonal, right)

    def densely(pieces, diagonal, right):
        return jnp.linalg.solve(dense(pieces, diagonal), right)

    given = pieces, diagonal, right
    np.testing.assert_allclose(jax.jit(solved)(*given), densely(*given), rtol=1e-9, atol=1e-12)
    weights = jnp.cos(jnp.arange(count, dtype=float))
    own, wanted = (
        jax.jit(jax.grad(lambda *given, of=of: weights @ of(*given), argnums=(0, 1, 2)))(*given)
        for of in (solved, densely)
    )
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-11), own, wanted)
