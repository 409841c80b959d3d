"""What the stage is sent: the chosen mode or state, and what colours it."""

import base64

import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb.viewer.page import page_data
from flexmb.workbench.counts import count
from flexmb.workbench.live import Scenes
from flexmb.workbench.live_answers import Answers, Wants


def answers(**wants) -> Answers:
    found = Answers(mechanisms.planar_guide(elongation=True, force=(0.5, -20.0)).build(), Wants(**wants))
    for _, analyse in found.analyses():
        analyse()
    return found


@pytest.fixture(scope="module")
def found() -> Answers:
    return answers()


def wanting(found: Answers, **wants) -> Answers:
    """The same answers, of which something else is to be shown."""
    found.wants = Wants(**wants)
    return found


def numbers(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<f4")


@pytest.mark.slow
@pytest.mark.parametrize("mode", [0, 1])
def test_the_chosen_mode_alone_is_sent_as_the_viewer_has_it(found, mode):
    scene = Scenes().of_answers(wanting(found, mode=mode))
    assert (scene["kind"], scene["mode"], scene["modes"]) == ("modes", mode, 3)
    assert scene["view"] == page_data(fm.view(fm.modes(found.model), which=[mode]))


@pytest.mark.slow
def test_a_mode_that_there_is_not_is_the_last(found):
    assert Scenes().of_answers(wanting(found, mode=7))["mode"] == 2


@pytest.mark.slow
def test_states_are_those_of_the_public_functions(found):
    scene = Scenes().of_answers(wanting(found, state="equilibrium"))
    assert scene["view"] == page_data(fm.view(fm.linearize(found.model)))
    scene = Scenes().of_answers(wanting(found, state="buckling"))
    assert scene["view"]["choices"] == (f"buckling mode 1: λ = {found.values['multiplier 1']['text']}",)


@pytest.mark.slow
def test_colours_are_stress_or_sensitivity(found):
    view = Scenes().of_answers(wanting(found, colour="stress"))["view"]
    assert view["colours"]["label"] == "von Mises stress [MPa]"
    assert np.nanmax(numbers(view["colours"]["values"])) == approx(found.values["stress"]["value"] / 1e6, rel=0.05)
    slopes = {"left 1": 1.0, "right 1": -2.0}
    view = Scenes().of_answers(wanting(found, colour="sensitivity", sensitivity_of="mass"), slopes)["view"]
    assert view["colours"]["label"] == "mass: % per % of the section's sizes"
    assert (view["colours"]["low"], view["colours"]["high"]) == (-2.0, 2.0)
    values = numbers(view["colours"]["values"])
    for name, _, start, number, _ in view["parts"]:
        own = values[start : start + number]
        assert np.all(np.isnan(own)) if name not in slopes else np.all(own == slopes[name])


def test_an_over_constrained_mechanism_shows_its_self_stress_and_an_unfinished_one_where_it_is():
    scene = Scenes().of_count(count(mechanisms.spatial_guide()))
    assert scene is not None
    assert scene["kind"] == "self-stress"
    under = Scenes().of_count(count(mechanisms.spatial_guide(beams=2, extra=(6,))))
    assert under is not None
    assert under["kind"] == "state"
    assert Scenes().of_count(count(fm.Builder())) is None


@pytest.mark.slow
def test_a_mode_keeps_its_side():
    scenes, one = Scenes(), answers()
    first = numbers(scenes.of_answers(one)["view"]["states"])
    assert one.modes is not None
    one.modes = type(one.modes)(**{**vars(one.modes), "shapes": -one.modes.shapes})
    assert numbers(scenes.of_answers(one)["view"]["states"]) == approx(first, rel=1e-6, abs=1e-9)
