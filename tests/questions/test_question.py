"""A question is one file: every place that asks questions offers it."""

import json
import sys

import numpy as np
import pytest
from cases.commands import command
from cases.snapping import truss
from cases.tolerances import approx

import flexmb as fm
from flexmb import questions
from flexmb.questions import question

FILE = """
from flexmb.questions.question import Question, at_rest

def _height(state, node):
    return 2 * at_rest(state).position(node, "y")

QUESTIONS = (Question("double height", ("node",), _height, "m", of_many=True),)
"""
MODEL = """PLTRUSS 1 1 2
PLTRUSS 2 2 3
X 1 -3 0
X 2 0 {h}
X 3 3 0
FIX 1
FIX 3
END
HALT
ESTIFF 1 1e6
ESTIFF 2 1e6
XM 2 1
END
END
"""
STUDY = """model = "arch.dat"
[parameters]
h = { value = 1.0, lower = 0.5, upper = 2.0 }
[answers]
high = "double height 2"
[sweep]
points = 2
"""


@pytest.fixture
def dropped(tmp_path, monkeypatch):
    """A folder that counts as part of the room, with a file for a new question in it."""
    (tmp_path / "double_height.py").write_text(FILE)
    monkeypatch.setattr(questions, "__path__", [*questions.__path__, str(tmp_path)])
    question.questions.cache_clear()
    yield tmp_path
    sys.modules.pop("flexmb.questions.double_height", None)
    question.questions.cache_clear()


@pytest.mark.slow
def test_a_new_file_is_a_new_question(dropped):
    path = fm.path(truss(), stop={"double height apex": -0.4})
    height = path.along("double height apex")
    assert (path.stopped_by, height.unit, height.of) == ("double height apex", "m", "double height")
    np.testing.assert_allclose(height.values, 2 * np.asarray(path.at("apex"))[:, 1], rtol=1e-15)
    assert height.values[-1] == approx(-0.4, abs=1e-9)
    with pytest.raises(KeyError, match="double height"):
        path.along("nothing")
    (dropped / "arch.dat").write_text(MODEL)
    (dropped / "study.toml").write_text(STUDY)
    run = command("sweep", dropped / "study.toml", "--json", "-")
    assert json.loads(run.stdout)["answers"]["high"] == approx([1.0, 4.0])
    run = command("run", dropped / "arch.dat", "--mode", "7", "--set", "h=1", "--ask", "double height 2", "--json", "-")
    assert json.loads(run.stdout)["asked"] == {"double height 2": {"values": approx(2.0), "unit": "m"}}


def test_names_of_questions_are_told():
    assert question.asked("stiffness top.phi").unit == "N m/rad"
    assert question.asked("top.x").unit == "m"
    for text, fault, words in (("colour", KeyError, "ask for .*frequency"), ("time", ValueError, "for a motion")):
        with pytest.raises(fault, match=words):
            question.asked(text)
    assert question.question_names("motion")[:2] == ["elastic", "energy"]


def test_longer_names_are_found_first():
    assert question.asked("stress resultant leaf.1").question.name == "stress resultant"
    assert question.asked("stress leaf").question.name == "stress"
