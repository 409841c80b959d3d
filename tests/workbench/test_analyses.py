"""Analyses of a document: the numbers of the public functions, options checked, what is missing told, stops kept."""

import base64
import json

import numpy as np
import pytest
from cases import mechanisms
from cases.documents import drawn, planar_guide, spatial_guide
from cases.tolerances import approx

import flexmb as fm
from flexmb.answers.answers import modes
from flexmb.workbench import analyses
from flexmb.workbench.document import Document, apply

FORCE = ("force", {"node": "left1", "force": ["1", "-5"]})
INPUT = ("input", {"of": "right1", "component": "x"})
OUTPUT = ("output", {"of": "left1", "component": "x"})


class Job:
    """What is told, and a stop after so many times."""

    def __init__(self, patience=10_000):
        self.told, self.patience = [], patience

    @property
    def stopped(self):
        return len(self.told) >= self.patience

    def tell(self, **changes):
        self.told.append(changes)


def having(*calls, document=None):
    ops = [{"op": "add", "thing": {"call": call, "args": args}} for call, args in calls]
    return apply(document or planar_guide(), ops)[0]


def ran(document, analysis, job=None, **options):
    found = analyses.run(document, analysis, options, job or Job())
    # As it goes to pages: no number that JSON has not.
    json.dumps(found, allow_nan=False)
    return found


def floats(text):
    return np.frombuffer(base64.b64decode(text), "<f4")


@pytest.mark.slow
def test_what_a_building_block_carries_may_be_driven():
    things = [
        ("Material", "steel", {"E": "210e9", "G": "80e9", "rho": "7850"}),
        ("Rectangle", "leaf", {"width": "0.02", "thickness": "0.5e-3", "material": "steel"}),
        ("node", "A", {"position": ["0", "0"]}),
        ("fix", None, {"node": "A"}),
        ("blocks.cross_pivot", "pivot", {"base": "A", "stage": "B", "section": "leaf", "length": "0.1"}),
    ]
    fields = {field["name"]: field for field in analyses.offered_analyses(drawn(2, {}, things))["stroke"]["fields"]}
    assert "B.phi" in fields["coordinate"]["choices"]
    assert not any(choice.startswith("A.") for choice in fields["coordinate"]["choices"])
    assert {"A", "B"} <= set(fields["node"]["choices"])


def test_every_mode_of_the_command_line_is_offered_and_no_second_list():
    found = analyses.offered_analyses(planar_guide())
    assert {mode.name for mode in modes().values()} <= set(found)
    assert all(own["title"] and own["doc"] for own in found.values())
    assert len({own["doc"] for own in found.values()}) == len(found)
    assert [field["name"] for field in found["simulate"]["fields"]] == ["end", "steps", "rtol"]
    assert [field["name"] for field in found["path"]["fields"]] == ["max_steps"]
    json.dumps(found, allow_nan=False)
    assert analyses.offered_analyses(Document.empty(3))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("path", "There is no load: add a force"),
        ("buckling", "There is no load: add a force"),
        ("simulate", "Nothing moves it: add a force"),
        ("statespace", "There is no input: add one"),
        ("inverse", "Add an input there"),
    ],
)
def test_what_is_missing_is_told_with_what_to_add(name, said):
    with pytest.raises(fm.ModelError, match=said):
        ran(planar_guide(), name)


def test_bode_lacks_an_output_and_a_sweep_a_name():
    assert "no output" in analyses.offered_analyses(having(INPUT))["statespace"]["missing"]
    assert analyses.offered_analyses(having(INPUT, OUTPUT))["statespace"]["missing"] is None
    assert "no name" in analyses.offered_analyses(Document.empty(2))["sweep"]["missing"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"colour": "red"}, "no option 'colour'"),
        ({"end": "soon"}, "Option 'end': 'soon'"),
        ({"end": "-1"}, "Option 'end' must be positive"),
        ({"steps": "2.5"}, "Option 'steps' must be a whole number"),
    ],
)
def test_options_are_checked_by_name(options, said):
    with pytest.raises(ValueError, match=said):
        ran(having(FORCE), "simulate", **options)
    with pytest.raises(ValueError, match="no analysis 'magic'"):
        ran(having(FORCE), "magic")
    with pytest.raises(ValueError, match="must be one of"):
        ran(having(FORCE), "stroke", coordinate="left0.q")


def test_a_document_with_problems_names_them():
    document = having(FORCE, ("mass", {"node": "left1", "mass": "heavy"}))
    with pytest.raises(fm.ModelError, match="not complete: 'heavy' needs 'heavy'"):
        ran(document, "frequencies")


@pytest.mark.slow
def test_frequencies_and_buckling_are_those_of_the_tutorial():
    found = ran(planar_guide(), "frequencies")
    assert found["status"] == "done"
    # Printed 10.6448 Hz; 78.75 N.
    assert "10.6448" in found["text"]
    assert found["view"]["kind"] == "modes"
    assert found["picture"].lstrip().startswith("<?xml")
    down = having(("force", {"node": "left1", "force": ["0", "-1"]}))
    assert "78.7" in ran(down, "buckling")["text"]


@pytest.mark.slow
def test_a_motion_plays_with_its_stress_and_reports_how_far_it_is():
    job = Job()
    found = ran(having(FORCE), "simulate", job, end="0.2", steps="50")
    own = mechanisms.planar_guide(force=(1.0, -5.0)).build()
    motion = fm.simulate(own, np.linspace(0, 0.2, 51), rtol=1e-5)
    assert found["view"]["kind"] == "motion"
    np.testing.assert_allclose(floats(found["view"]["along"]), motion.t, rtol=1e-6)
    names = found["view"]["nodes"]["names"]
    states = floats(found["view"]["nodes"]["states"]).reshape(51, len(names), 3)
    # Single precision, and the integrator's tolerance in parts of the time.
    np.testing.assert_allclose(states[:, names.index("left1"), 0], motion.at("left1")[:, 0], atol=2e-6)
    assert "von Mises" in found["view"]["colours"]["label"]
    fractions = [one["fraction"] for one in job.told if "fraction" in one]
    assert fractions == sorted(fractions)
    assert len(fractions) > 10


@pytest.mark.slow
def test_a_motion_and_a_path_that_are_stopped_keep_what_they_have():
    found = ran(having(FORCE), "simulate", Job(patience=10), end="0.2", steps="50")
    assert found["status"] == "failed"
    assert "stopped" in found["text"].lower()
    assert 0 < len(floats(found["view"]["along"])) < 51
    found = ran(having(FORCE), "path", Job(patience=5))
    assert 0 < len(floats(found["view"]["along"])) < 11


@pytest.mark.slow
def test_a_path_reaches_its_load_with_the_displacement_of_the_equilibrium():
    found = ran(having(FORCE), "path")
    names = found["view"]["nodes"]["names"]
    last = floats(found["view"]["nodes"]["states"]).reshape(-1, len(names), 3)[-1]
    own = fm.equilibrium(mechanisms.planar_guide(force=(1.0, -5.0)).build())
    assert last[names.index("left1"), 0] == approx(float(own.at("left1")[0]), rel=1e-6)


@pytest.mark.slow
def test_a_bode_plot_in_a_range_of_frequencies():
    document = having(INPUT, OUTPUT)
    found = ran(document, "statespace")
    assert "B:" in found["text"]
    narrow = ran(document, "statespace", low="1", high="100")
    assert narrow["picture"] != found["picture"]
    with pytest.raises(ValueError, match="must be positive and ascending"):
        ran(document, "statespace", low="100", high="1")


@pytest.mark.slow
def test_a_coordinate_is_led_by_the_input_there_is():
    """The input holds the guide against its stiffness at the end: 24 E I/L^3 times the way, to terms of its cube."""
    found = ran(having(INPUT, OUTPUT), "inverse", by="1e-3", duration="0.5", end="1", steps="20")
    assert found["status"] == "done"
    line = next(line for line in found["text"].splitlines() if "input" in line)
    stiffness = 24 * mechanisms.leaf().rigidity().EIy / mechanisms.LENGTH**3
    assert float(line.split()[-1]) == approx(stiffness * 1e-3, rel=1e-3)


@pytest.mark.slow
def test_the_stroke_tells_the_stress_along_it():
    found = ran(planar_guide(), "stroke", to="2e-3", steps="2")
    own = fm.verdict(mechanisms.planar_guide().build(), {"left1.x": 2e-3}, steps=2)
    rows = dict(found["rows"])
    assert rows["stress"].startswith(own.measured("stress", -1))
    np.testing.assert_allclose(floats(found["view"]["along"]), own.stroke, rtol=1e-6)
    assert found["view"]["colours"]["high"] == approx(float(np.max(own.curves["stress"])) / 1e6, rel=1e-6)
    with pytest.raises(KeyboardInterrupt):
        ran(planar_guide(), "stroke", Job(patience=3))


@pytest.mark.slow
def test_answers_over_a_dimension():
    found = ran(having(FORCE), "sweep", name="t", low="0.4e-3", high="0.6e-3", points="5")
    assert [row["t"] for row in found["rows"]] == approx(np.linspace(0.4e-3, 0.6e-3, 5))
    for row in found["rows"]:
        model = mechanisms.planar_guide(row["t"], force=(1.0, -5.0)).build()
        assert row["frequency 1"] == approx(float(fm.frequencies(model)[0]), rel=1e-9)
        assert row["stress"] == approx(float(fm.stress(model).maximum), rel=1e-9)
    with pytest.raises(ValueError, match="The last value must be larger"):
        ran(planar_guide(), "sweep", name="t", low="1", high="0.5")


@pytest.mark.slow
def test_in_space_and_of_what_is_over_constrained():
    found = ran(spatial_guide(), "frequencies")
    assert found["view"]["dimension"] == 3
    over = apply(planar_guide(), [{"op": "set", "address": f"{planar_guide().things[4]['id']}/released", "to": "3"}])[0]
    told = ran(over, "mobility")
    assert told["status"] == "done"
    assert "over-constraints: 1" in told["text"]
    refused = ran(over, "frequencies")
    assert refused["status"] == "failed"
    assert "cannot move" in refused["text"]
