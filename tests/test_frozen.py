"""Frozen answers: what is kept of a result, what may differ, and that all that is shipped is found."""

import dataclasses

import jax
import numpy as np
import pytest
import shipped
from cases.tolerances import approx
from frozen import apart, compared
from recorded import TIGHT, Recorder, collect

OLD = np.array([[3.0, 1.0], [4.0, 2.0], [0.0, -5.0]])
TURN = np.array([[0.6, -0.8], [0.8, 0.6]])


def told(rtol=0.0, tuned=False, **tell):
    return {"answers": {"a": tell}, "rtol": rtol, "tuned": tuned}


@pytest.mark.parametrize(("factor", "wrong"), [(1, False), (1 + 1e-10, False), (1 + 1e-8, True), (np.nan, True)])
def test_a_changed_number_is_found(factor, wrong):
    new = OLD * np.array([1.0, factor])
    loose, worst, differ = compared(told(), {"a": OLD}, {"a": new})
    assert loose == 0
    assert bool(differ) is wrong
    assert worst == approx(abs(factor - 1), rel=1e-5) or not np.isfinite(factor)


def test_an_answer_that_is_gone_or_has_another_shape_is_found():
    assert compared(told(), {"a": OLD}, {})[2] == ["a is not there"]
    assert compared(told(), {"a": OLD}, {"a": OLD[:1]})[2]


def test_modes_are_equal_up_to_sign_and_to_the_basis_of_a_repeated_value():
    assert apart(OLD * [-1, 1], OLD, [1.0, 2.0]) == 0
    assert apart(OLD * [-1, 1], OLD) > 1
    assert apart(OLD @ TURN, OLD, [2.0, 2.0 + 1e-9]) < 1e-14
    assert apart(OLD @ TURN, OLD, [1.0, 2.0]) > 0.1
    # Another plane, one mode twice, and one that is not as long.
    assert apart(OLD[::-1] @ TURN, OLD, [2.0, 2.0]) > 0.1
    assert apart(OLD[:, [0, 0]], OLD, [2.0, 2.0]) > 0.1
    assert apart(OLD * [1, 2], OLD, [1.0, 2.0]) > 0.1


def test_a_motion_may_differ_by_ten_times_its_tolerance_from_the_close_one():
    stored = {"a": OLD, "a~": OLD * (1 + 5e-5)}
    for factor, wrong in ((5e-5 + 9e-5, False), (5e-5 + 2e-4, True)):
        loose, _, differ = compared(told(rtol=1e-5), stored, {"a": OLD * (1 + factor)})
        assert loose == 1
        assert bool(differ) is wrong


def test_what_follows_from_a_search_may_differ_and_its_objective_within_its_tolerance():
    assert not compared(told(tuned=True), {"a": OLD, "a~": OLD * (1 + 1e-8)}, {"a": OLD * (1 + 9e-7)})[2]
    assert compared(told(tuned=True), {"a": OLD, "a~": OLD * (1 + 1e-8)}, {"a": OLD * (1 + 2e-6)})[2]
    for off, wrong in ((0.9e-6, False), (2e-6, True)):
        found = compared(told(tuned=True, objective=1e-6), {"a": np.array(0.5)}, {"a": np.array(0.5 + off)})
        assert bool(found[2]) is wrong


@dataclasses.dataclass
class Answer:
    eigenvalues: np.ndarray
    shapes: np.ndarray
    iterations: int
    rows: list
    label: str = "text"
    _hidden: float = 1.0

    @property
    def twice(self):
        return 2 * self.eigenvalues


def test_numbers_of_a_result_are_kept_by_name():
    out = {}
    collect({"one": Answer(np.array([1.0, 4.0]), OLD, 7, [1, None])}, "job", out)
    assert set(out) == {f"job/one/{name}" for name in ("eigenvalues", "shapes", "rows", "twice")}
    assert out["job/one/shapes"][1] == {"by": [1.0, 4.0]}
    np.testing.assert_array_equal(out["job/one/rows"][0], [1.0, np.nan])
    out.clear()
    jax.jit(lambda x: collect({"x": x, "y": 2}, "traced", out))(1.0)
    assert set(out) == {"traced/y"}


def test_calls_are_kept_once_and_the_second_time_by_other_steps():
    def simulate(model, times, *, throw=True, **keywords):
        return {"x": np.asarray(times) + keywords.get("rtol", 0.0)}

    def tune(build, answers, dimensions, bounds):
        return dimensions

    plain, tight = Recorder(False), Recorder(True)
    assert plain.recorded(simulate, "simulate")(None, [0.0], rtol=1e-3)["x"] == 1e-3
    assert plain.rtol == 1e-3
    assert plain.out["simulate#0/x"][1] == {"rtol": 1e-3}
    assert tight.recorded(simulate, "simulate")(None, [0.0], rtol=1e-3)["x"] == TIGHT
    assert tight.recorded(tune, "tune")(None, None, {"t": 1.0}, bounds={"t": (0.0, 4.0)}) == {"t": 1.001}
    assert tight.tuned
    assert not plain.tuned
    with pytest.raises(TypeError):
        plain.recorded(simulate, "simulate")()
    assert "simulate#1/raises TypeError" in plain.out


def test_all_that_is_shipped_is_found():
    jobs = shipped.jobs()
    files = (shipped.ROOT / "flexmb/mechanisms").iterdir()
    assert {f"mechanism:{path.name}" for path in files if path.suffix == ".dat"} <= {*jobs}
    assert sum(job.startswith("notebook:") for job in jobs) == len(list((shipped.ROOT / "notebooks").glob("*.ipynb")))
    assert {"case:cases.mechanisms.planar_guide", "case:scenes.guide"} <= {*jobs}
    assert {"question:buckling", "manual:README.md"} <= {*jobs}
    assert "tests:statics/test_static_references.py" in jobs
    assert len(jobs) == len({*jobs})
