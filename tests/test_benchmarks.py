"""Tables that watch themselves: what got worse is named, and nothing else; what scripts compare with is there."""

import copy
import importlib.util
import json
import re
import sys
from pathlib import Path

import pytest
from cases.tolerances import approx

PLACE = Path(__file__).parents[1] / "benchmarks"


def script(name):
    """A script of the benchmarks, which imports those beside it."""
    sys.path.insert(0, str(PLACE))
    try:
        found = importlib.util.spec_from_file_location(f"benchmarks_{name}", PLACE / f"{name}.py")
        assert found is not None
        assert found.loader is not None
        module = importlib.util.module_from_spec(found)
        found.loader.exec_module(module)
    finally:
        sys.path.remove(str(PLACE))
    return module


quick, against, solutions, whole = map(script, ("quick", "against", "solutions", "__main__"))
solid, solid_shapes, shape_beams = map(script, ("solid", "solid_shapes", "solid_shape_beams"))


@pytest.fixture
def rows():
    return json.loads(quick.TABLE.read_text())["rows"]


def test_every_row_stands_in_the_committed_table(rows):
    assert list(rows) == [case.__name__ for case in quick.CASES]


def test_nothing_is_named_where_nothing_changed(rows):
    assert quick.losses(rows, rows) == []


@pytest.mark.parametrize(
    ("key", "factor", "told"),
    [("time", 2.0, True), ("time", 1.2, False), ("first", 1.5, True), ("instructions", 1.03, True), ("error", 3, True)],
)
def test_a_loss_above_noise_is_named(rows, key, factor, told):
    worse = copy.deepcopy(rows)
    worse["elastica"][key] *= factor
    said = quick.losses(worse, rows)
    assert bool(said) is told
    assert all(text.startswith(f"elastica: {key} ") for text in said)


def test_a_slower_machine_is_no_loss(rows):
    slower = copy.deepcopy(rows)
    for row in slower.values():
        row["time"] *= 3
        row["yardstick"]["time"] *= 3
    assert quick.losses(slower, rows) == []


def test_an_answer_that_is_no_number_is_named(rows):
    worse = copy.deepcopy(rows)
    worse["path"]["error"] = float("nan")
    assert len(quick.losses(worse, rows)) == 1


@pytest.mark.slow
def test_rows_that_are_missing_or_new_are_named(rows):
    fewer = {name: row for name, row in rows.items() if name != "path"}
    assert "no longer measured" in quick.losses(fewer, rows)[0]
    assert "not in the committed table" in quick.losses(rows, fewer)[0]


def pair(then, now, error=1e-9):
    return {
        "then": {"times": then, "first": 2.0, "error": error},
        "now": {"times": now, "first": 1.0, "error": error},
    }


@pytest.mark.parametrize(
    ("pairs", "told"),
    [
        # Each round's ratio counts: a machine that slows down in between is no loss.
        ([pair([1.0, 2.0, 4.0], [1.0, 2.0, 4.0])], False),
        ([pair([1.0, 2.0, 4.0], [1.1, 2.2, 4.4])] * 2, True),
        # One process in bad luck is none either, nor a scatter that reaches below.
        ([pair([1.0] * 5, [1.2] * 5), pair([1.0] * 2, [1.0] * 2)], False),
        ([pair([1.0] * 4, [0.9, 0.95, 1.2, 1.3])] * 2, False),
    ],
)
def test_what_is_slower_than_an_older_package_is_named(pairs, told):
    row = against.summary(pairs)
    assert against.slower({"row": row, "other": against.summary([pair([1.0, 1.0], [0.5, 0.5])])}) == ["row"] * told


def test_a_summary_of_pairs_is_that_of_their_rounds():
    row = against.summary([pair([1.0, 1.0, 1.0], [0.5, 0.6, 0.7]), pair([2.0, 2.0, 2.0], [1.2, 1.2, 1.2])])
    assert row["ratio"] == approx(0.6)
    assert row["of_pairs"] == approx([0.6, 0.6])
    assert row["quartiles"] == approx([0.6, 0.6])
    assert (row["then"]["time"], row["now"]["first"]) == (1.5, 1.0)
    assert "0.60" in against.shown({"row": row})


def test_rows_are_chosen_by_how_they_begin():
    assert against.chosen(["motion", "path"]) == [
        "motion_plane",
        "motion_fixed",
        "motion_space",
        "motion_derivative",
        "path",
    ]
    assert len(against.chosen([])) == len(quick.CASES) + len(against.KERNELS)
    with pytest.raises(ValueError, match="no row 'motio'"):
        against.chosen(["motio"])
    with pytest.raises(ValueError, match="'no-such' is no commit"):
        against.package_of("no-such", Path())


def test_every_solution_that_a_script_compares_with_is_kept():
    scripts = "".join(path.read_text() for path in PLACE.glob("*.py"))
    for name in re.findall(r'kept\("([^"]+)"\)', scripts):
        assert name in solutions.SOLUTIONS
    kept = json.loads(solutions.KEPT.read_text())["solutions"]
    assert {name: own["origin"] for name, own in kept.items()} == {
        name: origin for name, (_, origin) in solutions.SOLUTIONS.items()
    }


def test_what_scripts_took_is_kept_in_their_order_and_summed():
    known = json.loads((PLACE / "results" / "whole.json").read_text())["scripts"]
    assert list(known) == [name for name in whole.SCRIPTS if name in known]
    made_up = {"one": {"seconds": 10.0, "processor": 3.0}, "other": {"seconds": 20.0, "processor": 4.0}}
    assert whole.told(made_up).splitlines()[-1].split() == ["together", "30", "7"]


@pytest.mark.slow
def test_a_package_that_is_not_there_is_no_other_one(tmp_path):
    # One that is installed may be found in its place: that is told too, and nothing is compared.
    with pytest.raises(RuntimeError, match=r"^then: (another package than|ModuleNotFoundError)"):
        against.paired("elastica", {"then": tmp_path, "now": PLACE.parent}, tmp_path)


@pytest.fixture
def solids():
    return json.loads(solid.RESULTS.read_text())


def test_every_shape_is_compared(solids):
    """No case of a solid model is left out."""
    assert sorted(shape_beams.CASES) == sorted(solid_shapes.SHAPES)
    assert set(solid_shapes.SHAPES) <= set(solids["solid"])


def test_meshes_of_the_shapes_agree(solids):
    """The coarse mesh is within 0.7 % of the fine one, at the corners of thick parts and of the arch within 1 %."""
    for name in set(solid_shapes.SHAPES) & set(solids["solid"]):
        most = 0.01 if name.startswith(("steps in thickness", "cosine arch")) else 0.007
        for what, q in solids["solid"][name]["quantities"].items():
            assert abs(q["coarse"] / q["fine"] - 1) < most, (name, what)
