"""Where methods fail: scenes at the ends of their range, each with the methods asked; right, or refused by name.

What is right comes of closed forms, or of dimensional analysis: a mechanism ten times as large under a hundred times
the load takes the same shape, vibrates a tenth as fast, and moves a tenth as fast.
"""

import functools

import diffrax
import jax
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

# Mechanisms in other units of length are meant here.
pytestmark = pytest.mark.filterwarnings("ignore:.*flexmb reads metres:flexmb.FlexmbWarning")

WAVE = 1.8751040687119611  # first root of cos(z) cosh(z) = -1


# -- scenes -------------------------------------------------------------------------------------------------------


def crossed(ratio, force=0.0):
    """A mass on two bars at right angles, one so many times as stiff as the other."""
    b = fm.Builder()
    for node, place in {"soft": (-1, 0), "stiff": (0, -1), "mass": (0, 0)}.items():
        b.node(node, place)
    b.add(planar.truss, "soft", "mass", name="bar", section=fm.Rigidity(EA=100.0))
    b.add(planar.truss, "stiff", "mass", name="rod", section=fm.Rigidity(EA=100.0 * ratio))
    b.fix("soft")
    b.fix("stiff")
    b.mass("mass", 2.0)
    b.force("mass", (force, 0.0))
    return b


def cantilever(slenderness, size=1.0, load=0.02, beams=4):
    """A strip of that length over thickness; load in units of EI/L^2."""
    section = fm.Rectangle(0.1 * size, size / slenderness, fm.Material(E=2e11, G=7.7e10, rho=8000.0))
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(f"n{i}", (size * i / beams, 0))
    for i in range(beams):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section, released=(2, 3))
    b.fix("n0")
    b.force(f"n{beams}", (0.0, load * section.rigidity().EIy / size**2))
    return b


def guide(size, load=2.0):
    """A stage on two leaf springs, all lengths times a size."""
    leaf = fm.Rectangle(0.02 * size, 5e-4 * size, fm.Material(E=2e11, G=7.7e10, rho=8000.0))
    b = fm.Builder()
    for i, x in enumerate((0.0, 0.1)):
        b.node(f"foot{i}", (x * size, 0))
        b.node(f"top{i}", (x * size, 0.1 * size))
        b.add(planar.beam, f"foot{i}", f"top{i}", name=f"leaf{i}", section=leaf)
        b.fix(f"foot{i}")
        b.mass(f"top{i}", 0.1 * size**3)
    b.add(planar.beam, "top0", "top1", name="stage")
    b.force("top0", (load * size**2, 0))
    return b


def spinner(mass=1.0, speed=2 * np.pi):
    """A point on a rigid arm that turns round and round."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("end", (1, 0))
    b.rotation("arm")
    b.add(planar.rigid_beam, "pivot", "arm", "end", name="rod")
    b.fix("pivot")
    b.mass("end", mass)
    b.start("arm", "phi", 0.0, velocity=speed)
    return b


def arch(load):
    """Two bars over a base; its top is the limit point (closed form: l^3 = L0 b^2)."""
    b = fm.Builder()
    for node, place in {"left": (-1, 0), "right": (1, 0), "apex": (0, 0.2)}.items():
        b.node(node, place)
    for side in ("left", "right"):
        b.add(planar.truss, side, "apex", name=f"{side} bar", section=fm.Rigidity(EA=1e4))
        b.fix(side)
    b.fix("apex", "x")
    b.force("apex", (0, -load))
    return b


# -- the table ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1e2, 1e4, 1e6, 1e8])
@pytest.mark.parametrize("sparse", [False, True])
def test_stiffness_ratio(ratio, sparse):
    b = crossed(ratio)
    exact = np.sqrt(np.array([50.0, 50.0 * ratio])) / (2 * np.pi)
    if sparse:
        found = fm.frequencies(b.build(check=False), count=2, sparse=True)
    else:
        found = fm.frequencies(b.build())
    np.testing.assert_allclose(found, exact, rtol=1e-12)
    pushed = crossed(ratio, 1e-3)
    at = fm.equilibrium(pushed.build(check=not sparse), sparse=sparse).at("mass")
    assert float(at[0]) == approx(1e-5, rel=1e-5)  # second order: force over EA


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1e2, 1e5, 1e8])
def test_stiffness_ratio_in_motion(ratio):
    """One period of the soft direction, from rest at a thousandth: the stiff one is not to slow it down.

    The mass starts on the circle about the end of the stiff rod: strained, the rod would vibrate with most of the
    energy, and each of its vibrations would be followed.
    """
    b = crossed(ratio)
    b.dof("mass", "x")
    b.dof("mass", "y")
    b.start("mass", "x", 1e-3)
    b.start("mass", "y", np.sqrt(1 - 1e-6) - 1)
    period = 2 * np.pi / np.sqrt(50.0)
    found = fm.simulate(b.build(), np.array([0.0, period / 2, period]), max_steps=5_000)
    np.testing.assert_allclose(found.at("mass")[:, 0], [1e-3, -1e-3, 1e-3], atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("slenderness", [10.0, 100.0, 1e3, 1e4])
def test_slenderness(slenderness):
    model = cantilever(slenderness).build()
    # Closed forms: small deflection to order (load)^2; frequency with the rotary inertia of a thick strip left aside.
    assert float(fm.equilibrium(model).at("n4")[1]) == approx(0.02 / 3, rel=2e-4)
    omega = WAVE**2 * np.sqrt(2e11 / 8000.0 / 12) / slenderness
    expected = approx(omega / (2 * np.pi), rel=1e-3 + 1.5 / slenderness**2)
    assert float(fm.frequencies(cantilever(slenderness, load=0.0).build())[0]) == expected


@pytest.mark.slow
@pytest.mark.parametrize("slenderness", [10.0, 1e4])
def test_slenderness_by_sparse_factors(slenderness):
    dense, sparse = (cantilever(slenderness).build(check=check) for check in (True, False))
    found = fm.equilibrium(sparse, sparse=True)
    np.testing.assert_allclose(found.x, fm.equilibrium(dense).x, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-5, 1e-3, 10.0, 1e4])
def test_units_from_micrometres_to_kilometres(size):
    """Dimensional analysis; tolerance: round-off of the equilibrium and of the frequency of a bent guide."""
    one, other = guide(1.0).build(), guide(size).build()
    np.testing.assert_allclose(fm.equilibrium(other).at("top0") / size, fm.equilibrium(one).at("top0"), rtol=1e-10)
    np.testing.assert_allclose(fm.frequencies(other) * size, fm.frequencies(one), rtol=1e-8)
    sparse = fm.equilibrium(guide(size).build(check=False), sparse=True)
    np.testing.assert_allclose(sparse.at("top0") / size, fm.equilibrium(one).at("top0"), rtol=1e-8)


@pytest.mark.slow("element1")
@pytest.mark.parametrize("element", [planar.spectral_beam(3), planar.beam])
def test_a_path_in_metres_and_in_micrometres(element):
    """The same steps, critical points included; tolerance: what the place of a critical point is found to."""

    def walked(metre):
        b = fm.Builder()
        section = fm.Rectangle(0.02 * metre, 0.002 * metre, fm.Material(E=2e11 / metre**2, G=8e10 / metre**2))
        for name, place in {"A": (0, 0), "C": (0.1, 0.012), "B": (0.2, 0)}.items():
            b.node(name, (place[0] * metre, place[1] * metre))
        for p, q in ("AC", "CB"):
            b.add(element, p, q, section=section)
        b.fix("A")
        b.fix("B")
        b.force("C", (0.0, -1000.0))
        return fm.path(b.build())

    one, other = walked(1.0), walked(1e6)
    np.testing.assert_allclose(other.load_factor, one.load_factor, rtol=1e-6)
    np.testing.assert_allclose(other.at("C") / 1e6, one.at("C"), rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-5, 1e4])
def test_motion_from_micrometres_to_kilometres(size):
    def swing(size):
        model = guide(size, load=0.0).build()
        bent = fm.equilibrium(guide(size).build())
        return fm.simulate(model, np.linspace(0, 0.05 * size, 3), initial=bent).at("top0") / size

    # The tolerance of a step, 1e-5, over some hundred steps.
    np.testing.assert_allclose(swing(size), swing(1.0), atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_zero_load(sparse):
    model = cantilever(100.0, load=0.0).build(check=not sparse)
    np.testing.assert_array_equal(fm.equilibrium(model, sparse=sparse).x, model.parameters.reference)


@pytest.mark.slow
def test_nothing_buckles_without_load():
    assert not np.any(np.isfinite(fm.buckling_loads(cantilever(100.0, load=0.0).build())))


@pytest.mark.slow
@pytest.mark.parametrize("turns", [1, 3])
def test_turns(turns):
    found = fm.simulate(spinner().build(), np.array([0.0, float(turns)]))
    np.testing.assert_allclose(found.at("arm")[-1], 2 * np.pi * turns, rtol=1e-6)
    # Error of the default tolerance, 1e-5 a step, over a turn or three.
    np.testing.assert_allclose(found.at("end")[-1], [1, 0], atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("mass", [1e-12, 1.0, 1e12])
def test_mass_from_nothing_to_much(mass):
    found = fm.simulate(spinner(mass).build(), np.array([0.0, 1.0]))
    np.testing.assert_allclose(found.at("end")[-1], [1, 0], atol=1e-5)


@pytest.mark.slow
def test_repeated_frequencies():
    """A round bar bends both ways alike; a cluster function has the derivative of either."""

    def first(diameter):
        section = fm.Circle(diameter, fm.Material(E=2e11, G=7.7e10, rho=8000.0))
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("end", (1, 0, 0))
        b.add(spatial.beam, "foot", "end", section=section, y=(0, 1, 0), released=(3, 4, 5, 6))
        b.fix("foot")
        b.mass("end", 5.0)
        for i in (3, 4, 5, 6):
            b.dof("beam 1", i, kind="element")
        return fm.linear.smooth_minimum(fm.frequencies(b.build())[:2])

    at = 0.01
    h = 1e-5 * at
    difference = (float(first(at + h)) - float(first(at - h))) / (2 * h)
    slope = float(jax.jit(jax.grad(first))(at))
    assert np.isfinite(slope)
    assert slope == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_redundant_constraints_are_refused_or_released():
    leaf = fm.Rectangle(0.02, 5e-4, fm.Material(E=2e11, G=7.7e10, rho=8000.0))
    b = fm.Builder()
    for i, x in enumerate((0.0, 0.05, 0.1)):
        b.node(f"foot{i}", (x, 0))
        b.node(f"top{i}", (x, 0.1))
        b.add(planar.beam, f"foot{i}", f"top{i}", name=f"leaf{i}", section=leaf, released=(2, 3))
        b.fix(f"foot{i}")
    b.add(planar.beam, "top0", "top1", name="stage 1")
    b.add(planar.beam, "top1", "top2", name="stage 2")
    b.mass("top1", 1.0)
    with pytest.raises(fm.MechanismError, match="over-constrained"):
        b.build()
    # Three leaf springs with both ends held: stiffness 12 EI/L^3 each, and 13/35 of their mass by cubic shapes; the
    # middle one may stretch, but by symmetry does not.
    r = leaf.rigidity()
    moved = 1.0 + 3 * 13 / 35 * r.mass * 0.1
    expected = np.sqrt(3 * 12 * r.EIy / 0.1**3 / moved) / (2 * np.pi)
    assert float(fm.frequencies(b.build(release="auto"))[0]) == approx(expected, rel=1e-9)


@pytest.mark.slow
def test_beyond_a_limit_point():
    # Top of the load: closed form 2 EA (1/L0 - 1/l) y with l^3 = L0 b^2.
    l0 = np.hypot(1.0, 0.2)
    length = l0 ** (1 / 3)
    top = 2e4 * (1 / l0 - 1 / length) * -np.sqrt(length**2 - 1)
    for share, refused in ((0.99, False), (1.01, True)):
        dense, sparse = arch(share * top).build(), arch(share * top).build(check=False)
        if refused:
            for model, options in ((dense, {}), (sparse, {"sparse": True})):
                with pytest.raises(fm.AnalysisError, match="not found"):
                    fm.equilibrium(model, **options)
            continue
        at = float(fm.equilibrium(dense).at("apex")[1])
        bar = np.hypot(1.0, at)
        # Equilibrium by the closed form of the force.
        assert 2e4 * (1 / bar - 1 / l0) * at == approx(share * top, rel=1e-8)
        np.testing.assert_allclose(fm.equilibrium(sparse, sparse=True).at("apex")[1], at, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("first", [1e-6, 1e-4, 1e-2, 1.0])
def test_any_first_step(first):
    """The default finds its steps whatever the first one was."""
    found = fm.simulate(spinner().build(), np.array([0.0, 1.0]), dt0=first)
    np.testing.assert_allclose(found.at("end")[-1], [1, 0], atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("solver", "steps", "outcome"),
    [
        ("Rodas5P", (1e-1, 1e-2, 1e-3), ("refused", "refused", "right")),
        ("EnergyKeeping", (1e-1, 1e-2, 1e-3), ("refused", "late", "right")),
    ],
)
def test_steps_of_a_fixed_size(solver, steps, outcome):
    """A swing of a stiff guide, whose period is 0.09 s: right, refused, or late by as much as the method says.

    The midpoint rule keeps the amplitude and lowers the frequency: tan(w' h/2) = w h/2.
    """
    model = guide(1.0, load=0.0).build()
    bent = fm.equilibrium(guide(1.0).build())
    times = np.linspace(0, 0.1, 3)
    exact = np.asarray(fm.simulate(model, times, initial=bent, rtol=1e-8).at("top0"))
    omega, rest = 2 * np.pi * float(fm.frequencies(model)[0]), np.array([0, 0.1])
    run = functools.partial(fm.simulate, model, times, initial=bent, solver=getattr(fm, solver)(), throw=False)
    found = []
    for step in steps:
        motion = run(dt0=step, controller=diffrax.ConstantStepSize())
        slow = 2 / step * np.arctan(omega * step / 2)
        late = rest + np.cos(slow * times)[:, None] * (exact[0] - rest)
        off, off_late = (
            np.max(np.abs(np.asarray(motion.at("top0")) - expected)) / np.max(np.abs(exact[0] - exact))
            for expected in (exact, late)
        )
        named = "right" if off < 0.02 else "late" if off_late < 0.02 else "wrong"
        found.append("refused" if int(motion.result) else named)
    assert tuple(found) == outcome
