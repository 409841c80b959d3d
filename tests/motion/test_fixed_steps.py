"""Methods of fixed steps: order, damping, energy over long times, and named refusals."""

import diffrax
import jax
import numpy as np
import pytest
from cases import motions

import flexmb as fm
from flexmb import planar, spatial

SOLVERS = {"alpha": fm.motion.GeneralizedAlpha(), "energy": fm.motion.EnergyKeeping()}


@pytest.fixture(scope="module")
def pendulum():
    return motions.pendulum().build()


@pytest.mark.parametrize("name", SOLVERS)
def test_order_two(pendulum, name):
    """REFERENCES D5, closed form at t = 10: the error falls with the square of the step."""
    errors = []
    for steps in (1000, 2000):
        found = fm.simulate(pendulum, np.array([0.0, 10.0]), solver=SOLVERS[name], dt0=10 / steps)
        errors.append(np.linalg.norm(found.at("mass")[-1] - np.array([-0.2750874626, -0.9614192051])))
    assert errors[0] < 0.02
    np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.05)


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


@pytest.mark.parametrize("radius", [0.0, 0.8, 1.0])
def test_what_a_step_does_not_resolve_is_damped(oscillator, radius):
    """Steps of 160 periods: as the recursion of one coordinate, which dies out but for a radius of one."""
    found = fm.simulate(oscillator, np.arange(0.0, 31.0), solver=fm.motion.GeneralizedAlpha(radius), dt0=1.0)
    expected = recursion(radius, 1e6, 1e-6, 30)
    # Positions are near one.
    np.testing.assert_allclose(np.asarray(found.at("mass"))[:, 0] - 1.0, expected, atol=1e-13)
    late = np.max(np.abs(expected[25:])) / 1e-6
    assert (late > 0.9) if radius == 1.0 else (late < 0.25)


def rod(element, *, space=False, beams=2):
    """Flexible steel strip under its own weight, pinned in the plane and clamped in space, straight and at rest."""
    leaf = fm.Rectangle(0.01, 0.001, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (0.3 * i / beams, 0, 0) if space else (0.3 * i / beams, 0))
    for i in range(beams):
        b.add(element, f"n{i}", f"n{i + 1}", section=leaf, **({"y": (0, 1, 0)} if space else {}))
    if space:
        b.fix("n0")
        b.mass(f"n{beams}", 0.05)
        b.gravity((0.3, 0.2, -9.81))
    else:
        b.fix("n0", "x", "y")
        b.gravity((0, -9.81))
    return b.build()


@pytest.mark.parametrize(("where", "steps"), [("plane", 5000), ("space", 1000)])
def test_energy_is_kept_without_a_trend(where, steps):
    """A flexible mechanism without losses: round-off alone, at steps that do not resolve its axial vibration.

    ``benchmarks/stability.py`` takes 100 000 steps.
    """
    model = rod(planar.beam, beams=1) if where == "plane" else rod(spatial.beam, space=True, beams=1)
    times = np.linspace(0, steps * 1e-3, 101)
    found = fm.simulate(model, times, solver=fm.motion.EnergyKeeping(), dt0=1e-3, max_steps=steps + 1)
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


def test_the_trapezoidal_rule_gains_energy_where_the_other_does_not():
    """The known failure of trapezoidal steps on bodies that turn; the energy-keeping steps are of the same size."""
    model = motions.double_pendulum().build()
    times = np.linspace(0, 20, 101)
    spread = {}
    for name, solver in (("trapezoidal", fm.motion.GeneralizedAlpha(1.0)), ("keeping", fm.motion.EnergyKeeping())):
        seen = fm.simulate(model, times, solver=solver, dt0=0.02).observe()
        spread[name] = np.ptp(seen.energy) / np.max(seen.kinetic)
    assert spread["keeping"] < 0.02 * spread["trapezoidal"]


def test_too_large_a_step_is_named():
    model = motions.released_guide().build()
    bent = fm.equilibrium(motions.pushed(model, "left2", 0, 1.0))
    explicit = dict(solver=diffrax.Dopri8(), controller=diffrax.ConstantStepSize(), dt0=1e-3)
    with pytest.raises(fm.AnalysisError, match="smaller dt0") as fault:
        fm.simulate(model, np.array([0.0, 0.1]), initial=bent, **explicit)
    assert fault.value.code == "step_too_large"


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, "dt0"),
        ({"dt0": 0.1, "form": "reduced"}, "EnergyKeeping"),
        ({"dt0": 0.1, "loads": {"mass.x": fm.motion.Table([0.0, 1.0], [0.0, 1.0])}}, "StepTo"),
    ],
)
def test_what_fixed_steps_need(pendulum, options, expected):
    with pytest.raises(ValueError, match=expected):
        fm.simulate(pendulum, np.array([0.0, 1.0]), solver=fm.motion.EnergyKeeping(), **options)


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
