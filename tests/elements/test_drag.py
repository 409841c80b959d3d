"""Drag against the ground: terminal velocity, decay of modes, gradients."""

import diffrax
import jax
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

GRAVITY, MASS, DRAG = 9.81, 2.0, 3.0
KINDS = pytest.mark.parametrize(("kind", "axes"), [(planar, 2), (spatial, 3)], ids=("plane", "space"))


def falling(kind, axes, drag=DRAG):
    """A point mass in free fall with drag."""
    b = fm.Builder()
    b.node("p", (0.0, 0.0, 0.0)[:axes])
    b.mass("p", MASS)
    b.add(kind.drag, "p", name="drag", damping=drag)
    b.gravity((0.0, -GRAVITY, 0.0)[:axes])
    return b.build()


def beam(kind, axes, element, drag, count=4):
    """Cantilever of 1 m and 0.5 kg/m with drag by length."""
    section = fm.Rigidity(EA=1e5, EIy=1.0, EIz=1.0, GIt=1.0, mass=0.5)
    b = fm.Builder()
    for i in range(count + 1):
        b.node(f"n{i}", (i / count, 0.0, 0.0)[:axes])
    for i in range(count):
        b.add(element, f"n{i}", f"n{i + 1}", name=f"beam {i}", section=section)
        b.add(kind.beam_drag, f"n{i}", f"n{i + 1}", name=f"drag {i}", damping=drag)
    b.fix("n0")
    return b.build()


@pytest.mark.slow("space")
@KINDS
def test_a_falling_mass_approaches_its_terminal_velocity(kind, axes):
    times = np.linspace(0, 4, 9)
    velocity = fm.simulate(falling(kind, axes), times, rtol=1e-8).velocity("p")
    terminal = MASS * GRAVITY / DRAG
    np.testing.assert_allclose(velocity[:, 1], terminal * np.expm1(-DRAG / MASS * times), rtol=0, atol=1e-7 * terminal)


@pytest.mark.slow("space-1")
@pytest.mark.parametrize("count", [1, 4])
@KINDS
def test_drag_by_length_damps_each_mode_like_rayleigh(kind, axes, count):
    """Without rotary inertia the damping is alpha M0, so that every pole has the real part -alpha/2."""
    alpha = 0.8
    poles = np.asarray(fm.poles(beam(kind, axes, kind.beam, alpha * 0.5, count)))
    # Torsion has no mass and no pole; that of elongation does not vanish either.
    np.testing.assert_allclose(np.real(poles), -alpha / 2, rtol=1e-6)


@pytest.mark.slow("space")
@KINDS
def test_spectral_beams_have_nearly_the_same_decay(kind, axes):
    poles = np.asarray(fm.poles(beam(kind, axes, kind.spectral_beam(4), 0.4)))
    lowest = poles[np.argmin(abs(poles))]
    # The cubic between the ends of a quarter differs little from the beam.
    assert float(np.real(lowest)) == approx(-0.4, rel=3e-4)


@pytest.mark.slow
def test_a_free_fall_of_a_rod_has_the_drag_of_its_length():
    """Translation alone: mass m L, drag c L."""
    b = fm.Builder()
    b.node("p", (0.0, 0.0))
    b.node("q", (0.6, 0.8))
    b.add(planar.beam, "p", "q", section=fm.Rigidity(EA=1e3, EIy=1.0, mass=0.5))
    b.add(planar.beam_drag, "p", "q", damping=0.4)
    b.gravity((0.0, -GRAVITY))
    velocity = fm.simulate(b.build(), [0.0, 1.0, 2.0], rtol=1e-8).velocity("q")
    exact = 0.5 * GRAVITY / 0.4 * np.expm1(-0.8 * np.arange(3.0))
    np.testing.assert_allclose(velocity[:, 1], exact, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_derivatives_by_the_drag():
    """Reverse and forward, against the closed form and central differences."""
    model = falling(planar, 2)

    def velocity(drag, **options):
        changed = model.with_property("damping", drag)
        return fm.simulate(changed, np.array([0.0, 1.0]), rtol=1e-9, **options).velocity("p")[-1, 1]

    rate, step = DRAG / MASS, 1e-3
    exact = GRAVITY * MASS * (1 - np.exp(-rate) * (1 + rate)) / DRAG**2
    difference = float(velocity(DRAG + step) - velocity(DRAG - step)) / (2 * step)
    assert difference == approx(exact, rel=1e-6)
    assert float(jax.grad(velocity)(DRAG)) == approx(exact, rel=1e-6)
    forward = jax.jvp(lambda drag: velocity(drag, adjoint=diffrax.ForwardMode()), (DRAG,), (1.0,))[1]
    assert float(forward) == approx(exact, rel=1e-6)


@KINDS
def test_drag_vanishes_exactly_in_the_undeformed_mechanism(kind, axes):
    """In any direction, or `build` refuses it."""
    section = fm.Rigidity(EA=1.0, EIy=1.0, EIz=1.0, GIt=1.0, mass=1.0)
    for places in np.random.default_rng(0).normal(size=(3, 2, axes)):
        b = fm.Builder()
        b.node("p", tuple(places[0]))
        b.node("q", tuple(places[1]))
        b.add(kind.beam, "p", "q", section=section)
        b.add(kind.beam_drag, "p", "q", damping=1.0)
        b.fix("p")
        b.build()
