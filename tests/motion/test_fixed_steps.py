"""Methods of fixed steps: order, damping, energy over long times, and named refusals."""

import diffrax
import jax
import numpy as np
import pytest
from cases import motions
from references import motion_references as reference

import flexmb as fm
from flexmb import planar, spatial

SOLVERS = {"alpha": fm.motion.GeneralizedAlpha(), "energy": fm.motion.EnergyKeeping()}


@pytest.mark.slow
def test_order_two():
    """REFERENCES M1, before chaos has grown: the error falls with the square of the step.

    The known failure of trapezoidal steps on bodies that turn is to gain energy, which the energy-keeping steps, as
    long and as many, do not.
    """
    model = motions.double_pendulum().build()
    times = np.linspace(0, 2, 11)
    exact = reference.double_pendulum(times)["positions"][-1, 1]
    for solver in SOLVERS.values():
        ends = [fm.simulate(model, times, solver=solver, dt0=2 / steps).at("lower")[-1] for steps in (1000, 2000)]
        errors = np.linalg.norm(np.array(ends) - exact, axis=1)
        assert errors[0] < 0.02
        np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.05)
    spread = {}
    for name, solver in (("trapezoidal", fm.motion.GeneralizedAlpha(1.0)), ("keeping", SOLVERS["energy"])):
        seen = fm.simulate(model, 10 * times, solver=solver, dt0=0.02).observe()
        spread[name] = np.ptp(seen.energy) / np.max(seen.kinetic)
    assert spread["keeping"] < 0.02 * spread["trapezoidal"]


@pytest.fixture(scope="module")
def oscillator():
    """A mass of 1 kg on a truss of 1 MN/m, 1 um from where it is unloaded."""
    b = fm.Builder()
    b.node("ground", (0, 0))
    b.node("mass", (1.0, 0))
    b.add(planar.truss, "ground", "mass", section=fm.Rigidity(EA=1e6))
    b.fix("ground")
    b.fix("mass", "y")
    b.mass("mass", 1.0)
    b.start("mass", "x", 1e-6)
    return b.build()


def recursion(radius, stiffness, u, steps):
    """Displacements of an oscillator of unit mass at unit steps, by the method written for one coordinate."""
    m, f = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
    gamma = 0.5 + f - m
    beta = (0.5 + gamma) ** 2 / 4
    w, a = 0.0, -stiffness * u
    mean, found = a, [u]
    for _ in range(steps):
        known = u + w + (0.5 - beta) * mean + beta * (f * a - m * mean) / (1 - m)
        u = known / (1 + stiffness * beta * (1 - f) / (1 - m))
        before, a, last = a, -stiffness * u, mean
        mean = ((1 - f) * a + f * before - m * last) / (1 - m)
        w = w + (1 - gamma) * last + gamma * mean
        found.append(u)
    return np.array(found)


FEW = {"solver": SOLVERS["energy"], "dt0": 0.000314}


@pytest.mark.slow
def test_steps_that_keep_energy_are_those_of_the_middle_rule(oscillator):
    """Twenty steps a period: w h = 2 tan(phase / 2) of each, where all is linear."""
    found = fm.simulate(oscillator, np.linspace(0, 0.0314, 11), **FEW)
    assert int(found.steps) == 100
    expected = 1e-6 * np.cos(200 * np.arctan(0.157) * np.arange(11) / 10)
    # A bar that turns with its end is linear to 1e-6 of this; positions are near one.
    np.testing.assert_allclose(found.at("mass")[:, 0] - 1.0, expected, atol=1e-11)


@pytest.mark.slow
def test_parts_of_whole_steps(oscillator):
    times = np.linspace(0, 0.0314, 11)
    whole = fm.simulate(oscillator, times, **FEW)
    parts = fm.simulate(oscillator, times, progress=lambda *counts: None, **FEW)
    assert int(whole.steps) == int(parts.steps) == 100
    # Newton's method of each step ends at 1e-10 of its start or so.
    np.testing.assert_allclose(parts.x, whole.x, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.0, 0.8])
def test_what_a_step_does_not_resolve_is_damped(oscillator, radius):
    """Steps of 160 periods: as the recursion of one coordinate, which dies out."""
    found = fm.simulate(oscillator, np.arange(0.0, 31.0), solver=fm.motion.GeneralizedAlpha(radius), dt0=1.0)
    expected = recursion(radius, 1e6, 1e-6, 30)
    # Positions are near one.
    np.testing.assert_allclose(np.asarray(found.at("mass"))[:, 0] - 1.0, expected, atol=1e-13)
    assert np.max(np.abs(expected[25:])) < 0.25 * 1e-6


@pytest.mark.slow
def test_energy_is_kept_without_a_trend():
    """A flexible mechanism without losses: round-off alone, at steps that do not resolve its axial vibration.

    A steel strip under its own weight, clamped, straight and at rest; ``benchmarks/stability.py`` takes 100 000 steps.
    """
    leaf, steps = fm.Rectangle(0.01, 0.001, fm.Material(E=210e9, G=80e9, rho=7850.0)), 1000
    b = fm.Builder()
    b.node("foot", (0, 0, 0))
    b.node("tip", (0.3, 0, 0))
    b.add(spatial.beam, "foot", "tip", section=leaf, y=(0, 1, 0))
    b.fix("foot")
    b.mass("tip", 0.05)
    b.gravity((0.3, 0.2, -9.81))
    model = b.build()
    times = np.linspace(0, steps * 1e-3, 101)
    found = fm.simulate(model, times, solver=SOLVERS["energy"], dt0=1e-3)
    assert int(found.steps) == steps
    seen = found.observe()
    greatest = np.max(seen.kinetic)
    assert greatest > 1e-3
    # Asked for is 1e-6; each step is solved to round-off of the positions, some 1e-14 of its energy.
    assert np.ptp(seen.energy) < 1e-9 * greatest
    trend = np.polyfit(times, seen.energy, 1)[0] * times[-1]
    assert abs(trend) < 1e-9 * greatest
    held = np.asarray(model.topology.e.fixed)
    assert np.max(np.abs(np.asarray(seen.e)[:, held]), initial=0.0) < 1e-12


@pytest.mark.slow
def test_too_large_a_step_is_named(oscillator):
    explicit = dict(solver=diffrax.Heun(), controller=diffrax.ConstantStepSize(), dt0=1.0)
    with pytest.raises(fm.AnalysisError, match="smaller dt0") as fault:
        fm.simulate(oscillator, np.array([0.0, 100.0]), **explicit)
    assert fault.value.code == "step_too_large"


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, "dt0"),
        ({"dt0": 0.1, "form": "reduced"}, "EnergyKeeping"),
        ({"dt0": 0.1, "loads": {"mass.x": fm.motion.Table([0.0, 1.0], [0.0, 1.0])}}, "StepTo"),
    ],
)
def test_what_fixed_steps_need(oscillator, options, expected):
    with pytest.raises(ValueError, match=expected):
        fm.simulate(oscillator, np.array([0.0, 1.0]), solver=fm.motion.EnergyKeeping(), **options)


@pytest.mark.parametrize("radius", [-0.5, 3.0, np.nan])
def test_a_spectral_radius_beyond_its_range_is_refused(radius):
    with pytest.raises(ValueError, match="`radius` must be at least 0 and at most 1"):
        fm.motion.GeneralizedAlpha(radius)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "derivative", "adjoint"),
    [("alpha", jax.grad, diffrax.RecursiveCheckpointAdjoint()), ("energy", jax.jacfwd, diffrax.ForwardMode())],
    ids=["alpha", "energy"],
)
def test_derivatives_are_those_of_the_solution_of_every_step(name, derivative, adjoint):
    """Reverse of one and forward of the other, since both solve their steps by the same function, and differences."""

    def place(stiffness):
        b = fm.Builder()
        b.node("ground", (0, 0))
        b.node("mass", (1.0, 0))
        b.add(planar.truss, "ground", "mass", section=fm.Rigidity(EA=stiffness))
        b.fix("ground")
        b.mass("mass", 1.0)
        b.start("mass", "x", 0.1)
        b.start("mass", "y", 0.0, velocity=3.0)
        found = fm.simulate(b.build(), np.array([0.0, 0.4]), solver=SOLVERS[name], dt0=0.02, adjoint=adjoint)
        return found.at("mass")[-1, 0]

    difference = (place(100.0 + 1e-3) - place(100.0 - 1e-3)) / 2e-3
    # Differences: round-off 1e-15/1e-3.
    np.testing.assert_allclose(derivative(place)(100.0), difference, rtol=1e-7)
