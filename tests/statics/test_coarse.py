"""A word where one beam is bent or twisted further than it is right for, against arcs and twists in closed form."""

import warnings

import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.errors import CoarseWarning

fm.enable_x64()
BEND, TWIST, LENGTH = 1.0, 0.5, 0.4
SECTION = fm.Rigidity(EA=1e6, EIy=BEND, EIz=BEND, GIt=TWIST, EIw=1e-3, mass=1.0, Jx=1e-3)


def bent(moment, element=planar.beam):
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (LENGTH, 0))
    b.add(element, "a", "b", name="blade", section=SECTION)
    b.fix("a")
    b.moment("b", moment)
    return b.build()


def turned(moment, element=spatial.beam, begin=0.0, way=(1, 0, 0)):
    """A rod in space from a point on the diagonal, with a moment at its end."""
    b = fm.Builder()
    b.node("a", (begin, begin, begin))
    b.node("b", tuple(begin + LENGTH * one for one in way))
    b.add(element, "a", "b", name="rod", section=SECTION)
    b.fix("a")
    b.moment("b", moment)
    return b.build()


def said(ask):
    """What is asked for, and what of coarse beams is said."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = ask()
    return found, [str(one.message) for one in heard if one.category is CoarseWarning]


@pytest.mark.parametrize("share", [0.3, 0.7, 0.97])
def test_an_arc_is_right_as_long_as_nothing_is_said(share):
    """An end of an arc turns from the chord by half of the arc's angle, and one beam a little more."""
    angle = 0.4 * share
    found, words = said(lambda: fm.equilibrium(bent(angle * BEND / LENGTH)))
    exact = LENGTH / angle * np.array([np.sin(angle), 1 - np.cos(angle)])
    error = np.linalg.norm(np.asarray(found.at("b")) - exact) / exact[1]
    turned = float(found.e[1]) / LENGTH
    assert abs(turned) == pytest.approx(angle / 2, rel=0.1)
    assert (error < 0.06, bool(words)) == (True, abs(turned) > 0.2)


@pytest.mark.parametrize(
    "ask",
    [
        fm.equilibrium,
        fm.linearize,
        lambda model: fm.linearize(model, sparse=True),
        lambda model: fm.equilibria(model, load_factor=[0.0, 0.5, 1.0]),
        lambda model: fm.path(model, step=0.2),
        lambda model: fm.simulate(model, np.linspace(0, 0.2, 5)),
    ],
    ids=["equilibrium", "linearize", "sparse", "equilibria", "path", "motion"],
)
def test_every_answer_says_it(ask):
    _, words = said(lambda: ask(bent(0.5 * BEND / LENGTH)))
    (word,) = set(words)
    assert word.startswith("Element 'blade': an end turns by up to 0.")
    assert "use more beams" in word


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1)])
def test_a_beam_that_warps_says_the_same(way):
    """Bent across, away from the origin, as a beam that does not."""
    kinds = spatial.beam, spatial.warping_beam
    models = [turned((0, 0.5 * BEND / LENGTH, 0), element, 5.0, way) for element in kinds]
    words = [said(lambda model=model: fm.equilibrium(model))[1] for model in models]
    assert words[0] == words[1] != []


def test_a_twist():
    """One beam meets GIt sin(2 a)/2 over its length where GIt a is right."""
    for angle, is_said in ((0.15, False), (0.24, True)):
        found, words = said(lambda angle=angle: fm.equilibrium(turned((TWIST * angle / LENGTH, 0, 0))))
        a = 2 * np.arcsin(np.asarray(found.x)[-3])
        assert np.sin(2 * a) / 2 == pytest.approx(angle, rel=1e-9)
        assert bool(words) == is_said


def test_a_spectral_beam_needs_no_other():
    _, words = said(lambda: fm.equilibrium(bent(1.0 * BEND / LENGTH, planar.spectral_beam(5))))
    assert words == []
