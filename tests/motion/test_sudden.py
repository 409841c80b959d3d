"""Pulses in functions of time are met, however long a mechanism was at rest before."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.arguments import as_floats
from flexmb.compilation.program import captured, is_wave
from flexmb.motion.sudden import PARTS, sudden_changes

MASS, STIFFNESS, LATE = 2.0, 800.0, 3.0
OMEGA = np.sqrt(STIFFNESS / MASS)
TIMES = np.linspace(0.0, 4.0, 5)


def mass_on_spring():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (1, 0))
    b.fix("wall")
    b.fix("mass", "y")
    b.mass("mass", MASS)
    b.add(planar.truss, "wall", "mass", section=fm.Rigidity(EA=STIFFNESS, mass=0.0))
    return b.build()


def pulse(t, late=LATE, width=0.01):
    return jnp.exp(-(((t - late) / width) ** 2))


def swing(width=0.01):
    """Motion after a Gaussian pulse: its spectrum at the frequency of the mass."""
    size = width * np.sqrt(np.pi) * np.exp(-((OMEGA * width / 2) ** 2)) / (MASS * OMEGA)
    return size * np.sin(OMEGA * (TIMES[-1] - LATE))


@pytest.mark.slow("chain", "diffrax")
@pytest.mark.parametrize(
    "given", [{}, {"form": "chain"}, {"solver": diffrax.Dopri8()}], ids=["own", "chain", "diffrax"]
)
def test_a_pulse_after_long_rest_is_met(given):
    found = fm.simulate(mass_on_spring(), TIMES, loads={"mass.x": pulse}, **given)
    # Tolerance of a step, 1e-5 of the motion, over some dozens.
    assert float(found.at("mass")[-1, 0]) - 1 == approx(swing(), rel=1e-3)


@pytest.mark.slow
def test_where_functions_change_suddenly():
    span, part = np.array([0.0, 2.0]), 2.0 / PARTS

    def edges(*functions):
        found = sudden_changes([captured(f, as_floats(0.0)) for f in functions], span)
        return None if found is None else found[np.isfinite(found)]

    # Begin and end of a window, one part aside; two of them are filled up to a power of two.
    window = lambda t: jnp.where((t > 0.50001) & (t < 0.70001), 1.0, 0.0)  # noqa: E731
    np.testing.assert_allclose(edges(window), [0.5 - part, 0.5 + 2 * part, 0.7 - part, 0.7 + 2 * part], atol=1e-9)
    np.testing.assert_allclose(edges(lambda t: pulse(t, 1.0, 0.01)), [0.967, 1.033], atol=3e-3)
    assert len(edges(window, lambda t: pulse(t, 1.0, 0.01))) == 6
    # On a wave as well, and one of several numbers.
    np.testing.assert_allclose(edges(lambda t: jnp.sin(9 * t) + 0.1 * pulse(t, 1.0)), [0.98, 1.02], atol=0.01)
    assert len(edges(lambda t: jnp.stack([t, 1e-6 * pulse(t, 1.0)]))) == 2
    # What long steps see: constants, ramps, waves, slow decays, wide pulses.
    for function in (lambda t: 0 * t, lambda t: 3 * t, jnp.sin, lambda t: jnp.exp(-t), lambda t: pulse(t, 1.0, 0.5)):
        assert edges(function) is None
    assert edges(lambda t: jnp.where(t < 3, jnp.sin(40 * t), 0.0)) is None

    def printing(t):
        jax.debug.print("{}", t)
        return pulse(t, 1.0)

    assert edges(printing) is None
    host = jax.ShapeDtypeStruct((), float)
    assert len(edges(lambda t: jax.pure_callback(lambda t: np.asarray(t > 1.0, float), host, t))) == 2

    def sized(size):
        # Looked at as it is, whatever derivatives are taken by.
        assert len(edges(lambda t: size * pulse(t, 1.0))) == 2
        return size

    jax.grad(sized)(3.0)
    assert sudden_changes([fm.motion.Table(TIMES, TIMES)], span) is None


def test_a_jump_by_whose_time_a_motion_is_differentiated_has_to_be_named():
    """Its place is found, but as a number without a derivative."""

    def looked_at(named, at, function=lambda t, at: jnp.where(t < at, 0.0, 5.0)):
        own = captured(lambda t: function(t, at), as_floats(0.0))
        return len(sudden_changes([own], np.array([0.0, 4.0]), named))

    with pytest.warns(fm.FlexmbWarning, match=r"jumps at t = 1\.29\d* s, .* as zero. To differentiate"):
        jax.grad(lambda at: at * looked_at(False, at))(1.3)
    # Named, not differentiated, or a bend alone.
    jax.grad(lambda at: at * looked_at(True, at))(1.3)
    looked_at(False, 1.3)
    jax.grad(lambda at: at * looked_at(False, at, lambda t, at: 5 * jnp.maximum(t - at, 0.0)))(1.3)


def test_waves_are_not_looked_at():
    def wave(f):
        return is_wave(captured(f, as_floats(0.0)))

    assert wave(lambda t: 2.0 * jnp.sin(3 * t + 1) - t * jnp.cos(t))
    assert not wave(lambda t: jnp.exp(2.0 * t))
    assert not wave(lambda t: jnp.where(t > 1, jnp.sin(t), 0.0))
