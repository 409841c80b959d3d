"""Targets: met to round-off where closed forms or another root finder say, and what limits them where they are not."""

import numpy as np
import pytest
from cases import mechanisms
from cases.documents import planar_guide
from cases.tolerances import approx
from scipy.optimize import brentq

import flexmb as fm
from flexmb.workbench import targets, traced, wants
from flexmb.workbench.building import build
from flexmb.workbench.document import apply


class Job:
    """What is told, and a stop after so many times."""

    def __init__(self, patience=10_000):
        self.told, self.patience = [], patience

    @property
    def stopped(self):
        return len(self.told) >= self.patience

    def tell(self, **changes):
        self.told.append(changes)


def bounded(**bounds):
    document = planar_guide()
    ops = [
        {"op": "name", "name": name, "to": {**document.names[name], "low": low, "high": high}}
        for name, (low, high) in bounds.items()
    ]
    return apply(document, ops)[0]


def loaded(document, aside="0"):
    force = {"call": "force", "args": {"node": "left1", "force": [aside, "-5"]}}
    return apply(document, [{"op": "add", "thing": force}])[0]


def root(function, low, high) -> float:
    return float(brentq(function, low, high, xtol=1e-16))  # pyright: ignore


def want(answer, value, kind="equal"):
    return {"answer": answer, "kind": kind, "value": value}


def frequency(document):
    return float(fm.frequencies(build(document).builder.build())[0])


@pytest.mark.slow
def test_20_hz_by_the_thickness_is_where_another_root_finder_finds_it():
    document, job = bounded(t=("0.1e-3", "2e-3")), Job()
    found = targets.meet(document, [want("frequency 1", "20 Hz")], ["t"], job)
    t = root(lambda t: fm.frequencies(mechanisms.planar_guide(t).build())[0] - 20, 0.4e-3, 1.2e-3)
    assert found["met"]
    assert found["design"]["t"] == approx(t, rel=1e-10)
    after = apply(document, found["ops"])[0]
    assert frequency(after) == approx(20, rel=1e-10)
    # One edit, which leaves bounds as they are and writes the number as it was written.
    assert [op["name"] for op in found["ops"]] == ["t"]
    assert after.names["t"] == {**document.names["t"], "value": found["ops"][0]["to"]["value"]}
    assert found["label"] == "target frequency 1 = 20 Hz"
    designs = [one["design"]["t"] for one in job.told if "design" in one]
    assert designs[0] == mechanisms.THICKNESS
    assert len(designs) > 5
    assert all(0 <= one["fraction"] < 1 for one in job.told)


@pytest.mark.slow
def test_twice_the_buckling_load_takes_the_cube_root_of_two_in_thickness():
    """The load multiplier of a leaf spring in its stiff plane goes as its moment of inertia."""
    found = targets.meet(loaded(bounded(t=("0.1e-3", "2e-3"))), [want("multiplier 1", "2*78.75/5")], ["t"], Job())
    assert found["design"]["t"] == approx(0.5e-3 * 2 ** (1 / 3), rel=1e-9)


@pytest.mark.slow
def test_the_nearest_design_is_found_and_limits_are_kept():
    """At least twice the frequency by thickness and length together: the least sum of squared relative changes."""
    document = bounded(t=("0.1e-3", "2e-3"), L=("0.02", "0.3"))
    found = targets.meet(document, [want("frequency 1", "20", "least")], ["t", "L"], Job())
    assert found["met"]
    assert found["values"]["frequency 1"] == approx(20, rel=1e-5)
    assert found["values"]["frequency 1"] >= 20

    def size(t):
        """Along the curve of 20 Hz."""

        def off(length):
            ops = [{"op": "name", "name": n, "to": {"value": repr(v)}} for n, v in (("t", t), ("L", length))]
            return frequency(apply(document, ops)[0]) - 20

        return np.hypot(np.log(t / 0.5e-3), np.log(root(off, 0.05, 0.15) / 0.1))

    best = size(found["design"]["t"])
    # A minimum, to the search's 1e-6.
    assert best <= min(size(found["design"]["t"] * side) for side in (0.99, 1.01))


@pytest.mark.slow
def test_what_is_so_already_changes_nothing():
    found = targets.meet(planar_guide(), [want("frequency 1", "5", "least")], ["t"], Job())
    assert found["met"]
    assert not found["ops"]
    assert "already met" in found["text"]


@pytest.mark.slow
def test_what_cannot_be_reached_says_how_near_it_comes_and_what_limits_it():
    document = bounded(t=("0.1e-3", "0.6e-3"))
    found = targets.meet(document, [want("frequency 1", "20")], ["t"], Job())
    assert not found["met"]
    assert found["design"]["t"] == approx(0.6e-3)
    nearest = float(fm.frequencies(mechanisms.planar_guide(0.6e-3).build())[0])
    assert found["values"]["frequency 1"] == approx(nearest)
    assert "t is at its upper bound 0.0006" in found["text"]
    assert f"{nearest:.5g} Hz" in found["text"]
    both = [want("frequency 1", "20"), want("multiplier 1", "3", "most")]
    found = targets.meet(loaded(bounded(t=("0.1e-3", "2e-3"))), both, ["t"], Job())
    assert not found["met"]
    assert "contradict each other" in found["text"]


@pytest.mark.slow
def test_a_stop_keeps_the_best_design_so_far():
    document = bounded(t=("0.1e-3", "2e-3"))
    found = targets.meet(document, [want("frequency 1", "20")], ["t"], Job(patience=4))
    assert found["stopped"]
    assert "Stopped on the way" in found["text"]
    assert abs(found["values"]["frequency 1"] - 20) < abs(frequency(document) - 20)
    assert frequency(apply(document, found["ops"])[0]) == approx(found["values"]["frequency 1"], rel=1e-9)


@pytest.mark.slow
def test_a_name_without_bounds_gets_some_and_it_is_told():
    found = targets.meet(planar_guide(), [want("frequency 1", "20")], ["t"], Job())
    assert found["met"]
    assert found["assumed"] == {"t": [approx(0.1e-3), approx(2.5e-3)]}
    assert "'t' has no bounds. The search used 0.0001 to 0.0025." in found["text"]


@pytest.mark.slow
def test_a_second_search_traces_nothing_and_other_numbers_share_it(monkeypatch):
    document = bounded(t=("0.1e-3", "2e-3"))
    targets.meet(document, [want("frequency 1", "20")], ["t"], Job())
    heavier = apply(document, [{"op": "name", "name": "t", "to": {"value": "0.6e-3"}}])[0]
    moved = apply(heavier, [{"op": "set", "address": f"{document.things[1]['id']}/width", "to": "0.02"}])[0]

    def traced_again(*_):
        raise AssertionError("traced again")

    before = dict(traced._TRACED)
    monkeypatch.setattr(traced, "flat_function", traced_again)
    found = targets.meet(heavier, [want("frequency 1", "21")], ["t"], Job())
    assert found["met"]
    assert traced._TRACED.keys() == before.keys()
    # The width was arithmetic of no name before as well.
    assert targets.meet(moved, [want("frequency 1", "21")], ["t"], Job())["met"]


@pytest.mark.slow
def test_derivatives_agree_with_differences():
    document = loaded(planar_guide(), "1")
    keys = ["frequency 1", "multiplier 1", "stress", "mass", "stiffness x", "displacement", "displacement x"]
    function = traced.traced(document, build(document).builder.build(), keys, "left1")
    at = function.at(document)
    names = {name: k for k, name in enumerate(function.names)}
    x = np.array([mechanisms.THICKNESS, mechanisms.LENGTH, mechanisms.DISTANCE])[[*names.values()]]
    values, slopes, code = at(x)
    assert code == fm.RESULTS.successful
    for k in range(len(x)):
        step = np.cbrt(np.finfo(float).eps) * x[k] * np.eye(len(x))[k]
        difference = (at(x + step)[0] - at(x - step)[0]) / (2 * step[k])
        # Second order in the step, and round-off of a stiff mechanism over it.
        scale = np.abs(values) / x[k]
        np.testing.assert_allclose(slopes[:, k] / scale, difference / scale, atol=2e-6)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("20", "Hz", 20.0),
        ("20 Hz", "Hz", 20.0),
        (" 2e-2 kHz ", "Hz", 20.0),
        ("300 MPa", "Pa", 300e6),
        ("5 mm", "m", 5e-3),
        ("5m", "m", 5.0),
        ("10 kN/m", "N/m", 1e4),
        ("3 kg", "kg", 3.0),
        ("2*f", "Hz", 26.0),
    ],
)
def test_values_with_and_without_units(text, unit, value):
    assert wants.wanted_value("it", text, unit, {"f": 13.0}) == approx(value)


@pytest.mark.slow("given12-free12-has no effect on it")
@pytest.mark.parametrize(
    ("given", "free", "said"),
    [
        ([], ["t"], "There is no target"),
        ([want("frequency 1", "fast")], ["t"], "'fast' asks for 'fast'"),
        ([want("frequency 1", "20 kg")], ["t"], "Give a number"),
        ([want("frequency 1", "20", "about")], ["t"], "must be equal, least or most"),
        ([want("frequency 1", "20"), want("frequency 1", "30", "least")], ["t"], "has two targets"),
        ([want("frequency 1", "30", "least"), want("frequency 1", "20", "most")], ["t"], "cannot be at least 30"),
        ([want("colour", "20")], ["t"], "'colour' has no derivatives"),
        ([want("stiffness x", "20")], ["t"], "belongs to a node"),
        ([want("frequency 1", "20")], ["thickness"], "no name 'thickness'"),
        ([want("frequency 1", "20")], ["L2"], "follows from other names"),
        ([want("frequency 3", "20")], ["t"], "numbered 1 to 1"),
        ([want("multiplier 1", "20")], ["t"], "No load acts"),
        ([want("frequency 1", "20")], ["d"], "has no effect on it"),
    ],
)
def test_what_cannot_be_asked_is_told_by_name(given, free, said):
    document = apply(planar_guide(), [{"op": "name", "name": "L2", "to": {"value": "2*L"}}])[0]
    with pytest.raises(ValueError, match=said):
        targets.meet(document, given, free, Job())


@pytest.mark.slow
def test_numbers_are_written_as_they_were():
    assert wants.number_like("0.5e-3", 0.00076919, 12) == "0.76919e-3"
    assert wants.number_like("0.1", 1 / 3, 12) == "0.333333333333"
    assert wants.number_like("5E+2", 1234.5, 12) == "12.345E+2"
    assert float(wants.number_like("1e-9", 3e40, 17)) == 3e40
