"""Equilibria one after the other: the closed form of a truss (A7) that is pushed through its limit points."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

EA, SPRING = 1e4, 100.0
# The apex from where it stands through the plane of the feet, past both limit points, to as far below; the last twice.
HEIGHTS = np.array([0.9, 0.6, 0.2, 0.0, -0.5, -1.2, -1.2])


def truss(bars=EA, load=0.0):
    """A7 with a dead load on its apex."""
    b = fm.Builder()
    for name, place in {"left": (-10, 0), "right": (10, 0), "apex": (0, 1)}.items():
        b.node(name, place)
    for foot in ("left", "right"):
        b.add(planar.truss, foot, "apex", section=fm.Rigidity(EA=bars, mass=1.0))
        b.fix(foot)
    b.fix("apex", "x")
    b.dof("apex", "y")
    b.force("apex", (0, -load))
    return b


def pushed(bars=EA):
    """A7 with a spring on its apex, whose other end is pushed down: 1 m for each unit of the increment."""
    b = truss(bars)
    b.node("drive", (0, 3))
    b.add(planar.truss, "drive", "apex", section=fm.Rigidity(EA=2 * SPRING, mass=1.0))
    b.fix("drive", "x")
    b.prescribe("drive", "y", -1.0, increment=True)
    return b.build()


def load_at(y):
    """Load down that holds the apex at a height, closed form."""
    return 2 * EA * (1 / np.hypot(10, y) - 1 / np.hypot(10, 1)) * y


# Way of the apex, and what the spring gives way.
STROKES = 1 - HEIGHTS + load_at(HEIGHTS) / SPRING


def force(model):
    """Force down on the drive at every stroke, (states,) [N]."""
    along = fm.equilibria(model, increment=STROKES)
    return -along.reactions[:, along.labels.known("drive")[1]]


def test_a_truss_is_pushed_through():
    found = fm.equilibria(pushed(), increment=STROKES)
    # Round-off over the stiffness along the stroke, which is 1e-3 of that of the bars.
    np.testing.assert_allclose(found.at("apex")[:, 1], HEIGHTS, atol=1e-12)
    np.testing.assert_allclose(force(pushed()), load_at(HEIGHTS), rtol=1e-10, atol=1e-10)
    assert found.x.shape == (7, found.model.topology.n_x)
    alone = fm.equilibrium(pushed(), increment=float(STROKES[2]))
    for name in ("x", "e", "sigma", "reactions"):
        np.testing.assert_allclose(getattr(found[2], name), getattr(alone, name), rtol=1e-9, atol=1e-10)
    # Each begins from the one before it, and not from nothing: where nothing changes, nothing is left to do.
    assert found.iterations[-1] == 1 < fm.equilibrium(pushed(), increment=float(STROKES[-1])).iterations
    assert "Equilibria: 7 states, drive.y moves most" in repr(found)


@pytest.mark.slow
@pytest.mark.parametrize("differentiate", [jax.jacfwd, jax.jacrev])
def test_derivatives_along_a_stroke(differentiate):
    slopes = differentiate(lambda bars: force(pushed(bars)))(EA)
    # P(y, EA) at s = 1 - y + P/c: at constant s the apex gives way by dy = dP/c.
    by_height = 2 * EA * (100 / np.hypot(10, HEIGHTS) ** 3 - 1 / np.hypot(10, 1))
    expected = load_at(HEIGHTS) / EA / (1 - by_height / SPRING)
    np.testing.assert_allclose(slopes, expected, rtol=1e-9, atol=1e-14)


def test_loads_beyond_the_limit_are_told_apart():
    limit = 2e4 * (1 - (10 / np.hypot(10, 1)) ** (2 / 3)) ** 1.5
    model, shares = truss(load=limit).build(), np.array([0.5, 1.5, 0.9])
    found = fm.equilibria(model, load_factor=shares, throw=False)
    assert [fm.RESULTS(int(code)).name for code in found.result] == ["successful", "not_converged", "successful"]
    # The last one from the first.
    heights = np.asarray(found.at("apex")[:, 1])[[0, 2]]
    np.testing.assert_allclose(load_at(heights), limit * shares[[0, 2]], rtol=1e-9)
    with pytest.raises(fm.AnalysisError, match=r"number 1 was the first .* at load factor 1\.5") as told:
        fm.equilibria(model, load_factor=shares)
    # Load steps end below the limit load, by their smallest share of the way at most, and the model has no laws.
    reached = float(re.findall(r"reached load factor ([\d.]+)\. fm\.path goes past a limit load", str(told.value))[0])
    assert 0.99 < reached <= 1.0
    assert "law" not in str(told.value)
    with pytest.raises(fm.AnalysisError, match=r"Load steps reached load factor (0\.99\d+|1)\."):
        fm.equilibrium(model, load_factor=1.5)


@pytest.mark.slow
def test_a_law_that_may_hold_the_search_up_is_named():
    """A pull of a thousandth against a spring that gives way for good."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("end", (1, 0))
    b.add(planar.spring_damper, "wall", "end", name="s", law=lambda e, ed: 1e-4 * jnp.tanh(e / 1e-3))
    b.fix("wall")
    b.fix("end", "y")
    b.dof("end", "x")
    b.force("end", (1e-3, 0.0))
    with pytest.raises(fm.AnalysisError, match=r"reached load factor 0\..* A law of spring_damper has a sharp bend"):
        fm.equilibrium(b.build())


@pytest.mark.slow("given4-must be numbers")
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"increment": 0.1}, "as a list"),
        ({"increment": [[0.1]]}, "has shape"),
        ({"increment": [0.1, np.nan]}, "increment"),
        ({"increment": [0.1, 0.2], "load_factor": [1.0, 2.0, 3.0]}, "2 and 3"),
        ({"load_factor": []}, "must be numbers"),
    ],
)
def test_wrong_calls_are_named(given, words):
    with pytest.raises(ValueError, match=words):
        fm.equilibria(pushed(), **{"increment": 0.0, **given})
    with pytest.raises(fm.ModelError, match="no incremental loads"):
        fm.equilibria(truss().build(), increment=[0.1])


def test_a_stroke_goes_back_to_nothing():
    """From a state to one without any load or stroke: that of a bar that stands where it stood."""
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1.0, 0))
    b.fix("a", "y")
    b.fix("b", "y")
    b.add(planar.truss, "a", "b", name="bar", section=fm.Rigidity(EA=1e3))
    b.prescribe("a", "x", 1.0, increment=True)
    b.dof("bar", 1)
    found = fm.equilibria(b.build(), increment=np.array([0.0, 0.2, 0.0]))
    np.testing.assert_allclose(found.x[:, [0, 2]], [[0, 1], [0.2, 1.2], [0, 1]], rtol=0, atol=1e-12)
    assert [float(state.x[0]) for state in found] == found.x[:, 0].tolist()
    for number in (3, -4):
        with pytest.raises(IndexError, match=f"3 equilibria, numbered from 0. Number {number} is none"):
            found[number]
