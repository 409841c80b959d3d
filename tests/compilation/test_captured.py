"""Functions that a user gives are taken as they are at the call, with the numbers in them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm

TIMES = np.linspace(0.0, 1.0, 3)
# The error of the default tolerance, 1e-5 a step, over a motion of some ten steps.
CLOSE = 1e-4


@pytest.fixture(scope="module")
def mass():
    """A free mass of 2 kg with a force and a sensor along x."""
    b = fm.Builder()
    b.node("m", (0.0, 0.0))
    b.mass("m", 2.0)
    b.fix("m", "y")
    b.input("m", "x")
    b.output("m", "x")
    return b.build()


def end(model, **given):
    return float(fm.simulate(model, TIMES, **given).at("m")[-1, 0])


FORCE = 3.0
FORCES = np.array([3.0, 0.0])


def by_global(t):
    return FORCE * jnp.ones_like(t)


def by_array(t):
    return jnp.asarray(FORCES[0]) * t**0


def by_captured_array(t):
    return jnp.sum(jnp.asarray(FORCES)) + 0 * t


@pytest.mark.slow
@pytest.mark.parametrize("load", [by_global, by_array, by_captured_array])
def test_a_load_follows_what_it_refers_to(mass, load, monkeypatch):
    assert end(mass, loads={"m.x": load}) == approx(3.0 / 4, rel=CLOSE)  # F t^2/2m
    monkeypatch.setitem(globals(), "FORCE", 5.0)
    monkeypatch.setitem(globals(), "FORCES", np.array([5.0, 0.0]))
    assert end(mass, loads={"m.x": load}) == approx(5.0 / 4, rel=CLOSE)


class Gain:
    """A controller with a number that is changed from outside."""

    def __init__(self, value):
        self.value = value

    def __call__(self, t, y):
        return jnp.array([self.value])

    def step(self, t, z, y):
        return jnp.array([self.value]), z


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrap",
    [lambda g: g, lambda g: fm.motion.Feedback(lambda t, z, y: g(t, y)), lambda g: fm.motion.Sampled(g.step, 0.5)],
)
def test_a_controller_follows_what_it_refers_to(mass, wrap):
    gain = Gain(3.0)
    control = wrap(gain)
    assert end(mass, control=control) == approx(3.0 / 4, rel=CLOSE)
    gain.value = 5.0
    assert end(mass, control=control) == approx(5.0 / 4, rel=CLOSE)


@pytest.mark.slow
def test_a_reference_follows_what_it_refers_to(mass):
    import control

    wanted = Gain(3.0)
    proportional = control.ss([], [], [], [[1.0]])

    def reference(t):
        return wanted(t, None)

    def expected(r):
        return r * (1 - np.cos(np.sqrt(1 / 2.0)))  # 2 x'' = r - x

    for value in (3.0, 5.0):
        wanted.value = value
        assert end(mass, control=proportional, reference=reference) == approx(expected(value), rel=CLOSE)


@pytest.mark.slow
def test_an_event_follows_what_it_refers_to(mass):
    import diffrax

    limit = Gain(0.3)
    # Displacements are in extents of the mechanism: of a point, 1 m.
    event = diffrax.Event(lambda t, y, args, **_: y.u[0] > limit.value)
    steps = {"controller": diffrax.ConstantStepSize(), "dt0": 0.01}
    for value in (0.3, 0.1):
        limit.value = value
        found = fm.simulate(mass, np.linspace(0, 1, 101), loads={"m.x": by_global}, event=event, **steps)
        x = np.asarray(found.at("m")[:, 0])
        # F t^2/2m passes the limit in one of the steps of 0.01 s.
        assert abs(np.sum(np.isfinite(x)) / 100 - np.sqrt(4 * value / 3)) < 0.02


@pytest.mark.slow
def test_an_event_of_diffrax_is_passed_through(mass):
    import diffrax

    event = diffrax.Event(diffrax.steady_state_event(rtol=1e-3, atol=1e-3))
    assert fm.simulate(mass, TIMES, event=event).result == 0


@pytest.mark.slow
def test_derivative_by_a_captured_number(mass):
    """x = a t^2/2m of a load, in reverse, and of a controller, forward."""
    import diffrax

    def moved(a):
        return fm.simulate(mass, TIMES, loads={"m.x": lambda t: a * t**0}).at("m")[-1, 0]

    assert float(fm.jit(jax.grad(moved))(3.0)) == approx(0.25, rel=CLOSE)

    def controlled(a):
        found = fm.simulate(mass, TIMES, control=lambda t, y: jnp.array([a]), adjoint=diffrax.ForwardMode())
        return found.at("m")[-1, 0]

    assert float(jax.jacfwd(controlled)(3.0)) == approx(0.25, rel=CLOSE)


@pytest.mark.slow
def test_functions_that_differ_in_numbers_share_compiled_code(mass):
    compiled = []

    def listen(event, duration, **_):
        if event == "/jax/core/compile/backend_compile_duration":
            compiled.append(duration)

    def moved(a):
        return end(mass, loads={"m.x": lambda t: a * jnp.sin(t) + jnp.interp(t, jnp.arange(3.0), a * jnp.arange(3.0))})

    first = moved(1.0)
    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        second = moved(2.0)
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)
    assert second == approx(2 * first, rel=CLOSE)
    assert not compiled


@jax.custom_jvp
def held(t):
    return t


@held.defjvp
def _held_jvp(primals, tangents):
    return held(*primals), tangents[0]


def test_functions_with_derivatives_of_their_own_are_told_apart():
    from flexmb.compilation.program import captured

    @jax.custom_jvp
    def other(t):
        return t

    other.defjvp(lambda p, t: (other(*p), 2 * t[0]))
    time = jax.ShapeDtypeStruct((), float)
    assert captured(lambda t: held(t) + 1, time).code == captured(lambda t: held(t) + 2, time).code
    assert captured(held, time).code != captured(other, time).code
    assert captured(jax.nn.relu, time).code == captured(jax.nn.relu, time).code != captured(jax.nn.softplus, time).code


@pytest.mark.slow("<lambda>")
@pytest.mark.parametrize("value", [3.0, "sin", None, lambda t: 1.0 if t > 0.5 else 0.0])
def test_what_is_no_function_is_refused_by_name(mass, value):
    with pytest.raises(fm.ModelError, match=r"Load 'm\.x' (must be|cannot be computed as) a function of time"):
        fm.simulate(mass, TIMES, loads={"m.x": value})


@pytest.mark.slow
def test_an_event_that_is_none_or_holds_at_the_start_is_told(mass):
    import diffrax

    with pytest.raises(ValueError, match="condition of `event` is no number at the start, t = 0 s"):
        fm.simulate(mass, TIMES, event=diffrax.Event(lambda t, y, args, **_: jnp.nan * t))
    with pytest.warns(fm.FlexmbWarning, match="holds at the start. The motion ends there"):
        found = fm.simulate(mass, TIMES, event=diffrax.Event(lambda t, y, args, **_: t > -1))
    x = np.asarray(found.at("m")[:, 0])
    assert np.isfinite(x[0])
    assert not np.any(np.isfinite(x[1:]))
