"""A word where a cubic beam is bent, twisted or stretched further than it is right for, against closed forms."""

import warnings

import numpy as np
import pytest
from cases.tolerances import approx

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


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.3, 0.7, 0.97])
def test_an_arc_is_right_as_long_as_nothing_is_said(share):
    """An end of an arc turns from the chord by half of the arc's angle, and one beam a little more."""
    angle = 0.4 * share
    found, words = said(lambda: fm.equilibrium(bent(angle * BEND / LENGTH)))
    exact = LENGTH / angle * np.array([np.sin(angle), 1 - np.cos(angle)])
    error = np.linalg.norm(np.asarray(found.at("b")) - exact) / exact[1]
    turned = float(found.e[1]) / LENGTH
    assert abs(turned) == approx(angle / 2, rel=0.1)
    assert (error < 0.06, bool(words)) == (True, abs(turned) > 0.2)


@pytest.mark.slow
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
    assert "Use more beams" in word


@pytest.mark.slow
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
        assert np.sin(2 * a) / 2 == approx(angle, rel=1e-9)
        assert bool(words) == is_said


@pytest.mark.slow
def test_a_spectral_beam_needs_no_other():
    _, words = said(lambda: fm.equilibrium(bent(1.0 * BEND / LENGTH, planar.spectral_beam(5))))
    assert words == []


PULLED = fm.Rigidity(EA=2e3, EIy=BEND, EIz=BEND, GIt=TWIST, mass=1.0)


def pulled(strain, element=planar.beam, count=4, across=1e-4, **options):
    """A cantilever that is stretched, with a small force across its end."""
    b = fm.Builder()
    b.node("n0", (0, 0))
    for i in range(count):
        b.node(f"n{i + 1}", (LENGTH * (i + 1) / count, 0))
        b.add(element, f"n{i}", f"n{i + 1}", name=f"l{i}", section=PULLED, **options)
    b.fix("n0")
    b.force(f"n{count}", (PULLED.EA * strain, across))
    return b.build()


def deflection(strain, bend, across=1e-4):
    """Of an exact beam: (F/N)(1 + eps)(L - tanh(kL)/k), k^2 = N (1 + eps)/EI, THEORY.md 2."""
    pull = PULLED.EA * strain
    k = np.sqrt(pull * (1 + strain) / bend)
    return across / pull * (1 + strain) * (LENGTH - np.tanh(k * LENGTH) / k)


@pytest.mark.slow
@pytest.mark.parametrize("strain", [0.005, 0.05])
def test_more_beams_do_not_help_where_they_are_stretched(strain):
    """They converge to another EI, and what is advised has the right one."""
    stiffer = BEND * (1 + strain) ** 2
    for count, near in ((4, 2e-3), (16, 2e-4)):
        # Off by the square of their length: 1e-3 with 4.
        found, words = said(lambda count=count: fm.equilibrium(pulled(strain, count=count)))
        assert found.position(f"n{count}", "y") == approx(deflection(strain, stiffer), rel=near)
        assert [word for word in words if "Use more beams" in word] == []
        assert len(words) == (strain > 0.01)
    if words:
        assert "Elements 'l" in words[0]
        assert "the strain along the beam reaches 0.05" in words[0]
        assert "an error of about 10%, for any number of beams. Use spectral beams" in words[0]
    found, words = said(lambda: fm.equilibrium(pulled(strain, planar.spectral_beam(5), count=1)))
    # Digits that a force of 1e-4 leaves, and six coefficients fewer than kL = 4 needs.
    assert found.position("n1", "y") == approx(deflection(strain, BEND), rel=1e-4)
    assert words == []


def test_a_beam_that_is_bent_and_stretched_is_not_told_to_be_divided():
    _, words = said(lambda: fm.equilibrium(pulled(0.02, count=1, across=20.0)))
    (bent_far,) = [word for word in words if "an end turns" in word]
    assert "Use more beams" not in bent_far
    assert len(words) == 2


@pytest.mark.slow
def test_a_bar_that_cannot_bend_may_stretch():
    _, words = said(lambda: fm.equilibrium(pulled(0.05, count=1, across=0.0, released=(1,))))
    assert words == []


@pytest.mark.slow
@pytest.mark.parametrize("how", ["skew", "twist"])
def test_strokes_of_skew_and_twisted_leaf_springs_warn_wherever_they_are_reached(how):
    """Forces reach a stroke too. A twisted strip is stiffer."""

    def guided(force, **properties):
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("tip", (0.1, 0, 0))
        section = fm.Rectangle(0.018, 0.5e-3, fm.Material(210e9, 80e9, 7850.0))
        b.add(spatial.leaf_spring, "foot", "tip", name="leaf", section=section, y=(0, 1, 0), **properties)
        b.fix("foot")
        b.fix("tip", "rotation")
        b.force("tip", (0, 0, force))
        return b.build()

    shape = {"curvature": lambda s: (np.radians(30) / 0.1, 0.0, 0.0)} if how == "twist" else {"skew": (0.7, 0.0)}
    fm.equilibrium(guided(0.1, **shape))
    with pytest.warns(fm.BeamTheoryWarning, match=r"Element 'leaf': .* at a stroke of 0\.\d+ of the length"):
        fm.equilibrium(guided(60.0 if how == "twist" else 5.0, **shape))
