"""Questions about a stated state: increments, a state of a path or of a motion; against closed forms of a guide."""

import dataclasses
import pickle

import jax
import numpy as np
import pytest
from cases.mechanisms import LENGTH, THICKNESS, WIDTH, cart_on_rod, planar_guide
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, plot

# Printed 78.7500 N (tutorial 3.1); the load that the guide bears takes the share P / 78.75 of its stiffness.
CRITICAL, LOAD = 78.75, 20.0


@pytest.fixture(scope="module")
def pressed():
    """A guide pressed down by an incremental load, and its path to that load."""
    b = planar_guide()
    b.force("left1", (0, -LOAD), increment=True)
    model = b.build()
    return model, fm.path(model, step=1.0)


ASKS = {
    "frequencies": lambda m, **at: fm.frequencies(m, **at)[0] ** 2,
    "modes": lambda m, **at: fm.modes(m, **at).eigenvalues[0],
    "poles": lambda m, **at: np.abs(fm.poles(m, **at)[0]) ** 2,
    "compliance": lambda m, **at: 1 / fm.compliance(m, "left1", **at)[0, 0],
    "directional_compliance": lambda m, **at: 1 / fm.linear.directional_compliance(m, **at)["left1"][0],
    "to_statespace": lambda m, **at: -fm.to_statespace(m, **at).A[1, 0],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ASKS)
def test_a_load_takes_its_share_of_the_stiffness(pressed, name):
    model, path = pressed
    ask = ASKS[name]
    # One degree of freedom about a straight state: K0 + P G0 to round-off.
    for at in ({"increment": 1.0}, {"at": path, "step": -1}, {"at": path.linearization(-1)}):
        assert float(ask(model, **at) / ask(model, increment=0.0)) == approx(1 - LOAD / CRITICAL, rel=1e-9)


@pytest.mark.slow
def test_buckling_counts_from_the_increments_that_act(pressed):
    model, path = pressed
    for at in ({"increment": 1.0}, {"at": path, "step": -1}):
        # What more of the increment it bears.
        assert float(fm.buckling_loads(model, **at)[0]) == approx(CRITICAL / LOAD - 1, rel=1e-8)
    assert float(fm.buckling(model, increment=1.0).multipliers[0]) == approx(CRITICAL / LOAD - 1, rel=1e-8)


@pytest.mark.slow
def test_buckling_about_a_state_without_increments_scales_its_own_loads(pressed):
    model, _ = pressed
    constant = dataclasses.replace(model.parameters, loads=model.parameters.increment, increment=None)
    constant = dataclasses.replace(model, parameters=constant)
    path = fm.path(constant, step=0.5)
    assert float(fm.buckling_loads(constant, at=path, step=1)[0]) == approx(2 * CRITICAL / LOAD, rel=1e-8)


def bent_strip():
    """A strip with a small force and a mass on its end, as cases of a path and of a motion."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (LENGTH, 0))
    section = fm.Rectangle(WIDTH, THICKNESS, fm.Material(E=210e9, G=80e9, rho=0.0, strength=1e7))
    b.add(planar.beam, "foot", "tip", name="strip", section=section, released=(2, 3))
    b.fix("foot")
    b.mass("tip", 0.1, inertia=1e-6)
    b.force("tip", (0, 1e-3), increment=True)
    return b.build()


@pytest.fixture(scope="module")
def bent():
    return bent_strip()


@pytest.mark.slow
def test_stress_of_all_states_is_one_call(bent):
    path = fm.path(bent, step=0.5)
    found = fm.stress(bent, at=path)
    # 6 F L / (w t^2); the square of the slope is 3e-6.
    expected = 6 * 1e-3 * LENGTH / (WIDTH * THICKNESS**2)
    np.testing.assert_allclose(found.maximum, expected * path.load_factor, rtol=1e-5)
    assert found.where[:2] == ("strip", 0.0)
    assert found.where.state == len(path.load_factor) - 1
    np.testing.assert_allclose(found.utilisation[-1], expected / 1e7, rtol=1e-5)
    alone = fm.stress(bent, at=path, step=1)
    np.testing.assert_allclose(found.sigma_x[1], alone.sigma_x, rtol=1e-12)
    np.testing.assert_allclose(found.smooth_maximum()[1], alone.smooth_maximum(), rtol=1e-12)
    assert alone.where.state is None
    assert "of state 2" in repr(found)
    with pytest.raises(ValueError, match="has 3 states: draw one state"):
        fm.plot.stress(found, path)


@pytest.fixture(scope="module")
def swinging(bent):
    """A force twice what the path has, on the strip at rest: it swings about its equilibrium, to twice the stress."""
    stiffness = 3 * 210e9 * WIDTH * THICKNESS**3 / 12 / LENGTH**3
    half = np.pi / np.sqrt(stiffness / 0.1)
    return half, fm.simulate(bent, [0.0, half / 2, half], increment=lambda t: 1.0, rtol=1e-8)


@pytest.mark.slow
def test_what_is_no_time_of_a_motion_is_named_beside_the_nearest(bent, swinging):
    half, motion = swinging
    with pytest.raises(ValueError, match=rf"but is {half / 3:.5g} s\. The nearest are 0, {half / 2:.5g} s"):
        fm.frequencies(bent, at=motion, time=half / 3)


@pytest.mark.slow
def test_states_of_a_motion(bent, swinging):
    half, motion = swinging
    found = fm.stress(bent, at=motion)
    expected = 6 * 1e-3 * LENGTH / (WIDTH * THICKNESS**2)
    # The rotary inertia of the tip adds a share of 1e-6 / (0.1 L^2), a thousandth.
    np.testing.assert_allclose(found.maximum, expected * np.array([0.0, 1.0, 2.0]), rtol=5e-3, atol=1e-3 * expected)
    alone = fm.stress(bent, at=motion, time=half)
    np.testing.assert_allclose(alone.maximum, found.maximum[2], rtol=1e-9)
    at_rest = fm.frequencies(bent, increment=0.0)
    np.testing.assert_allclose(fm.frequencies(bent, at=motion, step=0), at_rest, rtol=1e-8)
    with pytest.raises(NotImplementedError, match=r"fm\.poles"):
        fm.modes(bent, at=motion, time=half)


def thicker():
    return planar_guide(2 * THICKNESS).build()


def renamed():
    """As many coordinates, by other elements."""
    b = planar_guide()
    b.members["other"] = b.members.pop(next(iter(b.members)))
    return b.build()


@pytest.mark.slow(
    "<lambda>-TypeError-not a Model",
    "<lambda>-TypeError-must be a Path",
    "<lambda>-IndexError-2 steps",
    "<lambda>-ValueError-needs at=",
)
@pytest.mark.parametrize(
    ("ask", "kind", "words"),
    [
        (lambda m, p: fm.frequencies(m, at=p), ValueError, r"a Path with 2 states\. Choose one by step="),
        (lambda m, p: fm.frequencies(m, step=1), ValueError, "`step` of fm.frequencies needs at="),
        (lambda m, p: fm.poles(m, at=p, time=0.1), ValueError, "A path has no times"),
        (lambda m, p: fm.modes(m, at=p, step=1, increment=1.0), ValueError, "contradicts at="),
        (lambda m, p: fm.modes(p.linearization(), increment=1.0), ValueError, "contradicts a linearisation"),
        (lambda m, p: fm.frequencies(bent_strip(), at=p, step=0), ValueError, "belongs to another model"),
        (lambda m, p: fm.frequencies(thicker(), at=p, step=0), ValueError, "with other dimensions"),
        (lambda m, p: fm.stress(thicker(), at=p, step=0), ValueError, "with other dimensions"),
        (lambda m, p: fm.stress(thicker(), at=fm.equilibrium(m, increment=0.0)), ValueError, "with other dimensions"),
        (lambda m, p: fm.stress(renamed(), at=fm.equilibrium(m, increment=0.0)), ValueError, "have other names"),
        (lambda m, p: fm.frequencies(m, at=m), TypeError, "not a Model"),
        (lambda m, p: fm.frequencies(thicker(), at=fm.equilibrium(m, increment=0.0)), ValueError, "other dimensions"),
        (lambda m, p: fm.buckling(m, at=p.linearization()), TypeError, "must be a Path"),
        (lambda m, p: fm.frequencies(m, at=p, step=9), IndexError, "2 steps"),
        (lambda m, p: fm.stress(m, step=1), ValueError, "needs at="),
        (lambda m, p: fm.stress(m, at=p, step=0, load_factor=2.0), ValueError, "`load_factor` of fm.stress contra"),
    ],
)
def test_what_does_not_go_together(pressed, ask, kind, words):
    with pytest.raises(kind, match=words):
        ask(*pressed)


def test_an_equilibrium_is_stored_without_its_model(pressed):
    model, _ = pressed
    found = fm.equilibrium(model, increment=0.0)
    assert found.asked_of is model
    stored = pickle.loads(pickle.dumps(found))
    assert stored.asked_of is None
    assert stored.factors is None
    assert stored.states() is None
    np.testing.assert_array_equal(stored.x, found.x)


@pytest.mark.slow
def test_an_equilibrium_is_a_state_to_ask_about(pressed):
    model, _ = pressed
    found = fm.equilibrium(model, increment=1.0)
    # One degree of freedom about a straight state: K0 + P G0 to round-off.
    share = fm.frequencies(model, at=found)[0] ** 2 / fm.frequencies(model, increment=0.0)[0] ** 2
    assert float(share) == approx(1 - LOAD / CRITICAL, rel=1e-9)
    half = fm.equilibria(model, increment=[0.0, 0.5])[1]
    share = fm.frequencies(model, at=half)[0] ** 2 / fm.frequencies(model, increment=0.0)[0] ** 2
    assert float(share) == approx(1 - LOAD / 2 / CRITICAL, rel=1e-9)
    dense, sparse = (fm.frequencies(model, count=1, at=found, sparse=sparse) for sparse in (False, True))
    np.testing.assert_allclose(sparse, dense, rtol=1e-8)
    about = fm.linearize(model, increment=1.0)
    np.testing.assert_allclose(fm.modes(model, at=found).lin.K, about.K, rtol=1e-9)
    assert found.states().model is model


def test_an_equilibrium_that_was_not_found_is_refused(pressed):
    model, _ = pressed
    found = fm.equilibrium(model, increment=0.0)
    missed = dataclasses.replace(found, result=np.array(int(fm.RESULTS.not_converged))).known(model, found.factors)
    for ask in (lambda: fm.frequencies(model, at=missed), lambda: fm.plot.mechanism(missed)):
        with pytest.raises(fm.AnalysisError, match=r"was not found|no state to show"):
            ask()


def test_an_equilibrium_without_its_model_is_refused(pressed):
    model, _ = pressed
    found = fm.equilibrium(model, increment=0.0)
    stored = pickle.loads(pickle.dumps(found))
    with pytest.raises(TypeError, match="without its model and loads"):
        fm.frequencies(model, at=stored)

    def frequency(scale):
        numbers = dataclasses.replace(model.parameters, reference=scale * model.parameters.reference)
        return fm.frequencies(dataclasses.replace(model, parameters=numbers), at=found)[0]

    # Its numbers do not follow those that are differentiated by: zero would be wrong.
    with pytest.raises(TypeError, match=r"fm\.linearize"):
        jax.grad(frequency)(1.0)


def test_a_picture_takes_an_equilibrium_by_its_article(pressed):
    model, _ = pressed
    found = fm.equilibrium(model, increment=1.0)
    plot.stress(fm.stress(model, at=found), found)
    stored = pickle.loads(pickle.dumps(found))
    with pytest.raises(TypeError, match="not an Equilibrium"):
        plot.mechanism(stored)


def test_a_known_state_of_traced_numbers_is_refused():
    """Its derivative would be zero. Dimensions are compared where jax.grad alone traces them."""
    lin = fm.linearize(cart_on_rod(100.0, 1.0).build())

    def first(stiffness):
        return fm.frequencies(cart_on_rod(stiffness, 1.0).build(), at=lin)[0]

    with pytest.raises(TypeError, match="would not follow them"):
        jax.grad(first)(100.0)
    with pytest.raises(TypeError, match="would not follow them"):
        jax.eval_shape(first, 100.0)
    with pytest.raises(ValueError, match="other dimensions"):
        jax.grad(first)(110.0)


@pytest.mark.slow("frequencies-1", "modes-1", "buckling_loads-1")
@pytest.mark.parametrize(
    ("function", "there"),
    [("frequencies", 1), ("modes", 1), ("poles", 2), ("buckling_loads", 1), ("buckling", 1)],
)
def test_fewer_answers_than_wanted_are_told(function, there):
    b = planar_guide()
    b.force("left1", (0, -LOAD))
    model = b.build()
    ask = getattr(fm, function)
    with pytest.warns(fm.FlexmbWarning, match=rf"`count` of fm\.{function} is 50, but .* fewer .*: {there}\."):
        ask(model, count=50)
    # As many as there are: no word.
    ask(model, count=there)
