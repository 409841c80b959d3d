"""Laws that answers obey whatever the mechanism: turned, mirrored, in other units, reversed, by other matrices."""

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial

PLACES = np.array([[0, 0, 0], [0.1, 0.01, 0], [0.19, -0.02, 0.03], [0.12, 0.11, 0.02], [0.3, 0.02, 0]])
BEAMS = [(0, 1), (1, 2), (1, 3), (2, 4), (3, 4)]
# Round-off, times what is lost where stretching is a million times as stiff as bending.
CLOSE = 1e-10


def loop(space, turn=0.0, mirror=False, size=1.0, back=False):
    """A loop of beams on a stalk, its places and load drawn at random, and the matrix that turns it."""
    drawn, kind, d = np.random.default_rng(5), spatial if space else planar, 3 if space else 2
    places = PLACES[:, :d] + drawn.uniform(-0.02, 0.02, (5, d))
    turned = np.eye(d)
    turned[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    turned = turned @ np.diag([1, -1 if mirror else 1] + [1] * (d - 2))
    b = fm.Builder()
    for i, place in enumerate(places):
        b.node(f"n{i}", size * (turned @ place))
    # Forces stay, times stays, lengths grow.
    section = fm.Rigidity(EA=1e4, EIy=0.8 * size**2, EIz=0.8 * size**2, GIt=0.7 * size**2, mass=1.3 / size**2)
    for p, q in BEAMS:
        b.add(kind.beam, f"n{q if back else p}", f"n{p if back else q}", name=f"b{p}{q}", section=section)
    b.fix("n0")
    b.mass("n4", 0.2 / size)
    b.force("n4", turned @ drawn.uniform(-3, 3, d))
    return b.build(), turned


def answers(model):
    """Place of the tip, frequencies and load multipliers."""
    return fm.equilibrium(model).position("n4"), fm.frequencies(model), fm.buckling_loads(model)[:2]


# What is told of its loads, which bend it far, is the same however it is turned.
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:At the load multiplier", "ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize("space", [False, True])
def test_answers_obey_the_laws(space):
    model, _ = loop(space)
    place, hertz, loads = (np.asarray(one) for one in answers(model))
    for how in ({"turn": 1.1}, {"mirror": True}, {"size": 1e3}, {"back": True}):
        other, turned = loop(space, **how)
        there, others, other_loads = answers(other)
        size = how.get("size", 1.0)
        np.testing.assert_allclose(np.asarray(there) / size, turned @ place, rtol=0, atol=CLOSE * 0.3)
        np.testing.assert_allclose(others, hertz, rtol=CLOSE)
        np.testing.assert_allclose(other_loads, loads, rtol=CLOSE)
    compliance = np.asarray(fm.compliance(model, "n4"))
    # Maxwell's law; then matrices in the degrees of freedom beside those in the coordinates, and poles beside modes.
    largest = np.max(np.abs(compliance))
    np.testing.assert_allclose(compliance, compliance.T, rtol=0, atol=CLOSE * largest)
    np.testing.assert_allclose(fm.compliance(model, "n4", sparse=True), compliance, rtol=0, atol=CLOSE * largest)
    np.testing.assert_allclose(fm.frequencies(model, count=4, sparse=True), hertz[:4], rtol=CLOSE)
    poles = np.sort(np.abs(np.imag(fm.poles(model))))[::2] / (2 * np.pi)
    np.testing.assert_allclose(poles[:8], hertz[:8], rtol=CLOSE)


def asked_of(name):
    """An answer of a beam with a mass at its end, of the force on it [N]."""

    def answer(force):
        b = fm.Builder()
        b.node("a", (0.0, 0.0))
        b.node("c", (0.1, 0.0))
        section = fm.Rectangle(0.01, 5e-4, fm.Material(E=200e9, G=77e9, rho=7800))
        b.add(planar.beam, "a", "c", section=section)
        b.fix("a")
        b.mass("c", 0.1, inertia=1e-5)
        b.force("c", (0.0, force))
        b.input("c", "y", name="push")
        b.output("c", "y", name="place")
        model = b.build()
        return {
            "equilibrium": lambda: fm.equilibrium(model).x,
            "equilibria": lambda: fm.equilibria(model, load_factor=[0.0, 1.0]).position("c")[1],
            "frequencies": lambda: fm.frequencies(model),
            "state": lambda: fm.frequencies(fm.linearize(model)),
            "compliance": lambda: fm.compliance(model, "c"),
            "poles": lambda: fm.poles(model, count=2),
            "response": lambda: fm.frequency_response(model, [1.0]).response,
            "load multipliers": lambda: fm.buckling_loads(model),
            "noise": lambda: fm.control.noise_budget(
                fm.damped(model, ratio=0.1), sources={"push": 1.0}, band=(1.0, 50.0)
            ).rms("place"),
            "stress": lambda: fm.stress(model).maximum,
            "smooth stress": lambda: fm.stress(model).smooth_maximum(),
            "sparse equilibrium": lambda: fm.equilibrium(model, sparse=True).x,
            "sparse frequencies": lambda: fm.frequencies(model, count=1, sparse=True),
            "sparse load multipliers": lambda: fm.buckling_loads(model, count=1, sparse=True),
            "sparse poles": lambda: fm.poles(model, count=2, sparse=True),
            "motion": lambda: fm.simulate(model, np.linspace(0, 1e-3, 3)).x[-1],
        }[name]()

    return answer


NAMES = (
    "stress; frequencies; motion; sparse frequencies; equilibrium; equilibria; state; compliance; poles; response;"
    " load multipliers; smooth stress; noise; sparse equilibrium; sparse load multipliers; sparse poles"
)


@pytest.mark.slow(
    "compliance",
    "equilibria",
    "equilibrium",
    "load multipliers",
    "motion",
    "noise",
    "poles",
    "response",
    "smooth stress",
    "sparse equilibrium",
    "sparse frequencies",
    "sparse load multipliers",
    "sparse poles",
    "state",
    "stress",
)
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize("name", NAMES.split("; "))
def test_what_fails_under_a_trace_is_no_number(name):
    good, bad = fm.jit(jax.vmap(asked_of(name)))(np.array([0.1, np.nan]))
    assert not np.any(np.isnan(good))
    assert np.all(np.isnan(bad))


@pytest.mark.slow("equilibrium-jacfwd", "motion-grad")
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize(
    ("name", "derivative"), [("equilibrium", jax.grad), ("equilibrium", jax.jacfwd), ("motion", jax.grad)]
)
def test_what_fails_under_a_trace_has_no_derivative(name, derivative):
    # Of the equilibrium, ten thousand newtons are beyond all that load steps reach.
    forces = np.array([0.1, np.nan, 1e4][: 2 if name == "motion" else 3])
    slopes = fm.jit(jax.vmap(derivative(lambda force: asked_of(name)(force)[-1])))(forces)
    assert np.isfinite(slopes[0])
    assert np.all(np.isnan(slopes[1:]))
